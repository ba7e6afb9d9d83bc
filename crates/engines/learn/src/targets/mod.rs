//! What to predict: space groups, or something coarser that fewer samples can teach.
//!
//! Proteins are chiral, so their crystals have no mirror planes or inversion: 65 of the 230 space
//! groups remain. They are numbered as in *International Tables for Crystallography*, volume A.

mod space_groups;

use crate::Result;
use crate::error::refuse;
use crate::number_classes::NumberClasses;
use serde::{Deserialize, Serialize};
use space_groups::{crystal_system, point_group, space_group};
use std::collections::BTreeMap;

/// The class of samples whose own class is too rare.
pub const OTHER: &str = "other";

protomer_kernel::choices! {
    /// Quantity that a network is to predict.
    ///
    /// ```
    /// use protomer_learn::targets::Target;
    ///
    /// assert_eq!(Target::SpaceGroup.read("P 1 21 1")?, "P21");
    /// assert_eq!(Target::PointGroup.read("19")?, "222");
    /// assert_eq!(Target::Polar.read("H 3")?, "polar");
    /// assert!(Target::CrystalSystem.read("P -1").is_err(), "it has an inversion");
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// Space groups are by their usual symbols, other settings included. 65 of them, 11 point groups and 7 crystal
    /// systems have no mirror images. In polar ones some direction differs from its opposite: those of the point groups
    /// 1, 2, 3, 4 and 6. Numbers are classes by [`NumberClasses`].
    pub enum Target, default Label, files "snake_case" {
        /// The label of the set, unchanged.
        Label = "label",
        /// The space group; all settings of a group count as one.
        SpaceGroup = "space-group",
        /// The crystal system of the space group.
        CrystalSystem = "crystal-system",
        /// The point group of the space group.
        PointGroup = "point-group",
        /// Whether the space group is polar.
        Polar = "polar",
        /// The label as a number.
        Number = "number",
    }
}

impl Target {
    /// The class of a label under this target; of a number, the number. For all but [`Target::Label`] and
    /// [`Target::Number`] the label is a space group, by number or by symbol.
    ///
    /// ```
    /// use protomer_learn::targets::Target;
    /// assert_eq!(Target::SpaceGroup.read("19")?, "P212121");
    /// assert_eq!(Target::CrystalSystem.read("P 21 21 21")?, "orthorhombic");
    /// assert_eq!((Target::Polar.read("P 1")?, Target::Polar.read("19")?), ("polar".into(), "non-polar".into()));
    /// assert!(Target::SpaceGroup.read("P -1").is_err(), "a mirror image");
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if no crystal of a protein can have
    /// this space group, and if the label is not a finite number.
    pub fn read(self, label: &str) -> Result<String> {
        match self {
            Self::Label => return Ok(label.to_owned()),
            Self::Number => return Ok(number(label)?.to_string()),
            Self::SpaceGroup | Self::PointGroup | Self::CrystalSystem | Self::Polar => {}
        }
        let (number, symbol) = space_group(label)?;
        let class = match self {
            Self::Label | Self::Number | Self::SpaceGroup => symbol,
            Self::PointGroup => point_group(number),
            Self::CrystalSystem => crystal_system(number),
            Self::Polar => match point_group(number) {
                "1" | "2" | "3" | "4" | "6" => "polar",
                _ => "non-polar",
            },
        };
        Ok(class.to_owned())
    }
}

/// The number that a label is.
///
/// ```
/// use protomer_learn::targets::number;
/// assert_eq!(number(" 2.5 ")?, 2.5);
/// assert!(number("large").is_err() && number("inf").is_err());
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if it is not a finite number.
pub fn number(label: &str) -> Result<f64> {
    match label.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => refuse(format!("the label '{label}' is not a finite number")),
    }
}

/// Classes by name and number.
///
/// ```
/// use protomer_learn::targets::{Classes, Target};
///
/// let labels = ["P 21 21 21", "19", "C 1 2 1", "C2", "P 6"];
/// let classes = Classes::from_labels(&labels, Target::SpaceGroup, 2)?;
/// assert_eq!(classes.names, ["C2", "P212121", "other"]);
/// assert_eq!(classes.labels, [1, 1, 0, 0, 2]);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes {
    /// Names in alphabetical order, [`OTHER`] last if there is one; of numbers, ascending.
    pub names: Vec<String>,
    /// The class of each sample.
    pub labels: Vec<usize>,
}

/// A label and how many samples have it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelCount {
    /// The label.
    pub label: String,
    /// Samples that have it.
    pub samples: usize,
}

impl Classes {
    /// The classes of labels under a target. Those with fewer than `least` samples become [`OTHER`]
    /// together.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) names a label that the target does not
    /// know.
    pub fn from_labels<S: AsRef<str>>(labels: &[S], target: Target, least: usize) -> Result<Self> {
        let mut classes = Vec::with_capacity(labels.len());
        for label in labels {
            classes.push(target.read(label.as_ref())?);
        }
        let counts = count(&classes);
        let mut names: Vec<&str> = counts.keys().copied().collect();
        names.retain(|name| counts[name] >= least && *name != OTHER);
        let other = names.len();
        let mut labels = Vec::with_capacity(classes.len());
        for class in &classes {
            labels.push(names.binary_search(&class.as_str()).unwrap_or(other));
        }
        if labels.contains(&other) {
            names.push(OTHER);
        }
        Ok(Self {
            names: names.into_iter().map(String::from).collect(),
            labels,
        })
    }

    /// The classes of numbers.
    pub fn of_numbers(numbers: &[f64], classes: &NumberClasses) -> Self {
        Self {
            names: classes.names(),
            labels: numbers
                .iter()
                .map(|number| classes.class_of(*number))
                .collect(),
        }
    }

