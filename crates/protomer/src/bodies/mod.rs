//! Bodies: made from structures or from a mesh of one's own, kept in files.

pub mod body_file;
pub mod fetch;
pub mod ingest;
pub mod own_body;
pub mod surface_of_file;
