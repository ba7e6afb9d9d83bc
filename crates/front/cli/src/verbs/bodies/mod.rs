//! The verbs of bodies.

pub mod body;
pub mod fetch;
pub mod ingest;
pub mod surface;
