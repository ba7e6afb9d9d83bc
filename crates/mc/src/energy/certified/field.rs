//! The smooth part of one body's potential, in cubes with one polynomial each.
//!
//! The potential is sampled on a lattice that neighbouring cubes share, and a cube's polynomial is
//! the least-squares fit to the samples in it and on its faces. A cube whose residual is large is
//! divided once into eight. The error of a polynomial is its largest residual at the samples times
//! [`SAFETY`], and what one charge may hide between them near the two distances at which its kernel
//! is less smooth: a measured bound, not a proven one.

mod storage;

use super::leaves::{LEAF, Leaves};
use super::sampling::{LINE, SmoothKernel};
use super::split::{NEAR_DEGREE, Split};
use super::window::Bounded;
use crate::charges::LANES;
use nalgebra::DMatrix;
use protomer_kernel::potential::exp_of_minus;

/// Degree of the polynomials.
const DEGREE: usize = 7;
/// Coefficients of a polynomial ...
const COEFFICIENTS: usize = (DEGREE + 1) * (DEGREE + 2) * (DEGREE + 3) / 6;
/// ... and with those that fill whole vectors, zero.
const PADDED: usize = 128;
/// Samples along an edge of a cube, both ends included.
const SAMPLES: usize = 8;
/// Largest residual to bound.
const SAFETY: f64 = 2.0;
/// A cube is divided where its residual, at all charges of a body like this one, would add up to
/// more than this, kT: pair energies are then known about as well for bodies of many charges as for
/// those of few.
const DIVIDE_ABOVE: f64 = 2e-3;
const NO_CUBE: u32 = u32::MAX;
/// Marks the first of eight children.
const DIVIDED: u32 = 1 << 31;

/// The smooth part of a body's potential, kT/e.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SmoothField {
    /// Edge of a cube, Å.
    edge: f64,
    /// Lower corner of the grid of cubes, Å.
    corner: [f64; 3],
    /// Cubes along each axis.
    counts: [usize; 3],
    /// The cube at each place of the grid, x fastest.
    cubes: Vec<u32>,
    /// Coefficients by cube, in the order of [`exponents`].
    coefficients: Vec<Coefficients>,
    /// Error bound by cube, kT/e.
    errors: Vec<f32>,
}

/// The cubes of a target leaf's members, and where in them: -1 to 1 along each axis.
pub(super) struct Spots {
    cubes: [u32; LEAF],
    u: [[f32; LEAF]; 3],
}

#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
struct Coefficients([f32; PADDED]);

impl SmoothField {
    /// The field within `reach` (Å) of the charges' box.
    pub fn new(leaves: &Leaves, split: &Split, edge: f64, reach: f64) -> Self {
        let counts = leaves
            .half_extents
            .map(|half| (2.0 * (half + reach) / edge).ceil() as usize);
        let corner: [f64; 3] = std::array::from_fn(|axis| -0.5 * edge * counts[axis] as f64);
        let mut field = Self {
            edge,
            corner,
            counts,
            cubes: Vec::new(),
            coefficients: Vec::new(),
            errors: Vec::new(),
        };
        let fit = Fit::new();
        let largest = leaves
            .charge
            .iter()
            .flatten()
            .fold(0.0f64, |largest, charge| largest.max(charge.abs()));
        // Half the diagonal of a cell of samples.
        let hidden = |edge: f64| largest * split.hidden(0.87 * edge / (SAMPLES - 1) as f64);
        let farthest = 2.0 * (reach + leaves.half_extents.iter().sum::<f64>());
        let kernel = SmoothKernel::new(split, farthest);
        let kernel = kernel.as_ref();
        let samples = Samples::new(
            leaves,
            split,
            corner,
            edge,
            counts.map(|count| count * (SAMPLES - 1) + 1),
            reach + edge,
            kernel,
        );
        let divide_above = SAFETY * DIVIDE_ABOVE / leaves.magnitude.iter().sum::<f64>();
        let mut places = Vec::new();
        for index in 0..counts.iter().product() {
            let place = [
                index % counts[0],
                index / counts[0] % counts[1],
                index / counts[0] / counts[1],
            ];
            let outside = |axis: usize| {
                let centre = corner[axis] + (place[axis] as f64 + 0.5) * edge;
                (centre.abs() - leaves.half_extents[axis] - 0.5 * edge).max(0.0)
            };
            let distance = (outside(0).powi(2) + outside(1).powi(2) + outside(2).powi(2)).sqrt();
            if distance > reach {
                field.cubes.push(NO_CUBE);
            } else {
                field.cubes.push(places.len() as u32);
                places.push((index, place));
            }
        }
        for batch in places.chunks(LANES) {
            let corners: Vec<[usize; 3]> = batch
                .iter()
                .map(|(_, place)| place.map(|n| n * (SAMPLES - 1)))
                .collect();
            fit.batch(&corners, &samples, hidden(edge), &mut field);
        }
        for (cube, (index, place)) in places.iter().enumerate() {
            if f64::from(field.errors[cube]) > divide_above {
                field.cubes[*index] = field.errors.len() as u32 | DIVIDED;
                let low: [f64; 3] =
                    std::array::from_fn(|axis| corner[axis] + place[axis] as f64 * edge);
                let samples = Samples::new(
                    leaves,
                    split,
                    low,
                    0.5 * edge,
                    [2 * SAMPLES - 1; 3],
                    f64::INFINITY,
                    kernel,
                );
                let corners: Vec<[usize; 3]> = (0..8)
                    .map(|octant| {
                        [octant & 1, octant >> 1 & 1, octant >> 2].map(|n| n * (SAMPLES - 1))
                    })
                    .collect();
                fit.batch(&corners, &samples, hidden(0.5 * edge), &mut field);
            }
        }
        field
    }

