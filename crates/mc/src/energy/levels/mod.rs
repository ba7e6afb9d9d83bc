//! Energies by levels: the decisions of the direct sum at a small part of its price.
//!
//! | level | what is summed |
//! |---|---|
//! | coarse | points chosen for the pair and kept while it moves little, in the coarse table |
//! | middle | all charges of one body in the coarse table of the other |
//! | fine | all charges of one body in the fine table of the other |
//! | direct | all pairs of charges |
//!
//! A table (`table`) holds a body's potential in its own frame in two parts (`split`): the smooth one
//! as Chebyshev series in nested boxes of cells (`field`, `packed`), the near one as charges to be summed pair
//! by pair (`neighbours`). Far parts of the other body are stood for by equivalent charges (`tree`,
//! `fit`). A list (`list`) keeps which ones for a pair, so that errors before and after a move cancel.
//!
//! Poses that have nothing to do with each other take the fine level without a list (`alone`).
//!
//! A decision (`model`) starts at the coarse level with an error by a variance model and goes up, the
//! least certain pair first, while the random number is within [`MULTIPLE`] standard deviations of
//! the change of the energy. The model's scale is found by comparison of the levels (`calibration`).
#![allow(
    clippy::needless_range_loop,
    reason = "a lane runs through several arrays at once"
)]

mod alone;
mod calibration;
mod field;
mod fit;
mod list;
mod model;
mod neighbours;
mod packed;
mod split;
mod storage;
mod table;
mod tree;

pub use calibration::{Calibration, MULTIPLE};
pub use model::{Decided, LevelReport, Levels, table_reach_angstrom};
pub use table::Table;
