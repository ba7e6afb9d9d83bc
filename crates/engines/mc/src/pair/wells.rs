//! Bound poses: local minima of the energy, each once, the lowest first.

use super::BodyPair;
use super::estimator::Found;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Pose, Rotation};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A local minimum of the energy of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BoundPose {
    /// Energy, kT.
    pub energy_kt: f64,
    /// The second body in the frame of the first.
    pub pose: Pose,
}

/// Starts that are brought down to a minimum.
const MOST_STARTS: usize = 64;
/// Poses that are returned.
const MOST_POSES: usize = 24;
/// Trial moves of one descent.
const TRIALS: u32 = 1200;
/// Temperature at the start and at the end of a descent, in units of kT.
const TEMPERATURES: (f64, f64) = (0.5, 0.005);
/// Poses nearer than this root mean square distance of the body's points are one, Å.
const SAME_POSE_ANGSTROM: f64 = 5.0;

/// The minima below these starts, without repetitions. Poses of zero or positive energy are not
/// bound.
///
/// `are_equal` says that both bodies are the same: a pose and its inverse are one then.
pub fn bound_poses(
    pair: &BodyPair,
    starts: &[Found],
    are_equal: bool,
    seed: u64,
) -> Vec<BoundPose> {
    let different = Different::new(pair, are_equal);
    let starts = starts.iter().map(|start| BoundPose {
        energy_kt: start.energy_kt,
        pose: start.pose,
    });
    // The lowest of each well only: descents of the same well would find the same minimum.
    let apart = different.bound(starts, MOST_STARTS);
    let descend = |(number, start): (usize, &BoundPose)| {
        // A stream per start: results do not depend on the order of threads.
        let mut rng = CounterRng::for_purpose(seed, number as u32, 0, Purpose::PairDescent);
        descend(pair, start, &mut rng)
    };
    let mut minima: Vec<BoundPose> = apart.par_iter().enumerate().map(descend).collect();
    minima.sort_by(|a, b| a.energy_kt.total_cmp(&b.energy_kt));
    // Again after the descents, as two starts may have ended in one minimum.
    different.bound(minima, MOST_POSES)
}

/// The first of these poses that are unlike all before them, up to a number of poses. In the order of their
/// energies, that is the lowest pose of each well.
pub(super) fn apart(pair: &BodyPair, found: Vec<Found>, most: usize) -> Vec<Found> {
    let different = Different::new(pair, false);
    let mut kept: Vec<Found> = Vec::with_capacity(most);
    for found in found {
        if kept.len() == most {
            break;
        }
        if different.is_new(kept.iter().map(|kept| &kept.pose), &found.pose) {
            kept.push(found);
        }
    }
    kept
}

/// A Monte Carlo walk that cools down, with steps that shrink with the temperature; the lowest pose
/// it met.
fn descend(pair: &BodyPair, start: &BoundPose, rng: &mut CounterRng) -> BoundPose {
    let radius = pair.second.hard_radius_angstrom().max(1.0);
    let (hot, cold) = TEMPERATURES;
    let mut present = *start;
    let mut lowest = *start;
    for trial in 0..TRIALS {
        let progress = f64::from(trial) / f64::from(TRIALS);
        let temperature = hot * (cold / hot).powf(progress);
        let step_angstrom = 1.5 * (0.03_f64).powf(progress);
        // A turn moves the surface at most twice as far as a shift does.
        let turn = rng.small_rotation(2.0 * step_angstrom / radius);
        let pose = Pose {
            position: present.pose.position + rng.vector_in_ball(step_angstrom),
            rotation: turn * present.pose.rotation,
        };
        let relative = RelativePose::from(&pose);
        // An overlap is passed over before the energy, which is not defined there.
        if pair.excludes(&relative) {
            continue;
        }
        let energy_kt = pair.potential.energy_kt(&relative);
        let rise = energy_kt - present.energy_kt;
        // Uniform numbers are drawn only for rises; each
        // descent has its own stream, so nothing else shifts.
        if rise <= 0.0 || rng.uniform() < (-rise / temperature).exp() {
            present = BoundPose { energy_kt, pose };
            if energy_kt < lowest.energy_kt {
                lowest = present;
            }
        }
    }
    lowest
}

/// Tells poses apart.
pub(super) struct Different {
    square_of_gyration: f64,
    are_equal: bool,
}

/// Mean square displacement of the points of a body that is shifted, and turned by an angle with this versine, Å².
pub(super) fn square_displacement(
    square_shift_angstrom2: f64,
    versine: f64,
    square_of_gyration_angstrom2: f64,
) -> f64 {
    square_shift_angstrom2 + 4.0 / 3.0 * versine * square_of_gyration_angstrom2
}

/// Versine 1 - cos θ of the angle of a rotation: 2 |v|² with the vector part v of its quaternion.
pub(super) fn versine(turn: &Rotation) -> f64 {
    2.0 * turn.imag().norm_squared()
}

impl Different {
    pub(super) fn new(pair: &BodyPair, are_equal: bool) -> Self {
        Self {
            square_of_gyration: pair.second.square_of_gyration_angstrom2(),
            are_equal,
        }
    }

    /// Whether both bodies are the same.
    pub(super) fn are_equal(&self) -> bool {
        self.are_equal
    }

    /// The first of these poses that are bound and unlike all before them, up to a number of poses.
    fn bound(&self, found: impl IntoIterator<Item = BoundPose>, most: usize) -> Vec<BoundPose> {
        let mut poses: Vec<BoundPose> = Vec::new();
        for pose in found {
            let is_new = self.is_new(poses.iter().map(|kept| &kept.pose), &pose.pose);
            if pose.energy_kt < 0.0 && is_new && poses.len() < most {
                poses.push(pose);
            }
        }
        poses
    }

    /// Whether a pose is unlike all of these.
    fn is_new<'a>(&self, mut kept: impl Iterator<Item = &'a Pose>, pose: &Pose) -> bool {
        !kept.any(|kept| self.are_same(kept, pose))
    }

    fn are_same(&self, a: &Pose, b: &Pose) -> bool {
        self.square_distance_as_complexes(a, b) < SAME_POSE_ANGSTROM.powi(2)
    }

    /// The mean square distance of two poses, Å²; of equal bodies a pose and its inverse are one.
    pub(super) fn square_distance_as_complexes(&self, a: &Pose, b: &Pose) -> f64 {
        let square = self.square_distance(a, b);
        match self.are_equal {
            // The inverse pose shows the same complex from the other body.
            true => square.min(self.square_distance(a, &b.inverse())),
            false => square,
        }
    }

    /// The mean square distance of the points of the second body at two poses, Å².
    pub(super) fn square_distance(&self, a: &Pose, b: &Pose) -> f64 {
        let turn: Rotation = a.rotation.inverse() * b.rotation;
        let square_shift = (a.position - b.position).norm_squared();
        square_displacement(square_shift, versine(&turn), self.square_of_gyration)
    }
}
