//! The smooth part of a body's potential, tabulated in the body's frame.
//!
//! Boxes around the charges, each with twice the margin of the one inside it and cells of twice the
//! edge, so that a cell's edge is at most half its distance from the charges. In a cell the
//! potential is a Chebyshev series in three coordinates, from its values at 6³ Chebyshev points;
//! decisions that need less use the first 4³ coefficients, in a short form (`packed`).

use super::packed::{COARSE, Head, Packed, pack};
use super::split::Split;
use crate::charges::ChargeCloud;
use crate::energy::SitePotential;
use protomer_kernel::Vec3;
use std::f64::consts::PI;

/// Points of a fine series along each axis.
pub(super) const FINE: usize = 6;
/// Its coefficients: x runs fastest, then y, then z.
pub(super) const FINE_STRIDE: usize = 6;
pub(super) const FINE_ROW: usize = FINE * FINE_STRIDE;
const FINE_SIZE: usize = FINE_ROW * FINE;
/// The near part ends this many innermost cells from a charge.
const CELLS_PER_NEAR_RADIUS: f64 = 2.0;
/// Margin of the innermost box, in cells.
const MARGIN_CELLS: f64 = 4.0;
/// The outermost box has at most this many times the innermost margin (as a power of two).
const MOST_SHELLS: usize = 14;
/// Points evaluated together.
pub(super) const BLOCK: usize = 16;
/// A cell that a smaller box covers.
const COVERED: u32 = u32::MAX;

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
    heads: Vec<Head>,
    coarse: Vec<Packed>,
    pub fine: Vec<Aligned>,
}

