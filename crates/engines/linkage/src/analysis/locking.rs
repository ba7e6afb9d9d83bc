//! The time from which phases are locked.
//!
//! Phases are locked while |θ_a - θ_b| < c for all pairs (eq. 37 of the preprint). The locking time is
//! that of the first sample from which this holds to the end.

use super::synchronisation::largest_phase_difference;

/// Finds the locking time sample by sample, in constant memory.
///
/// ```
/// use protomer_linkage::analysis::locking::Locking;
/// let mut locking = Locking::within(0.5);
/// for (time, angle) in [(0.0, 0.0), (1.0, 0.8), (2.0, 0.4), (3.0, 0.45)] {
///     locking.push(time, &[0.0, angle]);
/// }
/// assert_eq!(locking.since(), Some(2.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Locking {
    bound: f64,
    since: Option<f64>,
}

impl Locking {
    /// A search for the time from which all differences stay below this bound, rad.
    pub fn within(bound: f64) -> Self {
        Self { bound, since: None }
    }

    /// Adds the (-1)^(i+j) θ of the next time.
    pub fn push(&mut self, time: f64, angles: &[f64]) {
        if largest_phase_difference(angles) < self.bound {
            self.since.get_or_insert(time);
        } else {
            self.since = None;
        }
    }

    /// The locking time; `None` if phases are not locked at the end.
    pub fn since(&self) -> Option<f64> {
        self.since
    }
}