    /// Where the members of a target leaf are among the cubes; asks the memory for these.
    #[inline(always)]
    pub fn locate(&self, places: [&[f64; LEAF]; 3], charge: &[f64; LEAF]) -> Spots {
        let inverse = 1.0 / self.edge;
        let mut spots = Spots {
            cubes: [NO_CUBE; LEAF],
            u: [[0.0; LEAF]; 3],
        };
        for i in 0..LEAF {
            let mut place = [0usize; 3];
            let mut u = [0.0; 3];
            let mut within = charge[i] != 0.0;
            for axis in 0..3 {
                let coordinate = (places[axis][i] - self.corner[axis]) * inverse;
                within &= coordinate >= 0.0 && coordinate < self.counts[axis] as f64;
                place[axis] = coordinate as usize;
                u[axis] = 2.0 * (coordinate - place[axis] as f64) - 1.0;
            }
            if !within {
                continue;
            }
            let mut cube =
                self.cubes[(place[2] * self.counts[1] + place[1]) * self.counts[0] + place[0]];
            if cube == NO_CUBE {
                continue;
            }
            if cube & DIVIDED != 0 {
                cube &= !DIVIDED;
                for (axis, u) in u.iter_mut().enumerate() {
                    let upper = *u >= 0.0;
                    cube += u32::from(upper) << axis;
                    *u = 2.0 * *u + if upper { -1.0 } else { 1.0 };
                }
            }
            self.prefetch(cube as usize);
            spots.cubes[i] = cube;
            for axis in 0..3 {
                spots.u[axis][i] = u[axis] as f32;
            }
        }
        spots
    }

