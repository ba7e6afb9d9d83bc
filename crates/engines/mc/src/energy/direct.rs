//! The plain sum over all pairs of charges.

use super::reach::{Reach, require_room};
use super::regulated::Protons;
use super::{
    Effort, EnergyModel, PairEnergy, Pairs, all_pairs, finite, pair_energy_kt, require_fixed,
    sum_of_pairs,
};
use crate::Result;
use crate::charges::ChargeCloud;
use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::titratable::TitratableCharges;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use std::sync::Arc;

/// The direct sum in double precision over all images that count, each pair of bodies computed once
/// per state.
#[derive(Debug, Clone)]
pub struct DirectSum {
    potential: Yukawa,
    reach: Reach,
    energies: PairTable<f64>,
    proposed: Vec<PairEnergy>,
    /// Protons of the bodies, if their charges respond to each other.
    protons: Option<Protons>,
}

impl DirectSum {
    /// The direct sum of this potential.
    pub fn new(potential: Yukawa) -> Self {
        Self {
            potential,
            reach: Reach::default(),
            energies: PairTable::new(0),
            proposed: Vec::new(),
            protons: None,
        }
    }

    /// The direct sum for bodies that take up and lose protons at constant pH. `groups` holds the titratable groups of each
    /// type of body, `None` for a type whose charges are fixed.
    ///
    /// Energies of pairs are those of the present charges; a change of protons adds the sum over the few charges that
    /// change.
    pub fn regulated(potential: Yukawa, groups: Vec<Option<Arc<TitratableCharges>>>) -> Self {
        Self {
            protons: Some(Protons::new(groups)),
            ..Self::new(potential)
        }
    }

    fn reach_in(&self, system: &System) -> Reach {
        match &self.protons {
            Some(protons) => Reach::by_charges(system, &self.potential, |kind| {
                protons.strongest(system, kind)
            }),
            None => Reach::new(system, &self.potential),
        }
    }

    fn prepare(&mut self, system: &System) {
        self.reach = self.reach_in(system);
        self.proposed.clear();
        if let Some(protons) = &mut self.protons {
            protons.prepare(system);
        }
    }

    fn energy_kt(&self, pair: &Pair<'_>) -> Result<Option<f64>> {
        match &self.protons {
            Some(protons) => {
                let charges = [pair.first, pair.second].map(|body| protons.charges(body));
                sum_over_images_kt(&self.potential, &self.reach, pair, charges)
            }
            None => direct_energy_kt(&self.potential, &self.reach, pair),
        }
    }

    fn propose(&mut self, pair: &Pair<'_>) -> Result<f64> {
        let Some(energy_kt) = self.energy_kt(pair)? else {
            return Ok(0.0);
        };
        // Kept until the move is decided: an accepted one needs no second sum.
        self.proposed
            .push(PairEnergy::new(pair.first, pair.second, energy_kt));
        Ok(energy_kt)
    }
}

/// The energy of two bodies with all images that count, kT; `None` if none does.
pub(super) fn direct_energy_kt(
    potential: &Yukawa,
    reach: &Reach,
    pair: &Pair<'_>,
) -> Result<Option<f64>> {
    let (first, second) = pair.types();
    sum_over_images_kt(potential, reach, pair, [&first.charges, &second.charges])
}

/// The same for these charges of the first and the second body.
fn sum_over_images_kt(
    potential: &Yukawa,
    reach: &Reach,
    pair: &Pair<'_>,
    [first, second]: [&ChargeCloud; 2],
) -> Result<Option<f64>> {
    // `None` and zero differ: a pair without images is not listed, one that holds nothing is.
    let mut energy_kt = None;
    for displacement in reach.images(pair) {
        let relative = pair.relative_image(&displacement);
        let image = pair_energy_kt(potential, first, second, &relative);
        *energy_kt.get_or_insert(0.0) += image;
    }
    let checked = |energy_kt| finite(pair.first, pair.second, energy_kt);
    energy_kt.map(checked).transpose()
}

impl EnergyModel for DirectSum {
    fn range_angstrom(&self, system: &System) -> f64 {
        self.reach_in(system).largest_angstrom()
    }

    fn require_room(&self, system: &System) -> Result<()> {
        require_room(system, &self.potential)
    }

