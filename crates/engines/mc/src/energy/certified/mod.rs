//! The direct sum's decisions by proven bounds.
//!
//! | level | energy of a pair | error, at most |
//! |---|---|---|
//! | far | none | the energy itself, from the multipoles of both bodies ([`FarField`](super::FarField)) |
//! | cells | the charges of one body in the potential of the other, a polynomial in each cell of space | Σ of charge times the cell's bound (`cells`) |
//! | direct | all pairs of charges | none |
//!
//! A decision adds the intervals of all pairs, before the move and after it, and refines the widest one
//! until the random number lies outside. No estimate and no fitted number enters.
//!
//! The cells are separate from the tables and lists of the calibrated levels. Worst-case bounds of
//! lists, equivalent charges and 16-bit coefficients are hundreds of times their errors.
//! Polynomials of the far charges in cells, with the near charges summed, have bounds a few times
//! their errors and need no set-up.
//!
//! | file | what it holds |
//! |---|---|
//! | `cells` | an octree of cells around a body, made where they are needed, and energies in it |
//! | `series` | the polynomial through 8³ Chebyshev points, and how far it can be from the function |
//! | `model` | the levels of a pair, and decisions |

#![allow(
    clippy::needless_range_loop,
    reason = "a lane runs through several arrays at once"
)]

mod cells;
mod model;
mod series;

pub use cells::{Cells, Interval};
pub use model::{Certified, DecidedByBounds};
