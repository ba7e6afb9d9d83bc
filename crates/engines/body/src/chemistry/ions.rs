//! Ions by their residue names: the wwPDB's, and those of other programs.

/// A monatomic ion.
///
/// ```
/// use protomer_body::chemistry::ions::ion;
/// let magnesium = ion("MG");
/// assert_eq!(magnesium.map(|ion| (ion.element, ion.charge_e)), Some(("MG", 2)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ion {
    /// Residue name in the wwPDB chemical component dictionary.
    pub name: &'static str,
    /// Charge, e.
    pub charge_e: i32,
    /// Element symbol in upper case.
    pub element: &'static str,
    /// Names that other programs use: CHARMM (`SOD`), AMBER (`Na+`), GROMOS (`NA+`), Schrödinger.
    aliases: &'static [&'static str],
}

const fn entry(
    name: &'static str,
    charge_e: i32,
    element: &'static str,
    aliases: &'static [&'static str],
) -> Ion {
    Ion {
        name,
        charge_e,
        element,
        aliases,
    }
}

const IONS: &[Ion] = &[
    entry("LI", 1, "LI", &["LIT", "LI+"]),
    entry("NA", 1, "NA", &["SOD", "NA+", "NAI", "NIO"]),
    entry("K", 1, "K", &["POT", "K+"]),
    entry("RB", 1, "RB", &["RUB", "RB+"]),
    entry("CS", 1, "CS", &["CES", "CS+"]),
    entry("AG", 1, "AG", &["AG+"]),
    entry("CU1", 1, "CU", &["CU+"]),
    entry("MG", 2, "MG", &["MG2", "MG2+", "MG+2"]),
    entry("CA", 2, "CA", &["CAL", "CA2", "CA2+", "CA+2", "C0"]),
    entry("SR", 2, "SR", &["SR2", "SR2+"]),
    entry("BA", 2, "BA", &["BAR", "BA2+"]),
    entry("MN", 2, "MN", &["MN2", "MN2+"]),
    entry("FE2", 2, "FE", &["FE2+"]),
    entry("CO", 2, "CO", &["CO2+"]),
    entry("NI", 2, "NI", &["NI2+"]),
    entry("CU", 2, "CU", &["CU2", "CU2+"]),
    entry("ZN", 2, "ZN", &["ZN2", "ZN2+", "ZN+2"]),
    entry("CD", 2, "CD", &["CD2", "CD2+", "CAD"]),
    entry("HG", 2, "HG", &["HG2", "HG2+"]),
    entry("PB", 2, "PB", &["PB2+"]),
    entry("FE", 3, "FE", &["FE3", "FE3+"]),
    entry("MN3", 3, "MN", &[]),
    entry("AL", 3, "AL", &["AL3", "AL3+"]),
    entry("F", -1, "F", &["FLU", "F-"]),
    entry("CL", -1, "CL", &["CLA", "CL-", "CHL", "CIO"]),
    entry("BR", -1, "BR", &["BRO", "BR-"]),
    entry("IOD", -1, "I", &["I-"]),
];

/// Charges of ions of several atoms, e (wwPDB chemical component dictionary).
const MOLECULAR_IONS: &[(&str, i32)] = &[("SO4", -2), ("PO4", -3), ("NH4", 1)];

/// The monatomic ion of a residue name, in the words of the wwPDB or of another program.
///
/// ```
/// use protomer_body::chemistry::ions::ion;
/// assert_eq!(ion("SOD").map(|ion| ion.name), Some("NA"));
/// assert_eq!(ion("Cl-").map(|ion| ion.charge_e), Some(-1));
/// ```
pub fn ion(name: &str) -> Option<&'static Ion> {
    let is_name = |candidate: &str| candidate.eq_ignore_ascii_case(name);
    IONS.iter()
        .find(|ion| is_name(ion.name) || ion.aliases.iter().any(|alias| is_name(alias)))
}

/// The charge of an ion by its residue name and its number of atoms other than hydrogen, e.
///
/// ```
/// use protomer_body::chemistry::ions::ion_charge_e;
/// assert_eq!((ion_charge_e("SO4", 5), ion_charge_e("ZN", 1)), (Some(-2), Some(2)));
/// assert_eq!(ion_charge_e("ZN", 7), None, "no ion has seven atoms");
/// ```
pub fn ion_charge_e(name: &str, heavy_atoms: usize) -> Option<i32> {
    if let Some((_, charge)) = MOLECULAR_IONS
        .iter()
        .find(|(candidate, _)| *candidate == name)
    {
        return Some(*charge);
    }
    let ion = ion(name)?;
    (heavy_atoms == 1).then_some(ion.charge_e)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chemistry::residue_names::{is_polymer, is_water};

    #[test]
    fn no_name_means_two_things() {
        let mut names: Vec<&str> = Vec::new();
        for ion in IONS {
            names.push(ion.name);
            names.extend(ion.aliases);
        }
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all);
        for name in names {
            assert!(!is_polymer(name) && !is_water(name), "{name}");
        }
    }

    #[test]
    fn a_ligand_of_several_atoms_is_no_ion() {
        assert_eq!(ion_charge_e("CLA", 1), Some(-1));
        // Chlorophyll a has the name of the chloride of CHARMM.
        assert_eq!(ion_charge_e("CLA", 65), None);
        assert_eq!(ion_charge_e("SO4", 5), Some(-2));
    }
}
