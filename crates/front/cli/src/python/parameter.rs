//! The parameters of Python functions.

use super::identifier;
use crate::numbers::{is_real, is_whole};
use crate::paths::is_path;
use clap::{Arg, ArgAction};
use serde::Serialize;
use std::fmt::Write;

/// The flag whose text needs a unit: its function also has the keyword [`SALT_MOLAR`] for numbers.
pub const SALT: &str = "salt";
/// The keyword for the salt concentration as numbers, mol/L.
const SALT_MOLAR: &str = "salt_molar";
/// Files that may also be objects: verb, argument, class.
const OBJECTS: [(&str, &str, &str); 21] = [
    ("assemble ring", "bodies", "Body"),
    ("assemble fluid", "bodies", "Body"),
    ("candidates", "bodies", "Body"),
    ("surface", "input", "Body"),
    ("potential", "input", "Body"),
    ("binding", "receptor", "Body"),
    ("binding", "ligand", "Body"),
    ("pair", "first", "Body"),
    ("pair", "second", "Body"),
    ("lattice square", "body", "Body"),
    ("export", "input", "Assembly | Body"),
    ("export", "assembly", "Assembly"),
    ("report", "assembly", "Assembly"),
    ("scattering", "input", "Assembly"),
    ("scattering", "assembly", "Assembly"),
    ("reweight", "assembly", "Assembly"),
    ("inspect", "assembly", "Assembly"),
    ("stability", "inputs", "Assembly"),
    ("simulate", "assembly", "Assembly"),
    ("sweep", "assembly", "Assembly"),
    ("bench", "assembly", "Assembly"),
];

/// Part of a command that a parameter stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Section {
    /// A word without a flag, which Python also takes by position.
    Place,
    /// A flag with its value.
    Flag,
    /// No part: only the function has it.
    Function,
}

/// One parameter of a Python function.
#[derive(Debug, Clone, Serialize)]
pub struct Parameter {
    /// Keyword.
    pub name: String,
    /// Part of the command.
    pub section: Section,
    /// The flag, such as `--salt`; empty without one.
    pub flag: String,
    /// Type of a value.
    pub annotation: String,
    /// Whether there is no default.
    pub required: bool,
    /// Whether the flag has no value.
    pub is_switch: bool,
    /// Whether the flag is repeated for each value. Without a delimiter clap would take a list
    /// with commas for a single value.
    pub is_repeated: bool,
    /// Description, with the default.
    pub help: String,
}

impl Parameter {
    /// Parameter for an argument of a verb.
    pub(super) fn new(arg: &Arg, verb: &str) -> Self {
        let flag = match (arg.get_long(), arg.get_short()) {
            (Some(long), _) => format!("--{long}"),
            (None, Some(short)) => format!("-{short}"),
            (None, None) => String::new(),
        };
        let is_switch = matches!(arg.get_action(), ArgAction::SetTrue);
        Self {
            name: identifier(arg.get_long().unwrap_or(arg.get_id().as_str())),
            section: if arg.is_positional() {
                Section::Place
            } else {
                Section::Flag
            },
            flag,
            annotation: annotation(arg, verb),
            // Salt may be given as text or as a number, so neither of the two is required.
            required: arg.is_required_set() && arg.get_id() != SALT,
            is_switch,
            is_repeated: !arg.is_positional()
                && matches!(arg.get_action(), ArgAction::Append)
                && arg.get_value_delimiter().is_none(),
            help: help(arg, is_switch),
        }
    }

    fn only_function(name: &str, annotation: &str, help: &str) -> Self {
        Self {
            name: name.into(),
            section: Section::Function,
            flag: String::new(),
            annotation: annotation.into(),
            required: false,
            is_switch: false,
            is_repeated: false,
            help: help.into(),
        }
    }

    /// The salt as numbers, next to the parameter for the salt as text.
    pub(super) fn salt_molar(salt: &Self) -> Self {
        if salt.annotation.contains("Sequence") {
            Self::only_function(
                SALT_MOLAR,
                "float | Sequence[float] | NDArray[np.float64]",
                "The same as numbers in mol/L, instead of `salt`",
            )
        } else {
            Self::only_function(
                SALT_MOLAR,
                "float",
                "The same as a number in mol/L, instead of `salt`",
            )
        }
    }

    /// Keywords of verbs that can be distributed over machines.
    pub(super) fn shared() -> [Self; 2] {
        [
            Self::only_function(
                "client",
                "Client | str",
                "A `distributed.Client`, the address of a Dask scheduler such as \"tcp://host:8786\", or \"local\" for \
                 workers on this machine. The workers must see all files and folders under the same paths",
            ),
            Self::only_function(
                "parts",
                "int",
                "Number of parts with a client [default: four per worker thread]",
            ),
        ]
    }

    /// The function that hears of the progress.
    pub(super) fn progress() -> Self {
        Self::only_function(
            "progress",
            "Callable[[int, int, str], None]",
            "Called as progress(done, total, unit) during the work.",
        )
    }

    /// Declaration in a signature.
    pub(super) fn declaration(&self) -> String {
        let Self {
            name, annotation, ..
        } = self;
        match (self.is_switch, self.required) {
            (true, _) => format!("{name}: bool = False"),
            (_, true) => format!("{name}: {annotation}"),
            _ => format!("{name}: {annotation} | None = None"),
        }
    }
}

fn help(arg: &Arg, is_switch: bool) -> String {
    let mut help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let defaults = arg.get_default_values();
    if !defaults.is_empty() && !is_switch {
        let defaults: Vec<String> = defaults
            .iter()
            .map(|value| value.display().to_string())
            .collect();
        let _ = write!(help, " [default: {}]", defaults.join(" "));
    }
    help
}

/// The type of the values of an argument.
fn annotation(arg: &Arg, verb: &str) -> String {
    let parser = arg.get_value_parser();
    let choices: Vec<String> = parser
        .possible_values()
        .into_iter()
        .flatten()
        .filter(|value| !value.is_hide_set())
        .map(|value| format!("\"{}\"", value.get_name()))
        .collect();
    let most_values = arg.get_num_args().map_or(1, |count| count.max_values());
    let many = matches!(arg.get_action(), ArgAction::Append) || most_values > 1;
    if arg.get_id() == SALT {
        // One concentration is a number for the program, several are text.
        return if is_real(arg) {
            "str"
        } else {
            "str | Sequence[str]"
        }
        .to_owned();
    }
    let name = identifier(arg.get_long().unwrap_or(arg.get_id().as_str()));
    let one = match () {
        () if !choices.is_empty() && !many => return format!("Literal[{}]", choices.join(", ")),
        () if is_path(arg) => {
            let object = OBJECTS
                .iter()
                .find(|(command, arg, _)| *command == verb && *arg == name);
            object.map_or("Path | str".to_owned(), |(_, _, class)| {
                format!("Path | str | {class}")
            })
        }
        () if is_whole(arg) => "int | str".to_owned(),
        () if is_real(arg) => "float | str".to_owned(),
        // Lists of names, and lists of numbers that the program reads itself.
        () => return "str | float | Sequence[str | float]".to_owned(),
    };
    match (many, one.starts_with("float")) {
        (false, _) => one,
        (true, false) => format!("{one} | Sequence[{one}]"),
        (true, true) => format!("{one} | Sequence[{one}] | NDArray[np.float64]"),
    }
}
