//! protomer: from structure files to stability curves.
//!
//! ```text
//! input --ingest--> body files --assemble--> assembly file --sweep--> run directories --> table and figure
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`input`], [`fetch`] | input files: found, read, hashed; downloaded when asked for |
//! | [`ingest`], [`own_body`], [`body_file`] | bodies from structures, bodies of one's own, bodies on the disk |
//! | [`surface_of_file`] | the solvent-excluded surface alone |
//! | [`assemble`], [`assembly_file`] | assemblies made and read |
//! | [`fluid`] | bodies at random places in a box |
//! | [`potential`] | the electrostatic potential around a structure |
//! | [`interaction`] | salt, temperature, permittivity to a Yukawa potential |
//! | [`inspect`] | one state looked at |
//! | [`run`] | one simulation in its directory |
//! //! | [`sweep`], [`sweep_table`], [`sweep_figure`] | many simulations, one table, one figure |
//! | [`framework`] | networks of rods and hinges: elastic constants, loads, figures |
//! | [`compare`] | several sweeps in one figure |
//! | [`lattice`] | lattices of rigid squares: runs, sweeps, pictures |
//! | [`mod@voxelize`], [`voxel_set`] | structures to sparse voxel grids, and these as samples |
//! | [`mod@bench`], [`cpu_time`] | trial moves per CPU-second |
//! | [`energy_tables`], [`disk_cache`] | tables of certified energies, shared, bounded in memory, kept on the disk |
//! | [`train`] | networks trained in their directories |
//! | [`tune`], `tune_records`, `tune_table`, [`tune_figure`] | networks searched for: the search, what is kept of each trial, tables, figure |
//! | [`mod@predict`] | a trained network applied to a set |
//! | [`mod@report`] | a directory of results as one page |
//! | [`quantity`], [`plot`] | what several of them need |
//! | `cli` | the command line, one file per verb (feature `cli`) |

pub mod assemble;
pub mod assembly_file;
pub mod bench;
pub mod body_file;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compare;
pub mod cpu_time;
pub mod disk_cache;
pub mod energy_tables;
pub mod fetch;
pub mod fluid;
pub mod framework;
pub mod ingest;
pub mod input;
pub mod inspect;
pub mod interaction;
pub mod lattice;
pub mod own_body;
pub mod plot;
pub mod potential;
pub mod predict;
pub mod quantity;
pub mod report;
pub mod run;
pub mod surface_of_file;
pub mod sweep;
pub mod sweep_figure;
pub mod sweep_table;
pub mod train;
pub mod tune;
pub mod tune_figure;
mod tune_records;
mod tune_table;
pub mod voxel_set;
pub mod voxelize;
