//! One simulation in its directory: start or continue, log, keep the trajectory, stop when asked.

use super::checkpoint_file::{KIND, RunCheckpoint, read_checkpoint, write_checkpoint};
use super::execution::Execution;
use super::log::{Log, LogMark, LogRow, check_log};
use super::record::{RunRecord, read_record};
use super::trajectory::Trajectory;
use super::{Engine, RunSettings};
use crate::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::remove_abandoned;
use protomer_mc::Statistics;
use protomer_mc::{Outcome, Simulation};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Names of files in the directory of a simulation.
const CHECKPOINT: &str = "checkpoint.bin";
const LOG: &str = "log.csv";
const TRAJECTORY: &str = "trajectory.gsd";

/// One simulation to be run or continued.
#[derive(Debug)]
pub struct ReplicaTask<'a> {
    /// The bodies.
    pub engine: &'a Engine,
    /// The settings of the run.
    pub settings: &'a RunSettings,
    /// The medium at this salt concentration.
    pub interaction: ScreenedCoulomb,
    /// Index of the salt concentration: part of the random stream, so that no two simulations share
    /// one.
    pub salt_index: u32,
    /// Index of the replica.
    pub replica: u32,
    /// Where its files go.
    pub directory: PathBuf,
    /// Hash of everything that shapes the result.
    pub identity: &'a str,
}

/// How a simulation ended.
#[derive(Debug, Clone, PartialEq)]
pub enum ReplicaEnd {
    /// All sweeps are done.
    Finished(ReplicaCounts),
    /// It was asked to stop and can go on.
    Stopped,
}

impl ReplicaEnd {
    /// The counts, if it finished.
    pub fn finished(self) -> Option<ReplicaCounts> {
        match self {
            ReplicaEnd::Finished(counts) => Some(counts),
            ReplicaEnd::Stopped => None,
        }
    }
}

/// Acceptance over production.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ReplicaCounts {
    /// Accepted fraction of translations.
    pub translation_acceptance: f64,
    /// Accepted fraction of rotations.
    pub rotation_acceptance: f64,
}

/// Runs a simulation to its end, from the checkpoint if there is one. `advanced` hears how many
/// sweeps were done.
///
/// # Errors
/// For an overlapping start, a directory that belongs to another run, a disk that takes no more, or
/// an energy that is not finite. `run.json` of the simulation then says what happened and after how
/// many sweeps.
pub fn run_replica(
    task: &ReplicaTask<'_>,
    execution: &Execution,
    advanced: &dyn Fn(u64),
) -> Result<ReplicaEnd> {
    std::fs::create_dir_all(&task.directory)
        .with_context(|| format!("cannot make the directory {}", task.directory.display()))?;
    remove_abandoned(&task.directory)?;
    if let Some(counts) = finished(task)? {
        advanced(task.settings.total_sweeps());
        return Ok(ReplicaEnd::Finished(counts));
    }
    let mut run = Run::open(task).inspect_err(|error| task.record_failed_start(error))?;
    // What an earlier process said of its end no longer holds.
    task.record("running", run.details())
        .write(&task.directory)?;
    advanced(run.simulation.sweep());
    let outcome = match run
        .advance(execution, advanced)
        .and_then(|outcome| run.save().map(|()| outcome))
    {
        Ok(outcome) => outcome,
        Err(error) => {
            // The error is what counts; on a full disk there may be no room for the record either.
            let _ = task
                .record(&format!("{error:#}"), run.details())
                .write(&task.directory);
            return Err(error);
        }
    };
    let (end, record) = match outcome {
        Outcome::Finished => {
            let counts = acceptance(run.simulation.statistics());
            (
                ReplicaEnd::Finished(counts),
                task.record("done", run.details()),
            )
        }
        Outcome::Stopped => (
            ReplicaEnd::Stopped,
            task.record("stopped", run.details())
                .stopped_by(&execution.interrupt),
        ),
    };
    record.write(&task.directory)?;
    Ok(end)
}

