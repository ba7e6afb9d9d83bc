//! Symmetric sparse systems whose pattern never changes while their numbers do: constraint forces,
//! elastic networks.
//!
//! ```text
//! A x = b,    P A Pᵀ = L D Lᵀ
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `ordering` | P: nested dissection of the graph of A by coordinates |
//! | `symbolic` | from the pattern to dense fronts and where every number goes, once |
//! | `front` | dense work on one front, vectorised |
//! | `ldl` | L and D, as often as the numbers change; solutions |
//!
//! Measured on one core of a virtual Xeon (family 6, model 207, AVX-512, shared with other work),
//! processor time, by `cargo bench -p protomer-kernel --bench sparse`: grids coupled to nearest and
//! diagonal neighbours,
//!
//! | grid, unknowns per node | entries of L per unknown | multiplications | factor, s | solve, s |
//! |---|---|---|---|---|
//! | 100 x 100, 2 | 63.5 | 7.2e7 | 0.013 | 0.0018 |
//! | 316 x 316, 2 | 88.5 | 2.4e9 | 0.55 | 0.048 |
//! | 12 x 12 x 12, 3 | 252 | 2.2e8 | 0.022 | 0.0014 |
//! | 20 x 20 x 20, 3 | 495 | 5.1e9 | 0.46 | 0.019 |
//!
//! A is held as its lower triangle, a list of (row, column) places fixed at the start; the numbers
//! come as one slice in the order of that list.

mod front;
mod ldl;
mod ordering;
mod symbolic;
#[cfg(test)]
mod up_looking;

pub use ldl::{LdlFactor, SparseError};
pub use ordering::nested_dissection;
