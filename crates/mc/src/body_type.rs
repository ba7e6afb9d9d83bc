//! One kind of body, as the engine sees it.

use crate::Result;
use crate::charges::ChargeCloud;
use crate::contact::SurfacePoints;
use protomer_body::Body;
use protomer_kernel::overlap::CollisionShape;
use protomer_kernel::{TriangleMesh, Vec3};

/// What the engine knows about one kind of body. Immutable; systems share it behind an `Arc`.
#[derive(Debug)]
pub struct BodyType {
    /// Name, as it appears in assemblies and tables.
    pub name: String,
    /// The hard surface, ready for overlap tests.
    pub shape: CollisionShape,
    /// The surface's vertices, for contacts.
    pub surface_points: SurfacePoints,
    /// The point charges.
    pub charges: ChargeCloud,
    /// Volume inside the surface, Å³: the body's weight in weighted averages.
    pub volume_angstrom3: f64,
}

impl BodyType {
    /// A body type from a hard surface and point charges (position in Å, charge in e).
    ///
    /// # Errors
    /// [`McError::Kernel`](crate::McError::Kernel) if the mesh does not bound a solid.
    pub fn new(
        name: impl Into<String>,
        mesh: &TriangleMesh,
        charges: &[(Vec3, f64)],
    ) -> Result<Self> {
        Ok(Self {
            name: name.into(),
            shape: CollisionShape::new(mesh)?,
            surface_points: SurfacePoints::new(mesh),
            charges: ChargeCloud::new(charges),
            volume_angstrom3: mesh.volume_angstrom3(),
        })
    }

    /// The body type of an ingested body.
    ///
    /// # Errors
    /// As [`BodyType::new`].
    pub fn from_body(body: &Body) -> Result<Self> {
        let charges: Vec<(Vec3, f64)> = body
            .sites
            .iter()
            .map(|site| (site.position, site.charge_e))
            .collect();
        Self::new(body.name.clone(), &body.mesh, &charges)
    }

    /// Radius of the sphere about the body's origin that holds its surface, Å.
    pub fn hard_radius_angstrom(&self) -> f64 {
        self.shape.bounding_radius_angstrom()
    }

    /// Radius of the sphere about the body's origin that holds its charges, Å; zero without
    /// charges.
    pub fn charge_radius_angstrom(&self) -> f64 {
        self.charges.radius_angstrom()
    }
}
