//! Virial coefficients against closed forms and quadrature.

use protomer_hpmc::body::HardBody;
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::virial::{DepletedPair, Estimate, SampledVirials, Triples, draw_triple};
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::swept::Swept;
use protomer_kernel::statistics::RunningMoments;
use protomer_kernel::{Pose, Vec3};
use std::f64::consts::PI;

fn sampled<const D: usize>(body: &HardBody<D>, count: u64) -> SampledVirials {
    let mut triples = Triples::default();
    for number in 0..count {
        triples = triples.with(draw_triple(body, 3, number).unwrap());
    }
    triples.virials(body)
}

fn assert_within(found: Estimate, expected: f64) {
    let off = (found.mean - expected).abs();
    assert!(
        off < 4.0 * found.error && found.error < 0.02 * expected,
        "{found:?}, not {expected}"
    );
}

#[test]
fn the_third_coefficient_is_that_of_balls_and_disks() {
    // B3 = 10 v² for spheres.
    let ball = HardBody::<3>::ball(0.7).unwrap();
    let found = sampled(&ball, 20_000);
    // All places in the ball about the first are of overlaps.
    assert!(
        (found.b2.mean / (4.0 * ball.volume) - 1.0).abs() < 1e-12,
        "{found:?}"
    );
    let b3 = found.b3_over_b2_squared.mean * (4.0 * ball.volume).powi(2);
    assert!(
        (b3 / (10.0 * ball.volume.powi(2)) - 1.0).abs() < 0.03,
        "{b3}"
    );
    let disk = HardBody::<2>::ball(0.7).unwrap();
    assert_within(
        sampled(&disk, 20_000).b3_over_b2_squared,
        4.0 / 3.0 - 3.0_f64.sqrt() / PI,
    );
}

#[test]
fn the_second_coefficient_of_the_same_draws_is_that_of_isihara() {
    for (name, rounding) in [("cube", 0.0), ("tetrahedron", 0.1), ("cuboid:1,1,4", 0.0)] {
        let shape = by_name(name).unwrap();
        let found = sampled(&HardBody::<3>::new(&shape, rounding).unwrap(), 5000);
        assert_within(found.b2, Measures::from_shape(&shape, rounding).unwrap().b2);
    }
    let shape = by_name("polygon:5").unwrap();
    let found = sampled(&HardBody::<2>::new(&shape, 0.0).unwrap(), 5000);
    assert_within(found.b2, Measures::from_shape(&shape, 0.0).unwrap().b2);
}

/// Two halves of a cuboid are the cuboid.
#[test]
fn pieces_have_the_coefficients_of_what_they_make() {
    let whole = by_name("cuboid:2,1,1").unwrap();
    let half = |x: f64| {
        let corner = |n: u32| {
            Vec3::new(
                x + f64::from(n & 1),
                f64::from(n >> 1 & 1),
                f64::from(n >> 2),
            )
        };
        Shape::solid(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
    };
    let pieces = sampled(
        &HardBody::<3>::of_pieces(&[half(0.0), half(1.0)], 0.0).unwrap(),
        10_000,
    );
    assert_within(pieces.b2, Measures::from_shape(&whole, 0.0).unwrap().b2);
    let one = sampled(&HardBody::<3>::new(&whole, 0.0).unwrap(), 10_000);
    let [a, b] = [pieces, one].map(|found| found.b3_over_b2_squared);
    assert!(
        (a.mean - b.mean).abs() < 4.0 * a.error.hypot(b.error),
        "{a:?} {b:?}"
    );
}

/// In rejection sampling the number of draws says nothing about the places that end them, so the errors of
/// B2 and of B3/B2² of a concave body are independent, though both come from the same triples.
#[test]
fn numbers_of_draws_and_overlaps_are_not_correlated() {
    const COUNT: u64 = 20_000;
    let arms = [
        [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]],
        [[0.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]],
    ];
    let arms = arms.map(|corners| Shape::flat(&corners).unwrap());
    let body = HardBody::<2>::of_pieces(&arms, 0.0).unwrap();
    let (mut draws, mut overlaps) = (Vec::new(), Vec::new());
    for number in 0..COUNT {
        let triple = draw_triple(&body, 3, number).unwrap();
        draws.push(triple.draws as f64);
        overlaps.push(f64::from(u8::from(triple.overlaps)));
    }
    let [x, y] =
        [&draws, &overlaps].map(|series| series.iter().copied().collect::<RunningMoments>());
    let pairs = draws.iter().zip(&overlaps);
    let covariance: f64 = pairs.map(|(a, b)| (a - x.mean()) * (b - y.mean())).sum();
    let scale = COUNT as f64 * x.standard_deviation() * y.standard_deviation();
    let correlation = covariance / scale;
    assert!(
        scale > 0.0 && correlation.abs() < 4.0 / (COUNT as f64).sqrt(),
        "{correlation}"
    );
}

/// A few triples that all overlap, or of which none does, leave the coefficient uncertain.
#[test]
fn triples_that_are_all_alike_have_an_error() {
    let body = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    for overlapping in [0, 20] {
        let triples = Triples {
            count: 20,
            overlapping,
            draws: 100,
        };
        let found = triples.virials(&body).b3_over_b2_squared;
        // That of one triple of 20: 4/3 √(0.05 · 0.95 / 20).
        assert!((found.error - 0.064_979).abs() < 1e-6, "{found:?}");
    }
}

