//! The verbs of stability.

pub mod bench;
pub mod compare;
pub mod inspect;
pub mod pair;
pub mod simulate;
pub mod sweep;
