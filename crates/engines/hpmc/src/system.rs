//! Hard bodies in a periodic box: which places are free, and trial moves.
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
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::{Block, dot};
use rand_core::Rng;
use serde::{Deserialize, Serialize};

/// The longest components of a rotation step: tan of half an angle of nearly 180 degrees.
const LONGEST_TURN: f64 = 2.0;
/// Neighbours whose separating directions a body remembers; a power of two.
const SLOTS: usize = 32;
/// A multiplicative hash spreads neighbours over the slots.
const HASH: u32 = 0x9E37_79B1;
/// The number that stands for no body.
const NOBODY: u32 = u32::MAX;

/// Outcome of an attempt to deform the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Deformation {
    /// The box is deformed.
    Done,
    /// Bodies would overlap; nothing has changed.
    Blocked,
    /// No two bodies overlap, but the box would be too small to tell whether a body meets its own images;
    /// nothing has changed.
    TooSmall,
}

/// Largest steps of the trial moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steps {
    /// Largest step of a coordinate, in the unit of the bodies.
    pub translation: f64,
    /// Largest step of a component of the rotation vector, as the tangent of half the angle.
    pub rotation: f64,
}

/// Trials and how many were accepted.
///
/// ```
/// use protomer_hpmc::system::Counts;
/// assert_eq!(Counts { trials: 40, accepted: 10 }.acceptance(), 0.25);
/// assert_eq!(Counts::default().acceptance(), 0.0);
/// ```
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

    /// Counts of all moves together.
    ///
    /// ```
    /// use protomer_hpmc::system::{Counts, MoveCounts};
    /// let moves = MoveCounts {
    ///     translation: Counts { trials: 10, accepted: 5 },
    ///     rotation: Counts { trials: 30, accepted: 9 },
    /// };
    /// assert_eq!(moves.total(), Counts { trials: 40, accepted: 14 });
    /// ```
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

/// Place and orientation that a body would have after a move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial<const D: usize> {
    pub body: usize,
    pub position: [f64; D],
    pub rotation: Rotation,
    /// Whether the corners for this rotation are in [`System::trial_corners`].
    pub is_turned: bool,
}

/// Equal hard bodies in a periodic box of D dimensions.
///
/// ```
/// use protomer_hpmc::{body::HardBody, system::System};
/// use protomer_kernel::{Rotation, periodic_box::PeriodicBox};
/// let disk = HardBody::<2>::ball(0.5)?;
/// let space = PeriodicBox::rectangular([4.0, 4.0])?;
/// let places = vec![[0.2, 2.0], [3.8, 2.0], [2.0, 2.0]];
/// let system = System::new(disk, Vec::new(), space, places, vec![Rotation::identity(); 3])?;
/// assert_eq!(system.overlaps(), 1, "across the border");
/// assert!((system.packing_fraction() - 3.0 * std::f64::consts::PI / 64.0).abs() < 1e-12);
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct System<const D: usize> {
    pub(crate) body: HardBody<D>,
    pub(crate) space: PeriodicBox<D>,
    has_walls: bool,
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) rotations: Vec<Rotation>,
    /// The corners of all bodies, turned, each from the centre of its body.
    pub(crate) corners: Vec<Block<D>>,
    pub(crate) grid: Grid<D>,
    pub(crate) depletants: Vec<Depletant>,
    /// Corners of the body of a trial.
    pub(crate) trial_corners: Vec<Block<D>>,
    pub(crate) near: Vec<Near<D>>,
    memory: Vec<Slot<D>>,
}

