//! Pilot, adaptation, and replicas with error bars.

use super::BodyPair;
use super::orientation::{EvenSequence, Orientation};
use super::profile::{Bins, MeanForceRow, mean_force, over_directions};
use super::proposal::{Proposal, Width};
use super::radial::{RaySample, hard_ray};
use super::replicas::mean_and_error;
use super::wells::apart;
use crate::error::require;
use crate::{McError, Result};
use protomer_kernel::Pose;
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Energies are followed out to where they are below this, kT; beyond, they count to first order.
const TAIL_ENERGY_KT: f64 = 5e-3;
/// The widths of the caps, from one step of the pilot to the next, rad.
const WIDTHS: [Width; 5] = [
    width(0.6, 0.9),
    width(0.35, 0.55),
    width(0.2, 0.32),
    width(0.12, 0.2),
    width(0.07, 0.12),
];
/// The share of draws in caps while the pilot adapts.
const PILOT_SHARE: f64 = 0.7;
/// The shares that the production may choose from, in addition to the uniform distribution.
const SHARES: [f64; 2] = [0.5, 0.85];
/// The replicas sample in this many rounds: each but the first adds what the error still lacks.
const ROUNDS: u64 = 3;
/// Number of caps of a distribution.
const CAPS: usize = 384;
/// Samples kept in memory at a time.
const CHUNK: u64 = 1024;
/// Poses kept as starts for the search for bound poses: the lowest of each well, so that one deep well does
/// not hide all others.
const KEPT_POSES: usize = 64;

const fn width(direction_rad: f64, rotation_rad: f64) -> Width {
    Width {
        direction_rad,
        rotation_rad,
    }
}

/// Settings of the sampling.
///
/// ```
/// use protomer_mc::pair::PairSettings;
/// let quick = PairSettings { replicas: 4, relative_error: 0.05, ..PairSettings::default() };
/// assert!(quick.check().is_ok());
/// assert!(PairSettings { replicas: 2, ..quick }.check().is_err(), "two show no spread");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PairSettings {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Independent replicas, whose spread is the error.
    pub replicas: u32,
    /// Directions of each step of the pilot; at most `most_directions` of them.
    pub pilot_directions: u64,
    /// Directions of each replica at which only the surfaces count; fewer where a relative error above 3 % is wanted.
    pub hard_directions: u64,
    /// The wanted standard error of B₂, relative to the larger of |B₂| and its hard part.
    pub relative_error: f64,
    /// The wanted standard error of B₂, Å³, in the place of the relative one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_angstrom3: Option<f64>,
    /// Directions with energies that the replicas may take together.
    pub most_directions: u64,
}

impl Default for PairSettings {
    fn default() -> Self {
        Self {
            seed: 1,
            replicas: 16,
            pilot_directions: 1024,
            hard_directions: 512,
            relative_error: 0.004,
            error_angstrom3: None,
            most_directions: 65_536,
        }
    }
}

impl PairSettings {
    /// Refuses settings that make no sense.
    ///
    /// # Errors
    /// [`McError::BadSetting`] names the setting.
    pub fn check(&self) -> Result<()> {
        let spread = "4 to 1000: their spread is the error";
        let has_spread = (4..=1000).contains(&self.replicas);
        require(
            "number of replicas",
            f64::from(self.replicas),
            spread,
            has_spread,
        )?;
        let counts = [
            ("directions of the pilot", self.pilot_directions),
            ("directions without energies", self.hard_directions),
            ("most directions", self.most_directions),
        ];
        for (setting, count) in counts {
            let is_between = (64..=1_000_000_000).contains(&count);
            require(setting, count as f64, "64 to 1 000 000 000", is_between)?;
        }
        let is_between = (1e-6..=1.0).contains(&self.relative_error);
        require(
            "relative error",
            self.relative_error,
            "1e-6 to 1",
            is_between,
        )?;
        let error = self.error_angstrom3.unwrap_or(1.0);
        let is_positive = error.is_finite() && error > 0.0;
        require("error of B2 in Å³", error, "positive", is_positive)
    }
}

impl PairSettings {
    /// Error up to which all of [`hard_directions`](Self::hard_directions) are taken, relative.
    const PRECISE: f64 = 0.03;

