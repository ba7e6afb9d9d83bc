//! Screened charges on the squares.
//!
//! Charges q at fixed places c in the frames of their squares act on those of other squares through
//!
//! V = kT Σ q q' λ_B exp(-κ r) / r, with r in Å = scale · |Δ|, Δ = s + R(θ) c - s' - R(θ') c'.
//!
//! The force on the first charge, in reduced units, is F = -kT q q' V'(r) scale Δ/|Δ|, and the
//! torque on its square (R c)_x F_y - (R c)_y F_x. There is no cut-off between charges. Squares are
//! left out as a whole where so many others lie between them that exp(-κ r) is below 10⁻³ for every
//! pair of their charges; see [`rings`].

use super::cell::{Cell, cell_gradient};
use super::force::Force;
use super::network::Network;
use super::state::angles;
use crate::error::{CrystalError, Result, require_positive};
use crate::plane::{Vector, cross, direction, minus, norm, plus, scaled, turned};
use protomer_kernel::potential::Yukawa;
use serde::{Deserialize, Serialize};
use std::f64::consts::SQRT_2;

/// Squares act on each other unless their charges are more Debye lengths apart: exp(-7) = 9·10⁻⁴.
const FARTHEST_DEBYE_LENGTHS: f64 = 7.0;
/// Rows of images on which a square of a periodic lattice may act at most.
const MOST_RINGS: usize = 100;

/// A charge on a square.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SquareCharge {
    /// Position in the frame of the square at θ = 0, in half-diagonals of the unit square.
    pub position: [f64; 2],
    /// Charge in elementary charges.
    pub charge: f64,
}

/// Two squares that act on each other, the second in this periodic image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SquarePair {
    /// Indices of the squares.
    pub squares: [usize; 2],
    /// The image of the second, in cells along x and y.
    #[serde(default)]
    pub image: [i32; 2],
}

/// The screened Coulomb forces between the charges of neighbouring squares.
///
/// ```
/// use protomer_linkage::lattice::pair::SquareCharge;
/// use protomer_linkage::lattice::{Edges, Force, Network, ScreenedCharges, Square, State};
/// use protomer_kernel::potential::Yukawa;
/// let network = Network::lattice(1, 2, 1.0, Square::default(), Edges::Open, 0.0)?;
/// let state = State::coherent(&network, 0.0);
/// // One charge in the middle of each square, 14 Å per unit of length.
/// let charges = [SquareCharge { position: [0.0, 0.0], charge: 2.0 }];
/// let yukawa = Yukawa::new(7.0, 1.0 / 9.6, f64::INFINITY)?;
/// let force = ScreenedCharges::on_every_square(&network, yukawa, 14.0, 0.1, &charges)?;
/// let mut accelerations = vec![0.0; state.positions.len()];
/// let energy = force.accelerate(&network, &state.positions, &mut accelerations);
/// let apart_angstrom = 14.0 * (state.positions[3] - state.positions[0]);
/// assert!((energy - 0.1 * 4.0 * yukawa.energy_kt(apart_angstrom)).abs() < 1e-15);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenedCharges {
    yukawa: Yukawa,
    scale_angstrom: f64,
    kt: f64,
    charges: Vec<Vec<SquareCharge>>,
    pairs: Vec<SquarePair>,
}

/// The force between the charges of two squares, and what it does to each of them.
#[derive(Debug, Clone, Copy, Default)]
struct Interaction {
    energy: f64,
    /// Force on the first square; that on the second is its opposite.
    force: Vector,
    torques: [f64; 2],
}