impl<const D: usize> System<D> {
    /// Bodies in a box with a corner at the origin. A box whose edges overhang far is replaced by one with
    /// the same images (see [`PeriodicBox::reduced`]), and places outside are wrapped. The bodies may overlap;
    /// see [`overlaps`](Self::overlaps).
    ///
    /// # Errors
    /// If a body could meet an image of itself. Two bodies may meet at several images.
    pub fn new(
        body: HardBody<D>,
        depletants: Vec<Depletant>,
        space: PeriodicBox<D>,
        positions: Vec<[f64; D]>,
        rotations: Vec<Rotation>,
    ) -> Result<Self> {
        let space = space.reduced();
        let range = range(&body, &depletants);
        let (edge, least) = (space.smallest_length(), least_edge(&body, &depletants));
        if edge < least {
            let from = bodies_in_longer_box::<D>(positions.len(), least / edge);
            // The guess may be off by one, as roots and powers round.
            let bodies = first_that_works(from, 1, |bodies| {
                let factor = bodies as f64 / positions.len().max(1) as f64;
                edge * factor.powf(1.0 / D as f64) >= least
            });
            return Err(Error::BoxTooSmall {
                edge,
                least,
                bodies,
            });
        }
        let blocks = body.blocks();
        let places: Vec<[f64; D]> = positions.iter().map(|place| space.wrap(place)).collect();
        let mut system = Self {
            trial_corners: vec![[[0.0; 4]; D]; blocks],
            corners: vec![[[0.0; 4]; D]; blocks * places.len()],
            grid: Grid::new(&space, range, &places),
            body,
            space,
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
        self.sort();
        let empty = Slot {
            other: NOBODY,
            direction: [0.0; D],
        };
        self.memory.clear();
        // Round bodies are decided by their distance; they need no directions.
        if !self.body.is_round() {
            self.memory.resize(SLOTS * self.positions.len(), empty);
        }
    }

    /// The shape of the bodies.
    pub fn body(&self) -> &HardBody<D> {
        &self.body
    }

    /// The box.
    pub fn space(&self) -> &PeriodicBox<D> {
        &self.space
    }

    /// Volume of the box; in a plane, area.
    pub fn volume(&self) -> f64 {
        self.space.volume()
    }

    /// The same bodies between hard walls at both ends of the last axis.
    ///
    /// ```
    /// use protomer_hpmc::{body::HardBody, system::System};
    /// use protomer_kernel::{Rotation, periodic_box::PeriodicBox};
    /// let disk = HardBody::<2>::ball(0.5)?;
    /// let space = PeriodicBox::rectangular([4.0, 4.0])?;
    /// let low = vec![[2.0, 0.2]];
    /// let system = System::new(disk, Vec::new(), space, low, vec![Rotation::identity()])?;
    /// assert_eq!(system.overlaps(), 0);
    /// assert_eq!(system.between_walls()?.overlaps(), 1, "it reaches into the lower wall");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// In a box that is tilted.
    pub fn between_walls(mut self) -> Result<Self> {
        if !self.space.is_rectangular() {
            return Err(Error::NotTogether {
                first: "walls",
                second: "a tilted box",
            });
        }
        self.has_walls = true;
        Ok(self)
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

    /// The centres, in the box.
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
            *place = self.space.wrap(place);
        }
        self.rotations = rotations;
        let blocks = self.body.blocks();
        for (number, rotation) in self.rotations.iter().enumerate() {
            let corners = &mut self.corners[number * blocks..(number + 1) * blocks];
            self.body.turned_into(rotation, corners);
        }
        self.sort();
    }

    /// Sorts the bodies into new cells.
    fn sort(&mut self) {
        let range = range(&self.body, &self.depletants);
        self.grid = Grid::new(&self.space, range, &self.positions);
    }

    /// Deforms the box and the places in it by an upper triangular matrix (see [`PeriodicBox::deformed`]),
    /// unless bodies overlap then or could meet images of themselves.
    pub(crate) fn try_deform(&mut self, matrix: &[[f64; D]; D]) -> Deformation {
        let space = self.space.deformed(matrix).reduced();
        let is_too_small = space.smallest_length() < least_edge(&self.body, &self.depletants);
        // Copied before: a blocked change, which is the usual end, must leave no trace.
        let before = (self.space, self.positions.clone(), self.grid.clone());
        self.space = space;
        for place in &mut self.positions {
            // The centres move with the space, the bodies keep their shape and orientation.
            let new_place = matrix.map(|row| dot(&row, place));
            *place = space.wrap(&new_place);
        }
        self.sort();
        // Pairs first try the direction that separated them last: after a small change it mostly still does.
        let is_blocked = (0..self.len()).any(|body| self.collides(&self.where_it_is(body)));
        if !is_blocked && !is_too_small {
            return Deformation::Done;
        }
        (self.space, self.positions, self.grid) = before;
        match is_blocked {
            true => Deformation::Blocked,
            false => Deformation::TooSmall,
        }
    }

