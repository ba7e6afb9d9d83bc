//! The docstrings of Python functions, in the style of NumPy.

use super::example::python_call;
use super::{Parameter, about, wrapped};
use crate::help::examples_of;
use clap::Command;

/// Longest line, for an indentation of four.
const WIDTH: usize = 106;
/// Errors that every verb may raise.
const RAISES: [(&str, &str); 4] = [
    (
        "MissingFileError",
        "If a file or a folder does not exist; also a `FileNotFoundError`",
    ),
    ("ParseError", "If a file cannot be understood"),
    ("ConfigError", "If an argument is invalid"),
    (
        "ProtomerError",
        "For any other error; all of them are of this class",
    ),
];
/// Further errors of verbs with these flags.
const RAISES_WITH: [(&str, &str, &str); 1] = [(
    "time_limit",
    "StoppedError",
    "If the time was over before the end; the same call continues it",
)];
/// Verbs that go on if an input fails.
const PARTIAL: [&str; 1] = ["ingest"];

/// The docstring of a function: description, parameters, result, errors and examples.
pub fn docstring(
    command: &Command,
    path: &[&str],
    result: &str,
    parameters: &[Parameter],
) -> String {
    let described = parameters
        .iter()
        .map(|parameter| (parameter.name.as_str(), parameter.help.as_str()));
    let fields = "The fields that `--json` prints, as attributes";
    let mut sections = vec![
        wrapped(&about(command), WIDTH, ""),
        section("Parameters", described),
        section("Returns", [(result, fields)]),
        section("Raises", raises(path, parameters)),
    ];
    let examples: Vec<String> = examples_of(command)
        .iter()
        .filter_map(|words| python_call(command, path, words))
        .map(|call| format!(">>> {call}  # doctest: +SKIP"))
        .collect();
    if !examples.is_empty() {
        sections.push([heading("Examples"), examples].concat());
    }
    sections.join(&String::new()).join("\n")
}

fn raises(path: &[&str], parameters: &[Parameter]) -> Vec<(&'static str, &'static str)> {
    let mut raises = RAISES.to_vec();
    for (name, class, when) in RAISES_WITH {
        if parameters.iter().any(|parameter| parameter.name == name) {
            raises.push((class, when));
        }
    }
    if PARTIAL.contains(&path.join(" ").as_str()) {
        raises.push((
            "PartialError",
            "If some of the files failed; its attribute `result` holds the answer for all",
        ));
    }
    raises
}

fn heading(title: &str) -> Vec<String> {
    vec![title.to_owned(), "-".repeat(title.len())]
}

fn section<'a>(title: &str, entries: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<String> {
    let mut lines = heading(title);
    for (name, help) in entries {
        lines.push(name.to_owned());
        lines.extend(wrapped(help, WIDTH - 4, "    "));
    }
    lines
}
