//! The energy model: what it keeps from move to move, and what the engine asks it.

use super::calibration::Calibration;
use super::decision::{Changes, Decided};
use super::far::{Far, Images};
use super::list::List;
use super::stored::{Lists, PoseEnergies};
use super::table::Table;
use crate::energy::direct::direct_energy_kt;
use crate::energy::reach::{Reach, require_room};
use crate::energy::{
    Effort, EnergyModel, LevelReport, PairEnergy, Pairs, all_pairs, finite, sum_of_pairs,
};
use crate::prefetch::prefetch;
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::{BodyType, Result};
use protomer_kernel::potential::Yukawa;
use std::sync::Arc;

/// Energies by levels.
#[derive(Debug, Clone)]
pub struct Levels {
    pub(super) potential: Yukawa,
    pub(super) tables: Vec<Arc<Table>>,
    pub(super) calibration: Calibration,
    pub(super) tolerance_kt: Option<f64>,
    pub(super) reach: Reach,
    pub(super) far: Far,
    pub(super) energies: PairTable<Arc<PoseEnergies>>,
    pub(super) proposed: Vec<(usize, usize, Arc<PoseEnergies>)>,
    pub(super) decided: Decided,
    pub(super) first_energies: u64,
}

impl Levels {
    /// The model for this potential and system, with a table for each of its body types. Their levels
    /// are compared here.
    pub fn with_tables(potential: Yukawa, system: &System, tables: Vec<Arc<Table>>) -> Self {
        let calibration = Calibration::of_system(&potential, system, &tables);
        Self::with_calibration(potential, tables, calibration)
    }

    /// The model with tables whose levels have been compared.
    pub fn with_calibration(
        potential: Yukawa,
        tables: Vec<Arc<Table>>,
        calibration: Calibration,
    ) -> Self {
        Self {
            calibration,
            potential,
            tables,
            tolerance_kt: None,
            reach: Reach::default(),
            far: Far::default(),
            energies: PairTable::new(0),
            proposed: Vec::new(),
            decided: Decided::default(),
            first_energies: 0,
        }
    }

    /// The model with tables made here.
    pub fn for_system(potential: Yukawa, system: &System) -> Self {
        let reach = table_reach_angstrom(&potential, system);
        let table = |kind: &Arc<BodyType>| Arc::new(Table::new(&kind.charges, &potential, reach));
        let tables = system.types().iter().map(table).collect();
        Self::with_tables(potential, system, tables)
    }

    /// The same levels without the direct sum's decisions: each pair energy from the first level
    /// whose error is likely (within [`MULTIPLE`](super::MULTIPLE) standard deviations) below `tolerance_kt`.
    pub fn with_tolerance(mut self, tolerance_kt: f64) -> Self {
        self.tolerance_kt = Some(tolerance_kt);
        self
    }

    /// Number of decisions at each level.
    pub fn decided(&self) -> Decided {
        self.decided
    }

    /// The built-in comparison.
    pub fn calibration(&self) -> Calibration {
        self.calibration
    }

    /// Number of pair energies found at the first level.
    pub fn first_energies(&self) -> u64 {
        self.first_energies
    }

    fn prepare(&mut self, system: &System) {
        self.reach = Reach::of_multipoles(system, &self.potential);
        self.far = Far::new(system, &self.potential, &self.reach, self.tolerance_kt);
        self.proposed.clear();
    }

    /// Asks for what is known of a body's pairs. In a large system it is far from the processor, in
    /// three steps from pointer to pointer; those of all pairs are taken at once.
    fn prefetch(&self, body: usize) {
        let energies = self.energies.row(body).map(|(_, energies)| energies);
        energies
            // Energies, then lists, then the lists' points:
            // each needs the address from the one before.
            .clone()
            .for_each(|energies| prefetch(energies.as_ref()));
        let images = energies.flat_map(|energies| &energies.images);
        let lists = images.map(|image| image.list.as_ref());
        lists.clone().for_each(prefetch);
        lists.for_each(List::prefetch);
    }

    /// All pairs in reach, ascending.
    fn all_reported<'a>(&'a self, system: &'a System) -> impl Iterator<Item = Reported> + 'a {
        let bodies = 0..system.len();
        let pairs =
            bodies.flat_map(|first| (first + 1..system.len()).map(move |second| (first, second)));
        // Nothing is kept of far images, so they are found here, for reports only.
        pairs.filter_map(|(first, second)| {
            let near = self.energies.get(first, second);
            let far = self.stored(&system.pair(first, second), Images::Far);
            let of_near = near
                .as_deref()
                .map(|energies| self.reported(energies, Images::Near));
            let of_far = far
                .as_deref()
                .map(|energies| self.reported(energies, Images::Far));
            let both = of_near.into_iter().chain(of_far);
            let sum = both.fold((0.0, 0.0), |sum, (energy_kt, _, error_kt)| {
                (sum.0 + energy_kt, sum.1 + error_kt)
            });
            (near.is_some() || far.is_some()).then_some(Reported {
                first,
                second,
                near,
                energy_kt: sum.0,
                error_kt: sum.1,
            })
        })
    }
}

