//! AMBER ff94 partial charges.
//!
//! Cornell et al., J. Am. Chem. Soc. 117, 5179 (1995), residues within a chain; ff99 and ff14SB
//! keep these charges. The neutral lysine is that of the later AMBER libraries. Each entry is a
//! heavy atom, its own charge and the sum of the charges of its hydrogens, e; a united atom carries
//! both.

use super::amino_acid::AminoAcid;

/// A heavy atom: name, own charge, sum of the charges of its hydrogens, e.
pub type TemplateAtom = (&'static str, f64, f64);

/// The charges of one residue in one protonation state.
pub type Template = &'static [TemplateAtom];

/// The two forms of a residue between which protonation moves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forms {
    /// The form with its proton, or the only one.
    pub protonated: &'static [Template],
    /// The form without its proton; empty where the force field has none.
    pub deprotonated: &'static [Template],
}

/// The forms of a residue. A form with several templates (the two tautomers of neutral histidine)
/// is their unweighted mean.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::templates::{Template, forms};
/// let charge = |template: &Template| -> f64 { template.iter().map(|(_, own, of_h)| own + of_h).sum() };
/// let aspartate = forms(AminoAcid::Asp, false);
/// assert!(charge(&aspartate.protonated[0]).abs() < 1e-9);
/// assert!((charge(&aspartate.deprotonated[0]) + 1.0).abs() < 1e-9);
/// ```
pub fn forms(residue: AminoAcid, in_disulfide: bool) -> Forms {
    let (protonated, deprotonated): (&'static [Template], &'static [Template]) = match residue {
        AminoAcid::Ala => (&[ALA], &[]),
        AminoAcid::Arg => (&[ARG], &[]),
        AminoAcid::Asn => (&[ASN], &[]),
        AminoAcid::Asp => (&[ASH], &[ASP]),
        AminoAcid::Cys if in_disulfide => (&[CYX], &[]),
        AminoAcid::Cys => (&[CYS], &[CYM]),
        AminoAcid::Gln => (&[GLN], &[]),
        AminoAcid::Glu => (&[GLH], &[GLU]),
        AminoAcid::Gly => (&[GLY], &[]),
        AminoAcid::His => (&[HIP], &[HID, HIE]),
        AminoAcid::Ile => (&[ILE], &[]),
        AminoAcid::Leu => (&[LEU], &[]),
        AminoAcid::Lys => (&[LYS], &[LYN]),
        AminoAcid::Met => (&[MET], &[]),
        AminoAcid::Phe => (&[PHE], &[]),
        AminoAcid::Pro => (&[PRO], &[]),
        AminoAcid::Ser => (&[SER], &[]),
        AminoAcid::Thr => (&[THR], &[]),
        AminoAcid::Trp => (&[TRP], &[]),
        AminoAcid::Tyr => (&[TYR], &[]),
        AminoAcid::Val => (&[VAL], &[]),
    };
    Forms {
        protonated,
        deprotonated,
    }
}

/// Charges that protonation of the terminal amine adds to the atoms: N-terminal minus mid-chain
/// alanine, hydrogens included in their heavy atoms, the remainder on CA.
pub const N_TERMINUS: [(&str, f64); 2] = [("N", 0.8843), ("CA", 0.1157)];

/// Charges that deprotonation of the terminal carboxyl adds to the atoms: C-terminal minus
/// mid-chain alanine, the remainder on CA.
pub const C_TERMINUS: [(&str, f64); 4] = [
    ("C", 0.1758),
    ("O", -0.2376),
    ("OXT", -0.8055),
    ("CA", -0.1327),
];

/// Sum of the charges of the hydrogens on a heavy atom, e; zero for one in no template. Forms that
/// protonation changes count as protonated.
pub(crate) fn hydrogen_charge_e(residue: Option<AminoAcid>, atom: &str) -> f64 {
    let Some(residue) = residue else {
        return 0.0;
    };
    for (name, _, hydrogens) in forms(residue, false).protonated.iter().copied().flatten() {
        if *name == atom {
            return *hydrogens;
        }
    }
    0.0
}

