//! Collective rotations and the share of the energy in them.
//!
//! With row i and column j of a square, an array of angles (or of angular velocities) has the modes
//!
//! | mode | sign | picture |
//! |---|---|---|
//! | uniform, θ_u | 1 | all turn alike |
//! | checkerboard, θ_c | (-1)^(i+j) | neighbours turn oppositely: the coherent motion |
//! | vertical, θ_v | (-1)^j | the squares of a column turn alike, next columns oppositely |
//! | horizontal, θ_h | (-1)^i | the squares of a row turn alike, next rows oppositely |
//!
//! and the amplitude of each is the mean of sign · θ (fig. 6 of the paper). On a lattice with even
//! numbers of rows and columns of equal squares the modes are orthogonal. Elsewhere uniform and
//! checkerboard are fitted together by least squares, weighted with the moments of inertia, as the
//! coherence potential does, and vertical and horizontal together to what is left. For the 2 x 2
//! lattice the four modes are all there is.

use crate::lattice::force::{coherent_part, incoherent_part, incoherent_spread};
use crate::lattice::state::angles;
use crate::lattice::{Network, State};
use protomer_kernel::statistics::RunningMoments;
use serde::{Deserialize, Serialize};

/// A determinant below this share of its largest term is zero: the two modes are one.
const DEPENDENT: f64 = 1e-12;
/// Energies below this share of the whole are rounding.
const NO_ENERGY: f64 = 1e-14;

/// Amplitudes of the four modes.
///
/// ```
/// use protomer_linkage::analysis::modes::Modes;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(4, 4, 0.2, Square::default(), Edges::Open, 0.3)?;
/// let modes = Modes::from_coordinates(&network, &State::coherent(&network, 0.3).positions);
/// assert!((modes.checkerboard - 0.3).abs() < 1e-15 && modes.uniform.abs() < 1e-15);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Modes {
    /// θ_u, ⟨θ⟩₀ of the paper.
    pub uniform: f64,
    /// θ_c, ⟨θ⟩₁ of the paper.
    pub checkerboard: f64,
    /// θ_v; 0 in a single column.
    pub vertical: f64,
    /// θ_h; 0 in a single row.
    pub horizontal: f64,
}

impl Modes {
    /// The modes of the angles of an array x, y, θ per square, or of the angular velocities of an
    /// array ẋ, ẏ, ω.
    pub fn from_coordinates(network: &Network, coordinates: &[f64]) -> Self {
        let [uniform, checkerboard] = coherent_part(network, coordinates);
        let [vertical, horizontal] = stripes(network, coordinates);
        Self {
            uniform,
            checkerboard,
            vertical,
            horizontal,
        }
    }
}

/// θ_v and θ_h, fitted to what the uniform and the checkerboard mode leave.
fn stripes(network: &Network, coordinates: &[f64]) -> [f64; 2] {
    // Sums of the weights I, alone and times (-1)^(i+j), and of what is left times either sign.
    let (mut weight, mut mixed, mut of_columns, mut of_rows) = (0.0, 0.0, 0.0, 0.0);
    for (p, residual) in incoherent_part(network, coordinates).enumerate() {
        let inertia = network.squares[p].inertia;
        let [row, column] = network.place(p).map(parity);
        of_columns += inertia * column * residual;
        of_rows += inertia * row * residual;
        weight += inertia;
        mixed += inertia * column * row;
    }
    let determinant = weight * weight - mixed * mixed;
    let one_line = network.rows == 1 || network.columns == 1;
    if one_line || determinant <= DEPENDENT * weight * weight {
        // A mode that is the uniform or the checkerboard one over again has nothing left.
        return [0.0; 2];
    }
    [
        (weight * of_columns - mixed * of_rows) / determinant,
        (weight * of_rows - mixed * of_columns) / determinant,
    ]
}

fn parity(index: usize) -> f64 {
    if index.is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Energies of a state, and of its modes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ModeEnergies {
    /// ½ Σ I ω_u².
    pub uniform: f64,
    /// ½ Σ I ω_c².
    pub checkerboard: f64,
    /// ½ Σ I ω_v².
    pub vertical: f64,
    /// ½ Σ I ω_h².
    pub horizontal: f64,
    /// ½ Σ I ω² of all rotation.
    pub rotational: f64,
    /// ½ Σ m v² of all translation.
    pub translational: f64,
}

/// The energy of which a fraction is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutOf {
    /// ½ Σ I ω² (fig. 11 of the paper).
    Rotational,
    /// Rotational and translational energy, and the potential energy that is given (fig. 7 of the
    /// paper).
    Total,
}

