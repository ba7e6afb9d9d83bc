//! Parses a command line into its parts, for a program that runs them on other machines.

use super::paths::is_path;
use super::{UsageError, syntax};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::OsStr;
use std::path::Path;

/// A command in a form that is valid on any machine: long flag names, absolute paths.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Command {
    /// The verb, such as `lattice` `run`.
    pub verb: Vec<String>,
    /// Flags that were given, without `--`, and their values; switches have none.
    pub flags: Vec<(String, Option<String>)>,
    /// Positional arguments, such as the assembly of a sweep.
    pub places: Vec<String>,
}

impl Command {
    /// Parses the words of a command line, without the program's name.
    ///
    /// ```
    /// use protomer_cli::Command;
    /// let command = Command::from_words(&["merge", "-qj2", "/parts/1.zarr", "-o", "/set.zarr"]).unwrap();
    /// let flag = |name: &str, value: Option<&str>| (name.to_owned(), value.map(str::to_owned));
    /// assert_eq!(command.flags, [flag("output", Some("/set.zarr")), flag("threads", Some("2")), flag("quiet", None)]);
    /// assert_eq!((command.verb, command.places), (vec!["merge".into()], vec!["/parts/1.zarr".into()]));
    /// ```
    ///
    /// # Errors
    /// For words that are not a command.
    pub fn from_words<S: AsRef<str>>(words: &[S]) -> Result<Self, UsageError> {
        let mut syntax = syntax();
        syntax.build();
        let words = ["protomer"]
            .into_iter()
            .chain(words.iter().map(AsRef::as_ref));
        let parsed = syntax.try_get_matches_from_mut(words);
        let parsed = parsed.map_err(|error| UsageError(error.to_string().trim().to_owned()))?;
        let (mut syntax, mut given) = (&syntax, &parsed);
        let mut command = Self::default();
        while let Some((name, inner)) = given.subcommand() {
            let Some(verb) = syntax.find_subcommand(name) else {
                break;
            };
            (syntax, given) = (verb, inner);
            command.verb.push(name.to_owned());
        }
        for arg in syntax.get_arguments() {
            command.add(arg, given);
        }
        Ok(command)
    }

    fn add(&mut self, arg: &Arg, given: &ArgMatches) {
        if given.value_source(arg.get_id().as_str()) != Some(ValueSource::CommandLine) {
            return;
        }
        let is_path = is_path(arg);
        let values = given.get_raw(arg.get_id().as_str()).unwrap_or_default();
        let values = values.map(|value| {
            if is_path {
                from_the_root(value)
            } else {
                value.display().to_string()
            }
        });
        match arg.get_long() {
            None => self.places.extend(values),
            Some(long) if matches!(arg.get_action(), ArgAction::SetTrue) => {
                self.flags.push((long.to_owned(), None))
            }
            Some(long) => self
                .flags
                .extend(values.map(|value| (long.to_owned(), Some(value)))),
        }
    }
}

fn from_the_root(path: &OsStr) -> String {
    // Fails only for an empty path, which is reported when it is opened.
    std::path::absolute(path)
        .unwrap_or_else(|_| Path::new(path).to_owned())
        .display()
        .to_string()
}
