//! What the help adds to the table of flags: verbs in groups, examples, and values that may start with a
//! minus.

use crate::verbs::GROUPS;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, Command};
use protomer_body::structure::Format;
use protomer_common::input::is_pdb_entry;
use protomer_protein_verbs::file_kind::FileKind;
use std::ffi::OsString;
use std::path::Path;

/// The two examples of a verb, each without the name of the program, as its help shows them.
macro_rules! examples {
    ($first:literal, $second:literal) => {
        concat!("Examples:\n  protomer ", $first, "\n  protomer ", $second)
    };
}

/// Largest width of the list of verbs.
const WIDTH: usize = 100;
/// Column at which the descriptions of verbs begin.
const INDENT: usize = 17;

/// The command line as clap derives it from the flags, with what this module adds.
pub fn completed(derived: Command) -> Command {
    let list = grouped(&derived);
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}Options:\n{{options}}\n\n\
         'protomer VERB --help' shows the flags of a verb, with examples."
    );
    with_numbers_below_zero(derived).help_template(template)
}

/// Groups of verbs, in the order of the help, with the names of the verbs: words in small letters with hyphens.
fn groups() -> Vec<(&'static str, Vec<String>)> {
    let name = |verb: &&str| {
        let mut name = String::new();
        for letter in verb.chars() {
            if letter.is_uppercase() && !name.is_empty() {
                name.push('-');
            }
            name.extend(letter.to_lowercase());
        }
        name
    };
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for (group, verbs) in GROUPS {
        groups.push((group, verbs.iter().map(name).collect()));
    }
    // The verb that clap adds.
    if let Some((_, last)) = groups.last_mut() {
        last.push("help".into());
    }
    groups
}

/// The verbs in groups, each with the beginning of its description.
fn grouped(derived: &Command) -> String {
    let mut list = String::new();
    for (group, mut verbs) in groups() {
        verbs.retain(|name| name == "help" || derived.find_subcommand(name).is_some());
        if verbs.is_empty() {
            continue;
        }
        list.push_str(&format!("{group}:\n"));
        for name in verbs {
            let verb = derived.find_subcommand(&name);
            let about = verb.and_then(Command::get_about).map(ToString::to_string);
            let about = about.unwrap_or_else(|| "Print the help of a verb".into());
            let mut line = format!("  {name:<width$}", width = INDENT - 2);
            for word in beginning(&about).split(' ') {
                if line.chars().count() + word.chars().count() > WIDTH {
                    list.push_str(line.trim_end());
                    line = format!("\n{:INDENT$}", "");
                }
                line.push_str(word);
                line.push(' ');
            }
            list.push_str(line.trim_end());
            list.push('\n');
        }
        list.push('\n');
    }
    list
}

/// The first sentence, up to a colon.
fn beginning(about: &str) -> &str {
    let end = [". ", ": "]
        .iter()
        .filter_map(|mark| about.find(mark))
        .min();
    about[..end.unwrap_or(about.len())].trim_end_matches('.')
}

/// The examples of a verb, without the name of the program.
pub fn examples_of(verb: &Command) -> Vec<String> {
    let text = verb.get_after_long_help().map(ToString::to_string);
    let text = text.unwrap_or_default();
    let examples = text
        .lines()
        .filter_map(|line| line.strip_prefix("  protomer "));
    examples.map(str::to_owned).collect()
}

/// The verb and those below it, with flags that take numbers below zero.
fn with_numbers_below_zero(verb: Command) -> Command {
    verb.mut_args(minus_is_no_flag)
        .mut_subcommands(with_numbers_below_zero)
}

/// Lets a flag take a number below zero as its value; the flag itself then states whether it may be
/// negative.
fn minus_is_no_flag(arg: Arg) -> Arg {
    let takes_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    match takes_value && !arg.is_positional() && !arg.is_allow_hyphen_values_set() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    }
}

/// The error without the advice to write a value that starts with a minus behind `--`: that makes
/// it a separate argument.
pub fn without_double_dash(mut error: clap::Error) -> clap::Error {
    let Some(ContextValue::StyledStrs(tips)) = error.remove(ContextKind::Suggested) else {
        return error;
    };
    let is_helpful = |tip: &StyledStr| !tip.to_string().contains("'-- ");
    let tips: Vec<StyledStr> = tips.into_iter().filter(is_helpful).collect();
    if !tips.is_empty() {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
    }
    error
}

