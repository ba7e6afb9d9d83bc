//! Boxes that change their shape, against exact results; short runs.

use crate::common::{logarithm, pressed};
use protomer_hpmc::Error;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::box_moves::Freedom;
use protomer_hpmc::crystal::{Crystal, UnitCell};
use protomer_hpmc::simulation::{Settings, Simulation};
use protomer_hpmc::start::Start;
use protomer_kernel::Vec3;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::Shape;
use protomer_kernel::statistics::{Summary, summarize};

/// The boxes after every fifth sweep.
fn boxes<const D: usize>(
    settings: &Settings,
    body: &HardBody<D>,
    start: &Start<D>,
    count: usize,
) -> Vec<PeriodicBox<D>> {
    let mut simulation = Simulation::new(settings, body, &[], start).unwrap();
    simulation.run(settings.equilibration_sweeps).unwrap();
    let mut boxes = Vec::new();
    for _ in 0..count {
        simulation.run(5).unwrap();
        boxes.push(*simulation.system().space());
    }
    assert_eq!(simulation.system().overlaps(), 0);
    boxes
}

fn mean<const D: usize>(boxes: &[PeriodicBox<D>], of: impl Fn(&PeriodicBox<D>) -> f64) -> Summary {
    summarize(&boxes.iter().map(of).collect::<Vec<f64>>())
}

fn assert_mean(found: &Summary, exact: f64, precision: f64, what: &str) {
    assert!(found.standard_error < precision, "{what}: {found:?}");
    let off = (found.mean - exact).abs();
    assert!(
        off < 4.0 * found.standard_error,
        "{what}: {exact}, {found:?}"
    );
}

/// The volume of an ideal gas has the density V^N exp(-βPV): its mean is (N + 1)/βP, its variance (N + 1)/(βP)²,
/// its third cumulant 2 (N + 1)/(βP)³.
fn assert_volumes<const D: usize>(boxes: &[PeriodicBox<D>], bodies: f64, pressure: f64) {
    let exact = (bodies + 1.0) / pressure;
    let off = |space: &PeriodicBox<D>| space.volume() - exact;
    let precision = 0.01 * exact;
    assert_mean(
        &mean(boxes, |space| space.volume()),
        exact,
        precision,
        "volume",
    );
    let variance = exact / pressure;
    assert_mean(
        &mean(boxes, |space| off(space).powi(2)),
        variance,
        0.05 * variance,
        "variance",
    );
    let third = 2.0 * variance / pressure;
    assert_mean(
        &mean(boxes, |space| off(space).powi(3)),
        third,
        0.4 * third,
        "third cumulant",
    );
}

/// Means of f over the shapes of an ideal gas in space. The tilt factors are uniform, and a lattice of images
/// repeats after Lx/Ly in xy, Lx/Lz in xz, Ly/Lz in yz, so lengths at a volume of one have the density
/// (Lx/Lz)² in their logarithms, each within ± ln 2.
fn mean_over_shapes(of: impl Fn([f64; 3]) -> f64) -> f64 {
    let (bound, parts) = (2.0_f64.ln(), 800);
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in 0..parts {
        for j in 0..parts {
            let place = |k: i32| bound * (2.0 * (f64::from(k) + 0.5) / f64::from(parts) - 1.0);
            let (x, y) = (place(i), place(j));
            let z = -x - y;
            if z.abs() < bound {
                let weight = (2.0 * (x - z)).exp();
                weights += weight;
                sum += weight * of([x, y, z]);
            }
        }
    }
    sum / weights
}