/// The counts of a run that is done already; an error if the directory holds another run.
fn finished(task: &ReplicaTask<'_>) -> Result<Option<ReplicaCounts>> {
    let Some(record) = read_record(&task.directory)? else {
        return Ok(None);
    };
    check_identity(&task.directory, &record.identity, task.identity)?;
    let sweeps_done = record
        .details
        .get("sweeps_done")
        .and_then(serde_json::Value::as_u64);
    if record.exit_reason != "done" || sweeps_done != Some(task.settings.total_sweeps()) {
        return Ok(None);
    }
    if let Some(saved) = read_checkpoint::<RunCheckpoint>(&task.path(CHECKPOINT), KIND)? {
        check_log(&task.path(LOG), &saved.log)?;
    }
    let counts = record
        .details
        .get("acceptance")
        .cloned()
        .unwrap_or_default();
    serde_json::from_value(counts)
        .map(Some)
        .with_context(|| format!("run.json in {}", task.directory.display()))
}

fn check_identity(directory: &Path, present: &str, wanted: &str) -> Result<()> {
    if present != wanted {
        bail!(
            "{} holds a run with other settings or other input; choose another directory, or start anew with --force",
            directory.display()
        );
    }
    Ok(())
}

impl ReplicaTask<'_> {
    fn path(&self, name: &str) -> PathBuf {
        self.directory.join(name)
    }

    /// A stream of random numbers of its own for every simulation of a sweep.
    fn stream(&self) -> u32 {
        self.salt_index * self.settings.replicas + self.replica
    }

    fn record(&self, reason: &str, details: serde_json::Value) -> RunRecord {
        RunRecord {
            version: env!("CARGO_PKG_VERSION").into(),
            verb: "simulate".into(),
            identity: self.identity.into(),
            input_sha256: self.engine.assembly().sha256.clone(),
            exit_reason: reason.into(),
            details,
        }
    }

    /// Keeps the reason why a simulation could not begin. A directory that holds anything of an
    /// earlier process is left alone: what is wrong with it can be seen there only.
    fn record_failed_start(&self, error: &anyhow::Error) {
        if matches!(read_record(&self.directory), Ok(None)) && !self.path(CHECKPOINT).exists() {
            let details = serde_json::json!({ "replica": self.replica, "medium": self.interaction, "sweeps_done": 0 });
            // The error is what counts, also where its record cannot be written.
            let _ = self
                .record(&format!("{error:#}"), details)
                .write(&self.directory);
        }
    }
}

/// A simulation with its open files.
struct Run<'a> {
    task: &'a ReplicaTask<'a>,
    simulation: Simulation,
    log: Log,
    trajectory: Option<Trajectory>,
    cluster_moves_logged: (u64, u64),
    saved: Instant,
}

impl<'a> Run<'a> {
    /// Continues from the checkpoint, or starts anew.
    fn open(task: &'a ReplicaTask<'a>) -> Result<Self> {
        let system = task.engine.system()?;
        let settings = task.engine.settings(task.settings, &task.interaction)?;
        let model = task.engine.energy_model(task.settings, &task.interaction)?;
        let (simulation, log, frames, cluster_moves_logged) =
            match read_checkpoint::<RunCheckpoint>(&task.path(CHECKPOINT), KIND)? {
                Some(saved) => {
                    check_identity(&task.directory, &saved.identity, task.identity)?;
                    let simulation =
                        Simulation::resume_with_model(system, saved.simulation, model)?;
                    (
                        simulation,
                        saved.log,
                        saved.trajectory_frames,
                        saved.cluster_moves_logged,
                    )
                }
                None => {
                    let simulation = Simulation::with_model(
                        system,
                        settings,
                        model,
                        task.settings.seed,
                        task.stream(),
                    )?;
                    (simulation, LogMark::default(), 0, (0, 0))
                }
            };
        let log = Log::open(&task.path(LOG), &log)?;
        let trajectory = match task.settings.trajectory_every {
            0 => None,
            _ => Some(Trajectory::open(
                &task.path(TRAJECTORY),
                task.engine.assembly(),
                frames,
            )?),
        };
        Ok(Self {
            task,
            simulation,
            log,
            trajectory,
            cluster_moves_logged,
            saved: Instant::now(),
        })
    }

