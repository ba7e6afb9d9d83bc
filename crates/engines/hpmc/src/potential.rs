//! Energies of pairs of bodies in a system, in addition to their hardness.
//!
//! The potentials are those of [`pair_energy`](protomer_kernel::pair_energy). With all distances scaled, an energy that is
//! continuous adds -r du/dr to the virial of a pair. Where it jumps, pairs that would cross the jump count instead, by
//! 1 - exp(-Δu): see [`compression`](crate::compression).

pub use protomer_kernel::pair_energy::{PairPotential, PosedPair, Sum, Term};

use crate::system::System;
use crate::system::Trial;
use protomer_kernel::Rotation;
use protomer_kernel::random::CounterRng;

impl<const D: usize> System<D> {
    /// Energy of a body with all others, kT; zero without a potential.
    pub(crate) fn energy_with_others(&self, trial: &Trial<D>) -> f64 {
        let Some(potential) = &self.potential else {
            return 0.0;
        };
        let range = potential.range();
        let mut energy = 0.0;
        self.grid
            .any_near(&trial.position, range * range, trial.body as u32, |near| {
                let rotations = [&trial.rotation, &self.rotations[near.body as usize]];
                energy += potential.energy_kt(&PosedPair::new(near.offset, rotations));
                false
            });
        energy
    }

    /// Energy of two bodies at all of their images, kT.
    pub(crate) fn energy_of_pair(&self, first: usize, second: usize) -> f64 {
        let Some(potential) = &self.potential else {
            return 0.0;
        };
        let range = potential.range();
        let mut energy = 0.0;
        self.grid.any_near(
            &self.positions[first],
            range * range,
            first as u32,
            |near| {
                if near.body as usize == second {
                    let rotations = [&self.rotations[first], &self.rotations[second]];
                    energy += potential.energy_kt(&PosedPair::new(near.offset, rotations));
                }
                false
            },
        );
        energy
    }

    /// Energy that one more body would have with all others, kT.
    pub(crate) fn energy_of_inserted(&self, position: [f64; D], rotation: &Rotation) -> f64 {
        self.energy_with_others(&Trial {
            // A number that no body has, so that none is left out.
            body: u32::MAX as usize,
            position,
            rotation: *rotation,
            is_turned: false,
        })
    }

    /// Energy of all pairs, kT.
    pub fn potential_energy_kt(&self) -> f64 {
        if self.potential.is_none() {
            return 0.0;
        }
        // Each pair is met from both sides.
        let of_body = |body| self.energy_with_others(&self.where_it_is(body));
        0.5 * (0..self.len()).map(of_body).sum::<f64>()
    }

    /// Whether the potential allows a move of a body that overlaps none (Metropolis).
    pub(crate) fn potential_allows(&self, trial: &Trial<D>, rng: &mut CounterRng) -> bool {
        if self.potential.is_none() {
            return true;
        }
        let before = self.energy_with_others(&self.where_it_is(trial.body));
        let change = self.energy_with_others(trial) - before;
        change <= 0.0 || rng.uniform() < (-change).exp()
    }
}
