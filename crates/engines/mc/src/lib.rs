//! Hard-particle Monte Carlo with screened charges and geometric cluster moves.
//!
//! ```text
//! Body --BodyType--> System (types, poses, boundary) --Simulation--> observables, checkpoints
//!                                                         |
//!                    moves propose --> hard bodies veto --> the energy model decides
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`body_type`] | what the engine knows about one kind of body: shape and charges |
//! | [`beads`] | the residues of a body, laid out for vector units |
//! | [`charges`] | the charges of a body, laid out for vector units |
//! | [`system`] | the bodies and their poses |
//! | [`energy`] | the seam: a model keeps the pair energies and decides; the direct sum is one such model |
//! | [`contributions`] | what each residue, and each pair of residues, contributes to the energy |
//! | [`depletants`] | penetrable hard spheres that push bodies together, without being there |
//! | [`desolvation`] | what charges lose where another body displaces solvent |
//! | [`solvent_response`] | what the salt water that two bodies displace does to the field of each other |
//! | [`hard`] | hard-body overlap, cheapest test first |
//! | [`moves`] | trial moves of one body, geometric cluster moves, moves that form and dissolve contacts, step sizes |
//! | [`surface_points`] | the vertices of a surface, about which bodies turn |
//! | [`observables`] | radius of gyration, contacts between surfaces, clusters |
//! | [`pair`] | two bodies: virial coefficient, mean force, association, bound poses |
//! | [`parts`] | how much of an assembly there is: its connected parts, and mass action over them |
//! | `nested` | nested sampling: the integral of a Boltzmann factor |
//! | `prefetch` | requests for values ahead of their use |
//! | [`settings`] | the settings of a simulation |
//! | [`simulation`] | the loop |
//! | [`exchange`] | a ladder of simulations that swap their states |
//! | [`reweighting`] | one answer from the frames of several simulations (MBAR) |
//! | [`scatter`] | bodies at random places |
//! | [`scattering`] | what light and X-rays see: S(q), P(q), clusters, hydrodynamic radii |
//! | [`checkpoint`] | the state from which a run continues bit for bit |
//! | [`statistics`] | counters of the moves |
//!
//! Lengths are in Å, energies in kT, charges in elementary charges.
//!
//! ```
//! use protomer_kernel::{Boundary, Pose, Rotation, TriangleMesh, Vec3, potential::Yukawa};
//! use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
//! use std::{ops::ControlFlow, sync::Arc};
//!
//! let mesh = TriangleMesh::tetrahedron(5.0);
//! let kind = |name, charge| BodyType::new(name, &mesh, &[(Vec3::zeros(), charge)]).map(Arc::new);
//! let pose = |x| Pose { position: Vec3::new(x, 0.0, 0.0), rotation: Rotation::identity() };
//! let system = System::new(vec![kind("a", 3.0)?, kind("b", -3.0)?], &[(0, pose(-8.0)), (1, pose(8.0))], Boundary::Open)?;
//!
//! let settings = Settings::new(Interaction::YukawaDirect(Yukawa::new(7.0, 1.0 / 9.6, 48.0)?));
//! let mut simulation = Simulation::new(system.clone(), settings, 1, 0)?;
//! simulation.run_until(100, &mut |_| ControlFlow::Continue(()))?;
//!
//! // A continued run equals the uninterrupted one.
//! let mut continued = Simulation::resume(system, simulation.checkpoint())?;
//! simulation.run_until(200, &mut |_| ControlFlow::Continue(()))?;
//! continued.run_until(200, &mut |_| ControlFlow::Continue(()))?;
//! assert_eq!(simulation.observables(), continued.observables());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod beads;
pub mod body_type;
pub mod charges;
pub mod checkpoint;
pub mod contributions;
pub mod depletants;
pub mod desolvation;
pub mod energy;
mod error;
pub mod exchange;
pub mod hard;
pub mod moves;
mod neighbours;
mod nested;
pub mod observables;
pub mod pair;
pub mod parts;
mod prefetch;
pub mod reweighting;
pub mod scatter;
pub mod scattering;
pub mod settings;
pub mod simulation;
pub mod solvent_response;
mod sparse_rows;
pub mod statistics;
pub mod surface_points;
pub mod system;
#[cfg(test)]
mod test_support;
pub mod titratable;

pub use body_type::BodyType;
pub use checkpoint::Checkpoint;
pub use depletants::Depletants;
pub use error::{McError, Result};
pub use exchange::Ladder;
pub use observables::Observables;
pub use settings::{DEFAULT_CONTACT_GAP_ANGSTROM, Interaction, Settings};
pub use simulation::{Outcome, Simulation};
pub use statistics::Statistics;
pub use system::System;
