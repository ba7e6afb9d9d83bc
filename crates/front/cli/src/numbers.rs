//! The flags that take numbers, from the table of flags: tests try each of them with numbers that make no sense.

use super::syntax;
use clap::{Arg, Command};
use std::any::TypeId;

/// A flag that takes a number or several.
///
/// ```
/// let flags = protomer_cli::number_flags();
/// let tilt = flags.iter().find(|flag| flag.flag == "tilt").unwrap();
/// assert_eq!((tilt.verb.join(" "), tilt.is_whole), ("assemble ring".into(), false));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NumberFlag {
    /// The verb, such as `assemble` `ring`.
    pub verb: Vec<String>,
    /// The long name, without `--`.
    pub flag: String,
    /// Whether it takes whole numbers only.
    pub is_whole: bool,
}

/// The flags of all verbs that take numbers, without the global ones. Flags that take lists with ranges in them,
/// such as `--salt` of a sweep, take text.
pub fn number_flags() -> Vec<NumberFlag> {
    let mut syntax = syntax();
    syntax.build();
    let mut flags = Vec::new();
    collect(&syntax, &[], &mut flags);
    flags
}

fn collect(command: &Command, verb: &[String], flags: &mut Vec<NumberFlag>) {
    for arg in command.get_arguments().filter(|arg| !arg.is_global_set()) {
        let kinds = [(true, is_whole(arg)), (false, is_real(arg))];
        let kind = kinds.into_iter().find(|(_, holds)| *holds);
        if let (Some(flag), Some((is_whole, _))) = (arg.get_long(), kind) {
            flags.push(NumberFlag {
                verb: verb.to_vec(),
                flag: flag.to_owned(),
                is_whole,
            });
        }
    }
    for sub in command
        .get_subcommands()
        .filter(|sub| sub.get_name() != "help")
    {
        let mut words = verb.to_vec();
        words.push(sub.get_name().to_owned());
        collect(sub, &words, flags);
    }
}

/// Whether an argument takes whole numbers.
pub(crate) fn is_whole(arg: &Arg) -> bool {
    let whole = [
        TypeId::of::<u8>(),
        TypeId::of::<u32>(),
        TypeId::of::<i32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
        TypeId::of::<i64>(),
    ];
    whole
        .iter()
        .any(|id| arg.get_value_parser().type_id() == *id)
}

/// Whether an argument takes numbers that need not be whole.
pub(crate) fn is_real(arg: &Arg) -> bool {
    arg.get_value_parser().type_id() == TypeId::of::<f64>()
}
