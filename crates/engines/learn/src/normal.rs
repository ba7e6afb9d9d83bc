//! A number with its spread: the network gives mean and spread of a normal distribution.
//!
//! With a number y in units of the spread S of the training part about its mean M, t = (y - M)/S, and the
//! two outputs m and u of the network, the loss is the negative logarithm of the density (Nix and Weigend,
//! ICNN 1994),
//!
//! ```text
//! L = ½ ((t - m)/σ)² + ln σ + ½ ln 2π,   ln σ = 5 tanh(u/5)
//! ```
//!
//! which keeps σ between 0.0067 and 150. The prediction for y is M + S m with the standard deviation S σ.

use crate::Result;
use crate::error::refuse;
use crate::number_classes::NumberClasses;
use candle_core::Tensor;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};

/// Outputs of a network that predicts a number: mean, and what decides the spread.
pub const OUTPUTS: usize = 2;
/// Largest size of ln σ.
const WIDEST: f64 = 5.0;
/// Below this the series for the error function converges fast; above it the continued fraction does.
const SERIES: f64 = 2.5;

/// A predicted number, in the unit of the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictedNumber {
    /// The prediction.
    pub mean: f64,
    /// Standard deviation that the network expects the truth to have about it.
    pub spread: f64,
}

/// Mean and spread of the numbers of a training part, by which a network's outputs become numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NormalHead {
    /// Mean of the numbers of the training part.
    pub mean: f64,
    /// Standard deviation of the numbers of the training part.
    pub spread: f64,
}

impl NormalHead {
    /// The mean and spread of weighted numbers: (number, weight).
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if they are all the same, or none.
    pub fn fit(weighted: &[(f64, f64)]) -> Result<Self> {
        let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
        let mean = weighted.iter().map(|(y, weight)| weight * y).sum::<f64>() / total;
        let squares = weighted
            .iter()
            .map(|(y, weight)| weight * (y - mean).powi(2));
        let spread = (squares.sum::<f64>() / total).sqrt();
        match spread > 0.0 && spread.is_finite() {
            true => Ok(Self { mean, spread }),
            false => refuse(
                "the numbers of the training part are all the same; there is nothing to learn",
            ),
        }
    }

    /// A number in units of the spread, from the mean.
    pub fn standardised(&self, number: f64) -> f64 {
        (number - self.mean) / self.spread
    }

    /// The number that two outputs of a network predict, its spread multiplied by `temperature`.
    ///
    /// ```
    /// use protomer_learn::normal::NormalHead;
    /// let head = NormalHead { mean: 10.0, spread: 4.0 };
    /// let predicted = head.predicted([0.5, 0.0], 1.0);
    /// assert_eq!((predicted.mean, predicted.spread), (12.0, 4.0));
    /// ```
    pub fn predicted(&self, [mean, width]: [f32; OUTPUTS], temperature: f64) -> PredictedNumber {
        let log_spread = WIDEST * (f64::from(width) / WIDEST).tanh();
        PredictedNumber {
            mean: self.mean + self.spread * f64::from(mean),
            spread: self.spread * log_spread.exp() * temperature,
        }
    }
}

impl PredictedNumber {
    /// The probability of each class of a number.
    ///
    /// ```
    /// use protomer_learn::normal::PredictedNumber;
    /// use protomer_learn::number_classes::NumberClasses;
    /// let classes = NumberClasses { bounds: vec![2.0], means: vec![1.0, 3.0] };
    /// let middle = PredictedNumber { mean: 2.0, spread: 0.5 };
    /// assert_eq!(middle.probabilities(&classes), [0.5, 0.5]);
    /// ```
    pub fn probabilities(&self, classes: &NumberClasses) -> Vec<f64> {
        let below = classes.bounds.iter();
        let below = below.map(|bound| normal_below((bound - self.mean) / self.spread));
        let mut probabilities = Vec::with_capacity(classes.count());
        let mut before = 0.0;
        for below in below.chain([1.0]) {
            // Rounding must not make a share of nothing negative.
            probabilities.push((below - before).max(0.0));
            before = below;
        }
        probabilities
    }

