//! The engine's view of one kind of body.

use crate::Result;
use crate::beads::BeadCloud;
use crate::charges::ChargeCloud;
use crate::surface_points::SurfacePoints;
use protomer_body::Body;
use protomer_body::residue_contacts::beads_of;
use protomer_kernel::overlap::CollisionShape;
use protomer_kernel::{TriangleMesh, Vec3};

/// One kind of body as the engine knows it. Immutable; systems share it behind an `Arc`.
///
/// ```
/// use protomer_mc::BodyType;
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let mesh = TriangleMesh::tetrahedron(5.0);
/// let body = BodyType::new("tetrahedron", &mesh, &[(Vec3::zeros(), 3.0)])?;
/// assert_eq!(body.charges.net_charge_e(), 3.0);
/// assert!((body.hard_radius_angstrom() - 75.0_f64.sqrt()).abs() < 1e-9);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
#[derive(Debug)]
pub struct BodyType {
    /// Name, as it appears in assemblies and tables.
    pub name: String,
    /// The hard surface, ready for overlap tests.
    pub shape: CollisionShape,
    /// The vertices of the surface, about which bodies turn.
    pub surface_points: SurfacePoints,
    /// Distance of the surface from the body's origin, Å: no point of it is nearer.
    pub least_radius_angstrom: f64,
    /// The point charges.
    pub charges: ChargeCloud,
    /// The residues, for contact terms; none for a body made of a mesh and charges.
    pub beads: BeadCloud,
    /// Volume inside the surface, Å³: the body's weight in weighted averages.
    pub volume_angstrom3: f64,
    /// The surface that encloses what displaces solvent, where the hard core is smaller.
    pub surface: Option<TriangleMesh>,
}

impl BodyType {
    /// Square of the radius of gyration of a sphere with the volume of this body, Å².
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// use protomer_mc::BodyType;
    /// let mesh = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(10.0));
    /// let cube = BodyType::new("cube", &mesh, &[])?;
    /// // A sphere of 1000 Å³ has the radius 6.204 Å, and a square of gyration of 3/5 r².
    /// assert!((cube.square_of_gyration_angstrom2() - 0.6 * 6.2035_f64.powi(2)).abs() < 1e-3);
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    pub fn square_of_gyration_angstrom2(&self) -> f64 {
        let radius = (0.75 / std::f64::consts::PI * self.volume_angstrom3).cbrt();
        0.6 * radius * radius
    }

    /// A body type from a hard surface and point charges (position in Å, charge in e).
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// use protomer_mc::BodyType;
    /// let mut mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// let cube = BodyType::new("cube", &mesh, &[(Vec3::x(), 1.0), (-Vec3::x(), -1.0)])?;
    /// assert!((cube.volume_angstrom3 - 1000.0).abs() < 1e-9 && cube.least_radius_angstrom == 5.0);
    /// mesh.triangles.pop();
    /// assert!(BodyType::new("open", &mesh, &[]).is_err());
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    ///
    /// # Errors
    /// [`McError::Kernel`](crate::McError::Kernel) if the mesh does not bound a solid.
    pub fn new(
        name: impl Into<String>,
        mesh: &TriangleMesh,
        charges: &[(Vec3, f64)],
    ) -> Result<Self> {
        let shape = CollisionShape::new(mesh)?;
        Ok(Self {
            name: name.into(),
            least_radius_angstrom: shape.least_radius_angstrom(),
            shape,
            surface_points: SurfacePoints::new(mesh),
            charges: ChargeCloud::new(charges),
            beads: BeadCloud::default(),
            volume_angstrom3: mesh.volume_angstrom3(),
            surface: None,
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
        let mut kind = Self::new(body.name.clone(), body.hard_mesh(), &charges)?;
        if body.core.is_some() {
            kind.surface = Some(body.mesh.clone());
            kind.volume_angstrom3 = body.mesh.volume_angstrom3();
        }
        kind.beads = BeadCloud::new(&beads_of(body));
        Ok(kind)
    }

    /// The same body with other charges (position in Å, charge in e).
    ///
    /// ```
    /// use protomer_kernel::{TriangleMesh, Vec3};
    /// use protomer_mc::BodyType;
    /// let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// let neutral = BodyType::new("cube", &mesh, &[])?;
    /// let charged = neutral.with_charges(&[(Vec3::new(3.0, 4.0, 0.0), -2.0)]);
    /// assert_eq!((charged.charges.net_charge_e(), charged.charge_radius_angstrom()), (-2.0, 5.0));
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    pub fn with_charges(self, charges: &[(Vec3, f64)]) -> Self {
        Self {
            charges: ChargeCloud::new(charges),
            ..self
        }
    }

    /// Radius of the sphere around the body's origin that encloses its surface, Å.
    pub fn hard_radius_angstrom(&self) -> f64 {
        self.shape.bounding_radius_angstrom()
    }

    /// Radius of the sphere around the body's origin that encloses its charges, Å; zero
    /// without charges.
    pub fn charge_radius_angstrom(&self) -> f64 {
        self.charges.radius_angstrom()
    }
}
