//! What scattering sees of an assembly or a trajectory: curves to compare with those of X-rays
//! and light.
//!
//! | module | one idea |
//! |---|---|
//! | `source` | the frames of an assembly file, a simulation or a sweep |
//! | `average` | means over frames and replicas with errors |
//! | `answer` | the answer: text, tables, figure |
//! | `page` | what the page of a run shows of it |

mod answer;
mod average;
pub(crate) mod page;
mod source;

pub use answer::{BodyRow, CurveRow, ScatteringReport, SizeRow, StateRow};
pub use protomer_mc::scattering::experiment::Settings as ExperimentSettings;
pub(crate) use source::Source;

use crate::stability::compare::NOT_ONE_STATE;
use crate::stability::sweep::result::SweepResult;
use answer::FILE;
use anyhow::{Context, Result, bail};
use average::{estimate, ratio};
use protomer_common::output_file::write_folder;
use protomer_mc::contributions::Mean;
use protomer_mc::scattering::experiment::{self, ClusterMeasure, Experiment, Measured};
use protomer_mc::{BodyType, System};
use protomer_results::Progress;
use rayon::prelude::*;
use source::Series;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The folder in the directory of a run in which a report looks for the answer.
pub const FOLDER: &str = "scattering";

/// Settings of [`scattering()`].
///
/// ```no_run
/// use protomer_protein_verbs::scattering::{ScatteringSettings, scattering};
/// let settings = ScatteringSettings {
///     input: "stability".into(),
///     ..ScatteringSettings::default()
/// };
/// for state in scattering(&settings, &())?.states {
///     println!("{:?}", state.hydrodynamic_radius_angstrom);
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ScatteringSettings {
    /// An assembly file, or the directory of a simulation or a sweep.
    pub input: PathBuf,
    /// Salt concentration of a sweep that is measured, mol/L; all if `None`.
    pub salt_molar: Option<f64>,
    /// The assembly of a run, if it is no longer where the run was begun with it.
    pub assembly: Option<PathBuf>,
    /// Share of the frames at the beginning of each trajectory that is left out.
    pub skip: f64,
    /// Frames of each trajectory that are measured at most, evenly spread.
    pub most_frames: usize,
    /// Gap of surfaces in contact, Å; that of the run, or the default, if `None`.
    pub contact_gap_angstrom: Option<f64>,
    /// Settings of the experiment; `contact_gap_angstrom` replaces its contact gap.
    pub experiment: experiment::Settings,
    /// Directory for tables, JSON and figure.
    pub output: Option<PathBuf>,
    /// Whether existing files are replaced.
    pub force: bool,
}

impl Default for ScatteringSettings {
    fn default() -> Self {
        Self {
            input: PathBuf::new(),
            salt_molar: None,
            assembly: None,
            skip: 0.2,
            most_frames: 100,
            contact_gap_angstrom: None,
            experiment: experiment::Settings::default(),
            output: None,
            force: false,
        }
    }
}

impl ScatteringSettings {
    pub(crate) fn check(&self) -> Result<()> {
        if !(0.0..1.0).contains(&self.skip) {
            bail!(
                "the share of frames to skip is {}; give one from 0 to below 1, such as 0.2",
                self.skip
            );
        }
        if self.most_frames == 0 {
            bail!("no frame would be measured; let --most-frames be at least 1");
        }
        Ok(self.experiment.check()?)
    }
}

