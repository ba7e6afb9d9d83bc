//! The energy of a pair of convex shapes on a grid of places of the second one, as a table and as contours.

use anyhow::{Result, bail};
use protomer_common::output_file::write_folder;
use protomer_io::csv::{Cell, Table};
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Pose, Vec3};
use protomer_md::Error;
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Radial;
use protomer_md::pair::{CONTACT_RATIO, Interaction, Placed};
use protomer_plot::{ContourMap, ContourPanel};
use std::path::Path;

/// Cut-off that a map has for an attraction that reaches to infinity, in units of its length.
const ENDLESS: f64 = 2.5;
/// The largest number of levels of a figure.
const MOST_LEVELS: usize = 7;
/// Levels above zero that are taken unless others are given, in units of ε.
const REPULSIVE: [f64; 4] = [0.1, 1.0, 10.0, 100.0];
/// Levels below zero, of which those are taken that the energy reaches, lowest first.
const ATTRACTIVE: [f64; 9] = [-50.0, -20.0, -10.0, -5.0, -2.0, -1.0, -0.5, -0.2, -0.05];
/// Levels below zero, and above it next to them.
const LEVELS_BY_SIGN: [usize; 2] = [4, 2];

/// Grid and contours of a map.
///
/// ```
/// use protomer_shape_verbs::shapes::contact_map::MapSettings;
/// let coarse = MapSettings { points: 41, ..MapSettings::default() };
/// assert!(coarse.reach.is_none() && coarse.levels.is_empty(), "the bodies say both");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MapSettings {
    /// Largest coordinate of the centroid of the second body, in the unit of the shapes; `None` for as far as the
    /// bodies interact.
    pub reach: Option<f64>,
    /// Number of points along each axis.
    pub points: usize,
    /// Energies of the contours, in units of ε; empty for levels that suit the energies found.
    pub levels: Vec<f64>,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            reach: None,
            points: 121,
            levels: Vec::new(),
        }
    }
}

/// Energies of a pair on a grid of places of the second body, in units of ε.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ContactMap {
    /// Coordinates along both axes, in the unit of the shapes.
    axis: Vec<f64>,
    /// Height of the plane above the centroid of the first body.
    height: f64,
    /// Nodes row after row from the bottom; `None` where the bodies overlap.
    nodes: Vec<Option<Node>>,
    /// Section of the first body through the plane.
    outline: Vec<[f64; 2]>,
    /// Energies of the contours.
    levels: Vec<f64>,
    /// Term between the centroids.
    central: Central,
}

/// Energies at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    distance: f64,
    /// Energy of the points of the surfaces alone.
    contact: f64,
    /// Energy with the term between the centroids.
    total: f64,
}

impl ContactMap {
    /// Computes the map of a pair; the height of the plane is that of the second body.
    pub fn compute(
        pair: &Placed,
        interaction: Interaction,
        settings: &MapSettings,
        names: [&str; 2],
    ) -> Result<Self> {
        let reach = settings.reach.unwrap_or_else(|| reach(pair, interaction));
        let steps = (settings.points - 1) as f64;
        let axis: Vec<f64> = (0..settings.points)
            .map(|k| reach * (2.0 * k as f64 / steps - 1.0))
            .collect();
        let height = pair.poses[1].position.z;
        let mut nodes = Vec::with_capacity(axis.len().pow(2));
        for y in &axis {
            for x in &axis {
                nodes.push(node(pair, interaction, Vec3::new(*x, *y, height))?);
            }
        }
        let mut map = Self {
            axis,
            height,
            nodes,
            outline: section(pair.bodies[0], pair.poses[0], height),
            levels: settings.levels.clone(),
            central: interaction.central,
        };
        if map.levels.is_empty() {
            map.levels = map.fitting_levels();
        }
        if map.levels.is_empty() {
            bail!(
                "{} and {} have no energy anywhere on the map, which reaches to {reach}; change --map-reach, or the \
                 third coordinate of the position",
                names[0],
                names[1]
            );
        }
        if map.levels.len() > MOST_LEVELS {
            bail!(
                "{} levels are too many to tell apart; give at most {MOST_LEVELS}",
                map.levels.len()
            );
        }
        Ok(map)
    }

