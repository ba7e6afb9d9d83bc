//! Whether the voxels of a set match those that a network was trained on.

use anyhow::{Result, bail};
use protomer_learn::SampleSource;
use protomer_learn::training::ModelCard;
use serde::Serialize;
use serde_json::{Map, Value};
use std::path::Path;

/// Settings that do not change the meaning of a voxel: the seed of the random rotations, and the
/// criterion for excluding structures.
const INDIFFERENT: [&str; 2] = ["seed", "most_incomplete"];

/// A setting in which the voxels of a set differ from those of the training.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The setting of `protomer voxelize`.
    pub setting: String,
    /// Value of the setting in the training.
    pub trained_on: Value,
    /// Value of the setting in this set.
    pub set: Value,
}

/// Lists how the voxels of a set differ from those of the training, if the network can still be
/// applied. If the model does not record how its voxels were made, only channels and size are
/// compared.
///
/// # Errors
/// If channels, size or spacing differ.
pub fn differences(
    card: &ModelCard,
    set: &dyn SampleSource,
    path: &Path,
) -> Result<Vec<Difference>> {
    let shown = path.display();
    let trained_channels = &card.scaling.channels;
    if set.channels() != trained_channels {
        bail!(
            "the network was trained on voxels with the channels {}, {shown} has {}; make the \
             set again with voxelize --channels {}",
            trained_channels.join(", "),
            set.channels().join(", "),
            trained_channels.join(",")
        );
    }
    if set.size() != card.size {
        let (trained, size) = (card.size, set.size());
        bail!(
            "the network was trained on grids of {trained}³ voxels, {shown} has {size}³; make \
             the set again with voxelize --size {trained}"
        );
    }
    let (Some(Value::Object(trained)), Some(Value::Object(present))) =
        (&card.made_with, set.made_with())
    else {
        return Ok(Vec::new());
    };
    let differences = between(trained, present);
    if let Some(Difference {
        trained_on, set, ..
    }) = differences
        .iter()
        .find(|difference| difference.setting == "spacing")
    {
        let with_unit = |value: &Value| {
            format!(
                "{}{}",
                plain(value),
                if value.is_number() { " Å" } else { "" }
            )
        };
        bail!(
            "the network was trained on voxels with the spacing {}, {shown} has {}; make the \
             set again with voxelize --spacing {}",
            with_unit(trained_on),
            with_unit(set),
            plain(trained_on)
        );
    }
    Ok(differences)
}

fn between(trained: &Map<String, Value>, present: &Map<String, Value>) -> Vec<Difference> {
    let value = |map: &Map<String, Value>, key: &str| map.get(key).cloned().unwrap_or_default();
    let mut keys: Vec<&String> = trained.keys().chain(present.keys()).collect();
    keys.sort();
    keys.dedup();
    let differ = |key: &&String| {
        trained.get(*key) != present.get(*key) && !INDIFFERENT.contains(&key.as_str())
    };
    let of_key = |key: &String| Difference {
        setting: key.clone(),
        trained_on: value(trained, key),
        set: value(present, key),
    };
    keys.into_iter().filter(differ).map(of_key).collect()
}

/// The text of a JSON value, without quotes.
fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

impl Difference {
    /// Describes the difference in one line.
    pub fn line(&self) -> String {
        format!(
            "{}: {} here, {} in the training",
            self.setting,
            plain(&self.set),
            plain(&self.trained_on)
        )
    }
}
