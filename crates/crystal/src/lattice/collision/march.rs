//! The first root of a gap along a path.
//!
//! A gap is the greatest of some smooth functions m_i of time with |m_i''| ≤ K, so it is at least
//! m_i(t) + m_i'(t) δ - K δ²/2 for every i. Going from t by the largest δ at which one of these
//! bounds is still positive passes over no root, however short the gap dips, and converges
//! quadratically to the first. Where a function has a kink (another corner takes the lead), its
//! slope is corrected there.

use crate::lattice::contact::TOUCHING;
use crate::lattice::contact::separation::Along;

/// A gap this small is a root.
pub const ROOT: f64 = 1e-11;
const SMALLEST_ADVANCE: f64 = 1e-14;
const MOST_ADVANCES: usize = 10_000;

/// A gap at some time: its functions, and how long until one of them has a kink.
pub struct Probe<const N: usize> {
    /// m_i and m_i'.
    pub along: [Along; N],
    /// Time to the next kink.
    pub to_kink: f64,
}

/// Where a march ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// No root.
    Free,
    /// The gap is closed at this time, at this rate.
    Root {
        /// Time.
        time: f64,
        /// Rate of the gap there.
        rate: f64,
    },
    /// The gap was negative at the start.
    Overlapping {
        /// How far.
        depth: f64,
    },
}

/// Marches from 0 to `end`. A gap closed at the start is no root if it opens.
pub fn first_root<const N: usize>(
    probe: impl Fn(f64) -> Probe<N>,
    curvature: f64,
    end: f64,
) -> End {
    let (mut time, mut before, mut lowest) = (0.0, 0.0, 0.0_f64);
    let mut leaving = false;
    // While bodies still touch, samples this near miss nothing deeper than a hundredth of a touch.
    let sample = (8.0 * 0.01 * TOUCHING / curvature).sqrt();
    for _ in 0..MOST_ADVANCES {
        let Probe { along, to_kink } = probe(time);
        let (mut most, mut rate) = (f64::NEG_INFINITY, 0.0);
        for function in &along {
            if function.distance > most {
                (most, rate) = (function.distance, function.rate);
            }
        }
        if time == 0.0 {
            if most < -TOUCHING || most.is_nan() {
                return End::Overlapping { depth: -most };
            }
            leaving = most <= TOUCHING;
            lowest = most.min(0.0) - 2.0 * ROOT;
        }
        leaving = leaving && most <= TOUCHING;
        if leaving && most < lowest {
            // What touched has not come apart, or another corner has come down beside it.
            let depth = |time: f64| {
                probe(time)
                    .along
                    .iter()
                    .fold(f64::NEG_INFINITY, |most, m| most.max(m.distance))
            };
            let (mut open, mut closed) = (before, time);
            for _ in 0..40 {
                let middle = 0.5 * (open + closed);
                if depth(middle) < lowest {
                    closed = middle
                } else {
                    open = middle
                }
            }
            return End::Root { time: open, rate };
        }
        if most <= ROOT && !leaving {
            return End::Root { time, rate };
        }
        let mut advance = 0.0_f64;
        for function in &along {
            let height = if leaving && function.distance >= -TOUCHING {
                function.distance.max(0.0)
            } else {
                function.distance
            };
            if height < 0.0 {
                continue;
            }
            let mut safe = safe_advance(height, function.rate, curvature);
            if safe > to_kink {
                safe = (to_kink + SMALLEST_ADVANCE).max(safe_advance(
                    height,
                    function.worst_rate,
                    curvature,
                ));
            }
            advance = advance.max(safe);
        }
        if leaving {
            advance = advance.max(sample);
        } else if advance <= SMALLEST_ADVANCE && most <= TOUCHING {
            return End::Root { time, rate };
        }
        before = time;
        time += advance.max(SMALLEST_ADVANCE);
        if time >= end {
            return End::Free;
        }
    }
    End::Root { time, rate: 0.0 }
}

/// The largest δ with m + m' δ - K δ²/2 ≥ 0.
fn safe_advance(height: f64, rate: f64, curvature: f64) -> f64 {
    let root = (rate * rate + 2.0 * curvature * height).sqrt();
    if rate > 0.0 {
        if curvature > 0.0 {
            (rate + root) / curvature
        } else {
            f64::INFINITY
        }
    } else if height == 0.0 {
        0.0
    } else {
        // The same, without taking the difference of near numbers.
        2.0 * height / (root - rate)
    }
}
