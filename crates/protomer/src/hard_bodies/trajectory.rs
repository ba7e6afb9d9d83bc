//! `trajectory.gsd`: the bodies with their shape, which OVITO draws.

use anyhow::{Result, bail};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::system::System;
use protomer_io::gsd::{Chunk, ChunkData, GsdFile, GsdWriter};
use serde_json::{Value, json};
use std::path::Path;

const APPLICATION: &str = concat!("protomer ", env!("CARGO_PKG_VERSION"));
/// HOOMD's schema.
const SCHEMA: &str = "hoomd";
const SCHEMA_VERSION: (u16, u16) = (1, 4);

/// A trajectory that is being written.
#[derive(Debug)]
pub struct Trajectory {
    writer: GsdWriter,
}

impl Trajectory {
    /// Opens the trajectory and cuts it to its first `frames` frames (zero starts a new one).
    ///
    /// # Errors
    /// If the file cannot be written, or holds fewer frames than the checkpoint records.
    pub fn open(path: &Path, frames: u64) -> Result<Self> {
        if frames == 0 {
            let writer = GsdWriter::create(path, APPLICATION, SCHEMA, SCHEMA_VERSION)?;
            return Ok(Self { writer });
        }
        let mut old = GsdFile::open(path)?;
        if old.frames() < frames {
            bail!(
                "{} holds {} frames where the checkpoint has written {frames}; restore it, or start \
                 again with --force",
                path.display(),
                old.frames()
            );
        }
        let partial = path.with_extension("gsd.partial");
        let mut writer = GsdWriter::create(&partial, APPLICATION, SCHEMA, SCHEMA_VERSION)?;
        for frame in 0..frames {
            writer.append_frame(&old.frame(frame)?)?;
        }
        writer.sync()?;
        std::fs::rename(&partial, path)?;
        Ok(Self { writer })
    }

    /// Appends a state.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn append<const D: usize>(&mut self, sweep: u64, system: &System<D>) -> Result<()> {
        let mut chunks = frame(sweep, system);
        if self.writer.frames() == 0 {
            chunks.extend(header(system));
        }
        Ok(self.writer.append_frame(&chunks)?)
    }

    /// Flushes everything to disk and returns the number of frames.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn sync(&mut self) -> Result<u64> {
        self.writer.sync()?;
        Ok(self.writer.frames())
    }
}

fn chunk(name: &str, columns: u32, data: ChunkData) -> Chunk {
    Chunk {
        name: name.to_owned(),
        columns,
        data,
    }
}

/// The data that is the same in every frame.
fn header<const D: usize>(system: &System<D>) -> Vec<Chunk> {
    vec![
        chunk("configuration/dimensions", 1, ChunkData::U8(vec![D as u8])),
        text("particles/types", "body"),
        text("particles/type_shapes", &shape(system.body()).to_string()),
    ]
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

/// The data that changes from frame to frame; the box is centred on the origin.
fn frame<const D: usize>(sweep: u64, system: &System<D>) -> Vec<Chunk> {
    let edge = system.edge();
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for (place, rotation) in system.positions().iter().zip(system.rotations()) {
        let mut centre = [0.0_f32; 3];
        for (centre, x) in centre.iter_mut().zip(place) {
            *centre = (x - 0.5 * edge) as f32;
        }
        positions.extend(centre);
        let q = rotation.quaternion();
        orientations.extend([q.w, q.i, q.j, q.k].map(|x| x as f32));
    }
    let depth = if D == 2 { 0.0 } else { edge as f32 };
    let lengths = vec![edge as f32, edge as f32, depth, 0.0, 0.0, 0.0];
    vec![
        chunk("configuration/step", 1, ChunkData::U64(vec![sweep])),
        chunk("configuration/box", 1, ChunkData::F32(lengths)),
        chunk("particles/N", 1, ChunkData::U32(vec![system.len() as u32])),
        chunk("particles/position", 3, ChunkData::F32(positions)),
        chunk("particles/orientation", 4, ChunkData::F32(orientations)),
    ]
}

/// One string, terminated by a zero byte.
fn text(name: &str, row: &str) -> Chunk {
    let mut data: Vec<i8> = row.bytes().map(|byte| byte as i8).collect();
    data.push(0);
    chunk(name, data.len() as u32, ChunkData::I8(data))
}
