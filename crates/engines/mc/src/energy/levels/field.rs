//! The smooth part of a body's potential, tabulated in the body's frame.
//!
//! Boxes around the charges, each with twice the margin of the one inside it and cells of twice the
//! edge; in the corners of a box, where the charges are farther away, the next box's cells serve. A
//! cell's edge is at most half its distance from the charges, or the smallest edge. In a cell the
//! potential is a Chebyshev series in three coordinates, from its values at 6³ Chebyshev points;
//! decisions that need less use 63 of its coefficients, in a short form (`packed`).

use super::fine::{FINE, Fine};
use super::lanes::BLOCK;
use super::motion::length;
use super::packed::{Head, Packed, pack};
use super::sampler::Sites;
use super::split::Split;
use crate::charges::ChargeCloud;
use crate::prefetch::prefetch;
use protomer_kernel::chebyshev::Chebyshev;

/// The near part ends this many innermost cells from a charge.
const CELLS_PER_NEAR_RADIUS: f64 = 2.0;
/// Margin of the innermost box, in cells.
const MARGIN_CELLS: f64 = 4.0;
/// The outermost box has at most this many times the innermost margin (as a power of two).
const MOST_SHELLS: usize = 14;
/// A cell that a smaller box covers.
const COVERED: u32 = u32::MAX;
/// A cell so far from the charges that the next box's cell serves in its place, before that one's
/// number is known.
const ROOMY: u32 = u32::MAX - 1;
/// Number of low bits of an entry of the index that hold a cell; those above say by how many boxes
/// the cell is farther out.
const CELL_BITS: u32 = 28;
/// Least distance, in its edges, of charges from a cell of the next box that serves in place of
/// smaller ones.
const ROOM: f32 = 2.0;
/// Number whose addition rounds to an integer, which then is in the low bits.
const ROUNDER: f32 = 12_582_912.0; // 1.5 · 2²³
/// Outermost part of a box's margin that is not used, so that rounding leads to no place beyond.
const UNUSED_MARGIN: f64 = 1e-4;

/// The tabulated potential of one body type.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    centre: [f32; 3],
    half: [f32; 3],
    inverse_margin: f32,
    /// Edge of the innermost cells, Å.
    edge: f32,
    shells: Vec<Shell>,
    /// The cell of each place of each shell, and above [`CELL_BITS`] how much larger it is.
    index: Vec<u32>,
    /// Distance of each cell's centre from the nearest charge, Å.
    pub distance: Vec<f32>,
    /// Mean square errors of each cell's coarse and fine series, (kT/e)².
    pub errors: Vec<[f32; 2]>,
    pub heads: Vec<Head>,
    pub coarse: Vec<Packed>,
    pub fine: Vec<Fine>,
}

/// One box of cells.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shell {
    /// The number of the cell whose low corner is the centre, and how far apart numbers are along x,
    /// y and z.
    origin: i32,
    strides: [i32; 3],
    first: u32,
    cells: [u32; 3],
    low: [f64; 3],
    edge: f64,
}

/// Positions of 16 points: their cells, and their coordinates in them from -1 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spots {
    pub cell: [u32; BLOCK],
    pub coordinates: [[f32; BLOCK]; 3],
    /// Edges of the cells, Å.
    pub edge: [f32; BLOCK],
}

impl Spots {
    /// The coordinates of one point in its cell.
    #[inline(always)]
    pub fn place(&self, lane: usize) -> [f32; 3] {
        [
            self.coordinates[0][lane],
            self.coordinates[1][lane],
            self.coordinates[2][lane],
        ]
    }
}

impl Shell {
    /// Low and high end of a cell along each axis, Å.
    fn corners(&self, place: u32) -> [[f64; 2]; 3] {
        let [nx, ny, _] = self.cells;
        let cell = [place % nx, place / nx % ny, place / (nx * ny)];
        let end =
            |axis: usize, side: u32| self.low[axis] + f64::from(cell[axis] + side) * self.edge;
        [0, 1, 2].map(|axis| [end(axis, 0), end(axis, 1)])
    }

    /// The place of the cell that holds a point.
    fn place_of(&self, x: &[f64; 3]) -> usize {
        // Positive within the box, so truncation is the floor.
        let cell = |axis: usize| ((x[axis] - self.low[axis]) / self.edge) as usize;
        let [nx, ny, _] = self.cells.map(|cells| cells as usize);
        cell(0) + nx * (cell(1) + ny * cell(2))
    }
}

fn middle(corners: &[[f64; 2]; 3]) -> [f64; 3] {
    corners.map(|[low, high]| (low + high) / 2.0)
}

