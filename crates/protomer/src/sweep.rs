//! A sweep: salt concentrations × replicas, on all threads, resumable, with one table and one
//! figure at the end.
//!
//! ```text
//! DIR/run.toml  run.json  sweep.csv  sweep.json  sweep.svg  sweep.png
//! DIR/salt_0.100000M/replica_0/ log.csv trajectory.gsd checkpoint.bin run.json
//! ```

use crate::interaction::ScreenedCoulomb;
use crate::run::{
    Engine, Execution, Hold, Layout, ReplicaCounts, ReplicaEnd, ReplicaTask, ResultsDirectory,
    RunRecord, RunSettings, SWEEP, lock, read_log, read_record, refuse, run_replica, salt_label,
};
use crate::shard::Shard;
use crate::sweep_figure;
use crate::sweep_table::{ReplicaResult, SaltRow, to_csv};
use anyhow::{Context, Result, bail};
use protomer_io::atomic::{sha256_hex, write_atomically};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// How a part of a sweep ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShardEnd {
    /// So many simulations are done.
    Finished(usize),
    /// It was asked to stop; the same command goes on.
    Stopped,
}

/// The directory of a sweep.
const LAYOUT: Layout = Layout {
    settings: "run.toml",
    holds: SWEEP,
    results: &[
        "run.json",
        "sweep.csv",
        "sweep.json",
        "sweep.svg",
        "sweep.png",
        "report.html",
    ],
    is_result: is_simulation,
};

/// What a sweep leaves behind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepResult {
    /// Version of the program.
    pub version: String,
    /// SHA-256 of the assembly and its bodies.
    pub input_sha256: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Concentration of the bodies, mol/L; zero in open space.
    #[serde(rename = "concentration_M")]
    pub concentration_molar: f64,
    /// Edge lengths of the box, Å; `None` without a box.
    pub box_angstrom: Option<[f64; 3]>,
    /// The resolved settings.
    pub settings: RunSettings,
    /// One row per salt concentration.
    pub salts: Vec<SaltRow>,
    /// The replicas behind each row.
    pub replicas: Vec<Vec<ReplicaResult>>,
}

/// How a sweep ended.
#[derive(Debug, Clone, PartialEq)]
pub enum SweepEnd {
    /// Everything is done.
    Finished(Box<SweepResult>),
    /// It was asked to stop; the same command goes on.
    Stopped,
}

/// Whether this is the folder of the simulations at one salt concentration.
fn is_simulation(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("salt_") && name.ends_with('M') && path.join("replica_0").is_dir()
}

/// Runs or continues a sweep in a directory. `advanced` hears how many sweeps of all simulations
/// were done.
///
/// # Errors
/// For settings or a start that make no sense, a directory that holds another sweep or that another
/// process works in, and a disk that takes no more. The first simulation that fails stops the
/// others at their next sweep; what they did is kept, and `run.json` says what happened.
pub fn run_sweep(
    engine: &Engine,
    settings: &RunSettings,
    directory: &Path,
    execution: &Execution,
    advanced: &(dyn Fn(u64) + Sync),
) -> Result<SweepEnd> {
    let interactions = interactions(engine, settings)?;
    let identity = identity(engine, settings)?;
    let record = |exit_reason: &str| record(engine, directory, &identity, exit_reason);
    let continues = |present: &RunSettings| continues(directory, present, settings, &identity);
    let entered =
        ResultsDirectory::enter(directory, LAYOUT, settings, execution.start_anew, continues)?;
    // A finished sweep stays one, whatever becomes of a second look at it; one that is to be longer
    // is finished no more.
    let was_done = !entered.settings_are_new()
        && read_record(directory)?.is_some_and(|present| present.is_done());
    if !was_done {
        record("running").write(directory)?;
    }
    let work = Work {
        engine,
        settings,
        interactions: &interactions,
        identity: &identity,
        directory,
    };
    let end = work.to_the_end(execution, advanced);
    match &end {
        Ok(SweepEnd::Finished(_)) => record("done").write(directory)?,
        Ok(SweepEnd::Stopped) => record("stopped")
            .stopped_by(&execution.interrupt)
            .write(directory)?,
        Err(_) if was_done => {}
        // The error is what counts; on a full disk there may be no room for the record either.
        Err(error) => drop(record(&format!("{error:#}")).write(directory)),
    }
    end
}

