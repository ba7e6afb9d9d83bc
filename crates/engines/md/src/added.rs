//! Energies in addition to the contacts: of each pair by the places and orientations of both, and of each body by its height.
//!
//! The definitions are those that Monte Carlo has, [`pair_energy`](protomer_kernel::pair_energy) and
//! [`height_energy`](protomer_kernel::height_energy), with energies in kT of a temperature that is given. Heights are counted
//! from the lower end of the box along the last axis. Distances are those of the centres, and sites are in the frame of the
//! shape, from its centre of mass.

use crate::bath::require;
use crate::body::Kind;
use crate::near::Felt;
use crate::neighbours::Pair;
use crate::state::{Bodies, State};
use crate::{Error, Result};
use protomer_kernel::height_energy::{HeightCurve, HeightTable};
use protomer_kernel::pair_energy::{PosedPair, SmoothSum, Term};
use protomer_kernel::{Boundary, Rotation, Vec3};
use std::sync::Arc;

/// Part of the length of a box by which a table of heights may reach beyond it, for rounding.
const ROUNDING: f64 = 1e-9;

/// Energies of pairs and of heights. The default has neither.
///
/// ```
/// use protomer_kernel::pair_energy::Term;
/// use protomer_md::added::Added;
/// let terms = [Term::Radial { distances: vec![1.0, 2.0], energies_kt: vec![0.5, 0.0], curve: None }];
/// let added = Added::new(&terms, None, 3, 1.0)?;
/// assert_eq!((added.range(), Added::default().range()), (2.0, 0.0));
/// let well = [Term::SquareWell { range: 1.5, depth_kt: 1.0 }];
/// assert!(Added::new(&well, None, 3, 1.0).is_err(), "its force is infinite at the range");
/// # Ok::<(), protomer_md::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Added {
    pub(crate) pairs: Option<PairEnergy>,
    pub(crate) heights: Option<HeightEnergy>,
}

impl Added {
    /// The energies of these terms and of a table of heights, in kT of this temperature, of bodies in a plane (dimension 2) or
    /// in space (3).
    ///
    /// # Errors
    /// [`Error::Energy`] for terms without a force, and for numbers that cannot be; [`Error::OutOfRange`] for the temperature.
    pub fn new(
        terms: &[Term],
        heights: Option<&HeightTable>,
        dimension: usize,
        temperature: f64,
    ) -> Result<Self> {
        require("the temperature", temperature)?;
        let terms = match (terms, dimension) {
            ([], _) => None,
            (terms, 2) => Some(SumOfTerms::Flat(Arc::new(SmoothSum::new(terms)?))),
            (terms, _) => Some(SumOfTerms::Solid(Arc::new(SmoothSum::new(terms)?))),
        };
        let curve = heights.map(HeightCurve::through).transpose()?;
        Ok(Self {
            pairs: terms.map(|terms| PairEnergy { terms, temperature }),
            heights: curve.map(|curve| HeightEnergy { curve, temperature }),
        })
    }

    /// Largest distance of the centres of two bodies with an energy; zero for none.
    pub fn range(&self) -> f64 {
        self.pairs.as_ref().map_or(0.0, PairEnergy::range)
    }

    /// The energies of a state, whose pairs within the range are these.
    pub(crate) fn energies(&self, bodies: &Bodies, state: &State, pairs: &[Pair]) -> AddedEnergies {
        let of_pairs = |energy: &PairEnergy| energy.sum(bodies, state, pairs);
        let of_heights = |energy: &HeightEnergy| energy.sum(state, bodies.dimension());
        AddedEnergies {
            pairs: self.pairs.as_ref().map(of_pairs),
            heights: self.heights.as_ref().map(of_heights),
        }
    }

    /// Refuses bodies that cannot turn as the energies would turn them, and a box that is too short for the table of heights.
    ///
    /// # Errors
    /// [`Error::BallWithSites`]; [`Error::TableBeyondBox`]; [`Error::NoBox`] for heights without a box.
    pub fn check(&self, bodies: &Bodies, state: &State) -> Result<()> {
        let is_directed = self.pairs.as_ref().is_some_and(PairEnergy::is_directed);
        if is_directed && bodies.kinds.iter().any(Kind::is_ball) {
            return Err(Error::BallWithSites);
        }
        let dimension = bodies.dimension();
        let Some(heights) = &self.heights else {
            return Ok(());
        };
        let length = box_length(state, dimension).ok_or(Error::NoBox)?;
        let [first, last] = heights.curve.range();
        if first < -ROUNDING * length || last > length * (1.0 + ROUNDING) {
            return Err(Error::TableBeyondBox {
                first,
                last,
                length,
            });
        }
        Ok(())
    }
}

/// Energies of all bodies in addition to their contacts; none for what they do not have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AddedEnergies {
    /// Energy of all pairs.
    pub pairs: Option<f64>,
    /// Energy of all heights.
    pub heights: Option<f64>,
}

