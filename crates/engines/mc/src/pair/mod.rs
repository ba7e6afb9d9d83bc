//! The thermodynamics of two bodies: second virial coefficient, potential of mean force,
//! association constant, bound poses.
//!
//! ```text
//! B₂ = -½ ∫ <exp(-U) - 1> d³R = B₂(hard) - 2π <∫ (exp(-U) - 1) r² dr>,   U = ∞ at overlap,
//! ```
//!
//! R leads from the origin of the first body to that of the second, and <> averages over the
//! direction of R and over the rotation of the second body.
//!
//! ```text
//! Orientation --Approach--> contact distance --radial--> RaySample: integrals along the ray
//!      ^                                                    |
//!      `------------- Proposal <---- adapts to ------------ Estimator --> PairThermodynamics
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`potential`] | the terms of the energy of two bodies |
//! | `orientation` | a direction and a rotation; points that fill their space evenly |
//! | `approach` | how near the second body comes along a direction |
//! | `radial` | integrals along one direction |
//! | `proposal` | a distribution of orientations that favours wells |
//! | [`estimator`] | pilot, adaptation, replicas with error bars |
//! | `replicas` | a mean over replicas and its error |
//! | [`profile`] | the potential of mean force |
//! | `region` | poses around one, and coordinates for them |
//! | [`bound_state`] | the association constant of one bound pose |
//! | [`tied`] | the potential of mean force of two bodies tied at a corner |
//! | [`wells`] | bound poses: local minima of the energy, each once |
//! | [`deep_wells`] | wells that decide the association constant, integrated one by one, and the sampled rest |
//!
//! A few narrow wells can decide B₂, and uniform orientations miss them. A pilot therefore looks for
//! them with distributions that narrow step by step around what contributes, and the production
//! draws from a mixture of the uniform distribution and caps around the pilot's best orientations.
//! The production does not depend on itself: its estimates have no bias, however bad the pilot. Its
//! error comes from independent replicas.

mod approach;
pub mod bound_state;
pub mod deep_wells;
pub mod estimator;
mod orientation;
pub mod potential;
pub mod profile;
mod proposal;
mod radial;
pub(crate) mod region;
mod replicas;
pub mod tied;
pub mod wells;

pub use crate::energy::terms::{EnergyParts, PairParts, PairPotential, Term, Terms};
pub use bound_state::{BoundState, BoundStateSettings};
pub use deep_wells::{Well, WellIntegral, Wells};
pub use estimator::{Estimator, PairSettings, PairThermodynamics};
pub use potential::{Charged, Contacts};
pub use wells::BoundPose;

use crate::BodyType;
use protomer_kernel::Pose;
use protomer_kernel::overlap::{comes_within, overlaps};
use protomer_kernel::pose::RelativePose;
use std::sync::Arc;

/// Two bodies and what acts between them in addition to their hard surfaces.
///
/// ```
/// use protomer_kernel::{Pose, potential::Yukawa};
/// use protomer_mc::BodyType;
/// use protomer_mc::pair::{BodyPair, Charged, Core, Terms};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let ion = Arc::new(BodyType::new("cube", &mesh, &[(Vec3::zeros(), 2.0)])?);
/// let yukawa = Yukawa::uncut(7.0, 0.1)?;
/// let charges = Charged::new(yukawa, &ion.charges, &ion.charges)?;
/// let pair = BodyPair {
///     first: Arc::clone(&ion),
///     second: ion,
///     potential: Terms(vec![Arc::new(charges)]),
///     core: Core::Surfaces,
///     contact_gap_angstrom: 5.0,
/// };
/// let apart = Pose { position: Vec3::new(0.0, 0.0, 20.0), ..Pose::identity() };
/// assert!((pair.energy_kt(&apart) - 4.0 * yukawa.energy_kt(20.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct BodyPair {
    /// The body whose frame poses are given in.
    pub first: Arc<BodyType>,
    /// The other body.
    pub second: Arc<BodyType>,
    /// Energy in addition to the surfaces.
    pub potential: Terms,
    /// Core that keeps the bodies apart.
    pub core: Core,
    /// Bodies whose surfaces are closer than this are bound, Å.
    pub contact_gap_angstrom: f64,
}

/// Cores that keep two bodies apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Core {
    /// Hard surfaces.
    #[default]
    Surfaces,
    /// The energy alone: that of beads with cores.
    Energy,
}

/// Energy beyond which bodies count as overlapping if only their energy keeps them apart, kT: exp(-30) is 1e-13.
const CORE_ENERGY_KT: f64 = 30.0;

impl BodyPair {
    /// Energy in addition to the hard surfaces, kT, of a pose of the second body in the frame of the first.
    pub fn energy_kt(&self, pose: &Pose) -> f64 {
        self.potential.energy_kt(&RelativePose::from(pose))
    }

    /// Whether the bodies overlap at a pose of the second in the frame of the first.
    fn excludes(&self, second_in_first: &RelativePose) -> bool {
        match self.core {
            Core::Surfaces => overlaps(&self.first.shape, &self.second.shape, second_in_first),
            Core::Energy => self.potential.energy_kt(second_in_first) > CORE_ENERGY_KT,
        }
    }

    /// Whether the two surfaces are closer than the contact gap.
    fn is_in_contact(&self, second_in_first: &RelativePose) -> bool {
        let (first, second) = (&self.first.shape, &self.second.shape);
        comes_within(first, second, second_in_first, self.contact_gap_angstrom)
    }

    /// The distance of the origins beyond which nothing overlaps, Å.
    fn outer_distance_angstrom(&self) -> f64 {
        let surfaces = self.first.hard_radius_angstrom() + self.second.hard_radius_angstrom();
        match self.core {
            Core::Surfaces => surfaces,
            Core::Energy => self.potential.reach_angstrom(CORE_ENERGY_KT),
        }
    }
}
