//! Multinomial logistic regression, the yardstick of what a few numbers predict.

use crate::calibration::softmax;
use crate::{LearnError, Result};
use std::collections::VecDeque;

const MEMORY: usize = 10;
const MOST_ITERATIONS: usize = 500;
/// Fitting ends when no component of the gradient exceeds this (nats per unit).
const FLAT: f64 = 1e-7;
/// Sufficient decrease (Nocedal and Wright, *Numerical Optimization*, 2006, equation 3.4).
const SUFFICIENT: f64 = 1e-4;
const MOST_HALVINGS: usize = 40;

/// Samples with one row of features each.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    /// Sample after sample.
    pub features: &'a [f64],
    /// Features of a sample.
    pub columns: usize,
}

impl<'a> Table<'a> {
    fn row(&self, sample: usize) -> &'a [f64] {
        &self.features[sample * self.columns..(sample + 1) * self.columns]
    }

    fn rows(&self) -> usize {
        self.features.len() / self.columns.max(1)
    }
}

/// A fitted model: p_k ∝ exp(b_k + Σ_f A_kf (x_f - mean_f) / deviation_f).
#[derive(Debug, Clone, PartialEq)]
pub struct Logistic {
    classes: usize,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    /// For each class the slopes, then the intercept.
    coefficients: Vec<f64>,
}

impl Logistic {
    /// Fits `samples` of the table by L-BFGS to the smallest
    ///
    /// L = Σ_i w_i (-ln p_label(i)) / Σ_i w_i + ridge/2 Σ_k [ Σ_f A_kf² + (b_k - ln π_k)² ]
    ///
    /// with features standardised over `samples` and π the smoothed shares of the classes
    /// ([`prior`]): a large ridge gives the prior, and classes not seen keep a finite logarithm. L
    /// is strictly convex for ridge > 0.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if shapes disagree, a number is not finite, or the ridge is not
    /// positive.
    pub fn fit(
        table: Table,
        samples: &[usize],
        labels: &[usize],
        weights: Option<&[f64]>,
        classes: usize,
        ridge: f64,
    ) -> Result<Self> {
        let rows = labels.len();
        if table.columns == 0 || table.features.len() != rows * table.columns {
            let reason = format!(
                "{} features for {rows} samples of {}",
                table.features.len(),
                table.columns
            );
            return Err(LearnError::Settings(reason));
        }
        let weighted = weights.is_none_or(|weights| weights.len() == rows);
        let known = samples
            .iter()
            .all(|sample| labels.get(*sample).is_some_and(|label| *label < classes));
        let usable = !samples.is_empty() && known && weighted && ridge > 0.0 && ridge.is_finite();
        if !usable {
            let reason = format!(
                "no fit to {} of {rows} samples with the ridge {ridge}",
                samples.len()
            );
            return Err(LearnError::Settings(reason));
        }
        if let Some(place) = table.features.iter().position(|value| !value.is_finite()) {
            let (sample, value) = (place / table.columns, table.features[place]);
            return Err(LearnError::Settings(format!(
                "feature {} of sample {sample} is {value}",
                place % table.columns
            )));
        }
        let weight = |sample: usize| weights.map_or(1.0, |weights| weights[sample]);
        let (mean, deviation) = moments(table, samples, &weight);
        let log_prior: Vec<f64> = prior(samples, labels, weights, classes)
            .iter()
            .map(|p| p.ln())
            .collect();
        let standardised: Vec<f64> = samples
            .iter()
            .flat_map(|sample| {
                table
                    .row(*sample)
                    .iter()
                    .zip(&mean)
                    .zip(&deviation)
                    .map(|((x, m), d)| (x - m) / d)
            })
            .collect();
        let problem = Problem {
            rows: standardised,
            columns: table.columns,
            labels: samples.iter().map(|sample| labels[*sample]).collect(),
            weights: samples.iter().map(|sample| weight(*sample)).collect(),
            log_prior: &log_prior,
            ridge,
        };
        let stride = table.columns + 1;
        let mut start = vec![0.0; classes * stride];
        for (class, log_prior) in log_prior.iter().enumerate() {
            start[class * stride + table.columns] = *log_prior;
        }
        let coefficients = minimise(start, |point, gradient| problem.loss(point, gradient));
        Ok(Self {
            classes,
            mean,
            deviation,
            coefficients,
        })
    }

