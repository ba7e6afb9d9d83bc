//! A body goes next to another, or anywhere: aggregation-volume bias.

use super::proposal::{Proposal, another};
use crate::system::{System, Trial};
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use std::f64::consts::PI;

/// Probability that a body is put next to another, and not anywhere.
const BESIDE: f64 = 0.5;

/// Puts a random body i, turned at random, next to another random body j or anywhere in the space
/// (aggregation-volume bias, Chen and Siepmann, J. Phys. Chem. B 104, 8725 (2000)).
///
/// *Next to* j is a shell of volume v about its origin, in which surfaces can touch. The new place
/// has the density
///
/// q(r) = p 1[r in the shell]/v + (1 - p)/V,
///
/// **Why this is exact.** i and j are drawn without regard to the state, and q knows j, which does not
/// move, but not where i was: the way back from r' to r is proposed with density q(r) and the way
/// there with q(r'). The allowance is ln(q(r)/q(r')). Orientations are uniform both ways. A place
/// beyond a wall is refused, which changes neither density.
pub fn propose(system: &System, gap_angstrom: f64, rng: &mut CounterRng) -> Option<Proposal> {
    let body = rng.index(system.len());
    let target = another(body, system.len(), rng);
    let shell = Shell::from_bodies(system, body, target, gap_angstrom)?;
    let centre = system.pose(target).position;
    let position = match rng.uniform() < shell.probability() {
        true => centre + shell.random(rng),
        false => anywhere(system.boundary(), rng),
    };
    let pose = system.tidy(Pose {
        position,
        rotation: rng.rotation(),
    });
    let new = Trial { system, body, pose };
    let distance = |displacement: Vec3| displacement.norm();
    let old_density = shell.density(distance(system.pair(body, target).displacement));
    let new_density = shell.density(distance(new.pair(target).displacement));
    Some(Proposal {
        poses: vec![(body, pose)],
        allowance_kt: (old_density / new_density).ln(),
        is_rigid: true,
    })
}

/// Distances of two origins at which surfaces can touch, Å, in a space of this volume.
#[derive(Debug, Clone, Copy)]
struct Shell {
    inner_angstrom: f64,
    outer_angstrom: f64,
    space_angstrom3: f64,
}

impl Shell {
    /// The shell of a body next to its target; `None` in a space without a volume.
    fn from_bodies(system: &System, body: usize, target: usize, gap_angstrom: f64) -> Option<Self> {
        let kinds = [body, target].map(|body| system.body_type(body));
        let least = kinds.map(|kind| kind.least_radius_angstrom);
        let largest = kinds.map(|kind| kind.hard_radius_angstrom());
        let half_box = 0.5 * system.boundary().smallest_length_angstrom();
        let space_angstrom3 = system.boundary().volume_angstrom3();
        space_angstrom3.is_finite().then_some(Self {
            inner_angstrom: least[0] + least[1],
            outer_angstrom: (largest[0] + largest[1] + gap_angstrom).min(half_box),
            space_angstrom3,
        })
    }

    fn is_empty(&self) -> bool {
        self.outer_angstrom <= self.inner_angstrom
    }

    fn probability(&self) -> f64 {
        if self.is_empty() { 0.0 } else { BESIDE }
    }

    fn cubes(&self) -> [f64; 2] {
        [self.inner_angstrom, self.outer_angstrom].map(|radius| radius.powi(3))
    }

    fn volume_angstrom3(&self) -> f64 {
        let [inner, outer] = self.cubes();
        4.0 / 3.0 * PI * (outer - inner)
    }

    /// A vector uniform in the shell, Å.
    fn random(&self, rng: &mut CounterRng) -> Vec3 {
        let [inner, outer] = self.cubes();
        rng.unit_vector() * rng.uniform_in(inner, outer).cbrt()
    }

    /// q at this distance from the target, Å⁻³.
    fn density(&self, distance_angstrom: f64) -> f64 {
        let is_inside = (self.inner_angstrom..self.outer_angstrom).contains(&distance_angstrom);
        let beside = match is_inside && !self.is_empty() {
            true => self.probability() / self.volume_angstrom3(),
            false => 0.0,
        };
        beside + (1.0 - self.probability()) / self.space_angstrom3
    }
}

/// A place uniform in the space, Å.
fn anywhere(boundary: &Boundary, rng: &mut CounterRng) -> Vec3 {
    match boundary {
        Boundary::Periodic { lengths_angstrom } => {
            lengths_angstrom.map(|length| length * rng.uniform_in(-0.5, 0.5))
        }
        Boundary::SphereWall { radius_angstrom } => rng.vector_in_ball(*radius_angstrom),
        Boundary::Open => Vec3::zeros(),
    }
}