    #[inline(always)]
    fn prefetch(&self, cube: usize) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            for line in self.coefficients[cube].0.chunks_exact(16) {
                // SAFETY: a prefetch reads nothing; the instruction is part of every x86-64
                // processor.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
            }
        }
    }

    /// The potential at the members of a target leaf, times their charges.
    #[inline(always)]
    pub fn sum<const WIDE: bool>(
        &self,
        spots: &Spots,
        charge: &[f64; LEAF],
        outside: impl Fn(usize) -> f64,
    ) -> Bounded {
        let mut sum = Bounded::default();
        for i in 0..LEAF {
            if charge[i] == 0.0 {
                continue;
            }
            match self.errors.get(spots.cubes[i] as usize) {
                Some(error) => {
                    let error = charge[i].abs() * f64::from(*error);
                    sum.error += error;
                    sum.square += error * error;
                }
                None => sum.value += charge[i] * outside(i),
            }
        }
        #[cfg(target_arch = "x86_64")]
        let lanes = if WIDE {
            // SAFETY: WIDE says that the processor has the features.
            unsafe { self.polynomials_avx512(spots, charge) }
        } else {
            self.polynomials(spots, charge)
        };
        #[cfg(not(target_arch = "x86_64"))]
        let lanes = self.polynomials(spots, charge);
        sum.value += lanes.iter().map(|lane| f64::from(*lane)).sum::<f64>();
        sum
    }

    /// The charges times their cubes' polynomials, in sixteen partial sums.
    #[inline(always)]
    fn polynomials(&self, spots: &Spots, charge: &[f64; LEAF]) -> [f32; 16] {
        let mut lanes = [0.0f32; 16];
        for i in 0..LEAF {
            if let Some(coefficients) = self.coefficients.get(spots.cubes[i] as usize) {
                let u = [spots.u[0][i], spots.u[1][i], spots.u[2][i]];
                add_polynomial(&coefficients.0, u, charge[i] as f32, &mut lanes);
            }
        }
        lanes
    }

    /// The same operations in the same order.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi1")]
    #[inline]
    fn polynomials_avx512(&self, spots: &Spots, charge: &[f64; LEAF]) -> [f32; 16] {
        use std::arch::x86_64::*;
        const INDICES: [[[i32; 16]; PADDED / 16]; 3] = indices();
        // SAFETY: arrays of sixteen integers.
        let at =
            INDICES.map(|axis| axis.map(|row| unsafe { _mm512_loadu_si512(row.as_ptr().cast()) }));
        let one = _mm512_set1_ps(1.0);
        // 1, u, u², u²u, u²u², u²u²u, and zeros for the padding.
        let powers = |u: f32| {
            let u = _mm512_set1_ps(u);
            let square = _mm512_mul_ps(u, u);
            let even = _mm512_mask_mov_ps(one, 0b1100, square);
            let even = _mm512_mask_mul_ps(even, 0b1111_0000, square, square);
            let even = _mm512_mask_mul_ps(even, 0b1100_0000, even, square);
            _mm512_mask_mul_ps(even, 0b1010_1010, even, u)
        };
        let mut lanes = _mm512_setzero_ps();
        for i in 0..LEAF {
            let Some(coefficients) = self.coefficients.get(spots.cubes[i] as usize) else {
                continue;
            };
            let [x, y, z] = [
                powers(spots.u[0][i]),
                powers(spots.u[1][i]),
                powers(spots.u[2][i]),
            ];
            let mut values = _mm512_setzero_ps();
            for (row, c) in coefficients.0.as_chunks::<16>().0.iter().enumerate() {
                let monomials = _mm512_mul_ps(
                    _mm512_mul_ps(
                        _mm512_permutexvar_ps(at[0][row], x),
                        _mm512_permutexvar_ps(at[1][row], y),
                    ),
                    _mm512_permutexvar_ps(at[2][row], z),
                );
                // SAFETY: an array of sixteen floats.
                values = _mm512_fmadd_ps(monomials, unsafe { _mm512_loadu_ps(c.as_ptr()) }, values);
            }
            lanes = _mm512_fmadd_ps(_mm512_set1_ps(charge[i] as f32), values, lanes);
        }
        let mut sums = [0.0; 16];
        // SAFETY: an array of sixteen floats.
        unsafe { _mm512_storeu_ps(sums.as_mut_ptr(), lanes) };
        sums
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.cubes[..])
            + size_of_val(&self.coefficients[..])
            + size_of_val(&self.errors[..])
    }
}

/// The exponents of the monomials, in the order of the coefficients, by exponent and place.
const EXPONENTS: [[u8; PADDED]; 3] = exponents();

const fn exponents() -> [[u8; PADDED]; 3] {
    let mut exponents = [[0; PADDED]; 3];
    let (mut at, mut total) = (0, 0);
    while total <= DEGREE {
        let mut i = 0;
        while i <= total {
            let mut j = 0;
            while j <= total - i {
                exponents[0][at] = i as u8;
                exponents[1][at] = j as u8;
                exponents[2][at] = (total - i - j) as u8;
                at += 1;
                j += 1;
            }
            i += 1;
        }
        total += 1;
    }
    exponents
}

/// The same by rows of sixteen.
const fn indices() -> [[[i32; 16]; PADDED / 16]; 3] {
    let mut indices = [[[0; 16]; PADDED / 16]; 3];
    let mut at = 0;
    while at < 3 * PADDED {
        indices[at / PADDED][at % PADDED / 16][at % 16] =
            EXPONENTS[at / PADDED][at % PADDED] as i32;
        at += 1;
    }
    indices
}

