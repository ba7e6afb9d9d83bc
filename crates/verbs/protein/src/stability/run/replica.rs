//! One simulation in its directory.
//!
//! ```text
//! DIR/  log.csv  trajectory.gsd  checkpoint.bin  run.json
//! ```

use super::outputs::{Outputs, SavedOutputs};
use super::settings::Start;
use super::{Engine, GivenState, RunSettings};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Error, Result};
use protomer_kernel::null;
use protomer_mc::moves::Acceptance;
use protomer_mc::observables::contacts;
use protomer_mc::scatter::scattered;
use protomer_mc::{Checkpoint, Simulation, Statistics};
use protomer_results::{LogMark, Record, ResultKind, Run, Turn, Work};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::Path;

/// One simulation of a sweep.
#[derive(Debug)]
pub struct Replica<'a> {
    /// The bodies, with the charges that interact in this medium.
    pub engine: &'a Engine,
    /// The settings of the sweep.
    pub settings: &'a RunSettings,
    /// The medium at this salt concentration.
    pub interaction: ScreenedCoulomb,
    /// Index of the salt concentration. Part of the random stream, which is thus unique to a
    /// simulation.
    pub salt_index: u32,
    /// Index of the replica.
    pub replica: u32,
    /// Poses of a file from which the bodies start, in the place of those of the assembly.
    pub state: Option<&'a GivenState>,
    /// Hash of everything that shapes the result.
    pub identity: &'a str,
}

/// Acceptance ratios of the trial moves of production.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AcceptedFractions {
    /// Acceptance ratio of translations.
    #[serde(deserialize_with = "null::as_nan")]
    pub translation_acceptance: f64,
    /// Acceptance ratio of rotations.
    #[serde(deserialize_with = "null::as_nan")]
    pub rotation_acceptance: f64,
}

/// The details of the record that are part of the answer.
#[derive(Deserialize)]
struct Details {
    acceptance: AcceptedFractions,
}

impl AcceptedFractions {
    /// Ratios in the record of a simulation; `None` in the record of one that is not finished.
    pub fn recorded(record: &Record) -> Option<Self> {
        let details = Details::deserialize(&record.details).ok()?;
        Some(details.acceptance)
    }
}

/// A state from which a simulation continues bit for bit.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// The part of the charges that belongs to this state; empty where they are fixed.
    #[serde(default, skip_serializing_if = "LogMark::is_empty")]
    charges: LogMark,
    /// Frames of the trajectory that belong to this state.
    trajectory_frames: u64,
    /// Cluster moves, and bodies they moved, at the last row of the log.
    cluster_moves_logged: (u64, u64),
    /// The simulation.
    simulation: Checkpoint,
}

/// A simulation with its open files.
pub struct State {
    simulation: Simulation,
    outputs: Outputs,
}

