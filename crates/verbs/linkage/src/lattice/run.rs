//! One lattice run in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  trajectory.gsd  checkpoint.bin
//! ```
//!
//! With the automatic time step a run keeps its energy to [`LARGEST_ENERGY_ERROR`], or says that it
//! does not. A run that loses more, or whose rods cannot be kept, begins again with every step taken
//! in twice as many parts. What it wrote before is overwritten, so the files do not depend on where
//! it was stopped, and rows and frames stay at the same times.

use super::log::LogRow;
use super::settings::{LatticeSettings, TimeStep};
use super::start::{Begun, begin_unless, is_stopped, time_step};
use super::trajectory::{frame, open_trajectory};
use anyhow::{Context, Error, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::settings::is_default;
use protomer_io::gsd::FrameWriter;
use protomer_linkage::CrystalError;
use protomer_linkage::lattice::angle_potential::openings;
use protomer_linkage::lattice::paper::PaperStatistics;
use protomer_linkage::lattice::{Mover, State};
use protomer_results::checkpoint::{self, require_lengths};
use protomer_results::{
    CHECKPOINT, End, Execution, Interrupt, Layout, Log, LogMark, Record, ResultKind,
    ResultsDirectory, Run, Turn, Work, drive, log, settings,
};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest relative deviation of the energy that the automatic time step allows in a run that
/// conserves it.
pub const LARGEST_ENERGY_ERROR: f64 = 1e-3;
/// Largest number of parts in which an automatic step is taken.
const MOST_SUB_STEPS: u32 = 64;

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
    /// Number of squares.
    pub squares: usize,
    /// Number of rods.
    pub rods: usize,
    /// Number of steps done.
    pub steps: u64,
    /// Time reached.
    pub time: f64,
    /// Time step, in which rows and frames are counted.
    pub time_step: f64,
    /// Number of equal parts in which every step was taken to keep the energy; 1 for a step that
    /// was given.
    #[serde(default = "one")]
    pub sub_steps: u32,
    /// Standard deviation of the angles about the coherent state at the start: less than
    /// requested where rods are short.
    pub start_angle_spread: f64,
    /// Number of random starts that were discarded because squares overlapped.
    #[serde(default)]
    pub discarded_starts: u32,
    /// Number of collisions.
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
    /// Rows of the log in which an angle was beyond the points of its tabulated potential.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rows_beyond_table: u64,
    /// Statistics of the paper's protocol, where it is followed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<PaperStatistics>,
}

fn one() -> u32 {
    1
}

impl Answer for LatticeResult {
    fn text(&self) -> String {
        let mut line = format!(
            "t = {}: energy {:.6} (at most {:.1e} off), rods off by at most {:.1e}, {} collisions",
            self.time, self.energy, self.energy_error, self.max_rod_violation, self.events
        );
        if let Some(paper) = &self.paper {
            line += &format!(
                "\npaper's protocol: {} steps end with overlaps (deepest {:.1e}), {} of {} impulses pull, {} collisions \
                 unsolved, rods of the ansatz off by at most {:.1e} (its equations by {:.1e})",
                paper.steps_with_overlap,
                paper.deepest_overlap,
                paper.pulling_impulses,
                paper.contacts,
                paper.unsolved_collisions,
                paper.largest_ansatz_rod_error,
                paper.largest_ansatz_residual
            );
        }
        line
    }
}

impl LatticeResult {
    /// The length of the steps taken.
    pub fn shortest_step(&self) -> f64 {
        self.time_step / f64::from(self.sub_steps)
    }

    /// The warning of a run that left the points of a tabulated potential.
    pub fn table_warning(&self) -> Option<String> {
        (self.rows_beyond_table > 0).then(|| {
            format!(
                "an angle was beyond the points of its tabulated potential in {} rows of the log; the potential goes on as a \
                 straight line there: give a wider table",
                self.rows_beyond_table
            )
        })
    }

