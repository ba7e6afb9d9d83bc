//! The smooth part of a body's potential, tabulated in the body's frame.
//!
//! Boxes around the charges, each with twice the margin of the one inside it and cells of twice the
//! edge; in the corners of a box, where the charges are farther away, the next box's cells serve. A
//! cell's edge is at most half its distance from the charges, or the smallest edge. In a cell the
//! potential is a Chebyshev series in three coordinates, from its values at 6³ Chebyshev points;
//! decisions that need less use 63 of its coefficients, in a short form (`packed`).

use super::fine::{FINE, Fine};
use super::lanes::{BLOCK, prefetch};
use super::motion::length;
use super::packed::{Head, Packed, pack};
use super::sampler::{Sampler, Sites};
use super::split::Split;
use crate::charges::ChargeCloud;
use crate::energy::SitePotential;

/// The near part ends this many innermost cells from a charge.
const CELLS_PER_NEAR_RADIUS: f64 = 2.0;
/// Margin of the innermost box, in cells.
const MARGIN_CELLS: f64 = 4.0;
/// The outermost box has at most this many times the innermost margin (as a power of two).
const MOST_SHELLS: usize = 14;
/// A cell that a smaller box covers.
const COVERED: u32 = u32::MAX;
/// A cell so far from the charges that the next box's cell serves in its place.
const ROOMY: u32 = u32::MAX - 1;
/// How far, in its edges, charges must be from such a cell of the next box.
const ROOM: f32 = 2.0;
/// Adding it rounds to an integer, which then is in the low bits.
const ROUNDER: f32 = 12_582_912.0; // 1.5 · 2²³

/// The tabulated potential of one body type.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    centre: [f32; 3],
    half: [f32; 3],
    inverse_margin: f32,
    shells: Vec<Shell>,
    /// The cell of each place of each shell.
    index: Vec<u32>,
    /// How far each cell's centre is from the nearest charge, Å.
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
    first: u32,
    cells: [u32; 3],
    low: [f32; 3],
    edge: f32,
}

/// Where 16 points lie: their cells, and their coordinates in them from -1 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spots {
    pub cell: [u32; BLOCK],
    pub at: [[f32; BLOCK]; 3],
    /// Of the cells, Å.
    pub edge: [f32; BLOCK],
}

impl Shell {
    /// Low and high end of a cell along each axis, Å.
    fn corners(&self, place: u32) -> [[f64; 2]; 3] {
        let [nx, ny, _] = self.cells;
        self.corners_of([place % nx, place / nx % ny, place / (nx * ny)])
    }

    /// Those of the cell that holds a point.
    fn corners_around(&self, x: &[f64; 3]) -> [[f64; 2]; 3] {
        let cell = |axis: usize| (x[axis] - f64::from(self.low[axis])) / f64::from(self.edge);
        self.corners_of([0, 1, 2].map(|axis| cell(axis) as u32))
    }

    fn corners_of(&self, cell: [u32; 3]) -> [[f64; 2]; 3] {
        let end = |axis: usize, side: u32| {
            f64::from(self.low[axis]) + f64::from(cell[axis] + side) * f64::from(self.edge)
        };
        [0, 1, 2].map(|axis| [end(axis, 0), end(axis, 1)])
    }
}

fn middle(corners: &[[f64; 2]; 3]) -> [f64; 3] {
    corners.map(|[low, high]| (low + high) / 2.0)
}

/// Whether a cell is so far from the charges that it serves also where smaller ones could.
fn is_roomy(sites: &Sites, corners: &[[f64; 2]; 3]) -> bool {
    let edge = (corners[0][1] - corners[0][0]) as f32;
    let half_diagonal = edge * 3.0_f32.sqrt() / 2.0;
    sites.nearest(middle(corners).map(|x| x as f32)) as f32 - half_diagonal > ROOM * edge
}

impl Field {
    /// The table of these charges out to `reach_angstrom` from them.
    pub fn new<P: SitePotential>(
        charges: &ChargeCloud,
        split: &Split<P>,
        reach_angstrom: f64,
    ) -> Self {
        let mut field = Self::boxes(charges, split.radius_angstrom, reach_angstrom);
        let sampler = Sampler::new();
        let sites = Sites::new(charges);
        let centres = field.number_cells(&sites);
        for (centre, edge) in centres {
            let (values, nearest) = sites.sample(split, &sampler, centre, edge);
            let series = sampler.series(&values);
            field.add_cell(
                nearest as f32,
                truncation_errors(&series),
                Fine::new(&series),
            );
        }
        field
    }

