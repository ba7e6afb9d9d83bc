//! Merges several sets into one.

use super::attributes::Making;
use super::content::Content;
use super::identity::identity;
use super::origin::{Missing, Origin, joined, origins};
use super::records::{Exclusion, SampleRecord, exclusions};
use super::row::Row;
use super::set;
use super::settings::VoxelizeSettings;
use super::structure::Properties;
use super::{open_set, relatives};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_field::voxels::Voxels;
use protomer_io::zarr::{SetReader, StoredSample};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// The result of a merge.
#[derive(Debug, Clone, Serialize)]
pub struct MergeReport {
    /// The set.
    pub set: PathBuf,
    /// Number of merged sets.
    pub sets: usize,
    /// Samples in the set.
    pub samples: usize,
    /// Structures left out of the sets.
    pub excluded: usize,
    /// Occupied voxels of all samples.
    pub voxels: u64,
    /// Bytes of the set's files.
    pub bytes: u64,
    /// Manifests with missing parts.
    pub missing: Vec<Missing>,
    /// Relatives in different clusters; ten lines at most.
    pub manifest_warnings: Vec<String>,
    /// Whether the set already existed.
    pub nothing_to_do: bool,
}

impl Answer for MergeReport {
    fn text(&self) -> String {
        let end = if self.nothing_to_do {
            ", nothing to do"
        } else {
            ""
        };
        format!(
            "{}: {} samples of {} sets, {} left out{end}",
            self.set.display(),
            self.samples,
            self.sets,
            self.excluded
        )
    }
}

/// Merges sets with the same settings. Parts of one manifest are sorted like the manifest, so that
/// all parts together give the same files as a single run. Sets of different manifests follow each
/// other in the given order. The report lists missing parts.
///
/// # Errors
/// If settings differ, a name appears in two sets, or a file cannot be read.
///
/// ```no_run
/// use std::path::Path;
/// let parts = ["part_1.zarr".into(), "part_2.zarr".into()];
/// let report = protomer_learn_verbs::voxels::merge::merge(&parts, Path::new("set.zarr"), false)?;
/// assert_eq!(report.sets, 2);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn merge(inputs: &[PathBuf], output: &Path, force: bool) -> Result<MergeReport> {
    let sources = Sources::read(inputs)?;
    let rows = sources.rows();
    let identity = identity(&sources.settings, || rows.iter().cloned().map(Ok))?;
    let row = |number: usize| rows.get(number).cloned().context("there is no such row");
    let nothing_to_do = match set::state_of(output, &identity)? {
        set::OnDisk::Same(_) => true,
        set::OnDisk::Other if !force => {
            bail!(
                "{} holds another set: other parts, or parts that have changed since; overwrite it \
                 with --force or name another output",
                output.display()
            )
        }
        set::OnDisk::Other | set::OnDisk::Nothing => {
            sources.write(output, &identity)?;
            false
        }
    };
    Ok(MergeReport {
        set: output.to_owned(),
        sets: inputs.len(),
        samples: sources.len(),
        excluded: sources.excluded.len(),
        voxels: sources.voxels(),
        bytes: set::bytes_on_disk(output),
        missing: Missing::find(&sources.manifests),
        manifest_warnings: relatives::in_several_clusters(rows.len(), row)?,
        nothing_to_do,
    })
}

/// The sets to merge, and the content of the merged set.
struct Sources {
    readers: Vec<SetReader>,
    settings: VoxelizeSettings,
    manifests: Vec<Origin>,
    samples: Vec<Source>,
    excluded: Vec<Exclusion>,
    warnings: BTreeMap<String, Vec<String>>,
    /// Whether the sets are parts of one manifest, which then determines the order.
    one_manifest: bool,
}

/// A sample, the number of its set and its index there.
struct Source {
    record: SampleRecord,
    set: usize,
    index: usize,
}

impl Sources {
    fn read(inputs: &[PathBuf]) -> Result<Self> {
        let mut readers = Vec::with_capacity(inputs.len());
        let mut of_each = Vec::with_capacity(inputs.len());
        for path in inputs {
            readers.push(open_set(path)?);
        }
        let settings = common_settings(&readers, inputs)?;
        for (reader, path) in readers.iter().zip(inputs) {
            of_each.push(origins(reader).context(path.display().to_string())?);
        }
        // A set merged from several manifests has no common order of entries.
        // Merged sets keep only the order in which they were merged.
        let parts_of_one = of_each.iter().all(|of_one| of_one.len() == 1);
        let manifests = joined(of_each.into_iter().flatten());
        let one_manifest = parts_of_one && manifests.len() == 1;
        let (samples, excluded) = joined_content(&readers, inputs, one_manifest)?;
        Ok(Self {
            readers,
            settings,
            manifests,
            warnings: warnings_of(&samples),
            samples,
            excluded,
            one_manifest,
        })
    }

