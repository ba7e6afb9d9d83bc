//! The plain sum over all pairs of charges.

use super::{EnergyModel, PairEnergy, all_pairs, finite, yukawa_energy_kt};
use crate::Result;
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use protomer_kernel::potential::Yukawa;

/// The direct sum in double precision, each pair of bodies computed once per state.
#[derive(Debug, Clone)]
pub struct DirectSum {
    yukawa: Yukawa,
    energies: PairTable<f64>,
    proposed: Vec<PairEnergy>,
}

impl DirectSum {
    /// The direct sum of this potential.
    pub fn new(yukawa: Yukawa) -> Self {
        Self {
            yukawa,
            energies: PairTable::new(0),
            proposed: Vec::new(),
        }
    }

    /// The energy of one pair of bodies, kT; `None` beyond the range of their charges.
    fn pair_energy(&self, pair: &Pair<'_>) -> Result<Option<f64>> {
        let (first, second) = pair.types();
        let reach = first.charge_radius_angstrom()
            + second.charge_radius_angstrom()
            + self.yukawa.cutoff_angstrom;
        if first.charges.is_empty()
            || second.charges.is_empty()
            || pair.displacement.norm_squared() >= reach * reach
        {
            return Ok(None);
        }
        let energy = yukawa_energy_kt(
            &self.yukawa,
            &first.charges,
            &second.charges,
            &pair.relative(),
        );
        finite(pair.first, pair.second, energy).map(Some)
    }

    fn propose(&mut self, pair: &Pair<'_>) -> Result<f64> {
        let Some(energy_kt) = self.pair_energy(pair)? else {
            return Ok(0.0);
        };
        self.proposed
            .push(PairEnergy::new(pair.first, pair.second, energy_kt));
        Ok(energy_kt)
    }
}

impl EnergyModel for DirectSum {
    fn range_angstrom(&self, system: &System) -> f64 {
        let mut range = 0.0_f64;
        for kind in system.placed_types() {
            if !kind.charges.is_empty() {
                let reach = 2.0 * kind.charge_radius_angstrom();
                range = range.max(reach + self.yukawa.cutoff_angstrom);
            }
        }
        range
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.proposed.clear();
        self.energies = all_pairs(system, |pair| self.pair_energy(pair))?;
        Ok(())
    }

    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.proposed.clear();
        self.energies = PairTable::new(system.len());
        for pair in pairs {
            self.energies.set(
                pair.first,
                pair.second,
                finite(pair.first, pair.second, pair.energy_kt)?,
            );
        }
        Ok(())
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        let old: f64 = self
            .energies
            .row(trial.body)
            .map(|(_, energy)| energy)
            .sum();
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

    fn commit(&mut self, moved: &[usize]) {
        let proposed = self
            .proposed
            .drain(..)
            .map(|pair| (pair.first, pair.second, pair.energy_kt));
        self.energies.take_over(moved, proposed);
    }

    fn reject(&mut self) {
        self.proposed.clear();
    }

    fn pairs(&self) -> Vec<PairEnergy> {
        self.energies
            .pairs()
            .map(|(first, second, energy_kt)| PairEnergy::new(first, second, energy_kt))
            .collect()
    }
}
