//! Voxelises the structures of a manifest into a set, on all threads, with interruption and
//! continuation.

use super::manifest::{Entry, Manifest};
use super::origin::Origin;
use super::records::{Exclusion, SampleRecord, SetContent, exclusions};
use super::row::Row;
use super::settings::VoxelizeSettings;
use super::structure::Outcome;
use super::work::WorkFile;
use super::{identity, relatives, set, structure};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::input::InputFile;
use protomer_io::zarr::SetReader;
use protomer_results::{End, Execution, Shard, each};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// How it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// The set was written.
    Written,
    /// The set already existed, from the same inputs and settings.
    NothingToDo,
    /// It was stopped on request; the same command continues it.
    Stopped,
}

/// The result of voxelising a manifest.
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
    /// Number of samples in the set (so far, if stopped).
    pub samples: usize,
    /// Occupied voxels of all samples.
    pub voxels: u64,
    /// Bytes of the set's files.
    pub bytes: u64,
    /// Mean time to read a sample back, ms; measured in the check after writing.
    pub read_ms_per_sample: Option<f64>,
    /// Structures left out.
    pub excluded: Vec<Exclusion>,
    /// Warnings about input files, by sample; ten lines of each at most.
    pub warnings: BTreeMap<String, Vec<String>>,
    /// Relatives that the manifest puts into different clusters; ten lines at most.
    pub manifest_warnings: Vec<String>,
    /// Wall time, s.
    pub seconds: f64,
}

impl Answer for VoxelizeReport {
    fn text(&self) -> String {
        let set = self.set.display();
        match self.state {
            State::NothingToDo => {
                format!("{set} is complete: {} samples, nothing to do", self.samples)
            }
            State::Stopped => format!(
                "stopped: {} of {} structures done",
                self.samples, self.structures
            ),
            State::Written => {
                let per_sample = |total: u64| total as f64 / self.samples.max(1) as f64;
                format!(
                    "{set}: {} samples, {} left out\n{:.0} voxels and {:.1} kB per sample, {:.1} s",
                    self.samples,
                    self.excluded.len(),
                    per_sample(self.voxels),
                    per_sample(self.bytes) / 1000.0,
                    self.seconds
                )
            }
        }
    }
}

/// Voxelises the structures of a manifest, or a part of them, into a set.
///
/// # Errors
/// For invalid settings or manifest, an output that holds something else or is in use by another
/// process, or a file that cannot be written. An error in a structure only excludes it, and is
/// reported.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_training::voxels::{VoxelizeSettings, manifest::Manifest, voxelize};
/// use protomer_results::{Execution, Shard};
/// use std::path::Path;
/// let manifest = Manifest::read(Path::new("set.csv"))?;
/// let settings = VoxelizeSettings { size: 32, ..VoxelizeSettings::default() };
/// let (output, execution) = (Path::new("set.zarr"), Execution::default());
/// let report = voxelize(&manifest, Shard::WHOLE, &settings, output, &execution)?;
/// println!("{}", report.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn voxelize(
    manifest: &Manifest,
    shard: Shard,
    settings: &VoxelizeSettings,
    output: &Path,
    execution: &Execution,
) -> Result<VoxelizeReport> {
    let start = Instant::now();
    settings.check()?;
    let part = Part::new(manifest, shard, settings)?;
    let mut report = part.report(output);
    match set::state_of(output, &part.identity)? {
        set::OnDisk::Same(reader) => report.describe_present(&reader)?,
        set::OnDisk::Other if !execution.start_anew => {
            bail!(
                "{} holds another set; overwrite it with --force or name another output",
                output.display()
            )
        }
        set::OnDisk::Other | set::OnDisk::Nothing => part.make(output, execution, &mut report)?,
    }
    report.bytes = set::bytes_on_disk(output);
    report.seconds = start.elapsed().as_secs_f64();
    Ok(report)
}

/// The structures of a manifest that one process voxelises.
struct Part<'a> {
    manifest: &'a Manifest,
    shard: Shard,
    settings: &'a VoxelizeSettings,
    entries: Vec<&'a Entry>,
    /// SHA-256 of each readable file.
    hashes: Vec<Option<String>>,
    identity: String,
}

impl<'a> Part<'a> {
    fn new(manifest: &'a Manifest, shard: Shard, settings: &'a VoxelizeSettings) -> Result<Self> {
        let entries: Vec<&Entry> = manifest
            .entries
            .iter()
            .filter(|entry| shard.has(entry.number))
            .collect();
        let hashes: Vec<Option<String>> = entries
            .par_iter()
            .map(|entry| InputFile::read(&entry.path).ok().map(|file| file.sha256))
            .collect();
        let mut part = Self {
            manifest,
            shard,
            settings,
            entries,
            hashes,
            identity: String::new(),
        };
        part.identity = identity::identity(settings, &part.rows())?;
        Ok(part)
    }

    fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::with_capacity(self.entries.len());
        for (entry, hash) in self.entries.iter().zip(&self.hashes) {
            rows.push(Row::new(entry, hash.as_deref()));
        }
        rows
    }

    /// The initial report of a set.
    fn report(&self, output: &Path) -> VoxelizeReport {
        VoxelizeReport {
            set: output.to_owned(),
            state: State::Stopped,
            structures: self.entries.len(),
            taken_over: 0,
            samples: 0,
            voxels: 0,
            bytes: 0,
            read_ms_per_sample: None,
            excluded: Vec::new(),
            warnings: BTreeMap::new(),
            manifest_warnings: relatives::in_several_clusters(&self.rows()),
            seconds: 0.0,
        }
    }

    /// Voxelises the structures that no earlier run has done, and writes the set once all are done.
    fn make(
        &self,
        output: &Path,
        execution: &Execution,
        report: &mut VoxelizeReport,
    ) -> Result<()> {
        if let Some(folder) = output.parent() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        }
        let work = WorkFile::open(&work_path(output))?;
        let keys = self.keys()?;
        report.taken_over = keys.iter().filter(|key| work.has(key)).count();
        if self.voxelize_missing(&keys, &work, execution)? == End::Stopped {
            report.samples = keys.iter().filter(|key| work.has(key)).count();
            return Ok(());
        }
        let content = collect(&self.entries, &self.hashes, keys, &work)?;
        report.samples = content.samples.len();
        report.voxels = content.voxels();
        report.warnings = set::warnings_of(&content.samples);
        report.excluded = content.excluded.clone();
        report.read_ms_per_sample = Some(self.write(output, content, &work)?);
        work.remove()?;
        report.state = State::Written;
        Ok(())
    }

    /// The key of each sample.
    fn keys(&self) -> Result<Vec<String>> {
        let mut keys = Vec::with_capacity(self.entries.len());
        for (entry, hash) in self.entries.iter().zip(&self.hashes) {
            keys.push(identity::key(self.settings, entry, hash.as_deref())?);
        }
        Ok(keys)
    }

    fn voxelize_missing(
        &self,
        keys: &[String],
        work: &WorkFile,
        execution: &Execution,
    ) -> Result<End<()>> {
        let mut missing: Vec<(&Entry, &String)> = Vec::new();
        for (entry, key) in self.entries.iter().zip(keys) {
            if !work.has(key) {
                missing.push((entry, key));
            }
        }
        let progress = &execution.progress;
        progress.begin(missing.len() as u64, "structures");
        let one = |(entry, key): &(&Entry, &String)| -> Result<End<()>> {
            if execution.interrupt.is_requested() {
                return Ok(End::Stopped);
            }
            work.keep(key, &structure::voxelize_structure(entry, self.settings))?;
            progress.advance(1);
            Ok(End::Finished(()))
        };
        Ok(each(&missing, &execution.interrupt, one)?.map(drop))
    }

    /// Writes the set, and returns the mean time to read a sample back, ms. What is read back takes as
    /// much memory as the content, which is gone by then.
    fn write(&self, output: &Path, content: SetContent, work: &WorkFile) -> Result<f64> {
        let origin = Origin::new(
            &self.manifest.sha256,
            self.manifest.entries.len(),
            self.shard,
            self.entries.len(),
        );
        let attributes = set::attributes(self.settings, &[origin], &self.identity, &content)?;
        let mut read_ms_per_sample = f64::NAN;
        set::replace(output, |folder| {
            let mut voxels = |sample: usize| {
                let Some(entry) = content.samples.get(sample) else {
                    bail!("there is no sample {sample}")
                };
                match work.get(&entry.key)? {
                    Outcome::Sample(sample) => Ok(sample.voxels),
                    Outcome::Excluded { .. } => bail!("{} was excluded", entry.row.name),
                }
            };
            set::write(folder, self.settings, &content, attributes, &mut voxels)?;
            drop(content);
            read_ms_per_sample = set::read_back(folder)?;
            Ok(())
        })?;
        Ok(read_ms_per_sample)
    }
}

impl VoxelizeReport {
    /// Reports on the existing set.
    fn describe_present(&mut self, reader: &SetReader) -> Result<()> {
        self.state = State::NothingToDo;
        self.taken_over = self.structures;
        self.samples = reader.len();
        for sample in 0..reader.len() {
            self.voxels += reader.voxels(sample) as u64;
        }
        self.warnings = set::warnings_of(&set::samples_of(reader)?);
        self.excluded = exclusions(reader)?;
        Ok(())
    }
}

/// The work file of a set.
pub fn work_path(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".work");
    output.with_file_name(name)
}

/// The content of the set, except for its voxels.
fn collect(
    entries: &[&Entry],
    hashes: &[Option<String>],
    keys: Vec<String>,
    work: &WorkFile,
) -> Result<SetContent> {
    let mut content = SetContent::default();
    for ((entry, hash), key) in entries.iter().zip(hashes).zip(keys) {
        let row = Row::new(entry, hash.as_deref());
        match work.get(&key).with_context(|| entry.name.clone())? {
            Outcome::Sample(sample) => content.samples.push(SampleRecord {
                row,
                key,
                voxels: sample.voxels.index.len(),
                properties: sample.properties,
                warnings: sample.warnings,
            }),
            Outcome::Excluded { reason, detail } => content.excluded.push(Exclusion {
                row,
                reason,
                detail,
            }),
        }
    }
    Ok(content)
}

/// Opens an existing set.
///
/// # Errors
/// Names the file.
pub fn open_set(path: &Path) -> Result<SetReader> {
    SetReader::open(path).with_context(|| format!("cannot open the set {}", path.display()))
}