/// Whether a cell is so far from the charges that it serves also where smaller ones could.
fn is_roomy(sites: &Sites, corners: &[[f64; 2]; 3]) -> bool {
    let edge = (corners[0][1] - corners[0][0]) as f32;
    // Half the diagonal: the farthest place of the cell from its centre.
    let half_diagonal = edge * 3.0_f32.sqrt() / 2.0;
    sites.nearest(middle(corners).map(|x| x as f32)) as f32 - half_diagonal > ROOM * edge
}

impl Field {
    /// The table of these charges out to `reach_angstrom` from them.
    pub fn new(charges: &ChargeCloud, split: &Split, reach_angstrom: f64) -> Self {
        let mut field = Self::boxes(charges, split.radius_angstrom, reach_angstrom);
        let chebyshev = Chebyshev::default();
        let sites = Sites::new(charges);
        let centres = field.number_cells(&sites);
        let weights = truncation_weights();
        for (centre, edge) in centres {
            let (values, nearest) = sites.sample(split, &chebyshev, centre, edge);
            let series = chebyshev.series(&values);
            field.add_cell(
                nearest as f32,
                truncation_errors(&series, &weights),
                Fine::new(&series),
            );
        }
        field
    }

    /// Adds the next cell: the distance of its centre from the nearest charge, its errors, its
    /// series.
    pub fn add_cell(&mut self, distance: f32, errors: [f32; 2], fine: Fine) {
        self.distance.push(distance);
        self.errors.push(errors);
        let (head, coarse) = pack(&fine);
        self.heads.push(head);
        self.coarse.push(coarse);
        self.fine.push(fine);
    }

    /// The boxes without their cells.
    pub fn boxes(charges: &ChargeCloud, near_radius: f64, reach: f64) -> Self {
        let edge = near_radius / CELLS_PER_NEAR_RADIUS;
        let (low, high) = charges.bounds_angstrom();
        let (centre, half) = ((low + high) / 2.0, (high - low) / 2.0);
        let mut shells = Vec::new();
        let mut first = 0;
        for k in 0..MOST_SHELLS {
            let edge = edge * f64::from(1_u32 << k);
            let margin = MARGIN_CELLS * edge;
            // Planes of the boxes coincide: all have one through the centre.
            // Even numbers of cells, half of them on each side of the centre.
            let cells = half.map(|half| 2 * ((half + margin) / edge).ceil() as u32);
            let low = centre - cells.map(f64::from) * (edge / 2.0);
            let strides = [1, cells.x, cells.x * cells.y];
            let to_centre: u32 = (0..3).map(|axis| cells[axis] / 2 * strides[axis]).sum();
            shells.push(Shell {
                origin: (first + to_centre) as i32,
                strides: strides.map(|stride| stride as i32),
                first,
                cells: cells.into(),
                low: low.into(),
                edge,
            });
            first += cells.product();
            if margin > reach {
                break;
            }
        }
        Self {
            centre: centre.map(|x| x as f32).into(),
            half: half.map(|x| x as f32).into(),
            // Slightly larger than exact: the outermost part of the margin leads to the next box.
            inverse_margin: (1.0 / ((1.0 - UNUSED_MARGIN) * MARGIN_CELLS * edge)) as f32,
            edge: edge as f32,
            shells,
            index: vec![COVERED; first as usize],
            distance: Vec::new(),
            errors: Vec::new(),
            heads: Vec::new(),
            coarse: Vec::new(),
            fine: Vec::new(),
        }
    }

    /// Gives each cell that is used its number; centres and edges in that order.
    pub fn number_cells(&mut self, sites: &Sites) -> Vec<([f64; 3], f64)> {
        let mut centres = Vec::new();
        for k in 0..self.shells.len() {
            let shell = self.shells[k];
            for place in 0..shell.cells.iter().product() {
                let corners = shell.corners(place);
                // A smaller box serves here; as this cell is not roomy, no smaller one leads to it.
                let number = if k > 0 && self.covers(k - 1, &corners) && !is_roomy(sites, &corners)
                {
                    COVERED
                } else if self
                    .around(k + 1, &middle(&corners))
                    .is_some_and(|(shell, place)| is_roomy(sites, &shell.corners(place as u32)))
                {
                    ROOMY
                } else {
                    centres.push((middle(&corners), shell.edge));
                    centres.len() as u32 - 1
                };
                self.index[(shell.first + place) as usize] = number;
            }
        }
        self.lead_outwards();
        centres
    }

    /// The cell of box k, if there is one, that holds a point.
    fn around(&self, k: usize, x: &[f64; 3]) -> Option<(&Shell, usize)> {
        let shell = self.shells.get(k)?;
        Some((shell, shell.place_of(x)))
    }

