//! Contacts between the chains of a crystal and their symmetry copies.
//!
//! | module | one idea |
//! |---|---|
//! | `table` | generators of the space groups |
//! | `space_group` | operations of a space group |
//! | `closure` | motions that close to a ring |
//! | `contacts` | chains and copies that touch |

mod closure;
mod contacts;
mod space_group;
mod table;

pub use contacts::{CrystalContact, crystal_contacts};
pub use space_group::{SymmetryOperation, operations};