    /// Directions of each step of the pilot: not more than the replicas may take together.
    fn pilot_step(&self) -> u64 {
        self.pilot_directions.min(self.most_directions)
    }

    /// Rays of each replica at which only the surfaces count. Their error falls as the root of their number, so
    /// fewer serve where a larger error is wanted; it stays below half of that.
    fn hard_rays(&self) -> u64 {
        if self.error_angstrom3.is_some() {
            return self.hard_directions;
        }
        let needed = self.hard_directions as f64 * (Self::PRECISE / self.relative_error).powi(2);
        (needed.ceil() as u64).clamp(64, self.hard_directions)
    }
}

/// The state of an estimate, which advances step by step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimator {
    settings: PairSettings,
    explored: Vec<Explored>,
    plan: Option<Plan>,
    replicas: Vec<Replica>,
    lowest: Vec<Found>,
}

/// One orientation that the pilot has looked at.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Explored {
    orientation: Orientation,
    step: u32,
    /// ∫ (exp(-U) - 1) r² dr, Å³.
    soft: f64,
    /// The density it was drawn with.
    density: f64,
}

/// Plan of the draws of the replicas.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Plan {
    proposal: Proposal,
    /// Directions of each replica in each round so far.
    rounds: Vec<u64>,
    /// Replicas that the last round has sampled.
    sampled: u32,
}

/// The sums of one replica, Å³: of rays without energies, whose averages they are, and over
/// directions with energies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Replica {
    covered: f64,
    open: f64,
    directions: u64,
    soft: f64,
    bound: f64,
    bound_hard: f64,
    bins: Bins,
}

/// A pose with its energy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// The second body in the frame of the first.
    pub pose: Pose,
    /// Energy, kT.
    pub energy_kt: f64,
}

/// Thermodynamics of two bodies.
///
/// ```
/// use protomer_mc::BodyType;
/// use protomer_mc::pair::{BodyPair, Core, Estimator, PairSettings, Terms};
/// # use protomer_kernel::{TriangleMesh, Vec3};
/// # use std::sync::Arc;
/// # let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// # let cube = Arc::new(BodyType::new("cube", &mesh, &[])?);
/// let pair = BodyPair {
///     first: Arc::clone(&cube),
///     second: cube,
///     potential: Terms::default(),
///     core: Core::Surfaces,
///     contact_gap_angstrom: 5.0,
/// };
/// let settings = PairSettings { replicas: 4, relative_error: 0.05, ..PairSettings::default() };
/// let mut estimator = Estimator::new(settings)?;
/// while estimator.done() < Estimator::steps(&settings) {
///     estimator.advance(&pair);
/// }
/// let thermodynamics = estimator.thermodynamics(&pair);
/// // Hard cubes of edge a have B₂ = 5.5 a³.
/// assert!((thermodynamics.b2_angstrom3 / 5500.0 - 1.0).abs() < 0.05);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairThermodynamics {
    /// B₂ (B₁₂ of different bodies), Å³.
    pub b2_angstrom3: f64,
    /// Standard error of B₂, Å³.
    pub b2_error_angstrom3: f64,
    /// B₂ of the surfaces alone, Å³.
    pub b2_hard_angstrom3: f64,
    /// Standard error of B₂ of the surfaces, Å³.
    pub b2_hard_error_angstrom3: f64,
    /// ∫ exp(-U) d³R over poses in contact, averaged over rotations, Å³.
    pub association_volume_angstrom3: f64,
    /// Standard error of the association volume, Å³.
    pub association_volume_error_angstrom3: f64,
    /// The same of bodies with the same surfaces and no energy, Å³.
    pub contact_volume_angstrom3: f64,
    /// Directions with energies that the replicas took together.
    pub directions: u64,
    /// w(r).
    pub mean_force: Vec<MeanForceRow>,
}

impl Estimator {
    /// An estimate that has not begun.
    ///
    /// # Errors
    /// As [`PairSettings::check`].
    pub fn new(settings: PairSettings) -> Result<Self> {
        settings.check()?;
        Ok(Self {
            settings,
            explored: Vec::new(),
            plan: None,
            replicas: Vec::new(),
            lowest: Vec::new(),
        })
    }

