//! The 65 space groups of chiral molecules.

use crate::Result;
use crate::error::refuse;

/// Number and Hermann-Mauguin symbols without spaces, the usual one first.
pub(super) const SPACE_GROUPS: [(u8, &[&str]); 65] = [
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

/// The number of a space group, and its usual symbol.
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if it is not one of the 65.
pub(super) fn space_group(label: &str) -> Result<(u8, &'static str)> {
    let plain = plain(label);
    let number = plain.parse::<u8>().ok();
    for (group, symbols) in SPACE_GROUPS {
        let is_named = symbols
            .iter()
            .any(|symbol| symbol.eq_ignore_ascii_case(&plain));
        if is_named || number == Some(group) {
            return Ok((group, symbols[0]));
        }
    }
    refuse(format!(
        "{label:?} is no space group without mirror images; give a number of International \
         Tables or a symbol such as \"P 21 21 21\""
    ))
}

/// The symbol without blanks. Settings (":H") and marks of screw axes ("2(1)", "2_1") do not change
/// the group.
fn plain(label: &str) -> String {
    let symbol = label.split(':').next().unwrap_or_default();
    symbol.replace(
        |letter: char| letter.is_whitespace() || "()_".contains(letter),
        "",
    )
}

/// The point group of a space group.
pub(super) fn point_group(number: u8) -> &'static str {
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

/// The crystal system of a space group.
pub(super) fn crystal_system(number: u8) -> &'static str {
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
