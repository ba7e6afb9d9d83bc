//! The metadata of an array, `zarr.json`, held against those of the layout before zarrs sees them.
//!
//! zarrs trusts the shapes and lengths of a file: it takes memory for them, and some make it panic. So
//! an array is opened as the layout would make it, and a file that states anything else is refused.

use super::layout::Kind;
use serde_json::{Map, Value};
use std::path::Path;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

/// The longest `zarr.json` of an array: it holds the names of columns.
const LONGEST_METADATA_BYTES: u64 = 1 << 26;
/// Keys of the metadata that the layout decides apart from the shapes and the attributes.
const FIXED: [&str; 7] = [
    "zarr_format",
    "node_type",
    "data_type",
    "chunk_grid",
    "chunk_key_encoding",
    "fill_value",
    "codecs",
];

type Checked<T> = std::result::Result<T, String>;

/// The metadata as JSON.
pub(super) struct Metadata(Value);

impl Metadata {
    pub(super) fn read(file: &Path) -> Checked<Self> {
        let length = std::fs::metadata(file)
            .map_err(|cause| cause.to_string())?
            .len();
        if length > LONGEST_METADATA_BYTES {
            return Err(format!("it has {length} bytes"));
        }
        let bytes = crate::input::read(file).map_err(|cause| cause.to_string())?;
        let value = serde_json::from_slice(&bytes).map_err(|cause| cause.to_string())?;
        Ok(Self(value))
    }

    /// Elements along each dimension.
    pub(super) fn shape(&self) -> Checked<Vec<u64>> {
        lengths(&self.0["shape"]).ok_or_else(|| "there is no list 'shape' of lengths".into())
    }

    /// Elements in a file along each dimension.
    pub(super) fn per_file(&self) -> Checked<Vec<u64>> {
        let shape = &self.0["chunk_grid"]["configuration"]["chunk_shape"];
        lengths(shape).ok_or_else(|| "there is no list 'chunk_shape' of lengths".into())
    }

    pub(super) fn attributes(&self) -> Map<String, Value> {
        self.0["attributes"]
            .as_object()
            .cloned()
            .unwrap_or_default()
    }

    /// Refuses metadata other than those that the layout gives this array.
    pub(super) fn require_equal(&self, array: &Array<FilesystemStore>) -> Checked<()> {
        let ours = serde_json::to_value(array.metadata()).map_err(|cause| cause.to_string())?;
        match FIXED.iter().find(|key| ours[**key] != self.0[**key]) {
            Some(key) => Err(format!("its '{key}' is not that of a voxel set")),
            None => Ok(()),
        }
    }
}

fn lengths(value: &Value) -> Option<Vec<u64>> {
    value.as_array()?.iter().map(Value::as_u64).collect()
}

/// Refuses shapes that the files of an array cannot have.
pub(super) fn require_sizes(kind: Kind, shape: &[u64], per_file: &[u64]) -> Checked<()> {
    let dimensions = kind.dimensions();
    if shape.len() != dimensions || per_file.len() != dimensions {
        return Err(format!(
            "it has {} dimensions instead of {dimensions}",
            shape.len()
        ));
    }
    let mut elements = Some(1_u64);
    for length in per_file {
        elements = elements.and_then(|elements| elements.checked_mul(*length));
    }
    let most = kind.most_elements_per_file();
    if !elements.is_some_and(|elements| (1..=most).contains(&elements)) {
        return Err(format!(
            "its files are stated to have {per_file:?} elements"
        ));
    }
    Ok(())
}