/// Runs or continues the simulations of one part of a sweep, while other processes do other parts
/// in the same directory. [`run_sweep`] finds them done and writes the table and the figure.
///
/// # Errors
/// As [`run_sweep`].
pub fn run_shard(
    engine: &Engine,
    settings: &RunSettings,
    directory: &Path,
    shard: Shard,
    execution: &Execution,
    advanced: &(dyn Fn(u64) + Sync),
) -> Result<ShardEnd> {
    let interactions = interactions(engine, settings)?;
    let identity = identity(engine, settings)?;
    let continues = |present: &RunSettings| continues(directory, present, settings, &identity);
    let entered =
        ResultsDirectory::share(directory, LAYOUT, settings, execution.start_anew, continues)?;
    if entered.settings_are_new() {
        record(engine, directory, &identity, "running").write(directory)?;
    }
    let work = Work {
        engine,
        settings,
        interactions: &interactions,
        identity: &identity,
        directory,
    };
    let mine: Vec<(usize, u32)> = tasks(settings)
        .into_iter()
        .enumerate()
        .filter(|(number, _)| shard.has(*number))
        .map(|(_, task)| task)
        .collect();
    let counts = work.simulate(&mine, Hold::Shared, execution, advanced)?;
    Ok(counts.map_or(ShardEnd::Stopped, |counts| ShardEnd::Finished(counts.len())))
}

/// What the simulations of a sweep have in common.
struct Work<'a> {
    engine: &'a Engine,
    settings: &'a RunSettings,
    interactions: &'a [ScreenedCoulomb],
    identity: &'a str,
    directory: &'a Path,
}

impl Work<'_> {
    /// Simulates everything, and writes the table and the figure.
    fn to_the_end(
        &self,
        execution: &Execution,
        advanced: &(dyn Fn(u64) + Sync),
    ) -> Result<SweepEnd> {
        let Some(counts) =
            self.simulate(&tasks(self.settings), Hold::Alone, execution, advanced)?
        else {
            return Ok(SweepEnd::Stopped);
        };
        let result = collect(
            self.engine,
            self.settings,
            self.interactions,
            self.directory,
            &counts,
        )?;
        write_results(&result, self.directory)?;
        Ok(SweepEnd::Finished(Box::new(result)))
    }

    /// Runs these simulations; none if they were stopped. The first that fails stops the others.
    fn simulate(
        &self,
        tasks: &[(usize, u32)],
        hold: Hold,
        execution: &Execution,
        advanced: &(dyn Fn(u64) + Sync),
    ) -> Result<Option<Vec<ReplicaCounts>>> {
        let one = |&(salt_index, replica): &(usize, u32)| {
            let salt = self.settings.salt_molar[salt_index];
            let end = self.simulate_one(salt_index, replica, hold, execution, advanced);
            if end.is_err() {
                execution.interrupt.request_after_failure();
            }
            end.with_context(|| format!("salt {salt} M, replica {replica}"))
        };
        let ends: Vec<Result<ReplicaEnd>> = tasks.par_iter().map(one).collect();
        let ends = ends.into_iter().collect::<Result<Vec<ReplicaEnd>>>()?;
        Ok(ends.into_iter().map(ReplicaEnd::finished).collect())
    }

    fn simulate_one(
        &self,
        salt_index: usize,
        replica: u32,
        hold: Hold,
        execution: &Execution,
        advanced: &(dyn Fn(u64) + Sync),
    ) -> Result<ReplicaEnd> {
        let directory = replica_directory(
            self.directory,
            self.settings.salt_molar[salt_index],
            replica,
        );
        // Where the sweep is shared, a process that was given up for lost may still be at work
        // here.
        let _mine = match hold {
            Hold::Shared => {
                std::fs::create_dir_all(&directory).with_context(|| {
                    format!("cannot make the directory {}", directory.display())
                })?;
                Some(lock(&directory, Hold::Alone)?)
            }
            Hold::Alone => None,
        };
        let task = ReplicaTask {
            engine: self.engine,
            settings: self.settings,
            interaction: self.interactions[salt_index],
            salt_index: salt_index as u32,
            replica,
            directory,
            identity: self.identity,
        };
        run_replica(&task, execution, advanced)
    }
}

