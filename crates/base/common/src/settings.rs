//! Settings that are declared once: name, type, text, default and range of each stand in one place.
//!
//! [`settings!`](crate::settings!) makes the struct, its default, its form in TOML, and a table of the settings. The
//! command line and the reference build their flags from this table.

use crate::range::{Count, Range};
use anyhow::Result;
use protomer_kernel::setting::{Kind, Setting};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::Deref;

/// Range of a setting.
///
/// ```
/// use protomer_common::range::{Count, PH};
/// use protomer_common::settings::Bounds;
/// assert!(matches!(Bounds::from(PH), Bounds::Real(range) if range == PH));
/// assert!(matches!(Bounds::from(Count::new(1, 9)), Bounds::Whole(_)));
/// ```
#[derive(Debug, Clone, Copy)]
pub enum Bounds {
    /// Range of numbers.
    Real(Range),
    /// Range of whole numbers.
    Whole(Count),
}

impl From<Range> for Bounds {
    fn from(range: Range) -> Self {
        Self::Real(range)
    }
}

impl From<Count> for Bounds {
    fn from(range: Count) -> Self {
        Self::Whole(range)
    }
}

/// A setting with a flag, as its declaration has it.
///
/// ```
/// use protomer_common::settings::Declaration;
/// let declaration = Declaration::new("time_step", &[" Time step."], &0.001);
/// assert_eq!((&*declaration.flag, &*declaration.value_name), ("time-step", "TIME_STEP"));
/// assert_eq!(declaration.default.as_deref(), Some("0.001"));
/// ```
#[derive(Debug, Clone)]
pub struct Declaration {
    /// Key in TOML.
    pub key: &'static str,
    /// Flag without its dashes.
    pub flag: String,
    /// Word that stands for the value in the help.
    pub value_name: String,
    /// Description in one paragraph.
    pub text: String,
    /// Kind of the values.
    pub kind: Kind,
    /// Range of the values.
    pub bounds: Option<Bounds>,
    /// The default, or what happens without a value; `None` if that needs no words.
    pub default: Option<String>,
    /// Verb that alone has the flag; `None` if all verbs with these settings have it.
    pub verb: Option<&'static str>,
}

impl Declaration {
    /// Makes the declaration of a key: `--time-step <TIME_STEP>` for `time_step`.
    ///
    /// ```
    /// use protomer_common::settings::Declaration;
    /// let declaration = Declaration::new("most_steps", &[" Limit on the steps."], &None::<u64>);
    /// assert_eq!((&*declaration.flag, &*declaration.text), ("most-steps", "Limit on the steps"));
    /// assert_eq!(declaration.default, None, "nothing stands for a missing value yet");
    /// ```
    pub fn new<T: Setting>(key: &'static str, lines: &[&str], default: &T) -> Self {
        Self {
            key,
            flag: key.replace('_', "-"),
            value_name: key.to_uppercase(),
            text: paragraph(lines),
            kind: T::KIND,
            bounds: None,
            default: default.text(),
            verb: None,
        }
    }

    /// States the range.
    ///
    /// ```
    /// use protomer_common::{range::PH, settings::{Bounds, Declaration}};
    /// let declaration = Declaration::new("ph", &[" The pH."], &7.0).within(PH);
    /// assert!(matches!(declaration.bounds, Some(Bounds::Real(range)) if range.holds(14.0)));
    /// ```
    #[must_use]
    pub fn within(self, bounds: impl Into<Bounds>) -> Self {
        Self {
            bounds: Some(bounds.into()),
            ..self
        }
    }

    /// States what happens without a value.
    ///
    /// ```
    /// use protomer_common::settings::Declaration;
    /// let declaration = Declaration::new("seed", &[" Seed."], &None::<u64>).otherwise("drawn anew");
    /// assert_eq!(declaration.default.as_deref(), Some("drawn anew"));
    /// ```
    #[must_use]
    pub fn otherwise(self, words: &str) -> Self {
        Self {
            default: Some(words.to_owned()),
            ..self
        }
    }

    /// Makes the flag a switch that turns the setting off, with its own text.
    ///
    /// ```
    /// use protomer_common::settings::Declaration;
    /// let declaration = Declaration::new("water", &[" Keeps waters."], &true).off("Removes waters");
    /// assert_eq!((declaration.key, &*declaration.flag), ("water", "no-water"));
    /// ```
    #[must_use]
    pub fn off(self, text: &str) -> Self {
        Self {
            flag: format!("no-{}", self.flag),
            text: text.to_owned(),
            kind: Kind::Switch(false),
            ..self
        }
    }

