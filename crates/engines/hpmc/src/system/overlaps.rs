//! Which places are free: bodies against their neighbours and the walls.

use super::{System, Trial};
use crate::body::HardBody;
use crate::ellipsoids::{is_separated_along, overlap};
use crate::grid::Near;
use protomer_kernel::Rotation;
use protomer_kernel::shape::separation::{Block, dot};

/// Neighbours whose separating directions a body remembers; a power of two.
const SLOTS: usize = 32;
/// A multiplicative hash spreads neighbours over the slots.
const HASH: u32 = 0x9E37_79B1;
/// The number that stands for no body.
const NOBODY: u32 = u32::MAX;

/// The direction that separated two bodies last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot<const D: usize> {
    other: u32,
    direction: [f32; D],
}

impl<const D: usize> System<D> {
    /// Forgets the directions that separated bodies.
    pub(super) fn forget_directions(&mut self) {
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
        match (self.are_ellipsoids, self.kinds.len()) {
            (true, _) => self.ellipsoid_collides(trial),
            (false, 1) => self.collides_among::<true>(trial),
            (false, _) => self.collides_among::<false>(trial),
        }
    }

    /// Whether an ellipsoid would overlap another, by the same steps as other bodies. It has no corners but half axes, so this
    /// is a function of its own: a question in the loop over corners would slow the others.
    fn ellipsoid_collides(&mut self, trial: &Trial<D>) -> bool {
        let mut near = std::mem::take(&mut self.near);
        let mut memory = std::mem::take(&mut self.memory);
        near.clear();
        let body = self.body_of(trial.body);
        let range = self.reach(trial);
        let is_deep =
            self.grid
                .any_near(&trial.position, range * range, trial.body as u32, |other| {
                    let kind = self.body_of(other.body as usize);
                    let outer = body.outer_radius + kind.outer_radius;
                    if other.squared < outer * outer {
                        near.push(other);
                    }
                    let inner = body.inner_radius + kind.inner_radius;
                    other.squared < inner * inner
                });
        let slots = &mut memory[trial.body * SLOTS..(trial.body + 1) * SLOTS];
        let first = &self.corners_of_trial(trial)[0];
        let mut collides = is_deep;
        if !is_deep {
            near.sort_unstable_by(|a, b| a.squared.total_cmp(&b.squared));
            for other in &near {
                let second = &self.corners_of(other.body as usize)[0];
                let slot = &mut slots[(other.body.wrapping_mul(HASH) >> 27) as usize];
                // The direction that separated this pair last does so again where bodies move little.
                if slot.other == other.body
                    && is_separated_along(
                        first,
                        second,
                        &other.offset,
                        &slot.direction.map(f64::from),
                    )
                {
                    continue;
                }
                let mut direction = other.offset;
                if overlap(first, second, &other.offset, &mut direction) {
                    collides = true;
                    break;
                }
                // To length one, which single precision holds for bodies of any size.
                let length = dot(&direction, &direction).sqrt();
                *slot = Slot {
                    other: other.body,
                    direction: direction.map(|x| (x / length) as f32),
                };
            }
        }
        self.near = near;
        self.memory = memory;
        collides
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
}