/// Measures the frames and averages over them; writes files if there is a directory for them.
///
/// # Errors
/// For settings out of range, an input without bodies or trajectories, and files that exist or cannot
/// be written.
pub fn scattering(
    settings: &ScatteringSettings,
    progress: &dyn Progress,
) -> Result<ScatteringReport> {
    settings.check()?;
    let source = Source::read(settings)?;
    let gap = settings
        .contact_gap_angstrom
        .unwrap_or(source.contact_gap_angstrom);
    let settings_of_experiment = experiment::Settings {
        contact_gap_angstrom: gap,
        ..settings.experiment
    };
    let experiment = Experiment::new(
        &source.assembly.bodies,
        &source.boundary,
        settings_of_experiment,
    )?;
    let frames: usize = source.series.iter().map(|series| series.frames.len()).sum();
    progress.begin(frames as u64, "frames");
    let kinds = kinds(&source)?;
    let mut states: Vec<(Option<f64>, Vec<Vec<Measured>>)> = Vec::new();
    for series in &source.series {
        let measured = measured(&source, &kinds, &experiment, series, progress)?;
        match states.last_mut() {
            // Series of one salt follow each other, replica by replica.
            Some((salt, replicas)) if *salt == series.salt_molar => replicas.push(measured),
            _ => states.push((series.salt_molar, vec![measured])),
        }
    }
    let system = source.system(&kinds, &source.assembly.poses)?;
    let form_factor = experiment.mean_form_factor(&system);
    let rows = states
        .iter()
        .map(|(salt, replicas)| state_row(*salt, replicas, &experiment, &form_factor));
    let bodies = source
        .assembly
        .bodies
        .iter()
        .enumerate()
        .map(|(kind, body)| BodyRow {
            name: body.name.clone(),
            hydrodynamic_radius_angstrom: experiment.hydrodynamic_radius_angstrom(kind),
            form_factor: experiment.form_factor(kind).to_vec(),
        });
    let report = ScatteringReport {
        version: env!("CARGO_PKG_VERSION").into(),
        bodies: source.assembly.len(),
        skipped_share: if source.is_run { settings.skip } else { 0.0 },
        is_periodic: source.assembly.box_angstrom().is_some(),
        settings: settings_of_experiment,
        kinds: bodies.collect(),
        states: rows.collect(),
        warnings: warnings(&settings.input)?,
    };
    if let Some(directory) = &settings.output {
        write(&report, directory, settings.force)?;
    }
    Ok(report)
}

/// A warning for a sweep whose replicas are not in one state.
fn warnings(input: &Path) -> Result<Vec<String>> {
    let sweep = match input.is_dir() {
        true => SweepResult::read(input)?,
        false => None,
    };
    let disagree = sweep.is_some_and(|sweep| sweep.stability.equilibrated == Some(false));
    let warning = disagree.then(|| format!("warning: {NOT_ONE_STATE}"));
    Ok(warning.into_iter().collect())
}

/// The bodies as the engine knows them.
fn kinds(source: &Source) -> Result<Vec<Arc<BodyType>>> {
    let mut kinds = Vec::new();
    for body in &source.assembly.bodies {
        kinds.push(Arc::new(BodyType::from_body(body)?));
    }
    Ok(kinds)
}

fn measured(
    source: &Source,
    kinds: &[Arc<BodyType>],
    experiment: &Experiment,
    series: &Series,
    progress: &dyn Progress,
) -> Result<Vec<Measured>> {
    let measure = |(number, poses): (usize, &Vec<_>)| -> Result<Measured> {
        let system: System = source.system(kinds, poses)?;
        // By number over all series: each frame has its
        // own random directions, whichever thread has it.
        let measured = experiment.measure(&system, series.first_number + number as u64);
        progress.advance(1);
        Ok(measured)
    };
    series.frames.par_iter().enumerate().map(measure).collect()
}

/// Averages one state over its replicas and their frames.
fn state_row(
    salt_molar: Option<f64>,
    replicas: &[Vec<Measured>],
    experiment: &Experiment,
    form_factor: &[f64],
) -> StateRow {
    let over_frames = |value: &dyn Fn(&Measured) -> f64| -> Mean {
        let series = replicas
            .iter()
            .map(|frames| frames.iter().map(value).collect());
        estimate(&series.collect::<Vec<Vec<f64>>>())
    };
    let mut curve = Vec::new();
    for (place, q) in experiment.q_per_angstrom().iter().enumerate() {
        let structure_factor = over_frames(&|state| state.structure_factor[place]);
        let intensity = over_frames(&|state| state.intensity[place]);
        curve.push(CurveRow {
            q_per_angstrom: *q,
            structure_factor: structure_factor.mean,
            structure_factor_error: structure_factor.error,
            form_factor: form_factor[place],
            intensity: intensity.mean,
            intensity_error: intensity.error,
        });
    }
    let clusters = || replicas.iter().flatten().flat_map(|state| &state.clusters);
    let bodies = replicas.iter().flatten().next().map_or(0, bodies_of);
    let largest = clusters().map(|cluster| cluster.bodies).max().unwrap_or(0);
    let mut sizes = Vec::new();
    for size in 1..=largest {
        let clusters = over_frames(&|state| count(state, size));
        let share = size as f64 / bodies.max(1) as f64;
        sizes.push(SizeRow {
            bodies: size,
            clusters: clusters.mean,
            clusters_error: clusters.error,
            fraction_of_bodies: share * clusters.mean,
            fraction_error: clusters.error.map(|error| share * error),
        });
    }
    let light = |power: i32| move |state: &Measured| light(state, power);
    // Γ ∝ Σ I / R: the radius that light scattering states is Σ I / Σ (I / R).
    let radius = ratio(replicas, &light(0), &light(1));
    StateRow {
        salt_molar,
        replicas: replicas.len(),
        frames: replicas.iter().map(Vec::len).sum(),
        mean_cluster_size: over_frames(&|state| {
            bodies_of(state) as f64 / state.clusters.len() as f64
        }),
        weighted_cluster_size: over_frames(&|state| {
            let squares = state
                .clusters
                .iter()
                .map(|cluster| cluster.bodies.pow(2) as f64);
            squares.sum::<f64>() / bodies_of(state) as f64
        }),
        hydrodynamic_radius_angstrom: radius,
        polydispersity: polydispersity(replicas),
        endless_clusters: over_frames(&|state| {
            let endless =
                |cluster: &&ClusterMeasure| cluster.hydrodynamic_radius_angstrom.is_none();
            state.clusters.iter().filter(endless).count() as f64
        })
        .mean,
        cluster_sizes: sizes,
        curve,
    }
}

