//! The start of a run: a crystal, or bodies on a wide lattice, turned at random, that are compressed to
//! their packing fraction.
//!
//! The box shrinks a little at a time. Bodies that overlap then move as soon as they find a place
//! where they overlap none; if they do not in time, the step is taken back and halved.

use crate::body::HardBody;
use crate::crystal::Crystal;
use crate::depletants::Counting;
use crate::error::{require, require_packing_fraction};
use crate::field::Nothing;
use crate::mixture::Mixture;
use crate::reservoir::Depletant;
use crate::system::{
    MoveCounts, Steps, System, bodies_in_longer_box, first_that_works, least_edge,
};
use crate::{Error, Result};
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::TAU;

/// Stream of the orientations at the start.
const ORIENTATION: u32 = 0;
/// Stream of the moves of the compression.
const COMPRESSION: u32 = 1;
/// The first shrinking of the edge, as a part of it.
const FIRST_SHRINKING: f64 = 0.01;
/// The largest shrinking.
const LARGEST_SHRINKING: f64 = 0.02;
/// Bodies that can be compressed by less than this part have jammed.
const JAMMED: f64 = 1e-5;
/// Bodies that must be compressed begin with so many times the room of balls that touch on a lattice, in
/// which round bodies could not move at all.
const ROOM_AT_FIRST: f64 = 1.05;
/// Sweeps that may remove the overlaps of a shrinking.
const REPAIR_SWEEPS: usize = 100;
/// Moves of a body that overlaps, in one of these sweeps.
const TRIES: usize = 10;
/// Sweeps between two shrinkings.
const SWEEPS_BETWEEN: usize = 6;
/// Acceptance that steps are tuned to.
const ACCEPTANCE: f64 = 0.3;

/// Start of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Start<const D: usize> {
    /// Bodies at random.
    Fluid {
        /// Number of bodies.
        bodies: usize,
        /// Part of the box that the bodies fill.
        packing_fraction: f64,
        /// The edges of the box, relative to each other.
        edge_ratios: [f64; D],
        /// Whether hard walls close the box at both ends of the last axis.
        has_walls: bool,
    },
    /// Bodies on the sites of a crystal.
    Crystal(Crystal<D>),
    /// Bodies in given places.
    Placed(Placed<D>),
}

/// Bodies in given places, such as those of another simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed<const D: usize> {
    /// The box, with a corner at the origin.
    pub space: PeriodicBox<D>,
    /// The centres.
    pub positions: Vec<[f64; D]>,
    /// The orientations, one for each centre.
    pub rotations: Vec<Rotation>,
    /// Whether hard walls close the box at both ends of the last axis.
    pub has_walls: bool,
}

impl<const D: usize> Placed<D> {
    /// Part of the box that bodies of a volume fill.
    ///
    /// ```
    /// use protomer_hpmc::start::Placed;
    /// use protomer_kernel::{Rotation, periodic_box::PeriodicBox};
    /// let placed = Placed {
    ///     space: PeriodicBox::rectangular([4.0, 5.0])?,
    ///     positions: vec![[1.0, 1.0], [3.0, 3.0]],
    ///     rotations: vec![Rotation::identity(); 2],
    ///     has_walls: false,
    /// };
    /// assert_eq!(placed.packing_fraction(1.0), 0.1);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn packing_fraction(&self, body_volume: f64) -> f64 {
        self.positions.len() as f64 * body_volume / self.space.volume()
    }

    fn system(&self, mixture: &Mixture<D>, depletants: &[Depletant]) -> Result<System<D>> {
        let count = self.positions.len();
        require(
            "the number of bodies",
            count as f64,
            "at least 1",
            count > 0,
        )?;
        require(
            "the number of orientations",
            self.rotations.len() as f64,
            "that of the positions",
            self.rotations.len() == count,
        )?;
        let system = System::of_mixture(
            mixture.clone(),
            depletants.to_vec(),
            self.space,
            self.positions.clone(),
            self.rotations.clone(),
        )?;
        let system = match self.has_walls {
            true => system.between_walls()?,
            false => system,
        };
        match system.overlaps() {
            0 => Ok(system),
            overlaps => Err(Error::PlacedOverlap { overlaps }),
        }
    }
}

