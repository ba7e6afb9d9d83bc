//! Trial moves of one body.

use super::StepSizes;
use protomer_kernel::Pose;
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// The kinds of trial moves of one body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// Moves the origin.
    Translation,
    /// Turns the body about its origin.
    Rotation,
}

/// The trial pose. A displacement and its opposite are equally likely, and so are a rotation and
/// its inverse, so the proposal is symmetric and the Metropolis rule satisfies detailed balance.
pub fn propose(pose: &Pose, kind: Kind, steps: &StepSizes, rng: &mut CounterRng) -> Pose {
    match kind {
        Kind::Translation => Pose {
            position: pose.position + rng.vector_in_ball(steps.translation_angstrom),
            rotation: pose.rotation,
        },
        Kind::Rotation => Pose {
            position: pose.position,
            rotation: rng.small_rotation(steps.rotation_rad) * pose.rotation,
        },
    }
}
