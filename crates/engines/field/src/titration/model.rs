//! The fitted numbers of the titration model, and the groups that follow from them.
//!
//! Energies come from the Poisson-Boltzmann equation with a permittivity of 20 inside. They shift the
//! pKa of a group by
//!
//! A = a d + b d² + B,
//!
//! with d the desolvation and B the background. Pairs are scaled by c: a rigid crystal structure holds
//! the salt bridges of one of many conformations, and it holds them closed. a, b, c and the pKa values
//! of the model compounds were fitted to the 690 values of docs/validation/measured-pka.md; the factor of
//! the background is 1 (a free fit gives 0.96 to 1.00).

use super::energies::GroupEnergies;
use super::equilibrium::TitratingGroups;
use protomer_body::chemistry::AminoAcid;
use protomer_body::chemistry::titration::{GroupKind, TitratableGroup, TitratableSites};

/// Fitted numbers of the titration model.
///
/// ```
/// use protomer_field::titration::TitrationModel;
/// let model = TitrationModel::default();
/// // Deep desolvation counts more than in proportion.
/// assert!(model.desolvation_kt(4.0) > 2.0 * model.desolvation_kt(2.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TitrationModel {
    /// Relative permittivity inside the protein.
    pub inner_permittivity: f64,
    /// Factor a of the desolvation energy.
    pub desolvation: f64,
    /// Factor b of its square, per kT.
    pub desolvation_squared_per_kt: f64,
    /// Factor of the background.
    pub background: f64,
    /// Factor c of the interaction of two groups.
    pub pair: f64,
    /// Constant of the binding of an anion of the salt to a positive group in water, L/mol; zero for no
    /// binding.
    pub anion_binding_per_molar: f64,
}

impl Default for TitrationModel {
    fn default() -> Self {
        Self {
            inner_permittivity: 20.0,
            desolvation: 0.36,
            desolvation_squared_per_kt: 0.294,
            background: 1.0,
            pair: 0.509,
            anion_binding_per_molar: 0.0,
        }
    }
}

impl TitrationModel {
    /// Desolvation as the model counts it, kT, from the energy of the solver. A negative energy, which a
    /// grid can give for a group in water, has no square.
    ///
    /// ```
    /// use protomer_field::titration::TitrationModel;
    /// let model = TitrationModel::default();
    /// assert!((model.desolvation_kt(2.0) - (0.36 * 2.0 + 0.294 * 4.0)).abs() < 1e-12);
    /// ```
    pub fn desolvation_kt(&self, energy_kt: f64) -> f64 {
        self.desolvation * energy_kt + self.desolvation_squared_per_kt * energy_kt.max(0.0).powi(2)
    }

    /// The titrating groups of a protein in a 1:1 salt of this concentration.
    pub fn groups(
        &self,
        sites: &TitratableSites,
        energies: &GroupEnergies,
        salt_molar: f64,
    ) -> TitratingGroups {
        let mut groups = TitratingGroups {
            model_pka: Vec::new(),
            charge_e: Vec::new(),
            shift_kt: Vec::new(),
            tautomer_kt: Vec::new(),
            pair_kt: energies.pair_kt.clone(),
            tautomer_pair_kt: energies.tautomer_pair_kt.clone(),
            bound_ion_weight: Vec::new(),
            ion_pair_factor: 1.0 / self.pair,
        };
        for (index, group) in sites.groups.iter().enumerate() {
            groups.model_pka.push(model_pka(group));
            groups.charge_e.push(group.charge_e);
            let binding = match group.charge_e > 0.0 {
                true => self.anion_binding_per_molar,
                false => 0.0,
            };
            groups.bound_ion_weight.push(binding * salt_molar);
            let desolvation_kt = self.desolvation_kt(energies.desolvation_kt[index]);
            let background_kt = self.background * energies.background_kt[index];
            groups.shift_kt.push(desolvation_kt + background_kt);
            let tautomer_kt = self.background * energies.tautomer_kt[index];
            let has_tautomers = !group.tautomer_e.is_empty();
            groups
                .tautomer_kt
                .push(has_tautomers.then_some(tautomer_kt));
        }
        for energy in groups
            .pair_kt
            .iter_mut()
            .chain(&mut groups.tautomer_pair_kt)
        {
            *energy *= self.pair;
        }
        groups
    }
}

/// pKa of the model compound of a group. That of arginine is not fitted, as no value has been measured;
/// that of cysteine rests on five values, four of them of catalytic thiolates (in a peptide it is 8.55:
/// Thurlkill, Grimsley, Scholtz and Pace, Protein Sci. 15, 1214 (2006)).
pub fn model_pka(group: &TitratableGroup) -> f64 {
    match group.kind {
        GroupKind::SideChain(AminoAcid::Asp) => 4.06,
        GroupKind::SideChain(AminoAcid::Glu) => 4.45,
        GroupKind::SideChain(AminoAcid::His) => 6.82,
        GroupKind::SideChain(AminoAcid::Lys) => 10.41,
        GroupKind::SideChain(AminoAcid::Tyr) => 10.28,
        GroupKind::SideChain(AminoAcid::Cys) => 7.61,
        GroupKind::NTerminus => 7.81,
        GroupKind::CTerminus => 3.49,
        GroupKind::SideChain(_) | GroupKind::Modified => group.model_pka,
    }
}
