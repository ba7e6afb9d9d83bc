//! A stress on a lattice.
//!
//! Where edges are open, the corners b of all squares are a uniform deformation F of where they were at first, a, plus what
//! is left: F = Σ b gᵀ with g = (Σ a aᵀ)⁻¹ a about the mean of a (see [`strain`](crate::analysis::strain)).
//! With the strain of Biot, ε = (Fᵀ F)^(1/2) - 1, which is blind to rotation, a stress has the potential
//!
//! V = -A₀ (σ_xx ε_xx + σ_yy ε_yy),
//!
//! A₀ the area of the lattice at first: one cell for each square. σ is the stress of Biot, the force
//! per width that the lattice had at first, positive where it pulls. The force on a corner is -∂V/∂b = P g with
//! P = A₀ (σ_xx ∂U_xx/∂F + σ_yy ∂U_yy/∂F) and, in two dimensions with C = Fᵀ F and J = det F,
//!
//! U_xx = (C_xx + J)/t, t = (tr C + 2 J)^(1/2), ∂t/∂F = (F + cof F)/t.
//!
//! A flexible [`cell`](super::cell) is strained itself, F = H H₀⁻¹ with its first edges H₀ and area
//! A₀ = det H₀, and the same V is a force -∂V/∂H on the cell.
//!
//! It adds no momentum and, where edges are open, no angular momentum. In equilibrium ⟨ε_i⟩ changes with σ_j by
//! A₀ ⟨δε_i δε_j⟩/kT: response and fluctuation are one, exactly.

use super::cell::Cell;
use super::force::Force;
use super::network::{Network, spacing};
use super::state::State;
use crate::analysis::strain::{biot_strain, corners, deformation_gradient};
use crate::error::{CrystalError, Result, require_finite};
use crate::plane::{Vector, cross, minus};
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

/// A determinant below this share of the squared trace means that the corners lie on one line.
const ON_ONE_LINE: f64 = 1e-12;

/// Stress on a lattice, an energy per area in reduced units; positive pulls.
///
/// ```
/// use protomer_linkage::lattice::Stress;
/// assert!(Stress { xx: 0.1, yy: 0.0 }.acts() && !Stress::default().acts());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stress {
    /// Along x.
    pub xx: f64,
    /// Along y.
    pub yy: f64,
}

impl Stress {
    /// Whether there is a load.
    pub fn acts(&self) -> bool {
        *self != Self::default()
    }
}

/// The force of a stress on a lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// A₀ σ_xx and A₀ σ_yy.
    strength: [f64; 2],
    grip: Grip,
}

/// Points at which a stress pulls.
#[derive(Debug, Clone, PartialEq)]
enum Grip {
    /// The corners of all squares.
    Corners {
        /// Corners at first.
        reference: Vec<Vector>,
        /// g of every corner.
        weights: Vec<Vector>,
    },
    /// The flexible cell, as it was at first.
    Cell(Cell),
}