    /// Negative logarithm of the density at a number, nats, in units of `head`'s spread.
    pub fn loss_nats(&self, number: f64, head: &NormalHead) -> f64 {
        let distance = (number - self.mean) / self.spread;
        0.5 * distance.powi(2) + (self.spread / head.spread).ln() + 0.5 * (2.0 * PI).ln()
    }

    /// The mixture of several predictions in equal parts: its mean and its standard deviation.
    pub(crate) fn mixed(predictions: &[Self]) -> Self {
        let count = predictions.len().max(1) as f64;
        let mean = predictions.iter().map(|one| one.mean).sum::<f64>() / count;
        let squares = predictions
            .iter()
            .map(|one| one.spread.powi(2) + (one.mean - mean).powi(2));
        Self {
            mean,
            spread: (squares.sum::<f64>() / count).sqrt(),
        }
    }
}

/// Weighted mean of the losses of a batch, nats, a scalar tensor: `outputs` is (B, 2), `targets` are
/// standardised numbers.
///
/// ```
/// use candle_core::{Device, Tensor};
/// use protomer_learn::normal::normal_loss;
///
/// let outputs = Tensor::new(&[[1f32, 0.0]], &Device::Cpu)?;
/// let loss = normal_loss(&outputs, &[3.0], &[1.0])?.to_scalar::<f32>()?;
/// assert!((loss - (2.0 + 0.5 * (2.0 * std::f32::consts::PI).ln())).abs() < 1e-6);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if the lengths differ.
pub fn normal_loss(outputs: &Tensor, targets: &[f32], weights: &[f32]) -> Result<Tensor> {
    let (samples, columns) = outputs.dims2()?;
    if columns != OUTPUTS || targets.len() != samples || weights.len() != samples {
        return refuse(format!(
            "{samples} rows of {columns} outputs, {} numbers and {} weights: give two outputs, a number \
             and a weight per sample",
            targets.len(),
            weights.len()
        ));
    }
    let device = outputs.device();
    let (targets, shares) = (Tensor::new(targets, device)?, Tensor::new(weights, device)?);
    let mean = outputs.narrow(1, 0, 1)?.squeeze(1)?;
    let width = outputs.narrow(1, 1, 1)?.squeeze(1)?;
    let log_spread = ((width / WIDEST)?.tanh()? * WIDEST)?;
    let distance = ((targets - mean)? * log_spread.neg()?.exp()?)?;
    let losses = (((distance.sqr()? * 0.5)? + log_spread)? + 0.5 * (2.0 * PI).ln())?;
    let total = f64::from(weights.iter().sum::<f32>());
    Ok(((losses * shares)?.sum_all()? / total)?)
}

/// Temperature of spreads: the root of the weighted mean of ((number - mean) / spread)², which
/// minimises the loss.
pub(crate) fn spread_temperature(distances: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (distance, weight) in distances {
        sum += weight * distance.powi(2);
        total += weight;
    }
    match sum > 0.0 && total > 0.0 {
        true => (sum / total).sqrt(),
        false => 1.0,
    }
}

/// The share of a standard normal distribution below x.
fn normal_below(x: f64) -> f64 {
    0.5 * complementary_error_function(-x / SQRT_2)
}

