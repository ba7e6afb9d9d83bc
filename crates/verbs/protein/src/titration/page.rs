//! The page of a titration.

use super::answer::{self, COLUMNS, FILE, TitrationReport};
use super::directory::{CURVE, GROUPS, PICTURE};
use anyhow::{Result, bail};
use protomer_common::page::{
    Contents, Origin, Part, Section, SettingsText, significant, significant_or_dash,
};
use protomer_results::Record;
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// If the answer is missing or damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let Some(report) = TitrationReport::read(directory)? else {
        bail!(
            "{} has no {FILE}; run titrate again with --force",
            directory.display()
        );
    };
    let mut contents = Contents::new("Titration");
    contents.origin = Origin {
        settings: SettingsText::File(FILE),
        more: Vec::new(),
        note: "A titration depends on the structure and the conditions alone; there is no seed.",
        is_run: false,
    };
    contents.add(results(&report));
    contents.add(groups(&report));
    contents.add(conditions(&report));
    if !report.warnings.is_empty() {
        contents.add(warnings(&report));
    }
    contents.subtitle = report.file;
    Ok(contents)
}

/// Charges, isoelectric point and the curve.
fn results(report: &TitrationReport) -> Section {
    let point = report
        .isoelectric_point
        .map_or("none from 0 to 14".into(), fixed);
    let values = vec![
        ("pH of the charges", significant(report.ph, 4)),
        ("net charge", format!("{} e", signed(report.net_charge_e))),
        (
            "net charge of a body that ingest makes",
            format!("{} e", signed(report.model_net_charge_e)),
        ),
        ("isoelectric point", point),
    ];
    let picture = Part::picture(PICTURE, "Net charge against pH", Some(CURVE));
    Section::new("Results", vec![Part::Values(values), picture])
}

/// Table of the groups, with the causes of their shifts.
fn groups(report: &TitrationReport) -> Section {
    let columns = COLUMNS.to_vec();
    let mut rows = Vec::with_capacity(report.groups.len());
    for group in &report.groups {
        let neighbour = group.strongest_neighbour.as_ref();
        rows.push(vec![
            group.label(),
            or_dash(group.pka, fixed),
            fixed(group.model_pka),
            signed(group.shift_desolvation),
            signed(group.shift_background),
            or_dash(group.shift_neighbours, signed),
            signed(group.charge_e),
            neighbour.map_or("–".into(), |neighbour| {
                format!("{} {}", neighbour.name, signed(neighbour.energy_kt))
            }),
        ]);
    }
    let note = "The pKa is that in water with the shifts by desolvation, by the background of partial \
                charges and by the other groups. A dash stands for a pKa outside −2 to 16.";
    let parts = vec![
        Part::Paragraph(note.into()),
        Part::Table { columns, rows },
        Part::file(GROUPS),
    ];
    Section::new("Groups", parts)
}

fn conditions(report: &TitrationReport) -> Section {
    let salt_millimolar = report.salt_molar.map(|molar| 1e3 * molar);
    let values = vec![
        ("salt (mM)", significant_or_dash(salt_millimolar, 6)),
        (
            "temperature",
            format!("{} K", significant(report.temperature_kelvin, 6)),
        ),
        (
            "relative permittivity inside",
            significant(report.inner_permittivity, 6),
        ),
        ("titratable groups", report.groups.len().to_string()),
    ];
    Section::new("Conditions", vec![Part::Values(values)])
}

fn warnings(report: &TitrationReport) -> Section {
    let warnings = report.warnings.iter().cloned();
    Section::new("Warnings", warnings.map(Part::Paragraph).collect())
}

/// A number with two decimals.
fn fixed(value: f64) -> String {
    format!("{value:.2}").replace('-', "−")
}

/// A number with its sign and two decimals.
fn signed(value: f64) -> String {
    answer::signed(value).replace('-', "−")
}

fn or_dash(value: Option<f64>, shown: fn(f64) -> String) -> String {
    value.map_or("–".into(), shown)
}
