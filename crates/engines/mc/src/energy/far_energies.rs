//! A bound of what two bodies hold, looked up by their distance.

use super::FarField;
use crate::system::System;
use protomer_kernel::potential::Yukawa;

/// The most that bodies of two types can hold, by the distance of their origins.
#[derive(Debug, Clone, Default)]
pub(crate) struct FarEnergies {
    types: usize,
    by_types: Vec<Vec<f64>>,
}

impl FarEnergies {
    /// Step between distances of the table; between two of them the value at the smaller one holds.
    const STEP_ANGSTROM: f64 = 1.0;
    /// Largest number of steps; beyond the end of the table its last value holds.
    const MOST_STEPS: f64 = 4096.0;

    /// The table out to the reach.
    pub fn new(system: &System, potential: &Yukawa, reach_angstrom: f64) -> Self {
        let types = system.types().iter();
        let fields: Vec<_> = types
            .map(|body_type| FarField::new(&body_type.charges, potential))
            .collect();
        let steps = (reach_angstrom / Self::STEP_ANGSTROM).min(Self::MOST_STEPS) as usize;
        let distances: Vec<f64> = (0..=steps)
            .map(|step| step as f64 * Self::STEP_ANGSTROM)
            .collect();
        let mut by_types = Vec::with_capacity(fields.len() * fields.len());
        for first in &fields {
            for second in &fields {
                let largest_energy_kt = first.largest_energy_kt(second, potential);
                let energies = distances
                    .iter()
                    .map(|distance| largest_energy_kt(*distance));
                by_types.push(energies.collect());
            }
        }
        Self {
            types: fields.len(),
            by_types,
        }
    }

    /// The most that bodies of these types can hold at this distance, kT; infinite where nothing is
    /// known.
    #[inline]
    pub fn energy(&self, (first, second): (usize, usize), distance_angstrom: f64) -> f64 {
        let energies = &self.by_types[first * self.types + second];
        let step = (distance_angstrom / Self::STEP_ANGSTROM) as usize;
        energies
            .get(step)
            .or(energies.last())
            .copied()
            .unwrap_or(f64::INFINITY)
    }
}