    /// Probabilities for `samples` of a table with the same features, sample after sample.
    ///
    /// # Errors
    /// [`LearnError::Settings`] for another number of features, or samples that are not in the
    /// table.
    pub fn probabilities(&self, table: Table, samples: &[usize]) -> Result<Vec<f64>> {
        if table.columns != self.mean.len() || samples.iter().any(|sample| *sample >= table.rows())
        {
            let reason = format!(
                "{} features, but the fit has {}; or no such sample",
                table.columns,
                self.mean.len()
            );
            return Err(LearnError::Settings(reason));
        }
        let mut probabilities = Vec::with_capacity(samples.len() * self.classes);
        for sample in samples {
            let standardise = |((x, mean), deviation): ((&f64, &f64), &f64)| (x - mean) / deviation;
            let row: Vec<f64> = table
                .row(*sample)
                .iter()
                .zip(&self.mean)
                .zip(&self.deviation)
                .map(standardise)
                .collect();
            let mut logits = logits(&self.coefficients, &row);
            softmax(&mut logits);
            probabilities.extend(logits);
        }
        Ok(probabilities)
    }
}

/// The share of each class among `samples`, with one more sample spread evenly over the classes: no
/// share is zero.
///
/// π_k = (Σ_{i in k} w_i + 1/K) / (Σ_i w_i + 1)
pub fn prior(
    samples: &[usize],
    labels: &[usize],
    weights: Option<&[f64]>,
    classes: usize,
) -> Vec<f64> {
    let mut shares = vec![1.0 / classes.max(1) as f64; classes];
    for sample in samples {
        if let Some(share) = labels.get(*sample).and_then(|label| shares.get_mut(*label)) {
            *share += weights
                .and_then(|weights| weights.get(*sample))
                .copied()
                .unwrap_or(1.0);
        }
    }
    let sum: f64 = shares.iter().sum();
    shares.into_iter().map(|share| share / sum).collect()
}

/// Mean and deviation of each feature; a feature without spread has the deviation 1.
fn moments(table: Table, samples: &[usize], weight: &dyn Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
    let total: f64 = samples
        .iter()
        .map(|sample| weight(*sample))
        .sum::<f64>()
        .max(f64::MIN_POSITIVE);
    let average = |value: &dyn Fn(usize) -> f64| {
        samples.iter().map(|s| weight(*s) * value(*s)).sum::<f64>() / total
    };
    let means: Vec<f64> = (0..table.columns)
        .map(|column| average(&|sample| table.row(sample)[column]))
        .collect();
    let deviation = |(column, mean): (usize, &f64)| {
        let variance = average(&|sample| (table.row(sample)[column] - mean).powi(2));
        if variance.sqrt() > 1e-12 * mean.abs().max(1e-300) {
            variance.sqrt()
        } else {
            1.0
        }
    };
    let deviations = means.iter().enumerate().map(deviation).collect();
    (means, deviations)
}

fn logits(coefficients: &[f64], row: &[f64]) -> Vec<f64> {
    let logit = |class: &[f64]| {
        row.iter()
            .zip(class)
            .map(|(x, slope)| x * slope)
            .sum::<f64>()
            + class[row.len()]
    };
    coefficients
        .chunks_exact(row.len() + 1)
        .map(logit)
        .collect()
}

struct Problem<'a> {
    rows: Vec<f64>,
    columns: usize,
    labels: Vec<usize>,
    weights: Vec<f64>,
    log_prior: &'a [f64],
    ridge: f64,
}

impl Problem<'_> {
    /// L and its gradient, ∂L/∂A_kf = Σ w (p_k - δ_k) x_f / Σ w + ridge A_kf.
    fn loss(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
        let stride = self.columns + 1;
        let total: f64 = self.weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        gradient.fill(0.0);
        let mut loss = 0.0;
        for ((row, label), weight) in self
            .rows
            .chunks_exact(self.columns)
            .zip(&self.labels)
            .zip(&self.weights)
        {
            let mut p = logits(point, row);
            let label_logit = p[*label];
            let largest = p.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            loss += weight / total
                * (largest + p.iter().map(|z| (z - largest).exp()).sum::<f64>().ln() - label_logit);
            softmax(&mut p);
            p[*label] -= 1.0;
            for (residual, gradient) in p.iter().zip(gradient.chunks_exact_mut(stride)) {
                let factor = weight / total * residual;
                for (gradient, x) in gradient.iter_mut().zip(row.iter().chain([&1.0])) {
                    *gradient += factor * x;
                }
            }
        }
        for (place, (value, gradient)) in point.iter().zip(gradient).enumerate() {
            let centre = if place % stride == self.columns {
                self.log_prior[place / stride]
            } else {
                0.0
            };
            loss += 0.5 * self.ridge * (value - centre).powi(2);
            *gradient += self.ridge * (value - centre);
        }
        loss
    }
}

