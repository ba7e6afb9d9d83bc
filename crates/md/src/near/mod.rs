//! The forces of [`pair`](crate::pair), fast: for bodies that are looked at step after step.
//!
//! | module | one idea |
//! |---|---|
//! | [`flat`] | polygons and disks |
//! | [`solid`] | polyhedra and balls |
//!
//! Corners and normals are turned into space once per body and step ([`Turned`]). What was learnt of
//! a pair is kept in a [`Hint`]: the face or the direction that separated it, and the features that
//! came closest. Nothing is allocated.

pub mod flat;
pub mod solid;

use crate::body::Kind;
use protomer_kernel::shape::remembered::Simplex;
use protomer_kernel::{Rotation, Vec3};
use serde::{Deserialize, Serialize};

/// A plane that separates two bodies by this much more than the reach leaves no force to rounding.
pub(crate) const SURELY_BEYOND: f64 = 1.0 + 1e-9;

/// The repulsion of two kinds, prepared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// The repulsion.
    pub repulsion: crate::pair::repulsion::Repulsion,
    /// The radii of the disks or balls, added.
    pub radii: f64,
    /// Distance of the corners and faces from which on there is no force.
    pub reach: f64,
}

impl Law {
    /// The repulsion between two kinds, with the length 0.15 σ.
    pub fn between(first: &Kind, second: &Kind) -> Self {
        let sigma = crate::pair::CONTACT_RATIO * (first.inradius() + second.inradius());
        let repulsion = crate::pair::repulsion::Repulsion { sigma };
        let radii = first.radius + second.radius;
        Self {
            repulsion,
            radii,
            reach: repulsion.range() + radii,
        }
    }
}

/// What a body pair feels: as [`PairForces`](crate::pair::PairForces), without the distance. The
/// energy is infinite where the bodies touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt {
    /// Energy in units of ε.
    pub energy: f64,
    /// Force on the first body; that on the second is its opposite.
    pub force: Vec3,
    /// Torques about the centres.
    pub torques: [Vec3; 2],
}

impl Felt {
    /// Nothing.
    pub fn nothing() -> Self {
        Self {
            energy: 0.0,
            force: Vec3::zeros(),
            torques: [Vec3::zeros(); 2],
        }
    }

    /// The bodies touch.
    pub fn touching() -> Self {
        Self {
            energy: f64::INFINITY,
            ..Self::nothing()
        }
    }
}

/// What was learnt of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hint {
    /// The face whose plane separated two polygons: those of the first, then those of the second.
    face: u32,
    /// The direction in which two polyhedra were apart, from the first to the second.
    direction: Vec3,
    /// The corners that came closest.
    simplex: Simplex,
}

impl Default for Hint {
    fn default() -> Self {
        Self {
            face: 0,
            direction: Vec3::zeros(),
            simplex: Simplex::default(),
        }
    }
}

/// The corners and normals of all bodies, turned into space, about the centres.
#[derive(Debug, Clone, Default)]
pub struct Turned {
    corners: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Where the corners and the normals of each body begin, and at last where they end.
    starts: Vec<[usize; 2]>,
}

/// A body turned into space.
#[derive(Debug, Clone, Copy)]
pub struct TurnedBody<'a> {
    /// Its kind.
    pub kind: &'a Kind,
    /// Corners from the centre.
    pub corners: &'a [Vec3],
    /// Normals of the faces.
    pub normals: &'a [Vec3],
}

impl Turned {
    /// Room for bodies of these kinds.
    pub fn of<'a>(kinds: impl Iterator<Item = &'a Kind>) -> Self {
        let mut turned = Self::default();
        let mut starts = [0, 0];
        turned.starts.push(starts);
        for kind in kinds {
            starts[0] += kind.polytope.corners.len();
            starts[1] += kind.polytope.faces.len();
            turned.starts.push(starts);
        }
        turned.corners.resize(starts[0], Vec3::zeros());
        turned.normals.resize(starts[1], Vec3::zeros());
        turned
    }

    /// Turns a body in a plane.
    pub fn turn_flat(&mut self, body: usize, kind: &Kind, angle_rad: f64) {
        let (sine, cosine) = angle_rad.sin_cos();
        let turn = |x: &Vec3| Vec3::new(cosine * x.x - sine * x.y, sine * x.x + cosine * x.y, 0.0);
        self.fill(body, kind, turn);
    }

    /// Turns a body in space.
    pub fn turn_solid(&mut self, body: usize, kind: &Kind, rotation: &Rotation) {
        let matrix = rotation.to_rotation_matrix().into_inner();
        self.fill(body, kind, |x| matrix * x);
    }

    fn fill(&mut self, body: usize, kind: &Kind, turn: impl Fn(&Vec3) -> Vec3) {
        let [corner, face] = self.starts[body];
        for (place, x) in self.corners[corner..]
            .iter_mut()
            .zip(&kind.polytope.corners)
        {
            *place = turn(x);
        }
        for (place, x) in self.normals[face..].iter_mut().zip(&kind.polytope.faces) {
            *place = turn(&x.normal);
        }
    }

    /// A body.
    pub fn body<'a>(&'a self, body: usize, kind: &'a Kind) -> TurnedBody<'a> {
        let ([corner, face], [end, last]) = (self.starts[body], self.starts[body + 1]);
        TurnedBody {
            kind,
            corners: &self.corners[corner..end],
            normals: &self.normals[face..last],
        }
    }
}