    /// Checks an estimate that was read back.
    ///
    /// # Errors
    /// [`McError::ForeignCheckpoint`] if it is of other settings, or its lists do not fit each other.
    pub fn check(&self, settings: &PairSettings) -> Result<()> {
        let replicas = settings.replicas as usize;
        let fits = match &self.plan {
            None => self.replicas.is_empty(),
            Some(plan) => {
                let sampled = plan.sampled as usize;
                let expected = match plan.rounds.len() {
                    0 => return Err(McError::ForeignCheckpoint("it has no rounds".into())),
                    1 => sampled,
                    _ => replicas,
                };
                sampled <= replicas && self.replicas.len() == expected && plan.proposal.fits()
            }
        };
        if self.settings == *settings && fits {
            return Ok(());
        }
        let cause = "its replicas are not those of these settings";
        Err(McError::ForeignCheckpoint(cause.into()))
    }

    /// The number of steps of a whole estimate.
    pub fn steps(settings: &PairSettings) -> u64 {
        Self::PILOT_STEPS + ROUNDS * u64::from(settings.replicas)
    }

    /// Uniform, one for each width, and one that compares the choices for the production.
    const PILOT_STEPS: u64 = WIDTHS.len() as u64 + 2;

    /// The steps made.
    pub fn done(&self) -> u64 {
        let pilot = self.explored.last().map_or(0, |last| last.step + 1);
        match &self.plan {
            Some(plan) => {
                let whole_rounds = plan.rounds.len() as u64 - 1;
                let replicas = u64::from(self.settings.replicas);
                Self::PILOT_STEPS + whole_rounds * replicas + u64::from(plan.sampled)
            }
            None => u64::from(pilot),
        }
    }

    /// Makes the next step, on all threads of the current pool.
    pub fn advance(&mut self, pair: &BodyPair) {
        // Taken out, so that steps may borrow the estimator while they read the plan.
        let Some(mut plan) = self.plan.take() else {
            self.explore(pair);
            return;
        };
        // A round ends with its last replica; the next adds what the spread so far says is missing.
        if plan.sampled == self.settings.replicas {
            plan.rounds.push(self.further_directions(pair, &plan));
            plan.sampled = 0;
        }
        self.sample(pair, &plan);
        plan.sampled += 1;
        self.plan = Some(plan);
    }

    /// The lowest energy met in each well, the lowest first.
    pub fn lowest(&self) -> &[Found] {
        &self.lowest
    }

    /// One step of the pilot.
    fn explore(&mut self, pair: &BodyPair) {
        let step = self.done() as u32;
        let proposal = match step {
            0 => Proposal::uniform(),
            step => {
                let width = WIDTHS[(step as usize - 1).min(WIDTHS.len() - 1)];
                Proposal::new(self.centres(), width, PILOT_SHARE)
            }
        };
        // Drawn before these samples are added: no choice
        // may be judged by the samples it was made from.
        let is_comparison = u64::from(step) + 1 == Self::PILOT_STEPS;
        // The choices for the production stand on centres that the last samples have not seen.
        let centres = is_comparison.then(|| self.centres());
        let count = self.settings.pilot_step();
        let mut drawn = Vec::new();
        self.draw_and_keep(pair, step, &proposal, count, |sample, density| {
            drawn.push(Explored {
                orientation: sample.orientation,
                step,
                soft: sample.soft_angstrom3(),
                density,
            });
        });
        self.explored.append(&mut drawn);
        if let Some(centres) = centres {
            self.plan = Some(self.choose(pair, centres, step));
            // The checkpoint shrinks: from here on only sums are kept.
            self.explored.clear();
        }
    }

    /// Orientations drawn in proportion to what they contribute.
    fn centres(&self) -> Vec<Orientation> {
        let weights: Vec<f64> = self
            .explored
            .iter()
            // What a draw contributes to the integral: its
            // value over the density it was drawn with.
            .map(|explored| explored.soft.abs() / explored.density)
            .collect();
        let total: f64 = weights.iter().sum();
        let mut centres = Vec::with_capacity(CAPS);
        // Bodies without energy outside contact: nothing to aim at, and the draws stay uniform.
        if !(total.is_finite() && total > 0.0) {
            return centres;
        }
        let step = self.done();
        // Systematic resampling: equal steps from one random start,
        // so copies differ by less than one from their expectation.
        let offset = self.rng(step as u32, u64::MAX).uniform();
        let mut sum = 0.0;
        for (explored, weight) in self.explored.iter().zip(&weights) {
            sum += weight / total * CAPS as f64;
            while (centres.len() as f64) + offset < sum {
                centres.push(explored.orientation);
            }
        }
        centres
    }

