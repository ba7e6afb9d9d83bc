//! Tables 2, 3 and 4 of Grima, Gatt, Bray, Alderson and Evans, Mol. Simul. 31, 925 (2005), printed
//! and recomputed.
//!
//! The columns of the simulation (EMUDA) follow with N_A = 6.022e23 /mol, those of the formulas
//! (AM) with 6.023e23 /mol and a hinge at both ends of a rib (K_h = 2 k_h). Honeycombs of h = 2 Å,
//! l = 1 Å, thickness 1 Å.

pub mod page;

use anyhow::Result;
use protomer_linkage::framework::analytic::{AxialModuli, Honeycomb};
use protomer_linkage::framework::{Elasticity, Moduli, build, gpa_per_kcal_mol_angstrom3};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// N_A of the simulated columns, 1/mol.
pub const AVOGADRO_OF_SIMULATION: f64 = 6.022e23;
/// N_A of the columns of formulas, 1/mol.
pub const AVOGADRO_OF_FORMULAS: f64 = 6.023e23;

/// Agreement of a computed value with the printed one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Agreement {
    /// Equal to the last printed digit.
    Same,
    /// Off by at most one unit of the last printed digit.
    OneUnit,
    /// Further off.
    Off,
}

/// A number from the paper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Value {
    /// Name of the quantity: `e_y_gpa`, `e_z_gpa`, `nu_yz` or `nu_zy`.
    pub quantity: Cow<'static, str>,
    /// The computed value.
    pub computed: f64,
    /// The printed value.
    pub printed: Cow<'static, str>,
    /// Agreement of the two values.
    pub agreement: Agreement,
    /// Relative deviation, printed / computed - 1.
    pub deviation: f64,
}

/// A row of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Number of the table: 2, 3 or 4.
    pub table: u32,
    /// Mechanism: `hinging`, `stretching` or `mixed`.
    pub mechanism: Cow<'static, str>,
    /// Angle θ, degrees.
    pub theta_deg: f64,
    /// Method: `emuda` or `am`.
    pub method: Cow<'static, str>,
    /// Number of cells of the simulated box along both axes.
    pub cells: usize,
    /// Avogadro constant N_A, 1/mol.
    pub avogadro_per_mol: f64,
    /// The four values of the row.
    pub values: Vec<Value>,
    /// A remark on the printed row.
    pub note: Option<Cow<'static, str>>,
}

const UNCONVERGED: &str = "the simulation of the paper was not converged here";
const WHOLE: &str = "E_y of the formula is rounded to whole GPa and printed with .00";

const QUANTITIES: [&str; 4] = ["e_y_gpa", "e_z_gpa", "nu_yz", "nu_zy"];

