//! The metadata of a group, `zarr.json`: written and read as they stream by, since a set names each
//! of its samples there.

use super::layout::LAYOUT_VERSION;
use super::write::is_identifier;
use crate::atomic::write_atomically;
use crate::{IoError, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{BufReader, ErrorKind};
use std::path::{Path, PathBuf};

#[derive(Serialize, Deserialize)]
struct Metadata<A> {
    zarr_format: u64,
    node_type: String,
    attributes: A,
}

fn file(path: &Path) -> PathBuf {
    path.join("zarr.json")
}

/// Writes the metadata of a group, in the form that zarrs gives them.
pub(super) fn write(path: &Path, attributes: &impl Serialize) -> Result<()> {
    let metadata = Metadata {
        zarr_format: 3,
        node_type: "group".to_owned(),
        attributes,
    };
    write_atomically(&file(path), |file| {
        Ok(serde_json::to_writer_pretty(file, &metadata)?)
    })
}

/// Reads the attributes of a set into a type. What the type does not name is passed over and takes
/// no memory.
///
/// ```
/// use protomer_io::zarr::{SetPlan, SetWriter, attributes};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("set.zarr");
/// let [channels, implied, columns] = [vec!["shape".to_owned()], vec![], vec![]];
/// let plan = SetPlan { size: 8, channels, implied, columns, samples: 0, voxels: 0 };
/// SetWriter::create(&path, plan)?.finish(&serde_json::json!({ "probe_angstrom": 1.4 }))?;
/// let read: serde_json::Value = attributes(&path)?;
/// assert_eq!((&read["probe_angstrom"], &read["size"]), (&1.4.into(), &8.into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] if there is no set, or its attributes are damaged or not of this type.
pub fn attributes<A: DeserializeOwned>(path: &Path) -> Result<A> {
    let file = match crate::input::open(file(path)) {
        Ok(file) => file,
        Err(cause) if matches!(cause.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            let cause = "there is no zarr group here, or an unfinished one";
            return Err(not_a_set(path, cause));
        }
        Err(cause) => return Err(not_a_set(path, &cause.to_string())),
    };
    // Streamed: a set's attributes name each sample and may be large.
    let read: serde_json::Result<Metadata<A>> = serde_json::from_reader(BufReader::new(file));
    match read {
        Ok(metadata) if metadata.zarr_format == 3 && metadata.node_type == "group" => {
            Ok(metadata.attributes)
        }
        Ok(_) => Err(not_a_set(path, "it is not a group of zarr v3")),
        Err(cause) => Err(not_a_set(path, &cause.to_string())),
    }
}

pub(super) fn not_a_set(path: &Path, cause: &str) -> IoError {
    let file = file(path).display().to_string();
    let remedy = "give a set that protomer voxelize has written";
    IoError::parse(&file, 0, cause, remedy)
}

/// The attributes that describe the arrays; checked one by one, since a newer layout may give them
/// other types.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Head {
    layout_version: Value,
    size: Value,
    channels: Value,
    implied_channels: Value,
}

impl Head {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let head: Self = attributes(path)?;
        match head.layout_version.as_u64() {
            None => Err(not_a_set(path, "it is not a voxel set")),
            Some(version) if version > LAYOUT_VERSION => {
                let cause =
                    format!("layout {version} is newer than this program's, {LAYOUT_VERSION}");
                Err(not_a_set(path, &cause))
            }
            Some(_) => Ok(head),
        }
    }

    pub(super) fn size(&self, path: &Path) -> Result<usize> {
        match self.size.as_u64() {
            Some(size @ 1..=1024) => Ok(size as usize),
            _ => Err(not_a_set(path, "attribute 'size' is missing or absurd")),
        }
    }

    pub(super) fn channels(&self, path: &Path) -> Result<Vec<String>> {
        let channels = list(path, "channels", &self.channels)?;
        // Folders are named after them.
        match channels.iter().all(|name| is_identifier(name)) {
            true => Ok(channels),
            false => Err(not_a_set(path, "a channel has a name that none can have")),
        }
    }

    pub(super) fn implied(&self, path: &Path) -> Result<Vec<String>> {
        list(path, "implied_channels", &self.implied_channels)
    }
}

fn list(path: &Path, key: &str, value: &Value) -> Result<Vec<String>> {
    words(value).ok_or_else(|| not_a_set(path, &format!("there is no list '{key}'")))
}

/// A list of words.
pub(super) fn words(value: &Value) -> Option<Vec<String>> {
    let mut words = Vec::new();
    for word in value.as_array()? {
        words.push(word.as_str()?.to_owned());
    }
    Some(words)
}

/// The names of the samples, for messages; empty if the set names none.
pub(super) fn names(path: &Path) -> Vec<String> {
    #[derive(Deserialize)]
    struct Named {
        samples: Samples,
    }
    #[derive(Deserialize)]
    struct Samples {
        name: Vec<String>,
    }
    attributes(path).map_or_else(|_| Vec::new(), |named: Named| named.samples.name)
}

#[cfg(test)]
mod tests {
    use super::super::layout;
    use super::*;
    use serde_json::{Map, json};
    use zarrs::group::GroupBuilder;

    fn examples() -> [Map<String, Value>; 2] {
        let many = json!({
            "size": 32, "real": [1.0, 1e-7, 0.1, -2.5e30], "nothing": null, "words": ["a\"b\n", "é"],
            "empty": [], "none": {}, "nested": {"z": [[1], []], "a": {"b": true}},
        });
        [many, json!({"layout_version": 1})].map(|value| value.as_object().unwrap().clone())
    }

    /// The twin: what zarrs writes.
    #[test]
    fn the_metadata_are_those_that_zarrs_writes() {
        for attributes in examples() {
            let [ours, theirs] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
            write(ours.path(), &attributes).unwrap();
            let store = layout::store(theirs.path()).unwrap();
            let mut builder = GroupBuilder::new();
            let group = builder.attributes(attributes.clone()).build(store, "/");
            group.unwrap().store_metadata().unwrap();
            let text = |folder: &Path| std::fs::read_to_string(file(folder)).unwrap();
            assert_eq!(text(ours.path()), text(theirs.path()));
            let back: Map<String, Value> = super::attributes(ours.path()).unwrap();
            assert_eq!(back, attributes);
        }
    }

    #[test]
    fn what_is_no_group_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        for (text, cause) in [
            (
                "{\"zarr_format\": 3, \"node_type\": \"array\", \"attributes\": {}}",
                "not a group",
            ),
            (
                "{\"zarr_format\": 2, \"node_type\": \"group\", \"attributes\": {}}",
                "not a group",
            ),
            (
                "{\"zarr_format\": 3, \"node_type\": \"group\", \"attributes\": {}",
                "EOF",
            ),
            (
                "{\"zarr_format\": 3, \"node_type\": \"group\", \"attributes\": {}} x",
                "trailing",
            ),
        ] {
            std::fs::write(file(folder.path()), text).unwrap();
            let message = attributes::<Map<String, Value>>(folder.path()).unwrap_err();
            assert!(message.to_string().contains(cause), "{message}");
        }
    }
}
