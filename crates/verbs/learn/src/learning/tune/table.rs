//! The table of a search.

use crate::learning::train::TrainSettings;
use crate::learning::tune::Trial;
use anyhow::Result;
use protomer_io::atomic::write_atomically;
use protomer_io::csv::{Cell, Table};
use std::path::Path;

/// Writes `trials.csv`: one row per trial, best first.
pub(crate) fn write_table<'a>(trials: impl Iterator<Item = &'a Trial>, path: &Path) -> Result<()> {
    let columns = [
        "trial",
        "epochs",
        "validation_loss_nats",
        "validation_balanced_accuracy",
        "widths",
        "kernels",
        "groups",
        "learning_rate",
        "channels",
    ];
    let mut table = Table::new(columns);
    for trial in trials {
        let TrainSettings {
            blocks, training, ..
        } = &trial.settings;
        let join = |values: Vec<usize>| {
            values
                .iter()
                .map(usize::to_string)
                .collect::<Vec<_>>()
                .join("-")
        };
        table.push([
            trial.number.into(),
            trial.reached.epochs.into(),
            trial.reached.validation_loss_nats.into(),
            trial.reached.validation_balanced_accuracy.into(),
            Cell::from(join(blocks.iter().map(|block| block.width).collect()).as_str()),
            join(blocks.iter().map(|block| block.kernel).collect())
                .as_str()
                .into(),
            blocks
                .first()
                .and_then(|block| block.groups)
                .unwrap_or(0)
                .into(),
            training.learning_rate.into(),
            training.channels.join("+").as_str().into(),
        ])?;
    }
    let csv = table.to_csv()?;
    write_atomically(&path.join("trials.csv"), |out| {
        out.write_all(csv.as_bytes())
    })?;
    Ok(())
}
