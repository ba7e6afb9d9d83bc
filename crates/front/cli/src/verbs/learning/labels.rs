//! The flags of labels from a table, for `train`, `tune` and `predict`.

use anyhow::{Result, bail};
use clap::Args;
use protomer_learn_verbs::learning::labels::LabelTable;
use protomer_learn_verbs::learning::train::TrainSettings;
use std::path::PathBuf;

/// Labels from a table instead of the set.
#[derive(Debug, Clone, Args)]
pub struct LabelArgs {
    /// Table of labels (CSV or TSV) with a column 'name' and a column 'label' for classes or 'number'
    /// for numbers, joined to the set by name; the set stays as it is.
    #[arg(long, value_name = "TABLE")]
    labels: Option<PathBuf>,
    /// Column of the labels; numbers if all its cells are [default: label or number].
    #[arg(long, value_name = "COLUMN")]
    label_column: Option<String>,
}

impl LabelArgs {
    /// Reads the table, if there is one.
    pub fn read(&self) -> Result<Option<LabelTable>> {
        let Some(path) = &self.labels else {
            if self.label_column.is_some() {
                bail!("--label-column names a column of a table; add --labels TABLE, or omit it");
            }
            return Ok(None);
        };
        LabelTable::read(path, self.label_column.as_deref()).map(Some)
    }

    /// Reads the table, or finds that of settings from a file again, and notes it in the settings.
    pub fn note(&self, settings: &mut TrainSettings) -> Result<Option<LabelTable>> {
        let table = match (self.read()?, &settings.labels) {
            (None, Some(source)) => Some(LabelTable::found_again(source)?),
            (table, _) => table,
        };
        settings.labels = table.as_ref().map(|table| table.source.clone());
        Ok(table)
    }

    /// Refuses a table where there is no set.
    pub fn refuse(&self, why: &str) -> Result<()> {
        match self.labels.is_some() || self.label_column.is_some() {
            true => bail!("--labels gives labels to a set; omit it: {why}"),
            false => Ok(()),
        }
    }
}
