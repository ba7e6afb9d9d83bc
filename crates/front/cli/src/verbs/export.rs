//! `protomer export`: back to atoms.

use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::quantity;
use protomer_protein_verbs::export::{
    ExportSettings, Frame, ResidueValues, Schema, Viewer, export, export_trajectory, is_trajectory,
};
use std::path::PathBuf;

/// Write an assembly, or a frame of a simulation, as a PDB or mmCIF file with all atoms of the
/// bodies, and a script for a viewer. Chains get new identifiers; a table in the file says which
/// copy and chain each was. An output that ends in .gsd is a trajectory in another version of its schema.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "export ring.json -o ring.cif --script chimerax",
    "export stability --salt 300mM --frame last -o end.pdb"
))]
pub struct ExportArgs {
    /// Assembly file, body file, or directory of a simulation or a sweep; for a trajectory also a .gsd
    /// file and the directory of any other run.
    input: PathBuf,
    /// Structure file to write, .pdb or .cif, or trajectory, .gsd.
    #[arg(short, long)]
    output: PathBuf,
    /// Frame of a simulation, counted from 0, or last [default: last; for a trajectory all].
    #[arg(long, value_parser = Frame::parse, allow_hyphen_values = true)]
    frame: Option<Frame>,
    /// Salt concentration of a sweep, such as 100mM.
    #[arg(long, value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    salt: Option<f64>,
    /// Replica of a sweep, counted from 0 [default: 0].
    #[arg(long)]
    replica: Option<u32>,
    /// Assembly file of a simulation, if it has moved.
    #[arg(long)]
    assembly: Option<PathBuf>,
    /// Contents of the B factors of the residues; zero if omitted.
    #[arg(long, value_parser = choice::<ResidueValues>())]
    values: Option<ResidueValues>,
    /// Shift copies by box lengths, so that a cluster across the border of a periodic box is in one
    /// piece.
    #[arg(long)]
    gather: bool,
    /// Write a script that opens the file, colours the bodies by kind and shows transparent surfaces; with
    /// --values, surfaces in the colours of the values.
    #[arg(long, value_parser = choice::<Viewer>())]
    script: Option<Viewer>,
    /// Version of the HOOMD schema of a trajectory [default: 2.0].
    #[arg(long, value_parser = choice::<Schema>())]
    schema: Option<Schema>,
}

impl ExportArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = ExportSettings {
            input: self.input.clone(),
            output: self.output.clone(),
            frame: self.frame,
            salt_molar: self.salt,
            replica: self.replica,
            assembly: self.assembly.clone(),
            values: self.values,
            gather: self.gather,
            script: self.script,
            schema: self.schema,
            force: front.force(),
        };
        match is_trajectory(&settings.output) {
            true => Ok(Reply::from_answer(export_trajectory(&settings)?)),
            false => Ok(Reply::from_answer(export(&settings)?)),
        }
    }
}
