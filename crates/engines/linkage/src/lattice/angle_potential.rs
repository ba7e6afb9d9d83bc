//! Potentials of angles: of the angle between two joined squares, and of the opening of the crystal.
//!
//! The opening of a rod's joint is φ = (-1)^(i+j) (θ - θ'), with the sign of the square of θ; the sign
//! of the other is its opposite, so both squares give the same φ. In the coherent motion φ = 2 θ_c: 0
//! and π where closed, π/2 where open. A potential V(φ) of every rod is the free energy of two bodies
//! that are tied at their corners, and its range is that of a rod.
//!
//! A potential of the opening acts on all squares at once, V = N U(⟨θ⟩₁) with the mean ⟨θ⟩₁ of
//! (-1)^(i+j) θ as in the coherence potential: the free energy per square of the crystal as a whole,
//! of infinite range.

use super::force::{Force, coherent_part};
use super::network::Network;
use crate::error::{CrystalError, Result};
use protomer_kernel::spline::Spline;

/// A share of the squared sum of inertia below which all squares have one sign.
const ONE_SIGN: f64 = 1e-12;

/// The potential V(φ) of the opening φ of every joint.
///
/// ```
/// use protomer_linkage::lattice::{Edges, Force, JointPotential, Network, Square, State};
/// use protomer_kernel::spline::{Ends, Spline};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let spline = Spline::through(&[0.0, 1.0, 2.0, 3.0], &[0.0, 2.0, 1.0, 0.0], Ends::Straight)?;
/// let potential = JointPotential::new(&network, spline.clone())?;
/// let state = State::coherent(&network, 0.3);
/// let mut accelerations = vec![0.0; state.positions.len()];
/// let energy = potential.accelerate(&network, &state.positions, &mut accelerations);
/// assert!((energy - 4.0 * spline.evaluate(0.6)[0]).abs() < 1e-12, "four rods");
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointPotential {
    spline: Spline,
    joints: Vec<Joint>,
}

/// Two squares that a rod joins, and the sign of the first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Joint {
    squares: [usize; 2],
    sign: f64,
}

/// The joints of a network, one for each rod.
fn joints(network: &Network) -> Result<Vec<Joint>> {
    let mut joints = Vec::with_capacity(network.rods.len());
    for (index, rod) in network.rods.iter().enumerate() {
        let squares = [rod.from.square, rod.to.square];
        let [sign, other] = squares.map(|square| network.sign(square));
        if sign == other {
            return Err(CrystalError::BadNetwork(format!(
                "rod {index} joins squares {} and {}, which have the same sign of (-1)^(i+j): their \
                 joint has no opening; remove the rod or the angle potential",
                squares[0], squares[1]
            )));
        }
        joints.push(Joint { squares, sign });
    }
    Ok(joints)
}

/// The opening φ of every joint, in the order of the rods.
///
/// ```
/// use protomer_linkage::lattice::angle_potential::openings;
/// use protomer_linkage::lattice::{Edges, Network, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let openings = openings(&network, &State::coherent(&network, 0.3).positions)?;
/// assert!(openings.iter().all(|opening| (opening - 0.6).abs() < 1e-12));
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
///
/// # Errors
/// [`CrystalError::BadNetwork`] names a rod between squares of the same sign.
pub fn openings(network: &Network, positions: &[f64]) -> Result<Vec<f64>> {
    let joints = joints(network)?;
    let mut openings = Vec::with_capacity(joints.len());
    for joint in joints {
        openings.push(joint.opening(positions));
    }
    Ok(openings)
}

impl Joint {
    fn opening(&self, positions: &[f64]) -> f64 {
        let [p, q] = self.squares;
        self.sign * (positions[3 * p + 2] - positions[3 * q + 2])
    }
}

impl JointPotential {
    /// Creates the potential at every rod of the network.
    ///
    /// # Errors
    /// As [`openings`].
    pub fn new(network: &Network, spline: Spline) -> Result<Self> {
        let joints = joints(network)?;
        Ok(Self { spline, joints })
    }
}

impl Force for JointPotential {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        let mut sum = 0.0;
        for joint in &self.joints {
            let [p, q] = joint.squares;
            let [energy, slope, _] = self.spline.evaluate(joint.opening(positions));
            let torque = joint.sign * slope;
            accelerations[3 * p + 2] -= torque / network.squares[p].inertia;
            accelerations[3 * q + 2] += torque / network.squares[q].inertia;
            sum += energy;
        }
        sum
    }
}

/// The potential N U(θ_c) of the opening θ_c = ⟨θ⟩₁ of N squares.
///
/// ```
/// use protomer_kernel::spline::{Ends, Spline};
/// use protomer_linkage::lattice::{Edges, Force, Network, OpeningPotential, Square, State};
/// let network = Network::lattice(2, 3, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let spline = Spline::through(&[0.0, 0.5, 1.0], &[0.0, 1.0, 0.0], Ends::Straight)?;
/// let potential = OpeningPotential::new(&network, spline.clone())?;
/// let state = State::coherent(&network, 0.3);
/// let mut accelerations = vec![0.0; state.positions.len()];
/// let energy = potential.accelerate(&network, &state.positions, &mut accelerations);
/// assert!((energy - 6.0 * spline.evaluate(0.3)[0]).abs() < 1e-12, "six squares");
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct OpeningPotential {
    spline: Spline,
    /// dθ_c/dθ over the inertia, of every square.
    weights: Vec<f64>,
}

impl OpeningPotential {
    /// Creates the potential of the opening of the network.
    ///
    /// # Errors
    /// [`CrystalError::BadNetwork`] if all squares have the same sign, so that there is no opening.
    pub fn new(network: &Network, spline: Spline) -> Result<Self> {
        let (mut inertia, mut signed) = (0.0, 0.0);
        for (p, square) in network.squares.iter().enumerate() {
            inertia += square.inertia;
            signed += square.inertia * network.sign(p);
        }
        // θ_c is linear in the angles: its derivatives are those of the normal equations of
        // `coherent_part`.
        let determinant = inertia * inertia - signed * signed;
        if determinant <= ONE_SIGN * inertia * inertia {
            return Err(CrystalError::BadNetwork(
                "all squares have the same sign of (-1)^(i+j), so the crystal has no opening; remove \
                 the opening potential"
                    .into(),
            ));
        }
        let squares = 0..network.squares.len();
        Ok(Self {
            spline,
            weights: squares
                .map(|p| (inertia * network.sign(p) - signed) / determinant)
                .collect(),
        })
    }
}

impl Force for OpeningPotential {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        let [_, opening] = coherent_part(network, positions);
        let [energy, slope, _] = self.spline.evaluate(opening);
        let squares = self.weights.len() as f64;
        for (p, weight) in self.weights.iter().enumerate() {
            accelerations[3 * p + 2] -= squares * slope * weight;
        }
        squares * energy
    }
}
