//! The scale of hydropathy: how strongly the side chain of an amino acid avoids water.
//!
//! Kyte and Doolittle, J. Mol. Biol. 157, 105 (1982), table 2.

use super::AminoAcid;

/// Name of the scale.
pub const HYDROPATHY_SCALE: &str = "Kyte-Doolittle";
/// The largest value of the scale, for either sign.
pub const LARGEST_HYDROPATHY: f64 = 4.5;

impl AminoAcid {
    /// Hydropathy index; positive for side chains that avoid water.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid;
    /// assert_eq!(AminoAcid::Ile.hydropathy(), 4.5);
    /// assert_eq!(AminoAcid::Arg.hydropathy(), -4.5);
    /// ```
    pub fn hydropathy(self) -> f64 {
        match self {
            AminoAcid::Ile => 4.5,
            AminoAcid::Val => 4.2,
            AminoAcid::Leu => 3.8,
            AminoAcid::Phe => 2.8,
            AminoAcid::Cys => 2.5,
            AminoAcid::Met => 1.9,
            AminoAcid::Ala => 1.8,
            AminoAcid::Gly => -0.4,
            AminoAcid::Thr => -0.7,
            AminoAcid::Ser => -0.8,
            AminoAcid::Trp => -0.9,
            AminoAcid::Tyr => -1.3,
            AminoAcid::Pro => -1.6,
            AminoAcid::His => -3.2,
            AminoAcid::Asn | AminoAcid::Asp | AminoAcid::Gln | AminoAcid::Glu => -3.5,
            AminoAcid::Lys => -3.9,
            AminoAcid::Arg => -4.5,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_has_its_published_ends_and_sum() {
        let mut largest: f64 = 0.0;
        for amino_acid in AminoAcid::all() {
            largest = largest.max(amino_acid.hydropathy().abs());
        }
        assert_eq!(largest, LARGEST_HYDROPATHY);
        let sum: f64 = AminoAcid::all().map(AminoAcid::hydropathy).sum();
        assert!((sum - -9.8).abs() < 1e-9, "{sum}");
    }
}
