//! Lines for a person on stderr, next to the data on stdout.

use protomer_kernel::name::{REPLACEMENT, is_forbidden, replaced};
use std::io::Write;

/// Prints a line on stderr. A closed stderr is not an error.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", for_terminal(line));
}

/// Text without characters that would command a terminal; names from outside may hold them.
pub fn for_terminal(text: &str) -> String {
    let commands = |character| is_forbidden(character) && !matches!(character, '\n' | '\t');
    replaced(text, commands, REPLACEMENT)
}
