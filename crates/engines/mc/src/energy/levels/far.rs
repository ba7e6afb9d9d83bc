//! Images of bodies that are far away.
//!
//! A body meets many partners that hold next to nothing: a hundred and more at physiological density
//! and low salt. What they hold is bounded by the multipoles of both bodies
//! ([`FarField`](crate::energy::FarField)), and most decisions need no more than the sum of the bounds.
//! Nothing is kept of them from move to move. Each of them holds 10⁻⁸ to 4 · 10⁻³ kT. Kept as near
//! ones, they made a move of 1000 bodies four times as dear.

use crate::energy::far_energies::FarEnergies;
use crate::energy::reach::{NEGLIGIBLE_KT, Reach};
use crate::system::{Pair, System};
use protomer_kernel::Vec3;
use protomer_kernel::potential::Yukawa;

/// An image that surely holds less than this is far away, kT.
const FAR_KT: f64 = 4e-3;
/// Energy below which an image is far away, as a part of the tolerance for a pair: a body meets
/// fewer than a hundred images.
const PART_OF_TOLERANCE: f64 = 0.01;

/// The images of a pair that are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Images {
    /// Near images, of which something is kept.
    Near,
    /// Images farther away.
    Far,
}

/// Distances beyond which images are far away, and bounds of what they hold.
#[derive(Debug, Clone, Default)]
pub(super) struct Far {
    near: Reach,
    reach: Reach,
    energies: FarEnergies,
    /// Whether the box is so large that no other image is in reach.
    nearest_only: bool,
}

impl Far {
    /// The bounds for images in reach of each other; those far away hold less where only a
    /// tolerance (kT) is requested.
    pub fn new(
        system: &System,
        potential: &Yukawa,
        reach: &Reach,
        tolerance_kt: Option<f64>,
    ) -> Self {
        let tolerable_kt = tolerance_kt.map_or(FAR_KT, |kt| PART_OF_TOLERANCE * kt);
        // Never below what is left out anyway, and never above the value for decisions.
        let far_kt = tolerable_kt.clamp(NEGLIGIBLE_KT, FAR_KT);
        Self {
            near: Reach::beyond(system, potential, far_kt),
            reach: reach.clone(),
            // Twice, as the nearest image is at most half a box away.
            nearest_only: 2.0 * reach.largest_angstrom()
                < system.boundary().smallest_length_angstrom(),
            energies: FarEnergies::new(system, potential, reach.largest_angstrom()),
        }
    }

    /// The distances beyond which images are far away.
    pub fn near(&self) -> &Reach {
        &self.near
    }

    /// Whether this image, at a displacement of origins in Å, is near or farther away.
    pub fn which(&self, pair: &Pair<'_>, image: &Vec3) -> Images {
        match self.near.holds(pair, image) {
            true => Images::Near,
            false => Images::Far,
        }
    }

    /// Number of near images of a pair.
    pub fn near_images(&self, pair: &Pair<'_>) -> usize {
        match self.nearest_only {
            true => usize::from(self.near.is_met(pair)),
            false => self.near.images(pair).count(),
        }
    }

    /// The most that the images of a pair that are far away can hold, kT.
    #[inline]
    pub fn bound_kt(&self, pair: &Pair<'_>) -> f64 {
        let types = pair.type_indices();
        let is_far = |image: &Vec3| self.which(pair, image) == Images::Far;
        // Several images: sum the bounds of all of them.
        if !self.nearest_only {
            let images = self.reach.images(pair).filter(is_far);
            return images
                .map(|image| self.energies.energy(types, image.norm()))
                .sum();
        }
        match self.reach.is_met(pair) && is_far(&pair.displacement) {
            true => self.energies.energy(types, pair.displacement.norm()),
            false => 0.0,
        }
    }
}

/// The images in a decision of which no more than a bound is known.
#[derive(Debug, Default)]
pub(super) struct FarImages {
    /// Bounds (kT) and partners.
    bounds_kt: Vec<(f64, usize)>,
    sum_kt: f64,
}

