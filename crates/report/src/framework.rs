//! The page of a network's elastic constants.

use super::html::{definitions, paragraph, significant, table};
use super::page::{Page, Section};
use super::{data, figures, provenance};
use anyhow::{Context, Result};
use protomer_lattices::frameworks::network_file;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::keys;
use serde_json::{Map, Value};
use std::path::Path;

/// Force (kcal/mol/Å) above which a network is not at rest.
const REST_FORCE: f64 = 1e-3;

/// The page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path) -> Result<Page> {
    let path = directory.join("result.json");
    let bytes = protomer_io::input::read(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let result: Map<String, Value> = keys::from_json(&path, &bytes)?;
    network_file::read(&directory.join("network.toml"))?;
    let text = |key: &str| {
        result
            .get(key)
            .and_then(Value::as_str)
            .unwrap_or_default()
            .to_owned()
    };
    let mut problems = Vec::new();
    let force = result
        .get("largest_force_kcal_mol_angstrom")
        .and_then(Value::as_f64)
        .unwrap_or(0.0);
    if force > REST_FORCE {
        problems.push(format!(
            "The network is not at rest: a force of {} kcal/mol/Å is left.",
            significant(force, 3)
        ));
    }
    let mut results = moduli(&result);
    let polar = data::of_file(directory, "polar.csv")?;
    results += &match directory.join("polar.svg").is_file() {
        true => figures::of_file(
            directory,
            "polar.svg",
            "Moduli against the direction of the load",
            &polar,
        )?,
        false => polar,
    };
    results += &data::of_file(directory, "stiffness.csv")?;
    let mut drawing = figures::of_file(directory, "drawing.svg", "Cells of the network", "")?;
    let curve = data::of_file(directory, "curve.csv")?;
    drawing += &match stretching(&result) {
        Some(figure) => figures::drawn(&figure, &curve)?,
        None => curve,
    };
    let about = "A network's elastic constants depend on network.toml alone; there is no seed.";
    let mut provenance = provenance::section(directory, "network.toml", None, Vec::new())?;
    provenance.html += &paragraph(about);
    Ok(Page {
        title: format!("Framework: {}", provenance::name(directory)),
        subtitle: text("network"),
        verdict: None,
        problems,
        sections: vec![
            Section::new("Results", results),
            Section::new("Network", drawing),
            conditions(&result),
            provenance,
        ],
    })
}

/// A table of E, G and ν, with closed formulas where they exist.
fn moduli(result: &Map<String, Value>) -> String {
    let formula = result.get("analytic").and_then(Value::as_object);
    let mut head = vec!["modulus".to_owned(), "network".to_owned()];
    if formula.is_some() {
        head.push("closed formula".to_owned());
    }
    let mut rows = Vec::new();
    for (key, value) in result {
        if !is_modulus(key) || !(value.is_number() || value.is_null()) {
            continue;
        }
        let mut row = vec![label(key), modulus(Some(value))];
        if let Some(formula) = formula {
            row.push(modulus(formula.get(key)));
        }
        rows.push(row);
    }
    table(&head, &rows)
}

fn is_modulus(key: &str) -> bool {
    key.starts_with("e_") || key.starts_with("g_") || key.starts_with("nu_")
}

fn modulus(value: Option<&Value>) -> String {
    match value.and_then(Value::as_f64) {
        Some(value) if value.abs() > 1e20 => "unlimited".into(),
        Some(value) => significant(value, 7),
        None => "–".to_owned(),
    }
}

/// Label of a key: `e_y_gpa` becomes `E_y (GPa)`.
fn label(key: &str) -> String {
    let unit = if key.ends_with("_gpa") { " (GPa)" } else { "" };
    let name = key.trim_end_matches("_gpa");
    let name = match name.split_once('_') {
        Some(("e", axis)) => format!("E_{axis}"),
        Some(("g", axes)) => format!("G_{axes}"),
        Some((_, axes)) => format!("ν_{axes}"),
        None => name.to_owned(),
    };
    name + unit
}

/// A figure of strains against stress, if the network was loaded.
fn stretching(result: &Map<String, Value>) -> Option<Figure> {
    let curve = result.get("curve")?;
    let points = curve["points"].as_array()?;
    let mut series = Vec::new();
    for key in points.first()?.as_object()?.keys() {
        if let Some(axis) = key.strip_prefix("strain_") {
            series.push(strain(points, key, axis));
        }
    }
    Some(Figure {
        title: format!("Loaded along {}", curve["axis"].as_str()?),
        caption: "each stress is applied to the previous state".into(),
        x: Axis::linear("nominal stress (GPa)"),
        panels: vec![Panel {
            y: Axis::linear("strain"),
            series,
        }],
    })
}

/// The strain along an axis, from the unloaded network on.
fn strain(points: &[Value], key: &str, axis: &str) -> Series {
    let mut curve = vec![Point::default()];
    for point in points {
        if let (Some(x), Some(y)) = (point["nominal_gpa"].as_f64(), point[key].as_f64()) {
            curve.push(Point { x, y, error: None });
        }
    }
    Series {
        name: format!("along {axis}"),
        points: curve,
        line: true,
        ..Series::default()
    }
}

fn conditions(result: &Map<String, Value>) -> Section {
    let number = |key: &str, unit: &str| {
        let value = result.get(key).and_then(Value::as_f64);
        value.map_or_else(
            || "–".to_owned(),
            |value| {
                format!("{} {unit}", significant(value, 8))
                    .trim_end()
                    .to_owned()
            },
        )
    };
    let mechanisms = result
        .get("mechanisms")
        .and_then(Value::as_array)
        .map_or(0, Vec::len);
    let relaxed = match result.get("relaxed").and_then(Value::as_str) {
        None => "as given",
        Some("fixed_cell") => "nodes relaxed in the given cell",
        Some(_) => "nodes and cell relaxed",
    };
    let rows = [
        (
            "nodes, rods, hinges, torsions",
            ["nodes", "rods", "hinges", "torsions"]
                .map(|key| number(key, ""))
                .join(", "),
        ),
        ("volume of the cell", number("volume_angstrom3", "Å³")),
        ("Avogadro's number", number("avogadro_per_mol", "/mol")),
        ("1 kcal/mol/Å³", number("gpa_per_kcal_mol_angstrom3", "GPa")),
        ("geometry", relaxed.to_owned()),
        (
            "largest residual force",
            number("largest_force_kcal_mol_angstrom", "kcal/mol/Å"),
        ),
        ("zero-energy strains", mechanisms.to_string()),
        (
            "floppy motions of the nodes at fixed cell",
            number("internal_mechanisms", ""),
        ),
    ];
    Section::new("Conditions", definitions(&rows))
}
