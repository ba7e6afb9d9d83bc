//! The bodies of the units of a structure, and which copies share one.

use super::files::{File, NamedUnit};
use super::{CopyShapes, StructureSettings};
use crate::assemblies::assemble::BodyFiles;
use anyhow::{Context, Result};
use protomer_body::assembly::{
    self, BodyType, ChainCopy, ResidueContacts, Unit, body_types_of_units,
};
use protomer_body::structure::SelectionReport;
use protomer_body::{BuiltBody, Draft, Source};
use protomer_field::titration::SolvedProtonation;
use protomer_io::written::FileNames;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Copies that differ by less than this from the reference have its shape, Å (root mean square).
const SAME_SHAPE_ANGSTROM: f64 = 0.02;
/// A copy that would keep less than this share of its native residue contacts keeps its own shape.
const LEAST_CONTACTS_KEPT: f64 = 0.95;

/// A copy that keeps its own shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OwnShape {
    /// Name of the copy.
    pub copy: String,
    /// The reference whose shape the copy would share otherwise.
    pub reference: String,
    /// Root mean square distance from the reference, Å.
    pub rmsd_angstrom: f64,
    /// Bodies that the copy would overlap with the shape of the reference.
    pub would_overlap: Vec<String>,
    /// Number of native residue contacts that the copy would lose with the shape of the reference;
    /// 0 where it would overlap.
    pub would_lose_contacts: usize,
}

/// The bodies of a structure and where they are.
pub(super) struct Placed {
    pub types: Vec<BodyType>,
    pub built: Vec<BuiltBody>,
    pub files: BodyFiles,
    /// Copies of the first type, then those of the second, and so on.
    pub placements: Vec<assembly::Placement>,
    /// Pairs of placements that overlap as hard bodies.
    pub overlaps: Vec<(usize, usize)>,
    pub own_shapes: Vec<OwnShape>,
}

/// Makes the bodies of units. Copies that would overlap with the shape of their reference or lose contacts of
/// the structure, and differ from it, keep their own, unless the settings say that all shapes are shared.
pub(super) fn place(
    files: &[File],
    named: &[NamedUnit],
    units: &[Unit],
    folder: &Path,
    settings: &StructureSettings,
) -> Result<Placed> {
    let mut maker = Maker {
        files,
        named,
        settings,
        made: BTreeMap::new(),
    };
    let (mut with_own_shape, mut own_shapes) = (BTreeSet::new(), Vec::new());
    let native = ResidueContacts::native(units);
    loop {
        // The report of each body is that of its file.
        let report = SelectionReport::default();
        let types = body_types_of_units(units, &report, &with_own_shape)?;
        let (built, body_files) = maker.bodies(&types, folder)?;
        let mut placements = Vec::new();
        for (kind, of_type) in types.iter().enumerate() {
            placements.extend(of_type.copies.iter().map(|copy| (kind, copy.pose)));
        }
        let overlaps = body_files.hard.overlapping_pairs(&placements);
        let differing = match settings.shapes {
            CopyShapes::Fitting => {
                let overlapping = overlapping(&types, units, &overlaps);
                if overlapping.is_empty() {
                    let now = ResidueContacts::of_placements(units, &types, &placements);
                    losing_contacts(&types, &native.kept_by_unit(&now, units.len()))
                } else {
                    overlapping
                }
            }
            CopyShapes::Shared => BTreeMap::new(),
        };
        if differing.is_empty() {
            return Ok(Placed {
                types,
                built,
                files: body_files,
                placements,
                overlaps,
                own_shapes,
            });
        }
        for (unit, own_shape) in differing {
            with_own_shape.insert(unit);
            own_shapes.push(own_shape);
        }
    }
}