    /// Gaps from the lower wall to the body and from the body to the upper wall; negative if it
    /// reaches in.
    pub(crate) fn gaps_to_walls(&self, trial: &Trial<D>) -> [f64; 2] {
        let [low, high] = self.body.extent(self.corners_of_trial(trial));
        let place = trial.position[D - 1];
        let top = self.space.lengths()[D - 1] - (place + high);
        [place + low, top]
    }

    fn reaches_into_wall(&self, trial: &Trial<D>) -> bool {
        if !self.has_walls {
            return false;
        }
        let height = trial.position[D - 1];
        // Height decides for most bodies; only those near a wall need their corners.
        let nearest = height.min(self.space.lengths()[D - 1] - height);
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

    /// Number of overlaps of a trial with the other bodies that `counts` accepts, and with the
    /// walls.
    pub(crate) fn overlaps_of(&self, trial: &Trial<D>, counts: impl Fn(u32) -> bool) -> usize {
        let mut overlaps = usize::from(self.reaches_into_wall(trial));
        let range = 2.0 * self.body.outer_radius;
        let but = trial.body as u32;
        // Beyond two outer radii no two bodies meet.
        self.grid
            .any_near(&trial.position, range * range, but, |near| {
                overlaps += usize::from(counts(near.body) && self.is_overlap(trial, &near, 1.0));
                false
            });
        overlaps
    }

    /// Whether the body of a trial overlaps another when all distances are scaled.
    pub(crate) fn is_overlap(&self, trial: &Trial<D>, other: &Near<D>, scale: f64) -> bool {
        let (first, second) = (
            self.corners_of_trial(trial),
            self.corners_of(other.body as usize),
        );
        // Scaling offsets, not bodies: pairs are compared as in a compressed box.
        let offset = other.offset.map(|x| x * scale);
        self.body.overlaps_at(first, second, &offset)
    }

    /// The smallest change of all distances at which the body of a trial first overlaps another: a contraction
    /// (`sign` is -1) or an expansion (1). `None` for convex bodies and beyond the largest.
    pub(crate) fn first_contact(
        &self,
        trial: &Trial<D>,
        other: &Near<D>,
        sign: f64,
        largest: f64,
    ) -> Option<f64> {
        let corners = [
            self.corners_of_trial(trial),
            self.corners_of(other.body as usize),
        ];
        let error = self.body.error_of_heights();
        let pieces = self.body.pieces()?;
        pieces.first_contact(corners, &other.offset, sign, largest, error)
    }

    pub(crate) fn corners_of_trial(&self, trial: &Trial<D>) -> &[Block<D>] {
        if trial.is_turned {
            &self.trial_corners
        } else {
            self.corners_of(trial.body)
        }
    }

    /// Whether a body at a place, turned so, overlaps none. Its corners are left in `trial_corners`.
    pub(crate) fn is_free(&mut self, position: [f64; D], rotation: &Rotation) -> bool {
        self.body.turned_into(rotation, &mut self.trial_corners);
        let trial = Trial {
            body: NOBODY as usize,
            position,
            rotation: *rotation,
            is_turned: true,
        };
        !self.reaches_into_wall(&trial) && !self.overlaps_any(&trial)
    }

    fn overlaps_any(&self, trial: &Trial<D>) -> bool {
        let range = 2.0 * self.body.outer_radius;
        let but = trial.body as u32;
        self.grid
            .any_near(&trial.position, range * range, but, |near| {
                self.is_overlap(trial, &near, 1.0)
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
            trial_corners,
            memory,
            ..
        } = self;
        let outer = 2.0 * body.outer_radius;
        let trial_body = trial.body as u32;
        if body.is_round() {
            return grid.any_near(&trial.position, outer * outer, trial_body, |_| true);
        }
        // Inner balls that overlap settle it without a look at the corners.
        let inner = 4.0 * body.inner_radius * body.inner_radius;
        near.clear();
        // Every neighbour is collected before any is
        // tested, so that the loop over cells stays short.
        let is_deep = grid.any_near(&trial.position, outer * outer, trial_body, |other| {
            near.push(other);
            other.squared < inner
        });
        if is_deep {
            return true;
        }
        let blocks = body.blocks();
        let slots = &mut memory[trial.body * SLOTS..(trial.body + 1) * SLOTS];
        let first = if trial.is_turned {
            &trial_corners[..]
        } else {
            &corners[trial.body * blocks..(trial.body + 1) * blocks]
        };
        // Corners of all bodies lie in one array: `blocks` per body.
        let corners_of = |other: &Near<D>| {
            let number = other.body as usize;
            &corners[number * blocks..(number + 1) * blocks]
        };
        let pair_with =
            |other: &Near<D>| body.pair_of_hulls(first, corners_of(other), &other.offset);
        // The upper five bits of the product: a number below 32, `SLOTS`.
        let place = |other: u32| (other.wrapping_mul(HASH) >> 27) as usize;
        // First the remembered directions of all: one pass over the corners of each drops most.
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
            // Without memory the search begins with the line of centres.
            let mut direction = other.offset;
            if pair.overlap(&mut direction, || body.exact(&pair)) {
                // Hulls overlap: of convex bodies that is the answer, others ask their pieces.
                if body.overlap_as_their_hulls_do(first, corners_of(other), &other.offset) {
                    return true;
                }
                continue;
            }
            // In single precision: it is only a place to begin, and the memory stays small.
            *slot = Slot {
                other: other.body,
                direction: direction.map(|x| x as f32),
            };
        }
        false
    }

    /// Proposes a move: a body, or any, moved or turned at random.
    pub(crate) fn propose(
        &mut self,
        rng: &mut CounterRng,
        steps: &Steps,
        body: Option<usize>,
    ) -> Trial<D> {
        // One word serves two questions: the lowest bit for the kind, the others for the body.
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
            // In a plane only the axis across it.
            for axis in if D == 2 { 2..3 } else { 0..3 } {
                turn[axis] = steps.rotation * symmetric(rng);
            }
            let [x, y, z] = turn;
            // The vector part is tan of half the angle along
            // the axis; its opposite is equally likely.
            let turn = UnitQuaternion::new_normalize(Quaternion::new(1.0, x, y, z));
            let quaternion = (turn * trial.rotation).into_inner();
            trial.rotation = UnitQuaternion::new_normalize(quaternion);
            self.body
                .turned_into(&trial.rotation, &mut self.trial_corners);
        } else {
            for x in &mut trial.position {
                *x += steps.translation * symmetric(rng);
            }
            self.return_to_box(&mut trial.position);
        }
        trial
    }

