//! Titratable groups: model pKa values and the Henderson-Hasselbalch equation.
//!
//! Model pKa values of PROPKA 3 (Olsson, Søndergaard, Rostkowski and Jensen, J. Chem. Theory
//! Comput. 7, 525 (2011)), for a residue in water. Shifts caused by the environment are not
//! modelled.

use super::amino_acid::AminoAcid;

/// One titratable group.
///
/// ```
/// use protomer_body::chemistry::protonation::Group;
/// let carboxylate = Group::acid(4.5, &["OE1", "OE2"]);
/// assert!((carboxylate.charge_e(4.5) + 0.5).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Group {
    /// pKa of the group.
    pub pka: f64,
    /// Charge of the protonated form, e: 0 for an acid, 1 for a base.
    pub protonated_charge_e: f64,
    /// Atoms that carry the charge in the formal model, in equal parts.
    pub atoms: &'static [&'static str],
}

impl Group {
    /// A group that is neutral when protonated.
    pub const fn acid(pka: f64, atoms: &'static [&'static str]) -> Self {
        Self {
            pka,
            protonated_charge_e: 0.0,
            atoms,
        }
    }

    /// A group that is positive when protonated.
    pub const fn base(pka: f64, atoms: &'static [&'static str]) -> Self {
        Self {
            pka,
            protonated_charge_e: 1.0,
            atoms,
        }
    }

    /// The mean charge at a pH, e: that of the protonated form less the deprotonated fraction.
    ///
    /// ```
    /// use protomer_body::chemistry::protonation::N_TERMINUS;
    /// assert!((N_TERMINUS.charge_e(7.4) - 0.799).abs() < 1e-3);
    /// ```
    pub fn charge_e(&self, ph: f64) -> f64 {
        self.protonated_charge_e - (1.0 - protonated_fraction(self.pka, ph))
    }
}

/// Protonated fraction 1 / (1 + 10^(pH - pKa)) (Henderson-Hasselbalch).
///
/// ```
/// use protomer_body::chemistry::protonation::protonated_fraction;
/// assert_eq!(protonated_fraction(6.5, 6.5), 0.5);
/// ```
pub fn protonated_fraction(pka: f64, ph: f64) -> f64 {
    1.0 / (1.0 + 10_f64.powf(ph - pka))
}

/// The amine at the beginning of a chain.
pub const N_TERMINUS: Group = Group::base(8.0, &["N"]);
/// The carboxylate at the end of a chain.
pub const C_TERMINUS: Group = Group::acid(3.2, &["O", "OXT"]);

const ARGININE: &[Group] = &[Group::base(12.5, &["NH1", "NH2"])];
const ASPARTATE: &[Group] = &[Group::acid(3.8, &["OD1", "OD2"])];
const CYSTEINE: &[Group] = &[Group::acid(9.0, &["SG"])];
const GLUTAMATE: &[Group] = &[Group::acid(4.5, &["OE1", "OE2"])];
const HISTIDINE: &[Group] = &[Group::base(6.5, &["ND1", "NE2"])];
const LYSINE: &[Group] = &[Group::base(10.5, &["NZ"])];
const TYROSINE: &[Group] = &[Group::acid(10.0, &["OH"])];

/// Groups of the side chain; a cysteine's are those of the free thiol.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::chemistry::protonation::side_chain_groups;
/// assert_eq!(side_chain_groups(AminoAcid::Asp)[0].pka, 3.8);
/// assert!(side_chain_groups(AminoAcid::Ala).is_empty());
/// ```
pub fn side_chain_groups(residue: AminoAcid) -> &'static [Group] {
    match residue {
        AminoAcid::Arg => ARGININE,
        AminoAcid::Asp => ASPARTATE,
        AminoAcid::Cys => CYSTEINE,
        AminoAcid::Glu => GLUTAMATE,
        AminoAcid::His => HISTIDINE,
        AminoAcid::Lys => LYSINE,
        AminoAcid::Tyr => TYROSINE,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_its_pka_a_group_is_half_protonated() {
        assert!((LYSINE[0].charge_e(10.5) - 0.5).abs() < 1e-15);
        assert!((GLUTAMATE[0].charge_e(4.5) + 0.5).abs() < 1e-15);
    }

    #[test]
    fn far_from_its_pka_a_group_has_its_integer_charge() {
        for (group, low, high) in [(LYSINE[0], 1.0, 0.0), (GLUTAMATE[0], 0.0, -1.0)] {
            assert!((group.charge_e(-20.0) - low).abs() < 1e-12);
            assert!((group.charge_e(40.0) - high).abs() < 1e-12);
        }
    }
}
