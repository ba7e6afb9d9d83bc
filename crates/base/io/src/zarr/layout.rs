//! The layout shared by writer and reader: arrays, chunks, files.

use crate::{IoError, Result};
use half::f16;
use std::path::Path;
use std::sync::Arc;
use zarrs::array::codec::{
    BloscCodec, BloscCompressionLevel, BloscCompressor, BloscShuffleMode, Crc32cCodec,
};
use zarrs::array::{Array, ArrayBuilder, CodecOptions, DataType, FillValue, data_type};
use zarrs::filesystem::FilesystemStore;

/// Version of the layout that this program writes, and the newest it reads.
pub const LAYOUT_VERSION: u64 = 1;
/// Elements of a chunk, the unit of decompression: about one sample.
pub const CHUNK_ELEMENTS: u64 = 8192;
/// Upper limit for the elements in a file of an array, which limits the memory for writing: about
/// 30 samples.
const MOST_ELEMENTS_PER_FILE: u64 = 1 << 18;
/// Level of zstd.
const COMPRESSION_LEVEL: u8 = 3;

/// Name of the array of voxel numbers.
pub const INDEX: &str = "index";
/// Name of the array of the samples' first elements.
pub const OFFSETS: &str = "offsets";
/// Name of the table of sample properties.
pub const PROPERTIES: &str = "properties";

/// Index of a chunk that was never written.
pub const NO_INDEX: u32 = u32::MAX;

/// Elements per file of an array over all voxels: whole chunks, a power of two of them.
///
/// ```
/// use protomer_io::zarr::layout::elements_per_file;
/// let [few, many] = [10, 1_000_000_000].map(elements_per_file);
/// assert!(few < many && few.is_power_of_two() && many.is_power_of_two());
/// assert!(many < 1_000_000_000, "a large array has several files");
/// ```
pub fn elements_per_file(elements: u64) -> u64 {
    elements
        .clamp(CHUNK_ELEMENTS, MOST_ELEMENTS_PER_FILE)
        .next_power_of_two()
}

/// A group's folder as a store.
pub(super) fn store(path: &Path) -> Result<Arc<FilesystemStore>> {
    match FilesystemStore::new(path) {
        Ok(store) => Ok(Arc::new(store)),
        Err(cause) => {
            let folder = path.display().to_string();
            let remedy = "name the folder of a zarr group";
            Err(IoError::parse(&folder, 0, cause.to_string(), remedy))
        }
    }
}

/// The types of the arrays.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Offsets,
    Index,
    Channel,
    Properties,
}

impl Kind {
    fn data_type(self) -> DataType {
        match self {
            Kind::Offsets => data_type::int64(),
            Kind::Index => data_type::uint32(),
            Kind::Channel => data_type::float16(),
            Kind::Properties => data_type::float64(),
        }
    }

    fn fill(self) -> FillValue {
        match self {
            // Values that no voxel has: what was never written is told from what was.
            Kind::Offsets => FillValue::from(-1_i64),
            Kind::Index => FillValue::from(NO_INDEX),
            Kind::Channel => FillValue::from(f16::NAN),
            Kind::Properties => FillValue::from(f64::NAN),
        }
    }

    /// Dimensions of the array: a table, or a list.
    pub(super) fn dimensions(self) -> usize {
        match self {
            Kind::Properties => 2,
            Kind::Offsets | Kind::Index | Kind::Channel => 1,
        }
    }

    /// Elements in a file at most, also of a table with very many columns.
    pub(super) fn most_elements_per_file(self) -> u64 {
        match self {
            Kind::Properties => 1 << 24,
            Kind::Offsets | Kind::Index | Kind::Channel => MOST_ELEMENTS_PER_FILE,
        }
    }

    fn bytes(self) -> usize {
        match self {
            Kind::Channel => 2,
            Kind::Index => 4,
            Kind::Offsets | Kind::Properties => 8,
        }
    }
}

/// Chunks are written sequentially: several threads would write them in the order in which
/// they finish.
pub(super) fn in_order() -> CodecOptions {
    CodecOptions::default().with_concurrent_target(1)
}

/// Turns an error of a store into one that names the array.
pub(super) fn succeeded<T, E: std::fmt::Display>(
    array: &str,
    result: std::result::Result<T, E>,
) -> Result<T> {
    result.map_err(|cause| {
        IoError::unwritable(
            format!("array {array}: {cause}"),
            "make sure that the disk has room and may be written to",
        )
    })
}

/// An array of the layout.
pub(super) fn array(
    store: &Arc<FilesystemStore>,
    name: &str,
    kind: Kind,
    shape: &[u64],
    per_file: &[u64],
    attributes: serde_json::Map<String, serde_json::Value>,
) -> Result<Array<FilesystemStore>> {
    let failed = |cause: String| {
        let cause = format!("array {name}: {cause}");
        Err(IoError::unwritable(cause, "use another name or folder"))
    };
    let blosc = match compression(kind) {
        Ok(blosc) => blosc,
        Err(cause) => return failed(cause),
    };
    let mut builder = ArrayBuilder::new(
        shape.to_vec(),
        per_file.to_vec(),
        kind.data_type(),
        kind.fill(),
    );
    builder
        // The checksum is over the compressed bytes, so damage is found before decompression.
        .bytes_to_bytes_codecs(vec![Arc::new(blosc), Arc::new(Crc32cCodec::new())])
        .attributes(attributes);
    // A table is read as a whole and needs no chunks within its files.
    if let ([_], [per_file]) = (shape, per_file) {
        builder.subchunk_shape(vec![CHUNK_ELEMENTS.min(*per_file)]);
    }
    match builder.build(store.clone(), &format!("/{name}")) {
        Ok(array) => Ok(array),
        Err(cause) => failed(cause.to_string()),
    }
}

/// zstd with byte shuffle.
fn compression(kind: Kind) -> std::result::Result<BloscCodec, String> {
    let Ok(level) = BloscCompressionLevel::try_from(COMPRESSION_LEVEL) else {
        return Err("compression level".into());
    };
    let (compressor, shuffle) = (BloscCompressor::Zstd, BloscShuffleMode::Shuffle);
    BloscCodec::new(compressor, level, None, shuffle, Some(kind.bytes()))
        .map_err(|cause| cause.to_string())
}

/// Whether voxel numbers ascend inside a grid of `size`³ voxels.
pub(super) fn ascends_within(index: &[u32], size: usize) -> bool {
    let is_inside = index
        .last()
        .is_none_or(|last| (*last as usize) < size.pow(3));
    // The last is the largest, once they ascend.
    is_inside && index.is_sorted_by(|a, b| a < b)
}
