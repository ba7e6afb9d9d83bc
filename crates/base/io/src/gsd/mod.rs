//! Trajectories in GSD 2 files with the HOOMD schema, which OVITO, freud and the Python package
//! `gsd` open.
//!
//! The file layer, frames of named arrays, is written from the public specification
//! (<https://gsd.readthedocs.io/en/stable/file-layer.html>): [`GsdWriter`] appends, [`GsdFile`]
//! reads, [`copy_trajectory`] changes the version of the schema. [`FrameWriter`] continues a file from a checkpoint. [`trajectory`] is the schema for rigid bodies on top of it
//! (<https://gsd.readthedocs.io/en/stable/schema-hoomd.html>), and [`TrajectoryReader`] reads the
//! poses back.

mod copy;
mod format;
mod frames;
mod poses;
mod reader;
pub mod trajectory;
mod writer;

pub use copy::{CopiedTrajectory, SchemaVersion, copy_trajectory};
pub use format::{Chunk, ChunkData};
pub use frames::FrameWriter;
pub use poses::{PosedFrame, TrajectoryReader};
pub use reader::GsdFile;
pub use trajectory::{
    ParticleType, TrajectoryFrame, TrajectoryHeader, TrajectoryWriter, enclosing_box,
};
pub use writer::GsdWriter;
