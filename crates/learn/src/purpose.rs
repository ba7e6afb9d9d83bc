//! What each stream of random numbers is for.
//!
//! A stream follows from a seed and its purpose, so two purposes never share a number. The
//! synthetic sets of [`crate::controls`] have their own list, because their seeds are their own.

/// The order in which a split fills its parts.
pub(crate) const SPLIT: u8 = 60;
/// Draws of clusters for an interval.
pub(crate) const BOOTSTRAP: u8 = 61;
/// Exchanges of labels.
pub(crate) const PERMUTATION: u8 = 62;
/// The order of the training samples in an epoch.
pub(crate) const ORDER: u8 = 63;
/// The rotation of a training sample in an epoch.
pub(crate) const ROTATION: u8 = 64;
/// The settings of a trial.
pub(crate) const TRIAL: u8 = 90;
