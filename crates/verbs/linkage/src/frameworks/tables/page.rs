//! The page of the recomputed tables.

use super::{Agreement, Row, describe, legend};
use anyhow::{Context, Result};
use protomer_common::page::{Contents, Data, Origin, Part, Section, SettingsText};
use protomer_io::csv::{Cell, Table};
use protomer_results::{Record, keys};
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let path = directory.join("tables.json");
    let bytes = protomer_io::input::read(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let rows: Vec<Row> = keys::from_json(&path, &bytes)?;
    let mut results = vec![counts(&rows)];
    for (title, mut rows) in describe(&rows) {
        let columns = if rows.is_empty() {
            Vec::new()
        } else {
            rows.remove(0)
        };
        results.push(Part::Heading(title));
        results.push(Part::Compact { columns, rows });
    }
    results.push(Part::Data(Data::Table {
        name: "tables.csv".into(),
        csv: long(&rows)?.to_csv()?,
    }));
    let mut contents = Contents::new("Tables of networks");
    contents.subtitle = "Elastic constants of honeycombs, printed and recomputed".into();
    contents.origin = Origin {
        settings: SettingsText::None,
        more: vec![("command", "protomer framework tables".into())],
        note: "",
        is_run: false,
    };
    contents.add(Section::new("Results", results));
    let reading = legend(&rows);
    let reading = reading.lines().map(|line| Part::Paragraph(line.to_owned()));
    contents.add(Section::new("How to read the tables", reading.collect()));
    Ok(contents)
}

fn counts(rows: &[Row]) -> Part {
    let values = || rows.iter().flat_map(|row| &row.values);
    let count = |agreement: Agreement| {
        values()
            .filter(|value| value.agreement == agreement)
            .count()
            .to_string()
    };
    let largest = values()
        .map(|value| value.deviation.abs())
        .fold(0.0, f64::max);
    Part::Values(vec![
        ("numbers", values().count().to_string()),
        ("the same to the last printed digit", count(Agreement::Same)),
        ("off by one unit of it", count(Agreement::OneUnit)),
        ("further off", count(Agreement::Off)),
        ("largest deviation", format!("{:.3} %", 100.0 * largest)),
    ])
}

/// A row for each number.
fn long(rows: &[Row]) -> Result<Table> {
    let head = [
        "table",
        "mechanism",
        "theta_deg",
        "method",
        "cells",
        "avogadro_per_mol",
        "quantity",
        "computed",
    ];
    let mut table = Table::new(
        head.into_iter()
            .chain(["printed", "agreement", "deviation"]),
    );
    for row in rows {
        for value in &row.values {
            let agreement = match value.agreement {
                Agreement::Same => "same",
                Agreement::OneUnit => "one_unit",
                Agreement::Off => "off",
            };
            table.push([
                Cell::Integer(i64::from(row.table)),
                row.mechanism.as_ref().into(),
                row.theta_deg.into(),
                row.method.as_ref().into(),
                row.cells.into(),
                row.avogadro_per_mol.into(),
                value.quantity.as_ref().into(),
                value.computed.into(),
                value.printed.as_ref().into(),
                agreement.into(),
                value.deviation.into(),
            ])?;
        }
    }
    Ok(table)
}
