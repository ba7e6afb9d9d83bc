//! A trajectory written again in another version of the HOOMD schema.

use super::frames::{APPLICATION, SCHEMA};
use super::{Chunk, ChunkData, GsdFile, GsdWriter};
use crate::{IoError, Result};
use std::fs::{remove_file, rename};
use std::ops::RangeInclusive;
use std::path::Path;

/// Beginning of the names of logged quantities, which have any type in every version.
const LOG: &str = "log/";
const NUMBER_OF_PARTICLES: &str = "particles/N";

/// Version of the HOOMD schema.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SchemaVersion {
    /// 1.4, with floating point numbers of 32 bits.
    V1_4,
    /// 2.0, with floating point numbers of 32 or 64 bits.
    #[default]
    V2_0,
}

impl SchemaVersion {
    /// Major and minor number.
    pub fn numbers(self) -> (u16, u16) {
        match self {
            Self::V1_4 => (1, 4),
            Self::V2_0 => (2, 0),
        }
    }

    /// A chunk as this version holds it: 1.4 has no numbers of 64 bits but those of the log.
    fn convert(self, chunk: Chunk) -> Chunk {
        match chunk.data {
            ChunkData::F64(values) if self == Self::V1_4 && !chunk.name.starts_with(LOG) => {
                let values = values.into_iter().map(|value| value as f32).collect();
                Chunk {
                    data: ChunkData::F32(values),
                    ..chunk
                }
            }
            _ => chunk,
        }
    }
}

/// Contents of a trajectory that was written again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CopiedTrajectory {
    /// Number of frames written.
    pub frames: u64,
    /// Number of frames of the source.
    pub frames_in_source: u64,
    /// Number of particles in the first frame written.
    pub particles: u64,
}

/// Writes a trajectory of any program again, in the given version of the schema; only one frame of it
/// if `frame` is given. A file in the place of `target` is replaced once the new one is complete.
///
/// ```
/// use protomer_io::gsd::{Chunk, ChunkData, FrameWriter, GsdFile, SchemaVersion, copy_trajectory};
/// # let folder = tempfile::tempdir()?;
/// let [old, new] = ["old.gsd", "new.gsd"].map(|name| folder.path().join(name));
/// let mut frames = FrameWriter::open(&old, vec![Chunk::text("particles/types", &["a"])?], 0)?;
/// for step in 0..3 {
///     frames.append(vec![Chunk::new("configuration/step", 1, ChunkData::U64(vec![step]))])?;
/// }
/// let copied = copy_trajectory(&old, &new, SchemaVersion::V2_0, Some(2))?;
/// assert_eq!((copied.frames, copied.frames_in_source), (1, 3));
/// assert_eq!(GsdFile::open(&new)?.schema(), ("hoomd", (2, 0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] if the source is no file of this schema, has no frames, or does not have the
/// frame; [`IoError::File`] if a system call fails.
pub fn copy_trajectory(
    source: &Path,
    target: &Path,
    version: SchemaVersion,
    frame: Option<u64>,
) -> Result<CopiedTrajectory> {
    let mut old = GsdFile::open(source)?;
    let error = |cause: String, remedy: &str| {
        IoError::parse(&source.display().to_string(), 0, cause, remedy)
    };
    if old.schema().0 != SCHEMA {
        let cause = format!("it has the schema {:?}", old.schema().0);
        return Err(error(cause, "give a trajectory in the HOOMD schema"));
    }
    let frames_in_source = old.frames();
    let Some(last) = frames_in_source.checked_sub(1) else {
        return Err(error("it has no frames".into(), "let the run go on"));
    };
    if let Some(frame) = frame.filter(|frame| *frame > last) {
        let cause = format!("it has no frame {frame}, only 0 to {last}");
        return Err(error(cause, "choose another frame"));
    }
    let chosen = frame.map_or(0..=last, |frame| frame..=frame);
    let partial = target.with_extension("gsd.partial");
    let copied = copy_frames(&mut old, &partial, version, chosen);
    if copied.is_err() {
        // Nothing may be left of a copy that failed; what failed is said by its own error.
        let _ = remove_file(&partial);
    }
    let copied = copied?;
    rename(&partial, target).map_err(IoError::file(target, "write"))?;
    Ok(copied)
}

