//! What is left of a separation after the bodies have moved.

use crate::{Pose, Vec3};
use nalgebra::Vector4;

/// A lower bound on the separation of two bodies together with the poses at which it was found.
///
/// A rotation by θ about its origin moves no point of a body of radius R farther than 2 R sin(θ/2),
/// and unit quaternions that differ by that rotation are 2 sin(θ/4) apart, so a body moves by at
/// most 2 R |q - q'|. The *net* motion counts, not the path: the bound outlives a random walk much
/// longer than a sum of steps would let it.
///
/// ```
/// use protomer_kernel::{Pose, Vec3, overlap::CarriedBound};
/// let (first, mut second) = (Pose::identity(), Pose::identity());
/// second.position = Vec3::new(30.0, 0.0, 0.0);
/// let carried = CarriedBound::new(2.0, &first, &second, &second.position);
/// second.position.x = 29.5;
/// let remaining = carried.remaining_angstrom(&first, &second, &second.position, [10.0, 10.0]);
/// assert!((remaining - 1.5).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarriedBound {
    bound: f64,
    displacement: Vec3,
    orientations: [Vector4<f64>; 2],
}

impl CarriedBound {
    /// A bound in Å found with the bodies at these poses; `displacement` (Å) leads from the first to
    /// the image of the second that is meant.
    pub fn new(bound_angstrom: f64, first: &Pose, second: &Pose, displacement: &Vec3) -> Self {
        Self {
            bound: bound_angstrom,
            displacement: *displacement,
            orientations: [first.rotation.coords, second.rotation.coords],
        }
    }

    /// The bound of a pair that has not been tested: nothing remains of it.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3, overlap::CarriedBound};
    /// let (pose, displacement) = (Pose::identity(), Vec3::zeros());
    /// let carried = CarriedBound::unknown();
    /// let remaining = carried.remaining_angstrom(&pose, &pose, &displacement, [1.0, 1.0]);
    /// assert_eq!(remaining, f64::NEG_INFINITY);
    /// ```
    pub fn unknown() -> Self {
        Self {
            bound: f64::NEG_INFINITY,
            displacement: Vec3::zeros(),
            orientations: [Vector4::zeros(); 2],
        }
    }

    /// Remainder of the bound with the bodies at other poses, Å, given their radii about their
    /// origins, Å. While it is positive the bodies cannot overlap.
    ///
    /// ```
    /// use protomer_kernel::{Pose, Vec3, overlap::CarriedBound};
    /// let (first, displacement) = (Pose::identity(), Vec3::new(30.0, 0.0, 0.0));
    /// let carried = CarriedBound::new(2.0, &first, &first, &displacement);
    /// let rotation = Pose::from_wxyz(Vec3::zeros(), [1.0, 0.0, 0.0, 0.02]);
    /// let [small, large] = [5.0, 10.0]
    ///     .map(|radius| carried.remaining_angstrom(&first, &rotation, &displacement, [0.0, radius]));
    /// assert!(2.0 > small && small > large, "a turn moves the surface of a large body farther");
    /// ```
    pub fn remaining_angstrom(
        &self,
        first: &Pose,
        second: &Pose,
        displacement: &Vec3,
        [first_radius, second_radius]: [f64; 2],
    ) -> f64 {
        let [first_before, second_before] = &self.orientations;
        // Each term is the most that a point can have moved,
        // so the sum of the three bounds the closing.
        self.bound
            - (displacement - self.displacement).norm()
            - 2.0 * first_radius * quaternion_distance(first_before, &first.rotation.coords)
            - 2.0 * second_radius * quaternion_distance(second_before, &second.rotation.coords)
    }
}

/// Distance of two unit quaternions, q and -q being the same rotation.
fn quaternion_distance(p: &Vector4<f64>, q: &Vector4<f64>) -> f64 {
    // The nearer of q and -q: otherwise a sign that flips would look like a turn by 2π.
    (p - q).norm_squared().min((p + q).norm_squared()).sqrt()
}
