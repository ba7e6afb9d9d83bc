//! The flag of approximate energies, shared by the verbs that compute energies.

use clap::Args;

/// The tolerance of energies.
#[derive(Debug, Clone, Args)]
pub struct ToleranceArgs {
    /// Largest likely error of the energy of two bodies, kT, with --energy approximate [default:
    /// 0.001].
    #[arg(long, value_name = "KT", allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
}
