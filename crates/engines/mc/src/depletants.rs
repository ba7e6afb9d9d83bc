//! Implicit depletants: penetrable hard spheres, ideal among themselves, in osmotic equilibrium with a reservoir.
//!
//! The centre of a depletant of radius r keeps a distance of r from every hard surface. With the number density z of the
//! reservoir, depletants integrate out to the weight exp(z V_free) of a state, where V_free is the volume open to their
//! centres (Asakura and Oosawa, J. Chem. Phys. 22, 1255 (1954)). No depletant is held, and V_free is never computed. A move
//! takes bodies from O to N, both widened by r, while the others cover J. Points are drawn from the Poisson process of
//! density z, and one in a region A refuses the move. If A and the region B of the reverse move fulfil |B| - |A| = change of
//! V_free, that is detailed balance (Glaser, Karas and Glotzer, J. Chem. Phys. 143, 184110 (2015)).
//!
//! * Bodies that move as one: A = (O \ N) ∩ J, the overlap with others that is lost. As |O| = |N|, that is enough. A body that
//!   meets no other is never refused, and no point is drawn for it.
//! * Others: A = N \ O \ J, what the bodies take from the depletants.
//!
//! This decision multiplies that of the energy, and the bonds of a cluster move know nothing of it: each of the factors alone
//! obeys detailed balance, so the product does.
//!
//! A point in the widened ball that fits into the body at both ends of a move of one body is in neither region. Whether a
//! mesh covers a point is decided by distances of triangles and, inside, by a ray
//! ([`CollisionShape::is_within`](protomer_kernel::CollisionShape::is_within)).

use crate::error::require;
use crate::neighbours::Neighbours;
use crate::{Result, System};
use protomer_kernel::cells::require_minimum_image;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shell::Shell;
use protomer_kernel::{Pose, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Depletants of one size.
///
/// ```
/// use protomer_mc::Depletants;
/// let coils = Depletants { radius_angstrom: 10.0, reservoir_fraction: 0.2 };
/// assert!((coils.fugacity_per_angstrom3() - 4.7746e-5).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Depletants {
    /// Radius, Å.
    pub radius_angstrom: f64,
    /// Part of the reservoir that the spheres would fill if they did not penetrate each other.
    pub reservoir_fraction: f64,
}

impl Depletants {
    /// Number density in the reservoir, Å⁻³; times kT it is the osmotic pressure.
    pub fn fugacity_per_angstrom3(&self) -> f64 {
        self.reservoir_fraction / (4.0 / 3.0 * PI * self.radius_angstrom.powi(3))
    }

    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) names the number that is out of range.
    pub(crate) fn check(&self) -> Result<()> {
        let (radius, fraction) = (self.radius_angstrom, self.reservoir_fraction);
        let holds = radius.is_finite() && radius > 0.0;
        require("radius_angstrom", radius, "positive", holds)?;
        let holds = (0.0..=10.0).contains(&fraction);
        require("reservoir_fraction", fraction, "0 to 10", holds)
    }

    /// Distance of two origins beyond which no depletant touches both bodies, Å.
    pub(crate) fn range_angstrom(&self, system: &System) -> f64 {
        system.hard_range_angstrom() + 2.0 * self.radius_angstrom
    }

    /// Checks that no depletant touches two images of a body.
    ///
    /// # Errors
    /// [`KernelError::BoxTooSmall`](protomer_kernel::KernelError::BoxTooSmall).
    pub fn require_room(&self, system: &System) -> Result<()> {
        let reach = 0.5 * self.range_angstrom(system);
        Ok(require_minimum_image(system.boundary(), reach)?)
    }
}

/// New poses of bodies, the numbers ascending.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moved<'a> {
    pub poses: &'a [(usize, Pose)],
    /// Whether the bodies move as one.
    pub is_rigid: bool,
}

/// Depletants around the bodies of a system.
#[derive(Debug, Clone)]
pub(crate) struct Depletion {
    radius_angstrom: f64,
    fugacity_per_angstrom3: f64,
    /// For each type of body the radius of a ball about the origin that lies in it; none where the origin does not.
    inner_radii_angstrom: Vec<Option<f64>>,
}

