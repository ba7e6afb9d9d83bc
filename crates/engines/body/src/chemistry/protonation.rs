//! Titratable groups: model pKa values and the Henderson-Hasselbalch equation.
//!
//! Model pKa values of PROPKA 3 (Olsson, Søndergaard, Rostkowski and Jensen, J. Chem. Theory
//! Comput. 7, 525 (2011)), for a residue in water. Shifts caused by the environment are not
//! modelled here: [`Protonate`] is the interface of a crate that computes them.

use super::amino_acid::AminoAcid;
use super::titration::BodyTitration;
use crate::structure::Selection;
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};

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
    ///
    /// ```
    /// use protomer_body::chemistry::protonation::Group;
    /// let carboxylate = Group::acid(4.0, &["OD1", "OD2"]);
    /// assert!((carboxylate.charge_e(5.0) + 10.0 / 11.0).abs() < 1e-12);
    /// ```
    pub const fn acid(pka: f64, atoms: &'static [&'static str]) -> Self {
        Self {
            pka,
            protonated_charge_e: 0.0,
            atoms,
        }
    }

    /// A group that is positive when protonated.
    ///
    /// ```
    /// use protomer_body::chemistry::protonation::Group;
    /// let amine = Group::base(10.0, &["NZ"]);
    /// assert!((amine.charge_e(9.0) - 10.0 / 11.0).abs() < 1e-12);
    /// ```
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
        self.mean_charge_e(protonated_fraction(self.pka, ph))
    }

    /// The mean charge of a group with its proton for this fraction of the time, e.
    ///
    /// ```
    /// use protomer_body::chemistry::protonation::{C_TERMINUS, N_TERMINUS};
    /// assert_eq!((N_TERMINUS.mean_charge_e(0.25), C_TERMINUS.mean_charge_e(0.25)), (0.25, -0.75));
    /// ```
    pub fn mean_charge_e(&self, protonated: f64) -> f64 {
        self.protonated_charge_e - (1.0 - protonated)
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

/// Protonated fractions of the groups of a residue, 0 to 1, and what they change by.
///
/// ```
/// use protomer_body::chemistry::ResidueProtonation;
/// use protomer_body::chemistry::protonation::{C_TERMINUS, N_TERMINUS};
/// let ends = ResidueProtonation::in_water(&[], 8.0);
/// assert_eq!((ends.side.len(), ends.n_terminus), (0, 0.5));
/// let charge = N_TERMINUS.mean_charge_e(ends.n_terminus) + C_TERMINUS.mean_charge_e(ends.c_terminus);
/// assert!((charge + 0.5).abs() < 1e-4);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ResidueProtonation {
    /// Groups of the side chain, in the order of [`side_groups`](super::charges::side_groups).
    pub side: Vec<f64>,
    /// Amine at the beginning of a chain.
    pub n_terminus: f64,
    /// Carboxylate at the end of a chain.
    pub c_terminus: f64,
    /// Capacitance of each group: the fall of its mean charge per kT/e of a potential that all groups
    /// feel, e². Side chain, then N-terminus, then C-terminus; empty where it is not known.
    pub capacitance_e2: Vec<f64>,
}

impl ResidueProtonation {
    /// Fractions by model pKa values, those of each group alone in water.
    ///
    /// ```
    /// use protomer_body::chemistry::ResidueProtonation;
    /// use protomer_body::chemistry::protonation::Group;
    /// let histidine = [Group::base(6.5, &["ND1", "NE2"])];
    /// let protonation = ResidueProtonation::in_water(&histidine, 7.5);
    /// assert!((protonation.side[0] - 1.0 / 11.0).abs() < 1e-12);
    /// ```
    pub fn in_water(side_groups: &[Group], ph: f64) -> Self {
        let fraction = |group: &Group| protonated_fraction(group.pka, ph);
        Self {
            side: side_groups.iter().map(fraction).collect(),
            n_terminus: fraction(&N_TERMINUS),
            c_terminus: fraction(&C_TERMINUS),
            capacitance_e2: Vec::new(),
        }
    }
}

protomer_kernel::choices! {
    /// Source of the pKa values of the groups of a structure.
    pub enum PkaSource, default Water {
        /// Single residues in water.
        Water = "water",
        /// The Poisson-Boltzmann equation of the structure, as `titrate`.
        Structure = "structure",
    }
}

/// Model of a protonation that is computed from the structure, in any salt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructureTitration {
    /// Constant of the binding of the salt's anion to a positive group in water, L/mol; zero for none.
    #[serde(rename = "anion_binding_per_M")]
    pub anion_binding_per_molar: f64,
}

impl StructureTitration {
    /// The protonation in a salt (mol/L) at a temperature (K).
    ///
    /// ```
    /// use protomer_body::chemistry::StructureTitration;
    /// let titration = StructureTitration { anion_binding_per_molar: 2.0 };
    /// let conditions = titration.conditions(0.15, 298.15);
    /// assert_eq!((conditions.salt_molar, conditions.anion_binding_per_molar), (0.15, 2.0));
    /// ```
    pub fn conditions(self, salt_molar: f64, temperature_kelvin: f64) -> StructureProtonation {
        StructureProtonation {
            salt_molar,
            temperature_kelvin,
            anion_binding_per_molar: self.anion_binding_per_molar,
        }
    }
}

/// Conditions of a protonation that is computed from the structure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructureProtonation {
    /// Concentration of a 1:1 salt, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Constant of the binding of the salt's anion to a positive group in water, L/mol; zero for none.
    #[serde(rename = "anion_binding_per_M")]
    pub anion_binding_per_molar: f64,
}

/// Protonation of a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Protonated {
    /// Protonated fractions of every residue.
    pub residues: Vec<ResidueProtonation>,
    /// The groups and the energies of their states, with changes of the charges of the force field.
    pub titration: BodyTitration,
    /// Changes of charge of each group in the formal model, by index of the atom, e.
    pub formal_changes_e: Vec<Vec<(u32, f64)>>,
}

/// Computation of the protonation of a structure, for crates that solve for potentials.
pub trait Protonate {
    /// Protonated fractions of every residue of a selection, and its titratable groups.
    ///
    /// # Errors
    /// Says what cannot be computed, and what to do.
    fn protonate(
        &self,
        selection: &Selection,
        ph: f64,
        conditions: &StructureProtonation,
    ) -> Result<Protonated>;
}

/// Protonation by model pKa values only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelValuesOnly;

impl Protonate for ModelValuesOnly {
    fn protonate(
        &self,
        _selection: &Selection,
        _ph: f64,
        _conditions: &StructureProtonation,
    ) -> Result<Protonated> {
        Err(BodyError::Invalid {
            cause: "a protonation that depends on the structure".into(),
            remedy: "use pKa values in water here".into(),
        })
    }
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