    /// Adds the next cell: how far its centre is from the nearest charge, its errors, its series.
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
            let cells = half.map(|half| 2 * ((half + margin) / edge).ceil() as u32);
            let low = centre - cells.map(f64::from) * (edge / 2.0);
            shells.push(Shell {
                first,
                cells: cells.into(),
                low: low.map(|x| x as f32).into(),
                edge: edge as f32,
            });
            first += cells.product();
            if margin > reach {
                break;
            }
        }
        Self {
            centre: centre.map(|x| x as f32).into(),
            half: half.map(|x| x as f32).into(),
            inverse_margin: (1.0 / (MARGIN_CELLS * edge)) as f32,
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
                let number = if k > 0 && self.covers(k - 1, &corners) && !is_roomy(sites, &corners)
                {
                    COVERED
                } else if k + 1 < self.shells.len()
                    && is_roomy(sites, &self.shells[k + 1].corners_around(&middle(&corners)))
                {
                    ROOMY
                } else {
                    centres.push((middle(&corners), f64::from(shell.edge)));
                    centres.len() as u32 - 1
                };
                self.index[(shell.first + place) as usize] = number;
            }
        }
        centres
    }

    /// Whether the margin of box k holds all of a cell.
    fn covers(&self, k: usize, corners: &[[f64; 2]; 3]) -> bool {
        let margin = MARGIN_CELLS * f64::from(self.shells[k].edge);
        (0..3).all(|axis| {
            corners[axis].iter().all(|x| {
                (x - f64::from(self.centre[axis])).abs()
                    < f64::from(self.half[axis]) + margin - 1e-3
            })
        })
    }

    /// Where 16 points (Å, in the body's frame) lie; `None` if one is beyond the table. One operation
    /// on all points after another, as vector units like it.
    #[inline(always)]
    pub fn locate(&self, x: &[[f32; BLOCK]; 3]) -> Option<Spots> {
        let mut excess = [0.5; BLOCK];
        for axis in 0..3 {
            let (centre, half) = (self.centre[axis], self.half[axis]);
            for lane in 0..BLOCK {
                let outside = ((x[axis][lane] - centre).abs() - half) * self.inverse_margin;
                excess[lane] = if outside > excess[lane] {
                    outside
                } else {
                    excess[lane]
                };
            }
        }
        let mut number = excess.map(power_of_two_above);
        let (mut k, mut most) = (lowest(&number), highest(&number));
        let mut spots = Spots {
            cell: [COVERED; BLOCK],
            at: [[0.0; BLOCK]; 3],
            edge: [1.0; BLOCK],
        };
        // Rounding must not decide which larger cell stands for a smaller one: its middle does.
        let mut within = *x;
        loop {
            let shell = self.shells.get(k as usize)?;
            let here = self.locate_in(shell, &within, x);
            let mut any_roomy = false;
            for lane in 0..BLOCK {
                let is_here = number[lane] == k;
                if is_here {
                    spots.cell[lane] = here.cell[lane];
                    spots.edge[lane] = shell.edge;
                    (0..3).for_each(|axis| spots.at[axis][lane] = here.at[axis][lane]);
                }
                any_roomy |= is_here && here.cell[lane] == ROOMY;
            }
            if any_roomy {
                for lane in 0..BLOCK {
                    if number[lane] == k && here.cell[lane] == ROOMY {
                        number[lane] = k + 1;
                        for axis in 0..3 {
                            within[axis][lane] -= 0.5 * shell.edge * here.at[axis][lane];
                        }
                    }
                }
                most = most.max(k + 1);
            }
            if k == most {
                return Some(spots);
            }
            k += 1;
        }
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

    /// The same for the fine series.
    #[inline(always)]
    pub fn prefetch_fine(&self, spots: &Spots) {
        for cell in spots.cell {
            if let Some(series) = self.fine.get(cell as usize) {
                prefetch(series);
            }
        }
    }

    /// Where points lie in the cells of one box that hold the points of `within`; what is said of
    /// points beyond the box has no meaning.
    #[inline(always)]
    fn locate_in(&self, shell: &Shell, within: &[[f32; BLOCK]; 3], x: &[[f32; BLOCK]; 3]) -> Spots {
        let inverse = 1.0 / shell.edge;
        let mut place = [0_i32; BLOCK];
        let mut at = [[0.0; BLOCK]; 3];
        for axis in (0..3).rev() {
            let (low, cells) = (shell.low[axis], shell.cells[axis] as i32);
            let last = cells as f32 - 0.1;
            for lane in 0..BLOCK {
                let u = (x[axis][lane] - low) * inverse;
                let inside = (within[axis][lane] - low) * inverse;
                let inside = if inside > 0.0 { inside } else { 0.0 };
                let inside = if inside < last { inside } else { last };
                let whole = (inside - 0.5) + ROUNDER;
                at[axis][lane] = 2.0 * (u - (whole - ROUNDER)) - 1.0;
                place[lane] = place[lane] * cells + (whole.to_bits() & 0x003f_ffff) as i32;
            }
        }
        let mut cell = [0; BLOCK];
        for lane in 0..BLOCK {
            let place = shell.first as usize + place[lane] as usize;
            cell[lane] = self.index.get(place).copied().unwrap_or(COVERED);
        }
        let edge = [shell.edge; BLOCK];
        Spots { cell, at, edge }
    }

    /// The cell that holds a point, its edge (Å), and the point's coordinates in it from -1 to 1;
    /// `None` beyond the table.
    #[inline(always)]
    pub fn cell_at(&self, x: [f32; 3]) -> Option<(usize, f32, [f32; 3])> {
        let outside = |axis: usize| (x[axis] - self.centre[axis]).abs() - self.half[axis];
        let excess = outside(0).max(outside(1)).max(outside(2)) * self.inverse_margin;
        let mut within = x;
        for shell in self.shells.get(power_of_two_above(excess) as usize..)? {
            let (mut place, mut stride, mut at) = (shell.first, 1, [0.0; 3]);
            for axis in 0..3 {
                let [u, inside] = [x, within].map(|x| (x[axis] - shell.low[axis]) / shell.edge);
                let cell = (inside as u32).min(shell.cells[axis] - 1);
                place += stride * cell;
                stride *= shell.cells[axis];
                at[axis] = 2.0 * (u - cell as f32) - 1.0;
                within[axis] -= 0.5 * shell.edge * at[axis];
            }
            let cell = *self.index.get(place as usize)?;
            if cell != ROOMY {
                return Some((cell as usize, shell.edge, at));
            }
        }
        None
    }

    /// A lower bound on the distance of a point from the nearest charge, Å.
    #[inline(always)]
    pub fn distance_bound(&self, x: [f32; 3]) -> f32 {
        match self.cell_at(x) {
            Some((cell, edge, at)) => self.distance[cell] - 0.5 * edge * length(at),
            None => {
                let outside = |axis: usize| (x[axis] - self.centre[axis]).abs() - self.half[axis];
                outside(0).max(outside(1)).max(outside(2))
            }
        }
    }

    /// Variance of the energy of these charges from the coarse series, kT².
    #[inline(always)]
    pub fn coarse_variance(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f32 {
        let of = |(cell, charge): (&u32, &f32)| charge * charge * self.errors[*cell as usize][0];
        spots.cell.iter().zip(charge).map(of).sum()
    }

    /// The same from the fine series.
    #[inline(always)]
    pub fn fine_variance(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f32 {
        self.fine_variances(spots, charge).iter().sum()
    }

    /// That of each charge.
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
/// Each factor T_n with n > 0 has the mean square 1/2.
fn truncation_errors(series: &[f64]) -> [f32; 2] {
    let mut errors = [0.0; 2];
    for (place, coefficient) in series.iter().enumerate() {
        let orders = [place % FINE, place / FINE % FINE, place / (FINE * FINE)];
        let halves = orders.iter().filter(|n| **n > 0).count() as i32;
        let square = coefficient * coefficient * 0.5_f64.powi(halves);
        let highest = orders.into_iter().max().unwrap_or(0);
        let is_last = highest == FINE - 1 || !Fine::keeps(orders);
        errors[0] += if Packed::keeps(orders) { 0.0 } else { square };
        errors[1] += if is_last { square } else { 0.0 };
    }
    errors.map(|square| square as f32)
}

/// The least k ≥ 0 with x below 2^k, from the exponent.
#[inline(always)]
fn power_of_two_above(x: f32) -> u32 {
    let x = if x > 0.5 { x } else { 0.5 };
    (x.to_bits() >> 23) - 126
}

#[inline(always)]
fn lowest(numbers: &[u32; BLOCK]) -> u32 {
    numbers
        .iter()
        .fold(u32::MAX, |least, number| least.min(*number))
}

#[inline(always)]
fn highest(numbers: &[u32; BLOCK]) -> u32 {
    numbers.iter().fold(0, |most, number| most.max(*number))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
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
                let (cell, _, at) = field.cell_at(*place).unwrap();
                assert_eq!(spots.cell[lane] as usize, cell);
                for axis in 0..3 {
                    assert!((spots.at[axis][lane] - at[axis]).abs() < 1e-4);
                    assert!(at[axis].abs() < 1.0001);
                }
            }
        }
        assert!(field.index.contains(&ROOMY));
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
            let there = Vec3::from(place.map(f64::from));
            let sum: f64 = charges
                .iter()
                .map(|(site, charge)| {
                    let square = (site - there).norm_squared();
                    charge * f64::from(split.smooth_f32(square as f32))
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
