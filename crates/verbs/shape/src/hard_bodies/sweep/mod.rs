//! Runs of hard bodies over packing fraction or pressure, once per seed: an equation of state.
//!
//! ```text
//! DIR/  run.toml  run.json  equation.csv  equation.json  equation.svg  equation.png
//! DIR/packing_0.3/seed_1/   a run directory each (pressure_2 for a pressure)
//! ```

mod equation;

pub use equation::{EquationOfState, StatePoint};

use super::kinds::Shapes;
use super::placed::start_text;
use super::result::HardBodyResult;
use super::run::run_hard_bodies;
use super::settings::{HardBodySettings, Pressure};
use super::start::{BodyShape, FLUID};
use anyhow::{Context, Error, Result, bail};
use equation::integrate;
use protomer_common::answer::Answer;
use protomer_io::atomic::write_bytes;
use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
use protomer_kernel::shape::measures::Measures;
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, Settings, Shard, Work, carry_out,
    carry_out_shard, settings,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

const TABLE: &str = "equation.csv";
const JSON: &str = "equation.json";
/// Upper limit for the number of runs, each of which has a folder.
const MOST_RUNS: usize = 10_000;

/// The directory of a sweep.
const LAYOUT: Layout = Layout {
    kind: ResultKind::HardBodySweep,
    settings: "run.toml",
    results: &[
        "run.json",
        TABLE,
        JSON,
        "equation.svg",
        "equation.png",
        "report.html",
    ],
    is_result: is_condition,
};

/// The settings of a sweep: those of a run, and what is varied.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HardBodySweepSettings {
    /// Packing fractions; empty for a sweep over pressures.
    pub packing_fractions: Vec<f64>,
    /// Pressures, kT per volume, at which the box changes; empty for a sweep over packing fractions. The
    /// packing fraction of the run is that of the start.
    pub pressures_kt_per_volume: Vec<f64>,
    /// Seeds of the runs at each condition.
    pub seeds: Vec<u64>,
    /// All other settings.
    pub run: HardBodySettings,
}

impl Settings for HardBodySweepSettings {
    /// Settings that must stay the same: more sweeps, conditions and seeds continue a sweep.
    fn essential(&self) -> Self {
        let over_pressure = !self.pressures_kt_per_volume.is_empty();
        // Everything that varies within a sweep is blanked, so that it can be extended.
        Self {
            packing_fractions: Vec::new(),
            pressures_kt_per_volume: Vec::new(),
            seeds: Vec::new(),
            run: HardBodySettings {
                packing_fraction: match over_pressure {
                    true => self.run.packing_fraction,
                    false => 0.0,
                },
                pressure: self.run.pressure.map(|pressure| Pressure {
                    kt_per_volume: 0.0,
                    ..pressure
                }),
                seed: 0,
                ..self.run.essential()
            },
        }
    }
}

/// One run of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Number of its condition.
    condition: usize,
    settings: HardBodySettings,
    directory: PathBuf,
}

impl Task {
    /// The directory of the run.
    pub fn directory(&self) -> &Path {
        &self.directory
    }
}

impl HardBodySweepSettings {
    /// The packing fractions or pressures, and the name of a folder for one.
    fn conditions(&self) -> Result<(&[f64], &'static str)> {
        let (packings, pressures) = (&self.packing_fractions, &self.pressures_kt_per_volume);
        match (packings.is_empty(), pressures.is_empty()) {
            (false, true) => Ok((packings, "packing")),
            (true, false) => Ok((pressures, "pressure")),
            _ => bail!("give packing fractions or pressures to sweep over, and not both"),
        }
    }

