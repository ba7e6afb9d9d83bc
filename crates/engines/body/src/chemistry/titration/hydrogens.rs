//! Places of the hydrogens on polar atoms whose geometry the heavy atoms decide.
//!
//! A hydrogen sits 1.01 Å from its nitrogen in the plane of the bonds: opposite the bisector of two
//! bonds (backbone amides, the indole of tryptophan, Nε of arginine), or at 120° from the one bond of
//! a terminal amide or guanidinium nitrogen. A hydroxyl turns to where its hydrogen has the lowest
//! Coulomb energy among the charges around it (`hydroxyl_hydrogen`). Thiols and amines keep their
//! hydrogens on the heavy atom, as do histidine and the carboxylates.

use crate::structure::SelectedResidue;
use protomer_kernel::Vec3;

/// Length of a bond between nitrogen and hydrogen, Å.
const BOND_ANGSTROM: f64 = 1.01;
/// Longest bond between two residues, Å.
const LONGEST_PEPTIDE_BOND_ANGSTROM: f64 = 2.0;

/// A hydrogen by the index of its heavy atom in the residue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hydrogen {
    /// Index of the heavy atom in the residue.
    pub parent: usize,
    /// Position, Å.
    pub position: Vec3,
}

/// Hydrogens of a residue on polar atoms; `previous` is the residue before it in the file.
///
/// ```
/// use protomer_body::chemistry::titration::hydrogens::polar_hydrogens;
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  CA  ALA A   1      -2.430   0.000   0.000  1.00  0.00           C
/// ATOM      2  C   ALA A   1      -1.150   0.670   0.000  1.00  0.00           C
/// ATOM      3  N   ALA A   2       0.000   0.000   0.000  1.00  0.00           N
/// ATOM      4  CA  ALA A   2       1.260   0.740   0.000  1.00  0.00           C";
/// let structure = Structure::read("peptide.pdb", text.as_bytes())?;
/// let selection = structure.select(&SelectionSettings::default())?;
/// let [first, second] = &selection.residues[..] else { panic!() };
/// let hydrogens = polar_hydrogens(second, Some(first));
/// assert_eq!(hydrogens.len(), 1);
/// assert!(hydrogens[0].position.y < -1.0); // opposite the two bonds
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn polar_hydrogens(
    residue: &SelectedResidue,
    previous: Option<&SelectedResidue>,
) -> Vec<Hydrogen> {
    let mut hydrogens = Vec::new();
    let Some(amino_acid) = residue.class.amino_acid() else {
        return hydrogens;
    };
    if let Some(carbon) = previous.and_then(|residue| position(residue, "C"))
        && amino_acid != super::super::AminoAcid::Pro
        && !residue.n_terminus
    {
        push_between(&mut hydrogens, residue, "N", carbon, "CA");
    }
    use super::super::AminoAcid::{Arg, Asn, Gln, Trp};
    match amino_acid {
        Asn => push_pair(&mut hydrogens, residue, ["ND2", "CG", "OD1"]),
        Gln => push_pair(&mut hydrogens, residue, ["NE2", "CD", "OE1"]),
        Arg => {
            push_pair(&mut hydrogens, residue, ["NH1", "CZ", "NE"]);
            push_pair(&mut hydrogens, residue, ["NH2", "CZ", "NE"]);
            if let Some(carbon) = position(residue, "CD") {
                push_between(&mut hydrogens, residue, "NE", carbon, "CZ");
            }
        }
        Trp => {
            if let Some(carbon) = position(residue, "CD1") {
                push_between(&mut hydrogens, residue, "NE1", carbon, "CE2");
            }
        }
        _ => {}
    }
    hydrogens
}

fn position(residue: &SelectedResidue, name: &str) -> Option<Vec3> {
    residue.atom(name).map(|atom| atom.position)
}

fn index(residue: &SelectedResidue, name: &str) -> Option<usize> {
    residue.atoms.iter().position(|atom| &*atom.name == name)
}

/// Adds the hydrogen opposite the bisector of two bonds.
fn push_between(
    hydrogens: &mut Vec<Hydrogen>,
    residue: &SelectedResidue,
    parent: &str,
    first: Vec3,
    second: &str,
) {
    let (Some(parent), Some(second)) = (index(residue, parent), position(residue, second)) else {
        return;
    };
    let centre = residue.atoms[parent].position;
    if (first - centre).norm() > LONGEST_PEPTIDE_BOND_ANGSTROM {
        return;
    }
    let bonds = [first - centre, second - centre].map(|bond| bond.try_normalize(1e-6));
    let [Some(first), Some(second)] = bonds else {
        return;
    };
    if let Some(outward) = (-first - second).try_normalize(1e-6) {
        hydrogens.push(Hydrogen {
            parent,
            position: centre + BOND_ANGSTROM * outward,
        });
    }
}

