//! The bodies and the frames of a run, or the one pose of an assembly.

use super::bound::AssemblyContacts;
use super::settings::ResiduesSettings;
use crate::assemblies::assembly_file::Assembly;
use crate::export::assembly_of;
use crate::file_kind::FileKind;
use crate::stability::effective::{EffectiveStore, near_contact_warning};
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{
    EnergyMode, Engine, RunSettings, chosen_salt, replica_directory, salt_label,
};
use crate::stability::sweep::result::SweepResult;
use crate::stability::sweep::stability::CountedContacts;
use crate::stability::sweep::table::SaltRow;
use anyhow::{Context, Result, bail};
use protomer_io::gsd::TrajectoryReader;
use protomer_kernel::Pose;
use protomer_mc::System;
use protomer_results::{Record, ResultKind, keys};
use std::path::PathBuf;
use std::sync::Arc;

/// A run, or an assembly in one pose.
pub struct Run {
    engine: Engine,
    pub settings: RunSettings,
    /// The directory of a run; `None` for an assembly.
    pub directory: Option<PathBuf>,
    /// Identity of the run, or hash of the assembly, from which the results are made.
    pub identity: String,
}

/// A salt concentration, and why it was chosen.
pub struct ShownSalt {
    pub salt_molar: f64,
    /// Reason for the choice; `None` if the salt was requested, or is the only one.
    pub why: Option<&'static str>,
}

/// Answer of the sweep itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct SweepAnswer {
    pub half_salt_molar: Option<f64>,
    pub is_equilibrated: bool,
    /// Whether runs are known to disagree, so that no mean over them is that of one state.
    pub is_not_equilibrated: bool,
}

/// The frames at one salt concentration.
pub struct AtSalt {
    /// Engine with the charges and the terms of this medium.
    pub engine: Engine,
    /// Engine with the charges of the bodies themselves, where effective ones interact: energies of
    /// residues are shared out by these.
    pub plain: Option<Engine>,
    /// Contacts of the assembly, if only frames count in which it holds; all frames count if
    /// `None`.
    bound: Option<AssemblyContacts>,
    pub interaction: ScreenedCoulomb,
    /// Blocks of frames that follow each other.
    pub blocks: Vec<Vec<Vec<Pose>>>,
    pub replicas: usize,
}

/// Blocks at one salt concentration, so that their spread tells the error.
const FEWEST_BLOCKS: usize = 8;

impl Run {
    /// Opens what the settings name.
    pub fn open(settings: &ResiduesSettings, store: Arc<EffectiveStore>) -> Result<Self> {
        let run = match settings.input.is_dir() {
            true => Self::of_directory(settings)?,
            false => Self::of_assembly(settings)?,
        };
        for body in &run.engine.assembly().bodies {
            if body.residues.is_empty() {
                bail!(
                    "body '{}' has no residues; make it from a structure file with 'protomer \
                     ingest'",
                    body.name
                );
            }
        }
        if run.settings.energy == Some(EnergyMode::None) {
            bail!(
                "{} holds hard bodies without charges, so no residue has an energy",
                settings.input.display()
            );
        }
        Ok(Self {
            engine: run.engine.with_effective_store(store),
            ..run
        })
    }

    fn of_assembly(settings: &ResiduesSettings) -> Result<Self> {
        FileKind::Assembly.require(&settings.input)?;
        if settings.assembly.is_some() {
            bail!(
                "--assembly applies to directories of runs, but {} is a file; leave it out",
                settings.input.display()
            );
        }
        let assembly = Assembly::read(&settings.input)?;
        let identity = assembly.sha256.clone();
        let mut run = settings.pose.run.clone();
        match settings.salt_molar {
            Some(salt_molar) => run.salt_molar = vec![salt_molar],
            None if run.medium.debye_length_angstrom.is_some() => run.salt_molar = vec![0.0],
            None => bail!("the energy depends on the salt; give --salt 100mM"),
        }
        run.check()?;
        Ok(Self {
            engine: Engine::new(assembly)?,
            settings: run,
            directory: None,
            identity,
        })
    }

