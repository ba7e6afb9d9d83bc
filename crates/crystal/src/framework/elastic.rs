//! Elastic constants, mechanisms, Maxwell's count.
//!
//! Relaxed stiffness: when the cell is strained the nodes follow, so that
//!
//! C = (K_εε - K_xεᵀ K_xx⁺ K_xε) / V,
//!
//! with K the blocks of the Hessian; without the second term it is the clamped stiffness. Both are
//! with respect to the Green-Lagrange strain η, for which ε = η - η²/2 + ..., so a network under
//! stress gets Σ_c ∂E/∂ε_c ∂²ε_c/∂η_a∂η_b, ∂²ε/∂η_a∂η_b = -(B_a B_b + B_b B_a)/2, added to K_εε.

use super::energy::{Configuration, Derivatives, NetworkEnergy, strain_tensor};
use super::model::Framework;
use crate::{CrystalError, Result};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use protomer_kernel::sparse::LdlFactor;
use serde::Serialize;

/// Up to this many node coordinates the Hessian is diagonalised; above, it is factored sparsely.
const MOST_DENSE_COORDINATES: usize = 240;
/// Eigenvalues below this part of the largest are zero.
const ZERO_EIGENVALUE: f64 = 1e-10;
/// What a sparse factorisation adds to the diagonal, in parts of the largest diagonal entry, so
/// that rigid motions and floppy modes do not stop it.
const SHIFT: f64 = 1e-9;
/// Rounds of refinement that take the shift out again.
const MOST_REFINEMENTS: usize = 60;

/// The elastic constants of a network, kcal/mol/Å³.
#[derive(Debug, Clone, PartialEq)]
pub struct Elasticity {
    /// 2 or 3.
    pub dimension: usize,
    /// With relaxed nodes.
    pub stiffness: DMatrix<f64>,
    /// With nodes that follow the strain as points of a homogeneous medium.
    pub clamped_stiffness: DMatrix<f64>,
    /// Stress of the network as it is: ∂E/∂ε / V.
    pub stress: Vec<f64>,
    /// Strains that cost nothing.
    pub mechanisms: Vec<Mechanism>,
    /// How many motions of the nodes, beyond translations, cost nothing at fixed cell; absent for
    /// networks too large to count them.
    pub internal_mechanisms: Option<usize>,
    /// Coordinates and springs.
    pub maxwell: MaxwellCount,
}

/// A strain that costs nothing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mechanism {
    /// The strain, largest component ±1, in the order of the [module](super).
    pub strain: Vec<f64>,
    /// ε C ε over that of the stiffest strain: zero but for rounding.
    pub relative_stiffness: f64,
}

/// Maxwell's count: coordinates against springs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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
    /// As [`Framework::check`]; [`CrystalError::BadState`] if the nodes cannot be relaxed because
    /// the network is not at a minimum of its energy.
    pub fn of(framework: &Framework) -> Result<Self> {
        let energy = NetworkEnergy::new(framework)?;
        Self::at(framework, &energy, &Configuration::built(framework))
    }

    /// The elastic constants of a network whose nodes and cell are elsewhere than built.
    ///
    /// # Errors
    /// As [`of`](Elasticity::of).
    pub fn at(framework: &Framework, energy: &NetworkEnergy, at: &Configuration) -> Result<Self> {
        let dimension = energy.dimension();
        let volume = at.place(framework).volume_angstrom3();
        let d = energy.derivatives(at);
        let strains = d.strain_gradient.len();
        let mut clamped = d.strain_hessian.clone();
        for a in 0..strains {
            for b in 0..strains {
                clamped[(a, b)] += stress_correction(dimension, &d.strain_gradient, a, b);
            }
        }
        let (response, internal_mechanisms) = relax_nodes(energy, at, &d)?;
        let mut relaxed = &clamped - d.mixed.transpose() * response;
        relaxed = 0.5 * (&relaxed + relaxed.transpose());
        let mechanisms = mechanisms(dimension, &relaxed, &clamped);
        let springs = [
            framework
                .rods
                .iter()
                .filter(|rod| rod.stiffness_kcal_mol_angstrom2 > 0.0)
                .count(),
            framework
                .hinges
                .iter()
                .filter(|hinge| hinge.stiffness_kcal_mol_rad2 > 0.0)
                .count(),
            framework
                .torsions
                .iter()
                .filter(|torsion| torsion.stiffness_kcal_mol_rad2 > 0.0)
                .count(),
        ];
        let springs = springs.iter().sum();
        let freedoms = energy.coordinates() + strains - dimension;
        Ok(Self {
            dimension,
            stiffness: relaxed / volume,
            clamped_stiffness: clamped / volume,
            stress: d.strain_gradient.iter().map(|x| x / volume).collect(),
            mechanisms,
            internal_mechanisms,
            maxwell: MaxwellCount {
                freedoms,
                springs,
                excess: freedoms as i64 - springs as i64,
            },
        })
    }

    /// S = C⁻¹, Å³ mol/kcal; `None` if a strain costs nothing.
    pub fn compliance(&self) -> Option<DMatrix<f64>> {
        if self.mechanisms.is_empty() {
            self.stiffness.clone().try_inverse()
        } else {
            None
        }
    }
}

/// Σ_c g_c ∂²ε_c/∂η_a∂η_b.
fn stress_correction(dimension: usize, gradient: &[f64], a: usize, b: usize) -> f64 {
    let unit = |index: usize| {
        let mut strains = vec![0.0; gradient.len()];
        strains[index] = 1.0;
        strain_tensor(dimension, &strains)
    };
    let (first, second) = (unit(a), unit(b));
    let product = |x: &[[f64; 3]; 3], y: &[[f64; 3]; 3], i: usize, j: usize| {
        (0..3).map(|k| x[i][k] * y[k][j]).sum::<f64>()
    };
    // The gradient over a shear component is over the engineering strain, which counts both of its
    // places.
    gradient
        .iter()
        .enumerate()
        .map(|(c, g)| {
            let (i, j) = super::energy::strain_axes(dimension, c);
            let second_derivative =
                -0.5 * (product(&first, &second, i, j) + product(&second, &first, i, j));
            g * second_derivative * if i == j { 1.0 } else { 2.0 }
        })
        .sum()
}

