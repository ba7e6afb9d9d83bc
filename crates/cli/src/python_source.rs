//! The Python functions of the verbs, generated from the table of flags, so that the two cannot
//! disagree.

use super::Cli;
use crate::help::examples_of;
use crate::numbers::{is_real, is_whole};
use crate::paths::is_path;
use clap::{Arg, ArgAction, Command, CommandFactory};
use std::fmt::Write;

/// Verbs for shells only.
const LEFT_OUT: [&str; 3] = ["completions", "man", "help"];
/// Flags without a meaning for a function, which returns what `--json` prints.
const NOT_FOR_FUNCTIONS: [&str; 7] = [
    "json",
    "quiet",
    "verbose",
    "no_progress",
    "scheduler",
    "help",
    "version",
];
/// A verb with this flag can be distributed over machines: its function also has the
/// keywords of [`SHARED`].
const SHARED_BY: &str = "shard";
/// Keywords, their types and descriptions.
const SHARED: [(&str, &str, &str); 2] = [
    (
        "client",
        "Client | str",
        "A `distributed.Client`, the address of a Dask scheduler such as \"tcp://host:8786\", or \"local\" for workers on \
         this machine. The workers must see all files and folders under the same paths",
    ),
    (
        "parts",
        "int",
        "Number of parts with a client [default: four per worker thread]",
    ),
];
/// Verbs whose results have their own class; a star stands for the verb and all its subcommands.
const RESULTS: [(&str, &str); 16] = [
    ("bench", "BenchResult"),
    ("compare", "CompareResult"),
    ("framework *", "FrameworkResult"),
    ("hpmc sweep", "HardBodySweepResult"),
    ("lattice run", "LatticeResult"),
    ("lattice sweep", "LatticeSweepResult"),
    ("pair", "PairResult"),
    ("phase-diagram", "PhaseDiagramResult"),
    ("potential", "PotentialResult"),
    ("predict", "PredictResult"),
    ("scattering", "ScatteringResult"),
    ("simulate", "SimulationResult"),
    ("sweep", "SweepResult"),
    ("train", "TrainResult"),
    ("tune", "TuneResult"),
    ("voxelize", "VoxelizeResult"),
];
/// The class of all other results.
const PLAIN: &str = "Result";
/// Subcommands of a starred verb with plain results.
const PLAIN_VERBS: [&str; 1] = ["framework tables"];
/// The flag whose text needs a unit: its function also has the keyword [`SALT_MOLAR`] for numbers.
const SALT: &str = "salt";
const SALT_MOLAR: &str = "salt_molar";
/// Verbs that require the flag [`SALT`].
const SALT_IS_REQUIRED: [&str; 2] = ["binding", "potential"];
/// Files that may also be objects: verb, argument, class.
const OBJECTS: [(&str, &str, &str); 20] = [
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
    ("simulate", "assembly", "Assembly"),
    ("sweep", "assembly", "Assembly"),
    ("bench", "assembly", "Assembly"),
];
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
/// Reserved words of Python.
const KEYWORDS: [&str; 6] = ["from", "lambda", "in", "is", "class", "global"];
const WIDTH: usize = 110;

