//! Multinomial logistic regression, the yardstick of what a few numbers predict.

mod minimise;

use crate::Result;
use crate::calibration::softmax;
use crate::error::refuse;
use minimise::minimise;

/// Samples with one row of features each.
#[derive(Debug, Clone, Copy)]
pub struct Table<'a> {
    /// Features, sample after sample.
    pub features: &'a [f64],
    /// Number of features of a sample.
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
///
/// ```
/// use protomer_learn::logistic::{Logistic, Table};
///
/// let table = Table { features: &[-2.0, -1.0, 1.0, 2.0], columns: 1 };
/// let fit = Logistic::fit(table, &[0, 1, 2, 3], &[0, 0, 1, 1], None, 2, 0.1)?;
/// let p = fit.probabilities(table, &[0, 3])?;
/// assert!(p[0] > 0.7 && p[3] > 0.7);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Logistic {
    classes: usize,
    standardisation: Standardisation,
    /// Coefficients: for each class the slopes, then the intercept.
    coefficients: Vec<f64>,
}

impl Logistic {
    /// Fits `samples` of the table by L-BFGS to the smallest
    ///
    /// L = Σ_i w_i (-ln p_label(i)) / Σ_i w_i + ridge/2 Σ_k [ Σ_f A_kf² + (b_k - ln π_k)² ]
    ///
    /// with features standardised over `samples` and π the smoothed shares of the classes
    /// ([`prior`]). A large ridge gives the prior, and classes that do not occur keep a finite
    /// logarithm. L is strictly convex for ridge > 0.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if shapes disagree, a number is not
    /// finite, or the ridge is not positive.
    pub fn fit(
        table: Table,
        samples: &[usize],
        labels: &[usize],
        weights: Option<&[f64]>,
        classes: usize,
        ridge: f64,
    ) -> Result<Self> {
        check_table(table, labels.len())?;
        let rows = labels.len();
        let weighted = weights.is_none_or(|weights| weights.len() == rows);
        let is_known = |sample: &usize| labels.get(*sample).is_some_and(|label| *label < classes);
        let has_labels = !samples.is_empty() && samples.iter().all(is_known);
        let is_ridge = ridge > 0.0 && ridge.is_finite();
        if !has_labels || !weighted || !is_ridge {
            let count = samples.len();
            return refuse(format!(
                "no fit to {count} of {rows} samples with the ridge {ridge}"
            ));
        }
        let sample_weights: Vec<f64> = samples
            .iter()
            // Checked weights belong to all rows; here only those of the fitted samples.
            .map(|sample| weights.map_or(1.0, |weights| weights[*sample]))
            .collect();
        // One ridge for all features only makes sense if all have the same spread.
        let standardisation = Standardisation::fit(table, samples, &sample_weights);
        // Start and centre of the ridge: with no usable feature
        // the model falls back to the prior, not to equal classes.
        let shares = prior(samples, labels, weights, classes);
        let problem = Problem {
            rows: standardisation.rows(table, samples),
            columns: table.columns,
            labels: samples.iter().map(|sample| labels[*sample]).collect(),
            weights: sample_weights,
            log_prior: shares.into_iter().map(f64::ln).collect(),
            ridge,
        };
        let coefficients = minimise(problem.start(), |point, gradient| {
            problem.loss(point, gradient)
        });
        Ok(Self {
            classes,
            standardisation,
            coefficients,
        })
    }

    /// Probabilities for `samples` of a table with the same features, sample after sample.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for another number of features, or
    /// samples that are not in the table.
    pub fn probabilities(&self, table: Table, samples: &[usize]) -> Result<Vec<f64>> {
        let columns = self.standardisation.mean.len();
        if table.columns != columns || samples.iter().any(|sample| *sample >= table.rows()) {
            let given = table.columns;
            return refuse(format!(
                "{given} features, but the fit has {columns}; or no such sample"
            ));
        }
        let mut probabilities = Vec::with_capacity(samples.len() * self.classes);
        for row in self
            .standardisation
            .rows(table, samples)
            .chunks_exact(columns)
        {
            let mut logits = logits(&self.coefficients, row);
            softmax(&mut logits);
            probabilities.extend(logits);
        }
        Ok(probabilities)
    }
}

