//! `protomer residues`: which residues hold an assembly together.

use crate::flags::cache::CacheArgs;
use crate::flags::medium::ConditionArgs;
use crate::flags::model::ModelArgs;
use crate::flags::settings::choice;
use crate::flags::solute::ChargesArgs;
use crate::flags::terms::TermsArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_protein_verbs::export::Viewer;
use protomer_protein_verbs::stability::residues::{PoseSettings, ResiduesSettings, residues};
use protomer_protein_verbs::stability::run::{EnergyMode, RunSettings};
use std::path::PathBuf;

/// Share out the energy of an assembly by residues and pairs of residues, averaged over the frames
/// of a sweep or a simulation: which residues hold it together, which touch, and what single
/// exchanges of charge would change. Where effective charges interact, energies are shared out by
/// the plain charges of the bodies. Where runs from the assembly and from a fluid disagree, only
/// frames count in which more than half of the contacts are left.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "residues stability --salt 100mM --mutations",
    "residues ring.json --salt 100mM -o holds --script pymol"
))]
pub struct ResiduesArgs {
    /// Directory of a sweep or a simulation, or an assembly file.
    input: PathBuf,
    /// Folder of tables, maps and a structure coloured by energy [default: residues in the directory
    /// of a run; none for an assembly].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Scan exchanges of single charges on the surfaces as well, and the half salt they lead to.
    #[arg(long)]
    mutations: bool,
    /// With --mutations: also list exchanges of residues that touch another body. Their energy
    /// changes by more than their charge does, which the scan does not know.
    #[arg(long, requires = "mutations")]
    include_touching: bool,
    /// Residues touch where heavy atoms of them are closer than this.
    #[arg(long, value_name = "LENGTH", default_value = "5A", allow_hyphen_values = true, value_parser = range::TOUCHING.read(quantity::length_angstrom))]
    touching: f64,
    /// Frames that are used for each salt concentration.
    #[arg(long, default_value_t = 200, value_parser = range::OBJECTS.number::<usize>())]
    frames: usize,
    /// Write a script that shows the structure, coloured by energy.
    #[arg(long, value_parser = choice::<Viewer>())]
    script: Option<Viewer>,
    /// Assembly file of a run, if it has moved.
    #[arg(long)]
    assembly: Option<PathBuf>,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    charges: ChargesArgs,
    #[command(flatten)]
    terms: TermsArgs,
    #[command(flatten)]
    cache: CacheArgs,
}

impl ResiduesArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        front.warn(quantity::salt_warning(self.conditions.salt));
        let medium = self.conditions.medium.medium();
        let has_charges = self.model.model.is_some()
            || self.charges.interaction.is_some()
            || self.charges.solute.solute().is_some();
        let usual = RunSettings {
            energy: Some(EnergyMode::Direct),
            ..RunSettings::default()
        };
        let acting = self.model.acting(&self.charges, &self.terms, usual)?;
        let pose = PoseSettings {
            is_stated: medium != Default::default() || has_charges || self.terms.is_given(),
            run: RunSettings { medium, ..acting },
        };
        let settings = ResiduesSettings {
            input: self.input.clone(),
            output: self.output.clone(),
            salt_molar: self.conditions.salt,
            assembly: self.assembly.clone(),
            pose,
            touching_angstrom: self.touching,
            most_frames: self.frames,
            mutations: self.mutations,
            recommends_touching: self.include_touching,
            script: self.script,
            force: front.force(),
        };
        let store = self.cache.effective_store(front);
        let result = residues(&settings, store, &*front.progress())?;
        let files = result.files.iter();
        let notes: Vec<String> = files
            .map(|file| format!("written: {}", file.display()))
            .collect();
        let warnings = result.warnings.clone();
        Ok(Reply::data(result)
            .with_notes(warnings)
            .with_repeated(notes))
    }
}