    /// The distribution with the least second moment of what one draw contributes, ∫ S²/q, judged by
    /// the samples of the last step, and how many draws the wanted error takes.
    fn choose(&self, pair: &BodyPair, centres: Vec<Orientation>, step: u32) -> Plan {
        let judges: Vec<&Explored> = self
            .explored
            .iter()
            .filter(|explored| explored.step == step)
            .collect();
        let count = self.settings.pilot_step();
        let mut choices = vec![Proposal::uniform()];
        for width in WIDTHS {
            for share in SHARES {
                choices.push(Proposal::new(centres.clone(), width, share));
            }
        }
        let second_moment = |proposal: &Proposal| {
            let mut sum = 0.0;
            // E[S²/(q p)] over draws from p is ∫ S²/q, for every choice q at once.
            for judge in &judges {
                let density = proposal.density(&judge.orientation, count);
                sum += judge.soft * judge.soft / (density * judge.density);
            }
            sum / judges.len() as f64
        };
        let moments: Vec<f64> = choices.par_iter().map(second_moment).collect();
        let mut best = 0;
        for (index, moment) in moments.iter().enumerate() {
            // The first of equal ones: uniform comes first.
            if *moment < moments[best] {
                best = index;
            }
        }
        let mut mean = 0.0;
        for judge in &judges {
            // The integral itself, from the same samples; its
            // square is subtracted from the second moment.
            mean += judge.soft / (judge.density * judges.len() as f64);
        }
        let variance = (moments[best] - mean * mean).max(0.0);
        let hard = self.rough_hard(pair);
        let size = hard.max((hard - 2.0 * PI * mean).abs());
        // 2π is half of the 4π over directions, as in B₂: the samples are integrals over r alone.
        let wanted = self.wanted_error_angstrom3(size) / (2.0 * PI);
        // The pilot sees too little of a heavy tail rather than too much.
        const MARGIN: f64 = 1.5;
        let needed = (MARGIN * variance / (wanted * wanted)).ceil();
        let replicas = u64::from(self.settings.replicas);
        // Enough for a spread between replicas to mean something.
        let least = 64 * replicas;
        let most = self.settings.most_directions.max(least);
        let directions = (needed as u64).clamp(least, most);
        Plan {
            proposal: choices.swap_remove(best),
            rounds: vec![directions.div_ceil(replicas)],
            sampled: 0,
        }
    }

    /// The hard part of B₂ to a few per cent, Å³.
    fn rough_hard(&self, pair: &BodyPair) -> f64 {
        let even = EvenSequence::new(&mut self.rng(u32::MAX, u64::MAX));
        const DIRECTIONS: u64 = 256;
        let covered = |number: u64| {
            let mut rng = self.rng(u32::MAX, number);
            let (covered, open) = hard_ray(pair, &even.orientation(number), &mut rng);
            // Without the openings: what surfaces exclude less what they leave open.
            covered - open
        };
        let rays: Vec<f64> = (0..DIRECTIONS).into_par_iter().map(covered).collect();
        2.0 * PI * rays.iter().sum::<f64>() / DIRECTIONS as f64
    }

    /// Directions that each replica still needs, by the spread of the replicas so far. The pilot may
    /// have missed wells that the replicas have met.
    fn further_directions(&self, pair: &BodyPair, plan: &Plan) -> u64 {
        let found = self.thermodynamics(pair);
        let size = found.b2_hard_angstrom3.max(found.b2_angstrom3.abs());
        let wanted = self.wanted_error_angstrom3(size);
        let so_far: u64 = plan.rounds.iter().sum();
        let ratio = found.b2_error_angstrom3 / wanted;
        // The error falls as the root of the number: n (ratio² - 1) more draws are missing.
        let missing = so_far as f64 * (ratio * ratio - 1.0);
        let replicas = u64::from(self.settings.replicas);
        let most = (self.settings.most_directions / replicas).saturating_sub(so_far);
        // The spread of few draws may be far off.
        const MOST_GROWTH: u64 = 6;
        (missing.max(0.0).ceil() as u64)
            .min(MOST_GROWTH * so_far)
            .min(most)
    }

