//! `protomer pair`: the thermodynamics of two bodies.

use crate::flags::body::ProtonationArgs;
use crate::flags::cache::CacheArgs;
use crate::flags::execution::ExecutionArgs;
use crate::flags::medium::MediumArgs;
use crate::flags::model::ModelArgs;
use crate::flags::scheduler::PartArgs;
use crate::flags::settings::choice;
use crate::flags::solute::SoluteArgs;
use crate::flags::terms::TermsArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Context, Result, bail};
use clap::Args;
use protomer_body::BodySettings;
use protomer_body::chemistry::StructureTitration;
use protomer_common::{quantity, range};
use protomer_protein_verbs::stability::DEFAULT_CONTACT_GAP_ANGSTROM;
use protomer_protein_verbs::stability::contacts::ContactCore;
use protomer_protein_verbs::stability::effective::SoluteModel;
use protomer_protein_verbs::stability::model::Model;
use protomer_protein_verbs::stability::pair::{
    Energies, LAYOUT, PairBodies, PairRunSettings, run_pair, run_pair_shard,
};
use protomer_protein_verbs::stability::terms::StatedTerms;
use protomer_results::{End, Execution, ResultsDirectory};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Compute the thermodynamics of two bodies over a grid of salt and pH: second virial coefficient,
/// potential of mean force, dissociation constant, bound poses. The same command continues work
/// that was stopped.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "pair 4lzt.pdb.gz --salt 100mM,300mM --ph 4.5 --interaction effective -o lysozyme",
    "pair a.body b.body --salt 10mM..1M/8 -o association"
))]
#[command(mut_arg("shard", |shard| shard.requires("output")))]
#[group(id = "PairResult")]
pub struct PairArgs {
    /// A body or a structure file.
    first: PathBuf,
    /// The other body or structure file; a second copy of the first if omitted.
    second: Option<PathBuf>,
    /// Directory of the results; nothing is kept if omitted.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Salt concentrations: a list such as 10mM,50mM,100mM or a range such as 10mM..1M/8.
    #[arg(long, allow_hyphen_values = true)]
    salt: Option<String>,
    /// pH values at which structure files are made into bodies, such as 4.5,7.
    #[arg(long, value_delimiter = ',')]
    ph: Vec<f64>,
    #[command(flatten)]
    protonation: ProtonationArgs,
    /// Interaction of the bodies apart from their hard cores [default: bare].
    #[arg(long, value_parser = choice::<Energies>())]
    interaction: Option<Energies>,
    #[command(flatten)]
    model: ModelArgs,
    /// The wanted standard error of B2, relative to the larger of its magnitude and its hard part.
    #[arg(long, default_value_t = 0.004)]
    relative_error: f64,
    /// The wanted standard error of B22, mol mL/g², such as 3e-5; instead of a relative one.
    #[arg(long, conflicts_with = "relative_error")]
    b22_error: Option<f64>,
    /// Directions with energies that may be sampled for one condition.
    #[arg(long, default_value_t = 65_536)]
    most_directions: u64,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Bodies whose surfaces are closer than this are bound, Å.
    #[arg(long, default_value_t = DEFAULT_CONTACT_GAP_ANGSTROM, value_parser = range::CONTACT_GAP.number())]
    contact_gap: f64,
    #[command(flatten)]
    part: PartArgs,
    /// Hard cores of the bodies: their surfaces, or the cores of the beads of the contact term.
    #[arg(long, value_parser = choice::<ContactCore>(), default_value = "surface")]
    core: ContactCore,
    #[command(flatten)]
    terms: TermsArgs,
    #[command(flatten)]
    solute: SoluteArgs,
    #[command(flatten)]
    medium: MediumArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
    #[command(flatten)]
    cache: CacheArgs,
}

