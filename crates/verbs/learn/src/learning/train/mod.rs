//! Training a network in a directory: start or continue, compare with baselines, write the results.
//!
//! ```text
//! DIR/settings.toml  metrics.json  model.safetensors  history.csv  learning_curve.svg
//! DIR/predictions.csv  predicted_numbers.svg  trained_on.json  checkpoint.bin
//! DIR/ablation/CHANNELS/seed_N/   a directory each    ablation.csv
//! DIR/EXPERIMENT/                 the further experiments of a control
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | the settings of a training |
//! | `source` | the source of the samples |
//! | `prepared` | a set ready for training |
//! | `run` | one training: the loop, checkpoints, results |
//! | `weights` | the trained network that a training starts from |
//! | `trained_on` | which structures a network has seen |
//! | `job` | a training with its ablation; a control with its experiments |
//! | `history` | scores of the validation part at an epoch |
//! | `metrics` | scores compared with baselines |
//! | [`page`] | the page of a training |
//! | `summary` | the scores as text |
//! | `told` | what the text and the page both say: rows of scores, joined labels, the permutation test |
//! | `ablation`, `control`, `control_report`, `figure` | tables of channels, verdicts on controls, the learning curve |

mod ablation;
mod control;
mod control_report;
mod figure;
mod history;
mod job;
mod metrics;
pub mod page;
mod prepared;
mod run;
mod settings;
mod source;
mod summary;
mod told;
mod trained_on;
mod weights;

pub(crate) use ablation::summary as ablation_summary;
pub use control_report::{ControlReport, ExperimentReport};
pub use figure::{learning_curve, predicted_numbers};
pub use job::{ControlRun, Job, run_control, run_job};
pub use metrics::{BaselineScores, Metrics, NumberMetrics, Parts, Predictions};
pub use prepared::{Numbers, Prepared};
pub(crate) use run::{Epochs, TrainingRun};
pub use run::{MODEL, PREDICTED_NUMBERS, SETTINGS, check, train_in};
pub use settings::{Source, SplitBy, TrainSettings};
pub use source::{channels_of, open_set, samples_of};
pub(crate) use summary::decimals_of;
pub use told::ScoreRow;
pub use trained_on::{Seen, TRAINED_ON, TrainedOn};
pub use weights::{Start, WeightSource};
