//! The volumes that pairs of convex shapes share when a ball sweeps them, listed in a JSON file.

use super::places::{Orientation, for_each_pair, poses};
use super::read_shape;
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::swept::Swept;
use serde::{Deserialize, Serialize};
use std::path::Path;

const EXAMPLE: &str =
    "{\"a\": \"cube\", \"b\": \"cube\", \"position\": [0, 0, 1.05], \"depletant_radius\": 0.1}";

/// A pair as its file says it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct PairEntry {
    /// File or name of the first shape.
    a: String,
    /// File or name of the second shape.
    b: String,
    /// The centroid of b; that of a is at the origin.
    position: Vec<f64>,
    orientation_a: Option<Orientation>,
    orientation_b: Option<Orientation>,
    /// Radius of the ball that rounds each shape.
    #[serde(default)]
    rounding_a: f64,
    #[serde(default)]
    rounding_b: f64,
    /// Radius of the depletant.
    depletant_radius: f64,
}

/// Volume that two bodies share, and their distance. Lengths are in the unit of the shapes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SharedVolume {
    /// Volume (in a plane, area) that is closed to the centre of a depletant by both bodies.
    pub overlap_volume: f64,
    /// Distance between the bodies; zero if they touch or overlap.
    pub distance: f64,
}

/// Volumes that the pairs of a file share.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct SharedVolumes(pub Vec<SharedVolume>);

impl Answer for SharedVolumes {
    fn text(&self) -> String {
        let mut rows = vec![heading(["pair", "distance", "overlap volume"])];
        for (number, pair) in self.0.iter().enumerate() {
            rows.push(vec![
                (number + 1).to_string(),
                format!("{:.6}", pair.distance),
                format!("{:.9}", pair.overlap_volume),
            ]);
        }
        columns(&rows)
    }
}

/// The volumes that the pairs of a JSON file share when a depletant sweeps them.
///
/// # Errors
/// Names the file and the pair, and what is wrong with it.
///
/// ```
/// use protomer_shape_verbs::shapes::overlap::shared_volumes;
/// # let folder = tempfile::tempdir()?;
/// let file = folder.path().join("pairs.json");
/// let pair = r#"{"a": "cube", "b": "cube", "position": [1.05, 0, 0], "depletant_radius": 0.1}"#;
/// std::fs::write(&file, format!("[{pair}]"))?;
/// let found = shared_volumes(&file)?;
/// assert!((found.0[0].overlap_volume - 0.1956929).abs() < 1e-6);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn shared_volumes(path: &Path) -> Result<SharedVolumes> {
    Ok(SharedVolumes(for_each_pair(path, EXAMPLE, shared_volume)?))
}

fn shared_volume(entry: &PairEntry) -> Result<SharedVolume> {
    let shapes = [read_shape(&entry.a)?, read_shape(&entry.b)?];
    let dimension = shapes[0].dimension();
    if shapes[1].dimension() != dimension {
        bail!("one shape has two dimensions and the other three; give both the same number");
    }
    let orientations = [entry.orientation_a, entry.orientation_b];
    let poses = poses(&entry.position, orientations, dimension)?;
    let names = ["rounding_a", "rounding_b"];
    let (mut swept, mut roundings) = (Vec::new(), 0.0);
    for (number, rounding) in [entry.rounding_a, entry.rounding_b].into_iter().enumerate() {
        if !(rounding >= 0.0 && rounding.is_finite()) {
            bail!(
                "{} is {rounding}; give zero or a positive number",
                names[number]
            );
        }
        let body = Swept::new(
            &shapes[number],
            rounding + entry.depletant_radius,
            &poses[number],
        );
        swept.push(body.context("depletant_radius")?);
        roundings += rounding;
    }
    let cores = closest_points(swept[0].corners(), swept[1].corners());
    let between_cores = cores.map_or(0.0, |points| points.distance());
    Ok(SharedVolume {
        overlap_volume: swept[0].overlap(&swept[1]),
        distance: (between_cores - roundings).max(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(pair: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("pairs.json");
        std::fs::write(&file, format!("[{pair}]")).unwrap();
        format!("{:#}", shared_volumes(&file).unwrap_err())
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cubes = r#""a": "cube", "b": "cube", "position": [2, 0, 0]"#;
        for (bad, words) in [
            (format!("{{{cubes}}}"), "depletant_radius"),
            (
                format!("{{{cubes}, \"depletant_radius\": -1}}"),
                "depletant_radius",
            ),
            (
                format!("{{{cubes}, \"depletant_radius\": 1, \"rounding_b\": -1}}"),
                "rounding_b is -1",
            ),
            (
                r#"{"a": "cube", "b": "polygon:4", "position": [2, 0, 0], "depletant_radius": 1}"#
                    .into(),
                "same number",
            ),
        ] {
            let said = complaint(&bad);
            assert!(said.contains(words), "{said}");
        }
    }
}
