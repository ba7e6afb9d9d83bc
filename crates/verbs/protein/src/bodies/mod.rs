//! Bodies: made from structures or from a custom mesh, stored in files.

pub mod body_file;
pub mod chain_groups;
pub mod fetch;
pub mod folder;
mod group_arrays;
pub mod ingest;
pub mod own_body;
pub mod stream;
pub mod surface_of_file;
pub mod tables;
