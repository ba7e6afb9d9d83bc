//! `protomer predict`: a trained network applied to a set.

use super::labels::LabelArgs;
use crate::flags::device::DeviceArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::answer::Answer;
use protomer_common::output_file::{require_writable, write_once};
use protomer_learn_verbs::learning::predict::{PredictReport, predict};
use protomer_protein_verbs::file_kind::FileKind;
use protomer_results::{End, ResultKind};
use std::path::PathBuf;

/// Apply a network trained by 'protomer train' to every sample of a set of voxels: class,
/// probabilities, and scores where the labels are known.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "predict run new.zarr -o predictions.csv",
    "predict run new.zarr --json"
))]
#[group(id = "PredictResult")]
pub struct PredictArgs {
    /// Directory of a finished training.
    run: PathBuf,
    /// Set of voxels (zarr), made by 'protomer voxelize' with the settings of the training set.
    set: PathBuf,
    /// Table to write (CSV); standard output if omitted.
    #[arg(short, long)]
    output: Option<PathBuf>,
    #[command(flatten)]
    labels: LabelArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

impl PredictArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        if let Some(path) = &self.output {
            require_writable(path, front.force())?;
        }
        // What a directory lacks, its reader knows better.
        if self.run.is_file() {
            FileKind::Results(ResultKind::Training).require(&self.run)?;
        }
        FileKind::Results(ResultKind::VoxelSet).require(&self.set)?;
        let execution = front.execution_without_signals();
        let (labels, device) = (self.labels.read()?, self.device.open()?);
        let end = predict(&self.run, &self.set, labels.as_ref(), &device, &execution)?;
        let End::Finished(report) = end else {
            return Ok(Reply::stopped("stopped; nothing was written".into()));
        };
        let table = report.table()?.to_csv()?;
        let (notes, summary) = (notes(&report), report.text());
        let is_incomplete = !report.left_out.is_empty();
        let reply = Reply::from_answer(report)
            .with_notes(notes)
            .partial_if(is_incomplete);
        match &self.output {
            Some(path) => {
                write_once(path, &table, front.force())?;
                Ok(reply)
            }
            None => Ok(reply
                .showing(table.trim_end().to_owned())
                .with_summary(summary)),
        }
    }
}

fn notes(report: &PredictReport) -> Vec<String> {
    let left_out = report.left_out.iter();
    let left_out = left_out.map(|sample| format!("left out: {}: {}", sample.name, sample.reason));
    let differences = report.differences.iter().map(|difference| {
        format!(
            "warning: the voxels were made with other settings: {}",
            difference.line()
        )
    });
    left_out.chain(differences).collect()
}
