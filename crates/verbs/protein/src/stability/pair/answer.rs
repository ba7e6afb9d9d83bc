//! What a pair answers: text, figure, and files in its directory.

use super::figure;
use super::result::{ConditionResult, PairResult};
use anyhow::{Context, Result};
use protomer_common::answer::{Answer, columns, heading};
use protomer_common::page::millimolar;
use protomer_io::atomic::write_atomically;
use protomer_io::csv::Table;
use protomer_mc::pair::Term;
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
        let mut lines = vec![columns(&rows)];
        lines.extend(self.what_holds());
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(figure::figure(self))
    }
}

impl PairResult {
    /// The terms of the energy of the lowest of all bound poses, with the condition it is from; `None` without
    /// poses.
    fn what_holds(&self) -> Option<String> {
        let lowest = |condition: &&ConditionResult| {
            condition
                .poses
                .first()
                .map_or(f64::INFINITY, |pose| pose.energy_kt)
        };
        let by_energy =
            |a: &&ConditionResult, b: &&ConditionResult| lowest(a).total_cmp(&lowest(b));
        let condition = self.conditions.iter().min_by(by_energy)?;
        let parts = condition.poses.first()?.parts;
        let acting = Term::ALL
            .into_iter()
            .filter(|term| parts.part_kt(*term) != 0.0);
        let share = |term: Term| format!("{} {:+.2} kT", term.word(), parts.part_kt(term));
        let parts: Vec<String> = acting.map(share).collect();
        let place = match (condition.ph, condition.salt_molar) {
            (None, None) => String::new(),
            (Some(ph), None) => format!(" (pH {ph})"),
            (None, Some(salt)) => format!(" ({} mM)", millimolar(salt)),
            (Some(ph), Some(salt)) => format!(" (pH {ph}, {} mM)", millimolar(salt)),
        };
        (!parts.is_empty())
            .then(|| format!("the lowest pose{place} is held by: {}", parts.join(", ")))
    }

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
