//! The maximal Lyapunov exponent from a time series.
//!
//! A series x of samples a time Δt apart is embedded, X_j = (x_j, x_(j+τ), ..., x_(j+(m-1)τ)). Pairs of
//! embedded points that are near but more than w samples apart in time are followed for k samples:
//!
//! S(k) = ⟨ln |X_(j+k) - X_(n(j)+k)|⟩ over all j, n(j) the nearest neighbour of j
//! (Rosenstein, Collins and De Luca, Physica D 65, 117 (1993)), or
//! S(k) = ⟨ln ⟨|x_(j+k) - x_(i+k)|⟩_i⟩ with all neighbours i within a radius and x the last coordinate
//! of the embedded point (Kantz, Phys. Lett. A 185, 77 (1994)).
//!
//! Where S is a straight line its slope over Δt is the exponent. Where it is not, there is none to be
//! had from the series: the line is the user's choice, and the residual of the fit says how straight it
//! is. Series of a few thousand samples only; every pair of points is compared.

use crate::error::{CrystalError, Result};
use serde::{Deserialize, Serialize};

/// Embedding of a series, and how long pairs are followed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Embedding {
    /// Dimension m.
    pub dimension: usize,
    /// Delay τ, in samples.
    pub delay: usize,
    /// Pairs are more than so many samples apart, w.
    pub window: usize,
    /// Largest k.
    pub horizon: usize,
}

/// The neighbours whose distance is followed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Neighbourhood {
    /// The nearest neighbour of every point (Rosenstein).
    Nearest,
    /// All neighbours within this radius, in standard deviations of the series (Kantz).
    Within(f64),
}

