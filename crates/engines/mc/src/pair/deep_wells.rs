//! Deep wells: what each of them holds, by local integration, and what the rays find outside of them.
//!
//! ```text
//! K_A = Σ_w ∫_w exp(-U) + ∫_rest exp(-U),   over poses in contact
//! ```
//!
//! Rays meet a deep, narrow well rarely, and each time it counts so much that their mean says little. Such wells are
//! therefore integrated one by one ([`bound_state`](super::bound_state)). Nothing counts twice, because their regions are disjoint: a pose
//! belongs to the well whose minimum is nearest, if that is nearer than 5 Å (root mean square displacement of the second body). All
//! other poses are the rest, which fresh rays sample.
//!
//! Of equal bodies a pose and its inverse are one complex. The region of a well then holds the poses near its minimum and their
//! inverses, and ∫_w is the integral over the former, each of which counts twice unless its inverse is one of them.

use super::BodyPair;
use super::bound_state::BoundStateSettings;
use super::estimator::{Estimator, Found, PairSettings, PairThermodynamics};
use super::profile::over_directions;
use super::radial::RaySample;
use super::replicas::mean_and_error;
use super::wells::{BoundPose, Different, bound_poses};
use crate::{McError, Result};
use protomer_kernel::{Pose, RelativePose};
use serde::{Deserialize, Serialize};

/// Wells that are integrated at most.
const MOST_DEEP: usize = 8;
/// A well above this energy is wide enough for rays, kT.
const DEEP_KT: f64 = -10.0;
/// A well this far above the lowest one is left to the rays, kT.
const WINDOW_KT: f64 = 4.0;
/// Below this energy the spread of rays says nothing: a few of them may have met the well, or none, kT.
const BEYOND_RAYS_KT: f64 = -15.0;
/// Largest relative error of the association constant by rays that is good enough.
const RESOLVED: f64 = 0.3;
/// The minimum of a well that rays have met lies less than this below the lowest of them, kT.
const MISSED_KT: f64 = 6.0;

/// The wells of two bodies: first found, then integrated step by step where rays do not resolve them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wells {
    are_equal: bool,
    poses: Vec<BoundPose>,
    /// Number of wells to integrate, the lowest ones.
    deep: usize,
    /// Wells integrated so far; `None` for a well without room.
    integrals: Vec<Option<WellIntegral>>,
    rest: Vec<Rest>,
}

/// Integral over a well.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WellIntegral {
    /// ∫ exp(-U) over the region of the well, as [`PairThermodynamics::association_volume_angstrom3`], Å³.
    pub association_volume_angstrom3: f64,
    /// Standard error of that volume, relative to it.
    pub relative_error: f64,
    /// Energy of the minimum from which its region was made, kT.
    pub minimum_kt: f64,
    /// Lowest pose that the integration met.
    pub lowest: BoundPose,
}

/// A bound pose, and the integral over its well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Well {
    /// The lowest pose that was met in the well.
    pub pose: BoundPose,
    /// Integral over the well; `None` where rays resolve it.
    pub integral: Option<WellIntegral>,
}

/// Sums of one replica over directions, outside of the wells, Å³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Rest {
    directions: u64,
    soft: f64,
    bound: f64,
}

impl Wells {
    /// Finds the wells below what an estimate has met, and chooses those to integrate.
    ///
    /// `are_equal` says that both bodies are the same: a pose and its inverse are one then.
    pub fn find(pair: &BodyPair, estimator: &Estimator, are_equal: bool) -> Self {
        let seed = estimator.settings().seed;
        let poses = bound_poses(pair, estimator.lowest(), are_equal, seed);
        let deep = unresolved(&estimator.thermodynamics(pair), estimator.lowest(), &poses);
        Self::new(poses, deep, are_equal)
    }

    fn new(poses: Vec<BoundPose>, deep: usize, are_equal: bool) -> Self {
        Self {
            are_equal,
            poses,
            deep,
            integrals: Vec::new(),
            rest: Vec::new(),
        }
    }

