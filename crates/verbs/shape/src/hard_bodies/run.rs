//! One run of hard bodies in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  trajectory.gsd  profile.csv  checkpoint.bin
//! ```

use super::equilibrium::{Equilibrium, Series};
use super::kinds::Shapes;
use super::log::LogRow;
use super::placed;
use super::result::{
    DepletantResult, HardBodyResult, MeanBox, WallsResult, mean_and_error,
    mean_and_error_following, tilt_factors,
};
use super::settings::{Freedom, HardBodySettings};
use super::start::{FLUID, cell_text, unit_cell};
use super::trajectory::{frame, open_trajectory};
use crate::given_state::is_state;
use anyhow::{Context, Error, Result};
use protomer_common::cpu_time::Stopwatch;
use protomer_common::output_file::write_once;
use protomer_hpmc::crystal::Crystal;
use protomer_hpmc::heights::Walls;
use protomer_hpmc::mixture::Mixture;
use protomer_hpmc::potential::Sum;
use protomer_hpmc::reservoir::ball_volume;
use protomer_hpmc::simulation::{self, Simulation, State};
use protomer_hpmc::start::Start;
use protomer_io::gsd::FrameWriter;
use protomer_results::checkpoint::require_lengths;
use protomer_results::keys::read_toml;
use protomer_results::{
    CHECKPOINT, End, Execution, Exit, Interrupt, Layout, Log, LogMark, Record, ResultKind,
    ResultsDirectory, Run, Turn, Work, checkpoint, drive, log, settings,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

const LOG: &str = log::FILE;
/// Name of the trajectory.
pub(super) const TRAJECTORY: &str = "trajectory.gsd";
const PROFILE: &str = "profile.csv";
const CHECKPOINT_KIND: &str = "hard bodies checkpoint";
/// Measurements between two looks at the clock. What makes a run fast is forgotten there, so that a run
/// goes on from a checkpoint as it would have.
const SAMPLES_AT_ONCE: u64 = 10;

/// The directory of a run.
const LAYOUT: Layout = Layout {
    kind: ResultKind::HardBodies,
    settings: "run.toml",
    results: &[
        "run.json",
        LOG,
        TRAJECTORY,
        PROFILE,
        CHECKPOINT,
        "trajectory.gsd.partial",
        "report.html",
    ],
    is_result: |_| false,
};

/// Runs or continues hard bodies in a directory.
///
/// # Errors
/// For invalid settings or a packing fraction that cannot be reached, a directory that holds other
/// work, and a file that cannot be written.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::{run::run_hard_bodies, settings::HardBodySettings};
/// use protomer_results::Execution;
/// let settings = HardBodySettings {
///     shape: "cube".into(),
///     bodies: 64,
///     packing_fraction: 0.1,
///     equilibration: 100,
///     sweeps: 200,
///     ..HardBodySettings::default()
/// };
/// # let folder = tempfile::tempdir()?;
/// let directory = folder.path().join("run");
/// let end = run_hard_bodies(&settings, &directory, &Execution::default())?;
/// assert!(end.finished().is_some_and(|result| result.compressibility_factor > 1.2));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_hard_bodies(
    settings: &HardBodySettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<HardBodyResult>> {
    settings.check()?;
    let shape = Shapes::read(settings)?;
    match shape.dimension() {
        1 => HardBodyRun::<1>::new(settings, &shape, &execution.interrupt)?.drive(path, execution),
        2 => HardBodyRun::<2>::new(settings, &shape, &execution.interrupt)?.drive(path, execution),
        _ => HardBodyRun::<3>::new(settings, &shape, &execution.interrupt)?.drive(path, execution),
    }
}

/// A run whose settings have been checked.
struct HardBodyRun<'a, const D: usize> {
    settings: &'a HardBodySettings,
    identity: String,
    input_sha256: String,
    mixture: Mixture<D>,
    start: Start<D>,
    engine: simulation::Settings,
    /// Request to stop, which also ends the compression of bodies.
    interrupt: Interrupt,
}