/// Adds the two hydrogens of a flat NH2 group: `[nitrogen, carbon, third]`, in whose plane they are.
fn push_pair(hydrogens: &mut Vec<Hydrogen>, residue: &SelectedResidue, names: [&str; 3]) {
    let [Some(parent), Some(carbon), Some(third)] = names.map(|name| index(residue, name)) else {
        return;
    };
    let [centre, carbon, third] = [parent, carbon, third].map(|atom| residue.atoms[atom].position);
    let Some(along) = (centre - carbon).try_normalize(1e-6) else {
        return;
    };
    let sideways = third - carbon;
    let Some(sideways) = (sideways - sideways.dot(&along) * along).try_normalize(1e-6) else {
        return;
    };
    let (half, height) = (0.5 * BOND_ANGSTROM, 0.75_f64.sqrt() * BOND_ANGSTROM);
    for sign in [1.0, -1.0] {
        hydrogens.push(Hydrogen {
            parent,
            position: centre + half * along + sign * height * sideways,
        });
    }
}

/// Length of the bond between oxygen and hydrogen, Å.
const HYDROXYL_ANGSTROM: f64 = 0.96;
/// Angle between the bonds of a hydroxyl oxygen, degrees.
const HYDROXYL_DEGREES: f64 = 109.0;
/// Number of torsions that a hydroxyl tries.
const TORSIONS: usize = 36;
/// Distance that a hydroxyl hydrogen keeps from other atoms, Å.
const LEAST_HYDROGEN_DISTANCE_ANGSTROM: f64 = 1.7;
/// Distance up to which charges turn a hydroxyl, Å.
const HYDROXYL_REACH_ANGSTROM: f64 = 6.0;

/// Oxygen and carbon of the hydroxyl of a residue, by index.
pub(super) fn hydroxyl(residue: &SelectedResidue) -> Option<[usize; 2]> {
    use super::super::AminoAcid::{Ser, Thr, Tyr};
    let names = match residue.class.amino_acid()? {
        Ser => ["OG", "CB"],
        Thr => ["OG1", "CB"],
        Tyr => ["OH", "CZ"],
        _ => return None,
    };
    let [Some(oxygen), Some(carbon)] = names.map(|name| index(residue, name)) else {
        return None;
    };
    Some([oxygen, carbon])
}

/// Position of the hydrogen of a hydroxyl, Å: of 36 torsions that of lowest Coulomb energy with
/// these charges (place, e), without those within 1.6 Å of the oxygen.
pub(super) fn hydroxyl_hydrogen(
    oxygen: Vec3,
    carbon: Vec3,
    charges: &[(Vec3, f64)],
) -> Option<Vec3> {
    let along = (oxygen - carbon).try_normalize(1e-6)?;
    let sideways = along.cross(&least_axis(&along)).try_normalize(1e-6)?;
    let upward = along.cross(&sideways);
    let bend = HYDROXYL_DEGREES.to_radians();
    let mut near = Vec::new();
    for (place, charge_e) in charges {
        let distance = (place - oxygen).norm();
        if distance > 1.6 && distance < HYDROXYL_REACH_ANGSTROM {
            near.push((*place, *charge_e));
        }
    }
    let mut best = (f64::INFINITY, None);
    for step in 0..TORSIONS {
        let torsion = std::f64::consts::TAU * step as f64 / TORSIONS as f64;
        let outward = torsion.cos() * sideways + torsion.sin() * upward;
        let bond = -bend.cos() * along + bend.sin() * outward;
        let place = oxygen + HYDROXYL_ANGSTROM * bond;
        let mut energy = 0.0;
        for (other, charge_e) in &near {
            let distance = (place - other).norm();
            energy += charge_e / distance.max(LEAST_HYDROGEN_DISTANCE_ANGSTROM);
            // A hydrogen inside another atom costs more than any charge gains.
            energy += 10.0 * (LEAST_HYDROGEN_DISTANCE_ANGSTROM - distance).max(0.0);
        }
        // A margin, so that rounding does not choose between torsions of equal energy.
        if energy < best.0 - 1e-9 {
            best = (energy, Some(place));
        }
    }
    best.1
}

/// The coordinate axis along which a vector is shortest.
fn least_axis(vector: &Vec3) -> Vec3 {
    let axis = vector.abs().imin();
    let mut unit = Vec3::zeros();
    unit[axis] = 1.0;
    unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hydroxyl_points_to_an_acceptor_and_away_from_a_donor() {
        let (oxygen, carbon) = (Vec3::zeros(), Vec3::new(-1.4, 0.0, 0.0));
        let acceptor = Vec3::new(1.0, 2.5, 0.0);
        let turned = |charge_e| hydroxyl_hydrogen(oxygen, carbon, &[(acceptor, charge_e)]).unwrap();
        let [to, away] = [-0.8, 0.8].map(turned);
        assert!((to - acceptor).norm() < 1.8 && (away - acceptor).norm() > 3.0);
        for hydrogen in [to, away] {
            assert!((hydrogen.norm() - HYDROXYL_ANGSTROM).abs() < 1e-12);
            let cosine = hydrogen.dot(&carbon) / (hydrogen.norm() * carbon.norm());
            assert!((cosine - HYDROXYL_DEGREES.to_radians().cos()).abs() < 1e-12);
        }
    }
}
