//! The bodies of an assembly with the energies between them at one salt.
//!
//! Bodies that are apart in the assembly have smooth energies, which hardly change while the parts tremble. They are
//! expanded to second order in the displacement d and the rotation vector θ of one body in the frame of the other:
//!
//! ```text
//! U(d, θ) = U₀ + g·x + ½ x·H x,     x = (d, θ)
//! ```
//!
//! Nearer bodies, and far ones that moved farther than the expansion reaches, have the energy itself.

use super::StabilitySettings;
use crate::stability::run::Engine;
use anyhow::Result;
use nalgebra::{Matrix6, Vector6};
use protomer_kernel::overlap::{comes_within, overlaps};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{Pose, Rotation, Vec3};
use protomer_mc::BodyType;
use protomer_mc::energy::terms::{Terms, TermsOfKinds};
use protomer_mc::parts::BodyEnergies;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Surfaces that are farther from each other than this in the assembly have an expansion, Å: more than most attractions
/// between residues reach.
const APART_ANGSTROM: f64 = 12.0;
/// An expansion holds up to this displacement, Å.
const HOLDS_ANGSTROM: f64 = 4.0;
/// An expansion holds up to this rotation, rad.
const HOLDS_RAD: f64 = 0.2;
/// Steps of the differences that give the derivatives.
const STEPS: [f64; 6] = [1.0, 1.0, 1.0, 0.05, 0.05, 0.05];

/// Bodies with the energies between them in one medium.
pub(super) struct Interacting {
    types: Vec<Arc<BodyType>>,
    kinds: Vec<usize>,
    potentials: TermsOfKinds,
    /// Expansions of the bodies that are apart, by their numbers, in the order in which terms are made.
    apart: BTreeMap<(usize, usize), Expansion>,
}

/// Energy of two bodies about their poses in the assembly.
struct Expansion {
    about: Pose,
    energy_kt: f64,
    gradient: Vector6<f64>,
    curvature: Matrix6<f64>,
}

impl Interacting {
    /// The bodies of an engine, at the salt that it was made for.
    ///
    /// # Errors
    /// As [`Engine::pair_potentials`].
    pub fn new(engine: &Engine, settings: &StabilitySettings, salt_molar: f64) -> Result<Self> {
        let interaction = settings.medium.interaction(Some(salt_molar))?;
        let assembly = engine.assembly();
        let mut interacting = Self {
            types: engine.body_types().to_vec(),
            kinds: assembly.kinds.clone(),
            potentials: engine.pair_potentials(&interaction)?,
            apart: BTreeMap::new(),
        };
        let poses = &assembly.poses;
        let pairs: Vec<(usize, usize)> = (0..poses.len())
            .flat_map(|j| (0..j).map(move |i| (i, j)))
            .map(|(i, j)| interacting.ordered(i, j))
            .filter(|(i, j)| !interacting.touch(*i, *j, poses, APART_ANGSTROM))
            .collect();
        let expansion = |(i, j): (usize, usize)| {
            let about = poses[j].then(&poses[i].inverse());
            (
                (i, j),
                Expansion::new(about, |pose| interacting.exact_kt(i, j, pose)),
            )
        };
        interacting.apart = pairs.into_par_iter().map(expansion).collect();
        Ok(interacting)
    }

    /// Two bodies in the order in which terms are made: the lower kind first.
    fn ordered(&self, i: usize, j: usize) -> (usize, usize) {
        match (self.kinds[i], i) <= (self.kinds[j], j) {
            true => (i, j),
            false => (j, i),
        }
    }

    fn terms(&self, i: usize, j: usize) -> Option<&Terms> {
        self.potentials.get(&(self.kinds[i], self.kinds[j]))
    }

    /// Energy of the second body at a pose in the frame of the first, in the order of the terms, kT.
    fn exact_kt(&self, i: usize, j: usize, second_in_first: &Pose) -> f64 {
        let relative = RelativePose::from(second_in_first);
        self.terms(i, j)
            .map_or(0.0, |terms| terms.energy_kt(&relative))
    }

    /// Whether the surfaces of two bodies are nearer than a gap in the assembly.
    fn touch(&self, i: usize, j: usize, poses: &[Pose], gap_angstrom: f64) -> bool {
        let shape = |body: usize| &self.types[self.kinds[body]].shape;
        let relative = RelativePose::from(&poses[j].then(&poses[i].inverse()));
        comes_within(shape(i), shape(j), &relative, gap_angstrom)
    }

    /// Table of the bodies that touch, by the gap between their surfaces.
    pub fn touching(&self, poses: &[Pose], gap_angstrom: f64) -> Vec<Vec<bool>> {
        let row = |i: usize| -> Vec<bool> {
            let others = 0..poses.len();
            others
                .map(|j| i != j && self.touch(i, j, poses, gap_angstrom))
                .collect()
        };
        (0..poses.len()).map(row).collect()
    }
}

impl BodyEnergies for Interacting {
    fn overlap(&self, first: usize, second: usize, first_pose: &Pose, second_pose: &Pose) -> bool {
        let shape = |body: usize| &self.types[self.kinds[body]].shape;
        let relative = RelativePose::from(&second_pose.then(&first_pose.inverse()));
        overlaps(shape(first), shape(second), &relative)
    }