/// Energy of each pair.
#[derive(Debug, Clone)]
pub(crate) struct PairEnergy {
    terms: SumOfTerms,
    temperature: f64,
}

#[derive(Debug, Clone)]
enum SumOfTerms {
    Flat(Arc<SmoothSum<2>>),
    Solid(Arc<SmoothSum<3>>),
}

impl PairEnergy {
    fn range(&self) -> f64 {
        match &self.terms {
            SumOfTerms::Flat(sum) => sum.range(),
            SumOfTerms::Solid(sum) => sum.range(),
        }
    }

    fn is_directed(&self) -> bool {
        match &self.terms {
            SumOfTerms::Flat(sum) => sum.is_directed(),
            SumOfTerms::Solid(sum) => sum.is_directed(),
        }
    }

    /// Turns from the frames of the shapes into space; none where no energy depends on them.
    pub(crate) fn turns(&self, bodies: &Bodies, state: &State, turns: &mut Vec<Rotation>) {
        turns.clear();
        if self.is_directed() {
            turns.extend(
                (0..bodies.count()).map(|body| state.rotation(body) * bodies.kind(body).frame),
            );
        }
    }

    /// Energy of all pairs.
    fn sum(&self, bodies: &Bodies, state: &State, pairs: &[Pair]) -> f64 {
        let mut turns = Vec::new();
        self.turns(bodies, state, &mut turns);
        let mut felt = Felt::nothing();
        for pair in pairs.iter().filter(|pair| pair.parts == [0, 0]) {
            let [first, second] = pair.bodies.map(|body| turns.get(body as usize));
            self.add(
                &mut felt,
                &pair.between(state),
                first.zip(second).map(<[_; 2]>::from),
            );
        }
        felt.energy
    }

    /// Adds the energy, force and torques of two bodies. The turns are those of both, if the energy depends on them.
    pub(crate) fn add(&self, felt: &mut Felt, between: &Vec3, turns: Option<[&Rotation; 2]>) {
        let identity = Rotation::identity();
        let turns = turns.unwrap_or([&identity, &identity]);
        let (energy_kt, force, torques) = match &self.terms {
            SumOfTerms::Flat(sum) => {
                let pair = PosedPair::new([between.x, between.y], turns);
                if pair.distance >= sum.range() {
                    return;
                }
                let added = sum.forces_kt(&pair);
                let [x, y] = added.force_kt_per_length;
                (added.energy_kt, Vec3::new(x, y, 0.0), added.torques_kt)
            }
            SumOfTerms::Solid(sum) => {
                let pair = PosedPair::new((*between).into(), turns);
                if pair.distance >= sum.range() {
                    return;
                }
                let added = sum.forces_kt(&pair);
                let force = Vec3::from(added.force_kt_per_length);
                (added.energy_kt, force, added.torques_kt)
            }
        };
        felt.energy += self.temperature * energy_kt;
        felt.force += self.temperature * force;
        for (sum, torque) in felt.torques.iter_mut().zip(torques) {
            *sum += self.temperature * torque;
        }
    }
}

/// Energy of each body by its height.
#[derive(Debug, Clone)]
pub(crate) struct HeightEnergy {
    curve: HeightCurve,
    temperature: f64,
}

impl HeightEnergy {
    /// Adds the forces on all bodies; returns their energy.
    pub(crate) fn add(&self, state: &State, dimension: usize, forces: &mut [Vec3]) -> f64 {
        let axis = dimension - 1;
        let length = box_length(state, dimension).unwrap_or(f64::INFINITY);
        let mut energy = 0.0;
        for (position, force) in state.positions.iter().zip(forces) {
            let [of_body, slope] = self.curve.evaluate(height(position[axis], length));
            energy += self.temperature * of_body;
            force[axis] -= self.temperature * slope;
        }
        energy
    }

    /// Energy of all bodies.
    fn sum(&self, state: &State, dimension: usize) -> f64 {
        let axis = dimension - 1;
        let length = box_length(state, dimension).unwrap_or(f64::INFINITY);
        let energy_kt = |position: &Vec3| {
            let [energy_kt, _] = self.curve.evaluate(height(position[axis], length));
            energy_kt
        };
        self.temperature * state.positions.iter().map(energy_kt).sum::<f64>()
    }
}

/// Height over the lower end of a box about the origin, of any image.
fn height(coordinate: f64, length: f64) -> f64 {
    (coordinate + 0.5 * length).rem_euclid(length)
}

/// Length of the box along the last axis; none in open space.
fn box_length(state: &State, dimension: usize) -> Option<f64> {
    match state.space {
        Boundary::Periodic { lengths_angstrom } => Some(lengths_angstrom[dimension - 1]),
        Boundary::Open | Boundary::SphereWall { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::height;

    #[test]
    fn heights_are_those_of_any_image() {
        for image in [-20.0, 0.0, 10.0] {
            assert!((height(1.5 + image, 10.0) - 6.5).abs() < 1e-12);
        }
        assert_eq!(height(-5.0, 10.0), 0.0);
    }
}
