//! Which settings can continue which: the identity of work, and the differences between settings.

use crate::keys::to_toml;
use crate::{Error, Result};
use protomer_io::atomic::sha256_hex;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Maximum number of differing settings in a message.
const MOST_DIFFERENCES: usize = 6;

/// The resolved settings of a piece of work, as stored in its directory. They contain
/// everything that can change a result.
///
/// ```
/// use protomer_results::Settings;
/// use serde::{Deserialize, Serialize};
///
/// #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
/// struct Walk {
///     seed: u64,
///     steps: u64,
/// }
///
/// impl Settings for Walk {
///     // A walk of 100 steps can be continued to 200.
///     fn essential(&self) -> Self {
///         Self { steps: 0, ..self.clone() }
///     }
/// }
///
/// let (short, long) = (Walk { seed: 1, steps: 100 }, Walk { seed: 1, steps: 200 });
/// assert_eq!(short.essential(), long.essential());
/// ```
pub trait Settings: Serialize + DeserializeOwned + PartialEq + Clone {
    /// The settings without those that may change when work is continued, such as its length.
    #[must_use]
    fn essential(&self) -> Self {
        self.clone()
    }

    /// Name of work with these settings, where the kind of its directory has a wider name.
    fn name(&self) -> Option<&'static str> {
        None
    }

    /// Reason why work that was begun with `present` cannot continue with these settings, although
    /// their essential parts are equal: a phrase that follows the name of the directory, such as
    /// "is meant to run to 200 steps, which is more than 100; ask for at least as many".
    fn objection(&self, _present: &Self) -> Option<String> {
        None
    }
}

/// SHA-256 of everything that shapes the result: the essential settings and the input.
///
/// # Errors
/// [`Error::Unwritable`] if the settings cannot be represented in TOML.
pub fn identity(settings: &impl Settings, input_sha256: &str) -> Result<String> {
    let text = to_toml("the settings", &settings.essential())?;
    // As TOML, whose keys have a fixed order: equal settings give equal text.
    Ok(sha256_hex(format!("{text}{input_sha256}").as_bytes()))
}

/// The differences between the settings of a directory and the requested ones, as in
/// `seed: 1 there, 2 here`.
///
/// # Errors
/// [`Error::Unwritable`] if one of them cannot be represented in TOML.
///
/// ```
/// use protomer_results::settings::differences;
/// use serde::Serialize;
///
/// #[derive(Serialize)]
/// struct Walk {
///     seed: u64,
/// }
///
/// assert_eq!(differences(&Walk { seed: 1 }, &Walk { seed: 2 })?, "seed: 1 there, 2 here");
/// # Ok::<(), protomer_results::Error>(())
/// ```
pub fn differences<S: Serialize>(stored: &S, requested: &S) -> Result<String> {
    let (stored, requested) = (flat(stored)?, flat(requested)?);
    let keys: BTreeSet<&String> = stored.keys().chain(requested.keys()).collect();
    let differing: Vec<&String> = keys
        .into_iter()
        .filter(|key| stored.get(*key) != requested.get(*key))
        .collect();
    let shown = |table: &Table, key: &str| {
        table
            .get(key)
            .map_or_else(|| "none".into(), ToString::to_string)
    };
    let mut lines: Vec<String> = differing
        .iter()
        .take(MOST_DIFFERENCES)
        .map(|key| {
            format!(
                "{key}: {} there, {} here",
                shown(&stored, key),
                shown(&requested, key)
            )
        })
        .collect();
    if differing.len() > MOST_DIFFERENCES {
        lines.push(format!("and {} more", differing.len() - MOST_DIFFERENCES));
    }
    Ok(lines.join("; "))
}

/// The settings with dotted keys: `medium.temperature_K`.
fn flat(settings: &impl Serialize) -> Result<Table> {
    let table = Table::try_from(settings).map_err(|error| Error::Unwritable {
        content: "the settings",
        cause: error.to_string(),
    })?;
    let mut flat = Table::new();
    flatten("", table, &mut flat);
    Ok(flat)
}

fn flatten(prefix: &str, table: Table, flat: &mut Table) {
    for (key, value) in table {
        match value {
            Value::Table(inner) => flatten(&format!("{prefix}{key}."), inner, flat),
            value => drop(flat.insert(format!("{prefix}{key}"), value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Run {
        seed: u64,
        steps: u64,
        tolerance: Option<f64>,
        medium: InteractionSettings,
    }

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct InteractionSettings {
        name: String,
    }

    impl Settings for Run {
        fn essential(&self) -> Self {
            Self {
                steps: 0,
                ..self.clone()
            }
        }
    }

    fn run(seed: u64, steps: u64) -> Run {
        Run {
            seed,
            steps,
            tolerance: None,
            medium: InteractionSettings {
                name: "water".into(),
            },
        }
    }

    #[test]
    fn the_identity_is_that_of_the_essential_settings_and_the_input() {
        let identified = |settings: &Run, input| identity(settings, input).unwrap();
        assert_eq!(identified(&run(1, 10), "a"), identified(&run(1, 20), "a"));
        assert_ne!(identified(&run(1, 10), "a"), identified(&run(2, 10), "a"));
        assert_ne!(identified(&run(1, 10), "a"), identified(&run(1, 10), "b"));
    }

    #[test]
    fn differences_name_both_values_and_where_they_stand() {
        let earlier = run(1, 10);
        let present = Run {
            tolerance: Some(0.5),
            medium: InteractionSettings { name: "oil".into() },
            ..run(2, 10)
        };
        assert_eq!(
            differences(&earlier, &present).unwrap(),
            "medium.name: \"water\" there, \"oil\" here; seed: 1 there, 2 here; \
             tolerance: none there, 0.5 here"
        );
        assert_eq!(differences(&earlier, &earlier).unwrap(), "");
        let many = |value: u32| -> Table {
            (0..9)
                .map(|key| (format!("k{key}"), Value::Integer(value.into())))
                .collect()
        };
        assert!(
            differences(&many(1), &many(2))
                .unwrap()
                .ends_with("; and 3 more")
        );
    }
}
