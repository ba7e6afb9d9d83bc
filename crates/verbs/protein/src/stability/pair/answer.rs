//! What a pair answers: text, figure, and files in its directory.

use super::figure;
use super::result::{ConditionResult, PairPart, PairResult};
use anyhow::{Context, Result};
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::atomic::write_atomically;
use protomer_io::csv::Table;
use protomer_plot::Figure;
use std::path::Path;

impl Answer for PairResult {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "pH",
            "salt (M)",
            "B2 (Å³)",
            "±",
            "hard (Å³)",
            "B22 (mol mL/g²)",
            "±",
            "K_D (M)",
            "lowest (kT)",
        ])];
        for condition in &self.conditions {
            rows.push(vec![
                shown(condition.ph, |ph| format!("{ph:.2}")),
                shown(condition.salt_molar, |salt| format!("{salt:.4}")),
                format!("{:.0}", condition.b2_angstrom3),
                format!("{:.0}", condition.b2_error_angstrom3),
                format!("{:.0}", condition.b2_hard_angstrom3),
                shown(condition.b22_mol_ml_per_g2, |b22| format!("{b22:.2e}")),
                shown(condition.b22_error_mol_ml_per_g2, |b22| {
                    format!("{b22:.1e}")
                }),
                shown(condition.kd_molar, |kd| format!("{kd:.2e}")),
                shown(condition.poses.first(), |pose| {
                    format!("{:.2}", pose.energy_kt)
                }),
            ]);
        }
        columns(&rows)
    }

    fn figure(&self) -> Option<Figure> {
        Some(figure::figure(self))
    }
}

impl Answer for PairPart {
    fn text(&self) -> String {
        format!(
            "part {} of {}: {} conditions done; run without --shard for the table",
            self.shard, self.of, self.conditions
        )
    }
}

impl PairResult {
    /// Writes the table, the JSON form and the figures into a directory.
    pub(super) fn write(&self, directory: &Path) -> Result<()> {
        let json = serde_json::to_string_pretty(self).context("the result cannot be serialised")?;
        let csv = to_csv(&self.conditions)?;
        write_atomically(&directory.join("pair.csv"), |file| {
            file.write_all(csv.as_bytes())
        })?;
        write_atomically(&directory.join("pair.json"), |file| {
            writeln!(file, "{json}")
        })?;
        figure::write(self, directory)
    }
}

/// A dash for what is not known.
fn shown<T>(value: Option<T>, format: impl FnOnce(T) -> String) -> String {
    value.map_or("-".into(), format)
}

fn to_csv(conditions: &[ConditionResult]) -> Result<String> {
    let mut names = Vec::new();
    for (name, _) in conditions.iter().take(1).flat_map(ConditionResult::cells) {
        names.push(name);
    }
    let mut table = Table::new(names);
    for condition in conditions {
        table.push(condition.cells().into_iter().map(|(_, cell)| cell))?;
    }
    Ok(table.to_csv()?)
}
