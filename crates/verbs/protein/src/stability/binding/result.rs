//! The charge part of a binding free energy, as JSON has it.

use super::bound_state::{BoundStateSummary, NO_ROOM, Sampled};
use super::estimate::Estimate;
use super::exchanges::{InterfaceCharge, rows};
use super::fast::FastInteraction;
use super::input::{Inputs, Partners};
use super::interface::Interface;
use super::settings::BindingSettings;
use super::uptake::ProtonUptake;
use crate::stability::affinity::{ContactAffinity, ERROR_KCAL_PER_MOL};
use crate::stability::model::OWN_TERMS;
use crate::stability::residues::{Change, ResidueName};
use anyhow::Result;
use protomer_field::binding::BindingEnergy;
use protomer_field::{Grid, IonModel};
use protomer_results::Execution;
use serde::Serialize;
use std::collections::BTreeMap;

/// A salt effect is not resolved if its error is larger than this, kT, and than `RESOLVED_PART` of
/// it.
const RESOLVED_KT: f64 = 0.3;
/// Error of a salt effect, as a part of the effect, beyond which the effect is not resolved if the
/// error exceeds `RESOLVED_KT`, too.
const RESOLVED_PART: f64 = 0.3;

/// The charge part of the binding free energy of a complex.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Binding {
    /// Name of the model of the fast interaction, or `own terms`.
    pub model: &'static str,
    /// The two bodies.
    pub bodies: Vec<BoundBody>,
    /// Whether the hard bodies overlap.
    pub overlaps: bool,
    /// Pairs of residues with heavy atoms within 4.5 Å.
    pub native_contacts: usize,
    /// Distance of the closest heavy atoms, Å.
    pub closest_angstrom: f64,
    /// Contacts that the calibrated estimate of the affinity rests on.
    pub affinity: ContactAffinity,
    /// Slope d ln K / d ln c of the association constant with the salt concentration at the first pH,
    /// from the charge part alone; null with a single salt.
    pub d_ln_k_d_ln_salt: Option<f64>,
    /// Expected error of the slope from the grids.
    pub d_ln_k_d_ln_salt_error: Option<f64>,
    /// Results at each pH with each salt.
    pub conditions: Vec<BindingCondition>,
    /// The bound state at each pH and the first salt.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bound_states: Vec<BoundStateSummary>,
    /// Slope at each pH.
    pub slopes: Vec<SlopeAtPh>,
    /// Exchanges of charge at the interface, at the first salt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exchanges: Option<Vec<ExchangeRow>>,
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Relative permittivity inside the bodies.
    pub inner_permittivity: f64,
    /// Distance of the centres of ions from the atoms, Å.
    pub ion_radius_angstrom: f64,
    /// Response of the ions to the potential.
    pub ions: IonModel,
    /// The fine grid.
    pub grid: Option<Grid>,
    /// Warnings about the results.
    pub warnings: Vec<String>,
}

/// One of the two bodies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BoundBody {
    /// Name of the body.
    pub name: String,
    /// File of the body.
    pub file: String,
    /// Names of the chains of the body.
    pub chains: Vec<String>,
    /// Number of atoms.
    pub atoms: usize,
    /// Number of residues.
    pub residues: usize,
    /// Net charge at the first pH, e.
    pub net_charge_e: f64,
}

/// The complex at one salt and pH.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BindingCondition {
    /// Salt concentration, mol/L.
    pub salt_molar: f64,
    /// pH; null where the files have their own charges.
    pub ph: Option<f64>,
    /// Charge part of the binding free energy by the Poisson-Boltzmann equation, kT: at the first salt
    /// from the fine grid, at the others with the extrapolated effect of the salt.
    pub poisson_boltzmann_kt: f64,
    /// Expected error of `poisson_boltzmann_kt` from the grids, kT.
    pub error_kt: f64,
    /// Difference of `poisson_boltzmann_kt` from that at the first salt, kT.
    pub salt_effect_kt: f64,
    /// Expected error of `salt_effect_kt` from the grids, kT.
    pub salt_effect_error_kt: f64,
    /// Calibrated estimate of the standard binding free energy at 1 M, kcal/mol.
    pub delta_g_kcal_per_mol: f64,
    /// Error of `delta_g_kcal_per_mol` in the calibration, kcal/mol.
    pub delta_g_error_kcal_per_mol: f64,
    /// log₁₀ of the dissociation constant in mol/L that the energies of the model give by integration over the
    /// poses around the given one; null if it was not requested, or nothing has room there.
    pub log10_kd_molar: Option<f64>,
    /// Standard error of log10_kd_molar.
    pub log10_kd_error: Option<f64>,
    /// Energy of the fast interaction for the same pose, kT.
    pub energy_kt: f64,
    /// Energy of the fast interaction by terms, kT.
    pub terms_kt: BTreeMap<&'static str, f64>,
    /// Protons that the bodies take up on binding, d log₁₀ K_D / d pH, by titrations of the complex and of
    /// each body; only if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub protons_taken_up: Option<f64>,
}

