//! `protomer phase-diagram`: coexisting phases from free energies.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_shape_verbs::hard_bodies::phases::{
    PhaseDirectories, Phases, draw, phases_of_measurements, phases_of_mixtures, phases_of_tables,
};
use std::path::PathBuf;

/// Print the phases that coexist: their packing fractions, pressure and chemical potential.
///
/// With `--size-ratio` and `--reservoir`, hard spheres among penetrable depletants by free volume theory:
/// the fluid of Carnahan and Starling, the cell model of the crystal, free volumes of scaled particle
/// theory. With `--fluid`, `--crystal` and `--free-energy`, any bodies, by what `hpmc sweep` and
/// `free-energy` measured, with errors; with `--reservoir` among the depletants whose free volumes
/// were measured. With `--branch`, tables of free energies: two columns, a packing fraction (or density)
/// and the free energy per volume, one file per phase.
///
/// Pressures are in units of kT over the volume of a body, chemical potentials in kT; with tables both
/// are in the units of the tables.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true)]
#[command(after_long_help = examples!(
    "phase-diagram --size-ratio 0.5 --reservoir 0.4,0.5,0.6",
    "phase-diagram --branch fluid.txt --branch solid.txt"
))]
#[group(id = "PhaseDiagramResult")]
pub struct PhaseDiagramArgs {
    /// Radius of the depletants over that of the spheres; several with commas between them.
    #[arg(long, value_delimiter = ',', value_name = "Q", requires = "reservoir")]
    size_ratio: Vec<f64>,
    /// Packing fraction of the depletants in the reservoir; several with commas between them.
    #[arg(long, value_delimiter = ',', value_name = "FRACTION")]
    reservoir: Vec<f64>,
    /// Directory of the `hpmc sweep` of a fluid over packing fractions.
    #[arg(long, value_name = "SWEEP", conflicts_with_all = ["size_ratio", "branch"])]
    fluid: Option<PathBuf>,
    /// Directory of the `hpmc sweep` of a crystal; once per crystal, each with its --free-energy.
    #[arg(long, value_name = "SWEEP", conflicts_with_all = ["size_ratio", "branch"])]
    crystal: Vec<PathBuf>,
    /// Directory of the `free-energy` of a crystal, in the order of the crystals.
    #[arg(long, value_name = "FREE_ENERGY", requires = "crystal")]
    free_energy: Vec<PathBuf>,
    /// Table of the free energy of a phase; once per phase.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["size_ratio", "reservoir"])]
    branch: Vec<PathBuf>,
    /// Figure to write, .svg or .png: packing fractions against the reservoir, with tie lines, critical and
    /// triple points; one size ratio per figure.
    #[arg(short, long, requires = "reservoir")]
    output: Option<PathBuf>,
}

impl PhaseDiagramArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let is_measured = self.fluid.is_some() || !self.crystal.is_empty();
        let phases = if is_measured {
            self.of_measurements()?
        } else if !self.branch.is_empty() {
            phases_of_tables(&self.branch)?
        } else if !self.size_ratio.is_empty() {
            phases_of_mixtures(&self.size_ratio, &self.reservoir)?
        } else {
            bail!(
                "give --size-ratio and --reservoir for spheres among depletants, --fluid and --crystal \
                 for phases that were measured, or a --branch FILE for each phase"
            )
        };
        if let Some(path) = &self.output {
            draw(&phases, path, front.force())?;
        }
        Ok(Reply::data(phases))
    }

    fn of_measurements(&self) -> Result<Phases> {
        if self.crystal.len() != self.free_energy.len() {
            bail!(
                "there are {} crystals and {} free energies; give a --free-energy for each --crystal, in \
                 the same order",
                self.crystal.len(),
                self.free_energy.len()
            );
        }
        let pairs = self
            .crystal
            .iter()
            .cloned()
            .zip(self.free_energy.iter().cloned());
        let directories = PhaseDirectories {
            fluid: self.fluid.clone(),
            crystals: pairs.collect(),
        };
        let without_depletants = [0.0];
        match self.reservoir.is_empty() {
            true => phases_of_measurements(&directories, &without_depletants),
            false => phases_of_measurements(&directories, &self.reservoir),
        }
    }
}
