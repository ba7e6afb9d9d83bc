//! The first root of a gap along a path.
//!
//! A gap is the greatest of some smooth functions m_i of time with |m_i''| ≤ K, so it is at least
//! m_i(t) + m_i'(t) δ - K δ²/2 for every i. Going from t by the largest δ at which one of these
//! bounds is still positive passes over no root, however short the gap dips, and converges
//! quadratically to the first. Where a function has a kink (another corner takes the lead), its
//! slope is corrected there.

use crate::lattice::contact::TOUCHING;
use crate::lattice::contact::separation::Along;
use protomer_kernel::bisection::halved;

/// A gap this small is a root.
pub const ROOT: f64 = 1e-11;
/// The march goes on by at least this time.
const SMALLEST_ADVANCE: f64 = 1e-14;
/// Largest number of advances of a march.
const MOST_ADVANCES: usize = 10_000;
/// While bodies still touch, samples are so near that they miss nothing deeper than this share of a
/// touch.
const MISSED_DEPTH: f64 = 0.01;
/// Halvings of the time in which a contact that did not come apart sinks in.
const BISECTIONS: u32 = 40;

/// A gap at some time: its functions, and how long until one of them has a kink.
pub struct Probe<const N: usize> {
    /// m_i and m_i'.
    pub functions: [Along; N],
    /// Time to the next kink.
    pub to_kink: f64,
}

/// Outcome of a march.
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
        /// Depth of the overlap.
        depth: f64,
    },
}

impl<const N: usize> Probe<N> {
    /// The gap, max m_i, and the rate of the function that leads.
    fn gap_and_rate(&self) -> (f64, f64) {
        let (mut gap, mut rate) = (f64::NEG_INFINITY, 0.0);
        for function in &self.functions {
            if function.distance > gap {
                (gap, rate) = (function.distance, function.rate);
            }
        }
        (gap, rate)
    }

    /// The longest time in which some m_i certainly stays positive. Functions that count as open
    /// although they touch start at zero while the bodies are `leaving`.
    fn safe_advance(&self, curvature: f64, leaving: bool) -> f64 {
        let mut longest = 0.0_f64;
        for function in &self.functions {
            // Bodies that touched count from zero while they part.
            let touches = leaving && function.distance >= -TOUCHING;
            let height = if touches {
                function.distance.max(0.0)
            } else {
                function.distance
            };
            if height < 0.0 {
                continue;
            }
            let mut safe = time_above(height, function.rate, curvature);
            // Beyond the kink another corner leads, whose slope may be lower.
            if safe > self.to_kink {
                let after_kink = time_above(height, function.worst_rate, curvature);
                safe = (self.to_kink + SMALLEST_ADVANCE).max(after_kink);
            }
            // One function that stays positive keeps the gap open.
            longest = longest.max(safe);
        }
        longest
    }
}

/// Marches from 0 to `end` over a gap whose functions have this curvature at most. A gap that is
/// closed at the start is no root if it opens.
pub fn first_root<const N: usize>(
    probe: impl Fn(f64) -> Probe<N>,
    curvature: f64,
    end: f64,
) -> End {
    let start = probe(0.0);
    let (gap, _) = start.gap_and_rate();
    if gap < -TOUCHING || gap.is_nan() {
        return End::Overlapping { depth: -gap };
    }
    // Below what rounding can make of a touch.
    let lowest = gap.min(0.0) - 2.0 * ROOT;
    // K t²/8 is how deep a parabola dips between samples: a share of a touch at most.
    let sample = (8.0 * MISSED_DEPTH * TOUCHING / curvature).sqrt();
    let (mut time, mut before, mut current) = (0.0, 0.0, start);
    let mut leaving = true;
    for _ in 0..MOST_ADVANCES {
        let (gap, rate) = current.gap_and_rate();
        leaving = leaving && gap <= TOUCHING;
        if leaving && gap < lowest {
            // What touched has not come apart, or another corner has come down next to it.
            let time = last_above(&probe, lowest, before, time);
            return End::Root { time, rate };
        }
        if gap <= ROOT && !leaving {
            return End::Root { time, rate };
        }
        let mut advance = current.safe_advance(curvature, leaving);
        if leaving {
            // While they touch the bound is zero; samples take its place.
            advance = advance.max(sample);
        } else if advance <= SMALLEST_ADVANCE && gap <= TOUCHING {
            return End::Root { time, rate };
        }
        before = time;
        time += advance.max(SMALLEST_ADVANCE);
        if time >= end {
            return End::Free;
        }
        current = probe(time);
    }
    End::Root { time, rate: 0.0 }
}

/// The last time between `open` and `closed` at which the gap is not below `lowest`.
fn last_above<const N: usize>(
    probe: &impl Fn(f64) -> Probe<N>,
    lowest: f64,
    open: f64,
    closed: f64,
) -> f64 {
    let is_open = |time: f64| probe(time).gap_and_rate().0 >= lowest;
    halved([open, closed], BISECTIONS, is_open)[0]
}

/// The largest δ with m + m' δ - K δ²/2 ≥ 0.
fn time_above(height: f64, rate: f64, curvature: f64) -> f64 {
    // The positive root of m + m' δ - K δ²/2.
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
