//! The source of samples: a set on disk, or a control.

use super::settings::Source;
use crate::voxels::samples::VoxelSet;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_learn::sample::SampleSource;
use std::path::Path;

/// The samples that settings name.
///
/// # Errors
/// If a set on disk cannot be read, or is not the one in the settings.
pub fn samples_of(source: &Source) -> Result<Box<dyn SampleSource>> {
    match source {
        Source::Control {
            name,
            variant,
            samples,
            size,
            seed,
        } => Ok(Box::new(name.samples(*variant, *samples, *size, *seed))),
        Source::Set { path, digest } => {
            let (stored_source, set) = open_set(path)?;
            match stored_source {
                Source::Set {
                    digest: present, ..
                } if present == *digest => Ok(Box::new(set)),
                _ => bail!(
                    "{} has changed since; train in another directory",
                    path.display()
                ),
            }
        }
    }
}

/// Opens a set on disk and describes it for settings. The digest covers the metadata of each
/// sample, its number of voxels, and how the set was made, but not every value.
///
/// # Errors
/// If it cannot be read, or has no samples.
pub fn open_set(path: &Path) -> Result<(Source, VoxelSet)> {
    let set = VoxelSet::open(path)?;
    let reader = set.reader();
    if reader.is_empty() {
        bail!(
            "{} has no samples; its attribute 'excluded' says why structures were left out",
            path.display()
        );
    }
    let voxels: Vec<usize> = (0..reader.len())
        .map(|sample| reader.voxels(sample))
        .collect();
    let description = (
        reader.size(),
        reader.channels(),
        reader.attributes(),
        set.descriptions(),
        voxels,
    );
    let digest =
        sha256_hex(&serde_json::to_vec(&description).context("the set cannot be described")?);
    let path = path
        .canonicalize()
        .with_context(|| format!("cannot read {}", path.display()))?;
    Ok((Source::Set { path, digest }, set))
}

/// Names of the channels of a set.
pub fn channels_of(set: &dyn SampleSource) -> Vec<String> {
    set.channels().to_vec()
}
