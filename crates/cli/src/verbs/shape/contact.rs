//! `protomer shape contact`: energies, forces and torques of pairs of convex shapes.

use crate::reply::Reply;
use anyhow::Result;
use clap::{Args, ValueEnum};
use protomer::shapes::contact::contacts;
use protomer_md::pair::Form;
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
    /// Which points of the bodies repel each other.
    #[arg(long, value_enum, default_value_t = Potential::Smooth)]
    potential: Potential,
}

/// Which points of two bodies repel each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Potential {
    /// The closest points alone; torques jump where faces are parallel.
    Contact,
    /// Corners and edges of the two faces that look at each other, as published.
    FaceSum,
    /// Corners and edges of both bodies, with forces that are the exact gradient.
    Smooth,
}

impl From<Potential> for Form {
    fn from(potential: Potential) -> Self {
        match potential {
            Potential::Contact => Form::Contact,
            Potential::FaceSum => Form::FaceSum,
            Potential::Smooth => Form::Smooth,
        }
    }
}

impl ContactArgs {
    pub fn run(&self) -> Result<Reply> {
        Ok(Reply::data(contacts(&self.pairs, self.potential.into())?))
    }
}