    fn of_directory(settings: &ResiduesSettings) -> Result<Self> {
        let directory = settings.input.as_path();
        if settings.pose.is_stated {
            bail!(
                "{} is a run, which has its medium, charges and terms; leave out their flags, or \
                 name an assembly file",
                directory.display()
            );
        }
        match ResultKind::detect(directory) {
            Some(ResultKind::Sweep) => {}
            Some(ResultKind::Simulation) => bail!(
                "{} holds one simulation of a sweep; name the directory of the whole sweep, with \
                 --salt if it has several",
                directory.display()
            ),
            Some(ResultKind::Pair | ResultKind::PairCondition) => bail!(
                "{} holds the results of two bodies, which have tables of residues already: \
                 residues.csv in its folders",
                directory.display()
            ),
            _ => bail!(
                "{} holds no sweep and no simulation; name the directory of one, or an assembly \
                 file",
                directory.display()
            ),
        }
        let run: RunSettings = keys::read_toml(&directory.join("run.toml"))?;
        run.require_fixed_charges("residues")?;
        let record = Record::read(directory)?;
        let assembly = assembly_of(directory, record.as_ref(), settings.assembly.as_deref());
        let assembly = assembly.context(
            "the assembly of this run cannot be used; name the right one with --assembly FILE",
        )?;
        Ok(Self {
            engine: Engine::new(assembly)?,
            settings: run,
            directory: Some(directory.to_owned()),
            identity: record.map_or_else(String::new, |record| record.identity),
        })
    }

    /// The assembly.
    pub fn assembly(&self) -> &Assembly {
        self.engine.assembly()
    }

    /// The bodies at the places of the assembly.
    pub fn system(&self) -> Result<System> {
        self.engine.system()
    }

    /// The salt concentrations, ascending.
    pub fn salts(&self) -> Vec<f64> {
        let mut salts = self.settings.salt_molar.clone();
        salts.sort_by(f64::total_cmp);
        salts
    }

    /// The salt concentration whose energies are shown: the requested one, or the highest at which
    /// the assembly still holds.
    pub fn shown_salt(&self, settings: &ResiduesSettings) -> Result<ShownSalt> {
        let salts = self.salts();
        if let (Some(asked), Some(_)) = (settings.salt_molar, &self.directory) {
            let salt_molar = chosen_salt(&settings.input, asked, &salts)?;
            return Ok(ShownSalt {
                salt_molar,
                why: None,
            });
        }
        let (Some(lowest), true) = (salts.first(), salts.len() > 1) else {
            let only = salts.first().copied().unwrap_or(0.0);
            return Ok(ShownSalt {
                salt_molar: only,
                why: None,
            });
        };
        // Runs that disagree have no half salt: only the lowest salt surely holds the assembly.
        if self.answer()?.is_not_equilibrated {
            return Ok(ShownSalt {
                salt_molar: *lowest,
                why: Some(
                    "the lowest salt of the sweep: it is not equilibrated, so no salt is known up to \
                     which the contacts are left",
                ),
            });
        }
        Ok(self.highest_that_holds()?.unwrap_or(ShownSalt {
            salt_molar: *lowest,
            why: Some("the lowest salt of the sweep"),
        }))
    }

    /// The highest salt at which the assembly holds, from the result of the sweep: more than half of
    /// its contacts are left, or, where bodies change places, more than half of them are bound.
    fn highest_that_holds(&self) -> Result<Option<ShownSalt>> {
        let Some(directory) = &self.directory else {
            return Ok(None);
        };
        let Some(result) = SweepResult::read(directory)? else {
            return Ok(None);
        };
        let (share, why): (fn(&SaltRow) -> f64, _) = match result.stability.half_salt_contacts {
            CountedContacts::Any => (
                |row| row.averages.bound_fraction.mean,
                "the highest salt at which more than half of the bodies touch another",
            ),
            CountedContacts::Native => (
                |row| row.averages.native_contacts.mean,
                "the highest salt at which more than half of the contacts are left",
            ),
        };
        let holding = result.salts.iter().filter(|row| share(row) > 0.5);
        let salts = holding.map(|row| row.salt_molar);
        let highest = salts.max_by(f64::total_cmp).map(salt_label);
        let ours = self.settings.salt_molar.iter().copied();
        let same = ours
            .into_iter()
            // The sweep's answer states rounded salts; the settings have the exact ones.
            .find(|salt| Some(salt_label(*salt)) == highest);
        Ok(same.map(|salt_molar| ShownSalt {
            salt_molar,
            why: Some(why),
        }))
    }

