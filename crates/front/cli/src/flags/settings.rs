//! Flags of settings, made from their declarations.

use anyhow::Result;
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Arg, ArgAction, ArgMatches, Command};
use protomer_common::range::{Count, Range};
use protomer_common::settings::{Bounds, Declaration, Declared, paragraph};
use protomer_kernel::setting::{Choice, Choices, Kind};
use protomer_results::keys::read_toml;
use std::marker::PhantomData;
use std::path::Path;
use toml::Value;

/// Settings that were given as flags. The others come from a configuration file, or else from the defaults.
#[derive(Debug, Clone)]
pub struct SettingsArgs<S, O = Shared> {
    given: Vec<(&'static str, Given)>,
    settings: PhantomData<(S, O)>,
}

/// Owner of flags.
pub trait Owner {
    /// Verb that has the flags; `None` for the flags that all verbs with the settings have.
    const VERB: Option<&'static str>;
}

/// Owner of the flags that all verbs with the settings have.
#[derive(Debug, Clone)]
pub struct Shared;

impl Owner for Shared {
    const VERB: Option<&'static str> = None;
}

/// Value of a flag.
#[derive(Debug, Clone)]
enum Given {
    /// Whole number, which may be larger than those of a `Value`.
    Whole(u64),
    Other(Value),
}

impl<S: Declared, O: Owner> SettingsArgs<S, O> {
    /// Settings of the configuration, if there is one, with those of the flags.
    ///
    /// # Errors
    /// If the configuration cannot be read.
    pub fn settings(&self, configuration: Option<&Path>) -> Result<S> {
        let mut settings = configuration.map_or(Ok(S::default()), read_toml)?;
        self.override_in(&mut settings)?;
        Ok(settings)
    }

    /// Overrides settings with the flags.
    ///
    /// # Errors
    /// For a number that a setting cannot hold.
    pub fn override_in(&self, settings: &mut S) -> Result<()> {
        for (key, given) in &self.given {
            match given {
                Given::Whole(whole) => settings.set(key, serde_json::Value::from(*whole))?,
                Given::Other(value) => settings.set(key, value.clone())?,
            }
        }
        Ok(())
    }

    /// Whether the flag of a key was given.
    pub fn has(&self, key: &str) -> bool {
        self.given.iter().any(|(given, _)| *given == key)
    }
}

impl<S: Declared, O: Owner> clap::Args for SettingsArgs<S, O> {
    fn augment_args(command: Command) -> Command {
        declarations::<S, O>().fold(command, |command, declaration| {
            command.arg(argument(declaration))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Declared, O: Owner> clap::FromArgMatches for SettingsArgs<S, O> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = declarations::<S, O>().filter_map(|declaration| {
            let given = given(matches, &declaration)?;
            Some((declaration.key, given))
        });
        Ok(Self {
            given: given.collect(),
            settings: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Declarations of the settings whose flags the owner has.
fn declarations<S: Declared, O: Owner>() -> impl Iterator<Item = Declaration> {
    let declarations = S::declarations().into_iter();
    declarations.filter(|declaration| declaration.verb == O::VERB)
}

/// The flag of a setting.
fn argument(declaration: Declaration) -> Arg {
    let Declaration {
        key,
        flag,
        value_name,
        text,
        kind,
        bounds,
        default,
        verb: _,
    } = declaration;
    let help = match default {
        Some(default) => format!("{text} [default: {default}]"),
        None => text,
    };
    let argument = Arg::new(key).long(flag).value_name(value_name).help(help);
    let range = match bounds {
        Some(Bounds::Real(range)) => range,
        _ => Range::new(f64::MIN, f64::MAX, ""),
    };
    match kind {
        Kind::Real => argument
            .value_parser(range.number())
            .allow_hyphen_values(true),
        Kind::Whole(most) => {
            let range = match bounds {
                Some(Bounds::Whole(range)) => range,
                _ => Count::new(0, most),
            };
            argument.value_parser(range.number::<u64>())
        }
        Kind::Switch(_) => argument.action(ArgAction::SetTrue),
        Kind::Choice(choices) => argument.value_parser(possible_values(choices)),
        Kind::NameOrNumber(check) => argument
            .value_parser(move |text: &str| {
                check(text)?;
                match text.parse() {
                    Ok(number) if !range.holds(number) => Err(format!("give {range}")),
                    _ => Ok(text.to_owned()),
                }
            })
            .allow_hyphen_values(true),
        Kind::Word => argument,
        Kind::Words => argument.action(ArgAction::Append),
        Kind::Reals => argument
            .action(ArgAction::Append)
            .value_parser(range.number())
            .allow_hyphen_values(true),
    }
}

/// The value of a flag, if it was given.
fn given(matches: &ArgMatches, declaration: &Declaration) -> Option<Given> {
    let key = declaration.key;
    let word = || matches.get_one::<String>(key);
    let value = match declaration.kind {
        Kind::Whole(_) => return matches.get_one(key).copied().map(Given::Whole),
        Kind::Real => Value::Float(*matches.get_one(key)?),
        Kind::Switch(value) => matches.get_flag(key).then_some(Value::Boolean(value))?,
        Kind::Choice(_) | Kind::Word => Value::String(word()?.clone()),
        Kind::NameOrNumber(_) => {
            let word = word()?;
            let number = word.parse().map(Value::Float);
            number.unwrap_or_else(|_| Value::String(word.clone()))
        }
        Kind::Words => {
            let words = matches.get_many::<String>(key)?;
            Value::Array(words.cloned().map(Value::String).collect())
        }
        Kind::Reals => {
            let values = matches.get_many::<f64>(key)?;
            Value::Array(values.copied().map(Value::Float).collect())
        }
    };
    Some(Given::Other(value))
}

fn possible_values(choices: &[Choice]) -> PossibleValuesParser {
    PossibleValuesParser::new(choices.iter().map(possible_value))
}

fn possible_value(choice: &Choice) -> PossibleValue {
    match choice.text {
        [] => PossibleValue::new(choice.name),
        text => PossibleValue::new(choice.name).help(paragraph(text)),
    }
}

/// Reader of a flag that chooses by name.
pub fn choice<T: Choices + Send + Sync>() -> impl clap::builder::TypedValueParser<Value = T> {
    use clap::builder::TypedValueParser;
    possible_values(T::CHOICES).try_map(|name| T::from_name(&name).ok_or("no such choice"))
}

/// A value chosen by name, or none for a word that stands for something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chosen<T>(pub Option<T>);

/// Reader of a flag that chooses by name, or something else by this word.
pub fn choice_or<T: Choices + Send + Sync>(
    word: &'static str,
    text: &'static str,
) -> impl clap::builder::TypedValueParser<Value = Chosen<T>> {
    use clap::builder::TypedValueParser;
    let values = T::CHOICES.iter().map(possible_value);
    let other = PossibleValue::new(word).help(text);
    let values = PossibleValuesParser::new([other].into_iter().chain(values));
    values.try_map(move |name| match T::from_name(&name) {
        None if name != word => Err("no such choice"),
        chosen => Ok(Chosen(chosen)),
    })
}
