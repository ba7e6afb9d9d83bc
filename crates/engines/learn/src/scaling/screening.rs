//! Samples that cannot be used are left out, with the reason.

use crate::{LearnError, Result, SampleSource, SparseGrid};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A sample left out, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quarantined {
    /// Place of the sample in the source.
    pub sample: usize,
    /// Name of the sample.
    pub name: String,
    /// Reason why the sample cannot be used.
    pub reason: String,
}

/// The voxels of a sample, if they can be read, fit the source, and are finite.
///
/// # Errors
/// [`LearnError::Sample`] names the sample and what is wrong.
pub fn read_checked(source: &dyn SampleSource, sample: usize) -> Result<SparseGrid> {
    read(source, sample).map_err(|error| LearnError::Sample {
        name: name(source, sample).unwrap_or_else(|| sample.to_string()),
        reason: reason(error),
    })
}

fn read(source: &dyn SampleSource, sample: usize) -> Result<SparseGrid> {
    let grid = source.voxels(sample)?;
    grid.check()?;
    let (size, channels) = (source.size(), source.channels().len());
    if grid.size != size || grid.channels != channels {
        return Err(crate::error::damaged(format!(
            "{} channels of {}³ voxels, but the set has {channels} of {size}³",
            grid.channels, grid.size
        )));
    }
    Ok(grid)
}

/// Splits `samples` into those that can be read and those that cannot, with the reason.
///
/// ```
/// use protomer_learn::controls::{Control, Variant};
/// use protomer_learn::scaling::screen;
///
/// let mut set = Control::Shapes.samples(Variant::Usual, 3, 16, 1);
/// set.grids[1].values[0] = f32::NAN;
/// let (good, bad) = screen(&set, &[0, 1, 2]);
/// assert_eq!((good, &*bad[0].reason), (vec![0, 2], "channel 0 holds NaN"));
/// ```
pub fn screen(source: &dyn SampleSource, samples: &[usize]) -> (Vec<usize>, Vec<Quarantined>) {
    let errors: Vec<Option<LearnError>> = samples
        .par_iter()
        .map(|sample| read(source, *sample).err())
        .collect();
    let (mut good, mut bad) = (Vec::new(), Vec::new());
    for (sample, error) in samples.iter().zip(errors) {
        match error {
            None => good.push(*sample),
            Some(error) => bad.push(Quarantined {
                sample: *sample,
                name: name(source, *sample).unwrap_or_default(),
                reason: reason(error),
            }),
        }
    }
    (good, bad)
}

fn name(source: &dyn SampleSource, sample: usize) -> Option<String> {
    let description = source.descriptions().get(sample)?;
    Some(description.name.clone())
}

/// Reason that an error states, without the name of the sample.
fn reason(error: LearnError) -> String {
    match error {
        LearnError::Sample { reason, .. } => reason,
        other => other.to_string(),
    }
}