/// Slope d ln K / d ln c at one pH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlopeAtPh {
    /// pH; null where the files have their own charges.
    pub ph: Option<f64>,
    /// d ln K / d ln c of the association constant; null with a single salt.
    pub d_ln_k_d_ln_salt: Option<f64>,
    /// Expected error of the slope from the grids.
    pub d_ln_k_d_ln_salt_error: Option<f64>,
}

/// Effect of one exchange of charge.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExchangeRow {
    /// pH.
    pub ph: Option<f64>,
    /// Name of the residue.
    #[serde(flatten)]
    pub name: ResidueName,
    /// Name of the exchange, such as `A:K15E`.
    pub mutation: String,
    /// Kind of the exchange.
    pub change: Change,
    /// Change of the charge of the residue, e.
    pub charge_change_e: f64,
    /// Change of the charge part of the binding free energy, kT; positive where it weakens the complex.
    pub energy_change_kt: f64,
    /// Part of the energy change that is linear in the change of charge, kT.
    pub first_order_kt: f64,
    /// Part of the energy change that is quadratic in the change of charge, kT: what the charge
    /// itself loses by the solvent that the partner displaces.
    pub second_order_kt: f64,
}

impl Binding {
    pub(super) fn new(settings: &BindingSettings, inputs: &Inputs) -> Self {
        Self {
            model: OWN_TERMS,
            bodies: Vec::new(),
            overlaps: false,
            native_contacts: 0,
            closest_angstrom: f64::NAN,
            affinity: ContactAffinity::default(),
            d_ln_k_d_ln_salt: None,
            d_ln_k_d_ln_salt_error: None,
            conditions: Vec::new(),
            bound_states: Vec::new(),
            slopes: Vec::new(),
            exchanges: settings.exchanges.then(Vec::new),
            temperature_kelvin: settings.temperature_kelvin,
            inner_permittivity: settings.inner_permittivity,
            ion_radius_angstrom: settings.ion_radius_angstrom,
            ions: settings.ions,
            grid: None,
            warnings: inputs.warnings.clone(),
        }
    }

    /// Adds what does not depend on the conditions.
    pub(super) fn describe(
        &mut self,
        partners: &Partners,
        interface: &Interface,
        fast: &FastInteraction,
    ) -> Result<()> {
        for (body, file) in partners.bodies.iter().zip(&partners.files) {
            let mut chains: Vec<String> = Vec::new();
            for residue in &body.residues {
                if !chains.contains(&residue.chain) {
                    chains.push(residue.chain.clone());
                }
            }
            self.bodies.push(BoundBody {
                name: body.name.clone(),
                file: file.clone(),
                chains,
                atoms: body.sites.len(),
                residues: body.residues.len(),
                net_charge_e: body.net_charge_e(),
            });
        }
        self.model = fast.model_name();
        self.overlaps = fast.overlaps()?;
        self.native_contacts = interface.contacts();
        self.closest_angstrom = interface.closest_angstrom;
        self.affinity = interface.affinity(partners);
        self.warnings.extend(interface.warnings.iter().cloned());
        self.warnings.extend(self.affinity.warning());
        Ok(())
    }

    /// Adds the energies at one pH.
    pub(super) fn add(
        &mut self,
        ph: Option<f64>,
        settings: &BindingSettings,
        energy: &BindingEnergy,
        fast: &FastInteraction,
        estimate: &Estimate,
        execution: &Execution,
    ) -> Result<()> {
        let medium = settings.medium();
        let before = self.conditions.len();
        let mut sampled: Option<Sampled> = None;
        for (number, energies) in energy
            .at_salts
            .iter()
            .take(settings.salt_molar.len())
            .enumerate()
        {
            let salt_molar = &settings.salt_molar[number];
            let in_medium = fast.in_medium(&medium.interaction(Some(*salt_molar))?)?;
            let of_pose = in_medium.energy()?;
            if number == 0 && settings.integrates {
                sampled = Sampled::new(&in_medium, self.overlaps, settings.seed, execution)?;
                if sampled.is_none() && !execution.interrupt.is_requested() {
                    self.warnings.push(NO_ROOM.to_owned());
                }
            }
            let weighted = match &sampled {
                Some(sampled) => Some(sampled.in_medium(&in_medium)?),
                None => None,
            };
            if let (Some(sampled), Some(weighted)) = (&sampled, &weighted) {
                self.warnings.extend(weighted.warning(*salt_molar));
                if number == 0 {
                    self.bound_states.push(sampled.summary(ph, weighted));
                    self.warnings.extend(sampled.warnings());
                }
            }
            self.conditions.push(BindingCondition {
                salt_molar: *salt_molar,
                ph,
                poisson_boltzmann_kt: energies.energy_kt,
                error_kt: energies.error_kt,
                salt_effect_kt: energies.salt_effect_kt,
                salt_effect_error_kt: energies.salt_effect_error_kt,
                delta_g_kcal_per_mol: estimate.delta_g_kcal_per_mol(energies.salt_effect_kt),
                delta_g_error_kcal_per_mol: ERROR_KCAL_PER_MOL,
                log10_kd_molar: weighted.as_ref().map(|average| average.log10_kd_molar),
                log10_kd_error: weighted.as_ref().map(|average| average.log10_kd_error),
                energy_kt: of_pose.total_kt(),
                terms_kt: of_pose.terms_kt,
                protons_taken_up: None,
            });
        }
        let at_ph = &self.conditions[before..];
        self.slopes.push(SlopeAtPh {
            ph,
            d_ln_k_d_ln_salt: slope(at_ph, |condition| condition.salt_effect_kt),
            d_ln_k_d_ln_salt_error: slope(at_ph, |condition| condition.salt_effect_error_kt)
                .map(f64::abs),
        });
        self.grid = Some(energy.grids[1]);
        Ok(())
    }

