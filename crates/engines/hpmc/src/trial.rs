//! One trial move: proposed, and refused by fields, bodies or depletants.

use crate::depletants::Counting;
use crate::field::Field;
use crate::system::{MoveCounts, Steps, System};
use protomer_kernel::random::CounterRng;

impl<const D: usize> System<D> {
    /// Makes one trial move with the numbers of a stream.
    pub(crate) fn trial(
        &mut self,
        rng: &mut CounterRng,
        steps: &Steps,
        counting: Counting,
        field: &mut impl Field<D>,
        counts: &mut MoveCounts,
    ) -> bool {
        let trial = self.propose(rng, steps, None);
        // From cheap to expensive: the field, the bodies, their potential, the depletants. Each accepts by itself with the
        // ratio of its own weights, so all of them together do with the product.
        let is_accepted = field.allows(self, &trial, rng)
            && !self.collides(&trial)
            && self.potential_allows(&trial, rng)
            && (self.depletants.is_empty() || self.depletants_allow(&trial, rng, counting));
        if is_accepted {
            // Before the bodies move: the field still sees the old place.
            field.moved(&trial);
            self.accept(&trial);
        }
        let kind = match trial.is_turned {
            true => &mut counts.rotation,
            false => &mut counts.translation,
        };
        kind.note(is_accepted);
        is_accepted
    }
}
