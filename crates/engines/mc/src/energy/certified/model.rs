//! The levels of a pair of bodies, and decisions that hold for every value in their intervals.

use super::cells::{Cells, Interval};
use crate::energy::direct::direct_energy_kt;
use crate::energy::far_energies::FarEnergies;
use crate::energy::reach::{Reach, require_room};
use crate::energy::{
    Effort, EnergyModel, LevelReport, PairEnergy, Pairs, all_pairs, finite, pair_energy_kt,
    sum_of_pairs,
};
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::{BodyType, Result};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use serde::Serialize;
use smallvec::SmallVec;
use std::sync::{Arc, OnceLock};

/// Number of decisions at each level.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct DecidedByBounds {
    /// Decisions from the distances of bodies alone.
    pub far: u64,
    /// Decisions with the charges of one body in the cells of the other, for one pair of bodies or
    /// more.
    pub cells: u64,
    /// Decisions with a direct sum for one pair of bodies or more.
    pub direct: u64,
}

/// Energies with proven bounds.
#[derive(Debug, Clone)]
pub struct Certified {
    potential: Yukawa,
    cells: Vec<Arc<Cells>>,
    far: FarEnergies,
    reach: Reach,
    energies: PairTable<Arc<PoseEnergies>>,
    proposed: Vec<Arc<PoseEnergies>>,
    decided: DecidedByBounds,
}

/// Energies known of a pair of bodies at one pose.
#[derive(Debug)]
struct PoseEnergies {
    bodies: (usize, usize),
    types: (usize, usize),
    /// Poses of the images of the second body that count, in the frame of the first.
    images: SmallVec<[RelativePose; 1]>,
    /// The most that the images hold together, kT.
    far_kt: f64,
    in_cells: OnceLock<Option<Interval>>,
    direct_kt: OnceLock<f64>,
}

/// One energy in a decision: of a pair after the move, or before it with the opposite sign.
struct Summand {
    energies: Arc<PoseEnergies>,
    sign: f64,
    level: usize,
    interval: Interval,
}

const FAR: usize = 0;
const CELLS: usize = 1;
const DIRECT: usize = 2;

impl Certified {
    /// The model for this potential and system. Its cells are made where they are needed.
    pub fn for_system(potential: Yukawa, system: &System) -> Self {
        let reach_angstrom = Self::cell_reach_angstrom(&potential, system);
        let cells =
            |kind: &Arc<BodyType>| Arc::new(Cells::new(&kind.charges, &potential, reach_angstrom));
        let cells = system.types().iter().map(cells).collect();
        Self::with_cells(potential, system, cells)
    }

    /// The model with the cells of each body type, which others may use at the same time.
    pub fn with_cells(potential: Yukawa, system: &System, cells: Vec<Arc<Cells>>) -> Self {
        let reach = Reach::of_multipoles(system, &potential);
        Self {
            potential,
            cells,
            far: FarEnergies::new(system, &potential, reach.largest_angstrom()),
            reach,
            energies: PairTable::new(0),
            proposed: Vec::new(),
            decided: DecidedByBounds::default(),
        }
    }

    /// Largest distance from a body's origin at which charges of another interact with it, Å.
    pub fn cell_reach_angstrom(potential: &Yukawa, system: &System) -> f64 {
        let radius = |kind: &Arc<BodyType>| kind.charge_radius_angstrom();
        let largest = system.types().iter().map(radius).fold(0.0, f64::max);
        Reach::of_multipoles(system, potential).largest_angstrom() + largest
    }

    /// Number of decisions at each level.
    pub fn decided(&self) -> DecidedByBounds {
        self.decided
    }

    fn prepare(&mut self, system: &System) {
        self.reach = Reach::of_multipoles(system, &self.potential);
        self.proposed.clear();
    }

    /// The pair at its present pose; `None` beyond the reach.
    fn stored(&self, pair: &Pair<'_>) -> Option<Arc<PoseEnergies>> {
        // Before any allocation: most pairs that are asked for are out of reach.
        if !self.reach.is_met(pair) {
            return None;
        }
        // Poses are kept with the energies, so that they can be found again bit for bit.
        let images = self.reach.images(pair);
        self.known_at(pair, images.map(|image| pair.relative_image(&image)))
    }

