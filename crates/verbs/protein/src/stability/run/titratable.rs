//! Titratable groups of the bodies of a run, for charges that respond.

use super::RunSettings;
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_body::chemistry::titration::BodyTitration;
use protomer_field::titration::DELTA_SHARE;
use protomer_kernel::Vec3;
use protomer_kernel::setting::Choices;
use protomer_mc::titratable::{Tautomers, TitratableCharges, TitratableGroup};
use std::f64::consts::LN_10;
use std::sync::Arc;

/// Difference of two salt concentrations, as a part of one, that counts as none.
const SAME_SALT: f64 = 0.01;
/// Difference of two temperatures that counts as none, K.
const SAME_KELVIN: f64 = 1.0;

/// The groups of each kind of body; `None` for one without groups, whose charges are fixed.
///
/// # Errors
/// If no body has any, and for a titration in another salt than that of the run.
pub(super) fn groups_of_bodies(
    bodies: &[Arc<Body>],
    interaction: &ScreenedCoulomb,
) -> Result<Vec<Option<Arc<TitratableCharges>>>> {
    let mut groups = Vec::with_capacity(bodies.len());
    for body in bodies {
        let charges = match &body.titration {
            Some(titration) if !titration.groups.is_empty() => {
                let named = || format!("body '{}'", body.name);
                require_conditions(titration, interaction).with_context(named)?;
                Some(Arc::new(charges(body, titration).with_context(named)?))
            }
            _ => None,
        };
        groups.push(charges);
    }
    if groups.iter().all(Option::is_none) {
        bail!(
            "--proton-moves changes titratable groups, and no body has any; make bodies with ingest --protonation \
             structure --titratable, or leave out --proton-moves"
        );
    }
    Ok(groups)
}

/// The charges of a body with every group neutral, and what its groups add.
fn charges(body: &Body, titration: &BodyTitration) -> Result<TitratableCharges> {
    let site = |site: &protomer_body::Site| (site.position, site.charge_e);
    let mut sites: Vec<(Vec3, f64)> = body.sites.iter().map(site).collect();
    let mut groups = Vec::with_capacity(titration.groups.len());
    for group in &titration.groups {
        let mut change_e = Vec::with_capacity(group.change_e.len());
        for (site, charge_e) in &group.change_e {
            let site = *site as usize;
            if let Some(neutral) = sites.get_mut(site) {
                neutral.1 -= group.charged_share * charge_e;
            }
            change_e.push((site, *charge_e));
        }
        let proton_kt = group.charge_e * LN_10 * (titration.ph - group.model_pka);
        groups.push(TitratableGroup {
            change_e,
            free_energy_kt: proton_kt + group.shift_kt,
            tautomers: group.tautomer_kt.map(|half_difference_kt| Tautomers {
                first_share: DELTA_SHARE,
                half_difference_kt,
            }),
        });
    }
    let (pairs, tautomers) = (
        titration.pair_kt.clone(),
        titration.tautomer_pair_kt.clone(),
    );
    Ok(TitratableCharges::new(&sites, groups, pairs, tautomers)?)
}

/// Refuses a run in another salt or at another temperature than those of the titration.
fn require_conditions(titration: &BodyTitration, interaction: &ScreenedCoulomb) -> Result<()> {
    let electrolyte = &interaction.electrolyte;
    let (solved, kelvin) = (titration.salt_molar, titration.temperature_kelvin);
    let is_same = electrolyte
        .salt_molar()
        .is_some_and(|salt| (salt - solved).abs() <= SAME_SALT * solved);
    if !is_same {
        bail!(
            "its groups were titrated in {solved} M salt, and the run has another; run it with --salt {solved}M, or \
             make the body with ingest --protonation structure --titratable --protonation-salt and the salt of the run"
        );
    }
    if (electrolyte.temperature_kelvin() - kelvin).abs() > SAME_KELVIN {
        bail!("its groups were titrated at {kelvin} K; run it with --temperature {kelvin}");
    }
    Ok(())
}

impl RunSettings {
    /// Checks that charges that respond are combined with what holds for them.
    pub(super) fn check_proton_moves(&self) -> Result<()> {
        if self.proton_moves_per_sweep == 0 {
            return Ok(());
        }
        if let Some(energy) = self.energy
            && energy != super::EnergyMode::Direct
        {
            bail!(
                "--proton-moves changes charges, and --energy {} holds for fixed ones; leave out --energy, or \
                 choose direct",
                energy.name()
            );
        }
        if self.effective_charges.is_some() || self.solvent_response.is_some() {
            bail!(
                "effective charges and the response of the solvent are solved for fixed charges; leave out \
                 --proton-moves, or use --interaction bare and no --model that has them (--interaction response \
                 --regulation lets charges respond to first order)"
            );
        }
        if self.exchange_every > 0 || self.salt_molar.len() > 1 {
            bail!(
                "groups are titrated in one salt, so --proton-moves is for one salt concentration without exchanges; \
                 give one --salt, and leave out --exchange-every"
            );
        }
        Ok(())
    }

    /// Refuses a run whose charges changed, for an analysis that computes energies of frames.
    ///
    /// # Errors
    /// If the run has moves of protons.
    pub fn require_fixed_charges(&self, verb: &str) -> Result<()> {
        if self.proton_moves_per_sweep > 0 {
            bail!(
                "{verb} computes energies of frames with the charges of the bodies, and in this run they changed \
                 (--proton-moves); run the simulation without, or use log.csv and charges.csv"
            );
        }
        Ok(())
    }
}