    /// The warning of a run that should have conserved its energy and did not.
    pub fn energy_warning(&self, settings: &LatticeSettings) -> Option<String> {
        let is_kept = self.energy_error <= LARGEST_ENERGY_ERROR;
        if is_kept || !settings.conserves_energy() {
            return None;
        }
        Some(format!(
            "the energy is off by up to {:.1e} of its first value, more than {LARGEST_ENERGY_ERROR}, with steps of {}; \
             give a smaller --dt",
            self.energy_error,
            self.shortest_step()
        ))
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
/// use protomer_linkage_verbs::lattice::{run::run_lattice, settings::LatticeSettings};
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
    let run = match LatticeRun::new(settings, &execution.interrupt) {
        Err(error) if is_stopped(&error) => return Ok(End::Stopped),
        run => run?,
    };
    let _ours = ResultsDirectory::enter(path, &LAYOUT, settings, &run.identity, execution)?;
    let mut total = run.length();
    loop {
        execution.progress.begin(total, "steps");
        match drive(&run, path, execution) {
            Err(error) => match error.downcast::<StepTooLong>() {
                // The checkpoint now holds the start, with more parts per step.
                Ok(too_long) if too_long.sub_steps < MOST_SUB_STEPS => {
                    execution.progress.describe(&too_long.to_string());
                    total += too_long.wasted_steps;
                }
                Ok(too_long) => return Err(too_long.into()),
                Err(error) => return Err(error),
            },
            end => return end,
        }
    }
}

/// The end of a pass whose automatic step was too long.
#[derive(Debug)]
struct StepTooLong {
    time_step: f64,
    sub_steps: u32,
    reason: String,
    /// Number of steps of the pass.
    wasted_steps: u64,
}

impl fmt::Display for StepTooLong {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let now = self.time_step / f64::from(self.sub_steps);
        write!(
            formatter,
            "steps of {now} are too long ({}): beginning again with steps of {}",
            self.reason,
            0.5 * now
        )
    }
}

impl std::error::Error for StepTooLong {}

/// The last state of the run in a directory.
///
/// # Errors
/// If there is no run, or it has not begun.
pub(super) fn saved_state(directory: &Path) -> Result<State> {
    ResultKind::LatticeRun.expect_in(directory)?;
    let identity = Record::read(directory)?.map(|record| record.identity);
    let path = directory.join(CHECKPOINT);
    let kind = LatticeRun::CHECKPOINT_KIND;
    let saved: Option<Saved> = checkpoint::read(&path, kind, &identity.unwrap_or_default())?;
    let saved = saved.with_context(|| {
        format!(
            "{} has no checkpoint yet; give a run that has begun, or a GSD file",
            directory.display()
        )
    })?;
    Ok(saved.state)
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
    trajectory: Option<FrameWriter>,
    /// Whether every output due at this state has been written.
    is_complete: bool,
    /// Number of parts in which every step is taken.
    sub_steps: u32,
    /// The state before the step.
    previous_state: State,
    /// Whether the run must begin again with more parts.
    begins_again: bool,
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
    /// Rows in which an angle was beyond the points of its potential.
    #[serde(default)]
    rows_beyond_table: u64,
}

/// A state from which a run continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// Number of frames of the trajectory that belong to this state.
    frames: u64,
    progress: Progress,
    state: State,
    /// Positions at the last row of the log.
    logged: Vec<f64>,
    /// Number of parts in which every step is taken.
    #[serde(default = "one")]
    sub_steps: u32,
    /// Statistics of the paper's protocol so far.
    #[serde(default)]
    paper: Option<PaperStatistics>,
}

