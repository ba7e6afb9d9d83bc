//! The smooth part of the potential along a line of sixteen points, in single precision.
//!
//! The smooth kernel s(t) beyond R is tabulated: four intervals to each octave of t = r², a
//! polynomial of degree five in each. The two lowest bits of the exponent's end and the mantissa's
//! begin say which, so that 32 intervals span a factor of 256 in t; below R the kernel is a
//! polynomial anyway. Sums over a leaf go on in double precision.

use super::leaves::{LEAF, Leaves};
use super::split::{NEAR_DEGREE, Split};

/// Points sampled at once.
pub(super) const LINE: usize = 16;
/// Degree of the table's polynomials.
const DEGREE: usize = 5;
/// Intervals of the table, by the low five bits of the quarter octave.
const INTERVALS: usize = 32;

/// s(t) for single precision.
#[derive(Debug, Clone)]
pub(super) struct SmoothKernel {
    /// Coefficients of u⁰, u¹, ... by interval; u is -1/2 at its lower and 1/2 at its upper end.
    table: [[f32; INTERVALS]; DEGREE + 1],
    /// Coefficients of (t - R²)ⁿ for t < R².
    near: [f32; NEAR_DEGREE + 1],
    near_square: f32,
    cut_square: f32,
    near_radius: f64,
    cutoff: f64,
}

impl SmoothKernel {
    /// The kernel out to `farthest` (Å); `None` if that is more than the table holds.
    pub fn new(split: &Split, farthest: f64) -> Option<Self> {
        let (near_square, cut_square) = (split.near_radius.powi(2), split.cutoff.powi(2));
        let quarter = |t: f64| (t as f32).to_bits() >> 21;
        let far_square = cut_square.min(farthest.powi(2));
        let first = quarter(near_square);
        if !far_square.is_finite() || quarter(far_square) >= first + INTERVALS as u32 {
            return None;
        }
        let mut table = [[0.0; INTERVALS]; DEGREE + 1];
        for at in first..first + INTERVALS as u32 {
            let (low, high) = (
                f64::from(f32::from_bits(at << 21)),
                f64::from(f32::from_bits((at + 1) << 21)),
            );
            let fit = interpolate(|u| split.beyond_near(low + (u + 0.5) * (high - low)));
            for (row, coefficient) in table.iter_mut().zip(fit) {
                row[at as usize % INTERVALS] = coefficient as f32;
            }
        }
        let mut near = split.near;
        if split.cutoff.is_finite() {
            // The step's polynomial about R² instead of r_cut².
            let (d, [c0, c1, c2]) = (near_square - cut_square, split.step);
            near[0] -= c0 + d * (c1 + d * c2);
            near[1] -= c1 + 2.0 * d * c2;
            near[2] -= c2;
        }
        Some(Self {
            table,
            near: near.map(|c| c as f32),
            near_square: near_square as f32,
            cut_square: cut_square as f32,
            near_radius: split.near_radius,
            cutoff: split.cutoff,
        })
    }

