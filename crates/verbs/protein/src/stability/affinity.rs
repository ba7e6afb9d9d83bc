//! A calibrated estimate of the standard binding free energy of a complex, from the contacts of its
//! residues.
//!
//! ```text
//! ΔG° = G + Σ s(d_ij) (-ε (λ_i + λ_j)/2 + p π_i π_j)
//! ```
//!
//! The sum is over pairs of residues of the two bodies. d is the distance of their closest heavy atoms;
//! s falls from 1 at 5 Å to 0 at 6 Å. ε and λ are those of Calvados 3, as published, at strength 1. π is 1
//! for uncharged polar residues (Asn, Gln, His, Ser, Thr): a pair of them gives up more hydration than it
//! gains. G and p are the two numbers that were fitted, to the 45 complexes of
//! `docs/validation/natural-complexes.md`; G holds what all complexes share, among it the loss of
//! translation and rotation.
//!
//! The estimate is a regression, not an integral over poses: it knows nothing of the shape of the well.

use protomer_body::Residue;
use protomer_body::chemistry::AminoAcid;
use protomer_body::chemistry::residue_names::parent_amino_acid;
use protomer_body::residue_contacts::ContactScale;
use protomer_common::answer::counted;
use protomer_kernel::units::KILOJOULES_PER_KILOCALORIE;
use serde::Serialize;
use std::collections::BTreeMap;

/// Residues farther apart than this are not in contact, Å.
pub const FARTHEST_CONTACT_ANGSTROM: f64 = 6.0;
/// Residues nearer than this are fully in contact, Å.
const FULL_CONTACT_ANGSTROM: f64 = 5.0;
/// Constant G, kcal/mol, fitted.
const CONSTANT_KCAL_PER_MOL: f64 = -5.01;
/// Energy p of a pair of polar residues, kcal/mol, fitted.
const POLAR_PAIR_KCAL_PER_MOL: f64 = 0.251;
/// Error of an estimate, kcal/mol: root mean square over the complexes of the fit, each left out of the
/// fit for its own estimate.
pub const ERROR_KCAL_PER_MOL: f64 = 1.63;
/// Contacts of the complexes of the fit, from the fewest to the most.
const CALIBRATED_CONTACTS: [f64; 2] = [29.0, 124.0];

/// The contacts between the residues of two bodies, as the estimate counts them.
///
/// ```
/// use protomer_protein_verbs::stability::affinity::ContactAffinity;
/// let affinity = ContactAffinity {
///     contacts: 60.0,
///     polar_contacts: 4.0,
///     attraction_kcal_per_mol: -5.0,
/// };
/// assert!((affinity.delta_g_kcal_per_mol() - (-5.01 - 5.0 + 4.0 * 0.251)).abs() < 1e-12);
/// assert_eq!(affinity.warning(), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ContactAffinity {
    /// Sum of s over all pairs of amino acids.
    pub contacts: f64,
    /// Sum of s over the pairs of polar residues.
    pub polar_contacts: f64,
    /// Attraction of the scale, kcal/mol.
    pub attraction_kcal_per_mol: f64,
}

impl ContactAffinity {
    /// The contacts between the residues of two bodies; `nearest_angstrom` has the distance of the closest heavy atoms of pairs
    /// of residues, at least of all those in contact.
    pub fn new(residues: [&[Residue]; 2], nearest_angstrom: &BTreeMap<(u32, u32), f64>) -> Self {
        let mut affinity = Self::default();
        for ((first, second), distance_angstrom) in nearest_angstrom {
            let pair = (
                amino_acid(residues[0], *first),
                amino_acid(residues[1], *second),
            );
            if let (Some(first), Some(second)) = pair {
                affinity.add(first, second, share_of_contact(*distance_angstrom));
            }
        }
        affinity
    }

    fn add(&mut self, first: AminoAcid, second: AminoAcid, share: f64) {
        let depth_kj_per_mol = ContactScale::Calvados3.depth_kj_per_mol(first, second);
        self.contacts += share;
        // ε is a depth, positive; an attraction lowers the energy.
        self.attraction_kcal_per_mol -= share * depth_kj_per_mol / KILOJOULES_PER_KILOCALORIE;
        if is_polar(first) && is_polar(second) {
            self.polar_contacts += share;
        }
    }

