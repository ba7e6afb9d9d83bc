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
//!
//! `faer` 0.24.4 was once compared with this code, on the rods of lattices of squares. The table
//! gives a refactorisation with one solution and a whole step of the lattice, in ms:
//!
//! | squares | this code | fastest of faer's variants | whole step |
//! |---|---|---|---|
//! | 10 x 10 | 0.015 | 0.014 | 0.036 |
//! | 32 x 32 | 0.21 | 0.35 | 0.45 |
//! | 100 x 100 | 3.3 | 6.1 | 7.5 |
//!
//! This is CPU time of one thread of a virtual Xeon, the best of five blocks of 0.2 s (2026-11-22);
//! the step is that of `cargo bench -p protomer-linkage --bench lattice -- 10 32 100`. This code
//! gives the same bits on every processor and names a dependent row. As a development dependency
//! faer would add 54 crates to the tests.

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
