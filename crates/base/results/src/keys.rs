//! JSON and TOML with errors that name the file, the line, the key, and the nearest valid key.

use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::error::Category;
use std::path::Path;
use strsim::levenshtein;

/// Deserialises JSON.
///
/// ```
/// use protomer_results::keys::from_json;
/// use std::path::Path;
/// assert_eq!(from_json::<Vec<u32>>(Path::new("a.json"), b"[1, 2]")?, [1, 2]);
/// let error = from_json::<Vec<u32>>(Path::new("a.json"), b"[1, 2").map_err(|error| error.to_string());
/// assert!(error.is_err_and(|message| message.contains("the file ends too early")));
/// # Ok::<(), protomer_results::Error>(())
/// ```
///
/// # Errors
/// Names the file, line, and key; for an unknown key the nearest valid one.
pub fn from_json<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T> {
    serde_json::from_slice(bytes).map_err(|error| {
        let cause = error.to_string();
        // serde's message ends with a place, which `Error::Parse` states on its own.
        let cause = cause.split(" at line ").next().unwrap_or(&cause);
        let explained = match error.classify() {
            Category::Eof => {
                format!("the file ends too early ({cause}); it is empty or truncated: complete it")
            }
            Category::Syntax => format!(
                "this is not JSON ({cause} at column {}); correct the line",
                error.column()
            ),
            Category::Data | Category::Io => with_hint(cause),
        };
        Error::Parse {
            path: path.to_owned(),
            line: error.line(),
            problem: explained,
        }
    })
}

/// Deserialises TOML.
///
/// # Errors
/// Names the file, line, and key; for an unknown key the nearest valid one.
///
/// ```
/// use protomer_results::keys::from_toml;
/// use serde::Deserialize;
/// use std::path::Path;
///
/// #[derive(Debug, Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Walk {
///     sweeps: u64,
/// }
///
/// let path = Path::new("run.toml");
/// assert_eq!(from_toml::<Walk>(path, "sweeps = 3")?.sweeps, 3);
/// let error = from_toml::<Walk>(path, "sweps = 3").unwrap_err();
/// assert!(error.to_string().ends_with("did you mean 'sweeps'?"));
/// # Ok::<(), protomer_results::Error>(())
/// ```
pub fn from_toml<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T> {
    toml::from_str(text).map_err(|error| {
        // The span is in bytes and may lie behind the end.
        let line = error.span().map_or(1, |span| {
            text[..span.start.min(text.len())].matches('\n').count() + 1
        });
        // Whether the text is TOML at all decides between two kinds of advice.
        let explained = match text.parse::<toml::Table>() {
            Ok(_) => with_hint(error.message()),
            Err(_) => format!("this is not TOML ({}); correct the line", error.message()),
        };
        Error::Parse {
            path: path.to_owned(),
            line,
            problem: explained,
        }
    })
}

/// Reads a JSON file.
///
/// # Errors
/// As [`from_json`]; also if the file cannot be read.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let bytes = protomer_io::input::read(path).map_err(Error::file("read", path))?;
    from_json(path, &bytes)
}

/// Reads a JSON file that may be missing.
///
/// ```
/// use protomer_results::keys::read_json_if_present;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.json");
/// assert_eq!(read_json_if_present::<u32>(&path)?, None);
/// std::fs::write(&path, "7")?;
/// assert_eq!(read_json_if_present::<u32>(&path)?, Some(7));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`from_json`]; also if it exists but cannot be read.
pub fn read_json_if_present<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    match protomer_io::input::read(path) {
        Ok(bytes) => from_json(path, &bytes).map(Some),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Error::file("read", path)(error)),
    }
}

/// Reads a TOML file.
///
/// # Errors
/// As [`from_toml`]; also if the file cannot be read.
pub fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = protomer_io::input::read_to_string(path).map_err(Error::file("read", path))?;
    from_toml(path, &text)
}

/// The TOML text of a value, such as settings.
///
/// ```
/// use protomer_results::keys::to_toml;
/// use std::collections::BTreeMap;
/// let text = to_toml("the settings", &BTreeMap::from([("sweeps", 100)]))?;
/// assert_eq!(text, "sweeps = 100\n");
/// # Ok::<(), protomer_results::Error>(())
/// ```
///
/// # Errors
/// [`Error::Unwritable`] if it cannot be represented in TOML.
pub fn to_toml<T: Serialize>(content: &'static str, value: &T) -> Result<String> {
    toml::to_string_pretty(value).map_err(|error| Error::Unwritable {
        content,
        cause: error.to_string(),
    })
}

/// Adds `did you mean ...?` to serde's message about an unknown field.
fn with_hint(message: &str) -> String {
    // serde names the field and then the known ones, each in backticks.
    let mut quoted = message.split('`').skip(1).step_by(2);
    let is_unknown_key = message.starts_with("unknown field");
    let near = match quoted.next() {
        Some(wrong) if is_unknown_key => nearest(wrong, quoted),
        _ => None,
    };
    match near {
        Some(nearest) => format!("{message}; did you mean '{nearest}'?"),
        None => message.to_owned(),
    }
}

/// The known word nearest to a misspelt one, if any is close.
///
/// ```
/// use protomer_results::keys::nearest;
/// assert_eq!(nearest("hexgon", ["square", "hexagon"]), Some("hexagon"));
/// assert_eq!(nearest("circle", ["hexagon"]), None);
/// ```
pub fn nearest<'a>(wrong: &str, words: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let nearest = words
        .into_iter()
        .min_by_key(|word| levenshtein(wrong, word))?;
    // One letter, and another for every three: more would suggest unrelated words.
    (levenshtein(wrong, nearest) <= 1 + wrong.chars().count() / 3).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Settings {
        replicas: u32,
        sweeps: u64,
    }

    #[test]
    fn unknown_keys_are_named_with_line_and_nearest() {
        let error = from_toml::<Settings>(Path::new("run.toml"), "sweeps = 3\nreplicsa = 1\n")
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("run.toml:2:") && error.ends_with("did you mean 'replicas'?"),
            "{error}"
        );
        let error = from_json::<Settings>(Path::new("a.json"), b"{\n\"sweps\": 1}")
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("a.json:2:") && error.ends_with("did you mean 'sweeps'?"),
            "{error}"
        );
    }
}
