//! `protomer voxelize`: structures to a set of voxel grids.

use crate::flags::body::ProtonationArgs;
use crate::flags::scheduler::SchedulerArgs;
use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::{Outcome, Reply};
use anyhow::{Error, Result, anyhow, bail};
use clap::Args;
use protomer_body::surface::ExactSurface;
use protomer_body::{Draft, SurfaceSettings};
use protomer_common::{quantity, range};
use protomer_field::PotentialModel;
use protomer_field::voxels::{Channel, Orientation};
use protomer_learn_verbs::voxels::body_store::BodyStore;
use protomer_learn_verbs::voxels::manifest::Manifest;
use protomer_learn_verbs::voxels::survey::survey;
use protomer_learn_verbs::voxels::{Spacing, State, VoxelizeReport, VoxelizeSettings, voxelize};
use protomer_protein_verbs::bodies::folder::{BodyFolder, has_tables};
use protomer_results::{FileRecord, Shard};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Turn the structures of a manifest into a set of sparse voxel grids, a zarr v3 group: surface,
/// potential, hydropathy.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "voxelize --manifest set.csv -o set.zarr --seed 1",
    "voxelize --manifest set.csv --shard 1/4 -o part1.zarr"
))]
#[group(id = "VoxelizeResult")]
pub struct VoxelizeArgs {
    /// CSV with the columns file, label, cluster and optionally family, name; paths are
    /// relative to its folder.
    #[arg(long)]
    manifest: PathBuf,
    /// The set to write, such as SET.zarr.
    #[arg(short, long)]
    output: PathBuf,
    /// Voxels along each edge of a grid.
    #[arg(long, default_value_t = 64)]
    size: usize,
    /// Edge of a voxel, Å; `fit` scales each structure to fill the grid.
    #[arg(long, default_value = "1.0", value_parser = Spacing::parse, allow_hyphen_values = true)]
    spacing: Spacing,
    /// Channels of the voxels [default: shape,potential,hydropathy; of interfaces also those of the
    /// partner].
    #[arg(long, value_parser = choice::<Channel>(), value_delimiter = ',')]
    channels: Option<Vec<Channel>>,
    /// For interfaces: the voxels of one body that have an atom of the other this near are kept, Å
    /// [default: 8].
    #[arg(long)]
    interface_reach: Option<f64>,
    /// The orientation of structures.
    #[arg(long, value_parser = choice::<Orientation>(), default_value = "random")]
    orientation: Orientation,
    /// Seed of the random orientations.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Model of the potential; the equation is solved on a grid of 1 Å.
    #[arg(long, value_parser = choice::<PotentialModel>(), default_value = "poisson-boltzmann")]
    potential: PotentialModel,
    /// Concentration of a 1:1 salt, such as 100mM or 0.1M.
    #[arg(long, value_parser = quantity::salt_molar, default_value = "150mM", allow_hyphen_values = true)]
    salt: f64,
    /// Temperature, K.
    #[arg(long, default_value = "298.15", allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    temperature: f64,
    /// pH of the protonation.
    #[arg(long, default_value_t = 7.4)]
    ph: f64,
    #[command(flatten)]
    protonation: ProtonationArgs,
    /// Probe radius of the surface, Å.
    #[arg(long, default_value_t = 1.4, value_parser = range::RADIUS.number())]
    probe: f64,
    /// Range of the hydropathy: residues with an atom within this distance of a voxel's centre
    /// count, Å.
    #[arg(long, default_value_t = 5.0)]
    hydropathy_reach: f64,
    /// Structures are excluded if a larger share of their residues lacks heavy atoms.
    #[arg(long, default_value_t = 0.25)]
    most_incomplete: f64,
    /// Make the bodies in this folder as well, as `protomer ingest --stream` does; each structure
    /// is read, charged and given its exact surface only once.
    #[arg(long, value_name = "FOLDER", help_heading = "Bodies")]
    bodies: Option<PathBuf>,
    /// With --bodies: mesh vertices per Å².
    #[arg(
        long,
        default_value_t = 1.0,
        requires = "bodies",
        help_heading = "Bodies", value_parser = range::MESH_DENSITY.number())]
    density: f64,
    /// Exit with 1 if structures are left out; the set is written all the same.
    #[arg(long)]
    strict: bool,
    /// Process only a part of the manifest, such as 2/8; `protomer merge` joins the parts.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    scheduler: SchedulerArgs,
    /// Stop after this many minutes; the same command continues it.
    #[arg(long, value_parser = range::MINUTES.number())]
    time_limit: Option<f64>,
}

/// Maximum number of warnings on the terminal; the set contains all.
const SHOWN_WARNINGS: usize = 10;

