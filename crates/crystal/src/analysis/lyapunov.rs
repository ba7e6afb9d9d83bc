//! How fast neighbouring trajectories part.
//!
//! The maximal Lyapunov exponent by the method of Benettin, Galgani and Strelcyn (Phys. Rev. A 14,
//! 2338 (1976)): a neighbour of a state at the small distance d0 is carried along for a while τ,
//! the logarithm of its distance over d0 is noted, and it is brought back to d0 along the line
//! between the two,
//!
//! λ = 1/(K τ) Σ_k ln(d_k / d0),
//!
//! after which it is projected on what the constraints allow: positions by Newton's method on the
//! rods, velocities on those that keep them. The distance after projection, not before, is what the
//! next growth is measured from. Distances are measured with the masses, in positions and in
//! velocities times a time scale of 1,
//!
//! d² = Σ m (δx² + δy² + δẋ² + δẏ²) + I (δθ² + δω²).
//!
//! Where collisions leave no room for the neighbour at d0, it is carried on from where it is.
//!
//! Directions without growth (translations, the time along the orbit) let d grow linearly, so a
//! regular motion gives λ of about ln(T)/T, not zero, after a time T.

use crate::lattice::start::{Projector, normal_pair};
use crate::lattice::{Dynamics, Engine, Network, State};
use crate::{CrystalError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::statistics::{block_standard_error, summarize};
use serde::{Deserialize, Serialize};

/// What carries a state along in time: any stepper, with collisions or without.
pub trait Flow {
    /// The state after this time.
    ///
    /// # Errors
    /// Whatever the stepper cannot do.
    fn advance(&mut self, state: &mut State, duration: f64) -> Result<()>;

    /// Brings a state that was moved by a little back to where the constraints hold, and prepares
    /// to go on from there.
    ///
    /// # Errors
    /// If there is no way back.
    fn project(&mut self, state: &mut State) -> Result<()> {
        let _ = state;
        Ok(())
    }
}

impl<F: FnMut(&mut State, f64) -> Result<()>> Flow for F {
    fn advance(&mut self, state: &mut State, duration: f64) -> Result<()> {
        self(state, duration)
    }
}

/// [`Dynamics`] without collisions, in equal steps of at most a given length.
pub struct RodFlow {
    dynamics: Dynamics,
    projector: Projector,
    longest_step: f64,
}

impl RodFlow {
    /// The flow of these dynamics, which must be prepared at the state from which it starts.
    pub fn new(dynamics: Dynamics, longest_step: f64) -> Self {
        let projector = Projector::new(dynamics.network());
        Self {
            dynamics,
            projector,
            longest_step,
        }
    }
}

impl Flow for RodFlow {
    fn advance(&mut self, state: &mut State, duration: f64) -> Result<()> {
        let steps = (duration / self.longest_step - 1e-9).ceil().max(1.0);
        for _ in 0..steps as u64 {
            self.dynamics.step(state, duration / steps)?;
        }
        Ok(())
    }

    fn project(&mut self, state: &mut State) -> Result<()> {
        self.projector.positions(&mut state.positions)?;
        self.projector
            .velocities(&state.positions, &mut state.velocities)?;
        self.dynamics.prepare(state)
    }
}

/// An [`Engine`], with collisions, in equal steps of at most a given length.
pub struct CollisionFlow {
    engine: Engine,
    projector: Projector,
    longest_step: f64,
}

impl CollisionFlow {
    /// The flow of this engine, which must be prepared at the state from which it starts.
    pub fn new(engine: Engine, longest_step: f64) -> Self {
        let projector = Projector::new(engine.network());
        Self {
            engine,
            projector,
            longest_step,
        }
    }

    /// The engine, with its statistics.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }
}

impl Flow for CollisionFlow {
    fn advance(&mut self, state: &mut State, duration: f64) -> Result<()> {
        let steps = (duration / self.longest_step - 1e-9).ceil().max(1.0);
        for _ in 0..steps as u64 {
            self.engine.step(state, duration / steps)?;
        }
        Ok(())
    }

    fn project(&mut self, state: &mut State) -> Result<()> {
        self.projector.positions(&mut state.positions)?;
        self.projector
            .velocities(&state.positions, &mut state.velocities)?;
        self.engine.prepare(state)
    }
}

/// How the exponent is measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LyapunovSettings {
    /// d0.
    pub separation: f64,
    /// τ, between two renormalisations.
    pub interval: f64,
    /// Intervals that are not counted, in which the neighbour finds the direction of fastest
    /// growth.
    pub discarded: usize,
    /// K, intervals that are counted.
    pub intervals: usize,
    /// Seed of the first direction.
    pub seed: u64,
}

