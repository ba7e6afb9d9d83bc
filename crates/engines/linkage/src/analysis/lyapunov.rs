//! How fast neighbouring trajectories part.
//!
//! The maximal Lyapunov exponent by the method of Benettin, Galgani and Strelcyn (Phys. Rev. A 14,
//! 2338 (1976)): a neighbour of a state at the small distance d0 is carried along for a while τ,
//! the logarithm of its distance over d0 is recorded, and it is brought back to d0 along the line
//! between the two,
//!
//! λ = 1/(K τ) Σ_k ln(d_k / d0),
//!
//! after which it is projected on what the constraints allow: positions by Newton's method on the
//! rods, velocities on those that keep them. The next growth is measured from the distance after
//! projection, not before. Distances are measured with the masses, in positions and in velocities
//! times a time scale of 1,
//!
//! d² = Σ m (δx² + δy² + δẋ² + δẏ²) + I (δθ² + δω²).
//!
//! Where collisions leave no room for the neighbour at d0, it continues from where it is.
//!
//! Directions without growth (translations, the time along the orbit) let d grow linearly, so a
//! regular motion gives λ of about ln(T)/T, not zero, after a time T.

use crate::error::{CrystalError, Result, require, require_positive};
use crate::lattice::{Dynamics, Engine, Mover, Network, Projector, State};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::statistics::{block_standard_error, summarize};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Flow that carries a state along in time: any stepper, with collisions or without.
pub trait Flow {
    /// Carries the state along for this time.
    ///
    /// # Errors
    /// Those of the stepper.
    fn advance(&mut self, state: &mut State, duration: f64) -> Result<()>;

    /// Brings a state that was moved by a little back to where the constraints hold, and prepares
    /// to continue from there.
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

/// Integrator that makes single steps with the rods kept at their lengths.
pub trait Stepper {
    /// The network.
    fn network(&self) -> &Arc<Network>;

    /// Makes one step.
    ///
    /// # Errors
    /// Those of the stepper.
    fn step(&mut self, state: &mut State, step: f64) -> Result<()>;

    /// Prepares to continue from a state that obeys the rods.
    ///
    /// # Errors
    /// Those of the stepper.
    fn prepare(&mut self, state: &State) -> Result<()>;
}

impl Stepper for Dynamics {
    fn network(&self) -> &Arc<Network> {
        self.network()
    }

    fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        self.step(state, step)
    }

    fn prepare(&mut self, state: &State) -> Result<()> {
        self.prepare(state)
    }
}

impl Stepper for Engine {
    fn network(&self) -> &Arc<Network> {
        self.network()
    }

    fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        self.step(state, step)
    }

    fn prepare(&mut self, state: &State) -> Result<()> {
        self.prepare(state)
    }
}

/// Every step is the first of its run: a heat bath would draw the same noise in each, so only movers
/// without noise may be used here.
impl Stepper for Mover {
    fn network(&self) -> &Arc<Network> {
        self.network()
    }

    fn step(&mut self, state: &mut State, step: f64) -> Result<()> {
        self.step(state, step, 0)
    }

    fn prepare(&mut self, state: &State) -> Result<()> {
        self.prepare(state)
    }
}

/// Flow of a stepper in equal steps of at most a given length, with a projection onto the rods.
pub struct SteppedFlow<S> {
    stepper: S,
    projector: Projector,
    longest_step: f64,
}

impl<S: Stepper> SteppedFlow<S> {
    /// The flow of this stepper, which must be prepared at the state from which it starts.
    pub fn new(stepper: S, longest_step: f64) -> Self {
        let projector = Projector::new(stepper.network());
        Self {
            stepper,
            projector,
            longest_step,
        }
    }

    /// The stepper, with its statistics.
    pub fn stepper(&self) -> &S {
        &self.stepper
    }
}

impl<S: Stepper> Flow for SteppedFlow<S> {
    fn advance(&mut self, state: &mut State, duration: f64) -> Result<()> {
        // A ratio that is a whole number but for its rounding is meant to be whole.
        let steps = (duration / self.longest_step - 1e-9).ceil().max(1.0);
        for _ in 0..steps as u64 {
            self.stepper.step(state, duration / steps)?;
        }
        Ok(())
    }

