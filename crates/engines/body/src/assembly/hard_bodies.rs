//! Bodies prepared for overlap tests, and assemblies built with them: closed rings and fluids.

use super::insertion::{self, InsertedBody};
use super::orbits::{Orbit, orbits, stack_rotations};
use super::placement::Placement;
use super::recipe::{ClosedAssembly, Recipe, upright_frame};
use crate::{Body, Result};
use protomer_kernel::overlap::{CollisionShape, overlaps};
use protomer_kernel::{Boundary, RelativePose, Rotation};

/// A body prepared for overlap tests.
#[derive(Debug)]
pub struct HardBody {
    shape: CollisionShape,
    /// Turns the longest axis of the body upright.
    upright: Rotation,
    volume_angstrom3: f64,
    radius_angstrom: f64,
}

impl HardBody {
    /// Prepares a body.
    ///
    /// # Errors
    /// [`BodyError::Kernel`](crate::BodyError::Kernel) for a mesh that bounds no solid.
    pub fn from_body(body: &Body) -> Result<Self> {
        let mut points = Vec::new();
        for site in &body.sites {
            points.push(site.position);
        }
        if points.is_empty() {
            points.clone_from(&body.mesh.vertices);
        }
        Ok(Self {
            shape: CollisionShape::new(body.hard_mesh())?,
            upright: upright_frame(&points),
            volume_angstrom3: body.mass_properties.volume_angstrom3,
            radius_angstrom: body.mesh_radius_angstrom(),
        })
    }
}

/// A closed recipe and its symmetry.
#[derive(Debug, Clone, PartialEq)]
pub struct SymmetricAssembly {
    /// The closed recipe.
    pub closed: ClosedAssembly,
    /// Bodies that its symmetry maps onto each other.
    pub orbits: Vec<Orbit>,
}

/// A list of hard bodies; placements refer to them by their index.
///
/// ```
/// use protomer_body::assembly::{HardBodies, HardBody, Recipe, RecipeSite};
/// # use protomer_body::{Source, SurfaceSettings, build_body_of_points};
/// # use protomer_kernel::PointRecord;
/// # let ball = PointRecord { radius_angstrom: 5.0, ..PointRecord::default() };
/// # let source = Source { file: "ball.xyzr", sha256: "" };
/// # let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
/// let bodies = HardBodies::new(vec![HardBody::from_body(&body)?]);
/// let ring = bodies.close(&Recipe::ring(4, &[RecipeSite::upright(0)]), 1.0)?;
/// assert!(!bodies.any_overlap(&ring.placements));
/// // Four balls of radius 5 Å, 1 Å apart: their centres lie on a square of edge 11 Å.
/// assert!((ring.radius_angstrom - 11.0 / 2.0_f64.sqrt()).abs() < 0.05);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Default)]
pub struct HardBodies {
    bodies: Vec<HardBody>,
}

impl HardBodies {
    /// A list of bodies.
    pub fn new(bodies: Vec<HardBody>) -> Self {
        Self { bodies }
    }