impl<'a> LatticeRun<'a> {
    fn new(settings: &'a LatticeSettings, interrupt: &Interrupt) -> Result<Self> {
        let begun = begin_unless(settings, &|| interrupt.is_requested())?;
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

    /// The saved state at the start of a pass with so many parts per step, before any output.
    fn saved_at_start(&self, mover: &mut Mover, sub_steps: u32) -> Saved {
        Saved {
            log: LogMark::default(),
            frames: 0,
            progress: Progress::at_start(mover.energy(&self.begun.state)),
            state: self.begun.state.clone(),
            logged: self.begun.state.positions.clone(),
            sub_steps,
            paper: None,
        }
    }

    /// Takes one step in its parts; a step that fails leaves the state as it was.
    fn step(&self, open: &mut Open) -> Result<(), CrystalError> {
        let Open {
            mover,
            state,
            progress,
            sub_steps,
            previous_state,
            ..
        } = open;
        let parts = u64::from(*sub_steps);
        let part = self.time_step / parts as f64;
        previous_state.clone_from(state);
        for number in progress.steps * parts..(progress.steps + 1) * parts {
            if let Err(error) = mover.step(state, part, number) {
                state.clone_from(previous_state);
                return Err(error);
            }
        }
        Ok(())
    }

    /// Error of the energy, relative to the first one or to the present kinetic energy, whichever
    /// is larger: the first one may be near zero where charges attract each other.
    fn energy_error(&self, open: &mut Open) -> f64 {
        let first = open.progress.first_energy;
        let kinetic = open.state.kinetic_energy(open.mover.network());
        relative_change(
            open.mover.energy(&open.state),
            first,
            first.abs().max(kinetic),
        )
    }

    /// Whether a shorter step may be tried: the step must be automatic.
    fn can_take_more_parts(&self, open: &Open) -> bool {
        matches!(self.settings.time_step, TimeStep::Named(_)) && open.sub_steps < MOST_SUB_STEPS
    }

    fn begin_again(&self, open: &mut Open, reason: String) -> Error {
        open.begins_again = true;
        StepTooLong {
            time_step: self.time_step,
            sub_steps: open.sub_steps,
            reason,
            wasted_steps: open.progress.steps,
        }
        .into()
    }

    /// Whether an angle is beyond the points of its tabulated potential.
    fn is_beyond_table(&self, open: &Open, row: &LogRow) -> Result<bool> {
        let LatticeSettings {
            angle_potential,
            opening_potential,
            ..
        } = self.settings;
        if let Some(table) = angle_potential {
            let openings = openings(open.mover.network(), &open.state.positions)?;
            if openings
                .into_iter()
                .any(|opening| table.ends_before(opening))
            {
                return Ok(true);
            }
        }
        Ok(opening_potential
            .as_ref()
            .is_some_and(|table| table.ends_before(row.checkerboard)))
    }

    /// Writes the row and the frame due at this step.
    fn write_outputs(&self, open: &mut Open) -> Result<()> {
        let step = open.progress.steps;
        open.is_complete = false;
        if step.is_multiple_of(self.settings.log_every) {
            let start = &self.begun.state.positions;
            let row = LogRow::new(step, &mut open.mover, &open.state, start, &open.logged);
            open.progress.note(&row);
            if self.is_beyond_table(open, &row)? {
                open.progress.rows_beyond_table += 1;
            }
            open.log.append(&row)?;
            open.logged.copy_from_slice(&open.state.positions);
        }
        if let Some(trajectory) = &mut open.trajectory
            && step.is_multiple_of(self.settings.trajectory_every)
        {
            let energy = open.mover.energy(&open.state);
            trajectory.append(frame(step, open.mover.network(), &open.state, energy))?;
        }
        open.is_complete = true;
        Ok(())
    }
}

/// Difference of two energies over a scale; zero if they are equal, even without a scale, and NaN if
/// one of them is.
fn relative_change(energy: f64, first: f64, scale: f64) -> f64 {
    let change = (energy - first).abs();
    // NaN is not above zero, so "above zero" would take it for no change.
    if change == 0.0 { 0.0 } else { change / scale }
}

impl Progress {
    fn at_start(first_energy: f64) -> Self {
        Self {
            steps: 0,
            events: 0,
            largest_rod_violation: 0.0,
            largest_energy_error: 0.0,
            first_energy,
            rows_beyond_table: 0,
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
        Work::new(
            ResultKind::LatticeRun,
            "lattice run",
            &self.identity,
            &self.begun.input_sha256,
        )
    }

    fn length(&self) -> u64 {
        self.settings.total_steps(self.time_step)
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open> {
        let mut mover = self.mover()?;
        let saved = match saved {
            Some(saved) => {
                let coordinates = self.begun.state.positions.len();
                require_lengths(&[
                    ("positions", saved.state.positions.len(), coordinates),
                    ("velocities", saved.state.velocities.len(), coordinates),
                    ("logged positions", saved.logged.len(), coordinates),
                ])?;
                mover.resume(&saved.state, saved.progress.events, saved.paper)?;
                saved
            }
            None => self.saved_at_start(&mut mover, 1),
        };
        // The first row belongs to every state but the one before any output.
        let is_new = saved.log == LogMark::default();
        let log = Log::open::<LogRow>(&directory.join(LOG), &saved.log)?;
        let trajectory = match self.settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                Some(open_trajectory(&path, &self.begun.network, saved.frames)?)
            }
        };
        let mut open = Open {
            path: directory.to_owned(),
            mover,
            previous_state: saved.state.clone(),
            state: saved.state,
            sub_steps: saved.sub_steps,
            begins_again: false,
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
        if let Err(error) = self.step(open) {
            let would_help = matches!(
                error,
                CrystalError::StepTooLarge { .. } | CrystalError::Overlap { .. }
            );
            if would_help && self.can_take_more_parts(open) {
                return Err(self.begin_again(open, error.to_string()));
            }
            let (failed, time) = (open.progress.steps + 1, open.state.time);
            let checkpoint = open.path.join(CHECKPOINT);
            return Err(Error::new(error).context(format!(
                "step {failed} (the last good state, t = {time}, is kept in {})",
                checkpoint.display()
            )));
        }
        let error = self.energy_error(open);
        let is_lost = error > LARGEST_ENERGY_ERROR && self.settings.conserves_energy();
        if (is_lost || error.is_nan()) && self.can_take_more_parts(open) {
            let time = open.state.time;
            let reason = format!("at t = {time:.4} the energy is off by {error:.1e}");
            return Err(self.begin_again(open, reason));
        }
        if error.is_nan() {
            return Err(Error::new(CrystalError::BadState(format!(
                "the energy at t = {} is not a number: charges of two squares meet, or the time step is far too long; \
                 give a smaller --dt, or move charges away from the sides",
                open.state.time
            ))));
        }
        open.progress.steps += 1;
        open.progress.events = open.mover.events();
        // Multiplied, not accumulated: sums would drift away from round times.
        open.state.time = open.progress.steps as f64 * self.time_step;
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
            sub_steps: open.sub_steps,
            paper: open.mover.paper_statistics(),
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
            sub_steps: open.sub_steps,
            start_angle_spread: self.begun.angle_spread,
            discarded_starts: self.begun.discarded_draws,
            events: open.progress.events,
            start_energy: open.progress.first_energy,
            energy,
            energy_error: open.progress.largest_energy_error,
            max_rod_violation: open.progress.largest_rod_violation,
            rows_beyond_table: open.progress.rows_beyond_table,
            paper: open.mover.paper_statistics(),
        })
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }

    /// The state to save after an error. A step that fails leaves the state unchanged; a run that
    /// must begin again continues from its start.
    fn rescue(&self, open: &mut Open) -> Option<Saved> {
        if open.begins_again {
            let mut mover = self.mover().ok()?;
            return Some(self.saved_at_start(&mut mover, 2 * open.sub_steps));
        }
        open.is_complete.then(|| self.save(open).ok()).flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_energy_that_is_no_number_is_no_small_error() {
        assert!(relative_change(f64::NAN, 1.0, 1.0).is_nan());
        assert_eq!(relative_change(1.5, 1.0, 2.0), 0.25);
        assert_eq!(relative_change(0.0, 0.0, 0.0), 0.0);
    }
}