    /// The sums over all charges at sixteen points with these x coordinates (ascending) and one y
    /// and z.
    pub fn line(&self, leaves: &Leaves, x: &[f64; LINE], y: f64, z: f64) -> [f64; LINE] {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") {
                // SAFETY: the processor has the feature the function is compiled for.
                return unsafe { self.sum_avx512(leaves, x, y, z) };
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the processor has the features the function is compiled for.
                return unsafe { self.sum_avx2(leaves, x, y, z) };
            }
        }
        self.sum(leaves, x, y, z)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn sum_avx2(&self, leaves: &Leaves, x: &[f64; LINE], y: f64, z: f64) -> [f64; LINE] {
        self.sum(leaves, x, y, z)
    }

    #[inline(always)]
    fn sum(&self, leaves: &Leaves, x: &[f64; LINE], y: f64, z: f64) -> [f64; LINE] {
        let line = Line::new(x, y, z);
        let mut sum = [0.0f64; LINE];
        for leaf in 0..leaves.len() {
            let Some(near) = self.reach(&line, &leaves.spheres[leaf]) else {
                continue;
            };
            let mut part = [0.0f32; LINE];
            for i in 0..LEAF {
                let (across, along, charge) = line.to(leaves, leaf, i);
                for lane in 0..LINE {
                    let d = along + line.offset[lane];
                    let t = d.mul_add(d, across);
                    let mut value = self.beyond(if t > self.near_square {
                        t
                    } else {
                        self.near_square
                    });
                    if near {
                        let s = t - self.near_square;
                        let mut g = self.near[NEAR_DEGREE];
                        for k in (0..NEAR_DEGREE).rev() {
                            g = g.mul_add(s, self.near[k]);
                        }
                        value = if s < 0.0 { g } else { value };
                    }
                    part[lane] = if t < self.cut_square {
                        charge.mul_add(value, part[lane])
                    } else {
                        part[lane]
                    };
                }
            }
            for lane in 0..LINE {
                sum[lane] += f64::from(part[lane]);
            }
        }
        sum
    }

    #[inline(always)]
    fn beyond(&self, t: f32) -> f32 {
        let bits = t.to_bits();
        let at = (bits >> 21) as usize % INTERVALS;
        let u = f32::from_bits((bits << 2) & 0x007f_ffff | 0x3f80_0000) - 1.5;
        let mut value = self.table[DEGREE][at];
        for k in (0..DEGREE).rev() {
            value = value.mul_add(u, self.table[k][at]);
        }
        value
    }

    /// Whether a leaf has charges within the cut-off of the line (`Some`), and within R (`true`).
    #[inline(always)]
    fn reach(&self, line: &Line, [cx, cy, cz, radius]: &[f64; 4]) -> Option<bool> {
        let along = ((line.centre - cx).abs() - line.half).max(0.0);
        let square = along * along + (line.y - cy) * (line.y - cy) + (line.z - cz) * (line.z - cz);
        let (reach, close) = (
            self.cutoff + radius + 1e-9,
            self.near_radius + radius + 1e-9,
        );
        (square <= reach * reach).then_some(square < close * close)
    }

    /// The same operations in the same order, sixteen at once.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f")]
    fn sum_avx512(&self, leaves: &Leaves, x: &[f64; LINE], y: f64, z: f64) -> [f64; LINE] {
        use std::arch::x86_64::*;
        let line = Line::new(x, y, z);
        // SAFETY: every row of the table is 32 floats long, `offset` 16, `sum` 16 doubles;
        // unaligned access is allowed.
        let rows: [[__m512; 2]; DEGREE + 1] = unsafe {
            std::array::from_fn(|k| {
                [
                    _mm512_loadu_ps(self.table[k].as_ptr()),
                    _mm512_loadu_ps(self.table[k].as_ptr().add(16)),
                ]
            })
        };
        // SAFETY: as above.
        let offset = unsafe { _mm512_loadu_ps(line.offset.as_ptr()) };
        let near = self.near.map(|c| _mm512_set1_ps(c));
        let near_square = _mm512_set1_ps(self.near_square);
        let cut_square = _mm512_set1_ps(self.cut_square);
        let (mantissa, one) = (
            _mm512_set1_epi32(0x007f_ffff),
            _mm512_set1_epi32(0x3f80_0000),
        );
        let middle = _mm512_set1_ps(1.5);
        let (mut low, mut high) = (_mm512_setzero_pd(), _mm512_setzero_pd());
        for leaf in 0..leaves.len() {
            let Some(close) = self.reach(&line, &leaves.spheres[leaf]) else {
                continue;
            };
            let mut part = _mm512_setzero_ps();
            for i in 0..LEAF {
                let (across, along, charge) = line.to(leaves, leaf, i);
                let d = _mm512_add_ps(_mm512_set1_ps(along), offset);
                let t = _mm512_fmadd_ps(d, d, _mm512_set1_ps(across));
                let bits = _mm512_castps_si512(_mm512_max_ps(t, near_square));
                let at = _mm512_srli_epi32::<21>(bits);
                // (bits << 2 & mantissa) | one
                let fraction =
                    _mm512_ternarylogic_epi32::<0xea>(_mm512_slli_epi32::<2>(bits), mantissa, one);
                let u = _mm512_sub_ps(_mm512_castsi512_ps(fraction), middle);
                let mut value = _mm512_permutex2var_ps(rows[DEGREE][0], at, rows[DEGREE][1]);
                for k in (0..DEGREE).rev() {
                    value = _mm512_fmadd_ps(
                        value,
                        u,
                        _mm512_permutex2var_ps(rows[k][0], at, rows[k][1]),
                    );
                }
                if close {
                    let s = _mm512_sub_ps(t, near_square);
                    let mut g = near[NEAR_DEGREE];
                    for k in (0..NEAR_DEGREE).rev() {
                        g = _mm512_fmadd_ps(g, s, near[k]);
                    }
                    let inner = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(s, _mm512_setzero_ps());
                    value = _mm512_mask_blend_ps(inner, value, g);
                }
                let within = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, cut_square);
                part = _mm512_mask3_fmadd_ps(_mm512_set1_ps(charge), value, part, within);
            }
            low = _mm512_add_pd(low, _mm512_cvtps_pd(_mm512_castps512_ps256(part)));
            let upper = _mm512_shuffle_f32x4::<0b1110>(part, part);
            high = _mm512_add_pd(high, _mm512_cvtps_pd(_mm512_castps512_ps256(upper)));
        }
        let mut sum = [0.0; LINE];
        // SAFETY: two halves of eight doubles of an array of sixteen.
        unsafe {
            _mm512_storeu_pd(sum.as_mut_ptr(), low);
            _mm512_storeu_pd(sum.as_mut_ptr().add(8), high);
        }
        sum
    }
}

