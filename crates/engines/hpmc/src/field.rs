//! Potentials that act on each body.

use crate::system::{System, Trial};
use crate::{Result, error::require};
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// Largest energy of a field, kT.
const LARGEST_ENERGY_KT: f64 = 1e6;

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

/// An energy of each body by its last coordinate: straight lines between the rows of a table.
///
/// ```
/// use protomer_hpmc::field::HeightTable;
/// let valley = HeightTable { heights: vec![0.0, 1.0, 2.0], energies_kt: vec![4.0, 0.0, 4.0] };
/// assert!(valley.check().is_ok());
/// assert_eq!((valley.energy_kt(0.5), valley.energy_kt(3.0)), (2.0, 4.0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeightTable {
    /// Heights over the lower end of the last axis, rising, in the unit of the shape.
    pub heights: Vec<f64>,
    /// Energies at these heights, kT. Beyond the table its ends hold.
    pub energies_kt: Vec<f64>,
}

impl HeightTable {
    /// Checks the numbers.
    ///
    /// ```
    /// use protomer_hpmc::field::HeightTable;
    /// let falling = HeightTable { heights: vec![1.0, 0.0], energies_kt: vec![0.0, 0.0] };
    /// assert!(falling.check().is_err(), "heights rise");
    /// ```
    ///
    /// # Errors
    /// Names the number that cannot be.
    pub fn check(&self) -> Result<()> {
        let (rows, energies) = (self.heights.len(), self.energies_kt.len());
        let count = (1..=100_000).contains(&rows);
        require(
            "the number of heights of a field",
            rows as f64,
            "from 1 to 100000",
            count,
        )?;
        require(
            "the number of energies of a field",
            energies as f64,
            "that of its heights",
            rows == energies,
        )?;
        for energy in &self.energies_kt {
            let holds = energy.abs() <= LARGEST_ENERGY_KT;
            require(
                "an energy of a field (kT)",
                *energy,
                "from -1e6 to 1e6",
                holds,
            )?;
        }
        for pair in self.heights.windows(2) {
            let is_rising = pair[1] > pair[0];
            require(
                "a height of a field",
                pair[1],
                "above the one before",
                is_rising,
            )?;
        }
        let first = self.heights[0];
        require(
            "a height of a field",
            first,
            "a finite number",
            first.is_finite(),
        )
    }

    /// Energy at a height, kT.
    ///
    /// ```
    /// use protomer_hpmc::field::HeightTable;
    /// let slope = HeightTable { heights: vec![1.0, 3.0], energies_kt: vec![0.0, 4.0] };
    /// assert_eq!([0.0, 2.0, 9.0].map(|height| slope.energy_kt(height)), [0.0, 2.0, 4.0]);
    /// ```
    pub fn energy_kt(&self, height: f64) -> f64 {
        let above = self.heights.partition_point(|row| *row <= height);
        match above {
            0 => self.energies_kt[0],
            all if all == self.heights.len() => self.energies_kt[all - 1],
            row => {
                let [low, high] = [self.heights[row - 1], self.heights[row]];
                let [first, second] = [self.energies_kt[row - 1], self.energies_kt[row]];
                first + (second - first) * (height - low) / (high - low)
            }
        }
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