impl Run for Replica<'_> {
    type State = State;
    type Checkpoint = Saved;
    type Answer = AcceptedFractions;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::Simulation,
            "simulate",
            self.identity,
            &self.engine.assembly().sha256,
        )
    }

    fn length(&self) -> u64 {
        self.settings.total_sweeps()
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<State> {
        let mut outputs = SavedOutputs::default();
        let simulation = match saved {
            None => self.start()?,
            Some(saved) => {
                outputs = saved.outputs();
                let model = self.engine.energy_model(self.settings, &self.interaction)?;
                Simulation::resume_with_model(self.engine.system()?, saved.simulation, model)?
            }
        };
        let outputs = Outputs::open(directory, self.engine, self.settings, &outputs)?;
        Ok(State {
            simulation,
            outputs,
        })
    }

    fn done(&self, state: &State) -> u64 {
        state.simulation.sweep()
    }

    fn advance(&self, state: &mut State, turn: &Turn<'_>) -> Result<()> {
        let mut until_over = |_: &Simulation| match turn.is_over() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        // The next output, at most; the time slice may end before it.
        let stop = self.settings.next_stop(state.simulation.sweep());
        state.simulation.run_until(stop, &mut until_over)?;
        state.outputs.write(self.settings, &state.simulation)
    }

    fn save(&self, state: &mut State) -> Result<Saved> {
        let SavedOutputs {
            log,
            charges,
            trajectory_frames,
            cluster_moves_logged,
        } = state.outputs.save()?;
        Ok(Saved {
            log,
            charges,
            trajectory_frames,
            cluster_moves_logged,
            simulation: state.simulation.checkpoint(),
        })
    }

    fn answer(&self, state: &mut State, _directory: &Path) -> Result<AcceptedFractions> {
        Ok(AcceptedFractions::from_statistics(
            state.simulation.statistics(),
        ))
    }

    fn details(&self, state: &mut State, _directory: &Path) -> Result<Value> {
        Ok(self.details_of(&state.simulation))
    }

    fn finished(
        &self,
        directory: &Path,
        record: Option<&Record>,
    ) -> Result<Option<AcceptedFractions>> {
        let done = record.filter(|record| record.is_done_at(self.length()));
        let details = done.map(|record| record.read_details::<Details>(directory));
        Ok(details.transpose()?.map(|details| details.acceptance))
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        saved.outputs().check(directory)
    }
}

impl Saved {
    fn outputs(&self) -> SavedOutputs {
        SavedOutputs {
            log: self.log.clone(),
            charges: self.charges.clone(),
            trajectory_frames: self.trajectory_frames,
            cluster_moves_logged: self.cluster_moves_logged,
        }
    }
}

impl Replica<'_> {
    /// The simulation before its first move: from a file, from the assembly or from a fluid, as the settings say.
    ///
    /// # Errors
    /// If the start is impossible.
    pub fn start(&self) -> Result<Simulation> {
        let (engine, settings) = (self.engine, self.settings);
        let assembly = engine.system()?;
        // Contacts of the assembly, not of the start: a fluid is compared with it as well.
        let native = contacts(&assembly, settings.contact_gap_angstrom);
        let system = match (self.state, settings.starts.of_replica(self.replica)) {
            (Some(state), _) => engine.system_at(&state.poses)?,
            (None, Start::Assembly) => assembly,
            (None, Start::Fluid) => scattered(&assembly, settings.seed, self.replica)?,
        };
        // Every simulation of a sweep has its own stream of random numbers.
        let stream = self.salt_index * settings.replicas + self.replica;
        let simulation = Simulation::with_model(
            system,
            engine.settings(settings, &self.interaction)?,
            engine.energy_model(settings, &self.interaction)?,
            settings.seed,
            stream,
        )?;
        Ok(simulation.with_native_contacts(native))
    }

    /// The details of the record.
    pub fn details_of(&self, simulation: &Simulation) -> Value {
        let mut details = json!({
            "replica": self.replica,
            "medium": self.interaction,
            "sweeps_done": simulation.sweep(),
            "acceptance": AcceptedFractions::from_statistics(simulation.statistics()),
            "step_sizes": simulation.step_sizes(),
            "statistics": simulation.statistics(),
            "native_contacts": simulation.native_contacts(),
        });
        if let Some(bodies) = self.engine.effective_bodies() {
            details["effective_bodies"] = json!(bodies);
        }
        details
    }
}

impl AcceptedFractions {
    /// Computes the ratios from the counts of a simulation.
    pub fn from_statistics(statistics: &Statistics) -> Self {
        Self {
            translation_acceptance: accepted_fraction(&statistics.translation),
            rotation_acceptance: accepted_fraction(&statistics.rotation),
        }
    }
}

/// The acceptance ratio over all kinds of bodies; zero without trials.
fn accepted_fraction(counts: &[Acceptance]) -> f64 {
    let accepted: u64 = counts.iter().map(|count| count.accepted).sum();
    let trials: u64 = counts.iter().map(|count| count.trials).sum();
    if trials == 0 {
        0.0
    } else {
        accepted as f64 / trials as f64
    }
}
