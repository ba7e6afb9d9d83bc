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
//! | `supernodes` | columns of L that are eliminated together |
//! | `symbolic` | from the pattern to dense fronts and where every number goes, once |
//! | `numbers` | what a factorisation fills and a solution uses |
//! | `arena` | places in a workspace that is planned ahead |
//! | `front` | dense work on one front, vectorised |
//! | `factorisation` | L and D, as often as the numbers change |
//! | `solution` | x, for any number of right-hand sides |
//! | `ldl` | all of it |
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

mod arena;
mod error;
mod factorisation;
mod front;
mod ldl;
mod numbers;
mod ordering;
mod solution;
mod supernodes;
mod symbolic;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod up_looking;

pub use error::SparseError;
pub use ldl::LdlFactor;
