//! A frame tied to the input, so that a mesh turns and moves with the body it is the surface of.
//!
//! A lattice fixed in space cuts a rotated body along other planes, and where the body is thinner
//! than the lattice that changes the topology of the mesh. A lattice fixed to the body does not.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use protomer_kernel::{Rotation, Vec3};

/// Two distances closer than this fraction of each other are a tie, settled by the order of the
/// input.
const TIE: f64 = 1e-9;

/// A rigid frame: lattice coordinates to input coordinates.
///
/// ```
/// use protomer_body::surface::frame::Frame;
/// use protomer_kernel::Vec3;
/// let points = [Vec3::zeros(), Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
/// let frame = Frame::of_points(&points);
/// let image = frame.to_input(&frame.to_lattice(&points[1]));
/// assert!((image - points[1]).norm() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin of the lattice in input coordinates, Å.
    pub origin: Vec3,
    /// Turns lattice directions into input directions.
    pub rotation: Rotation,
}

impl Frame {
    /// The frame of a set of points: its origin is their centroid, its first axis points to the
    /// farthest of them, its second axis to the one farthest from the first axis. Equal distances
    /// are settled by the order of the points, so that the frame is defined without signs to
    /// choose, also for symmetric sets. All of it is then turned by generic angles and moved by a
    /// little, so that no node of the lattice lies on a symmetry plane or between two touching
    /// atoms, where rounding would decide on which side of the surface it is.
    ///
    /// ```
    /// use protomer_body::surface::frame::Frame;
    /// use protomer_kernel::Vec3;
    /// let points = [Vec3::zeros(), Vec3::new(3.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    /// let shift = Vec3::new(5.0, 6.0, 7.0);
    /// let shifted = points.map(|point| point + shift);
    /// let [first, second] = [points, shifted].map(|points| Frame::of_points(&points));
    /// assert!((first.to_lattice(&points[1]) - second.to_lattice(&shifted[1])).norm() < 1e-9);
    /// ```
    pub fn of_points(points: &[Vec3]) -> Self {
        let origin = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
        let first = farthest(points.iter().map(|point| point - origin)).unwrap_or(Vec3::x());
        let perpendiculars = points.iter().map(|point| {
            let arm = point - origin;
            arm - first * arm.dot(&first)
        });
        let second = farthest(perpendiculars).unwrap_or_else(|| any_perpendicular(&first));
        let second = (second - first * second.dot(&first)).normalize();
        let axes = Matrix3::from_columns(&[first, second, first.cross(&second)]);
        let body = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let rotation = body * UnitQuaternion::from_euler_angles(0.347, 0.913, 1.719);
        Self {
            origin: origin + rotation * Vec3::new(0.0137, 0.0291, 0.0419),
            rotation,
        }
    }

    /// A point of the lattice frame in input coordinates, Å.
    #[inline]
    pub fn to_input(&self, point: &Vec3) -> Vec3 {
        self.origin + self.rotation * point
    }

    /// A point in input coordinates in the lattice frame, Å.
    #[inline]
    pub fn to_lattice(&self, point: &Vec3) -> Vec3 {
        self.rotation.inverse() * (point - self.origin)
    }
}

/// Direction of the longest of these arms, the first among equals; `None` if all are shorter than
/// 1e-6 Å.
fn farthest(arms: impl Iterator<Item = Vec3>) -> Option<Vec3> {
    let mut longest = Vec3::zeros();
    for arm in arms {
        if arm.norm() > longest.norm() * (1.0 + TIE) {
            longest = arm;
        }
    }
    longest.try_normalize(1e-6)
}

fn any_perpendicular(direction: &Vec3) -> Vec3 {
    let axis = if direction.x.abs() < 0.8 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    direction.cross(&axis).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_turns_along(points: &[Vec3]) {
        let motion = UnitQuaternion::from_euler_angles(1.1, -0.4, 2.2);
        let moved: Vec<Vec3> = points
            .iter()
            .map(|p| motion * p + Vec3::new(3.0, -40.0, 0.7))
            .collect();
        let (plain, turned) = (Frame::of_points(points), Frame::of_points(&moved));
        for (before, after) in points.iter().zip(&moved) {
            assert!((plain.to_lattice(before) - turned.to_lattice(after)).norm() < 1e-9);
            assert!((plain.to_input(&plain.to_lattice(before)) - before).norm() < 1e-12);
        }
    }

    #[test]
    fn the_frame_turns_with_the_points() {
        assert_turns_along(&[
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::new(-1.0, 0.3, 0.2),
            Vec3::new(0.0, -2.0, 1.0),
        ]);
    }

    #[test]
    fn symmetric_and_flat_sets_have_a_frame_too() {
        let cube: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64))
            .collect();
        assert_turns_along(&cube);
        assert_turns_along(&cube[..4]);
        assert_turns_along(&[Vec3::zeros(); 3]);
        assert_turns_along(&[]);
    }

    #[test]
    fn points_on_a_line_keep_their_distances_from_the_axis() {
        let frame = Frame::of_points(&[Vec3::zeros(), Vec3::x(), Vec3::x() * 2.5]);
        assert!(frame.rotation.coords.iter().all(|x| x.is_finite()));
    }
}