fn check_table(table: Table, rows: usize) -> Result<()> {
    let Table { features, columns } = table;
    if columns == 0 || features.len() != rows * columns {
        let count = features.len();
        return refuse(format!("{count} features for {rows} samples of {columns}"));
    }
    if let Some(place) = features.iter().position(|value| !value.is_finite()) {
        return refuse(format!(
            "feature {} of sample {} is {}",
            place % columns,
            place / columns,
            features[place]
        ));
    }
    Ok(())
}

/// The share of each class among `samples`, with one more sample spread evenly over the classes, so
/// that no share is zero.
///
/// π_k = (Σ_{i in k} w_i + 1/K) / (Σ_i w_i + 1)
///
/// ```
/// use protomer_learn::logistic::prior;
///
/// // The last sample is not among those counted.
/// assert_eq!(prior(&[0, 1, 2], &[0, 0, 1, 1], None, 2), [0.625, 0.375]);
/// ```
pub fn prior(
    samples: &[usize],
    labels: &[usize],
    weights: Option<&[f64]>,
    classes: usize,
) -> Vec<f64> {
    // As if one more sample had been seen, spread over the classes: its share
    // is positive even if a class is absent, and so its logarithm is finite.
    let mut shares = vec![1.0 / classes.max(1) as f64; classes];
    for sample in samples {
        let label = labels.get(*sample);
        if let Some(share) = label.and_then(|label| shares.get_mut(*label)) {
            let weight = weights.and_then(|weights| weights.get(*sample));
            *share += weight.copied().unwrap_or(1.0);
        }
    }
    let sum: f64 = shares.iter().sum();
    for share in &mut shares {
        *share /= sum;
    }
    shares
}

/// Mean and deviation of each feature; a feature without spread has the deviation 1.
#[derive(Debug, Clone, PartialEq)]
struct Standardisation {
    mean: Vec<f64>,
    deviation: Vec<f64>,
}

impl Standardisation {
    fn fit(table: Table, samples: &[usize], weights: &[f64]) -> Self {
        let total = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let average = |value: &dyn Fn(&[f64]) -> f64| {
            let mut sum = 0.0;
            for (sample, weight) in samples.iter().zip(weights) {
                sum += weight * value(table.row(*sample));
            }
            sum / total
        };
        let (mut mean, mut deviation) = (Vec::new(), Vec::new());
        for column in 0..table.columns {
            let middle = average(&|row| row[column]);
            let spread = average(&|row| (row[column] - middle).powi(2)).sqrt();
            // A constant column leaves a spread of rounding, about 1e-16 of the mean; dividing
            // by it would blow noise up to a feature. The floor serves a column of zeros.
            let has_spread = spread > 1e-12 * middle.abs().max(1e-300);
            mean.push(middle);
            deviation.push(if has_spread { spread } else { 1.0 });
        }
        Self { mean, deviation }
    }

    /// The standardised features of samples.
    fn rows(&self, table: Table, samples: &[usize]) -> Vec<f64> {
        let mut rows = Vec::with_capacity(samples.len() * table.columns);
        for sample in samples {
            for (column, x) in table.row(*sample).iter().enumerate() {
                rows.push((x - self.mean[column]) / self.deviation[column]);
            }
        }
        rows
    }
}

/// Logits b_k + Σ_f A_kf x_f of every class.
fn logits(coefficients: &[f64], row: &[f64]) -> Vec<f64> {
    let mut logits = Vec::new();
    for class in coefficients.chunks_exact(row.len() + 1) {
        let (slopes, intercept) = class.split_at(row.len());
        let sum: f64 = row.iter().zip(slopes).map(|(x, slope)| x * slope).sum();
        logits.push(sum + intercept[0]);
    }
    logits
}