    /// The pairs of placed bodies that overlap, in open space.
    pub fn overlapping_pairs(&self, placements: &[Placement]) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for (second, placement) in placements.iter().enumerate() {
            for (first, other) in placements[..second].iter().enumerate() {
                if self.overlap(other, placement, &Boundary::Open) {
                    pairs.push((first, second));
                }
            }
        }
        pairs
    }

    /// Whether any two of the placed bodies overlap, in open space.
    pub fn any_overlap(&self, placements: &[Placement]) -> bool {
        for (second, placement) in placements.iter().enumerate() {
            for other in &placements[..second] {
                if self.overlap(other, placement, &Boundary::Open) {
                    return true;
                }
            }
        }
        false
    }

    /// Whether a placed body overlaps the nearest image of any of the others.
    pub fn overlaps_any(
        &self,
        placement: &Placement,
        others: &[Placement],
        boundary: &Boundary,
    ) -> bool {
        others
            .iter()
            .any(|other| self.overlap(placement, other, boundary))
    }

    /// Whether two placed bodies overlap, in open space.
    ///
    /// ```
    /// use protomer_body::assembly::{HardBodies, HardBody};
    /// # use protomer_body::{Source, SurfaceSettings, build_body_of_points};
    /// # use protomer_kernel::{PointRecord, Pose, Vec3};
    /// # let ball = PointRecord { radius_angstrom: 5.0, ..PointRecord::default() };
    /// # let source = Source { file: "ball.xyzr", sha256: "" };
    /// # let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
    /// let balls = HardBodies::new(vec![HardBody::from_body(&body)?]);
    /// let ball_at = |x| (0, Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() });
    /// assert!(balls.overlap_in_open_space(&ball_at(0.0), &ball_at(9.0)));
    /// assert!(!balls.overlap_in_open_space(&ball_at(0.0), &ball_at(11.0)));
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn overlap_in_open_space(&self, first: &Placement, second: &Placement) -> bool {
        self.overlap(first, second, &Boundary::Open)
    }

    fn overlap(&self, first: &Placement, second: &Placement, boundary: &Boundary) -> bool {
        let ((kind_a, pose_a), (kind_b, pose_b)) = (first, second);
        let displacement = boundary.displacement(&pose_a.position, &pose_b.position);
        overlaps(
            &self.bodies[*kind_a].shape,
            &self.bodies[*kind_b].shape,
            &RelativePose::new(pose_a, pose_b, &displacement),
        )
    }

    /// Closes a recipe, each body upright, to contact and then opens it by a gap
    /// ([`Recipe::close_with_gap`]).
    ///
    /// # Errors
    /// [`BodyError::Invalid`](crate::BodyError::Invalid) if the recipe does not fit the bodies.
    pub fn close(&self, recipe: &Recipe, gap_angstrom: f64) -> Result<ClosedAssembly> {
        const TOLERANCE_ANGSTROM: f64 = 1e-3;
        let frames: Vec<Rotation> = self.bodies.iter().map(|body| body.upright).collect();
        recipe.close_with_gap(&frames, gap_angstrom, TOLERANCE_ANGSTROM, |placements| {
            self.any_overlap(placements)
        })
    }

    /// Closes a recipe as [`close`](Self::close), to another tolerance and with fewer overlap tests: rings by all
    /// pairs of a ring, and a stack by one body of each orbit with all others.
    ///
    /// # Errors
    /// As [`close`](Self::close).
    pub fn close_symmetric(
        &self,
        recipe: &Recipe,
        gap_angstrom: f64,
        tolerance_angstrom: f64,
    ) -> Result<SymmetricAssembly> {
        let frames: Vec<Rotation> = self.bodies.iter().map(|body| body.upright).collect();
        // Symmetry does not depend on the size, as long as no two bodies are in one place.
        let orbits = orbits(
            &recipe.placements(&frames, 3.0, 2.0, 0.0)?,
            &stack_rotations(recipe),
        );
        let size: usize = recipe.rings.iter().map(Vec::len).sum();
        let closed =
            recipe.close_with_gap(&frames, gap_angstrom, tolerance_angstrom, |placements| {
                match placements.len() == size {
                    true => self.any_overlap_of(&orbits, placements),
                    false => self.any_overlap(placements),
                }
            })?;
        Ok(SymmetricAssembly { closed, orbits })
    }

    /// Whether one body of an orbit overlaps any other body.
    fn any_overlap_of(&self, orbits: &[Orbit], placements: &[Placement]) -> bool {
        orbits.iter().any(|orbit| {
            let body = &placements[orbit.representative];
            placements.iter().enumerate().any(|(other, placement)| {
                other != orbit.representative && self.overlap(body, placement, &Boundary::Open)
            })
        })
    }

    /// A fluid: bodies at random positions and in random orientations in a periodic box, without
    /// overlaps ([`insertion`]). `counts` has the number of bodies of each kind, in the order of
    /// the list; placements are sorted by kind. The same seed gives the same fluid.
    ///
    /// # Errors
    /// [`BodyError::Invalid`](crate::BodyError::Invalid) if the counts do not fit the list or the
    /// box is too small for the bodies, [`BodyError::NoRoom`](crate::BodyError::NoRoom) if it is
    /// too full.
    ///
    /// ```
    /// use protomer_body::assembly::{HardBodies, HardBody};
    /// # use protomer_body::{Source, SurfaceSettings, build_body_of_points};
    /// # use protomer_kernel::PointRecord;
    /// # let ball = PointRecord { radius_angstrom: 5.0, ..PointRecord::default() };
    /// # let source = Source { file: "ball.xyzr", sha256: "" };
    /// # let body = build_body_of_points("ball", source, &[ball], &SurfaceSettings::default())?.body;
    /// let bodies = HardBodies::new(vec![HardBody::from_body(&body)?]);
    /// let fluid = bodies.insert_at_random(&[10], [60.0; 3], 7)?;
    /// assert_eq!(fluid.len(), 10);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn insert_at_random(
        &self,
        counts: &[usize],
        box_angstrom: [f64; 3],
        seed: u64,
    ) -> Result<Vec<Placement>> {
        let mut kinds = Vec::new();
        for body in &self.bodies {
            kinds.push(InsertedBody {
                volume_angstrom3: body.volume_angstrom3,
                radius_angstrom: body.radius_angstrom,
            });
        }
        insertion::insert_at_random(
            &kinds,
            counts,
            box_angstrom,
            seed,
            |placement, others, boundary| self.overlaps_any(placement, others, boundary),
        )
    }
}
