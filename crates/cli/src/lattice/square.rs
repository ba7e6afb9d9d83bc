//! `protomer lattice square`: the square that stands for a body.

use super::super::choices::{SquareSize, ViewAxis};
use super::super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::bodies::body_file;
use protomer::lattice::square_of_body::{Axis, Size, square_of_body};
use protomer_io::atomic::write_atomically;
use std::path::{Path, PathBuf};

/// The square that stands for a body with a symmetry axis, as part of a configuration.
#[derive(Debug, Args)]
pub struct SquareArgs {
    /// Body file.
    body: PathBuf,
    /// The axis to look along.
    #[arg(long, value_enum, default_value_t = ViewAxis::Auto)]
    axis: ViewAxis,
    /// What the half-diagonal is.
    #[arg(long, value_enum, default_value_t = SquareSize::Corners)]
    size: SquareSize,
    /// Write the configuration to this file instead of stdout.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl SquareArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        square(
            &self.body,
            self.axis.into(),
            self.size.into(),
            self.output.as_deref(),
            global,
        )
    }
}

/// Prints or writes the square of a body.
pub(super) fn square(
    body: &Path,
    axis: Axis,
    size: Size,
    to: Option<&Path>,
    global: &Global,
) -> Result<Outcome> {
    let (body, _) = body_file::read(body)?;
    let square = square_of_body(&body, axis, size)?;
    if let Some(path) = to {
        if path.exists() && !global.force {
            bail!(
                "{} is there already; give --force to replace it",
                path.display()
            );
        }
        let text = square.to_toml()?;
        write_atomically(path, |file| file.write_all(text.as_bytes()))?;
    }
    if global.json {
        output::json(&square)?;
    } else if to.is_none() {
        output::text(square.to_toml()?.trim_end())?;
    } else {
        global.say(&square.describe());
    }
    Ok(Outcome::Done)
}
