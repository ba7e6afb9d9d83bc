//! `protomer phase-diagram`: coexisting phases from free energies.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer::hard_bodies::phases::{draw, phases_of_mixtures, phases_of_tables};
use std::path::PathBuf;

/// Print the phases that coexist: their packing fractions, pressure and chemical potential.
///
/// With `--size-ratio` and `--reservoir`, hard spheres among penetrable depletants by free volume theory:
/// the fluid of Carnahan and Starling, the cell model of the crystal, free volumes of scaled particle
/// theory. With `--branch`, tables of free energies: two columns, a packing fraction (or density) and the
/// free energy per volume, one file per phase.
///
/// Pressures are in units of kT over the volume of a sphere, chemical potentials in kT; with tables both
/// are in the units of the tables.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true)]
pub struct PhaseDiagramArgs {
    /// Radius of the depletants over that of the spheres; several with commas between them.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "Q",
        requires = "reservoir",
        allow_negative_numbers = true
    )]
    size_ratio: Vec<f64>,
    /// Packing fraction of the depletants in the reservoir; several with commas between them.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "FRACTION",
        requires = "size_ratio",
        allow_negative_numbers = true
    )]
    reservoir: Vec<f64>,
    /// Table of the free energy of a phase; once per phase.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["size_ratio", "reservoir"])]
    branch: Vec<PathBuf>,
    /// Figure to write, .svg or .png: packing fractions against the reservoir, with tie lines, critical and
    /// triple points; one size ratio per figure.
    #[arg(short, long, requires = "size_ratio")]
    output: Option<PathBuf>,
}

impl PhaseDiagramArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let phases = match (self.branch.is_empty(), self.size_ratio.is_empty()) {
            (false, _) => phases_of_tables(&self.branch)?,
            (true, false) => phases_of_mixtures(&self.size_ratio, &self.reservoir)?,
            (true, true) => bail!(
                "give --size-ratio and --reservoir for spheres among depletants, or a --branch FILE \
                 for each phase"
            ),
        };
        if let Some(path) = &self.output {
            draw(&phases, path, front.force())?;
        }
        Ok(Reply::data(phases))
    }
}
