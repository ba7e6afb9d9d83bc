//! The equilibrium of an assembly in words, tables and files.

use super::figure;
use super::result::{ConditionRow, StabilityResult, concentration_in_words, listed};
use anyhow::{Context, Result};
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::atomic::write_atomically;
use protomer_io::csv::{Cell, Table};
use protomer_plot::Figure;
use std::path::Path;

/// Parts in the table of the terminal, the largest shares first.
const PARTS_SHOWN: usize = 6;

impl Answer for StabilityResult {
    fn text(&self) -> String {
        let mut lines = vec![
            format!(
                "equilibrium: {} ({})",
                self.equilibrated, self.equilibration
            ),
            format!("way: {}; {}", self.way, self.reason),
            self.table(),
            self.parts_in_words(),
            self.headline(),
            self.half_bound_in_words(),
            self.box_in_words(),
            format!("model: {}", self.model),
        ];
        lines.retain(|line| !line.is_empty());
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(figure::figure(self))
    }
}

impl StabilityResult {
    /// The proposed box, and its use.
    fn box_in_words(&self) -> String {
        let concentration = concentration_in_words(self.settings.concentration_molar[0]);
        self.proposed_box_angstrom
            .map_or(String::new(), |edge| {
                format!(
                    "box: {edge:.0} Å for {} bodies at {concentration}; mass action needs none, simulate and sweep take it from \
                     assembly/assembly.json",
                    self.bodies
                )
            })
    }

    fn table(&self) -> String {
        let mut rows = vec![heading([
            "pH",
            "salt (M)",
            "bodies (M)",
            "yield",
            "±",
            "free",
            "half yield at (M)",
            "free energy of the whole (kT)",
            "±",
        ])];
        for row in &self.conditions {
            for mixture in &row.mixtures {
                let whole = row.parts.last();
                rows.push(vec![
                    shown(row.ph, |ph| format!("{ph:.2}")),
                    format!("{:.4}", row.salt_molar),
                    format!("{:.2e}", mixture.concentration_molar),
                    format!("{:.3}", mixture.whole),
                    format!("{:.3}", mixture.whole_error),
                    format!("{:.3}", self.free_share(&mixture.shares)),
                    shown(row.half_concentration_molar, |molar| format!("{molar:.1e}")),
                    shown(whole.and_then(|whole| whole.free_energy_kt), |kt| {
                        format!("{kt:.1}")
                    }),
                    shown(whole.and_then(|whole| whole.free_energy_error_kt), |kt| {
                        format!("{kt:.1}")
                    }),
                ]);
            }
        }
        columns(&rows)
    }

    /// Share of the bodies that are alone.
    pub(super) fn free_share(&self, shares: &[f64]) -> f64 {
        let parts = self.parts.iter().zip(shares);
        parts
            .filter(|(part, _)| part.bodies.len() == 1)
            .map(|(_, share)| share)
            .sum()
    }

    /// Numbers of the parts with the largest shares under any condition, but the whole and single bodies.
    pub(super) fn largest_parts(&self) -> Vec<usize> {
        let most = |number: usize| {
            let mixtures = self.conditions.iter().flat_map(|row| &row.mixtures);
            mixtures
                .map(|mixture| mixture.shares[number])
                .fold(0.0, f64::max)
        };
        let mut numbers: Vec<usize> = (0..self.parts.len().saturating_sub(1))
            .filter(|number| self.parts[*number].bodies.len() > 1)
            .collect();
        numbers.sort_by(|a, b| most(*b).total_cmp(&most(*a)));
        numbers
    }

    fn parts_in_words(&self) -> String {
        let numbers = self.largest_parts();
        let Some(first) = self.conditions.first().filter(|_| !numbers.is_empty()) else {
            return String::new();
        };
        let mut rows = vec![heading([
            "part",
            "bodies",
            "symmetry",
            "free energy (kT)",
            "±",
            "share",
        ])];
        for number in numbers.into_iter().take(PARTS_SHOWN) {
            let (part, found) = (&self.parts[number], &first.parts[number]);
            rows.push(vec![
                part.name.clone(),
                listed(&part.bodies),
                part.symmetry_number.to_string(),
                shown(found.free_energy_kt, |kt| format!("{kt:.1}")),
                shown(found.free_energy_error_kt, |kt| format!("{kt:.1}")),
                format!("{:.3}", first.mixtures[0].shares[number]),
            ]);
        }
        format!("{}, parts:\n{}", condition_in_words(first), columns(&rows))
    }

    /// Writes the tables, the JSON form and the figures into a directory.
    pub(super) fn write(&self, directory: &Path) -> Result<()> {
        let json = serde_json::to_string_pretty(self).context("the result cannot be serialised")?;
        for (name, text) in [
            ("stability.csv", self.to_csv()?),
            ("parts.csv", self.parts_to_csv()?),
            ("stability.json", json + "\n"),
        ] {
            write_atomically(&directory.join(name), |file| {
                file.write_all(text.as_bytes())
            })?;
        }
        figure::write(self, directory)
    }

    fn to_csv(&self) -> Result<String> {
        let mut table = Table::new([
            "ph",
            "salt_M",
            "concentration_M",
            "yield",
            "yield_error",
            "free_share",
            "half_concentration_M",
        ]);
        for row in &self.conditions {
            for mixture in &row.mixtures {
                table.push([
                    optional(row.ph),
                    Cell::Number(row.salt_molar),
                    Cell::Number(mixture.concentration_molar),
                    Cell::Number(mixture.whole),
                    Cell::Number(mixture.whole_error),
                    Cell::Number(self.free_share(&mixture.shares)),
                    optional(row.half_concentration_molar),
                ])?;
            }
        }
        Ok(table.to_csv()?)
    }

    fn parts_to_csv(&self) -> Result<String> {
        let mut table = Table::new([
            "ph",
            "salt_M",
            "part",
            "bodies",
            "symmetry_number",
            "free_energy_kt",
            "free_energy_error_kt",
            "mean_energy_kt",
            "displacement_angstrom",
            "share_at_limit",
        ]);
        for row in &self.conditions {
            for (part, found) in self.parts.iter().zip(&row.parts) {
                table.push([
                    optional(row.ph),
                    Cell::Number(row.salt_molar),
                    Cell::Text(part.name.clone()),
                    Cell::Number(part.bodies.len() as f64),
                    Cell::Number(part.symmetry_number as f64),
                    optional(found.free_energy_kt),
                    optional(found.free_energy_error_kt),
                    optional(found.mean_energy_kt),
                    optional(found.displacement_angstrom),
                    optional(found.share_at_limit),
                ])?;
            }
        }
        Ok(table.to_csv()?)
    }
}

/// A condition in words.
pub(super) fn condition_in_words(row: &ConditionRow) -> String {
    let salt = format!("{} of salt", concentration_in_words(row.salt_molar));
    match row.ph {
        Some(ph) => format!("pH {ph:.2}, {salt}"),
        None => salt,
    }
}

/// A dash for what is not known.
pub(super) fn shown<T>(value: Option<T>, format: impl FnOnce(T) -> String) -> String {
    value.map_or("-".into(), format)
}

fn optional(value: Option<f64>) -> Cell {
    value.map_or(Cell::Empty, Cell::Number)
}
