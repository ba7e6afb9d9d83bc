//! The flags of the energy terms in addition to the charges.

use crate::flags::settings::{Chosen, choice_or};
use anyhow::{Result, bail};
use clap::Args;
use protomer_body::residue_contacts::ContactScale;
use protomer_common::range;
use protomer_protein_verbs::stability::contacts::{ContactCore, ContactTerm};
use protomer_protein_verbs::stability::terms::StatedTerms;

/// Attraction between residues.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Further terms")]
pub struct ContactArgs {
    /// Attraction between residues, by a published scale [default: none].
    #[arg(long, value_parser = choice_or::<ContactScale>("none", "No attraction between residues"))]
    pub contacts: Option<Chosen<ContactScale>>,
    /// Factor on the attraction of the scale [default: 1].
    #[arg(long, value_parser = range::STRENGTH.number())]
    pub contact_strength: Option<f64>,
}

/// Attraction between residues, and desolvation.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Further terms")]
pub struct TermsArgs {
    #[command(flatten)]
    pub attraction: ContactArgs,
    /// Count what charges lose where other bodies displace solvent; with effective charges.
    #[arg(long)]
    pub desolvation: bool,
}

impl TermsArgs {
    /// Whether any of the flags is given.
    pub fn is_given(&self) -> bool {
        self.attraction.contacts.is_some()
            || self.attraction.contact_strength.is_some()
            || self.desolvation
    }

    /// The terms of a configuration, overridden by the flags.
    ///
    /// # Errors
    /// As [`ContactArgs::over`].
    pub fn over(&self, present: StatedTerms, core: ContactCore) -> Result<StatedTerms> {
        Ok(StatedTerms {
            contacts: self.attraction.over(present.contacts, core)?,
            desolvation: self.desolvation || present.desolvation,
        })
    }
}

impl ContactArgs {
    /// The contact term of a configuration, overridden by the flags; `None` without one.
    ///
    /// # Errors
    /// For a strength without a scale.
    pub fn over(
        &self,
        present: Option<ContactTerm>,
        core: ContactCore,
    ) -> Result<Option<ContactTerm>> {
        let scale = match self.contacts {
            Some(Chosen(scale)) => scale,
            None => present.map(|term| term.scale),
        };
        let Some(scale) = scale else {
            if self.contact_strength.is_some() {
                bail!(
                    "--contact-strength multiplies a contact term; add --contacts calvados3, or \
                     leave it out"
                );
            }
            return Ok(None);
        };
        let of_scale = present.filter(|term| term.scale == scale);
        let strength = of_scale.map_or(1.0, |term| term.strength);
        Ok(Some(ContactTerm {
            scale,
            strength: self.contact_strength.unwrap_or(strength),
            core,
        }))
    }
}
