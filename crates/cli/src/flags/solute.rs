//! The flags of effective charges.

use clap::Args;
use protomer::stability::effective::SoluteModel;

/// The inside of bodies, for effective charges.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Effective charges")]
pub struct SoluteArgs {
    /// Relative permittivity inside the bodies [default: 4].
    #[arg(long, allow_negative_numbers = true)]
    pub inner_permittivity: Option<f64>,
    /// Minimum distance of ion centres from the atoms, Å; 0 lets ions reach the surface [default: 2].
    #[arg(long, allow_negative_numbers = true)]
    pub ion_radius: Option<f64>,
}

impl SoluteArgs {
    /// The flags over the defaults; `None` if none is given.
    pub fn solute(&self) -> Option<SoluteModel> {
        if self.inner_permittivity.is_none() && self.ion_radius.is_none() {
            return None;
        }
        let usual = SoluteModel::default();
        Some(SoluteModel {
            inner_permittivity: self.inner_permittivity.unwrap_or(usual.inner_permittivity),
            ion_radius_angstrom: self.ion_radius.unwrap_or(usual.ion_radius_angstrom),
        })
    }
}
