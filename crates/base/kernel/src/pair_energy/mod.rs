//! Energies of pairs of rigid bodies, in addition to what their shapes do to each other.
//!
//! A [`PairPotential`] gives the energy of two bodies by the vector between their centres and their orientations. Its
//! [`Term`]s are what a file says; several of them add up. Monte Carlo needs the energy alone, dynamics the force and the
//! torques as well: those potentials that have them are [`SmoothPotential`]s. Lengths are in the unit of the shape, energies
//! in kT.
//!
//! | kind | energy of a pair at the distance r |
//! |---|---|
//! | `square-well` | -depth for r below the range |
//! | `radial` | straight lines between the rows of a table, or a cubic spline through them |
//! | `patches` | -depth for r below the range, if each body has a patch that faces the other (Kern and Frenkel, J. Chem. Phys. 118, 9882 (2003)) |
//! | `charges` | screened charges on sites of the bodies: Σ l_B q q' exp(-s/λ)/s over the distances s of sites, less its value at the cut-off |

mod charges;
mod patches;
mod radial;
mod square_well;
mod sum;

pub use sum::{SmoothSum, Sum};

use crate::error::{KernelError, Result, require};
use crate::shape::separation::dot;
use crate::{Rotation, Vec3};
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

/// Energy of two bodies with the force and the torques that belong to it. The force on the second body is minus that on the
/// first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairForce<const D: usize> {
    /// Energy, kT.
    pub energy_kt: f64,
    /// Force on the first body, kT per length.
    pub force_kt_per_length: [f64; D],
    /// Torques on the first and the second body about their centres, kT; in a plane the third component.
    pub torques_kt: [Vec3; 2],
}

impl<const D: usize> PairForce<D> {
    /// No energy, no force, no torques.
    ///
    /// ```
    /// use protomer_kernel::pair_energy::PairForce;
    /// assert_eq!(PairForce::<2>::zero().force_kt_per_length, [0.0, 0.0]);
    /// ```
    pub fn zero() -> Self {
        Self {
            energy_kt: 0.0,
            force_kt_per_length: [0.0; D],
            torques_kt: [Vec3::zeros(); 2],
        }
    }

