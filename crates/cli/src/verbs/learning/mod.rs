//! The verbs of learning.

pub mod predict;
pub mod train;
pub mod tune;