    /// Moves a place that is less than an edge outside of the box by that edge. There are no images beyond
    /// walls.
    #[inline]
    fn return_to_box(&self, place: &mut [f64; D]) {
        if !self.space.is_rectangular() {
            *place = self.space.wrap(place);
            return;
        }
        let periodic = D - usize::from(self.has_walls);
        // A step is shorter than an edge, so one edge is enough.
        for (x, edge) in place.iter_mut().zip(self.space.lengths()).take(periodic) {
            if *x < 0.0 {
                *x += edge;
            }
            // Also where a tiny negative number has been rounded to the edge.
            if *x >= *edge {
                *x -= edge;
            }
        }
    }

    pub(crate) fn accept(&mut self, trial: &Trial<D>) {
        let body = trial.body;
        if trial.is_turned {
            let blocks = self.body.blocks();
            // Only now: a refused trial leaves the corners of the body untouched.
            self.corners[body * blocks..(body + 1) * blocks].copy_from_slice(&self.trial_corners);
            self.rotations[body] = trial.rotation;
        } else {
            self.positions[body] = trial.position;
            self.grid.moved(body, &self.positions);
        }
    }

    /// Vector from a place to the nearest image of another.
    pub(crate) fn nearest_image(&self, from: &[f64; D], to: &[f64; D]) -> [f64; D] {
        let apart = std::array::from_fn(|axis| to[axis] - from[axis]);
        self.space.nearest_image(&apart)
    }

