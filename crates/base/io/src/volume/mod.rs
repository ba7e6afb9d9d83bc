//! Values on a grid as files: MRC and CCP4, OpenDX and NumPy archives.

pub mod dx;
mod grid;
pub mod mrc;
#[cfg(feature = "npz")]
mod npz;

pub use grid::Volume;
#[cfg(feature = "npz")]
pub use npz::write_volume_npz;