    /// Checks wells that were read back.
    ///
    /// # Errors
    /// [`McError::ForeignCheckpoint`] if their lists do not fit each other or the settings.
    pub fn check(&self, settings: &PairSettings) -> Result<()> {
        let fits = self.deep <= MOST_DEEP.min(self.poses.len())
            && self.integrals.len() <= self.deep
            && self.rest.len() <= settings.replicas as usize;
        match fits {
            true => Ok(()),
            false => {
                let cause = "its wells do not fit each other";
                Err(McError::ForeignCheckpoint(cause.into()))
            }
        }
    }

    /// The largest number of steps: to find the wells, one for each well, and one for each replica of the rest.
    pub fn steps(settings: &PairSettings) -> u64 {
        1 + MOST_DEEP as u64 + u64::from(settings.replicas)
    }

    /// The steps made; all of them once nothing is left to do.
    pub fn done(&self, settings: &PairSettings) -> u64 {
        let is_finished = self.integrals.len() == self.deep
            && (self.deep == 0 || self.rest.len() == settings.replicas as usize);
        match is_finished {
            true => Self::steps(settings),
            false => (1 + self.integrals.len() + self.rest.len()) as u64,
        }
    }

    /// Makes the next step. `goes_on` is asked often, and ends the step with nothing done if it says no.
    ///
    /// # Errors
    /// [`McError::BadSetting`] for settings out of range.
    pub fn advance(
        &mut self,
        pair: &BodyPair,
        estimator: &Estimator,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<()> {
        if self.integrals.len() < self.deep {
            let number = self.integrals.len();
            let settings = BoundStateSettings {
                // Independent of the other wells, and of other seeds of users.
                seed: estimator.settings().seed ^ ((number as u64 + 1) << 40),
                ..BoundStateSettings::default()
            };
            let integral = self.integrate(pair, number, &settings, goes_on)?;
            // If the work was ended, the result is not whole and is left out.
            if goes_on() {
                self.integrals.push(integral);
            }
        } else {
            self.rest.push(self.sample_rest(pair, estimator));
        }
        Ok(())
    }

    /// Whether wells are integrated.
    pub fn are_integrated(&self) -> bool {
        self.deep > 0
    }

    /// The wells, the lowest first.
    pub fn wells(&self) -> Vec<Well> {
        let mut wells: Vec<Well> = Vec::with_capacity(self.poses.len());
        for (number, minimum) in self.poses.iter().enumerate() {
            let integral = self.integrals.get(number).copied().flatten();
            // The integration may have met a pose below the minimum that the descent found.
            let met = integral.map(|integral| integral.lowest);
            let is_lower = |met: &BoundPose| met.energy_kt < minimum.energy_kt;
            wells.push(Well {
                pose: met.filter(is_lower).unwrap_or(*minimum),
                integral,
            });
        }
        wells.sort_by(|a, b| a.pose.energy_kt.total_cmp(&b.pose.energy_kt));
        wells
    }

    /// The averages of an estimate, in which the wells are replaced by their integrals; w(r) stays that of the rays.
    pub fn thermodynamics(&self, pair: &BodyPair, estimator: &Estimator) -> PairThermodynamics {
        let by_rays = estimator.thermodynamics(pair);
        if !self.are_integrated() {
            return by_rays;
        }
        // Independent integrals: volumes and variances add.
        let (mut wells, mut variance) = (0.0, 0.0);
        for integral in self.integrals.iter().flatten() {
            let volume = integral.association_volume_angstrom3;
            wells += volume;
            variance += (volume * integral.relative_error).powi(2);
        }
        let over = |value: &dyn Fn(&Rest) -> f64| {
            let mean = |rest: &Rest| over_directions(value(rest) / rest.directions as f64);
            mean_and_error(&self.rest.iter().map(mean).collect::<Vec<f64>>())
        };
        let (bound, bound_error) = over(&|rest| rest.bound);
        let (soft, soft_error) = over(&|rest| rest.soft);
        let (covered, covered_error) = estimator.covered_angstrom3();
        let tail = Estimator::tail_angstrom3(pair);
        // The hard part, the rest and the wells come from different draws, so variances add.
        let b2_variance = covered_error.powi(2) + soft_error.powi(2) + variance;
        PairThermodynamics {
            b2_angstrom3: 0.5 * (covered - soft - wells - tail),
            b2_error_angstrom3: 0.5 * b2_variance.sqrt(),
            association_volume_angstrom3: wells + bound,
            association_volume_error_angstrom3: (variance + bound_error.powi(2)).sqrt(),
            ..by_rays
        }
    }

    /// Integrates one well over its region.
    fn integrate(
        &self,
        pair: &BodyPair,
        number: usize,
        settings: &BoundStateSettings,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<WellIntegral>> {
        let minimum = self.poses[number];
        let regions = self.regions(pair);
        let energy_kt = |pose: &Pose| {
            let relative = RelativePose::from(pose);
            // Outside its region, overlapping or not in contact: no part of this well.
            let counts = regions.well(pose) == Some(number)
                && !pair.excludes(&relative)
                && pair.is_in_contact(&relative);
            // A pose that stands for two counts twice: its energy is lower by ln 2.
            let of_copies = regions.copies(pose, number).ln();
            counts.then(|| pair.potential.energy_kt(&relative) - of_copies)
        };
        let state = pair.bound_state_with(&minimum.pose, settings, &energy_kt, goes_on)?;
        Ok(state.map(|state| WellIntegral {
            association_volume_angstrom3: state.ln_association_angstrom3.exp(),
            relative_error: state.ln_association_error,
            minimum_kt: minimum.energy_kt,
            lowest: BoundPose {
                energy_kt: pair.energy_kt(&state.lowest_pose),
                pose: state.lowest_pose,
            },
        }))
    }

    /// One replica of what lies outside of the wells.
    fn sample_rest(&self, pair: &BodyPair, estimator: &Estimator) -> Rest {
        let regions = self.regions(pair);
        // A well without an integral is left to the rays.
        let is_integrated = |number: usize| self.integrals[number].is_some();
        let is_in_well = |pose: &Pose| regions.well(pose).is_some_and(is_integrated);
        let (mut soft, mut bound) = (0.0, 0.0);
        let take = |sample: RaySample, density: f64| {
            let pose = |distance_angstrom: f64| sample.orientation.pose(distance_angstrom);
            // Beyond contact exp(-U) - 1 counts, in openings exp(-U):
            // there the 1 was subtracted with the covered volume.
            for (points, subtracts) in [(&sample.outside, 1.0), (&sample.openings, 0.0)] {
                for point in points {
                    // In a well the Boltzmann factor is that of the
                    // integral; only the -1 is left to the rays.
                    let in_well = point.in_contact && is_in_well(&pose(point.distance_angstrom));
                    let factor = if in_well {
                        0.0
                    } else {
                        (-point.energy_kt).exp()
                    };
                    let volume = point.volume_angstrom3 / density;
                    soft += volume * (factor - subtracts);
                    bound += if point.in_contact {
                        volume * factor
                    } else {
                        0.0
                    };
                }
            }
        };
        let directions = estimator.draw_rest(pair, self.rest.len() as u32, take);
        Rest {
            directions,
            soft,
            bound,
        }
    }

    fn regions(&self, pair: &BodyPair) -> Regions<'_> {
        let limit = BoundStateSettings::default().limit_angstrom;
        Regions {
            minima: &self.poses[..self.deep],
            different: Different::new(pair, self.are_equal),
            square_limit_angstrom2: limit.powi(2),
        }
    }
}

/// The number of wells, the lowest ones, that decide the association constant where the rays do not resolve it.
fn unresolved(by_rays: &PairThermodynamics, met: &[Found], poses: &[BoundPose]) -> usize {
    let (Some(lowest), Some(met)) = (poses.first(), met.first()) else {
        return 0;
    };
    let volume = by_rays.association_volume_angstrom3;
    // Rays are good enough if the well is shallow, the error small, and they have met its depth.
    let is_resolved = lowest.energy_kt > BEYOND_RAYS_KT
        && by_rays.association_volume_error_angstrom3 < RESOLVED * volume
        && met.energy_kt < lowest.energy_kt + MISSED_KT;
    if volume == 0.0 || is_resolved || lowest.energy_kt > DEEP_KT {
        return 0;
    }
    let is_near = |pose: &&BoundPose| pose.energy_kt < lowest.energy_kt + WINDOW_KT;
    // Wells far above the lowest add little; rays see them.
    poses.iter().take(MOST_DEEP).take_while(is_near).count()
}

/// Disjoint regions of poses, one for each well.
struct Regions<'a> {
    minima: &'a [BoundPose],
    different: Different,
    square_limit_angstrom2: f64,
}

