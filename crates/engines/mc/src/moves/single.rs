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
///
/// ```
/// use protomer_kernel::{Pose, random::CounterRng};
/// use protomer_mc::moves::{Kind, StepSizes, single::propose};
/// let steps = StepSizes { translation_angstrom: 0.5, rotation_rad: 0.1 };
/// let mut rng = CounterRng::new(1, 0, 0);
/// let translation = propose(&Pose::identity(), Kind::Translation, &steps, &mut rng);
/// assert!(translation.position.norm() <= 0.5 && translation.rotation.angle() == 0.0);
/// let rotation = propose(&Pose::identity(), Kind::Rotation, &steps, &mut rng);
/// assert!(rotation.position.norm() == 0.0 && rotation.rotation.angle() <= 0.1);
/// ```
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
