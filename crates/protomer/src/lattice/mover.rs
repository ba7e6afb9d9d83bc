//! One step of a run, whatever moves it.

use super::settings::LatticeSettings;
use super::start::heat_bath;
use anyhow::Result;
use protomer_crystal::lattice::{Coherence, CollisionSettings, Dynamics, Engine, Force, Langevin, Network, State};
use std::sync::Arc;

/// The engine of a run.
pub struct Mover {
    kind: Kind,
    /// Friction and noise, half a step before and half a step after the rest.
    bath: Option<Langevin>,
    sigma: Vec<f64>,
    /// Collisions before this engine was made, in the part of the run that led to its checkpoint.
    earlier_events: u64,
}

/// The two are as large as they are; there is one per run.
#[allow(clippy::large_enum_variant)]
enum Kind {
    Free(Dynamics),
    Colliding(Engine),
}

impl Mover {
    /// The engine of a run, prepared at the first state of the run.
    ///
    /// # Errors
    /// For a network or state that makes no sense, rods that depend on each other, or squares that overlap.
    pub fn new(settings: &LatticeSettings, network: Arc<Network>, first: &State) -> Result<Self> {
        let sigma = vec![0.0; network.rods.len()];
        let forces: Vec<Box<dyn Force>> = vec![Box::new(Coherence { kappa: settings.kappa })];
        let kind = if settings.collisions {
            let collisions = CollisionSettings { restitution: settings.restitution, ..CollisionSettings::default() };
            Kind::Colliding(Engine::new(network, forces, first, collisions)?)
        } else {
            Kind::Free(Dynamics::new(network, forces, first)?)
        };
        let bath = if settings.friction > 0.0 { Some(heat_bath(settings)?) } else { None };
        Ok(Self { kind, bath, sigma, earlier_events: 0 })
    }

    /// Goes on from another state, that of a checkpoint.
    ///
    /// The order of elimination stays that of the first state of the run: rounding, and with it every later bit, depends
    /// on it.
    ///
    /// # Errors
    /// If the rods depend on each other there.
    pub fn resume(&mut self, state: &State, events: u64) -> Result<()> {
        self.earlier_events = events;
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics.prepare(state)?,
            Kind::Colliding(engine) => engine.prepare(state)?,
        }
        Ok(())
    }

    fn dynamics(&mut self) -> &mut Dynamics {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics,
            Kind::Colliding(engine) => engine.dynamics(),
        }
    }

    /// What is joined to what.
    pub fn network(&self) -> &Arc<Network> {
        match &self.kind {
            Kind::Free(dynamics) => dynamics.network(),
            Kind::Colliding(engine) => engine.network(),
        }
    }

    /// Collisions so far: moments at which squares met.
    pub fn events(&self) -> u64 {
        match &self.kind {
            Kind::Free(_) => self.earlier_events,
            Kind::Colliding(engine) => self.earlier_events + engine.statistics().impacts,
        }
    }

    /// Kinetic and potential energy at the state last reached.
    pub fn energy(&mut self, state: &State) -> f64 {
        let kinetic = state.kinetic_energy(self.network());
        kinetic + self.dynamics().potential_energy()
    }

    /// Potential energy at the state last reached.
    pub fn potential_energy(&mut self) -> f64 {
        self.dynamics().potential_energy()
    }

    /// Largest deviation of a rod from its length.
    pub fn rod_violation(&mut self, state: &State) -> f64 {
        let mut sigma = std::mem::take(&mut self.sigma);
        let violation = self.dynamics().rods().violations(&state.positions, &mut sigma).1.abs();
        self.sigma = sigma;
        violation
    }

    /// One step of the run. `step` is its number, for the random numbers of a heat bath.
    ///
    /// # Errors
    /// For a step that is too large; the state is then as it was.
    pub fn step(&mut self, state: &mut State, time_step: f64, step: u64) -> Result<()> {
        let Some(bath) = self.bath else { return self.step_without_bath(state, time_step) };
        let before = state.clone();
        bath.before(self.dynamics(), state, time_step, step);
        if let Err(error) = self.step_without_bath(state, time_step) {
            *state = before;
            return Err(error);
        }
        bath.after(self.dynamics(), state, time_step, step);
        Ok(())
    }

    fn step_without_bath(&mut self, state: &mut State, time_step: f64) -> Result<()> {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics.step(state, time_step)?,
            Kind::Colliding(engine) => engine.step(state, time_step)?,
        }
        Ok(())
    }
}
