//! Random moves and exchanges of bodies.

use super::{Steps, System, Trial};
use nalgebra::{Quaternion, UnitQuaternion};
use protomer_kernel::random::CounterRng;
use rand_core::Rng;

/// The longest components of a rotation step: tan of half an angle of nearly 180 degrees.
const LONGEST_TURN: f64 = 2.0;

impl<const D: usize> System<D> {
    /// The longest steps that make sense.
    pub(crate) fn longest_steps(&self) -> Steps {
        Steps {
            translation: 0.5 * self.space.smallest_length(),
            rotation: LONGEST_TURN,
        }
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
}

/// A number in (-1, 1), as likely as its opposite.
fn symmetric(rng: &mut CounterRng) -> f64 {
    // The middle of each of 2³² intervals: never zero, and symmetric to the last bit.
    (f64::from(rng.next_u32()) + 0.5) / f64::from(1_u32 << 31) - 1.0
}
