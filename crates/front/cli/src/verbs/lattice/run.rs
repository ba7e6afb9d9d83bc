//! `protomer lattice run`: one run in its directory, and the flags that `sweep` shares with it.

use crate::flags::execution::ExecutionArgs;
use crate::flags::settings::SettingsArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::{ArgGroup, Args};
use protomer_linkage_verbs::lattice::directory::read_settings;
use protomer_linkage_verbs::lattice::potential_table::PotentialTable;
use protomer_linkage_verbs::lattice::run::run_lattice;
use protomer_linkage_verbs::lattice::settings::LatticeSettings;
use protomer_linkage_verbs::lattice::start::{begin_unless, charge_warning, is_stopped, time_step};
use protomer_results::{End, Execution};
use std::path::PathBuf;

/// Settings. Omitted settings come from the configuration file, or else from the defaults.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Lattice", group(ArgGroup::new("end").args(["time", "steps"])))]
pub struct LatticeFlags {
    /// Squares along an edge: rows and columns at once.
    #[arg(long, conflicts_with_all = ["rows", "columns"])]
    ns: Option<usize>,
    /// Potential of the opening of every joint: a table with the columns angle_rad or angle_deg (0 and 180°:
    /// closed, 90°: open), and energy (reduced units) or energy_kt.
    #[arg(long, value_name = "CSV")]
    angle_potential: Option<PathBuf>,
    /// Potential per square of the opening of the whole crystal: a table as for --angle-potential (0 and 90°:
    /// closed, 45°: open).
    #[arg(long, value_name = "CSV")]
    opening_potential: Option<PathBuf>,
    #[command(flatten)]
    flags: SettingsArgs<LatticeSettings>,
}

/// Output directory and execution.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub struct DirectoryArgs {
    /// Configuration (TOML), such as the run.toml of another run; flags override it.
    config: Option<PathBuf>,
    /// Directory of the results.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl LatticeFlags {
    /// The settings of the configuration file, overridden by the flags.
    pub fn settings(&self, directory: &DirectoryArgs) -> Result<LatticeSettings> {
        let mut settings = match &directory.config {
            None => LatticeSettings::default(),
            Some(path) => read_settings(path)?,
        };
        self.flags.override_in(&mut settings)?;
        if let Some(squares) = self.ns {
            (settings.rows, settings.columns) = (squares, squares);
        }
        if self.flags.has("time") {
            settings.steps = None;
        }
        for (path, table) in [
            (&self.angle_potential, &mut settings.angle_potential),
            (&self.opening_potential, &mut settings.opening_potential),
        ] {
            if let Some(path) = path {
                *table = Some(PotentialTable::read(path)?);
            }
        }
        settings.check()?;
        Ok(settings)
    }
}

impl DirectoryArgs {
    /// The execution of the run.
    pub fn execution(&self, front: &Front) -> Result<Execution> {
        self.execution.execution(front)
    }
}

/// Run one lattice. The same command continues it.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "lattice run --ns 10 --r0 0.05 --time 3 -o coherent",
    "lattice run square.toml --time 10 -o rhua"
))]
#[group(id = "LatticeResult")]
pub struct RunArgs {
    #[command(flatten)]
    directory: DirectoryArgs,
    #[command(flatten)]
    settings: LatticeFlags,
}

impl RunArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = self.settings.settings(&self.directory)?;
        let execution = self.directory.execution(front)?;
        let directory = &self.directory.output;
        let stopped = || {
            format!(
                "stopped; the same command continues {}",
                directory.display()
            )
        };
        let interrupt = &execution.interrupt;
        let begun = match begin_unless(&settings, &|| interrupt.is_requested()) {
            Err(error) if is_stopped(&error) => return Ok(Reply::stopped(stopped())),
            begun => begun?,
        };
        let step = time_step(&settings, &begun)?;
        let charges = charge_warning(&settings, &begun)?;
        front.say(&format!(
            "{} squares, {} rods, {} steps of {step}",
            begun.network.squares.len(),
            begun.network.rods.len(),
            settings.total_steps(step)
        ));
        let end = run_lattice(&settings, directory, &execution)?;
        let mut warnings: Vec<String> = charges.into_iter().collect();
        if let End::Finished(result) = &end {
            warnings.extend(result.energy_warning(&settings));
            warnings.extend(result.table_warning());
        }
        let notes = warnings
            .into_iter()
            .map(|warning| format!("warning: {warning}"));
        Ok(Reply::of_end(end, stopped).with_notes(notes))
    }
}
