//! An energy by the distance of the centres, as a table.

use super::{
    PairForce, PairPotential, PosedPair, SmoothPotential, require_energy, require_length,
    require_rows,
};
use crate::error::{KernelError, Result, require};
use crate::spline::{Ends, Spline};

/// Straight lines between the rows of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Radial {
    distances: Vec<f64>,
    energies_kt: Vec<f64>,
}

impl Radial {
    pub(super) fn new(distances: &[f64], energies_kt: &[f64]) -> Result<Self> {
        check(distances, energies_kt)?;
        Ok(Self {
            distances: distances.to_vec(),
            energies_kt: energies_kt.to_vec(),
        })
    }

    /// Energy and slope at a distance.
    fn evaluate(&self, distance: f64) -> (f64, f64) {
        let above = self.distances.partition_point(|row| *row <= distance);
        match above {
            0 => (self.energies_kt[0], 0.0),
            all if all == self.distances.len() => (0.0, 0.0),
            row => {
                let [low, high] = [self.distances[row - 1], self.distances[row]];
                let [first, second] = [self.energies_kt[row - 1], self.energies_kt[row]];
                let slope = (second - first) / (high - low);
                (first + slope * (distance - low), slope)
            }
        }
    }
}

impl<const D: usize> PairPotential<D> for Radial {
    fn range(&self) -> f64 {
        self.distances[self.distances.len() - 1]
    }

    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        self.evaluate(pair.distance).0
    }

    fn virial_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        -pair.distance * self.evaluate(pair.distance).1
    }

    fn jumps(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// A cubic spline through the rows of a table: level at the last, a straight line before the first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SmoothRadial(Spline);

impl SmoothRadial {
    pub(super) fn new(distances: &[f64], energies_kt: &[f64]) -> Result<Self> {
        check(distances, energies_kt)?;
        Ok(Self(Spline::through(
            distances,
            energies_kt,
            Ends::LevelAtLast,
        )?))
    }

    fn end(&self) -> f64 {
        self.0.range()[1]
    }

    /// Energy and slope at a distance.
    fn evaluate(&self, distance: f64) -> [f64; 2] {
        if distance >= self.end() {
            return [0.0; 2];
        }
        let [energy, slope, _] = self.0.evaluate(distance);
        [energy, slope]
    }
}

impl<const D: usize> PairPotential<D> for SmoothRadial {
    fn range(&self) -> f64 {
        self.end()
    }

    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        self.evaluate(pair.distance)[0]
    }

    fn virial_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        -pair.distance * self.evaluate(pair.distance)[1]
    }

    fn jumps(&self) -> Vec<f64> {
        Vec::new()
    }
}

impl<const D: usize> SmoothPotential<D> for SmoothRadial {
    fn forces_kt(&self, pair: &PosedPair<'_, D>) -> PairForce<D> {
        let [energy_kt, slope] = self.evaluate(pair.distance);
        PairForce {
            energy_kt,
            force_kt_per_length: pair.offset.map(|x| slope * x / pair.distance),
            ..PairForce::zero()
        }
    }
}

/// Refuses a table that is none.
fn check(distances: &[f64], energies_kt: &[f64]) -> Result<()> {
    require_rows("the number of distances of a potential", distances.len())?;
    if distances.len() != energies_kt.len() {
        return Err(KernelError::OutOfRange {
            quantity: "the number of energies of a potential",
            value: energies_kt.len() as f64,
            requirement: "that of its distances",
        });
    }
    for (distance, energy) in distances.iter().zip(energies_kt) {
        require_length("a distance of a potential", *distance)?;
        require_energy("an energy of a potential (kT)", *energy)?;
    }
    for pair in distances.windows(2) {
        let rising = "above the one before";
        require(
            "a distance of a potential",
            pair[1],
            rising,
            pair[1] > pair[0],
        )?;
    }
    let last = energies_kt[energies_kt.len() - 1];
    require(
        "the last energy of a potential (kT)",
        last,
        "0, so that nothing jumps where the table ends",
        last == 0.0,
    )
}
