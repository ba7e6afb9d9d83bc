//! The verbs of stability.

pub mod bench;
pub mod binding;
pub mod compare;
pub mod equilibrium;
pub mod inspect;
pub mod pair;
pub mod residues;
pub mod reweight;
pub mod score;
pub mod simulate;
pub mod sweep;
