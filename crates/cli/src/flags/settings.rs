//! Flags of settings, made from their declarations.

use anyhow::Result;
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use protomer_common::settings::{Declaration, Declared, paragraph};
use protomer_kernel::setting::{Choice, Choices, Kind};
use protomer_results::keys::read_toml;
use std::marker::PhantomData;
use std::path::Path;
use toml::{Table, Value};

/// Settings that were given as flags. The others come from a configuration file, or else from the defaults.
#[derive(Debug, Clone)]
pub struct SettingsArgs<S> {
    given: Table,
    settings: PhantomData<S>,
}

impl<S: Declared> SettingsArgs<S> {
    /// Settings of the configuration, if there is one, with those of the flags.
    ///
    /// # Errors
    /// If the configuration cannot be read.
    pub fn settings(&self, configuration: Option<&Path>) -> Result<S> {
        let settings: S = configuration.map_or(Ok(S::default()), read_toml)?;
        let mut table = Table::try_from(&settings)?;
        table.extend(self.given.clone());
        Ok(table.try_into()?)
    }
}

impl<S: Declared> clap::Args for SettingsArgs<S> {
    fn augment_args(command: Command) -> Command {
        let declarations = S::declarations();
        declarations
            .into_iter()
            .fold(command, |command, declaration| {
                command.arg(argument(declaration))
            })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Declared> clap::FromArgMatches for SettingsArgs<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut given = Table::new();
        for declaration in S::declarations() {
            if let Some(value) = value(matches, &declaration) {
                given.insert(declaration.key.to_owned(), value);
            }
        }
        Ok(Self {
            given,
            settings: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The flag of a setting.
fn argument(declaration: Declaration) -> Arg {
    let Declaration {
        key,
        text,
        kind,
        default,
    } = declaration;
    let help = match default {
        Some(default) => format!("{text} [default: {default}]"),
        None => text,
    };
    let argument = Arg::new(key)
        .long(key.replace('_', "-"))
        .value_name(key.to_uppercase())
        .help(help);
    match kind {
        Kind::Real => argument
            .value_parser(value_parser!(f64))
            .allow_negative_numbers(true),
        Kind::Whole => argument.value_parser(value_parser!(u64)),
        Kind::Switch => argument.action(ArgAction::SetTrue),
        Kind::Choice(choices) => argument.value_parser(possible_values(choices)),
        Kind::Words => argument.action(ArgAction::Append),
        Kind::Reals => argument
            .action(ArgAction::Append)
            .value_parser(value_parser!(f64))
            .allow_negative_numbers(true),
    }
}

/// The value of a flag, if it was given.
fn value(matches: &ArgMatches, declaration: &Declaration) -> Option<Value> {
    let key = declaration.key;
    match declaration.kind {
        Kind::Real => matches
            .get_one::<f64>(key)
            .map(|value| Value::Float(*value)),
        // TOML has no larger numbers.
        Kind::Whole => matches
            .get_one::<u64>(key)
            .map(|value| Value::Integer(i64::try_from(*value).unwrap_or(i64::MAX))),
        Kind::Switch => matches.get_flag(key).then_some(Value::Boolean(true)),
        Kind::Choice(_) => matches
            .get_one::<String>(key)
            .map(|name| Value::String(name.clone())),
        Kind::Words => matches
            .get_many::<String>(key)
            .map(|words| Value::Array(words.map(|word| Value::String(word.clone())).collect())),
        Kind::Reals => matches
            .get_many::<f64>(key)
            .map(|values| Value::Array(values.map(|value| Value::Float(*value)).collect())),
    }
}

fn possible_values(choices: &[Choice]) -> PossibleValuesParser {
    let values = choices
        .iter()
        .map(|choice| PossibleValue::new(choice.name).help(paragraph(choice.text)));
    PossibleValuesParser::new(values)
}

/// Reader of a flag that chooses by name.
pub fn choice<T: Choices + Send + Sync>() -> impl clap::builder::TypedValueParser<Value = T> {
    use clap::builder::TypedValueParser;
    possible_values(T::CHOICES).try_map(|name| T::from_name(&name).ok_or("no such choice"))
}
