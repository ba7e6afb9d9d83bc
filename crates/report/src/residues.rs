//! What holds an assembly together, as `protomer residues` left it in the directory of a run.

use super::html::{definitions, paragraph, significant, significant_or_dash, table};
use super::mesh_view::{Colouring, Shown};
use super::page::Section;
use super::{data, figures};
use anyhow::{Context, Result, bail};
use protomer::assemblies::assembly_file::Assembly;
use protomer::stability::pair::ResiduePlaces;
use protomer::stability::residues::{FOLDER, ResidueName};
use protomer_results::Record;
use protomer_results::keys::read_json_if_present;
use rayon::prelude::*;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Rows of the table of residues and of that of exchanges.
const MOST_ROWS: usize = 15;
/// Possible ends of the scale of colours, kT.
const LIMITS_KT: [f64; 9] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
const UNIT: &str = "mean energy of a residue with all other bodies, kT; negative (red): it holds the bodies together";
const HEAD: &str = "The energy of the assembly, shared out by residues. A pair of residues counts in full with both. In the viewer above, the \
                    surfaces can be coloured by it.";

/// The energies of residues in the directory of a run.
pub struct Residues {
    folder: PathBuf,
    result: Value,
}

impl Residues {
    /// Reads the energies; `None` if there are none. Those of an earlier run are refused with a
    /// note.
    ///
    /// # Errors
    /// If the file is damaged.
    pub fn read(directory: &Path, record: Option<&Record>) -> Result<Option<Self>> {
        let folder = directory.join(FOLDER);
        let result: Option<Value> = read_json_if_present(&folder.join("residues.json"))?;
        let Some(result) = result else {
            return Ok(None);
        };
        let identity = record.map(|record| record.identity.as_str());
        if identity.is_some() && result["identity"].as_str() != identity {
            bail!(
                "{} is of another run; repeat 'protomer residues' with --force",
                folder.display()
            );
        }
        Ok(Some(Self { folder, result }))
    }

    /// Adds a colouring by energy to the viewer, if it shows the bodies of this assembly.
    pub fn colour(&self, assembly: &Assembly, shown: &mut Shown) {
        let mut energies: Vec<(ResidueName, f64)> = Vec::new();
        for row in self.rows("residues") {
            let name = serde_json::from_value(row.clone());
            if let (Ok(name), Some(energy_kt)) = (name, mean(&row["energy_kt"])) {
                energies.push((name, energy_kt));
            }
        }
        let residues: usize = assembly.bodies.iter().map(|body| body.residues.len()).sum();
        if energies.len() != residues || shown.meshes.len() != assembly.bodies.len() {
            return;
        }
        let sizes = energies.iter().map(|(_, energy_kt)| energy_kt.abs());
        let most = sizes.fold(0.0, f64::max);
        let [.., largest] = LIMITS_KT;
        let covering = LIMITS_KT.into_iter().find(|limit| *limit >= most);
        shown.colourings.push(Colouring {
            name: format!("energy of residues at {}", self.salt()),
            unit: UNIT.into(),
            limit: covering.unwrap_or(largest),
            colours: ["#c0282d", "#f7f7f7", "#2457b8"],
        });
        let mut start = 0;
        for (mesh, body) in shown.meshes.iter_mut().zip(&assembly.bodies) {
            let of_body = &energies[start..start + body.residues.len()];
            start += body.residues.len();
            let places = ResiduePlaces::of(body);
            let value = |vertex| match places.nearest(vertex) {
                Some(residue) => of_body[residue].1,
                None => f64::NAN,
            };
            mesh.values
                .push(body.mesh.vertices.par_iter().map(value).collect());
        }
    }

    /// The section.
    ///
    /// # Errors
    /// If a file is damaged.
    pub fn section(&self) -> Result<Section> {
        let mut html = paragraph(HEAD) + &definitions(&self.summary());
        html += &self.residue_table();
        html += &data::of_file(&self.folder, "residues.csv")?;
        for (name, title) in [
            ("residues.svg", "Energy by residue"),
            ("contact_map.svg", "Contacts of residues"),
            ("energy_map.svg", "Energies of pairs of residues"),
        ] {
            html += &figures::of_file(&self.folder, name, title, "")?;
        }
        html += &data::of_file(&self.folder, "residue_pairs.csv")?;
        if !self.rows("mutations").is_empty() {
            html += &paragraph(
                "Exchanges of one charge in every copy, those that lower the energy most and least. \
                 Residues that touch another body are in the file only, unless they were requested:",
            );
            html += &self.mutation_table();
            html += &data::of_file(&self.folder, "mutations.csv")?;
        }
        Ok(Section::new("What holds it", html))
    }

