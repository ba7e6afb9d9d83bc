//! Free volumes of depletants in perfect crystals whose bodies do not move.

use super::settings::{check_packing_fraction, check_rounding};
use super::start::{BodyShape, cell_text, unit_cell};
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_common::range::Count;
use protomer_hpmc::crystal::Crystal;
use protomer_hpmc::static_free_volume::static_free_volume;
use protomer_kernel::Number;
use serde::Serialize;

/// Lines along an edge, whose square is the cost.
const LINES: Count = Count::new(1, 10_000);

/// A crystal, and the depletants. Lengths are in the unit of the shape.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticFreeVolumeSettings {
    /// File or name of the shape.
    pub shape: String,
    /// Radius of the ball that rounds the shape.
    pub rounding_radius: f64,
    /// Name of the crystal, or file of its unit cell.
    pub crystal: String,
    /// Rotation of every body in its own frame, a quaternion; empty for none.
    pub turn: Vec<f64>,
    /// The parts of space that the bodies fill.
    pub packing_fractions: Vec<f64>,
    /// Radii of the depletants.
    pub depletant_radii: Vec<f64>,
    /// Lines along each edge of the unit cell.
    pub lines: usize,
}

/// The free volume of one kind of depletant at one packing fraction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaticFreeVolumeRow {
    /// The part of space that the bodies fill.
    pub packing_fraction: f64,
    /// Radius of the depletant.
    pub depletant_radius: f64,
    /// Radius of the depletant over that of the ball about the centre that holds the body.
    pub size_ratio: f64,
    /// The part of space that is open to the centres of depletants.
    pub free_volume_fraction: f64,
    /// Standard error of the free volume.
    pub free_volume_fraction_error: f64,
}

/// Free volumes of a crystal.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct StaticFreeVolumes(pub Vec<StaticFreeVolumeRow>);

impl Answer for StaticFreeVolumes {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "packing fraction",
            "depletant radius",
            "size ratio",
            "free volume fraction",
        ])];
        for row in &self.0 {
            rows.push(vec![
                row.packing_fraction.to_string(),
                row.depletant_radius.to_string(),
                format!("{:.6}", row.size_ratio),
                format!(
                    "{:.7} ± {:.7}",
                    row.free_volume_fraction, row.free_volume_fraction_error
                ),
            ]);
        }
        columns(&rows)
    }
}

/// Computes the free volumes of a crystal for all packing fractions and depletants.
///
/// # Errors
/// For a shape in a plane, an unknown crystal, bodies that overlap in it, and numbers that are not positive.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::static_free_volume::{StaticFreeVolumeSettings, static_free_volumes};
/// let found = static_free_volumes(&StaticFreeVolumeSettings {
///     shape: "cube".into(),
///     rounding_radius: 0.0,
///     crystal: "simple-cubic".into(),
///     turn: Vec::new(),
///     packing_fractions: vec![0.125],
///     depletant_radii: vec![1e-6],
///     lines: 60,
/// })?;
/// assert!((found.0[0].free_volume_fraction - 0.875).abs() < 0.005);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn static_free_volumes(settings: &StaticFreeVolumeSettings) -> Result<StaticFreeVolumes> {
    check_rounding(settings.rounding_radius)?;
    LINES.require("lines", settings.lines as u64)?;
    for packing_fraction in &settings.packing_fractions {
        check_packing_fraction(*packing_fraction)?;
    }
    for radius in &settings.depletant_radii {
        if !(1e-30..=1e30).contains(radius) {
            bail!(
                "depletant_radius is {}; it must be from 1e-30 to 1e30",
                Number(*radius)
            );
        }
    }
    let shape = match BodyShape::read(&settings.shape)? {
        BodyShape::Shape(shape) => shape,
        BodyShape::Rod(_) => {
            bail!("rods on a line have no free volume in space; give a polyhedron")
        }
        BodyShape::Ellipsoid(_) => bail!(
            "{} has no corners; this integral takes polyhedra and balls, rounded or not",
            settings.shape
        ),
        BodyShape::Pieces(_) => bail!(
            "{} has several pieces; this integral takes convex bodies. Let `hpmc run` sample it: --start, \
             --depletants RADIUS:0 and --sweeps 1",
            settings.shape
        ),
    };
    if shape.dimension() != 3 {
        bail!("{} is flat; give a polyhedron", settings.shape);
    }
    let named = || settings.shape.clone();
    let body = BodyShape::Shape(shape.clone())
        .body::<3>(settings.rounding_radius)
        .with_context(named)?;
    let text = cell_text(&settings.crystal)?;
    let cell = unit_cell::<3>(&settings.crystal, text.as_deref(), &settings.turn)?;
    let mut rows = Vec::new();
    for packing_fraction in settings.packing_fractions.iter().copied() {
        let crystal = Crystal::new(&cell, &body, cell.sites.len(), packing_fraction)?;
        let lines_per_length = settings.lines as f64 / crystal.space.smallest_length();
        for depletant_radius in settings.depletant_radii.iter().copied() {
            let free_volume = static_free_volume(
                &crystal,
                &shape,
                settings.rounding_radius,
                depletant_radius,
                lines_per_length,
            )?;
            rows.push(StaticFreeVolumeRow {
                packing_fraction,
                depletant_radius,
                size_ratio: depletant_radius / body.outer_radius,
                free_volume_fraction: free_volume.fraction,
                free_volume_fraction_error: free_volume.error,
            });
        }
    }
    Ok(StaticFreeVolumes(rows))
}
