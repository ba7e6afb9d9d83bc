//! Linear friction.
//!
//! v̇ = -P Γ v, with Γ = γ for translations and γ' for rotations and P = 1 - M⁻¹ Jᵀ A⁻¹ J the
//! projection on velocities that keep the rods. Friction changes only the velocities; it acts for
//! half a step before and half a step after a step without friction. The whole is of second order,
//! whatever makes the middle step, collisions included ([`Drag::apply`] with the
//! [`dynamics`](super::Engine::dynamics) of an engine).
//!
//! A single γ commutes with P, and v ← exp(-γ t) v is exact. With two rates, the midpoint rule of
//! Runge is used, v ← v - t P Γ (v - t/2 P Γ v), of second order in t.

use super::dynamics::Dynamics;
use super::state::State;
use crate::error::{Result, require, require_not_negative};
use serde::{Deserialize, Serialize};

/// The midpoint rule with two rates is stable below γ t = 2, and accurate well below that.
const LARGEST_EXPLICIT: f64 = 0.5;

/// Friction proportional to the velocities.
///
/// ```
/// use protomer_linkage::lattice::{Drag, Dynamics, Edges, Network, Square, Start, StartVelocities};
/// use std::sync::Arc;
/// let velocities = StartVelocities::Checkerboard { rate: 1.0 };
/// let start = Start { velocities, ..Start::default() };
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, start.angle)?;
/// let mut state = start.build(&network, 0)?.state;
/// let before = state.kinetic_energy(&network);
/// let mut dynamics = Dynamics::new(Arc::new(network), Vec::new(), &state)?;
/// Drag::uniform(0.5)?.apply(&mut dynamics, &mut state.velocities, 2.0)?;
/// let after = state.kinetic_energy(dynamics.network());
/// assert!((after / before - (-2.0f64).exp()).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// γ of the centres, 1/time.
    pub translation: f64,
    /// γ' of the angles, 1/time.
    pub rotation: f64,
}

impl Drag {
    /// Friction with the same rate for translations and rotations.
    ///
    /// ```
    /// use protomer_linkage::lattice::Drag;
    /// assert_eq!(Drag::uniform(0.5)?, Drag::new(0.5, 0.5)?);
    /// assert!(Drag::uniform(-0.5).is_err());
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Drag::new`].
    pub fn uniform(rate: f64) -> Result<Self> {
        Self::new(rate, rate)
    }

    /// Friction with these rates for translations and rotations, 1/time.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for a rate that is negative or
    /// not finite.
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
        require_not_negative("drag of translations", self.translation)?;
        require_not_negative("drag of rotations", self.rotation)
    }

    /// Slows the velocities down for this time, at the positions at which `dynamics` is prepared.
    ///
    /// # Errors
    /// As [`Drag::new`], and [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) if two
    /// different rates are too high for so long a time.
    pub fn apply(
        &self,
        dynamics: &mut Dynamics,
        velocities: &mut [f64],
        duration: f64,
    ) -> Result<()> {
        self.check()?;
        if self.translation == self.rotation {
            // A single rate commutes with the projection: exact for any duration.
            let decay = (-self.translation * duration).exp();
            for velocity in velocities.iter_mut() {
                *velocity *= decay;
            }
        } else {
            self.require_resolved(duration)?;
            // Midpoint rule: the slope at half time, applied over the whole.
            let mut middle = velocities.to_vec();
            self.decelerate(dynamics, velocities, 0.5 * duration, &mut middle);
            let mut end = velocities.to_vec();
            self.decelerate(dynamics, &middle, duration, &mut end);
            velocities.copy_from_slice(&end);
        }
        // Multipliers for the next drift depend on the velocities.
        dynamics.velocities_changed(velocities);
        Ok(())
    }

    fn require_resolved(&self, duration: f64) -> Result<()> {
        let fastest = self.translation.max(self.rotation) * duration;
        require(
            "drag times half the time step",
            fastest,
            fastest <= LARGEST_EXPLICIT,
            "at most 0.5 where translations and rotations differ; take a shorter time step",
        )
    }

    /// target = P (target - t Γ v).
    fn decelerate(&self, dynamics: &mut Dynamics, v: &[f64], time: f64, target: &mut [f64]) {
        let squares = dynamics.network().squares.len();
        let rows = target.chunks_exact_mut(3).zip(v.chunks_exact(3));
        for (body, (target, v)) in rows.enumerate() {
            // All components of a flexible cell are translations.
            let is_square = body < squares;
            let turning = if is_square {
                self.rotation
            } else {
                self.translation
            };
            target[0] -= time * self.translation * v[0];
            target[1] -= time * self.translation * v[1];
            target[2] -= time * turning * v[2];
        }
        dynamics.project_velocities(target);
    }

    /// Makes one step without collisions: friction, [`Dynamics::step`], friction.
    ///
    /// # Errors
    /// As [`Drag::apply`] and [`Dynamics::step`].
    pub fn step(&self, dynamics: &mut Dynamics, state: &mut State, step: f64) -> Result<()> {
        self.apply(dynamics, &mut state.velocities, 0.5 * step)?;
        dynamics.step(state, step)?;
        self.apply(dynamics, &mut state.velocities, 0.5 * step)
    }
}
