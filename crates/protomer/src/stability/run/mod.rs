//! Simulations of an assembly: their engine, their settings, and one simulation in its directory.

mod costs;
mod engine;
mod log;
mod replica;
mod settings;
mod trajectory;

pub use costs::EnergyCosts;
pub use engine::{Engine, require_room};
pub use log::LogRow;
pub use replica::{AcceptedFractions, Replica};
pub use settings::{DEFAULT_TOLERANCE_KT, EnergyMode, Promise, RunSettings, salt_label};