    /// The rows of samples, then of excluded structures.
    fn rows(&self) -> Vec<Row> {
        let samples = self.samples.iter().map(|sample| &sample.record.row);
        let excluded = self.excluded.iter().map(|excluded| &excluded.row);
        let mut rows: Vec<Row> = samples.chain(excluded).cloned().collect();
        if self.one_manifest {
            // As a single run would have written them.
            rows.sort_by_key(|row| row.entry);
        }
        rows
    }

    fn write(&self, output: &Path, identity: &str) -> Result<()> {
        let making = Making {
            settings: &self.settings,
            origins: &self.manifests,
            identity,
        };
        set::replace(output, |folder| set::write(folder, making, self))
    }

    fn source(&self, sample: usize) -> Result<&Source> {
        let source = self.samples.get(sample);
        source.with_context(|| format!("there is no sample {sample}"))
    }
}

impl Content for Sources {
    fn len(&self) -> usize {
        self.samples.len()
    }

    fn voxels(&self) -> u64 {
        let samples = self.samples.iter();
        samples.map(|sample| sample.record.voxels as u64).sum()
    }

    fn row(&self, sample: usize) -> Result<Row> {
        Ok(self.source(sample)?.record.row.clone())
    }

    fn sample(&self, sample: usize) -> Result<(Properties, Voxels)> {
        let Source { record, set, index } = self.source(sample)?;
        let reader = self.readers.get(*set).context("there is no such set")?;
        let StoredSample { index, values } = reader.sample(*index)?;
        Ok((record.properties.clone(), Voxels { index, values }))
    }

    fn excluded(&self) -> &[Exclusion] {
        &self.excluded
    }

    fn warnings(&self) -> &BTreeMap<String, Vec<String>> {
        &self.warnings
    }
}

/// The settings that all sets have in common.
fn common_settings(readers: &[SetReader], inputs: &[PathBuf]) -> Result<VoxelizeSettings> {
    let (Some(first), Some(first_path)) = (readers.first(), inputs.first()) else {
        bail!("no sets are given; give at least one")
    };
    let settings = set::settings_of(first).context(first_path.display().to_string())?;
    for (reader, path) in readers.iter().zip(inputs) {
        let theirs = set::settings_of(reader).context(path.display().to_string())?;
        if theirs != settings {
            let how = differences(&settings, &theirs)?;
            let (a, b) = (first_path.display(), path.display());
            bail!("{a} and {b} have different settings: {how}; voxelize them alike");
        }
    }
    Ok(settings)
}

/// The samples and the exclusions of all sets. They are sorted by entry if the sets
/// are parts of one manifest.
fn joined_content(
    readers: &[SetReader],
    inputs: &[PathBuf],
    one_manifest: bool,
) -> Result<(Vec<Source>, Vec<Exclusion>)> {
    let mut samples: Vec<Source> = Vec::new();
    let mut excluded = Vec::new();
    let mut paths: HashMap<String, &PathBuf> = HashMap::new();
    for ((number, reader), path) in readers.iter().enumerate().zip(inputs) {
        let of_set = set::samples_of(reader).context(path.display().to_string())?;
        let exclusions = exclusions(reader).context(path.display().to_string())?;
        // Sorted, so that the message is always about the same name.
        let mut names = BTreeSet::new();
        names.extend(of_set.iter().map(|sample| sample.row.name.clone()));
        names.extend(exclusions.iter().map(|excluded| excluded.row.name.clone()));
        for name in names {
            // A name may stand in one set only, be it as a sample or as an exclusion.
            if let Some(earlier) = paths.insert(name.clone(), path) {
                bail!(
                    "'{name}' is in {} and in {}; give each part once",
                    earlier.display(),
                    path.display()
                );
            }
        }
        for (index, record) in of_set.into_iter().enumerate() {
            samples.push(Source {
                record,
                set: number,
                index,
            });
        }
        excluded.extend(exclusions);
    }
    if one_manifest {
        samples.sort_by_key(|sample| sample.record.row.entry);
        excluded.sort_by_key(|excluded| excluded.row.entry);
    }
    Ok((samples, excluded))
}

/// The warnings of the samples that have any, by name.
fn warnings_of(samples: &[Source]) -> BTreeMap<String, Vec<String>> {
    let mut warnings = BTreeMap::new();
    for Source { record, .. } in samples {
        if !record.warnings.is_empty() {
            warnings.insert(record.row.name.clone(), record.warnings.clone());
        }
    }
    warnings
}

/// The differences between two settings, such as `seed 0 and 3, size 32 and 64`.
fn differences(first: &VoxelizeSettings, second: &VoxelizeSettings) -> Result<String> {
    let (first, second) = (serde_json::to_value(first)?, serde_json::to_value(second)?);
    let mut shown = Vec::new();
    for (key, value) in first.as_object().into_iter().flatten() {
        let other = &second[key.as_str()];
        if value != other {
            shown.push(format!("{key} {value} and {other}"));
        }
    }
    Ok(shown.join(", "))
}
