//! Potentials that act on each body.

pub use protomer_kernel::height_energy::HeightTable;

use crate::system::{System, Trial};
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// A potential that acts on each body, in kT.
pub(crate) trait Field<const D: usize> {
    /// Change of the energy by a move, kT.
    fn change_kt(&mut self, system: &System<D>, trial: &Trial<D>) -> f64;

    /// Notes that a move has been accepted: the one whose change was requested last.
    fn moved(&mut self, _trial: &Trial<D>) {}

    /// Whether the move is accepted (Metropolis, J. Chem. Phys. 21, 1087 (1953)).
    #[inline]
    fn allows(&mut self, system: &System<D>, trial: &Trial<D>, rng: &mut CounterRng) -> bool {
        let change = self.change_kt(system, trial);
        change <= 0.0 || rng.uniform() < (-change).exp()
    }
}

/// No potential.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nothing;

impl<const D: usize> Field<D> for Nothing {
    fn change_kt(&mut self, _: &System<D>, _: &Trial<D>) -> f64 {
        0.0
    }
}

/// A potential that grows with the height, the last coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gravity {
    /// Weight of a body in kT per length: m g/kT, the inverse of the gravitational length.
    pub weight_kt_per_length: f64,
}

impl<const D: usize> Field<D> for Gravity {
    fn change_kt(&mut self, system: &System<D>, trial: &Trial<D>) -> f64 {
        let rise = trial.position[D - 1] - system.positions[trial.body][D - 1];
        self.weight_kt_per_length * rise
    }
}

impl<const D: usize> Field<D> for HeightTable {
    fn change_kt(&mut self, system: &System<D>, trial: &Trial<D>) -> f64 {
        let before = system.positions[trial.body][D - 1];
        self.energy_kt(trial.position[D - 1]) - self.energy_kt(before)
    }
}

/// Two fields that add up.
pub(crate) struct Both<'a, A, B>(pub &'a mut A, pub &'a mut B);

impl<const D: usize, A: Field<D>, B: Field<D>> Field<D> for Both<'_, A, B> {
    fn change_kt(&mut self, system: &System<D>, trial: &Trial<D>) -> f64 {
        self.0.change_kt(system, trial) + self.1.change_kt(system, trial)
    }

    fn moved(&mut self, trial: &Trial<D>) {
        self.0.moved(trial);
        self.1.moved(trial);
    }
}
