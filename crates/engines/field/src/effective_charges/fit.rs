//! Charges at given sites whose screened potential is nearest to given values: regularised least
//! squares,
//!
//! ```text
//! Σ_p w_p² (Σ_j g_pj q_j - φ_p)² + ε Σ_j q_j² -> min,   g_pj = λ_B exp(-κ r_pj)/r_pj.
//! ```
//!
//! The weights make the layers count alike, each relative to its own potential: the near ones shape
//! the pattern, the far ones the net charge.

use super::places::Place;
use crate::{FieldError, Result};
use nalgebra::{Cholesky, DMatrix, DVector};
use protomer_kernel::Vec3;
use rayon::prelude::*;

/// ε over the mean of the diagonal of the normal equations.
const REGULARISATION: f64 = 1e-8;
/// A layer whose potential nearly vanishes counts relative to this part of what a layer before it,
/// screened up to here, would have: no accuracy is requested below the noise of the grid.
const LEAST_PART: f64 = 0.02;

/// The result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The charge of each site, e.
    pub charges_e: Vec<f64>,
    /// Root mean square of the weighted errors.
    pub relative_residual: f64,
    /// Ratio of the largest to the smallest pivot, squared.
    pub condition: f64,
}

/// Fits charges at sites to the potential at points.
///
/// # Errors
/// [`FieldError::BadInput`] if there are no points, or the equations cannot be solved.
pub fn fit(sites: &[Vec3], points: &[Place], bjerrum: f64, kappa: f64) -> Result<Fit> {
    let unsolvable =
        || FieldError::BadInput("effective charges cannot be fitted to this potential".into());
    let weights = weights(points, kappa);
    let rows: Vec<Vec<f64>> = points
        .par_iter()
        .zip(&weights)
        .map(|(point, weight)| {
            let greens = sites.iter().map(|site| {
                let r = (point.position - site).norm();
                weight * bjerrum * (-kappa * r).exp() / r
            });
            greens.collect()
        })
        .collect();
    let matrix = DMatrix::from_fn(points.len(), sites.len(), |p, j| rows[p][j]);
    drop(rows);
    let wanted = DVector::from_iterator(
        points.len(),
        points
            .iter()
            .zip(&weights)
            .map(|(point, weight)| weight * point.potential_kt_per_e),
    );
    let mut normal = matrix.tr_mul(&matrix);
    let right = matrix.tr_mul(&wanted);
    let mean_diagonal = normal.diagonal().mean();
    for j in 0..sites.len() {
        normal[(j, j)] += REGULARISATION * mean_diagonal;
    }
    let factor = Cholesky::new(normal).ok_or_else(unsolvable)?;
    let charges = factor.solve(&right);
    let residual = (&matrix * &charges - &wanted).norm();
    let pivots = factor.l_dirty().diagonal();
    let condition = (pivots.max() / pivots.min()).powi(2);
    let charges_e: Vec<f64> = charges.iter().copied().collect();
    if charges_e.iter().any(|charge| !charge.is_finite()) {
        return Err(unsolvable());
    }
    Ok(Fit {
        charges_e,
        relative_residual: residual,
        condition,
    })
}

/// The weights of the points: squares add up to one over all points, alike for each layer, if the
/// potential has its root mean square everywhere.
fn weights(points: &[Place], kappa: f64) -> Vec<f64> {
    let layers = points
        .iter()
        .map(|point| point.layer + 1)
        .max()
        .unwrap_or(0);
    let (mut squares, mut counts) = (vec![0.0; layers], vec![0.0; layers]);
    for point in points {
        squares[point.layer] += point.potential_kt_per_e.powi(2);
        counts[point.layer] += 1.0;
    }
    // Layers are at most 3 Å apart.
    let screened = LEAST_PART * (-3.0 * kappa).exp();
    let mut scales: Vec<f64> = Vec::with_capacity(layers);
    for layer in 0..layers {
        let mean_square: f64 = squares[layer] / f64::max(counts[layer], 1.0);
        let floor = scales.last().map_or(0.0, |before| screened * before);
        scales.push(mean_square.sqrt().max(floor).max(1e-300));
    }
    let weight = |point: &Place| {
        let share = counts[point.layer] * layers as f64;
        1.0 / (scales[point.layer] * share.sqrt())
    };
    points.iter().map(weight).collect()
}
