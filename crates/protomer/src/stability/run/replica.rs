//! One simulation in its directory.
//!
//! ```text
//! DIR/  log.csv  trajectory.gsd  checkpoint.bin  run.json
//! ```

use super::trajectory::Trajectory;
use super::{Engine, LogRow, RunSettings};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Error, Result};
use protomer_mc::moves::Acceptance;
use protomer_mc::{Checkpoint, Simulation, Statistics};
use protomer_results::{Log, LogMark, Record, ResultKind, Run, Turn, Work, log};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::Path;

const LOG: &str = "log.csv";
const TRAJECTORY: &str = "trajectory.gsd";

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
    /// Hash of everything that shapes the result.
    pub identity: &'a str,
}

/// Acceptance ratios of the trial moves of production.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AcceptedFractions {
    /// Acceptance ratio of translations.
    pub translation_acceptance: f64,
    /// Acceptance ratio of rotations.
    pub rotation_acceptance: f64,
}

/// The details of the record that are part of the answer.
#[derive(Deserialize)]
struct Details {
    acceptance: AcceptedFractions,
}

/// A state from which a simulation continues bit for bit.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
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
    log: Log,
    trajectory: Option<Trajectory>,
    cluster_moves_logged: (u64, u64),
}

impl Run for Replica<'_> {
    type State = State;
    type Checkpoint = Saved;
    type Answer = AcceptedFractions;
    type Error = Error;

    fn work(&self) -> Work {
        Work {
            kind: ResultKind::Simulation,
            verb: "simulate",
            identity: self.identity.into(),
            input_sha256: self.engine.assembly().sha256.clone(),
        }
    }

    fn length(&self) -> u64 {
        self.settings.total_sweeps()
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<State> {
        let (mut mark, mut frames, mut cluster_moves_logged) = (LogMark::default(), 0, (0, 0));
        let simulation = match saved {
            None => self.start()?,
            Some(saved) => {
                (mark, frames) = (saved.log, saved.trajectory_frames);
                cluster_moves_logged = saved.cluster_moves_logged;
                let model = self.engine.energy_model(self.settings, &self.interaction)?;
                Simulation::resume_with_model(self.engine.system()?, saved.simulation, model)?
            }
        };
        let log = Log::open::<LogRow>(&directory.join(LOG), &mark)?;
        let trajectory = match self.settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                Some(Trajectory::open(&path, self.engine.assembly(), frames)?)
            }
        };
        Ok(State {
            simulation,
            log,
            trajectory,
            cluster_moves_logged,
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
        let stop = self.settings.next_stop(state.simulation.sweep());
        state.simulation.run_until(stop, &mut until_over)?;
        self.write_outputs(state)
    }

    fn save(&self, state: &mut State) -> Result<Saved> {
        let trajectory_frames = match &mut state.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        Ok(Saved {
            log: state.log.sync()?,
            trajectory_frames,
            cluster_moves_logged: state.cluster_moves_logged,
            simulation: state.simulation.checkpoint(),
        })
    }

    fn answer(&self, state: &mut State, _directory: &Path) -> Result<AcceptedFractions> {
        Ok(AcceptedFractions::of(state.simulation.statistics()))
    }

    fn details(&self, state: &mut State, _directory: &Path) -> Result<Value> {
        let simulation = &state.simulation;
        let mut details = json!({
            "replica": self.replica,
            "medium": self.interaction,
            "sweeps_done": simulation.sweep(),
            "acceptance": AcceptedFractions::of(simulation.statistics()),
            "step_sizes": simulation.step_sizes(),
            "statistics": simulation.statistics(),
            "native_contacts": simulation.native_contacts(),
        });
        if let Some(bodies) = self.engine.effective_bodies() {
            details["effective_bodies"] = json!(bodies);
        }
        Ok(details)
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
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }
}

impl Replica<'_> {
    fn start(&self) -> Result<Simulation> {
        let (engine, settings) = (self.engine, self.settings);
        // Every simulation of a sweep has its own stream of random numbers.
        let stream = self.salt_index * settings.replicas + self.replica;
        Ok(Simulation::with_model(
            engine.system()?,
            engine.settings(settings, &self.interaction)?,
            engine.energy_model(settings, &self.interaction)?,
            settings.seed,
            stream,
        )?)
    }

    /// Writes the row and the frame that are due. Equilibration writes neither.
    fn write_outputs(&self, state: &mut State) -> Result<()> {
        let sweep = state.simulation.sweep();
        let production = sweep.saturating_sub(self.settings.equilibration_sweeps);
        if production == 0 {
            state.cluster_moves_logged = (0, 0);
            return Ok(());
        }
        if production.is_multiple_of(self.settings.log_every) {
            let row = state.row(production);
            state.log.append(&row)?;
        }
        if let Some(trajectory) = &mut state.trajectory
            && production.is_multiple_of(self.settings.trajectory_every)
        {
            trajectory.append(production, &state.simulation)?;
        }
        Ok(())
    }
}

impl State {
    fn row(&mut self, production: u64) -> LogRow {
        let observables = self.simulation.observables();
        LogRow {
            sweep: production,
            r_g_angstrom: observables.r_g_angstrom,
            native_contacts: observables.native_contacts.unwrap_or(f64::NAN),
            largest_cluster: observables.largest_cluster,
            energy_kt: observables.energy_kt,
            cluster_moved: self.bodies_per_cluster_move(),
        }
    }

    /// Mean number of bodies moved per cluster move since the last row.
    fn bodies_per_cluster_move(&mut self) -> f64 {
        let statistics = self.simulation.statistics();
        let counted = (statistics.cluster_moves, statistics.cluster_bodies);
        let before = std::mem::replace(&mut self.cluster_moves_logged, counted);
        let (moves, bodies) = (counted.0 - before.0, counted.1 - before.1);
        if moves == 0 {
            0.0
        } else {
            bodies as f64 / moves as f64
        }
    }
}

impl AcceptedFractions {
    fn of(statistics: &Statistics) -> Self {
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
