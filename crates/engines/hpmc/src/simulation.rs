//! A run: equilibration, in which steps are tuned, and production, in which they are not.
//!
//! At constant pressure, a sweep ends with trial changes of the box (see [`box_moves`](crate::box_moves)).

use crate::body::HardBody;
use crate::box_moves::{BoxMoves, Pressure};
use crate::compression::Compression;
use crate::depletants::Counting;
use crate::field::{Both, Gravity, HeightTable, Nothing};
use crate::heights::{Heights, Walls};
use crate::mixture::Mixture;
use crate::potential::{Sum, Term};
use crate::reservoir::{Depletant, ball_volume};
use crate::start::{Placed, Start};
use crate::system::{Counts, MoveCounts, Steps, System};
use crate::{Error, Result, error::require};
use protomer_kernel::Rotation;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Acceptance that the steps are tuned to.
const ACCEPTANCE: f64 = 0.3;
/// Equilibration sweeps between two tunings.
const TUNE_EVERY: u64 = 10;
/// The part of the new value in the running estimate of the compressibility factor.
const NEW_PART: f64 = 0.3;
/// Stream of the points that are inserted.
const POINTS: u32 = 0;
/// Stream of the bodies that are inserted.
const BODIES: u32 = 1;
/// Stream of the points at the walls.
const WALLS: u32 = 2;
/// Stream of the exchanges of places.
const SWAPS: u32 = 1 << 24;
/// Streams of the changes of the box, in addition to that of the moves.
const BOX: u32 = 1 << 20;
/// Changes of the box in a sweep, so that their streams do not meet others.
const MOST_CHANGES: u32 = 10_000;
/// Smallest pressure or weight whose products with volumes and heights are numbers.
const SMALLEST_FORCE: f64 = 1e-100;
/// Largest such pressure or weight.
const LARGEST_FORCE: f64 = 1e100;

/// Settings of a run.
///
/// ```
/// use protomer_hpmc::reservoir::Depletant;
/// use protomer_hpmc::simulation::Settings;
/// use protomer_hpmc::field::Gravity;
/// use protomer_hpmc::box_moves::{Freedom, Pressure};
/// let gravity = Some(Gravity { weight_kt_per_length: 0.5 });
/// let settings = Settings { gravity, ..Settings::default() };
/// let depletants = [Depletant { radius: 0.1, fugacity: 1.0 }];
/// assert!(settings.check(&depletants).is_ok());
/// let pressure = Pressure { kt_per_volume: 2.0, freedom: Freedom::Volume, changes_per_sweep: None };
/// let both = Settings { pressure: Some(pressure), ..settings };
/// assert!(both.check(&[]).is_err(), "these do not go together");
/// ```
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
    /// Pressure, for a box that changes.
    pub pressure: Option<Pressure>,
    /// Gravity, for bodies between walls.
    pub gravity: Option<Gravity>,
    /// Terms of the energy of each pair of bodies; none for hard bodies alone.
    pub potential: Vec<Term>,
    /// Energy of each body by its last coordinate.
    pub field: Option<HeightTable>,
    /// Trial exchanges of the places of two bodies of different kinds in a sweep.
    pub swaps: usize,
}

impl Default for Settings {
    /// Bodies in a box that stays as it is.
    fn default() -> Self {
        Self {
            seed: 1,
            equilibration_sweeps: 0,
            insertions: 0,
            points: 1000,
            pressure: None,
            gravity: None,
            potential: Vec::new(),
            field: None,
            swaps: 0,
        }
    }
}

/// Averages over one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Compressibility factor of the bodies.
    pub compressibility_factor: f64,
    /// Part of the inserted bodies that overlap none, each weighed by exp(-u) with a potential; `None` without insertions.
    pub insertion_probability: Option<f64>,
    /// Free volume of each depletant as a part of the box.
    pub free_volume: Vec<f64>,
    /// The part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Pressures on the walls and mean height of the bodies, between walls.
    pub walls: Option<Walls>,
    /// Energy of all pairs over the number of bodies, kT; `None` without a potential.
    pub energy_kt_per_body: Option<f64>,
}

