//! Temperature scaling: one number that makes confidence honest, fitted on the validation part.
//!
//! p_k(T) ∝ exp(z_k / T), with T chosen for the smallest log-loss (Guo, Pleiss, Sun and Weinberger,
//! ICML 2017). The order of classes stays, so accuracies do not change.

use crate::Result;
use crate::scores::{SMALLEST_PROBABILITY, check};
use protomer_kernel::bisection::halved;

/// Smallest temperature tried.
const SMALLEST: f64 = 1e-2;
/// Largest temperature tried.
const LARGEST: f64 = 1e2;
/// Number of halvings after which the bracket of ln T is as narrow as rounding allows.
const HALVINGS: u32 = 80;

/// The temperature between 0.01 and 100 that gives these probabilities the smallest log-loss; 1 if
/// there is none in between.
///
/// There is none where the samples hold no mistake: the loss falls with any lower temperature, and
/// a single mistake elsewhere would cost without bound. There is none either where the
/// probabilities say nothing of the labels: the loss falls with any higher temperature, towards
/// equal shares.
///
/// In β = 1/T the loss is convex, with the slope Σ w (⟨z⟩_β - z_label) / Σ w, z = ln p. The slope's
/// zero is bracketed in ln β.
///
/// ```
/// use protomer_learn::calibration::{at_temperature, temperature};
///
/// // Sure of itself, and wrong in one case of four.
/// let p = [0.99, 0.01, 0.99, 0.01, 0.99, 0.01, 0.99, 0.01];
/// let found = temperature(&p, &[0, 0, 0, 1], 2, None)?;
/// assert!(found > 1.0, "overconfident");
/// assert!((at_temperature(&p, 2, found)[0] - 0.75).abs() < 1e-9);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) as for
/// [`Scores::from_probabilities`](crate::scores::Scores::from_probabilities).
pub fn temperature(
    p: &[f64],
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
) -> Result<f64> {
    check(p, labels, classes, weights)?;
    // The loss is convex in β = 1 / T: its slope rises, and one sign change is the minimum.
    let slope = |log_beta: f64| slope(p, labels, classes, weights, log_beta.exp());
    // In ln β: the range covers four decades, and both ends deserve the same relative precision.
    let ends = [LARGEST, SMALLEST].map(|temperature| (1.0 / temperature).ln());
    // No change of sign: the loss still falls at one end of the range.
    if slope(ends[0]) >= 0.0 || slope(ends[1]) <= 0.0 {
        return Ok(1.0);
    }
    let [low, high] = halved(ends, HALVINGS, |log_beta| slope(log_beta) < 0.0);
    // T = 1 / β, and the middle of the last bracket.
    Ok((-0.5 * (low + high)).exp())
}

/// Slope of the loss in β, times Σ w: Σ w (⟨z⟩_β - z_label).
fn slope(p: &[f64], labels: &[usize], classes: usize, weights: Option<&[f64]>, beta: f64) -> f64 {
    let mut slope = 0.0;
    for (sample, (label, p)) in labels.iter().zip(p.chunks_exact(classes)).enumerate() {
        let mut mean = 0.0;
        // ⟨z⟩ at β, with z = ln p up to a constant that cancels against z_label.
        for (q, p) in softened(p, beta).iter().zip(p) {
            mean += q * logarithm(*p);
        }
        let weight = weights.map_or(1.0, |weights| weights[sample]);
        slope += weight * (mean - logarithm(p[*label]));
    }
    slope
}

/// The probabilities at a temperature.
///
/// ```
/// use protomer_learn::calibration::at_temperature;
/// let softened = at_temperature(&[0.8, 0.2], 2, 2.0);
/// // Roots of the probabilities: 2 to 1 instead of 4 to 1.
/// assert!((softened[0] - 2.0 / 3.0).abs() < 1e-12);
/// ```
pub fn at_temperature(probabilities: &[f64], classes: usize, temperature: f64) -> Vec<f64> {
    let mut all = Vec::with_capacity(probabilities.len());
    for p in probabilities.chunks_exact(classes.max(1)) {
        all.extend(softened(p, 1.0 / temperature));
    }
    all
}

