//! Averages of correlated series and their errors.
//!
//! Successive states of a simulation resemble each other, so n samples are worth fewer independent
//! ones. With the normalised autocorrelation function ρ(t) = ⟨δx(s) δx(s+t)⟩ / ⟨δx²⟩ and the
//! integrated autocorrelation time
//!
//! τ = 1/2 + Σ_{t ≥ 1} ρ(t)
//!
//! the standard error of the mean is s √(2τ / n): n / (2τ) effective samples (Sokal, in *Functional
//! Integration*, Plenum 1997). A series without memory has τ = 1/2.
//!
//! [`summarize`] sums ρ up to the self-consistent window M, the first with M ≥ 5 τ(M) (Madras and
//! Sokal, J. Stat. Phys. 50, 109 (1988)); [`block_errors`] is the independent check by averaging
//! ever larger blocks (Flyvbjerg and Petersen, J. Chem. Phys. 91, 461 (1989)). [`RunningMoments`]
//! keeps mean and variance of a stream in constant memory. [`jackknife_error`] is for estimates that
//! are no means.

use crate::null;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The window's length in autocorrelation times.
const WINDOW_IN_AUTOCORRELATION_TIMES: f64 = 5.0;
/// Autocorrelation time τ of a series without memory.
const UNCORRELATED_TIME: f64 = 0.5;
/// Longest lag up to which autocorrelations are summed; beyond it the series is coarsened.
const LONGEST_LAG: usize = 1000;

/// Summary of a correlated series: its average, its spread, and the precision of the average.
///
/// ```
/// use protomer_kernel::statistics::summarize;
/// let constant = summarize(&[3.0; 10]);
/// assert_eq!((constant.mean, constant.standard_error), (3.0, 0.0));
/// assert_eq!((constant.autocorrelation_time, constant.effective_samples), (0.5, 10.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Mean.
    #[serde(deserialize_with = "null::as_nan")]
    pub mean: f64,
    /// Standard deviation of single samples, unbiased for independent ones; zero for fewer than
    /// two.
    #[serde(deserialize_with = "null::as_nan")]
    pub standard_deviation: f64,
    /// Standard error of the mean, corrected for autocorrelation; infinite for fewer than two
    /// samples, zero for a constant series.
    #[serde(deserialize_with = "null::as_infinity")]
    pub standard_error: f64,
    /// Integrated autocorrelation time τ in sampling intervals; 1/2 for independent samples.
    pub autocorrelation_time: f64,
    /// Number of independent samples that would have the same standard error, n / (2τ).
    #[serde(deserialize_with = "null::as_nan")]
    pub effective_samples: f64,
}

/// Summarises a correlated series, sampled at equal intervals. The mean of an empty series is NaN.
///
/// The autocorrelation time is known only if the series is many times as long. With fewer than some
/// 50 effective samples, treat the error as a lower bound.
///
/// ```
/// use protomer_kernel::statistics::summarize;
/// let summary = summarize(&[1.0, 2.0, 1.5, 2.5, 1.0, 2.0]);
/// assert!((summary.mean - 10.0 / 6.0).abs() < 1e-12);
/// ```
pub fn summarize(series: &[f64]) -> Summary {
    let moments: RunningMoments = series.iter().copied().collect();
    let autocorrelation_time = autocorrelation_time(series);
    let effective_samples = series.len() as f64 / (2.0 * autocorrelation_time);
    let standard_deviation = moments.standard_deviation();
    // s² itself is too small by a part of about 2τ/n, as deviations are from the mean of the same
    // samples: divide that out.
    let lost = (1.0 - effective_samples.recip()).max(0.0);
    let standard_error = match series.len() {
        0 | 1 => f64::INFINITY,
        _ if standard_deviation == 0.0 => 0.0,
        _ => standard_deviation / (effective_samples * lost).sqrt(),
    };
    Summary {
        mean: moments.mean(),
        standard_deviation,
        standard_error,
        autocorrelation_time,
        effective_samples,
    }
}

