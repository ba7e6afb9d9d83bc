//! What independent replicas say together.

use protomer_kernel::statistics::RunningMoments;

/// The mean of independent values and its standard error.
pub(super) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let moments = RunningMoments::in_two_passes(values);
    (moments.mean(), moments.independent_standard_error())
}
