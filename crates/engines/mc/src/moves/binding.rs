//! Moves that form and dissolve contacts, in both directions.
//!
//! Each proposes new poses of one or several bodies together with an allowance: the logarithm of how
//! much more often the way back is proposed than the way there. The Metropolis rule (Hastings,
//! Biometrika 57, 97 (1970)) then accepts with probability min(1, exp(allowance - ΔU)). Which kind is
//! tried does not depend on the state, so each kind may be looked at by itself.

use super::proposal::Proposal;
use super::{Acceptance, contact_turn, group, relocation, swap};
use crate::system::System;
use protomer_kernel::Boundary;
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// Declares the kinds of moves: text, variant, module with its `propose`, and, for a kind that does not make sense
/// in every system, when it does.
macro_rules! binding_moves {
    ($($(#[doc = $text:literal])* $kind:ident: $module:ident $(, if $makes_sense:expr)?;)*) => {
        /// The kinds of moves that form and dissolve contacts.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum BindingMove {
            $($(#[doc = $text])* $kind),*
        }

        impl BindingMove {
            /// All kinds.
            pub const ALL: &'static [Self] = &[$(Self::$kind),*];

            /// Whether the kind makes sense in a system; `None` if it does in every one.
            fn makes_sense(self, system: &System) -> Option<bool> {
                let condition: Option<fn(&System) -> bool> = match self {
                    $(Self::$kind => binding_moves!(@condition $($makes_sense)?)),*
                };
                condition.map(|makes_sense| makes_sense(system))
            }
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
                $(BindingMove::$kind => $module::propose(system, gap_angstrom, rng)),*
            }
        }

        /// Counts of the moves that form and dissolve contacts, by kind.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct BindingCounts {
            $(#[doc = concat!("[`BindingMove::", stringify!($kind), "`].")] pub $module: Acceptance),*
        }

        impl BindingCounts {
            pub(crate) fn count(&mut self, kind: BindingMove, accepted: bool) {
                let counts = match kind {
                    $(BindingMove::$kind => &mut self.$module),*
                };
                counts.count(accepted);
            }
        }
    };
    (@condition) => { None };
    (@condition $makes_sense:expr) => { Some($makes_sense) };
}

binding_moves! {
    /// A body goes next to another, or anywhere: [`relocation`].
    Relocation: relocation, if |system| system.len() > 1 && !matches!(system.boundary(), Boundary::Open);
    /// A body turns about a point where it touches another: [`contact_turn`].
    ContactTurn: contact_turn;
    /// Bodies in contact move as one: [`group`].
    Group: group;
    /// Two bodies of different kinds change places: [`swap`].
    Swap: swap, if |system| system.placed_types().len() > 1;
}

/// The kinds that make sense for these bodies in this space.
pub fn available(system: &System) -> Vec<BindingMove> {
    // A random number chooses by the place in this list, so the order decides results: first the kinds that always make
    // sense.
    let (mut kinds, mut conditional) = (Vec::new(), Vec::new());
    for kind in BindingMove::ALL {
        match kind.makes_sense(system) {
            None => kinds.push(*kind),
            Some(true) => conditional.push(*kind),
            Some(false) => {}
        }
    }
    kinds.extend(conditional);
    kinds
}