/// The error for a word that is not a number, in words of this program: those of the standard library say
/// nothing to a user.
pub fn with_plain_number(error: clap::Error) -> clap::Error {
    let cause = std::error::Error::source(&error).map(ToString::to_string);
    let remedy = match cause.as_deref() {
        Some("invalid float literal" | "cannot parse float from empty string") => {
            "write a number such as 0.5"
        }
        Some("invalid digit found in string" | "cannot parse integer from empty string") => {
            "write a whole number such as 5"
        }
        _ => return error,
    };
    let text = |kind: ContextKind| error.get(kind).map(ToString::to_string);
    let (Some(flag), Some(value)) = (
        text(ContextKind::InvalidArg),
        text(ContextKind::InvalidValue),
    ) else {
        return error;
    };
    clap::Error::raw(
        ErrorKind::ValueValidation,
        format!(
            "invalid value '{value}' for '{flag}': {remedy}\n\nFor more information, try '--help'.\n"
        ),
    )
}

/// The error for a verb that this build does not have, with the way to get it.
pub fn with_missing_feature(error: clap::Error, syntax: &mut Command) -> clap::Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    if !groups().iter().any(|(_, verbs)| verbs.contains(word)) {
        return error;
    }
    let reason = format!(
        "this protomer was built without '{word}'; install it with its default features, among them \
         `learning`"
    );
    syntax.error(ErrorKind::InvalidSubcommand, reason)
}

/// The error for a word that is not a verb, with what may be meant: a file, for which the verb that takes
/// it is missing, or the second word of a verb of two words.
pub fn with_missing_verb(
    error: clap::Error,
    syntax: &mut Command,
    words: &[OsString],
) -> clap::Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    let words = words.iter().map(|word| word.to_string_lossy());
    let before: Vec<_> = words.take_while(|other| other != word).collect();
    let in_assemble = before.iter().any(|other| other == "assemble");
    let reason = match FileKind::from_path(Path::new(word)) {
        Some(FileKind::Body) if in_assemble => format!(
            "{word} is a body: 'protomer assemble ring {word}' and 'assemble fluid {word}' make assemblies of \
             bodies"
        ),
        _ if in_assemble && is_structure_or_entry(word) => format!(
            "{word} is not a way to assemble; for a structure, write 'protomer assemble structure {word}'"
        ),
        Some(FileKind::Structure | FileKind::Pqr) => format!(
            "{word} is a structure, and the verb is missing; 'protomer ingest {word}' makes a body of it, \
             'protomer assemble structure {word}' an assembly"
        ),
        _ => match verbs_with(syntax, word) {
            verbs if verbs.is_empty() => return error,
            verbs => format!("'{word}' alone is no verb; write {}", verbs.join(" or ")),
        },
    };
    syntax.error(ErrorKind::InvalidSubcommand, reason)
}

fn is_structure_or_entry(word: &str) -> bool {
    Format::of_name(word).is_some() || is_pdb_entry(word) || Path::new(word).is_file()
}

/// The commands of two words that end with this one, in quotes.
fn verbs_with(syntax: &Command, word: &str) -> Vec<String> {
    let mut found = Vec::new();
    for verb in syntax.get_subcommands() {
        if verb.get_name() != "help" && verb.find_subcommand(word).is_some() {
            found.push(format!("'protomer {} {word}'", verb.get_name()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cli;
    use clap::CommandFactory;

    #[test]
    fn every_verb_stands_in_a_group_by_its_name() {
        let command = Cli::command();
        let mut verbs: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        verbs.push("help");
        let listed: Vec<String> = groups().into_iter().flat_map(|(_, verbs)| verbs).collect();
        assert_eq!(listed, verbs);
    }

    /// The verb and those below it, each with its name after that of the program.
    fn all_verbs(verb: &Command, path: &str) -> Vec<(String, Command)> {
        let mut verbs = Vec::new();
        for below in verb.get_subcommands() {
            let path = format!("{path} {}", below.get_name())
                .trim_start()
                .to_owned();
            verbs.extend(all_verbs(below, &path));
            verbs.push((path, below.clone()));
        }
        verbs
    }

    #[test]
    fn every_verb_has_examples_that_are_commands_of_it() {
        for (verb, command) in all_verbs(&Cli::command(), "") {
            let examples = examples_of(&command);
            let is_below = verb.contains(' ');
            assert!(is_below || examples.len() == 2, "{verb} has no examples");
            for example in examples {
                assert!(example == verb || example.starts_with(&format!("{verb} ")));
                let words = ["protomer"].into_iter().chain(example.split(' '));
                let parsed = completed(Cli::command()).try_get_matches_from(words);
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
            }
        }
    }

    #[test]
    fn the_list_shows_the_beginning_of_a_description() {
        assert_eq!(
            beginning("Inspect an assembly: overlaps"),
            "Inspect an assembly"
        );
        assert_eq!(beginning("Draw. More"), "Draw");
        assert_eq!(beginning("Print completions"), "Print completions");
    }
}
