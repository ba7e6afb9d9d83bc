//! Residue names beyond the twenty: modified residues and their parents, D-amino acids, caps,
//! nucleotides, waters.
//!
//! Sources of the pKa values of modified residues:
//!
//! * phosphate monoesters, second dissociation: Xie et al., J. Am. Chem. Soc. 112, 8996 (1990) and
//!   Hoffmann et al., Eur. J. Biochem. 221, 503 (1994) report 5.6 to 6.1 for the three residues;
//!   the first is below 2;
//! * pyridoxal phosphate: Williams and Neilands, Arch. Biochem. Biophys. 53, 56 (1954), 6.2 for the
//!   second dissociation of the phosphate; the protonated imine and the phenolate cancel;
//! * selenol of selenocysteine: Huber and Criddle, Arch. Biochem. Biophys. 122, 164 (1967), 5.24;
//! * ornithine, 2,4-diaminobutyric acid: CRC Handbook of Chemistry and Physics, dissociation
//!   constants of amino acids, 10.8 and 10.4;
//! * sulfate, sulfonate, sulfinate and quaternary ammonium groups are charged at any pH of interest;
//!   their pKa values are set out of that range.
//!
//! Masses are those of the parent and what the modification adds to its formula (IUPAC standard
//! atomic weights): 79.980 for HPO₃, 15.999 for O, 14.027 for CH₂, 42.037 for C₂H₂O. A chromophore
//! has those of its residues less H₂O and H₂, and another H₂ where it has an acylimine.

use super::amino_acid::AminoAcid::{
    self, Ala, Arg, Asn, Asp, Cys, Gln, Glu, His, Ile, Leu, Lys, Met, Phe, Pro, Ser, Thr, Trp, Tyr,
    Val,
};
use super::protonation::Group;

/// A residue that takes the place of an amino acid in a chain.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::residue_names::modified_residue;
/// let phosphoserine = modified_residue("SEP").ok_or("not in the table")?;
/// assert_eq!(phosphoserine.parent, Some(AminoAcid::Ser));
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModifiedResidue {
    /// Residue name.
    pub name: &'static str,
    /// Amino acid that the residue derives from; `None` for a chromophore made of several.
    pub parent: Option<AminoAcid>,
    /// Titratable groups of the residue; `None` where they are the parent's.
    pub groups: Option<&'static [Group]>,
    /// Mass of the residue in a chain, neutral, g/mol: the molecule without one water.
    pub mass_g_per_mol: f64,
    /// Description of the residue.
    pub description: &'static str,
}

const PHOSPHATE_ATOMS: &[&str] = &["O1P", "O2P", "O3P"];
const PHOSPHOSERINE: &[Group] = &[
    Group::acid(1.0, PHOSPHATE_ATOMS),
    Group::acid(5.6, PHOSPHATE_ATOMS),
];
const PHOSPHOTHREONINE: &[Group] = &[
    Group::acid(1.0, PHOSPHATE_ATOMS),
    Group::acid(6.1, PHOSPHATE_ATOMS),
];
const PHOSPHOTYROSINE: &[Group] = &[
    Group::acid(1.0, PHOSPHATE_ATOMS),
    Group::acid(5.9, PHOSPHATE_ATOMS),
];
const PYRIDOXAL_ATOMS: &[&str] = &["OP1", "OP2", "OP3"];
const PYRIDOXAL_PHOSPHATE: &[Group] = &[
    Group::acid(1.0, PYRIDOXAL_ATOMS),
    Group::acid(6.2, PYRIDOXAL_ATOMS),
];
const SULFOTYROSINE: &[Group] = &[Group::acid(-2.0, &["O1", "O2", "O3"])];
const CARBAMATE: &[Group] = &[Group::acid(5.0, &["OQ1", "OQ2"])];
const CYSTEIC_ACID: &[Group] = &[Group::acid(1.5, &["OD1", "OD2", "OD3"])];
const SULFINIC_ACID: &[Group] = &[Group::acid(2.0, &["OD1", "OD2"])];
const SELENOL: &[Group] = &[Group::acid(5.24, &["SE"])];
const QUATERNARY_AMINE: &[Group] = &[Group::base(20.0, &["NZ"])];
const ORNITHINE: &[Group] = &[Group::base(10.8, &["NE"])];
const DIAMINOBUTYRATE: &[Group] = &[Group::base(10.4, &["ND"])];
const GAMMA_CARBOXYGLUTAMATE: &[Group] = &[
    Group::acid(3.2, &["OE11", "OE12"]),
    Group::acid(4.4, &["OE21", "OE22"]),
];

