//! Geometric cluster moves (Liu and Luijten, Phys. Rev. Lett. 92, 035504 (2004)) by proper
//! rotations.
//!
//! A half turn T about an axis is applied to a seed body. A partner j of a moved body i follows
//! with probability 1 - exp(-max(0, Δ)), Δ = u(T i, j) - u(i, j), which is 1 if T i overlaps j;
//! then j's partners are tested, and so on. The result is always accepted.
//!
//! **Why this is exact.** T is an isometry of the space and its own inverse (Dress and Krauth, J.
//! Phys. A 28, L597 (1995)), so the reverse move starts from the same seed with the same T, and
//! every bond inside the cluster has the same Δ in both directions. Only the bonds that failed
//! between the cluster and the rest differ, and the ratio of their probabilities is Π exp(-Δ) =
//! exp(-ΔU): the Boltzmann factor. It remains that T must be as likely in the state after the move
//! as before; see [`HalfTurn::random`]. A half turn is a proper rotation, so it does not turn a
//! protein into its mirror image, as a point reflection would.

use crate::Result;
use crate::energy::EnergyModel;
use crate::hard::HardBodies;
use crate::neighbours::Neighbours;
use crate::system::{System, Trial};
use nalgebra::{Quaternion, Unit};
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Rotation, Vec3};

/// A rotation by π about an axis.
///
/// ```
/// use protomer_kernel::{Pose, Vec3};
/// use protomer_mc::moves::HalfTurn;
/// let turn = HalfTurn { point: Vec3::new(5.0, 0.0, 0.0), direction: Vec3::z() };
/// let image = turn.apply(&Pose::identity());
/// assert!((image.position - Vec3::new(10.0, 0.0, 0.0)).norm() < 1e-12);
/// assert!(turn.apply(&image).position.norm() < 1e-12, "twice is the identity");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfTurn {
    /// A point of the axis, Å.
    pub point: Vec3,
    /// Direction of the axis, of length one.
    pub direction: Vec3,
}

impl HalfTurn {
    /// Draws a half turn for the body `seed` that maps the space to itself.
    ///
    /// * Open space: any axis at a distance d from the seed's origin, d uniform in 0..reach, in a
    ///   random direction.
    /// * A periodic box, which need not be a cube: an axis along a random edge of the box. Only
    ///   these turns carry the lattice of images into itself. One time in two the axis passes at a
    ///   distance below `reach_angstrom` from the seed, one time in two anywhere through the box.
    /// * A spherical wall: an axis through the wall's centre.
    ///
    /// **Why T is as likely after the move as before.** The probability density of an axis
    /// depends only on its direction and its distance from the seed's origin (or on neither). A
    /// half turn keeps the distance between the seed's origin and its own axis. On a periodic box
    /// one and the same T has several axes, at half the box length from each other; T maps each
    /// of them to itself up to images, so the sum over them is conserved too.
    pub fn random(system: &System, seed: usize, reach_angstrom: f64, rng: &mut CounterRng) -> Self {
        let origin = system.pose(seed).position;
        match system.boundary() {
            Boundary::Open => {
                let direction = rng.unit_vector();
                Self {
                    point: origin + perpendicular(&direction, reach_angstrom, rng),
                    direction,
                }
            }
            Boundary::Periodic { lengths_angstrom } => {
                let mut direction = Vec3::zeros();
                direction[rng.index(3)] = 1.0;
                // One time in two near the seed, where bodies meet; else anywhere.
                let point = if rng.uniform() < 0.5 {
                    origin + perpendicular(&direction, reach_angstrom, rng)
                } else {
                    lengths_angstrom.map(|length| length * rng.uniform_in(-0.5, 0.5))
                };
                Self { point, direction }
            }
            Boundary::SphereWall { .. } => Self {
                point: Vec3::zeros(),
                direction: rng.unit_vector(),
            },
        }
    }

