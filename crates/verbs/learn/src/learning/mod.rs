//! Networks: training, search for settings, prediction.

pub mod labels;
pub mod predict;
pub mod train;
pub mod tune;
