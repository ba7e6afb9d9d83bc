//! Networks: trained, searched for, applied.

pub mod predict;
pub mod train;
pub mod tune;
