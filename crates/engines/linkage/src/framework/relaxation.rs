//! How nodes follow a strain: K_xx⁺ K_xε.

use super::energy::{Configuration, Derivatives, NetworkEnergy};
use crate::{CrystalError, Result};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use protomer_kernel::sparse::LdlFactor;

/// Up to this many node coordinates the Hessian is diagonalised; above, it is factored sparsely.
const MOST_DENSE_COORDINATES: usize = 240;
/// Eigenvalues below this part of the largest are zero.
const ZERO_EIGENVALUE: f64 = 1e-10;
/// Shift that a sparse factorisation adds to the diagonal, in parts of the largest diagonal entry,
/// so that rigid motions and floppy modes do not stop it.
const SHIFT: f64 = 1e-9;
/// Rounds of refinement that take the shift out again.
const MOST_REFINEMENTS: usize = 60;
/// Refinement ends when this share of the right-hand side is left.
const RESOLVED: f64 = 1e-13;
/// Refinement also ends when a round leaves more than this share of the error before it.
const STALLED: f64 = 0.9;

/// The response of the nodes to unit strains.
pub(super) struct Relaxation {
    /// K_xx⁺ K_xε.
    pub response: DMatrix<f64>,
    /// The number of floppy motions of the nodes, beyond translations, where they were counted.
    pub internal_mechanisms: Option<usize>,
}

/// The response of the nodes about a minimum of the energy.
pub(super) fn relax_nodes(
    energy: &NetworkEnergy,
    configuration: &Configuration,
    d: &Derivatives,
) -> Result<Relaxation> {
    if energy.coordinates() <= MOST_DENSE_COORDINATES {
        relax_densely(energy, d)
    } else {
        relax_sparsely(energy, configuration, d)
    }
}

fn relax_densely(energy: &NetworkEnergy, d: &Derivatives) -> Result<Relaxation> {
    let n = energy.coordinates();
    // The whole matrix, from its lower triangle.
    let mut dense = DMatrix::zeros(n, n);
    for (&(row, column), value) in energy.entries().iter().zip(&d.hessian) {
        dense[(row, column)] = *value;
        dense[(column, row)] = *value;
    }
    let eigen = SymmetricEigen::new(dense);
    let zero = ZERO_EIGENVALUE * eigen.eigenvalues.amax();
    // Pseudo-inverse: motions that cost nothing are left alone.
    let mut inverse = eigen.eigenvalues.clone();
    let mut soft = 0_usize;
    for value in inverse.iter_mut() {
        if *value < -zero {
            return Err(CrystalError::BadState(format!(
                "the network is not at a minimum of its energy (a curvature of {value:.3e} \
                 kcal/mol/Å²): minimise it first"
            )));
        }
        let is_soft = *value <= zero;
        soft += usize::from(is_soft);
        // A floppy motion takes no part: strains do no work on it.
        *value = if is_soft { 0.0 } else { 1.0 / *value };
    }
    let projected = eigen.eigenvectors.transpose() * &d.mixed;
    Ok(Relaxation {
        response: &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * projected,
        // Translations are always floppy and no mechanism.
        internal_mechanisms: Some(soft.saturating_sub(energy.dimension())),
    })
}

/// The sparse way: (K + s 1) factored once; s is taken out again by refinement, which converges on
/// what is not floppy and never touches what is, as a strain does no work on floppy motions.
fn relax_sparsely(
    energy: &NetworkEnergy,
    configuration: &Configuration,
    d: &Derivatives,
) -> Result<Relaxation> {
    let entries = energy.entries();
    let n = energy.coordinates();
    let mut factor = LdlFactor::new(n, entries, &configuration.places(energy.dimension()));
    let shift = SHIFT * largest_on_diagonal(entries, &d.hessian);
    let shifted = with_shift(entries, &d.hessian, shift);
    factor.factor(&shifted).map_err(|error| {
        CrystalError::BadState(format!("the network is not at a minimum: {error}"))
    })?;
    let mut response = DMatrix::zeros(n, d.mixed.ncols());
    for (column, wanted) in d.mixed.column_iter().enumerate() {
        let x = refine(&mut factor, entries, &d.hessian, wanted.into_owned());
        response.set_column(column, &x);
    }
    Ok(Relaxation {
        response,
        internal_mechanisms: None,
    })
}

/// K x = wanted through the factors of K + s 1.
fn refine(
    factor: &mut LdlFactor,
    entries: &[(usize, usize)],
    hessian: &[f64],
    wanted: DVector<f64>,
) -> DVector<f64> {
    let mut x = DVector::zeros(wanted.len());
    let mut residual = wanted.clone();
    let mut before = f64::INFINITY;
    for _ in 0..MOST_REFINEMENTS {
        let size = residual.norm();
        // Resolved, or no better than the round before.
        if size <= RESOLVED * wanted.norm() || size > STALLED * before {
            break;
        }
        before = size;
        let mut correction = residual.as_slice().to_vec();
        factor.solve(&mut correction);
        x += DVector::from_vec(correction);
        // With the unshifted matrix: the shift is taken out bit by bit.
        residual = &wanted - multiply(entries, hessian, &x);
    }
    x
}

fn largest_on_diagonal(entries: &[(usize, usize)], values: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for ((row, column), value) in entries.iter().zip(values) {
        if row == column {
            largest = largest.max(value.abs());
        }
    }
    largest
}

/// A matrix with a shift on its diagonal.
pub(super) fn with_shift(entries: &[(usize, usize)], values: &[f64], shift: f64) -> Vec<f64> {
    let mut shifted = values.to_vec();
    for ((row, column), value) in entries.iter().zip(&mut shifted) {
        if row == column {
            *value += shift;
        }
    }
    shifted
}

fn multiply(entries: &[(usize, usize)], values: &[f64], x: &DVector<f64>) -> DVector<f64> {
    let mut product = DVector::zeros(x.len());
    for (&(row, column), value) in entries.iter().zip(values) {
        product[row] += value * x[column];
        if row != column {
            product[column] += value * x[row];
        }
    }
    product
}