#[test]
fn an_ideal_gas_has_its_volumes_and_shapes_in_space() {
    let point = HardBody::<3>::ball(1e-4).unwrap();
    let start = Start::fluid(12, 12.0 * point.volume / 8.0);
    let boxes = boxes(&pressed(1.3, Freedom::Shape), &point, &start, 8000);
    assert_volumes(&boxes, 12.0, 1.3);
    for axis in 0..3 {
        let found = mean(&boxes, |space| logarithm(space, axis));
        assert_mean(
            &found,
            mean_over_shapes(|lengths| lengths[axis]),
            0.01,
            "length",
        );
        let found = mean(&boxes, |space| logarithm(space, axis).powi(2));
        let exact = mean_over_shapes(|lengths| lengths[axis].powi(2));
        assert_mean(&found, exact, 0.01, "squared length");
    }
    // No overhang is likelier than another.
    for (row, column) in [(0, 1), (1, 2)] {
        let overhang = |space: &PeriodicBox<3>| space.edge(column)[row] / space.lengths()[row];
        let found = mean(&boxes, |space| {
            (std::f64::consts::TAU * overhang(space)).cos()
        });
        assert_mean(&found, 0.0, 0.03, "overhang");
    }
}

/// In a plane the density of u = ln Lx at a volume of one is exp(2u): its mean is a coth(2a) - 1/2 within ± a.
#[test]
fn an_ideal_gas_has_its_areas_and_shapes_in_a_plane() {
    let point = HardBody::<2>::ball(1e-4).unwrap();
    let start = Start::fluid(12, 12.0 * point.volume / 8.0);
    let boxes = boxes(&pressed(1.3, Freedom::Shape), &point, &start, 8000);
    assert_volumes(&boxes, 12.0, 1.3);
    let bound = 2.0_f64.ln();
    let exact = bound / (2.0 * bound).tanh() - 0.5;
    assert_mean(
        &mean(&boxes, |space| logarithm(space, 0)),
        exact,
        0.01,
        "length",
    );
}

/// A fluid bears every shape alike: its packing fraction at a pressure is that in a cube.
#[test]
fn a_fluid_has_the_density_of_a_cube_in_a_box_of_any_shape() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    // Carnahan and Starling at 0.3.
    let pressure = 3.973_761 * 0.3 / ball.volume;
    let packing = |freedom: Freedom| {
        let start = Start::fluid(125, 0.3);
        let boxes = boxes(&pressed(pressure, freedom), &ball, &start, 3000);
        mean(&boxes, |space| 125.0 * ball.volume / space.volume())
    };
    let (cube, any) = (packing(Freedom::Volume), packing(Freedom::Shape));
    let error = cube.standard_error.hypot(any.standard_error);
    assert!(error < 0.003, "{cube:?} {any:?}");
    assert!(
        (cube.mean - any.mean).abs() < 4.0 * error,
        "{cube:?} {any:?}"
    );
    assert!((any.mean - 0.3).abs() < 4.0 * any.standard_error, "{any:?}");
}

/// A crystal of balls that begins sheared and stretched becomes cubic.
#[test]
fn a_sheared_crystal_becomes_cubic() {
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let cell = UnitCell {
        space: PeriodicBox::new([1.0, 1.05, 0.95], &[0.08, -0.05, 0.06]).unwrap(),
        ..UnitCell::by_name("fcc").unwrap()
    };
    let crystal = Crystal::new(&cell, &ball, 108, 0.54).unwrap();
    let begun = crystal.space;
    let start = Start::Crystal(crystal);
    let boxes = boxes(&pressed(25.0, Freedom::Shape), &ball, &start, 2000);
    for number in 0..3 {
        let tilt = |space: &PeriodicBox<3>| space.tilt_factors()[number];
        assert!(tilt(&begun).abs() > 0.04 && logarithm(&begun, 1) > 0.04);
        assert_mean(&mean(&boxes, tilt), 0.0, 0.003, "tilt");
        assert_mean(
            &mean(&boxes, |space| logarithm(space, number)),
            0.0,
            0.004,
            "length",
        );
    }
}

