//! Simulations of an assembly: their engine, their settings, and one simulation in its directory.

pub mod columns;
mod costs;
mod engine;
mod given_state;
mod ladder;
mod log;
mod outputs;
mod replica;
mod salt_choice;
mod settings;
mod titratable;
mod trajectory;

pub use columns::{Column, Columns};
pub use costs::EnergyCosts;
pub use engine::{Engine, require_room};
pub use given_state::GivenState;
pub use ladder::{Exchanged, LadderRun, Rung};
pub use log::LogRow;
pub use replica::{AcceptedFractions, Replica};
pub(crate) use salt_choice::rounds_to;
pub use salt_choice::{chosen_salt, listed_salts};
pub use settings::{
    DEFAULT_TOLERANCE_KT, EnergyMode, Promise, RunSettings, Start, Starts, replica_directory,
    salt_label,
};
pub(crate) use trajectory::{frame, header};
