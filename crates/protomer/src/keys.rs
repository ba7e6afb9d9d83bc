//! Reading JSON and TOML with errors that name the key, the file, the line and the nearest valid
//! key.

use anyhow::{Result, anyhow};
use serde::de::DeserializeOwned;
use serde_json::error::Category;
use std::path::Path;

/// Deserialises JSON.
///
/// # Errors
/// Names the file, line, and key; for an unknown key the nearest valid one.
pub fn from_json<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T> {
    serde_json::from_slice(bytes).map_err(|error| {
        let cause = error.to_string();
        let cause = cause.split(" at line ").next().unwrap_or(&cause);
        let explained = match error.classify() {
            Category::Eof => {
                format!("the file ends too early ({cause}); it is empty or cut: complete it")
            }
            Category::Syntax => format!(
                "this is no JSON ({cause} at column {}); mend the line",
                error.column()
            ),
            Category::Data | Category::Io => with_hint(cause),
        };
        anyhow!("{}:{}: {explained}", path.display(), error.line())
    })
}

/// Deserialises TOML.
///
/// # Errors
/// Names the file, line, and key; for an unknown key the nearest valid one.
pub fn from_toml<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T> {
    toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| {
            text[..span.start.min(text.len())].matches('\n').count() + 1
        });
        let explained = match text.parse::<toml::Table>() {
            Ok(_) => with_hint(error.message()),
            Err(_) => format!("this is no TOML ({}); mend the line", error.message()),
        };
        anyhow!("{}:{line}: {explained}", path.display())
    })
}

/// Adds `did you mean ...?` to serde's message about an unknown field.
fn with_hint(message: &str) -> String {
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

/// The known word nearest to a wrong one, unless none is near.
pub fn nearest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let nearest = known
        .into_iter()
        .min_by_key(|word| edit_distance(wrong, word))?;
    (edit_distance(wrong, nearest) <= 1 + wrong.chars().count() / 3).then_some(nearest)
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
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

    #[test]
    fn edit_distance_counts_edits() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
    }
}
