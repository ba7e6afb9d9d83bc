//! The built-in comparison: how large the errors of the levels are in units of the variance model.

use super::list::{List, ListEnergy};
use super::maker::{COARSE_OPENING, PART_OF_DISTANCE};
use super::neighbours::SKIN_ANGSTROM;
use super::sharpening::STEPS;
use super::table::{Estimate, Table, fine_deviation};
use crate::energy::pair_energy_kt;
use crate::system::System;
use protomer_kernel::bisection::halved;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Vec3};
use serde::Serialize;
use std::sync::Arc;

/// A decision is left open within this many standard deviations.
pub const MULTIPLE: f64 = 6.0;

/// Factor on the scales of coarse errors, whose tails are longer than a comparison of some hundred
/// poses shows.
const TAIL: f64 = 2.5;
/// Factor on the scales of fine errors, for their tails.
const FINE_TAIL: f64 = 1.5;
/// Scale where the comparison met no such pair: the model as it stands.
const NOT_MET: f64 = 1.0;
/// Least scale, where errors are smaller than those of rounding.
const LEAST_SCALE: f64 = 0.05;

/// Poses compared for each pair of types.
const POSES: u32 = 96;
/// Poses compared with the direct sum for each pair of types.
const DIRECT_POSES: u32 = 20;
/// Displacement in the small moves of the comparison, Å.
const STEP_ANGSTROM: f64 = 0.3;
/// Rotation in the small moves, rad.
const STEP_RADIAN: f64 = 0.03;
/// Displacement in the large moves of distant pairs, in gaps between their nearest charges.
const STEP_PER_GAP: f64 = 0.1;
/// Rotation in the large moves, rad.
const LARGE_STEP_RADIAN: f64 = 0.4;
/// The largest turn since a list was made, rad.
const DRIFT_RADIAN: f64 = 0.05;

/// Standard deviations in units of the variance model, from comparisons on random poses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Calibration {
    /// Scales of pairs with points near each other. Their errors are those of close cells, and have
    /// random signs.
    pub contact: ListScales,
    /// Scales of all other pairs. Their errors are small, but add up over the net charge.
    pub distant: ListScales,
    /// Poses compared.
    pub poses: u32,
    /// Errors above [`MULTIPLE`] standard deviations among them.
    pub exceeded: u32,
    /// The largest error, in standard deviations.
    pub largest: f64,
}

/// Scales of energies of one kind of pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ListScales {
    /// Scales of energies from all points.
    pub coarse: Scales,
    /// Scales of expansions of the far points.
    pub expansion: Scales,
    /// Scales of fine energies: of all charges, and of those left in the table after each step of
    /// sharpening.
    pub fine: [f64; 1 + STEPS],
}

/// Scales of an energy and of its changes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scales {
    /// Scale of an energy.
    pub energy: f64,
    /// Scale of the change of an energy with the same list.
    pub change: f64,
}

impl Calibration {
    /// Compares the levels for the types that bodies of a system have; `tables` are those of all its
    /// types.
    pub fn of_system(potential: &Yukawa, system: &System, tables: &[Arc<Table>]) -> Self {
        let placed = system.placed_types().into_iter();
        let table = |index: usize| tables.get(index).map(Arc::as_ref);
        let placed: Vec<&Table> = placed.filter_map(table).collect();
        Self::new(potential, &placed)
    }

    /// Compares the levels on random poses of each pair of types.
    fn new(potential: &Yukawa, types: &[&Table]) -> Self {
        let mut errors = Errors::default();
        for (number, first) in types.iter().enumerate() {
            for second in &types[number..] {
                // Numbers depend on the pair of types alone, not on how many poses others took.
                let mut rng = CounterRng::new(1, errors.pairs, 0);
                errors.pairs += 1;
                if !first.charges.is_empty() && !second.charges.is_empty() {
                    errors.compare(potential, first, second, &mut rng);
                }
            }
        }
        errors.finish()
    }

    /// The scales for a list.
    pub(super) fn scales(&self, list: &List) -> &ListScales {
        // Nothing to compare: the energies are zero at every level.
        match list.is_contact {
            true => &self.contact,
            false => &self.distant,
        }
    }
}

/// The errors met.
#[derive(Debug, Default)]
struct Errors {
    pairs: u32,
    contact: ListErrors,
    distant: ListErrors,
}

/// Errors of energies from lists.
#[derive(Debug, Default)]
struct ListErrors {
    coarse: Vec<ListError>,
    coarse_changes: Vec<ListError>,
    expanded: Vec<ListError>,
    expanded_changes: Vec<ListError>,
    /// Errors of fine energies, by steps of sharpening, over the square root of the model's
    /// variance.
    fine: [Vec<f64>; 1 + STEPS],
}

/// An error of an energy from a list, or of its change, kT, along with the variances of the model.
#[derive(Debug, Clone, Copy)]
struct ListError {
    error_kt: f64,
    points_variance: f64,
    expansion_variance: f64,
}