const ALA: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0337, 0.0823),
    ("CB", -0.1825, 0.1809),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const ARG: Template = &[
    ("N", -0.3479, 0.2747),
    ("CA", -0.2637, 0.156),
    ("CB", -0.0007, 0.0654),
    ("CG", 0.039, 0.057),
    ("CD", 0.0486, 0.1374),
    ("NE", -0.5295, 0.3456),
    ("CZ", 0.8076, 0.0),
    ("NH1", -0.8627, 0.8956),
    ("NH2", -0.8627, 0.8956),
    ("C", 0.7341, 0.0),
    ("O", -0.5894, 0.0),
];
const ASN: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0143, 0.1048),
    ("CB", -0.2041, 0.1594),
    ("CG", 0.713, 0.0),
    ("OD1", -0.5931, 0.0),
    ("ND2", -0.9191, 0.8392),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const ASP: Template = &[
    ("N", -0.5163, 0.2936),
    ("CA", 0.0381, 0.088),
    ("CB", -0.0303, -0.0244),
    ("CG", 0.7994, 0.0),
    ("OD1", -0.8014, 0.0),
    ("OD2", -0.8014, 0.0),
    ("C", 0.5366, 0.0),
    ("O", -0.5819, 0.0),
];
const ASH: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0341, 0.0864),
    ("CB", -0.0316, 0.0976),
    ("CG", 0.6462, 0.0),
    ("OD1", -0.5554, 0.0),
    ("OD2", -0.6376, 0.4747),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const CYS: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0213, 0.1124),
    ("CB", -0.1231, 0.2224),
    ("SG", -0.3119, 0.1933),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const CYM: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0351, 0.0508),
    ("CB", -0.2413, 0.2244),
    ("SG", -0.8844, 0.0),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const CYX: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0429, 0.0766),
    ("CB", -0.079, 0.182),
    ("SG", -0.1081, 0.0),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const GLN: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0031, 0.085),
    ("CB", -0.0036, 0.0342),
    ("CG", -0.0645, 0.0704),
    ("CD", 0.6951, 0.0),
    ("OE1", -0.6086, 0.0),
    ("NE2", -0.9407, 0.8502),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const GLU: Template = &[
    ("N", -0.5163, 0.2936),
    ("CA", 0.0397, 0.1105),
    ("CB", 0.056, -0.0346),
    ("CG", 0.0136, -0.085),
    ("CD", 0.8054, 0.0),
    ("OE1", -0.8188, 0.0),
    ("OE2", -0.8188, 0.0),
    ("C", 0.5366, 0.0),
    ("O", -0.5819, 0.0),
];
const GLH: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0145, 0.0779),
    ("CB", -0.0071, 0.0512),
    ("CG", -0.0174, 0.086),
    ("CD", 0.6801, 0.0),
    ("OE1", -0.5838, 0.0),
    ("OE2", -0.6511, 0.4641),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const GLY: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0252, 0.1396),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const HID: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", 0.0188, 0.0881),
    ("CB", -0.0462, 0.0804),
    ("CG", -0.0266, 0.0),
    ("ND1", -0.3811, 0.3649),
    ("CE1", 0.2057, 0.1392),
    ("NE2", -0.5727, 0.0),
    ("CD2", 0.1292, 0.1147),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const HIE: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0581, 0.136),
    ("CB", -0.0074, 0.0734),
    ("CG", 0.1868, 0.0),
    ("ND1", -0.5432, 0.0),
    ("CE1", 0.1635, 0.1435),
    ("NE2", -0.2795, 0.3339),
    ("CD2", -0.2207, 0.1862),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const HIP: Template = &[
    ("N", -0.3479, 0.2747),
    ("CA", -0.1354, 0.1212),
    ("CB", -0.0414, 0.162),
    ("CG", -0.0012, 0.0),
    ("ND1", -0.1513, 0.3866),
    ("CE1", -0.017, 0.2681),
    ("NE2", -0.1718, 0.3911),
    ("CD2", -0.1141, 0.2317),
    ("C", 0.7341, 0.0),
    ("O", -0.5894, 0.0),
];
const ILE: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0597, 0.0869),
    ("CB", 0.1303, 0.0187),
    ("CG2", -0.3204, 0.2646),
    ("CG1", -0.043, 0.0472),
    ("CD1", -0.066, 0.0558),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const LEU: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0518, 0.0922),
    ("CB", -0.1102, 0.0914),
    ("CG", 0.3531, -0.0361),
    ("CD1", -0.4121, 0.3),
    ("CD2", -0.4121, 0.3),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const LYS: Template = &[
    ("N", -0.3479, 0.2747),
    ("CA", -0.24, 0.1426),
    ("CB", -0.0094, 0.0724),
    ("CG", 0.0187, 0.0206),
    ("CD", -0.0479, 0.1242),
    ("CE", -0.0143, 0.227),
    ("NZ", -0.3854, 1.02),
    ("C", 0.7341, 0.0),
    ("O", -0.5894, 0.0),
];
const LYN: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.07206, 0.0994),
    ("CB", -0.04845, 0.068),
    ("CG", 0.06612, 0.02082),
    ("CD", -0.03768, 0.0231),
    ("CE", 0.32604, -0.06716),
    ("NZ", -1.03581, 0.77208),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const MET: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0237, 0.088),
    ("CB", 0.0342, 0.0482),
    ("CG", 0.0018, 0.088),
    ("SD", -0.2737, 0.0),
    ("CE", -0.0536, 0.2052),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const PHE: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0024, 0.0978),
    ("CB", -0.0343, 0.059),
    ("CG", 0.0118, 0.0),
    ("CD1", -0.1256, 0.133),
    ("CE1", -0.1704, 0.143),
    ("CZ", -0.1072, 0.1297),
    ("CE2", -0.1704, 0.143),
    ("CD2", -0.1256, 0.133),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const PRO: Template = &[
    ("N", -0.2548, 0.0),
    ("CD", 0.0192, 0.0782),
    ("CG", 0.0189, 0.0426),
    ("CB", -0.007, 0.0506),
    ("CA", -0.0266, 0.0641),
    ("C", 0.5896, 0.0),
    ("O", -0.5748, 0.0),
];
const SER: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0249, 0.0843),
    ("CB", 0.2117, 0.0704),
    ("OG", -0.6546, 0.4275),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const THR: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0389, 0.1007),
    ("CB", 0.3654, 0.0043),
    ("CG2", -0.2438, 0.1926),
    ("OG1", -0.6761, 0.4102),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const TRP: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0275, 0.1123),
    ("CB", -0.005, 0.0678),
    ("CG", -0.1415, 0.0),
    ("CD1", -0.1638, 0.2062),
    ("NE1", -0.3418, 0.3412),
    ("CE2", 0.138, 0.0),
    ("CZ2", -0.2601, 0.1572),
    ("CH2", -0.1134, 0.1417),
    ("CZ3", -0.1972, 0.1447),
    ("CE3", -0.2387, 0.17),
    ("CD2", 0.1243, 0.0),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const TYR: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0014, 0.0876),
    ("CB", -0.0152, 0.059),
    ("CG", -0.0011, 0.0),
    ("CD1", -0.1906, 0.1699),
    ("CE1", -0.2341, 0.1656),
    ("CZ", 0.3226, 0.0),
    ("OH", -0.5579, 0.3992),
    ("CE2", -0.2341, 0.1656),
    ("CD2", -0.1906, 0.1699),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];