    /// The answer of the sweep, if there is one.
    pub fn answer(&self) -> Result<SweepAnswer> {
        let Some(directory) = &self.directory else {
            return Ok(SweepAnswer::default());
        };
        let Some(SweepResult { stability, .. }) = SweepResult::read(directory)? else {
            return Ok(SweepAnswer::default());
        };
        Ok(SweepAnswer {
            half_salt_molar: stability.half_salt_molar,
            is_equilibrated: stability.equilibrated == Some(true),
            is_not_equilibrated: stability.equilibrated == Some(false),
        })
    }

    /// Rise of the mean energy of these frames with the logarithm of the salt, kT: from the same
    /// frames at the neighbouring salts of the run. `None` for an assembly, and without salt.
    pub fn rise_with_salt_kt(&self, ensemble: &AtSalt, salt_molar: f64) -> Result<Option<f64>> {
        let salts = self.salts();
        let place = salts.iter().position(|salt| *salt == salt_molar);
        let (Some(place), true) = (place, salts.len() > 1) else {
            return Ok(None);
        };
        // At an end of the sweep the difference is one-sided.
        let (low, high) = (
            salts[place.saturating_sub(1)],
            salts[(place + 1).min(salts.len() - 1)],
        );
        // ln of zero salt.
        if low <= 0.0 {
            return Ok(None);
        }
        let energies = [low, high].map(|salt| self.mean_energy_kt(ensemble, salt));
        let [low_kt, high_kt] = energies;
        Ok(Some((high_kt? - low_kt?) / (high / low).ln()))
    }

    /// The mean energy of the frames that count at another salt, kT.
    pub fn mean_energy_kt(&self, ensemble: &AtSalt, salt_molar: f64) -> Result<f64> {
        let interaction = self.settings.medium.interaction(Some(salt_molar))?;
        let engine = self.engine.in_medium(&self.settings, &interaction)?;
        // Directly: the energies are compared at different
        // salts, and errors of the levels would differ.
        let direct = RunSettings {
            energy: Some(EnergyMode::Direct),
            tolerance_kt: None,
            ..self.settings.clone()
        };
        let mut model = engine.energy_model(&direct, &interaction)?;
        let (mut sum, mut frames) = (0.0, 0.0);
        for poses in ensemble.blocks.iter().flatten() {
            let system = engine.system_at(poses)?;
            if !ensemble.counts(&system) {
                continue;
            }
            model.reset(&system)?;
            sum += model.total_kt(&system);
            frames += 1.0;
        }
        Ok(sum / frames)
    }

    /// The frames at one of the salt concentrations.
    pub fn ensemble(&self, settings: &ResiduesSettings, salt_molar: f64) -> Result<AtSalt> {
        let medium = &self.settings.medium;
        let interaction = medium.interaction(Some(salt_molar))?;
        let engine = self.engine.in_medium(&self.settings, &interaction)?;
        let plain = engine
            .effective_bodies()
            .is_some()
            .then(|| self.engine.clone());
        let Some(directory) = &self.directory else {
            engine.check(&self.settings, &[interaction])?;
            let pose = self.assembly().poses.clone();
            return Ok(AtSalt {
                engine,
                plain,
                bound: None,
                interaction,
                blocks: vec![vec![pose]],
                replicas: 1,
            });
        };
        let mut readers = Vec::new();
        for replica in 0..self.settings.replicas {
            let simulation = replica_directory(directory, salt_molar, replica);
            readers.push(self.reader(simulation)?);
        }
        let blocks_of_each = FEWEST_BLOCKS.div_ceil(readers.len().max(1));
        let most = settings.most_frames.div_ceil(readers.len().max(1));
        let mut blocks = Vec::new();
        for (reader, path) in &mut readers {
            let numbers = evenly(reader.frames() as usize, most);
            // Rounded up: no replica has more blocks than wanted.
            let length = numbers.len().div_ceil(blocks_of_each).max(1);
            for chosen in numbers.chunks(length) {
                let mut block = Vec::with_capacity(chosen.len());
                for number in chosen {
                    let frame = reader.frame(*number as u64)?;
                    let kinds = frame.type_ids.iter().map(|kind| *kind as usize);
                    // An assembly of another run would give energies all the same.
                    if !kinds.eq(self.assembly().kinds.iter().copied()) {
                        bail!(
                            "{} is a trajectory of other bodies than those of the assembly; name \
                             the right one with --assembly FILE",
                            path.display()
                        );
                    }
                    block.push(frame.poses);
                }
                blocks.push(block);
            }
        }
        let disagree = self.answer()?.is_not_equilibrated;
        let bound = match disagree {
            true => Some(AssemblyContacts::new(&self.system()?, &self.settings)),
            false => None,
        };
        Ok(AtSalt {
            engine,
            plain,
            bound,
            interaction,
            blocks,
            replicas: readers.len(),
        })
    }