/// A run with its open files.
struct Open<const D: usize> {
    simulation: Simulation<D>,
    rows: Vec<LogRow>,
    log: Log,
    trajectory: Option<FrameWriter>,
    /// Processor time of the moves, and how many, in this process.
    watch: Stopwatch,
    trials: u64,
}

/// A state from which a run continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// Frames of the trajectory that belong to this state.
    frames: u64,
    state: State,
}

/// Bodies, their start and the settings of the engine, from settings that have been checked.
pub(super) struct Prepared<const D: usize> {
    pub(super) mixture: Mixture<D>,
    pub(super) start: Start<D>,
    pub(super) engine: simulation::Settings,
    input_sha256: String,
}

impl<const D: usize> Prepared<D> {
    pub(super) fn new(settings: &HardBodySettings, shape: &Shapes) -> Result<Self> {
        let kinds = shape.kinds::<D>(settings)?;
        // Refused before there is a directory.
        Sum::<D>::new(&settings.potential)?;
        let (start, mixture, input_sha256) = match is_state(&settings.start) {
            true => {
                let state = placed::placed(settings, &kinds)?;
                let sha256 = shape.sha256(Some(&state.sha256));
                let mixture = Mixture::new(kinds, state.kind_of)?;
                (Start::Placed(state.placed), mixture, sha256)
            }
            false => {
                let text = cell_text(&settings.start)?;
                let (start, mixture) = start(settings, shape, text.as_deref())?;
                (start, mixture, shape.sha256(text.as_deref()))
            }
        };
        Ok(Self {
            mixture,
            start,
            engine: engine(settings)?,
            input_sha256,
        })
    }
}

/// The settings of the engine.
pub(super) fn engine(settings: &HardBodySettings) -> Result<simulation::Settings> {
    let engine = simulation::Settings {
        seed: settings.seed,
        equilibration_sweeps: settings.equilibration,
        insertions: settings.insertions,
        points: settings.resolved_points(),
        pressure: settings.pressure,
        gravity: settings.gravity,
        potential: settings.potential.clone(),
        field: settings.field.clone(),
        swaps: settings.swaps,
    };
    engine.check(&settings.depletants)?;
    Ok(engine)
}

impl<'a, const D: usize> HardBodyRun<'a, D> {
    fn new(settings: &'a HardBodySettings, shape: &Shapes, interrupt: &Interrupt) -> Result<Self> {
        let prepared = Prepared::new(settings, shape)?;
        Ok(Self {
            settings,
            identity: settings::identity(settings, &prepared.input_sha256)?,
            input_sha256: prepared.input_sha256,
            mixture: prepared.mixture,
            start: prepared.start,
            engine: prepared.engine,
            interrupt: interrupt.clone(),
        })
    }

    fn drive(&self, path: &Path, execution: &Execution) -> Result<End<HardBodyResult>> {
        let _ours =
            ResultsDirectory::enter(path, &LAYOUT, self.settings, &self.identity, execution)?;
        execution.progress.begin(self.length(), "sweeps");
        match drive(self, path, execution) {
            // Stopped before there was a state: recorded by hand, as the run never began.
            Err(error) if is_stopped(&error) => {
                let stopped = Record {
                    done: Some(0),
                    ..Record::new(&self.work(), Exit::stopped_by(&execution.interrupt))
                };
                stopped.write(path)?;
                Ok(End::Stopped)
            }
            end => end,
        }
    }