impl Regions<'_> {
    /// The well to which a pose belongs.
    fn well(&self, pose: &Pose) -> Option<usize> {
        // The limit as the first "least": farther poses belong to no well.
        let (mut nearest, mut least) = (None, self.square_limit_angstrom2);
        for (number, minimum) in self.minima.iter().enumerate() {
            let square = self
                .different
                .square_distance_as_complexes(pose, &minimum.pose);
            if square < least {
                (nearest, least) = (Some(number), square);
            }
        }
        nearest
    }

    /// Weight of a pose near the minimum of its well: two for equal bodies, because its inverse counts too,
    /// unless that is near the minimum itself.
    fn copies(&self, pose: &Pose, number: usize) -> f64 {
        let minimum = &self.minima[number].pose;
        let inverse = self.different.square_distance(&pose.inverse(), minimum);
        let counts_for_both = self.different.are_equal() && inverse >= self.square_limit_angstrom2;
        if counts_for_both { 2.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyType;
    use crate::pair::{Charged, Core, PairPotential, Term, Terms};
    use crate::test_support::tetrahedron;
    use nalgebra::{Rotation3, UnitQuaternion};
    use protomer_kernel::Vec3;
    use protomer_kernel::potential::Yukawa;
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// Stiffness of a harmonic well against displacement, kT/Å².
    const SHIFT: f64 = 20.0;
    /// Stiffness of the well against rotation, kT/rad².
    const TURN: f64 = 900.0;
    /// Depth of the well, kT.
    const DEPTH_KT: f64 = 30.0;

    /// Harmonic wells about these poses; of equal bodies also about their inverses.
    struct Harmonic {
        minima: Vec<Pose>,
        are_equal: bool,
    }

    fn harmonic_kt(pose: &Pose, minimum: &Pose) -> f64 {
        let turn = minimum.rotation.angle_to(&pose.rotation);
        let shift = (pose.position - minimum.position).norm_squared();
        0.5 * (SHIFT * shift + TURN * turn * turn) - DEPTH_KT
    }

    impl PairPotential for Harmonic {
        fn term(&self) -> Term {
            Term::Contacts
        }

        fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
            let rotation = Rotation3::from_matrix_unchecked(second_in_first.rotation);
            let pose = Pose {
                position: second_in_first.translation,
                rotation: UnitQuaternion::from_rotation_matrix(&rotation),
            };
            let mut energy_kt = f64::INFINITY;
            for minimum in &self.minima {
                energy_kt = energy_kt.min(harmonic_kt(&pose, minimum));
                if self.are_equal {
                    energy_kt = energy_kt.min(harmonic_kt(&pose.inverse(), minimum));
                }
            }
            energy_kt
        }

        fn shares(&self, _: &RelativePose, _: &mut dyn FnMut(usize, &Vec3, f64)) {}

        fn reach_angstrom(&self, _: f64) -> f64 {
            30.0
        }

        fn tail_angstrom3(&self, _: f64) -> f64 {
            0.0
        }
    }

    /// ∫ exp(-U) d³R dΩ/8π² of one of these wells, Å³; small rotations have the density θ²/(2π).
    fn exact_angstrom3() -> f64 {
        let by_shift = (2.0 * PI / SHIFT).powf(1.5);
        let by_turn = (2.0 * PI / TURN).powf(1.5) / (8.0 * PI * PI);
        DEPTH_KT.exp() * by_shift * by_turn
    }

    fn pair(potential: Arc<dyn PairPotential>, gap_angstrom: f64) -> BodyPair {
        let body = Arc::new(BodyType::new("tetrahedron", &tetrahedron(3.0), &[]).unwrap());
        BodyPair {
            first: Arc::clone(&body),
            second: body,
            potential: Terms(vec![potential]),
            core: Core::Surfaces,
            contact_gap_angstrom: gap_angstrom,
        }
    }

    fn estimated(pair: &BodyPair, settings: PairSettings) -> Estimator {
        let mut estimator = Estimator::new(settings).unwrap();
        while estimator.done() < Estimator::steps(&settings) {
            estimator.advance(pair);
        }
        estimator
    }

    fn sum_angstrom3(wells: &Wells, pair: &BodyPair) -> (f64, f64) {
        let settings = BoundStateSettings {
            live_poses: 120,
            ..BoundStateSettings::default()
        };
        let (mut sum, mut variance) = (0.0, 0.0);
        for number in 0..wells.deep {
            let found = wells.integrate(pair, number, &settings, &|| true);
            let found = found.unwrap().unwrap();
            assert!(found.lowest.energy_kt < found.minimum_kt + 1.0, "{found:?}");
            sum += found.association_volume_angstrom3;
            variance += (found.association_volume_angstrom3 * found.relative_error).powi(2);
        }
        (sum, variance.sqrt() / sum)
    }

    /// The boundary between the regions runs 1.5 Å from each minimum; the wells are 0.2 Å wide.
    #[test]
    fn wells_near_each_other_count_once_each() {
        let rotation = UnitQuaternion::from_scaled_axis(Vec3::new(0.3, -0.8, 1.1));
        let minimum = |x: f64| Pose {
            position: Vec3::new(x, 14.0, 3.0),
            rotation,
        };
        let minima = vec![minimum(0.0), minimum(3.0)];
        let poses = minima.iter().map(|pose| BoundPose {
            energy_kt: -DEPTH_KT,
            pose: *pose,
        });
        let wells = Wells::new(poses.collect(), 2, false);
        let pair = pair(
            Arc::new(Harmonic {
                minima,
                are_equal: false,
            }),
            20.0,
        );
        let (sum, relative_error) = sum_angstrom3(&wells, &pair);
        let deviation = (sum / (2.0 * exact_angstrom3())).ln();
        assert!(relative_error < 0.25, "{relative_error}");
        assert!(
            deviation.abs() < 3.0 * relative_error,
            "{deviation} {relative_error}"
        );
    }

    #[test]
    fn a_pose_of_equal_bodies_counts_with_its_inverse() {
        let minimum = Pose {
            position: Vec3::new(2.0, 14.0, 3.0),
            rotation: UnitQuaternion::from_scaled_axis(Vec3::new(0.3, -0.8, 1.1)),
        };
        let bound = BoundPose {
            energy_kt: -DEPTH_KT,
            pose: minimum,
        };
        let wells = Wells::new(vec![bound], 1, true);
        let pair = pair(
            Arc::new(Harmonic {
                minima: vec![minimum],
                are_equal: true,
            }),
            20.0,
        );
        let (sum, relative_error) = sum_angstrom3(&wells, &pair);
        let deviation = (sum / (2.0 * exact_angstrom3())).ln();
        assert!(
            deviation.abs() < 3.0 * relative_error,
            "{deviation} {relative_error}"
        );
    }

    /// The slow twin: rays alone, where they resolve the wells.
    #[test]
    fn wells_and_rest_together_are_what_rays_find() {
        let places = [[2.0, 1.6, 1.6], [-2.0, -1.6, 1.6]].map(Vec3::from);
        let body = |charges: [f64; 2]| {
            let sites: Vec<(Vec3, f64)> = places.into_iter().zip(charges).collect();
            Arc::new(BodyType::new("tetrahedron", &tetrahedron(3.0), &sites).unwrap())
        };
        let equal = body([1.3, -1.3]);
        let different = [body([1.3, 0.8]), body([-1.2, -1.0])];
        for [first, second] in [different, [Arc::clone(&equal), equal]] {
            let are_equal = Arc::ptr_eq(&first, &second);
            let yukawa = Yukawa::uncut(7.0, 0.2).unwrap();
            let charged = Charged::new(yukawa, &first.charges, &second.charges).unwrap();
            let pair = BodyPair {
                first,
                second,
                potential: Terms(vec![Arc::new(charged)]),
                core: Core::Surfaces,
                contact_gap_angstrom: 5.0,
            };
            let settings = PairSettings {
                relative_error: 0.02,
                pilot_directions: 128,
                hard_directions: 64,
                most_directions: 4096,
                ..PairSettings::default()
            };
            let estimator = estimated(&pair, settings);
            let by_rays = estimator.thermodynamics(&pair);
            let found = Wells::find(&pair, &estimator, are_equal);
            assert!(!found.are_integrated());
            let deep = found.poses.len().min(3);
            let mut wells = Wells::new(found.poses, deep, are_equal);
            while wells.done(&settings) < Wells::steps(&settings) {
                wells.advance(&pair, &estimator, &|| true).unwrap();
            }
            let both = wells.thermodynamics(&pair, &estimator);
            let in_wells: f64 = wells
                .wells()
                .iter()
                .filter_map(|well| well.integral)
                .map(|integral| integral.association_volume_angstrom3)
                .sum();
            assert!(in_wells > 0.1 * both.association_volume_angstrom3);
            let agree = |a: f64, b: f64, errors: [f64; 2]| {
                let error = errors[0].hypot(errors[1]);
                assert!((a - b).abs() < 3.0 * error, "{a} {b} ± {error}");
            };
            assert!(
                both.association_volume_error_angstrom3 < 0.2 * both.association_volume_angstrom3
            );
            agree(
                both.association_volume_angstrom3,
                by_rays.association_volume_angstrom3,
                [
                    both.association_volume_error_angstrom3,
                    by_rays.association_volume_error_angstrom3,
                ],
            );
            agree(
                both.b2_angstrom3,
                by_rays.b2_angstrom3,
                [both.b2_error_angstrom3, by_rays.b2_error_angstrom3],
            );
        }
    }

    #[test]
    fn wells_continue_and_can_be_interrupted() {
        let minimum = Pose {
            position: Vec3::new(0.0, 14.0, 0.0),
            ..Pose::identity()
        };
        let bound = BoundPose {
            energy_kt: -DEPTH_KT,
            pose: minimum,
        };
        let pair = pair(
            Arc::new(Harmonic {
                minima: vec![minimum],
                are_equal: false,
            }),
            20.0,
        );
        let settings = PairSettings {
            replicas: 4,
            pilot_directions: 64,
            hard_directions: 64,
            most_directions: 256,
            ..PairSettings::default()
        };
        let estimator = estimated(&pair, settings);
        let mut wells = Wells::new(vec![bound], 1, false);
        wells.advance(&pair, &estimator, &|| false).unwrap();
        assert_eq!(wells.done(&settings), 1);
        let mut whole = wells.clone();
        while whole.done(&settings) < Wells::steps(&settings) {
            whole.advance(&pair, &estimator, &|| true).unwrap();
        }
        wells.advance(&pair, &estimator, &|| true).unwrap();
        let json = serde_json::to_string(&wells).unwrap();
        let mut read: Wells = serde_json::from_str(&json).unwrap();
        read.check(&settings).unwrap();
        while read.done(&settings) < Wells::steps(&settings) {
            read.advance(&pair, &estimator, &|| true).unwrap();
        }
        assert_eq!(read, whole);
        read.deep = 0;
        assert!(read.check(&settings).is_err());
    }

    #[test]
    fn only_deep_wells_that_rays_do_not_resolve_are_integrated() {
        let pose = |energy_kt: f64| BoundPose {
            energy_kt,
            pose: Pose::identity(),
        };
        let met = |energy_kt: f64| {
            [Found {
                energy_kt,
                pose: Pose::identity(),
            }]
        };
        let by_rays = |relative_error: f64| PairThermodynamics {
            b2_angstrom3: 0.0,
            b2_error_angstrom3: 0.0,
            b2_hard_angstrom3: 0.0,
            b2_hard_error_angstrom3: 0.0,
            association_volume_angstrom3: 1e6,
            association_volume_error_angstrom3: 1e6 * relative_error,
            contact_volume_angstrom3: 1e4,
            directions: 64,
            mean_force: Vec::new(),
        };
        let poses = [pose(-14.0), pose(-11.0), pose(-9.0)];
        assert_eq!(unresolved(&by_rays(0.1), &met(-10.0), &poses), 0);
        assert_eq!(unresolved(&by_rays(0.1), &met(-7.0), &poses), 2);
        assert_eq!(unresolved(&by_rays(0.5), &met(-10.0), &poses), 2);
        assert_eq!(unresolved(&by_rays(0.1), &met(-20.0), &[pose(-20.0)]), 1);
        assert_eq!(unresolved(&by_rays(0.5), &met(-2.0), &[pose(-9.0)]), 0);
        assert_eq!(unresolved(&by_rays(0.5), &met(-2.0), &[]), 0);
        assert_eq!(unresolved(&by_rays(0.5), &[], &poses), 0);
    }
}