    fn rows(&self, key: &str) -> &[Value] {
        self.result[key].as_array().map_or(&[], Vec::as_slice)
    }

    fn salt(&self) -> String {
        let salt = self.result["salt_M"].as_f64();
        format!("{} mM", significant_or_dash(salt.map(|salt| 1e3 * salt), 4))
    }

    fn summary(&self) -> Vec<(&'static str, String)> {
        let result = &self.result;
        let energy = &result["energy"];
        let share = |key: &str| match result[key].is_null() {
            true => "–".to_owned(),
            false => format!("{} %", with_error(&result[key], 100.0, 2)),
        };
        let mut rows = vec![
            ("salt", self.salt()),
            ("frames", result["frames"].to_string()),
            (
                "energy",
                format!("{} kT", with_error(&energy["total_kt"], 1.0, 4)),
            ),
        ];
        for (key, name) in [
            ("contacts_kt", "attraction between residues"),
            ("desolvation_kt", "desolvation"),
            ("solvent_response_kt", "response of the solvent"),
        ] {
            if mean(&energy[key]).is_some_and(|energy_kt| energy_kt != 0.0) {
                rows.push((name, format!("{} kT", with_error(&energy[key], 1.0, 4))));
            }
        }
        rows.extend([
            (
                "residues that touch no other body",
                share("residues_outside_contacts"),
            ),
            (
                "of the energy of the charges, from these residues",
                share("outside_contacts_share"),
            ),
            (
                "from pairs of residues that do not touch each other",
                share("apart_share"),
            ),
        ]);
        rows
    }

    fn residue_table(&self) -> String {
        let mut rows: Vec<&Value> = self.rows("residues").iter().collect();
        let size = |row: &Value| mean(&row["energy_kt"]).unwrap_or(0.0).abs();
        rows.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let head = ["body", "residue", "energy per copy (kT)", "touching"];
        let line = |row: &Value| {
            let name = serde_json::from_value::<ResidueName>(row.clone());
            let short = name.map_or_else(|_| String::new(), |name| name.short());
            vec![
                row["body"].as_str().unwrap_or_default().to_owned(),
                short,
                with_error(&row["energy_kt"], 1.0, 3),
                significant_or_dash(row["touching"].as_f64(), 2),
            ]
        };
        let lines: Vec<Vec<String>> = rows.into_iter().take(MOST_ROWS).map(line).collect();
        table(&head.map(str::to_owned), &lines)
    }

    fn mutation_table(&self) -> String {
        let head = [
            "body",
            "exchange",
            "touching",
            "energy (kT)",
            "shift of the half salt (mM)",
            "effective frames",
        ];
        let line = |row: &Value| {
            let shift = &row["half_salt_shift_molar"];
            vec![
                row["body"].as_str().unwrap_or_default().to_owned(),
                row["mutation"].as_str().unwrap_or_default().to_owned(),
                significant_or_dash(row["touching"].as_f64(), 2),
                with_error(&row["energy_change_kt"], 1.0, 3),
                match shift.is_null() {
                    true => "–".into(),
                    false => with_error(shift, 1e3, 3),
                },
                significant_or_dash(row["effective_frames"].as_f64(), 3),
            ]
        };
        let lists_all = self.result["recommends_touching"] == true;
        let is_listed = |row: &&Value| lists_all || row["recommended"] != false;
        let rows: Vec<&Value> = self.rows("mutations").iter().filter(is_listed).collect();
        let half = MOST_ROWS.div_ceil(2).min(rows.len());
        let last = rows.len().saturating_sub(half).max(half);
        let lines: Vec<Vec<String>> = rows[..half]
            .iter()
            .chain(&rows[last..])
            .map(|row| line(row))
            .collect();
        table(&head.map(str::to_owned), &lines)
    }
}

fn mean(value: &Value) -> Option<f64> {
    value["mean"].as_f64()
}

fn with_error(value: &Value, factor: f64, digits: usize) -> String {
    let Some(mean) = mean(value) else {
        return "–".into();
    };
    match value["error"].as_f64() {
        Some(error) => format!(
            "{} ± {}",
            significant(factor * mean, digits),
            significant(factor * error, 2)
        ),
        None => significant(factor * mean, digits),
    }
}

/// Reads the energies of residues of a run; a note if they cannot be used.
pub fn collect(directory: &Path, record: Option<&Record>) -> (Option<Residues>, Option<String>) {
    let residues = Residues::read(directory, record)
        .with_context(|| "the energies of residues are not shown".to_owned());
    match residues {
        Ok(residues) => (residues, None),
        Err(error) => (None, Some(format!("{error:#}."))),
    }
}
