//! The page of a network's elastic constants.

use super::curve::{Curve, CurvePoint};
use super::network_file;
use super::report::{Relax, Report, field, label};
use anyhow::Result;
use protomer_common::page::{
    Contents, Origin, Part, Section, SettingsText, significant, significant_or_dash,
};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::Record;
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let result = Report::read(directory)?;
    network_file::read(&directory.join("network.toml"))?;
    let mut contents = Contents::new("Framework");
    contents.origin = Origin {
        settings: SettingsText::File("network.toml"),
        more: Vec::new(),
        note: "A network's elastic constants depend on network.toml alone; there is no seed.",
        is_run: false,
    };
    if !result.at_rest() {
        contents.problems.push(format!(
            "The network is not at rest: a force of {} kcal/mol/Å is left.",
            significant(result.largest_force_kcal_mol_angstrom, 3)
        ));
    }
    let title = "Moduli against the direction of the load";
    contents.add(Section::new(
        "Results",
        vec![
            moduli(&result),
            Part::picture("polar.svg", title, Some("polar.csv")),
            Part::file("stiffness.csv"),
        ],
    ));
    let loaded = result.curve.as_ref().and_then(stretching);
    let drawing = Part::picture("drawing.svg", "Cells of the network", None);
    contents.add(Section::new(
        "Network",
        vec![
            drawing,
            Part::picture(
                "deformation.svg",
                "The network under its load, moving",
                None,
            ),
            match loaded {
                Some(figure) => Part::figure(figure, "curve.csv"),
                None => Part::file("curve.csv"),
            },
        ],
    ));
    contents.add(conditions(&result));
    contents.subtitle = result.network;
    Ok(contents)
}

/// A table of E, G and ν, with closed formulas where they exist.
fn moduli(report: &Report) -> Part {
    let formula = report.analytic.as_ref().map(|all| &all.analytic.axial);
    let mut columns = vec!["modulus", "network"];
    if formula.is_some() {
        columns.push("closed formula");
    }
    let mut rows = Vec::new();
    for (key, value) in &report.moduli {
        let mut row = vec![label(key), modulus(*value)];
        if let Some(formula) = formula {
            row.push(modulus(field(formula, key)));
        }
        rows.push(row);
    }
    Part::Table { columns, rows }
}

fn modulus(value: Option<f64>) -> String {
    match value {
        Some(value) if value.abs() > 1e20 => "unlimited".into(),
        _ => significant_or_dash(value, 7),
    }
}

/// A figure of strains against stress, if the network was loaded.
fn stretching(curve: &Curve) -> Option<Figure> {
    let axes = curve.points.first()?.strains.keys();
    let series = axes.map(|key| strain(&curve.points, key)).collect();
    Some(Figure {
        title: format!("Loaded along {}", curve.axis),
        caption: "each stress is applied to the previous state".into(),
        x: Axis::linear("nominal stress (GPa)"),
        panels: vec![Panel {
            y: Axis::linear("strain"),
            series,
        }],
    })
}

/// The strain along an axis, from the unloaded network on.
fn strain(points: &[CurvePoint], key: &str) -> Series {
    let mut curve = vec![Point::default()];
    for point in points {
        if let Some(y) = point.strains.get(key) {
            curve.push(Point {
                x: point.nominal_gpa,
                y: *y,
                error: None,
            });
        }
    }
    Series {
        name: format!("along {}", key.trim_start_matches("strain_")),
        points: curve,
        line: true,
        ..Series::default()
    }
}

fn conditions(report: &Report) -> Section {
    let number = |value: f64, unit: &str| format!("{} {unit}", significant(value, 8));
    let counts = [report.nodes, report.rods, report.hinges, report.torsions];
    let relaxed = match report.relaxed {
        None => "as given",
        Some(Relax::FixedCell) => "nodes relaxed in the given cell",
        Some(Relax::FreeCell) => "nodes and cell relaxed",
    };
    let internal = report.internal_mechanisms.map(|count| count as f64);
    let rows = vec![
        (
            "nodes, rods, hinges, torsions",
            counts.map(|count| significant(count as f64, 8)).join(", "),
        ),
        ("volume of the cell", number(report.volume_angstrom3, "Å³")),
        ("Avogadro's number", number(report.avogadro_per_mol, "/mol")),
        (
            "1 kcal/mol/Å³",
            number(report.gpa_per_kcal_mol_angstrom3, "GPa"),
        ),
        ("geometry", relaxed.to_owned()),
        (
            "largest residual force",
            number(report.largest_force_kcal_mol_angstrom, "kcal/mol/Å"),
        ),
        ("zero-energy strains", report.mechanisms.len().to_string()),
        (
            "floppy motions of the nodes at fixed cell",
            significant_or_dash(internal, 8),
        ),
    ];
    Section::new("Conditions", vec![Part::Values(rows)])
}
