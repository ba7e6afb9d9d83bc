//! Residue names beyond the twenty: modified residues and their parents, caps, nucleotides, waters,
//! ions.

use super::amino_acid::AminoAcid;
use super::protonation::Group;

/// A residue that stands in a chain in place of an amino acid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModifiedResidue {
    /// Residue name.
    pub name: &'static str,
    /// The amino acid it was made from; `None` for a chromophore made of several.
    pub parent: Option<AminoAcid>,
    /// Its titratable groups; `None` where they are the parent's.
    pub groups: Option<&'static [Group]>,
    /// What it is.
    pub what: &'static str,
}

const NEUTRAL: Option<&[Group]> = Some(&[]);
/// Second dissociation of a phosphate monoester: Xie et al., J. Am. Chem. Soc. 112, 8996 (1990) and
/// Hoffmann et al., Eur. J. Biochem. 221, 503 (1994) report 5.6 to 6.1 for the three residues; the
/// first is below 2.
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
const SULFOTYROSINE: &[Group] = &[Group::acid(-2.0, &["O1", "O2", "O3"])];
const CARBAMATE: &[Group] = &[Group::acid(5.0, &["OQ1", "OQ2"])];
const CYSTEIC_ACID: &[Group] = &[Group::acid(1.5, &["OD1", "OD2", "OD3"])];
const SULFINIC_ACID: &[Group] = &[Group::acid(2.0, &["OD1", "OD2"])];
const QUATERNARY_AMINE: &[Group] = &[Group::base(20.0, &["NZ"])];
const GAMMA_CARBOXYGLUTAMATE: &[Group] = &[
    Group::acid(3.2, &["OE11", "OE12"]),
    Group::acid(4.4, &["OE21", "OE22"]),
];
const METHYLHISTIDINE: &[Group] = &[Group::base(6.5, &["ND1", "NE2"])];

const fn modified(
    name: &'static str,
    parent: Option<AminoAcid>,
    groups: Option<&'static [Group]>,
    what: &'static str,
) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent,
        groups,
        what,
    }
}

/// Modified residues (wwPDB chemical component dictionary) and the names force fields give to
/// protonation states. The states themselves follow from the pH, so that `HIP` of a prepared file
/// is a histidine like any other.
const MODIFIED: &[ModifiedResidue] = &[
    modified("MSE", Some(AminoAcid::Met), None, "selenomethionine"),
    modified("FME", Some(AminoAcid::Met), None, "N-formylmethionine"),
    modified("SME", Some(AminoAcid::Met), None, "methionine sulfoxide"),
    modified(
        "SEP",
        Some(AminoAcid::Ser),
        Some(PHOSPHOSERINE),
        "phosphoserine",
    ),
    modified(
        "TPO",
        Some(AminoAcid::Thr),
        Some(PHOSPHOTHREONINE),
        "phosphothreonine",
    ),
    modified(
        "PTR",
        Some(AminoAcid::Tyr),
        Some(PHOSPHOTYROSINE),
        "phosphotyrosine",
    ),
    modified(
        "TYS",
        Some(AminoAcid::Tyr),
        Some(SULFOTYROSINE),
        "sulfotyrosine",
    ),
    modified("CSO", Some(AminoAcid::Cys), NEUTRAL, "S-hydroxycysteine"),
    modified("CSX", Some(AminoAcid::Cys), NEUTRAL, "S-oxycysteine"),
    modified(
        "CME",
        Some(AminoAcid::Cys),
        NEUTRAL,
        "S-(2-hydroxyethyl)thiocysteine",
    ),
    modified("SMC", Some(AminoAcid::Cys), NEUTRAL, "S-methylcysteine"),
    modified(
        "CAS",
        Some(AminoAcid::Cys),
        NEUTRAL,
        "S-dimethylarsenocysteine",
    ),
    modified(
        "OCS",
        Some(AminoAcid::Cys),
        Some(CYSTEIC_ACID),
        "cysteic acid",
    ),
    modified(
        "CSD",
        Some(AminoAcid::Cys),
        Some(SULFINIC_ACID),
        "cysteine sulfinic acid",
    ),
    modified("SEC", Some(AminoAcid::Cys), None, "selenocysteine"),
    modified("HYP", Some(AminoAcid::Pro), None, "4-hydroxyproline"),
    modified(
        "PCA",
        Some(AminoAcid::Glu),
        NEUTRAL,
        "pyroglutamic acid, which has no free amine",
    ),
    modified(
        "CGU",
        Some(AminoAcid::Glu),
        Some(GAMMA_CARBOXYGLUTAMATE),
        "gamma-carboxyglutamic acid",
    ),
    modified("MLY", Some(AminoAcid::Lys), None, "dimethyllysine"),
    modified("MLZ", Some(AminoAcid::Lys), None, "methyllysine"),
    modified(
        "M3L",
        Some(AminoAcid::Lys),
        Some(QUATERNARY_AMINE),
        "trimethyllysine",
    ),
    modified("ALY", Some(AminoAcid::Lys), NEUTRAL, "acetyllysine"),
    modified(
        "KCX",
        Some(AminoAcid::Lys),
        Some(CARBAMATE),
        "carboxylated lysine",
    ),
    modified(
        "LLP",
        Some(AminoAcid::Lys),
        NEUTRAL,
        "lysine with pyridoxal phosphate, taken as neutral",
    ),
    modified("PYL", Some(AminoAcid::Lys), NEUTRAL, "pyrrolysine"),
    modified(
        "HIC",
        Some(AminoAcid::His),
        Some(METHYLHISTIDINE),
        "methylhistidine",
    ),
    modified("MHO", Some(AminoAcid::Met), None, "methionine sulfoxide"),
    modified("AYA", Some(AminoAcid::Ala), None, "N-acetylalanine"),
    modified("SAC", Some(AminoAcid::Ser), None, "N-acetylserine"),
    modified("AGM", Some(AminoAcid::Arg), None, "5-methylarginine"),
    // Names of protonation states: AMBER, CHARMM.
    modified("HID", Some(AminoAcid::His), None, "histidine"),
    modified("HIE", Some(AminoAcid::His), None, "histidine"),
    modified("HIP", Some(AminoAcid::His), None, "histidine"),
    modified("HSD", Some(AminoAcid::His), None, "histidine"),
    modified("HSE", Some(AminoAcid::His), None, "histidine"),
    modified("HSP", Some(AminoAcid::His), None, "histidine"),
    modified("ASH", Some(AminoAcid::Asp), None, "aspartic acid"),
    modified("GLH", Some(AminoAcid::Glu), None, "glutamic acid"),
    modified("LYN", Some(AminoAcid::Lys), None, "lysine"),
    modified("CYX", Some(AminoAcid::Cys), None, "cysteine"),
    modified("CYM", Some(AminoAcid::Cys), None, "cysteine"),
    // Chromophores of fluorescent proteins: three residues condensed to one, taken as neutral. The
    // phenol of the GFP chromophore has its pKa between 4 and 8 depending on its surroundings in
    // the barrel; no model value holds.
    modified("CRO", None, NEUTRAL, "chromophore of Thr-Tyr-Gly"),
    modified("CR2", None, NEUTRAL, "chromophore of Gly-Tyr-Gly"),
    modified("CRQ", None, NEUTRAL, "chromophore of Gln-Tyr-Gly"),
    modified("CRF", None, NEUTRAL, "chromophore of Thr-Trp-Gly"),
    modified("CFY", None, NEUTRAL, "chromophore of Phe-Cys-Tyr-Gly"),
    modified("CH6", None, NEUTRAL, "chromophore of Met-Tyr-Gly"),
    modified("GYS", None, NEUTRAL, "chromophore of Ser-Tyr-Gly"),
    modified("NRQ", None, NEUTRAL, "chromophore of Met-Tyr-Gly"),
    modified("PIA", None, NEUTRAL, "chromophore of Ala-Tyr-Gly"),
    modified("SWG", None, NEUTRAL, "chromophore of Ser-Trp-Gly"),
];

