//! How far screened bodies surely interact, from their multipoles.
//!
//! The sum of magnitudes bounds the energy of two bodies, but proteins have nearly as many positive
//! as negative partial charges: it promises a thousand times too much, and a reach that is longer
//! by many Debye lengths. Outside the sphere around its charges the potential of a body is
//!
//! φ(x) = λ_B κ Σ_l (2l+1) k_l(κ|x|) m_l(x/|x|) ≤ F(|x|) = λ_B κ Σ_l (2l+1) k_l(κ|x|) M_l,
//!
//! M_l² = Σ_ij q_i q_j i_l(κ r_i) i_l(κ r_j) P_l(cos γ_ij), with the modified spherical Bessel functions
//! i_0(x) = sinh(x)/x and k_0(x) = exp(-x)/x. In the ball of radius ρ around a second body, φ solves the
//! same equation. By the inequality of Cauchy and Schwarz over spherical harmonics, with the largest
//! φ on its sphere, for every ρ above the second body's radius
//!
//! |E| ≤ F(d - ρ) (Σ_l (2l+1) (M'_l / i_l(κρ))²)^½.

use crate::charges::ChargeCloud;
use protomer_kernel::Vec3;
use protomer_kernel::bisection::halved;
use protomer_kernel::potential::Yukawa;

/// Multipoles up to this order are summed; above it, magnitudes stand for them.
const ORDERS: usize = 16;
/// Terms of the series. They fall by half or more with each order: what is left out is below 10⁻¹⁷ of
/// the sum of magnitudes.
const TERMS: usize = 64;
/// The series are used from this many radii of a body on: their terms halve with each order.
const CONVERGING_RADII: f64 = 2.0;
/// The radii ρ that are tried, in radii of the second body.
const SPHERES: [f64; 6] = [2.0, 2.5, 3.0, 4.0, 6.0, 10.0];
/// The least radius of a body, Å: that of a single charge at its origin would be zero.
const LEAST_RADIUS_ANGSTROM: f64 = 1.0;
/// Rounding error of sums of charges over the sum of their magnitudes: multipoles may be smaller by
/// so much.
const ROUNDING: f64 = 1e-12;
/// Halvings of the interval in which the reach lies.
const HALVINGS: u32 = 40;

/// The multipoles of a body, seen through an electrolyte.
#[derive(Debug, Clone)]
pub struct FarField {
    /// Radius of the sphere around the origin that holds all charges, Å.
    radius_angstrom: f64,
    sum_of_magnitudes_e: f64,
    /// Bounds on M_l exp(-κR), e.
    moments_e: Vec<f64>,
}

impl FarField {
    /// Multipoles of these charges.
    pub fn new(charges: &ChargeCloud, potential: &Yukawa) -> Self {
        let kappa = potential.inverse_debye_length_per_angstrom;
        let radius_angstrom = charges.radius_angstrom().max(LEAST_RADIUS_ANGSTROM);
        let mut components = vec![[0.0; 2]; ORDERS * ORDERS];
        let mut magnitudes = vec![0.0; TERMS];
        for (place, charge) in charges.iter() {
            let distance = place.norm();
            // i_l(κ r) exp(-κ r), scaled: unscaled, it
            // overflows for large bodies at low Debye lengths.
            let bessel = scaled_i(kappa * distance);
            // exp(κ(r - R)) turns the scale of the charge
            // into that of the sphere; it is at most one.
            let weight = (kappa * (distance - radius_angstrom)).exp();
            for (order, magnitude) in magnitudes.iter_mut().enumerate() {
                // Σ |q| i_l bounds M_l, as |P_l(cos γ)| ≤ 1.
                *magnitude += charge.abs() * weight * bessel[order];
            }
            let harmonics = harmonics(&place);
            for l in 0..ORDERS {
                for m in 0..=l {
                    let [real, imaginary] = harmonics[l * ORDERS + m];
                    let strength = charge * weight * bessel[l];
                    components[l * ORDERS + m][0] += strength * real;
                    components[l * ORDERS + m][1] += strength * imaginary;
                }
            }
        }
        let moment = |l: usize| {
            let square = |m: usize| {
                let [real, imaginary] = components[l * ORDERS + m];
                // Those of m and -m are equal.
                let both = if m > 0 { 2.0 } else { 1.0 };
                both * (real * real + imaginary * imaginary)
            };
            (0..=l).map(square).sum::<f64>().sqrt()
        };
        // Above the orders that are summed, magnitudes bound the moments: less sharp, still true.
        let bound = |(l, magnitude): (usize, f64)| if l < ORDERS { moment(l) } else { magnitude };
        Self {
            radius_angstrom,
            sum_of_magnitudes_e: charges.sum_of_magnitudes_e(),
            moments_e: magnitudes.into_iter().enumerate().map(bound).collect(),
        }
    }