impl<const D: usize> Start<D> {
    /// Bodies at random in a periodic cube or square.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, start::Start};
    /// let ball = HardBody::<3>::ball(0.5)?;
    /// let (system, _) = Start::fluid(40, 0.2).make(&ball, &[], 1, &|| false)?;
    /// assert_eq!((system.len(), system.overlaps()), (40, 0));
    /// assert!((system.packing_fraction() - 0.2).abs() < 1e-9);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn fluid(bodies: usize, packing_fraction: f64) -> Self {
        Self::Fluid {
            bodies,
            packing_fraction,
            edge_ratios: [1.0; D],
            has_walls: false,
        }
    }

    /// The bodies in their places, and steps that suit them. Compressing many bodies takes long, so `must_stop`
    /// is asked often.
    ///
    /// # Errors
    /// For a packing fraction that cannot be reached, bodies that overlap in the crystal, and too few
    /// bodies; [`Error::Stopped`] if it had to stop.
    pub fn make(
        &self,
        body: &HardBody<D>,
        depletants: &[Depletant],
        seed: u64,
        must_stop: &dyn Fn() -> bool,
    ) -> Result<(System<D>, Steps)> {
        let mixture = Mixture::equal(body.clone(), self.bodies());
        self.make_mixture(&mixture, depletants, seed, must_stop)
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        match self {
            Self::Fluid { bodies, .. } => *bodies,
            Self::Crystal(crystal) => crystal.bodies(),
            Self::Placed(placed) => placed.positions.len(),
        }
    }

    /// Bodies of several kinds in their places, as [`make`](Self::make).
    ///
    /// # Errors
    /// As [`make`](Self::make); also for another number of bodies.
    pub fn make_mixture(
        &self,
        mixture: &Mixture<D>,
        depletants: &[Depletant],
        seed: u64,
        must_stop: &dyn Fn() -> bool,
    ) -> Result<(System<D>, Steps)> {
        let (count, wanted) = (mixture.len(), self.bodies());
        require(
            "the number of bodies",
            count as f64,
            "that of the start",
            count == wanted,
        )?;
        match self {
            Self::Crystal(crystal) => Ok((
                crystal.system_of(mixture, depletants)?,
                first_steps(mixture),
            )),
            Self::Placed(placed) => Ok((placed.system(mixture, depletants)?, first_steps(mixture))),
            Self::Fluid {
                bodies,
                packing_fraction,
                edge_ratios,
                has_walls,
            } => {
                let (bodies, packing) = (*bodies, *packing_fraction);
                check(bodies, packing, edge_ratios)?;
                let volume = mixture.mean_volume() / packing;
                let edges = edges(edge_ratios, bodies as f64 * volume);
                let (edge, least) = (shortest(&edges), least_edge(mixture.widest(), depletants));
                if edge < least {
                    let from = bodies_in_longer_box::<D>(bodies, least / edge);
                    let length =
                        |bodies| shortest(&self::edges(edge_ratios, bodies as f64 * volume));
                    let bodies = first_that_works(from, 1, |bodies| length(bodies) >= least);
                    return Err(Error::BoxTooSmall {
                        edge,
                        least,
                        bodies,
                    });
                }
                random_fluid(mixture, depletants, edges, *has_walls, seed, must_stop)
            }
        }
    }
}

/// Steps of bodies that stand in their places, before they are tuned.
fn first_steps<const D: usize>(mixture: &Mixture<D>) -> Steps {
    Steps {
        translation: 0.1 * mixture.widest(),
        rotation: 0.1,
    }
}

fn check(bodies: usize, packing_fraction: f64, edge_ratios: &[f64]) -> Result<()> {
    require_packing_fraction(packing_fraction)?;
    require(
        "the number of bodies",
        bodies as f64,
        "at least 1",
        bodies > 0,
    )?;
    for ratio in edge_ratios {
        require("an edge of the box", *ratio, "positive", *ratio > 0.0)?;
    }
    Ok(())
}