type Printed = [&'static str; 4];

/// A printed row: θ, the values of the formula, and those of the simulation.
type PrintedRow = (f64, Printed, Printed);

/// Table 3 (A), hinging.
const HINGING: [PrintedRow; 6] = [
    (
        30.0,
        ["408", "6301.91", "-0.255", "-3.928"],
        ["407.11", "5678.19", "-0.251", "-3.504"],
    ),
    (
        45.0,
        ["760", "2540.31", "-0.547", "-1.828"],
        ["752.45", "2419.72", "-0.536", "-1.724"],
    ),
    (
        60.0,
        ["1604", "1604.27", "-1.000", "-1.000"],
        ["1557.78", "1557.80", "-0.961", "-0.961"],
    ),
    (
        120.0,
        ["963", "2673.79", "0.600", "1.667"],
        ["934.67", "2596.31", "0.577", "1.602"],
    ),
    (
        135.0,
        ["363", "5318.99", "0.261", "3.828"],
        ["359.40", "5067.11", "0.256", "3.610"],
    ),
    (
        150.0,
        ["162", "15927.54", "0.101", "9.928"],
        ["161.11", "14353.74", "0.099", "8.855"],
    ),
];

/// Table 3 (B), stretching.
const STRETCHING: [PrintedRow; 6] = [
    (
        30.0,
        ["612.60", "286.45", "0.764", "0.357"],
        ["608.13", "286.43", "0.756", "0.356"],
    ),
    (
        45.0,
        ["379.93", "254.03", "0.547", "0.366"],
        ["379.04", "253.94", "0.544", "0.365"],
    ),
    (
        60.0,
        ["267.38", "267.38", "0.333", "0.333"],
        ["267.20", "267.20", "0.332", "0.332"],
    ),
    (
        120.0,
        ["160.43", "445.63", "-0.200", "-0.556"],
        ["160.32", "445.34", "-0.199", "-0.554"],
    ),
    (
        135.0,
        ["181.45", "531.9", "-0.261", "-0.766"],
        ["181.03", "531.72", "-0.260", "-0.763"],
    ),
    (
        150.0,
        ["242.38", "723.98", "-0.302", "-0.903"],
        ["240.64", "723.86", "-0.299", "-0.900"],
    ),
];

/// Table 4. Its simulated ratios have four decimals, filled up with a zero in print.
const MIXED: [PrintedRow; 6] = [
    (
        30.0,
        ["245.04", "274.00", "0.15274", "0.17079"],
        ["245.08", "274.04", "0.1527", "0.1708"],
    ),
    (
        45.0,
        ["253.29", "230.94", "0.18231", "0.16622"],
        ["253.35", "231.18", "0.1820", "0.1661"],
    ),
    (
        60.0,
        ["229.18", "229.18", "0.14286", "0.14286"],
        ["229.22", "229.22", "0.1429", "0.1429"],
    ),
    (
        120.0,
        ["137.51", "381.97", "-0.08571", "-0.23810"],
        ["137.53", "382.03", "-0.0857", "-0.2381"],
    ),
    (
        135.0,
        ["120.97", "483.54", "-0.08707", "-0.34804"],
        ["120.64", "483.61", "-0.0869", "-0.3485"],
    ),
    (
        150.0,
        ["96.95", "692.50", "-0.06043", "-0.43166"],
        ["96.97", "692.61", "-0.0604", "-0.4317"],
    ),
];

/// Table 2 by hinging: θ = 45°, cells of 1, 2 and 4 along both axes.
const CELLS_HINGING: [(usize, Printed); 3] = [
    (1, ["752.58", "2420.15", "-0.536", "-1.724"]),
    (2, ["752.41", "2419.56", "-0.536", "-1.724"]),
    (4, ["752.45", "2419.71", "-0.536", "-1.724"]),
];
/// Table 2 by stretching, for the same cells.
const CELLS_STRETCHING: [(usize, Printed); 3] = [
    (1, ["379.10", "253.99", "0.544", "0.365"]),
    (2, ["379.04", "253.94", "0.544", "0.365"]),
    (4, ["379.04", "253.94", "0.544", "0.365"]),
];

/// The honeycomb of a mechanism: (k_h, k_s) = (50, 10 000), (10 000, 50) or (50, 50).
fn honeycomb(mechanism: &str, theta_deg: f64) -> Honeycomb {
    let (kh, ks) = match mechanism {
        "hinging" => (50.0, 10_000.0),
        "stretching" => (10_000.0, 50.0),
        _ => (50.0, 50.0),
    };
    Honeycomb {
        h_angstrom: 2.0,
        l_angstrom: 1.0,
        theta_rad: theta_deg.to_radians(),
        hinge_stiffness_kcal_mol_rad2: kh,
        rod_stiffness_kcal_mol_angstrom2: ks,
        thickness_angstrom: 1.0,
    }
}

/// Tables 2, 3 and 4, recomputed.
///
/// # Errors
/// None in practice: the networks are valid.
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (mechanism, printed) in [("hinging", CELLS_HINGING), ("stretching", CELLS_STRETCHING)] {
        for (cells, numbers) in printed {
            rows.push(simulated(2, mechanism, 45.0, cells, &numbers)?);
        }
    }
    for (table, mechanism, printed) in [
        (3, "hinging", HINGING),
        (3, "stretching", STRETCHING),
        (4, "mixed", MIXED),
    ] {
        for (theta_deg, formula, simulation) in printed {
            rows.push(by_formula(table, mechanism, theta_deg, &formula));
            rows.push(simulated(table, mechanism, theta_deg, 1, &simulation)?);
        }
    }
    Ok(rows)
}

fn simulated(
    table: u32,
    mechanism: &'static str,
    theta_deg: f64,
    cells: usize,
    printed: &Printed,
) -> Result<Row> {
    let network = build::honeycomb(&honeycomb(mechanism, theta_deg))?.supercell(&[cells, cells])?;
    let gpa = gpa_per_kcal_mol_angstrom3(AVOGADRO_OF_SIMULATION);
    let moduli = Moduli::new(&Elasticity::from_framework(&network)?, gpa);
    let ratio = |i: usize, j: usize| moduli.poissons[i][j].unwrap_or(f64::NAN);
    let modulus = |i: usize| moduli.youngs_gpa[i].unwrap_or(f64::NAN);
    let unconverged = mechanism == "mixed" && [45.0, 135.0].contains(&theta_deg);
    Ok(Row {
        table,
        mechanism: mechanism.into(),
        theta_deg,
        method: "emuda".into(),
        cells,
        avogadro_per_mol: AVOGADRO_OF_SIMULATION,
        values: values([modulus(0), modulus(1), ratio(0, 1), ratio(1, 0)], printed),
        note: unconverged.then_some(UNCONVERGED.into()),
    })
}