    /// All runs, by seed first, so that an interrupted sweep covers all conditions early.
    ///
    /// # Errors
    /// For no runs or too many, one that is listed twice, and invalid settings of one.
    pub fn tasks(&self, directory: &Path) -> Result<Vec<Task>> {
        let (values, name) = self.conditions()?;
        if self.seeds.is_empty() {
            bail!("there are no seeds; give at least one");
        }
        // Saturating: the product may overflow before it is compared.
        if values.len().saturating_mul(self.seeds.len()) > MOST_RUNS {
            bail!(
                "{} conditions with {} seeds each are too many; ask for at most {MOST_RUNS} runs",
                values.len(),
                self.seeds.len()
            );
        }
        let (freedom, changes_per_sweep) = match self.run.pressure {
            Some(pressure) => (pressure.freedom, pressure.changes_per_sweep),
            None => Default::default(),
        };
        let mut tasks: Vec<Task> = Vec::new();
        for seed in self.seeds.iter().copied() {
            for (condition, value) in values.iter().copied().enumerate() {
                let mut settings = HardBodySettings {
                    seed,
                    ..self.run.clone()
                };
                match name {
                    "packing" => settings.packing_fraction = value,
                    _ => {
                        settings.pressure = Some(Pressure {
                            kt_per_volume: value,
                            freedom,
                            changes_per_sweep,
                        });
                    }
                }
                settings.check()?;
                let folder = format!("{name}_{value}");
                let directory = directory.join(folder).join(format!("seed_{seed}"));
                // Two runs in one folder would wait for each other's lock.
                if tasks.iter().any(|task| task.directory == directory) {
                    bail!("{name} {value} with seed {seed} is listed twice; list it once");
                }
                tasks.push(Task {
                    condition,
                    settings,
                    directory,
                });
            }
        }
        Ok(tasks)
    }
}

/// Whether this is the folder of one condition: `packing_0.3` or `pressure_2`.
fn is_condition(path: &Path) -> bool {
    // Checked by the number too: folders of the user stay.
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let value = name
        .strip_prefix("packing_")
        .or_else(|| name.strip_prefix("pressure_"));
    path.is_dir() && value.is_some_and(|value| value.parse::<f64>().is_ok())
}

/// Runs or continues a sweep in a directory.
///
/// # Errors
/// For invalid settings, a directory that holds other work, or a run that fails: the others then stop
/// at their next step and keep their progress.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::settings::HardBodySettings;
/// use protomer_shape_verbs::hard_bodies::sweep::{HardBodySweepSettings, run_sweep};
/// use protomer_results::Execution;
/// let settings = HardBodySweepSettings {
///     packing_fractions: vec![0.05, 0.1],
///     seeds: vec![1],
///     run: HardBodySettings {
///         shape: "cube".into(),
///         bodies: 64,
///         equilibration: 50,
///         sweeps: 100,
///         trajectory_every: 0,
///         ..HardBodySettings::default()
///     },
///     ..HardBodySweepSettings::default()
/// };
/// # let folder = tempfile::tempdir()?;
/// let end = run_sweep(&settings, &folder.path().join("sweep"), &Execution::default())?;
/// let points = end.finished().unwrap().points;
/// assert!(points[1].compressibility_factor > points[0].compressibility_factor);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_sweep(
    settings: &HardBodySweepSettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<EquationOfState>> {
    let sweep = Sweep::new(settings, path)?;
    carry_out(&sweep, path, &LAYOUT, settings, execution)
}

/// Runs or continues the runs of one part of a sweep, while other processes do other parts in the same directory;
/// returns their number. [`run_sweep`] finds them done and writes the table and the figure.
///
/// # Errors
/// As [`run_sweep`].
pub fn run_shard(
    settings: &HardBodySweepSettings,
    path: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    let sweep = Sweep::new(settings, path)?;
    carry_out_shard(&sweep, path, &LAYOUT, settings, shard, execution)
}

struct Sweep<'a> {
    settings: &'a HardBodySweepSettings,
    tasks: Vec<Task>,
    identity: String,
    input_sha256: String,
    shape: Shapes,
    path: &'a Path,
}

impl<'a> Sweep<'a> {
    fn new(settings: &'a HardBodySweepSettings, path: &'a Path) -> Result<Self> {
        let shape = Shapes::read(&settings.run)?;
        let text = start_text(&settings.run, &shape)?;
        let input_sha256 = shape.sha256(text.as_deref());
        Ok(Self {
            settings,
            tasks: settings.tasks(path)?,
            identity: settings::identity(settings, &input_sha256)?,
            input_sha256,
            shape,
            path,
        })
    }