/// A state from which a run goes on as if it had not stopped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Sweeps done, with those of the equilibration.
    pub sweeps: u64,
    /// Lengths of the box.
    pub lengths: Vec<f64>,
    /// Tilt factors of the box.
    pub tilt_factors: Vec<f64>,
    /// Coordinates of the centres, body by body.
    pub positions: Vec<f64>,
    /// Orientations, scalar first.
    pub orientations_wxyz: Vec<[f64; 4]>,
    /// Largest steps.
    pub steps: Steps,
    /// Running estimate of the compressibility factor in the equilibration.
    pub rough_factor: f64,
    /// Depletants that forbid a move.
    pub counting: Counting,
    /// Moves of the equilibration by the rules of depletants: lost, covered.
    pub tried: [MoveCounts; 2],
    /// Moves of the production.
    pub counts: MoveCounts,
    /// Steps of the changes of the box.
    pub box_moves: BoxMoves,
    /// Exchanges of places of the production.
    #[serde(default, skip_serializing_if = "Counts::is_none")]
    pub swap_counts: Counts,
    /// Bodies by height, between walls, from samples of the production.
    pub heights: Vec<u64>,
}

impl Settings {
    /// Refuses what several kinds of bodies do not go with.
    fn check_mixture<const D: usize>(&self, mixture: &Mixture<D>) -> Result<()> {
        match mixture.kinds().len() > 1 && self.insertions > 0 {
            true => Err(Error::NotTogether {
                first: "several kinds of bodies",
                second: "insertions",
            }),
            false => Ok(()),
        }
    }

    /// The system with the potential of these settings.
    fn with_potential<const D: usize>(&self, system: System<D>) -> Result<System<D>> {
        match self.potential.as_slice() {
            [] => Ok(system),
            terms => system.with_potential(Arc::new(Sum::new(terms)?)),
        }
    }
}

impl State {
    /// The bodies where they are, with or without walls.
    ///
    /// # Errors
    /// For numbers that make no box, and for another number of orientations than of positions.
    pub fn placed<const D: usize>(&self, has_walls: bool) -> Result<Placed<D>> {
        let (positions, _) = self.positions.as_chunks::<D>();
        // NaN for a wrong number of lengths, which the box refuses with its own message.
        let lengths = self.lengths.as_slice().try_into().unwrap_or([f64::NAN; D]);
        let rotation = |[w, x, y, z]: &[f64; 4]| {
            // The numbers are those of a rotation that was normalised before it was saved.
            Rotation::new_unchecked(nalgebra::Quaternion::new(*w, *x, *y, *z))
        };
        let rotations: Vec<Rotation> = self.orientations_wxyz.iter().map(rotation).collect();
        if rotations.len() != positions.len() {
            return Err(Error::OutOfRange {
                quantity: "the number of saved orientations",
                value: rotations.len() as f64,
                requirement: "that of the positions; start again with --force",
            });
        }
        Ok(Placed {
            space: PeriodicBox::new(lengths, &self.tilt_factors)?,
            positions: positions.to_vec(),
            rotations,
            has_walls,
        })
    }
}

impl Settings {
    /// Checks what does not depend on the bodies.
    ///
    /// # Errors
    /// For impossible numbers, and for what cannot be simulated together.
    pub fn check(&self, depletants: &[Depletant]) -> Result<()> {
        let swaps = self.swaps as f64;
        require(
            "the number of exchanges per sweep",
            swaps,
            "at most 1e6",
            swaps <= 1e6,
        )?;
        let active = depletants.iter().any(|kind| kind.fugacity > 0.0);
        let fields = self.gravity.is_some() || self.field.is_some();
        if self.swaps > 0 && (active || fields) {
            return Err(Error::NotTogether {
                first: "exchanges of places",
                second: "depletants or a field",
            });
        }
        if let Some(pressure) = &self.pressure {
            let value = pressure.kt_per_volume;
            let holds = (SMALLEST_FORCE..=LARGEST_FORCE).contains(&value);
            require(
                "the pressure (kT per volume)",
                value,
                "from 1e-100 to 1e100",
                holds,
            )?;
            let changes = pressure.changes();
            require(
                "the number of changes of the box per sweep",
                f64::from(changes),
                "from 1 to 10000",
                (1..=MOST_CHANGES).contains(&changes),
            )?;
        }
        if let Some(gravity) = &self.gravity {
            let value = gravity.weight_kt_per_length;
            let holds = (0.0..=LARGEST_FORCE).contains(&value);
            require(
                "the weight of a body (kT per length)",
                value,
                "from 0 to 1e100",
                holds,
            )?;
        }
        if let Some(field) = &self.field {
            field.check()?;
        }
        if self.pressure.is_some() && self.field.is_some() {
            return Err(Error::NotTogether {
                first: "constant pressure",
                second: "a field",
            });
        }
        if self.pressure.is_some() && self.gravity.is_some() {
            return Err(Error::NotTogether {
                first: "constant pressure",
                second: "gravity between walls",
            });
        }
        if let Some(kind) = depletants.iter().find(|kind| kind.fugacity > 0.0)
            && self.pressure.is_some()
        {
            // Each change of the box draws all of them.
            let fugacity = kind.fugacity;
            require(
                "the fugacity of the depletants",
                fugacity,
                "at most 1e6 at constant pressure",
                fugacity <= 1e6,
            )?;
        }
        Ok(())
    }
}

