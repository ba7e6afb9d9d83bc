//! The page of the recomputed tables of a paper on networks.

use super::html::{definitions, escape, paragraph, table};
use super::page::{Page, Section};
use super::{data, provenance};
use anyhow::{Context, Result};
use protomer_io::csv::{Cell, Table};
use protomer_linkage_verbs::frameworks::tables::{Agreement, Row, describe, legend};
use protomer_results::keys;
use std::path::Path;

/// The page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path) -> Result<Page> {
    let path = directory.join("tables.json");
    let bytes = protomer_io::input::read(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let rows: Vec<Row> = keys::from_json(&path, &bytes)?;
    let mut results = counts(&rows);
    for (title, mut lines) in describe(&rows) {
        let head = if lines.is_empty() {
            Vec::new()
        } else {
            lines.remove(0)
        };
        results += &format!(
            "<h3>{}</h3>\n<div class=\"compact\">{}</div>\n",
            escape(&title),
            table(&head, &lines)
        );
    }
    results += &data::data("tables.csv", &long(&rows)?.to_csv()?)?;
    let reading: String = legend(&rows).lines().map(paragraph).collect();
    Ok(Page {
        title: format!("Tables of networks: {}", provenance::name(directory)),
        subtitle: "Elastic constants of honeycombs, printed and recomputed".into(),
        verdict: None,
        problems: Vec::new(),
        sections: vec![
            Section::new("Results", results),
            Section::new("How to read the tables", reading),
            provenance::without_file(
                directory,
                None,
                vec![("command", "protomer framework tables".into())],
            ),
        ],
    })
}

fn counts(rows: &[Row]) -> String {
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
    definitions(&[
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
