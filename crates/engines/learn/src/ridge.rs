//! Linear regression of a number with a ridge: what is predicted of numbers without a network.

use crate::Result;
use crate::error::refuse;
use crate::logistic::Table;

/// A linear regression of standardised features.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridge {
    means: Vec<f64>,
    scales: Vec<f64>,
    /// One coefficient per standardised feature.
    coefficients: Vec<f64>,
    intercept: f64,
}

impl Ridge {
    /// Minimises Σ w (y - a - b·x)² / Σ w + λ b² over standardised features x.
    ///
    /// ```
    /// use protomer_learn::logistic::Table;
    /// use protomer_learn::ridge::Ridge;
    /// let table = Table { features: &[0.0, 1.0, 2.0, 3.0], columns: 1 };
    /// let line = Ridge::fit(table, &[0, 1, 2, 3], &[1.0, 3.0, 5.0, 7.0], &[1.0; 4], 0.0)?;
    /// assert!((line.predicted(table, &[3])[0] - 7.0).abs() < 1e-6);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) without samples.
    pub fn fit(
        table: Table,
        samples: &[usize],
        numbers: &[f64],
        weights: &[f64],
        ridge: f64,
    ) -> Result<Self> {
        let total: f64 = samples.iter().map(|sample| weights[*sample]).sum();
        if total <= 0.0 {
            return refuse("a regression of no samples");
        }
        let columns = table.columns;
        let mean = |value: &dyn Fn(usize) -> f64| {
            let terms = samples
                .iter()
                .map(|sample| weights[*sample] * value(*sample));
            terms.sum::<f64>() / total
        };
        let intercept = mean(&|sample| numbers[sample]);
        let (mut means, mut scales) = (Vec::new(), Vec::new());
        for column in 0..columns {
            let value = |sample: usize| table.features[sample * columns + column];
            let centre = mean(&value);
            let variance = mean(&|sample| (value(sample) - centre).powi(2));
            means.push(centre);
            // A feature that is always the same says nothing, and stays at zero.
            scales.push(if variance > 0.0 {
                variance.sqrt().recip()
            } else {
                0.0
            });
        }
        let mut fit = Self {
            means,
            scales,
            coefficients: vec![0.0; columns],
            intercept,
        };
        let mut matrix = vec![0.0; columns * columns];
        let mut right = vec![0.0; columns];
        for sample in samples {
            let x = fit.standardised(table, *sample);
            let weight = weights[*sample] / total;
            for (row, a) in x.iter().enumerate() {
                right[row] += weight * a * (numbers[*sample] - intercept);
                for (column, b) in x.iter().enumerate() {
                    matrix[row * columns + column] += weight * a * b;
                }
            }
        }
        for row in 0..columns {
            // The second term keeps shares that sum to one, such as a composition, solvable.
            matrix[row * columns + row] += ridge + 1e-9;
        }
        fit.coefficients = solve(matrix, right);
        Ok(fit)
    }

    /// The numbers of samples.
    pub fn predicted(&self, table: Table, samples: &[usize]) -> Vec<f64> {
        let of_sample = |sample: &usize| {
            let x = self.standardised(table, *sample);
            let terms = x.iter().zip(&self.coefficients).map(|(x, b)| x * b);
            self.intercept + terms.sum::<f64>()
        };
        samples.iter().map(of_sample).collect()
    }

    fn standardised(&self, table: Table, sample: usize) -> Vec<f64> {
        let row = &table.features[sample * table.columns..(sample + 1) * table.columns];
        let scaled = row.iter().zip(&self.means).zip(&self.scales);
        scaled
            .map(|((x, mean), scale)| (x - mean) * scale)
            .collect()
    }
}

/// The solution of a symmetric positive definite system, by Cholesky's decomposition.
fn solve(mut matrix: Vec<f64>, mut right: Vec<f64>) -> Vec<f64> {
    let size = right.len();
    for j in 0..size {
        for k in 0..j {
            for i in j..size {
                matrix[i * size + j] -= matrix[i * size + k] * matrix[j * size + k];
            }
        }
        let root = matrix[j * size + j].max(f64::MIN_POSITIVE).sqrt();
        for i in j..size {
            matrix[i * size + j] /= root;
        }
    }
    for i in 0..size {
        for k in 0..i {
            right[i] -= matrix[i * size + k] * right[k];
        }
        right[i] /= matrix[i * size + i];
    }
    for i in (0..size).rev() {
        for k in i + 1..size {
            right[i] -= matrix[k * size + i] * right[k];
        }
        right[i] /= matrix[i * size + i];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// At the minimum no small step of a coefficient lowers the cost: the slow twin of the equations.
    #[test]
    fn no_step_from_the_minimum_lowers_the_cost() {
        let mut random = CounterRng::new(5, 0, 0);
        let features: Vec<f64> = (0..120).map(|_| random.uniform_in(-2.0, 3.0)).collect();
        let table = Table {
            features: &features,
            columns: 3,
        };
        let samples: Vec<usize> = (0..40).collect();
        let number = |row: &[f64]| 2.0 + row[0] - 0.5 * row[2];
        let numbers: Vec<f64> = features
            .chunks(3)
            .map(|row| number(row) + random.uniform_in(-0.3, 0.3))
            .collect();
        let weights: Vec<f64> = (0..40).map(|i| 1.0 + f64::from(i % 3)).collect();
        let cost = |fit: &Ridge| {
            let predicted = fit.predicted(table, &samples);
            let errors = predicted.iter().zip(&numbers).zip(&weights);
            let squares = errors.map(|((x, y), w)| w * (x - y).powi(2)).sum::<f64>();
            let ridge = fit.coefficients.iter().map(|b| b * b).sum::<f64>();
            squares / weights.iter().sum::<f64>() + 0.1 * ridge
        };
        let fit = Ridge::fit(table, &samples, &numbers, &weights, 0.1).unwrap();
        for column in 0..3 {
            for step in [-1e-3, 1e-3] {
                let mut other = fit.clone();
                other.coefficients[column] += step;
                assert!(cost(&other) > cost(&fit));
            }
        }
        for step in [-1e-3, 1e-3] {
            let intercept = fit.intercept + step;
            assert!(
                cost(&Ridge {
                    intercept,
                    ..fit.clone()
                }) > cost(&fit)
            );
        }
    }

    #[test]
    fn features_that_depend_on_each_other_are_solved() {
        let mut features = Vec::new();
        for i in 0..20 {
            let share = f64::from(i) / 20.0;
            features.extend([share, 1.0 - share, 7.0]);
        }
        let table = Table {
            features: &features,
            columns: 3,
        };
        let numbers: Vec<f64> = (0..20).map(|i| 3.0 * f64::from(i)).collect();
        let samples: Vec<usize> = (0..20).collect();
        let fit = Ridge::fit(table, &samples, &numbers, &[1.0; 20], 0.0).unwrap();
        for (found, expected) in fit.predicted(table, &samples).iter().zip(&numbers) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
        assert!(Ridge::fit(table, &[], &numbers, &[1.0; 20], 0.0).is_err());
    }
}