impl ListError {
    /// The error in standard deviations of the model with these scales.
    fn ratio(&self, points_scale: f64, expansion_scale: f64) -> f64 {
        let points = self.points_variance * points_scale.powi(2);
        let expansion = self.expansion_variance * expansion_scale.powi(2);
        self.error_kt.abs() / (points + expansion).sqrt()
    }
}

/// Energies of the levels at one pose with a list.
struct Compared {
    list: ListEnergy,
    coarse_kt: f64,
    fine: Estimate,
}

impl Compared {
    fn new(first: &Table, second: &Table, list: &List, pose: &RelativePose) -> Option<Self> {
        let fine = first.fine_energy(second, list, pose)?;
        let energy = list.expanded_energy(first, pose)?;
        Some(Self {
            list: energy,
            coarse_kt: energy.close_kt + list.far_energy(first, pose)?,
            fine,
        })
    }

    fn expanded_error_kt(&self) -> f64 {
        self.list.expanded_kt - self.fine.energy_kt
    }

    fn coarse_error_kt(&self) -> f64 {
        self.coarse_kt - self.fine.energy_kt
    }
}

impl Errors {
    fn compare(&mut self, potential: &Yukawa, first: &Table, second: &Table, rng: &mut CounterRng) {
        for pose in 0..POSES {
            let gap = random_gap(pose, rng);
            let present_pose = apart(first, second, gap, rng);
            // Every fourth move is a large one.
            let trial_pose = match pose % 4 {
                3 => moved(&present_pose, STEP_PER_GAP * gap, LARGE_STEP_RADIAN, rng),
                _ => moved(&present_pose, STEP_ANGSTROM, STEP_RADIAN, rng),
            };
            // A pair has drifted some way from where its list was made.
            let drift_angstrom = f64::from(SKIN_ANGSTROM.max(PART_OF_DISTANCE * gap as f32));
            let before = moved(&present_pose, drift_angstrom, DRIFT_RADIAN, rng);
            let [before, present_pose, trial_pose] =
                [before, present_pose, trial_pose].map(|pose| RelativePose::from(&pose));
            let mut list = List::new(first, second, &before, COARSE_OPENING);
            // The drift was too far for the list; as in a run, it is made afresh.
            if !(list.serves(&present_pose) && list.serves(&trial_pose)) {
                list = List::new(first, second, &present_pose, COARSE_OPENING);
            }
            let compared =
                [&present_pose, &trial_pose].map(|pose| Compared::new(first, second, &list, pose));
            let [Some(at_present), Some(at_trial)] = compared else {
                continue;
            };
            let errors = match list.is_contact {
                true => &mut self.contact,
                false => &mut self.distant,
            };
            // Energies at one pose, and below their changes, which are smaller as errors cancel.
            errors.add_energies(&list, &at_present);
            if list.serves(&trial_pose) {
                errors.add_changes(
                    &list,
                    [&at_present, &at_trial],
                    [&present_pose, &trial_pose],
                );
            }
            // The direct sum is slow: a fifth of the poses is enough to check the fine level.
            if pose < DIRECT_POSES {
                let direct_kt =
                    pair_energy_kt(potential, &first.charges, &second.charges, &present_pose);
                let estimates = fine_estimates(first, second, at_present.fine, &present_pose);
                for (ratios, fine) in errors.fine.iter_mut().zip(estimates) {
                    let error_kt = (fine.energy_kt - direct_kt).abs();
                    ratios.push(error_kt / fine_deviation(fine.variance));
                }
            }
        }
    }

    fn finish(&self) -> Calibration {
        let (contact, distant) = (self.contact.scales(), self.distant.scales());
        let mut in_deviations = self.contact.in_deviations(&contact);
        in_deviations.extend(self.distant.in_deviations(&distant));
        let exceeded = in_deviations.iter().filter(|ratio| **ratio > MULTIPLE);
        Calibration {
            contact,
            distant,
            poses: (self.contact.coarse.len() + self.distant.coarse.len()) as u32,
            exceeded: exceeded.count() as u32,
            largest: in_deviations.into_iter().fold(0.0, f64::max),
        }
    }
}

/// The fine energy of a pair, and after each step of sharpening.
fn fine_estimates(
    first: &Table,
    second: &Table,
    fine: Estimate,
    pose: &RelativePose,
) -> Vec<Estimate> {
    let mut estimates = vec![fine];
    let Some(ranking) = first.ranking(second, pose) else {
        return estimates;
    };
    let mut energy_kt = fine.energy_kt;
    for step in 0..STEPS {
        let Some(correction_kt) = first.correction_kt(second, pose, &ranking, step) else {
            return estimates;
        };
        energy_kt += correction_kt;
        let variance = ranking.variance(step);
        estimates.push(Estimate {
            energy_kt,
            variance,
        });
    }
    estimates
}

impl ListErrors {
    fn add_energies(&mut self, list: &List, present: &Compared) {
        self.coarse.push(ListError {
            error_kt: present.coarse_error_kt(),
            points_variance: list.variance,
            expansion_variance: 0.0,
        });
        self.expanded.push(ListError {
            error_kt: present.expanded_error_kt(),
            points_variance: list.variance,
            expansion_variance: present.list.expansion_variance,
        });
    }

