//! Networks: training, search for settings, prediction.

pub mod predict;
pub mod train;
pub mod tune;