    /// The distance of origins beyond which this body and another surely hold less than `energy_kt`,
    /// Å.
    pub fn reach_angstrom(&self, other: &Self, potential: &Yukawa, energy_kt: f64) -> f64 {
        let product = self.sum_of_magnitudes_e * other.sum_of_magnitudes_e;
        // Without charges nothing is held at any distance.
        if product == 0.0 {
            return 0.0;
        }
        let radii = self.radius_angstrom + other.radius_angstrom;
        // Always valid, and the end of the interval in which the bisection searches.
        let of_magnitudes = radii + potential.reach_angstrom(product, energy_kt);
        if of_magnitudes.is_infinite() || potential.is_cut() {
            return of_magnitudes;
        }
        let largest_energy_kt = self.largest_energy_kt(other, potential);
        // The bound falls with the distance, so the first end stays on the safe side: beyond it the energy surely is below the
        // limit.
        let is_beyond = |distance: f64| largest_energy_kt(distance) < energy_kt;
        halved([of_magnitudes, 0.0], HALVINGS, is_beyond)[0]
    }

    /// The most that this body and another can hold, kT, as a function of the distance of their origins
    /// (Å) that nowhere rises.
    pub fn largest_energy_kt<'a>(
        &'a self,
        other: &'a Self,
        potential: &'a Yukawa,
    ) -> impl Fn(f64) -> f64 + 'a {
        let product = self.sum_of_magnitudes_e * other.sum_of_magnitudes_e;
        let radii = self.radius_angstrom + other.radius_angstrom;
        // Either body may be the source and the other the
        // probe; both bounds hold, the smaller counts.
        let ways = [(self, other), (other, self)];
        let spheres = ways.into_iter().flat_map(|(source, probe)| {
            SPHERES.map(|radii| {
                let sphere_angstrom = radii * probe.radius_angstrom;
                let seen_e = probe.strength_within_e(sphere_angstrom, potential);
                (source, sphere_angstrom, seen_e)
            })
        });
        let spheres: Vec<_> = spheres.collect();
        move |distance_angstrom| {
            // The spheres overlap: no expansion converges, and nothing is claimed.
            if distance_angstrom <= radii {
                return f64::INFINITY;
            }
            let of_magnitudes = product * potential.energy_kt(distance_angstrom - radii);
            if potential.is_cut() {
                return of_magnitudes;
            }
            let mut least = of_magnitudes;
            // Every sphere gives a bound; which is best depends on the distance, so all are tried.
            for (source, sphere_angstrom, seen_e) in &spheres {
                let to_sphere = distance_angstrom - sphere_angstrom;
                // Nearer, the series converge too slowly for the terms that are kept.
                if to_sphere >= CONVERGING_RADII * source.radius_angstrom {
                    least = least.min(seen_e * source.largest_potential(to_sphere, potential));
                }
            }
            // Multipoles that cancel may be rounding; magnitudes say how large that is.
            least + ROUNDING * of_magnitudes
        }
    }

    /// (Σ_l (2l+1) (M_l / i_l(κρ))²)^½, e.
    fn strength_within_e(&self, sphere_angstrom: f64, potential: &Yukawa) -> f64 {
        let kappa = potential.inverse_debye_length_per_angstrom;
        let bessel = scaled_i(kappa * sphere_angstrom);
        let weight = (kappa * (self.radius_angstrom - sphere_angstrom)).exp();
        let term = |(l, moment): (usize, &f64)| {
            // 0/0 where both are below the smallest number: such an order adds nothing.
            let ratio = match moment {
                0.0 => 0.0,
                _ => moment * weight / bessel[l],
            };
            (2 * l + 1) as f64 * ratio * ratio
        };
        self.moments_e
            .iter()
            .enumerate()
            .map(term)
            .sum::<f64>()
            .sqrt()
    }

    /// F at a distance from the origin, kT/e.
    fn largest_potential(&self, distance_angstrom: f64, potential: &Yukawa) -> f64 {
        let kappa = potential.inverse_debye_length_per_angstrom;
        let bessel = scaled_k(kappa * distance_angstrom);
        let decay = (kappa * (self.radius_angstrom - distance_angstrom)).exp();
        let term = |(l, moment): (usize, &f64)| (2 * l + 1) as f64 * bessel[l] * moment;
        let sum: f64 = self.moments_e.iter().enumerate().map(term).sum();
        potential.bjerrum_length_angstrom * kappa * decay * sum
    }
}

