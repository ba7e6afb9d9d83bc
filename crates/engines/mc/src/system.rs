//! The bodies and their poses.

use crate::{BodyType, McError, Result};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{Boundary, Pose, Vec3};
use std::sync::Arc;

/// Rigid bodies in a space: the types are shared and immutable, only the poses change.
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, System};
/// use std::sync::Arc;
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # let mesh = TriangleMesh::tetrahedron(5.0);
/// let body = Arc::new(BodyType::new("tetrahedron", &mesh, &[])?);
/// let far = Pose { position: Vec3::new(30.0, 0.0, 0.0), ..Pose::identity() };
/// let system = System::new(vec![body], &[(0, Pose::identity()), (0, far)], Boundary::Open)?;
/// assert_eq!(system.len(), 2);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
#[derive(Debug, Clone)]
pub struct System {
    types: Vec<Arc<BodyType>>,
    type_of: Vec<usize>,
    poses: Vec<Pose>,
    boundary: Boundary,
}

impl System {
    /// A system of bodies, each given by the index of its type and its pose. Positions are wrapped
    /// into a periodic box.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose, TriangleMesh, Vec3};
    /// use protomer_mc::{BodyType, System};
    /// use std::sync::Arc;
    /// let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// let types = vec![Arc::new(BodyType::new("cube", &mesh, &[])?)];
    /// let outside = Pose { position: Vec3::new(60.0, 0.0, 0.0), ..Pose::identity() };
    /// let space = Boundary::periodic(Vec3::repeat(100.0))?;
    /// let system = System::new(types.clone(), &[(0, outside)], space)?;
    /// assert_eq!(system.pose(0).position.x, -40.0);
    /// assert!(System::new(types, &[(1, outside)], space).is_err(), "there is one type");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`McError::BadSystem`] for no bodies, a type index out of range, a pose that is not finite,
    /// or an origin outside a wall.
    pub fn new(
        types: Vec<Arc<BodyType>>,
        bodies: &[(usize, Pose)],
        boundary: Boundary,
    ) -> Result<Self> {
        if bodies.is_empty() {
            return Err(McError::BadSystem(
                "the system has no bodies; give at least one placement".into(),
            ));
        }
        for (index, (kind, pose)) in bodies.iter().enumerate() {
            let finite = pose
                .position
                .iter()
                .chain(pose.rotation.coords.iter())
                .all(|number| number.is_finite());
            let problem = if *kind >= types.len() {
                format!("has type {kind}, but there are {} types", types.len())
            } else if !finite {
                "has a pose that is not finite".into()
            } else if !boundary.contains(&pose.position) {
                "has its origin outside the wall".into()
            } else {
                continue;
            };
            return Err(McError::BadSystem(format!("body {index} {problem}")));
        }
        let mut system = Self {
            types,
            type_of: bodies.iter().map(|body| body.0).collect(),
            poses: Vec::new(),
            boundary,
        };
        system.poses = bodies.iter().map(|body| system.tidy(body.1)).collect();
        Ok(system)
    }

    /// The pose as the system stores it: wrapped into the box, its quaternion normalised.
    pub(crate) fn tidy(&self, pose: Pose) -> Pose {
        Pose {
            position: self.boundary.wrap(&pose.position),
            // Quaternions drift by rounding over millions of products.
            rotation: protomer_kernel::Rotation::new_normalize(pose.rotation.into_inner()),
        }
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Always false: a system has at least one body.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// The body types.
    pub fn types(&self) -> &[Arc<BodyType>] {
        &self.types
    }

    /// Index of the type of a body.
    pub fn type_index(&self, body: usize) -> usize {
        self.type_of[body]
    }

    /// The type of a body.
    pub fn body_type(&self, body: usize) -> &BodyType {
        &self.types[self.type_of[body]]
    }

    /// The poses of all bodies, positions within the box.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// The pose of a body.
    pub fn pose(&self, body: usize) -> &Pose {
        &self.poses[body]
    }

    pub(crate) fn set_pose(&mut self, body: usize, pose: Pose) {
        self.poses[body] = pose;
    }

    /// The same bodies at other poses.
    pub(crate) fn with_poses(&self, poses: &[Pose]) -> Self {
        Self {
            poses: poses.to_vec(),
            ..self.clone()
        }
    }

    /// The same bodies with some at other poses.
    pub(crate) fn with_moved(&self, moved: &[(usize, Pose)]) -> Self {
        let mut system = self.clone();
        for (body, pose) in moved {
            system.set_pose(*body, *pose);
        }
        system
    }

    /// The space.
    pub fn boundary(&self) -> &Boundary {
        &self.boundary
    }

    /// A pair of bodies in its present state. The smaller index is always the first, so a pair's
    /// numbers have the same bits whichever of the two moved last.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose};
    /// use protomer_mc::{BodyType, System};
    /// # use protomer_kernel::{TriangleMesh, Vec3};
    /// # use std::sync::Arc;
    /// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    /// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
    /// let place = |x| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
    /// let space = Boundary::periodic(Vec3::repeat(100.0))?;
    /// let system = System::new(vec![cube], &[(0, place(-45.0)), (0, place(45.0))], space)?;
    /// let pair = system.pair(1, 0);
    /// assert_eq!((pair.first, pair.displacement.x), (0, -10.0), "across the border");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn pair(&self, body: usize, partner: usize) -> Pair<'_> {
        Trial {
            system: self,
            body,
            pose: self.poses[body],
        }
        .pair(partner)
    }

