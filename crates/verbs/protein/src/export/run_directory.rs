//! The trajectory and the assembly of a run.

use super::ExportSettings;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::run::{RunSettings, chosen_salt, listed_salts, replica_directory};
use anyhow::{Context, Result, bail};
use protomer_results::{Record, ResultKind, keys};
use std::path::{Path, PathBuf};

/// The trajectory of one simulation, and the assembly it was begun with.
pub(super) struct RunFiles {
    pub(super) trajectory: PathBuf,
    pub(super) assembly: Assembly,
}

impl RunFiles {
    /// Finds the files in the directory of a sweep, or of one simulation of a sweep.
    pub(super) fn find(settings: &ExportSettings) -> Result<Self> {
        let (sweep, simulation) = simulation_in(settings)?;
        let trajectory = trajectory_in(&simulation)?;
        let record = Record::read(&sweep)?;
        let assembly = assembly_of(&sweep, record.as_ref(), settings.assembly.as_deref());
        Ok(Self {
            trajectory,
            assembly: assembly.context(
                "the assembly of this run cannot be used; name the right one with --assembly FILE",
            )?,
        })
    }
}

/// The trajectory in the directory of a run of any engine.
pub(super) fn trajectory_of_run(settings: &ExportSettings) -> Result<PathBuf> {
    let own = settings.input.join(TRAJECTORY);
    match own.is_file() && settings.salt_molar.is_none() && settings.replica.is_none() {
        true => Ok(own),
        false => trajectory_in(&simulation_in(settings)?.1),
    }
}

const TRAJECTORY: &str = "trajectory.gsd";

fn trajectory_in(simulation: &Path) -> Result<PathBuf> {
    let trajectory = simulation.join(TRAJECTORY);
    if !trajectory.is_file() {
        bail!(
            "{} holds no trajectory; a run writes one after its equilibration, unless \
             --trajectory-every is 0",
            simulation.display()
        );
    }
    Ok(trajectory)
}

/// Directories of the sweep and of the requested simulation of it.
fn simulation_in(settings: &ExportSettings) -> Result<(PathBuf, PathBuf)> {
    let directory = settings.input.as_path();
    Ok(match ResultKind::detect(directory) {
        Some(ResultKind::Sweep) => (directory.to_owned(), simulation_of(directory, settings)?),
        Some(ResultKind::Simulation) => (sweep_of(directory, settings)?, directory.to_owned()),
        Some(ResultKind::Pair | ResultKind::PairCondition) => bail!(
            "{0} holds the results of two bodies; their bound poses are files already: look for \
             folders 'poses' in {0}",
            directory.display()
        ),
        Some(other) => bail!(
            "{} holds {other}, which has no bodies; name the directory of a simulation or a sweep",
            directory.display()
        ),
        None => bail!(
            "{} holds no results; name an assembly file, or the directory of a simulation or a \
             sweep",
            directory.display()
        ),
    })
}

/// The requested simulation of a sweep.
fn simulation_of(sweep: &Path, settings: &ExportSettings) -> Result<PathBuf> {
    let run: RunSettings = keys::read_toml(&sweep.join("run.toml"))?;
    let salt = match (settings.salt_molar, run.salt_molar.as_slice()) {
        (None, [only]) => *only,
        (None, salts) => bail!(
            "{} holds several salt concentrations ({}); choose one with --salt",
            sweep.display(),
            listed_salts(salts)
        ),
        (Some(asked), salts) => chosen_salt(sweep, asked, salts)?,
    };
    let replica = settings.replica.unwrap_or(0);
    if replica >= run.replicas {
        let choices = match run.replicas {
            0 | 1 => "0".to_owned(),
            many => format!("0 to {}", many - 1),
        };
        bail!(
            "{} holds no replica {replica}, only {choices}; choose another --replica",
            sweep.display()
        );
    }
    Ok(replica_directory(sweep, salt, replica))
}

/// The sweep that a simulation belongs to: two folders above it.
fn sweep_of(simulation: &Path, settings: &ExportSettings) -> Result<PathBuf> {
    if settings.salt_molar.is_some() || settings.replica.is_some() {
        bail!(
            "{} holds one simulation; leave out --salt and --replica, or name the directory of the \
             whole run",
            simulation.display()
        );
    }
    let path = simulation
        .canonicalize()
        .with_context(|| format!("cannot read {}", simulation.display()))?;
    let sweep = path.ancestors().nth(2);
    Ok(sweep.unwrap_or(simulation).to_owned())
}

/// The assembly of a run: the one that is given, or the one that its record names.
///
/// # Errors
/// If there is none, it cannot be read, or it is not what the results were made from.
pub fn assembly_of(
    directory: &Path,
    record: Option<&Record>,
    given: Option<&Path>,
) -> Result<Assembly> {
    let named = record.and_then(|record| record.details["assembly"].as_str());
    let path = match (given, named) {
        (Some(given), _) => given.to_owned(),
        (None, Some(named)) => directory.join(named),
        (None, None) => bail!("run.json names no assembly"),
    };
    let assembly = Assembly::read(&path)?;
    if let Some(record) = record
        && record.input_sha256 != assembly.sha256
    {
        bail!(
            "{} or a body of it is not what these results were made from",
            path.display()
        );
    }
    Ok(assembly)
}