impl Default for LyapunovSettings {
    fn default() -> Self {
        Self {
            separation: 1e-7,
            interval: 0.5,
            discarded: 20,
            intervals: 200,
            seed: 0,
        }
    }
}

/// A maximal Lyapunov exponent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LyapunovExponent {
    /// λ, 1/time.
    pub exponent: f64,
    /// Its standard error, from blocks of intervals or, where these do not settle, from their
    /// autocorrelation.
    pub standard_error: f64,
    /// ln(d_k / d0) / τ of every counted interval.
    pub growth_rates: Vec<f64>,
}

/// The maximal Lyapunov exponent of the trajectory from this state. The two flows carry the state
/// and its neighbour; flows that remember nothing of the state may be two copies of one. The state
/// is carried to the end.
///
/// # Errors
/// [`CrystalError::BadSetting`] for settings that make no sense, [`CrystalError::BadState`] if the
/// constraints leave no neighbour, and what the flows cannot do.
pub fn maximal_exponent<F: Flow, G: Flow>(
    network: &Network,
    flow: &mut F,
    neighbour_flow: &mut G,
    state: &mut State,
    settings: &LyapunovSettings,
) -> Result<LyapunovExponent> {
    for (setting, value) in [
        ("separation", settings.separation),
        ("interval", settings.interval),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(CrystalError::BadSetting {
                setting,
                value,
                requirement: "positive",
            });
        }
    }
    if settings.intervals == 0 {
        return Err(CrystalError::BadSetting {
            setting: "intervals",
            value: 0.0,
            requirement: "positive",
        });
    }
    state.check(network)?;
    let weights: Vec<f64> = network
        .squares
        .iter()
        .flat_map(|square| [square.mass, square.mass, square.inertia])
        .collect();
    let mut neighbour = state.clone();
    let mut rng = CounterRng::for_purpose(settings.seed, 0, 0, Purpose::LyapunovDirection);
    for numbers in [&mut neighbour.positions, &mut neighbour.velocities] {
        for (number, weight) in numbers.iter_mut().zip(&weights) {
            *number += settings.separation * normal_pair(&mut rng)[0] / weight.sqrt();
        }
    }
    neighbour_flow.project(&mut neighbour)?;
    let mut before = renormalise(
        &weights,
        neighbour_flow,
        state,
        &mut neighbour,
        settings.separation,
    )?;
    let mut growth_rates = Vec::with_capacity(settings.intervals);
    for interval in 0..settings.discarded + settings.intervals {
        flow.advance(state, settings.interval)?;
        neighbour_flow.advance(&mut neighbour, settings.interval)?;
        if interval >= settings.discarded {
            growth_rates
                .push((distance(&weights, state, &neighbour) / before).ln() / settings.interval);
        }
        before = renormalise(
            &weights,
            neighbour_flow,
            state,
            &mut neighbour,
            settings.separation,
        )?;
    }
    let summary = summarize(&growth_rates);
    let standard_error = block_standard_error(&growth_rates).unwrap_or(summary.standard_error);
    Ok(LyapunovExponent {
        exponent: summary.mean,
        standard_error,
        growth_rates,
    })
}

fn distance(weights: &[f64], state: &State, neighbour: &State) -> f64 {
    let squares = |a: &[f64], b: &[f64]| -> f64 {
        a.iter()
            .zip(b)
            .zip(weights)
            .map(|((a, b), weight)| weight * (a - b) * (a - b))
            .sum()
    };
    let positions = squares(&state.positions, &neighbour.positions);
    (positions + squares(&state.velocities, &neighbour.velocities)).sqrt()
}

/// Brings the neighbour back to the distance `separation`, where that is free; returns the distance
/// after projection.
fn renormalise<F: Flow>(
    weights: &[f64],
    flow: &mut F,
    state: &State,
    neighbour: &mut State,
    separation: f64,
) -> Result<f64> {
    let apart = distance(weights, state, neighbour);
    if !(apart.is_finite() && apart > 0.0) {
        return Err(CrystalError::BadState(format!(
            "the neighbouring trajectory is {apart} away at t = {}; take another separation",
            state.time
        )));
    }
    let kept = neighbour.clone();
    let factor = separation / apart;
    let shrink = |from: &[f64], to: &mut [f64]| {
        to.iter_mut()
            .zip(from)
            .for_each(|(to, from)| *to = from + factor * (*to - from));
    };
    shrink(&state.positions, &mut neighbour.positions);
    shrink(&state.velocities, &mut neighbour.velocities);
    neighbour.time = state.time;
    match flow.project(neighbour) {
        Err(CrystalError::Overlap { .. }) => {
            // The neighbour at the smaller distance would be inside another body: it is left where
            // it is this time.
            neighbour.clone_from(&kept);
            flow.project(neighbour)?;
        }
        other => other?,
    }
    Ok(distance(weights, state, neighbour))
}