    /// The indices of the types that bodies of the system have; a type without a body has no part
    /// in it.
    pub fn placed_types(&self) -> Vec<usize> {
        let is_placed = |index: &usize| self.type_of.contains(index);
        (0..self.types.len()).filter(is_placed).collect()
    }

    /// The largest distance of two origins at which the surfaces can touch, Å.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Pose, TriangleMesh, Vec3};
    /// use protomer_mc::{BodyType, System};
    /// use std::sync::Arc;
    /// let mesh = TriangleMesh::cuboid(&Vec3::repeat(-3.0), &Vec3::repeat(3.0));
    /// let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
    /// let system = System::new(vec![cube], &[(0, Pose::identity())], Boundary::Open)?;
    /// assert!((system.hard_range_angstrom() - 6.0 * 3.0_f64.sqrt()).abs() < 1e-6, "corner to corner");
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    pub fn hard_range_angstrom(&self) -> f64 {
        let mut largest = 0.0_f64;
        for kind in self.placed_types() {
            largest = largest.max(self.types[kind].hard_radius_angstrom());
        }
        2.0 * largest
    }
}

/// A system with one body moved to a trial pose.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// The system before the move.
    pub system: &'a System,
    /// The body that moves.
    pub body: usize,
    /// Trial pose of the body.
    pub pose: Pose,
}

impl<'a> Trial<'a> {
    /// The moved body and an unmoved partner, the smaller index first.
    pub fn pair(&self, partner: usize) -> Pair<'a> {
        let system = self.system;
        // Smaller index first, whichever moves: sums then have one order and one set of bits.
        let moved_first = self.body < partner;
        let (first, second) = if moved_first {
            (self.body, partner)
        } else {
            (partner, self.body)
        };
        let partner_pose = system.poses[partner];
        let (first_pose, second_pose) = if moved_first {
            (self.pose, partner_pose)
        } else {
            (partner_pose, self.pose)
        };
        let displacement = system
            .boundary
            .displacement(&first_pose.position, &second_pose.position);
        Pair {
            system,
            first,
            second,
            first_pose,
            second_pose,
            displacement,
        }
    }
}

/// Two bodies and the way from the first to the nearest image of the second.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    system: &'a System,
    /// Index of the first body.
    pub first: usize,
    /// Index of the second body, the larger.
    pub second: usize,
    /// Pose of the first body.
    pub first_pose: Pose,
    /// Pose of the second body.
    pub second_pose: Pose,
    /// Vector from the origin of the first body to that of the nearest image of the second, Å.
    pub displacement: Vec3,
}

impl<'a> Pair<'a> {
    /// The pose of the partner's nearest image in the frame of this body of the pair.
    pub(crate) fn partner_of(&self, body: usize) -> RelativePose {
        match body == self.first {
            true => self.relative(),
            false => self.relative().inverse(),
        }
    }

    /// The types of the two bodies.
    pub fn types(&self) -> (&'a BodyType, &'a BodyType) {
        (
            self.system.body_type(self.first),
            self.system.body_type(self.second),
        )
    }

    /// The indices of the types of the two bodies.
    pub fn type_indices(&self) -> (usize, usize) {
        (
            self.system.type_index(self.first),
            self.system.type_index(self.second),
        )
    }

    /// The pose of the second body's nearest image in the frame of the first.
    pub fn relative(&self) -> RelativePose {
        self.relative_image(&self.displacement)
    }

    /// The pose of the image of the second body at this displacement (Å) in the frame of the first.
    pub(crate) fn relative_image(&self, displacement: &Vec3) -> RelativePose {
        RelativePose::new(&self.first_pose, &self.second_pose, displacement)
    }

    pub(crate) fn boundary(&self) -> &'a Boundary {
        &self.system.boundary
    }
}
