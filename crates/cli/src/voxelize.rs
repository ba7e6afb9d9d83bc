//! `protomer voxelize`: structures to a set of voxel grids.

use super::potential_name::PotentialName;
use super::scheduler::SchedulerArgs;
use super::{Global, Outcome, interrupt_saying, output};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::quantity;
use protomer::voxels::manifest::Manifest;
use protomer::voxels::{Spacing, State, VoxelizeReport, VoxelizeSettings, voxelize};
use protomer_field::voxels::{Channel, Orientation};
use protomer_results::{Execution, Shard};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Turn the structures of a manifest into a set of sparse voxel grids, a zarr v3 group: surface,
/// potential, hydropathy.
#[derive(Debug, Args)]
pub struct VoxelizeArgs {
    /// CSV with the columns file, label, cluster and perhaps family, name; paths start from its
    /// folder.
    #[arg(long)]
    manifest: PathBuf,
    /// The set to write, such as SET.zarr.
    #[arg(short, long)]
    output: PathBuf,
    /// Voxels along each edge of a grid.
    #[arg(long, default_value_t = 64)]
    size: usize,
    /// Edge of a voxel, Å; `fit`: each structure scaled to fill the grid.
    #[arg(long, default_value = "1.0", value_parser = Spacing::parse, allow_hyphen_values = true)]
    spacing: Spacing,
    /// What the voxels carry.
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "shape,potential,hydropathy"
    )]
    channels: Vec<ChannelName>,
    /// How structures are turned.
    #[arg(long, value_enum, default_value_t = OrientationName::Random)]
    orientation: OrientationName,
    /// Seed of the random orientations.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How the potential is found; the equation is solved at 1 Å.
    #[arg(long, value_enum, default_value_t = PotentialName::PoissonBoltzmann)]
    potential: PotentialName,
    /// Concentration of a 1:1 salt, such as 100mM or 0.1M.
    #[arg(long, value_parser = quantity::salt_molar, default_value = "150mM", allow_hyphen_values = true)]
    salt: f64,
    /// Temperature, K.
    #[arg(long, default_value_t = 298.15, allow_negative_numbers = true)]
    temperature: f64,
    /// pH of the protonation.
    #[arg(long, default_value_t = 7.4, allow_negative_numbers = true)]
    ph: f64,
    /// Probe radius of the surface, Å.
    #[arg(long, default_value_t = 1.4, allow_negative_numbers = true)]
    probe: f64,
    /// Residues with an atom this near to a voxel's centre count for its hydropathy, Å.
    #[arg(long, default_value_t = 5.0, allow_negative_numbers = true)]
    hydropathy_reach: f64,
    /// Structures of which a larger part of the residues lacks heavy atoms are left out.
    #[arg(long, default_value_t = 0.25, allow_negative_numbers = true)]
    most_incomplete: f64,
    /// Only a part of the manifest, such as 2/8; `protomer merge` joins the parts.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    scheduler: SchedulerArgs,
    /// Stop after this many minutes; the same command goes on from there.
    #[arg(long, allow_negative_numbers = true)]
    time_limit: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ChannelName {
    /// 1 where the solvent-excluded surface passes through.
    Shape,
    /// 1 inside the surface.
    Solid,
    /// Electrostatic potential on the surface, kT/e.
    Potential,
    /// Kyte-Doolittle index of the residues near by.
    Hydropathy,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum OrientationName {
    /// By a random rotation, from the seed and the structure's name.
    Random,
    /// With the principal axes along x, y, z.
    Principal,
    /// Not at all.
    Deposited,
}

impl VoxelizeArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        self.scheduler.check()?;
        let settings = self.settings();
        settings.check()?;
        let manifest = Manifest::read(&self.manifest)?;
        let interrupt = interrupt_saying(
            global,
            "finishing the structures at hand; the same command goes on",
            self.time_limit,
        )?;
        let execution = Execution {
            interrupt,
            start_anew: global.force,
            progress: global.progress(),
            ..Execution::default()
        };
        let report = voxelize(&manifest, self.shard, &settings, &self.output, &execution)?;
        drop(execution);
        for excluded in report
            .excluded
            .iter()
            .filter(|_| report.state == State::Written)
        {
            global.say(&format!("left out: {}: {}", excluded.name, excluded.detail));
        }
        if report.state == State::Written {
            tell_warnings(global, &report.warnings);
        }
        for line in &report.manifest_warnings {
            global.say(&format!("warning: {line}"));
        }
        if global.json {
            output::json(&report)?;
        } else if !global.quiet {
            output::text(&describe(&report))?;
        }
        if report.state == State::Stopped {
            return Ok(Outcome::Stopped);
        }
        self.check_samples(global, &report)?;
        Ok(Outcome::Done)
    }

    /// A set without samples is of no use to anyone; a part without samples may be, and `protomer
    /// merge` looks again.
    fn check_samples(&self, global: &Global, report: &VoxelizeReport) -> Result<()> {
        if report.samples > 0 || report.structures == 0 {
            return Ok(());
        }
        let (count, set) = (report.structures, report.set.display());
        let message = format!(
            "none of the {count} structures could be used; the attribute 'excluded' of {set} says why of each"
        );
        if !self.shard.is_whole() {
            global.say(&format!("warning: {message}"));
            return Ok(());
        }
        bail!("{message}; correct the manifest or the files")
    }

    fn settings(&self) -> VoxelizeSettings {
        let channel = |name: &ChannelName| match name {
            ChannelName::Shape => Channel::Shape,
            ChannelName::Solid => Channel::Solid,
            ChannelName::Potential => Channel::Potential,
            ChannelName::Hydropathy => Channel::Hydropathy,
        };
        VoxelizeSettings {
            size: self.size,
            spacing: self.spacing,
            channels: self.channels.iter().map(channel).collect(),
            orientation: match self.orientation {
                OrientationName::Random => Orientation::Random,
                OrientationName::Principal => Orientation::Principal,
                OrientationName::Deposited => Orientation::Deposited,
            },
            seed: self.seed,
            potential: self.potential.model(),
            salt_molar: self.salt,
            temperature_kelvin: self.temperature,
            ph: self.ph,
            probe_angstrom: self.probe,
            hydropathy_reach_angstrom: self.hydropathy_reach,
            most_incomplete: self.most_incomplete,
        }
    }
}

