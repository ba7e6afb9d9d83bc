//! The association constant of one bound pose, by nested sampling of the poses around it.
//!
//! ```text
//! K_A = ∫ exp(-U) d³R dΩ/8π²   over poses without overlap, nearer to the given one than a limit
//! ```
//!
//! Poses are nearer than the limit if the points of the second body are displaced by less, as a root mean
//! square. The error is that of the nested sampling, or the spread of independent runs if
//! that is larger.

use super::BodyPair;
use super::region::{Region, density};
use crate::Result;
use crate::error::require;
use crate::nested::{Nested, Space, Step, Stepped, ln_sum, nested};
use nalgebra::Vector6;
use protomer_kernel::Pose;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::statistics::RunningMoments;
use rayon::prelude::*;

/// Settings of the sampling of a bound state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundStateSettings {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Live poses of one run.
    pub live_poses: usize,
    /// Independent runs.
    pub runs: u32,
    /// Poses farther than this from the given one are not part of the state, Å (root mean square
    /// displacement of the second body).
    pub limit_angstrom: f64,
}

impl Default for BoundStateSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            live_poses: 64,
            runs: 4,
            limit_angstrom: 5.0,
        }
    }
}

/// A bound state.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundState {
    /// Natural logarithm of K_A in Å³.
    pub ln_association_angstrom3: f64,
    /// Standard error of that logarithm.
    pub ln_association_error: f64,
    /// Mean energy, kT.
    pub mean_energy_kt: f64,
    /// Lowest energy of all sampled poses, kT.
    pub lowest_energy_kt: f64,
    /// Pose of the lowest energy.
    pub lowest_pose: Pose,
    /// Displacement of that pose from the given one, Å (root mean square).
    pub lowest_displacement_angstrom: f64,
    /// Root mean square displacement from the given pose over the state, Å.
    pub displacement_angstrom: f64,
    /// Share of the state beyond four fifths of the limit: where it is large, the limit decides the result.
    pub share_at_limit: f64,
    /// Poses drawn from the state, each with the same weight.
    pub samples: Vec<Pose>,
    /// Energies that were computed.
    pub evaluations: u64,
}

/// Poses drawn from each run.
const SAMPLES: usize = 64;

impl BodyPair {
    /// The bound state about a pose of the second body in the frame of the first; `None` if there is no
    /// room around it. `goes_on` is asked after each step and ends the work early with `false`.
    ///
    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) for settings out of range.
    pub fn bound_state(
        &self,
        about: &Pose,
        settings: &BoundStateSettings,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<BoundState>> {
        let energy_kt = |pose: &Pose| {
            let relative = RelativePose::from(pose);
            match self.excludes(&relative) {
                true => None,
                false => Some(self.potential.energy_kt(&relative)),
            }
        };
        self.bound_state_with(about, settings, &energy_kt, goes_on)
    }

    /// The same with another energy, which may leave out poses.
    pub(super) fn bound_state_with(
        &self,
        about: &Pose,
        settings: &BoundStateSettings,
        energy_kt: &EnergyOfPose<'_>,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<BoundState>> {
        let region = Region {
            about: *about,
            square_of_gyration_angstrom2: self.second.square_of_gyration_angstrom2(),
            limit_angstrom: settings.limit_angstrom,
        };
        sample(&region, energy_kt, settings, goes_on)
    }
}

/// Energy of a pose, kT; `None` at overlap.
pub(super) type EnergyOfPose<'a> = dyn Fn(&Pose) -> Option<f64> + Sync + 'a;

