//! `protomer lattice square`: the square that represents a body.

use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::output_file::write_once;
use protomer_linkage_verbs::lattice::square_of_body::{Axis, Size, square_of_body};
use protomer_protein_verbs::bodies::body_file;
use std::path::{Path, PathBuf};

/// The square that represents a body with a symmetry axis, as part of a configuration.
#[derive(Debug, Args)]
pub struct SquareArgs {
    /// Body file.
    body: PathBuf,
    /// Axis of projection.
    #[arg(long, value_parser = choice::<Axis>(), default_value = "auto")]
    axis: Axis,
    /// Definition of the half-diagonal.
    #[arg(long, value_parser = choice::<Size>(), default_value = "corners")]
    size: Size,
    /// Write the configuration to this file instead of stdout.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl SquareArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        square(
            &self.body,
            self.axis,
            self.size,
            self.output.as_deref(),
            front,
        )
    }
}

/// Shows or writes the square of a body.
pub fn square(
    body: &Path,
    axis: Axis,
    size: Size,
    output: Option<&Path>,
    front: &Front,
) -> Result<Reply> {
    let (body, _) = body_file::read(body)?;
    let square = square_of_body(&body, axis, size)?;
    let text = square.to_toml()?;
    let warning = square.warning();
    let notes = warning.map(|warning| format!("warning: {warning}"));
    let reply = Reply::from_answer(square).with_notes(notes);
    match output {
        Some(path) => {
            write_once(path, &text, front.force())?;
            Ok(reply)
        }
        None => Ok(reply.showing(text.trim_end().to_owned())),
    }
}
