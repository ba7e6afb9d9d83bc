//! The scores in words and files.

use super::record::ScoreRecord;
use super::table::ScoreTable;
use super::{Complexes, ScoreSettings, figure};
use anyhow::Result;
use protomer_common::answer::{Answer, counted};
use protomer_io::atomic::write_atomically;
use protomer_kernel::setting::Choices;
use protomer_plot::Figure;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Failed complexes that the text names.
const FAILURES_NAMED: usize = 5;

/// The scores of complexes: how many there are, and where the table is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScoreResult {
    /// Number of complexes.
    pub rows: usize,
    /// Complexes that could not be scored.
    pub failed: usize,
    /// Complexes with warnings.
    pub with_warnings: usize,
    /// Complexes that this command found done.
    pub taken_over: usize,
    /// Wall time of this command, s.
    pub seconds: f64,
    /// Processor time of this command, s.
    pub cpu_seconds: f64,
    /// The table with a row for each complex.
    pub table: PathBuf,
    /// Columns of the table.
    pub columns: Vec<String>,
    /// Name of the model of the energies.
    pub model: &'static str,
    /// Names of complexes that could not be scored, with the reasons.
    #[serde(skip)]
    failures: Vec<(String, String)>,
    #[serde(skip)]
    figure: Option<Figure>,
}

/// Processor time that the text tells, s.
const COST_WORTH_SECONDS: f64 = 10.0;

/// Cost of a command.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cost {
    /// Complexes that were done before.
    pub taken_over: usize,
    /// Wall time, s.
    pub seconds: f64,
    /// Processor time, s.
    pub cpu_seconds: f64,
}

impl ScoreResult {
    pub(super) fn new(
        complexes: &Complexes,
        settings: &ScoreSettings,
        records: &[ScoreRecord],
        table: &ScoreTable,
        (directory, cost): (&Path, Cost),
    ) -> Self {
        let named = complexes.0.iter().zip(records);
        let failures: Vec<(String, String)> = named
            .filter_map(|(complex, record)| Some((complex.name.clone(), record.error.clone()?)))
            .collect();
        let warned = records.iter().filter(|record| !record.warnings.is_empty());
        Self {
            rows: records.len(),
            failed: failures.len(),
            with_warnings: warned.count(),
            taken_over: cost.taken_over,
            seconds: cost.seconds,
            cpu_seconds: cost.cpu_seconds,
            table: directory.join("score.csv"),
            columns: table.columns().to_vec(),
            model: settings.model.name(),
            failures,
            figure: figure::figure(&table.shown()),
        }
    }

    /// Writes the table, the JSON form and the figure.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub(super) fn write(&self, table: &ScoreTable, directory: &Path) -> Result<()> {
        table.write(&self.table)?;
        let text = serde_json::to_string_pretty(self)?;
        write_atomically(&directory.join("score.json"), |file| {
            file.write_all(text.as_bytes())
        })?;
        if let Some(figure) = &self.figure {
            figure.write_svg(&directory.join("score.svg"))?;
            figure.write_png(&directory.join("score.png"))?;
        }
        Ok(())
    }
}

impl Answer for ScoreResult {
    fn text(&self) -> String {
        let mut lines = vec![format!(
            "{}, {} failed, {} with warnings{}",
            counted(self.rows, "complex", "complexes"),
            self.failed,
            self.with_warnings,
            self.cost_in_words()
        )];
        for (name, reason) in self.failures.iter().take(FAILURES_NAMED) {
            lines.push(format!("{name}: {reason}"));
        }
        if self.failures.len() > FAILURES_NAMED {
            let more = self.failures.len() - FAILURES_NAMED;
            lines.push(format!("and {more} more: see the column error"));
        }
        lines.push(self.table.display().to_string());
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        self.figure.clone()
    }
}

impl ScoreResult {
    /// Cost of the complexes that this command scored, where it is worth a word.
    fn cost_in_words(&self) -> String {
        let new = self.rows - self.taken_over;
        match self.cpu_seconds > COST_WORTH_SECONDS && new > 0 {
            true => format!(
                "; {new} scored in {:.0} s of processor time",
                self.cpu_seconds
            ),
            false => String::new(),
        }
    }
}