    /// Keeps the protons of the bodies.
    fn reset(&mut self, system: &System) -> Result<()> {
        self.prepare(system);
        self.energies = all_pairs(system, |pair| self.energy_kt(pair))?;
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
        // From the table, not summed again; partners left behind are in the row too.
        let old: f64 = energies.map(|(_, energy)| energy).sum();
        let mut new = 0.0;
        for &partner in partners {
            new += self.propose(&trial.pair(partner))?;
        }
        // Strictly below: with a budget of -ln u it is u < exp(-ΔU).
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
        sum_of_pairs(system, pairs, |pair| self.energy_kt(pair))
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
        let Some(protons) = &mut self.protons else {
            return Ok(false);
        };
        let Some(change) = protons.propose(system.type_index(body), body, rng) else {
            return Ok(false);
        };
        let mut rise_kt = change.own_kt;
        // Linear in the charges: only those that change are summed.
        let mut rises = Vec::with_capacity(partners.len());
        for &partner in partners {
            let pair = system.pair(body, partner);
            let charges = [pair.first, pair.second].map(|other| match other == body {
                true => &change.charges,
                false => protons.charges(other),
            });
            if let Some(rise) = sum_over_images_kt(&self.potential, &self.reach, &pair, charges)? {
                rise_kt += rise;
                rises.push((pair.first, pair.second, rise));
            }
        }
        if rise_kt >= change.budget_kt {
            return Ok(false);
        }
        for (first, second, rise) in rises {
            let old = self.energies.get(first, second).unwrap_or(0.0);
            self.energies.set(first, second, old + rise);
        }
        protons.take(system.type_index(body), body, change.states);
        Ok(true)
    }

    fn protonation(&self) -> &[Vec<bool>] {
        self.protons.as_ref().map_or(&[], Protons::states)
    }

    fn take_protonation(&mut self, system: &System, states: &[Vec<bool>]) -> Result<()> {
        match &mut self.protons {
            Some(protons) => protons.take_all(system, states),
            None => require_fixed(states),
        }
    }

    fn net_charges_e(&self) -> Option<Vec<f64>> {
        self.protons.as_ref().map(Protons::net_charges_e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::tetrahedron;
    use crate::{BodyType, McError};
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Boundary, Pose, Vec3};
    use std::sync::Arc;

    /// Two small bodies of net charge 3 and -1 in a box of this edge.
    fn system(edge: f64, rng: &mut CounterRng) -> System {
        let mesh = tetrahedron(1.0);
        let mut kind = |net: f64| {
            let mut charge = |_| {
                (
                    rng.vector_in_ball(0.8),
                    net / 6.0 + rng.uniform_in(-0.5, 0.5),
                )
            };
            let charges: Vec<(Vec3, f64)> = (0..6).map(&mut charge).collect();
            Arc::new(BodyType::new("body", &mesh, &charges).unwrap())
        };
        let kinds = vec![kind(3.0), kind(-1.0)];
        let mut pose = |x: f64| Pose {
            position: Vec3::new(x, 0.2 * edge, 0.0),
            rotation: rng.rotation(),
        };
        let bodies = [(0, pose(-0.2 * edge)), (1, pose(0.25 * edge))];
        System::new(
            kinds,
            &bodies,
            Boundary::periodic(Vec3::repeat(edge)).unwrap(),
        )
        .unwrap()
    }

    /// The plain sum over the images in a cube of 2 · 9 + 1 boxes.
    fn plain_sum(system: &System, yukawa: &Yukawa, edge: f64) -> f64 {
        let (first, second) = (system.pose(0), system.pose(1));
        let mut energy = 0.0;
        for cell in 0..19_i32.pow(3) {
            let cell = [cell % 19, cell / 19 % 19, cell / 361].map(|n| f64::from(n - 9) * edge);
            for (site, charge) in system.body_type(0).charges.iter() {
                for (place, other) in system.body_type(1).charges.iter() {
                    let place = second.transform_point(&place) + Vec3::from(cell);
                    let distance = (place - first.transform_point(&site)).norm();
                    energy += charge * other * yukawa.energy_kt(distance);
                }
            }
        }
        energy
    }

    #[test]
    fn images_are_summed_as_a_plain_sum_finds_them() {
        let mut rng = CounterRng::new(61, 0, 0);
        for (edge, debye) in [(20.0, 3.0), (30.0, 3.0), (25.0, 2.0), (60.0, 9.6)] {
            let system = system(edge, &mut rng);
            let yukawa = Yukawa::uncut(7.0, 1.0 / debye).unwrap();
            let mut model = DirectSum::new(yukawa);
            model.require_room(&system).unwrap();
            model.reset(&system).unwrap();
            let expected = plain_sum(&system, &yukawa, edge);
            let difference = (model.total_kt(&system) - expected).abs();
            assert!(
                difference < 1e-6,
                "{edge} {debye}: {difference:e} of {expected}"
            );
            assert!(expected.abs() > 1e-3);
        }
    }

    #[test]
    fn boxes_that_do_not_suit_the_interaction_are_refused() {
        let system = system(20.0, &mut CounterRng::new(62, 0, 0));
        let refusal = |yukawa: Yukawa| DirectSum::new(yukawa).require_room(&system).unwrap_err();
        let unscreened = refusal(Yukawa::uncut(7.0, 0.0).unwrap());
        assert_eq!(unscreened, McError::UnscreenedInBox);
        let far = refusal(Yukawa::uncut(7.0, 0.02).unwrap()).to_string();
        assert!(far.contains("every box length"), "{far}");
        let cut = refusal(Yukawa::new(7.0, 0.1, 15.0).unwrap()).to_string();
        assert!(cut.contains("at least"), "{cut}");
    }
}
