//! One run in its directory: start or continue, log, keep the trajectory, stop when asked.
//!
//! ```text
//! DIR/run.toml  run.json  log.csv  trajectory.gsd  checkpoint.bin
//! ```

use super::directory::{enter, identity, record};
use super::log::{LogRow, columns};
use super::settings::LatticeSettings;
use super::start::{Begun, begin, time_step};
use super::trajectory::Trajectory;
use crate::run::{
    Execution, LATTICE_RUN, Log, LogMark, RunRecord, check_log, read_checkpoint, read_record,
    write_checkpoint,
};
use anyhow::{Context, Result, bail};
use protomer_crystal::lattice::{Mover, State};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

const CHECKPOINT: &str = "checkpoint.bin";
const LOG: &str = "log.csv";
const TRAJECTORY: &str = "trajectory.gsd";
/// Everything that a run writes beside its settings.
pub const RESULTS: [&str; 7] = [
    "run.json",
    LOG,
    TRAJECTORY,
    CHECKPOINT,
    "trajectory.gsd.partial",
    "lyapunov.json",
    "report.html",
];
/// What the container says it holds.
const KIND: &str = "lattice checkpoint";

/// A point from which a run goes on bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Checkpoint {
    identity: String,
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// Frames of the trajectory that belong to this state.
    frames: u64,
    progress: Progress,
    state: State,
    /// Positions at the last row of the log.
    logged: Vec<f64>,
}

/// How far a run is, and the worst of what it met.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Progress {
    steps: u64,
    events: u64,
    largest_rod_violation: f64,
    largest_energy_error: f64,
    first_energy: f64,
}

/// What a run comes to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatticeResult {
    /// Squares.
    pub squares: usize,
    /// Rods.
    pub rods: usize,
    /// Steps done.
    pub steps: u64,
    /// Time reached.
    pub time: f64,
    /// Time step.
    pub time_step: f64,
    /// Standard deviation of the angles about the coherent state at the start: less than was asked
    /// for where rods are short.
    pub start_angle_spread: f64,
    /// Random starts that were discarded because squares overlapped.
    #[serde(default)]
    pub discarded_starts: u32,
    /// Collisions.
    pub events: u64,
    /// Energy at the start.
    pub start_energy: f64,
    /// Energy at the end.
    pub energy: f64,
    /// Largest deviation of the energy from that of the start in the log, in parts of it; it says
    /// nothing of a run with a heat bath, friction or inelastic collisions.
    pub energy_error: f64,
    /// Largest deviation of a rod from its length in the log.
    pub max_rod_violation: f64,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub enum LatticeEnd {
    /// All steps are done.
    Finished(LatticeResult),
    /// It was asked to stop and can go on.
    Stopped,
}

