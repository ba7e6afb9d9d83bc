//! Free energies of crystals against exact numbers; short runs.

use protomer_hpmc::body::HardBody;
use protomer_hpmc::crystal::{Crystal, UnitCell};
use protomer_hpmc::einstein::EinsteinCrystal;
use protomer_hpmc::frenkel_ladd::{Estimate, FreeEnergy, Measurement, share};
use protomer_hpmc::symmetry::Symmetry;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::statistics::summarize;

const EQUILIBRATION: u64 = 500;
/// Sweeps of one measurement.
const SWEEPS: u64 = 20;

/// The free energy with so many measurements per point on average.
fn measure<const D: usize>(
    body: &HardBody<D>,
    crystal: &Crystal<D>,
    measurements: usize,
) -> FreeEnergy {
    let measurement = Measurement::new(body, crystal, 7).unwrap();
    let plan = measurement.plan().unwrap();
    let mut walkers = Vec::new();
    for (number, point) in plan.points.iter().enumerate() {
        let mut walker = measurement
            .start(number as u32, point.strength, plan.turning)
            .unwrap();
        walker.run(EQUILIBRATION, true);
        walkers.push(walker);
    }
    let mut series = vec![Vec::new(); walkers.len()];
    let round = 50 * walkers.len();
    for _ in 0..measurements / 50 {
        let measured: Vec<(u64, f64)> = series
            .iter()
            .map(|series: &Vec<f64>| (series.len() as u64, summarize(series).standard_error))
            .collect();
        let shares = match series[0].is_empty() {
            true => vec![50; walkers.len()],
            false => share(&plan, &measured, round),
        };
        for ((walker, series), share) in walkers.iter_mut().zip(&mut series).zip(shares) {
            series.extend((0..share).map(|_| walker.run(SWEEPS, false)));
        }
    }
    let extents = series.iter().map(|series| {
        let summary = summarize(series);
        Estimate {
            mean: summary.mean,
            error: summary.standard_error,
        }
    });
    measurement.free_energy(&plan, &extents.collect::<Vec<_>>())
}

/// Hard rods on a ring, A = -ln[(L/N) (L - N)^(N-1) / (N-1)!] (Tonks, Phys. Rev. 50, 955 (1936)).
#[test]
fn rods_on_a_ring_have_their_exact_free_energy() {
    let rod = HardBody::<1>::ball(0.5).unwrap();
    let row = UnitCell::by_name("row").unwrap();
    for (bodies, density) in [(8, 0.5), (32, 0.7)] {
        let crystal = Crystal::new(&row, &rod, bodies, density).unwrap();
        let found = measure(&rod, &crystal, 2600);
        let n = bodies as f64;
        let factorial: f64 = (1..bodies).map(|k| (k as f64).ln()).sum();
        let length = n / density;
        let exact = -((length / n).ln() + (n - 1.0) * (length - n).ln() - factorial) / n;
        let off = found.total_kt - exact;
        assert!(found.total_kt_error < 0.002, "{found:?}");
        assert!(off.abs() < 4.0 * found.total_kt_error, "{exact}: {found:?}");
    }
}

/// Spheres in an fcc crystal: the box of 125 primitive cells, with angles of 60 degrees, has the free energy of
/// cubic boxes. A/(N kT) + ln N/(2N) is linear in 1/N (Polson et al., J. Chem. Phys. 112, 5339 (2000)); the line
/// is that of cubic boxes of 108 to 500 in docs/validation/hard-shapes-free-energies.md.
#[test]
fn a_crystal_has_the_free_energy_of_its_cubic_box_in_a_rhombohedral_one() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let cell = UnitCell {
        space: PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3]).unwrap(),
        ..UnitCell::by_name("simple-cubic").unwrap()
    };
    let crystal = Crystal::new(&cell, &ball, 125, 1.15 * ball.volume).unwrap();
    assert!(!crystal.space.is_rectangular());
    let found = measure(&ball, &crystal, 150);
    let n = 125.0_f64;
    let expected = 6.2733 - 5.97 / n - n.ln() / (2.0 * n);
    assert!(found.total_kt_error < 0.005, "{found:?}");
    let off = found.total_kt - expected;
    assert!(
        off.abs() < 4.0 * found.total_kt_error,
        "{expected}: {found:?}"
    );
}

