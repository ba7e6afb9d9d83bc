//! Hard bodies in a periodic box with right angles: which places are free, and trial moves.
//!
//! A trial move takes a body at random and moves or turns it by a random step; steps and their
//! opposites are equally likely. It is accepted if the body overlaps no other, if the field that acts
//! on it does (Metropolis), and if the depletants allow it (see [`depletants`](crate::depletants)).
//!
//! Hard walls can close the box at both ends of its last axis. Bodies between them do not reach the
//! images beyond, so nothing else changes. Random numbers of a trial depend on its number
//! alone, so a state and a number of trials say how a run goes on.

use crate::body::HardBody;
use crate::grid::{Grid, Near};
use crate::reservoir::Depletant;
use crate::{Error, Result};
use nalgebra::{Quaternion, UnitQuaternion};
use protomer_kernel::Rotation;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::{Block, Pair};
use rand_core::Rng;
use serde::{Deserialize, Serialize};

/// The longest components of a rotation step: tan of half an angle of nearly 180 degrees.
const LONGEST_TURN: f64 = 2.0;
/// Neighbours whose separating directions a body remembers; a power of two.
const SLOTS: usize = 32;
/// A multiplicative hash spreads neighbours over the slots.
const HASH: u32 = 0x9E37_79B1;
const NOBODY: u32 = u32::MAX;

/// Largest steps of the trial moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// Of a coordinate, in the unit of the bodies.
    pub translation: f64,
    /// Of a component of the rotation vector, as the tangent of half the angle.
    pub rotation: f64,
}

/// Trials and how many were accepted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Trials.
    pub trials: u64,
    /// Accepted trials.
    pub accepted: u64,
}

impl Counts {
    /// The accepted part; zero without trials.
    pub fn acceptance(&self) -> f64 {
        self.accepted as f64 / self.trials.max(1) as f64
    }

    pub(crate) fn note(&mut self, is_accepted: bool) {
        self.trials += 1;
        self.accepted += u64::from(is_accepted);
    }
}

/// Counts of both kinds of moves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoveCounts {
    /// Translations.
    pub translation: Counts,
    /// Rotations.
    pub rotation: Counts,
}

impl MoveCounts {
    pub(crate) fn add(&mut self, more: &Self) {
        for (sum, part) in [
            (&mut self.translation, &more.translation),
            (&mut self.rotation, &more.rotation),
        ] {
            sum.trials += part.trials;
            sum.accepted += part.accepted;
        }
    }

    /// All moves together.
    pub fn total(&self) -> Counts {
        Counts {
            trials: self.translation.trials + self.rotation.trials,
            accepted: self.translation.accepted + self.rotation.accepted,
        }
    }
}

/// The direction that separated two bodies last.
#[derive(Debug, Clone, Copy)]
struct Slot<const D: usize> {
    other: u32,
    direction: [f32; D],
}

/// What a body would be after a move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial<const D: usize> {
    pub body: usize,
    pub position: [f64; D],
    pub rotation: Rotation,
    /// Whether the corners for this rotation are in [`System::turned`].
    pub is_turned: bool,
}

/// Equal hard bodies in a periodic box of D dimensions.
#[derive(Debug, Clone)]
pub struct System<const D: usize> {
    pub(crate) body: HardBody<D>,
    pub(crate) edges: [f64; D],
    has_walls: bool,
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) rotations: Vec<Rotation>,
    /// The corners of all bodies, turned, each from the centre of its body.
    pub(crate) corners: Vec<Block<D>>,
    pub(crate) grid: Grid<D>,
    pub(crate) depletants: Vec<Depletant>,
    /// Corners of the body of a trial.
    pub(crate) turned: Vec<Block<D>>,
    pub(crate) near: Vec<Near<D>>,
    memory: Vec<Slot<D>>,
}

impl<const D: usize> System<D> {
    /// Bodies in a box from 0 to its edge along each axis. Places outside are wrapped. The bodies may
    /// overlap; see [`overlaps`](Self::overlaps).
    ///
    /// # Errors
    /// If a body could meet two images of another.
    pub fn new(
        body: HardBody<D>,
        depletants: Vec<Depletant>,
        edges: [f64; D],
        positions: Vec<[f64; D]>,
        rotations: Vec<Rotation>,
    ) -> Result<Self> {
        let reach = depletants
            .iter()
            .map(|kind| kind.radius)
            .fold(0.0, f64::max);
        let range = 2.0 * (body.outer_radius + reach);
        let edge = edges.iter().copied().fold(f64::INFINITY, f64::min);
        if edge < 2.0 * range {
            let bodies = positions.len() as f64 * (2.0 * range / edge).powi(D as i32);
            return Err(Error::BoxTooSmall {
                edge,
                range,
                bodies: (bodies - 1e-6).ceil() as usize,
            });
        }
        let blocks = body.blocks();
        let places: Vec<[f64; D]> = positions
            .iter()
            .map(|place| std::array::from_fn(|axis| wrapped(place[axis], edges[axis])))
            .collect();
        let mut system = Self {
            turned: vec![[[0.0; 4]; D]; blocks],
            corners: vec![[[0.0; 4]; D]; blocks * places.len()],
            grid: Grid::new(&edges, range, &places),
            body,
            edges,
            has_walls: false,
            positions: places,
            rotations,
            depletants,
            near: Vec::new(),
            memory: Vec::new(),
        };
        for (number, rotation) in system.rotations.iter().enumerate() {
            let corners = &mut system.corners[number * blocks..(number + 1) * blocks];
            system.body.turned_into(rotation, corners);
        }
        system.refresh();
        Ok(system)
    }

