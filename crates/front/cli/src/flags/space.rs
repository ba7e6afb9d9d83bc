//! The box of an assembly.

use anyhow::{Result, bail};
use clap::Args;
use protomer_common::range;

/// The space around the assembly.
#[derive(Debug, Clone, Args)]
pub struct SpaceArgs {
    /// Edge of a cubic periodic box, or three edges, Å; open space if omitted.
    #[arg(long = "box", value_delimiter = ',', value_parser = range::BOX_EDGE.number())]
    box_angstrom: Vec<f64>,
}

impl SpaceArgs {
    /// The box described by the flags.
    pub fn box_angstrom(&self) -> Result<Option<[f64; 3]>> {
        let lengths = match self.box_angstrom.as_slice() {
            [] => return Ok(None),
            [edge] => [*edge; 3],
            [x, y, z] => [*x, *y, *z],
            other => bail!(
                "--box takes one or three lengths, but {} are given",
                other.len()
            ),
        };
        match lengths
            .iter()
            .find(|length| !(length.is_finite() && **length > 0.0))
        {
            Some(length) => bail!("--box has a length of {length} Å; lengths are positive"),
            None => Ok(Some(lengths)),
        }
    }
}