    /// Sweeps at which the next block of a run ends.
    fn next_stop(&self, sweeps: u64) -> u64 {
        // The next multiple above, also from a multiple.
        let after = |period: u64| (sweeps / period + 1) * period;
        let (start, block) = (
            self.settings.equilibration,
            SAMPLES_AT_ONCE * self.settings.sample_every,
        );
        // Blocks count from the end of the equilibration, where measuring begins.
        let mut stop = match sweeps < start {
            true => after(block).min(start),
            false => start + ((sweeps - start) / block + 1) * block,
        };
        if self.settings.trajectory_every > 0 {
            // Frames end a block as well, so a checkpoint can hold them.
            stop = stop.min(after(self.settings.trajectory_every));
        }
        stop.min(self.length())
    }

    /// Verdict on whether a run that should keep a pressure or a height does.
    fn equilibrium(&self, rows: &[LogRow], walls: Option<&WallsResult>) -> Option<Equilibrium> {
        let series = |quantity: &dyn Fn(&LogRow) -> Option<f64>| -> Option<Vec<f64>> {
            rows.iter().map(quantity).collect()
        };
        if self.settings.field.is_some() {
            // A field bears a part of the bodies, which no pressure shows.
            return None;
        }
        if let Some(walls) = walls {
            return Some(Equilibrium::from_series(&Series {
                pressure: &series(&|row| {
                    // Between walls the difference of pressures carries the weight of the bodies.
                    Some(row.lower_wall_pressure? - row.upper_wall_pressure?)
                })?,
                expected_pressure: walls.weight_per_area,
                observable: &series(&|row| row.mean_height)?,
                observable_name: "mean height",
            }));
        }
        let pressure = self.settings.pressure?;
        if self
            .settings
            .depletants
            .iter()
            .any(|kind| kind.fugacity > 0.0)
        {
            // Trial compressions see the contacts of bodies, not what depletants push.
            return None;
        }
        let volume = self.mixture.mean_volume();
        Some(Equilibrium::from_series(&Series {
            pressure: &series(&|row| {
                // βP = Z ρ, with ρ = packing fraction / volume of a body.
                Some(row.compressibility_factor * row.packing_fraction / volume)
            })?,
            expected_pressure: pressure.kt_per_volume,
            observable: &series(&|row| Some(row.packing_fraction))?,
            observable_name: "packing fraction",
        }))
    }

    /// Mean pressures on the walls, and mean height of the bodies.
    fn walls(&self, open: &Open<D>) -> Option<WallsResult> {
        let gravity = self.settings.gravity?;
        let samples: Option<Vec<Walls>> = open.rows.iter().map(LogRow::walls).collect();
        let samples = samples?;
        let mean = |quantity: fn(&Walls) -> f64| {
            mean_and_error(&samples.iter().map(quantity).collect::<Vec<f64>>())
        };
        let (lower, lower_error) = mean(|walls| walls.pressures[0]);
        // Each wall bears what stands on it: their difference is the weight.
        let (upper, upper_error) = mean(|walls| walls.pressures[1]);
        let (height, height_error) = mean(|walls| walls.mean_height);
        let lengths = open.simulation.system().space().lengths();
        let area: f64 = lengths.iter().take(D - 1).product();
        Some(WallsResult {
            lower_pressure: lower,
            lower_pressure_error: lower_error,
            upper_pressure: upper,
            upper_pressure_error: upper_error,
            weight_per_area: self.settings.bodies as f64 * gravity.weight_kt_per_length / area,
            mean_height: height,
            mean_height_error: height_error,
        })
    }

    /// The error with a number of bodies that fills whole unit cells.
    fn with_whole_cells(&self, error: protomer_hpmc::Error) -> protomer_hpmc::Error {
        use protomer_hpmc::Error::BoxShrinks;
        match (error, &self.start) {
            (
                BoxShrinks {
                    edge,
                    least,
                    bodies,
                },
                Start::Crystal(crystal),
            ) => BoxShrinks {
                edge,
                least,
                // The engine names some number of bodies; a crystal needs whole cells of them.
                bodies: crystal.fewest_bodies_from(bodies, self.mixture.mean_volume(), least),
            },
            (error, _) => error,
        }
    }

