//! Moves that form and dissolve contacts, in both directions.
//!
//! Each proposes new poses of one or several bodies together with an allowance: the logarithm of how
//! much more often the way back is proposed than the way there. The Metropolis rule (Hastings,
//! Biometrika 57, 97 (1970)) then accepts with probability min(1, exp(allowance - ΔU)). Which kind is
//! tried does not depend on the state, so each kind may be looked at by itself.

use super::proposal::Proposal;
use super::{contact_turn, group, relocation, swap};
use crate::system::System;
use protomer_kernel::Boundary;
use protomer_kernel::random::CounterRng;

/// The kinds of moves that form and dissolve contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingMove {
    /// A body goes next to another, or anywhere: [`relocation`].
    Relocation,
    /// A body turns about a point where it touches another: [`contact_turn`].
    ContactTurn,
    /// Bodies in contact move as one: [`group`].
    Group,
    /// Two bodies of different kinds change places: [`swap`].
    Swap,
}

/// The kinds that make sense for these bodies in this space.
pub fn available(system: &System) -> Vec<BindingMove> {
    let mut kinds = vec![BindingMove::ContactTurn, BindingMove::Group];
    if system.len() > 1 && !matches!(system.boundary(), Boundary::Open) {
        kinds.push(BindingMove::Relocation);
    }
    if system.placed_types().len() > 1 {
        kinds.push(BindingMove::Swap);
    }
    kinds
}

/// Draws a move of this kind; `None` if it would leave everything where it is. Bodies are in contact
/// if their surfaces are closer than `gap_angstrom`.
pub fn propose(
    kind: BindingMove,
    system: &System,
    gap_angstrom: f64,
    rng: &mut CounterRng,
) -> Option<Proposal> {
    match kind {
        BindingMove::Relocation => relocation::propose(system, gap_angstrom, rng),
        BindingMove::ContactTurn => contact_turn::propose(system, gap_angstrom, rng),
        BindingMove::Group => group::propose(system, gap_angstrom, rng),
        BindingMove::Swap => swap::propose(system, gap_angstrom, rng),
    }
}