/// 1 - erf(x) (Abramowitz and Stegun, 7.1.6 and 7.1.14).
fn complementary_error_function(x: f64) -> f64 {
    let size = x.abs();
    let tail = if size < SERIES {
        let (mut term, mut sum, mut n) = (size, size, 0.0);
        while term > 1e-17 * sum {
            n += 1.0;
            term *= 2.0 * size * size / (2.0 * n + 1.0);
            sum += term;
        }
        1.0 - 2.0 / PI.sqrt() * (-size * size).exp() * sum
    } else {
        let mut fraction = size;
        for n in (1..60).rev() {
            fraction = size + 0.5 * f64::from(n) / fraction;
        }
        (-size * size).exp() / (PI.sqrt() * fraction)
    };
    if x < 0.0 { 2.0 - tail } else { tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use candle_core::{Device, Var};

    #[test]
    fn the_error_function_has_its_tabulated_values() {
        for (x, expected) in [
            (0.0, 1.0),
            (0.5, 0.479_500_122_186_953_5),
            (1.0, 0.157_299_207_050_285_13),
            (2.4, 6.885_138_966_450_79e-4),
            (2.6, 2.360_344_165_293_49e-4),
            (5.0, 1.537_459_794_428_034_8e-12),
            (-1.0, 1.842_700_792_949_715),
        ] {
            let value = complementary_error_function(x);
            assert!(
                (value / expected - 1.0).abs() < 1e-9,
                "{x}: {value:e} {expected:e}"
            );
        }
    }

    /// The slow twin: the density summed over each class.
    #[test]
    fn shares_of_classes_are_integrals_of_the_density() {
        let classes = NumberClasses {
            bounds: vec![-1.0, 0.5, 2.0],
            means: vec![0.0; 4],
        };
        let predicted = PredictedNumber {
            mean: 0.7,
            spread: 1.3,
        };
        let value = predicted.probabilities(&classes);
        let mut expected = [0.0; 4];
        let step = 1e-4;
        for i in -130_000..130_000 {
            let y = 0.7 + (f64::from(i) + 0.5) * step;
            let density = (-0.5 * ((y - 0.7) / 1.3_f64).powi(2)).exp() / (1.3 * (2.0 * PI).sqrt());
            expected[classes.class_of(y)] += density * step;
        }
        for (value, expected) in value.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-4, "{value} {expected}");
        }
        assert!((value.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// The loss in doubles is the twin of the tensors, and differences of losses are the gradient.
    #[test]
    fn loss_and_gradient_are_those_of_the_density() {
        let head = NormalHead {
            mean: 5.0,
            spread: 2.0,
        };
        let outputs = [[0.3f32, -0.8], [-1.2, 0.6], [0.0, 4.0]];
        let (numbers, weights) = ([6.0, 1.0, 9.0], [1.0f32, 0.5, 2.0]);
        let targets = numbers.map(|number| head.standardised(number) as f32);
        let loss = |outputs: &[[f32; 2]; 3]| {
            let losses = outputs.iter().zip(numbers).zip(weights);
            let losses = losses.map(|((outputs, number), weight)| {
                f64::from(weight) * head.predicted(*outputs, 1.0).loss_nats(number, &head)
            });
            losses.sum::<f64>() / 3.5
        };
        let variable = Var::new(&outputs, &Device::Cpu).unwrap();
        let value = normal_loss(variable.as_tensor(), &targets, &weights).unwrap();
        assert!((f64::from(value.to_scalar::<f32>().unwrap()) - loss(&outputs)).abs() < 1e-5);
        let gradients = value.backward().unwrap();
        let gradients = gradients.get(&variable).unwrap().to_vec2::<f32>().unwrap();
        for row in 0..3 {
            for column in 0..2 {
                let (mut above, mut below) = (outputs, outputs);
                above[row][column] += 1e-2;
                below[row][column] -= 1e-2;
                let slope = (loss(&above) - loss(&below)) / 2e-2;
                let value = f64::from(gradients[row][column]);
                assert!(
                    (value - slope).abs() < 2e-3 * (1.0 + slope.abs()),
                    "{value} {slope}"
                );
            }
        }
    }

    #[test]
    fn the_temperature_makes_distances_one_on_average() {
        let temperature = spread_temperature([(1.0, 1.0), (-3.0, 1.0)].into_iter());
        assert!((temperature - 5f64.sqrt()).abs() < 1e-12);
        assert_eq!(spread_temperature([].into_iter()), 1.0);
        let mixed = PredictedNumber::mixed(&[
            PredictedNumber {
                mean: 0.0,
                spread: 1.0,
            },
            PredictedNumber {
                mean: 2.0,
                spread: 1.0,
            },
        ]);
        assert_eq!((mixed.mean, mixed.spread), (1.0, 2f64.sqrt()));
        assert!(NormalHead::fit(&[(1.0, 1.0), (1.0, 2.0)]).is_err());
    }
}
