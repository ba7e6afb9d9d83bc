//! Largest steps of trial moves, and how many moves are accepted.

use serde::{Deserialize, Serialize};

/// Largest steps of the trial moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// Largest step of a coordinate, in the unit of the bodies.
    pub translation: f64,
    /// Largest step of a component of the rotation vector, as the tangent of half the angle.
    pub rotation: f64,
}

/// Trials and how many were accepted.
///
/// ```
/// use protomer_hpmc::system::Counts;
/// assert_eq!(Counts { trials: 40, accepted: 10 }.acceptance(), 0.25);
/// assert_eq!(Counts::default().acceptance(), 0.0);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Trials.
    pub trials: u64,
    /// Accepted trials.
    pub accepted: u64,
}

impl Counts {
    /// The accepted part; zero without trials.
    pub fn acceptance(&self) -> f64 {
        self.accepted as f64 / self.trials.max(1) as f64
    }

    pub(crate) fn is_none(&self) -> bool {
        self.trials == 0
    }

    pub(crate) fn note(&mut self, is_accepted: bool) {
        self.trials += 1;
        self.accepted += u64::from(is_accepted);
    }
}

/// Counts of both kinds of moves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoveCounts {
    /// Translations.
    pub translation: Counts,
    /// Rotations.
    pub rotation: Counts,
}

impl MoveCounts {
    pub(crate) fn add(&mut self, more: &Self) {
        for (sum, part) in [
            (&mut self.translation, &more.translation),
            (&mut self.rotation, &more.rotation),
        ] {
            sum.trials += part.trials;
            sum.accepted += part.accepted;
        }
    }

    /// Counts of all moves together.
    ///
    /// ```
    /// use protomer_hpmc::system::{Counts, MoveCounts};
    /// let moves = MoveCounts {
    ///     translation: Counts { trials: 10, accepted: 5 },
    ///     rotation: Counts { trials: 30, accepted: 9 },
    /// };
    /// assert_eq!(moves.total(), Counts { trials: 40, accepted: 14 });
    /// ```
    pub fn total(&self) -> Counts {
        Counts {
            trials: self.translation.trials + self.rotation.trials,
            accepted: self.translation.accepted + self.rotation.accepted,
        }
    }
}

impl Steps {
    /// Smallest number of trials for tuning; fewer say little.
    pub(crate) const ENOUGH: u64 = 300;

    /// Changes the steps towards an acceptance, by what they gave.
    pub(crate) fn tune(&mut self, counts: &MoveCounts, wanted: f64, longest: &Self) {
        let change = |step: &mut f64, counts: &Counts, longest: f64| {
            // Few trials would turn noise into steps.
            if counts.trials >= Self::ENOUGH {
                let factor = (counts.acceptance() / wanted).clamp(0.5, 1.5);
                *step = (*step * factor).clamp(1e-9 * longest, longest);
            }
        };
        change(
            &mut self.translation,
            &counts.translation,
            longest.translation,
        );
        change(&mut self.rotation, &counts.rotation, longest.rotation);
    }
}
