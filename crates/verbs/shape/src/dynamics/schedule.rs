//! Course of a run: compression, equilibration with a bath, and the run proper in its ensemble.

use super::settings::DynamicsSettings;
use super::start::{Begun, begin};
use anyhow::{Context, Result};
use protomer_md::bath::Ensemble;
use protomer_md::engine::{Engine, Motion, Settings};

/// Relaxation time of the bath of the preparation.
const PREPARATION_TIME: f64 = 0.05;

/// Settings that have been checked, and where the bodies begin.
pub(super) struct Schedule {
    pub(super) settings: DynamicsSettings,
    pub(super) begun: Begun,
}

impl Schedule {
    pub(super) fn new(settings: DynamicsSettings) -> Result<Self> {
        let begun = begin(&settings)?;
        Ok(Self { settings, begun })
    }

    /// An engine at the start, or at the saved state.
    pub(super) fn engine(&self, saved: Option<Motion>) -> Result<Engine> {
        let steps = saved.as_ref().map_or(0, |motion| motion.steps);
        let settings = self.motion(steps);
        let (bodies, added) = (self.begun.bodies.clone(), self.begun.added.clone());
        Ok(match saved {
            Some(motion) => Engine::continued_with_added(bodies, motion, settings, added)?,
            None => Engine::with_added(bodies, self.begun.state.clone(), settings, added)?,
        })
    }

    /// Settings of the motion after so many steps.
    pub(super) fn motion(&self, steps: u64) -> Settings {
        let is_prepared = steps >= self.settings.preparation_steps();
        let preparation = Ensemble::Nvt {
            temperature: self.settings.temperature,
            relaxation_time: PREPARATION_TIME,
        };
        let (time_step, ensemble) = match is_prepared {
            true => (self.settings.time_step, self.settings.ensemble()),
            false => (self.settings.preparation_time_step, preparation),
        };
        Settings {
            interaction: self.settings.interaction(),
            time_step,
            ensemble,
            seed: self.settings.seed,
            is_threaded: rayon::current_num_threads() > 1,
        }
    }

    /// Steps and time since the preparation.
    pub(super) fn place(&self, engine: &Engine) -> (i64, f64) {
        let step = engine.motion().steps as i64 - self.settings.preparation_steps() as i64;
        let time_step = match step >= 0 {
            true => self.settings.time_step,
            false => self.settings.preparation_time_step,
        };
        (step, step as f64 * time_step)
    }

    /// Makes a step: one of the compression, of the equilibration or of the run proper.
    pub(super) fn step(&self, engine: &mut Engine) -> Result<()> {
        let steps = engine.motion().steps;
        let scale = match steps < self.settings.compress_steps {
            true => self.begun.scale_per_step,
            false => 1.0,
        };
        engine.step(scale).with_context(|| {
            match (steps + 1).checked_sub(self.settings.preparation_steps()) {
                None | Some(0) => format!("preparation: step {}", steps + 1),
                Some(step) => format!("step {step}"),
            }
        })?;
        if steps + 1 == self.settings.preparation_steps() {
            engine.draw_free_spins(self.settings.temperature);
            engine.change_settings(self.motion(steps + 1))?;
        }
        Ok(())
    }
}