fn logarithm(probability: f64) -> f64 {
    probability.max(SMALLEST_PROBABILITY).ln()
}

/// Normalised powers p^β.
fn softened(p: &[f64], beta: f64) -> Vec<f64> {
    let mut logits: Vec<f64> = p.iter().map(|p| beta * logarithm(*p)).collect();
    softmax(&mut logits);
    logits
}

/// Replaces each z_k by exp(z_k) / Σ exp(z_j), safe for any finite z.
pub(crate) fn softmax(logits: &mut [f64]) {
    // The largest becomes exp(0) = 1, so the sum is at least 1 and nothing overflows.
    let largest = logits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for logit in logits.iter_mut() {
        *logit = (*logit - largest).exp();
    }
    let sum: f64 = logits.iter().sum();
    for p in logits {
        *p /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scores::Scores;
    use protomer_kernel::random::CounterRng;

    /// Labels drawn from known probabilities, which are then sharpened with a known temperature.
    fn sharpened(temperature: f64) -> (Vec<f64>, Vec<usize>) {
        let mut rng = CounterRng::new(2, 0, 0);
        let (mut p, mut labels) = (Vec::new(), Vec::new());
        for _ in 0..20_000 {
            let mut honest: Vec<f64> = (0..4).map(|_| rng.uniform_in(-2.0, 2.0)).collect();
            softmax(&mut honest);
            let mut left = rng.uniform();
            labels.push(
                honest
                    .iter()
                    .position(|p| {
                        left -= p;
                        left < 0.0
                    })
                    .unwrap_or(3),
            );
            p.extend(at_temperature(&honest, 4, temperature));
        }
        (p, labels)
    }

    #[test]
    fn the_temperature_of_overconfidence_is_found() {
        for applied in [0.4, 1.0, 2.5] {
            let (p, labels) = sharpened(applied);
            let found = temperature(&p, &labels, 4, None).unwrap();
            assert!(
                (found * applied - 1.0).abs() < 0.05,
                "{found} undoes {applied}"
            );
            let (before, after) = (p.clone(), at_temperature(&p, 4, found));
            let score = |p: &[f64]| Scores::from_probabilities(p, &labels, 4, None).unwrap();
            assert!(score(&after).log_loss_nats <= score(&before).log_loss_nats);
            assert!(score(&after).expected_calibration_error < 0.02);
            assert_eq!(score(&after).accuracy, score(&before).accuracy);
        }
    }

    #[test]
    fn no_other_temperature_has_a_smaller_loss() {
        let (p, labels) = sharpened(0.6);
        let (p, labels) = (&p[..400], &labels[..100]);
        let weights: Vec<f64> = (0..100).map(|sample| 1.0 + (sample % 3) as f64).collect();
        let found = temperature(p, labels, 4, Some(&weights)).unwrap();
        let loss = |t: f64| {
            Scores::from_probabilities(&at_temperature(p, 4, t), labels, 4, Some(&weights))
                .unwrap()
                .log_loss_nats
        };
        for other in [0.01, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 100.0] {
            assert!(loss(found) < loss(found * other), "{found} x {other}");
        }
    }

    #[test]
    fn where_no_temperature_is_best_it_stays_one() {
        let without_mistake = temperature(&[0.51, 0.49, 0.49, 0.51], &[0, 1], 2, None).unwrap();
        let without_meaning = temperature(
            &[0.6, 0.4, 0.6, 0.4, 0.3, 0.7, 0.3, 0.7],
            &[0, 1, 0, 1],
            2,
            None,
        )
        .unwrap();
        assert_eq!((without_mistake, without_meaning), (1.0, 1.0));
    }
}
