//! The flags of the contact term.

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::stability::contacts::{ContactCore, ContactTerm};
use protomer_body::residue_contacts::ContactScale;

/// Attraction between residues.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Contacts between residues")]
pub struct ContactArgs {
    /// Attraction between residues, by a published scale.
    #[arg(long, value_enum, default_value_t = Scale::None)]
    pub contacts: Scale,
    /// What multiplies the attraction of the scale [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    pub contact_strength: Option<f64>,
}

/// The scales of the contact term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Scale {
    /// No attraction between residues.
    None,
    /// Ashbaugh-Hatch with the stickiness of Calvados 3.
    Calvados3,
    /// Kim-Hummer with the contact energies of Miyazawa and Jernigan.
    KimHummer,
}

impl ContactArgs {
    /// The contact term; `None` without one.
    ///
    /// # Errors
    /// For a strength without a scale.
    pub fn term(&self, core: ContactCore) -> Result<Option<ContactTerm>> {
        let scale = match self.contacts {
            Scale::Calvados3 => ContactScale::Calvados3,
            Scale::KimHummer => ContactScale::KimHummer,
            Scale::None if self.contact_strength.is_some() => bail!(
                "--contact-strength multiplies a contact term; add --contacts calvados3, or leave \
                 it out"
            ),
            Scale::None => return Ok(None),
        };
        Ok(Some(ContactTerm {
            scale,
            strength: self.contact_strength.unwrap_or(1.0),
            core,
        }))
    }
}
