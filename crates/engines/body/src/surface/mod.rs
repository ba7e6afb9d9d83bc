//! The solvent-excluded surface, written here and robust for every input.
//!
//! ```text
//! atoms, probe --arrangement--> SAS faces, arcs, vertices --distance--> solid --extract, remesh--> mesh --calibrate--> mesh
//!                                                         --measure---> exact area and volume ---------------^
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`arrangement`] | the solvent-accessible surface (SAS): the boundary of the union of balls of radius r + p |
//! | [`distance`] | the signed distance to the solvent-excluded surface (SES), from the nearest feature of the SAS |
//! | [`measure`] | exact areas and volumes of both surfaces, per class of patch and per shell |
//! | [`implicit`] | the seam to the triangulation: a solid as a signed distance with a projection |
//! | [`frame`] | a lattice frame that turns with the body |
//! | `extract` | a first closed mesh, by dual marching cubes on a sparse lattice |
//! | `hashing` | a fast hash |
//! | `remesh` | the same surface at a requested vertex density |
//! | `calibrate` | the exact area and volume for flat triangles |
//! | [`mesher`] | extract, remesh, calibrate, check: the mesh of any implicit solid |
//! | [`deviation`] | how far a mesh lies from the surface that it stands for |
//! | [`placed`] | a solid turned and moved |
//! | `interior` | whether a cavity is an enclosed interior that other bodies may enter |
//! | [`ses`] | atoms in, mesh and exact measures out |
//!
//! The solvent-accessible surface was defined by Lee and Richards (J. Mol. Biol. 55, 379 (1971)),
//! the solvent-excluded one by Richards (Annu. Rev. Biophys. Bioeng. 6, 151 (1977)); its three
//! classes of patch are those of Connolly (J. Appl. Cryst. 16, 548 (1983)): convex on an atom,
//! toroidal along an arc of the SAS, concave at its vertices.

pub mod arrangement;
mod calibrate;
pub mod deviation;
pub mod distance;
mod extract;
pub mod frame;
mod hashing;
pub mod implicit;
mod interior;
pub mod measure;
pub mod mesher;
pub mod placed;
mod remesh;
pub mod ses;
#[cfg(test)]
pub(crate) mod test_support;

pub use arrangement::Arrangement;
pub use calibrate::Target;
pub use deviation::Deviation;
pub use distance::SesSolid;
pub use implicit::{Ball, ImplicitSolid};
pub use interior::ball_fits_inside;
pub use measure::{Measure, SurfaceMeasure};
pub use mesher::{MeshSettings, mesh_solid, without_cavities};
pub use placed::Placed;
pub use ses::{
    ExactSurface, FilledCavities, Surface, solvent_excluded_surface, surface_without_cavities,
};