/// Sixteen points of one y and z.
struct Line {
    centre: f64,
    half: f64,
    y: f64,
    z: f64,
    offset: [f32; LINE],
}

impl Line {
    #[inline(always)]
    fn new(x: &[f64; LINE], y: f64, z: f64) -> Self {
        let centre = 0.5 * (x[0] + x[LINE - 1]);
        Self {
            centre,
            half: 0.5 * (x[LINE - 1] - x[0]),
            y,
            z,
            offset: x.map(|x| (x - centre) as f32),
        }
    }

    /// A charge's squared distance from the line, its place along it and its charge.
    #[inline(always)]
    fn to(&self, leaves: &Leaves, leaf: usize, i: usize) -> (f32, f32, f32) {
        let (dy, dz) = (self.y - leaves.y[leaf][i], self.z - leaves.z[leaf][i]);
        (
            (dy * dy + dz * dz) as f32,
            (self.centre - leaves.x[leaf][i]) as f32,
            leaves.charge[leaf][i] as f32,
        )
    }
}

/// The polynomial in u through f at the Chebyshev nodes of [-1/2, 1/2].
fn interpolate(f: impl Fn(f64) -> f64) -> [f64; DEGREE + 1] {
    const N: usize = DEGREE + 1;
    let node: [f64; N] = std::array::from_fn(|k| {
        0.5 * ((2 * k + 1) as f64 * std::f64::consts::PI / (2 * N) as f64).cos()
    });
    // Newton's divided differences, then expanded in powers of u.
    let mut difference = node.map(&f);
    for order in 1..N {
        for k in (order..N).rev() {
            difference[k] = (difference[k] - difference[k - 1]) / (node[k] - node[k - order]);
        }
    }
    let mut powers = [0.0; N];
    for k in (0..N).rev() {
        for n in (1..N).rev() {
            powers[n] = powers[n - 1] - node[k] * powers[n];
        }
        powers[0] = difference[k] - node[k] * powers[0];
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charges::ChargeCloud;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn every_instruction_set_samples_alike_and_as_the_sum() {
        let mut rng = CounterRng::new(5, 0, 0);
        let charges: Vec<_> = (0..300)
            .map(|_| (rng.vector_in_ball(15.0), rng.uniform_in(-1.0, 1.0)))
            .collect();
        let leaves = Leaves::new(&ChargeCloud::new(&charges), 5.0);
        for (debye, cutoff, radius) in [(9.6, 48.0, 10.0), (3.0, 30.0, 10.0), (30.0, 150.0, 25.0)] {
            let split = Split::new(&Yukawa::new(7.0, 1.0 / debye, cutoff).unwrap(), radius);
            let kernel = SmoothKernel::new(&split, 500.0).unwrap();
            for _ in 0..200 {
                let place = rng.vector_in_ball(cutoff + 10.0);
                let x = std::array::from_fn(|lane| place.x + 0.6 * lane as f64);
                let sum = kernel.sum(&leaves, &x, place.y, place.z);
                assert_eq!(sum, kernel.line(&leaves, &x, place.y, place.z));
                for lane in 0..LINE {
                    let (mut exact, mut size) = (0.0, 0.0);
                    for leaf in 0..leaves.len() {
                        for i in 0..LEAF {
                            let d = [
                                x[lane] - leaves.x[leaf][i],
                                place.y - leaves.y[leaf][i],
                                place.z - leaves.z[leaf][i],
                            ];
                            let smooth = split.smooth(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
                            exact += leaves.charge[leaf][i] * smooth;
                            size += (leaves.charge[leaf][i] * smooth).abs();
                        }
                    }
                    assert!(
                        (sum[lane] - exact).abs() < 4e-7 * size + 1e-8,
                        "{} {exact} {size}",
                        sum[lane]
                    );
                }
            }
        }
    }
}
