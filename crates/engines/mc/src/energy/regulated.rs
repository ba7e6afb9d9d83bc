//! The plain sum over all pairs of charges of bodies whose groups take up and lose protons.
//!
//! Each body has a state of its own. Energies of pairs are those of the present charges, as in
//! [`DirectSum`](super::DirectSum); a change of protons adds the sum over the few charges that change.

use super::reach::{NEGLIGIBLE_KT, Reach, require_room};
use super::{
    Effort, EnergyModel, PairEnergy, Pairs, all_pairs, finite, pair_energy_kt, sum_of_pairs,
};
use crate::charges::ChargeCloud;
use crate::moves::protonation;
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::titratable::TitratableCharges;
use crate::{McError, Result};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use std::sync::Arc;

/// The direct sum for charges that respond to each other, at constant pH.
#[derive(Debug, Clone)]
pub struct Regulated {
    potential: Yukawa,
    /// Groups by type of body; `None` for a type whose charges are fixed.
    groups: Vec<Option<Arc<TitratableCharges>>>,
    reach: Reach,
    /// Charged groups and charges of each body.
    states: Vec<Vec<bool>>,
    clouds: Vec<ChargeCloud>,
    energies: PairTable<f64>,
    proposed: Vec<PairEnergy>,
}

impl Regulated {
    /// The sum of this potential, with the titratable groups of each type of body.
    pub fn new(potential: Yukawa, groups: Vec<Option<Arc<TitratableCharges>>>) -> Self {
        Self {
            potential,
            groups,
            reach: Reach::default(),
            states: Vec::new(),
            clouds: Vec::new(),
            energies: PairTable::new(0),
            proposed: Vec::new(),
        }
    }

    fn groups_of(&self, kind: usize) -> Option<&Arc<TitratableCharges>> {
        self.groups.get(kind).and_then(Option::as_ref)
    }

    /// The reach of the strongest charges that bodies can have.
    fn reach_in(&self, system: &System) -> Reach {
        let strongest = |kind: usize| match self.groups_of(kind) {
            Some(groups) => (groups.sum_of_magnitudes_e(), groups.radius_angstrom()),
            None => {
                let charges = &system.types()[kind].charges;
                (charges.sum_of_magnitudes_e(), charges.radius_angstrom())
            }
        };
        let types = system.types().len();
        let mut distances = Vec::with_capacity(types * types);
        for first in 0..types {
            for second in 0..types {
                let (first, second) = (strongest(first), strongest(second));
                let product = first.0 * second.0;
                distances.push(match product > 0.0 {
                    true => {
                        self.potential.reach_angstrom(product, NEGLIGIBLE_KT) + first.1 + second.1
                    }
                    false => 0.0,
                });
            }
        }
        Reach::of_types(system, distances)
    }

    /// Charges of all bodies in their states; bodies without a state begin with one.
    fn prepare(&mut self, system: &System) {
        self.reach = self.reach_in(system);
        self.proposed.clear();
        if self.states.len() != system.len() {
            let start = |body: usize| match self.groups_of(system.type_index(body)) {
                Some(groups) => groups.start(),
                None => Vec::new(),
            };
            self.states = (0..system.len()).map(start).collect();
        }
        let charges = |body: usize| match self.groups_of(system.type_index(body)) {
            Some(groups) => groups.charges(&self.states[body]),
            None => system.body_type(body).charges.clone(),
        };
        self.clouds = (0..system.len()).map(charges).collect();
    }

    /// The energy of a pair, kT, with other charges for one of the two; `None` if no image is in reach.
    fn energy_kt(
        &self,
        pair: &Pair<'_>,
        other: Option<(usize, &ChargeCloud)>,
    ) -> Result<Option<f64>> {
        let charges = |body: usize| match other {
            Some((changed, charges)) if changed == body => charges,
            _ => &self.clouds[body],
        };
        let (first, second) = (charges(pair.first), charges(pair.second));
        let mut energy_kt = None;
        for displacement in self.reach.images(pair) {
            let relative = pair.relative_image(&displacement);
            let image = pair_energy_kt(&self.potential, first, second, &relative);
            *energy_kt.get_or_insert(0.0) += image;
        }
        let checked = |energy_kt| finite(pair.first, pair.second, energy_kt);
        energy_kt.map(checked).transpose()
    }

