//! Means over frames and replicas with their errors.

use protomer_kernel::statistics::summarize;
use protomer_mc::contributions::Mean;
use protomer_mc::scattering::experiment::Measured;

/// The mean over all frames of all replicas. Its error is the larger of two: that of the correlated
/// series within the replicas, and that of the replicas' scatter.
pub(super) fn estimate(replicas: &[Vec<f64>]) -> Mean {
    let frames: usize = replicas.iter().map(Vec::len).sum();
    let mean = replicas.iter().flatten().sum::<f64>() / frames as f64;
    let (mut within, mut between) = (0.0, 0.0);
    for series in replicas {
        let summary = summarize(series);
        let share = series.len() as f64 / frames as f64;
        within += (share * summary.standard_error).powi(2);
        between += (share * (summary.mean - mean)).powi(2);
    }
    let count = replicas.len() as f64;
    let between = (between * count / (count - 1.0).max(1.0)).sqrt();
    let within = within.sqrt();
    let error = match (within.is_finite(), replicas.len() > 1) {
        (true, true) => Some(within.max(between)),
        (true, false) => Some(within),
        (false, true) => Some(between),
        (false, false) => None,
    };
    Mean { mean, error }
}

/// The ratio of two means; its error is that of the part in which they do not go together. Both means
/// zero give no number, and no error.
pub(super) fn ratio(
    replicas: &[Vec<Measured>],
    above: &dyn Fn(&Measured) -> f64,
    below: &dyn Fn(&Measured) -> f64,
) -> Mean {
    let series = |value: &dyn Fn(&Measured) -> f64| -> Vec<Vec<f64>> {
        let over = replicas.iter();
        over.map(|frames| frames.iter().map(value).collect())
            .collect()
    };
    let (top, bottom) = (estimate(&series(above)).mean, estimate(&series(below)).mean);
    let quotient = top / bottom;
    let apart = estimate(&series(&|state| {
        (above(state) - quotient * below(state)) / bottom
    }));
    Mean {
        mean: quotient,
        error: apart.error.filter(|error| error.is_finite()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_frames_and_of_replicas() {
        let one = estimate(&[vec![3.0]]);
        assert_eq!((one.mean, one.error), (3.0, None));
        // Replicas that do not move within themselves differ nevertheless.
        let frozen = estimate(&[vec![1.0; 10], vec![3.0; 10]]);
        assert_eq!(frozen.mean, 2.0);
        assert!((frozen.error.unwrap() - 1.0).abs() < 1e-12);
        let noisy: Vec<f64> = (0..100).map(|n| f64::from(n % 2)).collect();
        let within = estimate(std::slice::from_ref(&noisy));
        assert!(
            within
                .error
                .is_some_and(|error| error > 0.01 && error < 0.06)
        );
    }
}