/// Hard bodies that move.
///
/// ```
/// use protomer_hpmc::body::HardBody;
/// use protomer_hpmc::simulation::{Settings, Simulation};
/// use protomer_hpmc::start::Start;
/// use protomer_kernel::{Vec3, shape::Shape};
/// let ball = HardBody::<3>::new(&Shape::solid(&[Vec3::zeros()])?, 0.5)?;
/// let settings = Settings { equilibration_sweeps: 20, ..Settings::default() };
/// let mut simulation = Simulation::new(&settings, &ball, &[], &Start::fluid(64, 0.2))?;
/// simulation.run(100)?;
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
    box_moves: BoxMoves,
    swap_counts: Counts,
    heights: Heights,
    compression: Compression,
}

impl<const D: usize> Simulation<D> {
    /// A simulation of bodies at the start.
    ///
    /// # Errors
    /// As [`Start::make`]; also for depletants with impossible numbers.
    pub fn new(
        settings: &Settings,
        body: &HardBody<D>,
        depletants: &[Depletant],
        start: &Start<D>,
    ) -> Result<Self> {
        Self::new_unless(settings, body, depletants, start, &|| false)
    }

    /// Variant of [`new`](Self::new) that ends early when it must stop: bodies that are compressed
    /// take long.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Stopped`] if it had to stop.
    pub fn new_unless(
        settings: &Settings,
        body: &HardBody<D>,
        depletants: &[Depletant],
        start: &Start<D>,
        must_stop: &dyn Fn() -> bool,
    ) -> Result<Self> {
        let mixture = Mixture::equal(body.clone(), start.bodies());
        Self::of_mixture(settings, &mixture, depletants, start, must_stop)
    }

    /// A simulation of bodies of several kinds, as [`new_unless`](Self::new_unless).
    ///
    /// # Errors
    /// As [`new_unless`](Self::new_unless).
    pub fn of_mixture(
        settings: &Settings,
        mixture: &Mixture<D>,
        depletants: &[Depletant],
        start: &Start<D>,
        must_stop: &dyn Fn() -> bool,
    ) -> Result<Self> {
        settings.check_mixture(mixture)?;
        for kind in depletants {
            kind.check()?;
        }
        settings.check(depletants)?;
        // Points of a move grow with z times the volume: refused before it hangs.
        for kind in depletants {
            let around = ball_volume(D, mixture.widest() + kind.radius);
            let points = kind.fugacity * around;
            let requirement =
                "at most 1e7, because a move looks at each of them; give a lower fugacity";
            require(
                "the number of depletants around a body",
                points,
                requirement,
                points <= 1e7,
            )?;
        }
        let (system, steps) = start.make_mixture(mixture, depletants, settings.seed, must_stop)?;
        let system = settings.with_potential(system)?;
        let compression = Compression::new(&system, 1.0);
        let mut simulation = Self {
            settings: settings.clone(),
            box_moves: BoxMoves::new(system.space()),
            system,
            sweeps: 0,
            steps,
            rough_factor: 1.0,
            counting: Counting::Lost,
            tried: <[MoveCounts; 2]>::default(),
            counts: MoveCounts::default(),
            swap_counts: Counts::default(),
            heights: Heights::default(),
            compression,
        };
        // Two rounds: the first range of contractions may be too wide.
        // The first factor is a guess, the second is made with a range that fits.
        for _ in 0..2 {
            simulation.rough_factor = simulation.compression.rough_factor(&simulation.system);
            simulation.compression = Compression::new(&simulation.system, simulation.rough_factor);
        }
        Ok(simulation)
    }

