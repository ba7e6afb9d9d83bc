//! Structures to a set of sparse voxel grids.
//!
//! ```text
//! manifest --each structure, in parallel--> work file SET.zarr.work --all done--> SET.zarr
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`manifest`] | which structures, and what is known of them |
//! | [`settings`] | what to make of each |
//! | [`structure`] | one structure to one sample, or the reason why not |
//! | [`work`] | finished samples, kept until all are done |
//! | [`set`] | samples to a zarr group |
//! | [`identity`] | what sets and samples depend on, hashed |
//! | [`origin`] | what a set has of its manifests, and what it lacks |
//! | [`relatives`] | relatives in different clusters |
//! | [`row`] | a line of a manifest, wherever it stands by now |
//! | [`statistics`] | what values its channels have in the training part |
//! | [`mod@merge`] | several sets to one |

pub mod identity;
pub mod manifest;
pub mod merge;
pub mod origin;
pub mod relatives;
pub mod row;
pub mod set;
pub mod settings;
pub mod statistics;
pub mod structure;
pub mod work;

use crate::input::InputFile;
use crate::interrupt::Interrupt;
use crate::shard::Shard;
use anyhow::{Context, Result, bail};
use manifest::{Entry, Manifest};
use origin::Origin;
use protomer_io::zarr::SetReader;
use rayon::prelude::*;
use row::Row;
use serde::Serialize;
use set::{Exclusion, SetContent};
pub use settings::{Fit, Spacing, VoxelizeSettings};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use structure::Outcome;
use work::WorkFile;

/// How it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// The set was written.
    Written,
    /// The set was there already, from the same inputs and settings.
    NothingToDo,
    /// It was asked to stop; the same command goes on.
    Stopped,
}

/// What became of a manifest.
#[derive(Debug, Clone, Serialize)]
pub struct VoxelizeReport {
    /// The set.
    pub set: PathBuf,
    /// How it ended.
    pub state: State,
    /// Structures of the manifest, or of its part.
    pub structures: usize,
    /// Structures that were voxelised in an earlier run.
    pub taken_over: usize,
    /// Samples in the set, or so far.
    pub samples: usize,
    /// Occupied voxels of all samples.
    pub voxels: u64,
    /// Bytes of the set's files.
    pub bytes: u64,
    /// Time to read one sample back, as done once to check what was written, ms.
    pub read_ms_per_sample: Option<f64>,
    /// Structures left out.
    pub excluded: Vec<Exclusion>,
    /// What of the files of samples a careful user should know, by the sample's name; ten lines of
    /// each at most.
    pub warnings: BTreeMap<String, Vec<String>>,
    /// Relatives that the manifest puts into different clusters; ten lines at most.
    pub manifest_warnings: Vec<String>,
    /// Wall time, s.
    pub seconds: f64,
}

