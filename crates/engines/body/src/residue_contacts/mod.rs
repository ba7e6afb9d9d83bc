//! Short-ranged attraction between residues, by published scales.
//!
//! Two residues are beads at the centres of their heavy atoms. The attraction is that part of a
//! Lennard-Jones potential that is left when its repulsion is taken away (Weeks, Chandler and
//! Andersen, J. Chem. Phys. 54, 5237 (1971)):
//!
//! ```text
//! u_ij(r) = -d_ij                                 r < 2^(1/6) σ_ij
//! u_ij(r) = 4 d_ij ((σ_ij/r)¹² - (σ_ij/r)⁶)       beyond
//! ```
//!
//! Residues repel each other by the hard surfaces of their bodies. Both published forms are this
//! attraction, each with its own core:
//!
//! | scale | depth d_ij | core |
//! |---|---|---|
//! | Ashbaugh-Hatch, Calvados 3 | ε (λ_i + λ_j)/2 | ε for all pairs |
//! | Kim-Hummer | -λ (e_ij - e_0); negative depths repel | \|d_ij\| |

mod beads;
mod miyazawa_jernigan;

pub use beads::{Bead, beads_of};

use crate::chemistry::AminoAcid;
use miyazawa_jernigan::contact_energy_rt;

protomer_kernel::choices! {
    /// A published scale of contact energies: Ashbaugh and Hatch, J. Am. Chem. Soc. 130, 9536 (2008), with the
    /// stickiness of Cao, von Bülow, Tesei and Lindorff-Larsen, Protein Sci. 33, e5172 (2024), and model A of Kim and
    /// Hummer, J. Mol. Biol. 375, 1416 (2008).
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid::{Lys, Trp};
    /// use protomer_body::residue_contacts::ContactScale;
    /// let scale = ContactScale::Calvados3;
    /// assert!(scale.depth_kj_per_mol(Trp, Trp) > scale.depth_kj_per_mol(Lys, Lys));
    /// ```
    pub enum ContactScale {
        /// Ashbaugh-Hatch with the stickiness of Calvados 3.
        Calvados3 = "calvados3",
        /// Kim-Hummer with the contact energies of Miyazawa and Jernigan.
        KimHummer = "kim-hummer",
    }
}

/// Distance at which the attraction ends in both force fields, Å; it is shifted to zero there.
pub const CONTACT_CUTOFF_ANGSTROM: f64 = 20.0;

/// ε of Calvados, 0.2 kcal/mol.
const CALVADOS_EPSILON_KJ_PER_MOL: f64 = 0.8368;
/// λ of model A.
const KIM_HUMMER_SCALING: f64 = 0.159;
/// e_0 of model A, in units of RT.
const KIM_HUMMER_OFFSET_RT: f64 = -2.27;
/// RT at 300 K, where the energies of Kim and Hummer are stated.
const RT_AT_300_KELVIN_KJ_PER_MOL: f64 = 2.494_338_785;

impl ContactScale {
    /// Depth d_ij of the attraction of two residues, kJ/mol; negative where they repel.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid::{Glu, Phe};
    /// use protomer_body::residue_contacts::ContactScale::Calvados3;
    /// // 0.2 kcal/mol times the stickiness 0.8906 of phenylalanine
    /// assert!((Calvados3.depth_kj_per_mol(Phe, Phe) - 0.745).abs() < 1e-3);
    /// assert!(Calvados3.depth_kj_per_mol(Glu, Glu) < 0.001);
    /// ```
    pub fn depth_kj_per_mol(self, first: AminoAcid, second: AminoAcid) -> f64 {
        match self {
            Self::Calvados3 => {
                let stickiness = 0.5 * (calvados(first).0 + calvados(second).0);
                CALVADOS_EPSILON_KJ_PER_MOL * stickiness
            }
            Self::KimHummer => {
                let energy = contact_energy_rt(first, second) - KIM_HUMMER_OFFSET_RT;
                -KIM_HUMMER_SCALING * energy * RT_AT_300_KELVIN_KJ_PER_MOL
            }
        }
    }

    /// The strength of the core that the published force field gives the beads, kJ/mol.
    pub fn core_kj_per_mol(self, first: AminoAcid, second: AminoAcid) -> f64 {
        match self {
            Self::Calvados3 => CALVADOS_EPSILON_KJ_PER_MOL,
            Self::KimHummer => self.depth_kj_per_mol(first, second).abs(),
        }
    }

    /// σ_ij, the mean of the two diameters, Å. Both force fields share them but for rounding.
    ///
    /// ```
    /// use protomer_body::chemistry::AminoAcid::{Ala, Gly};
    /// use protomer_body::residue_contacts::ContactScale::Calvados3;
    /// assert!((Calvados3.diameter_angstrom(Gly, Ala) - 0.5 * (4.50 + 5.04)).abs() < 1e-12);
    /// ```
    pub fn diameter_angstrom(self, first: AminoAcid, second: AminoAcid) -> f64 {
        let diameter = |amino_acid| match self {
            Self::Calvados3 => calvados(amino_acid).1,
            Self::KimHummer => kim_hummer_diameter_angstrom(amino_acid),
        };
        0.5 * (diameter(first) + diameter(second))
    }
}

