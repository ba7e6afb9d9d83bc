//! The repulsion of pairs of convex shapes, listed in a JSON file.

use super::contact_map::{ContactMap, MapSettings};
use super::places::{Orientation, for_each_pair, poses};
use super::read_shape;
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_kernel::Pose;
use protomer_kernel::shape::polytope::Polytope;
use protomer_md::pair::{Interaction, Placed};
use serde::{Deserialize, Serialize};
use std::path::Path;

const EXAMPLE: &str = "{\"a\": \"cube\", \"b\": \"cube\", \"position\": [0, 0, 1.15]}";

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
}

/// Interaction of two bodies: energy in units of ε, lengths in the unit of the shapes. In a plane
/// the torques have only a third component.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contact {
    /// Energy.
    pub energy: f64,
    /// Distance between the bodies.
    pub distance: f64,
    /// Force on the first body; that on the second is its opposite.
    pub force_a: [f64; 3],
    /// Torque on the first body about its centroid.
    pub torque_a: [f64; 3],
    /// Torque on the second body about its centroid.
    pub torque_b: [f64; 3],
}

/// Interactions of the pairs of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Contacts(pub Vec<Contact>);

impl Answer for Contacts {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "pair",
            "distance",
            "energy",
            "force on a",
            "torque on a",
        ])];
        for (number, contact) in self.0.iter().enumerate() {
            rows.push(vec![
                (number + 1).to_string(),
                format!("{:.6}", contact.distance),
                format!("{:.6}", contact.energy),
                vector(&contact.force_a),
                vector(&contact.torque_a),
            ]);
        }
        columns(&rows)
    }
}

fn vector([x, y, z]: &[f64; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// Energies, forces and torques of the pairs of a JSON file.
///
/// # Errors
/// Names the file and the pair, and what is wrong with it.
///
/// ```
/// use protomer_shape_verbs::shapes::contact::contacts;
/// use protomer_md::pair::Form;
/// # let folder = tempfile::tempdir()?;
/// let file = folder.path().join("pairs.json");
/// std::fs::write(&file, r#"[{"a": "cube", "b": "cube", "position": [0, 0, 1.15]}]"#)?;
/// let found = contacts(&file, Form::FaceSum)?;
/// assert!((found.0[0].energy - 20.0).abs() < 1e-6);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn contacts(path: &Path, interaction: impl Into<Interaction>) -> Result<Contacts> {
    let interaction = interaction.into();
    let one = |entry: &PairEntry| contact(entry, interaction);
    Ok(Contacts(for_each_pair(path, EXAMPLE, one)?))
}

/// Writes the energy of the pair of a JSON file for a grid of places of its second body into a folder: `energies.csv`,
/// `contours.svg` and `contours.png`.
///
/// # Errors
/// As [`contacts`]; also for a file with several pairs, and files that exist with other content unless `force` is set.
///
/// ```
/// use protomer_md::pair::Form;
/// use protomer_shape_verbs::shapes::contact::map_contact;
/// use protomer_shape_verbs::shapes::contact_map::MapSettings;
/// # let folder = tempfile::tempdir()?;
/// let file = folder.path().join("pair.json");
/// std::fs::write(&file, r#"[{"a": "polygon:4", "b": "polygon:4", "position": [2, 0]}]"#)?;
/// let settings = MapSettings { points: 21, ..MapSettings::default() };
/// map_contact(&file, Form::Smooth, &settings, &folder.path().join("map"), false)?;
/// assert!(folder.path().join("map/energies.csv").exists());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn map_contact(
    path: &Path,
    interaction: impl Into<Interaction>,
    settings: &MapSettings,
    folder: &Path,
    force: bool,
) -> Result<()> {
    let interaction = interaction.into();
    let maps = for_each_pair(path, EXAMPLE, |entry: &PairEntry| {
        let pair = OwnPair::from_entry(entry)?;
        let names = [entry.a.as_str(), entry.b.as_str()];
        let title = format!("{} around {}", entry.b, entry.a);
        Ok((
            ContactMap::compute(&pair.placed(), interaction, settings, names)?,
            title,
        ))
    })?;
    let [(map, title)] = maps.as_slice() else {
        bail!(
            "{} has {} pairs, and a map is that of one; give a file with one pair",
            path.display(),
            maps.len()
        );
    };
    map.write(folder, title, force)
}

/// Bodies of a pair and their poses.
struct OwnPair {
    bodies: [Polytope; 2],
    poses: [Pose; 2],
}

impl OwnPair {
    fn from_entry(entry: &PairEntry) -> Result<Self> {
        let [a, b] = [&entry.a, &entry.b].map(|name| -> Result<Polytope> {
            Polytope::from_shape(&read_shape(name)?).with_context(|| name.clone())
        });
        let (a, b) = (a?, b?);
        let orientations = [entry.orientation_a, entry.orientation_b];
        let poses = poses(&entry.position, orientations, b.dimension)?;
        let bodies = [a, b];
        Ok(Self { bodies, poses })
    }

    fn placed(&self) -> Placed<'_> {
        Placed::sharp(self.bodies.each_ref(), self.poses.each_ref())
    }
}

fn contact(entry: &PairEntry, interaction: Interaction) -> Result<Contact> {
    let forces = OwnPair::from_entry(entry)?.placed().forces(interaction)?;
    Ok(Contact {
        energy: forces.energy,
        distance: forces.distance,
        force_a: forces.force.into(),
        torque_a: forces.torques[0].into(),
        torque_b: forces.torques[1].into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_md::pair::Form;

    fn complaint(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("pairs.json");
        std::fs::write(&file, text).unwrap();
        format!("{:#}", contacts(&file, Form::Smooth).unwrap_err())
    }

    #[test]
    fn what_is_wrong_is_named_with_its_pair() {
        let good = r#"{"a": "polygon:4", "b": "polygon:4", "position": [2, 0]}"#;
        for (bad, words) in [
            (
                r#"{"a": "cube", "b": "cube", "position": [2, 0]}"#,
                "give 3",
            ),
            (
                r#"{"a": "cube", "b": "cube", "position": [0, 0, 0.5]}"#,
                "overlap",
            ),
            (
                r#"{"a": "cube", "b": "polygon:4", "position": [2, 0]}"#,
                "two dimensions",
            ),
            (
                r#"{"a": "cube", "b": "ball", "position": [2, 0, 0]}"#,
                "'ball'",
            ),
            (
                r#"{"a": "cube", "b": "cube", "position": [2, 0, 0], "orientation_b": 0.1}"#,
                "orientation_b: give a quaternion",
            ),
        ] {
            let said = complaint(&format!("[{good}, {bad}]"));
            assert!(said.contains("pair 2") && said.contains(words), "{said}");
        }
        assert!(complaint("{}").contains("not a list of pairs"));
        let unknown = r#"[{"a": "cube", "b": "cube", "position": [2, 0, 0], "angle": 1}]"#;
        assert!(complaint(unknown).contains("angle"));
    }
}
