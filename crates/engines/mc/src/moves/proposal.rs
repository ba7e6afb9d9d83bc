//! What a move of several bodies proposes, and what such moves draw.

use protomer_kernel::Pose;
use protomer_kernel::random::CounterRng;

/// New poses that a move proposes, with its allowance.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The bodies that move (ascending), with their new poses, as the system stores them.
    pub poses: Vec<(usize, Pose)>,
    /// ln(probability density of the way back / of the way there): the energy may rise by this much
    /// and by -ln u, kT.
    pub allowance_kt: f64,
    /// Whether the bodies move as one, so that they cannot come to overlap each other.
    pub is_rigid: bool,
}

/// A size between these whose logarithm is uniform: it does not depend on the state, and no step
/// needs tuning.
pub(super) fn any_size(smallest: f64, largest: f64, rng: &mut CounterRng) -> f64 {
    smallest * (largest.max(smallest) / smallest).powf(rng.uniform())
}

/// Another body than this one, each with the same probability.
pub(super) fn another(body: usize, bodies: usize, rng: &mut CounterRng) -> usize {
    let other = rng.index(bodies - 1);
    other + usize::from(other >= body)
}