    /// Gives the places whose cells are too roomy the larger cell that holds their middle.
    fn lead_outwards(&mut self) {
        // From the outermost box inwards: the larger cell must have its number before it is copied.
        for k in (0..self.shells.len()).rev() {
            let shell = self.shells[k];
            for place in 0..shell.cells.iter().product() {
                let number = (shell.first + place) as usize;
                if self.index[number] != ROOMY {
                    continue;
                }
                if let Some((next, larger)) = self.around(k + 1, &middle(&shell.corners(place))) {
                    let larger = self.index[next.first as usize + larger];
                    // Adding one in the high bits counts how many boxes farther out the cell is.
                    self.index[number] = larger + (1 << CELL_BITS);
                }
            }
        }
    }

    /// Whether the margin of box k holds all of a cell.
    fn covers(&self, k: usize, corners: &[[f64; 2]; 3]) -> bool {
        let margin = (1.0 - 2.0 * UNUSED_MARGIN) * MARGIN_CELLS * self.shells[k].edge;
        (0..3).all(|axis| {
            corners[axis].iter().all(|x| {
                (x - f64::from(self.centre[axis])).abs() < f64::from(self.half[axis]) + margin
            })
        })
    }

    /// Finds the cells of 16 points (Å, in the body's frame) and their coordinates in them; `None`
    /// if one is beyond the table. Each operation runs over all points, as suits vector units.
    #[inline(always)]
    pub fn locate(&self, x: &[[f32; BLOCK]; 3]) -> Option<Spots> {
        // 0.5 has the exponent of box 0, which serves everything nearer too.
        let mut excess = [0.5; BLOCK];
        for axis in 0..3 {
            let (centre, half) = (self.centre[axis], self.half[axis]);
            for lane in 0..BLOCK {
                let outside = ((x[axis][lane] - centre).abs() - half) * self.inverse_margin;
                // Written as a selection, so that it becomes a maximum of vectors.
                excess[lane] = if outside > excess[lane] {
                    outside
                } else {
                    excess[lane]
                };
            }
        }
        // Box k has 2^k times the innermost margin: the exponent of the excess is its number.
        let number = excess.map(power_of_two_above);
        let most = highest(&number);
        let shells = self.shells.get(..=most as usize)?;
        let (mut place, mut strides) = ([0_i32; BLOCK], [[0_i32; BLOCK]; 3]);
        // Gathers from a short table; everything before and after it runs in vectors.
        for lane in 0..BLOCK {
            let shell = &shells[number[lane] as usize];
            place[lane] = shell.origin;
            (0..3).for_each(|axis| strides[axis][lane] = shell.strides[axis]);
        }
        // In cells of the box, from the centre: coordinates, and the corner below.
        let (mut u, mut below) = ([[0.0_f32; BLOCK]; 3], [[0_i32; BLOCK]; 3]);
        let inverse = 1.0 / self.edge;
        for axis in 0..3 {
            for lane in 0..BLOCK {
                let scale = inverse * power_of_two(-(number[lane] as i32));
                u[axis][lane] = (x[axis][lane] - self.centre[axis]) * scale;
                // Floor by rounding of u - 1/2: the low bits of the sum hold the integer.
                let rounded = (u[axis][lane] - 0.5) + ROUNDER;
                below[axis][lane] = rounded.to_bits().wrapping_sub(ROUNDER.to_bits()) as i32;
                place[lane] += below[axis][lane] * strides[axis][lane];
            }
        }
        let mut cell = [0_u32; BLOCK];
        // A second gather, this time far from the processor; the check costs less than the miss.
        for lane in 0..BLOCK {
            let entry = self.index.get(place[lane] as usize);
            cell[lane] = entry.copied().unwrap_or(COVERED);
        }
        let (mut coordinates, mut edge) = ([[0.0; BLOCK]; 3], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            let larger = cell[lane] >> CELL_BITS;
            // The number of the cell, without the bits that say how much larger it is.
            cell[lane] &= (1 << CELL_BITS) - 1;
            edge[lane] = self.edge * power_of_two((number[lane] + larger) as i32);
            for axis in 0..3 {
                // Rounding must not decide which larger cell stands for a smaller one: that one does.
                // An arithmetic shift halves towards minus infinity: the corner of the larger cell.
                let corner = (below[axis][lane] >> larger) as f32;
                let scaled = u[axis][lane] * power_of_two(-(larger as i32));
                coordinates[axis][lane] = 2.0 * (scaled - corner) - 1.0;
            }
        }
        Some(Spots {
            cell,
            coordinates,
            edge,
        })
    }

