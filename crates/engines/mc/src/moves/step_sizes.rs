//! The step sizes of trial moves, tuned during equilibration and then frozen.

use super::Kind;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Trials of one kind between two adjustments.
const WINDOW_TRIALS: u64 = 100;
/// The largest factor by which an adjustment may change a step.
const LARGEST_FACTOR: f64 = 1.5;
/// Lower limit for a step (Å or rad).
const SMALLEST_STEP: f64 = 1e-6;

/// Trials and acceptances.
///
/// ```
/// use protomer_mc::moves::Acceptance;
/// let mut translations = Acceptance::default();
/// translations.count(true);
/// translations.count(false);
/// assert_eq!(translations.rate(), Some(0.5));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Acceptance {
    /// Attempted moves.
    pub trials: u64,
    /// Accepted moves.
    pub accepted: u64,
}

impl Acceptance {
    /// Counts one trial.
    pub fn count(&mut self, accepted: bool) {
        self.trials += 1;
        self.accepted += u64::from(accepted);
    }

    /// Fraction accepted; `None` before the first trial.
    pub fn rate(&self) -> Option<f64> {
        (self.trials > 0).then(|| self.accepted as f64 / self.trials as f64)
    }
}

/// The step sizes of one body type.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepSizes {
    /// Largest displacement, Å.
    pub translation_angstrom: f64,
    /// Largest angle, rad.
    pub rotation_rad: f64,
}

/// Step sizes and the acceptance since their last adjustment.
///
/// ```
/// use protomer_mc::moves::step_sizes::Tuner;
/// use protomer_mc::moves::{Kind, StepSizes};
/// let steps = StepSizes { translation_angstrom: 1.0, rotation_rad: 0.1 };
/// let mut tuner = Tuner::new(steps, 10.0);
/// for trial in 0..100 {
///     tuner.learn(Kind::Translation, trial < 50, 0.4);
/// }
/// assert_eq!(tuner.steps.translation_angstrom, 1.25, "half of the trials instead of 40 %");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tuner {
    /// The step sizes in use.
    pub steps: StepSizes,
    largest_translation_angstrom: f64,
    translation: Acceptance,
    rotation: Acceptance,
}

impl Tuner {
    /// Starts with these steps; a translation is never tuned beyond `largest_translation_angstrom`.
    pub fn new(steps: StepSizes, largest_translation_angstrom: f64) -> Self {
        let (translation, rotation) = (Acceptance::default(), Acceptance::default());
        Self {
            steps,
            largest_translation_angstrom,
            translation,
            rotation,
        }
    }

    /// Counts a trial. After a fixed number of trials of one kind, adjusts that step towards the
    /// target acceptance.
    pub fn learn(&mut self, kind: Kind, accepted: bool, target_acceptance: f64) {
        let (step, largest, window) = match kind {
            Kind::Translation => (
                &mut self.steps.translation_angstrom,
                self.largest_translation_angstrom,
                &mut self.translation,
            ),
            Kind::Rotation => (&mut self.steps.rotation_rad, PI, &mut self.rotation),
        };
        window.count(accepted);
        if window.trials == WINDOW_TRIALS {
            let factor = (window.accepted as f64 / WINDOW_TRIALS as f64 / target_acceptance)
                .clamp(LARGEST_FACTOR.recip(), LARGEST_FACTOR);
            *step = (*step * factor).clamp(SMALLEST_STEP, largest);
            *window = Acceptance::default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn tuning_finds_the_target() {
        let mut tuner = Tuner::new(
            StepSizes {
                translation_angstrom: 10.0,
                rotation_rad: 1e-3,
            },
            20.0,
        );
        let mut rng = CounterRng::new(1, 0, 0);
        for _ in 0..20_000 {
            // A model system whose acceptance is exp(-step).
            let accepted = rng.uniform() < (-tuner.steps.translation_angstrom).exp();
            tuner.learn(Kind::Translation, accepted, 0.4);
            let accepted = rng.uniform() < (-tuner.steps.rotation_rad).exp();
            tuner.learn(Kind::Rotation, accepted, 0.4);
        }
        for step in [tuner.steps.translation_angstrom, tuner.steps.rotation_rad] {
            assert!(((-step).exp() - 0.4).abs() < 0.15, "{step}");
        }
    }
}