    fn project(&mut self, state: &mut State) -> Result<()> {
        self.projector.positions(&mut state.positions)?;
        self.projector
            .velocities(&state.positions, &mut state.velocities)?;
        self.stepper.prepare(state)
    }
}

/// Settings of the measurement of the exponent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LyapunovSettings {
    /// Initial distance d0 of the neighbour in each interval.
    pub separation: f64,
    /// Time τ between two renormalisations.
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

impl LyapunovSettings {
    /// Checks settings that were read from a file.
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a separation or interval that is not positive, or for no
    /// intervals.
    pub fn check(&self) -> Result<()> {
        require_positive("separation", self.separation)?;
        require_positive("interval", self.interval)?;
        let intervals = self.intervals as f64;
        require("intervals", intervals, self.intervals > 0, "positive")
    }
}

/// A maximal Lyapunov exponent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LyapunovExponent {
    /// λ, 1/time.
    pub exponent: f64,
    /// Standard error of the exponent, from blocks of intervals or, where these do not settle, from
    /// the autocorrelation of the intervals.
    pub standard_error: f64,
    /// ln(d_k / d0) / τ of every counted interval.
    pub growth_rates: Vec<f64>,
}

/// The maximal Lyapunov exponent of the trajectory from this state. The two flows carry the state
/// and its neighbour; flows that remember nothing of the state may be two copies of one. The state
/// is carried to the end.
///
/// ```
/// use protomer_linkage::analysis::lyapunov::{LyapunovSettings, SteppedFlow, maximal_exponent};
/// use protomer_linkage::lattice::{Dynamics, Plan, Start, StartVelocities};
/// use std::sync::Arc;
/// let plan = Plan { rows: 2, columns: 2, rod_length: 1.0, ..Plan::default() };
/// let network = Arc::new(plan.network()?);
/// let velocities = StartVelocities::Uniform { largest: 1.0, sum_of_squares: Some(4.0) };
/// let mut state = Start { velocities, seed: 4, ..Start::default() }.build(&network, 0)?.state;
/// let dynamics = || Dynamics::new(network.clone(), Vec::new(), &state);
/// let mut flow = SteppedFlow::new(dynamics()?, 0.01);
/// let mut neighbour_flow = SteppedFlow::new(dynamics()?, 0.01);
/// let settings = LyapunovSettings { intervals: 100, ..LyapunovSettings::default() };
/// let found =
///     maximal_exponent(&network, &mut flow, &mut neighbour_flow, &mut state, &settings)?;
/// assert!(found.exponent > 0.0); // four squares on rods are chaotic
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadSetting`] for settings that make no sense, [`CrystalError::BadState`] if the
/// constraints leave no neighbour, and those of the flows.
pub fn maximal_exponent<F: Flow, G: Flow>(
    network: &Network,
    flow: &mut F,
    neighbour_flow: &mut G,
    state: &mut State,
    settings: &LyapunovSettings,
) -> Result<LyapunovExponent> {
    let mut neighbours = Neighbours::new(network, flow, neighbour_flow, state, settings)?;
    while !neighbours.is_done() {
        neighbours.advance()?;
    }
    Ok(neighbours.exponent())
}

/// A trajectory and its neighbour, interval by interval: [`maximal_exponent`] for those who want to
/// stop in between.
pub struct Neighbours<'a, F, G> {
    flow: &'a mut F,
    neighbour_flow: &'a mut G,
    settings: LyapunovSettings,
    /// Masses and inertia, coordinate by coordinate.
    weights: Vec<f64>,
    state: &'a mut State,
    neighbour: State,
    /// The distance at the start of the interval.
    before: f64,
    /// Intervals done.
    done: usize,
    growth_rates: Vec<f64>,
}

impl<'a, F: Flow, G: Flow> Neighbours<'a, F, G> {
    /// A neighbour of this state in a random direction.
    ///
    /// # Errors
    /// As [`maximal_exponent`].
    pub fn new(
        network: &Network,
        flow: &'a mut F,
        neighbour_flow: &'a mut G,
        state: &'a mut State,
        settings: &LyapunovSettings,
    ) -> Result<Self> {
        settings.check()?;
        state.check(network)?;
        let mut weights = Vec::with_capacity(state.positions.len());
        for body in 0..network.bodies() {
            weights.extend(network.inertia_per_coordinate(body));
        }
        let mut neighbour = state.clone();
        let mut rng = CounterRng::for_purpose(settings.seed, 0, 0, Purpose::LyapunovDirection);
        for numbers in [&mut neighbour.positions, &mut neighbour.velocities] {
            for (number, weight) in numbers.iter_mut().zip(&weights) {
                *number += settings.separation * rng.normal() / weight.sqrt();
            }
        }
        neighbour_flow.project(&mut neighbour)?;
        let mut neighbours = Self {
            flow,
            neighbour_flow,
            settings: *settings,
            weights,
            state,
            neighbour,
            before: f64::NAN,
            done: 0,
            growth_rates: Vec::with_capacity(settings.intervals),
        };
        neighbours.renormalise()?;
        Ok(neighbours)
    }

    /// Whether all intervals are done.
    pub fn is_done(&self) -> bool {
        self.done >= self.settings.discarded + self.settings.intervals
    }

    /// Carries both along for an interval and brings the neighbour back.
    ///
    /// # Errors
    /// As [`maximal_exponent`].
    pub fn advance(&mut self) -> Result<()> {
        let interval = self.settings.interval;
        self.flow.advance(self.state, interval)?;
        self.neighbour_flow.advance(&mut self.neighbour, interval)?;
        if self.done >= self.settings.discarded {
            let growth = (self.distance() / self.before).ln();
            self.growth_rates.push(growth / interval);
        }
        self.done += 1;
        self.renormalise()
    }

    /// The exponent of the intervals so far.
    pub fn exponent(self) -> LyapunovExponent {
        let summary = summarize(&self.growth_rates);
        let of_blocks = block_standard_error(&self.growth_rates);
        LyapunovExponent {
            exponent: summary.mean,
            standard_error: of_blocks.unwrap_or(summary.standard_error),
            growth_rates: self.growth_rates,
        }
    }

    /// Distance d between the state and its neighbour.
    fn distance(&self) -> f64 {
        let (state, neighbour) = (&self.state, &self.neighbour);
        let positions = self.weighted_squares(&state.positions, &neighbour.positions);
        let velocities = self.weighted_squares(&state.velocities, &neighbour.velocities);
        (positions + velocities).sqrt()
    }

    fn weighted_squares(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut sum = 0.0;
        for ((a, b), weight) in a.iter().zip(b).zip(&self.weights) {
            sum += weight * (a - b) * (a - b);
        }
        sum
    }

    /// Brings the neighbour back to the distance d0, where there is room.
    fn renormalise(&mut self) -> Result<()> {
        let apart = self.distance();
        if !(apart.is_finite() && apart > 0.0) {
            return Err(CrystalError::BadState(format!(
                "the neighbouring trajectory is {apart} away at t = {}; take another separation",
                self.state.time
            )));
        }
        let saved_neighbour = self.neighbour.clone();
        let factor = self.settings.separation / apart;
        shrink(&self.state.positions, factor, &mut self.neighbour.positions);
        shrink(
            &self.state.velocities,
            factor,
            &mut self.neighbour.velocities,
        );
        self.neighbour.time = self.state.time;
        match self.neighbour_flow.project(&mut self.neighbour) {
            Err(CrystalError::Overlap { .. }) => {
                // At the smaller distance the neighbour would be inside another body: it stays
                // where it is this time.
                self.neighbour = saved_neighbour;
                self.neighbour_flow.project(&mut self.neighbour)?;
            }
            other => other?,
        }
        self.before = self.distance();
        Ok(())
    }
}

/// to = from + factor (to - from).
fn shrink(from: &[f64], factor: f64, to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from + factor * (*to - from);
    }
}