/// Residues whose nitrogen is no free amine at the beginning of a chain.
const BLOCKED_AMINE: &[&str] = &["PCA", "FME", "AYA", "SAC"];

/// Groups that close the ends of a chain.
const CAPS: &[&str] = &["ACE", "FOR", "NME", "NMA", "NH2", "NHE"];

const NUCLEOTIDES: &[&str] = &[
    "A", "C", "G", "U", "I", "N", "DA", "DC", "DG", "DT", "DU", "DI", "DN", "RA", "RC", "RG", "RU",
    "DA3", "DA5", "DC3", "DC5", "DG3", "DG5", "DT3", "DT5", "RA3", "RA5", "RC3", "RC5", "RG3",
    "RG5", "RU3", "RU5", "ADE", "CYT", "GUA", "URA", "THY",
];

const WATERS: &[&str] = &[
    "HOH", "WAT", "DOD", "H2O", "TIP", "TIP3", "TP3", "TIP4", "TIP5", "T3P", "T4P", "SOL", "SPC",
    "OH2",
];

/// Charges of monatomic ions, e (wwPDB chemical component dictionary).
const IONS: &[(&str, i32)] = &[
    ("LI", 1),
    ("NA", 1),
    ("K", 1),
    ("RB", 1),
    ("CS", 1),
    ("AG", 1),
    ("CU1", 1),
    ("MG", 2),
    ("CA", 2),
    ("SR", 2),
    ("BA", 2),
    ("MN", 2),
    ("FE2", 2),
    ("CO", 2),
    ("NI", 2),
    ("CU", 2),
    ("ZN", 2),
    ("CD", 2),
    ("HG", 2),
    ("PB", 2),
    ("FE", 3),
    ("MN3", 3),
    ("AL", 3),
    ("F", -1),
    ("CL", -1),
    ("BR", -1),
    ("IOD", -1),
    ("SO4", -2),
    ("PO4", -3),
    ("NH4", 1),
];

/// The entry of a modified residue.
pub fn modified_residue(name: &str) -> Option<&'static ModifiedResidue> {
    MODIFIED.iter().find(|entry| entry.name == name)
}

/// Whether the residue's nitrogen is blocked, so that it has no terminal amine.
pub fn has_blocked_amine(name: &str) -> bool {
    BLOCKED_AMINE.contains(&name)
}

/// Whether the name is that of a cap, such as acetyl.
pub fn is_cap(name: &str) -> bool {
    CAPS.contains(&name)
}

/// Whether the name is that of a nucleotide.
pub fn is_nucleotide(name: &str) -> bool {
    NUCLEOTIDES.contains(&name)
}

/// Whether the name is that of a water molecule.
pub fn is_water(name: &str) -> bool {
    WATERS.contains(&name)
}

/// Whether the name is that of an amino acid, a modified one, a cap or a nucleotide.
pub fn is_polymer(name: &str) -> bool {
    AminoAcid::of_residue(name).is_some()
        || modified_residue(name).is_some()
        || is_cap(name)
        || is_nucleotide(name)
}

/// The charge of an ion by its residue name, e.
pub fn ion_charge_e(name: &str) -> Option<i32> {
    IONS.iter()
        .find(|(ion, _)| *ion == name)
        .map(|(_, charge)| *charge)
}