    fn add_changes(
        &mut self,
        list: &List,
        [present, trial]: [&Compared; 2],
        [from, to]: [&RelativePose; 2],
    ) {
        let points_variance = list.change_variance(from, to);
        let variances = [present, trial].map(|compared| compared.list.expansion_variance);
        let shift = list.expansion_shift(from, to);
        self.coarse_changes.push(ListError {
            error_kt: trial.coarse_error_kt() - present.coarse_error_kt(),
            points_variance,
            expansion_variance: 0.0,
        });
        self.expanded_changes.push(ListError {
            error_kt: trial.expanded_error_kt() - present.expanded_error_kt(),
            points_variance,
            // The larger of both variances: the change is judged on the safe side.
            expansion_variance: variances[0].max(variances[1]) * shift.powi(2),
        });
    }

    /// Finds the scales of the points first, then those of the expansions.
    fn scales(&self) -> ListScales {
        let of_points = |errors: &[ListError]| {
            // Coarse errors alone first, so that what is left can be put down to the expansion.
            let ratios = errors.iter().map(|error| error.ratio(1.0, 0.0));
            TAIL * scale(ratios)
        };
        let of_expansions = |errors: &[ListError], points: f64| {
            let ratios = errors.iter().map(|error| error.ratio(points, 1.0));
            TAIL * scale(ratios)
        };
        let coarse = Scales {
            energy: of_points(&self.coarse),
            change: of_points(&self.coarse_changes),
        };
        let expansion = Scales {
            energy: of_expansions(&self.expanded, coarse.energy),
            change: of_expansions(&self.expanded_changes, coarse.change),
        };
        let of_step = |ratios: &Vec<f64>| FINE_TAIL * scale(ratios.iter().copied());
        ListScales {
            coarse,
            expansion,
            fine: self.fine.each_ref().map(of_step),
        }
    }

    /// All errors in standard deviations of the model with these scales.
    fn in_deviations(&self, scales: &ListScales) -> Vec<f64> {
        let ListScales {
            coarse,
            expansion,
            fine,
        } = scales;
        let of_fine = |(ratios, scale): (&Vec<f64>, &f64)| {
            let in_deviations = ratios.iter().map(|ratio| ratio / scale);
            in_deviations.collect::<Vec<f64>>()
        };
        let energies = self.coarse.iter().chain(&self.expanded);
        let changes = self.coarse_changes.iter().chain(&self.expanded_changes);
        energies
            .map(|error| error.ratio(coarse.energy, expansion.energy))
            .chain(changes.map(|error| error.ratio(coarse.change, expansion.change)))
            .chain(self.fine.iter().zip(fine).flat_map(of_fine))
            .collect()
    }
}

/// A standard deviation from errors in those of the model.
fn scale(ratios: impl Iterator<Item = f64>) -> f64 {
    let (mut number, mut squares, mut largest) = (0, 0.0, 0.0_f64);
    for ratio in ratios {
        (number, squares) = (number + 1, squares + ratio * ratio);
        largest = largest.max(ratio);
    }
    if number == 0 {
        return NOT_MET;
    }
    let typical = (squares / f64::from(number)).sqrt();
    // Half of the multiple is left for what the comparison did not meet.
    typical.max(2.0 * largest / MULTIPLE).max(LEAST_SCALE)
}

fn moved(pose: &Pose, step_angstrom: f64, step_rad: f64, rng: &mut CounterRng) -> Pose {
    Pose {
        position: pose.position + rng.vector_in_ball(step_angstrom),
        rotation: rng.small_rotation(step_rad) * pose.rotation,
    }
}

/// Every other pose is near contact; the others are as far as errors matter, Å.
fn random_gap(pose: u32, rng: &mut CounterRng) -> f64 {
    match pose % 2 {
        0 => 0.5 + 7.5 * rng.uniform().powi(2),
        _ => rng.uniform_in(5.0, 30.0),
    }
}

/// A random orientation at which the nearest charges of two bodies are this far (Å) apart.
fn apart(first: &Table, second: &Table, wanted: f64, rng: &mut CounterRng) -> Pose {
    let rotation = rng.rotation();
    let direction = rng.unit_vector();
    let second_pose = |distance: f64| Pose {
        position: direction * distance,
        rotation,
    };
    let gap = |distance: f64| {
        let pose = second_pose(distance);
        let gap = |(x, _): (Vec3, f64)| first.distance_bound(&pose.transform_point(&x));
        second.charges.iter().map(gap).fold(f64::INFINITY, f64::min)
    };
    // Doubling finds a distance that is certainly far enough, whatever the bodies' sizes.
    let (mut low, mut high) = (0.0, 1.0);
    while gap(high) < wanted {
        (low, high) = (high, 2.0 * high);
    }
    // The far end: never nearer than requested.
    second_pose(halved([low, high], 12, |distance| gap(distance) < wanted)[1])
}
