//! What was made of a structure, for the terminal and as JSON.

use super::checks::shortened;
use super::shapes::OwnShape;
use crate::bodies::ingest::BodyMeasures;
use protomer_body::assembly::PointGroup;
use protomer_body::structure::SelectionReport;
use protomer_common::answer::{Answer, columns, heading};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// A displacement by more than this, Å, opens the contacts of a structure.
const LARGE_DISPLACEMENT_ANGSTROM: f64 = 1.0;

/// Result of [`assemble_structure`](super::assemble_structure).
#[derive(Debug, Clone, Serialize)]
pub struct StructureAssembly {
    /// The assembly file.
    pub assembly: PathBuf,
    /// The body files with the copies of each.
    pub bodies: Vec<StructureBody>,
    /// Point group of the bodies as they are in the structure; null for one body, and where the rotations that map
    /// them onto each other form no group.
    pub point_group: Option<PointGroup>,
    /// Names of the placed bodies, in the order of the assembly file.
    pub placed: Vec<String>,
    /// Pairs of placed bodies that overlapped as hard bodies.
    pub overlaps: Vec<(usize, usize)>,
    /// Displacement of each placed body to remove the overlaps: root mean square over its atoms, Å.
    pub moved_angstrom: Vec<f64>,
    /// Pairs of residues of different bodies with heavy atoms within 4.5 Å in the structure.
    pub native_contacts: usize,
    /// Share of the native contacts that the placed bodies have; `None` if there are none.
    pub native_contacts_kept: Option<f64>,
    /// Copies that keep their own shape, and why.
    pub own_shapes: Vec<OwnShape>,
    /// Edge of a cubic periodic box with room for the bodies next to each other, Å.
    pub proposed_box_angstrom: f64,
    /// Bodies that should be one, and the flag that makes them one.
    pub proposals: Vec<String>,
    /// Atoms left out of all chains, by reason.
    pub skipped: BTreeMap<&'static str, usize>,
    /// Warnings about the files and their chains, as `ingest` gives them, and about interfaces.
    pub structure_warnings: Vec<String>,
    /// The full report on the selection of atoms, of the first file.
    pub selection: SelectionReport,
    /// The full reports on the selection of atoms, one for each further file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub further_selections: Vec<SelectionReport>,
    /// Whether the assembly has a periodic box already.
    #[serde(skip)]
    pub has_box: bool,
}

/// One kind of body of a structure.
#[derive(Debug, Clone, Serialize)]
pub struct StructureBody {
    /// The body file.
    pub file: PathBuf,
    /// The unit it was made from: a chain, joined chains, or a file.
    pub reference: String,
    /// The units that are copies of the body, the reference among them.
    pub chains: Vec<String>,
    /// Root mean square distance of each copy from the reference, Å.
    pub rmsd_angstrom: Vec<f64>,
    /// Size and charge of the body.
    #[serde(flatten)]
    pub measures: BodyMeasures,
    /// Warnings about the surface of the body.
    pub warnings: Vec<String>,
}

