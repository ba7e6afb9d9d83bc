//! A body prepared for overlap tests.

use super::containment::{Shell, solid_contains};
use super::tree::DiscTree;
use super::triangle_distance::triangle_distance;
use crate::pose::RelativePose;
use crate::{KernelError, Result, TriangleMesh, Vec3};

/// A hard body prepared for overlap tests; immutable, to be shared.
///
/// ```
/// use protomer_kernel::{CollisionShape, TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let shape = CollisionShape::new(&TriangleMesh { vertices, triangles })?;
/// assert_eq!(shape.bounding_radius_angstrom(), 1.0);
/// assert_eq!(shape.least_radius_angstrom(), 0.0);
/// assert!(shape.contains_point(&Vec3::repeat(0.1)));
/// assert!(!shape.contains_point(&Vec3::repeat(0.5)));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct CollisionShape {
    pub(super) mesh: TriangleMesh,
    pub(super) tree: DiscTree,
    shells: Vec<Shell>,
    pub(super) radius: f64,
}

impl CollisionShape {
    /// Prepares a body.
    ///
    /// ```
    /// use protomer_kernel::{CollisionShape, TriangleMesh, Vec3};
    /// let mut cube = TriangleMesh::cuboid(&Vec3::repeat(-1.0), &Vec3::repeat(1.0));
    /// assert!(CollisionShape::new(&cube).is_ok());
    /// cube.triangles.pop();
    /// assert!(CollisionShape::new(&cube).is_err(), "it has a hole");
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] unless the mesh is closed, 2-manifold and outward-oriented, with at
    /// least one triangle.
    pub fn new(mesh: &TriangleMesh) -> Result<Self> {
        mesh.topology()?;
        if mesh.triangles.is_empty() {
            return Err(KernelError::BadMesh("it has no triangles".into()));
        }
        Ok(Self {
            tree: DiscTree::new(mesh),
            shells: Shell::of_mesh(mesh)?,
            radius: mesh.radius_about_origin_angstrom(),
            mesh: mesh.clone(),
        })
    }

    /// Radius of the smallest sphere about the body's origin that holds it, Å.
    ///
    /// ```
    /// use protomer_kernel::{CollisionShape, TriangleMesh, Vec3};
    /// let cube = TriangleMesh::cuboid(&Vec3::repeat(-1.0), &Vec3::repeat(1.0));
    /// let radius = CollisionShape::new(&cube)?.bounding_radius_angstrom();
    /// assert!((radius - 3.0_f64.sqrt()).abs() < 1e-6);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn bounding_radius_angstrom(&self) -> f64 {
        self.radius
    }

    /// Distance of the surface from the body's origin, Å: no point of it is nearer.
    ///
    /// ```
    /// use protomer_kernel::{CollisionShape, TriangleMesh, Vec3};
    /// let cuboid = TriangleMesh::cuboid(&Vec3::repeat(-1.0), &Vec3::new(2.0, 3.0, 4.0));
    /// let least = CollisionShape::new(&cuboid)?.least_radius_angstrom();
    /// assert!((least - 1.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn least_radius_angstrom(&self) -> f64 {
        let origin = [Vec3::zeros(); 3];
        let mut least = f64::INFINITY;
        for triangle in 0..self.mesh.triangles.len() {
            least = least.min(triangle_distance(&self.mesh.corners(triangle), &origin));
        }
        least
    }

    /// The surface.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Memory held, bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val(self.mesh.vertices.as_slice())
            + size_of_val(self.mesh.triangles.as_slice())
            + size_of_val(self.tree.nodes.as_slice())
    }

    /// Whether a point (Å, in the body's frame) lies in the solid or on its surface.
    ///
    /// ```
    /// use protomer_kernel::{CollisionShape, TriangleMesh, Vec3};
    /// let cube = CollisionShape::new(&TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(2.0)))?;
    /// assert!(cube.contains_point(&Vec3::repeat(1.0)));
    /// assert!(!cube.contains_point(&Vec3::repeat(3.0)));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn contains_point(&self, point: &Vec3) -> bool {
        point.norm() <= self.radius && solid_contains(&self.mesh, &self.tree, self.radius, point)
    }

    /// Whether a shell of another body lies inside this one, for surfaces that do not meet.
    pub(super) fn holds_a_shell_of(&self, other: &Self, other_in_self: &RelativePose) -> bool {
        other
            .shells
            .iter()
            .any(|shell| self.holds(shell, other_in_self))
    }

    fn holds(&self, shell: &Shell, pose: &RelativePose) -> bool {
        // A corner outside the sphere is outside the body, and the whole shell with it.
        for corner in &shell.corners {
            if pose.transform_point(corner).norm() > self.radius {
                return false;
            }
        }
        // Surfaces do not meet, so any corner speaks for its shell.
        match shell.corners.first() {
            Some(corner) => self.contains_point(&pose.transform_point(corner)),
            None => false,
        }
    }
}
