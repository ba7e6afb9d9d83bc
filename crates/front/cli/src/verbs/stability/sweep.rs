//! `protomer sweep`: stability against salt.

use super::simulate::{RunArgs, figure_of, late_warnings, say_energies, say_limits};
use crate::flags::medium::MediumArgs;
use crate::flags::scheduler::PartArgs;
use crate::flags::settings::{Owner, SettingsArgs};
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::quantity;
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::run::RunSettings;
use protomer_protein_verbs::stability::sweep::{
    refuse_other_settings, resolved, run_shard, run_sweep,
};
use protomer_results::End;
use std::path::PathBuf;

/// Simulate an assembly at several salt concentrations, several replicas each: radius of gyration
/// and surviving contacts against salt. The same command continues a sweep that was stopped.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "sweep ring.json --salt 10mM..300mM/8 --replicas 4 -o stability",
    "sweep ring.json --salt 10mM,50mM,250mM --starts both --exchange-every 20 -o equilibrium"
))]
#[group(id = "SweepResult")]
pub struct SweepArgs {
    /// Assembly file.
    assembly: PathBuf,
    /// Salt concentrations: a list such as 10mM,50mM,100mM or a range such as 10mM..300mM/8.
    #[arg(long, allow_hyphen_values = true)]
    salt: Option<String>,
    #[command(flatten)]
    flags: SettingsArgs<RunSettings, Sweep>,
    #[command(flatten)]
    part: PartArgs,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    medium: MediumArgs,
}

/// Owner of the flags that `simulate` has not.
#[derive(Debug)]
struct Sweep;

impl Owner for Sweep {
    const VERB: Option<&'static str> = Some("sweep");
}

impl SweepArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let settings = self.settings()?;
        front.warn(quantity::salt_warning(settings.salt_molar.iter().copied()));
        let execution = self.run.execution.execution(front)?;
        let directory = &self.run.output;
        refuse_other_settings(&settings, directory, &execution)?;
        let assembly = Assembly::read(&self.assembly)?;
        front.say(&format!(
            "{} bodies, {} simulations of {} + {} sweeps",
            assembly.len(),
            settings.simulations(),
            settings.equilibration_sweeps,
            settings.sweeps
        ));
        for salt in &settings.salt_molar {
            front.explain(&settings.medium.interaction(Some(*salt))?.describe());
        }
        front.warn(self.run.model.body_warning(&assembly));
        let engine = self.run.tables.engine(assembly, front)?;
        say_limits(front, &engine, &settings)?;
        let settings = resolved(&engine, &settings, directory, &execution)?;
        say_energies(front, &engine, &settings)?;
        if let Some(shard) = self.part.shard() {
            let end = run_shard(&engine, &settings, directory, shard, &execution)?;
            return Ok(Reply::of_part(end, shard, ["simulation", "simulations"]));
        }
        Ok(
            match run_sweep(&engine, &settings, directory, &execution)? {
                End::Finished(result) => {
                    let figure = figure_of(directory, &settings);
                    let warnings = late_warnings(&engine, &settings, &result.warnings)?;
                    let reply = Reply::from_answer(result).with_notes(warnings);
                    reply.with_note(format!("figure: {}", figure.display()))
                }
                End::Stopped => {
                    let directory = directory.display();
                    Reply::stopped(format!("stopped; the same command continues {directory}"))
                }
            },
        )
    }

    /// The settings of the configuration file, if any, overridden by the flags.
    fn settings(&self) -> Result<RunSettings> {
        let mut settings = self.run.settings(&self.medium)?;
        if let Some(salt) = &self.salt {
            settings.salt_molar = quantity::salt_list(salt)?;
        } else if self.run.config.is_none() {
            bail!("no salt concentration is given; add --salt 10mM,100mM,300mM");
        }
        self.flags.override_in(&mut settings)?;
        settings.check()?;
        Ok(settings)
    }
}
