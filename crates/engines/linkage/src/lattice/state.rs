//! Where everything is and how it moves.

use super::cell::Cell;
use super::network::{Network, Square, spacing};
use crate::plane::cross;
use crate::{CrystalError, Result};
use serde::{Deserialize, Serialize};

/// Positions and velocities: x, y, θ of square after square in one array, and the components of a
/// flexible [`cell`](super::cell) after them.
///
/// ```
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let mut state = State::coherent(&network, 0.3);
/// assert_eq!(state.positions[2], 0.3);
/// state.velocities[2] = 1.0;
/// assert!((state.kinetic_energy(&network) - 1.0 / 6.0).abs() < 1e-15);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Time.
    pub time: f64,
    /// x, y, θ per square; H_xx, H_yy, H_xy of a flexible cell.
    pub positions: Vec<f64>,
    /// ẋ, ẏ, ω per square; Ḣ_xx, Ḣ_yy, Ḣ_xy of a flexible cell.
    pub velocities: Vec<f64>,
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self {
            time: self.time,
            positions: self.positions.clone(),
            velocities: self.velocities.clone(),
        }
    }

    /// Keeps the memory of the arrays: engines copy a state in every step.
    fn clone_from(&mut self, source: &Self) {
        self.time = source.time;
        self.positions.clone_from(&source.positions);
        self.velocities.clone_from(&source.velocities);
    }
}

impl State {
    /// The coherent state at rest: θ = (-1)^(i+j) angle, rods along x and y, centred at the origin.
    /// Open is π/4, closed is 0. The length of the first rod and the half-diagonal of the first
    /// square are taken for all.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square, State};
    /// let network = Network::lattice(1, 2, 0.5, Square::default(), Edges::Open, 0.7)?;
    /// let state = State::coherent(&network, 0.7);
    /// assert_eq!((state.positions[2], state.positions[5]), (0.7, -0.7));
    /// let distance = 2.0 * (0.7 - std::f64::consts::FRAC_PI_4).cos() + 0.5;
    /// assert!((state.positions[3] - state.positions[0] - distance).abs() < 1e-12);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn coherent(network: &Network, angle: f64) -> Self {
        let length = network.rods.first().map_or(0.0, |rod| rod.length);
        let distance = spacing(length, network.first_half_diagonal(), angle);
        let mut positions = Vec::with_capacity(network.coordinates());
        for p in 0..network.squares.len() {
            let [right, up] = from_middle(network, p);
            positions.push(right * distance);
            positions.push(up * distance);
            positions.push(network.sign(p) * angle);
        }
        if network.cell_mass.is_some() {
            let (columns, rows) = (network.columns as f64, network.rows as f64);
            positions.extend([columns * distance, rows * distance, 0.0]);
        }
        let velocities = vec![0.0; positions.len()];
        Self {
            time: 0.0,
            positions,
            velocities,
        }
    }

    /// Checks that the arrays fit the network and are finite.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square, State};
    /// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.7)?;
    /// let mut state = State::coherent(&network, 0.7);
    /// assert!(state.check(&network).is_ok());
    /// state.velocities[4] = f64::NAN;
    /// assert!(state.check(&network).is_err());
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadState`] if the arrays do not fit the network, [`CrystalError::NotFinite`]
    /// names the square.
    pub fn check(&self, network: &Network) -> Result<()> {
        let squares = network.squares.len();
        let expected = network.coordinates();
        for (name, array) in [
            ("positions", &self.positions),
            ("velocities", &self.velocities),
        ] {
            if array.len() != expected {
                return Err(CrystalError::BadState(format!(
                    "{name} has {} numbers; {squares} squares need {expected}: x, y and angle of \
                     each{}",
                    array.len(),
                    match network.cell_mass {
                        Some(_) => ", and xx, yy and xy of the flexible cell",
                        None => "",
                    }
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

    /// Kinetic energy, ½ Σ (m |v|² + I ω²), with ½ W Σ Ḣ² of a flexible cell.
    ///
    /// ```
    /// use protomer_linkage::lattice::{Edges, Network, Square, State};
    /// let square = Square { mass: 2.0, inertia: 3.0, ..Square::default() };
    /// let network = Network::lattice(1, 1, 0.5, square, Edges::Open, 0.7)?;
    /// let mut state = State::coherent(&network, 0.7);
    /// state.velocities = vec![3.0, 4.0, 1.0];
    /// assert_eq!(state.kinetic_energy(&network), 25.0 + 1.5);
    /// assert_eq!(state.momentum(&network), [6.0, 8.0]);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn kinetic_energy(&self, network: &Network) -> f64 {
        let mut energy = 0.0;
        for (square, _, v) in self.of_squares(network) {
            let translation = square.mass * (v[0] * v[0] + v[1] * v[1]);
            energy += 0.5 * (translation + square.inertia * v[2] * v[2]);
        }
        if let Some(mass) = network.cell_mass {
            for rate in Cell::rate(network, &self.velocities).components() {
                energy += 0.5 * mass * rate * rate;
            }
        }
        energy
    }

    /// Momentum along x and y.
    pub fn momentum(&self, network: &Network) -> [f64; 2] {
        let mut momentum = [0.0; 2];
        for (square, _, v) in self.of_squares(network) {
            momentum[0] += square.mass * v[0];
            momentum[1] += square.mass * v[1];
        }
        momentum
    }

    /// Angular momentum about the origin.
    pub fn angular_momentum(&self, network: &Network) -> f64 {
        let mut sum = 0.0;
        for (square, s, v) in self.of_squares(network) {
            sum += square.mass * cross([s[0], s[1]], [v[0], v[1]]) + square.inertia * v[2];
        }
        sum
    }

    /// Every square with its position and velocity.
    fn of_squares<'a>(
        &'a self,
        network: &'a Network,
    ) -> impl Iterator<Item = (&'a Square, &'a [f64], &'a [f64])> {
        let positions = self.positions.chunks_exact(3);
        let velocities = self.velocities.chunks_exact(3);
        let pairs = network.squares.iter().zip(positions).zip(velocities);
        pairs.map(|((square, s), v)| (square, s, v))
    }
}

/// Position of a square relative to the middle of the lattice: columns to the right, and rows up.
pub(crate) fn from_middle(network: &Network, square: usize) -> [f64; 2] {
    let [i, j] = network.place(square).map(|index| index as f64);
    let middle_row = 0.5 * (network.rows - 1) as f64;
    let middle_column = 0.5 * (network.columns - 1) as f64;
    [j - middle_column, middle_row - i]
}

/// The angles of an array x, y, θ per square, or the angular velocities of one ẋ, ẏ, ω.
pub(crate) fn angles(coordinates: &[f64]) -> impl Iterator<Item = f64> + Clone + '_ {
    coordinates.iter().skip(2).step_by(3).copied()
}