/// K_xx⁺ K_xε, and the number of floppy motions of the nodes where they were counted.
fn relax_nodes(
    energy: &NetworkEnergy,
    at: &Configuration,
    d: &Derivatives,
) -> Result<(DMatrix<f64>, Option<usize>)> {
    let n = energy.coordinates();
    if n > MOST_DENSE_COORDINATES {
        return Ok((relax_sparsely(energy, at, d)?, None));
    }
    let mut dense = DMatrix::zeros(n, n);
    for (&(row, column), value) in energy.entries().iter().zip(&d.hessian) {
        dense[(row, column)] = *value;
        dense[(column, row)] = *value;
    }
    let eigen = SymmetricEigen::new(dense);
    let largest = eigen.eigenvalues.amax();
    let zero = ZERO_EIGENVALUE * largest;
    if let Some(lowest) = eigen.eigenvalues.iter().find(|value| **value < -zero) {
        return Err(not_minimal(*lowest));
    }
    let inverse = eigen
        .eigenvalues
        .map(|value| if value > zero { 1.0 / value } else { 0.0 });
    let soft = eigen
        .eigenvalues
        .iter()
        .filter(|value| **value <= zero)
        .count();
    let projected = eigen.eigenvectors.transpose() * &d.mixed;
    let response = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * projected;
    Ok((response, Some(soft.saturating_sub(energy.dimension()))))
}

fn not_minimal(lowest: f64) -> CrystalError {
    CrystalError::BadState(format!(
        "the network is not at a minimum of its energy (a curvature of {lowest:.3e} kcal/mol/Å²): minimise it first"
    ))
}

/// The sparse way: (K + s 1) factored once; s is taken out again by refinement, which converges on
/// what is not floppy and never touches what is, as a strain does no work on floppy motions.
fn relax_sparsely(
    energy: &NetworkEnergy,
    at: &Configuration,
    d: &Derivatives,
) -> Result<DMatrix<f64>> {
    let (n, dimension) = (energy.coordinates(), energy.dimension());
    let places: Vec<[f64; 3]> = (0..n)
        .map(|row| {
            let node = row / dimension * dimension;
            std::array::from_fn(|i| {
                if i < dimension {
                    at.nodes_angstrom[node + i]
                } else {
                    0.0
                }
            })
        })
        .collect();
    let mut factor = LdlFactor::new(n, energy.entries(), &places);
    let diagonal = |entry: &(usize, usize)| entry.0 == entry.1;
    let pairs = energy.entries().iter().zip(&d.hessian);
    let shift = SHIFT
        * pairs
            .filter(|(entry, _)| diagonal(entry))
            .fold(0.0_f64, |most, (_, x)| most.max(x.abs()));
    let shifted: Vec<f64> = energy
        .entries()
        .iter()
        .zip(&d.hessian)
        .map(|(entry, x)| if diagonal(entry) { x + shift } else { *x })
        .collect();
    factor.factor(&shifted).map_err(|error| {
        CrystalError::BadState(format!("the network is not at a minimum: {error}"))
    })?;
    let mut response = DMatrix::zeros(n, d.mixed.ncols());
    for column in 0..d.mixed.ncols() {
        let wanted = DVector::from_column_slice(d.mixed.column(column).as_slice());
        let mut x = DVector::zeros(n);
        let mut residual = wanted.clone();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_REFINEMENTS {
            let size = residual.norm();
            if size <= 1e-13 * wanted.norm() || size > 0.9 * before {
                break;
            }
            before = size;
            let mut correction = residual.as_slice().to_vec();
            factor.solve(&mut correction);
            x += DVector::from_vec(correction);
            residual = &wanted - multiply(energy.entries(), &d.hessian, &x);
        }
        response.set_column(column, &x);
    }
    Ok(response)
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

/// Strains whose relaxed stiffness is zero beside the largest clamped one, in an orthogonal basis
/// of such strains.
fn mechanisms(dimension: usize, relaxed: &DMatrix<f64>, clamped: &DMatrix<f64>) -> Vec<Mechanism> {
    // In the basis where shear counts √2 ε, lengths of strains do not depend on the axes.
    let weight = DVector::from_fn(relaxed.nrows(), |index, _| {
        let (i, j) = super::energy::strain_axes(dimension, index);
        if i == j {
            1.0
        } else {
            std::f64::consts::SQRT_2
        }
    });
    let scaled = |matrix: &DMatrix<f64>| {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            matrix[(i, j)] * weight[i] * weight[j]
        })
    };
    let largest = SymmetricEigen::new(scaled(clamped)).eigenvalues.amax();
    let eigen = SymmetricEigen::new(scaled(relaxed));
    let mut found = Vec::new();
    for (value, vector) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > 1e-9 * largest {
            continue;
        }
        let strain = vector.component_mul(&weight);
        let most = strain.iter().fold(0.0_f64, |most, x| {
            if x.abs() > most.abs() + 1e-12 {
                *x
            } else {
                most
            }
        });
        let tidy = |x: f64| if x.abs() < 1e-9 { 0.0 } else { x };
        found.push(Mechanism {
            strain: strain.iter().map(|x| tidy(x / most)).collect(),
            relative_stiffness: value / largest,
        });
    }
    found
}
