//! Counter-based random numbers: the state of a run is its step number.
//!
//! Philox4x32-10 (Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3",
//! SC11 (2011)) turns a 64-bit key and a 128-bit counter into 128 random bits, without memory. The
//! key is the seed; the counter is (step, replica, purpose, block). Two steps, replicas or purposes
//! never share numbers, and what a step draws does not depend on how many numbers the steps before
//! it drew, nor on the thread it runs on.

use crate::{Rotation, Vec3};
use nalgebra::{Quaternion, UnitQuaternion};
use rand_core::{Infallible, TryRng};
use std::f64::consts::TAU;

const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
const ROUNDS: usize = 10;
const PURPOSE_SHIFT: u32 = 24;

/// Purposes of random numbers.
///
/// Each purpose has its own streams, so that two uses of one seed never share numbers. The values
/// are part of every seeded result: a new purpose takes a new value, and no value ever changes. The
/// compiler refuses two equal ones.
///
/// ```
/// use protomer_kernel::random::{CounterRng, Purpose};
/// let draw = |purpose| CounterRng::for_purpose(7, 0, 0, purpose).uniform();
/// assert_eq!(draw(Purpose::Simulation), CounterRng::new(7, 0, 0).uniform());
/// assert_ne!(draw(Purpose::Simulation), draw(Purpose::Exchange));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Purpose {
    /// Steps of a simulation; initial weights of a network.
    Simulation = 0,
    /// Making an object: a body inserted into a fluid, the shape of a benchmark's body, the object of
    /// a control.
    Object = 1,
    /// Orientation of the object of a control.
    Turn = 2,
    /// Outliers that a control puts into potentials.
    Damage = 3,
    /// Labels of a control that are permuted.
    Label = 4,
    /// Charges of a benchmark's body.
    BenchmarkCharges = 5,
    /// A benchmark's bodies drawn together into a cluster.
    BenchmarkCluster = 6,
    /// A benchmark's bodies spread over a box.
    BenchmarkSpread = 7,
    /// Orientations of two bodies.
    PairOrientation = 8,
    /// The search for bound poses of two bodies.
    PairDescent = 9,
    /// Poses of one bound state.
    BoundState = 10,
    /// Configurations of the parts of an assembly.
    PartGrowth = 11,
    /// Windows of the parts of an assembly.
    PartWindows = 12,
    /// Protons that bodies take up and lose.
    ProtonMove = 13,
    /// The order in which samples are dealt into the parts of a split.
    Split = 60,
    /// Samples drawn with replacement for a confidence interval.
    Bootstrap = 61,
    /// Labels permuted for a p-value.
    Permutation = 62,
    /// The order of samples in an epoch.
    TrainingOrder = 63,
    /// Rotation of a sample in an epoch.
    TrainingRotation = 64,
    /// Initial angles of the squares of a lattice.
    LatticeAngles = 0x50,
    /// Initial velocities of the squares of a lattice.
    LatticeVelocities = 0x51,
    /// The orientation in which a structure is laid on a voxel grid.
    VoxelOrientation = 0x56,
    /// Noise of the thermostat before a step.
    ThermostatBefore = 0x58,
    /// Noise of the thermostat after a step.
    ThermostatAfter = 0x59,
    /// Velocities drawn from the Maxwell distribution.
    MaxwellVelocities = 0x5a,
    /// Settings of the trials of a search.
    TuningTrial = 0x5b,
    /// The first deviation that a Lyapunov exponent follows.
    LyapunovDirection = 0x60,
    /// Exchanges between the rungs of a ladder.
    Exchange = 0x61,
    /// Bodies scattered at random.
    Scatter = 0x62,
    /// Orientations at the start of contact dynamics.
    ContactStart = 0x70,
    /// Velocities at the start of contact dynamics.
    ContactVelocities = 0x71,
    /// The heat bath of contact dynamics.
    ContactBath = 0x72,
    /// Moves that form and dissolve contacts of bodies.
    BindingMove = 0x66,
    /// Trial moves of hard bodies.
    HardBodyMove = 0x63,
    /// The start of hard bodies: places, orientations, compression.
    HardBodyStart = 0x64,
    /// Points and bodies inserted among hard bodies to measure free volumes.
    HardBodyInsertion = 0x65,
    /// Three hard bodies, for their third virial coefficient.
    VirialTriple = 0x67,
    /// Rays and orientations of two hard bodies among depletants.
    VirialRay = 0x68,
    /// New velocities for frames of a finished run.
    ReseededVelocities = 0xf1,
}

