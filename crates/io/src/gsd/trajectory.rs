//! Trajectories of rigid bodies in the HOOMD schema 1.4.
//!
//! Frame 0 holds what never changes: types, their meshes, the type of each body, charges. Every
//! frame holds step, box, positions, orientations and logged quantities; readers take the rest from
//! frame 0.

use super::{Chunk, ChunkData, GsdFile, GsdWriter};
use crate::{IoError, Result};
use protomer_kernel::{Pose, TriangleMesh};
use std::path::Path;

const APPLICATION: &str = concat!("protomer ", env!("CARGO_PKG_VERSION"));
const SCHEMA: &str = "hoomd";
const SCHEMA_VERSION: (u16, u16) = (1, 4);

/// A kind of body.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleType {
    /// Name.
    pub name: String,
    /// The shape to draw; a few thousand triangles at most serve a viewer well.
    pub mesh: Option<TriangleMesh>,
}

/// The data that is the same in every frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryHeader {
    /// The kinds of bodies.
    pub types: Vec<ParticleType>,
    /// For each body the index of its kind.
    pub type_ids: Vec<u32>,
    /// For each body its net charge, e.
    pub charges_e: Vec<f64>,
}

/// The data that changes from frame to frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryFrame<'a> {
    /// Sweeps done.
    pub step: u64,
    /// Edge lengths of the box centred on the origin, Å. For open space give [`enclosing_box`]:
    /// readers expect the bodies inside.
    pub box_lengths_angstrom: [f64; 3],
    /// The poses of the bodies.
    pub poses: &'a [Pose],
    /// Logged quantities by name (written as `log/NAME`); every frame should have the names of the
    /// first.
    pub log: &'a [(&'a str, f64)],
}

/// The smallest centred cube that holds these positions with a margin on every side, Å.
///
/// ```
/// use protomer_io::gsd::enclosing_box;
/// use protomer_kernel::{Pose, Vec3};
/// let pose = Pose { position: Vec3::new(-30.0, 5.0, 0.0), ..Pose::identity() };
/// assert_eq!(enclosing_box(&[pose], 10.0), [80.0; 3]);
/// ```
pub fn enclosing_box(poses: &[Pose], margin_angstrom: f64) -> [f64; 3] {
    let mut reach = 0.0_f64;
    for pose in poses {
        reach = reach.max(pose.position.amax());
    }
    [2.0 * (reach + margin_angstrom); 3]
}

/// Writes a trajectory, and continues one from a checkpoint.
///
/// ```
/// use protomer_io::gsd::{GsdFile, ParticleType, TrajectoryFrame, TrajectoryHeader, TrajectoryWriter};
/// use protomer_kernel::Pose;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("trajectory.gsd");
/// let types = vec![ParticleType { name: "a".into(), mesh: None }];
/// let header = TrajectoryHeader { types, type_ids: vec![0], charges_e: vec![6.0] };
/// let mut writer = TrajectoryWriter::create(&path, &header)?;
/// let (box_lengths_angstrom, poses) = ([90.0; 3], [Pose::identity()]);
/// writer.append(&TrajectoryFrame { step: 0, box_lengths_angstrom, poses: &poses, log: &[("energy_kT", -3.5)] })?;
/// writer.sync()?;
/// assert_eq!(GsdFile::open(&path)?.frames(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TrajectoryWriter {
    writer: GsdWriter,
    header: TrajectoryHeader,
}

impl TrajectoryWriter {
    /// Creates a trajectory without frames, replacing an existing one.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for an inconsistent header, [`IoError::File`] if
    /// the system call fails.
    pub fn create(path: &Path, header: &TrajectoryHeader) -> Result<Self> {
        check_header(header)?;
        let writer = GsdWriter::create(path, APPLICATION, SCHEMA, SCHEMA_VERSION)?;
        Ok(Self {
            writer,
            header: header.clone(),
        })
    }

    /// Continues a trajectory after its first `frames` frames; later ones, complete or not, are
    /// dropped.
    ///
    /// The frames to keep are written to a new file, which then replaces the old one. So the
    /// file always equals, byte for byte, that of an uninterrupted run with the same frames.
    ///
    /// # Errors
    /// [`IoError::Parse`] if the file has fewer frames or belongs to other bodies; else as
    /// [`TrajectoryWriter::create`].
    pub fn resume(path: &Path, header: &TrajectoryHeader, frames: u64) -> Result<Self> {
        let mut old = GsdFile::open(path)?;
        check_resumable(&mut old, path, header, frames)?;
        let temporary = path.with_extension("gsd.partial");
        let mut resumed = Self::create(&temporary, header)?;
        for frame in 0..frames {
            resumed.writer.append_frame(&old.frame(frame)?)?;
        }
        resumed.sync()?;
        resumed.writer.rename(path)?;
        Ok(resumed)
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] unless there is a pose for each body; [`IoError::File`] if
    /// the system call fails.
    pub fn append(&mut self, frame: &TrajectoryFrame) -> Result<()> {
        if frame.poses.len() != self.header.type_ids.len() {
            let cause = format!(
                "a frame has {} poses for {} bodies",
                frame.poses.len(),
                self.header.type_ids.len()
            );
            return Err(IoError::unwritable(cause, "give a pose for each body"));
        }
        let mut chunks = frame_chunks(frame);
        if self.writer.frames() == 0 {
            chunks.extend(header_chunks(&self.header)?);
        }
        self.writer.append_frame(&chunks)
    }

