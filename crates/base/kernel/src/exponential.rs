//! exp(-y) without branches and calls, for loops that are compiled into vectors.
//!
//! With n the integer nearest to -y/ln 2 and f = -y - n ln 2, |f| ≤ ln(2)/2, exp(-y) = 2ⁿ exp(f), and
//! a Taylor polynomial gives exp(f). Every processor rounds these operations alike, so that loops over
//! them may be compiled for any vectors.

use crate::fused::add;

/// Computes exp(-y) for y ≥ 0 to within 2 units in the last place; y above 700 counts as 700. The
/// polynomial has degree 12 and is in error by less than 2e-16.
///
/// ```
/// use protomer_kernel::exponential::exp_of_minus;
/// assert!((exp_of_minus(1.5) - (-1.5f64).exp()).abs() < 1e-16);
/// ```
#[inline(always)]
pub fn exp_of_minus(y: f64) -> f64 {
    /// Constant that rounds a number to an integer, held in the low bits, when added to it.
    const ROUNDER: f64 = 6_755_399_441_055_744.0; // 1.5 · 2⁵²
    /// The first part of ln 2: it has so few bits that n times it is exact.
    const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
    /// The rest of ln 2.
    const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    /// 1/12! to 1/0!.
    const INVERSE_FACTORIALS: [f64; 13] = [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    // A comparison instead of `min`: the compiler makes one vector instruction of it.
    let x = -(if y < 700.0 { y } else { 700.0 });
    // The sum's unit in the last place is 1, so rounding
    // to nearest leaves the integer n in the low bits.
    let shifted = x * std::f64::consts::LOG2_E + ROUNDER;
    let n = shifted - ROUNDER;
    // Two parts of ln 2 (Cody and Waite): n LN_2_HIGH is exact, so f keeps all its digits.
    let f = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    let mut polynomial = INVERSE_FACTORIALS[0];
    for coefficient in &INVERSE_FACTORIALS[1..] {
        // Not fused, so that every processor finds the same bits.
        polynomial = polynomial * f + coefficient;
    }
    // The low bits of `shifted` hold n; moved to the exponent and biased by 1023 they are 2ⁿ.
    polynomial * f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52))
}

/// Computes exp(-y) for y ≥ -80 to 3e-7 in single precision; y above 80 counts as 80. `FUSED`:
/// where multiply-add is one instruction.
///
/// ```
/// use protomer_kernel::exponential::exp_of_minus_f32;
/// assert!((exp_of_minus_f32::<false>(1.5) - (-1.5f32).exp()).abs() < 1e-7);
/// ```
#[inline(always)]
pub fn exp_of_minus_f32<const FUSED: bool>(y: f32) -> f32 {
    const ROUNDER: f32 = 12_582_912.0; // 1.5 · 2²³
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let x = -(if y < 80.0 { y } else { 80.0 });
    let shifted = add::<FUSED>(x, std::f32::consts::LOG2_E, ROUNDER);
    let n = shifted - ROUNDER;
    let f = add::<FUSED>(-n, LN_2_LOW, add::<FUSED>(-n, LN_2_HIGH, x));
    let mut polynomial = 1.0 / 720.0;
    for coefficient in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        polynomial = add::<FUSED>(polynomial, f, coefficient);
    }
    polynomial * f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_accurate_everywhere() {
        for step in 0..700_000 {
            let y = f64::from(step) * 1e-3;
            assert!((exp_of_minus(y) / (-y).exp() - 1.0).abs() < 5e-16, "{y}");
        }
        assert!(exp_of_minus(1e9) < 1e-300);
    }

    #[test]
    fn single_precision_is_good_for_both_signs() {
        for step in -8000..=8000 {
            let y = step as f32 * 0.01;
            let exact = (-f64::from(y)).exp();
            for found in [exp_of_minus_f32::<false>(y), exp_of_minus_f32::<true>(y)] {
                assert!((f64::from(found) / exact - 1.0).abs() < 3e-7, "{y}");
            }
        }
        let least = exp_of_minus_f32::<false>(80.0);
        assert_eq!(exp_of_minus_f32::<false>(1e9), least);
    }
}
