//! The forces of [`pair`](crate::pair), fast: for bodies that are looked at step after step.
//!
//! | module | one idea |
//! |---|---|
//! | [`flat`] | polygons and disks |
//! | [`solid`] | polyhedra and balls |
//! | [`round`] | ellipsoids, disks and balls |
//!
//! Corners and normals are turned into space once per body and step ([`Turned`]). What was learnt of
//! a pair is kept in a [`Hint`]: the face or the direction that separated it, and the features that
//! came closest. Nothing is allocated.

pub mod flat;
pub mod round;
pub mod solid;

use crate::body::Kind;
use crate::body::part::Part;
use crate::pair::central::Central;
use crate::pair::radial::{Attraction, Radial};
use crate::pair::{CONTACT_RATIO, Form, Interaction};
use protomer_kernel::shape::remembered::Simplex;
use protomer_kernel::{Rotation, Vec3};
use serde::{Deserialize, Serialize};

/// Factor on the reach: a plane that separates two bodies by more leaves no force, whatever the
/// rounding.
pub(crate) const SURELY_BEYOND: f64 = 1.0 + 1e-9;

/// The prepared interaction of two parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// The energy of two points.
    pub radial: Radial,
    /// Sum of the radii of the rounded parts, the disks or the balls.
    pub radii: f64,
    /// Distance of the cores beyond which there is no force.
    pub reach: f64,
    /// The energy between the centres, if any.
    pub central: Option<Radial>,
    /// Largest distance between the centres of two parts that interact.
    pub range: f64,
}

impl Law {
    /// The interaction of two parts; the length of that of points is 0.15 σ.
    pub fn between(first: &Part, second: &Part, interaction: &Interaction) -> Self {
        let sigma = first.inradius() + second.inradius();
        let radial_law = |sigma: f64| Radial {
            sigma,
            attraction: interaction.attraction,
        };
        let radial = radial_law(CONTACT_RATIO * sigma);
        let radii = first.radius + second.radius;
        let central = (interaction.central != Central::None).then(|| radial_law(sigma));
        let contact = first.circumradius() + second.circumradius() + radial.range();
        Self {
            radial,
            radii,
            reach: radial.range() + radii,
            central,
            range: central.map_or(contact, |central| central.range().max(contact)),
        }
    }
}

/// The distance of the centres beyond which two bodies do not repel each other in any orientation.
pub(crate) fn free_distance(first: &Kind, second: &Kind) -> f64 {
    let mut apart = 0.0_f64;
    let repulsion = Interaction {
        form: Form::Contact,
        attraction: Attraction::NONE,
        central: Central::None,
    };
    for a in &first.parts {
        for b in &second.parts {
            let law = Law::between(a, b, &repulsion);
            apart = apart.max(a.centre.norm() + b.centre.norm() + law.range);
        }
    }
    apart
}

/// Interaction of a pair of parts: [`PairForces`](crate::pair::PairForces) without the distance.
/// The energy is infinite where they touch.
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
    /// No interaction: zero energy, force and torques.
    pub fn nothing() -> Self {
        Self {
            energy: 0.0,
            force: Vec3::zeros(),
            torques: [Vec3::zeros(); 2],
        }
    }

    /// Interaction of bodies that touch: infinite energy.
    pub fn touching() -> Self {
        Self {
            energy: f64::INFINITY,
            ..Self::nothing()
        }
    }
}

/// Hint kept for a pair, from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hint {
    /// The face whose plane separated two polygons: those of the first, then those of the second.
    face: u32,
    /// The direction in which two polyhedra were apart, from the first to the second.
    direction: Vec3,
    /// The corners of two polyhedra that came closest.
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

/// Interaction of two parts, given the vector between their centres; the hint is updated.
pub fn felt(
    first: TurnedPart<'_>,
    second: TurnedPart<'_>,
    between: Vec3,
    law: &Law,
    form: Form,
    hint: &mut Hint,
) -> Felt {
    let is_oblong = first.part.half_axes.is_some() || second.part.half_axes.is_some();
    // Oblong parts have no faces: they go first, whatever the dimension.
    let mut felt = match first.part.dimension {
        _ if is_oblong => round::felt(first, second, between, law, hint),
        2 => flat::felt(first, second, between, law, form, hint),
        _ => solid::felt(first, second, between, law, form, hint),
    };
    if let Some(central) = &law.central {
        felt.add_central(central, &between);
    }
    felt
}

