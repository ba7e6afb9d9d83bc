//! What to predict: space groups, or something coarser that fewer samples can teach.
//!
//! Proteins are chiral, so their crystals have no mirror planes or inversion: 65 of the 230 space
//! groups remain. They are numbered as in *International Tables for Crystallography*, volume A.

use crate::{LearnError, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The class of samples whose own is too rare.
pub const OTHER: &str = "other";

/// The 65 space groups without mirror images: number, Hermann-Mauguin symbols without spaces (the
/// usual one first).
const SPACE_GROUPS: [(u8, &[&str]); 65] = [
    (1, &["P1", "A1", "B1", "C1", "F1", "I1"]),
    (3, &["P2", "P121", "P112", "P211"]),
    (4, &["P21", "P1211", "P1121", "P2111", "B1211"]),
    (
        5,
        &[
            "C2", "C121", "I2", "I121", "A2", "A121", "B2", "B112", "A112", "I112", "B211", "C211",
            "I211", "I1211", "C1211",
        ],
    ),
    (16, &["P222"]),
    (17, &["P2221", "P2122", "P2212"]),
    (18, &["P21212", "P22121", "P21221"]),
    (19, &["P212121"]),
    (20, &["C2221", "A2122", "B2212"]),
    (21, &["C222", "A222", "B222"]),
    (22, &["F222"]),
    (23, &["I222"]),
    (24, &["I212121"]),
    (75, &["P4", "C4"]),
    (76, &["P41", "C41"]),
    (77, &["P42", "C42"]),
    (78, &["P43", "C43"]),
    (79, &["I4", "F4"]),
    (80, &["I41", "F41"]),
    (89, &["P422", "C422"]),
    (90, &["P4212", "C4221"]),
    (91, &["P4122"]),
    (92, &["P41212"]),
    (93, &["P4222"]),
    (94, &["P42212"]),
    (95, &["P4322"]),
    (96, &["P43212"]),
    (97, &["I422", "F422"]),
    (98, &["I4122", "F4122"]),
    (143, &["P3"]),
    (144, &["P31"]),
    (145, &["P32"]),
    (146, &["R3", "H3"]),
    (149, &["P312"]),
    (150, &["P321"]),
    (151, &["P3112"]),
    (152, &["P3121"]),
    (153, &["P3212"]),
    (154, &["P3221"]),
    (155, &["R32", "H32"]),
    (168, &["P6"]),
    (169, &["P61"]),
    (170, &["P65"]),
    (171, &["P62"]),
    (172, &["P64"]),
    (173, &["P63"]),
    (177, &["P622"]),
    (178, &["P6122"]),
    (179, &["P6522"]),
    (180, &["P6222"]),
    (181, &["P6422"]),
    (182, &["P6322"]),
    (195, &["P23"]),
    (196, &["F23"]),
    (197, &["I23"]),
    (198, &["P213"]),
    (199, &["I213"]),
    (207, &["P432"]),
    (208, &["P4232"]),
    (209, &["F432"]),
    (210, &["F4132"]),
    (211, &["I432"]),
    (212, &["P4332"]),
    (213, &["P4132"]),
    (214, &["I4132"]),
];

/// What a network is to predict.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// The label as it is.
    #[default]
    Label,
    /// One of the 65 space groups by its usual symbol, other settings included.
    SpaceGroup,
    /// One of the 11 point groups without mirror images.
    PointGroup,
    /// One of the 7 crystal systems.
    CrystalSystem,
    /// Whether a direction differs from its opposite in every such crystal: point groups 1, 2, 3, 4
    /// and 6.
    Polar,
}