/// Returns what is known of a pair, if its energy is finite.
fn checked(pair: &Pair<'_>, energies: Arc<PoseEnergies>) -> Result<Arc<PoseEnergies>> {
    finite(pair.first, pair.second, energies.expanded_kt)?;
    Ok(energies)
}

/// The energy of a pair as it is reported.
struct Reported {
    first: usize,
    second: usize,
    near: Option<Arc<PoseEnergies>>,
    energy_kt: f64,
    error_kt: f64,
}

/// Distance to which a table must reach from its charges for this system, Å.
pub fn table_reach_angstrom(potential: &Yukawa, system: &System) -> f64 {
    Reach::of_multipoles(system, potential).largest_angstrom()
}

impl EnergyModel for Levels {
    /// Range of the direct sum: a cluster move draws a random number for each body in the cells of
    /// this size around a place, and must draw the same ones.
    fn range_angstrom(&self, system: &System) -> f64 {
        Reach::new(system, &self.potential).largest_angstrom()
    }

    fn reach_angstrom(&self, system: &System) -> f64 {
        table_reach_angstrom(&self.potential, system)
    }

    fn require_room(&self, system: &System) -> Result<()> {
        require_room(system, &self.potential)
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| {
            let energies = self.stored(pair, Images::Near);
            energies.map(|energies| checked(pair, energies)).transpose()
        })?;
        Ok(())
    }

    /// Energies from fine tables, whatever levels decisions requested: functions of the poses
    /// alone. What is far away is found here.
    fn pairs(&self, system: &System) -> Vec<PairEnergy> {
        let reported = |pair: Reported| {
            let near = pair.near.as_deref().map_or(&[][..], |near| &near.images);
            let images = near.iter().map(|image| image.relative);
            PairEnergy::found_at(pair.first, pair.second, pair.energy_kt, images)
        };
        self.all_reported(system).map(reported).collect()
    }

    /// Energies are found again where they were found first; lists are chosen there.
    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.prepare(system);
        self.energies = PairTable::new(system.len());
        for saved in pairs {
            let pair = system.pair(saved.first, saved.second);
            // Old files have no poses; the pair as it stands must do.
            let poses = match saved.computed_at {
                Some(_) => saved.images(&pair).collect(),
                None => self.image_poses(&pair, Images::Near),
            };
            if !poses.is_empty() {
                // No lists: they are chosen at these poses,
                // as they were when the energies were found.
                let energies = self.known_at(&pair, poses, Lists::new());
                let energies = checked(&pair, energies)?;
                self.energies.set(saved.first, saved.second, energies);
            }
        }
        Ok(())
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        // Memory on its way while the partners are found.
        self.prefetch(trial.body);
        let row = self.energies.row(trial.body);
        let mut near: Vec<usize> = row.map(|(partner, _)| partner).collect();
        let mut changes = Changes::default();
        for &partner in partners {
            let after = trial.pair(partner);
            // Far images of every partner, near or not: other images of a near one may be far.
            self.add_far(&mut changes, trial, partner, &after);
            if self.far.near().is_met(&after) {
                near.push(partner);
            }
        }
        near.sort_unstable();
        // A partner may be near before, after, or both; it counts once.
        near.dedup();
        for partner in near {
            changes.pairs.extend(self.first_change(trial, partner)?);
        }
        let accepted = self.rises_less(trial, &mut changes, budget_kt)?;
        // Also what is rejected: `reject` clears it, and the engine may accept after further tests.
        self.propose(trial, changes);
        Ok(accepted)
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        let mut changes = Changes::default();
        self.add_far(&mut changes, trial, partner, &trial.pair(partner));
        changes.pairs.extend(self.first_change(trial, partner)?);
        let exceeds = !self.rises_less(trial, &mut changes, threshold_kt)?;
        self.propose(trial, changes);
        Ok(exceeds)
    }

    fn commit(&mut self, bodies: &[usize]) {
        self.energies.take_over(bodies, self.proposed.drain(..));
    }

    fn reject(&mut self) {
        self.proposed.clear();
    }

    fn error_bound_kt(&self, system: &System) -> f64 {
        let errors = self.all_reported(system).map(|pair| pair.error_kt);
        errors.fold(0.0, f64::max)
    }

    /// Quick energies are those of fine tables.
    fn energy_elsewhere_kt(
        &self,
        system: &System,
        pairs: Pairs<'_>,
        effort: Effort,
    ) -> Result<f64> {
        let reach_of_all = Reach::new(system, &self.potential);
        sum_of_pairs(system, pairs, |pair| match effort {
            Effort::Quick => self.energy_alone_kt(pair).map(Some),
            Effort::Full => direct_energy_kt(&self.potential, &reach_of_all, pair),
        })
    }

    fn levels(&self) -> Option<LevelReport> {
        Some(LevelReport::Calibrated {
            decided_by_level: self.decided,
            calibration: self.calibration,
        })
    }

    fn memory_bytes(&self) -> usize {
        self.tables.iter().map(|table| table.memory_bytes()).sum()
    }
}
