//! Frames of chunks in the HOOMD schema, whatever they hold. The first frame has the header with it;
//! readers take from there what later frames leave out.

use super::{Chunk, ChunkData, GsdFile, GsdWriter};
use crate::{IoError, Result};
use std::path::Path;

pub(super) const APPLICATION: &str = concat!("protomer ", env!("CARGO_PKG_VERSION"));
pub(super) const SCHEMA: &str = "hoomd";
const SCHEMA_VERSION: (u16, u16) = (1, 4);

/// Writes frames, and continues a file from a checkpoint.
///
/// ```
/// use protomer_io::gsd::{Chunk, ChunkData, FrameWriter, GsdFile};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("trajectory.gsd");
/// let step = |step: u64| vec![Chunk::new("configuration/step", 1, ChunkData::U64(vec![step]))];
/// let mut frames = FrameWriter::open(&path, vec![Chunk::text("particles/types", &["a"])?], 0)?;
/// for number in 0..3 {
///     frames.append(step(number))?;
/// }
/// drop(frames);
/// FrameWriter::open(&path, Vec::new(), 2)?;
/// assert_eq!(GsdFile::open(&path)?.frames(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FrameWriter {
    writer: GsdWriter,
    header: Vec<Chunk>,
}

impl FrameWriter {
    /// Opens a file and cuts it to its first `frames` frames; zero starts a new one. `header` goes with
    /// the first frame.
    ///
    /// The frames to keep are written to a new file, which then replaces the old one. So the file
    /// always equals, byte for byte, that of an uninterrupted run with the same frames.
    ///
    /// # Errors
    /// [`IoError::Parse`] if the file has fewer frames, [`IoError::File`] if the system call fails.
    pub fn open(path: &Path, header: Vec<Chunk>, frames: u64) -> Result<Self> {
        let create = |path: &Path| GsdWriter::create(path, APPLICATION, SCHEMA, SCHEMA_VERSION);
        if frames == 0 {
            let writer = create(path)?;
            return Ok(Self { writer, header });
        }
        // The frames to keep are copied: the old file stays
        // whole until the new one takes its name.
        let mut old = GsdFile::open(path)?;
        let held = old.frames();
        if held < frames {
            let file = path.display().to_string();
            let cause = format!("it holds {held} frames where the checkpoint has written {frames}");
            let remedy = "restore it, or begin the run again with --force";
            return Err(IoError::parse(&file, 0, cause, remedy));
        }
        let mut writer = create(&path.with_extension("gsd.partial"))?;
        for frame in 0..frames {
            writer.append_frame(&old.frame(frame)?)?;
        }
        // On disk before the old file loses its name.
        writer.sync()?;
        writer.rename(path)?;
        Ok(Self { writer, header })
    }

    /// Appends a frame.
    ///
    /// ```
    /// use protomer_io::gsd::{Chunk, FrameWriter, GsdFile};
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("trajectory.gsd");
    /// let mut frames = FrameWriter::open(&path, vec![Chunk::text("particles/types", &["a"])?], 0)?;
    /// frames.append(vec![Chunk::text("log/state", &["bound"])?])?;
    /// frames.append(vec![Chunk::text("log/state", &["free"])?])?;
    /// frames.sync()?;
    /// let mut file = GsdFile::open(&path)?;
    /// assert_eq!((file.frame(0)?.len(), file.frame(1)?.len()), (2, 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`GsdWriter::append_frame`].
    pub fn append(&mut self, mut chunks: Vec<Chunk>) -> Result<()> {
        // With the first frame only: readers take from there what later ones lack.
        if self.writer.frames() == 0 {
            chunks.extend(self.header.iter().cloned());
        }
        self.writer.append_frame(&chunks)
    }

    /// The frames written.
    pub fn frames(&self) -> u64 {
        self.writer.frames()
    }

    /// Returns how many frames there are when all of them are on disk. Call it before writing a
    /// checkpoint that relies on it.
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails.
    pub fn sync(&mut self) -> Result<u64> {
        self.writer.sync()?;
        Ok(self.writer.frames())
    }
}

impl Chunk {
    /// Values in rows of so many columns.
    ///
    /// ```
    /// use protomer_io::gsd::{Chunk, ChunkData};
    /// let positions = Chunk::new("particles/position", 3, ChunkData::F32(vec![0.0; 6]));
    /// assert_eq!(positions.data.len() / positions.columns as usize, 2, "two bodies");
    /// ```
    pub fn new(name: &str, columns: u32, data: ChunkData) -> Self {
        Self {
            name: name.to_owned(),
            columns,
            data,
        }
    }

    /// The strings of [`Chunk::text`]; `None` for numbers.
    ///
    /// ```
    /// use protomer_io::gsd::{Chunk, ChunkData};
    /// let names = ["short".to_owned(), "a longer one".to_owned()];
    /// assert_eq!(Chunk::text("particles/types", &names)?.texts(), Some(names.to_vec()));
    /// assert_eq!(Chunk::new("step", 1, ChunkData::U64(vec![40])).texts(), None);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn texts(&self) -> Option<Vec<String>> {
        let ChunkData::I8(letters) = &self.data else {
            return None;
        };
        let text = |row: &[i8]| {
            let bytes = row.iter().map(|letter| *letter as u8);
            let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
            String::from_utf8_lossy(&bytes).into_owned()
        };
        // Rows of equal length, filled up with zeros.
        let rows = letters.chunks(self.columns.max(1) as usize);
        Some(rows.map(text).collect())
    }

    /// Strings as rows of equal length, each terminated by a zero byte.
    ///
    /// ```
    /// use protomer_io::gsd::Chunk;
    /// let types = Chunk::text("particles/types", &["a", "dimer"])?;
    /// assert_eq!((types.columns, types.data.len()), (6, 12));
    /// assert_eq!(types.texts(), Some(vec!["a".to_owned(), "dimer".to_owned()]));
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for strings of 4 GB and more.
    pub fn text(name: &str, rows: &[impl AsRef<str>]) -> Result<Self> {
        let rows = || rows.iter().map(AsRef::as_ref);
        let longest = rows().map(str::len).max().unwrap_or(0);
        let Ok(columns) = u32::try_from(longest + 1) else {
            let cause = format!("{name} is longer than 4 GB");
            return Err(IoError::unwritable(cause, "give coarser meshes"));
        };
        let mut data = Vec::new();
        // Equal rows: the schema stores strings as a matrix of bytes.
        for row in rows() {
            data.extend(row.bytes().map(|byte| byte as i8));
            data.resize(data.len() + longest + 1 - row.len(), 0);
        }
        Ok(Self::new(name, columns, ChunkData::I8(data)))
    }
}
