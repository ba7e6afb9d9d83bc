//! Names and other text from outside, as each language wants it written.
//!
//! | function | where it goes |
//! |---|---|
//! | [`csv_cell`] | a cell of a table, which spreadsheets read |
//! | [`html`] | an element or a quoted attribute of HTML |
//! | [`json_in_html`] | JSON inside a script element |
//! | [`script_words`] | a comment of a script for a viewer |
//! | [`file_name`], [`FileNames`] | the name of a file |

pub use protomer_kernel::name::printable;
use protomer_kernel::name::{is_forbidden, replaced};
use std::borrow::Cow;
use std::collections::HashSet;

/// Longest file name without its ending, in bytes: file systems take 255 with it.
pub const LONGEST_FILE_NAME_BYTES: usize = 200;
/// Names of devices on Windows, with any ending.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// The text of a cell on one line. A spreadsheet takes text that begins with one of `= + - @` for a
/// formula, so an apostrophe stands before it; numbers and ranges stay.
///
/// ```
/// use protomer_io::written::csv_cell;
/// assert_eq!(csv_cell("lysozyme"), "lysozyme");
/// assert_eq!(csv_cell("-2.5e-3"), "-2.5e-3");
/// assert_eq!(csv_cell("-7.5 to -2"), "-7.5 to -2");
/// assert_eq!(csv_cell("-2+3"), "'-2+3");
/// assert_eq!(csv_cell("=HYPERLINK(\"http://x\")"), "'=HYPERLINK(\"http://x\")");
/// assert_eq!(csv_cell("a\nb"), "a b");
/// ```
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    // Most cells need no copy.
    let line = match text.contains(is_forbidden) {
        true => Cow::Owned(replaced(text, is_forbidden, ' ')),
        false => Cow::Borrowed(text),
    };
    // A blank before the sign does not keep spreadsheets from taking it for a formula.
    let is_formula = line.trim_start().starts_with(['=', '+', '-', '@']) && !is_plain_cell(&line);
    match is_formula {
        true => Cow::Owned(format!("'{line}")),
        false => line,
    }
}

/// Whether a cell is a number, a dash that stands for none, or numbers between words: `-7.5 to -2`.
fn is_plain_cell(cell: &str) -> bool {
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    let is_plain = |word: &str| is_number(word) || word.chars().all(char::is_alphabetic);
    let begins_with_number = cell.split(' ').next().is_some_and(is_number);
    cell == "-" || (begins_with_number && cell.split(' ').all(is_plain))
}

/// Text that is safe in an element and in a quoted attribute.
///
/// ```
/// assert_eq!(protomer_io::written::html("a < b & \"c\""), "a &lt; b &amp; &quot;c&quot;");
/// ```
pub fn html(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            // Text of files has lines.
            '\n' | '\t' => safe.push(character),
            _ if is_forbidden(character) => safe.push(protomer_kernel::name::REPLACEMENT),
            _ => safe.push(character),
        }
    }
    safe
}

/// JSON inside a script element, which no text can end or turn into a comment. JSON has these characters
/// in strings only.
///
/// ```
/// let json = r#"{"name": "</script><!--"}"#;
/// let safe = protomer_io::written::json_in_html(json);
/// assert!(!safe.contains('<'));
/// assert_eq!(serde_json::from_str::<serde_json::Value>(&safe)?["name"], "</script><!--");
/// # Ok::<(), serde_json::Error>(())
/// ```
pub fn json_in_html(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for character in json.chars() {
        match character {
            // Covers `</script` and `<!--` alike.
            '<' => safe += "\\u003c",
            // Both end a line in JavaScript, but not in JSON.
            '\u{2028}' => safe += "\\u2028",
            '\u{2029}' => safe += "\\u2029",
            _ => safe.push(character),
        }
    }
    safe
}

/// The letters, digits and harmless signs of a text, for a comment in a script. Viewers separate
/// commands by semicolons and continue lines after a backslash, also in comments.
///
/// ```
/// let name = "a; python\nimport os #\\";
/// assert_eq!(protomer_io::written::script_words(name), "a_ python_import os __");
/// ```
pub fn script_words(text: &str) -> String {
    let is_harmless =
        |character: char| character.is_alphanumeric() || " ._-+(),:".contains(character);
    replaced(text, |character| !is_harmless(character), '_')
}

