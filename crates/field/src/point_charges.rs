//! Sums over point charges, eight at a time.
//!
//! The vector instructions do the same operations in the same order as the portable code, so every
//! machine finds the same bits.

use protomer_kernel::Vec3;
use protomer_kernel::potential::exp_of_minus;

/// Charges in a group.
const LANES: usize = 8;

/// Squares nearer than this many of their edges take their exact solid angle; for others an
/// expansion is within 10⁻³ of it.
const NEAR_IN_EDGES: f64 = 4.0;

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

/// A method that is compiled once for each instruction set and chosen at run time.
macro_rules! vectorised {
    ($(#[$doc:meta])* $name:ident, $any:ident, $avx512:ident, $avx2:ident, ($($argument:ident: $type:ty),*) -> $out:ty) => {
        $(#[$doc])*
        pub fn $name(&self, $($argument: $type),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            {
                if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                    // SAFETY: the processor has the features that the function is compiled for.
                    return unsafe { self.$avx512($($argument),*) };
                }
                if is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has the feature that the function is compiled for.
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

    /// Places and strengths of the sources that have a strength.
    pub fn sources(&self) -> Vec<(Vec3, f64)> {
        let mut sources = Vec::new();
        for group in &self.groups {
            for lane in 0..LANES {
                if group.strength[lane] != 0.0 {
                    let place = Vec3::new(group.x[lane], group.y[lane], group.z[lane]);
                    sources.push((place, group.strength[lane]));
                }
            }
        }
        sources
    }

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

    vectorised!(
        /// Flux of -∇ Σ s_i / r_i through a square (its middle and edge) perpendicular to an axis,
        /// in the direction of the axis: Σ s_i Ω_i with the solid angle Ω_i. For charges far away
        /// it is ∫ f = edge² (f + edge²/24 (f_xx + f_yy)), with f = z/r³ at the middle.
        flux, flux_any, flux_avx512, flux_avx2, (middle: &Vec3, axis: usize, edge: f64) -> f64
    );

    #[inline(always)]
    fn flux_any(&self, middle: &Vec3, axis: usize, edge: f64) -> f64 {
        let near = (NEAR_IN_EDGES * edge).powi(2);
        let area = edge * edge;
        let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
        let [at_z, at_x, at_y] = [middle[axis], middle[second], middle[third]];
        let mut sums = [0.0; LANES];
        for group in &self.groups {
            let coordinates = [&group.x, &group.y, &group.z];
            let [z, x, y] = [axis, second, third].map(|axis| coordinates[axis]);
            let mut nearest = f64::INFINITY;
            let mut far = [0.0; LANES];
            for lane in 0..LANES {
                let (dz, dx, dy) = (at_z - z[lane], at_x - x[lane], at_y - y[lane]);
                let square = dx * dx + dy * dy + dz * dz;
                nearest = if square < nearest { square } else { nearest };
                let inverse = 1.0 / square;
                let value = dz * inverse * inverse.sqrt();
                // f is harmonic: f_xx + f_yy = -f_zz.
                let curvature = value * inverse * (9.0 - 15.0 * dz * dz * inverse);
                far[lane] = group.strength[lane] * area * (value + area / 24.0 * curvature);
            }
            if nearest > near {
                for lane in 0..LANES {
                    sums[lane] += far[lane];
                }
            } else {
                for lane in 0..LANES {
                    let offset = [at_z - z[lane], at_x - x[lane], at_y - y[lane]];
                    sums[lane] += group.strength[lane] * solid_angle(offset, edge);
                }
            }
        }
        sums.iter().sum()
    }

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
        let (mut values, mut x, mut y, mut z) =
            ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
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
        let [value, x, y, z]: [f64; 4] = [values, x, y, z].map(|lanes| lanes.iter().sum());
        (value, Vec3::new(x, y, z))
    }
}

/// The solid angle of a square with its middle at z along its axis and x, y across, negative for
/// negative z: the sum of ± atan(x y / (z r)) over its corners.
fn solid_angle([z, x, y]: [f64; 3], edge: f64) -> f64 {
    let mut angle = 0.0;
    for (right, up) in [(1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0)] {
        let (x, y) = (x + 0.5 * edge * right, y + 0.5 * edge * up);
        let distance = (x * x + y * y + z * z).sqrt();
        angle += right * up * (x * y).atan2(z.abs() * distance);
    }
    if z < 0.0 { -angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn fluxes_are_those_of_many_points() {
        let mut rng = CounterRng::new(62, 0, 0);
        let (edge, n) = (0.7, 200);
        for turn in 0..60 {
            let axis = turn % 3;
            let place = rng.vector_in_ball(if turn < 30 { 1.5 } else { 8.0 });
            let source = Source {
                place,
                strength: 1.3,
                least_distance_angstrom: 1e-3,
            };
            let charges = PointCharges::new(&[source]);
            let middle = Vec3::new(0.1, -0.2, 0.3);
            let mut sum = 0.0;
            for code in 0..n * n {
                let along = |index: usize| edge * ((index as f64 + 0.5) / n as f64 - 0.5);
                let mut offset = middle - place;
                offset[(axis + 1) % 3] += along(code % n);
                offset[(axis + 2) % 3] += along(code / n);
                sum += 1.3 * offset[axis] / offset.norm().powi(3) * (edge / n as f64).powi(2);
            }
            let found = charges.flux(&middle, axis, edge);
            let whole = 1.3 * edge * edge / (middle - place).norm_squared();
            assert!((found - sum).abs() < 1e-3 * whole, "{place}: {found} {sum}");
            assert_eq!(
                found.to_bits(),
                charges.flux_any(&middle, axis, edge).to_bits()
            );
        }
    }

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
                let (mut value, mut screened, mut gradient, mut size) =
                    (0.0, 0.0, Vec3::zeros(), 1e-300);
                for source in &sources {
                    let offset = place - source.place;
                    let r = offset.norm().max(source.least_distance_angstrom);
                    value += source.strength / r;
                    screened += source.strength * (-0.1 * r).exp() / r;
                    gradient -= offset * (source.strength / r.powi(3));
                    size += source.strength.abs() / r.powi(3) * (r * r + r + offset.norm());
                }
                let close =
                    |a: f64, b: f64| assert!((a - b).abs() <= 1e-13 * size, "{count}: {a} {b}");
                close(charges.coulomb(&place), value);
                close(charges.screened(&place, 0.1), screened);
                let (found, slope) = charges.coulomb_with_gradient(&place);
                close(found, value);
                (0..3).for_each(|axis| close(slope[axis], gradient[axis]));
                assert_eq!(
                    charges.coulomb(&place).to_bits(),
                    charges.coulomb_any(&place).to_bits()
                );
                assert_eq!(
                    charges.screened(&place, 0.1).to_bits(),
                    charges.screened_any(&place, 0.1).to_bits()
                );
                assert_eq!(
                    charges.coulomb_with_gradient(&place),
                    charges.gradient_any(&place)
                );
            }
        }
    }
}
