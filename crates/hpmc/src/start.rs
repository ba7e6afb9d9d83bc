//! The start of a run: bodies on a wide lattice, turned at random, are compressed to their packing
//! fraction.
//!
//! The box shrinks a little at a time. Bodies that overlap then move as soon as they find a place
//! where they overlap none; if they do not in time, the step is taken back and halved.

use crate::body::HardBody;
use crate::depletants::{Counting, Depletant};
use crate::system::{MoveCounts, Steps, System};
use crate::{Error, Result, error::require};
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::TAU;

/// Streams of the start.
const ORIENTATION: u32 = 0;
const COMPRESSION: u32 = 1;
/// The first shrinking of the edge, as a part of it, and the largest.
const FIRST_SHRINKING: f64 = 0.01;
const LARGEST_SHRINKING: f64 = 0.02;
/// Bodies that can be compressed by less than this part have jammed.
const JAMMED: f64 = 1e-5;
/// Sweeps that may remove the overlaps of a shrinking.
const REPAIR_SWEEPS: usize = 100;
/// Moves of a body that overlaps, in one of these sweeps.
const TRIES: usize = 10;
/// Sweeps between two shrinkings.
const SWEEPS_BETWEEN: usize = 6;
const ACCEPTANCE: f64 = 0.3;

/// Bodies at random in a box of this packing fraction, and steps that suit them.
///
/// # Errors
/// For a packing fraction that cannot be reached, and too few bodies.
pub fn random_fluid<const D: usize>(
    body: &HardBody<D>,
    depletants: &[Depletant],
    bodies: usize,
    packing_fraction: f64,
    seed: u64,
) -> Result<(System<D>, Steps)> {
    require(
        "the packing fraction",
        packing_fraction,
        "between 0 and 1",
        packing_fraction > 0.0 && packing_fraction < 1.0,
    )?;
    require(
        "the number of bodies",
        bodies as f64,
        "at least 1",
        bodies > 0,
    )?;
    let edge = (bodies as f64 * body.volume / packing_fraction).powf(1.0 / D as f64);
    let per_edge = (1..)
        .find(|m: &usize| m.pow(D as u32) >= bodies)
        .unwrap_or(1);
    // The widest box comes first, so a box that is too small for the images is refused at once.
    let wide = edge.max(per_edge as f64 * 2.0 * body.outer_radius * (1.0 + 1e-9));
    let sites = per_edge.pow(D as u32);
    let (mut positions, mut rotations) = (Vec::new(), Vec::new());
    for number in 0..bodies {
        let (mut site, mut position) = (number * sites / bodies, [0.0; D]);
        for x in &mut position {
            *x = ((site % per_edge) as f64 + 0.5) * wide / per_edge as f64;
            site /= per_edge;
        }
        positions.push(position);
        rotations.push(orientation::<D>(body, seed, number as u64));
    }
    let depletants = depletants.to_vec();
    let hard = System::new(
        body.clone(),
        depletants.clone(),
        edge,
        Vec::new(),
        Vec::new(),
    );
    if let Err(Error::BoxTooSmall { edge, range, .. }) = hard {
        let density = bodies as f64 / edge.powi(D as i32);
        let bodies = (density * (2.0 * range).powi(D as i32)).ceil() as usize;
        return Err(Error::BoxTooSmall {
            edge,
            range,
            bodies,
        });
    }
    let system = System::new(body.clone(), Vec::new(), wide, positions, rotations)?;
    let (system, steps) = Compressor::new(system, seed).to(edge)?;
    let System {
        positions,
        rotations,
        ..
    } = system;
    let system = System::new(body.clone(), depletants, edge, positions, rotations)?;
    Ok((system, steps))
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
struct Compressor<const D: usize> {
    system: System<D>,
    steps: Steps,
    seed: u64,
    trials: u64,
}

impl<const D: usize> Compressor<D> {
    fn new(system: System<D>, seed: u64) -> Self {
        let steps = Steps {
            translation: 0.2 * system.body.outer_radius,
            rotation: 0.2,
        };
        let mut compressor = Self {
            system,
            steps,
            seed,
            trials: 0,
        };
        compressor.sweep(2 * SWEEPS_BETWEEN);
        compressor
    }

    fn to(mut self, edge: f64) -> Result<(System<D>, Steps)> {
        let mut shrinking = FIRST_SHRINKING;
        while self.system.edge > edge {
            let before = self.system.clone();
            self.shrink(edge.max(self.system.edge * (1.0 - shrinking)))?;
            if self.repair() {
                shrinking = (1.4 * shrinking).min(LARGEST_SHRINKING);
            } else {
                let reached = before.packing_fraction();
                self.system = before;
                shrinking *= 0.5;
                if shrinking < JAMMED {
                    let wanted = reached * (self.system.edge / edge).powi(D as i32);
                    return Err(Error::Jammed { reached, wanted });
                }
            }
            self.sweep(SWEEPS_BETWEEN);
        }
        Ok((self.system, self.steps))
    }

    fn shrink(&mut self, edge: f64) -> Result<()> {
        let scale = edge / self.system.edge;
        let moved = |place: &[f64; D]| place.map(|x| x * scale);
        self.system = System::new(
            self.system.body.clone(),
            Vec::new(),
            edge,
            self.system.positions.iter().map(moved).collect(),
            self.system.rotations.clone(),
        )?;
        Ok(())
    }

    fn rng(&mut self) -> CounterRng {
        self.trials += 1;
        CounterRng::for_purpose(self.seed, COMPRESSION, self.trials, Purpose::HardBodyStart)
    }

    /// Sweeps without overlaps, and better steps.
    fn sweep(&mut self, sweeps: usize) {
        let mut counts = MoveCounts::default();
        for _ in 0..sweeps {
            if counts.total().trials > 3 * Steps::ENOUGH {
                counts = MoveCounts::default();
            }
            for _ in 0..self.system.len() {
                let mut rng = self.rng();
                self.system
                    .trial(&mut rng, &self.steps, Counting::Lost, &mut counts);
            }
            let longest = self.system.longest_steps();
            self.steps.tune(&counts, ACCEPTANCE, &longest);
        }
    }

    /// Whether moves removed all overlaps.
    fn repair(&mut self) -> bool {
        for _ in 0..REPAIR_SWEEPS {
            let overlapping = self.overlapping();
            if overlapping.is_empty() {
                return true;
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
        self.overlapping().is_empty()
    }

    /// A move of a body, or of any, to where it overlaps none.
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
            let here = self.system.where_it_is(*body);
            self.system.overlaps_of(&here, |_| true) > 0
        };
        (0..self.system.len()).filter(overlaps).collect()
    }
}
