//! Trajectories of rigid bodies in the HOOMD schema 1.4.
//!
//! What never changes (types, their meshes, which body is of which type, charges) stands in frame
//! 0; later frames hold step, box, positions, orientations and logged quantities, and readers take
//! the rest from frame 0.

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

/// What is the same in every frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryHeader {
    /// The kinds of bodies.
    pub types: Vec<ParticleType>,
    /// For each body the index of its kind.
    pub type_ids: Vec<u32>,
    /// For each body its net charge, e.
    pub charges_e: Vec<f64>,
}

/// What changes from frame to frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryFrame<'a> {
    /// Sweeps done.
    pub step: u64,
    /// Edge lengths of the box centred on the origin, Å. For open space give [`enclosing_box`]:
    /// readers want the bodies inside.
    pub box_lengths_angstrom: [f64; 3],
    /// The poses of the bodies.
    pub poses: &'a [Pose],
    /// Logged quantities by name (written as `log/NAME`); the names of the first frame should come
    /// in every frame.
    pub log: &'a [(&'a str, f64)],
}

/// The smallest centred cube that holds these positions with a margin on every side, Å.
pub fn enclosing_box(poses: &[Pose], margin_angstrom: f64) -> [f64; 3] {
    let reach = poses
        .iter()
        .map(|pose| pose.position.amax())
        .fold(0.0, f64::max);
    [2.0 * (reach + margin_angstrom); 3]
}

/// Writes a trajectory, and continues one where a checkpoint stands.
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
    /// Creates a trajectory without frames, replacing one that is there.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for a header that contradicts itself, [`IoError::File`] if the
    /// system refuses.
    pub fn create(path: &Path, header: &TrajectoryHeader) -> Result<Self> {
        check_header(header)?;
        let writer = GsdWriter::create(path, APPLICATION, SCHEMA, SCHEMA_VERSION)?;
        Ok(Self {
            writer,
            header: header.clone(),
        })
    }

    /// Continues a trajectory after its first `frames` frames: later ones, complete or not, are
    /// dropped.
    ///
    /// The frames to keep are written to a new file, which then takes the place of the old one. So
    /// the file is always, byte for byte, what an uninterrupted run would have made of the same
    /// frames.
    ///
    /// # Errors
    /// [`IoError::Parse`] if the file has fewer frames or belongs to other bodies; else as
    /// [`TrajectoryWriter::create`].
    pub fn resume(path: &Path, header: &TrajectoryHeader, frames: u64) -> Result<Self> {
        let mut old = GsdFile::open(path)?;
        let name = path.display().to_string();
        if old.frames() < frames {
            let cause = format!(
                "it holds {} frames where the checkpoint has written {frames}",
                old.frames()
            );
            return Err(IoError::parse(
                &name,
                0,
                cause,
                "restore it, or begin the run again",
            ));
        }
        if frames > 0
            && !header_chunks(header)?
                .iter()
                .all(|chunk| stands_in(&mut old, chunk))
        {
            return Err(IoError::parse(
                &name,
                0,
                "it is a trajectory of other bodies",
                "continue it with its own run",
            ));
        }
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
    /// [`IoError::Unwritable`] unless there is a pose for each body; [`IoError::File`] if the
    /// system refuses.
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

    /// Returns when everything written is on disk; to be called before a checkpoint that counts on
    /// it is written.
    ///
    /// # Errors
    /// [`IoError::File`] if the system refuses.
    pub fn sync(&mut self) -> Result<()> {
        self.writer.sync()
    }
}

fn stands_in(old: &mut GsdFile, chunk: &Chunk) -> bool {
    matches!(old.chunk(0, &chunk.name), Ok(Some(present)) if present == *chunk)
}

fn check_header(header: &TrajectoryHeader) -> Result<()> {
    let bodies = header.type_ids.len();
    if header.charges_e.len() != bodies {
        let cause = format!(
            "there are {} charges for {bodies} bodies",
            header.charges_e.len()
        );
        return Err(IoError::unwritable(cause, "give a charge for each body"));
    }
    if let Some(id) = header
        .type_ids
        .iter()
        .find(|id| **id as usize >= header.types.len())
    {
        let cause = format!(
            "a body is of type {id}, but there are {} types",
            header.types.len()
        );
        return Err(IoError::unwritable(cause, "give an index into the types"));
    }
    Ok(())
}

fn frame_chunks(frame: &TrajectoryFrame) -> Vec<Chunk> {
    let [lx, ly, lz] = frame.box_lengths_angstrom.map(|length| length as f32);
    let positions = frame
        .poses
        .iter()
        .flat_map(|pose| pose.position.iter().map(|x| *x as f32).collect::<Vec<_>>());
    let orientations = frame
        .poses
        .iter()
        .flat_map(|pose| pose.wxyz().map(|x| x as f32));
    let mut chunks = vec![
        chunk("configuration/step", 1, ChunkData::U64(vec![frame.step])),
        chunk(
            "configuration/box",
            1,
            ChunkData::F32(vec![lx, ly, lz, 0.0, 0.0, 0.0]),
        ),
        chunk(
            "particles/N",
            1,
            ChunkData::U32(vec![frame.poses.len() as u32]),
        ),
        chunk("particles/position", 3, ChunkData::F32(positions.collect())),
        chunk(
            "particles/orientation",
            4,
            ChunkData::F32(orientations.collect()),
        ),
    ];
    chunks.extend(
        frame
            .log
            .iter()
            .map(|(name, value)| chunk(&format!("log/{name}"), 1, ChunkData::F64(vec![*value]))),
    );
    chunks
}

fn header_chunks(header: &TrajectoryHeader) -> Result<Vec<Chunk>> {
    let names: Vec<String> = header.types.iter().map(|kind| kind.name.clone()).collect();
    let shapes = header
        .types
        .iter()
        .map(|kind| shape_json(kind.mesh.as_ref()))
        .collect::<Vec<_>>();
    let charges = header
        .charges_e
        .iter()
        .map(|charge| *charge as f32)
        .collect();
    Ok(vec![
        text_chunk("particles/types", &names)?,
        text_chunk("particles/type_shapes", &shapes)?,
        chunk(
            "particles/typeid",
            1,
            ChunkData::U32(header.type_ids.clone()),
        ),
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

/// Strings as rows of equal length, each ended by a zero.
fn text_chunk(name: &str, rows: &[String]) -> Result<Chunk> {
    let columns = rows.iter().map(String::len).max().unwrap_or(0) + 1;
    let too_long =
        |_| IoError::unwritable(format!("{name} is longer than 4 GB"), "give coarser meshes");
    let mut data = Vec::with_capacity(columns * rows.len());
    for row in rows {
        data.extend(row.bytes().map(|byte| byte as i8));
        data.resize(data.len() + columns - row.len(), 0);
    }
    Ok(chunk(
        name,
        u32::try_from(columns).map_err(too_long)?,
        ChunkData::I8(data),
    ))
}

/// The shape definition that HOOMD and OVITO understand; `{}` for none.
fn shape_json(mesh: Option<&TriangleMesh>) -> String {
    let Some(mesh) = mesh else {
        return "{}".to_owned();
    };
    // Coordinates are rounded to f32, which is what viewers use and is half as long to write.
    let vertices: Vec<[f32; 3]> = mesh
        .vertices
        .iter()
        .map(|v| [v.x as f32, v.y as f32, v.z as f32])
        .collect();
    serde_json::json!({ "type": "Mesh", "vertices": vertices, "indices": mesh.triangles })
        .to_string()
}