/// A name for a file: letters, digits and the signs `. _ - + ( ) ,` and blanks, not too long, not hidden,
/// never a path or a device.
///
/// ```
/// use protomer_io::written::file_name;
/// assert_eq!(file_name("6mdr_A"), "6mdr_A");
/// assert_eq!(file_name("../../x"), "_.._x");
/// assert_eq!(file_name("/etc/passwd"), "_etc_passwd");
/// assert_eq!(file_name("nul.txt"), "_nul.txt");
/// assert!(file_name(&"x".repeat(1000)).len() <= 200);
/// ```
pub fn file_name(text: &str) -> String {
    let is_harmless =
        |character: char| character.is_alphanumeric() || " ._-+(),".contains(character);
    let name = replaced(text, |character| !is_harmless(character), '_');
    // A leading dot hides a file, and a leading dash makes it a flag.
    let mut name = name.trim_start_matches(['.', ' ', '-']).to_owned();
    // Whole characters: cutting bytes could leave half of one.
    while name.len() > LONGEST_FILE_NAME_BYTES {
        name.pop();
    }
    // After the cut, which may have brought a dot or blank to the end; Windows drops these.
    name.truncate(name.trim_end_matches(['.', ' ']).len());
    // `con.txt` is the console too: what counts is the part before the first dot.
    let stem = name.split('.').next().unwrap_or_default();
    match name.is_empty() || is_device(&stem.to_ascii_lowercase()) {
        true => format!("_{name}"),
        false => name,
    }
}

fn is_device(stem: &str) -> bool {
    let is_numbered = |kind: &str| {
        let number = stem.strip_prefix(kind);
        number.is_some_and(|number| number.len() == 1 && number.parse::<u8>().is_ok())
    };
    DEVICES.contains(&stem) || is_numbered("com") || is_numbered("lpt")
}

/// File names in one folder: names that were different stay different, also where a file system does
/// not tell capital letters from small ones.
///
/// ```
/// let mut names = protomer_io::written::FileNames::default();
/// let written = ["a/b", "a:b", "A", "a"].map(|name| names.add(name));
/// assert_eq!(written, ["a_b", "a_b_2", "A", "a_2"]);
/// ```
#[derive(Debug, Default)]
pub struct FileNames {
    /// Names in small letters.
    used: HashSet<String>,
}

impl FileNames {
    /// The file name of a further name.
    ///
    /// ```
    /// use protomer_io::written::FileNames;
    /// let mut names = FileNames::default();
    /// assert_eq!((names.add("chain A"), names.add("chain A")), ("chain A".into(), "chain A_2".into()));
    /// ```
    pub fn add(&mut self, name: &str) -> String {
        let first = file_name(name);
        let mut unused = first.clone();
        let mut count = 1;
        // In small letters, as file systems compare; the name itself keeps its capitals.
        while !self.used.insert(unused.to_lowercase()) {
            count += 1;
            unused = format!("{first}_{count}");
        }
        unused
    }
}

/// Message for a name that holds a forbidden character, with the name in printable form.
pub(crate) fn refused_name(subject: &str, name: &str) -> Option<String> {
    let character = protomer_kernel::name::first_forbidden(name)?;
    let shown = printable(name);
    let code = u32::from(character);
    Some(format!(
        "{subject} '{shown}' holds the character U+{code:04X}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever a name holds, it is one line, one cell, one file, and no command.
        #[test]
        fn nothing_gets_through(name in any::<String>()) {
            let cell = csv_cell(&name);
            prop_assert!(!cell.contains(is_forbidden));
            let begins_formula = cell.trim_start().starts_with(['=', '+', '@']);
            prop_assert!(!begins_formula || is_plain_cell(&cell));
            let script = script_words(&name);
            prop_assert!(!script.contains(is_forbidden) && !script.contains([';', '\\', '#', '"']));
            let file = file_name(&name);
            prop_assert!(!file.is_empty() && file.len() <= LONGEST_FILE_NAME_BYTES + 1);
            prop_assert!(!file.contains(['/', '\\', ':', '\0']) && !file.starts_with('.'));
            prop_assert_eq!(file_name(&file), file);
            prop_assert!(!html(&name).contains(['<', '>', '"', '\0', '\r']));
            let json = serde_json::to_string(&name).unwrap();
            let safe = json_in_html(&json);
            prop_assert!(!safe.contains('<'));
            prop_assert_eq!(serde_json::from_str::<String>(&safe).unwrap(), name);
        }
    }
}
