//! The twenty amino acids.

use serde::{Deserialize, Serialize};

/// An amino acid, by its three-letter name.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// assert_eq!(AminoAcid::Lys.letter(), 'K');
/// assert_eq!(AminoAcid::Ser.side_chain(), ["CB", "OG"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the variants are the three-letter names")]
pub enum AminoAcid {
    Ala,
    Arg,
    Asn,
    Asp,
    Cys,
    Gln,
    Glu,
    Gly,
    His,
    Ile,
    Leu,
    Lys,
    Met,
    Phe,
    Pro,
    Ser,
    Thr,
    Trp,
    Tyr,
    Val,
}

/// Name, letter, side chain's heavy atoms.
type Entry = (AminoAcid, &'static str, char, &'static [&'static str]);

const TABLE: [Entry; 20] = [
    (AminoAcid::Ala, "ALA", 'A', &["CB"]),
    (
        AminoAcid::Arg,
        "ARG",
        'R',
        &["CB", "CG", "CD", "NE", "CZ", "NH1", "NH2"],
    ),
    (AminoAcid::Asn, "ASN", 'N', &["CB", "CG", "OD1", "ND2"]),
    (AminoAcid::Asp, "ASP", 'D', &["CB", "CG", "OD1", "OD2"]),
    (AminoAcid::Cys, "CYS", 'C', &["CB", "SG"]),
    (
        AminoAcid::Gln,
        "GLN",
        'Q',
        &["CB", "CG", "CD", "OE1", "NE2"],
    ),
    (
        AminoAcid::Glu,
        "GLU",
        'E',
        &["CB", "CG", "CD", "OE1", "OE2"],
    ),
    (AminoAcid::Gly, "GLY", 'G', &[]),
    (
        AminoAcid::His,
        "HIS",
        'H',
        &["CB", "CG", "ND1", "CD2", "CE1", "NE2"],
    ),
    (AminoAcid::Ile, "ILE", 'I', &["CB", "CG1", "CG2", "CD1"]),
    (AminoAcid::Leu, "LEU", 'L', &["CB", "CG", "CD1", "CD2"]),
    (AminoAcid::Lys, "LYS", 'K', &["CB", "CG", "CD", "CE", "NZ"]),
    (AminoAcid::Met, "MET", 'M', &["CB", "CG", "SD", "CE"]),
    (
        AminoAcid::Phe,
        "PHE",
        'F',
        &["CB", "CG", "CD1", "CD2", "CE1", "CE2", "CZ"],
    ),
    (AminoAcid::Pro, "PRO", 'P', &["CB", "CG", "CD"]),
    (AminoAcid::Ser, "SER", 'S', &["CB", "OG"]),
    (AminoAcid::Thr, "THR", 'T', &["CB", "OG1", "CG2"]),
    (
        AminoAcid::Trp,
        "TRP",
        'W',
        &[
            "CB", "CG", "CD1", "CD2", "NE1", "CE2", "CE3", "CZ2", "CZ3", "CH2",
        ],
    ),
    (
        AminoAcid::Tyr,
        "TYR",
        'Y',
        &["CB", "CG", "CD1", "CD2", "CE1", "CE2", "CZ", "OH"],
    ),
    (AminoAcid::Val, "VAL", 'V', &["CB", "CG1", "CG2"]),
];

/// The heavy atoms every residue has.
pub const BACKBONE: [&str; 4] = ["N", "CA", "C", "O"];

impl AminoAcid {
    /// All twenty amino acids, by name.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// let letters: String = AminoAcid::all().map(AminoAcid::letter).collect();
    /// assert_eq!(letters, "ARNDCQEGHILKMFPSTWYV");
    /// ```
    pub fn all() -> impl Iterator<Item = AminoAcid> {
        TABLE.iter().map(|entry| entry.0)
    }

    fn entry(self) -> &'static Entry {
        // A test checks that the table is in the order of the variants.
        &TABLE[self as usize]
    }

    /// The amino acid of a three-letter name in upper case, or of a one-letter code.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// assert_eq!(AminoAcid::of_name("GLU"), AminoAcid::of_name("E"));
    /// ```
    pub fn of_name(name: &str) -> Option<Self> {
        if name.len() != 1 {
            return Self::of_residue(name);
        }
        for (amino_acid, _, letter, ..) in TABLE {
            if name.starts_with(letter) {
                return Some(amino_acid);
            }
        }
        None
    }

    /// The amino acid of a residue in a file, by its three-letter name in upper case. A single
    /// letter is not the name of an amino acid there: A, C and G are nucleotides.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// assert_eq!(AminoAcid::of_residue("GLU"), AminoAcid::of_name("E"));
    /// assert_eq!(AminoAcid::of_residue("G"), None);
    /// ```
    pub fn of_residue(name: &str) -> Option<Self> {
        for (amino_acid, letters, ..) in TABLE {
            if letters == name {
                return Some(amino_acid);
            }
        }
        None
    }

    /// Three-letter name, upper case.
    pub fn name(self) -> &'static str {
        self.entry().1
    }

    /// One-letter code.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// assert_eq!((AminoAcid::Lys.letter(), AminoAcid::Lys.name()), ('K', "LYS"));
    /// ```
    pub fn letter(self) -> char {
        self.entry().2
    }

    /// Mass of the residue in a chain, neutral, with the natural isotopes, g/mol: the molecule
    /// without one water (IUPAC standard atomic weights).
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// assert_eq!(AminoAcid::Gly.residue_mass_g_per_mol(), 57.052);
    /// ```
    pub const fn residue_mass_g_per_mol(self) -> f64 {
        match self {
            AminoAcid::Ala => 71.079,
            AminoAcid::Arg => 156.188,
            AminoAcid::Asn => 114.104,
            AminoAcid::Asp => 115.089,
            AminoAcid::Cys => 103.144,
            AminoAcid::Gln => 128.131,
            AminoAcid::Glu => 129.116,
            AminoAcid::Gly => 57.052,
            AminoAcid::His => 137.142,
            AminoAcid::Ile | AminoAcid::Leu => 113.160,
            AminoAcid::Lys => 128.174,
            AminoAcid::Met => 131.198,
            AminoAcid::Phe => 147.177,
            AminoAcid::Pro => 97.117,
            AminoAcid::Ser => 87.078,
            AminoAcid::Thr => 101.105,
            AminoAcid::Trp => 186.213,
            AminoAcid::Tyr => 163.176,
            AminoAcid::Val => 99.133,
        }
    }

    /// Heavy atoms of the side chain, in the names of the Protein Data Bank.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// assert_eq!(AminoAcid::Thr.side_chain(), ["CB", "OG1", "CG2"]);
    /// assert!(AminoAcid::Gly.side_chain().is_empty());
    /// ```
    pub fn side_chain(self) -> &'static [&'static str] {
        self.entry().3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_variants() {
        for (index, entry) in TABLE.iter().enumerate() {
            assert_eq!(entry.0 as usize, index);
            assert_eq!(
                AminoAcid::of_name(entry.1),
                AminoAcid::of_name(&entry.2.to_string())
            );
        }
    }
}