/// Lines of warnings on the terminal; all are in the set.
const SHOWN_WARNINGS: usize = 10;

fn tell_warnings(global: &Global, warnings: &BTreeMap<String, Vec<String>>) {
    let lines = || {
        warnings
            .iter()
            .flat_map(|(name, of)| of.iter().map(move |warning| (name, warning)))
    };
    for (name, warning) in lines().take(SHOWN_WARNINGS) {
        global.say(&format!("warning: {name}: {warning}"));
    }
    let count = lines().count();
    if count > SHOWN_WARNINGS {
        let structures = warnings.len();
        global.say(&format!(
            "{count} warnings of {structures} structures in all; the set's attribute 'warnings' has them"
        ));
    }
}

fn describe(report: &VoxelizeReport) -> String {
    let set = report.set.display();
    match report.state {
        State::NothingToDo => format!(
            "{set} is complete: {} samples, nothing to do",
            report.samples
        ),
        State::Stopped => format!(
            "stopped: {} of {} structures done",
            report.samples, report.structures
        ),
        State::Written => {
            let per_sample = |total: u64| total as f64 / report.samples.max(1) as f64;
            format!(
                "{set}: {} samples, {} left out\n{:.0} voxels and {:.1} kB per sample, {:.1} s",
                report.samples,
                report.excluded.len(),
                per_sample(report.voxels),
                per_sample(report.bytes) / 1000.0,
                report.seconds
            )
        }
    }
}