    /// Asks for the coarse series of these spots, which are far from the processor.
    #[inline(always)]
    pub fn prefetch_coarse(&self, spots: &Spots) {
        for cell in spots.cell {
            let cell = cell as usize;
            if let (Some(head), Some(series)) = (self.heads.get(cell), self.coarse.get(cell)) {
                prefetch(head);
                prefetch(series);
            }
        }
    }

    /// Asks for the fine series of these spots.
    #[inline(always)]
    pub fn prefetch_fine(&self, spots: &Spots) {
        for cell in spots.cell {
            if let Some(series) = self.fine.get(cell as usize) {
                prefetch(series);
            }
        }
    }

    /// The cell that holds a point, its edge (Å), and the point's coordinates in it from -1 to 1;
    /// `None` beyond the table.
    #[inline(always)]
    pub fn cell_at(&self, x: [f32; 3]) -> Option<(usize, f32, [f32; 3])> {
        let outside = |axis: usize| (x[axis] - self.centre[axis]).abs() - self.half[axis];
        let excess = outside(0).max(outside(1)).max(outside(2)) * self.inverse_margin;
        let number = power_of_two_above(excess);
        let shell = self.shells.get(number as usize)?;
        let scale = power_of_two(-(number as i32)) / self.edge;
        let u = [0, 1, 2].map(|axis: usize| (x[axis] - self.centre[axis]) * scale);
        let below = u.map(|u| u.floor() as i32);
        let [px, py, pz] = [0, 1, 2].map(|axis: usize| below[axis] * shell.strides[axis]);
        let entry = *self.index.get((shell.origin + px + py + pz) as usize)?;
        let (cell, larger) = (entry & ((1 << CELL_BITS) - 1), entry >> CELL_BITS);
        let coordinate = |axis: usize| {
            let corner = (below[axis] >> larger) as f32;
            2.0 * (u[axis] * power_of_two(-(larger as i32)) - corner) - 1.0
        };
        let edge = self.edge * power_of_two((number + larger) as i32);
        Some((cell as usize, edge, [0, 1, 2].map(coordinate)))
    }

    /// A lower bound on the distance of a point from the nearest charge, Å.
    #[inline(always)]
    pub fn distance_bound(&self, x: [f32; 3]) -> f32 {
        match self.cell_at(x) {
            Some((cell, edge, coordinates)) => {
                // Triangle inequality: the point is 0.5 edge |coordinates| from the cell's centre.
                self.distance[cell] - 0.5 * edge * length(coordinates)
            }
            None => {
                // Beyond the table: the distance to the charges' box is a bound as well.
                let outside = |axis: usize| (x[axis] - self.centre[axis]).abs() - self.half[axis];
                outside(0).max(outside(1)).max(outside(2))
            }
        }
    }

    /// Variance of the energy of these charges from the coarse series, kT².
    #[inline(always)]
    pub fn coarse_variance(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f32 {
        let variance =
            |(cell, charge): (&u32, &f32)| charge * charge * self.errors[*cell as usize][0];
        spots.cell.iter().zip(charge).map(variance).sum()
    }

    /// Variance of the energy of these charges from the fine series, kT².
    #[inline(always)]
    pub fn fine_variance(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f32 {
        self.fine_variances(spots, charge).iter().sum()
    }

    /// Variance of the energy of each of these charges from the fine series, kT².
    #[inline(always)]
    pub fn fine_variances(&self, spots: &Spots, charge: &[f32; BLOCK]) -> [f32; BLOCK] {
        let mut variances = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let error = self.errors[spots.cell[lane] as usize][1];
            variances[lane] = charge[lane] * charge[lane] * error;
        }
        variances
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let series = size_of::<Head>() + size_of::<Packed>() + size_of::<Fine>();
        let cell = 4 * (1 + 2) + series;
        4 * self.index.len() + cell * self.distance.len()
    }
}

/// Mean squares of what a series leaves out: of the coarse one, all other coefficients; of the fine
/// one, no more than those it drops and the last ones along an axis, whose successors are smaller.
fn truncation_errors(series: &[f64], weights: &[[f64; 2]]) -> [f32; 2] {
    let mut errors = [0.0; 2];
    for (coefficient, weight) in series.iter().zip(weights) {
        let square = coefficient * coefficient;
        errors[0] += square * weight[0];
        errors[1] += square * weight[1];
    }
    errors.map(|square| square as f32)
}

/// Weights of the square of each coefficient in the errors of the coarse and of the fine series.
/// Each factor T_n with n > 0 has the mean square 1/2.
fn truncation_weights() -> Vec<[f64; 2]> {
    let weights = |place: usize| {
        let orders = [place % FINE, place / FINE % FINE, place / (FINE * FINE)];
        let halves = orders.iter().filter(|n| **n > 0).count() as i32;
        let mean_square = 0.5_f64.powi(halves);
        // The last order along an axis stands for the truncated ones, which are smaller.
        let is_last = orders.contains(&(FINE - 1)) || !Fine::keeps(orders);
        [!Packed::keeps(orders), is_last].map(|counts| if counts { mean_square } else { 0.0 })
    };
    (0..FINE * FINE * FINE).map(weights).collect()
}

/// The least k ≥ 0 with x below 2^k, from the exponent.
#[inline(always)]
fn power_of_two_above(x: f32) -> u32 {
    let x = if x > 0.5 { x } else { 0.5 };
    // The exponent of x in [2^(k-1), 2^k) is k + 126 in its biased form.
    (x.to_bits() >> 23) - 126
}

/// 2^n, from the exponent.
#[inline(always)]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((127 + n) as u32) << 23)
}