    /// Adds what another potential does to the same pair.
    ///
    /// ```
    /// use protomer_kernel::pair_energy::PairForce;
    /// let push = PairForce::<2> { energy_kt: 1.0, force_kt_per_length: [0.0, 2.0], ..PairForce::zero() };
    /// let mut twice = push;
    /// twice.add(&push);
    /// assert_eq!((twice.energy_kt, twice.force_kt_per_length), (2.0, [0.0, 4.0]));
    /// ```
    pub fn add(&mut self, other: &Self) {
        self.energy_kt += other.energy_kt;
        for (force, added) in self
            .force_kt_per_length
            .iter_mut()
            .zip(&other.force_kt_per_length)
        {
            *force += added;
        }
        for (torque, added) in self.torques_kt.iter_mut().zip(&other.torques_kt) {
            *torque += added;
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

/// Energy of a pair of bodies that has a force everywhere but at the centre.
pub trait SmoothPotential<const D: usize>: PairPotential<D> {
    /// Energy, force and torques: those of [`PairPotential::energy_kt`].
    fn forces_kt(&self, pair: &PosedPair<'_, D>) -> PairForce<D>;
}

crate::choices! {
    /// Curve through the rows of a table.
    pub enum Curve {
        /// Straight lines, whose slope jumps at the rows.
        Lines = "lines",
        /// A cubic spline, which is level at the last row and goes on as a straight line before the first.
        Spline = "spline",
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
        /// Energies at these distances, kT. The last is zero; below the first distance of straight lines the first one
        /// holds.
        energies_kt: Vec<f64>,
        /// The curve through the rows; straight lines unless something else is said.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        curve: Option<Curve>,
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
                curve: None | Some(Curve::Lines),
            } => Box::new(radial::Radial::new(distances, energies_kt)?),
            Self::Radial { .. } | Self::Charges { .. } => self.smooth_potential()?,
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
        })
    }

    /// The potential in D dimensions with its force, for bodies in motion. A table without a word on its curve is a spline.
    ///
    /// ```
    /// use protomer_kernel::pair_energy::Term;
    /// let well = Term::SquareWell { range: 1.5, depth_kt: 1.0 };
    /// let message = well.smooth_potential::<3>().map(|_| ()).map_err(|error| error.to_string());
    /// assert!(message.unwrap_err().contains("no finite force"));
    /// ```
    ///
    /// # Errors
    /// As [`Term::potential`]; [`KernelError::NoForce`] for energies that jump, and for straight lines.
    pub fn smooth_potential<const D: usize>(&self) -> Result<Box<dyn SmoothPotential<D>>> {
        Ok(match self {
            Self::SquareWell { .. } => {
                return Err(KernelError::NoForce {
                    reason: "the energy of a square-well jumps at its range, where it has no finite force",
                    remedy: "sample it with hpmc, or give a radial table that rises over a distance",
                });
            }
            Self::Patches { .. } => {
                return Err(KernelError::NoForce {
                    reason: "the energy of patches jumps where they cease to face each other, and has no finite force there",
                    remedy: "sample it with hpmc, or give charges on sites of the body",
                });
            }
            Self::Radial {
                curve: Some(Curve::Lines),
                ..
            } => {
                return Err(KernelError::NoForce {
                    reason: "straight lines bend at the rows of a radial table, where the force jumps",
                    remedy: "sample it with hpmc, or give curve = \"spline\"",
                });
            }
            Self::Radial {
                distances,
                energies_kt,
                ..
            } => Box::new(radial::SmoothRadial::new(distances, energies_kt)?),
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
            return Err(KernelError::OutOfRange {
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

/// A vector of the plane or of space in three components.
fn in_space<const D: usize>(vector: &[f64; D]) -> Vec3 {
    Vec3::from_fn(|axis, _| vector.get(axis).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    fn terms(dimension: usize) -> Vec<Term> {
        let sites = [[0.3, 0.1, 0.2], [-0.3, 0.2, 0.1], [0.0, 0.0, 0.0]];
        let charges = Term::Charges {
            positions: sites.map(|site| site[..dimension].to_vec()).to_vec(),
            charges_e: vec![1.0, -2.0, 0.5],
            bjerrum_length: 0.7,
            debye_length: 0.5,
            cut_off: 2.5,
        };
        let table = Term::Radial {
            distances: vec![0.8, 1.0, 1.3, 1.7, 2.0],
            energies_kt: vec![3.0, -1.0, -1.5, -0.4, 0.0],
            curve: Some(Curve::Spline),
        };
        vec![charges, table]
    }

    /// Forces and torques against differences of the energy, which separate code computes.
    fn compare<const D: usize>(turn: impl Fn(&mut CounterRng) -> Rotation, axes: &[Vec3]) {
        let mut rng = CounterRng::new(5, 0, 0);
        let smooth = SmoothSum::<D>::new(&terms(D)).unwrap();
        let plain = Sum::<D>::new(&terms(D)).unwrap();
        let h = 1e-5;
        for _ in 0..50 {
            let mut offset: [f64; D] = std::array::from_fn(|_| rng.normal());
            let distance = 0.7 + 1.5 * rng.uniform();
            let length = dot(&offset, &offset).sqrt();
            offset = offset.map(|x| x * distance / length);
            let turns = [turn(&mut rng), turn(&mut rng)];
            let energy = |offset: [f64; D], turns: &[Rotation; 2]| {
                plain.energy_kt(&PosedPair::new(offset, [&turns[0], &turns[1]]))
            };
            let forces = smooth.forces_kt(&PosedPair::new(offset, [&turns[0], &turns[1]]));
            assert!((forces.energy_kt - energy(offset, &turns)).abs() < 1e-12);
            for axis in 0..D {
                // The first body moves, so the offset moves the other way.
                let shifted = |shift: f64| {
                    let mut offset = offset;
                    offset[axis] -= shift;
                    energy(offset, &turns)
                };
                let expected = -(shifted(h) - shifted(-h)) / (2.0 * h);
                let force = forces.force_kt_per_length[axis];
                assert!((force - expected).abs() < 1e-6, "{axis} {force} {expected}");
            }
            for body in 0..2 {
                for axis in axes {
                    let rotated = |angle: f64| {
                        let mut turns = turns;
                        turns[body] = Rotation::from_scaled_axis(axis * angle) * turns[body];
                        energy(offset, &turns)
                    };
                    let expected = -(rotated(h) - rotated(-h)) / (2.0 * h);
                    let torque = forces.torques_kt[body].dot(axis);
                    assert!(
                        (torque - expected).abs() < 1e-6,
                        "{body} {torque} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn forces_and_torques_are_gradients_of_the_energy() {
        compare::<3>(CounterRng::rotation, &[Vec3::x(), Vec3::y(), Vec3::z()]);
        compare::<2>(
            |rng| Rotation::from_scaled_axis(6.0 * rng.uniform() * Vec3::z()),
            &[Vec3::z()],
        );
    }

    /// Fine rows make the two curves one.
    #[test]
    fn lines_and_splines_meet_where_rows_are_fine() {
        let gap = |rows: u32| {
            let distances: Vec<f64> = (0..=rows)
                .map(|row| 1.0 + f64::from(row) / f64::from(rows))
                .collect();
            let energies_kt = distances
                .iter()
                .map(|r| (r - 2.0).powi(2) * (3.0 * r).sin())
                .collect();
            let of_curve = |curve| {
                let term = Term::Radial {
                    distances: distances.clone(),
                    energies_kt: Vec::clone(&energies_kt),
                    curve: Some(curve),
                };
                term.potential::<2>().unwrap()
            };
            let [lines, spline] = [Curve::Lines, Curve::Spline].map(of_curve);
            let turn = Rotation::identity();
            (0..200)
                .map(|step| {
                    let pair = PosedPair::new([0.0, 1.0 + 0.005 * f64::from(step)], [&turn, &turn]);
                    (lines.energy_kt(&pair) - spline.energy_kt(&pair)).abs()
                })
                .fold(0.0, f64::max)
        };
        let [coarse, fine] = [gap(10), gap(40)];
        assert!(fine < coarse / 10.0 && fine > 0.0, "{coarse} {fine}");
    }
}
