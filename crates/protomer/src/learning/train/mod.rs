//! Training a network in a directory: start or continue, evaluate beside baselines, write
//! everything down.
//!
//! ```text
//! DIR/settings.toml  metrics.json  model.safetensors  history.csv  learning_curve.svg  predictions.csv  checkpoint.bin
//! DIR/trained_on.json
//! DIR/ablation/CHANNELS/seed_N/   a directory each    ablation.csv
//! DIR/EXPERIMENT/                 the further experiments of a control
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what is trained, on what, and how |
//! | `source` | where samples come from |
//! | `run` | one training: the loop, checkpoints, results |
//! | `trained_on` | which structures a network has seen |
//! | `job` | a training with its ablation; a control with its experiments |
//! | `metrics` | scores beside baselines |
//! | `summary` | the scores as lines for a reader |
//! | `ablation`, `control`, `figure` | tables of channels, verdicts on controls, the learning curve |

mod ablation;
mod control;
mod figure;
mod job;
mod metrics;
mod run;
mod settings;
mod source;
mod summary;
mod trained_on;

pub use ablation::{Ablation, AblationRow, AblationRun, Mean, subsets};
pub use control::{ControlReport, ExperimentReport};
pub use figure::learning_curve;
pub use job::{ControlRun, Job, run_control, run_job};
pub use metrics::{BaselineScores, Intervals, Metrics, Parts, Predictions};
pub(crate) use run::{Epochs, TrainingRun};
pub use run::{MODEL, Prepared, SETTINGS, check, train_in};
pub use settings::{Source, SplitBy, TrainSettings, blocks};
pub use source::{channels_of, open_set, samples_of};
pub use trained_on::{Seen, TRAINED_ON, TrainedOn};