    /// Labels, of those from which these classes were made, that became [`OTHER`], in alphabetical
    /// order.
    ///
    /// ```
    /// use protomer_learn::targets::{Classes, Target};
    ///
    /// let labels = ["a", "b", "a", "b", "c", "d", "d"];
    /// let classes = Classes::from_labels(&labels, Target::Label, 2)?;
    /// let joined = classes.joined(&labels);
    /// assert_eq!((joined.len(), &*joined[0].label, joined[0].samples), (1, "c", 1));
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub fn joined<S: AsRef<str>>(&self, labels: &[S]) -> Vec<LabelCount> {
        let mut joined = Vec::new();
        for (label, class) in labels.iter().zip(&self.labels) {
            let is_other = self.names.get(*class).is_some_and(|name| name == OTHER);
            if is_other && label.as_ref() != OTHER {
                joined.push(label);
            }
        }
        let mut counts = Vec::new();
        for (label, samples) in count(&joined) {
            counts.push(LabelCount {
                label: label.to_owned(),
                samples,
            });
        }
        counts
    }
}

fn count<S: AsRef<str>>(names: &[S]) -> BTreeMap<&str, usize> {
    let mut counts = BTreeMap::new();
    for name in names {
        *counts.entry(name.as_ref()).or_default() += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::space_groups::SPACE_GROUPS;
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_table_has_the_known_counts() {
        let count = |target: Target, class: &str| {
            SPACE_GROUPS
                .iter()
                .filter(|(number, _)| target.read(&number.to_string()).unwrap() == class)
                .count()
        };
        let systems = [
            "triclinic",
            "monoclinic",
            "orthorhombic",
            "tetragonal",
            "trigonal",
            "hexagonal",
            "cubic",
        ];
        assert_eq!(
            systems.map(|system| count(Target::CrystalSystem, system)),
            [1, 3, 9, 16, 11, 12, 13]
        );
        let points = [
            "1", "2", "222", "4", "422", "3", "32", "6", "622", "23", "432",
        ];
        assert_eq!(
            points.map(|point| count(Target::PointGroup, point)),
            [1, 3, 9, 6, 10, 4, 7, 6, 6, 5, 8]
        );
        assert_eq!(
            (
                count(Target::Polar, "polar"),
                count(Target::Polar, "non-polar")
            ),
            (20, 45)
        );
    }

    #[test]
    fn no_symbol_means_two_groups_and_symbols_agree_with_numbers() {
        let all: Vec<&str> = SPACE_GROUPS
            .iter()
            .flat_map(|(_, symbols)| symbols.iter().copied())
            .collect();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
        for (number, symbols) in SPACE_GROUPS {
            let first = Target::SpaceGroup.read(&number.to_string()).unwrap();
            for symbol in symbols {
                assert_eq!(Target::SpaceGroup.read(symbol).unwrap(), first);
            }
        }
    }

    #[test]
    fn spellings_of_one_group_agree() {
        for spelling in [
            "P 21 21 21",
            "P212121",
            "p 21 21 21",
            "P2(1)2(1)2(1)",
            "P2_12_12_1",
            "19",
        ] {
            assert_eq!(Target::SpaceGroup.read(spelling).unwrap(), "P212121");
        }
        assert_eq!(Target::SpaceGroup.read("R 3 2 :H").unwrap(), "R32");
        assert_eq!(Target::SpaceGroup.read("C 1 2 1").unwrap(), "C2");
        assert_eq!(
            Target::CrystalSystem.read("P 43 21 2").unwrap(),
            "tetragonal"
        );
        assert_eq!(Target::PointGroup.read("P 63 2 2").unwrap(), "622");
        for wrong in ["P -1", "P 21/c", "2", "231", "300", "", "banana"] {
            assert!(Target::Polar.read(wrong).is_err(), "{wrong}");
        }
        assert_eq!(Target::Label.read("banana").unwrap(), "banana");
        assert_eq!(Target::Number.read(" -1.50e1").unwrap(), "-15");
        for wrong in ["banana", "", "inf", "NaN"] {
            assert!(Target::Number.read(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn rare_classes_join() {
        let labels = ["b", "a", "b", "c", "d", "a", "b"];
        let classes = Classes::from_labels(&labels, Target::Label, 2).unwrap();
        assert_eq!(classes.names, ["a", "b", "other"]);
        assert_eq!(classes.labels, [1, 0, 1, 2, 2, 0, 1]);
        let all = Classes::from_labels(&labels, Target::Label, 1).unwrap();
        assert_eq!(all.names, ["a", "b", "c", "d"]);
        let named_other =
            Classes::from_labels(&["other", "z", "z", "other"], Target::Label, 1).unwrap();
        assert_eq!(
            (named_other.names.len(), named_other.labels),
            (2, vec![1, 0, 0, 1])
        );
    }
    #[test]
    fn joined_labels_are_counted() {
        let labels = ["b", "a", "b", "c", "d", "c", "b"];
        let classes = Classes::from_labels(&labels, Target::Label, 3).unwrap();
        let joined = classes.joined(&labels);
        let found: Vec<_> = joined
            .iter()
            .map(|one| (&*one.label, one.samples))
            .collect();
        assert_eq!(found, [("a", 1), ("c", 2), ("d", 1)]);
        let all = Classes::from_labels(&labels, Target::Label, 1).unwrap();
        assert!(all.joined(&labels).is_empty());
        // A label that is called "other" has not become it.
        let named = Classes::from_labels(&["other", "z"], Target::Label, 1).unwrap();
        assert!(named.joined(&["other", "z"]).is_empty());
    }
}