    fn wanted_error_angstrom3(&self, size_angstrom3: f64) -> f64 {
        match self.settings.error_angstrom3 {
            Some(error) => error,
            None => self.settings.relative_error * size_angstrom3,
        }
    }

    /// One replica in one round.
    fn sample(&mut self, pair: &BodyPair, plan: &Plan) {
        let (number, step) = (plan.sampled as usize, self.step_of(plan));
        // The hard part once, in the first round; later rounds only add directions with energies.
        if self.replicas.len() == number {
            let (covered, open) = self.hard_part(pair, step);
            self.replicas.push(Replica {
                covered,
                open,
                directions: 0,
                soft: 0.0,
                bound: 0.0,
                bound_hard: 0.0,
                bins: Bins::default(),
            });
        }
        let count = plan.rounds.last().copied().unwrap_or(0);
        // A copy, as drawing borrows the estimator.
        let mut replica = self.replicas[number].clone();
        replica.directions += count;
        self.draw_and_keep(pair, step, &plan.proposal, count, |sample, density| {
            replica.add(&sample, 1.0 / density);
        });
        self.replicas[number] = replica;
    }

    /// The number of a step, for its own random numbers.
    fn step_of(&self, plan: &Plan) -> u32 {
        let whole_rounds = plan.rounds.len() as u32 - 1;
        Self::PILOT_STEPS as u32 + whole_rounds * self.settings.replicas + plan.sampled
    }

    /// Averages of what surfaces alone exclude, and leave open before contact, Å³.
    fn hard_part(&self, pair: &BodyPair, step: u32) -> (f64, f64) {
        // Numbers beyond any direction with energies, so the streams are disjoint.
        const HARD: u64 = 1 << 40;
        let even = EvenSequence::new(&mut self.rng(step, u64::MAX - 1));
        let count = self.settings.hard_rays();
        let ray = |number: u64| {
            let mut rng = self.rng(step, HARD + number);
            hard_ray(pair, &even.orientation(number), &mut rng)
        };
        let rays: Vec<(f64, f64)> = (0..count).into_par_iter().map(ray).collect();
        let (mut covered, mut open) = (0.0, 0.0);
        for (ray_covered, ray_open) in rays {
            covered += ray_covered / count as f64;
            open += ray_open / count as f64;
        }
        (covered, open)
    }

    /// Draws other directions than the replicas, a quarter of one's, for what lies outside of wells that are
    /// integrated apart; their number.
    pub(super) fn draw_rest(
        &self,
        pair: &BodyPair,
        // A quarter: the rest holds no deep wells and has a small variance.
        replica: u32,
        take: impl FnMut(RaySample, f64),
    ) -> u64 {
        let Some(plan) = &self.plan else { return 0 };
        let count = plan.rounds.iter().sum::<u64>().div_ceil(4).max(64);
        // Steps after the last of the estimator: fresh
        // random numbers, independent of the wells found.
        let step = Self::steps(&self.settings) as u32 + replica;
        self.draw(pair, step, &plan.proposal, count, take);
        count
    }

    /// Draws like [`draw`](Self::draw), and keeps the lowest poses.
    fn draw_and_keep(
        &mut self,
        pair: &BodyPair,
        step: u32,
        proposal: &Proposal,
        count: u64,
        mut take: impl FnMut(RaySample, f64),
    ) {
        let mut found = std::mem::take(&mut self.lowest);
        self.draw(pair, step, proposal, count, |sample, density| {
            if let Some(point) = sample.lowest() {
                found.push(Found {
                    pose: sample.orientation.pose(point.distance_angstrom),
                    energy_kt: point.energy_kt,
                });
            }
            // Thinned now and then: a long run meets more poses than memory should hold.
            if found.len() >= 2 * CHUNK as usize {
                found = lowest_apart(pair, std::mem::take(&mut found));
            }
            take(sample, density);
        });
        self.lowest = lowest_apart(pair, found);
    }