/// A square crystal of disks becomes a hexagonal one, which is denser than any square one.
#[test]
fn a_square_crystal_of_disks_becomes_hexagonal() {
    let disk = HardBody::<2>::ball(0.5).unwrap();
    let crystal = Crystal::new(&UnitCell::by_name("square").unwrap(), &disk, 64, 0.75).unwrap();
    let start = Start::Crystal(crystal);
    let boxes = boxes(&pressed(30.0, Freedom::Shape), &disk, &start, 500);
    let packing = mean(&boxes, |space| 64.0 * disk.volume / space.volume());
    let square = std::f64::consts::FRAC_PI_4;
    assert!(packing.mean > square + 0.03, "{packing:?}");
}

/// A box twice as wide as bodies reach holds 64 dipyramids at a packing fraction of 0.4115: a run that refused smaller
/// ones found that at every pressure. Here the bodies bear the pressure that is imposed.
#[test]
fn bodies_bear_the_pressure_in_a_box_where_they_meet_several_images() {
    let corners = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.8],
        [0.0, 0.0, -1.8],
    ];
    let shape = Shape::solid(&corners.map(Vec3::from)).unwrap();
    let body = HardBody::<3>::new(&shape, 0.0).unwrap();
    // As dense as 64 of them at 0.49, and with a shorter edge.
    let (bodies, pressure) = (24, 3.0);
    let mut settings = pressed(pressure, Freedom::Volume);
    settings.equilibration_sweeps = 1500;
    let start = Start::fluid(bodies, 0.35);
    let mut simulation = Simulation::new(&settings, &body, &[], &start).unwrap();
    simulation.run(settings.equilibration_sweeps).unwrap();
    let (mut pressures, mut edges) = (Vec::new(), Vec::new());
    for _ in 0..1500 {
        simulation.run(4).unwrap();
        let sample = simulation.sample();
        let density = sample.packing_fraction / body.volume;
        pressures.push(sample.compressibility_factor * density);
        edges.push(simulation.system().space().smallest_length());
    }
    let reach = 2.0 * body.outer_radius;
    assert!(summarize(&edges).mean < 1.6 * reach, "{reach}");
    assert_eq!(simulation.system().overlaps(), 0);
    assert_mean(&summarize(&pressures), pressure, 0.15, "pressure");
}

/// Rods in a plane under a pressure at which the box would become shorter than a rod.
#[test]
fn a_box_that_becomes_too_small_asks_for_a_number_of_bodies_that_works() {
    let corners = [[-2.0, -0.1], [2.0, -0.1], [2.0, 0.1], [-2.0, 0.1]];
    let rod = HardBody::<2>::new(&Shape::flat(&corners).unwrap(), 0.05).unwrap();
    for freedom in [Freedom::Volume, Freedom::Lengths] {
        let settings = pressed(40.0, freedom);
        let run = |bodies: usize| {
            let start = Start::fluid(bodies, 0.2);
            let mut simulation = Simulation::new(&settings, &rod, &[], &start)?;
            simulation.run(3000)
        };
        let Err(Error::BoxShrinks { bodies, .. }) = run(6) else {
            unreachable!("{freedom:?}: the box should become too small")
        };
        assert_eq!(run(bodies), Ok(()), "{freedom:?}: {bodies} bodies");
    }
}

/// More changes of the box in a sweep bring it to its pressure in fewer sweeps; the same mean follows.
#[test]
fn the_number_of_changes_of_the_box_can_be_chosen() {
    let point = HardBody::<3>::ball(1e-4).unwrap();
    let start = Start::fluid(12, 12.0 * point.volume / 8.0);
    for changes in [1, 3, 20] {
        let mut settings = pressed(1.3, Freedom::Shape);
        if let Some(pressure) = &mut settings.pressure {
            pressure.changes_per_sweep = Some(changes);
        }
        let boxes = boxes(&settings, &point, &start, 2500);
        let volume = mean(&boxes, |space| space.volume());
        assert_mean(&volume, 13.0 / 1.3, 0.5, "volume");
        let squared = mean(&boxes, |space| logarithm(space, 0).powi(2));
        let exact = mean_over_shapes(|lengths| lengths[0].powi(2));
        assert_mean(&squared, exact, 0.02, "squared length");
    }
}