impl Depletion {
    /// # Errors
    /// For numbers out of range, and for a box that is too small.
    pub fn new(depletants: &Depletants, system: &System) -> Result<Self> {
        depletants.check()?;
        depletants.require_room(system)?;
        let inner_radius = |kind: &std::sync::Arc<crate::BodyType>| {
            let holds_origin = kind.shape.contains_point(&Vec3::zeros());
            holds_origin.then_some(kind.least_radius_angstrom)
        };
        Ok(Self {
            radius_angstrom: depletants.radius_angstrom,
            fugacity_per_angstrom3: depletants.fugacity_per_angstrom3(),
            inner_radii_angstrom: system.types().iter().map(inner_radius).collect(),
        })
    }

    /// Whether no depletant forbids the move.
    pub fn allows(
        &self,
        system: &System,
        neighbours: &Neighbours,
        moved: &Moved<'_>,
        rng: &mut CounterRng,
    ) -> bool {
        let before: Vec<(usize, Pose)> = moved
            .poses
            .iter()
            .map(|(body, _)| (*body, *system.pose(*body)))
            .collect();
        // Points are drawn around the bodies at one end of the move and must not be covered by them at the other.
        let (inside, outside) = match moved.is_rigid {
            true => (before.as_slice(), moved.poses),
            false => (moved.poses, before.as_slice()),
        };
        let trial = Trial {
            depletion: self,
            system,
            neighbours,
            inside,
            outside,
            is_lost: moved.is_rigid,
        };
        (0..inside.len()).all(|number| trial.is_allowed_around(number, rng))
    }

    /// Radius of the ball about the origin of a body that holds it, widened by a depletant, Å.
    fn outer_radius(&self, system: &System, body: usize) -> f64 {
        system.body_type(body).hard_radius_angstrom() + self.radius_angstrom
    }

    /// Whether the centre of a depletant cannot be in a place, because of a body with this pose.
    fn covers(&self, system: &System, (body, pose): &(usize, Pose), place: &Vec3) -> bool {
        let way = system.boundary().displacement(&pose.position, place);
        let (squared, outer) = (way.norm_squared(), self.outer_radius(system, *body));
        if squared >= outer * outer {
            return false;
        }
        if let Some(inner) = self.inner_radii_angstrom[system.type_index(*body)] {
            let inner = inner + self.radius_angstrom;
            if squared < inner * inner {
                return true;
            }
        }
        let point = pose.rotation.inverse_transform_vector(&way);
        let shape = &system.body_type(*body).shape;
        shape.is_within(&point, self.radius_angstrom)
    }
}

/// One trial move, as the depletants see it.
struct Trial<'a> {
    depletion: &'a Depletion,
    system: &'a System,
    neighbours: &'a Neighbours,
    /// The bodies where the points are drawn.
    inside: &'a [(usize, Pose)],
    /// The bodies at the other end of the move.
    outside: &'a [(usize, Pose)],
    /// Whether depletants covered by others forbid the move, or free ones.
    is_lost: bool,
}

