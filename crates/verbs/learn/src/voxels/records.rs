//! What of a set is not voxels: a sample's properties, and structures that were excluded.

use super::row::Row;
use super::structure::{Properties, Reason};
use anyhow::{Context, Result};
use protomer_io::zarr::SetReader;
use serde::{Deserialize, Serialize};

/// A structure that was excluded from the set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exclusion {
    /// Manifest entry of the structure.
    #[serde(flatten)]
    pub row: Row,
    /// Reason for the exclusion.
    pub reason: Reason,
    /// Description of the reason in words.
    pub detail: String,
}

/// A sample without its voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleRecord {
    /// Manifest entry of the sample.
    pub row: Row,
    /// Occupied voxels.
    pub voxels: usize,
    /// Properties of the sample.
    pub properties: Properties,
    /// Warnings about the file of the sample.
    pub warnings: Vec<String>,
}

/// The structures left out of a set.
///
/// # Errors
/// If the attribute is damaged.
pub fn exclusions(reader: &SetReader) -> Result<Vec<Exclusion>> {
    let Some(value) = reader.attributes().get("excluded") else {
        return Ok(Vec::new());
    };
    serde_json::from_value(value.clone())
        .context("the attribute 'excluded' is damaged; make the set again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// The keys and their order belong to the format of a set.
    #[test]
    fn an_exclusion_is_one_flat_object_without_unknown_keys() {
        let text = r#"{"entry":3,"name":"a","file":"a.pdb","label":"x","cluster":"1","family":"","sha256":"00","reason":"unreadable","detail":"no atoms"}"#;
        let read: Exclusion = serde_json::from_str(text).unwrap();
        assert_eq!(serde_json::to_string(&read).unwrap(), text);
        let mut value = serde_json::to_value(&read).unwrap();
        value["colour"] = json!("red");
        let refused = serde_json::from_value::<Exclusion>(value).unwrap_err();
        assert_eq!(refused.to_string(), "unknown field `colour`");
        let mut value = serde_json::to_value(&read).unwrap();
        value.as_object_mut().unwrap().remove("cluster");
        let refused = serde_json::from_value::<Exclusion>(value).unwrap_err();
        assert_eq!(refused.to_string(), "missing field `cluster`");
    }
}