    fn write_frame(&self, open: &mut Open<D>) -> Result<()> {
        let sweeps = open.simulation.sweeps();
        if let Some(trajectory) = &mut open.trajectory
            && sweeps.is_multiple_of(self.settings.trajectory_every)
        {
            trajectory.append(frame(sweeps, open.simulation.system()))?;
        }
        Ok(())
    }
}

impl<const D: usize> Run for HardBodyRun<'_, D> {
    type State = Open<D>;
    type Checkpoint = Saved;
    type Answer = HardBodyResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = CHECKPOINT_KIND;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::HardBodies,
            "hpmc run",
            &self.identity,
            &self.input_sha256,
        )
    }

    fn length(&self) -> u64 {
        self.settings.equilibration + self.settings.sweeps
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open<D>> {
        let (settings, depletants) = (self.settings, &self.settings.depletants);
        let is_new = saved.is_none();
        let (mark, frames, simulation) = match saved {
            Some(saved) => {
                let (state, bodies) = (&saved.state, settings.bodies);
                // Before the state is used: lengths decide how it is indexed.
                require_lengths(&[
                    ("coordinates", state.positions.len(), D * bodies),
                    ("orientations", state.orientations_wxyz.len(), bodies),
                    ("lengths of the box", state.lengths.len(), D),
                ])?;
                let resumed =
                    Simulation::resume_mixture(&self.engine, &self.mixture, depletants, state)?;
                (saved.log, saved.frames, resumed)
            }
            None => {
                let new = Simulation::of_mixture(
                    &self.engine,
                    &self.mixture,
                    depletants,
                    &self.start,
                    // Compressing a fluid takes long at high
                    // density; it must hear a request to stop.
                    &|| self.interrupt.is_requested(),
                )?;
                (LogMark::default(), 0, new)
            }
        };
        let path = directory.join(LOG);
        let mut log = Log::open::<LogRow>(&path, &mark)?;
        // The file on disk must be as the checkpoint has it before rows are read back.
        log.sync()?;
        let trajectory = match settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                let first = settings.equilibration;
                Some(open_trajectory(
                    &path,
                    simulation.system(),
                    Some(first),
                    frames,
                )?)
            }
        };
        let mut open = Open {
            simulation,
            rows: log::read(&path)?,
            log,
            trajectory,
            watch: Stopwatch::default(),
            trials: 0,
        };
        if is_new {
            // The start is the first frame of a run without equilibration.
            self.write_frame(&mut open)?;
        }
        Ok(open)
    }

    fn done(&self, open: &Open<D>) -> u64 {
        open.simulation.sweeps()
    }

    fn advance(&self, open: &mut Open<D>, _turn: &Turn<'_>) -> Result<()> {
        let stop = self.next_stop(open.simulation.sweeps());
        // See `SAMPLES_AT_ONCE`: a checkpoint after any block continues as if there had been none.
        open.simulation.refresh();
        while open.simulation.sweeps() < stop {
            let done = open.simulation.sweeps();
            let period = self.settings.sample_every;
            let start = self.settings.equilibration;
            let next = match done < start {
                true => stop.min(start),
                // Up to the next sample: samples count from the end of the equilibration.
                false => stop.min(start + ((done - start) / period + 1) * period),
            };
            let outcome = open.watch.time(|| open.simulation.run(next - done));
            outcome.map_err(|error| self.with_whole_cells(error))?;
            open.trials += (next - done) * self.settings.bodies as u64;
            if next > start && (next - start).is_multiple_of(period) {
                let row = measure(&mut open.simulation, self.settings);
                open.log.append(&row)?;
                open.rows.push(row);
            }
        }
        self.write_frame(open)
    }

    fn save(&self, open: &mut Open<D>) -> Result<Saved> {
        let frames = match &mut open.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        // In this order: frames and rows are on disk before the checkpoint counts them.
        Ok(Saved {
            log: open.log.sync()?,
            frames,
            state: open.simulation.state(),
        })
    }

    fn answer(&self, open: &mut Open<D>, directory: &Path) -> Result<HardBodyResult> {
        let rows = &open.rows;
        let factors: Vec<f64> = rows.iter().map(|row| row.compressibility_factor).collect();
        let insertions: Option<Vec<f64>> =
            rows.iter().map(|row| row.insertion_probability).collect();
        let insertion = insertions
            .filter(|series| !series.is_empty())
            .map(|series| mean_and_error(&series));
        let mut depletants = Vec::new();
        for (number, kind) in self.settings.depletants.iter().enumerate() {
            let series: Vec<f64> = rows
                .iter()
                .map(|row| row.free_volume_fraction[number])
                .collect();
            let (fraction, error) = mean_and_error(&series);
            depletants.push(DepletantResult {
                radius: kind.radius,
                fugacity: kind.fugacity,
                reservoir_packing_fraction: kind.fugacity * ball_volume(D, kind.radius),
                free_volume_fraction: fraction,
                free_volume_fraction_error: error,
            });
        }
        let energies: Option<Vec<f64>> = rows.iter().map(|row| row.energy).collect();
        let energy = energies
            .filter(|series| !series.is_empty())
            .map(|series| mean_and_error(&series));
        let walls = self.walls(open);
        let equilibrium = self.equilibrium(rows, walls.as_ref());
        if walls.is_some() {
            write_once(&directory.join(PROFILE), profile(open).as_bytes(), true)?;
        }
        let packings: Vec<f64> = rows.iter().map(|row| row.packing_fraction).collect();
        let is_pressed = self.settings.pressure.is_some();
        let (packing, packing_error) = match is_pressed {
            // The density was measured, and its error enters that of the pressure.
            true => mean_and_error(&packings),
            false => (self.settings.packing_fraction, None),
        };
        let (factor, factor_error) = match is_pressed {
            // Pressure and density vary together; see `mean_and_error_following`.
            true => mean_and_error_following(&factors, &packings),
            false => mean_and_error(&factors),
        };
        let system = open.simulation.system();
        let first = depletants.first();
        let seconds = open.watch.seconds();
        Ok(HardBodyResult {
            shape: self.settings.shape.join(", "),
            dimension: D,
            rounding_radius: self.settings.rounding_radius,
            bodies: system.len(),
            packing_fraction: packing,
            packing_fraction_error: packing_error,
            box_edge: system.space().lengths()[0],
            box_edges: system.space().lengths().to_vec(),
            box_tilt_factors: tilt_factors(system.space()),
            mean_box: MeanBox::from_rows(rows),
            sweeps: open
                .simulation
                .sweeps()
                .saturating_sub(self.settings.equilibration),
            compressibility_factor: factor,
            compressibility_factor_error: factor_error,
            reduced_pressure: factor * packing,
            acceptance: open.simulation.counts().total().acceptance(),
            translation_step: open.simulation.steps().translation,
            rotation_step: open.simulation.steps().rotation,
            trial_moves_per_cpu_second: (seconds > 0.0).then(|| open.trials as f64 / seconds),
            energy_kt_per_body: energy.map(|(mean, _)| mean),
            energy_kt_per_body_error: energy.and_then(|(_, error)| error),
            insertion_probability: insertion.map(|(mean, _)| mean),
            insertion_probability_error: insertion.and_then(|(_, error)| error),
            excess_chemical_potential_kt: insertion
                // No insertion succeeded: the potential is beyond what the run can tell.
                .filter(|(mean, _)| *mean > 0.0)
                .map(|(mean, _)| -mean.ln()),
            // The error of -ln p is that of p over p.
            excess_chemical_potential_kt_error: insertion
                .filter(|(mean, _)| *mean > 0.0)
                .and_then(|(mean, error)| Some(error? / mean)),
            free_volume_fraction: first.map(|kind| kind.free_volume_fraction),
            free_volume_fraction_error: first.and_then(|kind| kind.free_volume_fraction_error),
            pressure_kt_per_volume: self
                .settings
                .pressure
                .map(|pressure| pressure.kt_per_volume),
            swap_acceptance: (self.settings.swaps > 0)
                .then(|| open.simulation.swap_counts().acceptance()),
            box_acceptance: self
                .settings
                .pressure
                .map(|_| open.simulation.box_acceptance()),
            equilibrium,
            walls,
            depletants,
        })
    }

    fn details(&self, open: &mut Open<D>, directory: &Path) -> Result<Value> {
        if open.rows.is_empty() {
            return Ok(Value::Null);
        }
        Ok(serde_json::to_value(self.answer(open, directory)?)?)
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }
}

