//! Energies of pairs of bodies, in addition to their hardness.
//!
//! A [`PairPotential`] gives the energy of two bodies by the vector between their centres and their orientations. Its
//! [`Term`]s are what a file says; several of them add up. Lengths are in the unit of the shape, energies in kT.
//!
//! | kind | energy of a pair at the distance r |
//! |---|---|
//! | `square-well` | -depth for r below the range |
//! | `radial` | straight lines between the rows of a table |
//! | `patches` | -depth for r below the range, if each body has a patch that faces the other (Kern and Frenkel, J. Chem. Phys. 118, 9882 (2003)) |
//! | `charges` | screened charges on sites of the bodies: Σ l_B q q' exp(-s/λ)/s over the distances s of sites, less its value at the cut-off |
//!
//! **Pressure.** With all distances scaled, an energy that is continuous adds -r du/dr to the virial of a pair. Where it
//! jumps, pairs that would cross the jump count instead, by 1 - exp(-Δu): see [`compression`](crate::compression).

mod charges;
mod patches;
mod radial;
mod square_well;
mod sum;

pub use sum::Sum;

use crate::system::System;
use crate::system::Trial;
use crate::{Error, Result, error::require};
use protomer_kernel::Rotation;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::dot;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

/// Largest number of sites, patches and rows of a term.
const MOST_ROWS: usize = 10_000;

/// Requirement on the length of a vector, by the number of dimensions.
const COORDINATES: [&str; 3] = ["1, on a line", "2, in a plane", "3, in space"];

/// Two bodies as a potential sees them.
#[derive(Debug, Clone, Copy)]
pub struct PosedPair<'a, const D: usize> {
    /// Vector from the centre of the first body to that of the second.
    pub offset: [f64; D],
    /// Length of the offset.
    pub distance: f64,
    /// Orientations.
    pub rotations: [&'a Rotation; 2],
}

impl<'a, const D: usize> PosedPair<'a, D> {
    /// A pair of bodies.
    pub fn new(offset: [f64; D], rotations: [&'a Rotation; 2]) -> Self {
        Self {
            offset,
            distance: dot(&offset, &offset).sqrt(),
            rotations,
        }
    }

    /// The pair at another distance along the same line.
    #[must_use]
    pub fn at_distance(&self, distance: f64) -> Self {
        let factor = distance / self.distance;
        Self {
            offset: self.offset.map(|x| x * factor),
            distance,
            rotations: self.rotations,
        }
    }
}

/// Energy of a pair of bodies.
pub trait PairPotential<const D: usize>: Debug + Send + Sync {
    /// Distance of the centres beyond which the energy is zero.
    fn range(&self) -> f64;

    /// Energy, kT.
    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64;

    /// Virial -r du/dr of the continuous part of the energy, with the orientations as they are, kT.
    fn virial_kt(&self, pair: &PosedPair<'_, D>) -> f64;

    /// Distances at which the energy jumps.
    fn jumps(&self) -> Vec<f64>;

    /// Whether the energy depends on the orientations, so that round bodies must turn as well.
    fn is_directed(&self) -> bool {
        false
    }
}

/// One term of the energy of a pair, as a file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Term {
    /// The same energy for all pairs whose centres are closer than a range.
    SquareWell {
        /// Range of the well.
        range: f64,
        /// Depth of the well, kT; below zero for a shoulder.
        depth_kt: f64,
    },
    /// An energy by the distance of the centres, as a table.
    Radial {
        /// Distances, rising.
        distances: Vec<f64>,
        /// Energies at these distances, kT. The last is zero; below the first distance the first one holds.
        energies_kt: Vec<f64>,
    },
    /// Patches that attract each other where they face.
    Patches {
        /// Range of the attraction.
        range: f64,
        /// Depth of the attraction, kT.
        depth_kt: f64,
        /// Angle between the middle of a patch and its rim, degrees.
        half_angle_degrees: f64,
        /// Middles of the patches from the centre of the body, in the body's frame; in a plane with two numbers.
        directions: Vec<Vec<f64>>,
    },
    /// Screened charges on sites of the bodies.
    Charges {
        /// Sites in the body's frame; in a plane with two numbers.
        positions: Vec<Vec<f64>>,
        /// Charges of the sites, e.
        charges_e: Vec<f64>,
        /// Bjerrum length.
        bjerrum_length: f64,
        /// Screening length.
        debye_length: f64,
        /// Distance of two sites beyond which they do not interact.
        cut_off: f64,
    },
}

impl Term {
    /// The potential in D dimensions.
    ///
    /// # Errors
    /// Names the number that cannot be, and what it must be.
    pub fn potential<const D: usize>(&self) -> Result<Box<dyn PairPotential<D>>> {
        Ok(match self {
            Self::SquareWell { range, depth_kt } => {
                Box::new(square_well::SquareWell::new(*range, *depth_kt)?)
            }
            Self::Radial {
                distances,
                energies_kt,
            } => Box::new(radial::Radial::new(distances, energies_kt)?),
            Self::Patches {
                range,
                depth_kt,
                half_angle_degrees,
                directions,
            } => {
                let well = square_well::SquareWell::new(*range, *depth_kt)?;
                Box::new(patches::Patches::<D>::new(
                    well,
                    *half_angle_degrees,
                    directions,
                )?)
            }
            Self::Charges {
                positions,
                charges_e,
                bjerrum_length,
                debye_length,
                cut_off,
            } => {
                let screening = charges::Screening::new(*bjerrum_length, *debye_length, *cut_off)?;
                Box::new(charges::Charges::<D>::new(screening, positions, charges_e)?)
            }
        })
    }
}

/// Refuses a length that is none.
fn require_length(quantity: &'static str, value: f64) -> Result<()> {
    require(
        quantity,
        value,
        "above 0 and at most 1e6",
        value > 0.0 && value <= 1e6,
    )
}

/// Refuses an energy that is none.
fn require_energy(quantity: &'static str, value: f64) -> Result<()> {
    require(
        quantity,
        value,
        "from -1000 to 1000 kT",
        value.abs() <= 1000.0,
    )
}

/// Refuses a list that is empty or endless.
fn require_rows(quantity: &'static str, count: usize) -> Result<()> {
    let holds = (1..=MOST_ROWS).contains(&count);
    require(quantity, count as f64, "from 1 to 10000", holds)
}

/// Vectors of D components from the rows of a file: sites or directions.
fn vectors<const D: usize>(rows: &[Vec<f64>]) -> Result<Vec<[f64; D]>> {
    require_rows("the number of sites or directions", rows.len())?;
    let vector = |row: &Vec<f64>| -> Result<[f64; D]> {
        let Ok(vector) = row.as_slice().try_into() else {
            return Err(Error::OutOfRange {
                quantity: "the number of coordinates of a site or a direction",
                value: row.len() as f64,
                requirement: COORDINATES[D - 1],
            });
        };
        for x in row {
            let coordinate = "a coordinate of a site or a direction";
            require(coordinate, *x, "at most 1e6", x.abs() <= 1e6)?;
        }
        Ok(vector)
    };
    rows.iter().map(vector).collect()
}

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