impl FarImages {
    /// Adds the images of a partner, which hold no more than this before and after the move
    /// together.
    pub fn add(&mut self, partner: usize, bound_kt: f64) {
        if bound_kt > 0.0 {
            self.bounds_kt.push((bound_kt, partner));
            self.sum_kt += bound_kt;
        }
    }

    /// Largest energy that all these images can hold, kT.
    pub fn bound_kt(&self) -> f64 {
        self.sum_kt
    }

    /// Removes the partner with the largest bound, to be looked at.
    pub fn take_widest(&mut self) -> Option<usize> {
        let places = 0..self.bounds_kt.len();
        let widest = places.max_by(|a, b| self.bounds_kt[*a].0.total_cmp(&self.bounds_kt[*b].0))?;
        let (_, partner) = self.bounds_kt.swap_remove(widest);
        // Summed again: subtracting would leave rounding where the sum should be zero.
        self.sum_kt = self.bounds_kt.iter().map(|(bound_kt, _)| bound_kt).sum();
        Some(partner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyType;
    use crate::energy::pair_energy_kt;
    use crate::test_support::tetrahedron;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Boundary, Pose};
    use std::sync::Arc;

    fn kind(net_e: f64, rng: &mut CounterRng) -> Arc<BodyType> {
        let mesh = tetrahedron(1.0);
        let mut charge = |_| {
            let charge_e = net_e / 20.0 + rng.uniform_in(-0.5, 0.5);
            (rng.vector_in_ball(8.0), charge_e)
        };
        let charges: Vec<(Vec3, f64)> = (0..20).map(&mut charge).collect();
        Arc::new(BodyType::new("body", &mesh, &charges).unwrap())
    }

    /// In small boxes several images of a pair count, near ones and others.
    #[test]
    fn images_far_away_hold_less_than_their_bound() {
        let mut rng = CounterRng::new(71, 0, 0);
        let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
        let types = vec![kind(12.0, &mut rng), kind(-9.0, &mut rng)];
        let (mut looked_at, mut near) = (0, 0);
        for edge in [100.0, 250.0, 700.0] {
            for _ in 0..30 {
                let mut place = || Pose {
                    position: Vec3::from_fn(|_, _| edge * rng.uniform_in(-0.5, 0.5)),
                    rotation: rng.rotation(),
                };
                let bodies = [(0, place()), (1, place())];
                let boundary = Boundary::periodic(Vec3::repeat(edge)).unwrap();
                let system = System::new(types.clone(), &bodies, boundary).unwrap();
                let reach = Reach::of_multipoles(&system, &yukawa);
                let far = Far::new(&system, &yukawa, &reach, None);
                let pair = system.pair(0, 1);
                let mut sum_kt = 0.0;
                for image in reach.images(&pair) {
                    let pose = pair.relative_image(&image);
                    let [first, second] = [0, 1].map(|kind| &types[kind].charges);
                    let energy_kt = pair_energy_kt(&yukawa, first, second, &pose).abs();
                    match far.which(&pair, &image) {
                        Images::Near => near += 1,
                        Images::Far => {
                            assert!(energy_kt < FAR_KT, "{edge}: {energy_kt}");
                            sum_kt += energy_kt;
                            looked_at += 1;
                        }
                    }
                }
                let bound_kt = far.bound_kt(&pair);
                assert!(sum_kt <= bound_kt, "{edge}: {sum_kt} {bound_kt}");
            }
        }
        assert!(looked_at > 300 && near > 30, "{looked_at} {near}");
    }

    #[test]
    fn the_widest_is_taken_first_and_the_others_stay() {
        let mut far = FarImages::default();
        for (partner, bound_kt) in [(3, 1.0), (5, 4.0), (7, 0.0), (8, 2.0)] {
            far.add(partner, bound_kt);
        }
        let mut taken = Vec::new();
        while let Some(partner) = far.take_widest() {
            taken.push((partner, far.bound_kt()));
        }
        assert_eq!(taken, [(5, 3.0), (8, 1.0), (3, 0.0)]);
    }
}