    /// The frames written.
    pub fn frames(&self) -> u64 {
        self.writer.frames()
    }

    /// Returns when everything written is on disk. Call it before writing a checkpoint that
    /// relies on it.
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails.
    pub fn sync(&mut self) -> Result<()> {
        self.writer.sync()
    }
}

/// Checks that a file has the frames to keep and belongs to these bodies.
fn check_resumable(
    old: &mut GsdFile,
    path: &Path,
    header: &TrajectoryHeader,
    frames: u64,
) -> Result<()> {
    let refuse = |cause: &str, remedy: &str| {
        let file = path.display().to_string();
        Err(IoError::parse(&file, 0, cause, remedy))
    };
    let held = old.frames();
    if held < frames {
        let cause = format!("it holds {held} frames where the checkpoint has written {frames}");
        return refuse(&cause, "restore it, or begin the run again");
    }
    if frames == 0 {
        return Ok(());
    }
    for chunk in header_chunks(header)? {
        let is_same = matches!(old.chunk(0, &chunk.name), Ok(Some(found)) if found == chunk);
        if !is_same {
            let cause = "it is a trajectory of other bodies";
            return refuse(cause, "continue it with its own run");
        }
    }
    Ok(())
}

fn check_header(header: &TrajectoryHeader) -> Result<()> {
    let bodies = header.type_ids.len();
    let charges = header.charges_e.len();
    if charges != bodies {
        let cause = format!("there are {charges} charges for {bodies} bodies");
        return Err(IoError::unwritable(cause, "give a charge for each body"));
    }
    let types = header.types.len();
    for id in &header.type_ids {
        if *id as usize >= types {
            let cause = format!("a body is of type {id}, but there are {types} types");
            return Err(IoError::unwritable(cause, "give an index into the types"));
        }
    }
    Ok(())
}

fn frame_chunks(frame: &TrajectoryFrame) -> Vec<Chunk> {
    let [lx, ly, lz] = frame.box_lengths_angstrom.map(|length| length as f32);
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for pose in frame.poses {
        positions.extend(pose.position.iter().map(|x| *x as f32));
        orientations.extend(pose.wxyz().map(|x| x as f32));
    }
    let box_and_tilts = vec![lx, ly, lz, 0.0, 0.0, 0.0];
    let bodies = frame.poses.len() as u32;
    let mut chunks = vec![
        chunk("configuration/step", 1, ChunkData::U64(vec![frame.step])),
        chunk("configuration/box", 1, ChunkData::F32(box_and_tilts)),
        chunk("particles/N", 1, ChunkData::U32(vec![bodies])),
        chunk("particles/position", 3, ChunkData::F32(positions)),
        chunk("particles/orientation", 4, ChunkData::F32(orientations)),
    ];
    for (name, value) in frame.log {
        let data = ChunkData::F64(vec![*value]);
        chunks.push(chunk(&format!("log/{name}"), 1, data));
    }
    chunks
}

fn header_chunks(header: &TrajectoryHeader) -> Result<Vec<Chunk>> {
    let (mut names, mut shapes) = (Vec::new(), Vec::new());
    for kind in &header.types {
        names.push(kind.name.clone());
        shapes.push(shape_json(kind.mesh.as_ref()));
    }
    let types = ChunkData::U32(header.type_ids.clone());
    let charges: Vec<f32> = header
        .charges_e
        .iter()
        .map(|charge| *charge as f32)
        .collect();
    Ok(vec![
        text_chunk("particles/types", &names)?,
        text_chunk("particles/type_shapes", &shapes)?,
        chunk("particles/typeid", 1, types),
        chunk("particles/charge", 1, ChunkData::F32(charges)),
    ])
}

fn chunk(name: &str, columns: u32, data: ChunkData) -> Chunk {
    Chunk {
        name: name.to_owned(),
        columns,
        data,
    }
}

/// Strings as rows of equal length, each terminated by a zero byte.
fn text_chunk(name: &str, rows: &[String]) -> Result<Chunk> {
    let longest = rows.iter().map(String::len).max().unwrap_or(0);
    let Ok(columns) = u32::try_from(longest + 1) else {
        let cause = format!("{name} is longer than 4 GB");
        return Err(IoError::unwritable(cause, "give coarser meshes"));
    };
    let mut data = Vec::with_capacity((longest + 1) * rows.len());
    for row in rows {
        data.extend(row.bytes().map(|byte| byte as i8));
        data.resize(data.len() + longest + 1 - row.len(), 0);
    }
    Ok(chunk(name, columns, ChunkData::I8(data)))
}

/// The shape definition understood by HOOMD and OVITO; `{}` for none.
fn shape_json(mesh: Option<&TriangleMesh>) -> String {
    let Some(mesh) = mesh else {
        return "{}".to_owned();
    };
    // Coordinates are rounded to f32, which is what viewers use and is half as long to write.
    let mut vertices: Vec<[f32; 3]> = Vec::with_capacity(mesh.vertices.len());
    for v in &mesh.vertices {
        vertices.push([v.x as f32, v.y as f32, v.z as f32]);
    }
    let shape = serde_json::json!({
        "type": "Mesh", "vertices": vertices, "indices": mesh.triangles,
    });
    shape.to_string()
}
