//! The calibrated estimate of the binding free energy against salt and pH.
//!
//! The contacts give ΔG° at 150 mM and the usual pH, where most of the affinities that they are calibrated
//! on were measured. Salt adds the change of the charge part by the Poisson-Boltzmann equation, and pH the
//! change of the screened Coulomb energy of all charges at 150 mM.

use super::input::{Inputs, Partners};
use super::settings::BindingSettings;
use crate::stability::affinity::ContactAffinity;
use anyhow::Result;
use protomer_field::binding::BindingEnergy;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::units::{KILOJOULES_PER_KILOCALORIE, kilojoule_per_mol_per_kt};

/// Salt at which the contacts alone give the estimate, mol/L.
const REFERENCE_SALT_MOLAR: f64 = 0.15;

/// The estimate at one pH.
pub(super) struct Estimate {
    contacts: ContactAffinity,
    /// Change of the energy with pH from the usual one, kT.
    ph_effect_kt: f64,
    /// Effect of the reference salt, from the first salt, kT.
    reference_effect_kt: f64,
    kcal_per_mol_per_kt: f64,
}

/// The concentrations to solve for: those requested, then the reference where it is not among them.
pub(super) fn salts_to_solve(settings: &BindingSettings) -> Vec<f64> {
    let mut salts = settings.salt_molar.clone();
    if !salts.iter().copied().any(is_reference) {
        salts.push(REFERENCE_SALT_MOLAR);
    }
    salts
}

fn is_reference(salt_molar: f64) -> bool {
    (salt_molar - REFERENCE_SALT_MOLAR).abs() < 1e-9
}

impl Estimate {
    /// # Errors
    /// If the bodies at the usual pH cannot be made.
    pub fn new(
        inputs: &Inputs,
        partners: &Partners,
        contacts: ContactAffinity,
        ph: Option<f64>,
        settings: &BindingSettings,
        energy: &BindingEnergy,
    ) -> Result<Self> {
        let salts = salts_to_solve(settings);
        let reference = salts.iter().copied().position(is_reference);
        let reference_energy = reference.and_then(|index| energy.at_salts.get(index));
        Ok(Self {
            contacts,
            ph_effect_kt: ph_effect_kt(inputs, partners, ph, settings)?,
            reference_effect_kt: reference_energy
                .map_or(0.0, |salt_energy| salt_energy.salt_effect_kt),
            kcal_per_mol_per_kt: kilojoule_per_mol_per_kt(settings.temperature_kelvin)
                / KILOJOULES_PER_KILOCALORIE,
        })
    }

    /// ΔG° at 1 M, kcal/mol, for the effect of a salt from the first one, kT.
    pub fn delta_g_kcal_per_mol(&self, salt_effect_kt: f64) -> f64 {
        let change_kt = salt_effect_kt - self.reference_effect_kt + self.ph_effect_kt;
        self.contacts.delta_g_kcal_per_mol() + self.kcal_per_mol_per_kt * change_kt
    }
}

/// Change of the screened Coulomb energy at the reference salt from the usual pH to `ph`, kT.
fn ph_effect_kt(
    inputs: &Inputs,
    partners: &Partners,
    ph: Option<f64>,
    settings: &BindingSettings,
) -> Result<f64> {
    let usual = inputs.usual_ph();
    if ph.is_none_or(|ph| ph == usual) {
        return Ok(0.0);
    }
    let medium = settings.medium().interaction(Some(REFERENCE_SALT_MOLAR))?;
    let yukawa = medium.yukawa()?;
    let at_usual = inputs.partners(Some(usual))?;
    Ok(coulomb_kt(partners, &yukawa) - coulomb_kt(&at_usual, &yukawa))
}

/// Screened Coulomb energy between the charges of two bodies, kT.
fn coulomb_kt(partners: &Partners, yukawa: &Yukawa) -> f64 {
    let [first, second] = partners.spheres();
    let mut sum = 0.0;
    for a in first.iter().filter(|a| a.charge_e != 0.0) {
        for b in second.iter().filter(|b| b.charge_e != 0.0) {
            let distance = (a.centre - b.centre).norm();
            sum += a.charge_e * b.charge_e * yukawa.energy_kt(distance);
        }
    }
    sum
}
