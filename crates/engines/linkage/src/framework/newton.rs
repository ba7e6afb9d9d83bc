//! Newton steps of nodes and cell together.

use super::energy::{Configuration, Derivatives, NetworkEnergy};
use crate::floppy::with_shift;
use crate::plane::largest_magnitude;
use nalgebra::{DMatrix, DVector};
use protomer_kernel::sparse::LdlFactor;

/// Translations cost nothing, so this share of the largest entry of the Hessian is always added to
/// its diagonal; the forces do no work on translations.
const TRANSLATION_SHIFT: f64 = 1e-10;

/// The Hessian over nodes, factored sparsely; strains are eliminated last.
pub(super) struct Newton<'a> {
    energy: &'a NetworkEnergy,
    factor: LdlFactor,
}

/// δx and δε.
pub(super) struct Step {
    pub nodes: DVector<f64>,
    pub strains: DVector<f64>,
}

impl<'a> Newton<'a> {
    pub fn new(energy: &'a NetworkEnergy, configuration: &Configuration) -> Self {
        let places = configuration.places(energy.dimension());
        Self {
            energy,
            factor: LdlFactor::new(energy.coordinates(), energy.entries(), &places),
        }
    }

    /// The step with a shifted Hessian, with strains if there is a force on the cell; `None` if the
    /// shifted matrix is not positive.
    pub fn step(
        &mut self,
        d: &Derivatives,
        work_slope: &DMatrix<f64>,
        strain_force: Option<&[f64]>,
        shift: f64,
    ) -> Option<Step> {
        let largest = largest_magnitude(&d.hessian);
        // Translations have eigenvalue zero: without a shift the factorisation would stop there.
        let shift = shift + TRANSLATION_SHIFT * largest;
        let shifted = with_shift(self.energy.entries(), &d.hessian, shift);
        // Not positive: the caller shifts more.
        self.factor.factor(&shifted).ok()?;
        let mut nodes: Vec<f64> = d.gradient.iter().map(|g| -g).collect();
        self.factor.solve(&mut nodes);
        let mut nodes = DVector::from_vec(nodes);
        let mut strains = DVector::zeros(d.strain_gradient.len());
        if let Some(force) = strain_force {
            let response = self.response(&d.mixed);
            let coupling = d.mixed.transpose();
            // In proportion, so that strains and nodes are damped alike.
            let strain_shift = shift * d.strain_hessian.amax() / largest.max(f64::MIN_POSITIVE);
            // Schur complement for the strains.
            let schur = &d.strain_hessian - work_slope - &coupling * &response
                + DMatrix::identity(force.len(), force.len()) * strain_shift;
            let right = -DVector::from_column_slice(force) - &coupling * &nodes;
            strains = schur.lu().solve(&right)?;
            // Back substitution: nodes follow the strains.
            nodes -= response * &strains;
        }
        let is_finite = nodes.iter().chain(strains.iter()).all(|x| x.is_finite());
        is_finite.then_some(Step { nodes, strains })
    }

    /// K_xx⁻¹ K_xε.
    fn response(&mut self, mixed: &DMatrix<f64>) -> DMatrix<f64> {
        let mut response = mixed.clone();
        for mut column in response.column_iter_mut() {
            let mut b = column.as_slice().to_vec();
            self.factor.solve(&mut b);
            column.copy_from_slice(&b);
        }
        response
    }
}