/// The edges of a box with these ratios and this volume.
fn edges<const D: usize>(ratios: &[f64; D], volume: f64) -> [f64; D] {
    let product: f64 = ratios.iter().product();
    let scale = (volume / product).powf(1.0 / D as f64);
    ratios.map(|ratio| scale * ratio)
}

fn shortest(edges: &[f64]) -> f64 {
    edges.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Bodies at random in a box.
fn random_fluid<const D: usize>(
    mixture: &Mixture<D>,
    depletants: &[Depletant],
    edges: [f64; D],
    has_walls: bool,
    seed: u64,
    must_stop: &dyn Fn() -> bool,
) -> Result<(System<D>, Steps)> {
    let (bodies, widest) = (mixture.len(), mixture.widest());
    // A lattice with room for all, filled as evenly as possible.
    let per_edge = sites_per_edge(&edges, bodies);
    let mut scale: f64 = 1.0;
    for (edge, sites) in edges.iter().zip(per_edge) {
        // Balls of the outer radius must fit; then no orientation overlaps.
        let wide = edge.max(sites as f64 * 2.0 * widest * (1.0 + 1e-9));
        if wide > *edge {
            scale = scale.max(ROOM_AT_FIRST * wide / edge);
        }
    }
    let wide = edges.map(|edge| edge * scale);
    let sites: usize = per_edge.iter().product();
    let (mut positions, mut rotations) = (Vec::new(), Vec::new());
    for number in 0..bodies {
        // Spread over all sites, not the first ones.
        let (mut site, mut position) = (number * sites / bodies, [0.0; D]);
        for axis in 0..D {
            let place = (site % per_edge[axis]) as f64 + 0.5;
            position[axis] = place * wide[axis] / per_edge[axis] as f64;
            site /= per_edge[axis];
        }
        positions.push(position);
        let body = mixture.body(number);
        rotations.push(orientation::<D>(body, seed, number as u64));
    }
    let depletants = depletants.to_vec();
    let space = PeriodicBox::rectangular(edges)?;
    let wide = PeriodicBox::rectangular(wide)?;
    // Without depletants: they would only slow the compression.
    let mut system = System::of_mixture(mixture.clone(), Vec::new(), wide, positions, rotations)?;
    if has_walls {
        system = system.between_walls()?;
    }
    let (system, steps) = Compressor::new(system, seed, must_stop)?.reach(&edges)?;
    let System {
        positions,
        rotations,
        ..
    } = system;
    // Into the wanted box, now with depletants: the bodies are in their places.
    let mut system = System::of_mixture(mixture.clone(), depletants, space, positions, rotations)?;
    if has_walls {
        system = system.between_walls()?;
    }
    Ok((system, steps))
}

/// Sites of a lattice with about equal spacings, at least as many as bodies.
fn sites_per_edge<const D: usize>(edges: &[f64; D], bodies: usize) -> [usize; D] {
    let longest = edges.iter().copied().fold(0.0, f64::max);
    let mut per_edge = [1; D];
    let mut along_longest = 1.0;
    while per_edge.iter().product::<usize>() < bodies {
        along_longest += 1.0;
        per_edge = edges.map(|edge| (along_longest * edge / longest - 1e-9).ceil() as usize);
    }
    per_edge
}

fn orientation<const D: usize>(body: &HardBody<D>, seed: u64, number: u64) -> Rotation {
    let mut rng = CounterRng::for_purpose(seed, ORIENTATION, number, Purpose::HardBodyStart);
    match (body.is_round(), D) {
        (true, _) => Rotation::identity(),
        (false, 2) => Rotation::from_scaled_axis(TAU * rng.uniform() * Vec3::z()),
        _ => rng.rotation(),
    }
}

/// Bodies that are being compressed.
struct Compressor<'a, const D: usize> {
    system: System<D>,
    steps: Steps,
    seed: u64,
    trials: u64,
    must_stop: &'a dyn Fn() -> bool,
}

