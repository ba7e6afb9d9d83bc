//! One lattice run in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  trajectory.gsd  checkpoint.bin
//! ```

use super::log::LogRow;
use super::settings::LatticeSettings;
use super::start::{Begun, begin, time_step};
use super::trajectory::Trajectory;
use anyhow::{Error, Result, bail};
use protomer_common::answer::Answer;
use protomer_crystal::lattice::{Mover, State};
use protomer_results::{
    CHECKPOINT, End, Execution, Layout, Log, LogMark, ResultKind, ResultsDirectory, Run, Turn,
    Work, drive, log, settings,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const LOG: &str = "log.csv";
const TRAJECTORY: &str = "trajectory.gsd";

/// The directory of a run.
const LAYOUT: Layout = Layout {
    kind: ResultKind::LatticeRun,
    settings: super::directory::SETTINGS,
    results: &[
        "run.json",
        LOG,
        TRAJECTORY,
        CHECKPOINT,
        "trajectory.gsd.partial",
        "lyapunov.json",
        "report.html",
    ],
    is_result: |_| false,
};

/// The result of a run.
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
    /// Standard deviation of the angles about the coherent state at the start: less than
    /// requested where rods are short.
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
    /// Largest relative deviation of the energy from its initial value in the log; meaningless
    /// for a run with a heat bath, friction or inelastic collisions.
    pub energy_error: f64,
    /// Largest deviation of a rod from its length in the log.
    pub max_rod_violation: f64,
}

impl Answer for LatticeResult {
    fn text(&self) -> String {
        format!(
            "t = {}: energy {:.6} (at most {:.1e} off), rods off by at most {:.1e}, {} collisions",
            self.time, self.energy, self.energy_error, self.max_rod_violation, self.events
        )
    }
}

/// Runs or continues a lattice in a directory.
///
/// # Errors
/// For invalid settings or an impossible start, a directory that holds other work, a file that
/// cannot be written, and a step that failed: the last good state is then in the checkpoint, and
/// `run.json` records the error.
///
/// ```
/// use protomer_lattices::lattice::{run::run_lattice, settings::LatticeSettings};
/// use protomer_results::Execution;
/// let settings = LatticeSettings { rows: 4, columns: 4, time: 0.1, ..LatticeSettings::default() };
/// # let folder = tempfile::tempdir()?;
/// let directory = folder.path().join("run");
/// let end = run_lattice(&settings, &directory, &Execution::default())?;
/// let result = end.finished().unwrap();
/// assert_eq!(result.squares, 16);
/// assert!(result.energy_error < 1e-3);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_lattice(
    settings: &LatticeSettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<LatticeResult>> {
    if settings.sweep.is_some() {
        bail!("the settings have a [sweep]; use 'protomer lattice sweep', or remove it");
    }
    // Checked before the directory is touched: an impossible start leaves nothing behind.
    let run = LatticeRun::new(settings)?;
    let _ours = ResultsDirectory::enter(path, &LAYOUT, settings, &run.identity, execution)?;
    execution.progress.begin(run.length(), "steps");
    drive(&run, path, execution)
}

/// A run whose settings have been checked.
struct LatticeRun<'a> {
    settings: &'a LatticeSettings,
    identity: String,
    begun: Begun,
    time_step: f64,
}

/// A run with its open files.
struct Open {
    path: PathBuf,
    mover: Mover,
    state: State,
    /// Positions at the last row of the log.
    logged: Vec<f64>,
    progress: Progress,
    log: Log,
    trajectory: Option<Trajectory>,
    /// Whether every output due at this state has been written.
    is_complete: bool,
}

/// Progress of a run, and the largest deviations so far.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Progress {
    steps: u64,
    events: u64,
    largest_rod_violation: f64,
    largest_energy_error: f64,
    first_energy: f64,
}

/// A state from which a run continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// Frames of the trajectory that belong to this state.
    frames: u64,
    progress: Progress,
    state: State,
    /// Positions at the last row of the log.
    logged: Vec<f64>,
}

impl<'a> LatticeRun<'a> {
    fn new(settings: &'a LatticeSettings) -> Result<Self> {
        let begun = begin(settings)?;
        let time_step = time_step(settings, &begun)?;
        let run = Self {
            settings,
            identity: settings::identity(settings, "")?,
            begun,
            time_step,
        };
        run.mover()?;
        Ok(run)
    }

    /// An engine at the initial state.
    fn mover(&self) -> Result<Mover> {
        let network = Arc::new(self.begun.network.clone());
        Ok(Mover::new(
            &self.settings.motion()?,
            network,
            &self.begun.state,
        )?)
    }