fn sample(
    region: &Region,
    energy_kt: &EnergyOfPose<'_>,
    settings: &BoundStateSettings,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Option<BoundState>> {
    check(settings)?;
    let space = Poses { region, energy_kt };
    let one = |run: u32| {
        let stream =
            |step: u64| CounterRng::for_purpose(settings.seed, run, step, Purpose::BoundState);
        nested(&space, settings.live_poses, &stream, goes_on)
    };
    let runs: Vec<Option<Run>> = (0..settings.runs).into_par_iter().map(one).collect();
    let runs: Option<Vec<Run>> = runs.into_iter().collect();
    Ok(runs.map(|runs| region.state(&runs, settings.seed)))
}

/// One run over places.
type Run = Nested<Vector6<f64>>;

/// Poses of a region with an energy.
struct Poses<'a> {
    region: &'a Region,
    energy_kt: &'a EnergyOfPose<'a>,
}

impl Space for Poses<'_> {
    /// Displacement (Å) and rotation vector (rad) from the given pose.
    type State = Vector6<f64>;

    fn volume(&self) -> f64 {
        self.region.volume_angstrom3()
    }

    fn draw(&self, rng: &mut CounterRng) -> Option<(Vector6<f64>, f64)> {
        let place = self.region.draw(rng);
        Some((place, (self.energy_kt)(&self.region.pose(&place))?))
    }

    fn step(&self, step: &Step<'_, Vector6<f64>>, _: &mut CounterRng) -> Stepped<Vector6<f64>> {
        let [a, b] = step.between;
        let place = step.from + step.scale * (a - b);
        // The density makes the walk even in rotations, not in their vectors.
        if !self.region.holds(&place) || step.uniform * density(step.from) > density(&place) {
            return Stepped::Refused;
        }
        match (self.energy_kt)(&self.region.pose(&place)) {
            None => Stepped::Overlap,
            Some(energy_kt) => Stepped::Free(place, energy_kt),
        }
    }
}

fn check(settings: &BoundStateSettings) -> Result<()> {
    let (poses, runs, limit) = (settings.live_poses, settings.runs, settings.limit_angstrom);
    let enough = (20..=1_000_000).contains(&poses);
    require("live poses", poses as f64, "20 to 1 000 000", enough)?;
    let spread = "2 to 1000: their spread is part of the error";
    let has_spread = (2..=1000).contains(&runs);
    require("runs of a bound state", f64::from(runs), spread, has_spread)?;
    let is_near = (0.1..=50.0).contains(&limit);
    require("limit of a bound state in Å", limit, "0.1 to 50", is_near)
}