    /// Names the flag.
    ///
    /// ```
    /// use protomer_common::settings::Declaration;
    /// let declaration = Declaration::new("time_step", &[" Time step."], &0.001).flag("dt");
    /// assert_eq!((declaration.key, &*declaration.flag, &*declaration.value_name), ("time_step", "dt", "DT"));
    /// ```
    #[must_use]
    pub fn flag(self, flag: &str) -> Self {
        Self {
            flag: flag.to_owned(),
            value_name: flag.replace('-', "_").to_uppercase(),
            ..self
        }
    }

    /// Names the value in the help.
    ///
    /// ```
    /// use protomer_common::settings::Declaration;
    /// let declaration = Declaration::new("input", &[" File."], &String::new()).value("FILE");
    /// assert_eq!((&*declaration.flag, &*declaration.value_name), ("input", "FILE"));
    /// ```
    #[must_use]
    pub fn value(self, name: &str) -> Self {
        Self {
            value_name: name.to_owned(),
            ..self
        }
    }

    /// Keeps the flag for one verb.
    ///
    /// ```
    /// use protomer_common::settings::Declaration;
    /// let declaration = Declaration::new("salt", &[" Salt."], &0.1);
    /// assert_eq!(declaration.verb, None, "all verbs have the flag");
    /// assert_eq!(declaration.from("sweep").verb, Some("sweep"));
    /// ```
    #[must_use]
    pub fn from(self, verb: &'static str) -> Self {
        Self {
            verb: Some(verb),
            ..self
        }
    }
}

/// Lines of a doc comment as one paragraph, without the full stop at its end.
///
/// ```
/// use protomer_common::settings::paragraph;
/// assert_eq!(paragraph(&[" Length of", " a step."]), "Length of a step");
/// ```
pub fn paragraph(lines: &[&str]) -> String {
    let mut words = Vec::new();
    for line in lines {
        words.extend(line.split_whitespace());
    }
    let text = words.join(" ");
    text.strip_suffix('.').map_or(text.clone(), str::to_owned)
}

/// Whether a setting has the default of its type, as files may leave it out.
///
/// ```
/// use protomer_common::settings::is_default;
/// assert!(is_default(&0.0) && is_default(&String::new()) && !is_default(&Some(0)));
/// ```
pub fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Settings with a table of their declarations. [`settings!`](crate::settings!) implements it.
pub trait Declared: Default + DeserializeOwned {
    /// The settings with a flag, in the order of their declaration.
    fn declarations() -> Vec<Declaration>;

    /// Sets the setting of a key.
    ///
    /// # Errors
    /// For a value of another kind.
    fn set<'de, D: Deserializer<'de>>(&mut self, key: &str, value: D) -> Result<(), D::Error>;

    /// Checks every number against the range of its declaration.
    ///
    /// # Errors
    /// Names the key, the value and the range.
    fn check_ranges(&self) -> Result<()>;
}

/// One word or several; a file has a single one as a word, several as a list.
///
/// ```
/// use protomer_common::settings::Words;
/// let one = Words::from("6mdr");
/// let several = Words(vec!["6mdr".to_owned(), "5pti".to_owned()]);
/// assert_eq!(serde_json::to_string(&one)?, r#""6mdr""#);
/// assert_eq!(serde_json::to_string(&several)?, r#"["6mdr","5pti"]"#);
/// # Ok::<(), serde_json::Error>(())
/// ```
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
///
/// ```
/// use protomer_common::range::SHARE;
/// use protomer_common::settings::Holds;
/// assert!(SHARE.require_setting("part", &0.5).is_ok());
/// assert!(SHARE.require_setting("part", &None::<f64>).is_ok());
/// assert!(SHARE.require_setting("parts", &vec![0.5, 1.5]).is_err());
/// ```
pub trait Holds<T> {
    /// Refuses a value that is outside the range.
    ///
    /// # Errors
    /// Names the key, the value and the range.
    fn require_setting(&self, key: &str, value: &T) -> Result<()>;
}

impl Holds<f64> for Range {
    fn require_setting(&self, key: &str, value: &f64) -> Result<()> {
        self.require(key, *value)
    }
}

impl Holds<u32> for Count {
    fn require_setting(&self, key: &str, value: &u32) -> Result<()> {
        self.require(key, u64::from(*value))
    }
}

impl Holds<u64> for Count {
    fn require_setting(&self, key: &str, value: &u64) -> Result<()> {
        self.require(key, *value)
    }
}

impl Holds<usize> for Count {
    fn require_setting(&self, key: &str, value: &usize) -> Result<()> {
        self.require(key, *value as u64)
    }
}

impl<T, R: Holds<T>> Holds<Option<T>> for R {
    fn require_setting(&self, key: &str, value: &Option<T>) -> Result<()> {
        value
            .iter()
            .try_for_each(|value| self.require_setting(key, value))
    }
}

