//! Screened charges seen from a small box, in single precision.
//!
//! With d_i the distance of charge i from the middle of the box,
//!
//! Σ s_i exp(-κ r_i) / r_i = Σ (s_i exp(-κ d_i)) exp(κ (d_i - r_i)) / r_i.
//!
//! The first factors are computed once, in double precision, and the exponents that are left are
//! small. Places count from the middle. In the tests, with charges 12 to 70 Å from the middle and κ up
//! to 3/Å, a sum is good to (2 + 3 κ Å) · 10⁻⁶ of Σ |s_i| exp(-κ r_i) / r_i.

use crate::point_charges::Source;
use protomer_kernel::Vec3;
use protomer_kernel::exponential::exp_of_minus_f32;
use protomer_kernel::vectorised;

/// Charges in a group.
const LANES: usize = 16;
/// The least exponent κ (r - d): `exp_of_minus_f32` takes no smaller one.
const LEAST: f32 = -80.0;

/// Charges; unused lanes have no strength and are at a distance.
struct Group {
    /// Offsets from the middle of the box, Å, by axis.
    offsets: [[f32; LANES]; 3],
    /// Smaller distances count as this one, Å.
    least: [f32; LANES],
    /// d, Å.
    from_middle: [f32; LANES],
    /// s exp(-κ d).
    strength: [f32; LANES],
}

/// A sum of screened potentials at the places of a box.
pub(crate) struct ScreenedSum {
    middle: Vec3,
    kappa: f32,
    groups: Vec<Group>,
}

impl ScreenedSum {
    /// The sum for places about this one.
    pub fn new(sources: &[Source], middle: Vec3, kappa: f64) -> Self {
        let mut groups = Vec::with_capacity(sources.len().div_ceil(LANES));
        for sources in sources.chunks(LANES) {
            // Unused lanes: no strength, and a distance that is not zero.
            let mut group = Group {
                offsets: [[1.0; LANES]; 3],
                least: [1.0; LANES],
                from_middle: [1.0; LANES],
                strength: [0.0; LANES],
            };
            for (lane, source) in sources.iter().enumerate() {
                let offset = source.place - middle;
                for axis in 0..3 {
                    group.offsets[axis][lane] = offset[axis] as f32;
                }
                let least = source.least_distance_angstrom;
                // Rounded first, since the exponents have the rounded number.
                // The same rounded number in both factors, so that its rounding cancels.
                let from_middle = offset.norm().max(least) as f32;
                group.least[lane] = least as f32;
                group.from_middle[lane] = from_middle;
                let screening = (-kappa * f64::from(from_middle)).exp();
                group.strength[lane] = (source.strength * screening) as f32;
            }
            groups.push(group);
        }
        Self {
            middle,
            kappa: kappa as f32,
            groups,
        }
    }

    vectorised!(
        /// Σ s_i exp(-κ r_i) / r_i.
        pub fn value_at[value_at_avx512, value_at_avx2, value_at_any](self: &Self, place: &Vec3) -> f64
    );

    #[inline(always)]
    fn value_at_any(&self, place: &Vec3) -> f64 {
        let [x, y, z] = (place - self.middle).map(|x| x as f32).into();
        let mut sums = [0.0; LANES];
        for group in &self.groups {
            let [xs, ys, zs] = &group.offsets;
            for (lane, sum) in sums.iter_mut().enumerate() {
                let (dx, dy, dz) = (x - xs[lane], y - ys[lane], z - zs[lane]);
                let (distance, least) = ((dx * dx + dy * dy + dz * dz).sqrt(), group.least[lane]);
                // Written as selections: maxima that compile into vectors.
                let distance = if distance > least { distance } else { least };
                let farther = self.kappa * (distance - group.from_middle[lane]);
                // exp of more than 80 would overflow; it would take a place far outside the box.
                let farther = if farther > LEAST { farther } else { LEAST };
                *sum += group.strength[lane] * exp_of_minus_f32::<false>(farther) / distance;
            }
        }
        sums.iter().map(|sum| f64::from(*sum)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// The slow twin: double precision, each term by itself.
    #[test]
    fn sums_are_those_of_double_precision() {
        let mut rng = CounterRng::new(72, 0, 0);
        for kappa in [0.0, 0.1, 0.7, 3.0] {
            for count in [0, 1, 15, 16, 900] {
                let middle = rng.vector_in_ball(40.0) + Vec3::repeat(100.0);
                let sources: Vec<Source> = (0..count)
                    .map(|_| Source {
                        place: middle + rng.unit_vector() * rng.uniform_in(12.0, 70.0),
                        strength: rng.uniform_in(-1.0, 1.0) * (kappa * 4.0_f64).exp(),
                        least_distance_angstrom: 2.0,
                    })
                    .collect();
                let sum = ScreenedSum::new(&sources, middle, kappa);
                for _ in 0..50 {
                    let place = middle + rng.vector_in_ball(8.0);
                    let (mut exact, mut size) = (0.0, 0.0);
                    for source in &sources {
                        let r = (place - source.place).norm();
                        let term = source.strength * (-kappa * r).exp() / r;
                        exact += term;
                        size += f64::abs(term);
                    }
                    let found = sum.value_at(&place);
                    let bound = (2e-6 + 3e-6 * kappa) * size + 1e-30;
                    assert!(
                        (found - exact).abs() < bound,
                        "{kappa} {found} {exact} {size}"
                    );
                    assert_eq!(found.to_bits(), sum.value_at_any(&place).to_bits());
                }
            }
        }
    }

    /// A charge in the box, where the distance that counts has a least value.
    #[test]
    fn near_charges_count_at_their_least_distance() {
        let source = Source {
            place: Vec3::new(1.0, 2.0, 3.0),
            strength: 2.0,
            least_distance_angstrom: 1.5,
        };
        let found = ScreenedSum::new(&[source], Vec3::zeros(), 0.2).value_at(&source.place);
        let exact = 2.0 * (-0.2_f64 * 1.5).exp() / 1.5;
        assert!((found / exact - 1.0).abs() < 1e-6);
    }

    /// Ions kept out of a sphere of 200 Å: exp(κ b) is beyond single precision.
    #[test]
    fn strengths_of_large_solutes_fit() {
        let (kappa, b) = (0.7, 200.0_f64);
        let source = Source {
            place: Vec3::zeros(),
            strength: f64::exp(kappa * b),
            least_distance_angstrom: 2.0,
        };
        let middle = Vec3::new(210.0, 0.0, 0.0);
        let place = middle + Vec3::new(3.0, 5.0, 0.0);
        let found = ScreenedSum::new(&[source], middle, kappa).value_at(&place);
        let r = place.norm();
        let exact = f64::exp(kappa * (b - r)) / r;
        assert!((found / exact - 1.0).abs() < 2e-5, "{found} {exact}");
    }
}