/// A residue with the titratable groups of its parent. `added_g_per_mol` is what the modification
/// adds to the mass of the parent.
const fn like(
    name: &'static str,
    added_g_per_mol: f64,
    parent: AminoAcid,
    description: &'static str,
) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent: Some(parent),
        groups: None,
        mass_g_per_mol: parent.residue_mass_g_per_mol() + added_g_per_mol,
        description,
    }
}

/// A residue whose side chain does not titrate.
const fn neutral(
    name: &'static str,
    added_g_per_mol: f64,
    parent: AminoAcid,
    description: &'static str,
) -> ModifiedResidue {
    titrating(name, added_g_per_mol, parent, &[], description)
}

/// A residue with its own groups.
const fn titrating(
    name: &'static str,
    added_g_per_mol: f64,
    parent: AminoAcid,
    groups: &'static [Group],
    description: &'static str,
) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent: Some(parent),
        groups: Some(groups),
        mass_g_per_mol: parent.residue_mass_g_per_mol() + added_g_per_mol,
        description,
    }
}

/// A chromophore of a fluorescent protein: several residues condensed to one, taken as neutral. The
/// phenol of the GFP chromophore has a pKa between 4 and 8, depending on its environment in the
/// barrel, so there is no useful model value.
const fn chromophore(
    name: &'static str,
    mass_g_per_mol: f64,
    description: &'static str,
) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent: None,
        groups: Some(&[]),
        mass_g_per_mol,
        description,
    }
}

/// Modified residues (wwPDB chemical component dictionary).
const MODIFIED: &[ModifiedResidue] = &[
    like("MSE", 46.911, Met, "selenomethionine"),
    like("FME", 28.010, Met, "N-formylmethionine"),
    like("SME", 15.999, Met, "methionine sulfoxide"),
    like("MHO", 15.999, Met, "methionine sulfoxide"),
    titrating("SEP", 79.980, Ser, PHOSPHOSERINE, "phosphoserine"),
    titrating("TPO", 79.980, Thr, PHOSPHOTHREONINE, "phosphothreonine"),
    titrating("PTR", 79.980, Tyr, PHOSPHOTYROSINE, "phosphotyrosine"),
    titrating("TYS", 80.057, Tyr, SULFOTYROSINE, "sulfotyrosine"),
    neutral("CSO", 15.999, Cys, "S-hydroxycysteine"),
    neutral("CSX", 15.999, Cys, "S-oxycysteine"),
    neutral("CME", 76.113, Cys, "S-(2-hydroxyethyl)thiocysteine"),
    neutral("SMC", 14.027, Cys, "S-methylcysteine"),
    neutral("CAS", 103.984, Cys, "S-dimethylarsenocysteine"),
    neutral("YCM", 57.052, Cys, "S-carbamoylmethylcysteine"),
    titrating("OCS", 47.997, Cys, CYSTEIC_ACID, "cysteic acid"),
    titrating("CSD", 31.998, Cys, SULFINIC_ACID, "cysteine sulfinic acid"),
    titrating("SEC", 46.911, Cys, SELENOL, "selenocysteine"),
    like("HYP", 15.999, Pro, "4-hydroxyproline"),
    neutral(
        "PCA",
        -18.015,
        Glu,
        "pyroglutamic acid, which has no free amine",
    ),
    titrating(
        "CGU",
        44.009,
        Glu,
        GAMMA_CARBOXYGLUTAMATE,
        "gamma-carboxyglutamic acid",
    ),
    like("MLY", 28.054, Lys, "dimethyllysine"),
    like("MLZ", 14.027, Lys, "methyllysine"),
    titrating("M3L", 43.089, Lys, QUATERNARY_AMINE, "trimethyllysine"),
    neutral("ALY", 42.037, Lys, "acetyllysine"),
    titrating("KCX", 44.009, Lys, CARBAMATE, "carboxylated lysine"),
    titrating(
        "LLP",
        229.128,
        Lys,
        PYRIDOXAL_PHOSPHATE,
        "lysine with pyridoxal phosphate",
    ),
    neutral("PYL", 109.128, Lys, "pyrrolysine"),
    titrating("ORN", -14.027, Lys, ORNITHINE, "ornithine"),
    titrating(
        "DAB",
        -28.054,
        Lys,
        DIAMINOBUTYRATE,
        "2,4-diaminobutyric acid",
    ),
    like("HIC", 14.027, His, "methylhistidine"),
    like("AYA", 42.037, Ala, "N-acetylalanine"),
    like("SAC", 42.037, Ser, "N-acetylserine"),
    like("AGM", 14.027, Arg, "5-methylarginine"),
    like("DA2", 28.054, Arg, "asymmetric dimethylarginine"),
    like("2MR", 28.054, Arg, "symmetric dimethylarginine"),
    neutral("CIR", 0.984, Arg, "citrulline"),
    // Mirror images have the charges and the hydropathy of their L-forms.
    like("DAL", 0.0, Ala, "D-alanine"),
    like("DAR", 0.0, Arg, "D-arginine"),
    like("DSG", 0.0, Asn, "D-asparagine"),
    like("DAS", 0.0, Asp, "D-aspartic acid"),
    like("DCY", 0.0, Cys, "D-cysteine"),
    like("DGN", 0.0, Gln, "D-glutamine"),
    like("DGL", 0.0, Glu, "D-glutamic acid"),
    like("DHI", 0.0, His, "D-histidine"),
    like("DIL", 0.0, Ile, "D-isoleucine"),
    like("DLE", 0.0, Leu, "D-leucine"),
    like("DLY", 0.0, Lys, "D-lysine"),
    like("MED", 0.0, Met, "D-methionine"),
    like("DPN", 0.0, Phe, "D-phenylalanine"),
    like("DPR", 0.0, Pro, "D-proline"),
    like("DSN", 0.0, Ser, "D-serine"),
    like("DTH", 0.0, Thr, "D-threonine"),
    like("DTR", 0.0, Trp, "D-tryptophan"),
    like("DTY", 0.0, Tyr, "D-tyrosine"),
    like("DVA", 0.0, Val, "D-valine"),
    chromophore("CRO", 301.302, "chromophore of Thr-Tyr-Gly"),
    chromophore("CR2", 257.249, "chromophore of Gly-Tyr-Gly"),
    chromophore("CRQ", 326.312, "chromophore of Gln-Tyr-Gly"),
    chromophore("CRF", 324.339, "chromophore of Thr-Trp-Gly"),
    chromophore("CFY", 450.518, "chromophore of Phe-Cys-Tyr-Gly"),
    chromophore("CH6", 331.395, "chromophore of Met-Tyr-Gly"),
    chromophore("GYS", 287.275, "chromophore of Ser-Tyr-Gly"),
    chromophore("NRQ", 329.379, "chromophore of Met-Tyr-Gly"),
    chromophore("PIA", 271.276, "chromophore of Ala-Tyr-Gly"),
    chromophore("SWG", 310.312, "chromophore of Ser-Trp-Gly"),
];

