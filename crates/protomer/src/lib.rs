//! protomer: from structure files to stability curves.
//!
//! ```text
//! input --ingest--> body files --assemble--> assembly file --sweep--> run directories --> table and figure
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`bodies`] | bodies from structures, custom bodies, body files |
//! | [`assemblies`] | building and reading assemblies |
//! | [`stability`] | simulations, sweeps over salt, comparisons, benchmarks |
//! | [`export`] | back to atoms: structure files of assemblies, frames and poses |
//! | [`potential`] | the electrostatic potential around a structure |
//! | [`shapes`] | convex shapes from files and names |
//! | [`voxels`] | sparse voxel grids of structures, as samples for training |
//! | [`learning`] | networks: training, search for settings, prediction |
//! | [`lattice`] | lattices of rigid squares: runs, sweeps, pictures |
//! | [`frameworks`] | networks of rods and hinges: elastic constants, loads, figures |
//! | [`answer`] | the answer of a verb: a value, its text, its figure |
//! | [`input`], [`output_file`], [`quantity`], [`cpu_time`] | shared utilities |

pub mod answer;
pub mod assemblies;
pub mod bodies;
pub mod cpu_time;
pub mod export;
pub mod frameworks;
pub mod input;
pub mod lattice;
pub mod learning;
pub mod output_file;
pub mod potential;
pub mod quantity;
pub mod shapes;
pub mod stability;
pub mod voxels;
