//! Symmetric sparse systems whose pattern never changes while their numbers do: constraint forces, elastic networks.
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
//! A is held as its lower triangle, a list of (row, column) places fixed at the start; the numbers come as one slice in
//! the order of that list.

mod front;
mod ldl;
mod ordering;
mod symbolic;
#[cfg(test)]
mod up_looking;

pub use ldl::{LdlFactor, SparseError};
pub use ordering::nested_dissection;