    /// The pose after the half turn.
    pub fn apply(&self, pose: &Pose) -> Pose {
        let from_axis = pose.position - self.point;
        // x → p + 2 (d·(x - p)) d - (x - p): the part along the axis stays, the other is reversed.
        let doubled_projection = self.direction * (2.0 * self.direction.dot(&from_axis));
        // A half turn about d is the quaternion (0, d).
        let turn: Rotation = Unit::new_unchecked(Quaternion::from_imag(self.direction));
        Pose {
            position: self.point + doubled_projection - from_axis,
            rotation: turn * pose.rotation,
        }
    }
}

/// A vector perpendicular to `direction`, with length uniform in 0..reach.
fn perpendicular(direction: &Vec3, reach: f64, rng: &mut CounterRng) -> Vec3 {
    let length = reach * rng.uniform();
    loop {
        let perpendicular = rng.unit_vector().cross(direction);
        // Nearly parallel vectors have a product of no certain direction.
        if perpendicular.norm_squared() > 1e-6 {
            return perpendicular.normalize() * length;
        }
    }
}

/// Grows the cluster of `seed` under the half turn and returns its members, ascending. The
/// proposed energies remain in the model, ready to be committed; the system is not changed.
///
/// # Errors
/// [`McError::NonFiniteEnergy`](crate::McError::NonFiniteEnergy) names a pair whose energy is not
/// finite.
pub(crate) fn grow(
    system: &System,
    seed: usize,
    turn: &HalfTurn,
    hard: &mut HardBodies,
    energy: &mut dyn EnergyModel,
    neighbours: &Neighbours,
    rng: &mut CounterRng,
) -> Result<Vec<usize>> {
    let mut in_cluster = vec![false; system.len()];
    in_cluster[seed] = true;
    let mut to_ask = vec![seed];
    let (mut near, mut near_old) = (Vec::new(), Vec::new());
    while let Some(body) = to_ask.pop() {
        let trial = Trial {
            system,
            body,
            // As the system stores it: energies are those of the pose that the move will leave.
            pose: system.tidy(turn.apply(system.pose(body))),
        };
        neighbours.around(&trial.pose.position, &mut near);
        // Partners of both places: a bond may be due to
        // what the body leaves as well as to what it meets.
        neighbours.around(&system.pose(body).position, &mut near_old);
        merge(&mut near, &near_old);
        for &partner in &near {
            // A bond is asked once; one that failed counts in the ratio of probabilities as it is.
            if in_cluster[partner] {
                continue;
            }
            // Bound with probability 1 - exp(-Δ): Δ > -ln(1 - w), with w drawn first.
            // Drawn before the overlap is tested: how many
            // numbers are used must not depend on the test.
            let threshold_kt = -(1.0 - rng.uniform()).ln();
            // An overlap is Δ = ∞, which exceeds every threshold.
            if hard.overlap(&trial.pair(partner))
                || energy.exceeds(&trial, partner, threshold_kt)?
            {
                in_cluster[partner] = true;
                to_ask.push(partner);
            }
        }
    }
    Ok((0..system.len()).filter(|body| in_cluster[*body]).collect())
}

/// Adds the elements that are only in `other`; both are sorted in ascending order.
fn merge(indices: &mut Vec<usize>, other: &[usize]) {
    indices.extend_from_slice(other);
    indices.sort_unstable();
    indices.dedup();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_turn_is_a_proper_rotation_and_its_own_inverse() {
        let mut rng = CounterRng::new(9, 0, 0);
        for _ in 0..100 {
            let turn = HalfTurn {
                point: rng.vector_in_ball(30.0),
                direction: rng.unit_vector(),
            };
            let pose = Pose {
                position: rng.vector_in_ball(50.0),
                rotation: rng.rotation(),
            };
            let moved = turn.apply(&pose);
            let back = turn.apply(&moved);
            assert!((back.position - pose.position).norm() < 1e-12);
            assert!(back.rotation.angle_to(&pose.rotation) < 1e-7);
            // Every point of the body moves as the half turn moves it: the pose is turned as a
            // whole.
            let point = rng.vector_in_ball(10.0);
            let from_axis = pose.transform_point(&point) - turn.point;
            let expected =
                turn.point + turn.direction * (2.0 * turn.direction.dot(&from_axis)) - from_axis;
            assert!((moved.transform_point(&point) - expected).norm() < 1e-12);
        }
    }
}
