//! Trajectories of rigid bodies in the HOOMD schema 1.4.
//!
//! Frame 0 holds what never changes: types, their meshes, the type of each body, charges. Every
//! frame holds step, box, positions, orientations and logged quantities; readers take the rest from
//! frame 0.

use super::{Chunk, ChunkData, FrameWriter, GsdFile};
use crate::{IoError, Result};
use protomer_kernel::name::printable;
use protomer_kernel::{Pose, TriangleMesh};
use std::path::Path;

/// A kind of body.
///
/// ```
/// use protomer_io::gsd::{ParticleType, TrajectoryHeader, trajectory::header_chunks};
/// let types = ["lysozyme", "insulin"].map(|name| ParticleType { name: name.into(), mesh: None });
/// let type_ids = vec![0, 1, 1];
/// let header = TrajectoryHeader { types: types.into(), type_ids, charges_e: vec![8.0, -2.0, -2.0] };
/// let names = header_chunks(&header)?[0].texts();
/// assert_eq!(names, Some(vec!["lysozyme".to_owned(), "insulin".to_owned()]));
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleType {
    /// Name.
    pub name: String,
    /// The shape to draw; a few thousand triangles at most serve a viewer well.
    pub mesh: Option<TriangleMesh>,
}

/// The data that is the same in every frame.
///
/// ```
/// use protomer_io::gsd::{ParticleType, TrajectoryHeader, TrajectoryWriter};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("trajectory.gsd");
/// let types = vec![ParticleType { name: "a".into(), mesh: None }];
/// let header = TrajectoryHeader { types, type_ids: vec![0, 1], charges_e: vec![6.0, 6.0] };
/// assert!(TrajectoryWriter::create(&path, &header).is_err(), "there is no second type");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryHeader {
    /// The kinds of bodies.
    pub types: Vec<ParticleType>,
    /// Index of the kind of each body.
    pub type_ids: Vec<u32>,
    /// Net charge of each body, e.
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
    /// Net charge of each body, e, where charges change (written as `log/particles/net_charge_e`); `None` for
    /// those of the header.
    pub charges_e: Option<&'a [f64]>,
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
        // The larger of all coordinates: a cube, centred on the origin as readers expect.
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
/// writer.append(&TrajectoryFrame { step: 0, box_lengths_angstrom, poses: &poses, log: &[("energy_kT", -3.5)], charges_e: None })?;
/// writer.sync()?;
/// assert_eq!(GsdFile::open(&path)?.frames(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TrajectoryWriter {
    writer: FrameWriter,
    bodies: usize,
}

impl TrajectoryWriter {
    /// Creates a trajectory without frames, replacing an existing one.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for an inconsistent header, [`IoError::File`] if
    /// the system call fails.
    pub fn create(path: &Path, header: &TrajectoryHeader) -> Result<Self> {
        Self::after(path, header, 0)
    }

    /// Continues a trajectory after its first `frames` frames; later ones, complete or not, are
    /// dropped.
    ///
    /// The file then equals, byte for byte, that of an uninterrupted run ([`FrameWriter::open`]).
    ///
    /// # Errors
    /// [`IoError::Parse`] if the file has fewer frames or belongs to other bodies; else as
    /// [`TrajectoryWriter::create`].
    pub fn resume(path: &Path, header: &TrajectoryHeader, frames: u64) -> Result<Self> {
        check_resumable(path, header, frames)?;
        Self::after(path, header, frames)
    }

    fn after(path: &Path, header: &TrajectoryHeader, frames: u64) -> Result<Self> {
        check_header(header)?;
        Ok(Self {
            writer: FrameWriter::open(path, header_chunks(header)?, frames)?,
            bodies: header.type_ids.len(),
        })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] unless there is a pose for each body; [`IoError::File`] if
    /// the system call fails.
    pub fn append(&mut self, frame: &TrajectoryFrame) -> Result<()> {
        if frame.poses.len() != self.bodies {
            let cause = format!(
                "a frame has {} poses for {} bodies",
                frame.poses.len(),
                self.bodies
            );
            return Err(IoError::unwritable(cause, "give a pose for each body"));
        }
        if let Some(charges_e) = frame.charges_e
            && charges_e.len() != self.bodies
        {
            let given = charges_e.len();
            let cause = format!("a frame has {given} charges for {} bodies", self.bodies);
            return Err(IoError::unwritable(cause, "give a charge for each body"));
        }
        self.writer.append(frame_chunks(frame))
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
        self.writer.sync().map(|_| ())
    }
}