impl Target {
    /// The class of a label under this target; for all but [`Target::Label`] the label is a space
    /// group, by number or by symbol.
    ///
    /// ```
    /// use protomer_learn::targets::Target;
    /// assert_eq!(Target::SpaceGroup.of("P 1 21 1").unwrap(), "P21");
    /// assert_eq!(Target::PointGroup.of("19").unwrap(), "222");
    /// assert_eq!(Target::Polar.of("H 3").unwrap(), "polar");
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`] if it is no space group that a protein can have.
    pub fn of(self, label: &str) -> Result<String> {
        if self == Self::Label {
            return Ok(label.to_string());
        }
        let (number, symbols) = space_group(label)?;
        let class = match self {
            Self::Label | Self::SpaceGroup => symbols.first().copied().unwrap_or_default(),
            Self::PointGroup => point_group(number),
            Self::CrystalSystem => crystal_system(number),
            Self::Polar if matches!(point_group(number), "1" | "2" | "3" | "4" | "6") => "polar",
            Self::Polar => "non-polar",
        };
        Ok(class.to_string())
    }
}

fn space_group(label: &str) -> Result<(u8, &'static [&'static str])> {
    // Settings (":H") and marks of screw axes ("2(1)", "2_1") do not change the group.
    let before = label.split(':').next().unwrap_or_default();
    let plain: String = before
        .chars()
        .filter(|letter| !letter.is_whitespace() && !"()_".contains(*letter))
        .collect();
    let number = plain.parse::<u16>().ok();
    let is = |(n, symbols): &&(u8, &[&str])| {
        number == Some(u16::from(*n))
            || symbols
                .iter()
                .any(|symbol| symbol.eq_ignore_ascii_case(&plain))
    };
    let unknown = || {
        let reason = "is no space group without mirror images; give a number of International Tables or a symbol";
        LearnError::Settings(format!("{label:?} {reason} such as \"P 21 21 21\""))
    };
    SPACE_GROUPS.iter().find(is).copied().ok_or_else(unknown)
}

fn point_group(number: u8) -> &'static str {
    match number {
        0..=2 => "1",
        3..=15 => "2",
        16..=74 => "222",
        75..=88 => "4",
        89..=142 => "422",
        143..=148 => "3",
        149..=167 => "32",
        168..=176 => "6",
        177..=194 => "622",
        195..=206 => "23",
        _ => "432",
    }
}

fn crystal_system(number: u8) -> &'static str {
    match point_group(number) {
        "1" => "triclinic",
        "2" => "monoclinic",
        "222" => "orthorhombic",
        "4" | "422" => "tetragonal",
        "3" | "32" => "trigonal",
        "6" | "622" => "hexagonal",
        _ => "cubic",
    }
}

/// Classes by name and number.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes {
    /// Names in alphabetical order, [`OTHER`] last if there is one.
    pub names: Vec<String>,
    /// The class of each sample.
    pub labels: Vec<usize>,
}

impl Classes {
    /// The classes of labels under a target. Those with fewer than `least` samples become [`OTHER`]
    /// together.
    ///
    /// # Errors
    /// [`LearnError::Settings`] names a label that the target does not know.
    pub fn of<S: AsRef<str>>(labels: &[S], target: Target, least: usize) -> Result<Self> {
        let classes: Vec<String> = labels
            .iter()
            .map(|label| target.of(label.as_ref()))
            .collect::<Result<_>>()?;
        let mut counts = BTreeMap::<&str, usize>::new();
        for class in &classes {
            *counts.entry(class).or_default() += 1;
        }
        let mut names: Vec<&str> = Vec::new();
        for (class, count) in &counts {
            if *count >= least && *class != OTHER {
                names.push(class);
            }
        }
        // Whatever is not among the names falls to the place behind them.
        let numbers: BTreeMap<&str, usize> = names
            .iter()
            .enumerate()
            .map(|(number, name)| (*name, number))
            .collect();
        let other = names.len();
        let labels: Vec<usize> = classes
            .iter()
            .map(|class| numbers.get(class.as_str()).copied().unwrap_or(other))
            .collect();
        if labels.contains(&other) {
            names.push(OTHER);
        }
        Ok(Self {
            names: names.into_iter().map(String::from).collect(),
            labels,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_table_has_the_known_counts() {
        let count = |target: Target, class: &str| {
            SPACE_GROUPS
                .iter()
                .filter(|(number, _)| target.of(&number.to_string()).unwrap() == class)
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
            let first = Target::SpaceGroup.of(&number.to_string()).unwrap();
            for symbol in symbols {
                assert_eq!(Target::SpaceGroup.of(symbol).unwrap(), first);
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
            assert_eq!(Target::SpaceGroup.of(spelling).unwrap(), "P212121");
        }
        assert_eq!(Target::SpaceGroup.of("R 3 2 :H").unwrap(), "R32");
        assert_eq!(Target::SpaceGroup.of("C 1 2 1").unwrap(), "C2");
        assert_eq!(Target::CrystalSystem.of("P 43 21 2").unwrap(), "tetragonal");
        assert_eq!(Target::PointGroup.of("P 63 2 2").unwrap(), "622");
        for wrong in ["P -1", "P 21/c", "2", "231", "300", "", "banana"] {
            assert!(Target::Polar.of(wrong).is_err(), "{wrong}");
        }
        assert_eq!(Target::Label.of("banana").unwrap(), "banana");
    }

    #[test]
    fn rare_classes_join() {
        let labels = ["b", "a", "b", "c", "d", "a", "b"];
        let classes = Classes::of(&labels, Target::Label, 2).unwrap();
        assert_eq!(classes.names, ["a", "b", "other"]);
        assert_eq!(classes.labels, [1, 0, 1, 2, 2, 0, 1]);
        let all = Classes::of(&labels, Target::Label, 1).unwrap();
        assert_eq!(all.names, ["a", "b", "c", "d"]);
        let named_other = Classes::of(&["other", "z", "z", "other"], Target::Label, 1).unwrap();
        assert_eq!(
            (named_other.names.len(), named_other.labels),
            (2, vec![1, 0, 0, 1])
        );
    }
}
