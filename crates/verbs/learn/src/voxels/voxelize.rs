//! Voxelises the structures of a manifest into a set, on all threads, with interruption and
//! continuation.

use super::attributes::Making;
use super::body_store::BodyStore;
use super::content::Content;
use super::finished::Finished;
use super::interface::InterfaceBodies;
use super::manifest::Manifest;
use super::origin::Origin;
use super::part::Part;
use super::records::Exclusion;
use super::settings::VoxelizeSettings;
use super::work::WorkFile;
use super::{relatives, set, structure};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_io::zarr::{self, SampleReader, SetReader};
use protomer_results::{End, Execution, Shard, each};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// State in which the work on a set ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// The set was written.
    Written,
    /// The set already existed, from the same inputs and settings.
    NothingToDo,
    /// The work was stopped on request; the same command continues it.
    Stopped,
}

/// The result of voxelising a manifest.
#[derive(Debug, Clone, Serialize)]
pub struct VoxelizeReport {
    /// The set.
    pub set: PathBuf,
    /// State in which the work ended.
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

/// Voxelises the structures of a manifest, or a part of them, into a set, and makes their bodies if there
/// is a store for them and the set does not exist yet.
///
/// # Errors
/// For invalid settings or manifest, an output that holds something else or is in use by another
/// process, a structure file that changes meanwhile, or a file that cannot be written. An error in a structure only excludes it, and is
/// reported.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_learn_verbs::voxels::{VoxelizeSettings, manifest::Manifest, voxelize};
/// use protomer_results::{Execution, Shard};
/// use std::path::Path;
/// let manifest = Manifest::read(Path::new("set.csv"))?;
/// let settings = VoxelizeSettings { size: 32, ..VoxelizeSettings::default() };
/// let (output, execution) = (Path::new("set.zarr"), Execution::default());
/// let report = voxelize(&manifest, Shard::WHOLE, &settings, None, output, &execution)?;
/// println!("{}", report.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn voxelize(
    manifest: &Manifest,
    shard: Shard,
    settings: &VoxelizeSettings,
    bodies: Option<&dyn BodyStore>,
    output: &Path,
    execution: &Execution,
) -> Result<VoxelizeReport> {
    let start = Instant::now();
    settings.check()?;
    let body_density = bodies.map(BodyStore::density_per_angstrom2);
    let part = Part::new(manifest, shard, settings, body_density)?;
    let mut report = part.report(output)?;
    match set::state_of(output, &part.identity)? {
        set::OnDisk::Same(reader) => {
            report.describe_present(&reader)?;
            // A killed process may have left the work file after the set was complete.
            part.remove_work_file(output)?;
        }
        set::OnDisk::Other if !execution.start_anew => {
            bail!(
                "{} holds another set: a setting differs, or an input file has changed since; \
                 overwrite it with --force or name another output",
                output.display()
            )
        }
        set::OnDisk::Other | set::OnDisk::Nothing => {
            part.make(output, bodies, execution, &mut report)?;
        }
    }
    report.bytes = set::bytes_on_disk(output);
    report.seconds = start.elapsed().as_secs_f64();
    Ok(report)
}

