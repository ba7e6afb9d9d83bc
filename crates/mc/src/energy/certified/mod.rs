//! Energies as intervals, at a fraction of the direct sum's cost.
mod field;
mod leaves;
mod model;
mod near;
mod pair;
mod sampling;
mod split;
mod window;

pub use model::{CertifiedSum, Counts};
pub use pair::{ChargeTable, EnergyInterval};