    /// Second virial coefficient over volume of fluids whose pressure is that of the bodies alone.
    fn b2_over_volume(&self) -> Result<Option<f64>> {
        let run = &self.settings.run;
        let is_plain = run.start == FLUID
            && run.gravity.is_none()
            && run.spread == 0.0
            && run.potential.is_empty()
            && run.field.is_none()
            // Depletants of fugacity 0 only measure free volumes.
            && run.depletants.iter().all(|kind| kind.fugacity == 0.0);
        if !is_plain || self.settings.packing_fractions.is_empty() {
            return Ok(None);
        }
        let measures = match self.shape.single() {
            Some(BodyShape::Shape(shape)) => Measures::from_shape(shape, run.rounding_radius)?,
            Some(BodyShape::Ellipsoid(axes)) => measures_of_ellipsoid(axes, 0.0)?,
            _ => return Ok(None),
        };
        Ok(Some(measures.b2 / measures.volume))
    }

    fn body_volume(&self) -> Result<f64> {
        let run = &self.settings.run;
        Ok(match self.shape.dimension() {
            1 => self.shape.mixture::<1>(run)?.mean_volume(),
            2 => self.shape.mixture::<2>(run)?.mean_volume(),
            _ => self.shape.mixture::<3>(run)?.mean_volume(),
        })
    }
}

impl Campaign for Sweep<'_> {
    type Task = Task;
    type Part = HardBodyResult;
    type Answer = EquationOfState;
    type Error = Error;

    const ENTERS_DIRECTORIES: bool = true;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::HardBodySweep,
            "hpmc sweep",
            &self.identity,
            &self.input_sha256,
        )
    }

    fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    fn directory(&self, task: &Task) -> PathBuf {
        task.directory.clone()
    }

    fn run(
        &self,
        task: &Task,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<HardBodyResult>> {
        // The directory was cleared with the sweep, and progress counts runs here.
        let end = run_hard_bodies(&task.settings, directory, &execution.of_part());
        execution.progress.advance(1);
        end.with_context(|| directory.display().to_string())
    }

    /// Makes the table and the figure.
    fn collect(&self, parts: Vec<HardBodyResult>) -> Result<EquationOfState> {
        let (conditions, _) = self.settings.conditions()?;
        let mut by_condition = vec![Vec::new(); conditions.len()];
        for (task, part) in self.tasks.iter().zip(parts) {
            by_condition[task.condition].push(part);
        }
        let mut points: Vec<StatePoint> = by_condition
            .iter()
            .map(|runs: &Vec<HardBodyResult>| StatePoint::from_runs(runs))
            .collect();
        // At constant pressure the order of densities is only known afterwards.
        points.sort_by(|a, b| a.packing_fraction.total_cmp(&b.packing_fraction));
        let b2_over_volume = self.b2_over_volume()?;
        if let Some(b2_over_volume) = b2_over_volume {
            integrate(&mut points, b2_over_volume)?;
        }
        let equation = EquationOfState {
            settings: self.settings.clone(),
            dimension: self.shape.dimension(),
            body_volume: self.body_volume()?,
            b2_over_volume,
            points,
        };
        write_results(&equation, self.path)?;
        Ok(equation)
    }
}