impl ScreenedCharges {
    /// Forces between these charges per square, with the length of one unit in Å, and kT in reduced
    /// units (mass · unit² / time²).
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`] for a scale or kT that is not positive,
    /// [`CrystalError::BadNetwork`] for charges or pairs that do not fit the network.
    pub fn new(
        network: &Network,
        yukawa: Yukawa,
        scale_angstrom: f64,
        kt: f64,
        charges: Vec<Vec<SquareCharge>>,
        pairs: Vec<SquarePair>,
    ) -> Result<Self> {
        require_positive("scale_angstrom", scale_angstrom)?;
        require_positive("kt", kt)?;
        let squares = network.squares.len();
        if charges.len() != squares {
            return Err(CrystalError::BadNetwork(format!(
                "there are charges for {} squares, but {squares} squares; give one list per square",
                charges.len()
            )));
        }
        for pair in &pairs {
            check_pair(network, pair)?;
        }
        Ok(Self {
            yukawa,
            scale_angstrom,
            kt,
            charges,
            pairs,
        })
    }

    /// Forces between the same charges on every square; each square acts on those in the [`rings`]
    /// around it.
    ///
    /// # Errors
    /// As [`ScreenedCharges::new`], and [`CrystalError::BadSetting`] for a Debye length that reaches
    /// over more than 100 squares of a periodic lattice.
    pub fn on_every_square(
        network: &Network,
        yukawa: Yukawa,
        scale_angstrom: f64,
        kt: f64,
        charges: &[SquareCharge],
    ) -> Result<Self> {
        require_positive("scale_angstrom", scale_angstrom)?;
        let charges = vec![charges.to_vec(); network.squares.len()];
        let debye_length = yukawa.inverse_debye_length_per_angstrom.recip();
        let rings = rings(network, debye_length / scale_angstrom);
        if network.cell.is_some() && rings > MOST_RINGS {
            return Err(CrystalError::BadSetting {
                setting: "debye_length_angstrom",
                value: debye_length,
                requirement: "at most 14 sides of a square where the edges are periodic",
            });
        }
        let pairs = pairs_within(network, rings);
        Self::new(network, yukawa, scale_angstrom, kt, charges, pairs)
    }

    /// The pairs of squares.
    pub fn pairs(&self) -> &[SquarePair] {
        &self.pairs
    }

    /// V and dV/dr of unit charges at this distance in Å, in kT and kT/Å.
    fn potential(&self, r: f64) -> [f64; 2] {
        // Both from one exponential.
        let kappa = self.yukawa.inverse_debye_length_per_angstrom;
        let energy = self.yukawa.bjerrum_length_angstrom * (-kappa * r).exp() / r;
        [energy, -energy * (1.0 / r + kappa)]
    }

    /// The interaction of the charges of two squares, given the vector between their centres and
    /// cosine and sine of the angles of all squares.
    fn interaction(
        &self,
        [p, q]: [usize; 2],
        between: Vector,
        turned_by: &[Vector],
    ) -> Interaction {
        let mut sum = Interaction::default();
        for first in &self.charges[p] {
            let first_arm = turned(first.position, turned_by[p]);
            for second in &self.charges[q] {
                let second_arm = turned(second.position, turned_by[q]);
                // From the second charge to the first, through the periodic image.
                let delta = minus(plus(between, first_arm), second_arm);
                let distance = norm(delta);
                let [energy, slope] = self.potential(distance * self.scale_angstrom);
                let strength = self.kt * first.charge * second.charge;
                sum.energy += strength * energy;
                // dV/dr is per Å; times the scale it is per unit of the lattice.
                let force = scaled(delta, -strength * slope * self.scale_angstrom / distance);
                sum.force = plus(sum.force, force);
                sum.torques[0] += cross(first_arm, force);
                sum.torques[1] -= cross(second_arm, force);
            }
        }
        sum
    }
}

fn check_pair(network: &Network, pair: &SquarePair) -> Result<()> {
    let squares = network.squares.len();
    let [first, second] = pair.squares;
    if first >= squares || second >= squares || (first == second && pair.image == [0, 0]) {
        return Err(CrystalError::BadNetwork(format!(
            "squares {first} and {second} are not a pair of the {squares} squares"
        )));
    }
    if pair.image != [0, 0] && network.cell.is_none() {
        return Err(CrystalError::BadNetwork(format!(
            "squares {first} and {second} meet in a periodic image, but the network has no cell"
        )));
    }
    Ok(())
}

impl Force for ScreenedCharges {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        let cell = Cell::read(network, positions);
        let turned_by: Vec<Vector> = angles(positions).map(direction).collect();
        let mut total = 0.0;
        for pair in &self.pairs {
            let [p, q] = pair.squares;
            let image = pair.image.map(f64::from);
            let (first, second) = (
                [positions[3 * p], positions[3 * p + 1]],
                [positions[3 * q], positions[3 * q + 1]],
            );
            let between = minus(minus(first, second), cell.shift(image));
            let sum = self.interaction(pair.squares, between, &turned_by);
            for (square, sign, torque) in [(p, 1.0, sum.torques[0]), (q, -1.0, sum.torques[1])] {
                let body = &network.squares[square];
                accelerations[3 * square] += sign * sum.force[0] / body.mass;
                accelerations[3 * square + 1] += sign * sum.force[1] / body.mass;
                accelerations[3 * square + 2] += torque / body.inertia;
            }
            if let (Some(mass), Some(place)) = (network.cell_mass, network.cell_place()) {
                let pulls = cell_gradient(sum.force, image);
                for (acceleration, pull) in accelerations[place..].iter_mut().zip(pulls) {
                    *acceleration -= pull / mass;
                }
            }
            total += sum.energy;
        }
        total
    }
}

/// Number of rings of squares around a square that act on it: the eight next to it are the first
/// ring.
///
/// n - 1 squares lie between a square and one of the n-th ring. They fill at least n - 1 sides of a
/// square, √2 l, whatever their angles, because squares do not overlap. `debye_length` is in
/// half-diagonals of the unit square.
pub fn rings(network: &Network, debye_length: f64) -> usize {
    let mut smallest = f64::INFINITY;
    for square in &network.squares {
        smallest = smallest.min(square.half_diagonal);
    }
    let sides = FARTHEST_DEBYE_LENGTHS * debye_length / (SQRT_2 * smallest);
    let all = network.rows.max(network.columns);
    // Sides of the smallest square between two charges, rounded up: at least as many rings.
    let rings = (sides.ceil() as usize).max(1);
    if network.cell.is_some() {
        rings
    } else {
        rings.min(all)
    }
}

/// Pairs of squares of which one is in the first `rings` rings around the other, once each, with
/// periodic images as separate partners.
pub fn pairs_within(network: &Network, rings: usize) -> Vec<SquarePair> {
    let places = places(network);
    let rings = rings as i64;
    let mut pairs = Vec::new();
    for row in 0..network.rows {
        for column in 0..network.columns {
            let Some(first) = places[row * network.columns + column] else {
                continue;
            };
            // Half of the ways around the square: the other half is that of its partners.
            for down in 0..=rings {
                // Half of the plane: down, or level and to the right.
                let leftmost = if down == 0 { 1 } else { -rings };
                for right in leftmost..=rings {
                    let below = wrap(network, row as i64 + down, network.rows);
                    // In a small periodic lattice a square meets
                    // several images of another, or of itself.
                    let beside = wrap(network, column as i64 + right, network.columns);
                    let (Some((row, cells_down)), Some((column, cells_right))) = (below, beside)
                    else {
                        continue;
                    };
                    if let Some(second) = places[row * network.columns + column] {
                        // y falls with the row.
                        pairs.push(SquarePair {
                            squares: [first, second],
                            image: [cells_right, -cells_down],
                        });
                    }
                }
            }
        }
    }
    pairs
}

/// The square at every place of the lattice, row by row.
fn places(network: &Network) -> Vec<Option<usize>> {
    let mut places = vec![None; network.rows * network.columns];
    for square in 0..network.squares.len() {
        let [row, column] = network.place(square);
        places[row * network.columns + column] = Some(square);
    }
    places
}

/// The index in the lattice, and the number of the cell along this axis; `None` beyond an open edge.
fn wrap(network: &Network, index: i64, count: usize) -> Option<(usize, i32)> {
    let cells = index.div_euclid(count as i64);
    let inside = index.rem_euclid(count as i64) as usize;
    (cells == 0 || network.cell.is_some()).then_some((inside, cells as i32))
}
