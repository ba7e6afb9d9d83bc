//! Elastic constants, mechanisms, Maxwell's count.
//!
//! Relaxed stiffness: when the cell is strained the nodes follow, so that
//!
//! C = (K_εε - K_xεᵀ K_xx⁺ K_xε) / V,
//!
//! with K the blocks of the Hessian; without the second term it is the clamped stiffness. Both are
//! with respect to the Green-Lagrange strain η, for which ε = η - η²/2 + ..., so a network under
//! stress gets Σ_c ∂E/∂ε_c ∂²ε_c/∂η_a∂η_b, ∂²ε/∂η_a∂η_b = -(B_a B_b + B_b B_a)/2, added to K_εε.

use super::configuration::{strain_axes, strain_tensor};
use super::energy::{Configuration, Derivatives, NetworkEnergy};
use super::model::Framework;
use super::relaxation::relax_nodes;
use crate::Result;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};
use std::f64::consts::SQRT_2;

/// A relaxed stiffness below this part of the largest clamped one is zero.
const ZERO_STIFFNESS: f64 = 1e-9;
/// Components of a mechanism's strain below this are rounding, where the largest is one.
const ZERO_STRAIN: f64 = 1e-9;

/// The elastic constants of a network, kcal/mol/Å³.
///
/// ```
/// use protomer_linkage::framework::{Elasticity, build::face_centred_cubic};
/// let elasticity = Elasticity::from_framework(&face_centred_cubic(3.0, 7.0)?)?;
/// let (c, a) = (&elasticity.stiffness, 3.0);
/// // C11 = 2 ks/a and C12 = C44 = ks/a; in a Bravais lattice nodes follow the strain anyway.
/// assert!((c[(0, 0)] - 14.0 / a).abs() < 1e-12 && (c[(3, 3)] - 7.0 / a).abs() < 1e-12);
/// assert!((c - &elasticity.clamped_stiffness).amax() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Elasticity {
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// Stiffness with relaxed nodes.
    pub stiffness: DMatrix<f64>,
    /// Stiffness with nodes that follow the strain as points of a homogeneous medium.
    pub clamped_stiffness: DMatrix<f64>,
    /// Stress of the network as it is: ∂E/∂ε / V.
    pub stress: Vec<f64>,
    /// Strains that cost nothing.
    pub mechanisms: Vec<Mechanism>,
    /// Number of motions of the nodes, beyond translations, that cost nothing at fixed cell; absent
    /// for networks too large to count them.
    pub internal_mechanisms: Option<usize>,
    /// Count of coordinates and springs.
    pub maxwell: MaxwellCount,
}

/// A strain that costs nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mechanism {
    /// The strain, largest component ±1, in the order of the [module](super).
    pub strain: Vec<f64>,
    /// ε C ε over that of the stiffest strain: zero but for rounding.
    pub relative_stiffness: f64,
}

/// Maxwell's count: coordinates against springs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MaxwellCount {
    /// Node coordinates and strains, less translations.
    pub freedoms: usize,
    /// Springs of every kind with a stiffness.
    pub springs: usize,
    /// Freedoms less springs: the least number of mechanisms if positive; of states of self-stress,
    /// with changed sign, if negative.
    pub excess: i64,
}

impl Elasticity {
    /// The elastic constants of a network about where it stands.
    ///
    /// # Errors
    /// As [`Framework::check`]; [`CrystalError::BadState`](crate::CrystalError::BadState) if the
    /// nodes cannot be relaxed because the network is not at a minimum of its energy.
    pub fn from_framework(framework: &Framework) -> Result<Self> {
        let energy = NetworkEnergy::new(framework)?;
        Self::from_configuration(framework, &energy, &Configuration::built(framework))
    }

    /// The elastic constants of a network whose nodes and cell are elsewhere than built.
    ///
    /// # Errors
    /// As [`from_framework`](Elasticity::from_framework).
    pub fn from_configuration(
        framework: &Framework,
        energy: &NetworkEnergy,
        configuration: &Configuration,
    ) -> Result<Self> {
        let dimension = energy.dimension();
        let volume = configuration.place(framework).volume_angstrom3();
        let d = energy.derivatives(configuration);
        let clamped = clamped_stiffness(dimension, &d);
        let relaxation = relax_nodes(energy, configuration, &d)?;
        // What the nodes' own relaxation gives back.
        let mut relaxed = &clamped - d.mixed.transpose() * relaxation.response;
        // Rounding of the response is not symmetric.
        relaxed = 0.5 * (&relaxed + relaxed.transpose());
        Ok(Self {
            dimension,
            mechanisms: mechanisms(dimension, &relaxed, &clamped),
            stiffness: relaxed / volume,
            clamped_stiffness: clamped / volume,
            stress: d.strain_gradient.iter().map(|x| x / volume).collect(),
            internal_mechanisms: relaxation.internal_mechanisms,
            maxwell: MaxwellCount::from_framework(framework, energy),
        })
    }

