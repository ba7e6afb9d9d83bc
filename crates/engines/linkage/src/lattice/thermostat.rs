//! Langevin dynamics at a temperature, on the rods.
//!
//! dv = a dt - γ v dt + √(2 γ kT) M^(-1/2) dW, with a and the noise both projected so that the rods
//! keep their lengths. One step is half a step of friction and noise, which is exact for velocities
//! that obey the rods,
//!
//! v ← c v + √((1 - c²) kT) P M^(-1/2) ξ, c = exp(-γ h/2), ξ standard normal, P = 1 - M⁻¹ Jᵀ A⁻¹ J,
//!
//! one step of the dynamics without them, and again half a step (the splitting of Lelièvre, Rousset
//! and Stoltz, Math. Comput. 81, 2071 (2012), with the exact Ornstein-Uhlenbeck map that a single γ
//! allows). P M^(-1/2) ξ has the covariance P M⁻¹, that of the velocities of the constrained
//! canonical ensemble, so the half steps leave that ensemble unchanged: for a harmonic potential the
//! time step causes no error in the mean kinetic energy.
//!
//! The samples follow exp(-H/kT) on the phase space of *rigid* rods. Positions are then distributed
//! as
//!
//! exp(-V/kT) √det(J M⁻¹ Jᵀ) δ(σ) ds,
//!
//! where the determinant comes from the momenta, which have no component along the rods. Rods that
//! are the limit of ever stiffer springs lack the factor. Their averages follow by weighting states
//! with exp(-½ ln det A)
//! ([`RodSystem::log_determinant`](super::rods::RodSystem::log_determinant), at the prepared
//! state), the correction of Fixman (Proc. Natl. Acad. Sci. 71, 3050 (1974)).
//!
//! With elastic collisions the middle step is that of an [`Engine`](super::Engine);
//! [`Langevin::before`] and [`Langevin::after`] then take its [`dynamics`](super::Engine::dynamics).
//!
//! A flexible [`cell`](super::cell) has friction and noise like a square, with its own mass.
//!
//! The noise is counter-based: it is a function of seed, replica, step and square. A run resumed
//! from its state and the number of its step continues bit for bit.

use super::dynamics::Dynamics;
use super::state::State;
use crate::error::{Result, require_not_negative};
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};

/// Friction and noise that keep a temperature.
///
/// ```
/// use protomer_linkage::lattice::{Dynamics, Edges, Langevin, Network, Square, Start};
/// use std::sync::Arc;
/// let start = Start::default();
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, start.angle)?;
/// let mut state = start.build(&network, 0)?.state;
/// let mut dynamics = Dynamics::new(Arc::new(network), Vec::new(), &state)?;
/// let langevin = Langevin::new(0.5, 1.0, 7, 0)?;
/// for step in 0..10 {
///     langevin.step(&mut dynamics, &mut state, 0.01, step)?;
/// }
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Langevin {
    /// kT in units of mass · half-diagonal² / time².
    pub kt: f64,
    /// γ, 1/time.
    pub friction: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Number of the run among several with this seed.
    #[serde(default)]
    pub replica: u32,
}

impl Langevin {
    /// A heat bath with the temperature kT and the friction γ.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) if either is negative or not
    /// finite.
    pub fn new(kt: f64, friction: f64, seed: u64, replica: u32) -> Result<Self> {
        let langevin = Self {
            kt,
            friction,
            seed,
            replica,
        };
        langevin.check()?;
        Ok(langevin)
    }

    /// Checks settings that were read from a file; [`step`](Langevin::step) does it too.
    ///
    /// # Errors
    /// As [`Langevin::new`].
    pub fn check(&self) -> Result<()> {
        require_not_negative("kt", self.kt)?;
        require_not_negative("friction", self.friction)
    }

    /// Draws velocities of the canonical ensemble at the positions at which `dynamics` is prepared.
    pub fn draw_velocities(&self, dynamics: &mut Dynamics, state: &mut State) {
        self.mix(
            dynamics,
            &mut state.velocities,
            0.0,
            0,
            Purpose::MaxwellVelocities,
        );
    }

    /// Applies friction and noise for half a step of this length, before the other parts of the
    /// step with this number. `dynamics` must be prepared at the state.
    pub fn before(&self, dynamics: &mut Dynamics, state: &mut State, step: f64, number: u64) {
        let decay = self.kept_in_half(step);
        self.mix(
            dynamics,
            &mut state.velocities,
            decay,
            number,
            Purpose::ThermostatBefore,
        );
    }

    /// Applies friction and noise for half a step of this length, after the other parts of the step
    /// with this number. `dynamics` must be prepared at the state.
    pub fn after(&self, dynamics: &mut Dynamics, state: &mut State, step: f64, number: u64) {
        let decay = self.kept_in_half(step);
        self.mix(
            dynamics,
            &mut state.velocities,
            decay,
            number,
            Purpose::ThermostatAfter,
        );
    }

    /// c = exp(-γ h/2).
    fn kept_in_half(&self, step: f64) -> f64 {
        (-0.5 * self.friction * step).exp()
    }

    /// Makes one step without collisions, the `number`th of the run.
    ///
    /// # Errors
    /// As [`Langevin::new`] and [`Dynamics::step`]; after an error of the latter the velocities
    /// have had their first half step of noise, so continue from a copy. The noise is unbounded:
    /// choose the time step for several times the thermal velocity, 0.1 r0 √(m/kT) / 3 or so.
    pub fn step(
        &self,
        dynamics: &mut Dynamics,
        state: &mut State,
        step: f64,
        number: u64,
    ) -> Result<()> {
        self.check()?;
        self.before(dynamics, state, step, number);
        dynamics.step(state, step)?;
        self.after(dynamics, state, step, number);
        Ok(())
    }

    /// v ← P (c v + √((1 - c²) kT) M^(-1/2) ξ).
    fn mix(
        &self,
        dynamics: &mut Dynamics,
        velocities: &mut [f64],
        decay: f64,
        number: u64,
        purpose: Purpose,
    ) {
        let mut rng = CounterRng::for_purpose(self.seed, self.replica, number, purpose);
        // c² v² + (1 - c²) kT/m: the variance kT/m is kept.
        let amplitude = ((1.0 - decay * decay) * self.kt).sqrt();
        for (square, velocity) in dynamics
            .network()
            .squares
            .iter()
            .zip(velocities.chunks_exact_mut(3))
        {
            // Always four uniform numbers per square, so that its noise has a fixed place in the
            // stream.
            let ([x, y], [angle, _]) = (rng.normal_pair(), rng.normal_pair());
            let per_mass = amplitude / square.mass.sqrt();
            velocity[0] = decay * velocity[0] + per_mass * x;
            velocity[1] = decay * velocity[1] + per_mass * y;
            velocity[2] = decay * velocity[2] + amplitude / square.inertia.sqrt() * angle;
        }
        let network = dynamics.network();
        if let (Some(mass), Some(place)) = (network.cell_mass, network.cell_place()) {
            let ([xx, yy], [xy, _]) = (rng.normal_pair(), rng.normal_pair());
            let per_mass = amplitude / mass.sqrt();
            for (velocity, noise) in velocities[place..].iter_mut().zip([xx, yy, xy]) {
                *velocity = decay * *velocity + per_mass * noise;
            }
        }
        // P: what would change the lengths of rods is removed, from noise as from friction.
        dynamics.velocities_changed(velocities);
    }
}
