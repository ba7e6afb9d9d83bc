//! File formats and nothing else: readers take bytes and a name for error messages and return
//! values, writers do the reverse. Only [`gzip`], [`atomic`], [`destination`], [`zarr`] and the trajectory in
//! [`gsd`] touch the file system.
//!
//! | module | one idea |
//! |---|---|
//! | [`mesh`] | triangle meshes, a module for each format |
//! | [`points`] | spheres and point charges: `.xyzr`, x y z charge |
//! | [`pqr`] | atoms with charge and radius |
//! | [`container`] | named arrays and a JSON header in one checksummed file: bodies, checkpoints |
//! | [`gsd`] | trajectories in the HOOMD schema |
//! | [`csv`] | tables |
//! | [`npz`] | NumPy archives |
//! | [`volume`] | values on a grid: MRC, OpenDX, NPZ |
//! | [`zarr`] | sparse voxel sets as zarr v3 groups |
//! | [`input`] | files as they are opened: regular ones only |
//! | [`gzip`] | reading files that may be compressed, within a limit |
//! | [`atomic`] | files that appear only when complete; SHA-256 |
//! | [`destination`] | what a path to be written leads to: a file, a device, a pipe |
//! | [`digest`] | SHA-256, of text as it is written too |
//! | [`written`] | names as tables, pages, scripts and folders want them written |

pub mod atomic;
mod bytes;
pub mod container;
pub mod csv;
pub mod destination;
pub mod digest;
mod error;
pub mod gsd;
pub mod gzip;
pub mod input;
pub mod mesh;
#[cfg(feature = "npz")]
pub mod npz;
pub mod points;
pub mod pqr;
mod text;
pub mod volume;
pub mod written;
#[cfg(feature = "zarr")]
pub mod zarr;

pub use error::{IoError, Result};
pub use text::without_byte_order_mark;
