//! `protomer shape free-volume`: free volumes of depletants by scaled particle theory.

use crate::flags::hard_body::FreeVolumeGridArgs;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_shape_verbs::shapes::free_volume::scaled_particles;

/// Print the part of space that is open to depletants in a fluid of hard convex bodies, by scaled particle theory.
///
/// The theory is exact for points and to first order in the density, and an approximation for dense fluids. For crystals,
/// see `hpmc free-volume`.
#[derive(Debug, Args)]
pub struct FreeVolumeArgs {
    /// File or name of a shape in space, as for `shape`.
    shape: String,
    /// Radius of the ball that rounds it (Minkowski sum).
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "RADIUS",
        allow_negative_numbers = true
    )]
    rounding: f64,
    #[command(flatten)]
    grid: FreeVolumeGridArgs,
}

impl FreeVolumeArgs {
    pub fn run(&self) -> Result<Reply> {
        Ok(Reply::data(scaled_particles(
            &self.shape,
            self.rounding,
            &self.grid.packing_fraction,
            &self.grid.depletant_radius,
        )?))
    }
}
