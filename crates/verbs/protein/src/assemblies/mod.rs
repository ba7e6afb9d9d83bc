//! Assemblies of bodies, and the files that store them.

pub mod assemble;
pub mod assembly_file;
pub mod candidates;
pub mod fluid;
pub mod ring;
pub mod search;
pub mod structure;