impl<T, R: Holds<T>> Holds<Vec<T>> for R {
    fn require_setting(&self, key: &str, values: &Vec<T>) -> Result<()> {
        values
            .iter()
            .try_for_each(|value| self.require_setting(key, value))
    }
}

/// Declares settings: a line each, with type, default (else that of the type), range, and then what differs from the
/// usual, in this order:
///
/// | words | meaning |
/// |---|---|
/// | `otherwise "all"` | what happens without a value, where the default does not say it |
/// | `off "Leave out X"` | `--no-key` turns off what is on by default; the text is that of the flag |
/// | `flag "dt"` | flag with another name than the key |
/// | `value "KT"` | word for the value in the help |
/// | `omit "is_default"` | function that says when files leave the setting out |
/// | `from file` | setting without a flag |
/// | `from sweep` | setting with a flag of this verb only |
///
/// ```
/// use protomer_common::range::Range;
/// use protomer_common::settings::{Declared, is_default};
///
/// protomer_common::settings! {
///     /// Settings of a walk.
///     pub struct Walk {
///         /// Length of a step.
///         step_length: f64 = 0.5, in Range::new(1e-3, 10.0, ""), flag "length";
///         /// Angle at the start.
///         angle: Option<f64>, otherwise "random", omit "is_default";
///         /// Whether the walk may cross itself.
///         crossings: bool = true, off "Avoid places that were visited";
///         /// Places that cannot be entered.
///         walls: Vec<[u32; 2]>, omit "is_default", from file;
///     }
/// }
///
/// let walk = Walk { step_length: 20.0, ..Walk::default() };
/// assert_eq!(walk.check_ranges().unwrap_err().to_string(), "step_length is 20; give 0.001 to 10");
/// let error = Walk::default().set("stride", serde_json::json!(1)).unwrap_err();
/// assert_eq!(error.to_string(), "there is no setting 'stride'");
/// let [length, angle, crossings] = &Walk::declarations()[..] else { panic!() };
/// assert_eq!((&*length.text, length.default.as_deref()), ("Length of a step", Some("0.5")));
/// assert_eq!(angle.default.as_deref(), Some("random"));
/// assert_eq!(crossings.flag, "no-crossings");
/// ```
#[macro_export]
macro_rules! settings {
    (
        $(#[doc = $about:literal])*
        $visible:vis struct $name:ident {
            $(
                $(#[doc = $text:literal])*
                $(#[serde(rename = $key:literal)])?
                $field:ident: $type:ty
                    $(= $default:expr)?
                    $(, in $range:expr)?
                    $(, otherwise $words:literal)?
                    $(, off $off:literal)?
                    $(, flag $flag:literal)?
                    $(, value $value:literal)?
                    $(, omit $omitted:literal)?
                    $(, from $source:ident)?;
            )*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        $visible struct $name {
            $(
                $(#[doc = $text])*
                $(#[serde(rename = $key)])?
                $(#[serde(skip_serializing_if = $omitted)])?
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
                [$($crate::settings!(@declare [$($source)?]
                    $crate::settings::Declaration::new(
                        $crate::settings!(@key $field $($key)?), &[$($text),*], &default.$field)
                        $(.within($range))?
                        $(.otherwise($words))?
                        $(.off($off))?
                        $(.flag($flag))?
                        $(.value($value))?
                )),*]
                .into_iter()
                .flatten()
                .collect()
            }

            fn set<'de, D: ::serde::Deserializer<'de>>(&mut self, key: &str, value: D) -> Result<(), D::Error> {
                match key {
                    $($crate::settings!(@key $field $($key)?) => {
                        self.$field = ::serde::Deserialize::deserialize(value)?;
                        Ok(())
                    })*
                    unknown => Err(::serde::de::Error::custom(format!("there is no setting '{unknown}'"))),
                }
            }

            fn check_ranges(&self) -> ::anyhow::Result<()> {
                $($crate::settings!(@check $crate::settings!(@key $field $($key)?), self.$field $(, $range)?);)*
                Ok(())
            }
        }
    };
    (@key $field:ident) => { stringify!($field) };
    (@key $field:ident $key:literal) => { $key };
    (@check $key:expr, $value:expr) => {};
    (@check $key:expr, $value:expr, $range:expr) => {
        $crate::settings::Holds::require_setting(&$range, $key, &$value)?;
    };
    (@default) => { Default::default() };
    (@default $default:expr) => { $default.into() };
    (@declare [file] $($declaration:tt)*) => { None };
    (@declare [] $declaration:expr) => { Some($declaration) };
    (@declare [$verb:ident] $declaration:expr) => { Some($declaration.from(stringify!($verb))) };
}