/// Integrated autocorrelation time τ = 1/2 + Σ ρ(t) in sampling intervals, at least 1/2, summed up
/// to the first window M ≥ 5 τ(M). 1/2 for a constant series and for fewer than two samples.
///
/// The relative standard error of τ is about √(2(2M + 1)/n).
///
/// ```
/// use protomer_kernel::statistics::autocorrelation_time;
/// let independent = [0.3, -1.2, 0.8, 0.1, -0.4, 1.1, -0.7];
/// assert_eq!(autocorrelation_time(&independent), 0.5);
/// let slow: Vec<f64> = (0..10_000).map(|t| (f64::from(t) / 50.0).sin()).collect();
/// assert!(autocorrelation_time(&slow) > 10.0);
/// ```
pub fn autocorrelation_time(series: &[f64]) -> f64 {
    let mean = series.iter().copied().collect::<RunningMoments>().mean();
    let mut deviations: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let variance = mean_square(&deviations);
    // Rounding leaves a constant series with a variance of up to (ε mean)².
    if variance.is_nan() || variance <= (4.0 * f64::EPSILON * mean).powi(2) {
        return UNCORRELATED_TIME;
    }
    // The squared error of the mean, 2 τ c₀ / n, is the same for averages of two samples each. Where
    // the memory is too long to be summed in time linear in n, τ follows from such averages.
    let mut samples_per_value = 1.0;
    loop {
        // The sum is in samples of the averages and for their variance; τ is in samples of the series
        // and for its own.
        if let Some(time) = windowed_time(&deviations) {
            let time = time * samples_per_value * mean_square(&deviations) / variance;
            return time.max(UNCORRELATED_TIME);
        }
        deviations = pair_averages(&deviations);
        samples_per_value *= 2.0;
    }
}

/// The sum 1/2 + Σ ρ(t) for t up to the window; `None` if the window lies beyond [`LONGEST_LAG`].
fn windowed_time(deviations: &[f64]) -> Option<f64> {
    let variance = mean_square(deviations);
    let mut time = UNCORRELATED_TIME;
    // Lag after lag, not by Fourier transform: the window closes after a few τ.
    for lag in 1..deviations.len() {
        if lag > LONGEST_LAG {
            return None;
        }
        let mut products = 0.0;
        for (early, late) in deviations.iter().zip(&deviations[lag..]) {
            products += early * late;
        }
        // Divided by the number of pairs and not by n: unbiased for each lag.
        time += products / ((deviations.len() - lag) as f64 * variance);
        // Noise grows with the window while what is left out shrinks: of an exponential, exp(-5).
        if lag as f64 >= WINDOW_IN_AUTOCORRELATION_TIMES * time {
            break;
        }
    }
    Some(time)
}

fn mean_square(deviations: &[f64]) -> f64 {
    let squares = deviations.iter().map(|deviation| deviation * deviation);
    squares.sum::<f64>() / deviations.len() as f64
}

fn pair_averages(values: &[f64]) -> Vec<f64> {
    // An odd value at the end is dropped: it belongs to no block.
    let (pairs, _) = values.as_chunks();
    let average = |[first, second]: &[f64; 2]| 0.5 * (first + second);
    pairs.iter().map(average).collect()
}

/// The error of the mean at one level of blocking.
///
/// ```
/// use protomer_kernel::statistics::block_errors;
/// let alternating: Vec<f64> = (0..64).map(|t| f64::from(t % 2)).collect();
/// let [single, pairs] = [0, 1].map(|level| block_errors(&alternating)[level]);
/// assert!((single.standard_error - 0.5 / 63.0_f64.sqrt()).abs() < 1e-12);
/// assert_eq!((pairs.block_length, pairs.blocks, pairs.standard_error), (2, 32, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BlockError {
    /// Samples in a block, a power of two.
    pub block_length: usize,
    /// Number of whole blocks.
    pub blocks: usize,
    /// Standard error of the mean if the blocks are independent, √(c₀ / (n' - 1)).
    pub standard_error: f64,
    /// Standard error of that estimate, `standard_error` / √(2(n' - 1)).
    pub uncertainty: f64,
}

