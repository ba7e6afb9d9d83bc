//! The answer: text, tables, figure.

use anyhow::Result;
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::csv::{Cell, Table};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::keys::read_json_if_present;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the file of the report.
pub(super) const FILE: &str = "titration.json";

/// Headings of the table of groups.
pub(super) const COLUMNS: [&str; 8] = [
    "group",
    "pKa",
    "in water",
    "desolvation",
    "background",
    "neighbours",
    "charge (e)",
    "strongest neighbour (kT)",
];

/// pKa values and charges of the proteins in a structure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TitrationReport {
    /// Version of the program.
    pub version: String,
    /// The input file.
    pub file: String,
    /// pH of the charges.
    pub ph: f64,
    /// Salt concentration, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: Option<f64>,
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Relative permittivity inside the protein.
    pub inner_permittivity: f64,
    /// Constant of the binding of the salt's anion to a positive group in water, L/mol.
    #[serde(rename = "anion_binding_per_M")]
    pub anion_binding_per_molar: f64,
    /// Net charge at the pH, e.
    pub net_charge_e: f64,
    /// Net charge of a body that `ingest` makes at this pH, from pKa values in water, e.
    pub model_net_charge_e: f64,
    /// pH at which the net charge is zero; null if there is none from 0 to 14.
    pub isoelectric_point: Option<f64>,
    /// The titratable groups.
    pub groups: Vec<GroupRow>,
    /// Net charge against pH.
    pub curve: Vec<CurvePoint>,
    /// Warnings about the structure.
    pub warnings: Vec<String>,
    /// Wall time, s.
    pub seconds: f64,
}

/// A titratable group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupRow {
    /// Chain.
    pub chain: String,
    /// Residue number.
    pub residue_number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: String,
    /// Residue name; `N-term` or `C-term` for an end of a chain.
    pub residue: String,
    /// pH at which the group is half protonated; null outside -2 to 16.
    pub pka: Option<f64>,
    /// pKa of the model compound in water.
    pub model_pka: f64,
    /// Mean charge at the pH of the report, e.
    pub charge_e: f64,
    /// Shift by the loss of water around the group, units of pKa.
    pub shift_desolvation: f64,
    /// Shift by the partial charges of the neutral protein, units of pKa.
    pub shift_background: f64,
    /// Shift by the other groups, units of pKa; null where the pKa is.
    pub shift_neighbours: Option<f64>,
    /// The group with the strongest interaction; null if none is above 0.1 kT.
    pub strongest_neighbour: Option<Neighbour>,
}

/// A group that acts on another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Neighbour {
    /// Chain, residue and number.
    pub name: String,
    /// Interaction of the charged forms, kT.
    #[serde(rename = "energy_kT")]
    pub energy_kt: f64,
}

/// Net charge at a pH.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// pH.
    pub ph: f64,
    /// Net charge, e.
    pub net_charge_e: f64,
}

impl Answer for TitrationReport {
    fn text(&self) -> String {
        let point = match self.isoelectric_point {
            Some(ph) => format!("isoelectric point {ph:.2}"),
            None => "no isoelectric point from 0 to 14".into(),
        };
        let mut lines = vec![format!(
            "net charge {:+.2} e at pH {} ({:+.2} e in a body of ingest), {point}",
            self.net_charge_e, self.ph, self.model_net_charge_e
        )];
        let mut rows = vec![heading(COLUMNS)];
        for group in &self.groups {
            rows.push(vec![
                group.label(),
                group.pka.map_or("-".into(), |pka| format!("{pka:.2}")),
                format!("{:.2}", group.model_pka),
                signed(group.shift_desolvation),
                signed(group.shift_background),
                group.shift_neighbours.map_or("-".into(), signed),
                signed(group.charge_e),
                group
                    .strongest_neighbour
                    .as_ref()
                    .map_or("-".into(), |neighbour| {
                        format!("{} {:+.1}", neighbour.name, neighbour.energy_kt)
                    }),
            ]);
        }
        lines.push(columns(&rows));
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(self.drawn())
    }
}

impl GroupRow {
    /// Chain, residue and number.
    pub(super) fn label(&self) -> String {
        format!(
            "{} {} {}{}",
            self.chain, self.residue, self.residue_number, self.insertion_code
        )
    }
}

impl TitrationReport {
    /// Reads the report in a directory; `None` if there is none.
    ///
    /// # Errors
    /// If it is damaged.
    pub fn read(directory: &Path) -> protomer_results::Result<Option<Self>> {
        read_json_if_present(&directory.join(FILE))
    }

    /// The groups as a table.
    pub(super) fn table(&self) -> Result<String> {
        let mut table = Table::new(vec![
            "chain",
            "residue_number",
            "insertion_code",
            "residue",
            "pka",
            "model_pka",
            "charge_e",
            "shift_desolvation",
            "shift_background",
            "shift_neighbours",
        ]);
        for group in &self.groups {
            table.push(vec![
                Cell::from(group.chain.as_str()),
                i64::from(group.residue_number).into(),
                Cell::from(group.insertion_code.as_str()),
                Cell::from(group.residue.as_str()),
                Cell::from(group.pka),
                group.model_pka.into(),
                group.charge_e.into(),
                group.shift_desolvation.into(),
                group.shift_background.into(),
                Cell::from(group.shift_neighbours),
            ])?;
        }
        Ok(table.to_csv()?)
    }

    /// The titration curve as a table.
    pub(super) fn curve_table(&self) -> Result<String> {
        let mut table = Table::new(vec!["ph", "net_charge_e"]);
        for point in &self.curve {
            table.push(vec![Cell::from(point.ph), point.net_charge_e.into()])?;
        }
        Ok(table.to_csv()?)
    }

    /// Net charge against pH, and the isoelectric point.
    pub(super) fn drawn(&self) -> Figure {
        let point = |x: f64, y: f64| Point { x, y, error: None };
        let curve = self.curve.iter();
        let mut series = vec![Series {
            name: "net charge".into(),
            points: curve.map(|row| point(row.ph, row.net_charge_e)).collect(),
            line: true,
            ..Series::default()
        }];
        if let Some(ph) = self.isoelectric_point {
            series.push(Series {
                name: format!("isoelectric point {ph:.2}"),
                points: vec![point(ph, 0.0)],
                ..Series::default()
            });
        }
        Figure {
            title: "Titration curve".into(),
            caption: format!("{}, {} titratable groups", self.file, self.groups.len()),
            x: Axis::linear("pH"),
            panels: vec![Panel {
                y: Axis::linear("net charge (e)"),
                series,
            }],
        }
    }
}

/// A number with its sign and two decimals; zero has none.
pub(super) fn signed(value: f64) -> String {
    let text = format!("{value:+.2}");
    match text.trim_start_matches(['+', '-']) {
        "0.00" => "0.00".into(),
        _ => text,
    }
}
