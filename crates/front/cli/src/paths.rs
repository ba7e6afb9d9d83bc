//! Names of files and folders on the command line must be text: results, tables and settings write them down.

use clap::error::ErrorKind;
use clap::{Arg, ArgMatches, Command, Error};
use std::any::TypeId;
use std::ffi::OsStr;
use std::path::PathBuf;

/// Refuses a path that is not UTF-8.
pub fn require_text(syntax: &Command, given: &ArgMatches) -> Result<(), Error> {
    let (mut verb, mut given) = (syntax, given);
    while let Some((name, inner)) = given.subcommand() {
        let Some(sub) = verb.find_subcommand(name) else {
            break;
        };
        (verb, given) = (sub, inner);
    }
    for arg in verb.get_arguments().filter(|arg| is_path(arg)) {
        let values = given.get_raw(arg.get_id().as_str());
        if let Some(value) = values
            .into_iter()
            .flatten()
            .find(|value| value.to_str().is_none())
        {
            return Err(refusal(syntax, arg, value));
        }
    }
    Ok(())
}

/// Whether an argument takes a path.
pub fn is_path(arg: &Arg) -> bool {
    arg.get_value_parser().type_id() == TypeId::of::<PathBuf>()
}

fn refusal(syntax: &Command, arg: &Arg, value: &OsStr) -> Error {
    let message =
        format!("invalid value {value:?} for '{arg}': the name is not UTF-8; rename the file");
    syntax.clone().error(ErrorKind::InvalidUtf8, message)
}