/// Measures a state: the row of the log.
pub(super) fn measure<const D: usize>(
    simulation: &mut Simulation<D>,
    settings: &HardBodySettings,
) -> LogRow {
    let sample = simulation.sample();
    let space = simulation.system().space();
    let (lengths, tilt_factors) = match settings.pressure.map(|pressure| pressure.freedom) {
        None | Some(Freedom::Volume) => (Vec::new(), Vec::new()),
        // What is fixed is not written.
        Some(Freedom::Lengths) => (space.lengths().to_vec(), Vec::new()),
        Some(Freedom::Shape) => (space.lengths().to_vec(), space.tilt_factors()),
    };
    LogRow {
        sweep: simulation.sweeps(),
        compressibility_factor: sample.compressibility_factor,
        insertion_probability: sample.insertion_probability,
        free_volume_fraction: sample.free_volume,
        packing_fraction: sample.packing_fraction,
        lower_wall_pressure: sample.walls.map(|walls| walls.pressures[0]),
        upper_wall_pressure: sample.walls.map(|walls| walls.pressures[1]),
        mean_height: sample.walls.map(|walls| walls.mean_height),
        box_lengths: lengths,
        box_tilt_factors: tilt_factors,
        energy: sample.energy_kt_per_body,
    }
}

/// Settings and last state of the run in a directory, whatever its progress.
///
/// # Errors
/// If the directory holds no such run, or one without a checkpoint.
pub(super) fn saved_state(directory: &Path) -> Result<(HardBodySettings, State)> {
    ResultKind::HardBodies.expect_in(directory)?;
    let settings: HardBodySettings = read_toml(&directory.join(LAYOUT.settings))?;
    let checkpoint = directory.join(CHECKPOINT);
    let record = Record::read(directory)?;
    let identity = record.map(|record| record.identity).unwrap_or_default();
    let saved: Option<Saved> = checkpoint::read(&checkpoint, CHECKPOINT_KIND, &identity)?;
    let saved = saved.with_context(|| {
        format!(
            "{} has no checkpoint yet; give a run that has begun, or a GSD file",
            directory.display()
        )
    })?;
    Ok((settings, saved.state))
}

