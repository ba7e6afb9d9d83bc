//! How far bodies interact, and which images of a body that is.

use super::{FarField, SitePotential};
use crate::system::{Pair, System};
use crate::{McError, Result};
use protomer_kernel::cells::require_minimum_image;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Vec3};

/// Two bodies, or a body and an image of another, whose energy is surely below this are left out,
/// kT. A body meets fewer than a hundred such partners, so all of them together stay below 10⁻⁶ kT.
pub(crate) const NEGLIGIBLE_KT: f64 = 1e-8;

/// A box that the interaction spans more often than this is refused: the sum over images would be
/// one over hundreds of them.
const MOST_SHELLS: f64 = 4.0;

/// The distances of origins beyond which bodies of two types do not interact, Å.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reach {
    types: usize,
    by_types: Vec<f64>,
    largest: f64,
}

impl Reach {
    /// The reach by |E| ≤ v(d) Σ|q_k| Σ|q_l| for charges no nearer than d.
    pub fn new(system: &System, potential: &Yukawa) -> Self {
        Self::by_charges(system, potential, |kind| {
            let charges = &system.types()[kind].charges;
            (charges.sum_of_magnitudes_e(), charges.radius_angstrom())
        })
    }

    /// The same for bodies whose charges `strongest` states by type: Σ|q| (e), and their radius (Å).
    pub fn by_charges(
        system: &System,
        potential: &Yukawa,
        strongest: impl Fn(usize) -> (f64, f64),
    ) -> Self {
        let charges: Vec<_> = (0..system.types().len()).map(strongest).collect();
        let mut distances = Vec::with_capacity(charges.len() * charges.len());
        for first in &charges {
            for second in &charges {
                let product = first.0 * second.0;
                // Beyond this gap of the nearest charges, v(d)
                // Σ|q| Σ|q| is below the negligible energy.
                let gap = potential.reach_angstrom(product, NEGLIGIBLE_KT);
                let radii = first.1 + second.1;
                distances.push(if product > 0.0 { gap + radii } else { 0.0 });
            }
        }
        Self::of_types(system, distances)
    }

    /// A shorter reach, from [multipoles](super::FarField).
    pub fn of_multipoles(system: &System, potential: &Yukawa) -> Self {
        Self::beyond(system, potential, NEGLIGIBLE_KT)
    }

    /// The reach beyond which bodies surely hold less than `energy_kt`, by their multipoles.
    pub fn beyond(system: &System, potential: &Yukawa, energy_kt: f64) -> Self {
        let types = system.types().iter();
        let fields: Vec<_> = types
            .map(|body_type| FarField::new(&body_type.charges, potential))
            .collect();
        let mut distances = Vec::with_capacity(fields.len() * fields.len());
        for first in &fields {
            for second in &fields {
                distances.push(first.reach_angstrom(second, potential, energy_kt));
            }
        }
        Self::of_types(system, distances)
    }

    /// The reach of these distances (Å), by the types of the first and the second body.
    pub fn of_types(system: &System, by_types: Vec<f64>) -> Self {
        let mut reach = Self {
            types: system.types().len(),
            by_types,
            largest: 0.0,
        };
        reach.largest = reach.largest_placed(system);
        reach
    }

    fn largest_placed(&self, system: &System) -> f64 {
        let mut largest: f64 = 0.0;
        // Only types that have bodies: an unused large type would slow every search for neighbours.
        for first in system.placed_types() {
            for second in system.placed_types() {
                largest = largest.max(self.by_types[first * self.types + second]);
            }
        }
        largest
    }

    /// The largest among bodies that have a place in the system, Å.
    pub fn largest_angstrom(&self) -> f64 {
        self.largest
    }

    fn of_pair(&self, pair: &Pair<'_>) -> f64 {
        let (first, second) = pair.type_indices();
        self.by_types[first * self.types + second]
    }

    /// Whether any image of the second body interacts with the first.
    pub fn is_met(&self, pair: &Pair<'_>) -> bool {
        self.holds(pair, &pair.displacement)
    }

    /// Whether an image of the second body at this displacement of origins (Å) interacts with the
    /// first.
    pub fn holds(&self, pair: &Pair<'_>, image: &Vec3) -> bool {
        image.norm_squared() < self.of_pair(pair).powi(2)
    }

