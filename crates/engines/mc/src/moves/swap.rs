//! Two bodies of different kinds change places.

use super::proposal::Proposal;
use crate::system::System;
use protomer_kernel::random::CounterRng;

/// Gives a random body the pose of a random one of another kind, and the other way round. `None` if
/// all are of one kind, since what looks alike may change places unseen, and if no third body is near
/// either of the two, where little would change.
///
/// **Why this is exact.** The two are drawn by their kinds alone, which do not move; whether a third is
/// near depends on where origins are and not on whose they are; and changing places once more leads
/// back. The allowance is zero.
pub fn propose(system: &System, gap_angstrom: f64, rng: &mut CounterRng) -> Option<Proposal> {
    let body = rng.index(system.len());
    let is_other = |other: &usize| system.type_index(*other) != system.type_index(body);
    let others: Vec<usize> = (0..system.len()).filter(is_other).collect();
    if others.is_empty() {
        return None;
    }
    let other = others[rng.index(others.len())];
    let reach = system.hard_range_angstrom() + gap_angstrom;
    let is_near = |third: usize| {
        [body, other]
            .iter()
            .any(|member| system.pair(*member, third).displacement.norm() < reach)
    };
    let mut thirds = (0..system.len()).filter(|third| *third != body && *third != other);
    if system.len() > 2 && !thirds.any(is_near) {
        return None;
    }
    let mut poses = vec![(body, *system.pose(other)), (other, *system.pose(body))];
    poses.sort_unstable_by_key(|(body, _)| *body);
    Some(Proposal {
        poses,
        allowance_kt: 0.0,
        is_rigid: false,
    })
}
