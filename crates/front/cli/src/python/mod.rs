//! The verbs as Python functions: a table of them, made from the flags, and the stub with their types.
//!
//! ```text
//! clap's commands --> Group, Function, Parameter --serde--> functions of the Python package
//!                                               `--stub--> python/protomer/_verbs.pyi
//! ```

mod docstring;
mod example;
mod parameter;
mod stub;

use super::Cli;
use clap::{Arg, Command, CommandFactory};
use parameter::{SALT, Section};
use serde::Serialize;

pub use parameter::Parameter;
pub use stub::python_stub;

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
/// keywords of [`Parameter::shared`].
const SHARED_BY: &str = "shard";
/// The class of results without a class of their own.
const PLAIN: &str = "Result";
/// Reserved words of Python.
const KEYWORDS: [&str; 6] = ["from", "lambda", "in", "is", "class", "global"];

/// A verb as Python has it: a function, or an object whose methods are the subcommands.
#[derive(Debug, Clone, Serialize)]
pub struct Group {
    /// Name of the function or the object.
    pub name: String,
    /// Description of the verb.
    pub about: String,
    /// Whether the verb has subcommands.
    pub has_methods: bool,
    /// The function, or the methods; `__call__` is the verb without a subcommand.
    pub functions: Vec<Function>,
}

/// A verb, or a subcommand of a verb, as a Python function.
#[derive(Debug, Clone, Serialize)]
pub struct Function {
    /// Name of the function.
    pub name: String,
    /// Words of the command.
    pub verb: Vec<String>,
    /// Description of the command, a paragraph.
    pub about: String,
    /// Docstring: description, parameters, result, errors and examples.
    pub doc: String,
    /// Class of the result.
    pub result: String,
    /// Whether a salt concentration must be given, as text or as a number.
    pub requires_salt: bool,
    /// Parameters in the order of the signature.
    pub parameters: Vec<Parameter>,
}

/// The verbs for programs, in the order of the help.
///
/// ```
/// let sweep = protomer_cli::python_functions().into_iter().find(|group| group.name == "sweep");
/// assert_eq!(sweep.unwrap().functions[0].parameters[0].name, "assembly");
/// ```
pub fn python_functions() -> Vec<Group> {
    let mut cli = Cli::command();
    cli.build();
    cli.get_subcommands()
        .filter(|verb| !LEFT_OUT.contains(&verb.get_name()) && !verb.is_hide_set())
        .map(group)
        .collect()
}

fn group(verb: &Command) -> Group {
    let name = verb.get_name();
    let subcommands: Vec<&Command> = verb
        .get_subcommands()
        .filter(|subcommand| subcommand.get_name() != "help")
        .collect();
    let class = result_class(verb).unwrap_or(PLAIN);
    let mut functions = Vec::new();
    if subcommands.is_empty() {
        functions.push(function(verb, &[name], class, identifier(name)));
    } else if !verb.is_subcommand_required_set() {
        functions.push(function(verb, &[name], class, "__call__".to_owned()));
    }
    for subcommand in &subcommands {
        let own = subcommand.get_name();
        let class = result_class(subcommand).unwrap_or(class);
        functions.push(function(subcommand, &[name, own], class, identifier(own)));
    }
    Group {
        name: identifier(name),
        about: about(verb),
        has_methods: !subcommands.is_empty(),
        functions,
    }
}

fn function(command: &Command, path: &[&str], result: &str, name: String) -> Function {
    let verb = path.join(" ");
    let parameters = parameters(command, &verb);
    Function {
        name,
        doc: docstring::docstring(command, path, result, &parameters),
        verb: path.iter().map(|word| (*word).to_owned()).collect(),
        about: about(command),
        result: result.to_owned(),
        requires_salt: requires_salt(command),
        parameters,
    }
}

/// Whether the flag of the salt concentration must be given.
fn requires_salt(command: &Command) -> bool {
    let mut arguments = command.get_arguments();
    arguments.any(|argument| argument.get_id() == SALT && argument.is_required_set())
}

/// Places first, then required flags, optional flags, and the keywords that only functions have.
fn parameters(command: &Command, verb: &str) -> Vec<Parameter> {
    let (mut places, mut flags): (Vec<&Arg>, Vec<&Arg>) = command
        .get_arguments()
        .filter(|arg| !NOT_FOR_FUNCTIONS.contains(&arg.get_id().as_str()) && !arg.is_hide_set())
        .partition(|arg| arg.is_positional());
    places.sort_by_key(|arg| arg.get_index());
    flags.sort_by_key(|arg| !arg.is_required_set());
    let mut parameters: Vec<Parameter> = places
        .into_iter()
        .chain(flags)
        .map(|arg| Parameter::new(arg, verb))
        .collect();
    let position = |name: &str| {
        parameters
            .iter()
            .position(|parameter| parameter.section == Section::Flag && parameter.name == name)
    };
    let shared = position(SHARED_BY).is_some();
    if let Some(index) = position(SALT) {
        let numbers = Parameter::salt_molar(&parameters[index]);
        parameters.insert(index + 1, numbers);
    }
    if shared {
        parameters.extend(Parameter::shared());
    }
    parameters.push(Parameter::progress());
    parameters
}

/// The class of the result of a verb: the id of the group of its flags, where that names one, as in
/// `#[group(id = "PairResult")]`. Subcommands have the class of their verb unless they name another.
fn result_class(command: &Command) -> Option<&str> {
    let mut groups = command.get_groups().map(|group| group.get_id().as_str());
    groups.find(|id| id.ends_with(PLAIN))
}

/// The description of a command, with a full stop.
fn about(command: &Command) -> String {
    let about = command.get_long_about().or(command.get_about());
    let about = about.map(ToString::to_string).unwrap_or_default();
    match about.ends_with('.') {
        true => about,
        false => format!("{about}."),
    }
}

/// The name of a flag or a verb in Python.
fn identifier(name: &str) -> String {
    let name = name.replace('-', "_");
    if KEYWORDS.contains(&name.as_str()) {
        format!("{name}_")
    } else {
        name
    }
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
