//! A well of one depth.

use super::{PairPotential, PosedPair, require_energy, require_length};
use crate::error::Result;

/// The same energy for all pairs whose centres are closer than a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SquareWell {
    pub(super) range: f64,
    pub(super) depth_kt: f64,
}

impl SquareWell {
    pub(super) fn new(range: f64, depth_kt: f64) -> Result<Self> {
        require_length("the range of a potential", range)?;
        require_energy("the depth of a potential (kT)", depth_kt)?;
        Ok(Self { range, depth_kt })
    }
}

impl<const D: usize> PairPotential<D> for SquareWell {
    fn range(&self) -> f64 {
        self.range
    }

    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        match pair.distance < self.range {
            true => -self.depth_kt,
            false => 0.0,
        }
    }

    fn virial_kt(&self, _: &PosedPair<'_, D>) -> f64 {
        0.0
    }

    fn jumps(&self) -> Vec<f64> {
        vec![self.range]
    }
}
