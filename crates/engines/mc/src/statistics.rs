//! Counters of the moves.

pub use crate::moves::binding::BindingCounts;
use crate::moves::{Acceptance, Kind};
use serde::{Deserialize, Serialize};

/// Counts since the end of equilibration (or, during equilibration, since the start).
///
/// ```
/// use protomer_kernel::{Boundary, Pose};
/// use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
/// use std::ops::ControlFlow;
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// let system = System::new(vec![cube], &[(0, Pose::identity())], Boundary::Open)?;
/// let mut simulation = Simulation::new(system, Settings::new(Interaction::HardOnly), 1, 0)?;
/// simulation.run_until(20, &mut |_| ControlFlow::Continue(()))?;
/// let statistics = simulation.statistics();
/// assert_eq!(statistics.translation[0].trials + statistics.rotation[0].trials, 20);
/// assert_eq!(statistics.translation[0].rate(), Some(1.0), "a body alone may go anywhere");
/// # Ok::<(), protomer_mc::McError>(())
/// ```
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
    #[serde(default, skip_serializing_if = "is_none")]
    pub binding: BindingCounts,
    /// Moves that change protons.
    #[serde(default, skip_serializing_if = "is_none")]
    pub protons: Acceptance,
}

fn is_none<T: Default + PartialEq>(counts: &T) -> bool {
    *counts == T::default()
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
            protons: Acceptance::default(),
        }
    }

    pub(crate) fn count(&mut self, kind: Kind, body_type: usize, accepted: bool) {
        match kind {
            Kind::Translation => self.translation[body_type].count(accepted),
            Kind::Rotation => self.rotation[body_type].count(accepted),
        }
    }
}
