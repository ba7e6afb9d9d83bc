//! The figure of a pair: B₂ against salt, one line per pH.

use super::result::{ConditionResult, PairResult};
use super::settings::Energies;
use anyhow::Result;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use std::path::Path;

/// Writes `pair.svg` and `pair.png` into a directory.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub fn write(result: &PairResult, directory: &Path) -> Result<()> {
    let figure = figure(result);
    figure.write_svg(&directory.join("pair.svg"))?;
    figure.write_png(&directory.join("pair.png"))?;
    Ok(())
}

/// B₂₂ against salt where there are several salts, otherwise w(r).
pub fn figure(result: &PairResult) -> Figure {
    let salts: Vec<f64> = result
        .conditions
        .iter()
        .filter_map(|condition| condition.salt_molar)
        .collect();
    let varies = salts.iter().any(|salt| *salt != salts[0]);
    match varies && salts.len() == result.conditions.len() {
        true => against_salt(result, salts.iter().all(|salt| *salt > 0.0)),
        false => against_distance(result),
    }
}

fn against_salt(result: &PairResult, is_logarithmic: bool) -> Figure {
    let in_mass = result
        .conditions
        .iter()
        .all(|condition| condition.b22_mol_ml_per_g2.is_some());
    let mut series: Vec<Series> = Vec::new();
    let mut hard = named("surfaces alone".into());
    let mut last_ph = None;
    for condition in &result.conditions {
        if series.is_empty() || condition.ph != last_ph {
            series.push(named(line_name(condition)));
            last_ph = condition.ph;
        }
        let factor = in_mass.then_some(1e4).zip(per_b2(condition));
        let factor = factor.map_or(1e-3, |(scale, per_b2)| scale * per_b2);
        let x = 1e3 * condition.salt_molar.unwrap_or(0.0);
        if let Some(line) = series.last_mut() {
            line.points.push(Point {
                x,
                y: factor * condition.b2_angstrom3,
                error: Some(factor * condition.b2_error_angstrom3),
            });
        }
        if series.len() == 1 {
            hard.points.push(Point {
                x,
                y: factor * condition.b2_hard_angstrom3,
                error: None,
            });
        }
    }
    series.push(hard);
    let axis = match in_mass {
        true => "B22 (10⁻⁴ mol mL/g²)",
        false => "B2 (10³ Å³)",
    };
    Figure {
        title: "Second virial coefficient against salt".into(),
        caption: caption(result),
        x: match is_logarithmic {
            true => Axis::log("salt (mM)"),
            false => Axis::linear("salt (mM)"),
        },
        panels: vec![Panel {
            y: Axis::linear(axis),
            series,
        }],
    }
}

/// w(r), a line for each condition.
pub fn against_distance(result: &PairResult) -> Figure {
    // Where no pose is free of overlap, w has no value; near it, it is all error.
    const LARGEST_ERROR_KT: f64 = 0.5;
    let mut series = Vec::new();
    for condition in &result.conditions {
        let mut line = named(line_name(condition));
        for row in &condition.mean_force {
            if row.w_error_kt < LARGEST_ERROR_KT {
                line.points.push(Point {
                    x: row.distance_angstrom,
                    y: row.w_kt,
                    error: None,
                });
            }
        }
        series.push(line);
    }
    Figure {
        title: "Potential of mean force".into(),
        caption: caption(result),
        x: Axis::linear("distance of the origins (Å)"),
        panels: vec![Panel {
            y: Axis::linear("w (kT)"),
            series,
        }],
    }
}

/// From Å³ to mol mL/g², as the two values of a condition have it.
fn per_b2(condition: &ConditionResult) -> Option<f64> {
    let b22 = condition.b22_mol_ml_per_g2?;
    Some(b22 / condition.b2_angstrom3)
}

fn line_name(condition: &ConditionResult) -> String {
    match condition.ph {
        Some(ph) => format!("pH {ph}"),
        None => "bodies as they are".into(),
    }
}

fn named(name: String) -> Series {
    Series {
        name,
        points: Vec::new(),
        replicas: Vec::new(),
        line: true,
    }
}

fn caption(result: &PairResult) -> String {
    let [first, second] = &result.bodies;
    let settings = &result.settings;
    let energies = match settings.energies {
        Energies::Hard => "hard surfaces only",
        Energies::Bare => "bare charges",
        Energies::Effective => "effective charges",
    };
    let contacts = match &settings.contacts {
        Some(contacts) => format!(", {}", contacts.describe()),
        None => String::new(),
    };
    format!(
        "{first} and {second}, {energies}{contacts}, {} K, seed {}",
        settings.medium.temperature_kelvin, settings.sampling.seed
    )
}
