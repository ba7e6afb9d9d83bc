//! Sums over point charges, eight at a time.

use protomer_kernel::Vec3;
use protomer_kernel::exponential::exp_of_minus;
use protomer_kernel::vectorised;

/// Charges in a group.
const LANES: usize = 8;

/// A radial function about a place, and its prefactor: a charge, for example.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source {
    pub place: Vec3,
    pub strength: f64,
    /// Smaller distances count as this one, Å.
    pub least_distance_angstrom: f64,
}

/// Eight sources; unused lanes have no strength.
#[derive(Debug, Clone, Copy)]
struct Group {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    strength: [f64; LANES],
    least: [f64; LANES],
}

/// Sources in groups.
#[derive(Debug, Clone, Default)]
pub(crate) struct PointCharges {
    groups: Vec<Group>,
}

impl Group {
    /// The group of up to eight sources.
    fn new(sources: &[Source]) -> Self {
        let mut group = Self {
            x: [0.0; LANES],
            y: [0.0; LANES],
            z: [0.0; LANES],
            strength: [0.0; LANES],
            least: [1.0; LANES],
        };
        for (lane, source) in sources.iter().enumerate() {
            group.x[lane] = source.place.x;
            group.y[lane] = source.place.y;
            group.z[lane] = source.place.z;
            group.strength[lane] = source.strength;
            group.least[lane] = source.least_distance_angstrom;
        }
        group
    }

    /// The distance that counts for a source, Å.
    #[inline(always)]
    fn distance(&self, lane: usize, place: &Vec3) -> f64 {
        let (dx, dy, dz) = (
            place.x - self.x[lane],
            place.y - self.y[lane],
            place.z - self.z[lane],
        );
        let (distance, least) = ((dx * dx + dy * dy + dz * dz).sqrt(), self.least[lane]);
        if distance > least { distance } else { least }
    }
}

impl PointCharges {
    pub fn new(sources: &[Source]) -> Self {
        Self {
            groups: sources.chunks(LANES).map(Group::new).collect(),
        }
    }

    vectorised!(
        /// Σ s_i / r_i.
        pub fn coulomb[coulomb_avx512, coulomb_avx2, coulomb_any](self: &Self, place: &Vec3) -> f64
    );
    vectorised!(
        /// Σ s_i exp(-κ r_i) / r_i.
        pub fn screened[screened_avx512, screened_avx2, screened_any](self: &Self, place: &Vec3, kappa: f64) -> f64
    );

    #[inline(always)]
    fn coulomb_any(&self, place: &Vec3) -> f64 {
        let mut sums = [0.0; LANES];
        for group in &self.groups {
            // Lanes inside, groups outside: each sum runs over
            // every eighth charge, in one order everywhere.
            for (lane, sum) in sums.iter_mut().enumerate() {
                *sum += group.strength[lane] / group.distance(lane, place);
            }
        }
        sums.iter().sum()
    }

    #[inline(always)]
    fn screened_any(&self, place: &Vec3, kappa: f64) -> f64 {
        let mut sums = [0.0; LANES];
        for group in &self.groups {
            for (lane, sum) in sums.iter_mut().enumerate() {
                let distance = group.distance(lane, place);
                *sum += group.strength[lane] * exp_of_minus(kappa * distance) / distance;
            }
        }
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn every_instruction_set_gives_the_plain_sums() {
        let mut rng = CounterRng::new(61, 0, 0);
        for count in [0, 1, 7, 8, 45] {
            let sources: Vec<Source> = (0..count)
                .map(|_| Source {
                    place: rng.vector_in_ball(10.0),
                    strength: rng.uniform_in(-1.0, 1.0),
                    least_distance_angstrom: rng.uniform_in(0.1, 2.0),
                })
                .collect();
            let charges = PointCharges::new(&sources);
            for _ in 0..50 {
                let place = rng.vector_in_ball(15.0);
                let (mut value, mut screened, mut size) = (0.0, 0.0, 1e-300);
                for source in &sources {
                    let distance = (place - source.place).norm();
                    let r = distance.max(source.least_distance_angstrom);
                    value += source.strength / r;
                    screened += source.strength * (-0.1 * r).exp() / r;
                    size += source.strength.abs() / r;
                }
                let close =
                    |a: f64, b: f64| assert!((a - b).abs() <= 1e-13 * size, "{count}: {a} {b}");
                close(charges.coulomb(&place), value);
                close(charges.screened(&place, 0.1), screened);
                assert_eq!(
                    charges.coulomb(&place).to_bits(),
                    charges.coulomb_any(&place).to_bits()
                );
                assert_eq!(
                    charges.screened(&place, 0.1).to_bits(),
                    charges.screened_any(&place, 0.1).to_bits()
                );
            }
        }
    }
}
