//! What the page of a run shows of the energies of residues: what holds the assembly together.

use super::{FOLDER, MutationRow, ResidueRow, ResiduesResult};
use crate::assemblies::assembly_file::Assembly;
use crate::stability::pair::ResiduePlaces;
use crate::stability::pair::page::surfaces::limit_of;
use anyhow::{Context, Result, bail};
use protomer_common::page::scene::{Colouring, Shown};
use protomer_common::page::{Part, Section, significant, significant_or_dash, with_error_to};
use protomer_mc::contributions::Mean;
use protomer_results::Record;
use rayon::prelude::*;
use std::path::Path;

/// Rows of the table of residues and of that of exchanges.
const MOST_ROWS: usize = 15;
const UNIT: &str = "mean energy of a residue with all other bodies, kT; negative (red): it holds the bodies together";
const HEAD: &str = "The energy of the assembly, shared out by residues. A pair of residues counts in full with both. In the viewer above, the \
                    surfaces can be coloured by it.";

/// The energies of residues in the directory of a run.
#[derive(Debug)]
pub struct Residues {
    result: ResiduesResult,
}

impl Residues {
    /// Reads the energies; `None` if there are none. Those of an earlier run are refused with a
    /// note.
    ///
    /// # Errors
    /// If the file is damaged.
    pub fn read(directory: &Path, record: Option<&Record>) -> Result<Option<Self>> {
        let folder = directory.join(FOLDER);
        let Some(result) = ResiduesResult::read(&folder)? else {
            return Ok(None);
        };
        // Energies of another run must not colour these bodies.
        if record.is_some_and(|record| record.identity != result.identity) {
            bail!(
                "{} is of another run; repeat 'protomer residues' with --force",
                folder.display()
            );
        }
        Ok(Some(Self { result }))
    }

    /// Adds a colouring by energy to the viewer, if it shows the bodies of this assembly.
    pub fn colour(&self, assembly: &Assembly, shown: &mut Shown) {
        let rows = self.result.residues.iter();
        let energies_kt: Vec<f64> = rows.map(|row| row.energy_kt.mean).collect();
        let residues: usize = assembly.bodies.iter().map(|body| body.residues.len()).sum();
        // Another assembly, or one that was changed since.
        if energies_kt.len() != residues || shown.meshes.len() != assembly.bodies.len() {
            return;
        }
        shown.colourings.push(Colouring {
            name: format!("energy of residues at {}", self.salt()),
            unit: UNIT.into(),
            limit: limit_of(energies_kt.iter().copied()),
            colours: ["#c0282d", "#f7f7f7", "#2457b8"],
        });
        // Rows follow bodies and their residues in order.
        let mut start = 0;
        for (mesh, body) in shown.meshes.iter_mut().zip(&assembly.bodies) {
            let of_body = &energies_kt[start..start + body.residues.len()];
            start += body.residues.len();
            let places = ResiduePlaces::from_body(body);
            let value = |vertex| match places.nearest(vertex) {
                Some(residue) => of_body[residue],
                None => f64::NAN,
            };
            mesh.values
                .push(body.mesh.vertices.par_iter().map(value).collect());
        }
    }

    /// The section.
    pub fn section(&self) -> Section {
        let file = |name: &str| format!("{FOLDER}/{name}");
        let picture = |name: &str, title| Part::picture(&file(name), title, None);
        let mut parts = vec![
            Part::Paragraph(HEAD.into()),
            Part::Values(self.summary()),
            self.residue_table(),
            Part::file(&file("residues.csv")),
            picture("residues.svg", "Energy by residue"),
            picture("contact_map.svg", "Contacts of residues"),
            picture("energy_map.svg", "Energies of pairs of residues"),
            Part::file(&file("residue_pairs.csv")),
        ];
        if !self.mutations().is_empty() {
            let note = "Exchanges of one charge in every copy, those that lower the energy most and least. \
                        Residues that touch another body are in the file only, unless they were requested:";
            parts.extend([
                Part::Paragraph(note.into()),
                self.mutation_table(),
                Part::file(&file("mutations.csv")),
            ]);
        }
        Section::new("What holds it", parts)
    }

    fn mutations(&self) -> &[MutationRow] {
        self.result.mutations.as_deref().unwrap_or_default()
    }

    fn salt(&self) -> String {
        let salt_molar = self.result.interaction.electrolyte.salt_molar();
        let salt_millimolar = salt_molar.map(|molar| 1e3 * molar);
        format!("{} mM", significant_or_dash(salt_millimolar, 4))
    }

    fn summary(&self) -> Vec<(&'static str, String)> {
        let result = &self.result;
        let energy = &result.energy;
        let share = |share: Option<Mean>| match share {
            None => "–".to_owned(),
            Some(share) => format!("{} %", with_error(share, 100.0, 2)),
        };
        let mut rows = vec![
            ("salt", self.salt()),
            ("frames", result.frames.to_string()),
            (
                "energy",
                format!("{} kT", with_error(energy.total_kt, 1.0, 4)),
            ),
        ];
        for (term, energy_kt) in result.further_terms() {
            rows.push((
                term.phrase(),
                format!("{} kT", with_error(energy_kt, 1.0, 4)),
            ));
        }
        rows.extend([
            (
                "residues that touch no other body",
                share(Some(result.residues_outside_contacts)),
            ),
            (
                "of the energy of the charges, from these residues",
                share(result.outside_contacts_share),
            ),
            (
                "from pairs of residues that do not touch each other",
                share(result.apart_share),
            ),
        ]);
        rows
    }

    fn residue_table(&self) -> Part {
        let line = |row: &ResidueRow| {
            vec![
                row.name.body.clone(),
                row.name.short(),
                with_error(row.energy_kt, 1.0, 3),
                significant(row.touching, 2),
            ]
        };
        let strongest = self.result.strongest().into_iter().take(MOST_ROWS);
        Part::Table {
            columns: vec!["body", "residue", "energy per copy (kT)", "touching"],
            rows: strongest.map(line).collect(),
        }
    }

    fn mutation_table(&self) -> Part {
        let columns = vec![
            "body",
            "exchange",
            "touching",
            "energy (kT)",
            "shift of the half salt (mM)",
            "effective frames",
        ];
        let line = |row: &MutationRow| {
            let shift = row.half_salt_shift_molar;
            vec![
                row.name.body.clone(),
                row.mutation.clone(),
                significant(row.touching, 2),
                with_error(row.energy_change_kt, 1.0, 3),
                shift.map_or_else(|| "–".into(), |shift| with_error(shift, 1e3, 3)),
                significant(row.effective_frames, 3),
            ]
        };
        let lists_all = self.result.recommends_touching;
        let is_listed = |row: &&MutationRow| lists_all || row.recommended;
        let rows: Vec<&MutationRow> = self.mutations().iter().filter(is_listed).collect();
        let half = MOST_ROWS.div_ceil(2).min(rows.len());
        let last = rows.len().saturating_sub(half).max(half);
        let ends = rows[..half].iter().chain(&rows[last..]);
        Part::Table {
            columns,
            rows: ends.map(|row| line(row)).collect(),
        }
    }
}

fn with_error(value: Mean, factor: f64, digits: usize) -> String {
    let error = value.error.map(|error| factor * error);
    with_error_to(factor * value.mean, error, digits)
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
