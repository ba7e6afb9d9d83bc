//! Hydrogen bonds and salt bridges across an interface, from heavy atoms alone.
//!
//! A donor and an acceptor within 3.5 Å are a hydrogen bond if the angles at both, towards each atom that they are
//! bound to, exceed 90° (after Baker and Hubbard, Prog. Biophys. Mol. Biol. 44, 97 (1984), who use the hydrogens).
//! A salt bridge is a pair of residues of opposite charge with charged atoms within 4 Å (Barlow and Thornton, J. Mol.
//! Biol. 168, 867 (1983)).

use super::Partner;
use super::partner::{Neighbourhood, PlacedAtom};
use crate::chemistry::AminoAcid;
use crate::chemistry::residue_names::parent_amino_acid;
use protomer_kernel::Vec3;
use serde::Serialize;
use std::collections::BTreeSet;

/// Donor and acceptor of a hydrogen bond are at most this far apart, Å.
const HYDROGEN_BOND_ANGSTROM: f64 = 3.5;
/// Charged atoms of a salt bridge are at most this far apart, Å.
const SALT_BRIDGE_ANGSTROM: f64 = 4.0;
/// Heavy atoms nearer than this are bound to each other, Å; a bond of carbon and sulphur has 1.8 Å.
const BOND_ANGSTROM: f64 = 1.9;

/// Number of polar contacts across an interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct PolarContacts {
    /// Pairs of a donor and an acceptor.
    pub hydrogen_bonds: usize,
    /// Pairs of residues of opposite charge.
    pub salt_bridges: usize,
}

/// Part that an atom takes in polar contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Role {
    donates: bool,
    accepts: bool,
    /// Sign of the charge that the group of the atom may carry.
    charge: i8,
}

/// A polar atom with the directions to the atoms that it is bound to.
struct PolarAtom {
    position: Vec3,
    residue: u32,
    role: Role,
    bonds: Vec<Vec3>,
}