impl<'a, const D: usize> Compressor<'a, D> {
    fn new(system: System<D>, seed: u64, must_stop: &'a dyn Fn() -> bool) -> Result<Self> {
        let steps = Steps {
            translation: 0.2 * system.widest,
            rotation: 0.2,
        };
        let mut compressor = Self {
            system,
            steps,
            seed,
            trials: 0,
            must_stop,
        };
        compressor.sweep(2 * SWEEPS_BETWEEN)?;
        Ok(compressor)
    }

    fn go_on(&self) -> Result<()> {
        match (self.must_stop)() {
            true => Err(Error::Stopped),
            false => Ok(()),
        }
    }

    fn reach(mut self, edges: &[f64; D]) -> Result<(System<D>, Steps)> {
        let mut shrinking = FIRST_SHRINKING;
        // All edges shrink alike, so the first one tells.
        while self.system.space.lengths()[0] > edges[0] {
            let before = self.system.clone();
            self.shrink(edges, 1.0 - shrinking)?;
            if self.repair()? {
                // Faster after success, slower after failure.
                shrinking = (1.4 * shrinking).min(LARGEST_SHRINKING);
            } else {
                let reached = before.packing_fraction();
                // Back to the state before: a failed shrinking leaves overlaps.
                self.system = before;
                shrinking *= 0.5;
                if shrinking < JAMMED {
                    let wanted = reached * self.system.volume() / edges.iter().product::<f64>();
                    return Err(Error::Jammed { reached, wanted });
                }
            }
            self.sweep(SWEEPS_BETWEEN)?;
        }
        Ok((self.system, self.steps))
    }

    /// Scales all lengths, down to the edges that are wanted.
    fn shrink(&mut self, edges: &[f64; D], scale: f64) -> Result<()> {
        let before = *self.system.space.lengths();
        // Never below the wanted edges; the last step lands on them exactly.
        let scale = scale.max(edges[0] / before[0]);
        let shrunk = match scale * before[0] <= edges[0] {
            true => *edges,
            false => before.map(|edge| edge * scale),
        };
        let scaled = |place: &[f64; D]| place.map(|x| x * scale);
        let system = System::of_mixture(
            self.system.mixture(),
            Vec::new(),
            PeriodicBox::rectangular(shrunk)?,
            self.system.positions.iter().map(scaled).collect(),
            self.system.rotations.clone(),
        )?;
        self.system = match self.system.has_walls() {
            true => system.between_walls()?,
            false => system,
        };
        Ok(())
    }

    fn rng(&mut self) -> CounterRng {
        self.trials += 1;
        CounterRng::for_purpose(self.seed, COMPRESSION, self.trials, Purpose::HardBodyStart)
    }

    /// Does sweeps without overlaps, and improves the steps.
    fn sweep(&mut self, sweeps: usize) -> Result<()> {
        let mut counts = MoveCounts::default();
        for _ in 0..sweeps {
            self.go_on()?;
            // Old steps say nothing about the new ones.
            if counts.total().trials > 3 * Steps::ENOUGH {
                counts = MoveCounts::default();
            }
            for _ in 0..self.system.len() {
                let mut rng = self.rng();
                self.system.trial(
                    &mut rng,
                    &self.steps,
                    Counting::Lost,
                    &mut Nothing,
                    &mut counts,
                );
            }
            let longest = self.system.longest_steps();
            self.steps.tune(&counts, ACCEPTANCE, &longest);
        }
        Ok(())
    }

    /// Whether moves removed all overlaps.
    fn repair(&mut self) -> Result<bool> {
        for _ in 0..REPAIR_SWEEPS {
            self.go_on()?;
            let overlapping = self.overlapping();
            if overlapping.is_empty() {
                return Ok(true);
            }
            for body in overlapping {
                for _ in 0..TRIES {
                    self.ease(Some(body));
                }
            }
            // The others make room.
            for _ in 0..self.system.len() {
                self.ease(None);
            }
        }
        Ok(self.overlapping().is_empty())
    }

