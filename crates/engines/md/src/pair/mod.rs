//! The anisotropic potential of two convex bodies (ALJ, and its repulsive form AWCA): a short-ranged
//! energy between points of their surfaces (Ramasubramani et al., J. Chem. Phys. 153, 084106 (2020)).
//!
//! | module | one idea |
//! |---|---|
//! | [`radial`] | the energy of two points at a distance |
//! | [`contact`] | between the closest points alone |
//! | [`face_sum`] | between all features of the two faces that look at each other, as published |
//! | [`smooth`] | between all features of the bodies, with forces that are its exact gradient |
//! | [`central`] | between the centroids |
//! | [`features`] | closest points, plainly |
//! | [`terms`] | forces on points, added up to forces and torques |
//!
//! Lengths: σ is the mean of the diameters of the balls about the centroids that fit in, and that of
//! the energy of points is σ_c = 0.15 σ. Bodies may be rounded: with the Minkowski sum of a core and a
//! ball, points are nearer by the radius.
//!
//! The contact point alone has a torque that jumps where two faces pass through parallel. The face
//! sum mends that in two dimensions; in three, parallel edges jump, and in both the energy jumps
//! where another face is chosen. The smooth sum does neither.

pub mod central;
pub mod contact;
pub mod face_sum;
pub mod features;
pub mod radial;
pub mod smooth;
mod step;
pub mod terms;

use crate::{Error, Result};
use central::Central;
use features::Features;
use protomer_kernel::choices;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Pose, Vec3};
use radial::{Attraction, Radial};
use terms::Terms;

/// Ratio of the length σ_c of contacts to σ.
pub const CONTACT_RATIO: f64 = 0.15;

choices! {
    /// Points of two bodies that repel each other.
    pub enum Form {
        /// The closest points alone; torques jump where faces are parallel.
        Contact = "contact",
        /// Corners and edges of the two faces that look at each other, as published.
        FaceSum = "face-sum",
        /// Corners and edges of both bodies, with forces that are the exact gradient.
        Smooth = "smooth",
    }
}

/// Interaction of two bodies.
///
/// ```
/// use protomer_md::pair::{Form, Interaction, radial::Attraction};
/// let repulsion = Interaction::from(Form::Smooth);
/// let attraction = Attraction { strength: 0.5, cut_off: 2.5 };
/// let sticky = Interaction { attraction, ..repulsion };
/// assert_eq!((sticky.form, repulsion.attraction), (Form::Smooth, Attraction::NONE));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interaction {
    /// Points that repel each other.
    pub form: Form,
    /// Attraction between points, and between centroids.
    pub attraction: Attraction,
    /// The energy between the centroids.
    pub central: Central,
}

/// The repulsion alone, without a term between the centroids.
impl From<Form> for Interaction {
    fn from(form: Form) -> Self {
        Self {
            form,
            attraction: Attraction::NONE,
            central: Central::None,
        }
    }
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
    /// The shapes, or their cores.
    pub bodies: [&'a Polytope; 2],
    /// The radii by which they are rounded; zero for sharp bodies.
    pub radii: [f64; 2],
    /// Poses of the bodies: positions of the centroids, and orientations.
    pub poses: [&'a Pose; 2],
}

impl<'a> Placed<'a> {
    /// Two bodies that are not rounded.
    pub fn sharp(bodies: [&'a Polytope; 2], poses: [&'a Pose; 2]) -> Self {
        Self {
            bodies,
            radii: [0.0; 2],
            poses,
        }
    }

    /// The energy, force and torques of this interaction.
    ///
    /// # Errors
    /// [`Error::Overlap`] if the bodies touch or overlap; [`Error::MixedDimensions`] for a polygon
    /// and a polyhedron; [`Error::OutOfRange`] for an attraction that is none.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders, polytope::Polytope};
    /// use protomer_kernel::{Pose, Vec3};
    /// use protomer_md::pair::{Form, Placed};
    /// let cube = Polytope::from_shape(&builders::by_name("cube")?)?;
    /// let second = Pose { position: Vec3::new(1.15, 0.0, 0.0), ..Pose::identity() };
    /// let first = Pose::identity();
    /// let pair = Placed::sharp([&cube, &cube], [&first, &second]);
    /// let energy = pair.forces(Form::Contact)?.energy;
    /// assert!((energy - 1.0).abs() < 1e-9); // at the distance σ_c
    /// assert!((pair.forces(Form::FaceSum)?.energy - 20.0).abs() < 1e-6);
    /// assert!((pair.forces(Form::Smooth)?.energy - 8.0).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn forces(&self, interaction: impl Into<Interaction>) -> Result<PairForces> {
        let Interaction {
            form,
            attraction,
            central,
        } = interaction.into();
        attraction.check()?;
        let [first, second] = self.bodies;
        if first.dimension != second.dimension {
            return Err(Error::MixedDimensions);
        }
        let features = [0, 1].map(|n| Features::from_polytope(self.bodies[n], self.poses[n]));
        // Whether they overlap is told by the walk; where they are closest, more exactly by features.
        closest_points(&features[0].corners, &features[1].corners).ok_or(Error::Overlap)?;
        let closest = features[0].closest(&features[1]).ok_or(Error::Overlap)?;
        let radii = self.radii[0] + self.radii[1];
        let distance = closest.distance() - radii;
        if distance <= 0.0 {
            return Err(Error::Overlap);
        }
        let sigma = first.inradius() + second.inradius() + radii;
        let radial_law = |sigma: f64| Radial { sigma, attraction };
        let centroids = self.poses.map(|pose| pose.position);
        let mut terms = Terms::about(centroids, radial_law(CONTACT_RATIO * sigma), radii);
        if distance < terms.radial.range() {
            match form {
                Form::Contact => contact::add(&mut terms, &closest),
                Form::FaceSum => face_sum::add(&mut terms, self, &features, &closest),
                Form::Smooth => smooth::add(&mut terms, self, &features),
            }
        }
        let mut forces = PairForces {
            energy: terms.energy,
            distance,
            force: terms.force,
            torques: terms.torques,
        };
        central::add(&mut forces, central, &radial_law(sigma), self, &closest);
        Ok(forces)
    }
}
