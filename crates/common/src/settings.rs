//! Settings that are declared once: name, type, text, default and range of each stand in one place.
//!
//! [`settings!`](crate::settings!) makes the struct, its default, its form in TOML, and a table of the settings. The
//! command line and the reference build their flags from this table.

use crate::range::{Count, Range};
use anyhow::Result;
use protomer_kernel::setting::{Kind, Setting};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::Deref;

/// A setting as its declaration has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// Key in TOML.
    pub key: &'static str,
    /// Description in one paragraph.
    pub text: String,
    /// Kind of the values.
    pub kind: Kind,
    /// The default, or what happens without a value; `None` if that needs no words.
    pub default: Option<String>,
}

impl Declaration {
    /// Makes a declaration from its parts.
    pub fn new<T: Setting>(
        key: &'static str,
        lines: &[&str],
        default: &T,
        otherwise: Option<&str>,
    ) -> Self {
        Self {
            key,
            text: paragraph(lines),
            kind: T::KIND,
            default: otherwise.map(str::to_owned).or_else(|| default.text()),
        }
    }
}

/// Lines of a doc comment as one paragraph, without the full stop at its end.
pub fn paragraph(lines: &[&str]) -> String {
    let mut words = Vec::new();
    for line in lines {
        words.extend(line.split_whitespace());
    }
    let text = words.join(" ");
    text.strip_suffix('.').map_or(text.clone(), str::to_owned)
}

/// The flag of a key: `--time-step` for `time_step`.
pub fn flag(key: &str) -> String {
    format!("--{}", key.replace('_', "-"))
}

/// Settings with a table of their declarations. [`settings!`](crate::settings!) implements it.
pub trait Declared: Default + Serialize + for<'de> Deserialize<'de> {
    /// The settings in the order of their declaration.
    fn declarations() -> Vec<Declaration>;

    /// Checks every number against the range of its declaration.
    ///
    /// # Errors
    /// Names the flag, the value and the range.
    fn check_ranges(&self) -> Result<()>;
}

/// One word or several; a file has a single one as a word, several as a list.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Words(pub Vec<String>);

impl Deref for Words {
    type Target = Vec<String>;

    fn deref(&self) -> &Vec<String> {
        &self.0
    }
}

impl From<&str> for Words {
    fn from(word: &str) -> Self {
        Self(vec![word.to_owned()])
    }
}

impl Setting for Words {
    const KIND: Kind = Kind::Words;

    fn text(&self) -> Option<String> {
        Some(self.join(" "))
    }
}

impl Serialize for Words {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0[..] {
            [word] => word.serialize(serializer),
            words => words.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Words {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            One(String),
            Several(Vec<String>),
        }
        Ok(match Form::deserialize(deserializer)? {
            Form::One(word) => Self(vec![word]),
            Form::Several(words) => Self(words),
        })
    }
}

/// A range that a setting of a type can be held against.
pub trait Holds<T> {
    /// Refuses a value that is outside the range.
    ///
    /// # Errors
    /// Names the flag, the value and the range.
    fn require_setting(&self, key: &str, value: &T) -> Result<()>;
}

impl Holds<f64> for Range {
    fn require_setting(&self, key: &str, value: &f64) -> Result<()> {
        self.require(&flag(key), *value)
    }
}

impl Holds<Option<f64>> for Range {
    fn require_setting(&self, key: &str, value: &Option<f64>) -> Result<()> {
        value.map_or(Ok(()), |value| self.require_setting(key, &value))
    }
}

impl Holds<Vec<f64>> for Range {
    fn require_setting(&self, key: &str, values: &Vec<f64>) -> Result<()> {
        values
            .iter()
            .try_for_each(|value| self.require_setting(key, value))
    }
}

impl Holds<u64> for Count {
    fn require_setting(&self, key: &str, value: &u64) -> Result<()> {
        self.require(&flag(key), *value)
    }
}

impl Holds<usize> for Count {
    fn require_setting(&self, key: &str, value: &usize) -> Result<()> {
        self.require_setting(key, &(*value as u64))
    }
}

/// Declares settings: a line each, with type, default (else that of the type), range, and what happens without a
/// value where the default does not say it.
///
/// ```
/// use protomer_common::range::Range;
/// use protomer_common::settings::Declared;
///
/// protomer_common::settings! {
///     /// Settings of a walk.
///     pub struct Walk {
///         /// Length of a step.
///         step_length: f64 = 0.5, in Range::new(1e-3, 10.0, "");
///         /// Angle at the start.
///         angle: Option<f64>, otherwise "random";
///     }
/// }
///
/// let walk = Walk { step_length: 20.0, ..Walk::default() };
/// assert_eq!(walk.check_ranges().unwrap_err().to_string(), "--step-length is 20; give 0.001 to 10");
/// let [length, angle] = &Walk::declarations()[..] else { panic!() };
/// assert_eq!((&*length.text, length.default.as_deref()), ("Length of a step", Some("0.5")));
/// assert_eq!(angle.default.as_deref(), Some("random"));
/// ```
#[macro_export]
macro_rules! settings {
    (
        $(#[doc = $about:literal])*
        $visible:vis struct $name:ident {
            $(
                $(#[doc = $text:literal])*
                $field:ident: $type:ty
                    $(= $default:expr)?
                    $(, in $range:expr)?
                    $(, otherwise $words:literal)?;
            )*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        $visible struct $name {
            $(
                $(#[doc = $text])*
                #[serde(skip_serializing_if = "::protomer_kernel::setting::Setting::is_absent")]
                pub $field: $type,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $crate::settings!(@default $($default)?)),* }
            }
        }

        impl $crate::settings::Declared for $name {
            fn declarations() -> Vec<$crate::settings::Declaration> {
                let default = Self::default();
                vec![$($crate::settings::Declaration::new(
                    stringify!($field),
                    &[$($text),*],
                    &default.$field,
                    $crate::settings!(@words $($words)?),
                )),*]
            }

            fn check_ranges(&self) -> ::anyhow::Result<()> {
                $($($crate::settings::Holds::require_setting(&$range, stringify!($field), &self.$field)?;)?)*
                Ok(())
            }
        }
    };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default.into() };
    (@words) => { None };
    (@words $words:literal) => { Some($words) };
}