impl ModeEnergies {
    /// The energies of this state.
    pub fn from_state(network: &Network, state: &State) -> Self {
        let modes = Modes::from_coordinates(network, &state.velocities);
        let (mut inertia, mut rotational) = (0.0, 0.0);
        for (square, omega) in network.squares.iter().zip(angles(&state.velocities)) {
            inertia += square.inertia;
            rotational += 0.5 * square.inertia * omega * omega;
        }
        let energy = |amplitude: f64| 0.5 * inertia * amplitude * amplitude;
        Self {
            uniform: energy(modes.uniform),
            checkerboard: energy(modes.checkerboard),
            vertical: energy(modes.vertical),
            horizontal: energy(modes.horizontal),
            rotational,
            translational: state.kinetic_energy(network) - rotational,
        }
    }

    /// The share of the checkerboard mode after the uniform one has been taken off, E_c / (E -
    /// E_u); `None` when nothing but uniform rotation is left. E_c counts the rotation only: the
    /// translations of the coherent motion are in E but not in E_c.
    ///
    /// ```
    /// use protomer_linkage::analysis::modes::{ModeEnergies, OutOf};
    /// use protomer_linkage::lattice::{Edges, Network, Square, Start, StartVelocities};
    /// let velocities = StartVelocities::Checkerboard { rate: 1.0 };
    /// let start = Start { velocities, ..Start::default() };
    /// let network = Network::lattice(2, 2, 0.2, Square::default(), Edges::Open, start.angle)?;
    /// let energies = ModeEnergies::from_state(&network, &start.build(&network, 0)?.state);
    /// let fraction = energies.checkerboard_fraction(OutOf::Rotational, 0.0).unwrap();
    /// assert!((fraction - 1.0).abs() < 1e-12);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn checkerboard_fraction(&self, out_of: OutOf, potential_energy: f64) -> Option<f64> {
        let energy = match out_of {
            OutOf::Rotational => self.rotational,
            OutOf::Total => self.rotational + self.translational + potential_energy,
        };
        let nonuniform_energy = energy - self.uniform;
        (nonuniform_energy > NO_ENERGY * energy.abs())
            .then(|| self.checkerboard / nonuniform_energy)
    }
}

/// Standard deviation of the angles about the coherent state,
///
/// σ² = Σ (θ - ⟨θ⟩₀ - (-1)^(i+j) ⟨θ⟩₁)² / N.
///
/// ```
/// use protomer_linkage::analysis::modes::orientational_spread;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.7)?;
/// let mut positions = State::coherent(&network, 0.7).positions;
/// assert!(orientational_spread(&network, &positions) < 1e-12);
/// positions[2] += 0.1;
/// assert!(orientational_spread(&network, &positions) > 0.01);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
pub fn orientational_spread(network: &Network, positions: &[f64]) -> f64 {
    incoherent_spread(network, positions)
}

