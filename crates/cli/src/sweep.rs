//! `protomer sweep`: stability against salt.

use super::medium::MediumArgs;
use super::scheduler::SchedulerArgs;
use super::simulate::RunArgs;
use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::assemblies::assembly_file::Assembly;
use protomer::quantity;
use protomer::stability::run::{Engine, RunSettings};
use protomer::stability::sweep::{SweepResult, run_shard, run_sweep};
use protomer_results::{End, Shard};
use std::path::PathBuf;

/// Simulate an assembly at several salt concentrations, several replicas each: radius of gyration
/// and surviving contacts against salt. The same command continues a sweep that was stopped.
#[derive(Debug, Args)]
pub struct SweepArgs {
    /// Assembly file.
    assembly: PathBuf,
    /// Salt concentrations: a list such as 10mM,50mM,100mM or a range such as 10mM..300mM/8.
    #[arg(long, allow_hyphen_values = true)]
    salt: Option<String>,
    /// Independent replicas per salt concentration.
    #[arg(long)]
    replicas: Option<u32>,
    /// Only a part of the simulations, such as 2/8, beside other processes in the same directory;
    /// the command without it collects the parts.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    scheduler: SchedulerArgs,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    medium: MediumArgs,
}

impl SweepArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        self.scheduler.check()?;
        let settings = self.settings()?;
        let assembly = Assembly::read(&self.assembly)?;
        global.say(&format!(
            "{} bodies, {} simulations of {} + {} sweeps",
            assembly.len(),
            settings.simulations(),
            settings.equilibration_sweeps,
            settings.sweeps
        ));
        for salt in &settings.salt_molar {
            global.explain(&settings.medium.interaction(Some(*salt))?.describe());
        }
        let execution = self.run.execution.execution(global)?;
        let engine = Engine::new(assembly)?.with_tables(self.run.tables.tables(global));
        if !self.shard.is_whole() {
            let end = run_shard(&engine, &settings, &self.run.output, self.shard, &execution)?;
            drop(execution);
            return self.report_shard(end, global);
        }
        let end = run_sweep(&engine, &settings, &self.run.output, &execution)?;
        drop(execution);
        match end {
            End::Stopped => {
                global.say(&format!(
                    "stopped; the same command continues {}",
                    self.run.output.display()
                ));
                Ok(Outcome::Stopped)
            }
            End::Finished(result) => {
                self.report(&result, global)?;
                Ok(Outcome::Done)
            }
        }
    }

    fn report_shard(&self, end: End<usize>, global: &Global) -> Result<Outcome> {
        let Shard { index, of } = self.shard;
        let End::Finished(simulations) = end else {
            global.say(&format!(
                "stopped; the same command continues part {index} of {of}"
            ));
            return Ok(Outcome::Stopped);
        };
        if global.json {
            output::json(
                &serde_json::json!({ "shard": index, "of": of, "simulations": simulations }),
            )?;
        } else {
            global.say(&format!(
                "part {index} of {of}: {simulations} simulations done; without --shard: the table"
            ));
        }
        Ok(Outcome::Done)
    }

    /// The settings of the configuration file, if there is one, with those of the flags on top.
    fn settings(&self) -> Result<RunSettings> {
        let mut settings = self.run.settings(&self.medium)?;
        if let Some(salt) = &self.salt {
            settings.salt_molar = quantity::salt_list(salt)?;
        } else if self.run.config.is_none() {
            bail!("no salt concentration is given; add --salt 10mM,100mM,300mM");
        }
        if let Some(replicas) = self.replicas {
            settings.replicas = replicas;
        }
        settings.check()?;
        Ok(settings)
    }

    fn report(&self, result: &SweepResult, global: &Global) -> Result<()> {
        if global.json {
            return output::json(result);
        }
        if global.quiet {
            return Ok(());
        }
        let heading = [
            "salt (M)",
            "R_g (Å)",
            "± sd",
            "native contacts",
            "largest cluster",
            "energy (kT)",
        ];
        let mut rows = vec![heading.map(str::to_owned).to_vec()];
        for row in &result.salts {
            rows.push(vec![
                format!("{:.4}", row.salt_molar),
                format!("{:.2}", row.r_g_mean_angstrom),
                format!("{:.2}", row.r_g_sd_angstrom),
                format!("{:.3}", row.native_contacts_mean),
                format!("{:.2}", row.largest_cluster_mean),
                format!("{:.2}", row.energy_mean_kt),
            ]);
        }
        output::text(&output::table(&rows))?;
        global.say(&format!(
            "figure: {}",
            self.run.output.join("sweep.png").display()
        ));
        Ok(())
    }
}