    fn energy_kt(&self, first: usize, second: usize, first_pose: &Pose, second_pose: &Pose) -> f64 {
        let (i, j) = self.ordered(first, second);
        let (a, b) = match i == first {
            true => (first_pose, second_pose),
            false => (second_pose, first_pose),
        };
        let second_in_first = b.then(&a.inverse());
        let expanded = self.apart.get(&(i, j));
        expanded
            .and_then(|expansion| expansion.energy_kt(&second_in_first))
            .unwrap_or_else(|| self.exact_kt(i, j, &second_in_first))
    }
}

impl Expansion {
    /// The expansion of an energy about a pose, by central differences.
    fn new(about: Pose, energy_kt: impl Fn(&Pose) -> f64) -> Self {
        let displaced = |moves: &[(usize, f64)]| {
            let mut place: Vector6<f64> = Vector6::zeros();
            for (coordinate, sign) in moves {
                place[*coordinate] += sign * STEPS[*coordinate];
            }
            energy_kt(&pose(&about, &place))
        };
        let middle_kt = displaced(&[]);
        let (mut gradient, mut curvature) = (Vector6::zeros(), Matrix6::zeros());
        for row in 0..6 {
            let (up, down) = (displaced(&[(row, 1.0)]), displaced(&[(row, -1.0)]));
            gradient[row] = (up - down) / (2.0 * STEPS[row]);
            curvature[(row, row)] = (up - 2.0 * middle_kt + down) / STEPS[row].powi(2);
            for column in 0..row {
                let corner = |a: f64, b: f64| displaced(&[(row, a), (column, b)]);
                let twist =
                    corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0);
                let mixed = twist / (4.0 * STEPS[row] * STEPS[column]);
                curvature[(row, column)] = mixed;
                curvature[(column, row)] = mixed;
            }
        }
        Self {
            about,
            energy_kt: middle_kt,
            gradient,
            curvature,
        }
    }

    /// The energy of a pose, kT; `None` beyond the reach of the expansion.
    fn energy_kt(&self, second_in_first: &Pose) -> Option<f64> {
        let shift = second_in_first.position - self.about.position;
        let turn = (second_in_first.rotation * self.about.rotation.inverse()).scaled_axis();
        if shift.norm_squared() > HOLDS_ANGSTROM.powi(2) || turn.norm_squared() > HOLDS_RAD.powi(2)
        {
            return None;
        }
        let place = Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z);
        let second_order = 0.5 * place.dot(&(self.curvature * place));
        Some(self.energy_kt + self.gradient.dot(&place) + second_order)
    }
}

/// The pose displaced and rotated from another.
fn pose(about: &Pose, place: &Vector6<f64>) -> Pose {
    let turn = Vec3::new(place[3], place[4], place[5]);
    Pose {
        position: about.position + Vec3::new(place[0], place[1], place[2]),
        rotation: Rotation::new(turn) * about.rotation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Screened charges of two bodies 60 Å apart, summed directly: the slow twin.
    #[test]
    fn expansions_follow_screened_charges_of_bodies_that_are_apart() {
        let charges: Vec<(Vec3, f64)> = (0..40)
            .map(|number| {
                let t = f64::from(number);
                let place = Vec3::new((1.3 * t).sin(), (0.7 * t).cos(), (2.1 * t).sin()) * 18.0;
                (place, if number % 5 == 0 { -1.5 } else { 1.5 })
            })
            .collect();
        let direct_kt = |pose: &Pose| {
            let mut sum = 0.0;
            for (place, charge) in &charges {
                for (other, other_charge) in &charges {
                    let distance = (pose.transform_point(other) - place).norm();
                    sum += 7.0 * charge * other_charge * (-distance / 20.0).exp() / distance;
                }
            }
            sum
        };
        let about = Pose {
            position: Vec3::new(52.0, -8.0, 11.0),
            rotation: Rotation::new(Vec3::new(0.4, -1.2, 0.3)),
        };
        let expansion = Expansion::new(about, direct_kt);
        let mut largest_kt: f64 = 0.0;
        for number in 0..50 {
            let t = f64::from(number);
            // Displacements up to 2 Å and 0.1 rad, as those of bodies in their wells.
            let place = Vector6::new(
                2.0 * t.sin() * 0.6,
                2.0 * (1.7 * t).cos() * 0.6,
                2.0 * (2.3 * t).sin() * 0.6,
                0.06 * (0.9 * t).sin(),
                0.06 * (1.1 * t).cos(),
                0.06 * (3.1 * t).sin(),
            );
            let moved = pose(&about, &place);
            let error_kt = expansion.energy_kt(&moved).unwrap_or(f64::NAN) - direct_kt(&moved);
            largest_kt = largest_kt.max(error_kt.abs());
        }
        let energy_kt = direct_kt(&about).abs();
        assert!(energy_kt > 5.0, "{energy_kt}");
        // Third derivatives are left: some thousandths.
        assert!(largest_kt < 0.005 * energy_kt, "{largest_kt} {energy_kt}");
        let far = pose(&about, &Vector6::new(5.0, 0.0, 0.0, 0.0, 0.0, 0.0));
        assert_eq!(expansion.energy_kt(&far), None);
    }
}
