//! `protomer hpmc free-volume`: free volumes of crystals that do not move.

use crate::flags::hard_body::{FreeVolumeGridArgs, RoundingArgs};
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_shape_verbs::hard_bodies::start::names_of_crystals;
use protomer_shape_verbs::hard_bodies::static_free_volume::{
    StaticFreeVolumeSettings, static_free_volumes,
};

/// Print the free volume of depletants in a perfect crystal whose bodies do not move.
///
/// Lines through the unit cell are cut exactly by the bodies, each swept by a depletant; the error is
/// that of grids of lines that are shifted against each other. For crystals that move, give `run` a
/// start and depletants.
#[derive(Debug, Args)]
pub struct FreeVolumeArgs {
    /// File with points, or the name of a shape, as for `shape`.
    #[arg(long, value_name = "FILE")]
    shape: String,
    #[command(flatten)]
    rounding: RoundingArgs,
    #[arg(long, help = format!("Name of the crystal ({}), or the file of its unit cell", names_of_crystals(&[3])))]
    crystal: String,
    /// Turn every body first: a quaternion W,X,Y,Z.
    #[arg(long, value_delimiter = ',')]
    turn: Vec<f64>,
    #[command(flatten)]
    grid: FreeVolumeGridArgs,
    /// Lines along the shortest edge of the unit cell.
    #[arg(long, default_value_t = 100, value_name = "NUMBER")]
    lines: usize,
}

impl FreeVolumeArgs {
    pub fn run(&self) -> Result<Reply> {
        Ok(Reply::data(static_free_volumes(
            &StaticFreeVolumeSettings {
                shape: self.shape.clone(),
                rounding_radius: self.rounding.rounding,
                crystal: self.crystal.clone(),
                turn: self.turn.clone(),
                packing_fractions: self.grid.packing_fraction.clone(),
                depletant_radii: self.grid.depletant_radius.clone(),
                lines: self.lines,
            },
        )?))
    }
}
