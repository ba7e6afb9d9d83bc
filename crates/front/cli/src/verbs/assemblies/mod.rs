//! The verbs of assemblies.

pub mod assemble;
pub mod candidates;