fn bodies_of(state: &Measured) -> usize {
    state.clusters.iter().map(|cluster| cluster.bodies).sum()
}

fn count(state: &Measured, size: usize) -> f64 {
    let of_size = state
        .clusters
        .iter()
        .filter(|cluster| cluster.bodies == size);
    of_size.count() as f64
}

/// Σ I / R^power over the clusters that have a radius.
fn light(state: &Measured, power: i32) -> f64 {
    let mut sum = 0.0;
    for cluster in &state.clusters {
        if let Some(radius) = cluster.hydrodynamic_radius_angstrom {
            sum += cluster.light_angstrom6 / radius.powi(power);
        }
    }
    sum
}

/// The second cumulant over the square of the first, from the rates of all clusters: μ₂/Γ²; `None` if
/// no cluster has a radius.
fn polydispersity(replicas: &[Vec<Measured>]) -> Option<f64> {
    let moment = |power: i32| -> f64 {
        replicas
            .iter()
            .flatten()
            .map(|state| light(state, power))
            .sum()
    };
    let (intensity, rate, square) = (moment(0), moment(1), moment(2));
    // μ₂/Γ² = <R⁻²><1> / <R⁻¹>² - 1; not negative but for rounding.
    (rate > 0.0).then(|| (square * intensity / (rate * rate) - 1.0).max(0.0))
}

fn write(report: &ScatteringReport, directory: &Path, force: bool) -> Result<()> {
    let figure = report.drawn();
    let json = serde_json::to_string_pretty(report).context("the answer cannot be serialised")?;
    let files = [
        ("scattering.csv", report.curves()?.into_bytes()),
        ("clusters.csv", report.clusters()?.into_bytes()),
        (FILE, (json + "\n").into_bytes()),
        ("scattering.svg", figure.to_svg()?.into_bytes()),
        ("scattering.png", figure.to_png()?),
    ];
    write_folder(directory, &files, force)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame of clusters with these radii, Å, which all scatter alike.
    fn frame(radii_angstrom: &[Option<f64>]) -> Measured {
        let cluster = |radius: &Option<f64>| ClusterMeasure {
            bodies: 2,
            hydrodynamic_radius_angstrom: *radius,
            light_angstrom6: 1.0,
        };
        Measured {
            structure_factor: Vec::new(),
            intensity: Vec::new(),
            clusters: radii_angstrom.iter().map(cluster).collect(),
        }
    }

    #[test]
    fn clusters_without_a_radius_have_no_polydispersity() {
        let endless = [vec![frame(&[None]); 2], vec![frame(&[None]); 2]];
        assert_eq!(polydispersity(&endless), None);
        let of_power = |power: i32| move |state: &Measured| light(state, power);
        let radius = ratio(&endless, &of_power(0), &of_power(1));
        assert!(radius.mean.is_nan() && radius.error.is_none(), "{radius:?}");
        let alike = [vec![frame(&[Some(20.0), None, Some(20.0)])]];
        assert!(polydispersity(&alike).unwrap() < 1e-12);
        // Rates 1 and 2: mean 3/2, variance 1/4.
        let unlike = [vec![frame(&[Some(20.0), Some(10.0)])]];
        assert!((polydispersity(&unlike).unwrap() - 1.0 / 9.0).abs() < 1e-12);
    }
}