/// The error of the mean at every level of blocking, from single samples to two blocks. It grows
/// with the length of the blocks until they are independent; its plateau is the error.
///
/// ```
/// use protomer_kernel::statistics::block_errors;
/// let levels = block_errors(&[1.0, 2.0, 1.5, 2.5, 1.0, 2.0, 1.5, 2.5]);
/// let blocks: Vec<usize> = levels.iter().map(|level| level.blocks).collect();
/// assert_eq!(blocks, [8, 4, 2]);
/// ```
pub fn block_errors(series: &[f64]) -> Vec<BlockError> {
    let mut levels = Vec::new();
    let mut averages = series.to_vec();
    let mut block_length = 1;
    while averages.len() >= 2 {
        let moments: RunningMoments = averages.iter().copied().collect();
        let standard_error = moments.standard_deviation() / (averages.len() as f64).sqrt();
        let uncertainty = standard_error / (2.0 * (averages.len() as f64 - 1.0)).sqrt();
        levels.push(BlockError {
            block_length,
            blocks: averages.len(),
            standard_error,
            uncertainty,
        });
        averages = pair_averages(&averages);
        block_length *= 2;
    }
    levels
}

/// The standard error by blocking: that of the first level which later ones do not exceed by more
/// than their uncertainty. Only levels with at least 16 blocks count. `None` if the error still grows
/// there, or for fewer than 32 samples.
///
/// ```
/// use protomer_kernel::statistics::block_standard_error;
/// let alternating: Vec<f64> = (0..64).map(|t| f64::from(t % 2)).collect();
/// assert!(block_standard_error(&alternating).is_some());
/// assert_eq!(block_standard_error(&alternating[..31]), None);
/// ```
pub fn block_standard_error(series: &[f64]) -> Option<f64> {
    const FEWEST_BLOCKS: usize = 16;
    let mut levels = block_errors(series);
    levels.retain(|level| level.blocks >= FEWEST_BLOCKS);
    for (index, level) in levels.iter().enumerate() {
        let later = &levels[index + 1..];
        let is_no_larger =
            |later: &BlockError| later.standard_error <= level.standard_error + later.uncertainty;
        if !later.is_empty() && later.iter().all(is_no_larger) {
            return Some(level.standard_error);
        }
    }
    None
}

/// Mean Σ x / n of values; NaN without any.
///
/// ```
/// use protomer_kernel::statistics::mean;
/// assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
/// assert!(mean(&[]).is_nan());
/// ```
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median in the order of a comparison, the upper of the two in the middle for an even count; `None`
/// without values. The values are left in another order.
///
/// ```
/// use protomer_kernel::statistics::median;
/// assert_eq!(median(&mut [5.0, 1.0, 9.0], f64::total_cmp), Some(5.0));
/// assert_eq!(median(&mut [2, 3, 1, 4], Ord::cmp), Some(3));
/// ```
pub fn median<T: Copy>(values: &mut [T], compare: impl FnMut(&T, &T) -> Ordering) -> Option<T> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, compare).1)
}

/// Standard error of an estimate from the B estimates that leave out one block each, by the jackknife
/// (Miller, Biometrika 61, 1 (1974)):
///
/// error² = (B - 1)/B Σ (estimate without a block - their mean)²
///
/// `None` for fewer than two blocks, or if an estimate is not finite.
///
/// ```
/// use protomer_kernel::statistics::jackknife_error;
/// // Means of 1, 2, 4 and 9 without one of them: the error is that of the mean.
/// let without = [5.0, 14.0 / 3.0, 4.0, 7.0 / 3.0];
/// assert!((jackknife_error(&without).unwrap() - (38.0_f64 / 12.0).sqrt()).abs() < 1e-14);
/// ```
pub fn jackknife_error(without_block: &[f64]) -> Option<f64> {
    let moments = RunningMoments::in_two_passes(without_block);
    let blocks = moments.count as f64;
    let error = (moments.squares * (blocks - 1.0) / blocks).sqrt();
    (moments.count > 1 && error.is_finite()).then_some(error)
}