const VAL: Template = &[
    ("N", -0.4157, 0.2719),
    ("CA", -0.0875, 0.0969),
    ("CB", 0.2985, -0.0297),
    ("CG1", -0.3192, 0.2373),
    ("CG2", -0.3192, 0.2373),
    ("C", 0.5973, 0.0),
    ("O", -0.5679, 0.0),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn charge(template: Template) -> f64 {
        template
            .iter()
            .map(|(_, own, hydrogens)| own + hydrogens)
            .sum()
    }

    #[test]
    fn every_template_sums_to_its_integer_charge() {
        for residue in AminoAcid::all() {
            for in_disulfide in [false, true] {
                let forms = forms(residue, in_disulfide);
                let protonated = match residue {
                    AminoAcid::Arg | AminoAcid::His | AminoAcid::Lys => 1.0,
                    _ => 0.0,
                };
                for template in forms.protonated {
                    assert!(
                        (charge(template) - protonated).abs() < 1e-6,
                        "{residue:?} {}",
                        charge(template)
                    );
                }
                for template in forms.deprotonated {
                    assert!(
                        (charge(template) - protonated + 1.0).abs() < 1e-6,
                        "{residue:?} {}",
                        charge(template)
                    );
                }
            }
        }
        assert!((N_TERMINUS.iter().map(|(_, q)| q).sum::<f64>() - 1.0).abs() < 1e-9);
        assert!((C_TERMINUS.iter().map(|(_, q)| q).sum::<f64>() + 1.0).abs() < 1e-9);
    }

    #[test]
    fn templates_hold_the_heavy_atoms_of_their_residue() {
        use crate::chemistry::amino_acid::BACKBONE;
        for residue in AminoAcid::all() {
            let forms = forms(residue, false);
            for template in forms.protonated.iter().chain(forms.deprotonated) {
                let mut names: Vec<_> = template.iter().map(|atom| atom.0).collect();
                let mut expected: Vec<_> = BACKBONE
                    .iter()
                    .chain(residue.side_chain())
                    .copied()
                    .collect();
                names.sort_unstable();
                expected.sort_unstable();
                assert_eq!(names, expected, "{residue:?}");
            }
        }
    }
}