    fn known_at(
        &self,
        pair: &Pair<'_>,
        images: impl Iterator<Item = RelativePose>,
    ) -> Option<Arc<PoseEnergies>> {
        let (types, images) = (pair.type_indices(), images.collect::<SmallVec<_>>());
        let far_kt = |image: &RelativePose| self.far.energy(types, image.translation.norm());
        let energies = PoseEnergies {
            bodies: (pair.first, pair.second),
            types,
            far_kt: images.iter().map(far_kt).sum(),
            images,
            in_cells: OnceLock::new(),
            direct_kt: OnceLock::new(),
        };
        (!energies.images.is_empty()).then(|| Arc::new(energies))
    }

    /// The energy of a pair at one level; the error names a pair whose energy is not finite.
    fn interval(&self, energies: &PoseEnergies, level: usize) -> Result<Interval> {
        let (energy_kt, error_kt) = match level {
            // Somewhere between minus and plus the bound: zero is the middle.
            FAR => (0.0, energies.far_kt),
            CELLS => match self.in_cells(energies) {
                Some(interval) => return Ok(interval),
                // Beyond the octree there are no cells; the direct sum is the next level.
                None => return self.interval(energies, DIRECT),
            },
            _ => (self.direct_kt(energies)?, 0.0),
        };
        Ok(Interval {
            energy_kt,
            error_kt,
        })
    }

    /// The sum over the images, each with the charges of the second body in the cells of the first;
    /// `None` if one lies beyond them.
    fn in_cells(&self, energies: &PoseEnergies) -> Option<Interval> {
        let (first, second) = energies.types;
        let (cells, charges) = (&self.cells[first], self.cells[second].charges());
        let add = |sum: Interval, image| {
            let image = cells.energy_with(charges, image)?;
            Some(Interval {
                energy_kt: sum.energy_kt + image.energy_kt,
                error_kt: sum.error_kt + image.error_kt,
            })
        };
        let sum = || energies.images.iter().try_fold(Interval::default(), add);
        // Kept: an energy after an accepted move is that before the next one.
        *energies.in_cells.get_or_init(sum)
    }

    fn direct_kt(&self, energies: &PoseEnergies) -> Result<f64> {
        let (first, second) = energies.types;
        let charges = [first, second].map(|index| self.cells[index].charges());
        let energy = |image| pair_energy_kt(&self.potential, charges[0], charges[1], image);
        let sum = || energies.images.iter().map(energy).sum();
        let (first, second) = energies.bodies;
        finite(first, second, *energies.direct_kt.get_or_init(sum))
    }

    /// Whether the energy rises by less than the threshold, for every value in the intervals.
    fn rises_less(&mut self, mut summands: Vec<Summand>, threshold_kt: f64) -> Result<bool> {
        loop {
            let rise: f64 = summands.iter().map(Summand::signed_kt).sum();
            let error: f64 = summands
                .iter()
                .map(|summand| summand.interval.error_kt)
                .sum();
            // Outside the summed error no value in the intervals changes the answer.
            let is_settled = (rise - threshold_kt).abs() > error;
            let open = summands.iter_mut().filter(|summand| summand.level < DIRECT);
            // The widest interval first: it shrinks the error most, whatever it costs.
            let widest = open.max_by(|a, b| a.interval.error_kt.total_cmp(&b.interval.error_kt));
            let Some(widest) = widest.filter(|_| !is_settled) else {
                // Nothing open: all are direct sums, and the comparison is that of numbers.
                self.count(&summands);
                return Ok(rise < threshold_kt);
            };
            widest.level += 1;
            widest.interval = self.interval(&widest.energies, widest.level)?;
        }
    }

    fn count(&mut self, summands: &[Summand]) {
        let levels = summands.iter().map(|summand| summand.level);
        match levels.max().unwrap_or(FAR) {
            FAR => self.decided.far += 1,
            CELLS => self.decided.cells += 1,
            _ => self.decided.direct += 1,
        }
    }

    /// The energy with a partner after the move, if they interact there; it is proposed.
    fn after(&mut self, trial: &Trial<'_>, partner: usize) -> Option<Summand> {
        let energies = self.stored(&trial.pair(partner))?;
        self.proposed.push(Arc::clone(&energies));
        Some(Summand::new(energies, 1.0))
    }

    /// Reported energy: a function of the pose alone. Not a number where the direct sum is none,
    /// which every decision with this pair has refused.
    fn reported(&self, energies: &PoseEnergies) -> Interval {
        // NaN and not zero: a broken pair must show.
        let unknown = Interval {
            energy_kt: f64::NAN,
            error_kt: f64::INFINITY,
        };
        self.interval(energies, CELLS).unwrap_or(unknown)
    }
}

