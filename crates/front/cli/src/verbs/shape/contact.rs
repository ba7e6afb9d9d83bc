//! `protomer shape contact`: energies, forces and torques of pairs of convex shapes.

use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::range::{self, Count};
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction};
use protomer_shape_verbs::shapes::contact::{contacts, map_contact};
use protomer_shape_verbs::shapes::contact_map::MapSettings;
use std::path::PathBuf;

/// Print the repulsion of pairs of convex shapes: energy, force and torques of each pair.
///
/// PAIRS is a JSON list of objects: `a` and `b` (file or name of a shape, as for `shape`), `position`
/// (of the centroid of b; that of a is at the origin), `orientation_a` and `orientation_b` (an angle
/// in radians for polygons, a quaternion w x y z for polyhedra; left out: not turned).
///
/// The repulsion has the length 0.15 sigma, where sigma is the mean diameter of the balls about the
/// centroids that fit in, and the energy 1 at that distance; energies are in units of epsilon.
#[derive(Debug, Args)]
pub struct ContactArgs {
    /// JSON file with the pairs.
    pairs: PathBuf,
    /// Points of the bodies that repel each other.
    #[arg(long, value_parser = choice::<Form>(), default_value = "smooth")]
    potential: Form,
    /// Energy between the centroids, added to that of the points.
    #[arg(long, value_parser = choice::<Central>(), default_value = "none")]
    central: Central,
    /// Strength of the attraction: 0 for the repulsion alone, 1 for Lennard-Jones.
    #[arg(long, default_value_t = 0.0, value_parser = range::STRENGTH.number())]
    attraction: f64,
    /// Cut-off of the attraction, in units of its length; inf for none. It is switched off smoothly
    /// from 0.8 of that on.
    #[arg(long, default_value_t = 2.5)]
    attraction_cut_off: f64,
    /// Folder for a map of the energy over places of b, at the height of its position: energies.csv, contours.svg and
    /// contours.png; for a file with one pair.
    #[arg(long, value_name = "FOLDER", help_heading = "Map")]
    map: Option<PathBuf>,
    /// Largest coordinate of the map; as far as the bodies interact if omitted.
    #[arg(long, value_name = "LENGTH", requires = "map", value_parser = range::POSITIVE.number(), help_heading = "Map")]
    map_reach: Option<f64>,
    /// Points of the map along each axis.
    #[arg(long, value_name = "NUMBER", requires = "map", default_value_t = 121, value_parser = MAP_POINTS.number::<usize>(), help_heading = "Map")]
    map_points: usize,
    /// Energies of the contours, at most seven with commas between them; chosen by the energies found if omitted.
    #[arg(long, value_name = "ENERGY,…", requires = "map", value_delimiter = ',', allow_hyphen_values = true, value_parser = range::STRENGTH.number(), help_heading = "Map")]
    map_levels: Vec<f64>,
}

/// Range of the number of points of a map along each axis.
const MAP_POINTS: Count = Count::new(5, 1001);

impl ContactArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let interaction = Interaction {
            form: self.potential,
            attraction: Attraction {
                strength: self.attraction,
                cut_off: self.attraction_cut_off,
            },
            central: self.central,
        };
        let reply = Reply::data(contacts(&self.pairs, interaction)?);
        let Some(folder) = &self.map else {
            return Ok(reply);
        };
        let settings = MapSettings {
            reach: self.map_reach,
            points: self.map_points,
            levels: self.map_levels.clone(),
        };
        map_contact(&self.pairs, interaction, &settings, folder, front.force())?;
        let picture = folder.join("contours.png");
        Ok(reply.with_note(format!("map: {}", picture.display())))
    }
}
