//! Trial moves of one body, geometric cluster moves, moves that form and dissolve contacts, and step
//! sizes.

pub mod binding;
#[cfg(test)]
mod binding_tests;
pub mod cluster;
pub mod contact_turn;
pub mod group;
pub mod proposal;
pub mod protonation;
pub mod relocation;
pub mod single;
pub mod step_sizes;
pub mod swap;

pub use binding::BindingMove;
pub use cluster::HalfTurn;
pub use single::Kind;
pub use step_sizes::{Acceptance, StepSizes};
