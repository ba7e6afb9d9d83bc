//! `protomer simulate`: one simulation in its directory, and the flags that `sweep` shares with it.

use crate::flags::execution::ExecutionArgs;
use crate::flags::medium::{ConditionArgs, MediumArgs};
use crate::flags::model::ModelArgs;
use crate::flags::settings::{Owner, SettingsArgs};
use crate::flags::solute::ChargesArgs;
use crate::flags::tables::TablesArgs;
use crate::flags::terms::TermsArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::live::{Arrays, Live};
use protomer_common::quantity;
use protomer_kernel::setting::Choices;
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::effective;
use protomer_protein_verbs::stability::live;
use protomer_protein_verbs::stability::run::{EnergyMode, Engine, RunSettings};
use protomer_protein_verbs::stability::sweep::{figure, refuse_other_settings, resolved, simulate};
use protomer_results::{End, keys};
use std::path::{Path, PathBuf};

/// Flags of every run. Omitted settings come from the configuration file, or else from the
/// defaults.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub struct RunArgs {
    /// Directory of the results.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Configuration (TOML), such as the run.toml of another run; flags override it.
    #[arg(long)]
    pub config: Option<PathBuf>,
    #[command(flatten)]
    flags: SettingsArgs<RunSettings>,
    #[command(flatten)]
    pub model: ModelArgs,
    #[command(flatten)]
    pub charges: ChargesArgs,
    #[command(flatten)]
    pub terms: TermsArgs,
    #[command(flatten)]
    pub execution: ExecutionArgs,
    #[command(flatten)]
    pub tables: TablesArgs,
}

impl RunArgs {
    /// The settings of the configuration file, overridden by the flags.
    pub fn settings(&self, medium: &MediumArgs) -> Result<RunSettings> {
        let mut settings = match &self.config {
            None => RunSettings::default(),
            Some(path) => keys::read_toml(path)?,
        };
        let energy = settings.energy;
        self.flags.override_in(&mut settings)?;
        if settings.energy != energy && !self.flags.has("tolerance_kt") {
            // The tolerance of a configuration applies only to its own energy mode.
            settings.tolerance_kt = None;
        }
        // Stored even if it is the default, so that a run keeps it if the default changes.
        settings.tolerance_kt = settings.tolerance_of_energy_kt()?;
        self.model
            .override_in(&mut settings, &self.charges, &self.terms)?;
        medium.override_in(&mut settings.medium);
        Ok(settings)
    }
}

/// Says, before anything takes long, what the run cannot answer, and that effective charges come
/// first.
pub fn say_limits(front: &Front, engine: &Engine, settings: &RunSettings) -> Result<()> {
    front.warn(engine.open_space_warning());
    if settings.effective_charges.is_some() {
        front.warn(effective::near_contact_warning(&engine.system()?, settings));
        front.say(
            "effective charges are fitted for each kind of body and salt concentration, unless they \
             are in the cache",
        );
    }
    Ok(())
}

/// The warnings of a result that [`say_limits`] has not said before the run.
pub fn late_warnings(
    engine: &Engine,
    settings: &RunSettings,
    warnings: &[String],
) -> Result<Vec<String>> {
    let said = effective::near_contact_warning(&engine.system()?, settings);
    let is_new = |warning: &&String| said.as_ref() != Some(*warning);
    Ok(warnings.iter().filter(is_new).cloned().collect())
}

/// Says how energies are computed and, where tables are made first, how long that takes.
pub fn say_energies(front: &Front, engine: &Engine, settings: &RunSettings) -> Result<()> {
    let energy = settings.energy.unwrap_or(EnergyMode::Direct);
    let name = energy.name();
    if !matches!(energy, EnergyMode::Calibrated | EnergyMode::Approximate) {
        front.explain(&format!("energies: {name}"));
        return Ok(());
    }
    let costs = engine.costs_of(settings)?;
    front.say(&format!(
        "energies: {name}; unless they are in the cache, tables take about {:.0} s of processor time \
         for each salt concentration",
        costs.tables_seconds.max(1.0)
    ));
    Ok(())
}

/// The figure that a sweep or a simulation leaves.
pub fn figure_of(directory: &Path, settings: &RunSettings) -> PathBuf {
    directory.join(figure::name(settings)).with_extension("png")
}

/// Run one simulation of an assembly at one salt concentration. The same command continues it.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "simulate ring.json --salt 100mM -o run",
    "simulate ring.json --salt 0.1M --sweeps 5000 --interaction effective -o run"
))]
#[group(id = "SimulationResult")]
pub struct SimulateArgs {
    /// Assembly file.
    assembly: PathBuf,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    flags: SettingsArgs<RunSettings, Simulate>,
    #[command(flatten)]
    run: RunArgs,
}

/// Owner of the flags that `sweep` has not.
#[derive(Debug)]
struct Simulate;

impl Owner for Simulate {
    const VERB: Option<&'static str> = Some("simulate");
}

impl SimulateArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let execution = self.run.execution.execution(front)?;
        let directory = &self.run.output;
        refuse_other_settings(&settings, directory, &execution)?;
        let assembly = Assembly::read(&self.assembly)?;
        front.warn(self.run.model.body_warning(&assembly));
        let engine = self.run.tables.engine(assembly, front)?;
        say_limits(front, &engine, &settings)?;
        let settings = resolved(&engine, &settings, directory, &execution)?;
        say_energies(front, &engine, &settings)?;
        let end = simulate(&engine, &settings, directory, &execution)?;
        let mut notes = Vec::new();
        if let End::Finished(result) = &end {
            notes = late_warnings(&engine, &settings, &result.warnings)?;
            let figure = figure_of(directory, &settings);
            notes.push(format!("figure: {}", figure.display()));
        }
        let reply = Reply::of_end(end, || {
            format!(
                "stopped; the same command continues {}",
                directory.display()
            )
        });
        Ok(reply.with_notes(notes))
    }

    /// The simulation in memory; the directory of the results is not touched.
    pub fn live(&self, front: &Front, arrays: Option<Arrays>) -> Result<Box<dyn Live>> {
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let assembly = Assembly::read(&self.assembly)?;
        front.warn(self.run.model.body_warning(&assembly));
        let engine = self.run.tables.engine(assembly, front)?;
        say_limits(front, &engine, &settings)?;
        live::assembly(engine, &settings, arrays)
    }

    fn settings(&self) -> Result<RunSettings> {
        let mut settings = self.run.settings(&self.conditions.medium)?;
        settings.replicas = 1;
        self.flags.override_in(&mut settings)?;
        match self.conditions.salt {
            Some(salt) => settings.salt_molar = vec![salt],
            None if self.run.config.is_none()
                && settings.medium.debye_length_angstrom.is_none() =>
            {
                if settings.energy != Some(EnergyMode::None) {
                    bail!("no salt concentration is given; add --salt 100mM")
                }
                // Hard bodies do not feel the salt.
                settings.salt_molar = vec![0.0];
            }
            None => {}
        }
        if settings.salt_molar.len() != 1 {
            bail!(
                "simulate takes one salt concentration, but {} are given; use sweep",
                settings.salt_molar.len()
            );
        }
        settings.check()?;
        Ok(settings)
    }
}