/// Mean and variance of a stream in constant memory, without cancellation (Welford, Technometrics
/// 4, 419 (1962)).
///
/// ```
/// use protomer_kernel::statistics::RunningMoments;
/// let mut moments = RunningMoments::default();
/// for value in [1.0, 2.0, 3.0] {
///     moments.push(value);
/// }
/// assert_eq!((moments.mean(), moments.variance()), (2.0, 1.0));
///
/// let other: RunningMoments = [4.0, 5.0].into_iter().collect();
/// moments.merge(&other);
/// assert_eq!((moments.count(), moments.mean()), (5, 3.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct RunningMoments {
    count: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
}

impl RunningMoments {
    /// Moments of values that are all in memory: first their mean, then Σ (x - mean)². Rounding leaves
    /// the smallest error that way; the last digits can differ from those of a stream.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let moments = RunningMoments::in_two_passes(&[1e9, 1e9 + 2.0]);
    /// assert_eq!((moments.mean(), moments.variance()), (1e9 + 1.0, 2.0));
    /// ```
    pub fn in_two_passes(values: &[f64]) -> Self {
        if values.is_empty() {
            return Self::default();
        }
        let mean = mean(values);
        let squares = values.iter().map(|value| (value - mean).powi(2));
        Self {
            count: values.len() as u64,
            mean,
            squares: squares.sum(),
        }
    }

    /// Adds a value.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let mut moments = RunningMoments::default();
    /// moments.push(2.0);
    /// moments.push(4.0);
    /// assert_eq!((moments.count(), moments.mean(), moments.variance()), (2, 3.0, 2.0));
    /// ```
    pub fn push(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        // One factor before the mean moves and one after: exact, without the cancellation of Σx².
        self.squares += before * (value - self.mean);
    }

    /// Adds all values of another stream (Chan, Golub and LeVeque, Am. Stat. 37, 242 (1983)).
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let mut moments: RunningMoments = [1.0, 3.0].into_iter().collect();
    /// moments.merge(&[5.0, 7.0].into_iter().collect());
    /// assert_eq!((moments.mean(), moments.variance()), (4.0, 20.0 / 3.0));
    /// ```
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (ours, theirs) = (self.count as f64, other.count as f64);
        let difference = other.mean - self.mean;
        self.count += other.count;
        self.mean += difference * theirs / (ours + theirs);
        self.squares += other.squares + difference * difference * ours * theirs / (ours + theirs);
    }

    /// The number of values.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let moments: RunningMoments = [5.0, 5.0, 5.0].into_iter().collect();
    /// assert_eq!(moments.count(), 3, "equal values count each");
    /// ```
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean of the values; NaN without any.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let moments: RunningMoments = [1.0, 2.0, 6.0].into_iter().collect();
    /// assert_eq!(moments.mean(), 3.0);
    /// assert!(RunningMoments::default().mean().is_nan(), "there is no value yet");
    /// ```
    pub fn mean(&self) -> f64 {
        if self.count == 0 { f64::NAN } else { self.mean }
    }

    /// Unbiased variance of the values; zero for fewer than two.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let moments: RunningMoments = [1.0, 3.0, 5.0].into_iter().collect();
    /// assert_eq!(moments.variance(), (4.0 + 0.0 + 4.0) / 2.0);
    /// ```
    pub fn variance(&self) -> f64 {
        if self.count < 2 {
            0.0
        } else {
            self.squares / (self.count - 1) as f64
        }
    }

    /// The square root of the variance.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let moments: RunningMoments = [1.0, 3.0, 5.0].into_iter().collect();
    /// assert_eq!(moments.standard_deviation(), 2.0);
    /// ```
    pub fn standard_deviation(&self) -> f64 {
        self.variance().sqrt()
    }

    /// Root mean square deviation from the mean, √(Σ (x - mean)² / n); NaN without values.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let moments: RunningMoments = [1.0, 5.0].into_iter().collect();
    /// assert_eq!(moments.root_mean_square_deviation(), 2.0);
    /// ```
    pub fn root_mean_square_deviation(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    /// Standard error of the mean of *independent* values, such as the averages of replicas;
    /// infinite for fewer than two.
    ///
    /// ```
    /// use protomer_kernel::statistics::RunningMoments;
    /// let replicas: RunningMoments = [1.0, 1.0, 5.0, 5.0].into_iter().collect();
    /// assert!((replicas.independent_standard_error() - (16.0_f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
    /// ```
    pub fn independent_standard_error(&self) -> f64 {
        if self.count < 2 {
            f64::INFINITY
        } else {
            (self.variance() / self.count as f64).sqrt()
        }
    }
}