/// Counts the polar contacts between two bodies.
pub fn polar_contacts(partners: [Partner<'_>; 2]) -> PolarContacts {
    let [first, second] = partners.map(|partner| polar_atoms(&partner));
    let places = second.iter().map(|atom| atom.position).collect();
    let neighbourhood = Neighbourhood::new(places, SALT_BRIDGE_ANGSTROM);
    let (mut hydrogen_bonds, mut bridges, mut near) = (0, BTreeSet::new(), Vec::new());
    for atom in &first {
        neighbourhood.within(&atom.position, &mut near);
        for index in &near {
            let partner = &second[*index];
            hydrogen_bonds += usize::from(is_hydrogen_bond(atom, partner));
            if atom.role.charge * partner.role.charge < 0 {
                bridges.insert((atom.residue, partner.residue));
            }
        }
    }
    PolarContacts {
        hydrogen_bonds,
        salt_bridges: bridges.len(),
    }
}

fn is_hydrogen_bond(first: &PolarAtom, second: &PolarAtom) -> bool {
    let (a, b) = (first.role, second.role);
    let separation = second.position - first.position;
    let points_away = |atom: &PolarAtom, towards: Vec3| {
        let mut bonds = atom.bonds.iter();
        bonds.all(|bond| bond.dot(&towards) < 0.0)
    };
    ((a.donates && b.accepts) || (a.accepts && b.donates))
        && separation.norm() <= HYDROGEN_BOND_ANGSTROM
        && points_away(first, separation)
        && points_away(second, -separation)
}

fn polar_atoms(partner: &Partner<'_>) -> Vec<PolarAtom> {
    let atoms = partner.heavy_atoms();
    let places = atoms.iter().map(|atom| atom.position).collect();
    let neighbourhood = Neighbourhood::new(places, BOND_ANGSTROM);
    let mut near = Vec::new();
    let mut polar = Vec::new();
    for (index, atom) in atoms.iter().enumerate() {
        let Some((residue, role)) = role(partner, atom) else {
            continue;
        };
        neighbourhood.within(&atom.position, &mut near);
        let bound = near.iter().filter(|other| **other != index);
        polar.push(PolarAtom {
            position: atom.position,
            residue,
            role,
            bonds: bound
                .map(|other| atoms[*other].position - atom.position)
                .collect(),
        });
    }
    polar
}

/// The residue of a polar atom, and its role; `None` for other atoms.
fn role(partner: &Partner<'_>, atom: &PlacedAtom<'_>) -> Option<(u32, Role)> {
    let index = atom.site.residue?;
    let amino_acid = parent_amino_acid(&partner.body.residues[index as usize].name)?;
    let role = match &*atom.site.atom_name {
        // Proline has no hydrogen there.
        "N" => Role {
            donates: amino_acid != AminoAcid::Pro,
            ..Role::default()
        },
        "O" => ACCEPTOR,
        "OXT" => Role {
            charge: -1,
            ..ACCEPTOR
        },
        name => side_chain_role(amino_acid, name)?,
    };
    Some((index, role))
}

const ACCEPTOR: Role = Role {
    donates: false,
    accepts: true,
    charge: 0,
};
const DONOR: Role = Role {
    donates: true,
    accepts: false,
    charge: 0,
};
const BOTH: Role = Role {
    donates: true,
    accepts: true,
    charge: 0,
};

fn side_chain_role(amino_acid: AminoAcid, atom_name: &str) -> Option<Role> {
    use AminoAcid::{Arg, Asn, Asp, Gln, Glu, His, Lys, Ser, Thr, Trp, Tyr};
    Some(match (amino_acid, atom_name) {
        (Asp, "OD1" | "OD2") | (Glu, "OE1" | "OE2") => Role {
            charge: -1,
            ..ACCEPTOR
        },
        (Lys, "NZ") | (Arg, "NE" | "NH1" | "NH2") => Role { charge: 1, ..DONOR },
        (Asn, "OD1") | (Gln, "OE1") => ACCEPTOR,
        (Asn, "ND2") | (Gln, "NE2") | (Trp, "NE1") => DONOR,
        // Either nitrogen of histidine may carry the hydrogen.
        (Ser, "OG") | (Thr, "OG1") | (Tyr, "OH") | (His, "ND1" | "NE2") => BOTH,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BodySettings, Source, build_body};

    /// Counts for residues of two chains, whose atoms are (residue, name, place).
    fn counted(chains: [&[(&str, &str, [f64; 3])]; 2]) -> PolarContacts {
        let bodies = chains.map(|atoms| {
            let mut text = String::new();
            for (residue, name, [x, y, z]) in atoms {
                let element = &name[..1];
                text += &format!(
                    "ATOM      1  {name:<3} {residue} A   1    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {element:>2}\n"
                );
            }
            let source = Source { file: "part.pdb", sha256: "" };
            let settings = BodySettings::default();
            build_body("part", source, text.as_bytes(), &settings).unwrap().body
        });
        let [first, second] = &bodies;
        polar_contacts([Partner::in_file(first), Partner::in_file(second)])
    }

    #[test]
    fn a_bridge_is_a_pair_of_residues_and_its_bonds_point_outward() {
        let acid = [
            ("ASP", "CG", [-1.2, 0.0, 0.0]),
            ("ASP", "OD1", [0.0, 0.3, 0.0]),
            ("ASP", "OD2", [-1.6, -1.1, 0.0]),
        ];
        let base = |x: f64| {
            [
                ("LYS", "CE", [x + 1.4, 0.5, 0.0]),
                ("LYS", "NZ", [x, 0.3, 0.0]),
            ]
        };
        let found = counted([&acid, &base(2.8)]);
        assert_eq!((found.hydrogen_bonds, found.salt_bridges), (1, 1));
        // Too far for a bond, not for a bridge; then too far for both.
        let found = counted([&acid, &base(3.8)]);
        assert_eq!((found.hydrogen_bonds, found.salt_bridges), (0, 1));
        assert_eq!(counted([&acid, &base(4.2)]), PolarContacts::default());
        // The amine turns its back: NZ is behind CE as seen from the acid.
        let turned = [
            ("LYS", "CE", [2.2, 1.2, 0.0]),
            ("LYS", "NZ", [2.8, 0.0, 0.0]),
        ];
        let found = counted([&acid, &turned]);
        assert_eq!((found.hydrogen_bonds, found.salt_bridges), (0, 1));
    }

    #[test]
    fn like_groups_make_no_contact() {
        let lysine = |x: f64, side: f64| {
            [
                ("LYS", "CE", [x + side * 1.4, 0.0, 0.0]),
                ("LYS", "NZ", [x, 0.0, 0.0]),
            ]
        };
        let found = counted([&lysine(0.0, -1.0), &lysine(2.9, 1.0)]);
        assert_eq!(found, PolarContacts::default());
    }
}
