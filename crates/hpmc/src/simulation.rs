//! A run: equilibration, in which steps are tuned, and production, in which they are not.

use crate::body::HardBody;
use crate::compression::Compression;
use crate::depletants::{Counting, Depletant};
use crate::start::random_fluid;
use crate::system::{MoveCounts, Steps, System};
use crate::{Error, Result};
use protomer_kernel::Rotation;
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};

/// Acceptance that the steps are tuned to.
const ACCEPTANCE: f64 = 0.3;
/// Equilibration sweeps between two tunings.
const TUNE_EVERY: u64 = 10;
/// The part of the new value in the running estimate of the compressibility factor.
const NEW_PART: f64 = 0.3;
/// Streams of what is inserted.
const POINTS: u32 = 0;
const BODIES: u32 = 1;

/// What a run does.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Sweeps in which the steps are tuned.
    pub equilibration_sweeps: u64,
    /// Bodies inserted at random per sample, to measure the chemical potential.
    pub insertions: usize,
    /// Points per sample, to measure the free volume of each depletant.
    pub points: usize,
}

/// Averages over one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Compressibility factor of the bodies.
    pub compressibility_factor: f64,
    /// Part of the inserted bodies that overlap none; `None` without insertions.
    pub insertion_probability: Option<f64>,
    /// Free volume of each depletant as a part of the box.
    pub free_volume: Vec<f64>,
}

/// A state from which a run goes on as if it had not stopped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Sweeps done, with those of the equilibration.
    pub sweeps: u64,
    /// Edge of the box.
    pub edge: f64,
    /// Coordinates of the centres, body by body.
    pub positions: Vec<f64>,
    /// Orientations, scalar first.
    pub orientations_wxyz: Vec<[f64; 4]>,
    /// Largest steps.
    pub steps: Steps,
    /// Running estimate of the compressibility factor in the equilibration.
    pub rough_factor: f64,
    /// Which depletants forbid a move.
    pub counting: Counting,
    /// Moves of the equilibration by the rules of depletants: lost, covered.
    pub tried: [MoveCounts; 2],
    /// Moves of the production.
    pub counts: MoveCounts,
}

/// Hard bodies that move.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_hpmc::simulation::{Settings, Simulation};
/// use protomer_kernel::{Vec3, shape::Shape};
/// let ball = HardBody::<3>::new(&Shape::solid(&[Vec3::zeros()])?, 0.5)?;
/// let settings = Settings { seed: 1, equilibration_sweeps: 20, insertions: 0, points: 1000 };
/// let mut simulation = Simulation::new(&settings, &ball, &[], 64, 0.2)?;
/// simulation.run(100);
/// assert_eq!(simulation.system().overlaps(), 0);
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation<const D: usize> {
    settings: Settings,
    system: System<D>,
    sweeps: u64,
    steps: Steps,
    rough_factor: f64,
    counting: Counting,
    tried: [MoveCounts; 2],
    counts: MoveCounts,
    compression: Compression,
}

impl<const D: usize> Simulation<D> {
    /// Bodies compressed to a packing fraction.
    ///
    /// # Errors
    /// As [`random_fluid`]; also for depletants with impossible numbers.
    pub fn new(
        settings: &Settings,
        body: &HardBody<D>,
        depletants: &[Depletant],
        bodies: usize,
        packing_fraction: f64,
    ) -> Result<Self> {
        for kind in depletants {
            kind.check()?;
        }
        let (system, steps) =
            random_fluid(body, depletants, bodies, packing_fraction, settings.seed)?;
        let compression = Compression::new(&system, 1.0);
        let mut simulation = Self {
            settings: settings.clone(),
            system,
            sweeps: 0,
            steps,
            rough_factor: 1.0,
            counting: Counting::Lost,
            tried: <[MoveCounts; 2]>::default(),
            counts: MoveCounts::default(),
            compression,
        };
        // Two rounds: the first range of contractions may be too wide.
        for _ in 0..2 {
            simulation.rough_factor = simulation.compression.rough_factor(&simulation.system);
            simulation.compression = Compression::new(&simulation.system, simulation.rough_factor);
        }
        Ok(simulation)
    }

    /// From a saved state.
    ///
    /// # Errors
    /// If the state does not belong to these bodies.
    pub fn resume(
        settings: &Settings,
        body: &HardBody<D>,
        depletants: &[Depletant],
        state: &State,
    ) -> Result<Self> {
        let (positions, _) = state.positions.as_chunks::<D>();
        let rotation = |[w, x, y, z]: &[f64; 4]| {
            // The numbers are those of a rotation that was normalised before it was saved.
            Rotation::new_unchecked(nalgebra::Quaternion::new(*w, *x, *y, *z))
        };
        let rotations: Vec<Rotation> = state.orientations_wxyz.iter().map(rotation).collect();
        if rotations.len() != positions.len() {
            return Err(Error::OutOfRange {
                quantity: "the number of saved orientations",
                value: rotations.len() as f64,
                requirement: "that of the positions; start again with --force",
            });
        }
        let system = System::new(
            body.clone(),
            depletants.to_vec(),
            state.edge,
            positions.to_vec(),
            rotations,
        )?;
        let compression = Compression::new(&system, state.rough_factor);
        Ok(Self {
            settings: settings.clone(),
            system,
            sweeps: state.sweeps,
            steps: state.steps,
            rough_factor: state.rough_factor,
            counting: state.counting,
            tried: state.tried,
            counts: state.counts,
            compression,
        })
    }

