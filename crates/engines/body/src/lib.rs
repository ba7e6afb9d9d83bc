//! From structure files to rigid bodies.
//!
//! ```text
//! text --structure--> Structure --chemistry--> charges, radii, hydropathy --surface--> mesh --> Body --assembly--> poses
//! ```
//!
//! ```
//! use protomer_body::{BodySettings, Source, build_body};
//! let text = "\
//! ATOM      1  N   GLY A   7      11.104   6.134  -6.504  1.00 10.00           N
//! ATOM      2  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C";
//! let source = Source { file: "glycine.pdb", sha256: "" };
//! let built = build_body("glycine", source, text.as_bytes(), &BodySettings::default())?;
//! println!("{:+.2} e, {:.0} Å³", built.body.net_charge_e(), built.body.mesh.volume_angstrom3());
//! # Ok::<(), protomer_body::BodyError>(())
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`structure`] | PDB and mmCIF text to atoms; which of them are selected |
//! | [`chemistry`] | protonation, partial charges, radii, hydropathy, mutation |
//! | [`surface`] | the solvent-excluded surface as a closed mesh |
//! | [`body`] | the rigid body every engine shares |
//! | [`build`] | from text to body in one call |
//! | [`hard_core`] | what of a body is hard |
//! | `points` | the points of a PQR file that are atoms |
//! | `warnings` | warnings about a file and the body made from it |
//! | [`crystal`] | symmetry copies that touch in a crystal |
//! | [`interface`] | area, fit and polar contacts of two bodies that touch |
//! | [`residue_contacts`] | attraction between residues by published scales; residues as beads |
//! | [`assembly`] | poses of bodies: copies, rings, stacks, candidates, random insertion |

pub mod assembly;
pub mod body;
pub mod build;
pub mod chemistry;
pub mod crystal;
mod error;
pub mod hard_core;
pub mod interface;
mod points;
pub mod residue_contacts;
pub mod structure;
pub mod surface;
mod warnings;

pub use body::{Body, Provenance, Residue, Site};
pub use build::{
    ANION_BINDING_SETTING, BodySettings, BuiltBody, Draft, Source, SurfaceSettings, build_body,
    build_body_of_points, build_body_of_selection, check_name, surface_of_sites,
};
pub use error::{BodyError, Result};
pub use hard_core::HardCore;
pub use warnings::structure_warnings;
