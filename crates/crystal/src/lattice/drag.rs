//! Linear friction.
//!
//! v̇ = -P Γ v, with Γ = γ for translations and γ' for rotations and P = 1 - M⁻¹ Jᵀ A⁻¹ J the
//! projection on velocities that keep the rods. It is a map of the velocities, made for half a step
//! before and after a step without friction: the whole is of second order, and any way of making
//! the middle step will do, collisions included ([`Drag::apply`] with the
//! [`dynamics`](super::Engine::dynamics) of an engine).
//!
//! A single γ commutes with P, and v ← exp(-γ t) v is exact. With two, the midpoint rule of Runge
//! is used, v ← v - t P Γ (v - t/2 P Γ v), of second order in t.

use super::dynamics::Dynamics;
use super::state::State;
use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};

/// The midpoint rule with two rates is stable below γ t = 2, and accurate well below.
const LARGEST_EXPLICIT: f64 = 0.5;

/// Friction proportional to the velocities.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// γ of the centres, 1/time.
    pub translation: f64,
    /// γ' of the angles, 1/time.
    pub rotation: f64,
}

impl Drag {
    /// The same rate for translations and rotations.
    ///
    /// # Errors
    /// As [`Drag::new`].
    pub fn uniform(rate: f64) -> Result<Self> {
        Self::new(rate, rate)
    }

    /// Rates for translations and rotations, 1/time.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a rate that is negative or not finite.
    pub fn new(translation: f64, rotation: f64) -> Result<Self> {
        let drag = Self {
            translation,
            rotation,
        };
        drag.check()?;
        Ok(drag)
    }

    /// Checks settings that were read from a file; [`apply`](Drag::apply) does it too.
    ///
    /// # Errors
    /// As [`Drag::new`].
    pub fn check(&self) -> Result<()> {
        for (setting, value) in [
            ("drag of translations", self.translation),
            ("drag of rotations", self.rotation),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(CrystalError::BadSetting {
                    setting,
                    value,
                    requirement: "zero or positive",
                });
            }
        }
        Ok(())
    }

    /// What friction alone makes of the velocities in this time, at the positions at which
    /// `dynamics` is prepared.
    ///
    /// # Errors
    /// As [`Drag::new`], and [`CrystalError::BadSetting`] if two different rates are too high for
    /// so long a time.
    pub fn apply(
        &self,
        dynamics: &mut Dynamics,
        velocities: &mut [f64],
        duration: f64,
    ) -> Result<()> {
        self.check()?;
        if self.translation == self.rotation {
            let kept = (-self.translation * duration).exp();
            velocities.iter_mut().for_each(|velocity| *velocity *= kept);
        } else {
            let fastest = self.translation.max(self.rotation) * duration;
            if fastest > LARGEST_EXPLICIT {
                return Err(CrystalError::BadSetting {
                    setting: "drag times half the time step",
                    value: fastest,
                    requirement: "at most 0.5 where translations and rotations differ; take a shorter time step",
                });
            }
            let mut middle = velocities.to_vec();
            self.decelerate(dynamics, velocities, 0.5 * duration, &mut middle);
            let slowed = middle.clone();
            middle.copy_from_slice(velocities);
            self.decelerate(dynamics, &slowed, duration, &mut middle);
            velocities.copy_from_slice(&middle);
        }
        dynamics.velocities_changed(velocities);
        Ok(())
    }

    /// target = P (target - t Γ v).
    fn decelerate(&self, dynamics: &mut Dynamics, v: &[f64], time: f64, target: &mut [f64]) {
        for (target, v) in target.chunks_exact_mut(3).zip(v.chunks_exact(3)) {
            target[0] -= time * self.translation * v[0];
            target[1] -= time * self.translation * v[1];
            target[2] -= time * self.rotation * v[2];
        }
        dynamics.project_velocities(target);
    }

    /// One step without collisions: friction, [`Dynamics::step`], friction.
    ///
    /// # Errors
    /// As [`Drag::apply`] and [`Dynamics::step`].
    pub fn step(&self, dynamics: &mut Dynamics, state: &mut State, step: f64) -> Result<()> {
        self.apply(dynamics, &mut state.velocities, 0.5 * step)?;
        dynamics.step(state, step)?;
        self.apply(dynamics, &mut state.velocities, 0.5 * step)
    }
}