/// Minimises a smooth convex function with the limited-memory method of Broyden, Fletcher, Goldfarb
/// and Shanno: the two-loop recursion (Nocedal and Wright, algorithm 7.4) and step halving until
/// the decrease suffices.
fn minimise(mut point: Vec<f64>, mut function: impl FnMut(&[f64], &mut [f64]) -> f64) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut gradient = vec![0.0; point.len()];
    let mut value = function(&point, &mut gradient);
    // Steps s, changes of the gradient y, and 1 / (s y).
    let mut history: VecDeque<(Vec<f64>, Vec<f64>, f64)> = VecDeque::new();
    for _ in 0..MOST_ITERATIONS {
        if gradient.iter().all(|component| component.abs() < FLAT) {
            break;
        }
        let mut direction = gradient.clone();
        let mut projections = Vec::with_capacity(history.len());
        for (step, change, inverse) in history.iter().rev() {
            let projection = inverse * dot(step, &direction);
            direction
                .iter_mut()
                .zip(change)
                .for_each(|(d, y)| *d -= projection * y);
            projections.push(projection);
        }
        if let Some((_, change, inverse)) = history.back() {
            let scale = 1.0 / (inverse * dot(change, change));
            direction.iter_mut().for_each(|d| *d *= scale);
        }
        for ((step, change, inverse), projection) in history.iter().zip(projections.iter().rev()) {
            let correction = projection - inverse * dot(change, &direction);
            direction
                .iter_mut()
                .zip(step)
                .for_each(|(d, s)| *d += correction * s);
        }
        let slope = dot(&gradient, &direction);
        let mut length = 1.0;
        let (mut next, mut next_gradient, mut next_value) =
            (point.clone(), gradient.clone(), f64::INFINITY);
        for _ in 0..MOST_HALVINGS {
            next.iter_mut()
                .zip(&point)
                .zip(&direction)
                .for_each(|((n, p), d)| *n = p - length * d);
            next_value = function(&next, &mut next_gradient);
            if next_value <= value - SUFFICIENT * length * slope {
                break;
            }
            length *= 0.5;
        }
        if next_value.partial_cmp(&value) != Some(std::cmp::Ordering::Less) {
            break; // Rounding hides any further decrease.
        }
        let step: Vec<f64> = next.iter().zip(&point).map(|(n, p)| n - p).collect();
        let change: Vec<f64> = next_gradient
            .iter()
            .zip(&gradient)
            .map(|(n, g)| n - g)
            .collect();
        let curvature = dot(&step, &change);
        if curvature > 0.0 {
            history.push_back((step, change, 1.0 / curvature));
            if history.len() > MEMORY {
                history.pop_front();
            }
        }
        (point, gradient, value) = (next, next_gradient, next_value);
    }
    point
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use protomer_kernel::random::CounterRng;

    fn set(rows: usize, columns: usize, classes: usize) -> (Vec<f64>, Vec<usize>, Vec<f64>) {
        let mut rng = CounterRng::new(8, 0, 0);
        let features: Vec<f64> = (0..rows * columns)
            .map(|_| rng.uniform_in(-2.0, 5.0))
            .collect();
        let label =
            |row: &[f64], noise: f64| ((row[0] + 2.0 * noise).max(0.0) as usize).min(classes - 1);
        let labels = features
            .chunks(columns)
            .map(|row| label(row, rng.uniform()))
            .collect();
        let weights = (0..rows).map(|row| 0.5 + (row % 4) as f64).collect();
        (features, labels, weights)
    }

    #[test]
    fn the_gradient_is_that_of_the_loss() {
        let (rows, labels, weights) = set(30, 3, 4);
        let log_prior = [-1.0, -2.0, -1.5, -1.2];
        let problem = Problem {
            rows,
            columns: 3,
            labels,
            weights,
            log_prior: &log_prior,
            ridge: 0.3,
        };
        let point: Vec<f64> = (0..16).map(|place| 0.1 * place as f64 - 0.7).collect();
        let mut gradient = vec![0.0; 16];
        problem.loss(&point, &mut gradient);
        for place in 0..16 {
            let shifted = |by: f64| {
                let mut point = point.clone();
                point[place] += by;
                problem.loss(&point, &mut [0.0; 16])
            };
            let difference = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
            assert!(
                (difference - gradient[place]).abs() < 1e-8,
                "{place}: {difference} {}",
                gradient[place]
            );
        }
    }

    /// The slow twin: plain gradient descent with a small step, many times.
    #[test]
    fn gradient_descent_ends_at_the_same_point() {
        let (rows, labels, weights) = set(40, 2, 3);
        let log_prior = [-1.0, -1.0, -1.2];
        let problem = Problem {
            rows,
            columns: 2,
            labels,
            weights,
            log_prior: &log_prior,
            ridge: 0.1,
        };
        let found = minimise(vec![0.0; 9], |point, gradient| {
            problem.loss(point, gradient)
        });
        let (mut slow, mut gradient) = (vec![0.0; 9], vec![0.0; 9]);
        for _ in 0..20_000 {
            problem.loss(&slow, &mut gradient);
            slow.iter_mut()
                .zip(&gradient)
                .for_each(|(x, g)| *x -= 0.1 * g);
        }
        for (fast, slow) in found.iter().zip(&slow) {
            assert!((fast - slow).abs() < 1e-5, "{fast} {slow}");
        }
    }

    #[test]
    fn a_strong_ridge_gives_the_prior_and_a_weak_one_learns() {
        let (features, labels, weights) = set(300, 2, 3);
        let table = Table {
            features: &features,
            columns: 2,
        };
        let samples: Vec<usize> = (0..300).collect();
        let loss = |ridge| {
            let fit = Logistic::fit(table, &samples, &labels, Some(&weights), 3, ridge).unwrap();
            let p = fit.probabilities(table, &samples).unwrap();
            (
                p[..3].to_vec(),
                crate::scores::Scores::of(&p, &labels, 3, None)
                    .unwrap()
                    .log_loss_nats,
            )
        };
        let prior = prior(&samples, &labels, Some(&weights), 3);
        for (p, expected) in loss(1e9).0.iter().zip(&prior) {
            assert!((p - expected).abs() < 1e-6);
        }
        assert!(
            loss(1e-4).1 < 0.6 * loss(1e9).1,
            "{} {}",
            loss(1e-4).1,
            loss(1e9).1
        );
    }

    #[test]
    fn units_do_not_matter_and_constants_do_no_harm() {
        let (features, labels, _) = set(60, 2, 3);
        let other: Vec<f64> = features
            .chunks(2)
            .flat_map(|x| [1e4 * x[0] - 3.0, 1e-3 * x[1], 7.0])
            .collect();
        let samples: Vec<usize> = (0..60).collect();
        let p = |table: Table| {
            let fit = Logistic::fit(table, &samples, &labels, None, 3, 0.01).unwrap();
            fit.probabilities(table, &samples).unwrap()
        };
        let first = p(Table {
            features: &features,
            columns: 2,
        });
        let second = p(Table {
            features: &other,
            columns: 3,
        });
        assert!(first.iter().zip(&second).all(|(a, b)| (a - b).abs() < 1e-5));
    }

    #[test]
    fn nonsense_is_refused() {
        let (mut features, labels, _) = set(10, 2, 3);
        let samples = [0, 1, 2];
        let fit = |features: &[f64], samples: &[usize], ridge| {
            Logistic::fit(
                Table {
                    features,
                    columns: 2,
                },
                samples,
                &labels,
                None,
                3,
                ridge,
            )
        };
        assert!(fit(&features, &samples, 0.0).is_err());
        assert!(fit(&features, &[10], 0.1).is_err());
        let fitted = fit(&features, &samples, 0.1).unwrap();
        assert!(
            fitted
                .probabilities(
                    Table {
                        features: &features,
                        columns: 4
                    },
                    &[0]
                )
                .is_err()
        );
        features[3] = f64::NAN;
        assert!(fit(&features, &samples, 0.1).is_err());
    }
}
