//! Counters of the moves.

use crate::moves::{Acceptance, BindingMove, Kind};
use serde::{Deserialize, Serialize};

/// Counts since the end of equilibration (or, during equilibration, since the start).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Statistics {
    /// Translations, by body type.
    pub translation: Vec<Acceptance>,
    /// Rotations, by body type.
    pub rotation: Vec<Acceptance>,
    /// Geometric cluster moves.
    pub cluster_moves: u64,
    /// Total number of bodies moved by cluster moves.
    pub cluster_bodies: u64,
    /// Moves that form and dissolve contacts.
    #[serde(default, skip_serializing_if = "BindingCounts::are_none")]
    pub binding: BindingCounts,
}

/// Counts of the moves that form and dissolve contacts, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BindingCounts {
    /// [`BindingMove::Relocation`].
    pub relocation: Acceptance,
    /// [`BindingMove::ContactTurn`].
    pub contact_turn: Acceptance,
    /// [`BindingMove::Group`].
    pub group: Acceptance,
    /// [`BindingMove::Swap`].
    pub swap: Acceptance,
}

impl BindingCounts {
    pub(crate) fn count(&mut self, kind: BindingMove, accepted: bool) {
        let counts = match kind {
            BindingMove::Relocation => &mut self.relocation,
            BindingMove::ContactTurn => &mut self.contact_turn,
            BindingMove::Group => &mut self.group,
            BindingMove::Swap => &mut self.swap,
        };
        counts.count(accepted);
    }

    fn are_none(&self) -> bool {
        *self == Self::default()
    }
}

impl Statistics {
    pub(crate) fn new(types: usize) -> Self {
        let none = vec![Acceptance::default(); types];
        Self {
            translation: none.clone(),
            rotation: none,
            cluster_moves: 0,
            cluster_bodies: 0,
            binding: BindingCounts::default(),
        }
    }

    pub(crate) fn count(&mut self, kind: Kind, body_type: usize, accepted: bool) {
        match kind {
            Kind::Translation => self.translation[body_type].count(accepted),
            Kind::Rotation => self.rotation[body_type].count(accepted),
        }
    }
}