impl VoxelizeArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.scheduler.check()?;
        front.warn(quantity::salt_warning([self.salt]));
        let manifest = Manifest::read(&self.manifest)?;
        let settings = self.settings(manifest.has_partners())?;
        settings.check()?;
        let notice = "finishing the current structures; the same command continues";
        let execution = front.execution(notice, self.time_limit)?;
        let bodies = self.bodies(&manifest, front)?;
        if !self.output.exists() {
            front.warn(survey(&manifest, self.shard, &settings).note());
        }
        let store = bodies.as_ref().map(|bodies| bodies as &dyn BodyStore);
        let report = voxelize(
            &manifest,
            self.shard,
            &settings,
            store,
            &self.output,
            &execution,
        )?;
        let mut notes = notes(&report);
        notes.extend(bodies.as_ref().and_then(Bodies::note));
        if report.state == State::Stopped {
            return Ok(Reply::from_answer(report)
                .with_notes(notes)
                .ending(Outcome::Stopped));
        }
        let complaint = complaint(&report);
        let is_incomplete = self.strict && !report.excluded.is_empty();
        let reply = Reply::from_answer(report)
            .with_notes(notes)
            .partial_if(is_incomplete);
        // A set without samples is useless; a part without samples may be fine, and
        // `protomer merge` checks again.
        Ok(match complaint {
            Some(error) if self.shard.is_whole() => {
                reply.failing(Some(anyhow!("{error}; correct the manifest or the files")))
            }
            Some(error) => reply.with_note(format!("warning: {error}")),
            None => reply,
        })
    }

    fn channels(&self, has_partners: bool) -> Vec<Channel> {
        match &self.channels {
            Some(chosen) => chosen.clone(),
            None => {
                let mut usual = VoxelizeSettings::default().channels;
                usual.extend(Channel::PARTNER.into_iter().filter(|_| has_partners));
                usual
            }
        }
    }

    /// The folder of the bodies, if they are wanted.
    fn bodies(&self, manifest: &Manifest, front: &Front) -> Result<Option<Bodies>> {
        let Some(folder) = &self.bodies else {
            return Ok(None);
        };
        let surface = SurfaceSettings {
            probe_radius_angstrom: self.probe,
            density_per_angstrom2: self.density,
            ..SurfaceSettings::default()
        };
        surface.check()?;
        if self.output.exists() && !front.force() && !has_tables(folder, self.shard) {
            bail!(
                "{} exists already, and bodies are made in the same pass; make them with 'protomer \
                 ingest', or both anew with --force",
                self.output.display()
            );
        }
        let mut names = Vec::new();
        for number in 0..manifest.len() {
            if self.shard.has(number) {
                names.push(manifest.entry(number)?.name);
            }
        }
        Ok(Some(Bodies {
            folder: BodyFolder::open(folder, &names, self.shard, front.force())?,
            density_per_angstrom2: self.density,
            counts: Mutex::new([0; 2]),
        }))
    }

    fn settings(&self, has_partners: bool) -> Result<VoxelizeSettings> {
        if self.interface_reach.is_some() && !has_partners {
            bail!(
                "--interface-reach is for interfaces; give a manifest with a column 'partner', or omit it"
            );
        }
        if self.bodies.is_some() && has_partners {
            bail!(
                "--bodies makes the bodies of structures alone; make those of interfaces with 'protomer ingest'"
            );
        }
        let reach = self.interface_reach;
        let reach = reach.unwrap_or(VoxelizeSettings::INTERFACE_REACH_ANGSTROM);
        Ok(VoxelizeSettings {
            size: self.size,
            spacing: self.spacing,
            channels: self.channels(has_partners),
            interface_reach_angstrom: has_partners.then_some(reach),
            orientation: self.orientation,
            seed: self.seed,
            potential: self.potential,
            salt_molar: self.salt,
            temperature_kelvin: self.temperature,
            ph: self.ph,
            titration: self.protonation.titration()?,
            probe_angstrom: self.probe,
            hydropathy_reach_angstrom: self.hydropathy_reach,
            most_incomplete: self.most_incomplete,
        })
    }
}

/// The folder of bodies that a set is made with.
struct Bodies {
    folder: BodyFolder,
    density_per_angstrom2: f64,
    /// Files without a body, and all files; known when all are done.
    counts: Mutex<[usize; 2]>,
}

impl Bodies {
    fn counts(&self) -> MutexGuard<'_, [usize; 2]> {
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The warning about files without a body.
    fn note(&self) -> Option<String> {
        let [failed, files] = *self.counts();
        let table = self.folder.warnings_table().display();
        (failed > 0).then(|| {
            format!(
                "warning: no body was written for {failed} of {files} structures; {table} says why"
            )
        })
    }
}

impl BodyStore for Bodies {
    fn density_per_angstrom2(&self) -> f64 {
        self.density_per_angstrom2
    }

    fn keep(&self, file: &Path, draft: Draft, surface: ExactSurface) -> Result<FileRecord> {
        self.folder.keep(file, draft, surface)
    }

    fn failed(&self, file: &Path, error: &Error) -> FileRecord {
        self.folder.failed(file, error)
    }

    fn finish(&self, records: &mut dyn Iterator<Item = Result<FileRecord>>) -> Result<()> {
        *self.counts() = self.folder.write_tables(records)?;
        Ok(())
    }
}

/// The error of a set without samples.
fn complaint(report: &VoxelizeReport) -> Option<Error> {
    let is_empty = report.samples == 0 && report.structures > 0;
    is_empty.then(|| {
        anyhow!(
            "none of the {} structures could be used; the attribute 'excluded' of {} gives the reasons",
            report.structures,
            report.set.display()
        )
    })
}

/// Notes on structures that were left out, and warnings.
fn notes(report: &VoxelizeReport) -> Vec<String> {
    let mut lines = Vec::new();
    if report.state == State::Written {
        let excluded = report.excluded.iter();
        lines.extend(excluded.map(|one| format!("left out: {}: {}", one.row.name, one.detail)));
        lines.extend(warnings(report));
    }
    let relatives = report.manifest_warnings.iter();
    lines.extend(relatives.map(|line| format!("warning: {line}")));
    lines
}

/// The first warnings, and the total number.
fn warnings(report: &VoxelizeReport) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, warnings) in &report.warnings {
        let warnings = warnings.iter();
        lines.extend(warnings.map(|warning| format!("warning: {name}: {warning}")));
    }
    let count = lines.len();
    if count > SHOWN_WARNINGS {
        lines.truncate(SHOWN_WARNINGS);
        lines.push(format!(
            "{count} warnings for {} structures in total; all are in the set's attribute 'warnings'",
            report.warnings.len()
        ));
    }
    lines
}