    /// Levels that the energies pass: a few of each sign.
    fn fitting_levels(&self) -> Vec<f64> {
        let energies = || {
            let nodes = self.nodes.iter().flatten();
            nodes.flat_map(|node| [node.contact, node.total])
        };
        let least = energies().fold(0.0, f64::min);
        let most = energies().fold(0.0, f64::max);
        let below = ATTRACTIVE.into_iter().filter(|level| *level > least);
        let mut levels: Vec<f64> = below.take(LEVELS_BY_SIGN[0]).collect();
        let above = match levels.is_empty() {
            true => REPULSIVE.as_slice(),
            // The attraction is the subject: two levels show where the repulsion begins.
            false => &REPULSIVE[1..=LEVELS_BY_SIGN[1]],
        };
        levels.extend(above.iter().filter(|level| **level < most));
        levels
    }

    /// Writes the table and the contours into a folder.
    ///
    /// # Errors
    /// If a file exists with other content and `force` is not set, or cannot be written.
    pub fn write(&self, folder: &Path, title: &str, force: bool) -> Result<()> {
        let figure = self.figure(title);
        let files = [
            ("energies.csv", self.table()?.to_csv()?.into_bytes()),
            ("contours.svg", figure.to_svg()?.into_bytes()),
            ("contours.png", figure.to_png()?),
        ];
        write_folder(folder, &files, force)
    }

    fn table(&self) -> Result<Table> {
        let mut table = Table::new(["x", "y", "distance", "contact_energy", "energy"]);
        for (index, node) in self.nodes.iter().enumerate() {
            let [x, y] = [index % self.axis.len(), index / self.axis.len()].map(|k| self.axis[k]);
            let value = |number: fn(&Node) -> f64| Cell::from(node.as_ref().map(number));
            table.push([
                x.into(),
                y.into(),
                value(|node| node.distance),
                value(|node| node.contact),
                value(|node| node.total),
            ])?;
        }
        Ok(table)
    }

    fn figure(&self, title: &str) -> ContourMap {
        let panel = |title: &str, energy: fn(&Node) -> f64| ContourPanel {
            title: title.into(),
            values: self
                .nodes
                .iter()
                .map(|node| node.as_ref().map(energy))
                .collect(),
            outline: self.outline.clone(),
        };
        let mut panels = vec![panel("points of the surfaces", |node| node.contact)];
        if self.central != Central::None {
            let name = format!(
                "with the central term ({})",
                protomer_kernel::setting::Choices::name(self.central)
            );
            panels.push(panel(&name, |node| node.total));
        }
        let [first, last] = [self.axis[0], self.axis[self.axis.len() - 1]];
        let plane = match self.height == 0.0 {
            true => String::new(),
            false => format!(", in the plane z = {}", self.height),
        };
        ContourMap {
            title: title.into(),
            caption: format!(
                "energy in ε by the place of the second body{plane}; light grey: the bodies overlap"
            ),
            x: "x".into(),
            y: "y".into(),
            ends: [first, last],
            points: self.axis.len(),
            levels: self.levels.clone(),
            panels,
        }
    }
}

/// Distance from the first centroid up to which the second one feels the first body, rounded up to two digits.
fn reach(pair: &Placed, interaction: Interaction) -> f64 {
    let radii = pair.radii[0] + pair.radii[1];
    let [a, b] = pair.bodies;
    let sigma = a.inradius() + b.inradius() + radii;
    let range = |sigma: f64| {
        let attraction = interaction.attraction;
        let range = Radial { sigma, attraction }.range();
        range.min(ENDLESS * sigma)
    };
    let of_contacts = a.circumradius() + b.circumradius() + radii + range(CONTACT_RATIO * sigma);
    let farthest = match interaction.central {
        Central::None => of_contacts,
        _ => of_contacts.max(range(sigma)),
    };
    let digit = 10_f64.powf(farthest.log10().floor() - 1.0);
    // A reach that is a whole number of digits but for rounding is one.
    (farthest / digit - 1e-9).ceil() * digit
}

