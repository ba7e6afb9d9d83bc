//! Messages of the readers: errors with their line, warnings, quoted text.

use crate::BodyError;

/// An error that names the file, the line (zero for the whole file), the cause and the remedy.
pub(crate) fn parse_error(
    source: &str,
    line: usize,
    cause: impl Into<String>,
    remedy: impl Into<String>,
) -> BodyError {
    BodyError::Parse {
        file: source.to_string(),
        line,
        cause: cause.into(),
        remedy: remedy.into(),
    }
}

/// Text quoted in a message: shortened, without control characters.
pub(crate) fn quoted(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown = String::new();
    for (count, character) in text.chars().enumerate() {
        if count == LONGEST {
            return format!("`{shown}...`");
        }
        shown.push(if character.is_control() {
            '·'
        } else {
            character
        });
    }
    format!("`{shown}`")
}

/// The first few items of a list, for a message.
pub(crate) fn listed(items: &[String]) -> String {
    const SHOWN: usize = 20;
    match items.get(..SHOWN) {
        Some(shown) if items.len() > SHOWN => {
            format!("{} and {} more", shown.join(", "), items.len() - SHOWN)
        }
        _ => items.join(", "),
    }
}

/// Warnings of a reader: the first few in full, and the total number.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Warnings {
    /// The first warnings, each with its line number.
    pub messages: Vec<String>,
    /// Total number.
    pub count: usize,
}

impl Warnings {
    /// Warnings kept in full.
    const KEPT: usize = 50;

    pub(crate) fn add(&mut self, line: usize, message: &str) {
        self.count += 1;
        if self.messages.len() < Self::KEPT {
            self.messages.push(format!("line {line}: {message}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_shortened_and_control_characters_are_replaced() {
        assert_eq!(quoted("a\tb"), "`a·b`");
        assert_eq!(quoted(&"x".repeat(40)), format!("`{}`", "x".repeat(40)));
        assert_eq!(quoted(&"x".repeat(41)), format!("`{}...`", "x".repeat(40)));
    }

    #[test]
    fn long_lists_end_with_the_number_left_out() {
        let items: Vec<String> = (0..22).map(|number| number.to_string()).collect();
        assert_eq!(listed(&items[..2]), "0, 1");
        assert!(listed(&items).ends_with("18, 19 and 2 more"));
    }
}