/// i_l(x) exp(-x): by the recurrence downwards, which is stable, in units of its first.
fn scaled_i(x: f64) -> [f64; TERMS] {
    let mut values = [0.0; TERMS];
    if x < f64::MIN_POSITIVE.sqrt() {
        values[0] = 1.0;
        return values;
    }
    // Ratios i_{l+1}/i_l; the first guess is forgotten well before the last term.
    let mut ratio = 0.0;
    let mut ratios = [0.0; TERMS];
    // Miller's algorithm: so far above the last term, the wrong start has died out.
    let start = 2 * TERMS + x as usize;
    for l in (0..start).rev() {
        ratio = 1.0 / ((2 * l + 3) as f64 / x + ratio);
        if l < TERMS {
            ratios[l] = ratio;
        }
    }
    // sinh(x)/x · exp(-x) by expm1, exact also for small x.
    values[0] = -(-2.0 * x).exp_m1() / (2.0 * x);
    for l in 1..TERMS {
        values[l] = values[l - 1] * ratios[l - 1];
    }
    values
}

/// k_l(x) exp(x), by the recurrence upwards.
fn scaled_k(x: f64) -> [f64; TERMS] {
    let mut values = [0.0; TERMS];
    values[0] = 1.0 / x;
    values[1] = (1.0 + 1.0 / x) / x;
    for l in 2..TERMS {
        values[l] = values[l - 2] + (2 * l - 1) as f64 / x * values[l - 1];
    }
    values
}

