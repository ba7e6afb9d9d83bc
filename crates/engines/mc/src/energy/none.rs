//! Bodies without charges.

use super::{Effort, EnergyModel, PairEnergy, Pairs};
use crate::Result;
use crate::system::{System, Trial};

/// Hard bodies and nothing else: every move that overlaps nobody is accepted.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoCharges;

impl EnergyModel for NoCharges {
    fn range_angstrom(&self, _: &System) -> f64 {
        0.0
    }

    fn reset(&mut self, _: &System) -> Result<()> {
        Ok(())
    }

    fn restore(&mut self, _: &System, _: &[PairEnergy]) -> Result<()> {
        Ok(())
    }

    fn accept(&mut self, _: &Trial<'_>, _: &[usize], budget_kt: f64) -> Result<bool> {
        Ok(budget_kt >= 0.0)
    }

    fn exceeds(&mut self, _: &Trial<'_>, _: usize, threshold_kt: f64) -> Result<bool> {
        Ok(threshold_kt < 0.0)
    }

    fn commit(&mut self, _: &[usize]) {}

    fn reject(&mut self) {}

    fn energy_elsewhere_kt(&self, _: &System, _: Pairs<'_>, _: Effort) -> Result<f64> {
        Ok(0.0)
    }

    fn pairs(&self, _: &System) -> Vec<PairEnergy> {
        Vec::new()
    }
}
