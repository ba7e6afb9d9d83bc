//! Screened charges on the squares.
//!
//! Charges q at fixed places c in the frames of their squares act on those of other squares through
//!
//! V = kT Σ q q' λ_B exp(-κ r) / r, with r in Å = scale · |Δ|, Δ = s + R(θ) c - s' - R(θ') c'.
//!
//! The force on the first charge, in reduced units, is F = -kT q q' V'(r) scale Δ/|Δ|, and the
//! torque on its square (R c)_x F_y - (R c)_y F_x. At a finite cut-off, value and slope are taken
//! off, V(r) - V(r_c) - (r - r_c) V'(r_c), so that neither energy nor force jumps.

use super::force::Force;
use super::network::Network;
use crate::{CrystalError, Result};
use protomer_kernel::potential::Yukawa;
use serde::{Deserialize, Serialize};

/// A charge on a square.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SquareCharge {
    /// Where it is in the frame of the square at θ = 0, in half-diagonals of the unit square.
    pub position: [f64; 2],
    /// Elementary charges.
    pub charge: f64,
}

/// Two squares that act on each other, the second in this periodic image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SquarePair {
    /// Their indices.
    pub squares: [usize; 2],
    /// Cells along x and y.
    #[serde(default)]
    pub image: [i32; 2],
}

/// The screened Coulomb forces between the charges of neighbouring squares.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenedCharges {
    yukawa: Yukawa,
    scale_angstrom: f64,
    kt: f64,
    charges: Vec<Vec<SquareCharge>>,
    pairs: Vec<SquarePair>,
}

impl ScreenedCharges {
    /// Charges per square, the length of one unit in Å, and kT in reduced units (mass · unit² /
    /// time²).
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
        for (setting, value) in [("scale_angstrom", scale_angstrom), ("kt", kt)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(CrystalError::BadSetting {
                    setting,
                    value,
                    requirement: "positive",
                });
            }
        }
        let squares = network.squares.len();
        if charges.len() != squares {
            return Err(CrystalError::BadNetwork(format!(
                "there are charges for {} squares, but {squares} squares; give one list per square",
                charges.len()
            )));
        }
        for pair in &pairs {
            let [first, second] = pair.squares;
            if first >= squares || second >= squares || (first == second && pair.image == [0, 0]) {
                return Err(CrystalError::BadNetwork(format!(
                    "squares {first} and {second} are no pair of {squares}"
                )));
            }
            if pair.image != [0, 0] && network.cell.is_none() {
                return Err(CrystalError::BadNetwork(format!(
                    "squares {first} and {second} meet in a periodic image, but the network has no cell"
                )));
            }
        }
        Ok(Self {
            yukawa,
            scale_angstrom,
            kt,
            charges,
            pairs,
        })
    }

    /// The same charges on every square, which act on the eight squares around each.
    ///
    /// # Errors
    /// As [`ScreenedCharges::new`].
    pub fn on_every_square(
        network: &Network,
        yukawa: Yukawa,
        scale_angstrom: f64,
        kt: f64,
        charges: &[SquareCharge],
    ) -> Result<Self> {
        let charges = vec![charges.to_vec(); network.squares.len()];
        Self::new(
            network,
            yukawa,
            scale_angstrom,
            kt,
            charges,
            neighbours(network),
        )
    }

    /// The pairs of squares.
    pub fn pairs(&self) -> &[SquarePair] {
        &self.pairs
    }

    /// V and dV/dr of unit charges, in kT and kT/Å.
    fn potential(&self, distance_angstrom: f64) -> [f64; 2] {
        let plain = |r: f64| {
            let energy = self.yukawa.bjerrum_length_angstrom
                * (-self.yukawa.inverse_debye_length_per_angstrom * r).exp()
                / r;
            [
                energy,
                -energy * (1.0 / r + self.yukawa.inverse_debye_length_per_angstrom),
            ]
        };
        let cutoff = self.yukawa.cutoff_angstrom;
        if distance_angstrom >= cutoff {
            return [0.0; 2];
        }
        let [energy, slope] = plain(distance_angstrom);
        if cutoff == f64::INFINITY {
            return [energy, slope];
        }
        let [energy_there, slope_there] = plain(cutoff);
        [
            energy - energy_there - (distance_angstrom - cutoff) * slope_there,
            slope - slope_there,
        ]
    }
}

impl Force for ScreenedCharges {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        let cell = network.cell.unwrap_or([0.0; 2]);
        let turned: Vec<[f64; 2]> = positions
            .iter()
            .skip(2)
            .step_by(3)
            .map(|angle| angle.sin_cos().into())
            .collect();
        let arm = |square: usize, charge: &SquareCharge| {
            let ([sine, cosine], [x, y]) = (turned[square], charge.position);
            [cosine * x - sine * y, sine * x + cosine * y]
        };
        let mut total = 0.0;
        for pair in &self.pairs {
            let [p, q] = pair.squares;
            let apart = |axis: usize| {
                positions[3 * p + axis]
                    - positions[3 * q + axis]
                    - f64::from(pair.image[axis]) * cell[axis]
            };
            let between = [apart(0), apart(1)];
            let (mut force, mut torques) = ([0.0; 2], [0.0; 2]);
            for first in &self.charges[p] {
                let here = arm(p, first);
                for second in &self.charges[q] {
                    let there = arm(q, second);
                    let delta = [
                        between[0] + here[0] - there[0],
                        between[1] + here[1] - there[1],
                    ];
                    let distance = delta[0].hypot(delta[1]);
                    let [energy, slope] = self.potential(distance * self.scale_angstrom);
                    let strength = self.kt * first.charge * second.charge;
                    total += strength * energy;
                    let pull = -strength * slope * self.scale_angstrom / distance;
                    let [x, y] = [pull * delta[0], pull * delta[1]];
                    force[0] += x;
                    force[1] += y;
                    torques[0] += here[0] * y - here[1] * x;
                    torques[1] -= there[0] * y - there[1] * x;
                }
            }
            for (square, sign, torque) in [(p, 1.0, torques[0]), (q, -1.0, torques[1])] {
                let body = &network.squares[square];
                accelerations[3 * square] += sign * force[0] / body.mass;
                accelerations[3 * square + 1] += sign * force[1] / body.mass;
                accelerations[3 * square + 2] += torque / body.inertia;
            }
        }
        total
    }
}

/// Every two squares that are next to each other in the lattice along rows, columns or diagonals,
/// once each.
pub fn neighbours(network: &Network) -> Vec<SquarePair> {
    let (rows, columns) = (network.rows as i64, network.columns as i64);
    // Outside the lattice there is nothing, or the next cell: its number along this axis.
    let wrap = |index: i64, count: i64| {
        let cells = index.div_euclid(count);
        (cells == 0 || network.cell.is_some()).then_some((index.rem_euclid(count), cells as i32))
    };
    let mut pairs = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            for (down, right) in [(0, 1), (1, 0), (1, 1), (1, -1)] {
                if let (Some((row, below)), Some((column, beside))) =
                    (wrap(i + down, rows), wrap(j + right, columns))
                {
                    let square = |row: i64, column: i64| network.at(row as usize, column as usize);
                    if let (Some(first), Some(second)) = (square(i, j), square(row, column)) {
                        // y falls with the row.
                        pairs.push(SquarePair {
                            squares: [first, second],
                            image: [beside, -below],
                        });
                    }
                }
            }
        }
    }
    pairs
}
