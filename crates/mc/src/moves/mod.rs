//! Trial moves of one body, geometric cluster moves, and their step sizes.

pub mod cluster;
pub mod single;
pub mod step_sizes;

pub use cluster::HalfTurn;
pub use single::Kind;
pub use step_sizes::{Acceptance, StepSizes};