impl PairArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let execution = self.execution.execution(front)?;
        if let Some(directory) = &self.output {
            ResultsDirectory::refuse_other_settings(directory, &LAYOUT, &settings, &execution)?;
        }
        let body = self
            .model
            .model()
            .map_or_else(BodySettings::default, Model::body_settings);
        let bodies = PairBodies::read_with(&self.first, self.second.as_deref(), &settings, &body)?
            .with_effective_store(self.cache.effective_store(front));
        for warning in &bodies.warnings {
            front.say(warning);
        }
        match &self.output {
            Some(directory) => self.compute(&bodies, &settings, directory, &execution),
            None => {
                let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
                self.compute(&bodies, &settings, &folder.path().join("pair"), &execution)
            }
        }
    }

    fn compute(
        &self,
        bodies: &PairBodies,
        settings: &PairRunSettings,
        directory: &Path,
        execution: &Execution,
    ) -> Result<Reply> {
        if let Some(shard) = self.part.shard() {
            let end = run_pair_shard(bodies, settings, directory, shard, execution)?;
            return Ok(Reply::of_part(end, shard, ["condition", "conditions"]));
        }
        Ok(match run_pair(bodies, settings, directory, execution)? {
            End::Finished(result) => {
                let mut warnings = Vec::new();
                for condition in &result.conditions {
                    warnings.extend(condition.warnings.iter().cloned());
                }
                let mut said = HashSet::new();
                warnings.retain(|warning| said.insert(warning.clone()));
                let reply = Reply::from_answer(result).with_notes(warnings);
                match &self.output {
                    Some(output) => {
                        let figure = output.join("pair.png");
                        let reply = reply.with_note(format!("figure: {}", figure.display()));
                        let map = output.join("pair_map.png");
                        match map.is_file() {
                            true => reply.with_note(format!("map: {}", map.display())),
                            false => reply,
                        }
                    }
                    None => reply,
                }
            }
            End::Stopped => Reply::stopped(match &self.output {
                Some(output) => {
                    format!("stopped; the same command continues {}", output.display())
                }
                None => "stopped; without --output nothing is kept".into(),
            }),
        })
    }

    /// Model of the inside of the bodies. It is stored even where it is the default, so that a run
    /// keeps it if the default changes.
    fn effective_solute(&self) -> Option<SoluteModel> {
        match self.interaction() {
            Energies::Effective | Energies::Response => {
                Some(self.solute.solute().unwrap_or_default())
            }
            Energies::Hard | Energies::Bare => self.solute.solute(),
        }
    }

    /// Interaction of the charges, stated or by the model.
    fn interaction(&self) -> Energies {
        let response = self.model.model().map(Model::solvent_response);
        let by_model = match response {
            Some(Some(_)) => Energies::Response,
            Some(None) | None => Energies::Bare,
        };
        self.interaction.unwrap_or(by_model)
    }

    /// Titration of structure files, stated or by the model; none where no structure file is given, as bodies
    /// have their charges.
    fn titration(&self) -> Result<Option<StructureTitration>> {
        let files = [Some(&self.first), self.second.as_ref()];
        let is_body = |file: &&PathBuf| file.extension().is_some_and(|ending| ending == "body");
        let model = self.model.model().and_then(Model::titration);
        let are_bodies = files.into_iter().flatten().all(|file| is_body(&file));
        self.protonation
            .titration_over(model.filter(|_| !are_bodies))
    }

    fn stated_terms(&self) -> Result<StatedTerms> {
        let terms = self.model.terms(&self.terms);
        let stated = terms.over(StatedTerms::default(), self.core)?;
        if self.core == ContactCore::Beads && stated.contacts.is_none() {
            bail!(
                "--core beads takes the cores of a contact term; add --contacts calvados3, or \
                 leave it out"
            );
        }
        Ok(stated)
    }

    fn settings(&self) -> Result<PairRunSettings> {
        let mut settings = PairRunSettings {
            salt_molar: match &self.salt {
                Some(salt) => quantity::salt_list(salt)?,
                None => Vec::new(),
            },
            ph: self.ph.clone(),
            protonation: self.titration()?,
            energies: self.interaction(),
            solute: self.effective_solute(),
            contact_gap_angstrom: self.contact_gap,
            b22_error_mol_ml_per_g2: self.b22_error,
            medium: self.medium.medium(),
            ..PairRunSettings::default()
        };
        settings.set_terms(self.stated_terms()?);
        settings.sampling.seed = self.seed;
        settings.sampling.relative_error = self.relative_error;
        settings.sampling.most_directions = self.most_directions;
        settings.check()?;
        Ok(settings)
    }
}
