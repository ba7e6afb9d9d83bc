//! The seam between the terms of an energy and their users: each term is a function of the relative
//! pose of two bodies that do not overlap.

use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::AddAssign;
use std::sync::Arc;

/// One term of the energy of two bodies in addition to their hard surfaces.
///
/// ```
/// use protomer_kernel::{RelativePose, Pose, Vec3};
/// use protomer_mc::pair::{PairPotential, Term, Terms};
/// use std::sync::Arc;
///
/// struct SquareWell;
///
/// impl PairPotential for SquareWell {
///     fn term(&self) -> Term {
///         Term::Contacts
///     }
///     fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
///         if second_in_first.translation.norm() < 10.0 { -2.0 } else { 0.0 }
///     }
///     fn shares(&self, pose: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64)) {
///         take(0, &Vec3::zeros(), self.energy_kt(pose));
///     }
///     fn reach_angstrom(&self, _: f64) -> f64 {
///         10.0
///     }
///     fn tail_angstrom3(&self, _: f64) -> f64 {
///         0.0
///     }
/// }
///
/// let terms = Terms(vec![Arc::new(SquareWell), Arc::new(SquareWell)]);
/// let pose = Pose::identity();
/// let apart = |x| RelativePose::new(&pose, &pose, &Vec3::new(x, 0.0, 0.0));
/// assert_eq!((terms.energy_kt(&apart(9.0)), terms.energy_kt(&apart(11.0))), (-4.0, 0.0));
/// ```
pub trait PairPotential: Send + Sync {
    /// Kind of the term.
    fn term(&self) -> Term;

    /// The energy at a pose of the second body in the frame of the first, kT.
    fn energy_kt(&self, second_in_first: &RelativePose) -> f64;

    /// Hands out which places of which body hold how much of the energy: body (0 or 1), place in the
    /// frame of that body (Å), energy (kT). A pair of places counts in full with both bodies;
    /// displaced solvent counts with the body that displaces it, and the response of the solvent with
    /// the charges and the volume that it acts on.
    fn shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64));

    /// Hands out which pairs of places hold how much of the energy, for a term that is a sum over
    /// pairs: place of the first and of the second body, each in the frame of its body (Å), energy
    /// (kT). Another term hands out nothing.
    fn pair_shares(&self, _: &RelativePose, _: &mut dyn FnMut(&Vec3, &Vec3, f64)) {}

    /// The distance of the origins beyond which no energy is larger than `energy_kt`, Å.
    fn reach_angstrom(&self, energy_kt: f64) -> f64;

    /// ∫ <exp(-U) - 1> d³R over all distances of the origins beyond `distance_angstrom`, to first
    /// order in U, Å³.
    fn tail_angstrom3(&self, distance_angstrom: f64) -> f64;
}