    /// Resumes from a saved state.
    ///
    /// # Errors
    /// If the state does not belong to these bodies.
    pub fn resume(
        settings: &Settings,
        body: &HardBody<D>,
        depletants: &[Depletant],
        state: &State,
    ) -> Result<Self> {
        let mixture = Mixture::equal(body.clone(), state.positions.len() / D);
        Self::resume_mixture(settings, &mixture, depletants, state)
    }

    /// Resumes bodies of several kinds from a saved state.
    ///
    /// # Errors
    /// As [`resume`](Self::resume).
    pub fn resume_mixture(
        settings: &Settings,
        mixture: &Mixture<D>,
        depletants: &[Depletant],
        state: &State,
    ) -> Result<Self> {
        let placed = state.placed::<D>(settings.gravity.is_some())?;
        let count = placed.positions.len();
        require(
            "the number of saved bodies",
            count as f64,
            "that of the run",
            count == mixture.len(),
        )?;
        let system = System::of_mixture(
            mixture.clone(),
            depletants.to_vec(),
            placed.space,
            placed.positions,
            placed.rotations,
        )?;
        let system = match placed.has_walls {
            true => system.between_walls()?,
            false => system,
        };
        let system = settings.with_potential(system)?;
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
            box_moves: state.box_moves.clone(),
            swap_counts: state.swap_counts,
            heights: Heights(state.heights.clone()),
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
            lengths: self.system.space().lengths().to_vec(),
            tilt_factors: self.system.space().tilt_factors(),
            positions: self.system.positions().as_flattened().to_vec(),
            orientations_wxyz: self.system.rotations().iter().map(wxyz).collect(),
            steps: self.steps,
            rough_factor: self.rough_factor,
            counting: self.counting,
            tried: self.tried,
            counts: self.counts,
            box_moves: self.box_moves.clone(),
            swap_counts: self.swap_counts,
            heights: self.heights.0.clone(),
        }
    }

    /// Forgets what only makes the run faster: directions that separate bodies, the order in cells.
    pub fn refresh(&mut self) {
        self.system.refresh();
        self.compression = Compression::new(&self.system, self.rough_factor);
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

    /// Exchanges of places in the production so far.
    pub fn swap_counts(&self) -> &Counts {
        &self.swap_counts
    }

    /// Bodies by height, from the samples of the production; without walls, none.
    pub fn heights(&self) -> &Heights {
        &self.heights
    }

    /// The accepted part of the changes of the box, since their steps were tuned last.
    pub fn box_acceptance(&self) -> f64 {
        self.box_moves.acceptance()
    }

    /// The steps of the changes of the box.
    pub fn box_moves(&self) -> &BoxMoves {
        &self.box_moves
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
    ///
    /// # Errors
    /// [`Error::BoxShrinks`] if the box, at constant pressure, becomes too small for the bodies.
    pub fn run(&mut self, sweeps: u64) -> Result<()> {
        for _ in 0..sweeps {
            self.sweep()?;
        }
        Ok(())
    }

    fn sweep(&mut self) -> Result<()> {
        let equilibrates = self.is_equilibrating();
        // Two sweeps by one rule, two by the other.
        let number = (self.sweeps / 2 % 2) as usize;
        let mut counting = self.counting;
        if equilibrates && !self.system.depletants().is_empty() {
            counting = [Counting::Lost, Counting::Covered][number];
        }
        let mut counts = MoveCounts::default();
        let bodies = self.system.len() as u64;
        // Trials are numbered through the run, so a stop between sweeps changes nothing.
        for trial in self.sweeps * bodies..(self.sweeps + 1) * bodies {
            let mut rng =
                CounterRng::for_purpose(self.settings.seed, 0, trial, Purpose::HardBodyMove);
            let (system, steps, counts) = (&mut self.system, &self.steps, &mut counts);
            match (&mut self.settings.gravity, &mut self.settings.field) {
                (None, None) => system.trial(&mut rng, steps, counting, &mut Nothing, counts),
                (Some(gravity), None) => system.trial(&mut rng, steps, counting, gravity, counts),
                (None, Some(table)) => system.trial(&mut rng, steps, counting, table, counts),
                (Some(gravity), Some(table)) => {
                    let mut both = Both(gravity, table);
                    system.trial(&mut rng, steps, counting, &mut both, counts)
                }
            };
        }
        for number in 0..self.settings.swaps as u64 {
            let trial = self.sweeps * self.settings.swaps as u64 + number;
            let mut rng =
                CounterRng::for_purpose(self.settings.seed, SWAPS, trial, Purpose::HardBodyMove);
            let is_accepted = self.system.swap(&mut rng);
            if !equilibrates {
                self.swap_counts.note(is_accepted);
            }
        }
        if let Some(pressure) = self.settings.pressure {
            let changes = pressure.changes();
            // Streams of their own; `MOST_CHANGES` keeps them apart from others.
            for number in 0..changes {
                let (seed, stream) = (self.settings.seed, BOX + number);
                let mut rng =
                    CounterRng::for_purpose(seed, stream, self.sweeps, Purpose::HardBodyMove);
                let number = self.sweeps * u64::from(changes) + u64::from(number);
                self.box_moves
                    .change(&mut self.system, &pressure, number, &mut rng)?;
            }
        }
        self.sweeps += 1;
        if equilibrates {
            self.tried[number].add(&counts);
            self.equilibrate();
        } else {
            self.counts.add(&counts);
        }
        Ok(())
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
            // The other rule's moves say nothing about the steps for this one.
            both = self.tried[usize::from(covered > lost)];
        }
        if !is_last {
            self.steps
                .tune(&both, ACCEPTANCE, &self.system.longest_steps());
            if both.total().trials >= 2 * Steps::ENOUGH {
                self.tried = <[MoveCounts; 2]>::default();
            }
        }
        if !is_last {
            self.box_moves.tune();
        }
        let rough = self.compression.rough_factor(&self.system);
        // A running mean: one state alone is too noisy to set a range.
        self.rough_factor += NEW_PART * (rough - self.rough_factor);
        self.compression = Compression::new(&self.system, self.rough_factor);
    }

    /// Measures the state. The same state gives the same sample, but heights are counted.
    pub fn sample(&mut self) -> Sample {
        let free_volume = self.free_volume();
        let walls = self.settings.gravity.map(|gravity| {
            self.heights.count(&self.system);
            let density = self.system.len() as f64 / self.system.volume();
            let mut walls = Walls::from_system(&self.system, &gravity, density * self.rough_factor);
            self.add_depletants(&mut walls);
            walls
        });
        Sample {
            packing_fraction: self.system.packing_fraction(),
            walls,
            energy_kt_per_body: self
                .system
                .potential
                .is_some()
                .then(|| self.system.potential_energy_kt() / self.system.len() as f64),
            compressibility_factor: self.compression.factor(&self.system),
            insertion_probability: self.insertion_probability(),
            free_volume,
        }
    }

    /// Adds the pressure of the depletants on the walls: that of their reservoir on the part that they can touch.
    fn add_depletants(&self, walls: &mut Walls) {
        let mut rng = self.inserted(WALLS);
        for kind in self.system.depletants() {
            if kind.fugacity > 0.0 {
                let points = self.settings.points;
                let free = self.system.free_walls(kind.radius, points, &mut rng);
                for (pressure, free) in walls.pressures.iter_mut().zip(free) {
                    *pressure += kind.fugacity * free;
                }
            }
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

    /// The part of bodies inserted at random that overlap none (Widom, J. Chem. Phys. 39, 2808 (1963)); with a potential, each
    /// weighed by exp(-u).
    fn insertion_probability(&mut self) -> Option<f64> {
        let insertions = self.settings.insertions;
        if insertions == 0 {
            return None;
        }
        // By the sweep: the same state gives the same sample.
        let mut rng = self.inserted(BODIES);
        let mut free = 0.0;
        for _ in 0..insertions {
            // Centres at random in the whole box, also where a wall is in the way.
            let parts = std::array::from_fn(|_| rng.uniform());
            let place = self.system.space().point(&parts);
            let rotation = match D {
                2 => {
                    let angle = std::f64::consts::TAU * rng.uniform();
                    Rotation::from_scaled_axis(angle * protomer_kernel::Vec3::z())
                }
                _ => rng.rotation(),
            };
            if self.system.is_free(place, &rotation) {
                free += (-self.system.energy_of_inserted(place, &rotation)).exp();
            }
        }
        Some(free / insertions as f64)
    }

    fn inserted(&self, stream: u32) -> CounterRng {
        CounterRng::for_purpose(
            self.settings.seed,
            stream,
            self.sweeps,
            Purpose::HardBodyInsertion,
        )
    }
}