/// Checks that the frames to keep, if any, are of these bodies.
fn check_resumable(path: &Path, header: &TrajectoryHeader, frames: u64) -> Result<()> {
    let mut old = GsdFile::open(path)?;
    if frames == 0 || old.frames() == 0 {
        return Ok(());
    }
    // The first frame holds what never changes: bodies, shapes, charges.
    for chunk in header_chunks(header)? {
        let is_same = matches!(old.chunk(0, &chunk.name), Ok(Some(stored)) if stored == chunk);
        if !is_same {
            let file = path.display().to_string();
            let cause = "it is a trajectory of other bodies";
            let remedy = "continue it with its own run";
            return Err(IoError::parse(&file, 0, cause, remedy));
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

/// Data of one frame.
///
/// ```
/// use protomer_io::gsd::{ChunkData, TrajectoryFrame, trajectory::frame_chunks};
/// let (box_lengths_angstrom, log) = ([90.0; 3], &[("energy_kT", -3.5)]);
/// let frame = TrajectoryFrame { step: 40, box_lengths_angstrom, poses: &[], log, charges_e: None };
/// let chunks = frame_chunks(&frame);
/// assert_eq!(chunks[0].data, ChunkData::U64(vec![40]));
/// assert!(chunks.iter().any(|chunk| chunk.name == "log/energy_kT"));
/// ```
pub fn frame_chunks(frame: &TrajectoryFrame) -> Vec<Chunk> {
    let [lx, ly, lz] = frame.box_lengths_angstrom.map(|length| length as f32);
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for pose in frame.poses {
        positions.extend(pose.position.iter().map(|x| *x as f32));
        orientations.extend(pose.wxyz().map(|x| x as f32));
    }
    // HOOMD's box is three lengths and three tilt factors.
    let box_and_tilts = vec![lx, ly, lz, 0.0, 0.0, 0.0];
    let bodies = frame.poses.len() as u32;
    let mut chunks = vec![
        Chunk::new("configuration/step", 1, ChunkData::U64(vec![frame.step])),
        Chunk::new("configuration/box", 1, ChunkData::F32(box_and_tilts)),
        Chunk::new("particles/N", 1, ChunkData::U32(vec![bodies])),
        Chunk::new("particles/position", 3, ChunkData::F32(positions)),
        Chunk::new("particles/orientation", 4, ChunkData::F32(orientations)),
    ];
    if let Some(charges_e) = frame.charges_e {
        // Not `particles/charge`, which the first frame has for all.
        let charges = ChunkData::F64(charges_e.to_vec());
        chunks.push(Chunk::new("log/particles/net_charge_e", 1, charges));
    }
    for (name, value) in frame.log {
        let data = ChunkData::F64(vec![*value]);
        chunks.push(Chunk::new(&format!("log/{name}"), 1, data));
    }
    chunks
}

/// Data of a trajectory that are the same in every frame.
///
/// # Errors
/// [`IoError::Unwritable`] for a name that does not fit.
pub fn header_chunks(header: &TrajectoryHeader) -> Result<Vec<Chunk>> {
    let (mut names, mut shapes) = (Vec::new(), Vec::new());
    for kind in &header.types {
        names.push(printable(&kind.name).into_owned());
        shapes.push(shape_json(kind.mesh.as_ref()));
    }
    let types = ChunkData::U32(header.type_ids.clone());
    let charges: Vec<f32> = header
        .charges_e
        .iter()
        .map(|charge| *charge as f32)
        .collect();
    Ok(vec![
        Chunk::text("particles/types", &names)?,
        Chunk::text("particles/type_shapes", &shapes)?,
        Chunk::new("particles/typeid", 1, types),
        Chunk::new("particles/charge", 1, ChunkData::F32(charges)),
    ])
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