/// Whether the work was asked to stop before there was a state to save.
fn is_stopped(error: &Error) -> bool {
    matches!(
        error.downcast_ref::<protomer_hpmc::Error>(),
        Some(protomer_hpmc::Error::Stopped)
    )
}

/// The start of a run that is not a state, and the bodies in their order.
fn start<const D: usize>(
    settings: &HardBodySettings,
    shapes: &Shapes,
    cell_text: Option<&str>,
) -> Result<(Start<D>, Mixture<D>)> {
    let (bodies, packing) = (settings.bodies, settings.packing_fraction);
    if settings.start != FLUID {
        let cell = unit_cell(&settings.start, cell_text, &settings.turn)?;
        let mixture = shapes.mixture_on(settings, &cell)?;
        let crystal = Crystal::of_mixture(&cell, &mixture, &settings.depletants, packing)?;
        // What cannot be is refused before a directory is made.
        // Built once and thrown away: an impossible crystal is refused here.
        crystal.system_of(&mixture, &settings.depletants)?;
        return Ok((Start::Crystal(crystal), mixture));
    }
    let edge_ratios = match settings.box_ratios.as_slice() {
        [] => [1.0; D],
        ratios => ratios.try_into().ok().with_context(|| {
            let count = ratios.len();
            format!("there are {count} ratios of edges, and the box has {D} edges; give {D}")
        })?,
    };
    let fluid = Start::Fluid {
        bodies,
        packing_fraction: packing,
        edge_ratios,
        has_walls: settings.gravity.is_some(),
    };
    Ok((fluid, shapes.mixture(settings)?))
}