/// Standard deviation of |θ| over the squares, the curve of fig. 10 of the paper. It is the spread
/// about the coherent state only while no square turns through θ = 0 and the lattice as a whole
/// does not turn.
///
/// ```
/// use protomer_linkage::analysis::modes::spread_of_magnitudes;
/// assert_eq!(spread_of_magnitudes(&[0.0, 0.0, 0.3, 2.0, 0.0, -0.3]), 0.0);
/// assert!((spread_of_magnitudes(&[0.0, 0.0, 0.1, 2.0, 0.0, -0.5]) - 0.2).abs() < 1e-12);
/// ```
pub fn spread_of_magnitudes(positions: &[f64]) -> f64 {
    let magnitudes: Vec<f64> = angles(positions).map(f64::abs).collect();
    RunningMoments::in_two_passes(&magnitudes).root_mean_square_deviation()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Edges, Square};

    fn network(rows: usize, columns: usize) -> Network {
        Network::lattice(rows, columns, 0.5, Square::default(), Edges::Open, 0.7).unwrap()
    }

    /// An array whose angles are the given combination of modes.
    fn combined(network: &Network, modes: Modes) -> Vec<f64> {
        let angle = |p: usize| {
            let (i, j) = (p / network.columns, p % network.columns);
            let sign = |count: usize| (-1.0f64).powi(count as i32);
            modes.uniform
                + sign(i + j) * modes.checkerboard
                + sign(j) * modes.vertical
                + sign(i) * modes.horizontal
        };
        (0..network.squares.len())
            .flat_map(|p| [9.0, -9.0, angle(p)])
            .collect()
    }

    #[test]
    fn four_modes_are_all_there_is_of_two_by_two() {
        let network = network(2, 2);
        let angles = [0.3, -0.8, 0.1, 0.6];
        let coordinates: Vec<f64> = angles.iter().flat_map(|angle| [0.0, 0.0, *angle]).collect();
        let modes = Modes::from_coordinates(&network, &coordinates);
        let [a, b, c, d] = angles;
        let expected = Modes {
            uniform: (a + b + c + d) / 4.0,
            checkerboard: (a - b - c + d) / 4.0,
            vertical: (a - b + c - d) / 4.0,
            horizontal: (a + b - c - d) / 4.0,
        };
        for (found, expected) in [
            (modes.uniform, expected.uniform),
            (modes.checkerboard, expected.checkerboard),
            (modes.vertical, expected.vertical),
            (modes.horizontal, expected.horizontal),
        ] {
            assert!((found - expected).abs() < 1e-15);
        }
        for (found, expected) in combined(&network, modes)
            .iter()
            .zip(&coordinates)
            .skip(2)
            .step_by(3)
        {
            assert!((found - expected).abs() < 1e-15);
        }
        let state = State {
            time: 0.0,
            positions: coordinates.clone(),
            velocities: coordinates,
        };
        let energies = ModeEnergies::from_state(&network, &state);
        let parts =
            energies.uniform + energies.checkerboard + energies.vertical + energies.horizontal;
        assert!((parts - energies.rotational).abs() < 1e-15);
    }

    #[test]
    fn modes_of_even_and_odd_lattices_are_recovered() {
        let mixed = Modes {
            uniform: 0.4,
            checkerboard: -0.7,
            vertical: 0.2,
            horizontal: -0.1,
        };
        let found = Modes::from_coordinates(&network(4, 6), &combined(&network(4, 6), mixed));
        assert!((found.vertical - 0.2).abs() < 1e-14 && (found.horizontal + 0.1).abs() < 1e-14);
        // Odd: exact for what is fitted together.
        let coherent = Modes {
            vertical: 0.0,
            horizontal: 0.0,
            ..mixed
        };
        for (rows, columns) in [(3, 5), (1, 4), (3, 1), (4, 6)] {
            let network = network(rows, columns);
            let coordinates = combined(&network, coherent);
            let found = Modes::from_coordinates(&network, &coordinates);
            assert!(
                (found.uniform - 0.4).abs() < 1e-14 && (found.checkerboard + 0.7).abs() < 1e-14
            );
            assert!(found.vertical.abs() < 1e-14 && found.horizontal.abs() < 1e-14);
            assert!(orientational_spread(&network, &coordinates) < 1e-14);
        }
    }

    #[test]
    fn fractions_leave_the_uniform_mode_out() {
        let network = network(4, 4);
        let modes = Modes {
            uniform: 3.0,
            checkerboard: 2.0,
            vertical: 1.0,
            horizontal: 0.0,
        };
        let mut velocities = combined(&network, modes);
        velocities
            .chunks_exact_mut(3)
            .for_each(|v| (v[0], v[1]) = (0.5, 0.0));
        let state = State {
            time: 0.0,
            positions: vec![0.0; 48],
            velocities,
        };
        let energies = ModeEnergies::from_state(&network, &state);
        let fraction = energies
            .checkerboard_fraction(OutOf::Rotational, 0.0)
            .unwrap();
        assert!((fraction - 4.0 / 5.0).abs() < 1e-14);
        // ½ · 16/3 · 5 of rotation, ½ · 16 · ¼ of translation, and 1.
        let fraction = energies.checkerboard_fraction(OutOf::Total, 1.0).unwrap();
        assert!((fraction - (32.0 / 3.0) / (40.0 / 3.0 + 2.0 + 1.0)).abs() < 1e-14);
        let turning = combined(
            &network,
            Modes {
                uniform: 1.0,
                ..Modes::default()
            },
        );
        let mut state = State {
            time: 0.0,
            positions: vec![0.0; 48],
            velocities: turning,
        };
        state
            .velocities
            .chunks_exact_mut(3)
            .for_each(|v| (v[0], v[1]) = (0.0, 0.0));
        assert_eq!(
            ModeEnergies::from_state(&network, &state)
                .checkerboard_fraction(OutOf::Rotational, 0.0),
            None
        );
    }

    #[test]
    fn spread_is_what_the_modes_leave() {
        let network = network(4, 4);
        let modes = Modes {
            uniform: 0.5,
            checkerboard: 0.7,
            vertical: 0.03,
            horizontal: -0.04,
        };
        let coordinates = combined(&network, modes);
        assert!((orientational_spread(&network, &coordinates) - 0.05).abs() < 1e-14);
        let coherent = State::coherent(&network, 0.3);
        assert!(spread_of_magnitudes(&coherent.positions) < 1e-15);
    }
}