    /// The standard binding free energy at 1 M, kcal/mol.
    pub fn delta_g_kcal_per_mol(&self) -> f64 {
        CONSTANT_KCAL_PER_MOL
            + self.attraction_kcal_per_mol
            + POLAR_PAIR_KCAL_PER_MOL * self.polar_contacts
    }

    /// The rounded number of contacts, with what it counts.
    pub(super) fn contacts_in_words(&self) -> String {
        let number = self.contacts.round() as usize;
        counted(number, "contact of residues", "contacts of residues")
    }

    /// A warning for an interface that is smaller or larger than all those of the fit.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::affinity::ContactAffinity;
    /// let few = ContactAffinity { contacts: 5.0, ..ContactAffinity::default() };
    /// assert!(few.warning().is_some_and(|warning| warning.contains("5 contacts of residues")));
    /// ```
    pub fn warning(&self) -> Option<String> {
        let [fewest, most] = CALIBRATED_CONTACTS;
        (!(fewest..=most).contains(&self.contacts)).then(|| {
            format!(
                "warning: {}, where the complexes that the affinity is calibrated on have \
                 {fewest:.0} to {most:.0}: the estimate is an extrapolation; do not use it as a number",
                self.contacts_in_words()
            )
        })
    }
}

/// Share s of a contact: 1 up to 5 Å, 0 from 6 Å on.
fn share_of_contact(distance_angstrom: f64) -> f64 {
    let width_angstrom = FARTHEST_CONTACT_ANGSTROM - FULL_CONTACT_ANGSTROM;
    // Linear between both distances, 1 nearer and 0 farther.
    ((FARTHEST_CONTACT_ANGSTROM - distance_angstrom) / width_angstrom).clamp(0.0, 1.0)
}

fn amino_acid(residues: &[Residue], index: u32) -> Option<AminoAcid> {
    parent_amino_acid(&residues[index as usize].name)
}

fn is_polar(amino_acid: AminoAcid) -> bool {
    use AminoAcid::{Asn, Gln, His, Ser, Thr};
    matches!(amino_acid, Asn | Gln | His | Ser | Thr)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn residues(names: &[&str]) -> Vec<Residue> {
        let residue = |name: &&str| Residue {
            chain: "A".into(),
            number: 1,
            insertion_code: String::new(),
            name: (*name).to_owned(),
            charge_e: 0.0,
            hydropathy: None,
        };
        names.iter().map(residue).collect()
    }

    #[test]
    fn contacts_end_between_five_and_six_angstrom() {
        for (distance, share) in [(2.8, 1.0), (5.0, 1.0), (5.25, 0.75), (6.0, 0.0), (9.0, 0.0)] {
            assert!((share_of_contact(distance) - share).abs() < 1e-12);
        }
    }

    /// By hand: Trp-Phe in full contact, Ser-Gln in half contact, a ligand that counts for nothing.
    #[test]
    fn an_interface_of_two_pairs_is_summed_by_hand() {
        let (first, second) = (residues(&["TRP", "SER", "HEM"]), residues(&["PHE", "GLN"]));
        let nearest = BTreeMap::from([((0, 0), 3.5), ((1, 1), 5.5), ((2, 0), 3.0)]);
        let affinity = ContactAffinity::new([&first, &second], &nearest);
        let by_hand = -0.2 * (1.033_450_123_574_512 + 0.890_644_935_549_986_6) / 2.0
            - 0.5 * 0.2 * (0.447_314_257_269_317_6 + 0.314_344_979_166_913_3) / 2.0;
        assert!((affinity.attraction_kcal_per_mol - by_hand).abs() < 1e-12);
        assert_eq!((affinity.contacts, affinity.polar_contacts), (1.5, 0.5));
        let total = CONSTANT_KCAL_PER_MOL + by_hand + 0.5 * POLAR_PAIR_KCAL_PER_MOL;
        assert!((affinity.delta_g_kcal_per_mol() - total).abs() < 1e-12);
        assert!(affinity.warning().is_some());
    }
}