fn copy_frames(
    old: &mut GsdFile,
    target: &Path,
    version: SchemaVersion,
    chosen: RangeInclusive<u64>,
) -> Result<CopiedTrajectory> {
    let mut writer = GsdWriter::create(target, APPLICATION, SCHEMA, version.numbers())?;
    let mut particles = 0;
    for number in chosen {
        let mut chunks = old.frame(number)?;
        if writer.frames() == 0 {
            complete(&mut chunks, old.frame(0)?);
            particles = number_of_particles(&chunks);
        }
        let chunks: Vec<Chunk> = chunks
            .into_iter()
            .map(|chunk| version.convert(chunk))
            .collect();
        writer.append_frame(&chunks)?;
    }
    writer.sync()?;
    Ok(CopiedTrajectory {
        frames: writer.frames(),
        frames_in_source: old.frames(),
        particles,
    })
}

/// Adds what a frame leaves to frame 0 to say, because it becomes frame 0 itself.
fn complete(chunks: &mut Vec<Chunk>, first: Vec<Chunk>) {
    for chunk in first {
        // A logged quantity belongs to its own frame only.
        let is_missing = chunks.iter().all(|own| own.name != chunk.name);
        if is_missing && !chunk.name.starts_with(LOG) {
            chunks.push(chunk);
        }
    }
}

fn number_of_particles(chunks: &[Chunk]) -> u64 {
    let number = chunks
        .iter()
        .find(|chunk| chunk.name == NUMBER_OF_PARTICLES);
    match number.map(|chunk| &chunk.data) {
        Some(ChunkData::U32(values)) => values.first().copied().unwrap_or_default().into(),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(name: &str, values: &[f64]) -> Chunk {
        Chunk::new(name, 1, ChunkData::F64(values.to_vec()))
    }

    /// A file of schema 2.0 in double precision, with what frame 1 leaves out.
    fn double(path: &Path) {
        let mut writer = GsdWriter::create(path, "another program", SCHEMA, (2, 0)).unwrap();
        let number = Chunk::new(NUMBER_OF_PARTICLES, 1, ChunkData::U32(vec![2]));
        let first = [
            number,
            chunk("configuration/box", &[10.0, 0.1]),
            chunk("log/energy", &[0.1]),
        ];
        writer.append_frame(&first).unwrap();
        let second = [chunk("particles/mass", &[0.1, 0.2])];
        writer.append_frame(&second).unwrap();
        writer.sync().unwrap();
    }

    #[test]
    fn version_1_has_single_precision_outside_the_log() {
        let folder = tempfile::tempdir().unwrap();
        let [source, target] = ["a.gsd", "b.gsd"].map(|name| folder.path().join(name));
        double(&source);
        let copied = copy_trajectory(&source, &target, SchemaVersion::V1_4, None).unwrap();
        assert_eq!((copied.frames, copied.particles), (2, 2));
        let mut file = GsdFile::open(&target).unwrap();
        assert_eq!(file.schema(), (SCHEMA, (1, 4)));
        let of_box = file.chunk(0, "configuration/box").unwrap().unwrap();
        assert_eq!(of_box.data, ChunkData::F32(vec![10.0, 0.1]));
        let energy = file.chunk(0, "log/energy").unwrap().unwrap();
        assert_eq!(energy.data, ChunkData::F64(vec![0.1]));
        let back = folder.path().join("c.gsd");
        copy_trajectory(&target, &back, SchemaVersion::V2_0, None).unwrap();
        let mut again = GsdFile::open(&back).unwrap();
        for frame in 0..2 {
            assert_eq!(again.frame(frame).unwrap(), file.frame(frame).unwrap());
        }
    }

    #[test]
    fn a_single_frame_is_complete_without_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let [source, target] = ["a.gsd", "b.gsd"].map(|name| folder.path().join(name));
        double(&source);
        let copied = copy_trajectory(&source, &target, SchemaVersion::V2_0, Some(1)).unwrap();
        assert_eq!((copied.frames, copied.frames_in_source), (1, 2));
        let mut file = GsdFile::open(&target).unwrap();
        let names: Vec<String> = file
            .frame(0)
            .unwrap()
            .into_iter()
            .map(|chunk| chunk.name)
            .collect();
        assert_eq!(
            names,
            ["particles/mass", NUMBER_OF_PARTICLES, "configuration/box"]
        );
        let message = copy_trajectory(&source, &target, SchemaVersion::V2_0, Some(2))
            .unwrap_err()
            .to_string();
        assert!(message.contains("no frame 2, only 0 to 1"), "{message}");
    }

    #[test]
    fn other_schemas_and_empty_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [source, target] = ["a.gsd", "b.gsd"].map(|name| folder.path().join(name));
        for (schema, cause) in [("own", "schema \"own\""), (SCHEMA, "no frames")] {
            GsdWriter::create(&source, "a test", schema, (1, 0)).unwrap();
            let error = copy_trajectory(&source, &target, SchemaVersion::V2_0, None).unwrap_err();
            assert!(error.to_string().contains(cause), "{error}");
            assert!(!target.exists());
        }
    }
}