impl Summand {
    /// A summand known from the distance alone.
    fn new(energies: Arc<PoseEnergies>, sign: f64) -> Self {
        let interval = Interval {
            energy_kt: 0.0,
            error_kt: energies.far_kt,
        };
        Self {
            energies,
            sign,
            level: FAR,
            interval,
        }
    }

    /// Summand of a pair before the move.
    fn before(energies: &Arc<PoseEnergies>) -> Self {
        Self::new(Arc::clone(energies), -1.0)
    }

    fn signed_kt(&self) -> f64 {
        self.sign * self.interval.energy_kt
    }
}

impl EnergyModel for Certified {
    /// Range of the direct sum, so that cluster moves draw the same random numbers.
    fn range_angstrom(&self, system: &System) -> f64 {
        Reach::new(system, &self.potential).largest_angstrom()
    }

    fn reach_angstrom(&self, system: &System) -> f64 {
        Reach::of_multipoles(system, &self.potential).largest_angstrom()
    }

    fn require_room(&self, system: &System) -> Result<()> {
        require_room(system, &self.potential)
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| {
            let Some(energies) = self.stored(pair) else {
                return Ok(None);
            };
            // Found once here, so that an energy that is not finite ends a run at its start.
            self.interval(&energies, CELLS)?;
            Ok(Some(energies))
        })?;
        Ok(())
    }

    fn pairs(&self, _: &System) -> Vec<PairEnergy> {
        let reported = |(first, second, energies): (usize, usize, Arc<PoseEnergies>)| {
            let energy_kt = self.reported(&energies).energy_kt;
            PairEnergy::found_at(first, second, energy_kt, energies.images.iter().copied())
        };
        self.energies.pairs().map(reported).collect()
    }

    /// Energies are found again where they were found first.
    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.prepare(system);
        self.energies = PairTable::new(system.len());
        for saved in pairs {
            let pair = system.pair(saved.first, saved.second);
            if let Some(energies) = self.known_at(&pair, saved.images(&pair)) {
                self.energies.set(saved.first, saved.second, energies);
            }
        }
        Ok(())
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        let row = self.energies.row(trial.body);
        let mut summands: Vec<Summand> =
            // Before the move with the opposite sign, so one sum of intervals is the change.
            row.map(|(_, energies)| Summand::before(energies)).collect();
        for &partner in partners {
            summands.extend(self.after(trial, partner));
        }
        self.rises_less(summands, budget_kt)
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        let before = self.energies.get(trial.body, partner);
        let mut summands: Vec<Summand> = before.iter().map(Summand::before).collect();
        summands.extend(self.after(trial, partner));
        // "Not less" is "more" but for equality, which has probability zero.
        Ok(!self.rises_less(summands, threshold_kt)?)
    }

    fn commit(&mut self, bodies: &[usize]) {
        let proposed = self.proposed.drain(..).map(|energies| {
            let (first, second) = energies.bodies;
            (first, second, energies)
        });
        self.energies.take_over(bodies, proposed);
    }

    fn reject(&mut self) {
        self.proposed.clear();
    }

    fn error_bound_kt(&self, _: &System) -> f64 {
        let pairs = self.energies.pairs();
        let errors = pairs.map(|(_, _, energies)| self.reported(&energies).error_kt);
        errors.fold(0.0, f64::max)
    }

    /// Quick energies are those of cells.
    fn energy_elsewhere_kt(
        &self,
        system: &System,
        pairs: Pairs<'_>,
        effort: Effort,
    ) -> Result<f64> {
        let reach_of_all = Reach::new(system, &self.potential);
        sum_of_pairs(system, pairs, |pair| match effort {
            Effort::Quick => {
                let energies = self.stored(pair);
                let energy = energies.map(|energies| self.interval(&energies, CELLS));
                Ok(energy.transpose()?.map(|interval| interval.energy_kt))
            }
            Effort::Full => direct_energy_kt(&self.potential, &reach_of_all, pair),
        })
    }

    fn levels(&self) -> Option<LevelReport> {
        Some(LevelReport::Certified {
            decided_by_level: self.decided,
        })
    }

    fn memory_bytes(&self) -> usize {
        self.cells.iter().map(|cells| cells.memory_bytes()).sum()
    }
}