fn interactions(engine: &Engine, settings: &RunSettings) -> Result<Vec<ScreenedCoulomb>> {
    settings.check()?;
    let of_salt = |salt: &f64| settings.medium.interaction(Some(*salt));
    let interactions = settings
        .salt_molar
        .iter()
        .map(of_salt)
        .collect::<Result<Vec<ScreenedCoulomb>>>()?;
    engine.check(settings, &interactions)?;
    Ok(interactions)
}

/// Whether the sweep of a directory is this one, whose length may have grown.
fn continues(
    path: &Path,
    present: &RunSettings,
    settings: &RunSettings,
    identity: &str,
) -> Result<bool> {
    if present.without_length() != settings.without_length() {
        return Ok(false);
    }
    if read_record(path)?.is_some_and(|record| record.identity != identity) {
        return refuse(path, LAYOUT, "input");
    }
    if present.sweeps > settings.sweeps {
        bail!(
            "{} is meant to run to {} sweeps, which is more than {}; ask for at least as many, or choose another directory",
            path.display(),
            present.sweeps,
            settings.sweeps
        );
    }
    Ok(true)
}

/// Every simulation of the sweep, the first replica of every salt first: an interrupted sweep has a
/// whole curve early.
fn tasks(settings: &RunSettings) -> Vec<(usize, u32)> {
    let salts = 0..settings.salt_molar.len();
    (0..settings.replicas)
        .flat_map(|replica| salts.clone().map(move |salt| (salt, replica)))
        .collect()
}

/// The directory of one simulation.
pub fn replica_directory(directory: &Path, salt_molar: f64, replica: u32) -> PathBuf {
    directory
        .join(salt_label(salt_molar))
        .join(format!("replica_{replica}"))
}

/// SHA-256 of everything that shapes the result but its length.
fn identity(engine: &Engine, settings: &RunSettings) -> Result<String> {
    let text = toml::to_string_pretty(&settings.without_length())
        .context("the settings cannot be written down")?;
    Ok(sha256_hex(
        format!("{text}{}", engine.assembly().sha256).as_bytes(),
    ))
}

fn record(engine: &Engine, directory: &Path, identity: &str, exit_reason: &str) -> RunRecord {
    RunRecord {
        version: env!("CARGO_PKG_VERSION").into(),
        verb: "sweep".into(),
        identity: identity.into(),
        input_sha256: engine.assembly().sha256.clone(),
        exit_reason: exit_reason.into(),
        // Where a report finds the shapes of the bodies.
        details: serde_json::json!({ "assembly": engine.assembly().path_from(directory) }),
    }
}

/// Averages every log.
fn collect(
    engine: &Engine,
    settings: &RunSettings,
    interactions: &[ScreenedCoulomb],
    directory: &Path,
    counts: &[ReplicaCounts],
) -> Result<SweepResult> {
    let mut replicas = vec![Vec::new(); settings.salt_molar.len()];
    for ((salt, replica), counts) in tasks(settings).into_iter().zip(counts) {
        let folder = replica_directory(directory, settings.salt_molar[salt], replica);
        let rows = read_log(&folder.join("log.csv"))?;
        replicas[salt].push(ReplicaResult::new(replica, &rows, *counts));
    }
    let salts = settings.salt_molar.iter().zip(interactions).zip(&replicas);
    let assembly = engine.assembly();
    Ok(SweepResult {
        version: env!("CARGO_PKG_VERSION").into(),
        input_sha256: assembly.sha256.clone(),
        bodies: assembly.len(),
        concentration_molar: assembly.concentration_molar(),
        box_angstrom: assembly.box_angstrom(),
        settings: settings.clone(),
        salts: salts
            .map(|((salt, interaction), replicas)| SaltRow::new(*salt, interaction, replicas))
            .collect(),
        replicas,
    })
}

fn write_results(result: &SweepResult, directory: &Path) -> Result<()> {
    let csv = to_csv(&result.salts)?;
    let json = serde_json::to_string_pretty(result).context("the result cannot be written down")?;
    write_atomically(&directory.join("sweep.csv"), |file| {
        file.write_all(csv.as_bytes())
    })?;
    write_atomically(&directory.join("sweep.json"), |file| {
        writeln!(file, "{json}")
    })?;
    sweep_figure::write(result, directory)
}
