//! Where samples come from: a set on the disk, or a control.

use super::settings::Source;
use anyhow::{Result, bail};
use protomer_learn::sample::SampleSource;
use std::path::Path;

/// The samples that settings name.
///
/// # Errors
/// If a set on the disk cannot be read, or is not the one of the settings.
pub fn samples_of(source: &Source) -> Result<Box<dyn SampleSource>> {
    match source {
        Source::Control { name, variant, samples, size, seed } => {
            Ok(Box::new(name.samples(*variant, *samples, *size, *seed)))
        }
        Source::Set { path, digest } => {
            let (found, set) = open_set(path)?;
            match found {
                Source::Set { digest: present, .. } if present == *digest => Ok(set),
                _ => bail!("{} has changed since; train in another directory", path.display()),
            }
        }
    }
}

/// A set on the disk, and what settings say of it.
///
/// # Errors
/// If it cannot be read.
pub fn open_set(path: &Path) -> Result<(Source, Box<dyn SampleSource>)> {
    bail!("{}: sets on the disk cannot be read yet", path.display())
}

/// Names of the channels of a set.
pub fn channels_of(set: &dyn SampleSource) -> Vec<String> {
    set.channels().to_vec()
}