    /// The compliance S = C⁻¹, Å³ mol/kcal; `None` if a strain costs nothing.
    pub fn compliance(&self) -> Option<DMatrix<f64>> {
        if self.mechanisms.is_empty() {
            self.stiffness.clone().try_inverse()
        } else {
            None
        }
    }
}

impl MaxwellCount {
    fn from_framework(framework: &Framework, energy: &NetworkEnergy) -> Self {
        let mut springs = 0;
        for rod in &framework.rods {
            springs += usize::from(rod.stiffness_kcal_mol_angstrom2 > 0.0);
        }
        for hinge in &framework.hinges {
            springs += usize::from(hinge.stiffness_kcal_mol_rad2 > 0.0);
        }
        for torsion in &framework.torsions {
            springs += usize::from(torsion.stiffness_kcal_mol_rad2 > 0.0);
        }
        let freedoms = energy.coordinates() + framework.strains() - framework.dimension();
        Self {
            freedoms,
            springs,
            excess: freedoms as i64 - springs as i64,
        }
    }
}

/// K_εε with respect to the Green-Lagrange strain: the Hessian over strains, and for a network under
/// stress Σ_c g_c ∂²ε_c/∂η_a∂η_b.
fn clamped_stiffness(dimension: usize, d: &Derivatives) -> DMatrix<f64> {
    let mut clamped = d.strain_hessian.clone();
    for a in 0..clamped.nrows() {
        for b in 0..clamped.ncols() {
            clamped[(a, b)] += stress_correction(dimension, &d.strain_gradient, a, b);
        }
    }
    clamped
}

/// Σ_c g_c ∂²ε_c/∂η_a∂η_b, ∂²ε/∂η_a∂η_b = -(B_a B_b + B_b B_a)/2.
fn stress_correction(dimension: usize, gradient: &[f64], a: usize, b: usize) -> f64 {
    let [first, second] = [a, b].map(|index| unit_strain(dimension, gradient.len(), index));
    let mut correction = 0.0;
    for (c, g) in gradient.iter().enumerate() {
        let (i, j) = strain_axes(dimension, c);
        let second_derivative =
            -0.5 * (product_at(&first, &second, i, j) + product_at(&second, &first, i, j));
        // The gradient over a shear component is over the engineering strain, which counts both of
        // its places.
        let places = if i == j { 1.0 } else { 2.0 };
        correction += g * second_derivative * places;
    }
    correction
}

fn unit_strain(dimension: usize, strains: usize, index: usize) -> [[f64; 3]; 3] {
    let mut strain = vec![0.0; strains];
    strain[index] = 1.0;
    strain_tensor(dimension, &strain)
}

/// One entry of the product of two tensors.
fn product_at(x: &[[f64; 3]; 3], y: &[[f64; 3]; 3], i: usize, j: usize) -> f64 {
    (0..3).map(|k| x[i][k] * y[k][j]).sum()
}

/// Strains whose relaxed stiffness is zero compared with the largest clamped one, in an orthogonal
/// basis of such strains.
fn mechanisms(dimension: usize, relaxed: &DMatrix<f64>, clamped: &DMatrix<f64>) -> Vec<Mechanism> {
    // In the basis where shear counts √2 ε, lengths of strains do not depend on the axes.
    let weight = DVector::from_fn(relaxed.nrows(), |index, _| {
        let (i, j) = strain_axes(dimension, index);
        if i == j { 1.0 } else { SQRT_2 }
    });
    // Clamped constants set the scale: relaxed ones may all be zero.
    let largest = SymmetricEigen::new(weighted(clamped, &weight))
        .eigenvalues
        .amax();
    let eigen = SymmetricEigen::new(weighted(relaxed, &weight));
    let mut mechanisms = Vec::new();
    for (index, value) in eigen.eigenvalues.iter().enumerate() {
        if *value <= ZERO_STIFFNESS * largest {
            // Back from the basis in which shear counts √2.
            let strain = eigen.eigenvectors.column(index).component_mul(&weight);
            mechanisms.push(Mechanism {
                strain: normalised(strain.as_slice()),
                relative_stiffness: value / largest,
            });
        }
    }
    mechanisms
}

fn weighted(matrix: &DMatrix<f64>, weight: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        matrix[(i, j)] * weight[i] * weight[j]
    })
}

/// The strain over its largest component, the first of equals; without rounding.
fn normalised(strain: &[f64]) -> Vec<f64> {
    let mut most = 0.0_f64;
    for x in strain {
        // Clearly larger only, so that of equals the first is chosen.
        if x.abs() > most.abs() + 1e-12 {
            most = *x;
        }
    }
    let mut normalised = Vec::with_capacity(strain.len());
    for x in strain {
        let share = x / most;
        normalised.push(if share.abs() < ZERO_STRAIN {
            0.0
        } else {
            share
        });
    }
    normalised
}
