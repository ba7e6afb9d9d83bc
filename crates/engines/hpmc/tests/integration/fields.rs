//! Constant pressure and gravity against exact results; short runs.

use crate::common::{assert_mean, mean_length, pressed, samples, samples_among};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::box_moves::Freedom;
use protomer_hpmc::crystal::{Crystal, UnitCell};
use protomer_hpmc::field::Gravity;
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::simulation::{Sample, Settings};
use protomer_hpmc::start::Start;
use protomer_kernel::shape::builders::by_name;

/// The volume of an ideal gas has the density V^N exp(-βPV), the mean (N + 1)/βP.
#[test]
fn an_ideal_gas_has_its_mean_volume() {
    let point = HardBody::<3>::ball(1e-4).unwrap();
    let packing = 2.0 * 20.0 * point.volume / 20.0;
    let start = Start::fluid(20, packing);
    let (samples, simulation) = samples(&pressed(2.0, Freedom::Volume), &point, &start, 4000);
    assert!((0.15..0.6).contains(&simulation.box_acceptance()));
    let volumes: Vec<f64> = samples
        .iter()
        .map(|sample| 20.0 * point.volume / sample.packing_fraction)
        .collect();
    assert_mean(&volumes, 10.5, 0.015, "volume");
}

/// Hard rods on a ring at constant pressure: the length L has the density L (L - N)^(N-1) exp(-βPL).
#[test]
fn rods_on_a_ring_have_their_mean_length() {
    let rod = HardBody::<1>::ball(0.5).unwrap();
    let crystal = Crystal::new(&UnitCell::by_name("row").unwrap(), &rod, 12, 0.5).unwrap();
    let start = Start::Crystal(crystal);
    for freedom in [Freedom::Volume, Freedom::Lengths] {
        let (samples, _) = samples(&pressed(3.0, freedom), &rod, &start, 20_000);
        let lengths: Vec<f64> = samples
            .iter()
            .map(|sample| 12.0 / sample.packing_fraction)
            .collect();
        // With x = L - N: moments of x^(N-1) exp(-βPx), <L> = <(x + N)²> / <x + N>.
        let (n, p) = (12.0, 3.0);
        let first: f64 = n / p;
        let second = n * (n + 1.0) / (p * p);
        let exact = (second + 2.0 * n * first + n * n) / (first + n);
        assert_mean(&lengths, exact, 0.003, "length");
    }
}

/// The mean of the pressure that trial compressions find is the pressure, whatever the bodies are.
#[test]
fn the_pressure_of_contacts_is_the_pressure() {
    let cube = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    let start = Start::fluid(64, 0.3);
    let (samples, simulation) = samples(&pressed(1.9, Freedom::Volume), &cube, &start, 1000);
    assert!((0.15..0.6).contains(&simulation.box_acceptance()));
    let series: Vec<f64> = samples
        .iter()
        .map(|sample| sample.compressibility_factor * sample.packing_fraction)
        .collect();
    assert_mean(&series, 1.9, 0.03, "pressure");
}

/// Edges that change on their own keep the bodies apart and do not stay equal.
#[test]
fn a_crystal_keeps_its_bodies_apart_when_each_edge_changes() {
    let cube = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    let cell = UnitCell::by_name("simple-cubic").unwrap();
    let crystal = Crystal::new(&cell, &cube, 64, 0.62).unwrap();
    for freedom in [Freedom::Volume, Freedom::Lengths] {
        let start = Start::Crystal(crystal.clone());
        // That no bodies overlap at the end is checked with the samples.
        let (_, simulation) = samples(&pressed(9.0, freedom), &cube, &start, 10);
        let [a, b, c] = simulation.system().space().lengths();
        let are_equal = (a / b - 1.0).abs() < 1e-9 && (b / c - 1.0).abs() < 1e-9;
        assert_eq!(are_equal, freedom == Freedom::Volume);
    }
}

fn falling(weight: f64) -> Settings {
    Settings {
        equilibration_sweeps: 2000,
        gravity: Some(Gravity {
            weight_kt_per_length: weight,
        }),
        ..Settings::default()
    }
}

fn between_walls<const D: usize>(bodies: usize, packing: f64, ratios: [f64; D]) -> Start<D> {
    Start::Fluid {
        bodies,
        packing_fraction: packing,
        edge_ratios: ratios,
        has_walls: true,
    }
}

