//! Bodies in contact move as one.

use super::proposal::{Proposal, any_size};
use crate::observables::in_contact;
use crate::system::System;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use std::f64::consts::PI;

/// Probability that every contact binds.
const WHOLE: f64 = 0.5;
/// The smallest of the largest displacements, Å.
const SMALLEST_STEP_ANGSTROM: f64 = 0.5;
/// The smallest of the largest rotations, rad.
const SMALLEST_ANGLE_RAD: f64 = 0.02;

/// Moves or turns a random body together with bodies that are joined to it by contacts, of which each
/// binds with probability p (as bonds do in Swendsen and Wang, Phys. Rev. Lett. 58, 86 (1987), but with
/// a p that knows no energy). One time in two p is 1, otherwise uniform in 0..1.
///
/// **Why this is exact.** A group G grows from its seed with the probability that its inner contacts
/// join it, times (1 - p)^n for its n contacts with the rest, none of which may bind. G moves as one, so
/// its inner contacts are the same after the move, and the probability that the same G grows there
/// differs by the outer contacts alone: the allowance is (n' - n) ln(1 - p). With p = 1 a group that
/// comes into contact could not part again, and n' must be zero. A step is as likely as its opposite, a
/// rotation about the seed as its inverse, and p and the sizes of steps know nothing of the state. In a
/// periodic box a group turns only if it is narrower than half the box, which turning does not
/// change: its inner distances are then those of nearest images, before and after.
pub fn propose(system: &System, gap_angstrom: f64, rng: &mut CounterRng) -> Option<Proposal> {
    let seed = rng.index(system.len());
    let p = if rng.uniform() < WHOLE {
        1.0
    } else {
        rng.uniform()
    };
    let group = Group::grow(system, seed, p, gap_angstrom, rng);
    let poses = match rng.uniform() < 0.5 {
        true => {
            // Sizes over orders of magnitude: what fits a
            // dilute state is too large for a dense one.
            let largest = any_size(SMALLEST_STEP_ANGSTROM, half_width_angstrom(system), rng);
            group.moved(system, &rng.vector_in_ball(largest))
        }
        false => {
            let largest = any_size(SMALLEST_ANGLE_RAD, PI, rng);
            let turn = rng.small_rotation(largest);
            // After the numbers are drawn, so that the stream does not depend on the answer.
            if !group.is_narrow(system.boundary()) {
                return None;
            }
            group.turned(system, &turn)
        }
    };
    let after = contacts_with_rest(&system.with_moved(&poses), &group, gap_angstrom);
    // With p = 1, ln(1 - p) is infinite: any new contact makes the reverse move impossible.
    if p == 1.0 && after > 0 {
        return None;
    }
    Some(Proposal {
        allowance_kt: match p == 1.0 {
            true => 0.0,
            false => (after as f64 - group.outer_contacts as f64) * (1.0 - p).ln(),
        },
        poses,
        is_rigid: true,
    })
}

/// Bodies joined to a seed.
struct Group {
    /// Members in the order in which they joined, with the way from the seed's origin to theirs
    /// along contacts, Å.
    members: Vec<(usize, Vec3)>,
    outer_contacts: usize,
}

impl Group {
    fn grow(system: &System, seed: usize, p: f64, gap_angstrom: f64, rng: &mut CounterRng) -> Self {
        let mut members = vec![(seed, Vec3::zeros())];
        let mut is_member = vec![false; system.len()];
        is_member[seed] = true;
        // Contacts that did not bind, of which some turn out to be inner ones.
        let mut loose = Vec::new();
        let mut asked = 0;
        // In the order in which they joined: `members` is queue and result in one.
        while let Some(&(body, way)) = members.get(asked) {
            asked += 1;
            let mut others: Vec<usize> = (0..system.len()).collect();
            others.retain(|other| !is_member[*other] && touch(system, body, *other, gap_angstrom));
            for other in others {
                if rng.uniform() < p {
                    let position = system.pose(body).position;
                    let step = system.boundary();
                    // Ways along contacts, not displacements from the
                    // seed: these are nearest images of neighbours.
                    let step = step.displacement(&position, &system.pose(other).position);
                    is_member[other] = true;
                    members.push((other, way + step));
                } else {
                    loose.push(other);
                }
            }
        }
        Self {
            members,
            // A loose contact to a body that joined by another is an inner one.
            outer_contacts: loose.iter().filter(|body| !is_member[**body]).count(),
        }
    }

    fn has(&self, body: usize) -> bool {
        self.members.iter().any(|(member, _)| *member == body)
    }

    fn is_narrow(&self, boundary: &Boundary) -> bool {
        let half = 0.5 * boundary.smallest_length_angstrom();
        // All pairs: a chain may close around the box though each link is short.
        let ways = || self.members.iter().map(|(_, way)| way);
        ways().all(|way| ways().all(|other| (way - other).norm() < half))
    }

    fn moved(&self, system: &System, step: &Vec3) -> Vec<(usize, Pose)> {
        self.placed(system, |pose, _| Pose {
            position: pose.position + step,
            rotation: pose.rotation,
        })
    }

    fn turned(&self, system: &System, turn: &protomer_kernel::Rotation) -> Vec<(usize, Pose)> {
        let seed = system.pose(self.members[0].0).position;
        self.placed(system, |pose, way| Pose {
            position: seed + turn * way,
            rotation: turn * pose.rotation,
        })
    }

    fn placed(&self, system: &System, place: impl Fn(&Pose, &Vec3) -> Pose) -> Vec<(usize, Pose)> {
        let mut poses = Vec::with_capacity(self.members.len());
        for (body, way) in &self.members {
            poses.push((*body, system.tidy(place(system.pose(*body), way))));
        }
        // Ascending, as the model takes groups over.
        poses.sort_unstable_by_key(|(body, _)| *body);
        poses
    }
}

fn touch(system: &System, body: usize, other: usize, gap_angstrom: f64) -> bool {
    in_contact(&system.pair(body, other), gap_angstrom)
}

fn contacts_with_rest(system: &System, group: &Group, gap_angstrom: f64) -> usize {
    let outsiders: Vec<usize> = (0..system.len()).filter(|body| !group.has(*body)).collect();
    let touching = |body: usize| {
        let contacts = outsiders.iter();
        contacts
            .filter(|other| touch(system, body, **other, gap_angstrom))
            .count()
    };
    group.members.iter().map(|(body, _)| touching(*body)).sum()
}

fn half_width_angstrom(system: &System) -> f64 {
    match system.boundary() {
        Boundary::SphereWall { radius_angstrom } => *radius_angstrom,
        Boundary::Open => 2.0 * system.hard_range_angstrom(),
        Boundary::Periodic { .. } => 0.5 * system.boundary().smallest_length_angstrom(),
    }
}
