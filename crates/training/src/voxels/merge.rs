//! Merges several sets into one.

use super::identity::identity;
use super::origin::{Missing, Origin, joined, origins};
use super::records::{SampleRecord, SetContent, exclusions};
use super::row::Row;
use super::set;
use super::settings::VoxelizeSettings;
use super::{open_set, relatives};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_field::voxels::Voxels;
use protomer_io::zarr::SetReader;
use serde::Serialize;
use std::collections::{BTreeSet, HashMap};
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
/// let report = protomer_training::voxels::merge::merge(&parts, Path::new("set.zarr"), false)?;
/// assert_eq!(report.sets, 2);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn merge(inputs: &[PathBuf], output: &Path, force: bool) -> Result<MergeReport> {
    let sources = Sources::read(inputs)?;
    let rows = sources.rows();
    let identity = identity(&sources.settings, &rows)?;
    let nothing_to_do = match set::state_of(output, &identity)? {
        set::OnDisk::Same(_) => true,
        set::OnDisk::Other if !force => {
            bail!(
                "{} holds another set; overwrite it with --force or name another output",
                output.display()
            )
        }
        set::OnDisk::Other | set::OnDisk::Nothing => {
            sources.write(output, &identity)?;
            false
        }
    };
    let content = &sources.content;
    Ok(MergeReport {
        set: output.to_owned(),
        sets: inputs.len(),
        samples: content.samples.len(),
        excluded: content.excluded.len(),
        voxels: content.voxels(),
        bytes: set::bytes_on_disk(output),
        missing: Missing::of(&sources.manifests),
        manifest_warnings: relatives::in_several_clusters(&rows),
        nothing_to_do,
    })
}

/// The sets to merge, and the content of the merged set.
struct Sources {
    readers: Vec<SetReader>,
    settings: VoxelizeSettings,
    manifests: Vec<Origin>,
    content: SetContent,
    /// For each sample, the number of its set and its index there.
    places: Vec<(usize, usize)>,
    /// Whether the sets are parts of one manifest, which then determines the order.
    one_manifest: bool,
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
        let parts_of_one = of_each.iter().all(|of_one| of_one.len() == 1);
        let manifests = joined(of_each.into_iter().flatten());
        let one_manifest = parts_of_one && manifests.len() == 1;
        let (content, places) = joined_content(&readers, inputs, one_manifest)?;
        Ok(Self {
            readers,
            settings,
            manifests,
            content,
            places,
            one_manifest,
        })
    }

    fn rows(&self) -> Vec<Row> {
        let mut rows = self.content.rows();
        if self.one_manifest {
            rows.sort_by_key(|row| row.entry);
        }
        rows
    }

    fn write(&self, output: &Path, identity: &str) -> Result<()> {
        let (settings, content) = (&self.settings, &self.content);
        let attributes = set::attributes(settings, &self.manifests, identity, content)?;
        set::replace(output, |folder| {
            let mut voxels = |sample| self.voxels(sample);
            set::write(folder, settings, content, attributes, &mut voxels)
        })
    }

    fn voxels(&self, sample: usize) -> Result<Voxels> {
        if let Some((set, place)) = self.places.get(sample)
            && let Some(reader) = self.readers.get(*set)
        {
            let stored = reader.sample(*place)?;
            return Ok(Voxels {
                index: stored.index,
                values: stored.values,
            });
        }
        bail!("there is no sample {sample}")
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

/// The content of all sets, and the origin of each sample. It is sorted by entry if the sets are
/// parts of one manifest.
fn joined_content(
    readers: &[SetReader],
    inputs: &[PathBuf],
    one_manifest: bool,
) -> Result<(SetContent, Vec<(usize, usize)>)> {
    let mut samples: Vec<(SampleRecord, (usize, usize))> = Vec::new();
    let mut excluded = Vec::new();
    let mut seen: HashMap<String, &PathBuf> = HashMap::new();
    for ((number, reader), path) in readers.iter().enumerate().zip(inputs) {
        let of_set = set::samples_of(reader).context(path.display().to_string())?;
        let exclusions = exclusions(reader).context(path.display().to_string())?;
        // Sorted, so that the message is always about the same name.
        let mut names = BTreeSet::new();
        names.extend(of_set.iter().map(|sample| sample.row.name.clone()));
        names.extend(exclusions.iter().map(|excluded| excluded.row.name.clone()));
        for name in names {
            if let Some(earlier) = seen.insert(name.clone(), path) {
                bail!(
                    "'{name}' is in {} and in {}; give each part once",
                    earlier.display(),
                    path.display()
                );
            }
        }
        for (index, sample) in of_set.into_iter().enumerate() {
            samples.push((sample, (number, index)));
        }
        excluded.extend(exclusions);
    }
    if one_manifest {
        samples.sort_by_key(|(sample, _)| sample.row.entry);
        excluded.sort_by_key(|excluded| excluded.row.entry);
    }
    let (samples, places) = samples.into_iter().unzip();
    Ok((SetContent { samples, excluded }, places))
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
