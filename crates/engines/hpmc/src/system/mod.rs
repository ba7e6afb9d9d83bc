//! Hard bodies in a periodic box: which places are free, and trial moves.
//!
//! | module | one idea |
//! |---|---|
//! | `steps` | largest steps of the moves, and how many are accepted |
//! | `room` | how large a box must be |
//! | `overlaps` | which places are free |
//! | `moves` | random moves and exchanges of bodies |
//! | `deformation` | deformations of the box |
//!
//! A trial move takes a body at random and moves or turns it by a random step; steps and their
//! opposites are equally likely. It is accepted if the body overlaps no other, if the field that acts
//! on it does (Metropolis), and if the depletants allow it (see [`depletants`](crate::depletants)).
//!
//! Hard walls can close the box at both ends of its last axis. Bodies between them do not reach the
//! images beyond, so nothing else changes. Random numbers of a trial depend on its number
//! alone, so a state and a number of trials say how a run goes on.

mod deformation;
mod moves;
mod overlaps;
mod room;
mod steps;
#[cfg(test)]
mod tests;

pub(crate) use deformation::Deformation;
pub(crate) use room::{bodies_in_longer_box, first_that_works, least_edge};
pub use steps::{Counts, MoveCounts, Steps};

use crate::body::HardBody;
use crate::grid::{Grid, Near};
use crate::mixture::Mixture;
use crate::potential::PairPotential;
use crate::reservoir::Depletant;
use crate::{Error, Result};
use overlaps::Slot;
use protomer_kernel::Rotation;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::separation::Block;
use room::range;
use std::sync::Arc;

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
    /// Whether all bodies are ellipsoids.
    are_ellipsoids: bool,
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
        let are_ellipsoids = kinds.iter().any(|kind| kind.half_axes().is_some());
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
            are_ellipsoids,
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
        self.forget_directions();
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

    pub(crate) fn where_it_is(&self, body: usize) -> Trial<D> {
        Trial {
            body,
            position: self.positions[body],
            rotation: self.rotations[body],
            is_turned: false,
        }
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

    /// Vector from a place to the nearest image of another.
    pub(crate) fn nearest_image(&self, from: &[f64; D], to: &[f64; D]) -> [f64; D] {
        let apart = std::array::from_fn(|axis| to[axis] - from[axis]);
        self.space.nearest_image(&apart)
    }
}