    /// Displacements of the origins, Å, to the images of the second body that interact with the
    /// first, the nearest image first.
    pub fn images(&self, pair: &Pair<'_>) -> impl Iterator<Item = Vec3> + use<> {
        let (reach, nearest) = (self.of_pair(pair), pair.displacement);
        let is_near = move |displacement: &Vec3| displacement.norm_squared() < reach * reach;
        // The nearest first, and without a search: in large boxes it is the only one.
        std::iter::once(nearest)
            .chain(farther_images(pair.boundary(), nearest, reach))
            .filter(is_near)
    }
}

/// All images but the nearest in a cube that holds the sphere of this radius.
fn farther_images(
    boundary: &Boundary,
    nearest: Vec3,
    reach: f64,
) -> impl Iterator<Item = Vec3> + use<> {
    let lengths = match boundary {
        Boundary::Periodic { lengths_angstrom } => *lengths_angstrom,
        Boundary::Open | Boundary::SphereWall { .. } => Vec3::repeat(f64::INFINITY),
    };
    let range = |axis: usize| {
        // The usual case: no other image along this axis
        // can be in reach, and no division is needed.
        if reach + nearest[axis].abs() < lengths[axis] {
            return 0..=0;
        }
        let first = ((-reach - nearest[axis]) / lengths[axis]).ceil() as i64;
        let last = ((reach - nearest[axis]) / lengths[axis]).floor() as i64;
        first..=last
    };
    let (x, y, z) = (range(0), range(1), range(2));
    let cells = x.flat_map(move |i| {
        let z = z.clone();
        y.clone()
            .flat_map(move |j| z.clone().map(move |k| [i, j, k]))
    });
    // The nearest image has been handed out before.
    cells.filter(|cell| *cell != [0; 3]).map(move |[i, j, k]| {
        nearest + Vec3::new(i as f64, j as f64, k as f64).component_mul(&lengths)
    })
}

/// Checks that the box suits the interaction. A cut-off must leave one image of each body in range,
/// as in the calculations it is compared with; without a cut-off the sum runs over images.
///
/// # Errors
/// [`KernelError::BoxTooSmall`](protomer_kernel::KernelError::BoxTooSmall) for a cut-off;
/// [`McError::UnscreenedInBox`] and [`McError::ReachesTooFar`] without one.
pub(crate) fn require_room(system: &System, potential: &Yukawa) -> Result<()> {
    let range = Reach::new(system, potential).largest_angstrom();
    let smallest = system.boundary().smallest_length_angstrom();
    // With a cut-off the nearest image is all there is, so the box must be twice the range.
    if potential.cutoff_angstrom().is_some() {
        return Ok(require_minimum_image(system.boundary(), range)?);
    }
    // Unscreened charges in a periodic box would need an Ewald sum.
    if smallest.is_finite() && range.is_infinite() {
        return Err(McError::UnscreenedInBox);
    }
    if range > MOST_SHELLS * smallest {
        return Err(McError::ReachesTooFar {
            range_angstrom: range,
            smallest_length_angstrom: smallest,
            needed_length_angstrom: range / MOST_SHELLS,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn images_are_those_of_a_search_among_all() {
        let mut rng = CounterRng::new(12, 0, 0);
        let mut found_in_all = 0;
        for _ in 0..200 {
            let lengths = Vec3::from_fn(|_, _| rng.uniform_in(20.0, 90.0));
            let nearest = lengths.map(|length| length * rng.uniform_in(-0.5, 0.5));
            let reach = rng.uniform_in(5.0, 120.0);
            let boundary = Boundary::periodic(lengths).unwrap();
            let is_near = |displacement: &Vec3| displacement.norm() < reach;
            let found: Vec<Vec3> = farther_images(&boundary, nearest, reach)
                .filter(is_near)
                .collect();
            let mut expected = Vec::new();
            for cell in 0..15 * 15 * 15 {
                let cell = [cell / 225, cell / 15 % 15, cell % 15].map(|n| f64::from(n - 7));
                let displacement = nearest + Vec3::from(cell).component_mul(&lengths);
                if cell != [0.0; 3] && is_near(&displacement) {
                    expected.push(displacement);
                }
            }
            assert_eq!(found, expected);
            found_in_all += found.len();
        }
        assert!(found_in_all > 1000, "{found_in_all}");
    }
}