fn by_formula(table: u32, mechanism: &'static str, theta_deg: f64, printed: &Printed) -> Row {
    let gpa = gpa_per_kcal_mol_angstrom3(AVOGADRO_OF_FORMULAS);
    let honeycomb = honeycomb(mechanism, theta_deg);
    let AxialModuli {
        e_y_gpa,
        e_z_gpa,
        nu_yz,
        nu_zy,
        ..
    } = match mechanism {
        "hinging" => honeycomb.hinging(gpa),
        "stretching" => honeycomb.stretching(gpa),
        _ => honeycomb.both(gpa),
    };
    Row {
        table,
        mechanism: mechanism.into(),
        theta_deg,
        method: "am".into(),
        cells: 1,
        avogadro_per_mol: AVOGADRO_OF_FORMULAS,
        values: values([e_y_gpa, e_z_gpa, nu_yz, nu_zy], printed),
        note: (mechanism == "hinging").then_some(WHOLE.into()),
    }
}

fn values(computed: [f64; 4], printed: &Printed) -> Vec<Value> {
    let one = |((quantity, computed), printed): ((&'static str, f64), &&'static str)| {
        // The printed number states its own precision.
        let decimals = printed
            .split_once('.')
            .map_or(0, |(_, decimals)| decimals.len());
        let number: f64 = printed.parse().unwrap_or(f64::NAN);
        let unit = 10f64.powi(-(decimals as i32));
        // Rounded like the print: digits are compared, not numbers.
        let agreement = if format!("{computed:.decimals$}") == **printed {
            Agreement::Same
        } else if (computed - number).abs() <= unit {
            Agreement::OneUnit
        } else {
            Agreement::Off
        };
        Value {
            quantity: quantity.into(),
            computed,
            printed: (*printed).into(),
            agreement,
            deviation: number / computed - 1.0,
        }
    };
    QUANTITIES
        .into_iter()
        .zip(computed)
        .zip(printed)
        .map(one)
        .collect()
}

/// The tables as text: each computed value with the printed one and a mark.
pub fn describe(rows: &[Row]) -> Vec<(String, Vec<Vec<String>>)> {
    let heading = [
        "mechanism",
        "θ",
        "method",
        "cells",
        "E_y (GPa)",
        "E_z (GPa)",
        "ν_yz",
        "ν_zy",
        "",
    ];
    let title = |table: u32| match table {
        2 => "Table 2: size of the box",
        3 => "Table 3: hinging or stretching",
        _ => "Table 4: hinging and stretching",
    };
    [2, 3, 4]
        .into_iter()
        .map(|table| {
            let mut lines = vec![heading.map(str::to_owned).to_vec()];
            for row in rows.iter().filter(|row| row.table == table) {
                let mut line = vec![
                    row.mechanism.to_string(),
                    row.theta_deg.to_string(),
                    row.method.to_uppercase(),
                    format!("{0} x {0}", row.cells),
                ];
                line.extend(row.values.iter().map(describe_value));
                line.push(
                    row.note
                        .as_deref()
                        .map_or("", |note| if note == UNCONVERGED { "(a)" } else { "(b)" })
                        .to_owned(),
                );
                lines.push(line);
            }
            (title(table).to_owned(), lines)
        })
        .collect()
}

/// Text of a value: `computed | printed mark`.
fn describe_value(value: &Value) -> String {
    let decimals = value
        .printed
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len());
    let mark = match value.agreement {
        Agreement::Same => "=".to_owned(),
        Agreement::OneUnit => "~".to_owned(),
        Agreement::Off => format!("{:+.3}%", 100.0 * value.deviation),
    };
    format!("{:.decimals$} | {} {mark}", value.computed, value.printed)
}

/// Explains the marks of [`describe`], with their counts.
pub fn legend(rows: &[Row]) -> String {
    let count = |agreement: Agreement| {
        rows.iter()
            .flat_map(|row| &row.values)
            .filter(|value| value.agreement == agreement)
            .count()
    };
    format!(
        "computed | printed (Grima et al., Mol. Simul. 31, 925 (2005)): {} the same to the last printed digit (=), {} off by \
         one unit of it (~), {} further off (printed over computed, less one).\nEMUDA with N_A = {AVOGADRO_OF_SIMULATION:e}, AM \
         with N_A = {AVOGADRO_OF_FORMULAS:e} /mol.\nThe moduli of \
         the paper scatter themselves: table 2 prints 752.58 to 752.41 GPa for one material.\n(a) {UNCONVERGED} (45°: E_z \
         0.09 % high, 135°: E_y 0.29 % low, and the ratios with them).\n(b) {WHOLE}.",
        count(Agreement::Same),
        count(Agreement::OneUnit),
        count(Agreement::Off)
    )
}
