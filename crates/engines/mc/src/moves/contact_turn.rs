//! A body turns about a point where it touches another.

use super::proposal::{Proposal, any_size};
use crate::system::{System, Trial};
use protomer_kernel::Pose;
use protomer_kernel::random::CounterRng;
use std::f64::consts::PI;

/// The smallest of the largest angles, rad.
const SMALLEST_ANGLE_RAD: f64 = 0.05;

/// Turns a random body i about one of its vertices that touch: a vertex of its surface closer than
/// the gap to a vertex of another body. Surfaces may be nearer than their vertices; bodies that only
/// touch so are left to other moves.
///
/// **Why this is exact.** The vertex stays where it is, and so do the other bodies, so it still touches
/// after the turn: the way back is always there. Of the n vertices that touch, each is drawn with
/// probability 1/n, and a rotation is as likely as its inverse. The way back is proposed n/n' times as
/// often as the way there, where n' vertices touch after the turn: the allowance is ln(n/n').
pub fn propose(system: &System, gap_angstrom: f64, rng: &mut CounterRng) -> Option<Proposal> {
    let body = rng.index(system.len());
    let largest_angle_rad = any_size(SMALLEST_ANGLE_RAD, PI, rng);
    let pose = *system.pose(body);
    let touching = touching(&Trial { system, body, pose }, gap_angstrom);
    if touching.is_empty() {
        return None;
    }
    let mark = touching[rng.index(touching.len())];
    let vertex = system.body_type(body).surface_points.of_mark(mark);
    let pivot = pose.transform_point(&vertex);
    let turn = rng.small_rotation(largest_angle_rad);
    let trial_pose = system.tidy(Pose {
        position: pivot + turn * (pose.position - pivot),
        rotation: turn * pose.rotation,
    });
    let trial = Trial {
        system,
        body,
        pose: trial_pose,
    };
    // The pivot itself, should rounding have lost it.
    let after = self::touching(&trial, gap_angstrom).len().max(1);
    Some(Proposal {
        poses: vec![(body, trial_pose)],
        allowance_kt: (touching.len() as f64 / after as f64).ln(),
        is_rigid: true,
    })
}

/// The vertices of the trial's body that touch another body.
fn touching(trial: &Trial<'_>, gap_angstrom: f64) -> Vec<usize> {
    let system = trial.system;
    let mut marks = Vec::new();
    for partner in (0..system.len()).filter(|partner| *partner != trial.body) {
        let pair = trial.pair(partner);
        let (first, second) = pair.types();
        let reach = first.hard_radius_angstrom() + second.hard_radius_angstrom() + gap_angstrom;
        if pair.displacement.norm_squared() < reach * reach {
            system.body_type(trial.body).surface_points.mark_within(
                &system.body_type(partner).surface_points,
                &pair.partner_of(trial.body),
                gap_angstrom,
                &mut marks,
            );
        }
    }
    (0..marks.len()).filter(|mark| marks[*mark]).collect()
}