    fn reader(&self, simulation: PathBuf) -> Result<(TrajectoryReader, PathBuf)> {
        let path = simulation.join("trajectory.gsd");
        if !path.is_file() {
            bail!(
                "{} holds no trajectory; a run writes one after its equilibration, unless \
                 --trajectory-every is 0",
                simulation.display()
            );
        }
        let reader = TrajectoryReader::open(&path)?;
        if reader.frames() == 0 {
            bail!(
                "{} has no frame; frames are written every {} sweeps: run longer (--sweeps), or \
                 write them more often (--trajectory-every)",
                path.display(),
                self.settings.trajectory_every
            );
        }
        Ok((reader, path))
    }
}

/// At most `most` numbers below `count`, evenly chosen, the last among them.
fn evenly(count: usize, most: usize) -> Vec<usize> {
    let chosen = count.min(most);
    // From 1, so that the last frame is always chosen.
    (1..=chosen)
        .map(|index| index * count / chosen - 1)
        .collect()
}

impl AtSalt {
    /// Whether a frame counts: always, unless the runs disagree and the assembly does not hold in it.
    pub fn counts(&self, system: &System) -> bool {
        self.bound.as_ref().is_none_or(|bound| bound.holds(system))
    }

    /// Whether only frames count in which the assembly holds.
    pub fn counts_bound_only(&self) -> bool {
        self.bound.is_some()
    }

    /// The salt, or the Debye length, in words.
    pub fn salt_in_words(&self) -> String {
        let electrolyte = &self.interaction.electrolyte;
        match electrolyte.salt_molar() {
            Some(salt_molar) => format!("{} mM salt", 1e3 * salt_molar),
            None => format!(
                "a Debye length of {} Å",
                electrolyte.debye_length_angstrom()
            ),
        }
    }

    /// A warning if bodies of a frame that counts are too near for effective charges.
    pub fn near_contact_warning(&self, run: &RunSettings) -> Result<Option<String>> {
        for poses in self.blocks.iter().flatten() {
            let system = self.engine.system_at(poses)?;
            let warning = near_contact_warning(&system, run);
            if warning.is_some() && self.counts(&system) {
                return Ok(warning);
            }
        }
        Ok(None)
    }

    /// Frames that were read.
    pub fn frames_read(&self) -> usize {
        self.blocks.iter().map(Vec::len).sum()
    }

    /// The last frame of the first replica, or the pose.
    pub fn last_of_first(&self) -> Option<&Vec<Pose>> {
        // Blocks of the first replica come first.
        let of_first = self.blocks.len() / self.replicas.max(1);
        self.blocks.get(of_first.max(1) - 1)?.last()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_chosen_evenly_and_end_with_the_last() {
        assert_eq!(evenly(4, 10), [0, 1, 2, 3]);
        assert_eq!(evenly(10, 4), [1, 4, 6, 9]);
        assert_eq!(evenly(10, 1), [9]);
        assert!(evenly(0, 5).is_empty());
    }
}
