//! Lines for a person, beside the data on stdout.

use std::io::Write;

/// Prints a line on stderr. A closed stderr is not an error.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
