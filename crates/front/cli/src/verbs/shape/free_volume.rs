//! `protomer shape free-volume`: free volumes of depletants by scaled particle theory.

use crate::flags::hard_body::{FreeVolumeGridArgs, RoundingArgs};
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_shape_verbs::shapes::free_volume::scaled_particles;

/// Print the part of space that is open to depletants in a fluid of hard convex bodies, by scaled particle theory.
///
/// The theory is exact for points and to first order in the density, and an approximation for dense fluids. For crystals,
/// see `hpmc free-volume`.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "shape free-volume cube --packing-fraction 0.3 --depletant-radius 0.1",
    "shape free-volume ellipsoid:1,1,3 --packing-fraction 0.1,0.2 --depletant-radius 0.05"
))]
pub struct FreeVolumeArgs {
    /// File or name of a shape in space, as for `shape`.
    shape: String,
    #[command(flatten)]
    rounding: RoundingArgs,
    #[command(flatten)]
    grid: FreeVolumeGridArgs,
}

impl FreeVolumeArgs {
    pub fn run(&self) -> Result<Reply> {
        Ok(Reply::data(scaled_particles(
            &self.shape,
            self.rounding.rounding,
            &self.grid.packing_fraction,
            &self.grid.depletant_radius,
        )?))
    }
}
