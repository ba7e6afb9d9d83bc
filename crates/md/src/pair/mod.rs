//! The anisotropic repulsion of two convex bodies (AWCA): a short-ranged repulsion between points of
//! their surfaces (Ramasubramani et al., J. Chem. Phys. 153, 084106 (2020)).
//!
//! | module | one idea |
//! |---|---|
//! | [`repulsion`] | the energy of two points at a distance |
//! | [`contact`] | between the closest points alone |
//! | [`face_sum`] | between all features of the two faces that look at each other, as published |
//! | [`smooth`] | between all features of the bodies, with forces that are its exact gradient |
//! | [`terms`] | forces on points, added up to forces and torques |
//!
//! Lengths: σ is the mean of the diameters of the balls about the centroids that fit in, and that of
//! the repulsion is σ_c = 0.15 σ.
//!
//! The contact point alone has a torque that jumps where two faces pass through parallel. The face
//! sum mends that in two dimensions; in three, parallel edges jump, and in both the energy jumps
//! where another face is chosen. The smooth sum does neither.

pub mod contact;
pub mod face_sum;
pub mod repulsion;
pub mod smooth;
pub mod terms;

use crate::{Error, Result};
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Pose, Vec3};
use repulsion::Repulsion;
use terms::Terms;

/// σ_c over σ.
pub const CONTACT_RATIO: f64 = 0.15;

/// Which points of two bodies repel each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// The closest points.
    Contact,
    /// Corners and edges of the faces that look at each other, as published.
    FaceSum,
    /// Corners and edges of both bodies, smoothly.
    Smooth,
}

/// The energy of two bodies in units of ε, and the forces and torques on them. The force on the
/// second is minus that on the first; torques are about the centroids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairForces {
    /// Energy.
    pub energy: f64,
    /// Distance between the bodies.
    pub distance: f64,
    /// Force on the first body.
    pub force: Vec3,
    /// Torques on the first and the second body.
    pub torques: [Vec3; 2],
}

/// Two bodies in place.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The shapes.
    pub bodies: [&'a Polytope; 2],
    /// Their poses: where the centroids are, and how the bodies are turned.
    pub poses: [&'a Pose; 2],
}

impl Placed<'_> {
    /// The energy, force and torques in this form.
    ///
    /// # Errors
    /// [`Error::Overlap`] if the bodies touch or overlap; [`Error::MixedDimensions`] for a polygon
    /// and a polyhedron.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders, polytope::Polytope};
    /// use protomer_kernel::{Pose, Vec3};
    /// use protomer_md::pair::{Form, Placed};
    /// let cube = Polytope::of(&builders::by_name("cube")?)?;
    /// let there = Pose { position: Vec3::new(1.15, 0.0, 0.0), ..Pose::identity() };
    /// let pair = Placed { bodies: [&cube, &cube], poses: [&Pose::identity(), &there] };
    /// let energy = pair.forces(Form::Contact)?.energy;
    /// assert!((energy - 1.0).abs() < 1e-9); // at the distance σ_c
    /// assert!((pair.forces(Form::FaceSum)?.energy - 20.0).abs() < 1e-6);
    /// assert!((pair.forces(Form::Smooth)?.energy - 8.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forces(&self, form: Form) -> Result<PairForces> {
        let [first, second] = self.bodies;
        if first.dimension != second.dimension {
            return Err(Error::MixedDimensions);
        }
        let corners = [0, 1].map(|n| self.bodies[n].corners_at(self.poses[n]));
        let closest = closest_points(&corners[0], &corners[1]).ok_or(Error::Overlap)?;
        let repulsion = Repulsion {
            sigma: CONTACT_RATIO * (first.inradius() + second.inradius()),
        };
        let mut terms = Terms::about(self.poses.map(|pose| pose.position));
        if closest.distance() < repulsion.range() {
            match form {
                Form::Contact => contact::add(&mut terms, &repulsion, &closest),
                Form::FaceSum => face_sum::add(&mut terms, &repulsion, self, &corners, &closest),
                Form::Smooth => smooth::add(&mut terms, &repulsion, self, &corners),
            }
        }
        Ok(PairForces {
            energy: terms.energy,
            distance: closest.distance(),
            force: terms.force,
            torques: terms.torques,
        })
    }
}
