//! Bodies of several convex pieces, against a convex body that is cut, and against exact results.

use protomer_hpmc::Error;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::compression::Compression;
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::simulation::{Settings, Simulation};
use protomer_hpmc::start::Start;
use protomer_hpmc::symmetry::Symmetry;
use protomer_hpmc::system::System;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::shape::{Shape, builders::by_name};
use protomer_kernel::statistics::{Summary, summarize};
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::TAU;

fn cuboid(from: [f64; 3], to: [f64; 3]) -> Shape {
    let corner = |number: usize| Vec3::from_fn(|axis, _| [from, to][number >> axis & 1][axis]);
    Shape::solid(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
}

fn rectangle(from: [f64; 2], to: [f64; 2]) -> Shape {
    Shape::flat(&[from, [to[0], from[1]], to, [from[0], to[1]]]).unwrap()
}

/// The unit cube in three pieces.
fn cut_cube() -> HardBody<3> {
    let pieces = [
        cuboid([0.0; 3], [0.4, 1.0, 1.0]),
        cuboid([0.4, 0.0, 0.0], [1.0, 0.5, 1.0]),
        cuboid([0.4, 0.5, 0.0], [1.0, 1.0, 1.0]),
    ];
    HardBody::of_pieces(&pieces, 0.0).unwrap()
}

/// A horseshoe whose arms fit between those of another.
fn horseshoe() -> HardBody<2> {
    let pieces = [
        rectangle([0.0, 0.0], [1.2, 0.1]),
        rectangle([0.0, 0.1], [0.1, 1.7]),
        rectangle([1.1, 0.1], [1.2, 1.7]),
    ];
    HardBody::of_pieces(&pieces, 0.0).unwrap()
}

/// A state of a dense fluid of cubes, with cubes and with cut cubes in the same places.
fn both(packing: f64) -> [System<3>; 2] {
    let whole = HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap();
    let settings = Settings::default();
    let mut simulation =
        Simulation::new(&settings, &whole, &[], &Start::fluid(125, packing)).unwrap();
    simulation.run(200).unwrap();
    let system = simulation.system();
    [whole, cut_cube()].map(|body| {
        let (places, turns) = (system.positions().to_vec(), system.rotations().to_vec());
        System::new(body, Vec::new(), *system.space(), places, turns).unwrap()
    })
}

#[test]
fn a_cut_cube_is_a_cube() {
    let [whole, cut] = both(0.4);
    assert!((cut.body().volume - 1.0).abs() < 1e-12);
    assert!((cut.body().outer_radius - 0.75_f64.sqrt()).abs() < 1e-12);
    assert_eq!((whole.overlaps(), cut.overlaps()), (0, 0));
    // It looks as a cube does however it is turned: what counts for the free energy is the body and not the cut.
    assert_eq!(Symmetry::find(cut.body()).unwrap().rotations().len(), 24);
    // The same pairs meet in the same bins, but for rounding at their edges.
    let compression = Compression::new(&whole, 8.0);
    let [of_whole, of_cut] = [&whole, &cut].map(|system| compression.factor(system));
    assert!(of_whole > 4.0, "{of_whole}");
    assert!(
        (of_whole - of_cut).abs() < 2e-3 * of_whole,
        "{of_whole}, {of_cut}"
    );
    let mut rng = [0, 1].map(|_| CounterRng::for_purpose(1, 0, 0, Purpose::HardBodyStart));
    for radius in [0.01, 0.1, 0.4] {
        let [first, second] = [&whole, &cut]
            .into_iter()
            .zip(&mut rng)
            .map(|(system, rng)| system.free_volume(radius, 20_000, rng))
            .collect::<Vec<_>>()[..]
        else {
            unreachable!()
        };
        assert_eq!(first, second, "{radius}");
    }
}

/// The same random poses, many of them near contact, overlap.
#[test]
fn a_cut_cube_overlaps_what_a_cube_does() {
    let [whole, cut] = [
        HardBody::<3>::new(&by_name("cube").unwrap(), 0.0).unwrap(),
        cut_cube(),
    ];
    let mut rng = CounterRng::for_purpose(2, 0, 0, Purpose::HardBodyStart);
    let space = PeriodicBox::rectangular([10.0; 3]).unwrap();
    let mut overlapping = 0;
    for _ in 0..20_000 {
        let places = vec![
            [5.0; 3],
            std::array::from_fn(|_| 5.0 + rng.uniform_in(-1.2, 1.2)),
        ];
        let turns = vec![rng.rotation(), rng.rotation()];
        let [first, second] = [&whole, &cut].map(|body| {
            System::new(
                body.clone(),
                Vec::new(),
                space,
                places.clone(),
                turns.clone(),
            )
            .unwrap()
            .overlaps()
        });
        assert_eq!(first, second);
        overlapping += first;
    }
    assert!((4_000..16_000).contains(&overlapping), "{overlapping}");
}

fn mean_factor<const D: usize>(
    settings: &Settings,
    body: &HardBody<D>,
    bodies: usize,
    packing: f64,
    samples: usize,
) -> Summary {
    let mut simulation =
        Simulation::new(settings, body, &[], &Start::fluid(bodies, packing)).unwrap();
    simulation.run(400).unwrap();
    let mut factors = Vec::new();
    for _ in 0..samples {
        simulation.run(4).unwrap();
        factors.push(simulation.sample().compressibility_factor);
    }
    assert_eq!(simulation.system().overlaps(), 0);
    summarize(&factors)
}

/// Tangent hard dumbbells at a packing fraction of 0.2: the equation of state of D. J. Tildesley and W. B. Streett,
/// Mol. Phys. 41, 85 (1980), with l = 1, which describes their simulations to 1 %.
#[test]
fn dumbbells_have_their_equation_of_state() {
    let ball = |x: f64| Shape::solid(&[Vec3::new(x, 0.0, 0.0)]).unwrap();
    let dumbbell = HardBody::<3>::of_pieces(&[ball(-0.5), ball(0.5)], 0.5).unwrap();
    let y: f64 = 0.2;
    let (f1, f2, f3) = (
        1.0 + 0.37836 + 1.07860,
        1.0 + 1.30376 + 1.80010,
        2.39803 + 0.35700,
    );
    let expected = (1.0 + f1 * y + f2 * y * y - f3 * y.powi(3)) / (1.0 - y).powi(3);
    let found = mean_factor(&Settings::default(), &dumbbell, 108, y, 1500);
    assert!(found.standard_error < 0.01 * expected, "{found:?}");
    assert!(
        (found.mean - expected).abs() < 4.0 * found.standard_error + 0.01 * expected,
        "{found:?} instead of {expected}"
    );
    assert_eq!(Symmetry::find(&dumbbell), Err(Error::Axis));
}

/// Two bodies in a box of area A that cover an area E for each other have the compressibility factor
/// 1 + E/A / (1 - E/A) / 2: the configurations without overlap are A² (1 - E/A). Horseshoes hook into each other,
/// so a part of the contacts is made by expansions, and counts against those by contractions.
#[test]
fn two_horseshoes_have_the_pressure_of_their_covered_area() {
    let body = horseshoe();
    assert!((body.volume - 0.44).abs() < 1e-12);
    let space = PeriodicBox::rectangular([6.0; 2]).unwrap();
    let mut rng = CounterRng::for_purpose(3, 0, 0, Purpose::HardBodyStart);
    let (mut factors, mut overlapping) = (Vec::new(), Vec::new());
    let mut compression = None;
    for _ in 0..400_000 {
        let places = vec![[0.0; 2], space.point(&[rng.uniform(), rng.uniform()])];
        let turns = vec![
            Rotation::identity(),
            Rotation::from_scaled_axis(TAU * rng.uniform() * Vec3::z()),
        ];
        let system = System::new(body.clone(), Vec::new(), space, places, turns).unwrap();
        let is_overlap = system.overlaps() > 0;
        overlapping.push(f64::from(u8::from(is_overlap)));
        if !is_overlap {
            let compression = compression.get_or_insert_with(|| Compression::new(&system, 1.0));
            factors.push(compression.factor(&system));
        }
    }
    let (covered, found) = (summarize(&overlapping), summarize(&factors));
    let expected = 1.0 + 0.5 * covered.mean / (1.0 - covered.mean);
    assert!(found.standard_error < 0.05 * (expected - 1.0), "{found:?}");
    assert!(
        (found.mean - expected).abs() < 4.0 * found.standard_error,
        "{found:?} instead of {expected}"
    );
}

#[test]
fn depletants_and_walls_see_all_pieces() {
    let body = horseshoe();
    let kinds = [Depletant {
        radius: 0.1,
        fugacity: 0.5,
    }];
    let settings = Settings {
        points: 500,
        ..Settings::default()
    };
    let mut simulation = Simulation::new(&settings, &body, &kinds, &Start::fluid(30, 0.1)).unwrap();
    simulation.run(300).unwrap();
    assert_eq!(simulation.system().overlaps(), 0);
    let walls = Start::Fluid {
        bodies: 30,
        packing_fraction: 0.1,
        edge_ratios: [1.0; 2],
        has_walls: true,
    };
    let mut simulation = Simulation::new(&Settings::default(), &body, &[], &walls).unwrap();
    simulation.run(300).unwrap();
    let system = simulation.system();
    assert_eq!(system.overlaps(), 0);
    // By the corners themselves.
    for (place, turn) in system.positions().iter().zip(system.rotations()) {
        for corner in &body.corners {
            let height = place[1] + (turn * Vec3::new(corner[0], corner[1], 0.0)).y;
            assert!((-1e-9..=system.space().lengths()[1] + 1e-9).contains(&height));
        }
    }
    assert_eq!(Symmetry::find(&body).unwrap().rotations().len(), 1);
}

#[test]
fn pieces_that_overlap_are_named() {
    let pieces = [
        cuboid([0.0; 3], [1.0; 3]),
        cuboid([3.0; 3], [4.0; 3]),
        cuboid([0.5; 3], [1.5; 3]),
    ];
    let error = HardBody::<3>::of_pieces(&pieces, 0.0).unwrap_err();
    assert!(error.to_string().contains("pieces 1 and 3"), "{error}");
    // Rounding makes pieces overlap that only touched.
    let touching = [
        rectangle([0.0; 2], [1.0; 2]),
        rectangle([1.0, 0.0], [2.0, 1.0]),
    ];
    assert!(HardBody::<2>::of_pieces(&touching, 0.0).is_ok());
    assert!(HardBody::<2>::of_pieces(&touching, 0.1).is_err());
    assert!(HardBody::<3>::of_pieces(&touching, 0.0).is_err());
}
