//! The flag of approximate energies, shared by the verbs that compute energies.

use clap::Args;
use protomer_common::range;

/// The tolerance of energies.
#[derive(Debug, Clone, Args)]
pub struct ToleranceArgs {
    /// Largest likely error of the energy of two bodies, kT, with --energy approximate [default:
    /// 0.001].
    #[arg(long, value_name = "KT", allow_hyphen_values = true, value_parser = range::TOLERANCE.number())]
    pub tolerance: Option<f64>,
}
