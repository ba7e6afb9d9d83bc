//! How nodes follow a strain: K_xx⁺ K_xε.

use super::energy::{Configuration, Derivatives, NetworkEnergy};
use crate::floppy::{FloppySystem, dense};
use crate::{CrystalError, Result};
use nalgebra::{DMatrix, SymmetricEigen};

/// Up to this many node coordinates the Hessian is diagonalised; above, it is factored sparsely.
const MOST_DENSE_COORDINATES: usize = 240;
/// Eigenvalues below this part of the largest are zero.
const ZERO_EIGENVALUE: f64 = 1e-10;

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
    let dense = dense(energy.entries(), &d.hessian, energy.coordinates());
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

/// The sparse way: a strain does no work on floppy motions.
fn relax_sparsely(
    energy: &NetworkEnergy,
    configuration: &Configuration,
    d: &Derivatives,
) -> Result<Relaxation> {
    let mut system = FloppySystem::new(
        energy.entries().to_vec(),
        d.hessian.clone(),
        &configuration.places(energy.dimension()),
    )
    .map_err(|error| CrystalError::BadState(format!("the network is not at a minimum: {error}")))?;
    let mut response = DMatrix::zeros(energy.coordinates(), d.mixed.ncols());
    for (column, wanted) in d.mixed.column_iter().enumerate() {
        response.set_column(column, &system.solve(&wanted.into_owned()));
    }
    Ok(Relaxation {
        response,
        internal_mechanisms: None,
    })
}
