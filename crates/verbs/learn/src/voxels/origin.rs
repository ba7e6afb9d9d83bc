//! The parts of manifests that a set contains or lacks.

use super::records::exclusions;
use anyhow::{Context, Result};
use protomer_io::zarr::SetReader;
use protomer_results::Shard;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The part of a manifest that a set contains.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// SHA-256 of the manifest.
    pub manifest_sha256: String,
    /// Number of structures in the manifest; `None` for sets of earlier versions, which did not
    /// record it.
    pub structures: Option<usize>,
    /// Number of structures of the manifest that are in the set or excluded from it.
    pub present: usize,
    /// The parts in this set, such as `2/8`; `1/1` for all.
    pub parts: Vec<String>,
}

impl Origin {
    /// A part of a manifest with `structures` entries.
    pub fn new(manifest_sha256: &str, structures: usize, shard: Shard, present: usize) -> Self {
        let parts = vec![format!("{}/{}", shard.index, shard.of)];
        Self {
            manifest_sha256: manifest_sha256.into(),
            structures: Some(structures),
            present,
            parts,
        }
    }

    /// Number of structures of the manifest that are missing here.
    ///
    /// ```
    /// use protomer_learn_verbs::voxels::origin::Origin;
    /// use protomer_results::Shard;
    /// let part = Origin::new("0a1b", 100, Shard { index: 2, of: 8 }, 12);
    /// assert_eq!((part.missing(), &part.parts[..]), (88, &["2/8".to_owned()][..]));
    /// ```
    pub fn missing(&self) -> usize {
        self.structures
            .map_or(0, |structures| structures.saturating_sub(self.present))
    }
}

/// The manifests of a set, in order.
///
/// # Errors
/// If the attribute is damaged.
pub fn origins(reader: &SetReader) -> Result<Vec<Origin>> {
    if let Some(value) = reader.attributes().get("manifests") {
        let damaged = "the attribute 'manifests' is damaged; make the set again";
        return serde_json::from_value(value.clone()).context(damaged);
    }
    let sha256 = reader
        .attributes()
        .get("manifest_sha256")
        .and_then(Value::as_str)
        .unwrap_or_default();
    if sha256.is_empty() {
        return Ok(Vec::new());
    }
    let present = reader.len() + exclusions(reader)?.len();
    Ok(vec![Origin {
        manifest_sha256: sha256.to_owned(),
        structures: None,
        present,
        parts: Vec::new(),
    }])
}

/// The manifests of several sets, each once, in order of appearance.
///
/// ```
/// use protomer_learn_verbs::voxels::origin::{Origin, joined};
/// use protomer_results::Shard;
/// let half = |index| Origin::new("0a1b", 100, Shard { index, of: 2 }, 50);
/// let whole = joined([half(1), half(2)].into_iter());
/// assert_eq!((whole.len(), whole[0].missing(), &whole[0].parts[0][..]), (1, 0, "1/1"));
/// ```
pub fn joined(all: impl Iterator<Item = Origin>) -> Vec<Origin> {
    let mut manifests: Vec<Origin> = Vec::new();
    for next in all {
        match manifests
            .iter_mut()
            .find(|origin| origin.manifest_sha256 == next.manifest_sha256)
        {
            Some(origin) => {
                origin.structures = origin.structures.or(next.structures);
                origin.present += next.present;
                origin.parts.extend(next.parts);
            }
            None => manifests.push(next),
        }
    }
    for manifest in &mut manifests {
        // 2/16 before 10/16.
        manifest
            .parts
            .sort_by_key(|part| (part.len(), part.clone()));
        if manifest.structures.is_some() && manifest.missing() == 0 {
            manifest.parts = vec!["1/1".to_owned()];
        }
    }
    manifests
}

/// A manifest with missing parts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// SHA-256 of the manifest.
    pub manifest_sha256: String,
    /// Structures of the manifest.
    pub structures: usize,
    /// Number of structures of the manifest that are in none of the sets.
    pub missing: usize,
    /// The parts present.
    pub parts: Vec<String>,
}

impl Missing {
    /// Lists the manifests with missing parts.
    pub fn find(manifests: &[Origin]) -> Vec<Self> {
        let incomplete = manifests.iter().filter(|manifest| manifest.missing() > 0);
        let missing = incomplete.map(|manifest| Self {
            manifest_sha256: manifest.manifest_sha256.clone(),
            structures: manifest.structures.unwrap_or_default(),
            missing: manifest.missing(),
            parts: manifest.parts.clone(),
        });
        missing.collect()
    }

    /// A description in words.
    pub fn line(&self) -> String {
        let short: String = self.manifest_sha256.chars().take(12).collect();
        format!(
            "parts of the manifest with SHA-256 {short}... are missing: {} of {} structures; the parts present are \
             {}; merge all parts",
            self.missing,
            self.structures,
            self.parts.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_manifest_come_together_in_their_order() {
        let part = |index| Origin::new("0123456789abcdef", 40, Shard { index, of: 16 }, 3);
        let other = Origin::new("f", 2, Shard::WHOLE, 2);
        let manifests = joined([part(10), other.clone(), part(2)].into_iter());
        assert_eq!((manifests.len(), &manifests[1]), (2, &other));
        assert_eq!(
            (manifests[0].parts.join(" "), manifests[0].missing()),
            ("2/16 10/16".into(), 34)
        );
        let lines: Vec<String> = Missing::find(&manifests)
            .iter()
            .map(Missing::line)
            .collect();
        assert!(
            lines.len() == 1
                && lines[0].contains("0123456789ab... are missing: 34 of 40 structures"),
            "{lines:?}"
        );
        // A set of an earlier version does not record how many there are, so nothing counts as
        // missing.
        let unknown = Origin {
            structures: None,
            parts: Vec::new(),
            ..part(1)
        };
        assert_eq!(Missing::find(&joined([unknown].into_iter())), []);
    }
}
