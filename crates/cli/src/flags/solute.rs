//! The flags of effective charges.

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::stability::effective::SoluteModel;
use protomer_common::range;

/// The inside of bodies, for effective charges.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Effective charges")]
pub struct SoluteArgs {
    /// Relative permittivity inside the bodies [default: 4].
    #[arg(long, allow_negative_numbers = true, value_parser = range::PERMITTIVITY.number())]
    pub inner_permittivity: Option<f64>,
    /// Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2].
    #[arg(long, allow_negative_numbers = true, value_parser = range::RADIUS.number())]
    pub ion_radius: Option<f64>,
}

impl SoluteArgs {
    /// The flags over the defaults; `None` if none is given.
    pub fn solute(&self) -> Option<SoluteModel> {
        if self.inner_permittivity.is_none() && self.ion_radius.is_none() {
            return None;
        }
        Some(self.over(SoluteModel::default()))
    }

    /// The flags over these values.
    fn over(&self, present: SoluteModel) -> SoluteModel {
        SoluteModel {
            inner_permittivity: self
                .inner_permittivity
                .unwrap_or(present.inner_permittivity),
            ion_radius_angstrom: self.ion_radius.unwrap_or(present.ion_radius_angstrom),
        }
    }
}

/// Which charges act between the bodies of an assembly.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Effective charges")]
pub struct ChargesArgs {
    /// Whether the charges of the bodies act, or their effective charges: those that give the
    /// potential around bodies of low permittivity that salt does not enter [default: bare].
    #[arg(long, value_enum)]
    pub interaction: Option<Charges>,
    #[command(flatten)]
    pub solute: SoluteArgs,
}

/// The charges of an interaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Charges {
    /// The charges of the bodies.
    Bare,
    /// Their effective charges.
    Effective,
}

impl ChargesArgs {
    /// The flags over the settings of a configuration; `None` for the charges of the bodies.
    pub fn effective_charges(&self, present: Option<SoluteModel>) -> Result<Option<SoluteModel>> {
        let present = match self.interaction {
            Some(Charges::Effective) => Some(present.unwrap_or_default()),
            Some(Charges::Bare) => None,
            None => present,
        };
        if present.is_none() && self.solute.solute().is_some() {
            bail!(
                "--inner-permittivity and --ion-radius apply to effective charges only; add \
                 --interaction effective, or leave them out"
            );
        }
        Ok(present.map(|present| self.solute.over(present)))
    }
}
