//! The flags of what acts between charges: bare, effective, or with the response of the solvent.

use crate::flags::settings::choice;
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::range;
use protomer_field::IonModel;
use protomer_protein_verbs::stability::effective::SoluteModel;

/// The inside of bodies, for effective charges and for the response of the solvent.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Inside of the bodies")]
pub struct SoluteArgs {
    /// Relative permittivity inside the bodies [default: 4].
    #[arg(long, value_parser = range::PERMITTIVITY.number())]
    pub inner_permittivity: Option<f64>,
    /// Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2].
    #[arg(long, value_parser = range::RADIUS.number())]
    pub ion_radius: Option<f64>,
    /// Response of the ions to the potential to which effective charges are fitted [default: linear].
    #[arg(long, value_parser = choice::<IonModel>())]
    pub ions: Option<IonModel>,
    /// Let the charges of titratable groups follow the potential of other bodies, with --interaction response
    /// and bodies of --protonation structure.
    #[arg(long)]
    pub regulation: bool,
}

impl SoluteArgs {
    /// The defaults, overridden by the flags; `None` if no flag is given.
    pub fn solute(&self) -> Option<SoluteModel> {
        let stated = self.over(SoluteModel::default());
        let is_stated = self.inner_permittivity.is_some()
            || self.ion_radius.is_some()
            || self.ions.is_some()
            || self.regulation;
        is_stated.then_some(stated)
    }

    /// The given values, overridden by the flags.
    fn over(&self, present: SoluteModel) -> SoluteModel {
        SoluteModel {
            inner_permittivity: self
                .inner_permittivity
                .unwrap_or(present.inner_permittivity),
            ion_radius_angstrom: self.ion_radius.unwrap_or(present.ion_radius_angstrom),
            ions: self.ions.unwrap_or(present.ions),
            regulation: self.regulation || present.regulation,
        }
    }
}

/// Interaction between the charges of an assembly.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Inside of the bodies")]
pub struct ChargesArgs {
    /// Effect on the charges of the low permittivity of the bodies, which salt does not enter
    /// [default: bare].
    #[arg(long, value_parser = choice::<Charges>())]
    pub interaction: Option<Charges>,
    #[command(flatten)]
    pub solute: SoluteArgs,
}

protomer_kernel::choices! {
    /// The charges of an interaction.
    pub enum Charges {
        /// No effect: the charges of the bodies in salt water everywhere.
        Bare = "bare",
        /// Effective charges act, which give the potential around a body; from 3 Å on.
        Effective = "effective",
        /// The charges of the bodies act, and to first order the response of the salt water that both
        /// displace; for native contacts.
        Response = "response",
    }
}

/// Models of the inside of the bodies, by purpose.
#[derive(Debug, Clone, Copy, Default)]
pub struct Insides {
    /// Model for effective charges.
    pub effective: Option<SoluteModel>,
    /// Model for the response of the solvent.
    pub response: Option<SoluteModel>,
}

impl ChargesArgs {
    /// The models of a configuration, overridden by the flags; none for the bare charges.
    ///
    /// # Errors
    /// For flags of an inside that nothing asks for.
    pub fn insides(&self, present: Insides) -> Result<Insides> {
        let usual = |inside: Option<SoluteModel>| Some(inside.unwrap_or_default());
        let chosen = match self.interaction {
            Some(Charges::Bare) => Insides::default(),
            Some(Charges::Effective) => Insides {
                effective: usual(present.effective),
                response: None,
            },
            Some(Charges::Response) => Insides {
                effective: None,
                response: usual(present.response),
            },
            None => present,
        };
        let is_bare = chosen.effective.is_none() && chosen.response.is_none();
        if is_bare && self.solute.solute().is_some() {
            bail!(
                "--inner-permittivity, --ion-radius, --ions and --regulation apply to bodies with an inside only; add \
                 --interaction effective or --interaction response, or leave them out"
            );
        }
        Ok(Insides {
            effective: chosen.effective.map(|inside| self.solute.over(inside)),
            response: chosen.response.map(|inside| self.solute.over(inside)),
        })
    }
}