impl Trial<'_> {
    /// Whether no depletant around one of the bodies forbids the move.
    fn is_allowed_around(&self, number: usize, rng: &mut CounterRng) -> bool {
        let (system, depletion) = (self.system, self.depletion);
        let (body, pose) = self.inside[number];
        let outer = depletion.outer_radius(system, body);
        let others = self.others_near(&pose, outer);
        // Nothing can be lost.
        if self.is_lost && others.is_empty() {
            return true;
        }
        let shell = Shell::<3>::new(self.inner_radius(body), outer);
        let expected = depletion.fugacity_per_angstrom3 * shell.volume();
        // Arrivals of a Poisson process: points are drawn only until one forbids the move.
        let mut arrived = rng.exponential();
        while arrived < expected {
            let place = pose.position + Vec3::from(shell.point(rng));
            if self.forbids(number, &others, &place) {
                return false;
            }
            arrived += rng.exponential();
        }
        true
    }

    /// Radius of a ball about a body that moves alone in which it covers every point at both ends of the move, Å.
    fn inner_radius(&self, body: usize) -> f64 {
        let depletion = self.depletion;
        let inner = depletion.inner_radii_angstrom[self.system.type_index(body)];
        match (inner, self.inside, self.outside) {
            (Some(inner), [from], [to]) => {
                let boundary = self.system.boundary();
                let step = boundary.displacement(&from.1.position, &to.1.position);
                (inner + depletion.radius_angstrom - step.norm()).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// Bodies that stay and can cover a depletant that this one covers, with their poses.
    fn others_near(&self, pose: &Pose, outer: f64) -> Vec<(usize, Pose)> {
        let (system, depletion) = (self.system, self.depletion);
        let is_near = |other: &usize| {
            let place = &system.pose(*other).position;
            let reach = outer + depletion.outer_radius(system, *other);
            let way = system.boundary().displacement(&pose.position, place);
            way.norm_squared() < reach * reach
        };
        let stays = |other: &usize| !self.moves(*other);
        let mut bodies = Vec::new();
        self.neighbours.find_sharing(&pose.position, &mut bodies);
        bodies
            .into_iter()
            .filter(|other| stays(other) && is_near(other))
            .map(|other| (other, *system.pose(other)))
            .collect()
    }

    /// Whether a body is one of those that move, whose numbers ascend.
    fn moves(&self, body: usize) -> bool {
        let numbers = self.inside;
        numbers
            .binary_search_by_key(&body, |(moved, _)| *moved)
            .is_ok()
    }

    fn forbids(&self, number: usize, others: &[(usize, Pose)], place: &Vec3) -> bool {
        let (system, depletion) = (self.system, self.depletion);
        let covers = |body: &(usize, Pose)| depletion.covers(system, body, place);
        let in_ball = |body: &(usize, Pose)| {
            let outer = depletion.outer_radius(system, body.0);
            let way = system.boundary().displacement(&body.1.position, place);
            way.norm_squared() < outer * outer
        };
        // A place in the balls of several bodies counts once, with the first.
        if self.inside[..number].iter().any(in_ball) {
            return false;
        }
        // Cheapest first: meshes are asked about points in a ball of another only.
        if self.is_lost && !others.iter().any(in_ball) {
            return false;
        }
        self.inside.iter().any(covers)
            && !self.outside.iter().any(covers)
            && others.iter().any(covers) == self.is_lost
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::BodyType;
    use crate::neighbours::Ranges;
    use crate::test_support::{octahedron, tetrahedron};
    use protomer_kernel::{Boundary, Rotation};
    use std::sync::Arc;

    const DEPLETANTS: Depletants = Depletants {
        radius_angstrom: 2.0,
        reservoir_fraction: 0.3,
    };

    /// Bodies of two kinds near each other, some of them across a border.
    fn system() -> System {
        let kinds = [tetrahedron(3.0), octahedron(4.0)]
            .map(|mesh| Arc::new(BodyType::new("body", &mesh, &[]).unwrap()));
        let pose = |x: f64, y: f64, angle: f64| Pose {
            position: Vec3::new(x, y, 0.5 * y),
            rotation: Rotation::from_scaled_axis(Vec3::new(angle, 0.3, -angle)),
        };
        let bodies = [
            (0, pose(13.0, 1.0, 0.2)),
            (1, pose(-13.0, 0.0, 0.8)),
            (0, pose(-6.0, 1.5, 1.4)),
            (1, pose(12.0, 8.5, -0.6)),
        ];
        let boundary = Boundary::periodic(Vec3::new(32.0, 30.0, 31.0)).unwrap();
        System::new(kinds.to_vec(), &bodies, boundary).unwrap()
    }

    /// Neighbours of bodies that interact up to this distance of origins.
    fn neighbours(system: &System, interaction_angstrom: f64) -> Neighbours {
        let ranges = Ranges {
            hard_angstrom: system.hard_range_angstrom(),
            interaction_angstrom,
            reach_angstrom: interaction_angstrom,
            depletion_angstrom: DEPLETANTS.range_angstrom(system),
        };
        Neighbours::new(system, ranges)
    }

    /// Many bodies of two kinds anywhere in a space of these edges; they may overlap.
    fn scattered(boundary: Boundary, edges: &Vec3, rng: &mut CounterRng) -> System {
        let kinds = [tetrahedron(3.0), octahedron(4.0)]
            .map(|mesh| Arc::new(BodyType::new("body", &mesh, &[]).unwrap()));
        let mut body = |number: usize| {
            let position = edges.map(|edge| edge * rng.uniform_in(-0.5, 0.5));
            let rotation = rng.rotation();
            (number % 2, Pose { position, rotation })
        };
        let bodies: Vec<_> = (0..300).map(&mut body).collect();
        System::new(kinds.to_vec(), &bodies, boundary).unwrap()
    }

    /// Bodies that stay and share places for depletants with one that moves, by a loop over all bodies.
    fn others_among_all(trial: &Trial<'_>, number: usize) -> Vec<(usize, Pose)> {
        let (system, depletion) = (trial.system, trial.depletion);
        let (body, pose) = trial.inside[number];
        let mut others = Vec::new();
        for other in 0..system.len() {
            let way = system
                .boundary()
                .displacement(&pose.position, &system.pose(other).position);
            let reach =
                depletion.outer_radius(system, body) + depletion.outer_radius(system, other);
            let stays = trial.inside.iter().all(|(moved, _)| *moved != other);
            if stays && way.norm_squared() < reach * reach {
                others.push((other, *system.pose(other)));
            }
        }
        others
    }

    /// With cells of the interaction and with cells of their own, in large boxes, a small one without cells, a wall and open space, before and
    /// after bodies have moved.
    #[test]
    fn bodies_near_a_move_are_those_of_a_loop_over_all() {
        let mut rng = CounterRng::new(31, 0, 0);
        let periodic = |edges: Vec3| (Boundary::periodic(edges).unwrap(), edges);
        let wall = Boundary::SphereWall {
            radius_angstrom: 100.0,
        };
        let spaces = [
            periodic(Vec3::new(64.0, 91.0, 120.0)),
            periodic(Vec3::new(40.0, 52.0, 45.0)),
            (wall, Vec3::repeat(80.0)),
            (Boundary::Open, Vec3::repeat(80.0)),
        ];
        for ((boundary, edges), interaction_angstrom) in spaces
            .into_iter()
            .flat_map(|space| [(space, 0.0), (space, 15.5)])
        {
            let mut system = scattered(boundary, &edges, &mut rng);
            let mut neighbours = neighbours(&system, interaction_angstrom);
            let depletion = Depletion::new(&DEPLETANTS, &system).unwrap();
            let mut near = 0;
            for _ in 0..100 {
                let mut place = |body: usize| {
                    let position = edges.map(|edge| edge * rng.uniform_in(-0.5, 0.5));
                    let rotation = rng.rotation();
                    (body, system.tidy(Pose { position, rotation }))
                };
                let moved = [7, 8, 150, 299].map(&mut place);
                let before = moved.map(|(body, _)| (body, *system.pose(body)));
                for (inside, outside) in [(&before, &moved), (&moved, &before)] {
                    let trial = Trial {
                        depletion: &depletion,
                        system: &system,
                        neighbours: &neighbours,
                        inside,
                        outside,
                        is_lost: true,
                    };
                    for (number, (body, pose)) in inside.iter().enumerate() {
                        let outer = depletion.outer_radius(&system, *body);
                        let found = trial.others_near(pose, outer);
                        assert_eq!(found, others_among_all(&trial, number));
                        near += found.len();
                    }
                }
                for ((body, old), (_, new)) in before.iter().zip(&moved) {
                    neighbours.moved(*body, &old.position, &new.position);
                    system.set_pose(*body, *new);
                }
            }
            assert!(near > 1000, "{near}");
        }
    }

    /// Volume of the region that forbids a move, over a grid through the whole box and all bodies.
    fn forbidden_volume(system: &System, moved: &Moved<'_>) -> f64 {
        let is_covered = |bodies: &[(usize, Pose)], place: &Vec3| {
            bodies.iter().any(|(body, pose)| {
                let shape = &system.body_type(*body).shape;
                // All images, by brute force.
                (0..27).any(|image| {
                    let lengths = Vec3::new(32.0, 30.0, 31.0);
                    let shift = [image % 3, image / 3 % 3, image / 9].map(|x| f64::from(x) - 1.0);
                    let way = place - pose.position + lengths.component_mul(&Vec3::from(shift));
                    let point = pose.rotation.inverse() * way;
                    shape.is_within(&point, DEPLETANTS.radius_angstrom)
                })
            })
        };
        let is_moved = |body: &usize| moved.poses.iter().any(|(other, _)| other == body);
        let at = |bodies: Vec<usize>| -> Vec<(usize, Pose)> {
            bodies
                .into_iter()
                .map(|body| (body, *system.pose(body)))
                .collect()
        };
        let before = at((0..system.len()).filter(is_moved).collect());
        let others = at((0..system.len()).filter(|body| !is_moved(body)).collect());
        let (inside, outside) = match moved.is_rigid {
            true => (before.as_slice(), moved.poses),
            false => (moved.poses, before.as_slice()),
        };
        let cells = [64, 60, 62];
        let mut count = 0;
        for number in 0..cells.iter().product::<usize>() {
            let index = [number % 64, number / 64 % 60, number / 64 / 60];
            let place = Vec3::from_fn(|axis, _| {
                0.5 * (index[axis] as f64 + 0.5) - 0.25 * cells[axis] as f64
            });
            let is_in = is_covered(inside, &place)
                && !is_covered(outside, &place)
                && is_covered(&others, &place) == moved.is_rigid;
            count += usize::from(is_in);
        }
        0.125 * count as f64
    }

    /// Moves are allowed with the probability exp(-z |A|): one body that is shifted or turned, two that turn half about an axis, and two
    /// that change places.
    #[test]
    fn moves_are_allowed_as_often_as_the_forbidden_volume_says() {
        let system = system();
        let shifted = |body: usize, shift: Vec3, angle: f64| {
            let pose = system.pose(body);
            let turn = Rotation::from_scaled_axis(Vec3::new(0.0, angle, 0.4 * angle));
            let new = Pose {
                position: pose.position + shift,
                rotation: turn * pose.rotation,
            };
            (body, system.tidy(new))
        };
        let half_turn = crate::moves::HalfTurn {
            point: Vec3::new(13.0, 3.0, 1.0),
            direction: Vec3::z(),
        };
        let turned = |body: usize| (body, system.tidy(half_turn.apply(system.pose(body))));
        let exchanged = |body: usize, other: usize| {
            let position = system.pose(other).position;
            (
                body,
                Pose {
                    position,
                    ..*system.pose(body)
                },
            )
        };
        let moves: [(Vec<(usize, Pose)>, bool); 6] = [
            (vec![shifted(0, Vec3::new(-0.7, 0.4, 0.3), 0.0)], true),
            (vec![shifted(1, Vec3::zeros(), 0.5)], true),
            (vec![shifted(2, Vec3::new(9.0, 4.0, 8.0), 1.0)], true),
            (vec![turned(0), turned(1)], true),
            (vec![exchanged(0, 1), exchanged(1, 0)], false),
            (vec![shifted(0, Vec3::new(-0.7, 0.4, 0.3), 0.0)], false),
        ];
        let depletion = Depletion::new(&DEPLETANTS, &system).unwrap();
        let neighbours = neighbours(&system, 0.0);
        for (number, (poses, is_rigid)) in moves.iter().enumerate() {
            let moved = Moved {
                poses,
                is_rigid: *is_rigid,
            };
            let expected =
                (-DEPLETANTS.fugacity_per_angstrom3() * forbidden_volume(&system, &moved)).exp();
            let trials = 20_000;
            let allowed = (0..trials)
                .filter(|trial| {
                    let mut rng = CounterRng::new(4, number as u32, *trial);
                    depletion.allows(&system, &neighbours, &moved, &mut rng)
                })
                .count();
            let part = allowed as f64 / trials as f64;
            let error = (expected * (1.0 - expected) / trials as f64).sqrt();
            // The grid is good to 2 % of the volume.
            let tolerance = 4.0 * error - 0.02 * expected * expected.ln();
            assert!(
                (part - expected).abs() < tolerance,
                "{number}: {part}, {expected}"
            );
            assert!((0.02..0.98).contains(&expected), "{number}: {expected}");
        }
    }

    #[test]
    fn a_body_that_meets_no_other_is_never_refused() {
        let system = system();
        let far = System::new(
            system.types().to_vec(),
            &[(0, Pose::identity())],
            Boundary::Open,
        )
        .unwrap();
        let depletion = Depletion::new(&DEPLETANTS, &far).unwrap();
        let there = Pose {
            position: Vec3::new(3.0, 0.0, 0.0),
            ..Pose::identity()
        };
        let moved = Moved {
            poses: &[(0, there)],
            is_rigid: true,
        };
        let neighbours = neighbours(&far, 0.0);
        let allows = |trial| {
            let mut rng = CounterRng::new(1, 0, trial);
            depletion.allows(&far, &neighbours, &moved, &mut rng)
        };
        assert!((0..200).all(allows));
    }

    #[test]
    fn numbers_out_of_range_and_small_boxes_are_refused() {
        for (radius_angstrom, reservoir_fraction) in [
            (0.0, 0.1),
            (f64::NAN, 0.1),
            (2.0, -0.1),
            (2.0, f64::INFINITY),
        ] {
            let wrong = Depletants {
                radius_angstrom,
                reservoir_fraction,
            };
            assert!(wrong.check().is_err(), "{wrong:?}");
        }
        let large = Depletants {
            radius_angstrom: 12.0,
            ..DEPLETANTS
        };
        assert!(Depletion::new(&large, &system()).is_err());
        // Half of the smallest edge is 15 Å, the largest body reaches 3 √3 Å.
        let fits = Depletants {
            radius_angstrom: 9.7,
            ..DEPLETANTS
        };
        assert!(Depletion::new(&fits, &system()).is_ok());
    }
}