    /// Sweeps until done or interrupted, one row or frame at a time.
    fn advance(&mut self, execution: &Execution, advanced: &dyn Fn(u64)) -> Result<Outcome> {
        let settings = self.task.settings;
        let mut reported = self.simulation.sweep();
        while self.simulation.sweep() < settings.total_sweeps() {
            let mut until_asked = |_: &Simulation| match execution.interrupt.is_requested() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            let outcome = self.simulation.run_until(
                settings.next_stop(self.simulation.sweep()),
                &mut until_asked,
            )?;
            let sweep = self.simulation.sweep();
            self.write_outputs(sweep)?;
            advanced(sweep - reported);
            reported = sweep;
            if outcome == Outcome::Stopped {
                return Ok(Outcome::Stopped);
            }
            if self.saved.elapsed() >= execution.checkpoint_interval {
                self.save()?;
            }
        }
        Ok(Outcome::Finished)
    }

    /// The row and the frame that are due at this sweep. Equilibration leaves neither.
    fn write_outputs(&mut self, sweep: u64) -> Result<()> {
        let settings = self.task.settings;
        let Some(production) = sweep
            .checked_sub(settings.equilibration_sweeps)
            .filter(|sweep| *sweep > 0)
        else {
            self.cluster_moves_logged = (0, 0);
            return Ok(());
        };
        if production.is_multiple_of(settings.log_every) {
            let row = self.row(production);
            self.log.append(&row)?;
        }
        if let Some(trajectory) = &mut self.trajectory
            && production.is_multiple_of(settings.trajectory_every)
        {
            trajectory.append(production, &self.simulation)?;
        }
        Ok(())
    }

    fn row(&mut self, production: u64) -> LogRow {
        let observables = self.simulation.observables();
        let statistics = self.simulation.statistics();
        let counted = (statistics.cluster_moves, statistics.cluster_bodies);
        let (moves, bodies) = (
            counted.0 - self.cluster_moves_logged.0,
            counted.1 - self.cluster_moves_logged.1,
        );
        self.cluster_moves_logged = counted;
        LogRow {
            sweep: production,
            r_g_angstrom: observables.r_g_angstrom,
            native_contacts: observables.native_contacts.unwrap_or(f64::NAN),
            largest_cluster: observables.largest_cluster,
            energy_kt: observables.energy_kt,
            cluster_moved: if moves == 0 {
                0.0
            } else {
                bodies as f64 / moves as f64
            },
        }
    }

    /// What the record says besides how it ended.
    fn details(&self) -> serde_json::Value {
        let simulation = &self.simulation;
        serde_json::json!({
            "replica": self.task.replica,
            "medium": self.task.interaction,
            "sweeps_done": simulation.sweep(),
            "acceptance": acceptance(simulation.statistics()),
            "step_sizes": simulation.step_sizes(),
            "statistics": simulation.statistics(),
            "native_contacts": simulation.native_contacts(),
        })
    }

    /// Everything on the disk, the checkpoint last: it vouches for the rest.
    fn save(&mut self) -> Result<()> {
        let log = self.log.sync()?;
        let trajectory_frames = match &mut self.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        let checkpoint = RunCheckpoint {
            identity: self.task.identity.into(),
            log,
            trajectory_frames,
            cluster_moves_logged: self.cluster_moves_logged,
            simulation: self.simulation.checkpoint(),
        };
        write_checkpoint(&self.task.path(CHECKPOINT), KIND, &checkpoint)?;
        self.saved = Instant::now();
        Ok(())
    }
}

fn acceptance(statistics: &Statistics) -> ReplicaCounts {
    let fraction = |counts: &[protomer_mc::moves::Acceptance]| {
        let (accepted, tried) = counts
            .iter()
            .fold((0, 0), |(a, t), c| (a + c.accepted, t + c.trials));
        if tried == 0 {
            0.0
        } else {
            accepted as f64 / tried as f64
        }
    };
    ReplicaCounts {
        translation_acceptance: fraction(&statistics.translation),
        rotation_acceptance: fraction(&statistics.rotation),
    }
}
