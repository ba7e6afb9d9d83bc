//! The random streams of this crate, and normal numbers.

use protomer_kernel::random::CounterRng;
use std::f64::consts::TAU;

/// Purposes of streams: each draws numbers of its own.
pub(crate) const START_ANGLES: u8 = 0x50;
pub(crate) const START_VELOCITIES: u8 = 0x51;
pub(crate) const NOISE_BEFORE_STEP: u8 = 0x58;
pub(crate) const NOISE_AFTER_STEP: u8 = 0x59;
pub(crate) const THERMAL_VELOCITIES: u8 = 0x5a;
pub(crate) const FIRST_NEIGHBOUR: u8 = 0x60;

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
