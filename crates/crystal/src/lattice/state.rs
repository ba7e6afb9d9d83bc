//! Where everything is and how it moves.

use super::network::{Network, spacing};
use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};

/// Positions and velocities: x, y, θ of square after square in one array.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Time.
    pub time: f64,
    /// x, y, θ per square.
    pub positions: Vec<f64>,
    /// ẋ, ẏ, ω per square.
    pub velocities: Vec<f64>,
}

impl State {
    /// The coherent state at rest: θ = (-1)^(i+j) angle, rods along x and y, centred at the origin.
    /// Open is π/4, closed is 0. Takes the rod length and half-diagonal of the first rod and square
    /// for all.
    pub fn coherent(network: &Network, angle: f64) -> Self {
        let length = network.rods.first().map_or(0.0, |rod| rod.length);
        let half_diagonal = network
            .squares
            .first()
            .map_or(1.0, |square| square.half_diagonal);
        let distance = spacing(length, half_diagonal, angle);
        let middle = |count: usize| 0.5 * (count - 1) as f64;
        let mut positions = Vec::with_capacity(3 * network.squares.len());
        for p in 0..network.squares.len() {
            let [i, j] = network.place(p).map(|index| index as f64);
            positions.push((j - middle(network.columns)) * distance);
            positions.push((middle(network.rows) - i) * distance);
            positions.push(network.sign(p) * angle);
        }
        let velocities = vec![0.0; positions.len()];
        Self {
            time: 0.0,
            positions,
            velocities,
        }
    }

    /// # Errors
    /// [`CrystalError::BadState`] if the arrays do not fit the network, [`CrystalError::NotFinite`]
    /// names the square.
    pub fn check(&self, network: &Network) -> Result<()> {
        let expected = 3 * network.squares.len();
        for (name, array) in [
            ("positions", &self.positions),
            ("velocities", &self.velocities),
        ] {
            if array.len() != expected {
                return Err(CrystalError::BadState(format!(
                    "{name} has {} numbers; {} squares need {expected}: x, y and angle of each",
                    array.len(),
                    network.squares.len()
                )));
            }
            if let Some(index) = array.iter().position(|number| !number.is_finite()) {
                return Err(CrystalError::NotFinite {
                    square: index / 3,
                    time: self.time,
                });
            }
        }
        Ok(())
    }

    /// Kinetic energy, ½ Σ (m |v|² + I ω²).
    pub fn kinetic_energy(&self, network: &Network) -> f64 {
        let squares = network.squares.iter().zip(self.velocities.chunks_exact(3));
        squares
            .map(|(q, v)| 0.5 * (q.mass * (v[0] * v[0] + v[1] * v[1]) + q.inertia * v[2] * v[2]))
            .sum()
    }

    /// Momentum along x and y.
    pub fn momentum(&self, network: &Network) -> [f64; 2] {
        let squares = network.squares.iter().zip(self.velocities.chunks_exact(3));
        squares.fold([0.0; 2], |sum, (q, v)| {
            [sum[0] + q.mass * v[0], sum[1] + q.mass * v[1]]
        })
    }

    /// Angular momentum about the origin.
    pub fn angular_momentum(&self, network: &Network) -> f64 {
        let places = self
            .positions
            .chunks_exact(3)
            .zip(self.velocities.chunks_exact(3));
        network
            .squares
            .iter()
            .zip(places)
            .map(|(q, (s, v))| q.mass * (s[0] * v[1] - s[1] * v[0]) + q.inertia * v[2])
            .sum()
    }
}
