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
//! | [`potential`] | the energy of two bodies as a function of their relative pose |
//! | `orientation` | a direction and a rotation; points that fill their space evenly |
//! | `approach` | how near the second body comes along a direction |
//! | `radial` | integrals along one direction |
//! | `proposal` | a distribution of orientations that favours wells |
//! | [`estimator`] | pilot, adaptation, replicas with error bars |
//! | [`profile`] | the potential of mean force |
//! | [`wells`] | bound poses: local minima of the energy, each once |
//!
//! A few narrow wells can decide B₂, and uniform orientations miss them. A pilot therefore looks for
//! them with distributions that narrow step by step around what contributes, and the production
//! draws from a mixture of the uniform distribution and caps around the pilot's best orientations.
//! The production does not depend on itself: its estimates have no bias, however bad the pilot. Its
//! error comes from independent replicas.

mod approach;
pub mod estimator;
mod orientation;
pub mod potential;
pub mod profile;
mod proposal;
mod radial;
pub mod wells;

pub use estimator::{Estimator, PairSettings, PairThermodynamics};
pub use potential::{Charged, Hard, PairPotential};
pub use wells::BoundPose;

use crate::BodyType;
use std::sync::Arc;

/// Two bodies and what acts between them beside their hard surfaces.
#[derive(Clone)]
pub struct BodyPair {
    /// The body whose frame poses are given in.
    pub first: Arc<BodyType>,
    /// The other body.
    pub second: Arc<BodyType>,
    /// The energy.
    pub potential: Arc<dyn PairPotential>,
    /// Bodies whose surfaces are closer than this are bound, Å.
    pub contact_gap_angstrom: f64,
}