impl Part<'_> {
    /// The initial report of a set.
    fn report(&self, output: &Path) -> Result<VoxelizeReport> {
        let row = |structure| self.row(structure);
        Ok(VoxelizeReport {
            set: output.to_owned(),
            state: State::Stopped,
            structures: self.len(),
            taken_over: 0,
            samples: 0,
            voxels: 0,
            bytes: 0,
            read_ms_per_sample: None,
            excluded: Vec::new(),
            warnings: BTreeMap::new(),
            manifest_warnings: relatives::in_several_clusters(self.len(), row)?,
            seconds: 0.0,
        })
    }

    /// Voxelises the structures that no earlier run has done, and writes the set once all are done.
    fn make(
        &self,
        output: &Path,
        bodies: Option<&dyn BodyStore>,
        execution: &Execution,
        report: &mut VoxelizeReport,
    ) -> Result<()> {
        if let Some(folder) = output.parent() {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        }
        let keys = (0..self.len()).map(|structure| self.key(structure));
        // The work file lies next to the set, so that an unfinished set never looks like one.
        let work = WorkFile::open(&work_path(output), keys)?;
        let missing = work.missing();
        report.taken_over = self.len() - missing.len();
        if self.voxelize_missing(&missing, &work, bodies, execution)? == End::Stopped {
            report.samples = self.len() - work.missing().len();
            return Ok(());
        }
        // The list is long for a large manifest; the memory is needed now.
        drop(missing);
        // Bodies' tables in the order of the manifest, whichever thread made them first.
        if let Some(bodies) = bodies {
            let records = (0..self.len()).map(|structure| work.get(structure));
            bodies
                .finish(&mut records.filter_map(|done| done.map(|done| done.body).transpose()))?;
        }
        let finished = Finished::count(self, &work)?;
        report.samples = finished.len();
        report.voxels = finished.voxels();
        // The set appears whole; the work file goes only after that.
        report.read_ms_per_sample = Some(self.write(output, &finished)?);
        (report.excluded, report.warnings) = finished.into_notes();
        work.remove()?;
        report.state = State::Written;
        Ok(())
    }

    /// Removes the work file of a finished set, which a process killed at its end has left.
    fn remove_work_file(&self, output: &Path) -> Result<()> {
        let path = work_path(output);
        if !path.is_file() {
            return Ok(());
        }
        let keys = (0..self.len()).map(|structure| self.key(structure));
        // Opened first, which takes its lock: nobody else is at work on it.
        WorkFile::open(&path, keys)?.remove()
    }

    fn voxelize_missing(
        &self,
        missing: &[usize],
        work: &WorkFile,
        bodies: Option<&dyn BodyStore>,
        execution: &Execution,
    ) -> Result<End<()>> {
        let progress = &execution.progress;
        progress.begin(missing.len() as u64, "structures");
        let interfaces = InterfaceBodies::default();
        let one = |structure: &usize| -> Result<End<()>> {
            if execution.interrupt.is_requested() {
                return Ok(End::Stopped);
            }
            let entry = self.entry(*structure)?;
            let done = structure::voxelize_structure(&entry, self.settings, bodies, &interfaces)?;
            // After the work: a file that changed meanwhile must not get the key of the old one.
            self.require_unchanged(*structure)?;
            work.keep(*structure, self.key(*structure)?, &done)?;
            progress.advance(1);
            Ok(End::Finished(()))
        };
        Ok(each(missing, &execution.interrupt, one)?.map(drop))
    }

    /// Writes the set, and returns the mean time to read a sample back, ms.
    fn write(&self, output: &Path, content: &Finished) -> Result<f64> {
        let structures = self.manifest.len();
        let origin = Origin::new(&self.manifest.sha256, structures, self.shard, self.len());
        let making = Making {
            settings: self.settings,
            origins: &[origin],
            identity: &self.identity,
        };
        // NaN until it was read back.
        let mut read_ms_per_sample = f64::NAN;
        set::replace(output, |folder| {
            set::write(folder, making, content)?;
            read_ms_per_sample = set::read_back(folder)?;
            Ok(())
        })?;
        Ok(read_ms_per_sample)
    }
}

impl VoxelizeReport {
    /// Reports on the existing set.
    fn describe_present(&mut self, reader: &SampleReader) -> Result<()> {
        #[derive(Default, Deserialize)]
        #[serde(default)]
        struct Notes {
            excluded: Vec<Exclusion>,
            warnings: BTreeMap<String, Vec<String>>,
        }
        self.state = State::NothingToDo;
        self.taken_over = self.structures;
        self.samples = reader.len();
        for sample in 0..reader.len() {
            self.voxels += reader.voxels(sample) as u64;
        }
        let Notes { excluded, warnings } = zarr::attributes(&self.set)?;
        (self.excluded, self.warnings) = (excluded, warnings);
        Ok(())
    }
}

/// The work file of a set.
pub fn work_path(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".work");
    output.with_file_name(name)
}

/// Opens an existing set.
///
/// # Errors
/// Names the file.
pub fn open_set(path: &Path) -> Result<SetReader> {
    SetReader::open(path).with_context(|| format!("cannot open the set {}", path.display()))
}
