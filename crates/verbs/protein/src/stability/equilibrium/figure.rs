//! The figure of an equilibrium: yield and free energies against salt, and where one half is left.

use super::answer::condition_in_words;
use super::result::{HalfSaltRow, StabilityResult, concentration_in_words};
use crate::stability::sweep::figure::half_salt;
use anyhow::Result;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use std::path::Path;

/// Curves of parts next to that of the whole.
const PARTS_DRAWN: usize = 3;

/// Writes the figure as SVG and PNG into a directory.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub(super) fn write(result: &StabilityResult, directory: &Path) -> Result<()> {
    let figure = figure(result);
    let path = directory.join("stability");
    figure.write_svg(&path.with_extension("svg"))?;
    figure.write_png(&path.with_extension("png"))?;
    Ok(())
}

/// The figure of an equilibrium.
pub fn figure(result: &StabilityResult) -> Figure {
    let x = match result.settings.salt_molar.len() > 1 {
        true => Axis::log("salt (mM)"),
        false => Axis::linear("salt (mM)"),
    };
    Figure {
        title: "Whole assemblies at equilibrium".into(),
        caption: caption(result),
        x,
        panels: vec![yields(result), parts(result)],
    }
}

/// Share of the bodies in whole assemblies, a curve for each pH and concentration.
fn yields(result: &StabilityResult) -> Panel {
    let mut series = Vec::new();
    for half in &result.half_salts {
        let mut curve = Series {
            name: name(result, half),
            line: true,
            ..Series::default()
        };
        for row in result.conditions.iter().filter(|row| row.ph == half.ph) {
            let mixture = row
                .mixtures
                .iter()
                .find(|mixture| mixture.concentration_molar == half.concentration_molar);
            curve.points.extend(mixture.map(|mixture| Point {
                x: 1e3 * row.salt_molar,
                y: mixture.whole,
                error: Some(mixture.whole_error),
            }));
        }
        series.push(in_order(curve));
        if result.half_salts.len() == 1 {
            series.extend(span(result, half));
        }
    }
    Panel {
        y: Axis::linear("bodies in whole assemblies").with_range(0.0, 1.05),
        series,
    }
}

/// Share of the bodies by part, at the first pH and concentration.
fn parts(result: &StabilityResult) -> Panel {
    let first_ph = result.conditions.first().and_then(|row| row.ph);
    let curve = |name: String, share: &dyn Fn(&[f64]) -> f64| {
        let rows = result.conditions.iter().filter(|row| row.ph == first_ph);
        in_order(Series {
            name,
            line: true,
            points: rows
                .map(|row| Point {
                    x: 1e3 * row.salt_molar,
                    y: share(&row.mixtures[0].shares),
                    error: None,
                })
                .collect(),
            ..Series::default()
        })
    };
    let mut series = vec![curve("free".into(), &|shares| result.free_share(shares))];
    for number in result.largest_parts().into_iter().take(PARTS_DRAWN) {
        // An underscore would begin a subscript.
        let name = result.parts[number].name.replace('_', " ");
        series.push(curve(name, &|shares| shares[number]));
    }
    series.push(curve("whole".into(), &|shares| {
        shares.last().copied().unwrap_or_default()
    }));
    Panel {
        y: Axis::linear("share of the bodies").with_range(0.0, 1.05),
        series,
    }
}

fn in_order(mut curve: Series) -> Series {
    curve.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    curve
}

fn name(result: &StabilityResult, half: &HalfSaltRow) -> String {
    let concentration = concentration_in_words(half.concentration_molar);
    match half.ph.filter(|_| result.settings.ph.len() > 1) {
        Some(ph) => format!("{concentration}, pH {ph:.2}"),
        None => concentration,
    }
}

/// The salt at which one half is left.
fn span(result: &StabilityResult, half: &HalfSaltRow) -> Option<Series> {
    let half = half.half_salt_molar.zip(half.half_salt_interval_molar)?;
    Some(half_salt(&result.settings.salt_molar, half))
}

fn caption(result: &StabilityResult) -> String {
    let condition = match result.conditions.as_slice() {
        [only] => format!(", {}", condition_in_words(only)),
        _ => String::new(),
    };
    format!(
        "{} bodies, {} parts, {}, model {}, seed {}{condition}; {}",
        result.bodies,
        result.parts.len(),
        result.way,
        result.model,
        result.settings.sampling.seed,
        result.headline()
    )
}