/// Runs or continues a lattice in a directory. `advanced` hears how many steps were done.
///
/// # Errors
/// For settings or a start that make no sense, a directory that holds another run, a disk that
/// takes no more, and a step that failed: the last good state is then in the checkpoint, and
/// `run.json` says what happened.
pub fn run_lattice(
    settings: &LatticeSettings,
    path: &Path,
    execution: &Execution,
    advanced: &dyn Fn(u64),
) -> Result<LatticeEnd> {
    if settings.sweep.is_some() {
        bail!("the settings have a [sweep]; use 'protomer lattice sweep', or leave it out");
    }
    let begun = begin(settings)?;
    let identity = identity(settings)?;
    // Before the directory is touched: a start that makes no sense leaves nothing behind.
    let time_step = time_step(settings, &begun)?;
    let mover = Mover::new(
        &settings.motion()?,
        Arc::new(begun.network.clone()),
        &begun.state,
    )?;
    let _mine = enter(path, settings, LATTICE_RUN, &RESULTS, execution.start_anew)?;
    let total = settings.total_steps(time_step);
    if let Some(result) = finished(path, &identity, total)? {
        advanced(total);
        return Ok(LatticeEnd::Finished(result));
    }
    let mut run = Run::open(settings, path, identity, begun, mover, time_step)?;
    advanced(run.progress.steps);
    let outcome = run.advance(total, execution, advanced);
    let saved = run.save();
    let (record, end) = match (outcome, saved) {
        (Ok(true), Ok(())) => (run.record("done")?, Ok(LatticeEnd::Finished(run.result()))),
        (Ok(false), Ok(())) => (
            run.record("stopped")?.stopped_by(&execution.interrupt),
            Ok(LatticeEnd::Stopped),
        ),
        (Err(error), Ok(())) => {
            let context = format!(
                "step {} (the last good state, t = {}, is kept in {})",
                run.progress.steps + 1,
                run.state.time,
                path.join(CHECKPOINT).display()
            );
            (
                run.record(&format!("{error:#}"))?,
                Err(error.context(context)),
            )
        }
        (Ok(_), Err(error)) | (Err(error), Err(_)) => {
            (run.record(&format!("{error:#}"))?, Err(error))
        }
    };
    let written = record.write(path);
    // An error of the run is what counts; on a full disk there may be no room for the record
    // either.
    end.and_then(|end| written.map(|()| end))
}

/// The result of a run that is done already.
fn finished(path: &Path, identity: &str, total: u64) -> Result<Option<LatticeResult>> {
    let Some(present) = read_record(path)? else {
        return Ok(None);
    };
    if present.identity != identity {
        bail!(
            "{} holds another run; choose another directory, or start anew with --force",
            path.display()
        );
    }
    if present.exit_reason != "done" {
        return Ok(None);
    }
    let result: LatticeResult = serde_json::from_value(present.details)
        .with_context(|| format!("run.json in {}", path.display()))?;
    if result.steps > total {
        bail!(
            "{} is at step {}, which is more than {total}; ask for at least as many, or choose another directory",
            path.display(),
            result.steps
        );
    }
    if let Some(saved) = read_checkpoint::<Checkpoint>(&path.join(CHECKPOINT), KIND)? {
        check_log(&path.join(LOG), &saved.log)?;
    }
    Ok((result.steps == total).then_some(result))
}

/// A run with its open files.
struct Run<'a> {
    settings: &'a LatticeSettings,
    path: PathBuf,
    identity: String,
    mover: Mover,
    /// The first state, which strains are measured from.
    start: State,
    start_angle_spread: f64,
    discarded_starts: u32,
    state: State,
    /// Positions at the last row of the log.
    logged: Vec<f64>,
    time_step: f64,
    progress: Progress,
    log: Log,
    trajectory: Option<Trajectory>,
    saved: Instant,
}

impl<'a> Run<'a> {
    /// Continues from the checkpoint, or starts anew.
    fn open(
        settings: &'a LatticeSettings,
        path: &Path,
        identity: String,
        begun: Begun,
        mut mover: Mover,
        time_step: f64,
    ) -> Result<Self> {
        let network = mover.network().clone();
        let first_energy = mover.energy(&begun.state);
        let new = Progress {
            steps: 0,
            events: 0,
            largest_rod_violation: 0.0,
            largest_energy_error: 0.0,
            first_energy,
        };
        let mut state = begun.state.clone();
        let mut logged = state.positions.clone();
        let (mut mark, mut frames, mut progress) = (LogMark::default(), 0, new);
        let saved = read_checkpoint::<Checkpoint>(&path.join(CHECKPOINT), KIND)?;
        let is_new = saved.is_none();
        if let Some(saved) = saved {
            if saved.identity != identity {
                bail!(
                    "{} holds another run; choose another directory, or start anew with --force",
                    path.display()
                );
            }
            (mark, frames, progress) = (saved.log, saved.frames, saved.progress);
            (state, logged) = (saved.state, saved.logged);
            mover.resume(&state, progress.events)?;
        }
        let log = Log::open_with_columns(&path.join(LOG), &columns(), &mark)?;
        let trajectory = match settings.trajectory_every {
            0 => None,
            _ => Some(Trajectory::open(&path.join(TRAJECTORY), &network, frames)?),
        };
        let mut run = Self {
            settings,
            path: path.to_owned(),
            identity,
            mover,
            start: begun.state,
            start_angle_spread: begun.angle_spread,
            discarded_starts: begun.discarded_draws,
            state,
            logged,
            time_step,
            progress,
            log,
            trajectory,
            saved: Instant::now(),
        };
        if is_new {
            run.write_outputs()?;
        }
        Ok(run)
    }