/// The coefficients of a cell, in whole lines of the cache.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Aligned(pub [f32; FINE_SIZE]);

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
    cell: [u32; BLOCK],
    at: [[f32; BLOCK]; 3],
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
        let centres = field.number_cells();
        for (centre, edge) in centres {
            let (values, nearest) = sites.sample(split, &sampler, centre, edge);
            let series = sampler.series(&values);
            field.add_cell(nearest as f32, truncation_errors(&series), rows(&series));
        }
        field
    }

    /// Adds the next cell: how far its centre is from the nearest charge, its errors, its series.
    pub fn add_cell(&mut self, distance: f32, errors: [f32; 2], fine: Aligned) {
        let (head, coarse) = pack(&fine.0);
        self.distance.push(distance);
        self.errors.push(errors);
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
            let cells = half.map(|half| (2.0 * (half + margin) / edge).ceil() as u32);
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

    /// Gives each cell that no smaller box covers its number; centres and edges in that order.
    pub fn number_cells(&mut self) -> Vec<([f64; 3], f64)> {
        let mut centres = Vec::new();
        for k in 0..self.shells.len() {
            let shell = self.shells[k];
            let [nx, ny, nz] = shell.cells;
            for place in 0..nx * ny * nz {
                let cell = [place % nx, place / nx % ny, place / (nx * ny)];
                let corner = |axis: usize, side: u32| {
                    f64::from(shell.low[axis])
                        + f64::from(cell[axis] + side) * f64::from(shell.edge)
                };
                let corners = [0, 1, 2].map(|axis| [corner(axis, 0), corner(axis, 1)]);
                if k > 0 && self.covers(k - 1, &corners) {
                    continue;
                }
                self.index[(shell.first + place) as usize] = centres.len() as u32;
                centres.push((
                    corners.map(|[low, high]| (low + high) / 2.0),
                    f64::from(shell.edge),
                ));
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
        let number = excess.map(power_of_two_above);
        let (least, most) = (lowest(&number), highest(&number));
        let mut spots = self.locate_in(self.shells.get(most as usize)?, x);
        for k in least..most {
            let others = self.locate_in(self.shells.get(k as usize)?, x);
            for lane in 0..BLOCK {
                if number[lane] == k {
                    spots.cell[lane] = others.cell[lane];
                    (0..3).for_each(|axis| spots.at[axis][lane] = others.at[axis][lane]);
                }
            }
        }
        Some(spots)
    }

    /// Where points lie in one box; what is said of points beyond it has no meaning.
    #[inline(always)]
    fn locate_in(&self, shell: &Shell, x: &[[f32; BLOCK]; 3]) -> Spots {
        let inverse = 1.0 / shell.edge;
        let mut place = [0_i32; BLOCK];
        let mut at = [[0.0; BLOCK]; 3];
        for axis in (0..3).rev() {
            let (low, cells) = (shell.low[axis], shell.cells[axis] as i32);
            let last = cells as f32 - 0.1;
            for lane in 0..BLOCK {
                let u = (x[axis][lane] - low) * inverse;
                let inside = if u > 0.0 { u } else { 0.0 };
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
        Spots { cell, at }
    }

    /// The smallest box that holds a point.
    fn shell(&self, x: [f32; 3]) -> u32 {
        let outside = |axis: usize| (x[axis] - self.centre[axis]).abs() - self.half[axis];
        power_of_two_above(outside(0).max(outside(1)).max(outside(2)) * self.inverse_margin)
    }

    /// A lower bound on the distance of a point from the nearest charge, Å.
    #[inline(always)]
    pub fn distance_bound(&self, x: [f32; 3]) -> f32 {
        let Some(shell) = self.shells.get(self.shell(x) as usize) else {
            let outside = |axis: usize| (x[axis] - self.centre[axis]).abs() - self.half[axis];
            return outside(0).max(outside(1)).max(outside(2));
        };
        let (mut place, mut square, mut stride) = (shell.first, 0.0, 1);
        for axis in 0..3 {
            let u = (x[axis] - shell.low[axis]) / shell.edge;
            let cell = (u as u32).min(shell.cells[axis] - 1);
            place += stride * cell;
            stride *= shell.cells[axis];
            let from_centre = u - cell as f32 - 0.5;
            square += from_centre * from_centre;
        }
        let cell = self.index[place as usize];
        self.distance[cell as usize] - shell.edge * square.sqrt()
    }

    /// Adds charge times coarse potential of each spot to the lanes of `sum`. `FUSED`: where
    /// multiply-add is one instruction.
    #[inline(always)]
    pub fn add_coarse<const FUSED: bool>(
        &self,
        spots: &Spots,
        charge: &[f32; BLOCK],
        sum: &mut [f32; BLOCK],
    ) {
        let mut first = [0.0; BLOCK];
        for point in 0..BLOCK {
            let cell = spots.cell[point] as usize;
            let (Packed(rows), head) = (&self.coarse[cell], &self.heads[cell]);
            let [x, y, z] = [0, 1, 2].map(|axis| spots.at[axis][point]);
            first[point] = head.first;
            let charge = charge[point] * head.unit;
            let (xx, yy, zz) = (x * x, y * y, z * z);
            let (z2, z3) = (2.0 * zz - 1.0, z * (4.0 * zz - 3.0));
            for lane in 0..BLOCK {
                let mut value = f32::from(rows[0][lane]);
                value = add::<FUSED>(f32::from(rows[1][lane]), z, value);
                value = add::<FUSED>(f32::from(rows[2][lane]), z2, value);
                value = add::<FUSED>(f32::from(rows[3][lane]), z3, value);
                // T_0 to T_3 are products of 1 or x with 1, 2x² - 1 or 4x² - 3.
                let of_x = add::<FUSED>(ODD_X[lane], x, EVEN_X[lane])
                    * add::<FUSED>(SLOPE_X[lane], xx, SHIFT_X[lane]);
                let of_y = add::<FUSED>(ODD_Y[lane], y, EVEN_Y[lane])
                    * add::<FUSED>(SLOPE_Y[lane], yy, SHIFT_Y[lane]);
                sum[lane] = add::<FUSED>(value, of_x * (of_y * charge), sum[lane]);
            }
        }
        for lane in 0..BLOCK {
            sum[lane] = add::<FUSED>(charge[lane], first[lane], sum[lane]);
        }
    }

    /// Charge times fine potential of each spot, summed.
    #[inline(always)]
    pub fn fine(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f64 {
        let mut total = 0.0;
        for point in 0..BLOCK {
            let rows = &self.fine[spots.cell[point] as usize].0;
            let [tx, ty, tz] = spots.at.map(|axis| chebyshev::<FINE>(axis[point]));
            let mut value = [0.0_f32; FINE_ROW];
            for (row, tz) in rows.chunks_exact(FINE_ROW).zip(tz) {
                for lane in 0..FINE_ROW {
                    value[lane] += row[lane] * tz;
                }
            }
            let mut sum = [0.0; FINE_STRIDE];
            for (row, ty) in value.chunks_exact(FINE_STRIDE).zip(ty) {
                for lane in 0..FINE_STRIDE {
                    sum[lane] += row[lane] * ty;
                }
            }
            let potential: f32 = (0..FINE).map(|x| sum[x] * tx[x]).sum();
            total += f64::from(potential) * f64::from(charge[point]);
        }
        total
    }

    /// Variance of the energy of these charges from the coarse series, kT².
    #[inline(always)]
    pub fn coarse_variance(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f32 {
        let of = |(cell, charge): (&u32, &f32)| charge * charge * self.errors[*cell as usize][0];
        spots.cell.iter().zip(charge).map(of).sum()
    }

    /// The same from the fine series.
    pub fn fine_variance(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f32 {
        let of = |(cell, charge): (&u32, &f32)| charge * charge * self.errors[*cell as usize][1];
        spots.cell.iter().zip(charge).map(of).sum()
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let cell = 4 * (1 + 2 + FINE_SIZE) + size_of::<Head>() + size_of::<Packed>();
        4 * self.index.len() + cell * self.distance.len()
    }
}

/// T_0 to T_{N-1} at t.
#[inline(always)]
fn chebyshev<const N: usize>(t: f32) -> [f32; N] {
    let mut values = [1.0; N];
    values[1] = t;
    for n in 2..N {
        values[n] = 2.0 * t * values[n - 1] - values[n - 2];
    }
    values
}

/// Mean squares of what a series leaves out: of the coarse one, all higher coefficients; of the fine
/// one, no more than its last coefficients, whose successors are smaller. Each factor T_n with n > 0
/// has the mean square 1/2.
fn truncation_errors(series: &[f64]) -> [f32; 2] {
    let mut errors = [0.0; 2];
    for (place, coefficient) in series.iter().enumerate() {
        let orders = [place % FINE, place / FINE % FINE, place / (FINE * FINE)];
        let halves = orders.iter().filter(|n| **n > 0).count() as i32;
        let square = coefficient * coefficient * 0.5_f64.powi(halves);
        let highest = orders.into_iter().max().unwrap_or(0);
        errors[0] += if highest >= COARSE { square } else { 0.0 };
        errors[1] += if highest == FINE - 1 { square } else { 0.0 };
    }
    errors.map(|square| square as f32)
}

/// The coefficients in single precision.
fn rows(series: &[f64]) -> Aligned {
    let mut rows = [0.0; FINE_SIZE];
    for (row, values) in rows
        .chunks_exact_mut(FINE_STRIDE)
        .zip(series.chunks_exact(FINE))
    {
        for (place, value) in row.iter_mut().zip(values) {
            *place = *value as f32;
        }
    }
    Aligned(rows)
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

/// a b + c.
#[inline(always)]
fn add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Adding it rounds to an integer, which then is in the low bits.
const ROUNDER: f32 = 12_582_912.0; // 1.5 · 2²³

const ODD: [f32; 4] = [0.0, 1.0, 0.0, 1.0];
const EVEN: [f32; 4] = [1.0, 0.0, 1.0, 0.0];
const SLOPE: [f32; 4] = [0.0, 0.0, 2.0, 4.0];
const SHIFT: [f32; 4] = [1.0, 1.0, -1.0, -3.0];
const ODD_X: [f32; BLOCK] = along_x(ODD);
const EVEN_X: [f32; BLOCK] = along_x(EVEN);
const SLOPE_X: [f32; BLOCK] = along_x(SLOPE);
const SHIFT_X: [f32; BLOCK] = along_x(SHIFT);
const ODD_Y: [f32; BLOCK] = along_y(ODD);
const EVEN_Y: [f32; BLOCK] = along_y(EVEN);
const SLOPE_Y: [f32; BLOCK] = along_y(SLOPE);
const SHIFT_Y: [f32; BLOCK] = along_y(SHIFT);

/// Lane 4 j + i has the value of i.
const fn along_x(of: [f32; 4]) -> [f32; BLOCK] {
    let mut lanes = [0.0; BLOCK];
    let mut lane = 0;
    while lane < BLOCK {
        lanes[lane] = of[lane % COARSE];
        lane += 1;
    }
    lanes
}

/// Lane 4 j + i has the value of j.
const fn along_y(of: [f32; 4]) -> [f32; BLOCK] {
    let mut lanes = [0.0; BLOCK];
    let mut lane = 0;
    while lane < BLOCK {
        lanes[lane] = of[lane / COARSE];
        lane += 1;
    }
    lanes
}

/// The Chebyshev points and the transform from values to coefficients.
struct Sampler {
    points: [f64; FINE],
    transform: [[f64; FINE]; FINE],
}

impl Sampler {
    fn new() -> Self {
        let angle = |i: usize| PI * (i as f64 + 0.5) / FINE as f64;
        let weight = |n: usize| if n == 0 { 1.0 } else { 2.0 } / FINE as f64;
        Self {
            points: std::array::from_fn(|i| angle(i).cos()),
            transform: std::array::from_fn(|n| {
                std::array::from_fn(|i| weight(n) * (n as f64 * angle(i)).cos())
            }),
        }
    }

    /// Coefficients from values, one axis after the other; x runs fastest.
    fn series(&self, values: &[f64]) -> Vec<f64> {
        let mut from = values.to_vec();
        for stride in [1, FINE, FINE * FINE] {
            let mut to = vec![0.0; from.len()];
            for (place, to) in to.iter_mut().enumerate() {
                let n = place / stride % FINE;
                let start = place - n * stride;
                *to = (0..FINE)
                    .map(|i| self.transform[n][i] * from[start + i * stride])
                    .sum();
            }
            from = to;
        }
        from
    }
}

/// The charges in arrays of 16.
struct Sites {
    blocks: Vec<[[f32; BLOCK]; 4]>,
}

impl Sites {
    fn new(charges: &ChargeCloud) -> Self {
        let sites: Vec<_> = charges.iter().collect();
        let block = |sites: &[(Vec3, f64)]| {
            let mut block = [[0.0; BLOCK]; 4];
            for lane in 0..BLOCK {
                // Empty lanes repeat the last place without a charge.
                let (x, charge) = sites[lane.min(sites.len() - 1)];
                (0..3).for_each(|axis| block[axis][lane] = x[axis] as f32);
                block[3][lane] = if lane < sites.len() {
                    charge as f32
                } else {
                    0.0
                };
            }
            block
        };
        Self {
            blocks: sites.chunks(BLOCK).map(block).collect(),
        }
    }

    /// The smooth potential at the Chebyshev points of a cell, and how far the nearest charge is
    /// from its centre. Single precision, which is that of the stored series.
    fn sample<P: SitePotential>(
        &self,
        split: &Split<P>,
        sampler: &Sampler,
        centre: [f64; 3],
        edge: f64,
    ) -> (Vec<f64>, f64) {
        let at = |axis: usize, i: usize| (centre[axis] + 0.5 * edge * sampler.points[i]) as f32;
        let mut values = Vec::with_capacity(FINE * FINE * FINE);
        for place in 0..FINE * FINE * FINE {
            let [i, j, k] = [place % FINE, place / FINE % FINE, place / (FINE * FINE)];
            values.push(f64::from(
                self.potential(split, [at(0, i), at(1, j), at(2, k)]),
            ));
        }
        (values, self.nearest(centre.map(|x| x as f32)))
    }

    fn potential<P: SitePotential>(&self, split: &Split<P>, x: [f32; 3]) -> f32 {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            // SAFETY: the processor has the two features the function is compiled for.
            return unsafe { self.potential_avx512(split, x) };
        }
        self.sum(split, x)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq")]
    fn potential_avx512<P: SitePotential>(&self, split: &Split<P>, x: [f32; 3]) -> f32 {
        self.sum(split, x)
    }

    #[inline(always)]
    fn sum<P: SitePotential>(&self, split: &Split<P>, [x, y, z]: [f32; 3]) -> f32 {
        let mut sum = [0.0; BLOCK];
        for [sx, sy, sz, charge] in &self.blocks {
            for lane in 0..BLOCK {
                let (dx, dy, dz) = (x - sx[lane], y - sy[lane], z - sz[lane]);
                sum[lane] += charge[lane] * split.smooth_f32(dx * dx + dy * dy + dz * dz);
            }
        }
        sum.iter().sum()
    }

    fn nearest(&self, [x, y, z]: [f32; 3]) -> f64 {
        let mut least = [f32::INFINITY; BLOCK];
        for [sx, sy, sz, _] in &self.blocks {
            for lane in 0..BLOCK {
                let (dx, dy, dz) = (x - sx[lane], y - sy[lane], z - sz[lane]);
                least[lane] = least[lane].min(dx * dx + dy * dy + dz * dz);
            }
        }
        f64::from(least.into_iter().fold(f32::INFINITY, f32::min)).sqrt()
    }
}