    /// Writes the row and the frame due at this step.
    fn write_outputs(&self, open: &mut Open) -> Result<()> {
        let step = open.progress.steps;
        open.is_complete = false;
        if step.is_multiple_of(self.settings.log_every) {
            let start = &self.begun.state.positions;
            let row = LogRow::new(step, &mut open.mover, &open.state, start, &open.logged);
            open.progress.note(&row);
            open.log.append(&row)?;
            open.logged.copy_from_slice(&open.state.positions);
        }
        if let Some(trajectory) = &mut open.trajectory
            && step.is_multiple_of(self.settings.trajectory_every)
        {
            let energy = open.mover.energy(&open.state);
            trajectory.append(step, open.mover.network(), &open.state, energy)?;
        }
        open.is_complete = true;
        Ok(())
    }
}

impl Progress {
    fn at_start(first_energy: f64) -> Self {
        Self {
            steps: 0,
            events: 0,
            largest_rod_violation: 0.0,
            largest_energy_error: 0.0,
            first_energy,
        }
    }

    /// Updates the largest deviations with those of a row.
    fn note(&mut self, row: &LogRow) {
        let change = (row.energy - self.first_energy).abs();
        let scale = self.first_energy.abs();
        let error = if scale > 0.0 { change / scale } else { change };
        self.largest_energy_error = self.largest_energy_error.max(error);
        self.largest_rod_violation = self.largest_rod_violation.max(row.rod_violation);
    }
}

impl Run for LatticeRun<'_> {
    type State = Open;
    type Checkpoint = Saved;
    type Answer = LatticeResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = "lattice checkpoint";

    fn work(&self) -> Work {
        Work {
            kind: ResultKind::LatticeRun,
            verb: "lattice run",
            identity: self.identity.clone(),
            input_sha256: String::new(),
        }
    }

    fn length(&self) -> u64 {
        self.settings.total_steps(self.time_step)
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open> {
        let mut mover = self.mover()?;
        let is_new = saved.is_none();
        let saved = match saved {
            Some(saved) => {
                mover.resume(&saved.state, saved.progress.events)?;
                saved
            }
            None => Saved {
                log: LogMark::default(),
                frames: 0,
                progress: Progress::at_start(mover.energy(&self.begun.state)),
                state: self.begun.state.clone(),
                logged: self.begun.state.positions.clone(),
            },
        };
        let log = Log::open::<LogRow>(&directory.join(LOG), &saved.log)?;
        let trajectory = match self.settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                Some(Trajectory::open(&path, &self.begun.network, saved.frames)?)
            }
        };
        let mut open = Open {
            path: directory.to_owned(),
            mover,
            state: saved.state,
            logged: saved.logged,
            progress: saved.progress,
            log,
            trajectory,
            is_complete: true,
        };
        if is_new {
            self.write_outputs(&mut open)?;
        }
        Ok(open)
    }

    fn done(&self, open: &Open) -> u64 {
        open.progress.steps
    }

    fn advance(&self, open: &mut Open, _turn: &Turn<'_>) -> Result<()> {
        let Open {
            state, progress, ..
        } = open;
        if let Err(error) = open.mover.step(state, self.time_step, progress.steps) {
            let (failed, time) = (progress.steps + 1, state.time);
            let checkpoint = open.path.join(CHECKPOINT);
            return Err(Error::new(error).context(format!(
                "step {failed} (the last good state, t = {time}, is kept in {})",
                checkpoint.display()
            )));
        }
        progress.steps += 1;
        progress.events = open.mover.events();
        // Multiplied, not accumulated: sums would drift away from round times.
        state.time = progress.steps as f64 * self.time_step;
        self.write_outputs(open)
    }

    fn save(&self, open: &mut Open) -> Result<Saved> {
        let frames = match &mut open.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        Ok(Saved {
            log: open.log.sync()?,
            frames,
            progress: open.progress,
            state: open.state.clone(),
            logged: open.logged.clone(),
        })
    }

    fn answer(&self, open: &mut Open, _directory: &Path) -> Result<LatticeResult> {
        let energy = open.mover.energy(&open.state);
        let network = open.mover.network();
        Ok(LatticeResult {
            squares: network.squares.len(),
            rods: network.rods.len(),
            steps: open.progress.steps,
            time: open.state.time,
            time_step: self.time_step,
            start_angle_spread: self.begun.angle_spread,
            discarded_starts: self.begun.discarded_draws,
            events: open.progress.events,
            start_energy: open.progress.first_energy,
            energy,
            energy_error: open.progress.largest_energy_error,
            max_rod_violation: open.progress.largest_rod_violation,
        })
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }

    /// A step that fails leaves the state unchanged.
    fn rescue(&self, open: &mut Open) -> Option<Saved> {
        open.is_complete.then(|| self.save(open).ok()).flatten()
    }
}