impl Felt {
    /// Adds the energy between the centres, which has no torque.
    fn add_central(&mut self, central: &Radial, between: &Vec3) {
        let r = between.norm();
        if r < central.range() {
            // dU/dr along the line of centres; a positive
            // slope pulls the first body towards the second.
            let [energy, slope] = central.energy_and_slope(r);
            self.energy += energy;
            self.force += slope / r * between;
        }
    }
}

/// The corners and normals of the parts of all bodies, turned into space, about the centres of the
/// parts. An ellipsoid has its half axes in the place of normals.
#[derive(Debug, Clone, Default)]
pub struct Turned {
    corners: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Vector from the centre of mass of the body to the centre of each part.
    centres: Vec<Vec3>,
    /// Start of the corners and of the normals of each part, and at last their end.
    starts: Vec<[usize; 2]>,
    /// Index of the first part of each body.
    first_part: Vec<usize>,
}

/// A part turned into space.
#[derive(Debug, Clone, Copy)]
pub struct TurnedPart<'a> {
    /// The part.
    pub part: &'a Part,
    /// Corners of the core from the centre.
    pub corners: &'a [Vec3],
    /// Normals of the faces, or the half axes of an ellipsoid.
    pub normals: &'a [Vec3],
}

impl Turned {
    /// Reserves room for bodies of these kinds.
    pub fn from_kinds<'a>(kinds: impl Iterator<Item = &'a Kind>) -> Self {
        let mut geometry = Self::default();
        let mut starts = [0, 0];
        geometry.starts.push(starts);
        for kind in kinds {
            geometry.first_part.push(geometry.centres.len());
            for part in &kind.parts {
                // Corners and normals of all parts lie in two arrays; `starts` says where.
                starts[0] += part.polytope.corners.len();
                starts[1] += match part.half_axes {
                    Some(_) => part.dimension,
                    None => part.polytope.faces.len(),
                };
                geometry.starts.push(starts);
                geometry.centres.push(Vec3::zeros());
            }
        }
        geometry.corners.resize(starts[0], Vec3::zeros());
        geometry.normals.resize(starts[1], Vec3::zeros());
        geometry
    }

    /// Turns a body in a plane.
    pub fn turn_flat(&mut self, body: usize, kind: &Kind, angle_rad: f64) {
        let (sine, cosine) = angle_rad.sin_cos();
        // Two products per coordinate; z stays zero in a plane.
        let turn = |x: &Vec3| Vec3::new(cosine * x.x - sine * x.y, sine * x.x + cosine * x.y, 0.0);
        self.fill(body, kind, turn);
    }

    /// Turns a body in space.
    pub fn turn_solid(&mut self, body: usize, kind: &Kind, rotation: &Rotation) {
        let matrix = rotation.to_rotation_matrix().into_inner();
        self.fill(body, kind, |x| matrix * x);
    }

    fn fill(&mut self, body: usize, kind: &Kind, turn: impl Fn(&Vec3) -> Vec3) {
        for (number, part) in kind.parts.iter().enumerate() {
            let number = self.first_part[body] + number;
            let [corner, face] = self.starts[number];
            let corners = self.corners[corner..].iter_mut();
            for (place, x) in corners.zip(&part.polytope.corners) {
                *place = turn(x);
            }
            let normals = self.normals[face..].iter_mut();
            match &part.half_axes {
                Some(axes) => {
                    for (axis, place) in normals.take(part.dimension).enumerate() {
                        // Half axes take the place of normals: they are turned alike.
                        *place = turn(&Vec3::ith(axis, axes[axis]));
                    }
                }
                None => {
                    for (place, x) in normals.zip(&part.polytope.faces) {
                        *place = turn(&x.normal);
                    }
                }
            }
            self.centres[number] = turn(&part.centre);
        }
    }

    /// A part of a body.
    pub fn part<'a>(&'a self, body: usize, number: usize, kind: &'a Kind) -> TurnedPart<'a> {
        let place = self.first_part[body] + number;
        let [corner, face] = self.starts[place];
        let [next_corner, next_face] = self.starts[place + 1];
        TurnedPart {
            part: &kind.parts[number],
            corners: &self.corners[corner..next_corner],
            normals: &self.normals[face..next_face],
        }
    }

    /// The vector from the centre of mass of a body to the centre of one of its parts.
    pub fn centre(&self, body: usize, number: usize) -> Vec3 {
        self.centres[self.first_part[body] + number]
    }
}