    /// Steps until done (true) or interrupted (false).
    fn advance(
        &mut self,
        total: u64,
        execution: &Execution,
        advanced: &dyn Fn(u64),
    ) -> Result<bool> {
        while self.progress.steps < total {
            if execution.interrupt.is_requested() {
                return Ok(false);
            }
            self.mover
                .step(&mut self.state, self.time_step, self.progress.steps)?;
            self.progress.steps += 1;
            self.progress.events = self.mover.events();
            // Not by adding up, which would drift off round times.
            self.state.time = self.progress.steps as f64 * self.time_step;
            self.write_outputs()?;
            advanced(1);
            if self.saved.elapsed() >= execution.checkpoint_interval {
                self.save()?;
            }
        }
        Ok(true)
    }

    /// The row and the frame that are due at this step.
    fn write_outputs(&mut self) -> Result<()> {
        let step = self.progress.steps;
        if step.is_multiple_of(self.settings.log_every) {
            let row = LogRow::new(
                step,
                &mut self.mover,
                &self.state,
                &self.start.positions,
                &self.logged,
            );
            let scale = self.progress.first_energy.abs();
            let error = (row.energy - self.progress.first_energy).abs()
                / if scale > 0.0 { scale } else { 1.0 };
            self.progress.largest_energy_error = self.progress.largest_energy_error.max(error);
            self.progress.largest_rod_violation =
                self.progress.largest_rod_violation.max(row.rod_violation);
            self.log.write_line(&row.to_line())?;
            self.logged.copy_from_slice(&self.state.positions);
        }
        if let Some(trajectory) = &mut self.trajectory
            && step.is_multiple_of(self.settings.trajectory_every)
        {
            let energy = self.mover.energy(&self.state);
            trajectory.append(step, self.mover.network(), &self.state, energy)?;
        }
        Ok(())
    }

    /// Everything on the disk, the checkpoint last: it vouches for the rest.
    fn save(&mut self) -> Result<()> {
        let log = self.log.sync()?;
        let frames = match &mut self.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        let checkpoint = Checkpoint {
            identity: self.identity.clone(),
            log,
            frames,
            progress: self.progress,
            state: self.state.clone(),
            logged: self.logged.clone(),
        };
        write_checkpoint(&self.path.join(CHECKPOINT), KIND, &checkpoint)?;
        self.saved = Instant::now();
        Ok(())
    }

    fn record(&mut self, exit_reason: &str) -> Result<RunRecord> {
        let details = serde_json::to_value(self.result()).context("run.json")?;
        Ok(record("lattice run", &self.identity, exit_reason, details))
    }

    fn result(&mut self) -> LatticeResult {
        let energy = self.mover.energy(&self.state);
        let network = self.mover.network();
        LatticeResult {
            squares: network.squares.len(),
            rods: network.rods.len(),
            steps: self.progress.steps,
            time: self.state.time,
            time_step: self.time_step,
            start_angle_spread: self.start_angle_spread,
            discarded_starts: self.discarded_starts,
            events: self.progress.events,
            start_energy: self.progress.first_energy,
            energy,
            energy_error: self.progress.largest_energy_error,
            max_rod_violation: self.progress.largest_rod_violation,
        }
    }
}
