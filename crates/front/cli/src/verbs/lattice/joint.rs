//! `protomer lattice joint`: the potential of the angle between two tied bodies.

use crate::flags::medium::ConditionArgs;
use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::output_file::write_once;
use protomer_common::quantity;
use protomer_linkage_verbs::lattice::square_of_body::{Axis, Size, square_of_body};
use protomer_protein_verbs::bodies::body_file;
use protomer_protein_verbs::stability::joint::{JointSettings, joint};
use std::path::PathBuf;

protomer_kernel::choices! {
    /// Charges that act between the bodies.
    enum Charges {
        /// The charges of the bodies, screened by salt.
        Bare = "bare",
        /// Effective charges: those that give the potential around bodies of low permittivity that salt
        /// does not enter.
        Effective = "effective",
    }
}

/// The potential of mean force of two copies of a body that a rod ties at their corners, against the
/// angle between them: a table for --angle-potential.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "lattice joint bodies/square.body --salt 100mM --rod 8A -o joint.csv",
    "lattice joint bodies/square.body --salt 20mM --rod 8A --turned-over"
))]
pub struct JointArgs {
    /// Body file.
    body: PathBuf,
    /// Length of the rod between the corners.
    #[arg(long, allow_hyphen_values = true)]
    rod: String,
    /// Axis of projection.
    #[arg(long, value_parser = choice::<Axis>(), default_value = "auto")]
    axis: Axis,
    /// Definition of the half-diagonal, at whose end the rod is tied.
    #[arg(long, value_parser = choice::<Size>(), default_value = "corners")]
    size: Size,
    /// Turn every other body over, so that neighbours face opposite ways.
    #[arg(long)]
    turned_over: bool,
    /// Angles from 0 to 180°.
    #[arg(long, default_value_t = 61)]
    openings: usize,
    /// Directions of the rod over which is averaged, an even number.
    #[arg(long, default_value_t = 360)]
    directions: usize,
    /// Charges of the bodies.
    #[arg(long, value_parser = choice::<Charges>(), default_value = "bare")]
    interaction: Charges,
    #[command(flatten)]
    condition: ConditionArgs,
    /// Write the table to this file instead of stdout.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl JointArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let (body, _) = body_file::read(&self.body)?;
        let square = square_of_body(&body, self.axis, self.size)?.square;
        front.warn(quantity::salt_warning(self.condition.salt));
        let settings = JointSettings {
            axis: square.axis,
            corner: square.corner,
            half_diagonal_angstrom: square.half_diagonal_angstrom,
            rod_angstrom: quantity::length_angstrom(&self.rod)?,
            is_turned_over: self.turned_over,
            openings: self.openings,
            directions: self.directions,
            interaction: self.condition.interaction()?,
            is_effective: self.interaction == Charges::Effective,
        };
        let answer = joint(&body, &settings)?;
        let table = answer.to_csv()?;
        let warning = answer
            .warning()
            .map(|warning| format!("warning: {warning}"));
        match &self.output {
            Some(path) => {
                write_once(path, &table, front.force())?;
                Ok(Reply::from_answer(answer).with_notes(warning))
            }
            None => Ok(Reply::data(answer)
                .showing(table.trim_end().to_owned())
                .with_notes(warning)),
        }
    }
}
