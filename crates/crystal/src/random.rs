//! Normal random numbers.

use protomer_kernel::random::CounterRng;
use std::f64::consts::TAU;

/// Two independent standard normal numbers (Box and Muller) from exactly two uniform ones.
pub(crate) fn normal_pair(rng: &mut CounterRng) -> [f64; 2] {
    // 1 - u lies in (0, 1].
    let radius = (-2.0 * (1.0 - rng.uniform()).ln()).sqrt();
    let (sine, cosine) = (TAU * rng.uniform()).sin_cos();
    [radius * cosine, radius * sine]
}

/// One standard normal number from two uniform ones.
pub(crate) fn normal(rng: &mut CounterRng) -> f64 {
    normal_pair(rng)[0]
}
