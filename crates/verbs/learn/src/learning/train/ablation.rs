//! The table of an ablation, as text and as `ablation.csv`.

use anyhow::Result;
use protomer_io::atomic::write_bytes;
use protomer_io::csv::{Cell, Table};
use protomer_learn::ablation::{Ablation, AblationRow, Mean};
use std::path::Path;

/// The table as lines of text.
pub(crate) fn summary(ablation: &Ablation) -> String {
    let mut lines = Vec::with_capacity(ablation.rows.len());
    for row in &ablation.rows {
        lines.push(format!(
            "{:<32} {}balanced accuracy {:.3}, less all channels {}; nats gained {}",
            row.channels.join(" + "),
            on_validation(row),
            row.balanced_accuracy.mean,
            with_error(&row.balanced_accuracy_less_all),
            with_error(&row.nats_gained_over_prior)
        ));
    }
    lines.join("\n")
}

/// Cost of the channels left out on the validation part, by which channels are chosen.
fn on_validation(row: &AblationRow) -> String {
    let Some(costs) = &row.validation_loss_more_than_all else {
        return String::new();
    };
    match costs.interval_95 {
        Some([low, high]) => format!(
            "validation loss {:+.3} ({low:+.3} to {high:+.3}) nats over all channels; test: ",
            costs.mean
        ),
        None => format!(
            "validation loss {:+.3} nats over all channels; test: ",
            costs.mean
        ),
    }
}

fn with_error(mean: &Mean) -> String {
    match mean.standard_error {
        Some(error) => format!("{:+.3} ± {error:.3}", mean.mean),
        None => format!("{:+.3}", mean.mean),
    }
}

/// Writes `ablation.csv`, one row per subset and seed.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write_csv(ablation: &Ablation, directory: &Path) -> Result<()> {
    let columns = [
        "channels",
        "seed",
        "balanced_accuracy",
        "accuracy",
        "majority_accuracy",
        "nats_gained_over_prior",
        "validation_loss_nats",
        "validation_balanced_accuracy",
    ];
    let mut table = Table::new(columns);
    for run in &ablation.runs {
        let seed = i64::try_from(run.seed).map_or(Cell::Text(run.seed.to_string()), Cell::from);
        table.push([
            run.channels.join("+").as_str().into(),
            seed,
            run.balanced_accuracy.into(),
            run.accuracy.into(),
            run.majority_accuracy.into(),
            run.nats_gained_over_prior.into(),
            Cell::from(run.validation_loss_nats),
            Cell::from(run.validation_balanced_accuracy),
        ])?;
    }
    let csv = table.to_csv()?;
    write_bytes(&directory.join("ablation.csv"), csv.as_bytes())?;
    Ok(())
}
