//! Patches that attract each other where they face.

use super::square_well::SquareWell;
use super::{PairPotential, PosedPair, vectors};
use crate::Rotation;
use crate::error::{Result, require};
use crate::shape::separation::{dot, matrix};

/// A well for pairs each of which has a patch that faces the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Patches<const D: usize> {
    well: SquareWell,
    /// Cosine of the angle between the middle of a patch and its rim.
    cosine: f64,
    /// Unit vectors to the middles of the patches.
    directions: Vec<[f64; D]>,
}

impl<const D: usize> Patches<D> {
    pub(super) fn new(
        well: SquareWell,
        half_angle_degrees: f64,
        directions: &[Vec<f64>],
    ) -> Result<Self> {
        let holds = half_angle_degrees > 0.0 && half_angle_degrees <= 180.0;
        require(
            "the half angle of a patch (degrees)",
            half_angle_degrees,
            "above 0 and at most 180",
            holds,
        )?;
        let mut directions = vectors::<D>(directions)?;
        for direction in &mut directions {
            let length = dot(direction, direction).sqrt();
            require(
                "the length of the direction of a patch",
                length,
                "above 0",
                length > 0.0,
            )?;
            *direction = direction.map(|x| x / length);
        }
        Ok(Self {
            well,
            cosine: half_angle_degrees.to_radians().cos(),
            directions,
        })
    }

    /// Whether a patch of a body covers a direction from its centre, a unit vector.
    fn faces(&self, rotation: &Rotation, direction: &[f64; D]) -> bool {
        let matrix = matrix::<D>(rotation);
        // Into the body's frame, by the transposed matrix: once for all patches.
        let own: [f64; D] = std::array::from_fn(|column| {
            (0..D).map(|row| matrix[row][column] * direction[row]).sum()
        });
        self.directions
            .iter()
            .any(|patch| dot(patch, &own) >= self.cosine)
    }
}

impl<const D: usize> PairPotential<D> for Patches<D> {
    fn range(&self) -> f64 {
        self.well.range
    }

    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        if pair.distance >= self.well.range {
            return 0.0;
        }
        let forward = pair.offset.map(|x| x / pair.distance);
        let backward = forward.map(|x| -x);
        let [first, second] = pair.rotations;
        match self.faces(first, &forward) && self.faces(second, &backward) {
            true => -self.well.depth_kt,
            false => 0.0,
        }
    }

    fn virial_kt(&self, _: &PosedPair<'_, D>) -> f64 {
        0.0
    }

    fn jumps(&self) -> Vec<f64> {
        vec![self.well.range]
    }

    fn is_directed(&self) -> bool {
        true
    }
}
