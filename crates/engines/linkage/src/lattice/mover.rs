//! What moves a lattice: its forces, how squares meet, and a heat bath.
//!
//! A [`Motion`] says what is wanted; a [`Mover`] makes the steps with the engine that this takes:
//! [`Dynamics`] where squares pass through each other, [`Engine`] where they collide event by
//! event, [`PaperEngine`] for the published protocol.

use super::angle_potential::{JointPotential, OpeningPotential};
use super::dynamics::Dynamics;
use super::engine::{CollisionSettings, Engine};
use super::force::{Coherence, Force};
use super::load::{Load, Stress};
use super::network::Network;
use super::pair::{ScreenedCharges, SquareCharge};
use super::paper::{PaperEngine, PaperSettings, PaperStatistics};
use super::state::State;
use super::thermostat::Langevin;
use crate::Result;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::spline::Spline;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Settings of the motion of a lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// κ of the coherence potential, an inverse time squared.
    pub kappa: f64,
    /// Charges that act on those of neighbouring squares.
    pub charges: Option<Charges>,
    /// Potential of the opening of every joint, reduced units.
    pub angle_potential: Option<Spline>,
    /// Potential of the opening of the crystal, per square, reduced units.
    pub opening_potential: Option<Spline>,
    /// Stress on the lattice.
    pub stress: Stress,
    /// Treatment of squares that meet.
    pub meeting: Meetings,
    /// Friction and noise, half a step before and half a step after the rest.
    pub bath: Option<Langevin>,
}

/// The same charges on every square.
#[derive(Debug, Clone, PartialEq)]
pub struct Charges {
    /// Charges of a square, with their positions.
    pub on_square: Vec<SquareCharge>,
    /// The medium between the charges.
    pub screening: Screening,
    /// Length of one reduced unit, Å.
    pub scale_angstrom: f64,
}

/// The medium between the charges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screening {
    /// Bjerrum length, Å.
    pub bjerrum_length_angstrom: f64,
    /// Debye length, Å.
    pub debye_length_angstrom: f64,
    /// kT in reduced units: how strong a pair of charges is against the motion.
    pub kt: f64,
}

/// Treatment of squares that meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meetings {
    /// Squares pass through each other.
    Ignored,
    /// Squares collide, one event after the other.
    Collisions(CollisionSettings),
    /// Squares collide as the paper prescribes.
    Paper(PaperSettings),
}

impl Default for Motion {
    /// Elastic collisions and nothing else.
    fn default() -> Self {
        Self {
            kappa: 0.0,
            charges: None,
            angle_potential: None,
            opening_potential: None,
            stress: Stress::default(),
            meeting: Meetings::Collisions(CollisionSettings::default()),
            bath: None,
        }
    }
}

impl Motion {
    /// The forces in addition to those of rods and contacts, for a run from this first state.
    ///
    /// # Errors
    /// [`CrystalError::Kernel`](crate::CrystalError::Kernel) for a screening that makes no sense,
    /// and those of [`ScreenedCharges::new`], [`JointPotential::new`], [`OpeningPotential::new`] and
    /// [`Load::new`].
    pub fn forces(&self, network: &Network, first: &State) -> Result<Vec<Box<dyn Force>>> {
        let mut forces: Vec<Box<dyn Force>> = vec![Box::new(Coherence { kappa: self.kappa })];
        if let Some(charges) = &self.charges {
            forces.push(Box::new(charges.force(network)?));
        }
        if let Some(spline) = &self.angle_potential {
            forces.push(Box::new(JointPotential::new(network, spline.clone())?));
        }
        if let Some(spline) = &self.opening_potential {
            forces.push(Box::new(OpeningPotential::new(network, spline.clone())?));
        }
        if self.stress.acts() {
            forces.push(Box::new(Load::new(network, self.stress, first)?));
        }
        Ok(forces)
    }
}

impl Charges {
    fn force(&self, network: &Network) -> Result<ScreenedCharges> {
        let yukawa = Yukawa::uncut(
            self.screening.bjerrum_length_angstrom,
            self.screening.debye_length_angstrom.recip(),
        )?;
        let (scale, kt) = (self.scale_angstrom, self.screening.kt);
        ScreenedCharges::on_every_square(network, yukawa, scale, kt, &self.on_square)
    }
}

/// Makes the steps of a run.
///
/// ```
/// use protomer_linkage::lattice::{Motion, Mover, Plan, Start, StartVelocities};
/// use std::sync::Arc;
/// let plan = Plan { rows: 2, columns: 2, rod_length: 1.0, ..Plan::default() };
/// let network = Arc::new(plan.network()?);
/// let velocities = StartVelocities::Checkerboard { rate: -1.0 };
/// let mut state = Start { velocities, ..Start::default() }.build(&network, 0)?.state;
/// let mut mover = Mover::new(&Motion::default(), network, &state)?;
/// for number in 0..300 {
///     mover.step(&mut state, 0.01, number)?;
/// }
/// assert!(mover.events() > 0);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub struct Mover {
    kind: Kind,
    network: Arc<Network>,
    bath: Option<Langevin>,
    /// The state before the last step.
    previous_state: State,
    sigma: Vec<f64>,
    /// Collisions before this mover was made, in the part of the run that led to its checkpoint.
    earlier_events: u64,
}