/// Residues whose nitrogen is acylated, so that it is not a free amine at the beginning of a chain.
const BLOCKED_AMINE: &[&str] = &["PCA", "FME", "AYA", "SAC"];

/// Groups that close the ends of a chain, and what each adds to the mass of the chain, g/mol: an acyl
/// group takes the place of a hydrogen, an amine that of the hydroxyl.
const CAPS: &[(&str, f64)] = &[
    ("ACE", 42.037),
    ("FOR", 28.010),
    ("NME", 13.043),
    ("NMA", 13.043),
    ("NAC", 13.043),
    ("NH2", -0.984),
    ("NHE", -0.984),
];

/// Names that force fields and their programs (AMBER, CHARMM, GROMACS, GROMOS, OPLS, Schrödinger)
/// give to protonation states and disulfides. The pH decides the state: `HIP` of a prepared file is
/// a histidine like any other.
const FORCE_FIELD: &[(&str, AminoAcid)] = &[
    ("HID", His),
    ("HIE", His),
    ("HIP", His),
    ("HIN", His),
    ("HSD", His),
    ("HSE", His),
    ("HSP", His),
    ("HDP", His),
    ("ASH", Asp),
    ("GLH", Glu),
    ("LYN", Lys),
    ("LYP", Lys),
    ("LSN", Lys),
    ("ARN", Arg),
    ("CYX", Cys),
    ("CYM", Cys),
    ("CYN", Cys),
    ("CYP", Cys),
    ("TYM", Tyr),
    ("DISU", Cys),
];

const NUCLEOTIDES: &[&str] = &[
    "A", "C", "G", "U", "I", "N", "DA", "DC", "DG", "DT", "DU", "DI", "DN", "RA", "RC", "RG", "RU",
    "DA3", "DA5", "DC3", "DC5", "DG3", "DG5", "DT3", "DT5", "RA3", "RA5", "RC3", "RC5", "RG3",
    "RG5", "RU3", "RU5", "ADE", "CYT", "GUA", "URA", "THY",
];

