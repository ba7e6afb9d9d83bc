//! `protomer shape contact`: energies, forces and torques of pairs of convex shapes.

use crate::flags::settings::choice;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::range;
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction};
use protomer_shape_verbs::shapes::contact::contacts;
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
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = range::STRENGTH.number())]
    attraction: f64,
    /// Cut-off of the attraction, in units of its length; inf for none. It is switched off smoothly
    /// from 0.8 of that on.
    #[arg(long, default_value_t = 2.5, allow_negative_numbers = true)]
    attraction_cut_off: f64,
}

impl ContactArgs {
    pub fn run(&self) -> Result<Reply> {
        let interaction = Interaction {
            form: self.potential,
            attraction: Attraction {
                strength: self.attraction,
                cut_off: self.attraction_cut_off,
            },
            central: self.central,
        };
        Ok(Reply::data(contacts(&self.pairs, interaction)?))
    }
}
