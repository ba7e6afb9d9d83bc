//! A potential of an angle as a table: in the settings of a run, and as a CSV file.
//!
//! ```text
//! angle_deg,energy_kt
//! 0,-2.5
//! 10,-1.9
//! ```
//!
//! The first line names the columns: `angle_rad` or `angle_deg`, and `energy` (reduced units) or
//! `energy_kt`. Columns whose names begin with `error` are passed over. The run keeps the table in its
//! settings, so that it does not depend on the file.

use anyhow::{Context, Result, anyhow, bail};
use protomer_io::csv::cells;
use protomer_kernel::spline::{Ends, Spline};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A potential of an angle, given at points; natural cubic splines between them, straight lines beyond.
///
/// ```
/// use protomer_linkage_verbs::lattice::potential_table::PotentialTable;
/// let table = PotentialTable::from_csv("well.csv", "angle_deg,energy_kt\n0,1\n90,0\n180,1\n")?;
/// assert_eq!(table.spline(Some(0.5))?.evaluate(0.0)[0], 0.5);
/// assert!(table.spline(None).is_err(), "in kT, but there is no temperature");
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PotentialTable {
    /// Angles, ascending, rad.
    pub angle_rad: Vec<f64>,
    /// Energies in reduced units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<Vec<f64>>,
    /// Energies in kT, instead of `energy`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_kt: Option<Vec<f64>>,
}

impl PotentialTable {
    /// Reads a CSV file.
    ///
    /// # Errors
    /// Names the file, the line and what is wrong.
    pub fn read(path: &Path) -> Result<Self> {
        let text = protomer_io::input::read_to_string(path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        Self::from_csv(&path.display().to_string(), &text)
    }

    /// The table of a text; `file` is for messages.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_csv(file: &str, text: &str) -> Result<Self> {
        let mut lines = text.lines().enumerate();
        let (_, first) = lines
            .next()
            .with_context(|| format!("{file} is empty; give a table with angles and energies"))?;
        let heading = Heading::from_cells(&cells(file, 1, first)?)
            .with_context(|| format!("{file}, line 1"))?;
        let (mut angle_rad, mut energies) = (Vec::new(), Vec::new());
        for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            let row = cells(file, number + 1, line)?;
            let value = |column: usize| -> Result<f64> {
                let word = row.get(column).map_or("", String::as_str);
                let place = || format!("{file}, line {}: '{word}' is no number", number + 1);
                let value: f64 = word.trim().parse().map_err(|_| anyhow!(place()))?;
                if value.is_finite() {
                    Ok(value)
                } else {
                    bail!("{}", place())
                }
            };
            angle_rad.push(value(heading.angle)? * heading.angle_unit_rad);
            energies.push(value(heading.energy)?);
        }
        let (energy, energy_kt) = match heading.is_in_kt {
            true => (None, Some(energies)),
            false => (Some(energies), None),
        };
        let table = Self {
            angle_rad,
            energy,
            energy_kt,
        };
        table.spline(Some(1.0)).with_context(|| file.to_owned())?;
        Ok(table)
    }

    /// The potential in reduced units, given kT in them.
    ///
    /// # Errors
    /// For points that make no table, and energies in kT without a temperature.
    pub fn spline(&self, kt: Option<f64>) -> Result<Spline> {
        let energies = match (&self.energy, &self.energy_kt, kt) {
            (Some(energy), None, _) => energy.clone(),
            (None, Some(energy), Some(kt)) => energy.iter().map(|energy| energy * kt).collect(),
            (None, Some(_), None) => bail!(
                "the energies are in kT, but there is no temperature; add --temperature and --friction, or give the \
                 column 'energy' in reduced units"
            ),
            _ => bail!("give either energy or energy_kt, one for each angle_rad"),
        };
        Ok(Spline::through(&self.angle_rad, &energies, Ends::Straight)?)
    }

    /// Whether an angle is beyond the first or the last point.
    pub fn ends_before(&self, angle_rad: f64) -> bool {
        let ends = self.angle_rad.first().zip(self.angle_rad.last());
        !ends.is_some_and(|(first, last)| (*first..=*last).contains(&angle_rad))
    }
}

/// Columns of angles and energies, and their units.
struct Heading {
    angle: usize,
    angle_unit_rad: f64,
    energy: usize,
    is_in_kt: bool,
}

impl Heading {
    fn from_cells(names: &[String]) -> Result<Self> {
        let (mut angle, mut energy) = (None, None);
        for (column, name) in names.iter().enumerate() {
            let place = match name.as_str() {
                "angle_rad" => angle.replace((column, 1.0)).is_some(),
                "angle_deg" => angle.replace((column, 1f64.to_radians())).is_some(),
                "energy" => energy.replace((column, false)).is_some(),
                "energy_kt" => energy.replace((column, true)).is_some(),
                other if other.starts_with("error") => false,
                other => bail!(
                    "there is no column '{other}'; the columns are angle_rad or angle_deg, and energy or energy_kt"
                ),
            };
            if place {
                bail!("there are two columns of the kind of '{name}'; leave one");
            }
        }
        match (angle, energy) {
            (Some((angle, angle_unit_rad)), Some((energy, is_in_kt))) => Ok(Self {
                angle,
                angle_unit_rad,
                energy,
                is_in_kt,
            }),
            _ => bail!(
                "the first line must name a column angle_rad or angle_deg, and a column energy or energy_kt"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_either_unit_are_the_same_potential() {
        let degrees = "error_kt,angle_deg,energy_kt\n0.1,0,2\n0.1,90,0\n,180,2\n\n";
        let radians = "angle_rad,energy\n0,1\n1.5707963267948966,0\n3.141592653589793,1\n";
        let [a, b] = [degrees, radians].map(|text| {
            PotentialTable::from_csv("t.csv", text)
                .unwrap()
                .spline(Some(0.5))
                .unwrap()
        });
        for k in -10..50 {
            let angle = 0.1 * f64::from(k);
            assert!((a.evaluate(angle)[0] - b.evaluate(angle)[0]).abs() < 1e-14);
        }
    }

    #[test]
    fn errors_name_the_line_and_the_remedy() {
        for (text, part) in [
            ("", "is empty"),
            ("angle,energy\n", "line 1"),
            ("angle_rad,energy,x\n", "no column 'x'"),
            ("angle_rad,energy,energy_kt\n", "two columns"),
            ("angle_rad\n0\n", "must name a column"),
            (
                "angle_rad,energy\n0,1\n1,high\n",
                "line 3: 'high' is no number",
            ),
            ("angle_rad,energy\n0,1\n1\n", "line 3: '' is no number"),
            ("angle_rad,energy\n0,1\n1,NaN\n", "line 3"),
            ("angle_rad,energy\n0,1\n", "at least 2 points"),
            ("angle_rad,energy\n0,1\n0,2\n", "do not ascend"),
        ] {
            let error = PotentialTable::from_csv("t.csv", text).unwrap_err();
            let message = format!("{error:#}");
            assert!(
                message.contains(part) && message.contains("t.csv"),
                "{message}"
            );
        }
    }

    #[test]
    fn angles_beyond_the_points_are_told() {
        let table = PotentialTable::from_csv("t.csv", "angle_rad,energy\n0,1\n1,2\n").unwrap();
        assert!(table.ends_before(1.1) && table.ends_before(-0.1) && !table.ends_before(1.0));
    }
}