/// Energies with the second centroid at this place; `None` where the bodies overlap.
fn node(pair: &Placed, interaction: Interaction, position: Vec3) -> Result<Option<Node>> {
    let pose = Pose {
        position,
        rotation: pair.poses[1].rotation,
    };
    let placed = Placed {
        poses: [pair.poses[0], &pose],
        ..*pair
    };
    let forces_with = |central| match placed.forces(Interaction {
        central,
        ..interaction
    }) {
        Ok(forces) => Ok(Some(forces)),
        Err(Error::Overlap) => Ok(None),
        Err(error) => Err(error),
    };
    let (Some(contact), Some(total)) = (
        forces_with(Central::None)?,
        forces_with(interaction.central)?,
    ) else {
        return Ok(None);
    };
    let node = Node {
        distance: contact.distance,
        contact: contact.energy,
        total: total.energy,
    };
    // Bodies that all but touch have an energy beyond all numbers.
    let is_finite = node.contact.is_finite() && node.total.is_finite();
    Ok(is_finite.then_some(node))
}

/// Corners of the section of a body through the plane of this height, counter-clockwise; of a polygon its corners.
fn section(body: &Polytope, pose: &Pose, height: f64) -> Vec<[f64; 2]> {
    let corners = body.corners_at(pose);
    let mut points: Vec<[f64; 2]> = match body.dimension {
        2 => corners.iter().map(|corner| [corner.x, corner.y]).collect(),
        _ => body
            .edges
            .iter()
            .filter_map(|[from, to]| crossing(&corners[*from], &corners[*to], height))
            .collect(),
    };
    // A section of a convex body is convex, so angles about the mean put its corners in order.
    let count = points.len().max(1) as f64;
    let sums = points
        .iter()
        .fold([0.0; 2], |[x, y], p| [x + p[0], y + p[1]]);
    let [x, y] = sums.map(|sum| sum / count);
    let angle = |p: &[f64; 2]| (p[1] - y).atan2(p[0] - x);
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points
}