/// Ellipsoids with axes that hardly differ turn freely, and have the free energy of spheres whatever holds their orientations: an axis, or
/// three of them.
#[test]
fn ellipsoids_that_are_nearly_spheres_have_their_free_energy() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let cell = UnitCell::by_name("fcc").unwrap();
    let free_energy = |body: &HardBody<3>| {
        let crystal = Crystal::new(&cell, body, 32, 0.58).unwrap();
        measure(body, &crystal, 100)
    };
    let spheres = free_energy(&ball);
    for (half_axes, freedom) in [([0.5, 0.5, 0.50001], 2), ([0.49999, 0.5, 0.50001], 3)] {
        let body = HardBody::<3>::ellipsoid(half_axes).unwrap();
        let symmetry = Symmetry::find(&body).unwrap();
        assert_eq!(symmetry.degrees_of_freedom(), freedom);
        let found = free_energy(&body);
        let error = found.total_kt_error.hypot(spheres.total_kt_error);
        // One of two ends counted twice would be 0.69 off.
        assert!(error < 0.06, "{found:?}");
        let off = found.total_kt - spheres.total_kt;
        assert!(off.abs() < 4.0 * error, "{half_axes:?}: {off} {error}");
    }
}

/// Rows of cubes slide; on springs of no strength they still belong to their sites.
#[test]
fn rows_that_slide_do_not_pass_their_neighbours() {
    let cube = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    let cell = UnitCell::by_name("simple-cubic").unwrap();
    // So dilute that bodies would exchange places at once.
    let crystal = Crystal::new(&cell, &cube, 64, 0.1).unwrap();
    let measurement = Measurement::new(&cube, &crystal, 3).unwrap();
    let mut walker = measurement.start(0, 0.0, 1.0).unwrap();
    walker.run(2000, true);
    let edge = crystal.space.lengths()[0];
    let spacing = edge / 4.0;
    let (mut longest, displacements) = (0.0_f64, walker.springs().displacements());
    for (number, site) in crystal.positions.iter().enumerate() {
        for (other, place) in crystal.positions.iter().enumerate() {
            let apart = [0, 1, 2].map(|axis| {
                let along = (place[axis] - site[axis]) / edge;
                (along - along.round()).abs() * edge / spacing
            });
            let is_bond = (apart.iter().sum::<f64>() - 1.0).abs() < 1e-9;
            for axis in [0, 1, 2]
                .into_iter()
                .filter(|axis| is_bond && apart[*axis] < 0.5)
            {
                let slip = displacements[number][axis] - displacements[other][axis];
                longest = longest.max(slip.abs());
            }
        }
    }
    // The limit is reached and kept.
    assert!(
        (0.4..=0.5).contains(&(longest / spacing)),
        "{longest} {spacing}"
    );
}

/// For springs alone, the derivative of the free energy is the extent, and both are exact.
#[test]
fn bodies_on_strong_springs_have_the_extent_of_an_einstein_crystal() {
    let cube = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    let cell = UnitCell::by_name("simple-cubic").unwrap();
    let crystal = Crystal::new(&cell, &cube, 64, 0.3).unwrap();
    let measurement = Measurement::new(&cube, &crystal, 3).unwrap();
    let (strength, turning) = (2000.0, 0.5);
    let mut walker = measurement.start(0, strength, turning).unwrap();
    walker.run(EQUILIBRATION, true);
    let series: Vec<f64> = (0..4000).map(|_| walker.run(5, false)).collect();
    let found = summarize(&series);
    let symmetry = Symmetry::find(&cube).unwrap();
    let free_energy = |strength: f64| {
        let einstein = EinsteinCrystal {
            crystal: &crystal,
            symmetry: &symmetry,
            strength,
            turning,
        };
        einstein.terms().total_kt()
    };
    let exact = (free_energy(strength + 1.0) - free_energy(strength - 1.0)) / 2.0;
    assert!(found.standard_error < 0.003 * exact, "{found:?}");
    let off = (found.mean - exact).abs();
    assert!(off < 4.0 * found.standard_error, "{exact}: {found:?}");
}

/// The formula of a molecule fixed at its site differs from that of a drifting crystal by N^(D/2), because
/// its springs pull at one body: both are the same integral over relative places.
#[test]
fn the_einstein_crystal_has_the_terms_of_the_reference() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let cell = UnitCell::by_name("fcc").unwrap();
    let symmetry = Symmetry::find(&ball).unwrap();
    for (bodies, strength, density, molecule) in [
        (32, 1000.0, 1.1, 8.377_374_717_514_893),
        (256, 5000.0, 1.0, 11.015_496_931_169_201),
    ] {
        let crystal = Crystal::new(&cell, &ball, bodies, density * ball.volume).unwrap();
        let einstein = EinsteinCrystal {
            crystal: &crystal,
            symmetry: &symmetry,
            strength,
            turning: 1.0,
        };
        let n = bodies as f64;
        let found = einstein.terms().total_kt() + 1.5 * n.ln() / n;
        assert!((found - molecule).abs() < 1e-12, "{found}");
    }
}