/// Data of the loss that is minimised.
struct Problem {
    /// Standardised features, sample after sample.
    rows: Vec<f64>,
    columns: usize,
    labels: Vec<usize>,
    weights: Vec<f64>,
    log_prior: Vec<f64>,
    ridge: f64,
}

impl Problem {
    /// Starting point: no slopes, and the prior as intercepts.
    fn start(&self) -> Vec<f64> {
        let mut start = Vec::new();
        for log_prior in &self.log_prior {
            // For each class its slopes, then its intercept: class (columns + 1) + column.
            start.resize(start.len() + self.columns, 0.0);
            start.push(*log_prior);
        }
        start
    }

    /// L and its gradient, ∂L/∂A_kf = Σ w (p_k - δ_k) x_f / Σ w + ridge A_kf.
    fn loss(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
        let total = self.weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        gradient.fill(0.0);
        let mut loss = 0.0;
        for (sample, row) in self.rows.chunks_exact(self.columns).enumerate() {
            // Shares, so that the ridge means the same for
            // any number of samples and any scale of weights.
            let share = self.weights[sample] / total;
            loss += self.add_sample(row, self.labels[sample], share, point, gradient);
        }
        for (place, (value, gradient)) in point.iter().zip(gradient).enumerate() {
            // Drawn to the prior, not to 0: a strong ridge then gives
            // the prior, which is the weakest honest prediction.
            let from_centre = value - self.centre(place);
            loss += 0.5 * self.ridge * from_centre.powi(2);
            *gradient += self.ridge * from_centre;
        }
        loss
    }

    /// Adds what a sample gives to the gradient and returns what it gives to the loss.
    fn add_sample(
        &self,
        row: &[f64],
        label: usize,
        share: f64,
        point: &[f64],
        gradient: &mut [f64],
    ) -> f64 {
        let mut p = logits(point, row);
        let label_logit = p[label];
        // Largest logit first: ln Σ exp(z) = z_max + ln Σ exp(z - z_max) cannot overflow.
        let largest = p.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = p.iter().map(|z| (z - largest).exp()).sum();
        softmax(&mut p);
        // ∂/∂z_k of -ln p_label is p_k - δ_k.
        p[label] -= 1.0;
        for (residual, gradient) in p.iter().zip(gradient.chunks_exact_mut(row.len() + 1)) {
            let factor = share * residual;
            // The intercept counts as a last feature that is always 1.
            for (gradient, x) in gradient.iter_mut().zip(row.iter().chain([&1.0])) {
                *gradient += factor * x;
            }
        }
        share * (largest + sum.ln() - label_logit)
    }

    /// Value to which the ridge draws a coefficient: the prior for intercepts, 0 for slopes.
    fn centre(&self, place: usize) -> f64 {
        let (class, column) = (place / (self.columns + 1), place % (self.columns + 1));
        if column == self.columns {
            self.log_prior[class]
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
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
        let log_prior = vec![-1.0, -2.0, -1.5, -1.2];
        let problem = Problem {
            rows,
            columns: 3,
            labels,
            weights,
            log_prior,
            ridge: 0.3,
        };
        let point: Vec<f64> = (0..16).map(|place| 0.1 * place as f64 - 0.7).collect();
        let mut gradient = vec![0.0; 16];
        problem.loss(&point, &mut gradient);
        for place in 0..16 {
            let shifted = |shift: f64| {
                let mut point = point.clone();
                point[place] += shift;
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
        let log_prior = vec![-1.0, -1.0, -1.2];
        let problem = Problem {
            rows,
            columns: 2,
            labels,
            weights,
            log_prior,
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
                crate::scores::Scores::from_probabilities(&p, &labels, 3, None)
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