/// Adds `charge` times the polynomial's terms to sixteen partial sums.
#[inline(always)]
fn add_polynomial(c: &[f32; PADDED], u: [f32; 3], charge: f32, lanes: &mut [f32; 16]) {
    let powers = u.map(|u| {
        let square = u * u;
        [
            1.0,
            u,
            square,
            square * u,
            square * square,
            square * square * u,
            square * square * square,
            square * square * square * u,
        ]
    });
    let mut values = [0.0f32; 16];
    for row in 0..PADDED / 16 {
        for lane in 0..16 {
            let at = 16 * row + lane;
            let [x, y, z] = [EXPONENTS[0][at], EXPONENTS[1][at], EXPONENTS[2][at]].map(usize::from);
            values[lane] =
                (powers[0][x] * powers[1][y] * powers[2][z]).mul_add(c[at], values[lane]);
        }
    }
    for lane in 0..16 {
        lanes[lane] = charge.mul_add(values[lane], lanes[lane]);
    }
}

/// Samples of the potential on a lattice.
struct Samples {
    counts: [usize; 3],
    values: Vec<f64>,
}

impl Samples {
    /// Samples from `corner` on, [`SAMPLES`] to an edge; those farther than `reach` from the
    /// charges' box are left zero.
    fn new(
        leaves: &Leaves,
        split: &Split,
        corner: [f64; 3],
        edge: f64,
        counts: [usize; 3],
        reach: f64,
        kernel: Option<&SmoothKernel>,
    ) -> Self {
        let spacing = edge / (SAMPLES - 1) as f64;
        let mut values = vec![0.0; counts.iter().product()];
        let at = |axis: usize, index: usize| corner[axis] + index as f64 * spacing;
        let outside = |axis: usize, low: f64, high: f64| {
            let half = leaves.half_extents[axis];
            (low - half).max(-half - high).max(0.0)
        };
        let run = if kernel.is_some() { LINE } else { LANES };
        for k in 0..counts[2] {
            for j in 0..counts[1] {
                let (y, z) = (at(1, j), at(2, k));
                for start in (0..counts[0]).step_by(run) {
                    let length = run.min(counts[0] - start);
                    let (low, high) = (at(0, start), at(0, start + length - 1));
                    let square = outside(0, low, high).powi(2)
                        + outside(1, y, y).powi(2)
                        + outside(2, z, z).powi(2);
                    if square > reach * reach {
                        continue;
                    }
                    let first = (k * counts[1] + j) * counts[0] + start;
                    let values = values[first..first + length].iter_mut();
                    if let Some(kernel) = kernel {
                        let sum = kernel.line(
                            leaves,
                            &std::array::from_fn(|lane| at(0, start + lane)),
                            y,
                            z,
                        );
                        values.zip(sum).for_each(|(value, sum)| *value = sum);
                    } else {
                        let sum = line_f64(
                            leaves,
                            split,
                            &std::array::from_fn(|lane| at(0, start + lane)),
                            y,
                            z,
                        );
                        values.zip(sum).for_each(|(value, sum)| *value = sum);
                    }
                }
            }
        }
        Self { counts, values }
    }
}

