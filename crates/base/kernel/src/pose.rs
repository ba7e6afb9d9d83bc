//! Rigid motions of a body.

use crate::{Rotation, Vec3};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// Position and orientation of a body: a point p of the body is at `rotation * p + position`.
///
/// ```
/// use protomer_kernel::{Pose, Vec3};
/// let half_turn_about_z = [0.0, 0.0, 0.0, 1.0];
/// let pose = Pose::from_wxyz(Vec3::new(1.0, 0.0, 0.0), half_turn_about_z);
/// assert!((pose.transform_point(&Vec3::new(1.0, 0.0, 0.0)) - Vec3::zeros()).norm() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position of the body's origin, Å.
    pub position: Vec3,
    /// Orientation.
    pub rotation: Rotation,
}

impl Pose {
    /// The pose that leaves every point where it is.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let point = Vec3::new(1.0, 2.0, 3.0);
    /// assert_eq!(Pose::identity().transform_point(&point), point);
    /// ```
    pub fn identity() -> Self {
        Self {
            position: Vec3::zeros(),
            rotation: Rotation::identity(),
        }
    }

    /// A pose from a position (Å) and a quaternion, scalar first; the quaternion is normalised.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let quarter_turn_about_z = Pose::from_wxyz(Vec3::zeros(), [1.0, 0.0, 0.0, 1.0]);
    /// assert!((quarter_turn_about_z.transform_point(&Vec3::x()) - Vec3::y()).norm() < 1e-12);
    /// ```
    pub fn from_wxyz(position: Vec3, [w, x, y, z]: [f64; 4]) -> Self {
        Self {
            position,
            rotation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        }
    }

    /// The orientation as a quaternion, scalar first.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let pose = Pose::from_wxyz(Vec3::zeros(), [0.0, 0.0, 0.0, 2.0]);
    /// assert_eq!(pose.wxyz(), [0.0, 0.0, 0.0, 1.0]);
    /// ```
    pub fn wxyz(&self) -> [f64; 4] {
        let q = self.rotation.quaternion();
        [q.w, q.i, q.j, q.k]
    }

    /// The image of a point, Å.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let half_turn_about_z = Pose::from_wxyz(Vec3::new(5.0, 0.0, 0.0), [0.0, 0.0, 0.0, 1.0]);
    /// let image = half_turn_about_z.transform_point(&Vec3::x());
    /// assert!((image - Vec3::new(4.0, 0.0, 0.0)).norm() < 1e-12, "turned first, then moved");
    /// ```
    pub fn transform_point(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.position
    }

    /// The point of the body that is at `point`, Å.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let pose = Pose { position: Vec3::new(5.0, 0.0, 0.0), ..Pose::identity() };
    /// assert_eq!(pose.inverse_transform_point(&Vec3::new(6.0, 1.0, 0.0)), Vec3::new(1.0, 1.0, 0.0));
    /// ```
    pub fn inverse_transform_point(&self, point: &Vec3) -> Vec3 {
        self.rotation.inverse() * (point - self.position)
    }

    /// The composition of two motions: first `self`, then `outer`.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let step = Pose { position: Vec3::x(), ..Pose::identity() };
    /// assert_eq!(step.then(&step).position, Vec3::new(2.0, 0.0, 0.0));
    /// assert_eq!(step.then(&step.inverse()), Pose::identity());
    /// ```
    pub fn then(&self, outer: &Pose) -> Pose {
        Pose {
            position: outer.transform_point(&self.position),
            rotation: outer.rotation * self.rotation,
        }
    }

    /// The motion that undoes this one.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3};
    /// let pose = Pose { position: Vec3::new(1.0, 2.0, 3.0), ..Pose::identity() };
    /// assert_eq!(pose.inverse().position, Vec3::new(-1.0, -2.0, -3.0));
    /// ```
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.inverse();
        Pose {
            position: -(rotation * self.position),
            rotation,
        }
    }
}

