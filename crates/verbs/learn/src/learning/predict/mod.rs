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
//! | `fit` | whether the voxels of a set fit the network |
//! | `truth` | the true class of each sample, and whether training has seen it |
//! | `report` | a row per sample, and scores |

mod fit;
mod report;
mod trained;
mod truth;

pub use fit::Difference;
use report::LabelledSet;
pub use report::{NotScored, PredictReport, SamplePrediction, SetScores};
pub use trained::Trained;
use truth::is_same;
pub use truth::{Part, Truth, Unscored};

use crate::learning::labels::{LabelTable, excluded_names};
use crate::learning::train::open_set;
use anyhow::{Result, bail};
use protomer_learn::scaling::Quarantined;
use protomer_learn::training::{Model, PredictionSettings, Predictions};
use protomer_learn::{Device, SampleSource};
use protomer_results::{End, Execution};
use std::path::Path;

/// Samples between two checks for an interrupt: a multiple of the batch size.
const CHUNK: usize = 64;

/// Predicts the class of every sample of a set, on a device. The true labels are those of the table,
/// if there is one; otherwise those that a training on this set took from a table; otherwise those of
/// the set.
///
/// # Errors
/// If the directory does not hold a finished training on a set, the voxels do not fit the
/// network, or no sample can be read.
///
/// ```no_run
/// use protomer_learn_verbs::learning::predict::predict;
/// use protomer_learn::device::DeviceChoice;
/// use protomer_results::Execution;
/// use std::path::Path;
/// let device = DeviceChoice::Cpu.open()?;
/// let (run, set) = (Path::new("run"), Path::new("set.zarr"));
/// let end = predict(run, set, None, &device, &Execution::default())?;
/// if let Some(report) = end.finished() {
///     println!("{} samples predicted", report.samples.len());
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn predict(
    run: &Path,
    set_path: &Path,
    labels: Option<&LabelTable>,
    device: &Device,
    execution: &Execution,
) -> Result<End<PredictReport>> {
    let mut trained = Trained::read(run)?;
    trained.model = trained.model.to_device(device)?;
    let (source, set) = open_set(set_path)?;
    let differences = fit::differences(&trained.model.card, &set, set_path)?;
    let table_of_training = trained.settings.labels.as_ref();
    // The table of the training itself brings nothing new.
    let is_own = |table: &&LabelTable| {
        table_of_training.is_some_and(|table_of_training| table_of_training.is_same(&table.source))
    };
    let labels = labels.filter(|table| !is_own(table));
    let table = match (labels, &trained.labels) {
        (Some(table), _) => Some(table.join(&set, &excluded_names(&set)?)?),
        (None, Some(table_of_training)) if is_same(&trained.settings.source, &source) => {
            Some(table_of_training.relabelled(&set))
        }
        (None, _) => None,
    };
    let labelled: &dyn SampleSource = match &table {
        Some(view) => view,
        None => &set,
    };
    // Other labels than those of the training know nothing of its parts.
    let truth = match labels {
        Some(_) => Truth::of_other(&trained, labelled),
        None => Truth::read(&trained, &source, labelled)?,
    };
    let samples = set.descriptions().len() as u64;
    execution.progress.begin(samples, "samples");
    let how = PredictionSettings {
        rotations: trained.settings.rotations,
        ..PredictionSettings::default()
    };
    let End::Finished(predictions) = in_chunks(&trained.model, &set, how, execution)? else {
        return Ok(End::Stopped);
    };
    if let ([], Some(Quarantined { name, reason, .. })) =
        (&predictions.samples[..], predictions.quarantined.first())
    {
        bail!(
            "no sample of {} can be read; the first, {name}: {reason}",
            set_path.display()
        );
    }
    let report = PredictReport::new(
        run,
        set_path,
        &trained,
        &LabelledSet {
            samples: labelled,
            files: set.files(),
        },
        &truth,
        predictions,
        differences,
    )?;
    Ok(End::Finished(report))
}

/// Predicts all samples, a chunk at a time, with the same results as all at once.
fn in_chunks(
    model: &Model,
    set: &dyn SampleSource,
    how: PredictionSettings,
    execution: &Execution,
) -> Result<End<Predictions>> {
    let samples: Vec<usize> = (0..set.descriptions().len()).collect();
    let mut all = Predictions::default();
    for chunk in samples.chunks(CHUNK) {
        if execution.interrupt.is_requested() {
            return Ok(End::Stopped);
        }
        let Predictions {
            samples,
            probabilities,
            numbers,
            quarantined,
        } = model.predict(set, chunk, how)?;
        all.samples.extend(samples);
        all.probabilities.extend(probabilities);
        all.numbers.extend(numbers);
        all.quarantined.extend(quarantined);
        execution.progress.advance(chunk.len() as u64);
    }
    Ok(End::Finished(all))
}
