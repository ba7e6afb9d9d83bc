//! The frames of an assembly file, a simulation or a sweep.

use super::ScatteringSettings;
use crate::assemblies::assembly_file::Assembly;
use crate::export::assembly_of;
use crate::stability::run::{RunSettings, chosen_salt, listed_salts, replica_directory};
use anyhow::{Context, Result, bail};
use protomer_io::gsd::TrajectoryReader;
use protomer_kernel::{Boundary, Pose};
use protomer_mc::{BodyType, System};
use protomer_results::{Record, ResultKind, keys};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The poses of one simulation.
pub(crate) struct Series {
    pub(crate) salt_molar: Option<f64>,
    pub(crate) frames: Vec<Vec<Pose>>,
    /// Number of the first frame among those of all series.
    pub(super) first_number: u64,
}

/// Bodies and the states that they were in.
pub(crate) struct Source {
    pub(crate) assembly: Assembly,
    /// Boundary of the space; a wall counts as open space.
    pub(super) boundary: Boundary,
    pub(super) contact_gap_angstrom: f64,
    pub(crate) series: Vec<Series>,
    pub(super) is_run: bool,
}

impl Source {
    pub(crate) fn read(settings: &ScatteringSettings) -> Result<Self> {
        let input = settings.input.as_path();
        if !input.is_dir() {
            return Self::of_assembly(settings);
        }
        let (sweep, only) = match ResultKind::detect(input) {
            Some(ResultKind::Sweep) => (input.to_owned(), None),
            Some(ResultKind::Simulation) => {
                let path = input
                    .canonicalize()
                    .with_context(|| format!("cannot read {}", input.display()))?;
                // DIRECTORY/salt_.../replica_N: two folders up is the sweep.
                let sweep = path.ancestors().nth(2).unwrap_or(&path);
                (sweep.to_owned(), Some(path.clone()))
            }
            Some(other) => bail!(
                "{} holds {other}, which has no trajectory of bodies; name the directory of a \
                 simulation or a sweep",
                input.display()
            ),
            None => bail!(
                "{} holds no results; name an assembly file, or the directory of a simulation or a \
                 sweep",
                input.display()
            ),
        };
        Self::of_run(settings, &sweep, only.as_deref())
    }

    fn of_assembly(settings: &ScatteringSettings) -> Result<Self> {
        for (name, is_given) in [
            ("--salt", settings.salt_molar.is_some()),
            ("--assembly", settings.assembly.is_some()),
        ] {
            if is_given {
                bail!(
                    "{name} applies to directories of runs, but {} is a file; leave it out",
                    settings.input.display()
                );
            }
        }
        let assembly = Assembly::read(&settings.input)?;
        let frames = vec![assembly.poses.clone()];
        Ok(Self {
            boundary: space_of(&assembly),
            assembly,
            contact_gap_angstrom: RunSettings::default().contact_gap_angstrom,
            series: vec![Series {
                salt_molar: None,
                frames,
                first_number: 0,
            }],
            is_run: false,
        })
    }

    fn of_run(settings: &ScatteringSettings, sweep: &Path, only: Option<&Path>) -> Result<Self> {
        let run: RunSettings = keys::read_toml(&sweep.join("run.toml"))?;
        let record = Record::read(sweep)?;
        let assembly = assembly_of(sweep, record.as_ref(), settings.assembly.as_deref()).context(
            "the assembly of this run cannot be used; name the right one with --assembly FILE",
        )?;
        let mut series = Vec::new();
        let mut first_number = 0;
        for (salt, path) in simulations(&run, sweep, only, settings.salt_molar)? {
            let frames = frames(&path, &assembly, settings)?;
            let count = frames.len() as u64;
            series.push(Series {
                salt_molar: Some(salt),
                frames,
                first_number,
            });
            first_number += count;
        }
        Ok(Self {
            boundary: space_of(&assembly),
            assembly,
            contact_gap_angstrom: run.contact_gap_angstrom,
            series,
            is_run: true,
        })
    }

    /// The bodies at these poses.
    pub(super) fn system(&self, kinds: &[Arc<BodyType>], poses: &[Pose]) -> Result<System> {
        let bodies: Vec<(usize, Pose)> = self
            .assembly
            .kinds
            .iter()
            .copied()
            .zip(poses.iter().copied())
            .collect();
        Ok(System::new(kinds.to_vec(), &bodies, self.boundary)?)
    }
}

fn space_of(assembly: &Assembly) -> Boundary {
    // A wall holds the bodies together; what scatters is a cluster in open space.
    match assembly.boundary {
        Boundary::SphereWall { .. } => Boundary::Open,
        boundary => boundary,
    }
}

/// Salt concentration and trajectory of each simulation.
fn simulations(
    run: &RunSettings,
    sweep: &Path,
    only: Option<&Path>,
    asked: Option<f64>,
) -> Result<Vec<(f64, PathBuf)>> {
    let choose = |asked| chosen_salt(sweep, asked, &run.salt_molar);
    let chosen = asked.map(choose).transpose()?;
    let mut trajectories = Vec::new();
    for salt in &run.salt_molar {
        if chosen.is_some_and(|chosen| chosen != *salt) {
            continue;
        }
        for replica in 0..run.replicas {
            let directory = replica_directory(sweep, *salt, replica);
            if only.is_none_or(|only| only == directory) {
                trajectories.push((*salt, directory.join("trajectory.gsd")));
            }
        }
    }
    if trajectories.is_empty() {
        bail!(
            "{} holds no such simulation, only salt concentrations of {}; choose one of them",
            sweep.display(),
            listed_salts(&run.salt_molar)
        );
    }
    Ok(trajectories)
}

fn frames(
    path: &Path,
    assembly: &Assembly,
    settings: &ScatteringSettings,
) -> Result<Vec<Vec<Pose>>> {
    if !path.is_file() {
        bail!(
            "{} is missing; a run writes its trajectory after its equilibration, unless \
             --trajectory-every is 0",
            path.display()
        );
    }
    let mut reader = TrajectoryReader::open(path)?;
    let mut poses = Vec::new();
    for frame in chosen(reader.frames(), settings.skip, settings.most_frames) {
        let read = reader.frame(frame)?;
        let is_ours = read
            .type_ids
            .iter()
            .map(|kind| *kind as usize)
            .eq(assembly.kinds.iter().copied());
        if !is_ours {
            bail!(
                "{} is a trajectory of other bodies than those of the assembly; name the right one \
                 with --assembly FILE",
                path.display()
            );
        }
        poses.push(read.poses);
    }
    if poses.is_empty() {
        bail!("{} holds no frame yet; let the run go on", path.display());
    }
    Ok(poses)
}

/// The frames after the first share, evenly spread; the last is among them.
fn chosen(frames: u64, skip: f64, most: usize) -> Vec<u64> {
    let first = ((frames as f64 * skip).floor() as u64).min(frames);
    let remaining_frames = frames - first;
    let count = remaining_frames.min(most as u64);
    (1..=count)
        // From 1, so that the last frame is chosen.
        .map(|number| first + number * remaining_frames / count - 1)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_over_what_is_left() {
        assert_eq!(chosen(10, 0.2, 100), [2, 3, 4, 5, 6, 7, 8, 9]);
        assert_eq!(chosen(10, 0.2, 4), [3, 5, 7, 9]);
        assert_eq!(chosen(3, 0.9, 5), [2]);
        assert_eq!(chosen(0, 0.5, 5), Vec::<u64>::new());
    }
}