/// Declares the terms of an energy: first those that are sums over pairs of places, then those that belong
/// to single places of one body. Each has its description, its variant of [`Term`], its field of
/// [`EnergyParts`], its name in JSON, the word for it in tables, and its name in a sentence. Statistics, answers,
/// tables and pages of the terms follow from this list.
macro_rules! energy_terms {
    (
        pairs { $($(#[doc = $pair_text:literal])* $(#[serde($pair_serde:meta)])?
            $pair:ident: $pair_part:ident, $pair_name:literal, $pair_word:literal, $pair_phrase:literal;)* }
        places { $($(#[doc = $text:literal])* $(#[serde($serde:meta)])?
            $term:ident: $part:ident, $name:literal, $word:literal, $phrase:literal;)* }
    ) => {
        /// The terms of an energy.
        ///
        /// ```
        /// use protomer_mc::pair::Term;
        /// assert_eq!(Term::SolventResponse.name(), "solvent_response");
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Term {
            $($(#[doc = $pair_text])* $pair,)*
            $($(#[doc = $text])* $term,)*
        }

        impl Term {
            /// All terms, in the order of [`EnergyParts::values`].
            pub const ALL: [Self; TERMS] = [$(Self::$pair,)* $(Self::$term),*];

            /// Whether the term is a sum over pairs of places, as [`PairPotential::pair_shares`] hands them out.
            pub fn is_sum_over_pairs(self) -> bool {
                matches!(self, $(Self::$pair)|*)
            }

            /// Name of the term in answers.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$pair => $pair_name,)*
                    $(Self::$term => $name,)*
                }
            }

            /// Key of the energy of the term in JSON and in tables.
            ///
            /// ```
            /// assert_eq!(protomer_mc::pair::Term::Charges.key(), "charges_kt");
            /// ```
            pub fn key(self) -> &'static str {
                match self {
                    $(Self::$pair => stringify!($pair_part),)*
                    $(Self::$term => stringify!($part),)*
                }
            }

            /// Word for the term in the headings of tables.
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$pair => $pair_word,)*
                    $(Self::$term => $word,)*
                }
            }

            /// Name of the term in a sentence.
            pub fn phrase(self) -> &'static str {
                match self {
                    $(Self::$pair => $pair_phrase,)*
                    $(Self::$term => $phrase,)*
                }
            }
        }

        /// Number of terms.
        pub(crate) const TERMS: usize = [$($pair_name,)* $($name),*].len();
        /// Number of terms that are sums over pairs of places.
        pub(crate) const PAIR_TERMS: usize = [$($pair_name),*].len();

        /// The energy of a pose by terms, kT, or something else of each term.
        ///
        /// ```
        /// use protomer_mc::pair::{EnergyParts, Term};
        /// let mut parts = EnergyParts { charges_kt: -3.0, ..EnergyParts::default() };
        /// parts.add(Term::Contacts, -1.5);
        /// parts += EnergyParts { desolvation_kt: 0.5, ..EnergyParts::default() };
        /// assert_eq!((parts.part_kt(Term::Contacts), parts.total_kt()), (-1.5, -4.0));
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
        pub struct EnergyParts<T = f64> {
            $($(#[doc = $pair_text])* $(#[serde($pair_serde)])? pub $pair_part: T,)*
            $($(#[doc = $text])* $(#[serde($serde)])? pub $part: T,)*
        }

        impl<T: Copy> EnergyParts<T> {
            /// The parts, by the values of [`Term::ALL`].
            pub fn from_values(values: [T; TERMS]) -> Self {
                let [$($pair_part,)* $($part),*] = values;
                Self { $($pair_part,)* $($part),* }
            }

            /// The parts in the order of [`Term::ALL`].
            pub fn values(&self) -> [T; TERMS] {
                [$(self.$pair_part,)* $(self.$part),*]
            }

            /// The part of one term, kT.
            pub fn part_kt(&self, term: Term) -> T {
                match term {
                    $(Term::$pair => self.$pair_part,)*
                    $(Term::$term => self.$part,)*
                }
            }
        }

        impl EnergyParts {
            /// Adds an energy (kT) to the part of its term.
            pub fn add(&mut self, term: Term, energy_kt: f64) {
                match term {
                    $(Term::$pair => self.$pair_part += energy_kt,)*
                    $(Term::$term => self.$part += energy_kt,)*
                }
            }
        }

        impl AddAssign<PairParts> for EnergyParts {
            fn add_assign(&mut self, pair: PairParts) {
                $(self.$pair_part += pair.$pair_part;)*
            }
        }

        /// The energy of a pair of places, kT, by those terms that are sums over pairs.
        ///
        /// ```
        /// use protomer_mc::pair::{EnergyParts, PairParts, Term};
        /// let mut pair = PairParts { charges_kt: -0.5, ..PairParts::default() };
        /// pair.add(Term::Contacts, -1.5);
        /// let mut sum = EnergyParts::default();
        /// sum += pair;
        /// assert_eq!((sum.total_kt(), pair.total_kt()), (-2.0, -2.0));
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
        pub struct PairParts {
            $($(#[doc = $pair_text])* $(#[serde($pair_serde)])? pub $pair_part: f64,)*
        }

        impl PairParts {
            /// The parts, by the values of the first terms of [`Term::ALL`].
            pub fn from_values(values: [f64; PAIR_TERMS]) -> Self {
                let [$($pair_part),*] = values;
                Self { $($pair_part),* }
            }

            /// The parts in the order of [`Term::ALL`].
            pub fn values(&self) -> [f64; PAIR_TERMS] {
                [$(self.$pair_part),*]
            }

            /// Adds an energy (kT) to the part of its term; nothing for a term that belongs to single places.
            pub fn add(&mut self, term: Term, energy_kt: f64) {
                match term {
                    $(Term::$pair => self.$pair_part += energy_kt,)*
                    $(Term::$term)|* => {}
                }
            }
        }
    };
}

energy_terms! {
    pairs {
        /// Screened charges.
        Charges: charges_kt, "charges", "charges", "charges";
        /// Attraction between residues.
        Contacts: contacts_kt, "contacts", "contacts", "attraction between residues";
    }
    places {
        /// Energy that charges lose where the other body displaces solvent.
        #[serde(default)]
        Desolvation: desolvation_kt, "desolvation", "desolvation", "desolvation";
        /// Effect of the salt water that two bodies displace on the field of each other.
        #[serde(default)]
        SolventResponse: solvent_response_kt, "solvent_response", "response", "response of the solvent";
    }
}

impl EnergyParts {
    /// The sum of the terms, kT.
    pub fn total_kt(&self) -> f64 {
        self.values().iter().sum()
    }
}

impl AddAssign for EnergyParts {
    fn add_assign(&mut self, other: Self) {
        for (term, energy_kt) in Term::ALL.into_iter().zip(other.values()) {
            self.add(term, energy_kt);
        }
    }
}

impl AddAssign for PairParts {
    fn add_assign(&mut self, other: Self) {
        for (term, energy_kt) in Term::ALL.into_iter().zip(other.values()) {
            self.add(term, energy_kt);
        }
    }
}

impl PairParts {
    /// The sum of the terms, kT.
    pub fn total_kt(&self) -> f64 {
        self.values().iter().sum()
    }
}

/// All terms of an energy; none for hard bodies.
///
/// ```
/// use protomer_kernel::{Pose, RelativePose, Vec3, potential::Yukawa};
/// use protomer_mc::charges::ChargeCloud;
/// use protomer_mc::pair::{Charged, Term, Terms};
/// use std::sync::Arc;
/// let yukawa = Yukawa::uncut(7.0, 0.1)?;
/// let [plus, minus] = [1.0, -1.0].map(|charge| ChargeCloud::new(&[(Vec3::zeros(), charge)]));
/// let terms = Terms(vec![Arc::new(Charged::new(yukawa, &plus, &minus)?)]);
/// let apart = RelativePose::new(&Pose::identity(), &Pose::identity(), &Vec3::new(10.0, 0.0, 0.0));
/// assert!((terms.parts_kt(&apart).part_kt(Term::Charges) + yukawa.energy_kt(10.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
pub struct Terms(pub Vec<Arc<dyn PairPotential>>);

/// Terms of the energy of each two kinds of bodies, the lower kind first.
pub type TermsOfKinds = BTreeMap<(usize, usize), Terms>;

impl Terms {
    /// The energy at a pose of the second body in the frame of the first, kT.
    pub fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
        let mut sum = 0.0;
        for term in &self.0 {
            sum += term.energy_kt(second_in_first);
        }
        sum
    }

    /// The energy at a pose of the second body in the frame of the first, term by term.
    pub fn parts_kt(&self, second_in_first: &RelativePose) -> EnergyParts {
        let mut parts = EnergyParts::default();
        for term in &self.0 {
            parts.add(term.term(), term.energy_kt(second_in_first));
        }
        parts
    }

    /// The distance of the origins beyond which no term is larger than `energy_kt`, Å.
    pub fn reach_angstrom(&self, energy_kt: f64) -> f64 {
        let mut reach: f64 = 0.0;
        for term in &self.0 {
            reach = reach.max(term.reach_angstrom(energy_kt));
        }
        reach
    }

    /// ∫ <exp(-U) - 1> d³R beyond a distance of the origins, to first order in U, Å³.
    pub fn tail_angstrom3(&self, distance_angstrom: f64) -> f64 {
        let mut sum = 0.0;
        for term in &self.0 {
            sum += term.tail_angstrom3(distance_angstrom);
        }
        sum
    }
}
