//! Screened charges on sites of the bodies.

use super::{
    PairForce, PairPotential, PosedPair, SmoothPotential, in_space, require_length, vectors,
};
use crate::Rotation;
use crate::error::{KernelError, Result, require};
use crate::shape::separation::{dot, matrix};

/// Interaction of two charges: l_B q q' (exp(-s/λ)/s - exp(-s_c/λ)/s_c) up to a cut-off s_c.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Screening {
    bjerrum_length: f64,
    debye_length: f64,
    cut_off: f64,
    shift: f64,
}

impl Screening {
    pub(super) fn new(bjerrum_length: f64, debye_length: f64, cut_off: f64) -> Result<Self> {
        require_length("the Bjerrum length", bjerrum_length)?;
        require_length("the screening length", debye_length)?;
        require_length("the cut-off of charges", cut_off)?;
        Ok(Self {
            bjerrum_length,
            debye_length,
            cut_off,
            shift: (-cut_off / debye_length).exp() / cut_off,
        })
    }

    /// Energy of two unit charges, and its derivative by their distance.
    fn between(&self, distance: f64) -> [f64; 2] {
        if distance >= self.cut_off {
            return [0.0; 2];
        }
        let decay = (-distance / self.debye_length).exp() / distance;
        let slope = -decay * (1.0 / self.debye_length + 1.0 / distance);
        [
            self.bjerrum_length * (decay - self.shift),
            self.bjerrum_length * slope,
        ]
    }
}

/// Charges at sites of equal bodies.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Charges<const D: usize> {
    screening: Screening,
    sites: Vec<([f64; D], f64)>,
    range: f64,
}

impl<const D: usize> Charges<D> {
    pub(super) fn new(
        screening: Screening,
        positions: &[Vec<f64>],
        charges_e: &[f64],
    ) -> Result<Self> {
        let positions = vectors::<D>(positions)?;
        if positions.len() != charges_e.len() {
            return Err(KernelError::OutOfRange {
                quantity: "the number of charges",
                value: charges_e.len() as f64,
                requirement: "that of their sites",
            });
        }
        for charge in charges_e {
            require(
                "a charge (e)",
                *charge,
                "from -1000 to 1000",
                charge.abs() <= 1000.0,
            )?;
        }
        let farthest = positions.iter().map(length).fold(0.0, f64::max);
        Ok(Self {
            screening,
            sites: positions
                .into_iter()
                .zip(charges_e.iter().copied())
                .collect(),
            range: screening.cut_off + 2.0 * farthest,
        })
    }

    /// Sum over pairs of sites of the charges times a function of the vector between them.
    fn sum(&self, pair: &PosedPair<'_, D>, function: impl Fn(&[f64; D]) -> f64) -> f64 {
        let [first, second] = pair.rotations.map(|rotation| self.turned(rotation));
        let mut sum = 0.0;
        for (first_site, (_, charge)) in first.iter().zip(&self.sites) {
            for (second_site, (_, other)) in second.iter().zip(&self.sites) {
                let apart = std::array::from_fn(|axis| {
                    pair.offset[axis] + second_site[axis] - first_site[axis]
                });
                sum += charge * other * function(&apart);
            }
        }
        sum
    }

    fn turned(&self, rotation: &Rotation) -> Vec<[f64; D]> {
        let matrix = matrix::<D>(rotation);
        let sites = self.sites.iter();
        sites
            .map(|(site, _)| matrix.map(|row| dot(&row, site)))
            .collect()
    }
}

impl<const D: usize> PairPotential<D> for Charges<D> {
    fn range(&self) -> f64 {
        self.range
    }

    fn energy_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        self.sum(pair, |apart| self.screening.between(length(apart))[0])
    }

    fn virial_kt(&self, pair: &PosedPair<'_, D>) -> f64 {
        // d/d(ln r) moves the second body along the offset.
        self.sum(pair, |apart| {
            let distance = length(apart);
            -self.screening.between(distance)[1] * dot(apart, &pair.offset) / distance
        })
    }

    fn jumps(&self) -> Vec<f64> {
        Vec::new()
    }

    fn is_directed(&self) -> bool {
        self.sites.iter().any(|(site, _)| length(site) > 0.0)
    }
}

impl<const D: usize> SmoothPotential<D> for Charges<D> {
    fn forces_kt(&self, pair: &PosedPair<'_, D>) -> PairForce<D> {
        let mut total = PairForce::zero();
        if pair.distance >= self.range {
            return total;
        }
        let [first, second] = pair.rotations.map(|rotation| self.turned(rotation));
        for (first_site, (_, charge)) in first.iter().zip(&self.sites) {
            for (second_site, (_, other)) in second.iter().zip(&self.sites) {
                let apart: [f64; D] = std::array::from_fn(|axis| {
                    pair.offset[axis] + second_site[axis] - first_site[axis]
                });
                let distance = length(&apart);
                if distance >= self.screening.cut_off {
                    continue;
                }
                let [energy, slope] = self.screening.between(distance);
                total.energy_kt += charge * other * energy;
                // The first site is pushed away from the second where the energy falls with the distance.
                let force = apart.map(|x| charge * other * slope * x / distance);
                for (sum, component) in total.force_kt_per_length.iter_mut().zip(&force) {
                    *sum += component;
                }
                let force = in_space(&force);
                total.torques_kt[0] += in_space(first_site).cross(&force);
                total.torques_kt[1] -= in_space(second_site).cross(&force);
            }
        }
        total
    }
}

fn length<const D: usize>(vector: &[f64; D]) -> f64 {
    dot(vector, vector).sqrt()
}
