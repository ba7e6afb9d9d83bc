//! The association constant of one bound pose, by nested sampling of the poses around it.
//!
//! ```text
//! K_A = ∫ exp(-U) d³R dΩ/8π²   over poses without overlap, nearer to the given one than a limit
//! ```
//!
//! Poses are nearer than the limit if the points of the second body are displaced by less, as a root mean
//! square. A native well holds 10⁻¹⁰ of these poses, in places that nobody knows beforehand. Nested sampling
//! (Skilling, Bayesian Anal. 1, 833 (2006)) closes in on them: of N live poses it replaces the one of highest
//! energy by one below, drawn evenly, so that the volume shrinks by a factor 1 - 1/N at a time, on average. It needs no temperature and no
//! guess of the form of the well, and hard surfaces do not disturb it.
//!
//! A new pose comes from a walk that starts at another live pose. Its steps are differences of live poses
//! (ter Braak, Stat. Comput. 16, 239 (2006)), which have the shape of what is left. Equal energies are told apart by a random
//! mark. The error is √(H/N), with the information H in nats, or the spread of independent runs if that is larger.

use super::BodyPair;
use super::wells::square_displacement;
use crate::{McError, Result};
use nalgebra::{UnitQuaternion, Vector6};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::statistics::RunningMoments;
use protomer_kernel::{Pose, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

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

/// Share of the integral that may be left when a run ends.
const LEFT: f64 = 1e-3;
/// Poses that are tried for the first live ones, for each of them.
const MOST_TRIES: u64 = 2000;
/// Accepted steps that a walk should have.
const WANTED_STEPS: f64 = 12.0;
/// Shortest step of a walk, in differences of live poses; the longest is one. Shorter ones mix too slowly: with 0.05 the
/// integral of a harmonic well comes out 28 % too large.
const SHORTEST: f64 = 0.25;
/// Fewest and most steps of a walk.
const STEPS: (f64, f64) = (16.0, 160.0);
/// Poses drawn from each run.
const SAMPLES: usize = 64;

impl BodyPair {
    /// The bound state about a pose of the second body in the frame of the first; `None` if there is no
    /// room around it. `goes_on` is asked after each step and ends the work early with `false`.
    ///
    /// # Errors
    /// [`McError::BadSetting`] for settings out of range.
    pub fn bound_state(
        &self,
        about: &Pose,
        settings: &BoundStateSettings,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<BoundState>> {
        let energy_kt = |pose: &Pose| {
            let relative = relative(pose);
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

pub(super) fn relative(pose: &Pose) -> RelativePose {
    RelativePose {
        rotation: pose.rotation.to_rotation_matrix().into_inner(),
        translation: pose.position,
    }
}

/// Energy of a pose, kT; `None` at overlap.
pub(super) type EnergyOfPose<'a> = dyn Fn(&Pose) -> Option<f64> + Sync + 'a;

/// The poses around one, by displacement and rotation vector.
struct Region {
    about: Pose,
    square_of_gyration_angstrom2: f64,
    limit_angstrom: f64,
}

/// A pose of a run.
#[derive(Debug, Clone, Copy)]
struct Live {
    /// Displacement (Å) and rotation vector (rad) from the given pose.
    place: Vector6<f64>,
    energy_kt: f64,
    /// Random mark that tells equal energies apart.
    mark: f64,
}

impl Live {
    fn is_below(&self, energy_kt: f64, mark: f64) -> bool {
        self.energy_kt < energy_kt || (self.energy_kt == energy_kt && self.mark < mark)
    }
}

/// Result of one run.
struct Nested {
    /// Poses with the logarithms of their weights in the integral.
    poses: Vec<(Live, f64)>,
    ln_integral: f64,
    /// Variance of the logarithm of the integral.
    variance: f64,
    evaluations: u64,
}

fn sample(
    region: &Region,
    energy_kt: &EnergyOfPose<'_>,
    settings: &BoundStateSettings,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Option<BoundState>> {
    check(settings)?;
    let nested = |run: u32| region.nested(energy_kt, settings, run, goes_on);
    let runs: Vec<Option<Nested>> = (0..settings.runs).into_par_iter().map(nested).collect();
    let runs: Option<Vec<Nested>> = runs.into_iter().collect();
    Ok(runs.map(|runs| region.state(&runs, settings.seed)))
}

fn check(settings: &BoundStateSettings) -> Result<()> {
    let bad = |setting, value, requirement| {
        Err(McError::BadSetting {
            setting,
            value,
            requirement,
        })
    };
    if !(20..=1_000_000).contains(&settings.live_poses) {
        return bad("live poses", settings.live_poses as f64, "20 to 1 000 000");
    }
    if !(2..=1000).contains(&settings.runs) {
        let requirement = "2 to 1000: their spread is part of the error";
        return bad(
            "runs of a bound state",
            f64::from(settings.runs),
            requirement,
        );
    }
    if !(0.1..=50.0).contains(&settings.limit_angstrom) {
        return bad(
            "limit of a bound state in Å",
            settings.limit_angstrom,
            "0.1 to 50",
        );
    }
    Ok(())
}

impl Region {
    /// Square of the displacement of the second body, Å².
    fn square_displacement(&self, place: &Vector6<f64>) -> f64 {
        let (shift, turn) = parts(place);
        square_displacement(
            shift.norm_squared(),
            turn.norm(),
            self.square_of_gyration_angstrom2,
        )
    }

    /// The widest rotation within the limit, rad.
    fn widest_turn_rad(&self) -> f64 {
        // 1 - cos θ at which the turn alone moves the points by the limit.
        let versine = self.limit_angstrom.powi(2) / (4.0 / 3.0 * self.square_of_gyration_angstrom2);
        // Beyond 2 even a half turn stays within the limit: small bodies.
        if versine < 2.0 {
            (1.0 - versine).acos()
        } else {
            PI
        }
    }

    /// Whether a place is within the limit, and its rotation vector the only one of its rotation.
    fn holds(&self, place: &Vector6<f64>) -> bool {
        let (_, turn) = parts(place);
        // |turn| ≤ π: every rotation has one vector, so none is counted twice.
        turn.norm() <= PI && self.square_displacement(place) < self.limit_angstrom.powi(2)
    }

    /// ∫ d³R dΩ/8π² over the region, Å³: with the density (1 - cos θ)/π of rotation angles and the ball that
    /// the limit leaves to displacements.
    fn volume_angstrom3(&self) -> f64 {
        const INTERVALS: usize = 2000;
        let widest = self.widest_turn_rad();
        let step = widest / INTERVALS as f64;
        let mut sum = 0.0;
        // The midpoint rule in the angle; the integrand
        // is smooth but at its end, where it vanishes.
        for interval in 0..INTERVALS {
            let angle = (interval as f64 + 0.5) * step;
            let turned = square_displacement(0.0, angle, self.square_of_gyration_angstrom2);
            let radius = (self.limit_angstrom.powi(2) - turned).max(0.0).sqrt();
            sum += (1.0 - angle.cos()) / PI * 4.0 / 3.0 * PI * radius.powi(3) * step;
        }
        sum
    }

    fn pose(&self, place: &Vector6<f64>) -> Pose {
        let (shift, turn) = parts(place);
        Pose {
            position: self.about.position + shift,
            rotation: UnitQuaternion::from_scaled_axis(turn) * self.about.rotation,
        }
    }

    /// A place drawn evenly.
    fn draw(&self, rng: &mut CounterRng) -> Vector6<f64> {
        let widest = self.widest_turn_rad();
        loop {
            let shift = rng.vector_in_ball(self.limit_angstrom);
            let turn = rng.vector_in_ball(widest);
            let place = joined(&shift, &turn);
            // Rejection turns evenly drawn vectors into evenly
            // drawn rotations; the density is at most one.
            if rng.uniform() < rotation_density(turn.norm()) && self.holds(&place) {
                return place;
            }
        }
    }

    /// One run; `None` without room, or if the work was ended.
    fn nested(
        &self,
        energy_kt: &EnergyOfPose<'_>,
        settings: &BoundStateSettings,
        run: u32,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<Nested> {
        let count = settings.live_poses;
        let stream =
            |step: u64| CounterRng::for_purpose(settings.seed, run, step, Purpose::BoundState);
        let (mut live, share, mut evaluations) =
            self.first_poses(energy_kt, count, &mut stream(0), goes_on)?;
        let mut ln_volume = (self.volume_angstrom3() * share).ln();
        let mut poses = Vec::new();
        let mut ln_integral = f64::NEG_INFINITY;
        // A guess: twice the wanted steps, as if half of them were accepted; it adapts.
        let mut steps = WANTED_STEPS * 2.0;
        for step in 1.. {
            if !goes_on() {
                return None;
            }
            let (highest, lowest_kt) = ends(&live);
            let removed = live[highest];
            // Each removal shrinks the volume by 1 - 1/N on average, in logarithms.
            let ln_next = ln_volume + (-1.0 / count as f64).ln_1p();
            let ln_weight = ln_difference(ln_volume, ln_next) - removed.energy_kt;
            // All live poses at the lowest energy could add no more than this part: enough.
            if ln_next - lowest_kt < ln_integral + LEFT.ln() {
                break;
            }
            ln_integral = ln_sum(ln_integral, ln_weight);
            poses.push((removed, ln_weight));
            ln_volume = ln_next;
            let mut rng = stream(step);
            let walk = self.walk(energy_kt, &live, highest, steps as u32, &mut rng);
            // The removed pose's place is filled by a walk
            // from one of the others, below the same energy.
            evaluations += walk.evaluations;
            steps = walk.next_steps(steps);
            live[highest] = walk.end;
        }
        // What is left of the volume, shared by the live poses.
        for left in live {
            let ln_weight = ln_volume - (count as f64).ln() - left.energy_kt;
            ln_integral = ln_sum(ln_integral, ln_weight);
            poses.push((left, ln_weight));
        }
        let information = information(&poses, ln_integral, self.volume_angstrom3() * share);
        // H/N of the shrinkage, and the error of the share without overlap.
        let variance = (information.max(0.0) + (1.0 - share)) / count as f64;
        Some(Nested {
            poses,
            ln_integral,
            variance,
            evaluations,
        })
    }

    /// Live poses without overlap, the share of such poses, and the number of poses tried.
    fn first_poses(
        &self,
        energy_kt: &EnergyOfPose<'_>,
        count: usize,
        rng: &mut CounterRng,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<(Vec<Live>, f64, u64)> {
        let mut live = Vec::with_capacity(count);
        let mut tries = 0;
        while live.len() < count {
            // No room within the limit, or asked to stop.
            if tries > MOST_TRIES * count as u64 || !goes_on() {
                return None;
            }
            tries += 1;
            let place = self.draw(rng);
            if let Some(energy_kt) = energy_kt(&self.pose(&place)) {
                let mark = rng.uniform();
                live.push(Live {
                    place,
                    energy_kt,
                    mark,
                });
            }
        }
        // The last try is a success by construction; without it the share has no bias.
        let share = match tries {
            1 => 1.0,
            tries => (count - 1) as f64 / (tries - 1) as f64,
        };
        Some((live, share, tries))
    }

    /// A walk below the highest of the live poses, from one of the others.
    fn walk(
        &self,
        energy_kt: &EnergyOfPose<'_>,
        live: &[Live],
        highest: usize,
        steps: u32,
        rng: &mut CounterRng,
    ) -> Walk {
        // Any live pose but the highest, without a loop of rejections.
        let other = |rng: &mut CounterRng| (highest + 1 + rng.index(live.len() - 1)) % live.len();
        let limit = live[highest];
        let mut walk = Walk {
            end: live[other(rng)],
            accepted: 0,
            steps,
            evaluations: 0,
        };
        for _ in 0..steps {
            let (a, b) = (other(rng), other(rng));
            // Lengths over a range of scales: the live poses
            // may lie in a ridge or in several places.
            let scale =
                SHORTEST.powf(rng.uniform()) * (if rng.uniform() < 0.5 { 1.0 } else { -1.0 });
            let place = walk.end.place + scale * (live[a].place - live[b].place);
            // Drawn before any test: how many numbers a step takes must not depend on its outcome.
            let (mark, uniform) = (rng.uniform(), rng.uniform());
            let density = |place: &Vector6<f64>| rotation_density(parts(place).1.norm());
            // a = b is no step. The density makes the walk even in rotations, not in their vectors.
            if a == b || !self.holds(&place) || uniform * density(&walk.end.place) > density(&place)
            {
                continue;
            }
            walk.evaluations += 1;
            // An overlap is infinite energy: never below.
            let Some(energy_kt) = energy_kt(&self.pose(&place)) else {
                continue;
            };
            let moved = Live {
                place,
                energy_kt,
                mark,
            };
            // Energies only need to be below the limit: within
            // it the walk is even, without a temperature.
            if moved.is_below(limit.energy_kt, limit.mark) {
                walk.end = moved;
                walk.accepted += 1;
            }
        }
        walk
    }

    /// The state from all runs.
    fn state(&self, runs: &[Nested], seed: u64) -> BoundState {
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
        for (pose, ln_weight) in runs.iter().flat_map(|run| &run.poses) {
            let weight = (ln_weight - all).exp();
            let square = self.square_displacement(&pose.place);
            state.mean_energy_kt += weight * pose.energy_kt;
            state.displacement_angstrom += weight * square;
            if square > near_limit {
                state.share_at_limit += weight;
            }
            if pose.energy_kt < state.lowest_energy_kt {
                state.lowest_energy_kt = pose.energy_kt;
                state.lowest_pose = self.pose(&pose.place);
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
            state
                .samples
                .extend(self.resampled(run, wanted, rng.uniform()));
        }
        state
    }

    /// Poses in proportion to their weights, by equal steps from a random start.
    fn resampled(&self, run: &Nested, wanted: usize, start: f64) -> Vec<Pose> {
        let mut samples = Vec::with_capacity(wanted);
        let mut sum = 0.0;
        for (pose, ln_weight) in &run.poses {
            sum += (ln_weight - run.ln_integral).exp() * wanted as f64;
            while (samples.len() as f64 + start) < sum && samples.len() < wanted {
                samples.push(self.pose(&pose.place));
            }
        }
        samples
    }
}

/// A walk and how it went.
struct Walk {
    end: Live,
    accepted: u32,
    steps: u32,
    evaluations: u64,
}

impl Walk {
    /// Steps of the next walk: enough for the wanted accepted ones, changed slowly.
    fn next_steps(&self, present: f64) -> f64 {
        // Half a step more, so that a walk without success does not divide by zero.
        let rate = (f64::from(self.accepted) + 0.5) / f64::from(self.steps);
        let wanted = (WANTED_STEPS / rate).clamp(STEPS.0, STEPS.1);
        // One part in twenty per walk: the length follows
        // the shrinking volume, not the luck of a walk.
        present + 0.05 * (wanted - present)
    }
}

/// Displacement and rotation vector.
fn parts(place: &Vector6<f64>) -> (Vec3, Vec3) {
    let shift = Vec3::new(place[0], place[1], place[2]);
    (shift, Vec3::new(place[3], place[4], place[5]))
}

fn joined(shift: &Vec3, turn: &Vec3) -> Vector6<f64> {
    Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
}

/// Density of even rotations over rotation vectors, relative to that of small ones: 2 (1 - cos θ)/θ².
fn rotation_density(angle_rad: f64) -> f64 {
    // The quotient of two small numbers would lose its digits.
    match angle_rad < 1e-4 {
        true => 1.0,
        false => 2.0 * (1.0 - angle_rad.cos()) / angle_rad.powi(2),
    }
}

/// The live pose of highest energy, and the lowest energy, kT.
fn ends(live: &[Live]) -> (usize, f64) {
    let (mut highest, mut lowest_kt) = (0, f64::INFINITY);
    for (number, pose) in live.iter().enumerate() {
        if live[highest].is_below(pose.energy_kt, pose.mark) {
            highest = number;
        }
        lowest_kt = lowest_kt.min(pose.energy_kt);
    }
    (highest, lowest_kt)
}

/// H = ∫ P ln(P/π): how far the state is from an even distribution, in nats.
fn information(poses: &[(Live, f64)], ln_integral: f64, volume_angstrom3: f64) -> f64 {
    let mean = |(pose, ln_weight): &(Live, f64)| -(ln_weight - ln_integral).exp() * pose.energy_kt;
    poses.iter().map(mean).sum::<f64>() - ln_integral + volume_angstrom3.ln()
}

/// ln(exp a + exp b).
fn ln_sum(a: f64, b: f64) -> f64 {
    let (large, small) = (a.max(b), a.min(b));
    // -∞ less -∞ would be no number.
    match large == f64::NEG_INFINITY {
        true => large,
        false => large + (small - large).exp().ln_1p(),
    }
}

/// ln(exp a - exp b) for a > b.
fn ln_difference(a: f64, b: f64) -> f64 {
    a + (-(b - a).exp()).ln_1p()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

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
