//! The periodic cell, and its place among the coordinates where it is flexible.
//!
//! The edges of the cell are the columns of
//!
//! H = (H_xx  H_xy; 0  H_yy),
//!
//! so the lattice cannot turn as a whole. Squares keep their own coordinates x, not wrapped into the
//! cell, and the image n of a square is at x + H n. A flexible cell is one more body of the network:
//! its coordinates H_xx, H_yy and H_xy follow those of the squares, each with the mass W. Its
//! kinetic energy is ½ W (Ḣ_xx² + Ḣ_yy² + Ḣ_xy²), and rods and contacts between a square and an
//! image move it as they move squares. Everything depends on differences of positions and on H n
//! only, so the momentum of the squares is conserved.

use super::network::Network;
use crate::plane::Vector;
use nalgebra::Matrix2;

protomer_kernel::choices! {
    /// Whether a periodic cell can change.
    pub enum CellKind, default Fixed {
        /// A cell that stays as it is at the start.
        Fixed = "fixed",
        /// A cell that rods, contacts and stress strain.
        Flexible = "flexible",
    }
}

/// The cell at some positions, or its rate of change at some velocities.
///
/// ```
/// use protomer_linkage::lattice::{Cell, Edges, Network, Square, State};
/// let network = Network::lattice(2, 4, 0.5, Square::default(), Edges::Periodic, 0.3)?;
/// let network = network.with_flexible_cell(1.0)?;
/// let mut state = State::coherent(&network, 0.3);
/// let cell = Cell::read(&network, &state.positions);
/// assert!((cell.xx / cell.yy - 2.0).abs() < 1e-12 && cell.xy == 0.0);
/// *state.positions.last_mut().unwrap() = 0.1;
/// let sheared = Cell::read(&network, &state.positions);
/// assert_eq!(sheared.shift([0.0, 1.0]), [0.1, cell.yy]);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cell {
    /// Length of the edge along x.
    pub xx: f64,
    /// Height, along y.
    pub yy: f64,
    /// Lean of the other edge along x.
    pub xy: f64,
}

impl Cell {
    /// The cell of a network at these positions; zero for open edges.
    pub fn read(network: &Network, positions: &[f64]) -> Self {
        match network.cell_place() {
            Some(place) => Self::from_components(&positions[place..]),
            None => Self::coherent(network),
        }
    }

    /// The rate of change of the cell at these velocities; zero for a fixed one.
    pub fn rate(network: &Network, velocities: &[f64]) -> Self {
        match network.cell_place() {
            Some(place) => Self::from_components(&velocities[place..]),
            None => Self::default(),
        }
    }

    /// The cell of the coherent state for which the network was made; zero for open edges.
    pub fn coherent(network: &Network) -> Self {
        let [xx, yy] = network.cell.unwrap_or_default();
        Self { xx, yy, xy: 0.0 }
    }

    fn from_components(components: &[f64]) -> Self {
        match *components {
            [xx, yy, xy, ..] => Self { xx, yy, xy },
            _ => Self::default(),
        }
    }

    /// H_xx, H_yy and H_xy, the order of the coordinates.
    pub fn components(&self) -> [f64; 3] {
        [self.xx, self.yy, self.xy]
    }

    /// H n.
    #[inline(always)]
    pub fn shift(&self, [right, up]: [f64; 2]) -> [f64; 2] {
        [right * self.xx + up * self.xy, up * self.yy]
    }

    /// Upper bound on how far images up to this many cells away have moved since the cell was `first`.
    pub(crate) fn largest_shift_since(&self, first: &Self, [right, up]: Vector) -> f64 {
        let [xx, yy, xy] = [self.xx - first.xx, self.yy - first.yy, self.xy - first.xy];
        right * xx.abs() + up * (yy.abs() + xy.abs())
    }

    /// Area.
    pub fn area(&self) -> f64 {
        self.xx * self.yy
    }

    /// The deformation gradient H H₀⁻¹ since the cell was `first`.
    ///
    /// ```
    /// use protomer_linkage::lattice::Cell;
    /// let first = Cell { xx: 2.0, yy: 1.0, xy: 0.0 };
    /// let gradient = Cell { xx: 2.2, yy: 1.0, xy: 0.1 }.gradient_since(&first);
    /// assert!((gradient[(0, 0)] - 1.1).abs() < 1e-14 && gradient[(0, 1)] == 0.1);
    /// ```
    pub fn gradient_since(&self, first: &Self) -> Matrix2<f64> {
        let xx = self.xx / first.xx;
        let xy = (self.xy - xx * first.xy) / first.yy;
        Matrix2::new(xx, xy, 0.0, self.yy / first.yy)
    }

    /// ∂E/∂H of an energy from P = ∂E/∂F with F = H H₀⁻¹, where `self` is H₀.
    pub(crate) fn pull_back(&self, stress: &Matrix2<f64>) -> [f64; 3] {
        // F_xx = H_xx/a, F_xy = (H_xy - F_xx s)/b and F_yy = H_yy/b of H₀ = (a s; 0 b).
        let along = stress[(0, 0)] - stress[(0, 1)] * self.xy / self.yy;
        [
            along / self.xx,
            stress[(1, 1)] / self.yy,
            stress[(0, 1)] / self.yy,
        ]
    }
}

/// ∂(f · H n)/∂H for the vector f, the order of the coordinates.
#[inline(always)]
pub(crate) fn cell_gradient(force: Vector, [right, up]: [f64; 2]) -> [f64; 3] {
    [force[0] * right, force[1] * up, force[0] * up]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_are_those_of_finite_differences() {
        let first = Cell {
            xx: 3.0,
            yy: 2.0,
            xy: 0.4,
        };
        let cell = Cell {
            xx: 3.3,
            yy: 1.9,
            xy: 0.7,
        };
        let matrix = |cell: &Cell| Matrix2::new(cell.xx, cell.xy, 0.0, cell.yy);
        let expected = matrix(&cell) * matrix(&first).try_inverse().unwrap();
        assert!((cell.gradient_since(&first) - expected).norm() < 1e-14);
        // E = P : F and E = f · H n are linear in the components.
        let stress = Matrix2::new(0.3, -0.8, 5.0, 1.1);
        let (force, image) = ([0.3, -1.2], [2.0, -1.0]);
        let energies = |cell: &Cell| {
            let [x, y] = cell.shift(image);
            [
                stress.dot(&cell.gradient_since(&first)),
                force[0] * x + force[1] * y,
            ]
        };
        let slopes = [first.pull_back(&stress), cell_gradient(force, image)];
        for component in 0..3 {
            let mut moved = cell.components();
            moved[component] += 1.0;
            let change = energies(&Cell::from_components(&moved));
            for (number, slope) in slopes.iter().enumerate() {
                let difference = change[number] - energies(&cell)[number];
                assert!((difference - slope[component]).abs() < 1e-13);
            }
        }
    }
}