    /// The state. Call [`refresh`](Self::refresh) before going on, so that this run does what one from
    /// the state does.
    pub fn state(&self) -> State {
        let wxyz = |rotation: &Rotation| {
            let q = rotation.quaternion();
            [q.w, q.i, q.j, q.k]
        };
        State {
            sweeps: self.sweeps,
            edge: self.system.edge(),
            positions: self.system.positions().as_flattened().to_vec(),
            orientations_wxyz: self.system.rotations().iter().map(wxyz).collect(),
            steps: self.steps,
            rough_factor: self.rough_factor,
            counting: self.counting,
            tried: self.tried,
            counts: self.counts,
        }
    }

    /// Forgets what only makes the run faster: directions that separate bodies, the order in cells.
    pub fn refresh(&mut self) {
        self.system.refresh();
    }

    /// The bodies.
    pub fn system(&self) -> &System<D> {
        &self.system
    }

    /// Sweeps done, with those of the equilibration.
    pub fn sweeps(&self) -> u64 {
        self.sweeps
    }

    /// Moves of the production so far.
    pub fn counts(&self) -> &MoveCounts {
        &self.counts
    }

    /// The steps.
    pub fn steps(&self) -> &Steps {
        &self.steps
    }

    /// Whether the steps are still tuned.
    pub fn is_equilibrating(&self) -> bool {
        self.sweeps < self.settings.equilibration_sweeps
    }

    /// Does sweeps, each of as many trial moves as there are bodies.
    pub fn run(&mut self, sweeps: u64) {
        for _ in 0..sweeps {
            self.sweep();
        }
    }

    fn sweep(&mut self) {
        let equilibrates = self.is_equilibrating();
        let number = (self.sweeps / 2 % 2) as usize;
        let mut counting = self.counting;
        if equilibrates && !self.system.depletants().is_empty() {
            counting = [Counting::Lost, Counting::Covered][number];
        }
        let mut counts = MoveCounts::default();
        let bodies = self.system.len() as u64;
        for trial in self.sweeps * bodies..(self.sweeps + 1) * bodies {
            let mut rng =
                CounterRng::for_purpose(self.settings.seed, 0, trial, Purpose::HardBodyMove);
            self.system
                .trial(&mut rng, &self.steps, counting, &mut counts);
        }
        self.sweeps += 1;
        if equilibrates {
            self.tried[number].add(&counts);
            self.equilibrate();
        } else {
            self.counts.add(&counts);
        }
    }

    /// Tunes the steps and the range of compressions; at the end fixes them.
    fn equilibrate(&mut self) {
        let is_last = !self.is_equilibrating();
        if !self.sweeps.is_multiple_of(TUNE_EVERY) && !is_last {
            return;
        }
        let mut both = self.tried[0];
        both.add(&self.tried[1]);
        if !self.system.depletants().is_empty() {
            let [lost, covered] = self.tried.map(|counts| counts.total().acceptance());
            self.counting = match covered > lost {
                true => Counting::Covered,
                false => Counting::Lost,
            };
            // The steps are for the rule that stays.
            both = self.tried[usize::from(covered > lost)];
        }
        if !is_last {
            self.steps
                .tune(&both, ACCEPTANCE, &self.system.longest_steps());
            if both.total().trials >= 2 * Steps::ENOUGH {
                self.tried = <[MoveCounts; 2]>::default();
            }
        }
        let rough = self.compression.rough_factor(&self.system);
        self.rough_factor += NEW_PART * (rough - self.rough_factor);
        self.compression = Compression::new(&self.system, self.rough_factor);
    }

    /// Measures the state. The same state gives the same sample.
    pub fn sample(&mut self) -> Sample {
        let free_volume = self.free_volume();
        Sample {
            compressibility_factor: self.compression.factor(&self.system),
            insertion_probability: self.insertion_probability(),
            free_volume,
        }
    }

    fn free_volume(&self) -> Vec<f64> {
        let mut rng = self.inserted(POINTS);
        let mut fractions = Vec::new();
        for kind in self.system.depletants() {
            let points = self.settings.points;
            fractions.push(self.system.free_volume(kind.radius, points, &mut rng));
        }
        fractions
    }

    /// The part of bodies inserted at random that overlap none (Widom, J. Chem. Phys. 39, 2808 (1963)).
    fn insertion_probability(&mut self) -> Option<f64> {
        let insertions = self.settings.insertions;
        if insertions == 0 {
            return None;
        }
        let mut rng = self.inserted(BODIES);
        let mut free = 0;
        for _ in 0..insertions {
            let edge = self.system.edge();
            let mut place = [0.0; D];
            for x in &mut place {
                *x = edge * rng.uniform();
            }
            let rotation = match D {
                2 => {
                    let angle = std::f64::consts::TAU * rng.uniform();
                    Rotation::from_scaled_axis(angle * protomer_kernel::Vec3::z())
                }
                _ => rng.rotation(),
            };
            free += usize::from(self.system.is_free(place, &rotation));
        }
        Some(free as f64 / insertions as f64)
    }

    fn inserted(&self, what: u32) -> CounterRng {
        CounterRng::for_purpose(
            self.settings.seed,
            what,
            self.sweeps,
            Purpose::HardBodyInsertion,
        )
    }
}
