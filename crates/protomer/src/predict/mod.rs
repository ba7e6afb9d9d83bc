//! A trained network applied to a set of voxels.
//!
//! ```text
//! RUN/model.safetensors --fits--> SET.zarr
//!     --forward pass and scaling of the training--> classes, probabilities, scores
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `trained` | the network of a directory |
//! | `fit` | whether a set has the voxels a network is for |
//! | `truth` | the true class of each sample, and whether training has seen it |
//! | `report` | a row per sample, and scores |

mod fit;
mod report;
mod trained;
mod truth;

pub use fit::Difference;
pub use report::{NotScored, PredictReport, SamplePrediction, SetScores};
pub use trained::Trained;
pub use truth::{Part, Truth, Unscored};

use crate::train::open_set;
use anyhow::{Result, bail};
use protomer_learn::scaling::Quarantined;
use protomer_learn::training::{Model, PredictionSettings, Predictions};
use protomer_learn::{Device, SampleSource};
use std::path::Path;

/// Samples between two questions whether to stop: a multiple of the grids at a time.
const CHUNK: usize = 64;

/// Predicts the class of every sample of a set, on a device. Calls `begin` with the number of
/// samples and `advanced` with how many more are done, and asks `stop` between chunks.
///
/// # Errors
/// If the directory holds no finished training on a set, the set has other voxels than the network
/// is for, no sample can be read, or it was asked to stop.
pub fn predict(
    run: &Path,
    set_path: &Path,
    device: &Device,
    begin: &dyn Fn(u64),
    advanced: &dyn Fn(u64),
    stop: &dyn Fn() -> bool,
) -> Result<PredictReport> {
    let mut trained = Trained::read(run)?;
    trained.model = trained.model.to_device(device)?;
    let (source, set) = open_set(set_path)?;
    let differences = fit::differences(&trained.model.card, &set, set_path)?;
    let truth = Truth::of(&trained, &source, &set)?;
    begin(set.descriptions().len() as u64);
    let how = PredictionSettings {
        rotations: trained.settings.rotations,
        ..PredictionSettings::default()
    };
    let predictions = in_chunks(&trained.model, &set, how, advanced, stop)?;
    if let ([], Some(Quarantined { name, reason, .. })) =
        (&predictions.samples[..], predictions.quarantined.first())
    {
        bail!(
            "no sample of {} can be read; the first, {name}: {reason}",
            set_path.display()
        );
    }
    PredictReport::of(
        run,
        set_path,
        &trained,
        &set,
        &truth,
        predictions,
        differences,
    )
}

/// All samples, a chunk at a time. The result is the same as at once.
fn in_chunks(
    model: &Model,
    set: &dyn SampleSource,
    how: PredictionSettings,
    advanced: &dyn Fn(u64),
    stop: &dyn Fn() -> bool,
) -> Result<Predictions> {
    let samples: Vec<usize> = (0..set.descriptions().len()).collect();
    let mut all = Predictions::default();
    for chunk in samples.chunks(CHUNK) {
        if stop() {
            bail!("stopped; nothing was written");
        }
        let Predictions {
            samples,
            probabilities,
            quarantined,
        } = model.predict(set, chunk, how)?;
        all.samples.extend(samples);
        all.probabilities.extend(probabilities);
        all.quarantined.extend(quarantined);
        advanced(chunk.len() as u64);
    }
    Ok(all)
}