/// An ideal gas between walls H apart: its mean height is l - H/(exp(H/l) - 1), its profile exponential.
#[test]
fn an_ideal_gas_has_its_profile() {
    let point = HardBody::<3>::ball(1e-4).unwrap();
    // Edges 1, 1, 3 and the gravitational length 1.
    let packing = 50.0 * point.volume / 3.0;
    let start = between_walls(50, packing, [1.0, 1.0, 3.0]);
    let (samples, simulation) = samples(&falling(1.0), &point, &start, 2000);
    let mean = |value: fn(&Sample) -> f64| -> Vec<f64> { samples.iter().map(value).collect() };
    let heights = mean(|sample| sample.walls.unwrap().mean_height);
    assert_mean(&heights, 0.842_812_910_526_232_1, 0.01, "height");
    let bottom = 50.0 / (1.0 - (-3.0_f64).exp());
    let low = mean(|sample| sample.walls.unwrap().pressures[0]);
    assert_mean(&low, bottom, 0.05, "pressure below");
    let high = mean(|sample| sample.walls.unwrap().pressures[1]);
    assert_mean(&high, bottom * (-3.0_f64).exp(), 0.3, "pressure above");
    // The lower half of the box.
    let parts = simulation.heights().parts();
    let below: f64 = parts[..parts.len() / 2].iter().sum();
    let exact = (1.0 - (-1.5_f64).exp()) / (1.0 - (-3.0_f64).exp());
    assert!((below - exact).abs() < 0.02, "{below} {exact}");
}

/// Whatever the bodies are, the walls' pressures differ by the weight over the area.
#[test]
fn walls_bear_the_weight_of_bodies() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let cube = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    for (body, width) in [(ball, 2.1), (cube, 3.5)] {
        let start = between_walls(60, 0.2, [1.0, 1.0, 1.5]);
        let (samples, simulation) = samples(&falling(0.5), &body, &start, 2000);
        let edges = simulation.system().space().lengths();
        assert!(edges[0] > width, "{edges:?}");
        let weight = 60.0 * 0.5 / (edges[0] * edges[1]);
        let series: Vec<f64> = samples
            .iter()
            .map(|sample| {
                let [low, high] = sample.walls.unwrap().pressures;
                low - high
            })
            .collect();
        assert_mean(&series, weight, 0.15, "weight");
    }
}

/// Hard rods on a ring among depletants of radius r, at an osmotic pressure Π: each gap g has the weight
/// exp(-Π g - z min(g, 2 r)), and a ring of length L once more the weight L.
#[test]
fn rods_among_depletants_have_their_mean_length() {
    let (rods, pressure, radius, fugacity) = (12.0, 2.0, 0.2, 3.0);
    let weight = |gap: f64| (-pressure * gap - fugacity * gap.min(2.0 * radius)).exp();
    let exact = mean_length(rods, weight);
    let rod = HardBody::<1>::ball(0.5).unwrap();
    let crystal = Crystal::new(&UnitCell::by_name("row").unwrap(), &rod, 12, 0.5).unwrap();
    for freedom in [Freedom::Volume, Freedom::Lengths] {
        let depletants = [Depletant { radius, fugacity }];
        let start = Start::Crystal(crystal.clone());
        let settings = pressed(pressure, freedom);
        let (samples, _) = samples_among(&depletants, &settings, &rod, &start, 20_000);
        let lengths: Vec<f64> = samples
            .iter()
            .map(|sample| rods / sample.packing_fraction)
            .collect();
        assert_mean(&lengths, exact, 0.01, "length");
    }
}

/// One rod that falls among depletants between walls: its height h has the weight exp(-w h + z V_free(h)).
#[test]
fn a_rod_that_falls_among_depletants_has_its_mean_height() {
    let (edge, weight_kt, radius, fugacity) = (4.0, 0.5, 0.3, 3.0);
    let free = |height: f64| {
        let gaps = [height - 0.5, edge - height - 0.5];
        gaps.map(|gap| (gap - 2.0 * radius).max(0.0))
            .iter()
            .sum::<f64>()
    };
    let (mut norm, mut first) = (0.0, 0.0);
    for cell in 0..30_000 {
        let height = 0.5 + 1e-4 * (f64::from(cell) + 0.5);
        let weight = (-weight_kt * height + fugacity * free(height)).exp();
        norm += weight;
        first += weight * height;
    }
    let rod = HardBody::<1>::ball(0.5).unwrap();
    let depletants = [Depletant { radius, fugacity }];
    let start = between_walls(1, 1.0 / edge, [1.0]);
    let (samples, _) = samples_among(&depletants, &falling(weight_kt), &rod, &start, 40_000);
    let heights: Vec<f64> = samples
        .iter()
        .map(|sample| sample.walls.unwrap().mean_height)
        .collect();
    assert_mean(&heights, first / norm, 0.01, "height");
}

/// Bodies and depletants together press on the walls: the pressures differ by the weight of the bodies.
#[test]
fn walls_bear_the_weight_of_bodies_among_depletants() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let depletants = [Depletant {
        radius: 0.15,
        fugacity: 5.0,
    }];
    let start = between_walls(60, 0.15, [1.0, 1.0, 1.5]);
    let settings = Settings {
        points: 100,
        ..falling(3.0)
    };
    let (samples, simulation) = samples_among(&depletants, &settings, &ball, &start, 8000);
    let [x, y, _] = *simulation.system().space().lengths();
    let differences: Vec<f64> = samples
        .iter()
        .map(|sample| {
            let [low, high] = sample.walls.unwrap().pressures;
            low - high
        })
        .collect();
    assert_mean(
        &differences,
        60.0 * 3.0 / (x * y),
        0.08,
        "difference of pressures",
    );
}
