//! Grids around proteins: electrostatic potentials, and voxels for networks.
//!
//! ```text
//! spheres with charges --dielectric--> permittivity and salt on a grid --operator, multigrid, solve--> potential, energy
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`grid`] | points in space, and values between them |
//! | [`surface`] | what separates the solute from the solvent |
//! | [`dielectric`] | what the medium is at every edge and point of a grid |
//! | [`debye_huckel`] | screened charges in a uniform medium: boundary values, and the cheap alternative |
//! | `point_charges` | sums over charges, in vectors |
//! | `coulomb_source` | the Coulomb potential inside as sources at the surface |
//! | `operator` | -∇·ε∇φ + k φ on a grid |
//! | `multigrid` | an approximate inverse of it |
//! | `conjugate_gradient` | the exact one |
//! | [`poisson_boltzmann`] | charges in, potential and solvation energy out |
//! | [`voxels`] | a structure as a sparse cubic grid: surface, potential, hydropathy |
//!
//! Lengths are in Å, charges in e, potentials in kT/e; energies in kT, and in kJ/mol where a name
//! says so.

mod conjugate_gradient;
mod coulomb_source;
pub mod debye_huckel;
pub mod dielectric;
mod error;
pub mod grid;
mod multigrid;
mod operator;
mod point_charges;
pub mod poisson_boltzmann;
pub mod surface;
pub mod voxels;

pub use error::{FieldError, Result};
pub use grid::{Grid, ScalarField};
pub use poisson_boltzmann::{
    Boundary, ChargedSphere, DielectricModel, Potential, SolveSettings, solve,
};
pub use surface::SurfaceDefinition;
pub use voxels::PotentialModel;