/// The sums over all charges at points along a line, in both precisions.
macro_rules! line_sum {
    ($name:ident, $any:ident, $avx512:ident, $avx2:ident, $float:ty, $lanes:expr, $inverse_root:path, $exp_of_minus:path) => {
        fn $name(
            leaves: &Leaves,
            split: &Split,
            x: &[f64; $lanes],
            y: f64,
            z: f64,
        ) -> [$float; $lanes] {
            #[cfg(target_arch = "x86_64")]
            {
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                    // SAFETY: the processor has the features the function is compiled for.
                    return unsafe { $avx512(leaves, split, x, y, z) };
                }
                if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                    // SAFETY: the processor has the features the function is compiled for.
                    return unsafe { $avx2(leaves, split, x, y, z) };
                }
            }
            $any(leaves, split, x, y, z)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512dq,fma")]
        fn $avx512(
            leaves: &Leaves,
            split: &Split,
            x: &[f64; $lanes],
            y: f64,
            z: f64,
        ) -> [$float; $lanes] {
            $any(leaves, split, x, y, z)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2,fma")]
        fn $avx2(
            leaves: &Leaves,
            split: &Split,
            x: &[f64; $lanes],
            y: f64,
            z: f64,
        ) -> [$float; $lanes] {
            $any(leaves, split, x, y, z)
        }

        #[inline(always)]
        fn $any(
            leaves: &Leaves,
            split: &Split,
            x: &[f64; $lanes],
            y: f64,
            z: f64,
        ) -> [$float; $lanes] {
            let mut sum = [0.0 as $float; $lanes];
            let (centre, half) = (0.5 * (x[0] + x[$lanes - 1]), 0.5 * (x[$lanes - 1] - x[0]));
            let near_square = (split.near_radius * split.near_radius) as $float;
            let cut_square = (split.cutoff * split.cutoff) as $float;
            let origin = if split.cutoff.is_finite() {
                cut_square
            } else {
                0.0
            };
            let (bjerrum, kappa) = (split.bjerrum as $float, split.kappa as $float);
            let step = [
                split.step[0] as $float,
                split.step[1] as $float,
                split.step[2] as $float,
            ];
            let mut offset = [0.0 as $float; $lanes];
            for lane in 0..$lanes {
                offset[lane] = (x[lane] - centre) as $float;
            }
            for leaf in 0..leaves.len() {
                let [cx, cy, cz, radius] = leaves.spheres[leaf];
                let along = ((centre - cx).abs() - half).max(0.0);
                let square = along * along + (y - cy) * (y - cy) + (z - cz) * (z - cz);
                let reach = split.cutoff + radius + 1e-9;
                if square > reach * reach {
                    continue;
                }
                let close = split.near_radius + radius + 1e-9;
                let near = square < close * close;
                for i in 0..LEAF {
                    let (dy, dz) = (y - leaves.y[leaf][i], z - leaves.z[leaf][i]);
                    let (across, dx) = (
                        (dy * dy + dz * dz) as $float,
                        (centre - leaves.x[leaf][i]) as $float,
                    );
                    let charge = leaves.charge[leaf][i] as $float;
                    let mut t = [0.0 as $float; $lanes];
                    for lane in 0..$lanes {
                        let along = dx + offset[lane];
                        t[lane] = along.mul_add(along, across);
                    }
                    let mut value = [0.0 as $float; $lanes];
                    for lane in 0..$lanes {
                        let far = if t[lane] > near_square {
                            t[lane]
                        } else {
                            near_square
                        };
                        let inverse = $inverse_root(far);
                        value[lane] = bjerrum * $exp_of_minus(kappa * (far * inverse)) * inverse;
                    }
                    if near {
                        for lane in 0..$lanes {
                            let s = t[lane] - near_square;
                            let mut g = split.near[NEAR_DEGREE] as $float;
                            for k in (0..NEAR_DEGREE).rev() {
                                g = g.mul_add(s, split.near[k] as $float);
                            }
                            value[lane] = if s < 0.0 { g } else { value[lane] };
                        }
                    }
                    for lane in 0..$lanes {
                        let s = t[lane] - origin;
                        let smooth = value[lane] - step[2].mul_add(s, step[1]).mul_add(s, step[0]);
                        let weight = if t[lane] < cut_square { charge } else { 0.0 };
                        sum[lane] = weight.mul_add(smooth, sum[lane]);
                    }
                }
            }
            sum
        }
    };
}

line_sum!(
    line_f64,
    line_f64_any,
    line_f64_avx512,
    line_f64_avx2,
    f64,
    8,
    inverse_root,
    exp_of_minus
);

/// 1/√t in double precision.
#[inline(always)]
fn inverse_root(t: f64) -> f64 {
    1.0 / t.sqrt()
}

/// The least-squares fit: the same linear map from samples to coefficients for every cube.
struct Fit {
    /// Coefficients from samples, row by row.
    map: Vec<Vec<f64>>,
    /// Monomials at the samples, sample by sample.
    design: Vec<Vec<f64>>,
}