impl FromIterator<f64> for RunningMoments {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut moments = Self::default();
        for value in values {
            moments.push(value);
        }
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Normal deviates by Box and Muller over a linear congruential generator with a good
    /// multiplier (L'Ecuyer 1999).
    struct Normal(u64);

    impl Normal {
        fn uniform(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(3_935_559_000_370_003_845)
                .wrapping_add(2_691_343_689_449_507_681);
            ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        }

        fn next(&mut self) -> f64 {
            (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
        }
    }

    /// An autoregressive series: x(t+1) = φ x(t) + √(1-φ²) ξ has ρ(t) = φᵗ, variance 1 and τ = 1/2
    /// + φ/(1-φ) = (1+φ)/(2(1-φ)).
    fn autoregressive(phi: f64, count: usize, seed: u64) -> Vec<f64> {
        let mut normal = Normal(seed);
        let mut value = normal.next();
        (0..count)
            .map(|_| {
                value = phi * value + (1.0 - phi * phi).sqrt() * normal.next();
                value
            })
            .collect()
    }

    fn autoregressive_time(phi: f64) -> f64 {
        (1.0 + phi) / (2.0 * (1.0 - phi))
    }

    #[test]
    fn autocorrelation_times_of_autoregressive_series_are_found() {
        for (seed, phi) in [(1, 0.0), (2, 0.5), (3, 0.9), (4, 0.98)] {
            let (count, exact) = (200_000, autoregressive_time(phi));
            let found = autocorrelation_time(&autoregressive(phi, count, seed));
            let relative_error = (2.0 * (2.0 * 5.0 * exact + 1.0) / count as f64).sqrt();
            // The cut at 5 τ loses about exp(-5) of the sum.
            assert!(
                (found / exact - 1.0).abs() < 3.0 * relative_error + 0.01,
                "phi {phi}: {found} for {exact}"
            );
        }
    }

    #[test]
    fn long_memory_is_found_by_coarsening() {
        // τ = 1000: the window of 5000 is beyond the longest lag.
        let (phi, count) = (0.999, 500_000);
        let exact = autoregressive_time(phi);
        let series = autoregressive(phi, count, 11);
        let relative_error = (2.0 * (2.0 * 5.0 * exact + 1.0) / count as f64).sqrt();
        let found = autocorrelation_time(&series);
        assert!(
            (found / exact - 1.0).abs() < 3.0 * relative_error,
            "{found} for {exact}"
        );
    }

    #[test]
    fn error_bars_cover_the_true_mean_as_often_as_they_should() {
        for phi in [0.0, 0.8, 0.95] {
            let runs = 1000;
            let mut within = [0; 2];
            for seed in 0..runs {
                let summary = summarize(&autoregressive(phi, 4000, 77 + seed * 1000));
                for (count, sigmas) in within.iter_mut().zip([1.0, 2.0]) {
                    *count += usize::from(summary.mean.abs() < sigmas * summary.standard_error);
                }
            }
            // Normal coverage is 0.683 and 0.954; binomial scatter of 1000 runs is 0.015 and 0.007.
            let [one, two] = within.map(|count| count as f64 / runs as f64);
            assert!(
                (0.638..0.728).contains(&one) && (0.933..0.975).contains(&two),
                "phi {phi}: {one} {two}"
            );
        }
    }