/// Stickiness λ and diameter σ (Å) of Calvados 3; the diameters are those of Kim and Hummer.
fn calvados(amino_acid: AminoAcid) -> (f64, f64) {
    match amino_acid {
        AminoAcid::Ala => (0.337_724_436_203_162_7, 5.04),
        AminoAcid::Arg => (0.740_790_276_483_995_9, 6.56),
        AminoAcid::Asn => (0.370_696_216_369_040_2, 5.68),
        AminoAcid::Asp => (0.092_587_557_536_158, 5.58),
        AminoAcid::Cys => (0.592_252_908_460_132_2, 5.48),
        AminoAcid::Gln => (0.314_344_979_166_913_3, 6.02),
        AminoAcid::Glu => (0.000_249_590_539_426, 5.92),
        AminoAcid::Gly => (0.753_830_811_519_738_6, 4.50),
        AminoAcid::His => (0.408_717_621_652_547_6, 6.08),
        AminoAcid::Ile => (0.513_039_887_442_570_8, 6.18),
        AminoAcid::Leu => (0.554_861_531_299_387_5, 6.18),
        AminoAcid::Lys => (0.138_060_254_203_926_7, 6.36),
        AminoAcid::Met => (0.517_087_416_039_854_3, 6.18),
        AminoAcid::Phe => (0.890_644_935_549_986_6, 6.36),
        AminoAcid::Pro => (0.346_977_752_351_937_2, 5.56),
        AminoAcid::Ser => (0.447_314_257_269_317_6, 5.18),
        AminoAcid::Thr => (0.267_238_793_654_414_6, 5.62),
        AminoAcid::Trp => (1.033_450_123_574_512, 6.78),
        AminoAcid::Tyr => (0.950_628_687_301_107, 6.46),
        AminoAcid::Val => (0.293_617_421_177_138_3, 5.86),
    }
}

/// Diameters of Kim and Hummer, table 5, Å.
fn kim_hummer_diameter_angstrom(amino_acid: AminoAcid) -> f64 {
    match amino_acid {
        AminoAcid::Ala => 5.0,
        AminoAcid::Arg => 6.6,
        AminoAcid::Asn => 5.7,
        AminoAcid::Asp | AminoAcid::Pro | AminoAcid::Thr => 5.6,
        AminoAcid::Cys => 5.5,
        AminoAcid::Gln => 6.0,
        AminoAcid::Glu | AminoAcid::Val => 5.9,
        AminoAcid::Gly => 4.5,
        AminoAcid::His => 6.1,
        AminoAcid::Ile | AminoAcid::Leu | AminoAcid::Met => 6.2,
        AminoAcid::Lys | AminoAcid::Phe => 6.4,
        AminoAcid::Ser => 5.2,
        AminoAcid::Trp => 6.8,
        AminoAcid::Tyr => 6.5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use AminoAcid::{Ala, Arg, Asp, Glu, Leu, Lys, Phe, Trp};

    #[test]
    fn both_scales_give_published_values() {
        // Kim-Hummer: 0.159 (e_ij + 2.27), with e_LeuLeu = -7.37, e_LysLys = -0.12,
        // e_ArgAsp = -2.29, in units of RT at 300 K.
        let rt = RT_AT_300_KELVIN_KJ_PER_MOL;
        for (a, b, depth) in [
            (Leu, Leu, 0.8109),
            (Lys, Lys, -0.34185),
            (Arg, Asp, 0.00318),
        ] {
            let found = ContactScale::KimHummer.depth_kj_per_mol(a, b) / rt;
            assert!((found - depth).abs() < 1e-9, "{a:?} {b:?} {found}");
            let other = ContactScale::KimHummer.depth_kj_per_mol(b, a) / rt;
            assert_eq!(found, other);
        }
        let both = ContactScale::Calvados3.depth_kj_per_mol(Phe, Glu);
        assert!((both - 0.8368 * 0.5 * (0.890_644_935_55 + 0.000_249_590_54)).abs() < 1e-9);
        assert_eq!(ContactScale::Calvados3.diameter_angstrom(Ala, Trp), 5.91);
        assert_eq!(ContactScale::KimHummer.diameter_angstrom(Ala, Trp), 5.9);
    }

    #[test]
    fn sums_over_all_pairs_guard_the_tables() {
        let mut sums = [0.0; 3];
        for first in AminoAcid::all() {
            for second in AminoAcid::all() {
                sums[0] += contact_energy_rt(first, second);
                sums[1] += ContactScale::Calvados3.depth_kj_per_mol(first, second);
                sums[2] += ContactScale::KimHummer.diameter_angstrom(first, second);
            }
        }
        // Σ e_ij, 20 ε Σ λ_i and 20 Σ σ_i, added up elsewhere.
        for (sum, expected) in sums.into_iter().zip([-1266.4, 160.065_036_301_66, 2358.0]) {
            assert!((sum - expected).abs() < 1e-6, "{sum} {expected}");
        }
    }
}
