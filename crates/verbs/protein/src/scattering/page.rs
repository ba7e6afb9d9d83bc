//! What the page of a run shows of its scattering.

use super::{FOLDER, ScatteringReport};
use anyhow::Result;
use protomer_common::page::{Part, Section, significant_or_dash, with_error_to};
use protomer_mc::contributions::Mean;
use std::path::Path;

const TITLE: &str = "What scattering sees";

/// The section on the scattering of a run; `None` if `scattering` left nothing in its directory.
///
/// # Errors
/// If a file is damaged.
pub fn section(directory: &Path) -> Result<Option<Section>> {
    let Some(result) = ScatteringReport::read(&directory.join(FOLDER))? else {
        return Ok(None);
    };
    let columns = [
        "salt (mM)",
        "frames",
        "bodies per cluster",
        "hydrodynamic radius (Å)",
    ];
    let estimate = |value: Mean| with_error_to(value.mean, value.error, 4);
    let mut rows = Vec::new();
    for state in &result.states {
        rows.push(vec![
            significant_or_dash(state.salt_molar.map(|molar| 1e3 * molar), 4),
            state.frames.to_string(),
            estimate(state.mean_cluster_size),
            estimate(state.hydrodynamic_radius_angstrom),
        ]);
    }
    let note = "Hydrodynamic radii as dynamic light scattering averages them; S(q) between the centres, and I(q) \
                beside P(q), which it would be without interactions.";
    let file = |name: &str| format!("{FOLDER}/{name}");
    let parts = vec![
        Part::Paragraph(note.into()),
        Part::Table {
            columns: columns.into(),
            rows,
        },
        Part::picture(
            &file("scattering.svg"),
            TITLE,
            Some(&file("scattering.csv")),
        ),
        Part::file(&file("clusters.csv")),
    ];
    Ok(Some(Section::new(TITLE, parts)))
}
