//! One step of a run, whatever moves it.

use super::settings::LatticeSettings;
use super::start::heat_bath;
use anyhow::Result;
use protomer_crystal::lattice::paper::{PaperEngine, PaperSettings};
use protomer_crystal::lattice::{
    Coherence, CollisionSettings, Dynamics, Engine, Force, Langevin, Network, ScreenedCharges,
    State,
};
use protomer_kernel::potential::Yukawa;
use std::sync::Arc;

/// The engine of a run.
pub struct Mover {
    kind: Kind,
    network: Arc<Network>,
    /// Friction and noise, half a step before and half a step after the rest.
    bath: Option<Langevin>,
    sigma: Vec<f64>,
    /// Collisions before this engine was made, in the part of the run that led to its checkpoint.
    earlier_events: u64,
}

/// They are as large as they are; there is one per run.
#[allow(clippy::large_enum_variant)]
enum Kind {
    Free(Dynamics),
    Colliding(Engine),
    Paper(PaperEngine),
}

impl Mover {
    /// The engine of a run, prepared at the first state of the run.
    ///
    /// # Errors
    /// For a network or state that makes no sense, rods that depend on each other, or squares that
    /// overlap.
    pub fn new(settings: &LatticeSettings, network: Arc<Network>, first: &State) -> Result<Self> {
        let (shared, sigma) = (network.clone(), vec![0.0; network.rods.len()]);
        let forces = forces(settings, &network)?;
        let kind = if settings.paper {
            Kind::Paper(PaperEngine::new(
                network,
                forces,
                first,
                PaperSettings::default(),
            )?)
        } else if settings.collisions {
            let collisions = CollisionSettings {
                restitution: settings.restitution,
                ..CollisionSettings::default()
            };
            Kind::Colliding(Engine::new(network, forces, first, collisions)?)
        } else {
            Kind::Free(Dynamics::new(network, forces, first)?)
        };
        let bath = if settings.friction > 0.0 {
            Some(heat_bath(settings)?)
        } else {
            None
        };
        Ok(Self {
            kind,
            network: shared,
            bath,
            sigma,
            earlier_events: 0,
        })
    }

    /// Goes on from another state, that of a checkpoint.
    ///
    /// # Errors
    /// If the rods depend on each other there.
    pub fn resume(&mut self, state: &State, events: u64) -> Result<()> {
        self.earlier_events = events;
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics.prepare(state)?,
            Kind::Colliding(engine) => engine.prepare(state)?,
            Kind::Paper(engine) => engine.dynamics().prepare(state)?,
        }
        Ok(())
    }

    fn dynamics(&mut self) -> &mut Dynamics {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics,
            Kind::Colliding(engine) => engine.dynamics(),
            Kind::Paper(engine) => engine.dynamics(),
        }
    }

    /// What is joined to what.
    pub fn network(&self) -> &Arc<Network> {
        &self.network
    }

    /// Collisions so far: moments at which squares met.
    pub fn events(&self) -> u64 {
        match &self.kind {
            Kind::Free(_) => self.earlier_events,
            Kind::Colliding(engine) => self.earlier_events + engine.statistics().impacts,
            Kind::Paper(engine) => self.earlier_events + engine.statistics().collisions,
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
        let violation = self
            .dynamics()
            .rods()
            .violations(&state.positions, &mut sigma)
            .1
            .abs();
        self.sigma = sigma;
        violation
    }

    /// One step of the run. `step` is its number, for the random numbers of a heat bath.
    ///
    /// # Errors
    /// For a step that is too large; the state is then as it was.
    pub fn step(&mut self, state: &mut State, time_step: f64, step: u64) -> Result<()> {
        let before = state.clone();
        let result = self.step_with_bath(state, time_step, step);
        if result.is_err() {
            *state = before;
        }
        result
    }

    fn step_with_bath(&mut self, state: &mut State, time_step: f64, step: u64) -> Result<()> {
        let Some(bath) = self.bath else {
            return self.step_without_bath(state, time_step);
        };
        bath.before(self.dynamics(), state, time_step, step);
        self.step_without_bath(state, time_step)?;
        bath.after(self.dynamics(), state, time_step, step);
        Ok(())
    }

    fn step_without_bath(&mut self, state: &mut State, time_step: f64) -> Result<()> {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics.step(state, time_step)?,
            Kind::Colliding(engine) => engine.step(state, time_step)?,
            Kind::Paper(engine) => engine.step(state, time_step)?,
        }
        Ok(())
    }
}

/// The forces of a run beside those of rods and contacts.
///
/// # Errors
/// For charges or a screening that make no sense.
pub fn forces(settings: &LatticeSettings, network: &Network) -> Result<Vec<Box<dyn Force>>> {
    let mut forces: Vec<Box<dyn Force>> = vec![Box::new(Coherence {
        kappa: settings.kappa,
    })];
    if let Some(screening) = &settings.screening {
        let yukawa = Yukawa::new(
            screening.bjerrum_length_angstrom,
            screening.debye_length_angstrom.recip(),
            screening.cutoff_angstrom,
        )?;
        // check() has seen to it that there is a scale.
        let scale_angstrom = settings.half_diagonal_angstrom.unwrap_or(f64::NAN);
        let charges = ScreenedCharges::on_every_square(
            network,
            yukawa,
            scale_angstrom,
            screening.kt,
            &settings.charges,
        )?;
        forces.push(Box::new(charges));
    }
    Ok(forces)
}