const WATERS: &[&str] = &[
    "HOH", "WAT", "DOD", "HOD", "H2O", "TIP", "TIP3", "TP3", "TIP4", "TP4", "TIP5", "TP5", "T3P",
    "T4P", "T4E", "T3H", "SOL", "SPC", "SPCE", "OPC", "OPC3", "OH2",
];

/// The entry of a modified residue.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::residue_names::modified_residue;
/// assert_eq!(modified_residue("MSE").and_then(|entry| entry.parent), Some(AminoAcid::Met));
/// assert!(modified_residue("MET").is_none());
/// ```
pub fn modified_residue(name: &str) -> Option<&'static ModifiedResidue> {
    MODIFIED.iter().find(|entry| entry.name == name)
}

/// Whether the residue's nitrogen is blocked, so that it has no terminal amine.
pub fn has_blocked_amine(name: &str) -> bool {
    BLOCKED_AMINE.contains(&name)
}

/// Whether the name is that of a cap, such as acetyl.
///
/// ```
/// use protomer_body::chemistry::residue_names::is_cap;
/// assert!(is_cap("ACE") && is_cap("NME") && !is_cap("ALA"));
/// ```
pub fn is_cap(name: &str) -> bool {
    cap_mass_g_per_mol(name).is_some()
}

/// Mass that a cap adds to a chain, g/mol.
fn cap_mass_g_per_mol(name: &str) -> Option<f64> {
    let cap = CAPS.iter().find(|(cap, _)| *cap == name)?;
    Some(cap.1)
}

/// Fourth letters by which GROMOS, GROMACS and CHARMM tell the states of an amino acid.
const STATES: &[(AminoAcid, &str)] = &[
    (Arg, "NP"),
    (Asp, "HP"),
    (Cys, "H12MX"),
    (Glu, "HP"),
    (His, "ABDEHP12"),
    (Lys, "HNP"),
    (Tyr, "M"),
];

/// Whether a name of four letters is one that programs for molecular dynamics use.
pub(crate) fn is_name_of_four_letters(name: &str) -> bool {
    let Some((three, state)) = name.split_at_checked(3) else {
        return false;
    };
    let has_state = |(amino_acid, states): &(AminoAcid, &str)| {
        amino_acid.name() == three && state.len() == 1 && states.contains(state)
    };
    is_water(name) || name == "DISU" || STATES.iter().any(has_state) || at_end(name).is_some()
}

/// The amino acid of a name of AMBER for a residue at the end of a chain.
fn at_end(name: &str) -> Option<AminoAcid> {
    let name = name
        .strip_prefix(['N', 'C'])
        .filter(|base_name| base_name.len() == 3)?;
    AminoAcid::of_residue(name).or_else(|| of_state(name))
}

/// The amino acid of an entry of [`FORCE_FIELD`].
fn of_state(name: &str) -> Option<AminoAcid> {
    let entry = FORCE_FIELD.iter().find(|(state, _)| *state == name)?;
    Some(entry.1)
}

/// The amino acid of a name that a force field gives to one of its protonation states, or to a
/// residue at the end of a chain (AMBER: `NALA`, `CHIE`). Names of four letters are the three of an
/// amino acid and one for the state (GROMOS, GROMACS: `LYSH`, `HISE`, `CYS2`).
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::residue_names::force_field_amino_acid;
/// assert_eq!(force_field_amino_acid("HISE"), Some(AminoAcid::His));
/// assert_eq!(force_field_amino_acid("NMET"), Some(AminoAcid::Met));
/// assert_eq!(force_field_amino_acid("MET"), None);
/// ```
pub fn force_field_amino_acid(name: &str) -> Option<AminoAcid> {
    let of_letters = || {
        let three = name.get(..3).filter(|_| name.len() == 4)?;
        AminoAcid::of_residue(three)
    };
    of_state(name).or_else(|| at_end(name)).or_else(of_letters)
}

/// The amino acid that a residue of this name is, by the name of the wwPDB or of a force field, or
/// derives from.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::residue_names::parent_amino_acid;
/// assert_eq!(parent_amino_acid("SEP"), Some(AminoAcid::Ser));
/// assert_eq!(parent_amino_acid("HOH"), None);
/// ```
pub fn parent_amino_acid(name: &str) -> Option<AminoAcid> {
    AminoAcid::of_residue(name)
        .or_else(|| force_field_amino_acid(name))
        .or_else(|| modified_residue(name)?.parent)
}

