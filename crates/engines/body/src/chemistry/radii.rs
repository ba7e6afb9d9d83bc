//! Radii of heavy atoms for the surface and for the hard core.

use super::AminoAcid;

/// Radius of an element, Å: C 1.70, N 1.55, O 1.52, S 1.80 (Bondi, J. Phys. Chem. 68, 441 (1964)),
/// any other 1.80 except the following: H 1.10 (Rowland and Taylor, J. Phys. Chem. 100, 7384
/// (1996)), P 1.80, Se 1.90, halogens and metals of common ions after Bondi and Mantina et al. (J.
/// Phys. Chem. A 113, 5806 (2009)).
///
/// ```
/// assert_eq!(protomer_body::chemistry::radii::radius_angstrom("N"), 1.55);
/// ```
pub fn radius_angstrom(element: &str) -> f64 {
    match element {
        "H" | "D" => 1.10,
        "C" => 1.70,
        "N" => 1.55,
        "O" => 1.52,
        "F" => 1.47,
        "NA" => 2.27,
        "MG" => 1.73,
        "P" | "S" => 1.80,
        "CL" => 1.75,
        "K" => 2.75,
        "CA" => 2.31,
        "NI" => 1.63,
        "CU" => 1.40,
        "ZN" => 1.39,
        "SE" => 1.90,
        "BR" => 1.83,
        "CD" => 1.58,
        "I" => 1.98,
        _ => 1.80,
    }
}

/// Radius of a heavy atom of an amino acid together with its hydrogens, Å (Chothia, J. Mol. Biol. 105, 1 (1976));
/// `None` for atoms that amino acids do not have.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::radii::united_atom_radius_angstrom;
/// assert_eq!(united_atom_radius_angstrom(AminoAcid::Lys, "NZ"), Some(1.50));
/// assert_eq!(united_atom_radius_angstrom(AminoAcid::Phe, "CG"), Some(1.76));
/// assert_eq!(united_atom_radius_angstrom(AminoAcid::Leu, "CG"), Some(1.87));
/// ```
pub fn united_atom_radius_angstrom(amino_acid: AminoAcid, atom_name: &str) -> Option<f64> {
    use AminoAcid::{Arg, Asn, Asp, Gln, Glu, His, Lys, Phe, Trp, Tyr};
    let is_trigonal = match (amino_acid, atom_name) {
        (_, "C") | (Asp | Asn, "CG") | (Glu | Gln, "CD") | (Arg, "CZ") => true,
        (Phe | Tyr | Trp | His, name) => !matches!(name, "CA" | "CB"),
        _ => false,
    };
    Some(match (atom_name.chars().next()?, is_trigonal) {
        ('N', _) if amino_acid == Lys && atom_name == "NZ" => 1.50,
        ('N', _) => 1.65,
        ('O', _) => 1.40,
        ('S', _) => 1.85,
        ('C', true) => 1.76,
        ('C', false) => 1.87,
        _ => return None,
    })
}

/// Radius of N and O in a native core before it is moved inward, Å: half of the shortest hydrogen
/// bonds, which are 2.4 Å long.
const POLAR_CORE_ANGSTROM: f64 = 1.2;

/// Radius of an element for the native core, Å, before the core is moved inward: 1.2 for N and O,
/// which form hydrogen bonds and salt bridges; the ionic radius plus 0.5 for ions of metals
/// (coordination number six; Shannon, Acta Cryst. A32, 751 (1976)), which other atoms coordinate;
/// that of [`radius_angstrom`] for all others.
///
/// ```
/// use protomer_body::chemistry::radii::core_radius_angstrom;
/// assert_eq!(["O", "C", "ZN"].map(core_radius_angstrom), [1.2, 1.7, 1.24]);
/// ```
pub fn core_radius_angstrom(element: &str) -> f64 {
    match element {
        "N" | "O" => POLAR_CORE_ANGSTROM,
        "NA" => 1.52,
        "MG" => 1.22,
        "K" => 1.88,
        "CA" => 1.50,
        "NI" => 1.19,
        "CU" => 1.23,
        "ZN" => 1.24,
        "CD" => 1.45,
        _ => radius_angstrom(element),
    }
}
