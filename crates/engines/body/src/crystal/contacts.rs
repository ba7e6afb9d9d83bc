//! Chains of a crystal and the symmetry copies that touch them.

use super::closure::{Backbone, is_closed};
use super::space_group::{SymmetryOperation, operations};
use crate::structure::{BiologicalAssembly, Header, SelectedResidue, Selection, UnitCell};
use crate::{BodyError, Result};
use nalgebra::{Matrix3, Rotation3, Vector3};
use protomer_kernel::cells::CellList;
use protomer_kernel::{Boundary, Pose, Rotation, Vec3};
use std::collections::BTreeSet;

/// Chains with fewer residues are no partners: ends of peptides that a crystal soaked in.
const FEWEST_RESIDUES: usize = 10;
/// Heavy atoms nearer than this are a contact of their residues, Å.
const CONTACT_ANGSTROM: f64 = 4.5;
/// Pairs of residues that make a contact; fewer are a graze.
const FEWEST_CONTACTS: usize = 4;
/// Two motions that put each atom within this of the same place are the same, Å.
const SAME_ANGSTROM: f64 = 1.0;

/// A chain and a copy of a chain that touches it.
#[derive(Debug, Clone, PartialEq)]
pub struct CrystalContact {
    /// Names of the two chains; those of a chain and its own copy are equal.
    pub chains: [String; 2],
    /// Motion of the second chain.
    pub pose: Pose,
    /// Symmetry operation of the second chain, such as `-x,y+1/2,-z`.
    pub symmetry: String,
    /// Pairs of residues in contact.
    pub residue_contacts: usize,
    /// Whether two equal chains make a ring by this motion instead of an endless row; `None` for different chains.
    pub is_closed: Option<bool>,
    /// Whether both are in one biological assembly of the file; `None` if the file describes none.
    pub in_assembly: Option<bool>,
}

/// A chain with what the search needs.
struct Unit<'a> {
    name: &'a str,
    label: &'a str,
    /// Heavy atoms with the number of their residue.
    atoms: Vec<(Vec3, usize)>,
    backbone: Backbone,
    centre: Vec3,
    radius_angstrom: f64,
}

/// Matrices between fractional and Cartesian coordinates, with a along x and b in the plane of x and y.
struct CellAxes {
    to_cartesian: Matrix3<f64>,
    to_fractional: Matrix3<f64>,
}

/// Different contacts between the protein chains of a crystal and their symmetry copies.
///
/// # Errors
/// [`BodyError::Invalid`] for a file without a cell, or with a space group that has mirrors or an unknown symbol.
pub fn crystal_contacts(
    header: &Header,
    assemblies: &[BiologicalAssembly],
    selection: &Selection,
) -> Result<Vec<CrystalContact>> {
    let (cell, symbol) = match (&header.cell, &header.space_group) {
        (Some(cell), Some(symbol)) => (cell, symbol),
        _ => {
            return Err(BodyError::Invalid {
                cause: "the file states no unit cell or no space group".into(),
                remedy: "give the deposited entry of a crystal structure".into(),
            });
        }
    };
    let group = operations(symbol, cell.angles_degree[2]).ok_or_else(|| BodyError::Invalid {
        cause: format!("'{symbol}' is no space group of chiral molecules"),
        remedy: "correct the symbol in the file".into(),
    })?;
    let axes = CellAxes::new(cell)?;
    let units = units(&selection.residues);
    let mut contacts = Vec::new();
    for (i, first) in units.iter().enumerate() {
        let cells = Neighbours::new(first);
        for second in &units[i..] {
            let is_same = std::ptr::eq(first, second);
            let mut motions: Vec<Pose> = Vec::new();
            for operation in &group {
                for (pose, shift) in axes.copies_near(operation, second, first) {
                    // A copy by g and one by its inverse make the same contact of a chain with itself.
                    let is_known = |earlier: &Pose| {
                        is_same && puts_alike(&second.atoms, earlier, &pose.inverse())
                    };
                    if is_same && puts_alike(&second.atoms, &pose, &Pose::identity())
                        || motions.iter().any(is_known)
                    {
                        continue;
                    }
                    let residue_contacts = cells.residue_contacts(second, &pose);
                    if residue_contacts >= FEWEST_CONTACTS {
                        motions.push(pose);
                        contacts.push(CrystalContact {
                            chains: [first.name.to_owned(), second.name.to_owned()],
                            pose,
                            symmetry: operation.in_words(shift),
                            residue_contacts,
                            is_closed: is_closed(&first.backbone, &second.backbone, &pose),
                            in_assembly: in_assembly(assemblies, first, second, &pose)?,
                        });
                    }
                }
            }
        }
    }
    Ok(contacts)
}

