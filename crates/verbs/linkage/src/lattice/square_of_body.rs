//! The square that represents a body, as part of a configuration.

use super::settings::LatticeSettings;
use anyhow::{Context, Result};
use protomer_body::Body;
use protomer_common::answer::Answer;
use protomer_linkage::lattice::Square;
pub use protomer_linkage::lattice::square_of_body::{Axis, Size};
use protomer_linkage::lattice::square_of_body::{BodySquare, Solid};
use protomer_results::keys::to_toml;
use serde::Serialize;

/// The configuration keys that describe a body.
const KEYS: [&str; 3] = ["half_diagonal_angstrom", "square", "charges"];

/// A body and its square.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedSquare {
    /// Name of the body.
    pub body: String,
    /// The square.
    #[serde(flatten)]
    pub square: BodySquare,
}

/// The square of a body.
///
/// # Errors
/// If the body has no extent across the axis.
pub fn square_of_body(body: &Body, axis: Axis, size: Size) -> Result<NamedSquare> {
    let sites = body.sites.iter();
    let charges: Vec<_> = sites.map(|site| (site.position, site.charge_e)).collect();
    let solid = Solid {
        mesh: &body.mesh,
        mass_properties: &body.mass_properties,
        charges: &charges,
    };
    let square = BodySquare::from_solid(&solid, axis, size)
        .with_context(|| format!("the body {}", body.name))?;
    Ok(NamedSquare {
        body: body.name.clone(),
        square,
    })
}

impl NamedSquare {
    /// The part of a configuration that describes the body.
    ///
    /// # Errors
    /// If it cannot be serialised.
    pub fn to_toml(&self) -> Result<String> {
        let settings = LatticeSettings {
            half_diagonal_angstrom: Some(self.square.half_diagonal_angstrom),
            square: Square {
                inertia: self.square.inertia,
                ..Square::default()
            },
            charges: self.square.charges.clone(),
            ..LatticeSettings::default()
        };
        let mut part: toml::Table = toml::from_str(&to_toml("the settings", &settings)?)?;
        part.retain(|key, _| KEYS.contains(&key));
        Ok(format!(
            "# {}, {}\n{}",
            self.body,
            self.text(),
            toml::to_string_pretty(&part)?
        ))
    }
}

impl Answer for NamedSquare {
    /// Describes the square in one line.
    fn text(&self) -> String {
        let square = &self.square;
        let [x, y, z] = square.axis;
        format!(
            "axis ({x:.3}, {y:.3}, {z:.3}), outline most {}-fold, {:.1} % off four-fold, \
             half-diagonal {:.2} Å, inertia {:.4} m l², net charge {:+.2} e on {} sites",
            square.symmetry_order,
            100.0 * square.deviation_from_fourfold,
            square.half_diagonal_angstrom,
            square.inertia,
            square.net_charge_e,
            square.charges.len()
        )
    }
}

impl NamedSquare {
    /// The warning about charges that stand out of the square.
    pub fn warning(&self) -> Option<String> {
        let displacements = &self.square.moved;
        (displacements.count > 0).then(|| {
            format!(
                "{} of {} charges ({:+.2} and {:+.2} e) stand out of the square and were moved to its outermost sites, by \
                 at most {:.1} Å: forces between corners that meet are those of the moved charges",
                displacements.count,
                displacements.out_of,
                displacements.positive_e,
                displacements.negative_e,
                displacements.farthest_angstrom
            )
        })
    }
}