/// Real and imaginary parts of √((l-m)!/(l+m)!) P_lm(cos θ) exp(imφ) in the direction of a place, at
/// l · ORDERS + m for 0 ≤ m ≤ l: Σ_m of the products of two directions is P_l(cos γ).
fn harmonics(place: &Vec3) -> Vec<[f64; 2]> {
    let axis_distance = place.x.hypot(place.y);
    let length = place.norm().max(f64::MIN_POSITIVE);
    let (cosine, sine) = (place.z / length, axis_distance / length);
    let azimuth = place.y.atan2(place.x);
    let mut legendre = vec![0.0; ORDERS * ORDERS];
    let mut diagonal = 1.0;
    for m in 0..ORDERS {
        // P_mm from P_{m-1,m-1}, with the normalisation √((l-m)!/(l+m)!) taken along.
        if m > 0 {
            diagonal *= sine * ((2 * m - 1) as f64 / (2 * m) as f64).sqrt();
        }
        let (mut before, mut value) = (0.0, diagonal);
        for l in m..ORDERS {
            legendre[l * ORDERS + m] = value;
            // (l-m)(l+m): roots of these replace factorials, which would overflow.
            let difference = |l: usize| (l * l - m * m) as f64;
            let next = (2 * l + 1) as f64 * cosine * value - difference(l).sqrt() * before;
            (before, value) = (value, next / difference(l + 1).sqrt());
        }
    }
    let part = |(place, value): (usize, f64)| {
        let (sine, cosine) = ((place % ORDERS) as f64 * azimuth).sin_cos();
        [value * cosine, value * sine]
    };
    legendre.into_iter().enumerate().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::pair_energy_kt;
    use protomer_kernel::Pose;
    use protomer_kernel::pose::RelativePose;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn products_of_harmonics_are_legendre_polynomials() {
        let mut rng = CounterRng::new(1, 0, 0);
        for _ in 0..50 {
            let (a, b) = (rng.unit_vector(), rng.unit_vector());
            let (of_a, of_b) = (harmonics(&a), harmonics(&b));
            let (mut before, mut legendre) = (0.0, 1.0);
            for l in 0..ORDERS {
                let product = |m: usize| {
                    let [a, b] = [&of_a, &of_b].map(|moments| moments[l * ORDERS + m]);
                    let both = if m > 0 { 2.0 } else { 1.0 };
                    both * (a[0] * b[0] + a[1] * b[1])
                };
                let sum: f64 = (0..=l).map(product).sum();
                assert!((sum - legendre).abs() < 1e-12, "{l}: {sum} {legendre}");
                let n = l as f64;
                let next = ((2.0 * n + 1.0) * a.dot(&b) * legendre - n * before) / (n + 1.0);
                (before, legendre) = (legendre, next);
            }
        }
    }

    #[test]
    fn the_series_of_two_charges_is_the_screened_potential() {
        for (near, far, kappa) in [(3.0, 7.0, 0.1), (20.0, 45.0, 0.3), (0.0, 5.0, 0.05)] {
            let (i, k) = (scaled_i(kappa * near), scaled_k(kappa * far));
            for cosine in [1.0, 0.3, -0.9] {
                let (mut before, mut legendre, mut sum) = (0.0, 1.0, 0.0);
                for l in 0..TERMS {
                    sum += (2 * l + 1) as f64 * i[l] * k[l] * legendre;
                    let n = l as f64;
                    let next = ((2.0 * n + 1.0) * cosine * legendre - n * before) / (n + 1.0);
                    (before, legendre) = (legendre, next);
                }
                let series = kappa * (kappa * (near - far)).exp() * sum;
                let distance = f64::sqrt(near * near + far * far - 2.0 * near * far * cosine);
                let expected = (-kappa * distance).exp() / distance;
                assert!(
                    (series / expected - 1.0).abs() < 1e-10,
                    "{series} {expected}"
                );
            }
        }
    }

    #[test]
    fn no_pair_beyond_the_reach_holds_more() {
        let mut rng = CounterRng::new(2, 0, 0);
        let mut cloud = |charges: usize, radius: f64, mean: f64| {
            let mut placed = Vec::new();
            for _ in 0..charges {
                let charge = mean + rng.uniform_in(-0.5, 0.5);
                placed.push((rng.vector_in_ball(radius), charge));
            }
            ChargeCloud::new(&placed)
        };
        let clouds = [
            cloud(800, 25.0, 0.04),
            cloud(600, 20.0, -0.02),
            cloud(2, 3.0, 0.0),
            ChargeCloud::new(&[(Vec3::zeros(), 1.0)]),
        ];
        let mut rng = CounterRng::new(3, 0, 0);
        let energy_kt = 1e-8;
        for debye_angstrom in [3.0, 9.6, 30.0, 100.0] {
            let yukawa = Yukawa::uncut(7.0, 1.0 / debye_angstrom).unwrap();
            let fields = clouds.each_ref().map(|cloud| FarField::new(cloud, &yukawa));
            for (first, of_first) in clouds.iter().zip(&fields) {
                for (second, of_second) in clouds.iter().zip(&fields) {
                    let reach = of_first.reach_angstrom(of_second, &yukawa, energy_kt);
                    let product = first.sum_of_magnitudes_e() * second.sum_of_magnitudes_e();
                    let of_magnitudes = yukawa.reach_angstrom(product, energy_kt)
                        + first.radius_angstrom()
                        + second.radius_angstrom();
                    assert!(reach <= of_magnitudes + 2.0 * LEAST_RADIUS_ANGSTROM);
                    let mut largest: f64 = 0.0;
                    for _ in 0..10 {
                        let position = rng.unit_vector() * reach;
                        let rotation = rng.rotation();
                        let pose = Pose { position, rotation };
                        let pose = RelativePose::new(&Pose::identity(), &pose, &position);
                        let energy = pair_energy_kt(&yukawa, first, second, &pose);
                        largest = largest.max(energy.abs());
                    }
                    assert!(
                        largest < energy_kt,
                        "{debye_angstrom}: {largest} at {reach}"
                    );
                }
            }
        }
    }

    /// At 30 mM the reach of two proteins with all partial charges is shorter by six Debye lengths.
    #[test]
    fn it_is_much_shorter_for_bodies_that_are_nearly_neutral() {
        let mut rng = CounterRng::new(4, 0, 0);
        let mut charges = Vec::new();
        for _ in 0..3000 {
            charges.push((rng.vector_in_ball(25.0), rng.uniform_in(-0.5, 0.51)));
        }
        let (cloud, yukawa) = (
            ChargeCloud::new(&charges),
            Yukawa::uncut(7.0, 1.0 / 17.6).unwrap(),
        );
        let field = FarField::new(&cloud, &yukawa);
        let product = cloud.sum_of_magnitudes_e().powi(2);
        let of_magnitudes = yukawa.reach_angstrom(product, 1e-8) + 50.0;
        let reach = field.reach_angstrom(&field, &yukawa, 1e-8);
        assert!(
            of_magnitudes - reach > 6.0 * 17.6,
            "{reach} of {of_magnitudes}"
        );
    }
}