    #[test]
    fn naive_errors_would_not_cover() {
        let covered = (0..300)
            .filter(|seed| {
                let moments: RunningMoments = autoregressive(0.95, 4000, 5 + seed * 1000)
                    .into_iter()
                    .collect();
                moments.mean().abs() < moments.independent_standard_error()
            })
            .count();
        assert!(covered < 90, "{covered} of 300");
    }

    #[test]
    fn blocking_agrees_with_the_autocorrelation_time() {
        let series = autoregressive(0.9, 1 << 17, 9);
        let blocked = block_standard_error(&series).unwrap();
        let exact = (2.0 * autoregressive_time(0.9) / series.len() as f64).sqrt();
        assert!(
            (blocked / exact - 1.0).abs() < 0.15,
            "{blocked} for {exact}"
        );
        assert!((summarize(&series).standard_error / exact - 1.0).abs() < 0.05);
        let levels = block_errors(&series);
        assert_eq!(
            (levels.len(), levels[3].block_length, levels[3].blocks),
            (17, 8, 1 << 14)
        );
        // Too short a series has no plateau.
        assert_eq!(block_standard_error(&series[..31]), None);
    }

    #[test]
    fn degenerate_series_are_harmless() {
        assert!(summarize(&[]).mean.is_nan());
        assert_eq!(summarize(&[3.0]).standard_error, f64::INFINITY);
        let constant = summarize(&[0.1; 1000]);
        assert!((constant.mean - 0.1).abs() < 1e-15 && constant.standard_error < 1e-15);
        assert_eq!(constant.autocorrelation_time, 0.5);
        // An alternating series is known better than an independent one, but is not credited for
        // it.
        assert_eq!(autocorrelation_time(&[1.0, -1.0].repeat(100)), 0.5);
        assert!(block_errors(&[1.0]).is_empty());
    }

    #[test]
    fn leaving_out_gives_the_error_of_a_mean() {
        let values: [f64; 4] = [1.0, 2.0, 4.0, 9.0];
        let without: Vec<f64> = values.iter().map(|value| (16.0 - value) / 3.0).collect();
        let error = RunningMoments::in_two_passes(&values).independent_standard_error();
        assert!((jackknife_error(&without).unwrap() - error).abs() < 1e-14);
        assert_eq!(jackknife_error(&[1.0]), None);
        assert_eq!(jackknife_error(&[1.0, f64::NAN]), None);
    }

    #[test]
    fn two_passes_keep_the_spread_of_values_far_from_zero() {
        let moments = RunningMoments::in_two_passes(&[1e9 + 1.0, 1e9 + 2.0, 1e9 + 3.0]);
        assert_eq!((moments.mean(), moments.variance()), (1e9 + 2.0, 1.0));
        assert!((moments.root_mean_square_deviation() - (2.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(
            RunningMoments::in_two_passes(&[]),
            RunningMoments::default()
        );
    }

    proptest! {
        #[test]
        fn running_moments_equal_the_two_pass_formulas(
            values in prop::collection::vec(-1e3..1e3f64, 2..60),
            cut in 0..60usize,
        ) {
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let squares = values.iter().map(|value| (value - mean).powi(2));
            let variance = squares.sum::<f64>() / (count - 1.0);
            let (first, second) = values.split_at(cut.min(values.len()));
            let at_once = RunningMoments::in_two_passes(&values);
            let mut merged: RunningMoments = first.iter().copied().collect();
            merged.merge(&second.iter().copied().collect());
            for moments in [merged, at_once, values.iter().copied().collect()] {
                prop_assert_eq!(moments.count(), values.len() as u64);
                prop_assert!((moments.mean() - mean).abs() < 1e-9);
                prop_assert!((moments.variance() - variance).abs() < 1e-9 * (1.0 + variance));
            }
        }
    }
}