/// The copies in overlapping pairs that differ from their reference, by the number of their unit.
fn overlapping(
    types: &[BodyType],
    units: &[Unit],
    overlaps: &[(usize, usize)],
) -> BTreeMap<usize, OwnShape> {
    let mut copies = Vec::new();
    for of_type in types {
        copies.extend(of_type.copies.iter().map(|copy| (of_type, copy)));
    }
    let mut own_shapes: BTreeMap<usize, OwnShape> = BTreeMap::new();
    for (a, b) in overlaps {
        for (one, other) in [(*a, *b), (*b, *a)] {
            let (of_type, copy) = copies[one];
            if copy.rmsd_angstrom < SAME_SHAPE_ANGSTROM {
                continue;
            }
            let own_shape = own_shapes
                .entry(copy.unit)
                .or_insert_with(|| OwnShape::from_copy(of_type, copy));
            let name = units[copies[other].1.unit].name.clone();
            own_shape.would_overlap.push(name);
        }
    }
    own_shapes
}

/// The copies that differ from their reference and keep few of their contacts, by the number of their unit.
fn losing_contacts(
    types: &[BodyType],
    contact_counts: &[(usize, usize)],
) -> BTreeMap<usize, OwnShape> {
    let mut own_shapes = BTreeMap::new();
    for of_type in types {
        for copy in &of_type.copies {
            let (contacts, retained_contacts) = contact_counts[copy.unit];
            let is_enough = retained_contacts as f64 >= LEAST_CONTACTS_KEPT * contacts as f64;
            if is_enough || copy.rmsd_angstrom < SAME_SHAPE_ANGSTROM {
                continue;
            }
            let own_shape = OwnShape {
                would_lose_contacts: contacts - retained_contacts,
                ..OwnShape::from_copy(of_type, copy)
            };
            own_shapes.insert(copy.unit, own_shape);
        }
    }
    own_shapes
}

impl OwnShape {
    fn from_copy(of_type: &BodyType, copy: &ChainCopy) -> Self {
        Self {
            copy: copy.chain.clone(),
            reference: of_type.reference.clone(),
            rmsd_angstrom: copy.rmsd_angstrom,
            would_overlap: Vec::new(),
            would_lose_contacts: 0,
        }
    }
}

/// Makes each body once.
struct Maker<'a> {
    files: &'a [File],
    named: &'a [NamedUnit],
    settings: &'a StructureSettings,
    /// The bodies made so far, by the number of their unit.
    made: BTreeMap<usize, BuiltBody>,
}

impl Maker<'_> {
    fn bodies(&mut self, types: &[BodyType], folder: &Path) -> Result<(Vec<BuiltBody>, BodyFiles)> {
        let (mut built, mut paths, mut names) = (Vec::new(), Vec::new(), FileNames::default());
        for of_type in types {
            let name = names.add(&self.named[of_type.unit].body);
            let mut body = self.body(of_type.unit)?.clone();
            body.body.name.clone_from(&name);
            paths.push(folder.join(format!("{name}.body")));
            built.push(body);
        }
        let bodies = built.iter().map(|built| built.body.clone()).collect();
        Ok((built, BodyFiles::new(paths, bodies)?))
    }

    fn body(&mut self, unit: usize) -> Result<&BuiltBody> {
        if !self.made.contains_key(&unit) {
            let made = self.make(unit)?;
            self.made.insert(unit, made);
        }
        Ok(&self.made[&unit])
    }

    fn make(&self, unit: usize) -> Result<BuiltBody> {
        let NamedUnit { file, body, unit } = &self.named[unit];
        let file = &self.files[*file];
        let source = Source {
            file: &file.name,
            sha256: &file.sha256,
        };
        let selection = unit.to_selection(&file.selection.report);
        let settings = &self.settings.body;
        let solved = &SolvedProtonation;
        let mut built = Draft::of_protonated_selection(body, source, selection, settings, solved)
            .and_then(Draft::build)
            .with_context(|| format!("{}: {}", file.name, unit.name))?;
        // Those about atoms and residues are said once, for all chains of the file.
        built
            .warnings
            .retain(|warning| !file.warnings.contains(warning));
        Ok(built)
    }
}
