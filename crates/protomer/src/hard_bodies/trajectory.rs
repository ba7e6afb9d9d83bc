//! `trajectory.gsd`: the bodies with their shape, which OVITO draws.

use anyhow::Result;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::system::System;
use protomer_io::gsd::{Chunk, ChunkData, FrameWriter};
use serde_json::{Value, json};
use std::path::Path;

/// A trajectory that is being written.
#[derive(Debug)]
pub struct Trajectory(FrameWriter);

impl Trajectory {
    /// Opens the trajectory and cuts it to its first `frames` frames (zero starts a new one).
    ///
    /// # Errors
    /// If the file cannot be written, or holds fewer frames than the checkpoint records.
    pub fn open<const D: usize>(path: &Path, system: &System<D>, frames: u64) -> Result<Self> {
        Ok(Self(FrameWriter::open(path, header(system)?, frames)?))
    }

    /// Appends a state.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn append<const D: usize>(&mut self, sweep: u64, system: &System<D>) -> Result<()> {
        Ok(self.0.append(frame(sweep, system))?)
    }

    /// Flushes everything to disk and returns the number of frames.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn sync(&mut self) -> Result<u64> {
        Ok(self.0.sync()?)
    }
}

/// The data that is the same in every frame.
fn header<const D: usize>(system: &System<D>) -> Result<Vec<Chunk>> {
    Ok(vec![
        Chunk::new(
            "configuration/dimensions",
            1,
            ChunkData::U8(vec![D.max(2) as u8]),
        ),
        Chunk::text("particles/types", &["body"])?,
        Chunk::new("particles/typeid", 1, ChunkData::U32(vec![0; system.len()])),
        Chunk::text("particles/type_shapes", &[shape(system.body()).to_string()])?,
    ])
}

/// The shape in the words of the schema.
fn shape<const D: usize>(body: &HardBody<D>) -> Value {
    let rounding = body.rounding_radius;
    if body.is_round() {
        return json!({ "type": "Sphere", "diameter": 2.0 * rounding });
    }
    let corner = |corner: &[f64; D]| -> Vec<f32> { corner.iter().map(|x| *x as f32).collect() };
    let vertices: Vec<Vec<f32>> = body.corners.iter().map(corner).collect();
    let kind = match D {
        2 => "Polygon",
        _ => "ConvexPolyhedron",
    };
    json!({ "type": kind, "rounding_radius": rounding, "vertices": vertices })
}

/// The data that changes from frame to frame; the box is centred on the origin, and given by its lengths and
/// tilt factors.
fn frame<const D: usize>(sweep: u64, system: &System<D>) -> Vec<Chunk> {
    let space = system.space();
    let middle = space.at(&[0.5; D]);
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for (place, rotation) in system.positions().iter().zip(system.rotations()) {
        let mut centre = [0.0_f32; 3];
        for axis in 0..D {
            centre[axis] = (place[axis] - middle[axis]) as f32;
        }
        positions.extend(centre);
        let q = rotation.quaternion();
        orientations.extend([q.w, q.i, q.j, q.k].map(|x| x as f32));
    }
    // Without a depth a box is flat; a line is drawn as a strip.
    let mut numbers = vec![0.0; 6];
    for (number, length) in numbers.iter_mut().zip(space.lengths()) {
        *number = *length as f32;
    }
    for (number, factor) in numbers[3..].iter_mut().zip(space.tilt_factors()) {
        *number = factor as f32;
    }
    if D == 1 {
        numbers[1] = 2.0 * system.body().outer_radius as f32;
    }
    vec![
        Chunk::new("configuration/step", 1, ChunkData::U64(vec![sweep])),
        Chunk::new("configuration/box", 1, ChunkData::F32(numbers)),
        Chunk::new("particles/N", 1, ChunkData::U32(vec![system.len() as u32])),
        Chunk::new("particles/position", 3, ChunkData::F32(positions)),
        Chunk::new("particles/orientation", 4, ChunkData::F32(orientations)),
    ]
}
