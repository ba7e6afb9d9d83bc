//! Assemblies: bodies put together, and the files they are kept in.

pub mod assemble;
pub mod assembly_file;
pub mod candidates;
pub mod fluid;
pub mod ring;
