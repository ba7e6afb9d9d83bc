//! Grids around proteins: electrostatic potentials, and voxels for networks.
//!
//! ```text
//! charged spheres --surface--> permittivity and salt on a grid --solve--> potential, energy
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `charged_sphere` | atoms as spheres with a charge |
//! | `grid` | points in space, and values between them |
//! | [`surface`] | what separates the solute from the solvent |
//! | `dielectric` | permittivities and ions inside and outside the surface |
//! | `ion_response` | the charge of the ions as a function of the potential |
//! | `point_charges` | sums over charges, in vectors |
//! | `edge_charges` | potential, slope and flux of charges at edges of a grid |
//! | `far_charges` | far charges seen from a small ball, as a polynomial |
//! | `screened_sum` | screened charges seen from a small box, in single precision |
//! | `vectorised` | methods compiled for several instruction sets |
//! | `charge_tree` | far charges in clusters |
//! | [`debye_huckel`] | screened charges in a uniform solvent |
//! | [`poisson_boltzmann`] | charges in, potential and solvation energy out |
//! | [`binding`] | the charge part of a binding free energy: a complex minus its parts |
//! | [`effective_charges`] | charges in salt water that stand for those inside a body |
//! | [`solvent_response`] | what two bodies that displace water and ions do to the field of each other |
//! | [`titration`] | electrostatic energies of titratable groups |
//! | [`voxels`] | a structure as a sparse cubic grid: surface, potential, hydropathy |
//!
//! Lengths are in Å, charges in e, potentials in kT/e; energies in kT, and in kJ/mol where a name
//! says so.

pub mod binding;
mod charge_tree;
mod charged_sphere;
pub mod debye_huckel;
mod dielectric;
mod edge_charges;
pub mod effective_charges;
mod error;
mod far_charges;
mod grid;
mod ion_response;
mod point_charges;
pub mod poisson_boltzmann;
mod screened_blocks;
mod screened_sum;
pub mod solvent_response;
pub mod surface;
pub mod titration;
pub mod voxels;

pub use charged_sphere::ChargedSphere;
pub use dielectric::DielectricModel;
pub use error::{FieldError, Result};
pub use grid::{Grid, ScalarField};
pub use ion_response::{IonModel, IonResponse, SaltValence};
pub use poisson_boltzmann::{BoundaryCondition, Potential, SolveSettings, solve};
pub use surface::SurfaceDefinition;
pub use voxels::PotentialModel;
