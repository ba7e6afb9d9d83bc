//! The seam between a surface's definition and its triangulation.

use protomer_kernel::Vec3;

/// A solid given by a signed function: negative inside, positive outside, zero on its surface,
/// 1-Lipschitz.
pub trait ImplicitSolid: Sync {
    /// Signed distance-like value at a point, Å: exact near the surface.
    fn signed_distance(&self, point: &Vec3) -> f64;
    /// The point of the surface nearest to `point` (exact for points near the surface) and the
    /// outward unit normal there.
    fn project(&self, point: &Vec3) -> (Vec3, Vec3);
    /// An axis-aligned box that holds the surface: lowest and highest corner, Å.
    fn bounds(&self) -> (Vec3, Vec3);
    /// Balls whose union holds the surface (centres and radii, Å): the surface is only looked for
    /// near them.
    fn cover(&self) -> Vec<(Vec3, f64)>;
}
