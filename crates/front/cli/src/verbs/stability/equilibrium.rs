//! `protomer stability`: how much of an assembly there is at equilibrium.

use crate::flags::body::{ChainGroupArgs, ProtonationArgs, SelectionArgs};
use crate::flags::execution::ExecutionArgs;
use crate::flags::model::ModelArgs;
use crate::flags::scheduler::PartArgs;
use crate::flags::settings::choice;
use crate::flags::tables::TablesArgs;
use crate::flags::terms::ContactArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Context, Result, bail};
use clap::Args;
use protomer_common::{quantity, range};
use protomer_kernel::setting::Choices;
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::DEFAULT_CONTACT_GAP_ANGSTROM;
use protomer_protein_verbs::stability::contacts::ContactCore;
use protomer_protein_verbs::stability::equilibrium::{
    GrowthSettings, LAYOUT, StabilityBodies, StabilitySettings, StructureChoices, Way,
    WindowSettings, run_stability, run_stability_shard,
};
use protomer_protein_verbs::stability::interaction::InteractionSettings;
use protomer_protein_verbs::stability::model::Model;
use protomer_results::{End, Execution, ResultsDirectory};
use std::path::{Path, PathBuf};

/// Say how much of an assembly there is at equilibrium, up to which salt: yields of the whole and of its
/// parts by mass action over their partition functions. The same command continues work that was
/// stopped.
#[derive(Debug, Args)]
// `--model` names what acts between the bodies here.
#[command(mut_arg(SelectionArgs::MODEL, |model| model.long("structure-model").value_name("NUMBER")))]
#[command(after_long_help = examples!(
    "stability 4hhb.cif.gz --salt 50mM,150mM,500mM --concentration 1uM",
    "stability 6mdr/assembly.json --salt 50mM..1M/6 --concentration 100nM,1uM -o yields"
))]
#[command(mut_arg("shard", |shard| shard.requires("output")))]
#[group(id = "StabilityResult")]
pub struct StabilityArgs {
    /// Assembly file, structure file, or several structure files in one frame; each chain of a structure is a
    /// body.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    bodies: ChainGroupArgs,
    /// Directory of the results; nothing is kept if omitted.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Concentrations of a 1:1 salt: a list such as 50mM,150mM or a range such as 10mM..1M/8.
    #[arg(long, default_value = "50mM,150mM,500mM", allow_hyphen_values = true)]
    salt: String,
    /// Total concentrations of the bodies, free and bound, such as 100nM,1uM.
    #[arg(long, default_value = "1uM", allow_hyphen_values = true)]
    concentration: String,
    /// pH values at which structure files are made into bodies, such as 6,7.4 [default: 7.4].
    #[arg(long, value_delimiter = ',', value_parser = range::PH.number())]
    ph: Vec<f64>,
    #[command(flatten)]
    protonation: ProtonationArgs,
    /// Temperature, K.
    #[arg(long, default_value = "298.15", allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    temperature: f64,
    #[command(flatten)]
    model: ModelArgs,
    #[command(flatten)]
    attraction: ContactArgs,
    /// Bodies whose surfaces are closer than this may hold a part together, Å.
    #[arg(long, default_value_t = DEFAULT_CONTACT_GAP_ANGSTROM, value_parser = range::CONTACT_GAP.number())]
    contact_gap: f64,
    /// Parts of each number of bodies at most; those of the lowest energies are kept.
    #[arg(long, default_value_t = StabilitySettings::PARTS_OF_A_SIZE, value_parser = range::OBJECTS.at_least(1).number::<usize>())]
    most_parts: usize,
    /// A body belongs to a part within this of its place next to the body that it is attached to, Å (root mean
    /// square displacement).
    #[arg(long, default_value_t = GrowthSettings::default().limit_angstrom, value_parser = range::PART_LIMIT.number())]
    limit: f64,
    /// Live states of the sampling of a part; errors fall with their square root.
    #[arg(long, default_value_t = GrowthSettings::default().live_states, value_parser = range::OBJECTS.at_least(20).number::<usize>())]
    live_states: usize,
    /// Independent runs of each part, whose spread is the error.
    #[arg(long, default_value_t = GrowthSettings::default().runs, value_parser = range::OBJECTS.at_least(2).number::<u32>())]
    runs: u32,
    /// Way to the partition functions of the parts.
    #[arg(long, value_parser = choice::<Way>(), default_value = Way::MassAction.name())]
    way: Way,
    /// Windows between a part and a free body, for --way biased [default: 24].
    #[arg(long, value_parser = range::OBJECTS.at_least(4).number::<usize>())]
    windows: Option<usize>,
    /// Sweeps of each window, for --way biased [default: 4000].
    #[arg(long, value_parser = range::OBJECTS.at_least(100).number::<u64>())]
    sweeps: Option<u64>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    part: PartArgs,
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

impl StabilityArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let execution = self.execution.execution(front)?;
        if let Some(directory) = &self.output {
            ResultsDirectory::refuse_other_settings(directory, &LAYOUT, &settings, &execution)?;
        }
        let mut body = self.named_model().body_settings();
        body.selection = self.selection.settings();
        let choices = StructureChoices {
            body,
            joined: self.bodies.body.clone(),
        };
        let bodies = StabilityBodies::read(&self.inputs, &settings, &choices)?;
        for warning in &bodies.warnings {
            front.say(&format!("warning: {warning}"));
        }
        front.warn(self.named_model().body_warning(&bodies.first().bodies));
        match &self.output {
            Some(directory) => self.compute(front, &bodies, &settings, directory, &execution),
            None => {
                let folder = tempfile::tempdir().context("cannot make a temporary folder")?;
                let directory = folder.path().join("stability");
                self.compute(front, &bodies, &settings, &directory, &execution)
            }
        }
    }

    fn compute(
        &self,
        front: &Front,
        bodies: &StabilityBodies,
        settings: &StabilitySettings,
        directory: &Path,
        execution: &Execution,
    ) -> Result<Reply> {
        let tables = &self.tables;
        let prepare = |assembly: Assembly| tables.engine(assembly, front);
        if let Some(shard) = self.part.shard() {
            let end = run_stability_shard(bodies, settings, &prepare, directory, shard, execution)?;
            return Ok(Reply::of_part(end, shard, ["condition", "conditions"]));
        }
        Ok(
            match run_stability(bodies, settings, &prepare, directory, execution)? {
                End::Finished(result) => {
                    let warnings = result.warnings.clone();
                    let reply = Reply::from_answer(result).with_notes(warnings);
                    match &self.output {
                        Some(output) => {
                            let figure = output.join("stability.png");
                            reply.with_note(format!("figure: {}", figure.display()))
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
            },
        )
    }

    fn named_model(&self) -> Model {
        self.model.model().unwrap_or(Model::Natural1)
    }

    /// Windows, if the way has them.
    fn windows(&self) -> Result<Option<WindowSettings>> {
        let usual = WindowSettings::default();
        if self.way == Way::Biased {
            return Ok(Some(WindowSettings {
                windows: self.windows.unwrap_or(usual.windows),
                sweeps: self.sweeps.unwrap_or(usual.sweeps),
            }));
        }
        if self.windows.is_some() || self.sweeps.is_some() {
            bail!("--windows and --sweeps belong to simulations with a bias; add --way biased");
        }
        Ok(None)
    }

    fn settings(&self) -> Result<StabilitySettings> {
        let model = self.named_model();
        let contacts = self
            .attraction
            .over(model.contacts(), ContactCore::Surface)?;
        let settings = StabilitySettings {
            salt_molar: quantity::salt_list(&self.salt)?,
            ph: self.ph.clone(),
            concentration_molar: quantity::concentration_list(&self.concentration)?,
            protonation: self.protonation.titration_over(model.titration())?,
            contacts,
            contact_gap_angstrom: self.contact_gap,
            parts_of_a_size: self.most_parts,
            sampling: GrowthSettings {
                seed: self.seed,
                live_states: self.live_states,
                runs: self.runs,
                limit_angstrom: self.limit,
                windows: self.windows()?,
            },
            medium: InteractionSettings {
                temperature_kelvin: self.temperature,
                ..InteractionSettings::default()
            },
            ..StabilitySettings::of_model(model)
        };
        settings.check()?;
        Ok(settings)
    }
}
