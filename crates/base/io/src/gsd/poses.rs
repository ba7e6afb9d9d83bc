//! Reading the poses of rigid bodies from a trajectory.

use super::{Chunk, ChunkData, GsdFile};
use crate::{IoError, Result};
use protomer_kernel::{Pose, Vec3};
use std::path::{Path, PathBuf};

/// Orientation of a body that is not turned, the schema's default.
const IDENTITY_WXYZ: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

/// The poses of one frame.
///
/// ```
/// use protomer_io::gsd::{FrameWriter, TrajectoryFrame, TrajectoryReader, trajectory::frame_chunks};
/// use protomer_kernel::Pose;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("trajectory.gsd");
/// let (box_lengths_angstrom, poses) = ([90.0; 3], &[Pose::identity()]);
/// let frame = TrajectoryFrame { step: 0, box_lengths_angstrom, poses, log: &[], charges_e: None };
/// let mut writer = FrameWriter::open(&path, Vec::new(), 0)?;
/// writer.append(frame_chunks(&frame))?;
/// writer.sync()?;
/// let read = TrajectoryReader::open(&path)?.frame(0)?;
/// assert_eq!(read.tilt_factors, [0.0; 3], "the box is rectangular");
/// assert_eq!(read.type_ids, [0], "without types all bodies are of the first");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PosedFrame {
    /// Sweeps done.
    pub step: u64,
    /// Edge lengths of the box, Å; of open space, those of a cube around the bodies.
    pub box_lengths_angstrom: [f64; 3],
    /// Tilt factors of the box: xy, xz, yz.
    pub tilt_factors: [f64; 3],
    /// Index of the kind of each body.
    pub type_ids: Vec<u32>,
    /// Pose of each body, as exact as the precision of the file holds it.
    pub poses: Vec<Pose>,
}

/// Reads the poses of a trajectory, frame by frame.
///
/// ```
/// use protomer_io::gsd::{ParticleType, TrajectoryFrame, TrajectoryHeader, TrajectoryReader, TrajectoryWriter};
/// use protomer_kernel::Pose;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("trajectory.gsd");
/// let types = vec![ParticleType { name: "a".into(), mesh: None }];
/// let header = TrajectoryHeader { types, type_ids: vec![0], charges_e: vec![6.0] };
/// let mut writer = TrajectoryWriter::create(&path, &header)?;
/// let (box_lengths_angstrom, poses) = ([90.0; 3], [Pose::identity()]);
/// writer.append(&TrajectoryFrame { step: 40, box_lengths_angstrom, poses: &poses, log: &[], charges_e: None })?;
/// writer.sync()?;
/// let frame = TrajectoryReader::open(&path)?.frame(0)?;
/// assert_eq!((frame.step, frame.type_ids, frame.poses), (40, vec![0], poses.to_vec()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TrajectoryReader {
    path: PathBuf,
    file: GsdFile,
}