const HEAD: &str = r#""""The verbs of protomer as functions. Written by the program from its table of flags; do not edit:
UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation
"""

# ruff: noqa: E501
from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ._call import call, salts
"#;

/// Types that only annotations name.
const TAIL: &str = r#"
if TYPE_CHECKING:
    from distributed import Client

    from ._assembly import Assembly
    from ._body import Body
"#;

/// The text of `python/protomer/_verbs.py`.
pub fn python_functions() -> String {
    let mut cli = Cli::command();
    cli.build();
    let mut verbs = Vec::new();
    for verb in cli.get_subcommands() {
        if !LEFT_OUT.contains(&verb.get_name()) && !verb.is_hide_set() {
            verbs.push(verb);
        }
    }
    let mut text = HEAD.to_owned();
    let mut classes = RESULTS.map(|(_, class)| class).to_vec();
    classes.push(PLAIN);
    classes.sort_unstable();
    text.push_str("from .results import (\n");
    for class in classes {
        let _ = writeln!(text, "    {class},");
    }
    text.push_str(")\n");
    text.push_str(TAIL);
    text.push_str("\n__all__ = [\n");
    for verb in &verbs {
        let _ = writeln!(text, "    \"{}\",", identifier(verb.get_name()));
    }
    text.push_str("]\n");
    for verb in verbs {
        write_verb(&mut text, verb);
    }
    text
}

fn write_verb(text: &mut String, verb: &Command) {
    let subverbs: Vec<&Command> = verb
        .get_subcommands()
        .filter(|sub| sub.get_name() != "help")
        .collect();
    let name = verb.get_name();
    if subverbs.is_empty() {
        text.push_str("\n\n");
        write_function(text, verb, &[name], &identifier(name), "");
        return;
    }
    // Verbs with subcommands are objects with methods.
    let _ = write!(text, "\n\nclass _{}:\n", capitalised(&identifier(name)));
    write_docstring(
        text,
        &[wrapped(&sentence(&about(verb)), WIDTH - 4, "")],
        "    ",
    );
    if !verb.is_subcommand_required_set() {
        text.push('\n');
        write_function(text, verb, &[name], "__call__", "    ");
    }
    for sub in subverbs {
        text.push('\n');
        write_function(
            text,
            sub,
            &[name, sub.get_name()],
            &identifier(sub.get_name()),
            "    ",
        );
    }
    let object = identifier(name);
    let _ = write!(text, "\n\n{object} = _{}()\n", capitalised(&object));
}

/// One argument of a Python function.
struct Parameter {
    name: String,
    /// The flag; `None` for a positional argument.
    flag: Option<String>,
    annotation: String,
    required: bool,
    is_switch: bool,
    /// Whether the flag is repeated for each value. Without a delimiter clap would take a list
    /// with commas for a single value.
    is_repeated: bool,
    help: String,
}

impl Parameter {
    fn of(arg: &Arg, verb: &str) -> Self {
        let flag = match (arg.get_long(), arg.get_short()) {
            (Some(long), _) => Some(format!("--{long}")),
            (None, Some(short)) => Some(format!("-{short}")),
            (None, None) => None,
        };
        let mut default = Vec::new();
        for value in arg.get_default_values() {
            default.push(value.display().to_string());
        }
        let is_switch = matches!(arg.get_action(), ArgAction::SetTrue);
        let mut help = arg.get_help().map(ToString::to_string).unwrap_or_default();
        if !default.is_empty() && !is_switch {
            let _ = write!(help, " [default: {}]", default.join(" "));
        }
        Self {
            name: identifier(arg.get_long().unwrap_or(arg.get_id().as_str())),
            flag,
            annotation: annotation(arg, verb),
            // Another keyword may say the same.
            required: arg.is_required_set() && arg.get_id() != SALT,
            is_switch,
            is_repeated: matches!(arg.get_action(), ArgAction::Append)
                && arg.get_value_delimiter().is_none(),
            help,
        }
    }

    fn for_functions((name, annotation, help): (&str, &str, &str)) -> Self {
        Self {
            name: name.into(),
            flag: None,
            annotation: annotation.into(),
            required: false,
            is_switch: false,
            is_repeated: false,
            help: help.into(),
        }
    }

    /// The salt as numbers.
    fn salt_molar(salt: &Self) -> Self {
        let several = salt.annotation.contains("Sequence");
        Self {
            name: SALT_MOLAR.into(),
            flag: None,
            annotation: match several {
                true => "float | Sequence[float] | NDArray[np.float64]".into(),
                false => "float".into(),
            },
            required: false,
            is_switch: false,
            is_repeated: false,
            help: match several {
                true => "The same as numbers in mol/L, instead of `salt`".into(),
                false => "The same as a number in mol/L, instead of `salt`".into(),
            },
        }
    }

    fn declaration(&self) -> String {
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

fn annotation(arg: &Arg, verb: &str) -> String {
    let parser = arg.get_value_parser();
    let mut choices = Vec::new();
    for value in parser.possible_values().into_iter().flatten() {
        if !value.is_hide_set() {
            choices.push(format!("\"{}\"", value.get_name()));
        }
    }
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

fn write_function(text: &mut String, command: &Command, path: &[&str], name: &str, indent: &str) {
    let (mut placed, mut flags): (Vec<&Arg>, Vec<&Arg>) = command
        .get_arguments()
        .filter(|arg| !NOT_FOR_FUNCTIONS.contains(&arg.get_id().as_str()) && !arg.is_hide_set())
        .partition(|arg| arg.is_positional());
    placed.sort_by_key(|arg| arg.get_index());
    // Required parameters come first.
    flags.sort_by_key(|arg| !arg.is_required_set());
    let verb = path.join(" ");
    let to_parameter = |arg: &Arg| Parameter::of(arg, &verb);
    let placed: Vec<Parameter> = placed.into_iter().map(to_parameter).collect();
    let mut flags: Vec<Parameter> = flags.into_iter().map(to_parameter).collect();
    if let Some(index) = flags.iter().position(|flag| flag.name == SALT) {
        let numbers = Parameter::salt_molar(&flags[index]);
        flags.insert(index + 1, numbers);
    }
    let result = class_of(path);
    let _ = writeln!(text, "{indent}def {name}(");
    if !indent.is_empty() {
        let _ = writeln!(text, "{indent}    self,");
    }
    for parameter in &placed {
        let _ = writeln!(text, "{indent}    {},", parameter.declaration());
    }
    let _ = writeln!(text, "{indent}    *,");
    for parameter in &flags {
        let _ = writeln!(text, "{indent}    {},", parameter.declaration());
    }
    let shared: Vec<Parameter> = if flags.iter().any(|flag| flag.name == SHARED_BY) {
        SHARED.into_iter().map(Parameter::for_functions).collect()
    } else {
        Vec::new()
    };
    for parameter in &shared {
        let _ = writeln!(text, "{indent}    {},", parameter.declaration());
    }
    let _ = writeln!(
        text,
        "{indent}    progress: Callable[[int, int, str], None] | None = None,\n{indent}) -> {result}:"
    );
    let inner = format!("{indent}    ");
    let parameters: Vec<&Parameter> = placed.iter().chain(&flags).chain(&shared).collect();
    let sections = sections(command, path, result, &parameters, WIDTH - inner.len());
    write_docstring(text, &sections, &inner);
    let words: Vec<String> = path.iter().map(|word| format!("\"{word}\"")).collect();
    let names = placed.iter().map(|parameter| parameter.name.as_str());
    let places: Vec<&str> = names.collect();
    let _ = writeln!(
        text,
        "{inner}return call(\n{inner}    {result},\n{inner}    [{}],",
        words.join(", ")
    );
    let _ = writeln!(text, "{inner}    [{}],\n{inner}    {{", places.join(", "));
    for Parameter { name, flag, .. } in &flags {
        let Some(flag) = flag else { continue };
        let value = match name.as_str() {
            SALT => {
                let required = SALT_IS_REQUIRED.contains(&verb.as_str());
                let required = if required { ", required=True" } else { "" };
                format!("salts(\"{verb}\", {SALT}, {SALT_MOLAR}{required})")
            }
            name => name.to_owned(),
        };
        let _ = writeln!(text, "{inner}        \"{flag}\": {value},");
    }
    let _ = writeln!(text, "{inner}    }},\n{inner}    progress,");
    for Parameter { name, .. } in &shared {
        let _ = writeln!(text, "{inner}    {name}={name},");
    }
    let repeated: Vec<String> = flags
        .iter()
        .filter(|flag| flag.is_repeated)
        .filter_map(|flag| Some(format!("\"{}\"", flag.flag.as_ref()?)))
        .collect();
    if !repeated.is_empty() {
        let _ = writeln!(text, "{inner}    repeated=[{}],", repeated.join(", "));
    }
    let _ = writeln!(text, "{inner})");
}

/// The class of the result of a verb.
fn class_of(path: &[&str]) -> &'static str {
    let verb = path.join(" ");
    let first = path.first().copied().unwrap_or_default();
    if PLAIN_VERBS.contains(&verb.as_str()) {
        return PLAIN;
    }
    for (name, class) in RESULTS {
        if name == verb || name.strip_suffix(" *") == Some(first) {
            return class;
        }
    }
    PLAIN
}

fn about(command: &Command) -> String {
    match command.get_long_about().or(command.get_about()) {
        Some(about) => about.to_string(),
        None => String::new(),
    }
}

/// The sections of the docstring of a function, each a list of lines.
fn sections(
    command: &Command,
    path: &[&str],
    result: &str,
    parameters: &[&Parameter],
    width: usize,
) -> Vec<Vec<String>> {
    let verb = path.join(" ");
    let described = |title: &str, entries: &[(&str, &str)]| {
        let mut lines = vec![title.to_owned(), "-".repeat(title.len())];
        for (name, help) in entries {
            lines.push((*name).to_owned());
            lines.extend(wrapped(help, width - 4, "    "));
        }
        lines
    };
    let mut descriptions = Vec::new();
    for parameter in parameters {
        descriptions.push((parameter.name.as_str(), parameter.help.as_str()));
    }
    descriptions.push((
        "progress",
        "Called as progress(done, total, unit) during the work.",
    ));
    let fields = "The fields that `--json` prints, as attributes";
    let mut raises = RAISES.to_vec();
    for (name, class, when) in RAISES_WITH {
        if parameters.iter().any(|parameter| parameter.name == name) {
            raises.push((class, when));
        }
    }
    if PARTIAL.contains(&verb.as_str()) {
        raises.push((
            "PartialError",
            "If some of the files failed; its attribute `result` holds the answer for all",
        ));
    }
    let mut sections = vec![
        wrapped(&sentence(&about(command)), width, ""),
        described("Parameters", &descriptions),
        described("Returns", &[(result, fields)]),
        described("Raises", &raises),
    ];
    let examples = examples_of(&verb).iter();
    let calls: Vec<String> = examples
        .filter_map(|words| python_call(command, path, words))
        .map(|call| format!(">>> {call}  # doctest: +SKIP"))
        .collect();
    if !calls.is_empty() {
        let mut lines = vec!["Examples".to_owned(), "-".repeat(8)];
        lines.extend(calls);
        sections.push(lines);
    }
    sections
}

/// An example of the command line as a call; `None` if it is of another verb, or has flags that
/// functions lack.
fn python_call(command: &Command, path: &[&str], words: &str) -> Option<String> {
    let mut words = words.split_whitespace();
    for word in path {
        if words.next() != Some(word) {
            return None;
        }
    }
    let mut places = Vec::new();
    let mut keywords: Vec<(String, Vec<String>)> = Vec::new();
    while let Some(word) = words.next() {
        let flags = || command.get_arguments().filter(|arg| !arg.is_positional());
        let arg = match (word.strip_prefix("--"), word.strip_prefix('-')) {
            (Some(long), _) => flags().find(|arg| arg.get_long() == Some(long))?,
            (None, Some(short)) => flags().find(|arg| {
                arg.get_short()
                    .is_some_and(|letter| short == letter.to_string())
            })?,
            (None, None) => {
                places.push(format!("\"{word}\""));
                continue;
            }
        };
        if NOT_FOR_FUNCTIONS.contains(&arg.get_id().as_str()) {
            continue;
        }
        let name = identifier(arg.get_long().unwrap_or(arg.get_id().as_str()));
        let value = match arg.get_action() {
            ArgAction::SetTrue => "True".to_owned(),
            _ => {
                let value = words.next()?;
                match value.parse::<f64>() {
                    Ok(_) => value.to_owned(),
                    Err(_) => format!("\"{value}\""),
                }
            }
        };
        match keywords.iter_mut().find(|(keyword, _)| *keyword == name) {
            Some((_, values)) => values.push(value),
            None => keywords.push((name, vec![value])),
        }
    }
    let first = command.get_arguments().find(|arg| arg.is_positional());
    let takes_many = first
        .and_then(Arg::get_num_args)
        .is_some_and(|count| count.max_values() > 1);
    let mut given = match takes_many && places.len() > 1 {
        true => vec![format!("[{}]", places.join(", "))],
        false => places,
    };
    for (name, values) in keywords {
        given.push(match &values[..] {
            [value] => format!("{name}={value}"),
            several => format!("{name}=[{}]", several.join(", ")),
        });
    }
    let mut function = path.iter().map(|word| identifier(word));
    Some(format!(
        "pm.{}({})",
        function.by_ref().collect::<Vec<_>>().join("."),
        given.join(", ")
    ))
}

fn sentence(about: &str) -> String {
    match about.ends_with('.') {
        true => about.to_owned(),
        false => format!("{about}."),
    }
}

/// Sections with an empty line between two.
fn write_docstring(text: &mut String, sections: &[Vec<String>], indent: &str) {
    let clean = |text: &str| text.replace('\\', "\\\\").replace("\"\"\"", "'''");
    let lines: Vec<String> = sections
        .join(&String::new())
        .iter()
        .map(|line| clean(line))
        .collect();
    let single = lines.len() == 1;
    let _ = write!(text, "{indent}\"\"\"");
    for (n, line) in lines.iter().enumerate() {
        let _ = match (n, line.is_empty()) {
            (0, _) => write!(text, "{line}"),
            (_, true) => writeln!(text),
            _ => write!(text, "\n{indent}{line}"),
        };
    }
    let _ = if single {
        writeln!(text, "\"\"\"")
    } else {
        writeln!(text, "\n{indent}\"\"\"")
    };
}

/// Wraps words into lines of at most `width` characters, each after `indent`.
fn wrapped(text: &str, width: usize, indent: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last().map_or(0, |line| line.chars().count());
        match lines.last_mut() {
            Some(line) if last == 0 => line.push_str(word),
            Some(line) if last + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
        .into_iter()
        .map(|line| format!("{indent}{line}"))
        .collect()
}

fn identifier(name: &str) -> String {
    let name = name.replace('-', "_");
    if KEYWORDS.contains(&name.as_str()) {
        format!("{name}_")
    } else {
        name
    }
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