/// S(k) of k = 0, 1, ..., NaN where no pair is left.
///
/// ```
/// use protomer_linkage::analysis::divergence::{Embedding, Neighbourhood, divergence, slope};
/// // The logistic map: ln 2.
/// let mut x = 0.3;
/// let series: Vec<f64> = (0..2000).map(|_| { x = 4.0 * x * (1.0 - x); x }).collect();
/// let embedding = Embedding { dimension: 2, delay: 1, window: 5, horizon: 6 };
/// let curve = divergence(&series, &embedding, Neighbourhood::Nearest)?;
/// let exponent = slope(&curve, 1.0, 0..=4)?.exponent;
/// assert!((exponent - 2f64.ln()).abs() < 0.05, "{exponent}");
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadState`] for a series too short for the embedding, without spread or with a
/// number that is not finite.
pub fn divergence(
    series: &[f64],
    embedding: &Embedding,
    neighbourhood: Neighbourhood,
) -> Result<Vec<f64>> {
    let points = check(series, embedding)?;
    let embedded = Embedded {
        series,
        dimension: embedding.dimension,
        delay: embedding.delay,
    };
    let horizon = embedding.horizon;
    let mut sums = vec![(0.0, 0.0); horizon + 1];
    // Both members of a pair must have k samples after them.
    let followed = points.saturating_sub(horizon);
    match neighbourhood {
        Neighbourhood::Nearest => {
            for j in 0..followed {
                if let Some(n) = embedded.nearest(j, followed, embedding.window) {
                    for (k, (sum, count)) in sums.iter_mut().enumerate() {
                        let distance = embedded.distance(j + k, n + k);
                        if distance > 0.0 {
                            *sum += distance.ln();
                            *count += 1.0;
                        }
                    }
                }
            }
        }
        Neighbourhood::Within(radius) => {
            let radius = radius * deviation(series);
            for j in 0..followed {
                let neighbours = embedded.within(j, followed, embedding.window, radius);
                if neighbours.is_empty() {
                    continue;
                }
                for (k, (sum, count)) in sums.iter_mut().enumerate() {
                    let distance = embedded.mean_distance_of_last(j + k, &neighbours, k);
                    if distance > 0.0 {
                        *sum += distance.ln();
                        *count += 1.0;
                    }
                }
            }
        }
    }
    Ok(sums.into_iter().map(|(sum, count)| sum / count).collect())
}

/// Number of embedded points.
fn check(series: &[f64], embedding: &Embedding) -> Result<usize> {
    let span = embedding.dimension.saturating_sub(1) * embedding.delay;
    let needed = span + embedding.horizon + 2 * embedding.window + 3;
    if embedding.dimension == 0 || embedding.delay == 0 || series.len() < needed {
        return Err(CrystalError::BadState(format!(
            "{} samples are too few for {} dimensions {} samples apart, followed for {} samples with a \
             window of {}: {needed} are needed, and dimension and delay are at least 1",
            series.len(),
            embedding.dimension,
            embedding.delay,
            embedding.horizon,
            embedding.window
        )));
    }
    let spread = deviation(series);
    if !(spread > 0.0 && spread.is_finite()) {
        return Err(CrystalError::BadState(
            "the series does not vary, or has a number that is not finite".into(),
        ));
    }
    Ok(series.len() - span)
}

fn deviation(series: &[f64]) -> f64 {
    protomer_kernel::statistics::RunningMoments::in_two_passes(series).standard_deviation()
}

struct Embedded<'a> {
    series: &'a [f64],
    dimension: usize,
    delay: usize,
}

impl Embedded<'_> {
    fn distance_squared(&self, a: usize, b: usize) -> f64 {
        let mut sum = 0.0;
        for d in 0..self.dimension {
            let shift = d * self.delay;
            sum += (self.series[a + shift] - self.series[b + shift]).powi(2);
        }
        sum
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        self.distance_squared(a, b).sqrt()
    }

    fn nearest(&self, j: usize, points: usize, window: usize) -> Option<usize> {
        let (mut nearest, mut least) = (None, f64::INFINITY);
        for i in 0..points {
            if i.abs_diff(j) <= window {
                continue;
            }
            let distance = self.distance_squared(i, j);
            if distance > 0.0 && distance < least {
                (nearest, least) = (Some(i), distance);
            }
        }
        nearest
    }

    fn within(&self, j: usize, points: usize, window: usize, radius: f64) -> Vec<usize> {
        let mut neighbours = Vec::new();
        for i in 0..points {
            if i.abs_diff(j) > window && self.distance_squared(i, j) < radius * radius {
                neighbours.push(i);
            }
        }
        neighbours
    }

    /// Mean |x - x'| of the last coordinates of a point and of its former neighbours.
    fn mean_distance_of_last(&self, point: usize, neighbours: &[usize], k: usize) -> f64 {
        let last = (self.dimension - 1) * self.delay;
        let mut sum = 0.0;
        for neighbour in neighbours {
            sum += (self.series[point + last] - self.series[neighbour + k + last]).abs();
        }
        sum / neighbours.len() as f64
    }
}

/// A straight line through part of S(k).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// Slope of S over the time between samples: the exponent, 1/time.
    pub exponent: f64,
    /// Root mean square distance of S from the line.
    pub residual: f64,
}

/// The slope of a curve of [`divergence`] over these k, by least squares.
///
/// # Errors
/// [`CrystalError::BadState`] for fewer than two points, or points without a number.
pub fn slope(
    curve: &[f64],
    time_between_samples: f64,
    range: std::ops::RangeInclusive<usize>,
) -> Result<Slope> {
    let (first, last) = (*range.start(), *range.end());
    let part = curve.get(first..=last).unwrap_or_default();
    if part.len() < 2 || part.iter().any(|value| !value.is_finite()) {
        return Err(CrystalError::BadState(format!(
            "the divergence from sample {first} to {last} has no slope; fit two samples or more \
             within the horizon, and take a longer series"
        )));
    }
    let count = part.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = part.iter().sum::<f64>() / count;
    let (mut up, mut across) = (0.0, 0.0);
    for (k, value) in part.iter().enumerate() {
        up += (k as f64 - middle) * (value - mean);
        across += (k as f64 - middle).powi(2);
    }
    let per_sample = up / across;
    let mut squares = 0.0;
    for (k, value) in part.iter().enumerate() {
        squares += (value - mean - per_sample * (k as f64 - middle)).powi(2);
    }
    Ok(Slope {
        exponent: per_sample / time_between_samples,
        residual: (squares / count).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Hénon map, a = 1.4 and b = 0.3: an exponent of 0.4192.
    fn henon(samples: usize) -> Vec<f64> {
        let (mut x, mut y) = (0.1, 0.1);
        let mut series = Vec::with_capacity(samples);
        for step in 0..samples + 100 {
            (x, y) = (1.0 - 1.4 * x * x + y, 0.3 * x);
            if step >= 100 {
                series.push(x);
            }
        }
        series
    }

    #[test]
    fn both_methods_find_the_exponent_of_a_map() {
        let embedding = Embedding {
            dimension: 2,
            delay: 1,
            window: 10,
            horizon: 12,
        };
        let series = henon(3000);
        for neighbourhood in [Neighbourhood::Nearest, Neighbourhood::Within(0.02)] {
            let curve = divergence(&series, &embedding, neighbourhood).unwrap();
            let line = slope(&curve, 1.0, 1..=6).unwrap();
            assert!((line.exponent - 0.4192).abs() < 0.04, "{line:?}");
            assert!(line.residual < 0.1);
        }
    }

    #[test]
    fn a_periodic_series_has_none() {
        let series: Vec<f64> = (0..2000).map(|k| (0.1 * f64::from(k)).sin()).collect();
        let embedding = Embedding {
            dimension: 3,
            delay: 12,
            window: 40,
            horizon: 60,
        };
        let curve = divergence(&series, &embedding, Neighbourhood::Nearest).unwrap();
        let line = slope(&curve, 0.1, 0..=60).unwrap();
        assert!(line.exponent.abs() < 0.05, "{line:?}");
    }

    #[test]
    fn series_too_short_or_flat_are_refused() {
        let embedding = Embedding {
            dimension: 3,
            delay: 5,
            window: 10,
            horizon: 20,
        };
        for (series, part) in [
            (vec![0.5; 20], "too few"),
            (vec![0.5; 500], "does not vary"),
        ] {
            let error = divergence(&series, &embedding, Neighbourhood::Nearest).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
        assert!(slope(&[0.0, 1.0], 1.0, 1..=1).is_err());
        assert!(slope(&[0.0, 1.0], 1.0, 0..=5).is_err());
    }
}
