//! Values of settings by kind: numbers, switches, and enums whose names and texts users see.

use crate::Number;

/// Kinds of values.
///
/// ```
/// use protomer_kernel::setting::{Kind, Setting};
/// assert!(matches!(bool::KIND, Kind::Switch(true)));
/// assert!(matches!(Vec::<f64>::KIND, Kind::Reals));
/// assert!(matches!(Option::<f64>::KIND, Kind::Real), "what may be left out is of the same kind");
/// ```
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// A number.
    Real,
    /// A whole number from zero to the largest.
    Whole(u64),
    /// A switch, which sets this value.
    Switch(bool),
    /// A choice of one of these names.
    Choice(&'static [Choice]),
    /// A name or a number; the function says what is wrong with another text.
    NameOrNumber(fn(&str) -> Result<(), String>),
    /// A word, such as the name of a file.
    Word,
    /// Words, one or several.
    Words,
    /// Numbers, none or several.
    Reals,
}

/// A name that a setting may have, with its description.
///
/// ```
/// use protomer_kernel::setting::Choices;
/// protomer_kernel::choices! {
///     /// Ensembles.
///     pub enum Ensemble {
///         /// Constant volume.
///         Volume = "nvt",
///         /// Constant pressure.
///         Pressure = "npt",
///     }
/// }
/// let names: Vec<&str> = Ensemble::CHOICES.iter().map(|choice| choice.name).collect();
/// assert_eq!(names, ["nvt", "npt"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The word in files and on the command line.
    pub name: &'static str,
    /// Lines of its description.
    pub text: &'static [&'static str],
}

/// A type that a setting may have.
///
/// ```
/// use protomer_kernel::setting::{Kind, Setting};
/// assert!(matches!(u32::KIND, Kind::Whole(4_294_967_295)));
/// assert_eq!((2e-9_f64.text(), None::<f64>.text()), (Some("2e-9".to_owned()), None));
/// ```
pub trait Setting {
    /// Kind of the values.
    const KIND: Kind;

    /// The value as the help shows it as a default; `None` to show nothing.
    fn text(&self) -> Option<String>;
}

impl Setting for f64 {
    const KIND: Kind = Kind::Real;

    fn text(&self) -> Option<String> {
        Some(Number(*self).to_string())
    }
}

macro_rules! whole {
    ($($type:ty),*) => {
        $(impl Setting for $type {
            const KIND: Kind = Kind::Whole(<$type>::MAX as u64);

            fn text(&self) -> Option<String> {
                Some(self.to_string())
            }
        })*
    };
}

whole!(u32, u64, usize);

impl Setting for String {
    const KIND: Kind = Kind::Word;

    fn text(&self) -> Option<String> {
        Some(self.clone())
    }
}

impl Setting for bool {
    const KIND: Kind = Kind::Switch(true);

    fn text(&self) -> Option<String> {
        None
    }
}

impl<T: Setting> Setting for Option<T> {
    const KIND: Kind = T::KIND;

    fn text(&self) -> Option<String> {
        self.as_ref().and_then(T::text)
    }
}

impl Setting for Vec<f64> {
    const KIND: Kind = Kind::Reals;

    fn text(&self) -> Option<String> {
        None
    }
}

/// A type with one value for each name. [`choices!`](crate::choices) implements it.
///
/// ```
/// use protomer_kernel::setting::Choices;
/// protomer_kernel::choices! {
///     /// Sides.
///     pub enum Side {
///         /// The left one.
///         Left = "left",
///         /// The right one.
///         Right = "right",
///     }
/// }
/// assert_eq!(Side::from_name("right").map(Side::name), Some("right"));
/// assert!(Side::from_name("Right").is_none(), "names are taken letter by letter");
/// ```
pub trait Choices: Copy + 'static {
    /// The values in the order of declaration.
    const ALL: &'static [Self];
    /// The names in the order of declaration.
    const CHOICES: &'static [Choice];

    /// The word of this value.
    fn name(self) -> &'static str;

    /// The value of a word; `None` for another word.
    fn from_name(name: &str) -> Option<Self>;
}

/// Declares an enum whose variants are chosen by name, perhaps with a default. Serde writes the names, or, with
/// `files "snake_case"`, those of the variants in this case.
///
/// ```
/// use protomer_kernel::setting::Choices;
///
/// protomer_kernel::choices! {
///     /// Ends of a chain.
///     pub enum End, default Amino {
///         /// Carries the amine.
///         Amino = "n",
///         /// Carries the acid.
///         Carboxyl = "c",
///     }
/// }
///
/// protomer_kernel::choices! {
///     /// Lattices.
///     pub enum Lattice, files "snake_case" {
///         /// Eight neighbours.
///         BodyCentred = "body-centred",
///     }
/// }
///
/// assert_eq!((End::from_name("c"), End::default()), (Some(End::Carboxyl), End::Amino));
/// assert_eq!((End::Amino.name(), End::CHOICES[0].text), ("n", &[" Carries the amine."][..]));
/// assert_eq!(Lattice::BodyCentred.name(), "body-centred");
/// ```
#[macro_export]
macro_rules! choices {
    (@enum [] $(#[$about:meta])* $visible:vis $name:ident {
        $($(#[$text:meta])* $variant:ident = $word:literal),*
    }) => {
        $(#[$about])*
        $visible enum $name {
            $($(#[$text])* #[serde(rename = $word)] $variant),*
        }
    };
    (@enum [$case:literal] $(#[$about:meta])* $visible:vis $name:ident {
        $($(#[$text:meta])* $variant:ident = $word:literal),*
    }) => {
        $(#[$about])*
        #[serde(rename_all = $case)]
        $visible enum $name {
            $($(#[$text])* $variant),*
        }
    };
    (
        $(#[doc = $about:literal])*
        $visible:vis enum $name:ident $(, default $default:ident)? $(, files $case:literal)? {
            $($(#[doc = $text:literal])* $variant:ident = $word:literal),* $(,)?
        }
    ) => {
        $crate::choices! { @enum [$($case)?]
            $(#[doc = $about])*
            #[derive(
                Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ::serde::Serialize, ::serde::Deserialize,
            )]
            $visible $name { $($(#[doc = $text])* $variant = $word),* }
        }

        $(impl Default for $name {
            fn default() -> Self {
                Self::$default
            }
        })?

        impl $crate::setting::Choices for $name {
            const ALL: &'static [Self] = &[$(Self::$variant),*];
            const CHOICES: &'static [$crate::setting::Choice] = &[
                $($crate::setting::Choice { name: $word, text: &[$($text),*] }),*
            ];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word),*
                }
            }

            fn from_name(name: &str) -> Option<Self> {
                match name {
                    $($word => Some(Self::$variant),)*
                    _ => None,
                }
            }
        }

        impl $crate::setting::Setting for $name {
            const KIND: $crate::setting::Kind =
                $crate::setting::Kind::Choice(<Self as $crate::setting::Choices>::CHOICES);

            fn text(&self) -> Option<String> {
                Some($crate::setting::Choices::name(*self).to_owned())
            }
        }
    };
}
