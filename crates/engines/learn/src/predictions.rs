//! Predictions for a test part, with what is known of the set: what an evaluation judges.

use crate::Description;
use crate::split::Split;

/// Predictions for the test part of a split, and what is known of the set.
#[derive(Debug, Clone, Copy)]
pub struct TestPredictions<'a> {
    /// All samples of the set.
    pub descriptions: &'a [Description],
    /// The class of each sample.
    pub labels: &'a [usize],
    /// Number of classes.
    pub classes: usize,
    /// The split.
    pub split: &'a Split,
    /// Probabilities of the test part, in its order: sample after sample, one number per class.
    pub probabilities: &'a [f64],
}