    /// The longest steps that make sense.
    pub(crate) fn longest_steps(&self) -> Steps {
        Steps {
            translation: 0.5 * self.space.smallest_length(),
            rotation: LONGEST_TURN,
        }
    }
}

/// The largest distance at which two bodies meet, with depletants between them.
fn range<const D: usize>(body: &HardBody<D>, depletants: &[Depletant]) -> f64 {
    // Depletants in contact with both bodies make them meet at larger distances.
    let radii = depletants.iter().map(|kind| kind.radius);
    2.0 * (body.outer_radius + radii.fold(0.0, f64::max))
}

/// The smallest length that a box may have. No body reaches an image of itself there. A move of up to half of a
/// length must not bring a body within the reach of where an image of it was either, if there are depletants,
/// because [`depletants`](crate::depletants) compare two places of one body and no images of them.
pub(crate) fn least_edge<const D: usize>(body: &HardBody<D>, depletants: &[Depletant]) -> f64 {
    match depletants {
        [] => range(body, depletants),
        _ => 2.0 * range(body, depletants),
    }
}

/// The first number of bodies that works: from one number on, in steps that grow beyond a thousand of them.
pub(crate) fn first_that_works(from: usize, step: usize, works: impl Fn(usize) -> bool) -> usize {
    let mut bodies = from.max(step);
    while bodies < usize::MAX && !works(bodies) {
        // One by one up to a thousand, then in steps of a thousandth: the search stays short.
        let steps = (bodies / (1000 * step)).max(1);
        bodies = bodies.saturating_add(steps * step);
    }
    bodies
}

/// The number of bodies, to within rounding, whose box is so much longer than that of the given number at the
/// same density.
pub(crate) fn bodies_in_longer_box<const D: usize>(bodies: usize, factor: f64) -> usize {
    (bodies as f64 * factor.powi(D as i32) * (1.0 - 1e-9)) as usize
}

/// A number in (-1, 1), as likely as its opposite.
fn symmetric(rng: &mut CounterRng) -> f64 {
    // The middle of each of 2³² intervals: never zero, and symmetric to the last bit.
    (f64::from(rng.next_u32()) + 0.5) / f64::from(1_u32 << 31) - 1.0
}

impl Steps {
    /// Smallest number of trials for tuning; fewer say little.
    pub(crate) const ENOUGH: u64 = 300;