/// Protein chains in the order of the file.
fn units(residues: &[SelectedResidue]) -> Vec<Unit<'_>> {
    let mut units: Vec<Unit<'_>> = Vec::new();
    let mut counts: Vec<usize> = Vec::new();
    for (number, residue) in residues.iter().enumerate() {
        if !residue.class.is_protein() {
            continue;
        }
        let name = &*residue.key.chain;
        let place = units.iter().position(|unit| unit.name == name);
        let place = place.unwrap_or_else(|| {
            units.push(Unit {
                name,
                label: residue.atoms.first().map_or("", |atom| &*atom.label_chain),
                atoms: Vec::new(),
                backbone: Backbone::new(),
                centre: Vec3::zeros(),
                radius_angstrom: 0.0,
            });
            counts.push(0);
            units.len() - 1
        });
        counts[place] += 1;
        if let Some(atom) = residue.atom("CA") {
            let key = (residue.key.number, residue.name.to_string());
            units[place].backbone.insert(key, atom.position);
        }
        let heavy = residue.atoms.iter().filter(|atom| !atom.is_hydrogen());
        units[place]
            .atoms
            .extend(heavy.map(|atom| (atom.position, number)));
    }
    let mut counts = counts.into_iter();
    units.retain(|unit| counts.next().unwrap_or(0) >= FEWEST_RESIDUES && !unit.atoms.is_empty());
    for unit in &mut units {
        let sum: Vec3 = unit.atoms.iter().map(|(position, _)| position).sum();
        unit.centre = sum / unit.atoms.len() as f64;
        let distances = unit
            .atoms
            .iter()
            .map(|(position, _)| (position - unit.centre).norm());
        unit.radius_angstrom = distances.fold(0.0, f64::max);
    }
    units
}

impl CellAxes {
    fn new(cell: &UnitCell) -> Result<Self> {
        let [a, b, c] = cell.lengths_angstrom;
        let [alpha, beta, gamma] = cell.angles_degree.map(f64::to_radians);
        let y = (alpha.cos() - beta.cos() * gamma.cos()) / gamma.sin();
        let z = (1.0 - beta.cos().powi(2) - y * y).sqrt();
        let to_cartesian = Matrix3::new(
            a,
            b * gamma.cos(),
            c * beta.cos(),
            0.0,
            b * gamma.sin(),
            c * y,
            0.0,
            0.0,
            c * z,
        );
        match to_cartesian.try_inverse() {
            Some(to_fractional) if z.is_finite() => Ok(Self {
                to_cartesian,
                to_fractional,
            }),
            _ => Err(BodyError::Invalid {
                cause: format!("no cell has the angles {:?}°", cell.angles_degree),
                remedy: "correct the cell in the file".into(),
            }),
        }
    }

    /// Copies of `moved` by an operation and whole cells whose sphere reaches that of `fixed`.
    fn copies_near(
        &self,
        operation: &SymmetryOperation,
        moved: &Unit<'_>,
        fixed: &Unit<'_>,
    ) -> Vec<(Pose, [i32; 3])> {
        let rotation = self.to_cartesian * operation.rotation() * self.to_fractional;
        let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        let reach = moved.radius_angstrom + fixed.radius_angstrom + CONTACT_ANGSTROM;
        let start = rotation * moved.centre + self.to_cartesian * operation.shift();
        let apart: Vector3<f64> = self.to_fractional * (fixed.centre - start);
        // A plane of the cell is 1 / |row| away from the next, so this many cells may reach.
        let span: Vec<(i32, i32)> = (0..3)
            .map(|axis| {
                let cells = reach * self.to_fractional.row(axis).norm();
                let (low, high) = (apart[axis] - cells, apart[axis] + cells);
                (low.ceil() as i32, high.floor() as i32)
            })
            .collect();
        let mut copies = Vec::new();
        for x in span[0].0..=span[0].1 {
            for y in span[1].0..=span[1].1 {
                for z in span[2].0..=span[2].1 {
                    let shift = Vector3::new(x, y, z).map(f64::from);
                    let position = self.to_cartesian * (operation.shift() + shift);
                    let pose = Pose { position, rotation };
                    if (pose.transform_point(&moved.centre) - fixed.centre).norm() <= reach {
                        copies.push((pose, [x, y, z]));
                    }
                }
            }
        }
        copies
    }
}

/// The atoms of a chain, sorted by place.
struct Neighbours<'a> {
    unit: &'a Unit<'a>,
    cells: CellList,
}

impl<'a> Neighbours<'a> {
    fn new(unit: &'a Unit<'a>) -> Self {
        let positions: Vec<Vec3> = unit.atoms.iter().map(|(position, _)| *position).collect();
        Self {
            unit,
            cells: CellList::new(&Boundary::Open, CONTACT_ANGSTROM, &positions),
        }
    }

    /// Pairs of residues in contact with a chain in a pose.
    fn residue_contacts(&self, other: &Unit<'_>, pose: &Pose) -> usize {
        let reach = self.unit.radius_angstrom + CONTACT_ANGSTROM;
        let (mut pairs, mut candidates) = (BTreeSet::new(), Vec::new());
        for (position, residue) in &other.atoms {
            let place = pose.transform_point(position);
            if (place - self.unit.centre).norm() > reach {
                continue;
            }
            self.cells.candidates(&place, &mut candidates);
            for index in &candidates {
                let (own, own_residue) = &self.unit.atoms[*index];
                if (own - place).norm_squared() < CONTACT_ANGSTROM.powi(2) {
                    pairs.insert((*own_residue, *residue));
                }
            }
        }
        pairs.len()
    }
}

