//! The complexes as points: the most telling number against the buried area.

use super::table::ShownScores;
use protomer_plot::{Axis, Figure, Panel, Series, literal};

/// Columns for the two axes, the first that exists; a heading that ends in `_` stands for any salt.
const ACROSS: [&str; 4] = [
    "buried_area_angstrom2",
    "residue_contacts",
    "shape_complementarity",
    "contact_delta_g_kcal_per_mol",
];
const UP: [&str; 6] = [
    "delta_g_kcal_per_mol_",
    "contact_delta_g_kcal_per_mol",
    "energy_kt_",
    "d_ln_k_d_ln_salt",
    "shape_complementarity",
    "residue_contacts",
];

/// The figure of a table; `None` without two columns of numbers.
pub fn figure(scores: &ShownScores) -> Option<Figure> {
    let across = column(scores, &ACROSS, None)?;
    let up = UP
        .iter()
        .filter_map(|name| column(scores, &[name], Some(across)));
    let panels: Vec<Panel> = up.take(2).map(|up| panel(scores, across, up)).collect();
    (!panels.is_empty()).then(|| Figure {
        title: "Complexes".into(),
        caption: String::new(),
        x: Axis::linear(literal(&words(&scores.columns[across]))),
        panels,
    })
}

fn column(scores: &ShownScores, names: &[&str], taken: Option<usize>) -> Option<usize> {
    let is_it = |heading: &str, name: &str| match name.ends_with('_') {
        true => heading.starts_with(name),
        false => heading == name,
    };
    let found = |name: &&str| {
        let mut headings = scores.columns.iter();
        headings.position(|heading| is_it(heading, name))
    };
    names
        .iter()
        .filter_map(found)
        .find(|index| Some(*index) != taken)
}

fn panel(scores: &ShownScores, across: usize, up: usize) -> Panel {
    let point = |row: &Vec<String>| {
        let [x, y] = [across, up].map(|index| row.get(index)?.parse::<f64>().ok());
        Some([x?, y?])
    };
    Panel {
        y: Axis::linear(literal(&words(&scores.columns[up]))),
        series: vec![Series {
            replicas: scores.rows.iter().filter_map(point).collect(),
            ..Series::default()
        }],
    }
}

/// A heading in words, with the unit in parentheses.
pub(super) fn words(heading: &str) -> String {
    let symbols = heading.replace("contact_delta_g", "ΔG°_by_contacts");
    let heading = symbols.replace("delta_g", "ΔG°");
    let heading = heading.as_str();
    let units = [
        ("_angstrom2", " (Å²)"),
        ("_angstrom", " (Å)"),
        ("_kcal_per_mol", " (kcal/mol)"),
        ("_mol_ml_per_g2", " (mol mL/g²)"),
        ("_molar", " (M)"),
        ("_kt", " (kT)"),
    ];
    let mut text = heading.to_owned();
    for (ending, unit) in units {
        if let Some((before, after)) = heading.split_once(ending) {
            text = match after.trim_start_matches('_') {
                "" => format!("{before}{unit}"),
                salt => format!("{before} in {}{unit}", salt.replace("mM", " mM")),
            };
            break;
        }
    }
    text.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_become_labels() {
        assert_eq!(words("energy_kt_150mM"), "energy in 150 mM (kT)");
        assert_eq!(words("buried_area_angstrom2"), "buried area (Å²)");
        assert_eq!(
            words("contact_delta_g_kcal_per_mol"),
            "ΔG° by contacts (kcal/mol)"
        );
    }
}
