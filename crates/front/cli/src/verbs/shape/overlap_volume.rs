//! `protomer shape overlap-volume`: the volumes that depletants gain between pairs of convex shapes.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_shape_verbs::shapes::overlap::shared_volumes;
use std::path::PathBuf;

/// Print the volume that two convex shapes, swept by a depletant, have in common, for each pair.
///
/// PAIRS is a JSON list of objects: `a` and `b` (file or name of a shape, as for `shape`), `position`
/// (of the centroid of b; that of a is at the origin), `orientation_a` and `orientation_b` (an angle
/// in radians for polygons, a quaternion w x y z for polyhedra; left out: not turned),
/// `depletant_radius`, and `rounding_a` and `rounding_b` (radius of the ball that rounds each shape).
///
/// Penetrable depletants of number density n in the reservoir give the pair the energy -n kT times this
/// volume.
#[derive(Debug, Args)]
pub struct OverlapVolumeArgs {
    /// JSON file with the pairs.
    pairs: PathBuf,
}

impl OverlapVolumeArgs {
    pub fn run(&self) -> Result<Reply> {
        Ok(Reply::data(shared_volumes(&self.pairs)?))
    }
}