/// The block function: ten rounds of Philox4x32.
fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..ROUNDS {
        let product_0 = u64::from(MULTIPLIERS[0]) * u64::from(counter[0]);
        // One round: high halves mix with their neighbours and the key, low halves pass on.
        let product_1 = u64::from(MULTIPLIERS[1]) * u64::from(counter[2]);
        counter = [
            (product_1 >> 32) as u32 ^ counter[1] ^ key[0],
            product_1 as u32,
            (product_0 >> 32) as u32 ^ counter[3] ^ key[1],
            product_0 as u32,
        ];
        // The key is bumped by a Weyl sequence: every round has another one.
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

/// The random numbers of one step of one replica.
///
/// A stream holds 2²⁴ blocks of four 32-bit words, far more than a step draws. It implements the
/// traits of `rand_core`, so every distribution of `rand` works on it.
///
/// ```
/// use protomer_kernel::random::CounterRng;
/// let draw = |step| CounterRng::new(7, 0, step).uniform();
/// assert_eq!(draw(12), draw(12)); // the same step gives the same numbers, whenever it is asked
/// assert_ne!(draw(12), draw(13));
/// ```
#[derive(Debug, Clone)]
pub struct CounterRng {
    key: [u32; 2],
    counter: [u32; 4],
    words: [u32; 4],
    used: usize,
}

impl CounterRng {
    /// The stream of this seed, replica and step of a simulation.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let (mut first, mut second) = (CounterRng::new(7, 0, 12), CounterRng::new(7, 1, 12));
    /// assert_ne!(first.uniform(), second.uniform(), "replicas share no numbers");
    /// ```
    pub fn new(seed: u64, replica: u32, step: u64) -> Self {
        Self::for_purpose(seed, replica, step, Purpose::Simulation)
    }

    /// The stream of this seed, replica and step for a purpose.
    ///
    /// ```
    /// use protomer_kernel::random::{CounterRng, Purpose};
    /// let mut split = CounterRng::for_purpose(7, 0, 0, Purpose::Split);
    /// let mut bootstrap = CounterRng::for_purpose(7, 0, 0, Purpose::Bootstrap);
    /// assert_ne!(split.uniform(), bootstrap.uniform());
    /// ```
    pub fn for_purpose(seed: u64, replica: u32, step: u64, purpose: Purpose) -> Self {
        Self {
            key: [seed as u32, (seed >> 32) as u32],
            counter: [
                step as u32,
                (step >> 32) as u32,
                replica,
                (purpose as u32) << PURPOSE_SHIFT,
            ],
            words: [0; 4],
            used: 4,
        }
    }

    fn word(&mut self) -> u32 {
        if self.used == self.words.len() {
            self.words = philox(self.counter, self.key);
            // Word 3 holds the purpose in its upper 8 bits; the count of blocks has the lower 24.
            self.counter[3] = self.counter[3].wrapping_add(1);
            self.used = 0;
        }
        let word = self.words[self.used];
        self.used += 1;
        word
    }

    fn two_words(&mut self) -> u64 {
        let low = u64::from(self.word());
        low | u64::from(self.word()) << 32
    }

    /// A number uniform in [0, 1), a multiple of 2⁻⁵³.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let mean = (0..10_000).map(|_| rng.uniform()).sum::<f64>() / 10_000.0;
    /// assert!((mean - 0.5).abs() < 0.02);
    /// ```
    pub fn uniform(&mut self) -> f64 {
        // 53 random bits: exactly the multiples of 2⁻⁵³, all of which a double holds.
        (self.two_words() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A number uniform in [low, high).
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// assert!((0..1000).all(|_| (-5.0..-3.0).contains(&rng.uniform_in(-5.0, -3.0))));
    /// ```
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// An index uniform in 0..count (0 for an empty range); the bias is below count / 2⁶⁴.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let mut counts = [0; 6];
    /// (0..6000).for_each(|_| counts[rng.index(6)] += 1);
    /// assert!(counts.iter().all(|count| (850..1150).contains(count)), "a fair die");
    /// ```
    pub fn index(&mut self, count: usize) -> usize {
        // The high half of the 128-bit product scales without a division and without rejection.
        ((u128::from(self.two_words()) * count as u128) >> 64) as usize
    }

    /// Two independent standard normal numbers from two uniform ones (Box and Muller, Ann. Math. Stat.
    /// 29, 610 (1958)).
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let sum: f64 = (0..1000).map(|_| rng.normal_pair()).map(|[x, y]| x * x + y * y).sum();
    /// assert!((sum / 2000.0 - 1.0).abs() < 0.1);
    /// ```
    pub fn normal_pair(&mut self) -> [f64; 2] {
        // 1 - u lies in (0, 1].
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sine, cosine) = (TAU * self.uniform()).sin_cos();
        [radius * cosine, radius * sine]
    }

    /// A standard normal number from two uniform ones, the first of [`Self::normal_pair`].
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let within_one = (0..10_000).filter(|_| rng.normal().abs() < 1.0).count();
    /// assert!((6600..7050).contains(&within_one), "68 % lie within one standard deviation");
    /// ```
    pub fn normal(&mut self) -> f64 {
        self.normal_pair()[0]
    }

    /// The time to the next event of a Poisson process of rate one.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let mean = (0..10_000).map(|_| rng.exponential()).sum::<f64>() / 10_000.0;
    /// assert!((mean - 1.0).abs() < 0.04);
    /// ```
    pub fn exponential(&mut self) -> f64 {
        // 1 - u lies in (0, 1].
        -(1.0 - self.uniform()).ln()
    }

    /// A direction uniform on the unit sphere.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, random::CounterRng};
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// assert!((rng.unit_vector().norm() - 1.0).abs() < 1e-12);
    /// let sum: Vec3 = (0..10_000).map(|_| rng.unit_vector()).sum();
    /// assert!(sum.norm() < 300.0, "no direction is preferred");
    /// ```
    pub fn unit_vector(&mut self) -> Vec3 {
        // Archimedes: z is uniform on the sphere.
        let z = self.uniform_in(-1.0, 1.0);
        let (sine, cosine) = (TAU * self.uniform()).sin_cos();
        // Rounding may make 1 - z² negative at the poles.
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * cosine, radius * sine, z)
    }

    /// A vector uniform in the ball of this radius.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let inner = (0..8000).filter(|_| rng.vector_in_ball(2.0).norm() < 1.0).count();
    /// assert!((850..1150).contains(&inner), "half of the radius holds an eighth of the volume");
    /// ```
    pub fn vector_in_ball(&mut self, radius: f64) -> Vec3 {
        let direction = self.unit_vector();
        // The volume within r grows as r³.
        direction * (radius * self.uniform().cbrt())
    }

    /// A rotation uniform over all rotations (Shoemake, Graphics Gems III (1992), 124).
    ///
    /// ```
    /// use protomer_kernel::{Vec3, random::CounterRng};
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let sum: Vec3 = (0..10_000).map(|_| rng.rotation() * Vec3::x()).sum();
    /// assert!(sum.norm() < 300.0, "no orientation is preferred");
    /// ```
    pub fn rotation(&mut self) -> Rotation {
        let u = self.uniform();
        let (sine_1, cosine_1) = (TAU * self.uniform()).sin_cos();
        let (sine_2, cosine_2) = (TAU * self.uniform()).sin_cos();
        let (near, far) = ((1.0 - u).sqrt(), u.sqrt());
        UnitQuaternion::new_normalize(Quaternion::new(
            far * cosine_2,
            near * sine_1,
            near * cosine_1,
            far * sine_2,
        ))
    }

    /// A rotation by at most `largest_angle_rad` whose rotation vector is uniform in a ball. A
    /// rotation and its inverse are equally likely, which is what a trial move needs.
    ///
    /// ```
    /// use protomer_kernel::random::CounterRng;
    /// let mut rng = CounterRng::new(1, 0, 0);
    /// let angles: Vec<f64> = (0..1000).map(|_| rng.small_rotation(0.1).angle()).collect();
    /// assert!(angles.iter().all(|angle| *angle <= 0.1) && angles.iter().any(|angle| *angle > 0.09));
    /// ```
    pub fn small_rotation(&mut self, largest_angle_rad: f64) -> Rotation {
        UnitQuaternion::from_scaled_axis(self.vector_in_ball(largest_angle_rad))
    }
}

impl TryRng for CounterRng {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.word())
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.two_words())
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        // A remainder below four bytes uses up a whole word, so later draws keep their places.
        for chunk in bytes.chunks_mut(4) {
            chunk.copy_from_slice(&self.word().to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt};

    /// The known answers that the authors publish with the algorithm (Random123, `kat_vectors`).
    #[test]
    fn philox_gives_the_published_answers() {
        let cases = [
            (
                [0; 4],
                [0; 2],
                [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8],
            ),
            (
                [u32::MAX; 4],
                [u32::MAX; 2],
                [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd],
            ),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, expected) in cases {
            assert_eq!(philox(counter, key), expected);
        }
    }

    #[test]
    fn streams_differ_in_every_word_of_their_name() {
        let first = |seed, replica, step, purpose| {
            CounterRng::for_purpose(seed, replica, step, purpose).next_u64()
        };
        let streams = [
            first(1, 0, 0, Purpose::Simulation),
            first(1 << 32, 0, 0, Purpose::Simulation),
            first(0, 1, 0, Purpose::Simulation),
            first(0, 0, 1, Purpose::Simulation),
            first(0, 0, 1 << 32, Purpose::Simulation),
            first(0, 0, 0, Purpose::Object),
        ];
        for (i, a) in streams.iter().enumerate() {
            assert!(streams[..i].iter().all(|b| a != b));
        }
    }

    #[test]
    fn it_serves_the_distributions_of_rand() {
        let mut rng = CounterRng::new(3, 1, 4);
        assert!((5..9).contains(&rng.random_range(5..9)));
        let mut bytes = [0; 7];
        rng.fill_bytes(&mut bytes);
        assert!(bytes.iter().any(|byte| *byte != 0));
    }

    #[test]
    fn moments_of_the_shapes_are_right() {
        const DRAWS: usize = 200_000;
        let mut rng = CounterRng::new(11, 0, 0);
        let mean = |value: &mut dyn FnMut() -> f64| {
            (0..DRAWS).map(|_| value()).sum::<f64>() / DRAWS as f64
        };
        // The error of each mean is below 1/sqrt(200 000) = 0.0022 times a standard deviation below
        // 1.
        assert!((mean(&mut || rng.uniform()) - 0.5).abs() < 4e-3);
        assert!((mean(&mut || rng.index(5) as f64 / 4.0) - 0.5).abs() < 4e-3);
        assert!((mean(&mut || rng.unit_vector().x.powi(2)) - 1.0 / 3.0).abs() < 4e-3);
        assert!(mean(&mut || rng.unit_vector().y).abs() < 8e-3);
        assert!((mean(&mut || rng.vector_in_ball(2.0).norm_squared() / 4.0) - 0.6).abs() < 4e-3);
        // A uniform rotation takes z to a uniform direction and has <w²> = 1/4.
        assert!((mean(&mut || (rng.rotation() * Vec3::z()).z.powi(2)) - 1.0 / 3.0).abs() < 4e-3);
        assert!((mean(&mut || rng.rotation().quaternion().w.powi(2)) - 0.25).abs() < 4e-3);
        assert!((mean(&mut || rng.small_rotation(0.1).angle() / 0.1) - 0.75).abs() < 4e-3);
        assert!(mean(&mut || rng.small_rotation(0.1).scaled_axis().x / 0.1).abs() < 4e-3);
    }
}
