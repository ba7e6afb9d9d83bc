//! Near pairs: Σ Z_i q_j (f - g)(r_ij) for r_ij < R, one by one in single precision.

use super::leaves::LEAF;
use super::split::{NEAR_DEGREE, Split};
use super::window::{Bounded, Sources, Target};

/// What the loop needs of the kernel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NearKernel {
    radius: f64,
    bjerrum: f32,
    kappa: f32,
    near: [f32; NEAR_DEGREE + 1],
}

impl NearKernel {
    pub fn new(split: &Split) -> Self {
        Self {
            radius: split.near_radius,
            bjerrum: split.bjerrum as f32,
            kappa: split.kappa as f32,
            near: split.near.map(|c| c as f32),
        }
    }

    /// The sum over the charges of these leaves.
    #[inline(always)]
    pub fn sum(&self, sources: &Sources, target: &Target, leaves: &[u32]) -> Bounded {
        let c = target.centre;
        let reach = self.radius + target.radius + 1e-3;
        let square = (self.radius * self.radius) as f32;
        let minus_two = target.offset.map(|axis| axis.map(|d| -2.0 * d));
        // |x - y|² = |y - c|² + η, as at the cut-off.
        let (mut sums, mut bounds) = ([0.0f64; LEAF], [0.0f64; LEAF]);
        for leaf in leaves {
            let leaf = *leaf as usize;
            let exact = &sources.exact[leaf];
            let (mut sum, mut bound) = ([0.0f32; LEAF], [0.0f32; LEAF]);
            for lane in 0..LEAF {
                let d: [f64; 3] = std::array::from_fn(|axis| exact[axis][lane] - c[axis]);
                let to_centre = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if to_centre > reach * reach {
                    continue;
                }
                let (dx, dy, dz) = (d[0] as f32, d[1] as f32, d[2] as f32);
                let (base, charge) = (to_centre as f32, sources.charge[leaf][lane]);
                for i in 0..LEAF {
                    let t = minus_two[0][i]
                        .mul_add(dx, minus_two[1][i].mul_add(dy, minus_two[2][i].mul_add(dz, target.square[i] + base)));
                    let inverse = inverse_root(t);
                    let f = self.bjerrum * exp_of_minus(self.kappa * (t * inverse)) * inverse;
                    let mut g = self.near[NEAR_DEGREE];
                    for k in (0..NEAR_DEGREE).rev() {
                        g = g.mul_add(t - square, self.near[k]);
                    }
                    let charge = if t < square { charge } else { 0.0 };
                    sum[i] = charge.mul_add(f - g, sum[i]);
                    // The relative error of f is that of its operations and that of t times its logarithmic slope.
                    let size = (f + g.abs()) * (40.0 * inverse).mul_add(inverse, 2.0);
                    bound[i] = charge.abs().mul_add(size, bound[i]);
                }
            }
            for i in 0..LEAF {
                sums[i] += f64::from(sum[i]);
                bounds[i] += f64::from(bound[i]);
            }
        }
        let value = sums.iter().zip(&target.charge).map(|(sum, charge)| sum * charge).sum();
        let error = bounds.iter().zip(&target.charge).map(|(bound, charge)| bound * charge.abs()).sum::<f64>();
        Bounded { value, error: RELATIVE_ERROR * error }
    }
}

/// Bound of the roundings of one term relative to its parts; tests hold it against double precision.
const RELATIVE_ERROR: f64 = 1e-6;

/// 1/√t for t > 0 by Newton's method from the exponent's half; only operations that every processor rounds alike.
#[inline(always)]
pub(super) fn inverse_root(t: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_59df_u32.wrapping_sub(t.to_bits() >> 1));
    let half = -0.5 * t;
    for _ in 0..3 {
        y *= (half * y).mul_add(y, 1.5);
    }
    y
}

/// exp(-y) for 0 <= y < 80.
#[inline(always)]
pub(super) fn exp_of_minus(y: f32) -> f32 {
    const ROUNDER: f32 = 12_582_912.0; // 1.5 · 2²³
    let x = -(if y < 80.0 { y } else { 80.0 });
    let shifted = x.mul_add(std::f32::consts::LOG2_E, ROUNDER);
    let n = shifted - ROUNDER;
    let f = n.mul_add(-1.428_606_8e-6, n.mul_add(-0.693_145_75, x));
    let mut polynomial = 1.0 / 5040.0;
    for coefficient in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0f32] {
        polynomial = f.mul_add(polynomial, coefficient);
    }
    polynomial * f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_and_exponentials_are_accurate() {
        for step in 1..100_000 {
            let x = step as f32 * 5e-4;
            let exact = f64::from(x);
            assert!((f64::from(inverse_root(x)) * exact.sqrt() - 1.0).abs() < 3e-7, "{x}");
            assert!((f64::from(exp_of_minus(x)) / (-exact).exp() - 1.0).abs() < 4e-7, "{x}");
        }
    }
}