impl StructureAssembly {
    /// Warnings that a user should read before simulating the assembly.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for warning in self.structure_warnings.iter().chain(&self.proposals) {
            warnings.push(format!("warning: {warning}"));
        }
        for body in &self.bodies {
            for warning in &body.warnings {
                let file = body.file.display();
                warnings.push(format!("warning: {file}: {warning}"));
            }
        }
        if self.placed.len() == 1 {
            warnings.push(
                "warning: this is a single body, which has nothing to fall apart from; ask for the \
                 biological assembly with --assembly 1"
                    .into(),
            );
        }
        warnings.extend(self.large_displacements());
        warnings
    }

    fn large_displacements(&self) -> Option<String> {
        let places = self.moved_angstrom.iter().zip(&self.placed);
        let displacements =
            places.filter(|(displacement, _)| **displacement > LARGE_DISPLACEMENT_ANGSTROM);
        let bodies: Vec<String> = displacements
            .map(|(displacement, name)| format!("{name} {displacement:.1} Å"))
            .collect();
        (!bodies.is_empty()).then(|| {
            format!(
                "warning: bodies moved far enough to open contacts of the structure ({}); bodies that \
                 interlock are better made one with --body",
                bodies.join(", ")
            )
        })
    }

    /// A line for each body that stands for copies that keep their own shape.
    fn own_shapes_in_words(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for body in &self.bodies {
            let shapes = self.own_shapes.iter();
            let shapes: Vec<&OwnShape> = shapes
                .filter(|shape| body.chains.contains(&shape.copy))
                .collect();
            let Some(first) = shapes.first() else {
                continue;
            };
            let copies: Vec<String> = shapes.iter().map(|shape| shape.copy.clone()).collect();
            let others: BTreeSet<&String> = shapes
                .iter()
                .flat_map(|shape| &shape.would_overlap)
                .collect();
            let others: Vec<String> = others.into_iter().cloned().collect();
            let lost: usize = shapes.iter().map(|shape| shape.would_lose_contacts).sum();
            let otherwise = match others.len() {
                0 => format!("lose {lost} native residue contacts"),
                _ => format!("overlap {}", shortened(&others)),
            };
            let (keeps, they) = match copies.len() {
                1 => ("keeps its own shape", "it"),
                _ => ("keep their own shape", "they"),
            };
            lines.push(format!(
                "{} {keeps}: with that of {} ({:.2} Å RMSD) {they} would {otherwise}",
                shortened(&copies),
                first.reference,
                first.rmsd_angstrom
            ));
        }
        lines
    }

    fn symmetry_in_words(&self) -> Option<String> {
        let group = self.point_group.as_ref()?;
        Some(match group.order {
            1 => "point group C1: no rotation maps the bodies onto each other".into(),
            _ => format!(
                "point group {}, deviations of at most {:.2} Å",
                group.name, group.deviation_angstrom
            ),
        })
    }

    fn overlaps_in_words(&self) -> String {
        let displacement = self.moved_angstrom.iter().copied().fold(0.0, f64::max);
        let contacts = match self.native_contacts_kept {
            Some(share) => format!(
                "{:.1} % of {} native residue contacts left",
                100.0 * share,
                self.native_contacts
            ),
            None => "no residues of different bodies in contact".into(),
        };
        match self.overlaps.len() {
            0 => format!("no overlaps; {contacts}"),
            pairs => format!(
                "{pairs} pairs of bodies overlapped; moved apart by at most {displacement:.2} Å; {contacts}"
            ),
        }
    }
}

impl Answer for StructureAssembly {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "body",
            "atoms",
            "residues",
            "net charge (e)",
            "copies",
            "largest RMSD (Å)",
        ])];
        for body in &self.bodies {
            let largest = body.rmsd_angstrom.iter().copied().fold(0.0, f64::max);
            rows.push(vec![
                body.file.display().to_string(),
                body.measures.atoms.to_string(),
                body.measures.residues.to_string(),
                format!("{:+.2}", body.measures.net_charge_e),
                body.chains.join(" "),
                format!("{largest:.3}"),
            ]);
        }
        let mut lines = vec![columns(&rows)];
        for report in std::iter::once(&self.selection).chain(&self.further_selections) {
            let skipped = report.skipped_in_words();
            lines.extend(skipped.map(|skipped| format!("left out: {skipped}")));
        }
        lines.extend(self.symmetry_in_words());
        lines.extend(self.own_shapes_in_words());
        lines.push(self.overlaps_in_words());
        if !self.has_box {
            lines.push(format!(
                "no periodic box; --box {:.0} has room for the bodies apart",
                self.proposed_box_angstrom
            ));
        }
        lines.push(self.assembly.display().to_string());
        lines.join("\n")
    }
}
