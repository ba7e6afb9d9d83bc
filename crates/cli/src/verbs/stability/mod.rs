//! The verbs of stability.

pub mod bench;
pub mod compare;
pub mod inspect;
pub mod simulate;
pub mod sweep;
