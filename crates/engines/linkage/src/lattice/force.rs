//! Accelerations beyond those of the rods.

use super::network::Network;

/// A force on the squares that depends on their positions.
///
/// ```
/// use protomer_linkage::lattice::{Dynamics, Edges, Force, Network, Square, State};
/// use std::sync::Arc;
///
/// /// A uniform pull along -y.
/// struct Gravity(f64);
///
/// impl Force for Gravity {
///     fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
///         let mut energy = 0.0;
///         for (p, square) in network.squares.iter().enumerate() {
///             accelerations[3 * p + 1] -= self.0;
///             energy += square.mass * self.0 * positions[3 * p + 1];
///         }
///         energy
///     }
/// }
///
/// let network = Arc::new(Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, 0.3)?);
/// let mut state = State::coherent(&network, 0.3);
/// let mut dynamics = Dynamics::new(network, vec![Box::new(Gravity(2.0))], &state)?;
/// dynamics.step(&mut state, 0.01)?;
/// assert!((state.velocities[1] + 0.02).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
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
///
/// ```
/// use protomer_linkage::lattice::{Coherence, Edges, Force, Network, Square, State};
/// let network = Network::lattice(2, 2, 1.0, Square::default(), Edges::Open, 0.3)?;
/// let coherent = State::coherent(&network, 0.3);
/// let mut accelerations = vec![0.0; coherent.positions.len()];
/// let coherence = Coherence { kappa: 10.0 };
/// let energy = coherence.accelerate(&network, &coherent.positions, &mut accelerations);
/// assert!(energy < 1e-30);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coherence {
    /// κ, an inverse time squared.
    pub kappa: f64,
}

/// ⟨θ⟩₀ and ⟨θ⟩₁ of the angles in an array of x, y, θ per square, or of the angular velocities in
/// one of velocities: the least squares of Σ I (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁)². Where all squares
/// have the same sign, ⟨θ⟩₁ is 0.
///
/// ```
/// use protomer_linkage::lattice::force::coherent_part;
/// use protomer_linkage::lattice::{Edges, Network, Square};
/// let network = Network::lattice(1, 2, 0.5, Square::default(), Edges::Open, 0.7)?;
/// let [common, alternating] = coherent_part(&network, &[0.0, 0.0, 0.5, 3.0, 0.0, 0.1]);
/// assert!((common - 0.3).abs() < 1e-12 && (alternating - 0.2).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub fn coherent_part(network: &Network, coordinates: &[f64]) -> [f64; 2] {
    // Sums of the weights I, signed and not, alone and times θ. Where signs and inertia balance,
    // the signed weights cancel and the result is two independent means.
    let (mut w, mut ws, mut wt, mut wst) = (0.0, 0.0, 0.0, 0.0);
    for (p, square) in network.squares.iter().enumerate() {
        let (sign, theta) = (network.sign(p), coordinates[3 * p + 2]);
        w += square.inertia;
        ws += square.inertia * sign;
        wt += square.inertia * theta;
        wst += square.inertia * sign * theta;
    }
    // Normal equations of two unknowns; singular if all squares have one sign.
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

/// θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁ of every square.
pub(crate) fn incoherent_part<'a>(
    network: &'a Network,
    coordinates: &'a [f64],
) -> impl Iterator<Item = f64> + 'a {
    let [uniform, checkerboard] = coherent_part(network, coordinates);
    (0..network.squares.len())
        .map(move |p| coordinates[3 * p + 2] - uniform - network.sign(p) * checkerboard)
}

/// Standard deviation of the angles about the coherent state,
///
/// σ² = Σ (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁)² / N.
pub(crate) fn incoherent_spread(network: &Network, coordinates: &[f64]) -> f64 {
    let mut squares = 0.0;
    for away in incoherent_part(network, coordinates) {
        squares += away.powi(2);
    }
    (squares / network.squares.len() as f64).sqrt()
}

impl Force for Coherence {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        if self.kappa == 0.0 {
            return 0.0;
        }
        let mut energy = 0.0;
        for (p, away) in incoherent_part(network, positions).enumerate() {
            accelerations[3 * p + 2] -= self.kappa * away;
            energy += 0.5 * self.kappa * network.squares[p].inertia * away * away;
        }
        energy
    }
}
