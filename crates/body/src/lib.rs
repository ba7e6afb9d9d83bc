//! From structure files to rigid bodies.
//!
//! ```text
//! text --structure--> Structure --chemistry--> charges, radii, hydropathy --surface--> mesh --> Body --assembly--> poses
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`structure`] | PDB and mmCIF text to atoms; which of them are selected |
//! | [`chemistry`] | protonation, partial charges, radii, hydropathy, mutation |
//! | [`surface`] | the solvent-excluded surface as a closed mesh |
//! | [`body`] | the rigid body every engine shares |
//! | [`build`] | the whole way, from text to body |
//! | [`assembly`] | where bodies stand: copies, rings, stacks, candidates |

pub mod assembly;
pub mod body;
pub mod build;
pub mod chemistry;
mod error;
pub mod structure;
pub mod surface;

pub use body::{Body, Provenance, Residue, Site};
pub use build::{
    BodySettings, BuiltBody, Source, SurfaceSettings, build_body, build_body_of_points,
    build_body_of_selection, structure_warnings, surface_of_sites,
};
pub use error::{BodyError, Result};
