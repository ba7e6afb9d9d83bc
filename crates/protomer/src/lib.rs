//! protomer: from structure files to stability curves.
//!
//! ```text
//! input --ingest--> body files --assemble--> assembly file --sweep--> run directories --> table and figure
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`bodies`] | bodies from structures, bodies of one's own, body files |
//! | [`assemblies`] | assemblies made and read |
//! | [`stability`] | simulations, sweeps over salt, comparisons, benchmarks |
//! | [`potential`] | the electrostatic potential around a structure |
//! | [`voxels`] | structures to sparse voxel grids, and these as samples |
//! | [`learning`] | networks trained, searched for, applied |
//! | [`lattice`] | lattices of rigid squares: runs, sweeps, pictures |
//! | [`frameworks`] | networks of rods and hinges: elastic constants, loads, figures |
//! | [`answer`] | what a verb answers: a value, its text, its figure |
//! | [`input`], [`output_file`], [`quantity`], [`cpu_time`] | what several of them need |

pub mod answer;
pub mod assemblies;
pub mod bodies;
pub mod cpu_time;
pub mod frameworks;
pub mod input;
pub mod lattice;
pub mod learning;
pub mod output_file;
pub mod potential;
pub mod quantity;
pub mod stability;
pub mod voxels;