    /// Changes the steps towards an acceptance, by what they gave.
    pub(crate) fn tune(&mut self, counts: &MoveCounts, wanted: f64, longest: &Self) {
        let change = |step: &mut f64, counts: &Counts, longest: f64| {
            // Few trials would turn noise into steps.
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use protomer_kernel::shape::builders::by_name;

    /// A box in which a body of this range meets no image of itself, tilted by up to twice its lengths: so small
    /// that bodies meet several images of each other, long and narrow, or as wide as it is deep.
    fn random_box<const D: usize>(rng: &mut CounterRng, range: f64) -> PeriodicBox<D> {
        let [shortest, longest] = [[1.0, 1.5], [2.0, 2.5], [1.0, 8.0], [2.0, 8.0]][rng.index(4)];
        let lengths = std::array::from_fn(|_| range * rng.uniform_in(shortest, longest));
        let tilts = (0..D * (D - 1) / 2).map(|_| rng.uniform_in(-2.0, 2.0));
        PeriodicBox::new(lengths, &tilts.collect::<Vec<_>>()).unwrap()
    }

    fn random_system<const D: usize>(name: &str, rng: &mut CounterRng) -> System<D> {
        let body = HardBody::<D>::new(&by_name(name).unwrap(), 0.0).unwrap();
        let space = random_box(rng, 2.0 * body.outer_radius);
        let bodies = 1 + (0.2 * space.volume() / body.volume) as usize;
        let (mut positions, mut rotations) = (Vec::new(), Vec::new());
        for _ in 0..bodies {
            positions.push(space.at(&std::array::from_fn(|_| rng.uniform_in(-1.0, 2.0))));
            rotations.push(match D {
                2 => Rotation::from_scaled_axis(rng.uniform() * protomer_kernel::Vec3::z()),
                _ => rng.rotation(),
            });
        }
        System::new(body, Vec::new(), space, positions, rotations).unwrap()
    }

    /// The bodies that one would overlap, over all images by up to so many edges.
    fn overlaps_over_images<const D: usize>(system: &System<D>, trial: &Trial<D>) -> Vec<u32> {
        const MOST: usize = 4;
        let mut found = Vec::new();
        for other in 0..system.len() {
            for image in 0..(2 * MOST + 1).pow(D as u32) {
                let mut rest = image;
                let mut place = system.positions[other];
                for edge in 0..D {
                    let times = (rest % (2 * MOST + 1)) as f64 - MOST as f64;
                    system.space.add_edges(&mut place, edge, times);
                    rest /= 2 * MOST + 1;
                }
                let offset = std::array::from_fn(|axis| place[axis] - trial.position[axis]);
                let near = Near {
                    body: other as u32,
                    offset,
                    squared: dot(&offset, &offset),
                };
                if other != trial.body && system.is_overlap(trial, &near, 1.0) {
                    found.push(other as u32);
                }
            }
        }
        found
    }

    fn overlaps_are_those_of_all_images<const D: usize>(name: &str) {
        let (mut overlapping, mut free, mut collisions) = (0, 0, 0);
        for number in 0..20 {
            let mut rng = CounterRng::new(1, D as u32, number);
            let mut system = random_system::<D>(name, &mut rng);
            for body in 0..system.len() {
                let here = system.where_it_is(body);
                let expected = overlaps_over_images(&system, &here);
                let mut found = Vec::new();
                for other in 0..system.len() as u32 {
                    let count = system.overlaps_of(&here, |counted| counted == other);
                    found.extend(std::iter::repeat_n(other, count));
                }
                assert_eq!(found, expected, "{:?}", system.space);
                overlapping += found.len();
                free += usize::from(found.is_empty());
                let steps = Steps {
                    translation: 0.45 * system.space.smallest_length(),
                    rotation: 1.0,
                };
                let trial = system.propose(&mut rng, &steps, Some(body));
                let is_blocked = !overlaps_over_images(&system, &trial).is_empty();
                assert_eq!(system.collides(&trial), is_blocked, "{:?}", system.space);
                collisions += usize::from(is_blocked);
            }
        }
        let kinds = [overlapping, free, collisions];
        assert!(kinds.iter().all(|count| *count > 20), "{kinds:?}");
    }

    #[test]
    fn overlaps_in_tilted_boxes_are_those_of_all_images() {
        overlaps_are_those_of_all_images::<2>("polygon:4");
        overlaps_are_those_of_all_images::<3>("cube");
    }

    /// A deformation that cannot be leaves everything as it was; one that can moves the bodies with the box.
    #[test]
    fn bodies_move_with_a_box_that_is_deformed() {
        let mut deformed = 0;
        for number in 0..20 {
            let mut rng = CounterRng::new(2, 0, number);
            let crowded = random_system::<3>("cube", &mut rng);
            // So far apart that few overlap.
            let apart = |place: &[f64; 3]| place.map(|x| 8.0 * x);
            let places: Vec<[f64; 3]> = crowded.positions.iter().map(apart).collect();
            let (space, rotations) = (crowded.space.scaled(8.0), crowded.rotations.clone());
            let mut system =
                System::new(crowded.body, Vec::new(), space, places.clone(), rotations).unwrap();
            let before = system.clone();
            let squeezed = [[0.01, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            let by = [[1.2, 0.9, -0.7], [0.0, 1.1, 0.8], [0.0, 0.0, 1.3]];
            let is_squeezed = system.try_deform(&squeezed) == Deformation::Done;
            if is_squeezed || system.try_deform(&by) != Deformation::Done {
                assert_eq!(system.space, before.space);
                assert_eq!(system.positions, before.positions);
                continue;
            }
            deformed += 1;
            for (place, before) in system.positions.iter().zip(&places) {
                let moved = by.map(|row| dot(&row, before));
                let off = std::array::from_fn(|axis| place[axis] - moved[axis]);
                let left = system.space.nearest_image(&off);
                assert!(dot(&left, &left) < 1e-18, "{left:?}");
            }
        }
        assert!(deformed > 5, "{deformed}");
    }
}