/// Mass that a residue adds to its chain, neutral, g/mol. `None` for a residue whose mass is not
/// known by its name.
///
/// ```
/// use protomer_body::chemistry::residue_names::mass_in_chain_g_per_mol;
/// // Phosphoserine is serine and HPO₃.
/// assert_eq!(mass_in_chain_g_per_mol("SEP"), Some(87.078 + 79.980));
/// assert_eq!(mass_in_chain_g_per_mol("LIG"), None);
/// ```
pub fn mass_in_chain_g_per_mol(name: &str) -> Option<f64> {
    if let Some(modified) = modified_residue(name) {
        return Some(modified.mass_g_per_mol);
    }
    match parent_amino_acid(name) {
        Some(amino_acid) => Some(amino_acid.residue_mass_g_per_mol()),
        None => cap_mass_g_per_mol(name),
    }
}

/// Whether the name is that of a nucleotide.
///
/// ```
/// use protomer_body::chemistry::residue_names::is_nucleotide;
/// assert!(is_nucleotide("DA") && is_nucleotide("U") && !is_nucleotide("ALA"));
/// ```
pub fn is_nucleotide(name: &str) -> bool {
    NUCLEOTIDES.contains(&name)
}

/// Whether the name is that of a water molecule.
///
/// ```
/// use protomer_body::chemistry::residue_names::is_water;
/// assert!(is_water("HOH") && is_water("TIP3") && !is_water("SO4"));
/// ```
pub fn is_water(name: &str) -> bool {
    WATERS.contains(&name)
}

/// Whether the name is that of an amino acid, a modified one, a cap or a nucleotide.
///
/// ```
/// use protomer_body::chemistry::residue_names::is_polymer;
/// assert!(["ALA", "MSE", "ACE", "DG"].into_iter().all(is_polymer));
/// assert!(!is_polymer("HEM") && !is_polymer("HOH"));
/// ```
pub fn is_polymer(name: &str) -> bool {
    parent_amino_acid(name).is_some()
        || modified_residue(name).is_some()
        || is_cap(name)
        || is_nucleotide(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_means_two_things() {
        for (name, amino_acid) in FORCE_FIELD {
            assert!(AminoAcid::of_residue(name).is_none() && modified_residue(name).is_none());
            assert_eq!(parent_amino_acid(name), Some(*amino_acid));
        }
    }

    /// Formulas of the wwPDB chemical component dictionary, less one water.
    #[test]
    fn masses_are_those_of_the_formulas() {
        let mass = |c: f64, h: f64, n: f64, o: f64, rest: f64| {
            c * 12.011 + h * 1.008 + n * 14.007 + o * 15.999 + rest - 18.015
        };
        let (sulfur, selenium, phosphorus, arsenic) = (32.06, 78.971, 30.974, 74.922);
        for (name, expected) in [
            ("MSE", mass(5.0, 11.0, 1.0, 2.0, selenium)),
            ("SEP", mass(3.0, 8.0, 1.0, 6.0, phosphorus)),
            ("TPO", mass(4.0, 10.0, 1.0, 6.0, phosphorus)),
            ("PTR", mass(9.0, 12.0, 1.0, 6.0, phosphorus)),
            ("TYS", mass(9.0, 11.0, 1.0, 6.0, sulfur)),
            ("CSO", mass(3.0, 7.0, 1.0, 3.0, sulfur)),
            ("CME", mass(5.0, 11.0, 1.0, 3.0, 2.0 * sulfur)),
            ("CAS", mass(5.0, 12.0, 1.0, 2.0, sulfur + arsenic)),
            ("PCA", mass(5.0, 7.0, 1.0, 3.0, 0.0)),
            ("M3L", mass(9.0, 21.0, 2.0, 2.0, 0.0)),
            ("LLP", mass(14.0, 22.0, 3.0, 7.0, phosphorus)),
            ("PYL", mass(12.0, 21.0, 3.0, 3.0, 0.0)),
            ("CIR", mass(6.0, 13.0, 3.0, 3.0, 0.0)),
            ("CGU", mass(6.0, 9.0, 1.0, 6.0, 0.0)),
            ("CRO", mass(15.0, 17.0, 3.0, 5.0, 0.0)),
            ("NRQ", mass(16.0, 17.0, 3.0, 4.0, sulfur)),
        ] {
            let found = mass_in_chain_g_per_mol(name).unwrap();
            assert!(
                (found - expected).abs() < 0.02,
                "{name}: {found}, not {expected}"
            );
        }
    }
}