impl Load {
    /// The load of a stress on a network that was at first in this state.
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] for a cell that is fixed;
    /// [`CrystalError::BadSetting`] for a stress that is not finite.
    pub fn new(network: &Network, stress: Stress, first: &State) -> Result<Self> {
        require_finite("stress_xx", stress.xx)?;
        require_finite("stress_yy", stress.yy)?;
        if network.cell.is_some() && network.cell_mass.is_none() {
            return Err(CrystalError::BadNetwork(
                "a stress cannot strain a periodic cell that is fixed; give cell = \"flexible\" or \
                 edges = \"open\", or remove the stress"
                    .into(),
            ));
        }
        let area = reference_area(network, first);
        let grip = if network.cell_mass.is_some() {
            Grip::Cell(Cell::read(network, &first.positions))
        } else {
            let reference = corners(network, &first.positions);
            let weights = weights(&reference)?;
            Grip::Corners { reference, weights }
        };
        Ok(Self {
            strength: [area * stress.xx, area * stress.yy],
            grip,
        })
    }

    /// V and P = -∂V/∂F of a deformation.
    fn energy_and_stress(&self, gradient: &Matrix2<f64>) -> (f64, Matrix2<f64>) {
        let strain = biot_strain(gradient);
        let (root, root_slope) = root_of_trace(gradient);
        let cofactor = cofactor(gradient);
        let mut stress = Matrix2::zeros();
        let mut energy = 0.0;
        for (axis, strength) in self.strength.into_iter().enumerate() {
            // ∂U/∂F of this axis: 2 F e eᵀ + cof F over t, less U ∂t/∂F over t.
            let mut slope = cofactor;
            for row in 0..2 {
                slope[(row, axis)] += 2.0 * gradient[(row, axis)];
            }
            let stretch = 1.0 + strain[(axis, axis)];
            stress += (slope - root_slope * stretch) * (strength / root);
            energy -= strength * strain[(axis, axis)];
        }
        (energy, stress)
    }

    fn pull_at_corners(
        &self,
        network: &Network,
        (reference, weights): (&[Vector], &[Vector]),
        positions: &[f64],
        accelerations: &mut [f64],
    ) -> f64 {
        let places = corners(network, positions);
        let Ok(gradient) = deformation_gradient(reference, &places) else {
            return f64::NAN;
        };
        let (energy, stress) = self.energy_and_stress(&gradient);
        for (index, (place, weight)) in places.iter().zip(weights).enumerate() {
            let p = index / 4;
            let force: Vector = (stress * Vector2::from(*weight)).into();
            let centre = [positions[3 * p], positions[3 * p + 1]];
            let square = &network.squares[p];
            accelerations[3 * p] += force[0] / square.mass;
            accelerations[3 * p + 1] += force[1] / square.mass;
            accelerations[3 * p + 2] += cross(minus(*place, centre), force) / square.inertia;
        }
        energy
    }

    fn pull_at_cell(
        &self,
        network: &Network,
        first: &Cell,
        positions: &[f64],
        accelerations: &mut [f64],
    ) -> f64 {
        let cell = Cell::read(network, positions);
        let (energy, stress) = self.energy_and_stress(&cell.gradient_since(first));
        if let (Some(mass), Some(place)) = (network.cell_mass, network.cell_place()) {
            let forces = first.pull_back(&stress);
            for (acceleration, force) in accelerations[place..].iter_mut().zip(forces) {
                *acceleration += force / mass;
            }
        }
        energy
    }
}

/// The area of a lattice at first: that of a flexible cell, or for every square a cell with the
/// distance of neighbours in the coherent state of its opening.
///
/// ```
/// use protomer_linkage::lattice::load::reference_area;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(3, 4, 0.5, Square::default(), Edges::Open, 0.785398)?;
/// let area = reference_area(&network, &State::coherent(&network, 0.785398));
/// assert!((area - 12.0 * 2.5 * 2.5).abs() < 1e-6);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub fn reference_area(network: &Network, first: &State) -> f64 {
    if network.cell_mass.is_some() {
        return Cell::read(network, &first.positions).area();
    }
    let [_, opening] = super::force::coherent_part(network, &first.positions);
    let mut rods = 0.0;
    for rod in &network.rods {
        rods += rod.length / network.rods.len() as f64;
    }
    let distance = spacing(rods, network.first_half_diagonal(), opening);
    network.squares.len() as f64 * distance * distance
}

fn weights(reference: &[Vector]) -> Result<Vec<Vector>> {
    let mut mean = Vector2::zeros();
    for corner in reference {
        mean += Vector2::from(*corner) / reference.len() as f64;
    }
    let mut moments = Matrix2::zeros();
    for corner in reference {
        let arm = Vector2::from(*corner) - mean;
        moments += arm * arm.transpose();
    }
    let flat = moments.determinant() <= ON_ONE_LINE * moments.trace().powi(2);
    let inverse = if flat { None } else { moments.try_inverse() };
    let Some(inverse) = inverse else {
        return Err(CrystalError::BadNetwork(
            "the squares lie on one line and cannot be strained".into(),
        ));
    };
    let weights = reference.iter();
    Ok(weights
        .map(|corner| (inverse * (Vector2::from(*corner) - mean)).into())
        .collect())
}

/// (t, F + cof F over t) of a deformation.
fn root_of_trace(gradient: &Matrix2<f64>) -> (f64, Matrix2<f64>) {
    let determinant = gradient.determinant();
    let trace = gradient.norm_squared();
    let root = (trace + 2.0 * determinant).sqrt();
    (root, (gradient + cofactor(gradient)) / root)
}

fn cofactor(gradient: &Matrix2<f64>) -> Matrix2<f64> {
    let [[a, c], [b, d]] = gradient.data.0;
    Matrix2::new(d, -c, -b, a)
}

impl Force for Load {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        match &self.grip {
            Grip::Corners { reference, weights } => {
                let grip = (reference.as_slice(), weights.as_slice());
                self.pull_at_corners(network, grip, positions, accelerations)
            }
            Grip::Cell(first) => self.pull_at_cell(network, first, positions, accelerations),
        }
    }
}
