//! The element of an atom of a body.
//!
//! A body keeps names and radii of its atoms, not their elements. The rule:
//!
//! 1. In a polymer and in water the first letter of the name is the element (CA is carbon, HG
//!    hydrogen, ND1 nitrogen), except for a selenium, which is named SE. Where the letter is no
//!    element, the first two are (AS of an arsenic).
//! 2. An ion is of its element, whatever the program that named it: SOD is sodium. In another residue of
//!    one atom whose name holds the letters of the atom, they are the element.
//! 3. Elsewhere the radius decides between the first letter and the first two: radii were given by
//!    the elements of the source ([`crate::chemistry::radii`]), so CL with 1.75 Å is chlorine, and NA
//!    of a haem with 1.55 Å is nitrogen. If both elements have the same radius or neither has it, the
//!    first letter counts (PA of ATP is phosphorus).
//!
//! A name in which nothing is an element gives `X`, the symbol of an unknown one.

use super::super::element::{from_name, parse_symbol};
use crate::chemistry::ions::ion;
use crate::chemistry::radii::radius_angstrom;

const UNKNOWN: &str = "X";

/// Properties of an atom from which its element follows.
#[derive(Debug, Clone, Copy)]
pub(super) struct NamedAtom<'a> {
    pub(super) name: &'a str,
    pub(super) residue_name: &'a str,
    pub(super) radius_angstrom: f64,
    /// Whether its residue is part of a polymer, or water.
    pub(super) is_common: bool,
    /// Whether it is the only atom of its residue.
    pub(super) is_alone: bool,
}

/// The symbol of the element in upper case.
pub(super) fn symbol(atom: &NamedAtom) -> &'static str {
    let letters = leading_letters(atom.name);
    let two = letters.get(..2).and_then(parse_symbol);
    let one = match from_name(atom.name) {
        UNKNOWN => None,
        element => Some(element),
    };
    if atom.is_common {
        return match (one, two) {
            (_, Some("SE")) if letters == "SE" => "SE",
            (Some(one), _) => one,
            (None, two) => two.unwrap_or(UNKNOWN),
        };
    }
    if let Some(ion) = ion(atom.residue_name)
        && atom.is_alone
    {
        return ion.element;
    }
    let whole = parse_symbol(letters);
    if let Some(whole) = whole
        && atom.is_alone
        && atom.residue_name.contains(letters)
    {
        return whole;
    }
    match (one, two) {
        (Some(one), Some(two)) => match has_radius(atom, two) && !has_radius(atom, one) {
            true => two,
            false => one,
        },
        (one, two) => one.or(two).unwrap_or(UNKNOWN),
    }
}

/// The letters at the start of a name, after digits.
fn leading_letters(name: &str) -> &str {
    let name = name.trim_start_matches(|c: char| c.is_ascii_digit());
    let end = name.find(|c: char| !c.is_ascii_alphabetic());
    &name[..end.unwrap_or(name.len())]
}

fn has_radius(atom: &NamedAtom, element: &str) -> bool {
    const ROUNDING_ANGSTROM: f64 = 1e-6;
    (atom.radius_angstrom - radius_angstrom(element)).abs() < ROUNDING_ANGSTROM
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The symbol of an atom with the radius of its true element.
    fn derived(
        name: &str,
        residue_name: &str,
        truth: &str,
        is_common: bool,
        is_alone: bool,
    ) -> String {
        symbol(&NamedAtom {
            name,
            residue_name,
            radius_angstrom: radius_angstrom(truth),
            is_common,
            is_alone,
        })
        .to_owned()
    }

    #[test]
    fn polymers_go_by_the_first_letter() {
        for (name, residue, element) in [
            ("CA", "ALA", "C"),
            ("CD1", "LEU", "C"),
            ("HG", "SER", "H"),
            ("1HB", "ALA", "H"),
            ("NE2", "HIS", "N"),
            ("OXT", "GLY", "O"),
            ("SG", "CYS", "S"),
            ("SE", "MSE", "SE"),
            ("AS", "CAS", "AS"),
            ("P", "DA", "P"),
            ("O5'", "DA", "O"),
            ("CO", "NH2", "C"),
            ("*", "ALA", "X"),
        ] {
            assert_eq!(
                derived(name, residue, element, true, false),
                element,
                "{name}"
            );
        }
    }

    #[test]
    fn ions_go_by_their_residue_and_ligands_by_their_radii() {
        for (name, residue, element) in [
            ("CA", "CA", "CA"),
            ("NA", "NA", "NA"),
            ("CL", "CL", "CL"),
            ("FE", "FE2", "FE"),
            ("HG", "HG", "HG"),
            ("K", "K", "K"),
            ("I", "IOD", "I"),
            ("MN", "MN3", "MN"),
            ("ZN", "ZN", "ZN"),
        ] {
            assert_eq!(
                derived(name, residue, element, false, true),
                element,
                "{name}"
            );
        }
        for (name, residue, element) in [
            ("FE", "HEM", "FE"),
            ("NA", "HEM", "N"),
            ("CHA", "HEM", "C"),
            ("CL1", "CLM", "CL"),
            ("BR", "BRO", "BR"),
            ("CA1", "LIG", "C"),
            ("CO", "B12", "CO"),
            ("PA", "ATP", "P"),
            ("SE1", "LIG", "SE"),
            ("HG", "MMC", "HG"),
            ("HG1", "LIG", "H"),
            ("CD", "LIG", "C"),
            ("CD", "LIG", "CD"),
            ("O5'", "ATP", "O"),
        ] {
            assert_eq!(
                derived(name, residue, element, false, false),
                element,
                "{name}"
            );
        }
    }
}