    /// Draws `count` orientations and hands each sample with its density to `take`, in order.
    fn draw(
        &self,
        pair: &BodyPair,
        step: u32,
        proposal: &Proposal,
        count: u64,
        mut take: impl FnMut(RaySample, f64),
    ) {
        let end = end_angstrom(pair);
        let even = EvenSequence::new(&mut self.rng(step, u64::MAX));
        let one = |number: u64| {
            let mut rng = self.rng(step, number);
            let orientation = proposal.draw(number, count, &even, &mut rng);
            // The density of the mixture, not of the component drawn from: lower variance, no bias.
            let density = proposal.density(&orientation, count);
            (RaySample::new(pair, orientation, end, &mut rng), density)
        };
        // In chunks and in order: sums have the same bits on any number of threads.
        for start in (0..count).step_by(CHUNK as usize) {
            let numbers = start..(start + CHUNK).min(count);
            let samples: Vec<_> = numbers.into_par_iter().map(one).collect();
            for (sample, density) in samples {
                take(sample, density);
            }
        }
    }

    fn rng(&self, step: u32, number: u64) -> CounterRng {
        CounterRng::for_purpose(self.settings.seed, step, number, Purpose::PairOrientation)
    }

    /// Settings of the sampling.
    pub fn settings(&self) -> &PairSettings {
        &self.settings
    }

    /// Volume that is covered up to contact, and its standard error, Å³.
    pub(super) fn covered_angstrom3(&self) -> (f64, f64) {
        let covered = |replica: &Replica| over_directions(replica.covered);
        mean_and_error(&self.replicas.iter().map(covered).collect::<Vec<f64>>())
    }

    /// Integral beyond the ends of the rays, ∫ (exp(-U) - 1) d³R, Å³.
    pub(super) fn tail_angstrom3(pair: &BodyPair) -> f64 {
        pair.potential.tail_angstrom3(end_angstrom(pair))
    }

    /// The averages over the replicas made so far.
    pub fn thermodynamics(&self, pair: &BodyPair) -> PairThermodynamics {
        let tail = Self::tail_angstrom3(pair);
        let over = |value: &dyn Fn(&Replica) -> f64| {
            let values: Vec<f64> = self.replicas.iter().map(value).collect();
            mean_and_error(&values)
        };
        // B₂ = -½ ∫ (e^{-U} - 1): covered volume counts +½, the soft part -½.
        let (b2, b2_error) = over(&|r| 0.5 * over_directions(r.covered - r.mean(r.soft)));
        let (hard, hard_error) = over(&|r| 0.5 * over_directions(r.covered - r.open));
        let (bound, bound_error) = over(&|r| over_directions(r.mean(r.bound)));
        let (bound_hard, _) = over(&|r| over_directions(r.mean(r.bound_hard)));
        let mut bins: Vec<Bins> = Vec::with_capacity(self.replicas.len());
        for replica in &self.replicas {
            bins.push(replica.bins.divided_by(replica.directions as f64));
        }
        PairThermodynamics {
            b2_angstrom3: b2 - 0.5 * tail,
            b2_error_angstrom3: b2_error,
            b2_hard_angstrom3: hard,
            b2_hard_error_angstrom3: hard_error,
            association_volume_angstrom3: bound,
            association_volume_error_angstrom3: bound_error,
            contact_volume_angstrom3: bound_hard,
            directions: self.replicas.iter().map(|r| r.directions).sum(),
            mean_force: mean_force(&bins),
        }
    }
}

impl Replica {
    /// The average over the directions with energies.
    fn mean(&self, sum: f64) -> f64 {
        sum / self.directions as f64
    }

    fn add(&mut self, sample: &RaySample, weight: f64) {
        self.soft += weight * sample.soft_angstrom3();
        for point in sample.points() {
            if point.in_contact {
                let volume = weight * point.volume_angstrom3;
                self.bound += volume * (-point.energy_kt).exp();
                self.bound_hard += volume;
            }
            self.bins.add(point, weight);
        }
    }
}

/// The lowest pose of each well, the lowest first.
fn lowest_apart(pair: &BodyPair, mut found: Vec<Found>) -> Vec<Found> {
    found.sort_by(|a, b| a.energy_kt.total_cmp(&b.energy_kt));
    apart(pair, found, KEPT_POSES)
}

/// End of the integrals along a ray, Å.
fn end_angstrom(pair: &BodyPair) -> f64 {
    let radii = pair.first.hard_radius_angstrom() + pair.second.hard_radius_angstrom();
    let contacts = radii + pair.contact_gap_angstrom;
    pair.potential.reach_angstrom(TAIL_ENERGY_KT).max(contacts)
}