/// The pose of one body in the frame of another, with the rotation as a matrix: computed once per
/// pair, used for many points.
///
/// ```
/// use protomer_kernel::{Pose, RelativePose, Vec3};
/// let first = Pose { position: Vec3::new(5.0, 0.0, 0.0), ..Pose::identity() };
/// let second = Pose { position: Vec3::new(8.0, 1.0, 0.0), ..Pose::identity() };
/// let relative = RelativePose::new(&first, &second, &(second.position - first.position));
/// assert_eq!(relative.transform_point(&Vec3::z()), Vec3::new(3.0, 1.0, 1.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RelativePose {
    /// Rotation matrix R: a point q of the second body is at `R q + translation` in the frame of the
    /// first.
    pub rotation: Matrix3<f64>,
    /// Position of the origin of the second body in the frame of the first, Å.
    pub translation: Vec3,
}

impl From<&Pose> for RelativePose {
    /// The pose of a second body in the frame of a first one, as a motion from its place.
    fn from(second_in_first: &Pose) -> Self {
        Self {
            rotation: second_in_first.rotation.to_rotation_matrix().into_inner(),
            translation: second_in_first.position,
        }
    }
}

impl RelativePose {
    /// The pose of `second` in the frame of `first`. `displacement` (Å) leads from `first` to the
    /// image of `second` that is meant; in open space it is `second.position - first.position`.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose, RelativePose, Vec3};
    /// let space = Boundary::periodic(Vec3::repeat(10.0))?;
    /// let first = Pose { position: Vec3::new(4.0, 0.0, 0.0), ..Pose::identity() };
    /// let second = Pose { position: Vec3::new(-4.0, 0.0, 0.0), ..Pose::identity() };
    /// let displacement = space.displacement(&first.position, &second.position);
    /// let relative = RelativePose::new(&first, &second, &displacement);
    /// assert_eq!(relative.translation, Vec3::new(2.0, 0.0, 0.0));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn new(first: &Pose, second: &Pose, displacement: &Vec3) -> Self {
        let into_first = first.rotation.inverse();
        Self {
            rotation: (into_first * second.rotation)
                .to_rotation_matrix()
                .into_inner(),
            translation: into_first * displacement,
        }
    }

    /// The pose of the first body in the frame of the second.
    ///
    /// ```
    /// use protomer_kernel::{Pose, RelativePose, Vec3};
    /// let pose = Pose::identity();
    /// let relative = RelativePose::new(&pose, &pose, &Vec3::new(3.0, 1.0, 0.0));
    /// assert_eq!(relative.inverse().translation, Vec3::new(-3.0, -1.0, 0.0));
    /// ```
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// A point of the second body in the frame of the first, Å.
    ///
    /// ```
    /// use protomer_kernel::{Pose, RelativePose, Vec3};
    /// let half_turn_about_z = Pose::from_wxyz(Vec3::zeros(), [0.0, 0.0, 0.0, 1.0]);
    /// let displacement = Vec3::new(3.0, 0.0, 0.0);
    /// let relative = RelativePose::new(&Pose::identity(), &half_turn_about_z, &displacement);
    /// let image = relative.transform_point(&Vec3::x());
    /// assert!((image - Vec3::new(2.0, 0.0, 0.0)).norm() < 1e-12);
    /// ```
    pub fn transform_point(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.translation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some_pose(seed: f64) -> Pose {
        Pose::from_wxyz(
            Vec3::new(seed, 2.0 - seed, seed * 3.0),
            [0.3 + seed, 0.4, -0.2 * seed, 0.7],
        )
    }

    #[test]
    fn a_pose_and_its_inverse_cancel() {
        let pose = some_pose(0.7);
        let point = Vec3::new(1.0, -2.0, 0.5);
        assert!((pose.then(&pose.inverse()).transform_point(&point) - point).norm() < 1e-12);
        assert!(
            (pose.inverse_transform_point(&pose.transform_point(&point)) - point).norm() < 1e-12
        );
    }

    #[test]
    fn the_relative_pose_maps_the_second_body_into_the_first() {
        let (first, second) = (some_pose(0.1), some_pose(1.3));
        let relative = RelativePose::new(&first, &second, &(second.position - first.position));
        let point = Vec3::new(0.2, 0.4, -3.0);
        let expected = first.inverse_transform_point(&second.transform_point(&point));
        assert!((relative.transform_point(&point) - expected).norm() < 1e-12);
        assert!((relative.inverse().transform_point(&expected) - point).norm() < 1e-12);
    }
}
