//! The built-in comparison: how large the errors of the levels are in units of the variance model.

use super::list::{List, SKIN_ANGSTROM};
use super::model::COARSE_OPENING;
use super::table::Table;
use crate::energy::{SitePotential, pair_energy_kt};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Vec3};
use serde::Serialize;

/// A decision is left open within this many standard deviations.
pub const MULTIPLE: f64 = 6.0;

/// Coarse errors have longer tails than a comparison of some hundred poses shows.
const TAIL: f64 = 2.5;

/// Poses compared for each pair of types.
const POSES: u32 = 96;
/// Of these, poses compared with the direct sum.
const DIRECT_POSES: u32 = 6;
/// The moves of the comparison, Å and rad.
const STEP_ANGSTROM: f64 = 0.3;
const STEP_RADIAN: f64 = 0.03;
/// The largest turn since a list was made, rad.
const DRIFT_RADIAN: f64 = 0.05;

/// Standard deviations in units of the variance model, from comparisons on random poses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Calibration {
    /// Of a coarse energy.
    pub energy_scale: f64,
    /// Of the change of a coarse energy when the pair moves by 1 Å near contact.
    pub change_scale_per_angstrom: f64,
    /// Of an energy of all charges in coarse tables.
    pub middle_scale: f64,
    /// Of a fine energy.
    pub fine_scale: f64,
    /// Poses compared.
    pub poses: u32,
    /// Errors above [`MULTIPLE`] standard deviations among them.
    pub exceeded: u32,
    /// The largest error, in standard deviations.
    pub largest: f64,
}

impl Calibration {
    /// Compares the levels on random poses of each pair of types.
    pub fn new<P: SitePotential>(potential: &P, types: &[&Table<P>]) -> Self {
        let mut ratios = Ratios::default();
        for (number, first) in types.iter().enumerate() {
            for second in &types[number..] {
                let mut rng = CounterRng::new(1, ratios.pairs, 0);
                ratios.pairs += 1;
                if !first.charges.is_empty() && !second.charges.is_empty() {
                    ratios.compare(potential, first, second, &mut rng);
                }
            }
        }
        ratios.finish()
    }
}

/// Errors over the square root of the model's variance.
#[derive(Debug, Default)]
struct Ratios {
    pairs: u32,
    energy: Vec<f64>,
    change: Vec<f64>,
    middle: Vec<f64>,
    fine: Vec<f64>,
}

impl Ratios {
    fn compare<P: SitePotential>(
        &mut self,
        potential: &P,
        first: &Table<P>,
        second: &Table<P>,
        rng: &mut CounterRng,
    ) {
        for pose in 0..POSES {
            let here = apart(first, second, random_gap(pose, rng), rng);
            let there = moved(&here, STEP_ANGSTROM, STEP_RADIAN, rng);
            // A pair has drifted some way from where its list was made.
            let before = moved(&here, f64::from(SKIN_ANGSTROM), DRIFT_RADIAN, rng);
            let [before, here, there] = [before, here, there].map(|pose| relative(&pose));
            let mut list = List::new(first, second, &before, COARSE_OPENING);
            if !(list.serves(&here) && list.serves(&there)) {
                list = List::new(first, second, &here, COARSE_OPENING);
            }
            let fine = [&here, &there].map(|pose| first.fine_energy(second, &list, pose));
            let coarse = [&here, &there].map(|pose| list.energy(first, pose));
            let ([Some(fine), Some(fine_there)], [Some(coarse), Some(coarse_there)]) =
                (fine, coarse)
            else {
                continue;
            };
            if let Some(middle) = first.middle_energy(second, &list, &here) {
                let error = middle.energy_kt - fine.energy_kt;
                self.middle.push(error / middle.deviation());
            }
            let deviation = list.variance.sqrt().max(f64::MIN_POSITIVE);
            self.energy.push((coarse - fine.energy_kt) / deviation);
            let change = (coarse_there - coarse) - (fine_there.energy_kt - fine.energy_kt);
            self.change
                .push(change / (deviation * list.shift(&here, &there)));
            if pose < DIRECT_POSES {
                let direct = pair_energy_kt(potential, &first.charges, &second.charges, &here);
                self.fine.push((fine.energy_kt - direct) / fine.deviation());
            }
        }
    }

    fn finish(&self) -> Calibration {
        let scale = |ratios: &[f64], least: f64| {
            let squares: f64 = ratios.iter().map(|ratio| ratio * ratio).sum();
            let largest = ratios
                .iter()
                .fold(0.0_f64, |most, ratio| most.max(ratio.abs()));
            let typical = (squares / ratios.len().max(1) as f64).sqrt();
            // Half of the multiple is left for what the comparison did not meet.
            typical.max(2.0 * largest / MULTIPLE).max(least)
        };
        let scales = [
            TAIL * scale(&self.energy, 0.1),
            TAIL * scale(&self.change, 0.02),
            scale(&self.middle, 0.12),
            scale(&self.fine, 0.06),
        ];
        let all = [&self.energy, &self.change, &self.middle, &self.fine];
        let in_deviations = all.into_iter().zip(scales);
        let in_deviations: Vec<f64> = in_deviations
            .flat_map(|(ratios, scale)| ratios.iter().map(move |ratio| ratio.abs() / scale))
            .collect();
        let [
            energy_scale,
            change_scale_per_angstrom,
            middle_scale,
            fine_scale,
        ] = scales;
        Calibration {
            energy_scale,
            change_scale_per_angstrom,
            middle_scale,
            fine_scale,
            poses: self.energy.len() as u32,
            exceeded: in_deviations
                .iter()
                .filter(|ratio| **ratio > MULTIPLE)
                .count() as u32,
            largest: in_deviations.into_iter().fold(0.0, f64::max),
        }
    }
}

fn moved(pose: &Pose, step_angstrom: f64, step_rad: f64, rng: &mut CounterRng) -> Pose {
    Pose {
        position: pose.position + rng.vector_in_ball(step_angstrom),
        rotation: rng.small_rotation(step_rad) * pose.rotation,
    }
}

fn relative(pose: &Pose) -> RelativePose {
    RelativePose::new(&Pose::identity(), pose, &pose.position)
}

/// Every other pose is near contact; the others are as far as errors matter, Å.
fn random_gap(pose: u32, rng: &mut CounterRng) -> f64 {
    match pose % 2 {
        0 => 0.5 + 7.5 * rng.uniform().powi(2),
        _ => rng.uniform_in(5.0, 30.0),
    }
}

/// A random orientation at which the nearest charges of two bodies are this far (Å) apart.
fn apart<P: SitePotential>(
    first: &Table<P>,
    second: &Table<P>,
    wanted: f64,
    rng: &mut CounterRng,
) -> Pose {
    let rotation = rng.rotation();
    let direction = rng.unit_vector();
    let at = |distance: f64| Pose {
        position: direction * distance,
        rotation,
    };
    let gap = |distance: f64| {
        let pose = at(distance);
        let gap = |(x, _): (Vec3, f64)| first.distance_bound(&pose.transform_point(&x));
        second.charges.iter().map(gap).fold(f64::INFINITY, f64::min)
    };
    let (mut low, mut high) = (0.0, 1.0);
    while gap(high) < wanted {
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..12 {
        let middle = (low + high) / 2.0;
        if gap(middle) < wanted {
            low = middle
        } else {
            high = middle
        }
    }
    at(high)
}