impl Region {
    /// The state from all runs.
    fn state(&self, runs: &[Run], seed: u64) -> BoundState {
        let count = runs.len() as f64;
        let all = runs
            .iter()
            .fold(f64::NEG_INFINITY, |sum, run| ln_sum(sum, run.ln_integral));
        let ln_mean = all - count.ln();
        let logs: Vec<f64> = runs.iter().map(|run| run.ln_integral).collect();
        let spread = RunningMoments::in_two_passes(&logs).variance() / count;
        let expected = runs.iter().map(|run| run.variance).sum::<f64>() / count.powi(2);
        let mut state = BoundState {
            ln_association_angstrom3: ln_mean,
            ln_association_error: spread.max(expected).sqrt(),
            mean_energy_kt: 0.0,
            lowest_energy_kt: f64::INFINITY,
            lowest_pose: self.about,
            lowest_displacement_angstrom: 0.0,
            displacement_angstrom: 0.0,
            share_at_limit: 0.0,
            samples: Vec::new(),
            evaluations: runs.iter().map(|run| run.evaluations).sum(),
        };
        let near_limit = (0.8 * self.limit_angstrom).powi(2);
        for (live, ln_weight) in runs.iter().flat_map(|run| &run.states) {
            let weight = (ln_weight - all).exp();
            let square = self.square_displacement_at_place(&live.state);
            state.mean_energy_kt += weight * live.energy_kt;
            state.displacement_angstrom += weight * square;
            if square > near_limit {
                state.share_at_limit += weight;
            }
            if live.energy_kt < state.lowest_energy_kt {
                state.lowest_energy_kt = live.energy_kt;
                state.lowest_pose = self.pose(&live.state);
                state.lowest_displacement_angstrom = square.sqrt();
            }
        }
        state.displacement_angstrom = state.displacement_angstrom.sqrt();
        for (number, run) in runs.iter().enumerate() {
            // Each run gives poses in proportion to its part of the integral.
            let share = (run.ln_integral - all).exp();
            let wanted = (share * (SAMPLES * runs.len()) as f64).round() as usize;
            let mut rng =
                CounterRng::for_purpose(seed, number as u32, u64::MAX, Purpose::BoundState);
            let drawn = run.resampled(wanted, rng.uniform());
            state
                .samples
                .extend(drawn.into_iter().map(|place| self.pose(place)));
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use protomer_kernel::Vec3;
    use std::f64::consts::PI;

    const GYRATION_ANGSTROM: f64 = 12.0;

    fn region() -> Region {
        Region {
            about: Pose {
                position: Vec3::new(30.0, -4.0, 7.0),
                rotation: UnitQuaternion::from_scaled_axis(Vec3::new(0.4, 2.0, -0.3)),
            },
            square_of_gyration_angstrom2: GYRATION_ANGSTROM.powi(2),
            limit_angstrom: 5.0,
        }
    }

    /// Displacement and rotation vector of a pose from that of the region.
    fn place(pose: &Pose) -> (Vec3, Vec3) {
        let region = region();
        let turn = pose.rotation * region.about.rotation.inverse();
        (pose.position - region.about.position, turn.scaled_axis())
    }

    /// Enough for an error of about 1 %; many runs of few live poses cost less than the other way round.
    fn precise(runs: u32, limit_angstrom: f64) -> BoundStateSettings {
        BoundStateSettings {
            live_poses: 256,
            runs,
            limit_angstrom,
            ..BoundStateSettings::default()
        }
    }

    fn found(settings: &BoundStateSettings, energy_kt: &EnergyOfPose<'_>) -> BoundState {
        let region = Region {
            limit_angstrom: settings.limit_angstrom,
            ..region()
        };
        sample(&region, energy_kt, settings, &|| true)
            .unwrap()
            .unwrap()
    }

    /// ∫ f(θ) dμ with the density (1 - cos θ)/π of rotation angles.
    fn over_rotations(function: impl Fn(f64) -> f64) -> f64 {
        let step = PI / 100_000.0;
        let angles = (0..100_000).map(|number| (f64::from(number) + 0.5) * step);
        angles
            .map(|angle| function(angle) * (1.0 - angle.cos()) / PI * step)
            .sum()
    }

    /// U = -30 + t·K t/2 + q θ²/2 with unequal directions, known in closed form but for one angle.
    fn harmonic(pose: &Pose) -> Option<f64> {
        let (shift, turn) = place(pose);
        let stretched = 20.0 * shift.x.powi(2) + 60.0 * shift.y.powi(2) + 5.0 * shift.z.powi(2);
        Some(-30.0 + 0.5 * stretched + 0.5 * 900.0 * turn.norm_squared())
    }

    #[test]
    fn a_harmonic_well_has_its_integral() {
        let by_shift = (2.0 * PI).powf(1.5) / (20.0_f64 * 60.0 * 5.0).sqrt();
        let by_turn = over_rotations(|angle| (-0.5 * 900.0 * angle * angle).exp());
        let exact = 30.0 + (by_shift * by_turn).ln();
        let state = found(&precise(250, 2.0), &harmonic);
        assert!(
            (state.ln_association_angstrom3 - exact).abs() < 0.02,
            "{} {exact}",
            state.ln_association_angstrom3
        );
        assert!(state.ln_association_error < 0.012);
        // Six quadratic terms have half a kT each.
        assert!((state.mean_energy_kt + 27.0).abs() < 0.1);
        assert!(state.share_at_limit < 0.01 && state.lowest_displacement_angstrom < 0.3);
        let mean = state
            .samples
            .iter()
            .map(|pose| harmonic(pose).unwrap() + 30.0)
            .sum::<f64>();
        assert!((mean / state.samples.len() as f64 - 3.0).abs() < 0.3);
    }

    /// A step of equal energies within 2 Å and 0.2 rad, cut by a wall.
    #[test]
    fn a_square_well_beside_a_wall_has_its_integral() {
        let well = |pose: &Pose| {
            let (shift, turn) = place(pose);
            let is_bound = shift.norm() < 2.0 && turn.norm() < 0.2;
            (shift.x > 0.0).then_some(if is_bound { -20.0 } else { 0.0 })
        };
        let by_turn = over_rotations(|angle| f64::from(u8::from(angle < 0.2)));
        let exact = 20.0 + (0.5 * 4.0 / 3.0 * PI * 8.0 * by_turn).ln();
        let state = found(&precise(100, 3.0), &well);
        assert!(
            (state.ln_association_angstrom3 - exact).abs() < 0.02,
            "{} {exact}",
            state.ln_association_angstrom3
        );
        assert!(state.ln_association_error < 0.012);
    }

    /// The slow twin: poses drawn evenly.
    #[test]
    fn a_shallow_well_equals_plain_integration() {
        let well = |pose: &Pose| {
            let (shift, turn) = place(pose);
            let is_free = shift.z + 3.0 * turn.x > -0.5;
            is_free.then(|| -4.0 * (-shift.norm_squared() - 20.0 * turn.norm_squared()).exp())
        };
        let (region, mut rng) = (region(), CounterRng::new(5, 0, 0));
        let (mut sum, draws) = (0.0, 200_000);
        for _ in 0..draws {
            let pose = region.pose(&region.draw(&mut rng));
            sum += well(&pose).map_or(0.0, |energy_kt: f64| (-energy_kt).exp());
        }
        let plain = (region.volume_angstrom3() * sum / f64::from(draws)).ln();
        let settings = BoundStateSettings {
            live_poses: 2000,
            ..BoundStateSettings::default()
        };
        let state = found(&settings, &well);
        assert!(
            (state.ln_association_angstrom3 - plain).abs() < 0.04,
            "{} {plain}",
            state.ln_association_angstrom3
        );
        assert!(state.share_at_limit > 0.3);
    }

    /// Errors cover, and seeds agree: twenty seeds of few live poses.
    #[test]
    fn errors_cover_what_seeds_differ_by() {
        let by_shift = (2.0 * PI).powf(1.5) / (20.0_f64 * 60.0 * 5.0).sqrt();
        let by_turn = over_rotations(|angle| (-0.5 * 900.0 * angle * angle).exp());
        let exact = 30.0 + (by_shift * by_turn).ln();
        let (mut squares, mut bias) = (Vec::new(), 0.0);
        for seed in 0..20 {
            let settings = BoundStateSettings {
                seed,
                ..BoundStateSettings::default()
            };
            let state = found(&settings, &harmonic);
            assert!(state.ln_association_error < 0.5);
            let deviation = (state.ln_association_angstrom3 - exact) / state.ln_association_error;
            squares.push(deviation.powi(2));
            bias += deviation / 20.0;
        }
        // Of 20 independent deviations of one, the mean has an error of 0.22.
        assert!(bias.abs() < 0.7, "{bias}");
        let mean = squares.iter().sum::<f64>() / 20.0;
        assert!((0.3..2.0).contains(&mean), "{squares:?}");
    }

    #[test]
    fn no_room_and_an_early_end_are_told() {
        let settings = BoundStateSettings {
            live_poses: 20,
            ..BoundStateSettings::default()
        };
        assert!(
            sample(&region(), &|_| None, &settings, &|| true)
                .unwrap()
                .is_none()
        );
        assert!(
            sample(&region(), &harmonic, &settings, &|| false)
                .unwrap()
                .is_none()
        );
        let wrong = BoundStateSettings {
            runs: 1,
            ..settings
        };
        assert!(sample(&region(), &harmonic, &wrong, &|| true).is_err());
    }
}