    /// Moves a body, or any, if it then overlaps none.
    fn ease(&mut self, body: Option<usize>) {
        let mut rng = self.rng();
        // Small steps leave narrow places.
        let part = rng.uniform();
        let steps = Steps {
            translation: part * self.steps.translation,
            rotation: part * self.steps.rotation,
        };
        let trial = self.system.propose(&mut rng, &steps, body);
        // Were bodies that overlap free to move, they would merge, which makes room for the others.
        if !self.system.collides(&trial) {
            self.system.accept(&trial);
        }
    }

    fn overlapping(&self) -> Vec<usize> {
        let overlaps = |body: &usize| {
            let pose = self.system.where_it_is(*body);
            self.system.overlaps_of(&pose, |_| true) > 0
        };
        (0..self.system.len()).filter(overlaps).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::shape::Shape;

    /// Balls on a lattice in which they touch cannot move; they must not begin there.
    #[test]
    fn balls_are_compressed_beyond_the_lattice_on_which_they_begin() {
        let point = Shape::solid(&[Vec3::zeros()]).unwrap();
        let ball = HardBody::<3>::new(&point, 0.5).unwrap();
        for bodies in [108, 125] {
            let start = Start::fluid(bodies, 0.5);
            let (system, _) = start.make(&ball, &[], 1, &|| false).unwrap();
            assert_eq!(system.positions.len(), bodies);
        }
    }

    /// The number that an error names works, and one less does not.
    #[test]
    fn a_fluid_in_too_small_a_box_is_told_a_number_that_works() {
        let point = Shape::solid(&[Vec3::zeros()]).unwrap();
        let ball = HardBody::<3>::new(&point, 0.5).unwrap();
        let flat_box = |bodies: usize| Start::Fluid {
            bodies,
            packing_fraction: 0.3,
            edge_ratios: [1.0, 3.0, 0.4],
            has_walls: false,
        };
        let make = |bodies: usize| flat_box(bodies).make(&ball, &[], 1, &|| false);
        let Err(Error::BoxTooSmall { bodies, .. }) = make(2) else {
            unreachable!()
        };
        assert!(make(bodies).is_ok(), "{bodies}");
        assert!(matches!(
            make(bodies - 1),
            Err(Error::BoxTooSmall { bodies: again, .. }) if again == bodies
        ));
    }

    /// Bodies are put where they are given, across the border as well, and overlaps are counted.
    #[test]
    fn given_places_are_kept_and_overlaps_refused() {
        let disk = HardBody::<2>::ball(0.5).unwrap();
        let placed = |x: f64| {
            Start::Placed(Placed {
                space: PeriodicBox::rectangular([6.0, 5.0]).unwrap(),
                positions: vec![[0.4, 2.0], [x, 2.0]],
                rotations: vec![Rotation::identity(); 2],
                has_walls: false,
            })
        };
        let (system, _) = placed(3.0).make(&disk, &[], 1, &|| false).unwrap();
        assert_eq!(system.positions(), [[0.4, 2.0], [3.0, 2.0]]);
        for x in [1.2, 5.8] {
            let refused = placed(x).make(&disk, &[], 1, &|| false).unwrap_err();
            assert_eq!(refused, Error::PlacedOverlap { overlaps: 1 });
        }
    }

    #[test]
    fn a_start_stops_when_it_is_told_to() {
        let point = Shape::solid(&[Vec3::zeros()]).unwrap();
        let ball = HardBody::<3>::new(&point, 0.5).unwrap();
        let asked = std::cell::Cell::new(0);
        let stops = || {
            asked.set(asked.get() + 1);
            asked.get() > 5
        };
        let found = Start::fluid(64, 0.5).make(&ball, &[], 1, &stops);
        assert!(matches!(found, Err(Error::Stopped)));
        assert_eq!(asked.get(), 6);
    }
}