impl TrajectoryReader {
    /// Opens a trajectory, also one that is still being written.
    ///
    /// # Errors
    /// As [`GsdFile::open`].
    pub fn open(path: &Path) -> Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: GsdFile::open(path)?,
        })
    }

    /// The number of frames.
    pub fn frames(&self) -> u64 {
        self.file.frames()
    }

    /// The names of the kinds of bodies; none without a frame.
    ///
    /// # Errors
    /// As [`GsdFile::chunk`].
    pub fn type_names(&mut self) -> Result<Vec<String>> {
        let Some(chunk) = self.file.chunk(0, "particles/types")? else {
            return Ok(Vec::new());
        };
        let names = chunk.texts();
        names.ok_or_else(|| self.other_content("names of kinds"))
    }

    /// A frame, counted from zero.
    ///
    /// # Errors
    /// [`IoError::Parse`] if there is no such frame or it is not one of rigid bodies,
    /// [`IoError::File`] if the system call fails.
    pub fn frame(&mut self, frame: u64) -> Result<PosedFrame> {
        let frames = self.frames();
        if frame >= frames {
            let cause = match frames {
                0 => "it has no frame yet".to_owned(),
                _ => format!("it has no frame {frame}, only 0 to {}", frames - 1),
            };
            return Err(self.error(&cause, "choose another frame"));
        }
        let step = match self.chunk(frame, "configuration/step")? {
            Some(ChunkData::U64(values)) => values.first().copied().unwrap_or(0),
            _ => 0,
        };
        let space = self.numbers(frame, "configuration/box")?;
        let Some([x, y, z, tilts @ ..]) = space.as_deref() else {
            return Err(self.other_content("box"));
        };
        let box_lengths_angstrom = [*x, *y, *z];
        let tilt_factors = std::array::from_fn(|place| tilts.get(place).copied().unwrap_or(0.0));
        let Some(positions) = self.numbers(frame, "particles/position")? else {
            return Err(self.other_content("particles/position"));
        };
        let positions = positions.as_chunks::<3>().0;
        // Other programs leave out what has the default of the schema for all bodies.
        let type_ids = match self.chunk(frame, "particles/typeid")? {
            Some(ChunkData::U32(type_ids)) => type_ids,
            Some(_) => return Err(self.other_content("particles/typeid")),
            None => vec![0; positions.len()],
        };
        let orientations = self.numbers(frame, "particles/orientation")?;
        let orientations = orientations.unwrap_or_else(|| IDENTITY_WXYZ.repeat(positions.len()));
        let orientations = orientations.as_chunks::<4>().0;
        // A row for each body, or bodies and poses would be matched wrongly.
        if [positions.len(), orientations.len()] != [type_ids.len(); 2] {
            return Err(self.other_content("pose for each body"));
        }
        let poses = positions.iter().zip(orientations);
        Ok(PosedFrame {
            step,
            box_lengths_angstrom,
            tilt_factors,
            type_ids,
            poses: poses
                .map(|(position, wxyz)| Pose::from_wxyz(Vec3::from(*position), *wxyz))
                .collect(),
        })
    }

    /// Vectors of a frame, one for each body, such as `particles/velocity`; `None` where neither the frame nor the
    /// first one has them.
    ///
    /// # Errors
    /// As [`frame`](Self::frame), and for another number of components.
    pub fn vectors(&mut self, frame: u64, name: &str) -> Result<Option<Vec<Vec3>>> {
        let Some(numbers) = self.numbers(frame, name)? else {
            return Ok(None);
        };
        let (vectors, rest) = numbers.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(self.other_content(name));
        }
        Ok(Some(
            vectors.iter().map(|vector| Vec3::from(*vector)).collect(),
        ))
    }

    /// Texts of the first frame, such as `particles/type_shapes`; none where it does not have them.
    ///
    /// # Errors
    /// As [`GsdFile::chunk`].
    pub fn texts(&mut self, name: &str) -> Result<Vec<String>> {
        let Some(chunk) = self.file.chunk(0, name)? else {
            return Ok(Vec::new());
        };
        chunk.texts().ok_or_else(|| self.other_content(name))
    }

    /// Number of dimensions of a frame, 2 or 3.
    ///
    /// # Errors
    /// As [`GsdFile::chunk`].
    pub fn dimensions(&mut self, frame: u64) -> Result<usize> {
        Ok(match self.chunk(frame, "configuration/dimensions")? {
            Some(ChunkData::U8(values)) => values.first().map_or(3, |value| usize::from(*value)),
            _ => 3,
        })
    }

    /// A chunk of a frame; readers take what a frame lacks from frame 0.
    fn chunk(&mut self, frame: u64, name: &str) -> Result<Option<ChunkData>> {
        let chunk = match self.file.chunk(frame, name)? {
            Some(chunk) => Some(chunk),
            None => self.file.chunk(0, name)?,
        };
        Ok(chunk.map(|Chunk { data, .. }| data))
    }

    /// Numbers in single or, as the schema allows since its version 2, in double precision.
    fn numbers(&mut self, frame: u64, name: &str) -> Result<Option<Vec<f64>>> {
        let values: Vec<f64> = match self.chunk(frame, name)? {
            Some(ChunkData::F32(values)) => values.into_iter().map(f64::from).collect(),
            Some(ChunkData::F64(values)) => values,
            Some(_) => return Err(self.other_content(name)),
            None => return Ok(None),
        };
        if values.iter().any(|value| !value.is_finite()) {
            return Err(self.error(
                &format!("{name} has a value that is not a number"),
                "write it again",
            ));
        }
        Ok(Some(values))
    }

    fn other_content(&self, content: &str) -> IoError {
        let cause = format!("it has no {content}");
        self.error(&cause, "give a trajectory of rigid bodies")
    }

    fn error(&self, cause: &str, remedy: &str) -> IoError {
        IoError::parse(&self.path.display().to_string(), 0, cause, remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{
        GsdWriter, ParticleType, TrajectoryFrame, TrajectoryHeader, TrajectoryWriter,
    };
    use super::*;

    fn write(path: &Path, frames: &[Vec<Pose>]) {
        let types = vec![ParticleType {
            name: "a".into(),
            mesh: None,
        }];
        let header = TrajectoryHeader {
            types,
            type_ids: vec![0; 2],
            charges_e: vec![0.0; 2],
        };
        let mut writer = TrajectoryWriter::create(path, &header).unwrap();
        for (step, poses) in frames.iter().enumerate() {
            let frame = TrajectoryFrame {
                step: 10 * step as u64,
                box_lengths_angstrom: [50.0; 3],
                poses,
                log: &[],
                charges_e: None,
            };
            writer.append(&frame).unwrap();
        }
        writer.sync().unwrap();
    }

    #[test]
    fn frames_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.gsd");
        let turned = Pose::from_wxyz(Vec3::new(1.5, -2.25, 3.0), [0.5, 0.5, -0.5, 0.5]);
        let frames = [vec![Pose::identity(); 2], vec![Pose::identity(), turned]];
        write(&path, &frames);
        let mut reader = TrajectoryReader::open(&path).unwrap();
        assert_eq!(reader.frames(), 2);
        assert_eq!(reader.type_names().unwrap(), ["a"]);
        for (index, poses) in frames.iter().enumerate() {
            let frame = reader.frame(index as u64).unwrap();
            assert_eq!(
                (frame.step, frame.type_ids, frame.box_lengths_angstrom),
                (10 * index as u64, vec![0, 0], [50.0; 3])
            );
            for (found, pose) in frame.poses.iter().zip(poses) {
                assert!((found.position - pose.position).norm() < 1e-6);
                assert!(found.rotation.angle_to(&pose.rotation) < 1e-6);
            }
        }
        let message = reader.frame(2).unwrap_err().to_string();
        assert!(message.contains("no frame 2, only 0 to 1"), "{message}");
    }

    /// Frames as the package gsd 5 writes them with `precision='double'`: schema 2.0, defaults left out.
    #[test]
    fn schema_2_is_read_in_double_precision_and_with_defaults() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("double.gsd");
        let mut writer = GsdWriter::create(&path, "gsd.hoomd 5.0.1", "hoomd", (2, 0)).unwrap();
        let box_and_tilts = vec![10.0, 20.0, 30.0, 0.0, 0.0, 0.0];
        let positions = vec![0.1, 0.2, 0.3, -1.0 / 3.0, 2.0, 3.0];
        let turned = vec![1.0, 0.0, 0.0, 0.0, 0.6, 0.0, 0.8, 0.0];
        let first = [
            Chunk::new("configuration/box", 1, ChunkData::F64(box_and_tilts)),
            Chunk::new("particles/N", 1, ChunkData::U32(vec![2])),
            Chunk::new("particles/position", 3, ChunkData::F64(positions.clone())),
        ];
        let step = Chunk::new("configuration/step", 1, ChunkData::U64(vec![5]));
        let turn = Chunk::new("particles/orientation", 4, ChunkData::F64(turned));
        writer.append_frame(&first).unwrap();
        writer.append_frame(&[step, turn]).unwrap();
        writer.sync().unwrap();
        let mut reader = TrajectoryReader::open(&path).unwrap();
        let [first, second] = [0, 1].map(|frame| reader.frame(frame).unwrap());
        assert_eq!((first.step, second.step), (0, 5));
        for frame in [&first, &second] {
            let found: Vec<f64> = frame
                .poses
                .iter()
                .flat_map(|pose| pose.position.iter().copied().collect::<Vec<_>>())
                .collect();
            assert_eq!(found, positions, "not a digit is lost");
            assert_eq!(frame.type_ids, [0, 0]);
            assert_eq!(frame.box_lengths_angstrom, [10.0, 20.0, 30.0]);
        }
        assert_eq!(first.poses[1].rotation, Pose::identity().rotation);
        assert_eq!(reader.dimensions(1).unwrap(), 3);
        assert_eq!(reader.vectors(1, "particles/velocity").unwrap(), None);
        let places = reader.vectors(1, "particles/position").unwrap().unwrap();
        assert_eq!(places[1].as_slice(), &positions[3..]);
        assert!(reader.texts("particles/type_shapes").unwrap().is_empty());
        assert!((second.poses[1].wxyz()[2] - 0.8).abs() < 1e-15);
    }

    #[test]
    fn other_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("other.gsd");
        let mut writer = GsdWriter::create(&path, "a test", "own", (1, 0)).unwrap();
        let step = Chunk {
            name: "configuration/step".into(),
            columns: 1,
            data: ChunkData::U64(vec![1]),
        };
        writer.append_frame(&[step]).unwrap();
        writer.sync().unwrap();
        let error = TrajectoryReader::open(&path).unwrap().frame(0).unwrap_err();
        assert!(error.to_string().contains("rigid bodies"), "{error}");
    }
}
