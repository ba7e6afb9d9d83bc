//! Effective charges of bodies: what stands in the place of their charges in a medium.

use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_field::effective_charges::{
    EffectiveChargeSettings, EffectiveCharges, LARGEST_RELATIVE_RESIDUAL, effective_charges,
};
use protomer_field::{ChargedSphere, DielectricModel};
use serde::{Deserialize, Serialize};

/// The inside of bodies, for effective charges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoluteModel {
    /// Relative permittivity inside the surface.
    pub inner_permittivity: f64,
    /// The centres of ions keep this distance from the atoms, Å.
    pub ion_radius_angstrom: f64,
}

impl Default for SoluteModel {
    /// Permittivity 4, which stands for a protein whose side chains may turn a little, and ions of
    /// 2 Å.
    fn default() -> Self {
        Self {
            inner_permittivity: 4.0,
            ion_radius_angstrom: 2.0,
        }
    }
}

/// The effective charges of a body in a medium.
///
/// # Errors
/// Without salt; where the medium was stated by lengths instead of salt and permittivity; and as
/// [`protomer_field::effective_charges::effective_charges`].
pub fn effective_charges_of(
    body: &Body,
    interaction: &ScreenedCoulomb,
    solute: &SoluteModel,
) -> Result<EffectiveCharges> {
    let electrolyte = interaction.electrolyte;
    let Some(salt_molar) = electrolyte.salt_molar() else {
        bail!(
            "effective charges need the salt and the permittivity, not a Debye or Bjerrum length; \
             give --salt 100mM, and --permittivity if it is not that of water"
        );
    };
    if salt_molar <= 0.0 {
        bail!("effective charges are those in an electrolyte; give --salt above zero");
    }
    let mut dielectric = DielectricModel::new(electrolyte);
    dielectric.inner_permittivity = solute.inner_permittivity;
    dielectric.ion_radius_angstrom = solute.ion_radius_angstrom;
    let mut spheres = Vec::with_capacity(body.sites.len());
    for site in &body.sites {
        spheres.push(ChargedSphere {
            centre: site.position,
            radius_angstrom: site.radius_angstrom,
            charge_e: site.charge_e,
        });
    }
    effective_charges(&spheres, &dielectric, &EffectiveChargeSettings::default())
        .with_context(|| format!("effective charges of body '{}'", body.name))
}

/// A warning if a fit stands badly for the potential.
pub fn warning(body: &Body, charges: &EffectiveCharges) -> Option<String> {
    (charges.relative_residual > LARGEST_RELATIVE_RESIDUAL).then(|| {
        format!(
            "warning: the effective charges of '{}' miss the potential around it by {:.1} %; \
             compare with --interaction bare, and check that its charges lie below its surface",
            body.name,
            100.0 * charges.relative_residual
        )
    })
}
