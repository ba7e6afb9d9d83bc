//! What the page of a sweep shows of the curves from all of its frames.

use super::{FOLDER, HalfSaltEstimate, ReweightingResult};
use anyhow::Result;
use protomer_common::page::{Part, Section, significant, significant_or_dash};
use std::path::Path;

/// The section on the curves of a sweep; `None` if `reweight` left nothing in its directory.
///
/// # Errors
/// If a file is damaged.
pub fn section(directory: &Path) -> Result<Option<Section>> {
    let Some(result) = ReweightingResult::read(&directory.join(FOLDER))? else {
        return Ok(None);
    };
    let note = match result.equilibrated {
        Some(false) => "Not equilibrated, as the sweep says, so there is no half salt.",
        _ => {
            "All frames of the sweep together, weighted to every salt, and to other concentrations of \
             bodies by mass action."
        }
    };
    let columns = [
        "bodies (mM)",
        "half of the contacts left (mM salt)",
        "half of the bodies bound (mM salt)",
    ];
    let half = |half: Option<HalfSaltEstimate>| {
        let Some(half) = half else {
            return significant_or_dash(None, 3);
        };
        let salt = millimolar(half.salt_molar, 3);
        match half
            .interval_molar
            .map(|ends| ends.map(|end| millimolar(end, 3)))
        {
            Some([low, high]) => format!("{salt} (95 %: {low} to {high})"),
            None => salt,
        }
    };
    let mut rows = Vec::new();
    for curve in &result.concentrations {
        rows.push(vec![
            millimolar(curve.concentration_molar, 3),
            half(curve.half_salt),
            half(curve.half_bound_salt),
        ]);
    }
    let parts = vec![
        Part::Paragraph(note.into()),
        Part::Table {
            columns: columns.into(),
            rows,
        },
        Part::picture(
            &format!("{FOLDER}/reweighting.svg"),
            "Stability from all frames",
            Some(&format!("{FOLDER}/reweighting.csv")),
        ),
    ];
    Ok(Some(Section::new("Curves from all frames", parts)))
}

fn millimolar(molar: f64, digits: usize) -> String {
    significant(1e3 * molar, digits)
}
