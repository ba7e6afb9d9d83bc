//! Counters of the moves.

use crate::moves::{Acceptance, Kind};
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
    /// Total number of bodies moved by these.
    pub cluster_bodies: u64,
}

impl Statistics {
    pub(crate) fn new(types: usize) -> Self {
        let none = vec![Acceptance::default(); types];
        Self {
            translation: none.clone(),
            rotation: none,
            cluster_moves: 0,
            cluster_bodies: 0,
        }
    }

    pub(crate) fn count(&mut self, kind: Kind, body_type: usize, accepted: bool) {
        match kind {
            Kind::Translation => self.translation[body_type].count(accepted),
            Kind::Rotation => self.rotation[body_type].count(accepted),
        }
    }
}
