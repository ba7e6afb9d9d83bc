//! Rigid squares, joined at their corners by massless rigid rods.
//!
//! ```text
//! Network (squares, rods)  +  State (positions, velocities, time)
//!         |                            |
//!         +------- Dynamics -----------+   one step: forces, SHAKE, RATTLE; one sparse factorisation
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`network`] | what is joined to what: data, not code |
//! | [`state`] | where everything is, and starting states |
//! | [`rods`] | the rods as constraints: lengths, gradients, J M⁻¹ Jᵀ |
//! | [`force`] | accelerations beyond those of the rods |
//! | [`dynamics`] | one step in time |
//! | [`contact`] | who touches whom, and how |
//! | [`collision`] | when bodies meet, and what follows |
//! | [`engine`] | steps with collisions, event by event |
//! | [`start`] | starting states, and how to bring positions and velocities onto the rods |
//! | [`drag`] | linear friction |
//! | [`thermostat`] | Langevin dynamics at a temperature |
//! | [`pair`] | screened charges on the squares |
//! | [`paper`] | collisions as the paper prescribes them, for comparison |
//!
//! The equations are those of Campos-Gonzalez-Angulo, Wiesehan, Ribeiro and Yuen-Zhou,
//! "Computational method for highly-constrained molecular dynamics of rigid bodies: coarse-grained
//! simulation of auxetic two-dimensional protein crystals" (2020), below "the paper", with its
//! misprints corrected.

pub mod collision;
pub mod contact;
pub mod drag;
pub mod dynamics;
pub mod engine;
pub mod force;
pub mod network;
pub mod pair;
pub mod paper;
pub mod rods;
pub mod start;
pub mod state;
pub mod thermostat;

pub use collision::replay::{FirstContact, Response, first_contact, respond};
pub use contact::Contact;
pub use drag::Drag;
pub use dynamics::Dynamics;
pub use engine::{CollisionSettings, CollisionStatistics, Engine};
pub use force::{Coherence, Force};
pub use network::{Corner, Edges, Network, Rod, Square};
pub use pair::ScreenedCharges;
pub use start::{AngularVelocities, Start, Started};
pub use state::State;
pub use thermostat::Langevin;
