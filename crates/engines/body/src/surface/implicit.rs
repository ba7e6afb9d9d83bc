//! The seam between a surface's definition and its triangulation.

use protomer_kernel::Vec3;

/// A ball: centre and radius, Å.
pub type Ball = (Vec3, f64);

/// A solid given by a signed function: negative inside, positive outside, zero on its surface,
/// 1-Lipschitz.
///
/// ```
/// use protomer_body::surface::{Ball, ImplicitSolid, MeshSettings, mesh_solid};
/// use protomer_kernel::Vec3;
///
/// struct UnitBall;
///
/// impl ImplicitSolid for UnitBall {
///     fn signed_distance(&self, point: &Vec3) -> f64 {
///         point.norm() - 1.0
///     }
///     fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
///         (point.normalize(), point.normalize())
///     }
///     fn bounds(&self) -> (Vec3, Vec3) {
///         (Vec3::repeat(-1.0), Vec3::repeat(1.0))
///     }
///     fn cover(&self) -> Vec<Ball> {
///         vec![(Vec3::zeros(), 1.0)]
///     }
/// }
///
/// let settings = MeshSettings { density_per_angstrom2: 40.0, ..MeshSettings::default() };
/// let volume = mesh_solid(&UnitBall, &settings, None)?.volume_angstrom3();
/// assert!((volume - 4.0 / 3.0 * std::f64::consts::PI).abs() < 0.05);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub trait ImplicitSolid: Sync {
    /// Signed distance-like value at a point, Å: exact near the surface.
    fn signed_distance(&self, point: &Vec3) -> f64;
    /// The point of the surface nearest to `point` (exact for points near the surface) and the
    /// outward unit normal there.
    fn project(&self, point: &Vec3) -> (Vec3, Vec3);
    /// A point near the surface for `point`, and the outward unit normal about there: the first step
    /// of a projection, for vertices that will move again.
    fn pull(&self, point: &Vec3) -> (Vec3, Vec3) {
        self.project(point)
    }
    /// An axis-aligned box that holds the surface: lowest and highest corner, Å.
    fn bounds(&self) -> (Vec3, Vec3);
    /// Balls whose union holds the surface (centres and radii, Å): the surface is only looked for
    /// near them.
    fn cover(&self) -> Vec<Ball>;
    /// The signed distance at a point, and a ball that has no point inside the solid, if one is
    /// found on the way: it need not hold the point itself. It saves evaluations.
    fn signed_distance_and_empty_ball(&self, point: &Vec3) -> (f64, Option<Ball>) {
        (self.signed_distance(point), None)
    }
    /// The signed distances at many points, Å, with the signs of [`Self::signed_distance`] and within
    /// some 1e-5 Å of its values: faster than one by one, if some points are near each other.
    fn signed_distances(&self, points: &[Vec3], values: &mut Vec<f64>) {
        values.clear();
        values.extend(points.iter().map(|point| self.signed_distance(point)));
    }
    /// Variant of [`Self::signed_distances`] that also gives an empty ball for each point, as
    /// [`Self::signed_distance_and_empty_ball`] finds one.
    fn signed_distances_and_empty_balls(
        &self,
        points: &[Vec3],
        results: &mut Vec<(f64, Option<Ball>)>,
    ) {
        results.clear();
        let each = points.iter();
        results.extend(each.map(|point| self.signed_distance_and_empty_ball(point)));
    }
    /// Adds balls that lie inside the solid and may reach within `reach_angstrom` of `point`, as
    /// many as are found at once. They save evaluations.
    fn add_inner_balls(&self, _point: &Vec3, _reach_angstrom: f64, _balls: &mut Vec<Ball>) {}
}
