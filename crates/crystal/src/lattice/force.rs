//! Accelerations beyond those of the rods.

use super::network::Network;

/// A force on the squares that depends on their positions.
pub trait Force: Send + Sync {
    /// Adds the accelerations (ẍ, ÿ, θ̈ of square after square) at these positions and returns the
    /// potential energy.
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64;
}

/// The potential that draws all squares to one coherent motion (eq. 16 of the paper, as an angular
/// acceleration):
///
/// V = κ/2 Σ I (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁)², f = -κ (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁),
///
/// with ⟨θ⟩₀ the mean of θ over the squares and ⟨θ⟩₁ that of (-1)^(i+j) θ. For squares of different
/// inertia the means are weighted by it, so that the force is the gradient of V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coherence {
    /// κ, an inverse time squared.
    pub kappa: f64,
}

/// ⟨θ⟩₀ and ⟨θ⟩₁ of the angles in an array of x, y, θ per square, or of the angular velocities in
/// one of velocities: the least squares of Σ I (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁)². Where all squares
/// have the same sign, ⟨θ⟩₁ is 0.
pub fn coherent_part(network: &Network, coordinates: &[f64]) -> [f64; 2] {
    // The two are independent means where signs and inertia balance.
    let (mut w, mut ws, mut wt, mut wst) = (0.0, 0.0, 0.0, 0.0);
    for (p, square) in network.squares.iter().enumerate() {
        let (sign, theta) = (network.sign(p), coordinates[3 * p + 2]);
        w += square.inertia;
        ws += square.inertia * sign;
        wt += square.inertia * theta;
        wst += square.inertia * sign * theta;
    }
    let determinant = w * w - ws * ws;
    if determinant > 1e-12 * w * w {
        [
            (w * wt - ws * wst) / determinant,
            (w * wst - ws * wt) / determinant,
        ]
    } else {
        [wt / w, 0.0]
    }
}

impl Force for Coherence {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        if self.kappa == 0.0 {
            return 0.0;
        }
        let [uniform, checkerboard] = coherent_part(network, positions);
        let mut energy = 0.0;
        for (p, square) in network.squares.iter().enumerate() {
            let away = positions[3 * p + 2] - uniform - network.sign(p) * checkerboard;
            accelerations[3 * p + 2] -= self.kappa * away;
            energy += 0.5 * self.kappa * square.inertia * away * away;
        }
        energy
    }
}
