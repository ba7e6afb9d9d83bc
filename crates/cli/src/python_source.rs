//! The Python functions of the verbs, generated from the table of flags, so that the two cannot
//! disagree.

use super::Cli;
use clap::{Arg, ArgAction, Command, CommandFactory};
use std::any::TypeId;
use std::fmt::Write;
use std::path::PathBuf;

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
        "Client",
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
const RESULTS: [(&str, &str); 13] = [
    ("bench", "BenchResult"),
    ("compare", "CompareResult"),
    ("framework *", "FrameworkResult"),
    ("lattice run", "LatticeResult"),
    ("lattice sweep", "LatticeSweepResult"),
    ("pair", "PairResult"),
    ("potential", "PotentialResult"),
    ("predict", "PredictResult"),
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
/// Flags whose numbers need a unit.
const TEXT_WITH_UNITS: [&str; 1] = ["salt"];
/// Reserved words of Python.
const KEYWORDS: [&str; 6] = ["from", "lambda", "in", "is", "class", "global"];
const WIDTH: usize = 110;

const HEAD: &str = r#""""The verbs of protomer as functions. Written by the program from its table of flags; do not edit:
UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation
"""

# ruff: noqa: E501
from __future__ import annotations

from typing import Literal

from ._call import Client, Integer, Integers, Number, Numbers, Path, Paths, Progress, Quantity, Text, call
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
    text.push_str(")\n\n__all__ = [\n");
    for verb in &verbs {
        let _ = writeln!(text, "    \"{}\",", verb.get_name());
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
        write_function(text, verb, &[name], name, "");
        return;
    }
    // Verbs with subcommands are objects with methods.
    let _ = write!(text, "\n\nclass _{}:\n", capitalised(name));
    write_docstring(text, &about(verb), &[], "    ");
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
    let _ = write!(text, "\n\n{name} = _{}()\n", capitalised(name));
}

/// One argument of a Python function.
struct Parameter {
    name: String,
    /// The flag; `None` for a positional argument.
    flag: Option<String>,
    annotation: String,
    required: bool,
    is_switch: bool,
    help: String,
}

impl Parameter {
    fn of(arg: &Arg) -> Self {
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
            annotation: annotation(arg),
            required: arg.is_required_set(),
            is_switch,
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
            help: help.into(),
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

fn annotation(arg: &Arg) -> String {
    let parser = arg.get_value_parser();
    let mut choices = Vec::new();
    for value in parser.possible_values().into_iter().flatten() {
        if !value.is_hide_set() {
            choices.push(format!("\"{}\"", value.get_name()));
        }
    }
    let most_values = arg.get_num_args().map_or(1, |count| count.max_values());
    let many = matches!(arg.get_action(), ArgAction::Append) || most_values > 1;
    if TEXT_WITH_UNITS.contains(&arg.get_id().as_str()) {
        return "Quantity".to_owned();
    }
    let is = |types: &[TypeId]| types.iter().any(|id| parser.type_id() == *id);
    let integers = [
        TypeId::of::<u8>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
        TypeId::of::<i64>(),
    ];
    match () {
        () if !choices.is_empty() && !many => format!("Literal[{}]", choices.join(", ")),
        () if is(&[TypeId::of::<PathBuf>()]) => if many { "Paths" } else { "Path" }.to_owned(),
        () if is(&integers) => if many { "Integers" } else { "Integer" }.to_owned(),
        () if is(&[TypeId::of::<f64>()]) => if many { "Numbers" } else { "Number" }.to_owned(),
        () => "Text".to_owned(),
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
    let placed: Vec<Parameter> = placed.into_iter().map(Parameter::of).collect();
    let flags: Vec<Parameter> = flags.into_iter().map(Parameter::of).collect();
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
        "{indent}    progress: Progress | None = None,\n{indent}) -> {result}:"
    );
    let inner = format!("{indent}    ");
    let known: Vec<&Parameter> = placed.iter().chain(&flags).chain(&shared).collect();
    write_docstring(text, &about(command), &known, &inner);
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
        let _ = writeln!(
            text,
            "{inner}        \"{}\": {name},",
            flag.as_deref().unwrap_or_default()
        );
    }
    let _ = writeln!(text, "{inner}    }},\n{inner}    progress,");
    for Parameter { name, .. } in &shared {
        let _ = writeln!(text, "{inner}    {name}={name},");
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

fn write_docstring(text: &mut String, about: &str, parameters: &[&Parameter], indent: &str) {
    let clean = |text: &str| text.replace('\\', "\\\\").replace("\"\"\"", "'''");
    let mut about = clean(about);
    if !about.ends_with('.') {
        about.push('.');
    }
    let mut lines = wrapped(&about, WIDTH - indent.len(), "");
    if !parameters.is_empty() {
        lines.push(String::new());
        lines.push("Parameters".into());
        lines.push("----------".into());
        for parameter in parameters {
            lines.push(parameter.name.clone());
            lines.extend(wrapped(
                &clean(&parameter.help),
                WIDTH - indent.len() - 4,
                "    ",
            ));
        }
        lines.push("progress".into());
        lines.push("    Called as progress(done, total, unit) during the work.".into());
    }
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