fn write_results(equation: &EquationOfState, directory: &Path) -> Result<()> {
    let json = serde_json::to_string_pretty(equation)?;
    for (name, text) in [(TABLE, equation.table()?), (JSON, format!("{json}\n"))] {
        write_bytes(&directory.join(name), text.as_bytes())?;
    }
    if let Some(figure) = equation.figure() {
        figure.write_svg(&directory.join("equation.svg"))?;
        figure.write_png(&directory.join("equation.png"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(packing_fractions: &[f64], sweeps: u64) -> HardBodySweepSettings {
        HardBodySweepSettings {
            packing_fractions: packing_fractions.to_vec(),
            seeds: vec![1, 2],
            run: HardBodySettings {
                shape: "tetrahedron".into(),
                bodies: 64,
                equilibration: 50,
                sweeps,
                trajectory_every: 0,
                ..HardBodySettings::default()
            },
            ..HardBodySweepSettings::default()
        }
    }

    fn run(settings: &HardBodySweepSettings, path: &Path) -> EquationOfState {
        let end = run_sweep(settings, path, &Execution::default()).unwrap();
        end.finished().unwrap()
    }

    /// Parts in any order, and the command that collects them, leave the table of one process.
    #[test]
    fn parts_give_the_table_of_one_process() {
        let folder = tempfile::tempdir().unwrap();
        let [parts, whole] = ["parts", "whole"].map(|name| folder.path().join(name));
        let settings = settings(&[0.05, 0.1], 50);
        for index in [3, 1, 2] {
            let shard = Shard::parse(&format!("{index}/3")).unwrap();
            let end = run_shard(&settings, &parts, shard, &Execution::default()).unwrap();
            let expected = if index == 1 { 2 } else { 1 };
            assert_eq!(end.finished().unwrap(), expected);
        }
        run(&settings, &parts);
        run(&settings, &whole);
        let [parts, whole] = [&parts, &whole].map(|path| std::fs::read(path.join(TABLE)).unwrap());
        assert!(parts == whole);
    }

    #[test]
    fn more_packing_fractions_and_sweeps_continue_a_sweep() {
        let folder = tempfile::tempdir().unwrap();
        let [parts, whole] = ["parts", "whole"].map(|name| folder.path().join(name));
        run(&settings(&[0.1], 50), &parts);
        let long = settings(&[0.05, 0.1, 0.15], 100);
        let (in_parts, at_once) = (run(&long, &parts), run(&long, &whole));
        assert_eq!(in_parts.points, at_once.points);
        for file in [TABLE, JSON, "equation.svg"] {
            let [parts, whole] =
                [&parts, &whole].map(|path| std::fs::read(path.join(file)).unwrap());
            assert!(parts == whole, "{file}");
        }
        let point = &at_once.points[0];
        assert_eq!(point.seeds, 2);
        // Forty times the sweeps give 0.427 ± 0.009; the second virial coefficient alone 0.385.
        let free_energy = point.excess_free_energy_per_body_kt.unwrap();
        let error = point.excess_free_energy_per_body_kt_error.unwrap();
        assert!((free_energy - 0.427).abs() < 4.0 * error, "{free_energy}");
        assert!(error < 0.1, "{error}");
        let other = HardBodySweepSettings {
            run: HardBodySettings {
                bodies: 65,
                ..long.run.clone()
            },
            ..long
        };
        assert!(run_sweep(&other, &whole, &Execution::default()).is_err());
    }

    #[test]
    fn what_cannot_be_swept_is_named() {
        let path = Path::new("sweep");
        let complaint =
            |settings: &HardBodySweepSettings| settings.tasks(path).unwrap_err().to_string();
        let none = HardBodySweepSettings::default();
        assert!(complaint(&none).contains("packing fractions or pressures"));
        let twice = settings(&[0.1, 0.1], 100);
        assert!(complaint(&twice).contains("listed twice"));
        let full = settings(&[1.5], 100);
        assert!(complaint(&full).contains("between 0 and 1"));
        let unseeded = HardBodySweepSettings {
            seeds: Vec::new(),
            ..settings(&[0.1], 100)
        };
        assert!(complaint(&unseeded).contains("seeds"));
    }

    /// f = ∫ (Z - 1)/φ of Z = 1 + aφ + bφ², whose spline is exact.
    #[test]
    fn the_free_energy_is_the_integral_of_the_factors() {
        let blank = StatePoint {
            packing_fraction: 0.0,
            packing_fraction_error: None,
            pressure_kt_per_volume: None,
            compressibility_factor: 0.0,
            compressibility_factor_error: Some(0.01),
            reduced_pressure: 0.0,
            excess_chemical_potential_kt: None,
            excess_chemical_potential_kt_error: None,
            excess_free_energy_per_body_kt: None,
            excess_free_energy_per_body_kt_error: None,
            equilibrium: None,
            free_volume_fraction: None,
            free_volume_fraction_error: None,
            seeds: 1,
        };
        let state = |packing: f64| StatePoint {
            packing_fraction: packing,
            compressibility_factor: 1.0 + 4.0 * packing + 10.0 * packing * packing,
            ..blank.clone()
        };
        let mut points = [0.1, 0.25, 0.3, 0.4].map(state);
        integrate(&mut points, 4.0).unwrap();
        for point in &points {
            let packing = point.packing_fraction;
            let found = point.excess_free_energy_per_body_kt.unwrap();
            assert!((found - 4.0 * packing - 5.0 * packing * packing).abs() < 1e-12);
            assert!(point.excess_free_energy_per_body_kt_error.unwrap() > 0.0);
        }
    }
}