/// Whether two motions put the atoms of a chain at the same places.
fn puts_alike(atoms: &[(Vec3, usize)], first: &Pose, second: &Pose) -> bool {
    // Four atoms far from each other in the sequence fix a motion.
    let step = (atoms.len() / 4).max(1);
    atoms.iter().step_by(step).all(|(position, _)| {
        let apart = first.transform_point(position) - second.transform_point(position);
        apart.norm() < SAME_ANGSTROM
    })
}

/// Whether a biological assembly holds a chain and a copy of another one in this pose.
fn in_assembly(
    assemblies: &[BiologicalAssembly],
    first: &Unit<'_>,
    second: &Unit<'_>,
    pose: &Pose,
) -> Result<Option<bool>> {
    if assemblies.is_empty() {
        return Ok(None);
    }
    for assembly in assemblies {
        let poses = |unit: &Unit<'_>| -> Result<Vec<Pose>> {
            let mut poses = Vec::new();
            for part in &assembly.parts {
                let has = |label: &str| part.chains.iter().any(|chain| &**chain == label);
                if part.chains.is_empty() || has(unit.label) || has(unit.name) {
                    for operator in &part.operators {
                        poses.push(operator.pose()?);
                    }
                }
            }
            Ok(poses)
        };
        let (of_first, of_second) = (poses(first)?, poses(second)?);
        for outer in &of_first {
            let back = outer.inverse();
            for inner in &of_second {
                if puts_alike(&second.atoms, &inner.then(&back), pose) {
                    return Ok(Some(true));
                }
            }
        }
    }
    Ok(Some(false))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{SelectionSettings, Structure};

    /// A column of residues along z, in a cell of 20 Å by 20 Å by 60 Å.
    fn crystal(space_group: &str, x: f64) -> Vec<CrystalContact> {
        let mut text =
            format!("CRYST1   20.000   20.000   60.000  90.00  90.00  90.00 {space_group:<11}\n");
        for number in 1..=12 {
            let z = 3.8 * f64::from(number);
            text += &format!(
                "ATOM  {number:>5}  CA  GLY A{number:>4}    {x:>8.3}{:>8.3}{z:>8.3}  1.00  0.00           C\n",
                1.0
            );
        }
        let structure = Structure::read("column.pdb", text.as_bytes()).unwrap();
        let selection = structure.select(&SelectionSettings::default()).unwrap();
        crystal_contacts(&structure.header, &structure.assemblies, &selection).unwrap()
    }

    #[test]
    fn a_column_touches_the_copy_by_its_screw_axis_once() {
        // The axis of P 1 1 2 along z is 1.4 Å away; the lattice is far.
        let found = crystal("P 1 1 2", 1.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].symmetry, "-x,-y,z");
        assert_eq!(found[0].in_assembly, None);
        assert!(crystal("P 1", 1.0).is_empty());
        assert!(crystal("P 1 1 2", 5.0).is_empty());
        let beyond = crystal("P 1 1 2", 9.0);
        assert_eq!(beyond[0].symmetry, "-x+1,-y,z");
    }

    #[test]
    fn contacts_are_those_of_all_copies_tried_one_by_one() {
        let text = std::fs::read("../../../data/structures/5pti.cif.gz").unwrap();
        let mut plain = Vec::new();
        std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&text[..]), &mut plain)
            .unwrap();
        let structure = Structure::read("5pti.cif", &plain).unwrap();
        let selection = structure.select(&SelectionSettings::default()).unwrap();
        let found = crystal_contacts(&structure.header, &structure.assemblies, &selection).unwrap();
        assert!(!found.is_empty());
        let cell = structure.header.cell.unwrap();
        let axes = CellAxes::new(&cell).unwrap();
        let unit = &units(&selection.residues)[0];
        let cells = Neighbours::new(unit);
        let mut touching = 0;
        for operation in operations("P 21 21 21", 90.0).unwrap() {
            for x in -3..=3 {
                for y in -3..=3 {
                    for z in -3..=3 {
                        let shift = Vector3::new(x, y, z).map(f64::from);
                        let rotation =
                            axes.to_cartesian * operation.rotation() * axes.to_fractional;
                        let rotation = Rotation3::from_matrix_unchecked(rotation);
                        let pose = Pose {
                            position: axes.to_cartesian * (operation.shift() + shift),
                            rotation: Rotation::from_rotation_matrix(&rotation),
                        };
                        let is_itself = puts_alike(&unit.atoms, &pose, &Pose::identity());
                        if !is_itself && cells.residue_contacts(unit, &pose) >= FEWEST_CONTACTS {
                            touching += 1;
                        }
                    }
                }
            }
        }
        // Each contact of a chain with its own copies is met from both sides.
        assert_eq!(touching, 2 * found.len());
    }
}
