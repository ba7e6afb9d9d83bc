//! Merges several sets into one.

use super::identity::identity;
use super::origin::{Missing, Origin, joined, origins};
use super::row::Row;
use super::set::{self, SampleRecord, SetContent};
use super::settings::VoxelizeSettings;
use super::{open_set, relatives};
use crate::answer::Answer;
use anyhow::{Context, Result, bail};
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
pub fn merge(inputs: &[PathBuf], output: &Path, force: bool) -> Result<MergeReport> {
    let readers = inputs
        .iter()
        .map(|path| open_set(path))
        .collect::<Result<Vec<SetReader>>>()?;
    let (Some(first), Some(first_path)) = (readers.first(), inputs.first()) else {
        bail!("no sets are given; give at least one")
    };
    let settings = set::settings_of(first).with_context(|| first_path.display().to_string())?;
    let of_each = readers
        .iter()
        .zip(inputs)
        .map(|(reader, path)| origins(reader).with_context(|| path.display().to_string()));
    let of_each = of_each.collect::<Result<Vec<Vec<Origin>>>>()?;
    // A set merged from several manifests has no common order of entries.
    let parts_of_one = of_each.iter().all(|of_one| of_one.len() == 1);
    let manifests = joined(of_each.into_iter().flatten());
    let one_manifest = parts_of_one && manifests.len() == 1;
    let mut samples: Vec<(usize, usize, SampleRecord)> = Vec::new();
    let mut excluded = Vec::new();
    let mut seen: HashMap<String, &PathBuf> = HashMap::new();
    for ((number, reader), path) in readers.iter().enumerate().zip(inputs) {
        let shown = || path.display().to_string();
        let theirs = set::settings_of(reader).with_context(shown)?;
        if theirs != settings {
            let (a, b, how) = (
                first_path.display(),
                path.display(),
                differences(&settings, &theirs)?,
            );
            bail!("{a} and {b} have different settings: {how}; voxelize them alike");
        }
        let ours = set::samples_of(reader).with_context(shown)?;
        let theirs = set::exclusions(reader).with_context(shown)?;
        let names = ours
            .iter()
            .map(|sample| &sample.name)
            .chain(theirs.iter().map(|excluded| &excluded.name));
        // Sorted, so that the message is always about the same name.
        let names: BTreeSet<String> = names.cloned().collect();
        for name in names {
            if let Some(earlier) = seen.insert(name.clone(), path) {
                bail!(
                    "'{name}' is in {} and in {}; give each part once",
                    earlier.display(),
                    path.display()
                );
            }
        }
        samples.extend(
            ours.into_iter()
                .enumerate()
                .map(|(place, sample)| (number, place, sample)),
        );
        excluded.extend(theirs);
    }
    if one_manifest {
        samples.sort_by_key(|(_, _, sample)| sample.entry);
        excluded.sort_by_key(|excluded| excluded.entry);
    }
    let places: Vec<(usize, usize)> = samples
        .iter()
        .map(|(set, place, _)| (*set, *place))
        .collect();
    let content = SetContent {
        samples: samples.into_iter().map(|(_, _, sample)| sample).collect(),
        excluded,
    };
    let mut rows = Row::of_content(&content);
    if one_manifest {
        rows.sort_by_key(|row| row.entry);
    }
    let identity = identity(&settings, &rows)?;
    let report = |nothing_to_do| MergeReport {
        set: output.to_owned(),
        sets: inputs.len(),
        samples: content.samples.len(),
        excluded: content.excluded.len(),
        voxels: content.voxels(),
        bytes: set::bytes_on_disk(output),
        missing: Missing::of(&manifests),
        manifest_warnings: relatives::in_several_clusters(&rows),
        nothing_to_do,
    };
    match set::state_of(output, &identity)? {
        set::OnDisk::Same(_) => return Ok(report(true)),
        set::OnDisk::Other if !force => {
            bail!(
                "{} holds another set; overwrite it with --force or name another output",
                output.display()
            )
        }
        set::OnDisk::Other | set::OnDisk::Nothing => {}
    }
    let attributes = set::attributes(&settings, &manifests, &identity, &content)?;
    set::replace(output, |folder| {
        set::write(folder, &settings, &content, attributes, &mut |sample| {
            let Some((reader, place)) = places
                .get(sample)
                .and_then(|(set, place)| Some((readers.get(*set)?, *place)))
            else {
                bail!("there is no sample {sample}");
            };
            let stored = reader.sample(place)?;
            Ok(Voxels {
                index: stored.index,
                values: stored.values,
            })
        })
    })?;
    Ok(report(false))
}

/// The differences between two settings, such as `seed 0 and 3, size 32 and 64`.
fn differences(first: &VoxelizeSettings, second: &VoxelizeSettings) -> Result<String> {
    let (first, second) = (serde_json::to_value(first)?, serde_json::to_value(second)?);
    let keys = first
        .as_object()
        .into_iter()
        .flat_map(|settings| settings.keys());
    let differing = keys.filter(|key| first.get(key) != second.get(key));
    let shown =
        differing.map(|key| format!("{key} {} and {}", first[key.as_str()], second[key.as_str()]));
    Ok(shown.collect::<Vec<_>>().join(", "))
}