fn crossing(from: &Vec3, to: &Vec3, height: f64) -> Option<[f64; 2]> {
    let [below, above] = [from.z - height, to.z - height];
    if (below < 0.0) == (above < 0.0) {
        return None;
    }
    let point = from + (below / (below - above)) * (to - from);
    Some([point.x, point.y])
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::Rotation;
    use protomer_kernel::shape::builders::by_name;
    use protomer_md::pair::Form;
    use protomer_md::pair::radial::Attraction;

    const LENNARD_JONES: Attraction = Attraction {
        strength: 1.0,
        cut_off: f64::INFINITY,
    };

    fn interaction(form: Form, central: Central) -> Interaction {
        Interaction {
            form,
            attraction: LENNARD_JONES,
            central,
        }
    }

    /// The distance at which the energy along a direction passes a level, from the far side.
    fn radius(pair: &Placed, interaction: Interaction, angle: f64, level: f64) -> f64 {
        let energy = |r: f64| {
            let place = r * Vec3::new(angle.cos(), angle.sin(), 0.0);
            node(pair, interaction, place)
                .unwrap()
                .map(|node| node.total)
        };
        let mut r = 4.0;
        while energy(r).is_some_and(|energy| energy > level) {
            r -= 1e-3;
        }
        r
    }

    #[test]
    fn grid_values_are_the_energies_of_single_pairs() {
        let square = Polytope::from_shape(&by_name("polygon:4").unwrap()).unwrap();
        let unmoved = Pose::identity();
        let turned = Pose {
            position: Vec3::zeros(),
            rotation: Rotation::from_scaled_axis(0.3 * Vec3::z()),
        };
        let pair = Placed::sharp([&square, &square], [&unmoved, &turned]);
        let interaction = interaction(Form::Smooth, Central::Conservative);
        let settings = MapSettings {
            reach: Some(1.8),
            points: 19,
            levels: vec![-0.5],
        };
        let map = ContactMap::compute(&pair, interaction, &settings, ["a", "b"]).unwrap();
        let mut compared = 0;
        for (index, node) in map.nodes.iter().enumerate() {
            // The coordinates of the grid, said a second time.
            let [x, y] = [index % 19, index / 19].map(|k| -1.8 + 0.2 * k as f64);
            let place = Pose {
                position: Vec3::new(x, y, 0.0),
                ..turned
            };
            let alone = Placed::sharp([&square, &square], [&unmoved, &place]);
            match node {
                None => assert!(matches!(alone.forces(interaction), Err(Error::Overlap))),
                Some(node) => {
                    let energy = alone.forces(interaction).unwrap().energy;
                    assert!((node.total - energy).abs() <= 1e-9 * energy.abs().max(1.0));
                    let energy = alone.forces(Interaction {
                        central: Central::None,
                        ..interaction
                    });
                    let energy = energy.unwrap().energy;
                    assert!((node.contact - energy).abs() <= 1e-9 * energy.abs().max(1.0));
                    compared += 1;
                }
            }
        }
        assert!((100..361).contains(&compared), "{compared}");
    }

    #[test]
    fn contours_keep_the_shape_only_if_the_central_term_is_rescaled() {
        // Nearly a disk around a square whose corners are on the axes, level -0.2 ε, across a side and along a diagonal.
        let [square, disk] = ["polygon:4", "polygon:60"]
            .map(|name| Polytope::from_shape(&by_name(name).unwrap()).unwrap());
        let unmoved = Pose::identity();
        let pair = Placed::sharp([&square, &disk], [&unmoved, &unmoved]);
        let ratio = |central| {
            let law = interaction(Form::Contact, central);
            let [side, diagonal] =
                [std::f64::consts::FRAC_PI_4, 0.0].map(|angle| radius(&pair, law, angle, -0.2));
            diagonal / side
        };
        let [none, unscaled, rescaled] =
            [Central::None, Central::Conservative, Central::Gradient].map(ratio);
        // From the closest points: a gap of 0.2605 where the contact alone has the level, and the distance 1.737 where the central term has it, which
        // M = (√2 - 1)/2 moves outwards at a corner.
        assert!((none - 1.157).abs() < 0.003, "{none}");
        assert!((unscaled - 1.005).abs() < 0.003, "{unscaled}");
        assert!((rescaled - 1.120).abs() < 0.003, "{rescaled}");
    }

    #[test]
    fn sections_are_those_of_the_plane() {
        let cube = Polytope::from_shape(&by_name("cube").unwrap()).unwrap();
        let section_at = |height| section(&cube, &Pose::identity(), height);
        assert_eq!(section_at(0.2).len(), 4);
        assert!(
            section_at(0.2)
                .iter()
                .flatten()
                .all(|x| (x.abs() - 0.5).abs() < 1e-12)
        );
        assert!(section_at(0.7).is_empty());
    }

    #[test]
    fn levels_suit_the_energies_and_their_absence_is_said() {
        let square = Polytope::from_shape(&by_name("polygon:4").unwrap()).unwrap();
        let unmoved = Pose::identity();
        let pair = Placed::sharp([&square, &square], [&unmoved, &unmoved]);
        let settings = |reach| MapSettings {
            reach,
            points: 41,
            levels: Vec::new(),
        };
        let repulsion = Interaction::from(Form::Smooth);
        let map = ContactMap::compute(&pair, repulsion, &settings(None), ["a", "b"]).unwrap();
        assert_eq!(map.levels, REPULSIVE);
        let law = interaction(Form::Contact, Central::None);
        let map = ContactMap::compute(&pair, law, &settings(None), ["a", "b"]).unwrap();
        assert_eq!(map.levels, [-0.5, -0.2, -0.05, 1.0, 10.0]);
        let inside = ContactMap::compute(&pair, repulsion, &settings(Some(0.3)), ["a", "b"]);
        let words = inside.unwrap_err().to_string();
        assert!(
            words.contains("a and b") && words.contains("--map-reach"),
            "{words}"
        );
    }
}