#[inline(always)]
fn highest(numbers: &[u32; BLOCK]) -> u32 {
    numbers.iter().fold(0, |most, number| most.max(*number))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use protomer_kernel::Vec3;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;

    /// 60 charges in a long box.
    fn charges() -> ChargeCloud {
        let mut rng = CounterRng::new(5, 0, 0);
        let sites = (0..60).map(|number| {
            let position = Vec3::new(
                rng.uniform_in(-20.0, 20.0),
                rng.uniform_in(-8.0, 8.0),
                rng.uniform_in(-6.0, 6.0),
            );
            (position, if number % 3 == 0 { -1.0 } else { 1.0 })
        });
        ChargeCloud::new(&sites.collect::<Vec<_>>())
    }

    fn potential() -> Yukawa {
        Yukawa::uncut(7.0, 1.0 / 9.6).unwrap()
    }

    pub fn field() -> Field {
        Field::new(&charges(), &Split::new(potential(), 5.0), 60.0)
    }

    /// Places in and around the charges, near and far.
    pub fn places(number: usize) -> Vec<[f32; 3]> {
        let mut rng = CounterRng::new(6, 0, 0);
        let place = |_| {
            let size = rng.uniform_in(5.0, 60.0);
            let place: Vec3 = rng.vector_in_ball(size);
            place.map(|x| x as f32).into()
        };
        (0..number).map(place).collect()
    }

    #[test]
    fn sixteen_places_are_found_as_each_alone() {
        let field = field();
        for sixteen in places(1600).chunks_exact(BLOCK) {
            let x = [0, 1, 2].map(|axis| std::array::from_fn(|lane| sixteen[lane][axis]));
            let spots = field.locate(&x).unwrap();
            for (lane, place) in sixteen.iter().enumerate() {
                let (cell, _, coordinates) = field.cell_at(*place).unwrap();
                assert_eq!(spots.cell[lane] as usize, cell);
                for axis in 0..3 {
                    assert!((spots.coordinates[axis][lane] - coordinates[axis]).abs() < 1e-4);
                    assert!(coordinates[axis].abs() < 1.0001);
                }
            }
        }
        let is_larger = |entry: &u32| *entry != COVERED && entry >> CELL_BITS > 0;
        assert!(field.index.iter().any(is_larger));
    }

    #[test]
    fn the_fine_series_is_the_smooth_potential() {
        let (field, charges) = (field(), charges());
        let split = Split::new(potential(), 5.0);
        let (mut squares, mut modelled, mut largest) = (0.0, 0.0, 0.0_f64);
        let places = places(800);
        for place in &places {
            let x = place.map(|x| [x; BLOCK]);
            let spots = field.locate(&x).unwrap();
            let mut charge = [0.0; BLOCK];
            charge[3] = 1.0;
            let point = Vec3::from(place.map(f64::from));
            let sum: f64 = charges
                .iter()
                .map(|(site, charge)| {
                    let square = (site - point).norm_squared();
                    charge * f64::from(split.smooth_f32::<false>(square as f32))
                })
                .sum();
            let error = field.fine::<false>(&spots, &charge) - sum;
            squares += error * error;
            modelled += f64::from(field.fine_variance(&spots, &charge));
            largest = largest.max(error.abs());
        }
        let number = places.len() as f64;
        let (error, modelled) = ((squares / number).sqrt(), (modelled / number).sqrt());
        assert!(
            error < modelled && largest < 2e-3,
            "{error} {modelled} {largest}"
        );
    }
}
