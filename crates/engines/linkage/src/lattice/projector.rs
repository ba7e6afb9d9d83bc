//! Bringing positions and velocities onto the rods.
//!
//! The way is the shortest in the metric of the masses:
//!
//! positions: s -= M⁻¹ Jᵀ A⁻¹ σ until σ = 0 (Newton's method; A = J M⁻¹ Jᵀ),
//! velocities: v -= M⁻¹ Jᵀ A⁻¹ J v.

use super::dynamics::project;
use super::network::Network;
use super::rods::RodSystem;
use crate::plane::largest_magnitude;
use crate::{CrystalError, Result};

/// Rods are brought this close to their lengths, plus the rounding of the largest coordinate.
const ROD_TOLERANCE: f64 = 1e-13;
/// Rods whose error no longer halves are as near as rounding allows within this many tolerances.
const STALLED_WITHIN: f64 = 8.0;
/// The largest |J v| that a projection leaves.
const VELOCITY_TOLERANCE: f64 = 1e-14;
/// Largest number of iterations that bring rods onto their length.
const MOST_ITERATIONS: usize = 50;

/// Brings positions and velocities onto the rods.
///
/// ```
/// use protomer_linkage::lattice::{Edges, Network, Projector, Square, State};
/// let network = Network::lattice(2, 2, 0.5, Square::default(), Edges::Open, 0.3)?;
/// let mut state = State::coherent(&network, 0.3);
/// state.positions[2] += 0.1;
/// let iterations = Projector::new(&network).positions(&mut state.positions)?;
/// assert!((1..10).contains(&iterations));
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Projector {
    rods: RodSystem,
    sigma: Vec<f64>,
}

impl Projector {
    /// A projector onto the rods of this network.
    pub fn new(network: &Network) -> Self {
        let rods = RodSystem::new(network);
        let sigma = vec![0.0; rods.len()];
        Self { rods, sigma }
    }

    /// Moves the squares, heavy ones the least, until every rod has its length. Returns the number
    /// of iterations.
    ///
    /// # Errors
    /// [`CrystalError::OverConstrained`] at a singular position, [`CrystalError::NotFinite`] for
    /// positions that are not finite, [`CrystalError::BadState`] if the iteration does not
    /// converge.
    pub fn positions(&mut self, positions: &mut [f64]) -> Result<usize> {
        let extent = largest_magnitude(positions).max(1.0);
        let tolerance = ROD_TOLERANCE + 2.0 * f64::EPSILON * extent;
        let mut before = f64::INFINITY;
        for iteration in 0..MOST_ITERATIONS {
            let (rod, violation) = self.rods.violations(positions, &mut self.sigma);
            let error = violation.abs();
            let stalled = error >= 0.5 * before && error <= STALLED_WITHIN * tolerance;
            if error <= tolerance || stalled {
                return Ok(iteration);
            }
            if !violation.is_finite() {
                return Err(CrystalError::BadState(format!(
                    "rod {rod} has no finite length"
                )));
            }
            before = error;
            // Newton's method: A is factored again at every iteration, as the start may be far off.
            self.rods.linearize(positions, 0.0)?;
            self.rods.solve(&mut self.sigma);
            self.rods.add_response(&self.sigma, -1.0, positions);
        }
        let (rod, violation) = self.rods.violations(positions, &mut self.sigma);
        Err(CrystalError::BadState(format!(
            "the positions cannot be brought onto the rods: rod {rod} is still off by \
             {violation:+e} after {MOST_ITERATIONS} iterations; start nearer to a state that obeys \
             them"
        )))
    }

    /// Removes from the velocities what would change the lengths of the rods at these positions.
    ///
    /// # Errors
    /// [`CrystalError::OverConstrained`] at a singular position, [`CrystalError::NotFinite`] for
    /// positions that are not finite.
    pub fn velocities(&mut self, positions: &[f64], velocities: &mut [f64]) -> Result<()> {
        self.rods.linearize(positions, 0.0)?;
        project(
            &mut self.rods,
            velocities,
            VELOCITY_TOLERANCE,
            &mut self.sigma,
        );
        Ok(())
    }
}