enum Kind {
    Free(Box<Dynamics>),
    Colliding(Box<Engine>),
    Paper(Box<PaperEngine>),
}

impl Mover {
    /// The mover of a run, prepared at its first state.
    ///
    /// # Errors
    /// Those of [`Motion::forces`], [`Dynamics::new`] and [`Engine::new`].
    pub fn new(motion: &Motion, network: Arc<Network>, first: &State) -> Result<Self> {
        let forces = motion.forces(&network, first)?;
        let shared = network.clone();
        let kind = match motion.meeting {
            Meetings::Ignored => Kind::Free(Box::new(Dynamics::new(shared, forces, first)?)),
            Meetings::Collisions(settings) => {
                Kind::Colliding(Box::new(Engine::new(shared, forces, first, settings)?))
            }
            Meetings::Paper(settings) => {
                Kind::Paper(Box::new(PaperEngine::new(shared, forces, first, settings)?))
            }
        };
        Ok(Self {
            kind,
            bath: motion.bath,
            previous_state: first.clone(),
            sigma: vec![0.0; network.rods.len()],
            earlier_events: 0,
            network,
        })
    }

    /// Prepares to continue from another state.
    ///
    /// # Errors
    /// Those of [`Dynamics::prepare`] and [`Engine::prepare`].
    pub fn prepare(&mut self, state: &State) -> Result<()> {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics.prepare(state),
            Kind::Colliding(engine) => engine.prepare(state),
            Kind::Paper(engine) => engine.dynamics().prepare(state),
        }
    }

    /// Continues from the state of a checkpoint, with the collisions up to there and what the paper's
    /// protocol counted, if it is followed.
    ///
    /// # Errors
    /// As [`prepare`](Mover::prepare).
    pub fn resume(
        &mut self,
        state: &State,
        events: u64,
        paper: Option<PaperStatistics>,
    ) -> Result<()> {
        self.earlier_events = events;
        if let (Kind::Paper(engine), Some(statistics)) = (&mut self.kind, paper) {
            // These are among the statistics.
            self.earlier_events = events.saturating_sub(statistics.collisions);
            engine.set_statistics(statistics);
        }
        self.prepare(state)
    }

    /// Counts and extremes of the paper's protocol; `None` if it is not followed.
    pub fn paper_statistics(&self) -> Option<PaperStatistics> {
        match &self.kind {
            Kind::Paper(engine) => Some(*engine.statistics()),
            Kind::Free(_) | Kind::Colliding(_) => None,
        }
    }

    fn dynamics(&mut self) -> &mut Dynamics {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics,
            Kind::Colliding(engine) => engine.dynamics(),
            Kind::Paper(engine) => engine.dynamics(),
        }
    }

    /// Network of squares and rods.
    pub fn network(&self) -> &Arc<Network> {
        &self.network
    }

    /// Moments at which squares met, so far.
    pub fn events(&self) -> u64 {
        let new_events = match &self.kind {
            Kind::Free(_) => 0,
            Kind::Colliding(engine) => engine.statistics().impacts,
            Kind::Paper(engine) => engine.statistics().collisions,
        };
        self.earlier_events + new_events
    }

    /// Kinetic and potential energy at the state last reached.
    pub fn energy(&mut self, state: &State) -> f64 {
        state.kinetic_energy(&self.network) + self.potential_energy()
    }

    /// Potential energy at the state last reached.
    pub fn potential_energy(&mut self) -> f64 {
        self.dynamics().potential_energy()
    }

    /// Largest deviation of a rod from its length.
    pub fn rod_violation(&mut self, state: &State) -> f64 {
        let mut sigma = std::mem::take(&mut self.sigma);
        let rods = self.dynamics().rods();
        let (_, violation) = rods.violations(&state.positions, &mut sigma);
        self.sigma = sigma;
        violation.abs()
    }

    /// Makes one step of the run. `number` counts the steps, for the random numbers of a heat bath.
    ///
    /// # Errors
    /// Those of [`Dynamics::step`], [`Engine::step`] and [`PaperEngine::step`]; the state is then
    /// as it was.
    pub fn step(&mut self, state: &mut State, time_step: f64, number: u64) -> Result<()> {
        self.previous_state.clone_from(state);
        let result = self.step_with_bath(state, time_step, number);
        if result.is_err() {
            state.clone_from(&self.previous_state);
        }
        result
    }

    fn step_with_bath(&mut self, state: &mut State, time_step: f64, number: u64) -> Result<()> {
        let Some(bath) = self.bath else {
            return self.step_without_bath(state, time_step);
        };
        bath.before(self.dynamics(), state, time_step, number);
        self.step_without_bath(state, time_step)?;
        bath.after(self.dynamics(), state, time_step, number);
        Ok(())
    }

    fn step_without_bath(&mut self, state: &mut State, time_step: f64) -> Result<()> {
        match &mut self.kind {
            Kind::Free(dynamics) => dynamics.step(state, time_step),
            Kind::Colliding(engine) => engine.step(state, time_step),
            Kind::Paper(engine) => engine.step(state, time_step),
        }
    }
}
