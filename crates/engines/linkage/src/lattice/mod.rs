//! Rigid squares, joined at their corners by massless rigid rods.
//!
//! ```text
//! Plan --> Network (squares, rods)  +  State (positions, velocities, time) <-- Start
//!                 |                            |
//!                 +---- Dynamics, Engine ------+   forces, SHAKE, RATTLE; one sparse factorisation
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`network`] | what is joined to what: data, not code |
//! | [`cell`] | the periodic cell, fixed or flexible |
//! | [`plan`] | a lattice with its defects |
//! | [`square_of_body`] | the square that stands for a body |
//! | [`state`] | where everything is and how it moves |
//! | [`start`] | starting states |
//! | [`projector`] | bringing positions and velocities onto the rods |
//! | [`rods`] | the rods as constraints: lengths, gradients, J M⁻¹ Jᵀ |
//! | [`force`] | accelerations beyond those of the rods |
//! | [`dynamics`] | one step in time |
//! | [`time_step`] | a time step that keeps the energy |
//! | [`contact`] | who touches whom, and how |
//! | [`collision`] | when bodies meet, and what follows |
//! | [`engine`] | steps with collisions, event by event |
//! | [`drag`] | linear friction |
//! | [`thermostat`] | Langevin dynamics at a temperature |
//! | [`pair`] | screened charges on the squares |
//! | [`angle_potential`] | potentials of the angle between joined squares and of the opening |
//! | [`load`] | a stress on a lattice |
//! | [`mover`] | forces, collisions and heat bath of a run in one |
//! | [`paper`] | collisions as the paper prescribes them, for comparison |
//!
//! Each state has one factorisation L D Lᵀ for its rods. It serves RATTLE, the start of the
//! multipliers, the chord iterations of SHAKE and the complementarity problem of the contacts. The
//! rods stay exact to rounding.
//!
//! The equations are those of Campos-Gonzalez-Angulo, Wiesehan, Ribeiro and Yuen-Zhou,
//! "Computational method for highly-constrained molecular dynamics of rigid bodies: coarse-grained
//! simulation of auxetic two-dimensional protein crystals" (2020), below "the paper", with its
//! misprints corrected.

pub mod angle_potential;
pub mod cell;
pub mod collision;
pub mod contact;
pub mod drag;
pub mod dynamics;
pub mod engine;
pub mod force;
pub mod load;
pub mod mover;
pub mod network;
pub mod pair;
pub mod paper;
pub mod plan;
pub mod projector;
pub mod rods;
pub mod square_of_body;
pub mod start;
pub mod state;
pub mod thermostat;
pub mod time_step;

pub use angle_potential::{JointPotential, OpeningPotential};
pub use cell::{Cell, CellKind};
pub use collision::replay::{FirstContact, Response, first_contact, respond};
pub use contact::Contact;
pub use drag::Drag;
pub use dynamics::Dynamics;
pub use engine::{CollisionSettings, CollisionStatistics, Engine};
pub use force::{Coherence, Force};
pub use load::{Load, Stress};
pub use mover::{Charges, Meetings, Motion, Mover, Screening};
pub use network::{Corner, Edges, Network, Rod, Square};
pub use pair::ScreenedCharges;
pub use plan::{ListedRod, OtherSquare, Plan};
pub use projector::Projector;
pub use start::{Start, StartVelocities, Started};
pub use state::State;
pub use thermostat::Langevin;
