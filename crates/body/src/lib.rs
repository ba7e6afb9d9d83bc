//! From structure files to rigid bodies.
//!
//! ```text
//! text --structure--> Structure --chemistry--> charges, radii, hydropathy --surface--> mesh --> Body --assembly--> poses
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`body`] | the rigid body every engine shares |

pub mod body;
mod error;

pub use body::{Body, Provenance, Residue, Site};
pub use error::{BodyError, Result};
