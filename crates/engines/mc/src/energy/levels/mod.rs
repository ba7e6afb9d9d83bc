//! Energies by levels: the decisions of the direct sum at a small part of its price.
//!
//! | level | what is summed |
//! |---|---|
//! | far | images far away: no more than a bound of what they hold (`far`) |
//! | expanded | points chosen for the pair and kept while it moves little: the nearer ones in the coarse table, the others as a quadratic function of how the pair has moved |
//! | coarse | all of these points in the coarse table |
//! | fine | all charges of one body in the fine table of the other |
//! | sharpened | the same, but for the least certain of the charges, from 1 % to 60 % of them, which are summed directly (`sharpening`) |
//! | direct | all pairs of charges |
//!
//! A table (`table`) holds a body's potential in its own frame in two parts (`split`): the smooth one
//! as Chebyshev series in nested boxes of cells (`field`; sampled by `sampler`, stored as `fine` and
//! `packed`, evaluated by `series` and `derivatives`), the near one as charges to be summed pair by pair
//! (`neighbours`, `near`). Far parts of the other body are stood for by equivalent charges (`tree`, `fit`). A
//! list (`list`, chosen by `maker`) keeps which ones for a pair, so that errors before and after a
//! move cancel, and an expansion of the far ones (`expansion`) in the pair's motion (`motion`).
//!
//! Poses that have nothing to do with each other take the fine level without a list (`fine_energy`).
//!
//! A decision (`decision`) starts at the first level with an error by a variance model and goes up, the
//! least certain pair first, while the random number is within [`MULTIPLE`] standard deviations of the
//! change of the energy and the bounds of far images. The energies of one pair at each level are in
//! `pair_levels`, what was found for it in `stored`; `model` keeps these from move to move. The scale of
//! the variance model is found by comparison of the levels (`calibration`).
#![allow(
    clippy::needless_range_loop,
    reason = "a lane runs through several arrays at once"
)]

mod calibration;
mod decision;
mod derivatives;
mod expansion;
mod far;
mod field;
mod fine;
mod fine_energy;
mod fit;
mod lanes;
mod list;
mod maker;
mod model;
mod motion;
mod near;
mod neighbours;
mod packed;
mod pair_levels;
mod sampler;
mod series;
mod sharpening;
mod split;
mod storage;
mod stored;
mod table;
mod tree;

pub use calibration::{Calibration, MULTIPLE};
pub use decision::Decided;
pub use model::{Levels, table_reach_angstrom};
pub use table::Table;