/// Voxelises the structures of a manifest into a set. `begin` hears how many structures are still
/// to be done, `advanced` of each that is.
///
/// # Errors
/// For settings or a manifest that make no sense, an output that holds something else, another
/// process working on it, and a disk that takes no more. What is wrong with a structure excludes it
/// and is in the report.
#[allow(
    clippy::too_many_arguments,
    reason = "two of them only tell of progress"
)]
pub fn voxelize(
    manifest: &Manifest,
    shard: Shard,
    settings: &VoxelizeSettings,
    output: &Path,
    force: bool,
    interrupt: &Interrupt,
    begin: &(dyn Fn(usize) + Sync),
    advanced: &(dyn Fn() + Sync),
) -> Result<VoxelizeReport> {
    let start = Instant::now();
    settings.check()?;
    let entries: Vec<&Entry> = manifest
        .entries
        .iter()
        .filter(|entry| shard.has(entry.number))
        .collect();
    let hashes: Vec<Option<String>> = entries
        .par_iter()
        .map(|entry| InputFile::read(&entry.path).ok().map(|file| file.sha256))
        .collect();
    let rows: Vec<Row> = entries
        .iter()
        .zip(&hashes)
        .map(|(entry, hash)| Row::of_entry(entry, hash.as_deref()))
        .collect();
    let relatives = relatives::in_several_clusters(&rows);
    let identity = identity::identity(settings, &rows)?;
    let report = |state, excluded: Vec<Exclusion>, samples, voxels, taken_over| VoxelizeReport {
        set: output.to_owned(),
        state,
        structures: entries.len(),
        taken_over,
        samples,
        voxels,
        bytes: set::bytes_on_disk(output),
        read_ms_per_sample: None,
        excluded,
        warnings: BTreeMap::new(),
        manifest_warnings: relatives.clone(),
        seconds: start.elapsed().as_secs_f64(),
    };
    match set::state_of(output, &identity)? {
        set::OnDisk::Same(reader) => {
            let excluded = set::exclusions(&reader)?;
            let voxels = (0..reader.len())
                .map(|sample| reader.voxels(sample) as u64)
                .sum();
            let warnings = set::warnings_of(&set::samples_of(&reader)?);
            let report = report(
                State::NothingToDo,
                excluded,
                reader.len(),
                voxels,
                entries.len(),
            );
            return Ok(VoxelizeReport { warnings, ..report });
        }
        set::OnDisk::Other if !force => {
            bail!(
                "{} holds another set; overwrite it with --force or name another output",
                output.display()
            )
        }
        set::OnDisk::Other | set::OnDisk::Nothing => {}
    }
    if let Some(folder) = output.parent() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let work = WorkFile::open(&work_path(output))?;
    let keys = entries
        .iter()
        .zip(&hashes)
        .map(|(entry, hash)| identity::key(settings, entry, hash.as_deref()));
    let keys = keys.collect::<Result<Vec<String>>>()?;
    let pending: Vec<(&Entry, &String)> = entries
        .iter()
        .copied()
        .zip(&keys)
        .filter(|(_, key)| !work.has(key))
        .collect();
    let taken_over = entries.len() - pending.len();
    begin(pending.len());
    pending
        .par_iter()
        .try_for_each(|(entry, key)| -> Result<()> {
            if interrupt.is_requested() {
                return Ok(());
            }
            let outcome = structure::voxelize_structure(entry, settings);
            work.keep(key, &outcome)
                .inspect_err(|_| interrupt.request())?;
            advanced();
            Ok(())
        })?;
    if keys.iter().any(|key| !work.has(key)) {
        let samples = keys.iter().filter(|key| work.has(key)).count();
        return Ok(report(State::Stopped, Vec::new(), samples, 0, taken_over));
    }
    let content = collect(&entries, &hashes, &keys, &work)?;
    let voxels = content.voxels();
    let (samples, excluded) = (content.samples.len(), content.excluded.clone());
    let origin = Origin::new(
        &manifest.sha256,
        manifest.entries.len(),
        shard,
        entries.len(),
    );
    let attributes = set::attributes(settings, &[origin], &identity, &content)?;
    let mut read_ms_per_sample = None;
    set::replace(output, |folder| {
        set::write(folder, settings, &content, attributes, &mut |sample| {
            let Some(entry) = content.samples.get(sample) else {
                bail!("there is no sample {sample}")
            };
            match work.get(&entry.key)? {
                Outcome::Sample(sample) => Ok(sample.voxels),
                Outcome::Excluded { .. } => bail!("{} was excluded", entry.name),
            }
        })?;
        read_ms_per_sample = Some(set::read_back(folder)?);
        Ok(())
    })?;
    work.remove()?;
    let report = report(State::Written, excluded, samples, voxels, taken_over);
    Ok(VoxelizeReport {
        read_ms_per_sample,
        warnings: set::warnings_of(&content.samples),
        ..report
    })
}

/// The work file of a set.
pub fn work_path(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".work");
    output.with_file_name(name)
}

/// Everything about the set but its voxels.
fn collect(
    entries: &[&Entry],
    hashes: &[Option<String>],
    keys: &[String],
    work: &WorkFile,
) -> Result<SetContent> {
    let mut content = SetContent::default();
    for ((entry, hash), key) in entries.iter().zip(hashes).zip(keys) {
        match work.get(key).with_context(|| entry.name.clone())? {
            Outcome::Sample(sample) => {
                content
                    .samples
                    .push(set::SampleRecord::new(entry, hash.as_deref(), key, &sample))
            }
            Outcome::Excluded { reason, detail } => {
                content
                    .excluded
                    .push(Exclusion::new(entry, hash.as_deref(), reason, detail));
            }
        }
    }
    Ok(content)
}

/// Opens a set that must be there.
///
/// # Errors
/// Names the file.
pub fn open_set(path: &Path) -> Result<SetReader> {
    SetReader::open(path).with_context(|| format!("cannot open the set {}", path.display()))
}
