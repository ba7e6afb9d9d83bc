//! A solid turned and moved. A question about a point is put to the solid where it was made, about the
//! point moved back.

use super::implicit::{Ball, ImplicitSolid};
use nalgebra::Matrix3;
use protomer_kernel::{Pose, Vec3};

/// A solid at a pose.
///
/// ```
/// use protomer_body::surface::{ExactSurface, ImplicitSolid, Placed};
/// use protomer_kernel::{Pose, Rotation, Vec3};
/// let exact = ExactSurface::new(&[Vec3::x()], &[1.7], 1.4)?;
/// let rotation = Rotation::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
/// let position = Vec3::new(0.0, 0.0, 5.0);
/// let placed = Placed::new(exact.solid(), Pose { position, rotation });
/// // The atom is at (0, 1, 5) now.
/// assert!((placed.signed_distance(&Vec3::new(0.0, 1.0, 7.0)) - 0.3).abs() < 1e-6);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub struct Placed<'a> {
    solid: &'a dyn ImplicitSolid,
    pose: Pose,
    /// The inverse of the rotation.
    back: Matrix3<f64>,
    bounds: (Vec3, Vec3),
}

impl<'a> Placed<'a> {
    /// A solid at a pose.
    pub fn new(solid: &'a dyn ImplicitSolid, pose: Pose) -> Self {
        let bounds = box_around(solid, &pose);
        Self {
            solid,
            pose,
            back: pose.rotation.inverse().to_rotation_matrix().into_inner(),
            bounds,
        }
    }

    /// A point moved back to where the solid was made.
    fn before(&self, point: &Vec3) -> Vec3 {
        self.back * (point - self.pose.position)
    }

    fn all_before(&self, points: &[Vec3]) -> Vec<Vec3> {
        points.iter().map(|point| self.before(point)).collect()
    }

    fn ball_there(&self, (centre, radius): Ball) -> Ball {
        (self.pose.transform_point(&centre), radius)
    }

    fn on_surface_there(&self, (place, normal): (Vec3, Vec3)) -> (Vec3, Vec3) {
        (
            self.pose.transform_point(&place),
            self.pose.rotation * normal,
        )
    }
}

/// A box that holds the solid: on each side the tighter one of the box around the turned box, and of that
/// around the turned balls of the cover.
fn box_around(solid: &dyn ImplicitSolid, pose: &Pose) -> (Vec3, Vec3) {
    let (low, high) = solid.bounds();
    let (middle, half) = (
        pose.transform_point(&(0.5 * (low + high))),
        0.5 * (high - low),
    );
    let half = pose.rotation.to_rotation_matrix().matrix().abs() * half;
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(f64::NEG_INFINITY);
    for (centre, radius) in solid.cover() {
        let centre = pose.transform_point(&centre);
        low = low.inf(&centre.add_scalar(-radius));
        high = high.sup(&centre.add_scalar(radius));
    }
    (low.sup(&(middle - half)), high.inf(&(middle + half)))
}

impl ImplicitSolid for Placed<'_> {
    fn signed_distance(&self, point: &Vec3) -> f64 {
        self.solid.signed_distance(&self.before(point))
    }

    fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
        self.on_surface_there(self.solid.project(&self.before(point)))
    }

    fn pull(&self, point: &Vec3) -> (Vec3, Vec3) {
        self.on_surface_there(self.solid.pull(&self.before(point)))
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    fn cover(&self) -> Vec<Ball> {
        let balls = self.solid.cover().into_iter();
        balls.map(|ball| self.ball_there(ball)).collect()
    }

    fn signed_distance_and_empty_ball(&self, point: &Vec3) -> (f64, Option<Ball>) {
        let result = self
            .solid
            .signed_distance_and_empty_ball(&self.before(point));
        (result.0, result.1.map(|ball| self.ball_there(ball)))
    }

    fn signed_distances(&self, points: &[Vec3], values: &mut Vec<f64>) {
        self.solid
            .signed_distances(&self.all_before(points), values);
    }

    fn signed_distances_and_empty_balls(
        &self,
        points: &[Vec3],
        results: &mut Vec<(f64, Option<Ball>)>,
    ) {
        self.solid
            .signed_distances_and_empty_balls(&self.all_before(points), results);
        for (_, ball) in results {
            *ball = ball.map(|ball| self.ball_there(ball));
        }
    }

    fn add_inner_balls(&self, point: &Vec3, reach_angstrom: f64, balls: &mut Vec<Ball>) {
        let first = balls.len();
        self.solid
            .add_inner_balls(&self.before(point), reach_angstrom, balls);
        for ball in &mut balls[first..] {
            *ball = self.ball_there(*ball);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::ExactSurface;
    use protomer_kernel::random::CounterRng;

    /// The twin: the surface of atoms that were moved themselves.
    #[test]
    fn a_placed_solid_is_the_solid_of_placed_atoms() {
        let mut rng = CounterRng::new(31, 0, 0);
        let centres: Vec<Vec3> = (0..80).map(|_| rng.vector_in_ball(7.0)).collect();
        let radii: Vec<f64> = (0..80).map(|_| rng.uniform_in(1.2, 1.9)).collect();
        let pose = Pose {
            position: Vec3::new(3.0, -20.0, 11.0),
            rotation: rng.rotation(),
        };
        let moved: Vec<Vec3> = centres.iter().map(|c| pose.transform_point(c)).collect();
        let exact = ExactSurface::new(&centres, &radii, 1.4).unwrap();
        let twin = ExactSurface::new(&moved, &radii, 1.4).unwrap();
        let (placed, twin) = (Placed::new(exact.solid(), pose), twin.solid());
        let (low, high) = placed.bounds();
        let mut points = Vec::new();
        for _ in 0..3000 {
            points.push(pose.position + rng.vector_in_ball(11.0));
        }
        let (mut batch, mut balls) = (Vec::new(), Vec::new());
        placed.signed_distances(&points, &mut batch);
        placed.signed_distances_and_empty_balls(&points, &mut balls);
        for (point, (value, (again, ball))) in points.iter().zip(batch.iter().zip(&balls)) {
            let expected = twin.signed_distance(point);
            assert!((placed.signed_distance(point) - expected).abs() < 1e-9);
            assert!((value - expected).abs() < 1e-4 && (again - expected).abs() < 1e-4);
            if let Some((centre, radius)) = ball {
                assert!(twin.signed_distance(centre) > radius - 1e-6);
            }
            if expected < 0.0 {
                let is_in_box = (0..3).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]));
                assert!(is_in_box, "{point}");
            }
            if expected.abs() < 0.5 {
                // Two places may be equally near.
                let ((found, normal), (there, _)) = (placed.project(point), twin.project(point));
                let farther = (found - point).norm() - (there - point).norm();
                assert!(farther.abs() < 1e-6, "{point} {farther}");
                assert!(twin.signed_distance(&found).abs() < 1e-6 && normal.norm() < 1.0 + 1e-9);
                assert!(twin.signed_distance(&(found + 1e-3 * normal)) > 0.0);
            }
        }
        assert_eq!(placed.cover().len(), twin.cover().len());
    }
}