    pub(super) fn add_exchanges(
        &mut self,
        ph: Option<f64>,
        charges: &[InterfaceCharge],
        energy: &BindingEnergy,
    ) {
        if let Some(exchanges) = &mut self.exchanges {
            exchanges.extend(rows(ph, charges, energy));
        }
    }

    /// Adds the protons taken up at one pH.
    pub(super) fn add_uptake(&mut self, ph: Option<f64>, uptake: &ProtonUptake) {
        let at_ph = self.conditions.iter_mut().filter(|row| row.ph == ph);
        for (salt, condition) in at_ph.enumerate() {
            condition.protons_taken_up = ph.and_then(|ph| uptake.value_at(ph, salt));
        }
    }

    /// Adds what follows from all conditions.
    pub(super) fn finish(&mut self) {
        if let Some(first) = self.slopes.first() {
            self.d_ln_k_d_ln_salt = first.d_ln_k_d_ln_salt;
            self.d_ln_k_d_ln_salt_error = first.d_ln_k_d_ln_salt_error;
        }
        let is_unresolved = |condition: &&BindingCondition| {
            let allowed = RESOLVED_KT.max(RESOLVED_PART * condition.salt_effect_kt.abs());
            condition.salt_effect_error_kt > allowed
        };
        if let Some(worst) = self.conditions.iter().find(is_unresolved) {
            self.warnings.push(format!(
                "warning: the grids leave an error of {:.1} kT in the effect of the salt; use a smaller --spacing",
                worst.salt_effect_error_kt
            ));
        }
    }
}

/// -d value / d ln c by least squares; `None` for fewer than two different salts.
///
/// With the values of the binding free energy over kT this is d ln K / d ln c of the association constant.
fn slope(conditions: &[BindingCondition], value: fn(&BindingCondition) -> f64) -> Option<f64> {
    let salted = conditions
        .iter()
        .filter(|condition| condition.salt_molar > 0.0);
    let points: Vec<(f64, f64)> = salted
        .map(|condition| (condition.salt_molar.ln(), value(condition)))
        .collect();
    let count = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let (mut products, mut squares) = (0.0, 0.0);
    for (x, y) in &points {
        products += (x - mean_x) * (y - mean_y);
        squares += (x - mean_x).powi(2);
    }
    (squares > 0.0).then(|| -products / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn condition(salt_molar: f64, salt_effect_kt: f64) -> BindingCondition {
        BindingCondition {
            salt_molar,
            ph: None,
            poisson_boltzmann_kt: 0.0,
            error_kt: 0.0,
            salt_effect_kt,
            salt_effect_error_kt: 0.0,
            delta_g_kcal_per_mol: 0.0,
            delta_g_error_kcal_per_mol: 0.0,
            log10_kd_molar: None,
            log10_kd_error: None,
            energy_kt: 0.0,
            terms_kt: BTreeMap::new(),
            protons_taken_up: None,
        }
    }

    /// ΔG/kT = 2 ln c, so that K falls with the square of the salt.
    #[test]
    fn the_slope_is_that_of_the_association_constant() {
        let salted = |salt: f64| condition(salt, 2.0 * salt.ln());
        let exponent = slope(&[salted(0.05), salted(0.15), salted(1.0)], |row| {
            row.salt_effect_kt
        });
        assert!((exponent.unwrap() + 2.0).abs() < 1e-12);
        for too_few in [
            &[][..],
            &[salted(0.1)],
            &[salted(0.1), salted(0.1)],
            &[condition(0.0, 0.0), salted(0.1)],
        ] {
            assert_eq!(slope(too_few, |row| row.salt_effect_kt), None);
        }
    }
}
