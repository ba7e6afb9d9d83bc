//! Where the bodies of a pair are, as JSON files say it.

use anyhow::{Context, Result, bail};
use protomer_common::input::InputFile;
use protomer_kernel::{Pose, Rotation, Vec3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Orientation of a body.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum Orientation {
    /// Angle in a plane, rad.
    Angle(f64),
    /// Quaternion, scalar first.
    Quaternion([f64; 4]),
}

/// Answers the pairs of a JSON file one by one.
///
/// # Errors
/// Names the file and the pair, and what is wrong with it.
pub(super) fn for_each_pair<Entry: DeserializeOwned, Found>(
    path: &Path,
    example: &str,
    answer: impl Fn(&Entry) -> Result<Found>,
) -> Result<Vec<Found>> {
    let file = InputFile::read(path)?;
    let entries: Vec<Entry> = serde_json::from_slice(&file.bytes)
        .with_context(|| format!("{} is not a list of pairs; write [{example}, …]", file.name))?;
    let mut answers = Vec::with_capacity(entries.len());
    for (number, entry) in entries.iter().enumerate() {
        let one = answer(entry);
        answers.push(one.with_context(|| format!("{}: pair {}", file.name, number + 1))?);
    }
    Ok(answers)
}

/// The poses of two bodies of one dimension; the first is at the origin.
pub(super) fn poses(
    position_of_b: &[f64],
    orientations: [Option<Orientation>; 2],
    dimension: usize,
) -> Result<[Pose; 2]> {
    Ok([
        Pose {
            position: Vec3::zeros(),
            rotation: rotation(orientations[0], dimension).context("orientation_a")?,
        },
        Pose {
            position: position(position_of_b, dimension)?,
            rotation: rotation(orientations[1], dimension).context("orientation_b")?,
        },
    ])
}

fn position(numbers: &[f64], dimension: usize) -> Result<Vec3> {
    match (numbers, dimension) {
        ([x, y], 2) => Ok(Vec3::new(*x, *y, 0.0)),
        ([x, y, z], 3) => Ok(Vec3::new(*x, *y, *z)),
        _ => bail!(
            "the position has {} numbers; give {dimension}",
            numbers.len()
        ),
    }
}

fn rotation(orientation: Option<Orientation>, dimension: usize) -> Result<Rotation> {
    match (orientation, dimension) {
        (None, _) => Ok(Rotation::identity()),
        (Some(Orientation::Angle(angle_rad)), 2) => {
            Ok(Rotation::from_scaled_axis(angle_rad * Vec3::z()))
        }
        (Some(Orientation::Quaternion(wxyz)), 3) if wxyz.iter().any(|part| *part != 0.0) => {
            Ok(Pose::from_wxyz(Vec3::zeros(), wxyz).rotation)
        }
        (Some(Orientation::Quaternion(_)), 3) => bail!("a quaternion of zeros is no rotation"),
        (_, 2) => bail!("give an angle in radians for a polygon"),
        _ => bail!("give a quaternion, four numbers w x y z, for a polyhedron"),
    }
}
