//! One body in one medium: what shapes its effective charges, and their fit.

use super::{SoluteModel, require_electrolyte};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_field::effective_charges::{
    EffectiveChargeSettings, EffectiveCharges, effective_charges,
};
use protomer_field::{ChargedSphere, DielectricModel};
use protomer_io::atomic::sha256_hex;
use std::fmt::Write;

/// Version of the fit, part of every key: another way of fitting makes other charges. To be raised
/// with every change of `protomer_field` that moves them.
const VERSION: &str = "effective charges 1";

/// A body in a medium that has effective charges.
pub(super) struct Problem<'a> {
    pub body: &'a Body,
    spheres: Vec<ChargedSphere>,
    dielectric: DielectricModel,
    settings: EffectiveChargeSettings,
}

impl<'a> Problem<'a> {
    /// # Errors
    /// As [`require_electrolyte`].
    pub fn new(
        body: &'a Body,
        interaction: &ScreenedCoulomb,
        solute: &SoluteModel,
    ) -> Result<Self> {
        require_electrolyte(interaction, "effective")?;
        if solute.regulation {
            bail!("--regulation is part of --interaction response; choose that, or leave it out");
        }
        Ok(Self {
            body,
            spheres: body.sites.iter().map(ChargedSphere::from).collect(),
            dielectric: solute.dielectric(interaction.electrolyte),
            settings: EffectiveChargeSettings::default(),
        })
    }

    /// # Errors
    /// As [`effective_charges`]: names the body.
    pub fn solve(&self) -> Result<EffectiveCharges> {
        effective_charges(&self.spheres, &self.dielectric, &self.settings)
            .with_context(|| format!("effective charges of body '{}'", self.body.name))
    }

    /// The hash of everything that shapes the charges. Numbers are written so that they read back
    /// the same.
    pub fn key(&self) -> String {
        let mut text = format!("{VERSION}\n{:?}\n{:?}\n", self.settings, self.dielectric);
        for sphere in &self.spheres {
            let [x, y, z]: [f64; 3] = sphere.centre.into();
            let (radius, charge) = (sphere.radius_angstrom, sphere.charge_e);
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{x:?} {y:?} {z:?} {radius:?} {charge:?}");
        }
        sha256_hex(text.as_bytes())
    }
}