impl Fit {
    fn new() -> Self {
        let design: Vec<Vec<f64>> = (0..SAMPLES.pow(3))
            .map(|n| {
                let u = offset(n).map(|i| 2.0 * i as f64 / (SAMPLES - 1) as f64 - 1.0);
                let power = |axis: usize, at: usize| u[axis].powi(i32::from(EXPONENTS[axis][at]));
                (0..COEFFICIENTS)
                    .map(|at| power(0, at) * power(1, at) * power(2, at))
                    .collect()
            })
            .collect();
        let qr = DMatrix::from_fn(design.len(), COEFFICIENTS, |row, column| {
            design[row][column]
        })
        .qr();
        let mut map = qr.q().transpose();
        // The monomials are independent on these samples, so R can be inverted.
        let solved = qr.r().solve_upper_triangular_mut(&mut map);
        debug_assert!(solved);
        let map = (0..COEFFICIENTS)
            .map(|row| map.row(row).iter().copied().collect())
            .collect();
        Self { map, design }
    }

    /// Fits up to [`LANES`] cubes with their lower corners at these samples, and appends them to
    /// the field with `hidden` added to their errors.
    fn batch(
        &self,
        corners: &[[usize; 3]],
        samples: &Samples,
        hidden: f64,
        field: &mut SmoothField,
    ) {
        let index = |corner: &[usize; 3], n: usize| {
            let [i, j, k] = offset(n);
            ((corner[2] + k) * samples.counts[1] + corner[1] + j) * samples.counts[0]
                + corner[0]
                + i
        };
        let values: Vec<[f64; LANES]> = (0..SAMPLES.pow(3))
            .map(|n| {
                std::array::from_fn(|lane| {
                    corners
                        .get(lane)
                        .map_or(0.0, |c| samples.values[index(c, n)])
                })
            })
            .collect();
        let mut coefficients = [[0.0; LANES]; COEFFICIENTS];
        let mut residuals = [0.0; LANES];
        fit_lanes(self, &values, &mut coefficients, &mut residuals);
        for lane in 0..corners.len() {
            // Rounding of each coefficient, of the monomial and of the sum.
            let size: f64 = coefficients.iter().map(|c| c[lane].abs()).sum();
            let rounding = 6.0 * 0.5 * f64::from(f32::EPSILON) * size;
            field
                .coefficients
                .push(Coefficients(std::array::from_fn(|i| {
                    coefficients.get(i).map_or(0.0, |c| c[lane] as f32)
                })));
            field
                .errors
                .push((SAFETY * residuals[lane] + hidden + rounding) as f32 * 1.0001);
        }
    }
}

/// The place of a sample in a cube.
fn offset(n: usize) -> [usize; 3] {
    [n % SAMPLES, n / SAMPLES % SAMPLES, n / SAMPLES / SAMPLES]
}

fn fit_lanes(
    fit: &Fit,
    values: &[[f64; LANES]],
    out: &mut [[f64; LANES]; COEFFICIENTS],
    residuals: &mut [f64; LANES],
) {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor has the feature the function is compiled for.
            return unsafe { fit_lanes_avx512(fit, values, out, residuals) };
        }
    }
    fit_lanes_any(fit, values, out, residuals);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn fit_lanes_avx512(
    fit: &Fit,
    values: &[[f64; LANES]],
    out: &mut [[f64; LANES]; COEFFICIENTS],
    residuals: &mut [f64; LANES],
) {
    fit_lanes_any(fit, values, out, residuals);
}

#[inline(always)]
fn fit_lanes_any(
    fit: &Fit,
    values: &[[f64; LANES]],
    out: &mut [[f64; LANES]; COEFFICIENTS],
    residuals: &mut [f64; LANES],
) {
    for (row, out) in fit.map.iter().zip(out.iter_mut()) {
        let mut sums = [[0.0; LANES]; 4];
        for (chunk, weights) in values.chunks(4).zip(row.chunks(4)) {
            for ((sum, value), weight) in sums.iter_mut().zip(chunk).zip(weights) {
                for lane in 0..LANES {
                    sum[lane] += weight * value[lane];
                }
            }
        }
        *out = std::array::from_fn(|lane| sums.iter().map(|sum| sum[lane]).sum());
    }
    for (row, value) in fit.design.iter().zip(values) {
        let mut sums = [[0.0; LANES]; 4];
        for (chunk, powers) in out.chunks(4).zip(row.chunks(4)) {
            for ((sum, coefficient), power) in sums.iter_mut().zip(chunk).zip(powers) {
                for lane in 0..LANES {
                    sum[lane] += power * coefficient[lane];
                }
            }
        }
        for lane in 0..LANES {
            let fitted: f64 = sums.iter().map(|sum| sum[lane]).sum();
            residuals[lane] = residuals[lane].max((fitted - value[lane]).abs());
        }
    }
}
