//! Sums over point charges, eight at a time.
//!
//! The processor's widest vectors do the same operations in the same order as the portable code: every machine finds the same
//! bits.

use protomer_kernel::Vec3;
use protomer_kernel::potential::exp_of_minus;

/// Charges of a group.
const LANES: usize = 8;

/// A charge, or whatever stands before a radial function, at a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source {
    pub place: Vec3,
    pub strength: f64,
    /// Distances below this are taken for it, Å.
    pub least_distance_angstrom: f64,
}

/// Eight sources; missing ones have no strength.
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

/// A method that is compiled once for each instruction set and chosen at run time.
macro_rules! vectorised {
    ($(#[$doc:meta])* $name:ident, $any:ident, $avx512:ident, $avx2:ident, ($($argument:ident: $type:ty),*) -> $out:ty) => {
        $(#[$doc])*
        pub fn $name(&self, $($argument: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            {
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                    // SAFETY: the processor has the features the function is compiled for.
                    return unsafe { self.$avx512($($argument),*) };
                }
                if is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has the feature the function is compiled for.
                    return unsafe { self.$avx2($($argument),*) };
                }
            }
            self.$any($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx512f,avx512dq")]
        fn $avx512(&self, $($argument: $type),*) -> $out {
            self.$any($($argument),*)
        }

        #[cfg(target_arch = "x86_64")]
        #[target_feature(enable = "avx2")]
        fn $avx2(&self, $($argument: $type),*) -> $out {
            self.$any($($argument),*)
        }
    };
}

impl FromIterator<Source> for PointCharges {
    fn from_iter<I: IntoIterator<Item = Source>>(sources: I) -> Self {
        let sources: Vec<Source> = sources.into_iter().collect();
        let none = Source { place: Vec3::zeros(), strength: 0.0, least_distance_angstrom: 1.0 };
        let group = |chunk: &[Source]| {
            let at = |lane: usize| chunk.get(lane).unwrap_or(&none);
            Group {
                x: std::array::from_fn(|lane| at(lane).place.x),
                y: std::array::from_fn(|lane| at(lane).place.y),
                z: std::array::from_fn(|lane| at(lane).place.z),
                strength: std::array::from_fn(|lane| at(lane).strength),
                least: std::array::from_fn(|lane| at(lane).least_distance_angstrom),
            }
        };
        Self { groups: sources.chunks(LANES).map(group).collect() }
    }
}

impl PointCharges {
    vectorised!(
        /// Σ s_i / r_i.
        coulomb, coulomb_any, coulomb_avx512, coulomb_avx2, (place: &Vec3) -> f64
    );
    vectorised!(
        /// Σ s_i / r_i and its gradient.
        coulomb_with_gradient, gradient_any, gradient_avx512, gradient_avx2, (place: &Vec3) -> (f64, Vec3)
    );
    vectorised!(
        /// Σ s_i exp(-κ r_i) / r_i.
        screened, screened_any, screened_avx512, screened_avx2, (place: &Vec3, kappa: f64) -> f64
    );

    #[inline(always)]
    fn coulomb_any(&self, place: &Vec3) -> f64 {
        let mut sums = [0.0; LANES];
        for group in &self.groups {
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

    #[inline(always)]
    fn gradient_any(&self, place: &Vec3) -> (f64, Vec3) {
        let (mut values, mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for group in &self.groups {
            for lane in 0..LANES {
                let inverse = 1.0 / group.distance(lane, place);
                let value = group.strength[lane] * inverse;
                let slope = value * inverse * inverse;
                values[lane] += value;
                x[lane] -= (place.x - group.x[lane]) * slope;
                y[lane] -= (place.y - group.y[lane]) * slope;
                z[lane] -= (place.z - group.z[lane]) * slope;
            }
        }
        let sum = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
        (sum(values), Vec3::new(sum(x), sum(y), sum(z)))
    }
}

impl Group {
    #[inline(always)]
    fn distance(&self, lane: usize, place: &Vec3) -> f64 {
        let (dx, dy, dz) = (place.x - self.x[lane], place.y - self.y[lane], place.z - self.z[lane]);
        let (distance, least) = ((dx * dx + dy * dy + dz * dz).sqrt(), self.least[lane]);
        if distance > least { distance } else { least }
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
            let charges: PointCharges = sources.iter().copied().collect();
            for _ in 0..50 {
                let place = rng.vector_in_ball(15.0);
                let (mut value, mut screened, mut gradient, mut size) = (0.0, 0.0, Vec3::zeros(), 1e-300);
                for source in &sources {
                    let offset = place - source.place;
                    let r = offset.norm().max(source.least_distance_angstrom);
                    value += source.strength / r;
                    screened += source.strength * (-0.1 * r).exp() / r;
                    gradient -= offset * (source.strength / r.powi(3));
                    size += source.strength.abs() / r.powi(3) * (r * r + r + offset.norm());
                }
                let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-13 * size, "{count}: {a} {b}");
                close(charges.coulomb(&place), value);
                close(charges.screened(&place, 0.1), screened);
                let (found, slope) = charges.coulomb_with_gradient(&place);
                close(found, value);
                (0..3).for_each(|axis| close(slope[axis], gradient[axis]));
                assert_eq!(charges.coulomb(&place).to_bits(), charges.coulomb_any(&place).to_bits());
                assert_eq!(charges.screened(&place, 0.1).to_bits(), charges.screened_any(&place, 0.1).to_bits());
                assert_eq!(charges.coulomb_with_gradient(&place), charges.gradient_any(&place));
            }
        }
    }
}