    /// Forgets everything but the places of the bodies: what follows depends on them alone.
    pub fn refresh(&mut self) {
        let range = 2.0 * (self.body.outer_radius + self.depletant_reach());
        self.grid = Grid::new(&self.edges, range, &self.positions);
        let empty = Slot {
            other: NOBODY,
            direction: [0.0; D],
        };
        self.memory.clear();
        if !self.body.is_round() {
            self.memory.resize(SLOTS * self.positions.len(), empty);
        }
    }

    fn depletant_reach(&self) -> f64 {
        self.depletants
            .iter()
            .map(|kind| kind.radius)
            .fold(0.0, f64::max)
    }

    /// The shape of the bodies.
    pub fn body(&self) -> &HardBody<D> {
        &self.body
    }

    /// Edges of the box.
    pub fn edges(&self) -> &[f64; D] {
        &self.edges
    }

    pub(crate) fn shortest_edge(&self) -> f64 {
        self.edges.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Volume of the box; in a plane, area.
    pub fn volume(&self) -> f64 {
        self.edges.iter().product()
    }

    /// The same bodies between hard walls at both ends of the last axis.
    pub fn between_walls(mut self) -> Self {
        self.has_walls = true;
        self
    }

    /// Whether there are walls.
    pub fn has_walls(&self) -> bool {
        self.has_walls
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The centres, from 0 to the edge along each axis.
    pub fn positions(&self) -> &[[f64; D]] {
        &self.positions
    }

    /// The orientations.
    pub fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }

    /// The depletants.
    pub fn depletants(&self) -> &[Depletant] {
        &self.depletants
    }

    /// The part of the box that the bodies fill.
    pub fn packing_fraction(&self) -> f64 {
        self.len() as f64 * self.body.volume / self.volume()
    }

    pub(crate) fn corners_of(&self, body: usize) -> &[Block<D>] {
        let blocks = self.body.blocks();
        &self.corners[body * blocks..(body + 1) * blocks]
    }

    /// The number of pairs that overlap, and of bodies that reach into a wall.
    pub fn overlaps(&self) -> usize {
        (0..self.len())
            .map(|body| self.overlaps_of(&self.where_it_is(body), |other| other as usize > body))
            .sum()
    }

    /// Whether any two overlap, or one reaches into a wall.
    pub(crate) fn has_overlaps(&self) -> bool {
        (0..self.len()).any(|body| {
            self.overlaps_of(&self.where_it_is(body), |other| other as usize > body) > 0
        })
    }

    /// Puts all bodies elsewhere.
    pub(crate) fn put_all(&mut self, positions: Vec<[f64; D]>, rotations: Vec<Rotation>) {
        self.positions = positions;
        for place in &mut self.positions {
            for (x, edge) in place.iter_mut().zip(&self.edges) {
                *x = wrapped(*x, *edge);
            }
        }
        self.rotations = rotations;
        let blocks = self.body.blocks();
        for (number, rotation) in self.rotations.iter().enumerate() {
            let corners = &mut self.corners[number * blocks..(number + 1) * blocks];
            self.body.turned_into(rotation, corners);
        }
        let range = 2.0 * (self.body.outer_radius + self.depletant_reach());
        self.grid = Grid::new(&self.edges, range, &self.positions);
    }

    /// Scales the box and the places in it along each axis, unless bodies overlap then or meet two
    /// images of each other; whether it did.
    pub(crate) fn try_rescale(&mut self, scales: &[f64; D]) -> bool {
        let before = (self.edges, self.positions.clone(), self.grid.clone());
        for axis in 0..D {
            self.edges[axis] *= scales[axis];
            for place in &mut self.positions {
                place[axis] = wrapped(place[axis] * scales[axis], self.edges[axis]);
            }
        }
        let range = 2.0 * (self.body.outer_radius + self.depletant_reach());
        if self.shortest_edge() >= 2.0 * range {
            self.grid = Grid::new(&self.edges, range, &self.positions);
            if !self.has_overlaps() {
                return true;
            }
        }
        (self.edges, self.positions, self.grid) = before;
        false
    }

    /// From the lower wall to the body and from the body to the upper wall; negative if it reaches in.
    pub(crate) fn gaps_to_walls(&self, trial: &Trial<D>) -> [f64; 2] {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for block in self.corners_of_trial(trial) {
            for x in block[D - 1] {
                low = low.min(x);
                high = high.max(x);
            }
        }
        let (place, rounding) = (trial.position[D - 1], self.body.rounding_radius);
        let top = self.edges[D - 1] - (place + high + rounding);
        [place + low - rounding, top]
    }

    fn reaches_into_wall(&self, trial: &Trial<D>) -> bool {
        if !self.has_walls {
            return false;
        }
        let height = trial.position[D - 1];
        let nearest = height.min(self.edges[D - 1] - height);
        if nearest >= self.body.outer_radius || nearest < self.body.inner_radius {
            return nearest < self.body.inner_radius;
        }
        self.gaps_to_walls(trial).iter().any(|gap| *gap < 0.0)
    }

    pub(crate) fn where_it_is(&self, body: usize) -> Trial<D> {
        Trial {
            body,
            position: self.positions[body],
            rotation: self.rotations[body],
            is_turned: false,
        }
    }

    /// How many of the other bodies that `counts` it would overlap.
    pub(crate) fn overlaps_of(&self, trial: &Trial<D>, counts: impl Fn(u32) -> bool) -> usize {
        let mut found = usize::from(self.reaches_into_wall(trial));
        let range = 2.0 * self.body.outer_radius;
        let but = trial.body as u32;
        self.grid
            .any_near(&trial.position, range * range, but, |near| {
                found += usize::from(counts(near.body) && self.is_overlap(trial, &near, 1.0));
                false
            });
        found
    }

    /// Whether the body of a trial overlaps another when all distances are scaled.
    pub(crate) fn is_overlap(&self, trial: &Trial<D>, other: &Near<D>, scale: f64) -> bool {
        let (inner, outer) = (2.0 * self.body.inner_radius, 2.0 * self.body.outer_radius);
        let squared = other.squared * scale * scale;
        if squared < inner * inner || squared >= outer * outer {
            return squared < outer * outer;
        }
        let pair = Pair {
            first: self.corners_of_trial(trial),
            second: self.corners_of(other.body as usize),
            offset: other.offset.map(|x| x * scale),
            reach: 2.0 * self.body.rounding_radius,
            error: self.body.error_of_heights(),
        };
        pair.overlap(&mut { other.offset }, || self.body.exact(&pair))
    }

    pub(crate) fn corners_of_trial(&self, trial: &Trial<D>) -> &[Block<D>] {
        if trial.is_turned {
            &self.turned
        } else {
            self.corners_of(trial.body)
        }
    }

    /// Whether a body at a place, turned so, overlaps none. Its corners are left in `turned`.
    pub(crate) fn is_free(&mut self, position: [f64; D], rotation: &Rotation) -> bool {
        self.body.turned_into(rotation, &mut self.turned);
        let trial = Trial {
            body: NOBODY as usize,
            position,
            rotation: *rotation,
            is_turned: true,
        };
        let range = 2.0 * self.body.outer_radius;
        !self.reaches_into_wall(&trial)
            && !self
                .grid
                .any_near(&position, range * range, NOBODY, |near| {
                    self.is_overlap(&trial, &near, 1.0)
                })
    }

    /// Whether the body would overlap another; fast, by the directions that separated them last.
    pub(crate) fn collides(&mut self, trial: &Trial<D>) -> bool {
        if self.reaches_into_wall(trial) {
            return true;
        }
        let Self {
            body,
            grid,
            near,
            corners,
            turned,
            memory,
            ..
        } = self;
        let outer = 2.0 * body.outer_radius;
        let own = trial.body as u32;
        if body.is_round() {
            return grid.any_near(&trial.position, outer * outer, own, |_| true);
        }
        let inner = 4.0 * body.inner_radius * body.inner_radius;
        near.clear();
        let is_deep = grid.any_near(&trial.position, outer * outer, own, |other| {
            near.push(other);
            other.squared < inner
        });
        if is_deep {
            return true;
        }
        let blocks = body.blocks();
        let slots = &mut memory[trial.body * SLOTS..(trial.body + 1) * SLOTS];
        let first = if trial.is_turned {
            &turned[..]
        } else {
            &corners[trial.body * blocks..(trial.body + 1) * blocks]
        };
        let error = body.error_of_heights();
        let pair_with = |other: &Near<D>| {
            let number = other.body as usize;
            Pair {
                first,
                second: &corners[number * blocks..(number + 1) * blocks],
                offset: other.offset,
                reach: 2.0 * body.rounding_radius,
                error,
            }
        };
        let place = |other: u32| (other.wrapping_mul(HASH) >> 27) as usize;
        near.retain(|other| {
            let slot = &slots[place(other.body)];
            slot.other != other.body
                || !pair_with(other).is_separated_along(&slot.direction.map(f64::from))
        });
        // The nearest is the likeliest to overlap.
        near.sort_unstable_by(|a, b| a.squared.total_cmp(&b.squared));
        for other in near.iter() {
            let slot = &mut slots[place(other.body)];
            let pair = pair_with(other);
            let mut direction = other.offset;
            if pair.overlap(&mut direction, || body.exact(&pair)) {
                return true;
            }
            *slot = Slot {
                other: other.body,
                direction: direction.map(|x| x as f32),
            };
        }
        false
    }

    /// A body, or any, moved or turned at random.
    pub(crate) fn propose(
        &mut self,
        rng: &mut CounterRng,
        steps: &Steps,
        body: Option<usize>,
    ) -> Trial<D> {
        let word = rng.next_u32();
        let any = (u64::from(word >> 1) * self.positions.len() as u64) >> 31;
        let body = body.unwrap_or(any as usize);
        let is_turned = !self.body.is_round() && word & 1 == 1;
        let mut trial = Trial {
            is_turned,
            ..self.where_it_is(body)
        };
        if is_turned {
            let mut turn = [0.0; 3];
            for axis in if D == 2 { 2..3 } else { 0..3 } {
                turn[axis] = steps.rotation * symmetric(rng);
            }
            let [x, y, z] = turn;
            let turn = UnitQuaternion::new_normalize(Quaternion::new(1.0, x, y, z));
            let turned = (turn * trial.rotation).into_inner();
            trial.rotation = UnitQuaternion::new_normalize(turned);
            self.body.turned_into(&trial.rotation, &mut self.turned);
        } else {
            let periodic = D - usize::from(self.has_walls);
            for (axis, x) in trial.position.iter_mut().enumerate() {
                *x += steps.translation * symmetric(rng);
                if axis == periodic {
                    break;
                }
                let edge = self.edges[axis];
                if *x < 0.0 {
                    *x += edge;
                }
                // Also where a tiny negative number has been rounded to the edge.
                if *x >= edge {
                    *x -= edge;
                }
            }
        }
        trial
    }

    pub(crate) fn accept(&mut self, trial: &Trial<D>) {
        let body = trial.body;
        if trial.is_turned {
            let blocks = self.body.blocks();
            self.corners[body * blocks..(body + 1) * blocks].copy_from_slice(&self.turned);
            self.rotations[body] = trial.rotation;
        } else {
            self.positions[body] = trial.position;
            self.grid.moved(body, &self.positions);
        }
    }

    /// From a place to the nearest image of another.
    pub(crate) fn nearest_image(&self, from: &[f64; D], to: &[f64; D]) -> [f64; D] {
        let mut step = [0.0; D];
        for axis in 0..D {
            let (along, edge) = (to[axis] - from[axis], self.edges[axis]);
            step[axis] = along - edge * (along / edge).round();
        }
        step
    }

    /// The longest steps that make sense.
    pub(crate) fn longest_steps(&self) -> Steps {
        Steps {
            translation: 0.5 * self.shortest_edge(),
            rotation: LONGEST_TURN,
        }
    }
}

/// A coordinate in the box, from 0 to less than its edge.
fn wrapped(x: f64, edge: f64) -> f64 {
    let inside = x.rem_euclid(edge);
    if inside < edge { inside } else { 0.0 }
}

/// A number in (-1, 1), as likely as its opposite.
fn symmetric(rng: &mut CounterRng) -> f64 {
    (f64::from(rng.next_u32()) + 0.5) / f64::from(1_u32 << 31) - 1.0
}

impl Steps {
    /// Fewer trials say little.
    pub(crate) const ENOUGH: u64 = 300;

    /// Changes the steps towards an acceptance, by what they gave.
    pub(crate) fn tune(&mut self, counts: &MoveCounts, wanted: f64, longest: &Self) {
        let change = |step: &mut f64, counts: &Counts, longest: f64| {
            if counts.trials >= Self::ENOUGH {
                let factor = (counts.acceptance() / wanted).clamp(0.5, 1.5);
                *step = (*step * factor).clamp(1e-9 * longest, longest);
            }
        };
        change(
            &mut self.translation,
            &counts.translation,
            longest.translation,
        );
        change(&mut self.rotation, &counts.rotation, longest.rotation);
    }
}
