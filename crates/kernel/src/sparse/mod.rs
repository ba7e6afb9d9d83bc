//! Symmetric sparse systems whose pattern never changes while their numbers do: constraint forces, elastic networks.
//!
//! ```text
//! A x = b,    P A Pᵀ = L D Lᵀ
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `ordering` | P: nested dissection of the graph of A by coordinates |
//! | `ldl` | L and D: the pattern found once, the numbers as often as they change |
//!
//! A is held as its lower triangle, a list of (row, column) places fixed at the start; the numbers come as one slice in
//! the order of that list.

mod ldl;
mod ordering;

pub use ldl::{LdlFactor, SparseError};
pub use ordering::nested_dissection;