    fn propose(&mut self, pair: &Pair<'_>) -> Result<f64> {
        let Some(energy_kt) = self.energy_kt(pair, None)? else {
            return Ok(0.0);
        };
        self.proposed
            .push(PairEnergy::new(pair.first, pair.second, energy_kt));
        Ok(energy_kt)
    }
}

impl EnergyModel for Regulated {
    fn range_angstrom(&self, system: &System) -> f64 {
        self.reach_in(system).largest_angstrom()
    }

    fn require_room(&self, system: &System) -> Result<()> {
        require_room(system, &self.potential)
    }

    /// Keeps the protons of the bodies.
    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| self.energy_kt(pair, None))?;
        Ok(())
    }

    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.prepare(system);
        self.energies = PairTable::new(system.len());
        for pair in pairs {
            let energy_kt = finite(pair.first, pair.second, pair.energy_kt)?;
            self.energies.set(pair.first, pair.second, energy_kt);
        }
        Ok(())
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        let energies = self.energies.row(trial.body);
        let old: f64 = energies.map(|(_, energy)| energy).sum();
        let mut new = 0.0;
        for &partner in partners {
            new += self.propose(&trial.pair(partner))?;
        }
        Ok(new - old < budget_kt)
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        let old = self.energies.get(trial.body, partner).unwrap_or(0.0);
        let new = self.propose(&trial.pair(partner))?;
        Ok(new - old > threshold_kt)
    }

    fn commit(&mut self, bodies: &[usize]) {
        let proposed = self
            .proposed
            .drain(..)
            .map(|pair| (pair.first, pair.second, pair.energy_kt));
        self.energies.take_over(bodies, proposed);
    }

    fn reject(&mut self) {
        self.proposed.clear();
    }

    fn energy_elsewhere_kt(&self, system: &System, pairs: Pairs<'_>, _: Effort) -> Result<f64> {
        sum_of_pairs(system, pairs, |pair| self.energy_kt(pair, None))
    }

    fn pairs(&self, _: &System) -> Vec<PairEnergy> {
        self.energies
            .pairs()
            .map(|(first, second, energy_kt)| PairEnergy::new(first, second, energy_kt))
            .collect()
    }

    fn change_protons(
        &mut self,
        system: &System,
        body: usize,
        partners: &[usize],
        rng: &mut CounterRng,
    ) -> Result<bool> {
        let Some(groups) = self.groups_of(system.type_index(body)).map(Arc::clone) else {
            return Ok(false);
        };
        let budget_kt = -rng.uniform().ln();
        let changed = protonation::propose(&self.states[body], rng);
        if changed.is_empty() {
            return Ok(false);
        }
        let mut states = self.states[body].clone();
        for group in &changed {
            states[*group] = !states[*group];
        }
        let mut rise_kt = groups.energy_kt(&states) - groups.energy_kt(&self.states[body]);
        // Linear in the charges: only those that change are summed.
        let change = groups.change(&changed, &states);
        let mut rises = Vec::with_capacity(partners.len());
        for &partner in partners {
            let pair = system.pair(body, partner);
            if let Some(rise) = self.energy_kt(&pair, Some((body, &change)))? {
                rise_kt += rise;
                rises.push((pair.first, pair.second, rise));
            }
        }
        if rise_kt >= budget_kt {
            return Ok(false);
        }
        for (first, second, rise) in rises {
            let old = self.energies.get(first, second).unwrap_or(0.0);
            self.energies.set(first, second, old + rise);
        }
        self.clouds[body] = groups.charges(&states);
        self.states[body] = states;
        Ok(true)
    }

    fn protonation(&self) -> &[Vec<bool>] {
        &self.states
    }

    fn take_protonation(&mut self, system: &System, states: &[Vec<bool>]) -> Result<()> {
        let groups = |body: usize| {
            self.groups_of(system.type_index(body))
                .map_or(0, |groups| groups.len())
        };
        let is_of_system = states.len() == system.len()
            && (0..system.len()).all(|body| states[body].len() == groups(body));
        if !is_of_system {
            let difference = "it has other titratable groups".into();
            return Err(McError::ForeignCheckpoint(difference));
        }
        self.states = states.to_vec();
        Ok(())
    }

    fn net_charges_e(&self) -> Option<Vec<f64>> {
        let charges = self.clouds.iter().map(ChargeCloud::net_charge_e);
        Some(charges.collect())
    }
}
