//! Residue names beyond the twenty: modified residues and their parents, D-amino acids, caps,
//! nucleotides, waters, ions.
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
    /// The amino acid it derives from; `None` for a chromophore made of several.
    pub parent: Option<AminoAcid>,
    /// Its titratable groups; `None` where they are the parent's.
    pub groups: Option<&'static [Group]>,
    /// What it is.
    pub what: &'static str,
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

/// A residue with the titratable groups of its parent.
const fn like(name: &'static str, parent: AminoAcid, what: &'static str) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent: Some(parent),
        groups: None,
        what,
    }
}

/// A residue whose side chain does not titrate.
const fn neutral(name: &'static str, parent: AminoAcid, what: &'static str) -> ModifiedResidue {
    titrating(name, parent, &[], what)
}

/// A residue with groups of its own.
const fn titrating(
    name: &'static str,
    parent: AminoAcid,
    groups: &'static [Group],
    what: &'static str,
) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent: Some(parent),
        groups: Some(groups),
        what,
    }
}

/// A chromophore of a fluorescent protein: several residues condensed to one, taken as neutral. The
/// phenol of the GFP chromophore has a pKa between 4 and 8, depending on its environment in the
/// barrel, so there is no useful model value.
const fn chromophore(name: &'static str, what: &'static str) -> ModifiedResidue {
    ModifiedResidue {
        name,
        parent: None,
        groups: Some(&[]),
        what,
    }
}

/// Modified residues (wwPDB chemical component dictionary) and the names that force fields give to
/// protonation states. The pH decides the state: `HIP` of a prepared file is a histidine like any
/// other.
const MODIFIED: &[ModifiedResidue] = &[
    like("MSE", Met, "selenomethionine"),
    like("FME", Met, "N-formylmethionine"),
    like("SME", Met, "methionine sulfoxide"),
    like("MHO", Met, "methionine sulfoxide"),
    titrating("SEP", Ser, PHOSPHOSERINE, "phosphoserine"),
    titrating("TPO", Thr, PHOSPHOTHREONINE, "phosphothreonine"),
    titrating("PTR", Tyr, PHOSPHOTYROSINE, "phosphotyrosine"),
    titrating("TYS", Tyr, SULFOTYROSINE, "sulfotyrosine"),
    neutral("CSO", Cys, "S-hydroxycysteine"),
    neutral("CSX", Cys, "S-oxycysteine"),
    neutral("CME", Cys, "S-(2-hydroxyethyl)thiocysteine"),
    neutral("SMC", Cys, "S-methylcysteine"),
    neutral("CAS", Cys, "S-dimethylarsenocysteine"),
    neutral("YCM", Cys, "S-carbamoylmethylcysteine"),
    titrating("OCS", Cys, CYSTEIC_ACID, "cysteic acid"),
    titrating("CSD", Cys, SULFINIC_ACID, "cysteine sulfinic acid"),
    titrating("SEC", Cys, SELENOL, "selenocysteine"),
    like("HYP", Pro, "4-hydroxyproline"),
    neutral("PCA", Glu, "pyroglutamic acid, which has no free amine"),
    titrating(
        "CGU",
        Glu,
        GAMMA_CARBOXYGLUTAMATE,
        "gamma-carboxyglutamic acid",
    ),
    like("MLY", Lys, "dimethyllysine"),
    like("MLZ", Lys, "methyllysine"),
    titrating("M3L", Lys, QUATERNARY_AMINE, "trimethyllysine"),
    neutral("ALY", Lys, "acetyllysine"),
    titrating("KCX", Lys, CARBAMATE, "carboxylated lysine"),
    titrating(
        "LLP",
        Lys,
        PYRIDOXAL_PHOSPHATE,
        "lysine with pyridoxal phosphate",
    ),
    neutral("PYL", Lys, "pyrrolysine"),
    titrating("ORN", Lys, ORNITHINE, "ornithine"),
    titrating("DAB", Lys, DIAMINOBUTYRATE, "2,4-diaminobutyric acid"),
    like("HIC", His, "methylhistidine"),
    like("AYA", Ala, "N-acetylalanine"),
    like("SAC", Ser, "N-acetylserine"),
    like("AGM", Arg, "5-methylarginine"),
    like("DA2", Arg, "asymmetric dimethylarginine"),
    like("2MR", Arg, "symmetric dimethylarginine"),
    neutral("CIR", Arg, "citrulline"),
    // Mirror images have the charges and the hydropathy of their L-forms.
    like("DAL", Ala, "D-alanine"),
    like("DAR", Arg, "D-arginine"),
    like("DSG", Asn, "D-asparagine"),
    like("DAS", Asp, "D-aspartic acid"),
    like("DCY", Cys, "D-cysteine"),
    like("DGN", Gln, "D-glutamine"),
    like("DGL", Glu, "D-glutamic acid"),
    like("DHI", His, "D-histidine"),
    like("DIL", Ile, "D-isoleucine"),
    like("DLE", Leu, "D-leucine"),
    like("DLY", Lys, "D-lysine"),
    like("MED", Met, "D-methionine"),
    like("DPN", Phe, "D-phenylalanine"),
    like("DPR", Pro, "D-proline"),
    like("DSN", Ser, "D-serine"),
    like("DTH", Thr, "D-threonine"),
    like("DTR", Trp, "D-tryptophan"),
    like("DTY", Tyr, "D-tyrosine"),
    like("DVA", Val, "D-valine"),
    // Names of protonation states: AMBER, CHARMM.
    like("HID", His, "histidine"),
    like("HIE", His, "histidine"),
    like("HIP", His, "histidine"),
    like("HSD", His, "histidine"),
    like("HSE", His, "histidine"),
    like("HSP", His, "histidine"),
    like("ASH", Asp, "aspartic acid"),
    like("GLH", Glu, "glutamic acid"),
    like("LYN", Lys, "lysine"),
    like("CYX", Cys, "cysteine"),
    like("CYM", Cys, "cysteine"),
    chromophore("CRO", "chromophore of Thr-Tyr-Gly"),
    chromophore("CR2", "chromophore of Gly-Tyr-Gly"),
    chromophore("CRQ", "chromophore of Gln-Tyr-Gly"),
    chromophore("CRF", "chromophore of Thr-Trp-Gly"),
    chromophore("CFY", "chromophore of Phe-Cys-Tyr-Gly"),
    chromophore("CH6", "chromophore of Met-Tyr-Gly"),
    chromophore("GYS", "chromophore of Ser-Tyr-Gly"),
    chromophore("NRQ", "chromophore of Met-Tyr-Gly"),
    chromophore("PIA", "chromophore of Ala-Tyr-Gly"),
    chromophore("SWG", "chromophore of Ser-Trp-Gly"),
];

/// Residues whose nitrogen is acylated, so that it is not a free amine at the beginning of a chain.
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
    for (ion, charge) in IONS {
        if *ion == name {
            return Some(*charge);
        }
    }
    None
}