/// B2 of spheres in the potential of Asakura and Oosawa, by Simpson's rule.
fn asakura_oosawa(radii: [f64; 2], depletant: Depletant) -> f64 {
    let [a, b] = radii.map(|radius| radius + depletant.radius);
    let (contact, end) = (radii[0] + radii[1], a + b);
    // The lens of two balls.
    let lens = |r: f64| {
        PI * (a + b - r).powi(2) * (r * r + 2.0 * r * (a + b) - 3.0 * (a - b).powi(2)) / (12.0 * r)
    };
    let integrand = |r: f64| r * r * (depletant.fugacity * lens(r)).exp_m1();
    let (count, mut sum) = (2000, 0.0);
    let step = (end - contact) / count as f64;
    for number in 0..=count {
        let weight = match number {
            0 => 1.0,
            n if n == count => 1.0,
            n if n % 2 == 1 => 4.0,
            _ => 2.0,
        };
        sum += weight * integrand(contact + step * number as f64) * step / 3.0;
    }
    2.0 * PI * sum
}

fn mean_over_rays(pair: &DepletedPair<'_>, rays: u64) -> RunningMoments {
    (0..rays)
        .map(|number| pair.on_ray(1, number).unwrap())
        .collect()
}

#[test]
fn depletants_act_between_spheres_as_asakura_and_oosawa_say() {
    let point = Shape::solid(&[Vec3::zeros()]).unwrap();
    for (radii, radius, fugacity) in [([0.5, 0.5], 0.1, 20.0), ([0.5, 0.3], 0.25, 3.0)] {
        let kinds = [Depletant { radius, fugacity }];
        let pair = DepletedPair::new([&point, &point], radii, &kinds).unwrap();
        let found = mean_over_rays(&pair, 8);
        let expected = asakura_oosawa(radii, kinds[0]);
        assert!(
            (found.mean() / expected - 1.0).abs() < 3e-4,
            "{found:?}, not {expected}"
        );
    }
    // Two kinds of half the density are one.
    let whole = [Depletant {
        radius: 0.1,
        fugacity: 20.0,
    }];
    let halves = [Depletant {
        radius: 0.1,
        fugacity: 10.0,
    }; 2];
    let both = [&whole[..], &halves[..]].map(|kinds| {
        let pair = DepletedPair::new([&point, &point], [0.5, 0.5], kinds).unwrap();
        pair.on_ray(1, 1).unwrap()
    });
    assert!((both[0] / both[1] - 1.0).abs() < 1e-9, "{both:?}");
}

/// Disks share a lens.
#[test]
fn depletants_act_between_disks_over_the_lens_of_both() {
    let point = Shape::flat(&[[0.0, 0.0]]).unwrap();
    let kinds = [Depletant {
        radius: 0.2,
        fugacity: 4.0,
    }];
    let pair = DepletedPair::new([&point, &point], [0.5, 0.5], &kinds).unwrap();
    let radius = 0.7;
    let lens = |r: f64| {
        2.0 * radius * radius * (r / (2.0 * radius)).acos()
            - 0.5 * r * (4.0 * radius * radius - r * r).max(0.0).sqrt()
    };
    let (count, mut sum) = (20_000, 0.0);
    let step = 0.4 / f64::from(count);
    for number in 0..count {
        let r = 1.0 + step * (f64::from(number) + 0.5);
        sum += step * r * (4.0 * lens(r)).exp_m1();
    }
    let found = mean_over_rays(&pair, 8).mean();
    assert!(
        (found / (PI * sum) - 1.0).abs() < 3e-4,
        "{found} {}",
        PI * sum
    );
}

/// For few depletants the integral is that of n v over places without overlap, which points drawn in both bodies
/// give too.
#[test]
fn few_depletants_take_their_number_times_the_mean_of_the_shared_volume() {
    let (cube, radius) = (by_name("cube").unwrap(), 0.2);
    let kinds = [Depletant {
        radius,
        fugacity: 1e-6,
    }];
    let pair = DepletedPair::new([&cube, &cube], [0.0, 0.0], &kinds).unwrap();
    let found = mean_over_rays(&pair, 200);
    let outer = 0.5 * 3.0_f64.sqrt() + radius;
    let still = Swept::new(&cube, radius, &Pose::identity()).unwrap();
    let mut drawn = RunningMoments::default();
    for number in 0..60_000 {
        let mut rng = CounterRng::new(9, 0, number);
        let point = rng.vector_in_ball(outer);
        let pose = Pose {
            position: rng.vector_in_ball(2.0 * outer),
            rotation: rng.rotation(),
        };
        let moving = Swept::new(&cube, radius, &pose).unwrap();
        let counts = still.holds(&point)
            && moving.holds(&point)
            && closest_points(still.corners(), moving.corners()).is_some();
        drawn.push(f64::from(u8::from(counts)));
    }
    let ball = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    let scale = 0.5 * ball(outer) * ball(2.0 * outer);
    let (expected, error) = (
        scale * drawn.mean(),
        scale * drawn.independent_standard_error(),
    );
    let [mean, own_error] = [found.mean(), found.independent_standard_error()].map(|x| x / 1e-6);
    assert!(
        (mean - expected).abs() < 4.0 * error.hypot(own_error),
        "{mean} ± {own_error}, not {expected} ± {error}"
    );
    assert!(
        error < 0.1 * expected && own_error < 0.05 * expected,
        "{own_error} {error}"
    );
}
