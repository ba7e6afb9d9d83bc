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
use crate::mixture::Mixture;
use crate::potential::PairPotential;
use crate::reservoir::Depletant;
use crate::{Error, Result};
use nalgebra::{Quaternion, UnitQuaternion};
use protomer_kernel::Rotation;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::separation::{Block, dot};
use rand_core::Rng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

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

    pub(crate) fn is_none(&self) -> bool {
        self.trials == 0
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

/// Hard bodies in a periodic box of D dimensions, of one kind or of several.
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
    /// Kinds of bodies.
    pub(crate) kinds: Vec<HardBody<D>>,
    /// Number of the kind of each body.
    pub(crate) kind_of: Vec<u32>,
    /// Radius of the ball that holds any of the bodies.
    pub(crate) widest: f64,
    /// Blocks of corners that each body has room for.
    stride: usize,
    /// Whether all bodies are balls, which their distances decide.
    is_round: bool,
    pub(crate) space: PeriodicBox<D>,
    has_walls: bool,
    /// Whether a move may turn a body.
    turns: bool,
    pub(crate) positions: Vec<[f64; D]>,
    pub(crate) rotations: Vec<Rotation>,
    /// The corners of all bodies, turned, each from the centre of its body.
    pub(crate) corners: Vec<Block<D>>,
    pub(crate) grid: Grid<D>,
    pub(crate) depletants: Vec<Depletant>,
    /// Corners of the body of a trial.
    pub(crate) trial_corners: Vec<Block<D>>,
    pub(crate) near: Vec<Near<D>>,
    pub(crate) potential: Option<Arc<dyn PairPotential<D>>>,
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
        let count = positions.len();
        let mixture = Mixture::equal(body, count);
        Self::of_mixture(mixture, depletants, space, positions, rotations)
    }

    /// Bodies of several kinds, as [`new`](Self::new).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_mixture(
        mixture: Mixture<D>,
        depletants: Vec<Depletant>,
        space: PeriodicBox<D>,
        positions: Vec<[f64; D]>,
        rotations: Vec<Rotation>,
    ) -> Result<Self> {
        let space = space.reduced();
        let widest = mixture.widest();
        let range = range(widest, &depletants);
        let (edge, least) = (space.smallest_length(), least_edge(widest, &depletants));
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
        let Mixture { kinds, kind_of } = mixture;
        let stride = kinds.iter().map(HardBody::blocks).max().unwrap_or(0);
        let places: Vec<[f64; D]> = positions.iter().map(|place| space.wrap(place)).collect();
        let is_round = kinds.iter().all(HardBody::is_round);
        let mut system = Self {
            trial_corners: vec![[[0.0; 4]; D]; stride],
            corners: vec![[[0.0; 4]; D]; stride * places.len()],
            grid: Grid::new(&space, range, &places),
            turns: !is_round,
            kinds,
            kind_of,
            widest,
            stride,
            is_round,
            space,
            has_walls: false,
            positions: places,
            rotations,
            depletants,
            near: Vec::new(),
            potential: None,
            memory: Vec::new(),
        };
        system.turn_corners();
        system.refresh();
        Ok(system)
    }

    /// Turns the corners of all bodies to their orientations.
    fn turn_corners(&mut self) {
        for (number, rotation) in self.rotations.iter().enumerate() {
            let body = &self.kinds[self.kind_of[number] as usize];
            let first = number * self.stride;
            body.turned_into(rotation, &mut self.corners[first..first + body.blocks()]);
        }
    }

    /// The body of a number; of a number that no body has, the first kind.
    #[inline]
    pub(crate) fn body_of(&self, number: usize) -> &HardBody<D> {
        if let [only] = self.kinds.as_slice() {
            return only;
        }
        let kind = self.kind_of.get(number).copied().unwrap_or(0);
        &self.kinds[kind as usize]
    }

    /// Kinds of bodies.
    pub fn kinds(&self) -> &[HardBody<D>] {
        &self.kinds
    }

    /// Number of the kind of each body.
    pub fn kind_of(&self) -> &[u32] {
        &self.kind_of
    }

    /// Kinds of bodies and the kind of each.
    pub(crate) fn mixture(&self) -> Mixture<D> {
        Mixture {
            kinds: self.kinds.clone(),
            kind_of: self.kind_of.clone(),
        }
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
        if !self.is_round {
            self.memory.resize(SLOTS * self.positions.len(), empty);
        }
    }

    /// The shape of the bodies; of several kinds, that of the first.
    pub fn body(&self) -> &HardBody<D> {
        &self.kinds[0]
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

    /// The same bodies with an energy of each pair.
    ///
    /// # Errors
    /// If a body could interact with an image of itself.
    pub fn with_potential(mut self, potential: Arc<dyn PairPotential<D>>) -> Result<Self> {
        let range = potential.range();
        self.turns |= D > 1 && potential.is_directed();
        self.potential = Some(potential);
        let (edge, least) = (self.space.smallest_length(), self.least_edge());
        if edge < least {
            return Err(Error::OutOfRange {
                quantity: "the range of the potential",
                value: range,
                requirement: "at most the smallest length of the box; give more bodies or a shorter range",
            });
        }
        self.refresh();
        Ok(self)
    }

    /// The smallest length that the box may have.
    pub(crate) fn least_edge(&self) -> f64 {
        let potential = self
            .potential
            .as_ref()
            .map_or(0.0, |potential| potential.range());
        least_edge(self.widest, &self.depletants).max(potential)
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
        self.body_volume() / self.volume()
    }

    /// Volume of all bodies together.
    pub fn body_volume(&self) -> f64 {
        match self.kinds.as_slice() {
            [body] => self.len() as f64 * body.volume,
            kinds => self
                .kind_of
                .iter()
                .map(|kind| kinds[*kind as usize].volume)
                .sum(),
        }
    }

    #[inline]
    pub(crate) fn corners_of(&self, body: usize) -> &[Block<D>] {
        let first = body * self.stride;
        &self.corners[first..first + self.body_of(body).blocks()]
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
        self.turn_corners();
        self.sort();
    }

    /// Sorts the bodies into new cells.
    fn sort(&mut self) {
        let potential = self
            .potential
            .as_ref()
            .map_or(0.0, |potential| potential.range());
        let range = range(self.widest, &self.depletants).max(potential);
        self.grid = Grid::new(&self.space, range, &self.positions);
    }

    /// Deforms the box and the places in it by an upper triangular matrix (see [`PeriodicBox::deformed`]),
    /// unless bodies overlap then or could meet images of themselves.
    pub(crate) fn try_deform(&mut self, matrix: &[[f64; D]; D]) -> Deformation {
        let space = self.space.deformed(matrix).reduced();
        let is_too_small = space.smallest_length() < self.least_edge();
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
        let body = self.body_of(trial.body);
        let [low, high] = body.extent(self.corners_of_trial(trial));
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
        let body = self.body_of(trial.body);
        if nearest >= body.outer_radius || nearest < body.inner_radius {
            return nearest < body.inner_radius;
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
        let range = self.reach(trial);
        let but = trial.body as u32;
        // Beyond two outer radii no two bodies meet.
        self.grid
            .any_near(&trial.position, range * range, but, |near| {
                overlaps += usize::from(counts(near.body) && self.is_overlap(trial, &near, 1.0));
                false
            });
        overlaps
    }

    /// Largest distance at which the body of a trial meets another.
    pub(crate) fn reach(&self, trial: &Trial<D>) -> f64 {
        self.body_of(trial.body).outer_radius + self.widest
    }

    /// Whether the body of a trial overlaps another when all distances are scaled.
    pub(crate) fn is_overlap(&self, trial: &Trial<D>, other: &Near<D>, scale: f64) -> bool {
        let (first, second) = (
            self.corners_of_trial(trial),
            self.corners_of(other.body as usize),
        );
        // Scaling offsets, not bodies: pairs are compared as in a compressed box.
        let offset = other.offset.map(|x| x * scale);
        let body = self.body_of(trial.body);
        body.overlaps_at(self.body_of(other.body as usize), first, second, &offset)
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
        let bodies = [trial.body, other.body as usize].map(|number| self.body_of(number));
        let error = bodies[0].error_of_heights(bodies[1]);
        let [first, second] = [bodies[0].pieces()?, bodies[1].pieces()?];
        first.first_contact(second, corners, &other.offset, sign, largest, error)
    }

    #[inline]
    pub(crate) fn corners_of_trial(&self, trial: &Trial<D>) -> &[Block<D>] {
        if trial.is_turned {
            &self.trial_corners[..self.body_of(trial.body).blocks()]
        } else {
            self.corners_of(trial.body)
        }
    }

    /// Whether a body at a place, turned so, overlaps none. Its corners are left in `trial_corners`.
    pub(crate) fn is_free(&mut self, position: [f64; D], rotation: &Rotation) -> bool {
        let body = &self.kinds[0];
        body.turned_into(rotation, &mut self.trial_corners[..body.blocks()]);
        let trial = Trial {
            body: NOBODY as usize,
            position,
            rotation: *rotation,
            is_turned: true,
        };
        !self.reaches_into_wall(&trial) && !self.overlaps_any(&trial)
    }

    fn overlaps_any(&self, trial: &Trial<D>) -> bool {
        let range = self.reach(trial);
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
        // Compiled twice: bodies of one kind, the usual case, look up neither their kinds nor the lengths of their corners, which took
        // a quarter of the time of cubes.
        match self.kinds.len() {
            1 => self.collides_among::<true>(trial),
            _ => self.collides_among::<false>(trial),
        }
    }

    /// Whether the body would overlap another, among bodies of one kind or of several.
    fn collides_among<const ONE_KIND: bool>(&mut self, trial: &Trial<D>) -> bool {
        let Self {
            kinds,
            kind_of,
            stride,
            grid,
            near,
            corners,
            trial_corners,
            memory,
            ..
        } = self;
        let only = &kinds[0];
        let kind_of = |body: usize| match ONE_KIND {
            true => only,
            false => &kinds[kind_of[body] as usize],
        };
        let body = kind_of(trial.body);
        let kind = |other: &Near<D>| kind_of(other.body as usize);
        let outer = body.outer_radius + self.widest;
        let trial_body = trial.body as u32;
        if self.is_round && ONE_KIND {
            return grid.any_near(&trial.position, outer * outer, trial_body, |_| true);
        }
        if self.is_round {
            return grid.any_near(&trial.position, outer * outer, trial_body, |other| {
                let contact = body.outer_radius + kind(&other).outer_radius;
                other.squared < contact * contact
            });
        }
        near.clear();
        // Every neighbour is collected before any is
        // tested, so that the loop over cells stays short.
        let is_deep = grid.any_near(&trial.position, outer * outer, trial_body, |other| {
            near.push(other);
            // Inner balls that overlap settle it without a look at the corners.
            let inner = body.inner_radius + kind(&other).inner_radius;
            other.squared < inner * inner
        });
        if is_deep {
            return true;
        }
        let slots = &mut memory[trial.body * SLOTS..(trial.body + 1) * SLOTS];
        let blocks = |body: &HardBody<D>| match ONE_KIND {
            true => *stride,
            false => body.blocks(),
        };
        let first = if trial.is_turned {
            &trial_corners[..blocks(body)]
        } else {
            &corners[trial.body * *stride..trial.body * *stride + blocks(body)]
        };
        // Corners of all bodies lie in one array, with room for `stride` blocks per body.
        let corners_of = |other: &Near<D>| {
            let begin = other.body as usize * *stride;
            &corners[begin..begin + blocks(kind(other))]
        };
        let pair_with = |other: &Near<D>| {
            body.pair_of_hulls(kind(other), first, corners_of(other), &other.offset)
        };
        // The upper five bits of the product: a number below 32, `SLOTS`.
        let place = |other: u32| (other.wrapping_mul(HASH) >> 27) as usize;
        if !ONE_KIND {
            // Beyond their two radii no two bodies meet; of one kind all that were found are closer.
            near.retain(|other| {
                let contact = body.outer_radius + kind(other).outer_radius;
                other.squared < contact * contact
            });
        }
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
            if pair.overlap(&mut direction, || body.exact(kind(other), &pair)) {
                // Hulls overlap: of convex bodies that is the answer, others ask their pieces.
                if body.overlap_as_their_hulls_do(
                    kind(other),
                    first,
                    corners_of(other),
                    &other.offset,
                ) {
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
        let is_turned = self.turns && word & 1 == 1;
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
            let kind = if self.kinds.len() == 1 {
                0
            } else {
                self.kind_of[trial.body] as usize
            };
            let body = &self.kinds[kind];
            body.turned_into(&trial.rotation, &mut self.trial_corners[..body.blocks()]);
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
            let (first, blocks) = (body * self.stride, self.body_of(body).blocks());
            // Only now: a refused trial leaves the corners of the body untouched.
            self.corners[first..first + blocks].copy_from_slice(&self.trial_corners[..blocks]);
            self.rotations[body] = trial.rotation;
        } else {
            self.positions[body] = trial.position;
            self.grid.moved(body, &self.positions);
        }
    }

    /// Tries to exchange the places of two bodies drawn at random; bodies of one kind have nothing to exchange.
    /// Both draws are as likely before as after, so only overlaps and the energy decide (Metropolis).
    pub(crate) fn swap(&mut self, rng: &mut CounterRng) -> bool {
        let count = self.len();
        let [first, second] = [rng.index(count), rng.index(count)];
        if self.kind_of[first] == self.kind_of[second] {
            return false;
        }
        let energy = |system: &Self| match &system.potential {
            None => 0.0,
            // The pair of both is counted twice before and after alike, up to their own exchange, which leaves it as it is but
            // for the direction; so it is taken once.
            Some(_) => [first, second]
                .iter()
                .map(|body| system.energy_with_others(&system.where_it_is(*body)))
                .sum::<f64>(),
        };
        let before = energy(self) - self.energy_of_pair(first, second);
        self.exchange(first, second);
        let is_free = ![first, second]
            .iter()
            .any(|body| self.collides(&self.where_it_is(*body)));
        let is_allowed = is_free && {
            let change = energy(self) - self.energy_of_pair(first, second) - before;
            change <= 0.0 || rng.uniform() < (-change).exp()
        };
        if !is_allowed {
            self.exchange(first, second);
        }
        is_allowed
    }

    fn exchange(&mut self, first: usize, second: usize) {
        self.positions.swap(first, second);
        for body in [first, second] {
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

/// The largest distance at which two bodies of an outer radius meet, with depletants between them.
fn range(widest: f64, depletants: &[Depletant]) -> f64 {
    // Depletants in contact with both bodies make them meet at larger distances.
    let radii = depletants.iter().map(|kind| kind.radius);
    2.0 * (widest + radii.fold(0.0, f64::max))
}

/// The smallest length that a box may have. No body reaches an image of itself there. A move of up to half of a
/// length must not bring a body within the reach of where an image of it was either, if there are depletants,
/// because [`depletants`](crate::depletants) compare two places of one body and no images of them.
pub(crate) fn least_edge(widest: f64, depletants: &[Depletant]) -> f64 {
    match depletants {
        [] => range(widest, depletants),
        _ => 2.0 * range(widest, depletants),
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
            positions.push(space.point(&std::array::from_fn(|_| rng.uniform_in(-1.0, 2.0))));
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
            let mut system = System::new(
                crowded.body().clone(),
                Vec::new(),
                space,
                places.clone(),
                rotations,
            )
            .unwrap();
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