/// Densities by height.
fn profile<const D: usize>(open: &Open<D>) -> String {
    let system = open.simulation.system();
    let parts = open.simulation.heights().parts();
    // The heights run along the last axis, which has the walls.
    let height = system.space().lengths()[D - 1] / parts.len().max(1) as f64;
    let volume = system.volume() / parts.len().max(1) as f64;
    let mean_volume = system.body_volume() / system.len() as f64;
    let mut table = String::from("height,number_density,packing_fraction\n");
    for (bin, part) in parts.iter().enumerate() {
        // `part` is the share of the bodies in this layer.
        let density = part * system.len() as f64 / volume;
        let middle = (bin as f64 + 0.5) * height;
        let packing = density * mean_volume;
        table.push_str(&format!("{middle},{density},{packing}\n"));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hard_bodies::settings::Pressure;

    fn run(settings: &HardBodySettings, path: &Path) -> HardBodyResult {
        let end = run_hard_bodies(settings, path, &Execution::default()).unwrap();
        end.finished().unwrap()
    }

    #[test]
    fn a_run_that_stops_and_goes_on_writes_the_same_bytes() {
        let plain = HardBodySettings {
            shape: "tetrahedron".into(),
            bodies: 64,
            packing_fraction: 0.1,
            equilibration: 100,
            sweeps: 100,
            trajectory_every: 50,
            insertions: 10,
            ..HardBodySettings::default()
        };
        stops_and_goes_on(&HardBodySettings {
            depletants: super::super::settings::parse_depletants("0.1:5").unwrap(),
            ..plain.clone()
        });
        // A fluid, whose box soon is so tilted that other edges describe it.
        stops_and_goes_on(&HardBodySettings {
            pressure: Some(Pressure {
                kt_per_volume: 0.5,
                freedom: Freedom::Shape,
                changes_per_sweep: None,
            }),
            ..plain
        });
    }

    fn stops_and_goes_on(short: &HardBodySettings) {
        let folder = tempfile::tempdir().unwrap();
        let long = HardBodySettings {
            sweeps: 300,
            ..short.clone()
        };
        let [parts, whole] = ["parts", "whole"].map(|name| folder.path().join(name));
        run(short, &parts);
        let (in_parts, at_once) = (run(&long, &parts), run(&long, &whole));
        assert_eq!(in_parts.sweeps, 300);
        assert_eq!(in_parts.mean_box, at_once.mean_box);
        assert_eq!(in_parts.mean_box.is_some(), short.pressure.is_some());
        assert_eq!(
            in_parts.compressibility_factor,
            at_once.compressibility_factor
        );
        for file in [LOG, TRAJECTORY, CHECKPOINT] {
            let [parts, whole] =
                [&parts, &whole].map(|path| std::fs::read(path.join(file)).unwrap());
            assert!(parts == whole, "{file}");
        }
        // A finished run answers from its record.
        assert_eq!(
            run(&long, &whole).compressibility_factor,
            at_once.compressibility_factor
        );
        let other = HardBodySettings { seed: 2, ..long };
        let refused = run_hard_bodies(&other, &whole, &Execution::default());
        assert!(refused.unwrap_err().to_string().contains("seed"));
    }
}
