//! Overlaps of swept bodies against closed forms, a grid, and numbers of an independent program.

use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::shape::swept::Swept;
use protomer_kernel::{Pose, Rotation, Vec3};
use std::f64::consts::PI;

fn placed(x: f64, y: f64, z: f64) -> Pose {
    turned([x, y, z], [1.0, 0.0, 0.0, 0.0])
}

fn turned(position: [f64; 3], wxyz: [f64; 4]) -> Pose {
    Pose::from_wxyz(position.into(), wxyz)
}

fn point() -> Shape {
    Shape::solid(&[Vec3::zeros()]).unwrap()
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs();
    assert!(off < tolerance, "{found} instead of {expected}");
}

/// Of two balls: π (R₁ + R₂ - d)² (d² + 2d(R₁ + R₂) - 3(R₁ - R₂)²) / 12d.
#[test]
fn balls_share_a_lens() {
    for (radii, apart, expected) in [
        ([0.6, 0.6], 1.05, 0.02032217747790895),
        ([1.0, 1.0], 1.3, 0.679893010114391),
        ([0.6, 0.35], 0.8, 0.014523730099701234),
        ([1.3, 0.8], 1.7, 0.2286586652965749),
        // One within the other, and with one centre.
        ([1.0, 0.2], 0.5, 4.0 / 3.0 * PI * 0.008),
        ([1.0, 0.2], 0.0, 4.0 / 3.0 * PI * 0.008),
        ([0.5, 0.5], 1.01, 0.0),
    ] {
        let first = Swept::new(&point(), radii[0], &placed(0.0, 0.0, 0.0)).unwrap();
        let second =
            Swept::new(&point(), radii[1], &placed(0.0, 0.6 * apart, 0.8 * apart)).unwrap();
        assert_near(first.overlap(&second), expected, 1e-9);
        assert_near(second.overlap(&first), expected, 1e-9);
    }
}

/// A body within another shares all of itself: the formulas of Steiner.
#[test]
fn a_body_within_another_is_shared_wholly() {
    for (name, radius) in [
        ("tetrahedron", 0.1),
        ("prism:3,0.2", 0.0),
        ("polygon:5", 0.15),
    ] {
        let shape = by_name(name).unwrap();
        let volume = Measures::from_shape(&shape, radius).unwrap().volume;
        let small = Swept::new(&shape, radius, &placed(0.1, -0.2, 0.0)).unwrap();
        let large = Swept::new(&point_like(&shape), 5.0, &placed(0.0, 0.0, 0.0)).unwrap();
        assert_near(small.overlap(&large), volume, 1e-6 * volume);
    }
}

/// A point in the space of a shape.
fn point_like(shape: &Shape) -> Shape {
    match shape.dimension() {
        2 => Shape::flat(&[[0.0, 0.0]]).unwrap(),
        _ => point(),
    }
}

/// Bodies that overlap, without sweeping.
#[test]
fn cuboids_share_a_cuboid() {
    let cube = by_name("cube").unwrap();
    let first = Swept::new(&cube, 0.0, &placed(0.0, 0.0, 0.0)).unwrap();
    let second = Swept::new(&cube, 0.0, &placed(0.6, -0.3, 0.2)).unwrap();
    assert_near(first.overlap(&second), 0.4 * 0.7 * 0.8, 1e-8);
    let square = by_name("polygon:4").unwrap();
    let half_turn = Rotation::from_scaled_axis(PI / 4.0 * Vec3::z());
    let straight = |x: f64, y: f64| Pose {
        position: Vec3::new(x, y, 0.0),
        rotation: half_turn,
    };
    let first = Swept::new(&square, 0.0, &straight(0.0, 0.0)).unwrap();
    let second = Swept::new(&square, 0.0, &straight(0.5, 0.25)).unwrap();
    assert_near(first.overlap(&second), 0.375, 1e-8);
}

/// Two squares with disks between them, side by side: a strip, and caps at both ends that are two
/// halves of a lens.
#[test]
fn squares_share_a_strip() {
    let square = by_name("polygon:4").unwrap();
    let straight = |x: f64| Pose {
        position: Vec3::new(x, 0.0, 0.0),
        rotation: Rotation::from_scaled_axis(PI / 4.0 * Vec3::z()),
    };
    let (radius, gap) = (0.2_f64, 0.1_f64);
    let first = Swept::new(&square, radius, &straight(0.0)).unwrap();
    let second = Swept::new(&square, radius, &straight(1.0 + gap)).unwrap();
    let lens = 2.0 * radius * radius * (0.5 * gap / radius).acos()
        - 0.5 * gap * (4.0 * radius * radius - gap * gap).sqrt();
    assert_near(first.overlap(&second), (2.0 * radius - gap) + lens, 1e-8);
}

/// What is inside is what the closest points say, and the ends of intervals are at the radius.
#[test]
fn intervals_are_those_of_the_distance() {
    let mut rng = CounterRng::new(4, 0, 0);
    let flat = Shape::solid(&[Vec3::zeros(), Vec3::x(), Vec3::new(0.3, 1.0, 0.0)]).unwrap();
    let named = ["octahedron", "truncated-tetrahedron:0.6667"].map(|name| by_name(name).unwrap());
    for shape in named.into_iter().chain([flat]) {
        let corners = match &shape {
            Shape::Solid(hull) => hull.corners(),
            Shape::Flat(_) => unreachable!(),
        };
        let mean = corners.iter().sum::<Vec3>() / corners.len() as f64;
        let pose = Pose {
            position: Vec3::zeros(),
            rotation: rng.rotation(),
        };
        let places: Vec<Vec3> = corners.iter().map(|x| pose.rotation * (x - mean)).collect();
        let distance =
            |point: &Vec3| closest_points(&places, &[*point]).map_or(0.0, |p| p.distance());
        let swept = Swept::new(&shape, 0.25, &pose).unwrap();
        let mut met = 0;
        for _ in 0..500 {
            let (origin, direction) = (rng.vector_in_ball(1.0), rng.unit_vector());
            assert_eq!(swept.holds(&origin), distance(&origin) <= 0.25);
            if let Some(ends) = swept.interval(&origin, &direction) {
                for end in ends {
                    assert_near(distance(&(origin + end * direction)), 0.25, 1e-9);
                }
                met += 1;
            }
        }
        assert!(met > 100, "{met}");
    }
}

/// The slow twin: a grid of points, whose axes have nothing to do with the faces.
#[test]
fn an_overlap_is_what_a_grid_of_points_finds() {
    let shape = by_name("truncated-tetrahedron:0.6667").unwrap();
    let first = Swept::new(&shape, 0.2, &placed(0.0, 0.0, 0.0)).unwrap();
    let second = turned([0.3, 0.65, -0.2], [0.7, 0.2, -0.4, 0.5]);
    let second = Swept::new(&shape, 0.2, &second).unwrap();
    // A box around what is shared.
    let (lower, edges) = (Vec3::new(-0.2, 0.05, -0.4), Vec3::new(0.7, 0.55, 0.7));
    let (count, mut inside) = (50_usize, 0);
    for cell in 0..count.pow(3) {
        let place = [cell % count, cell / count % count, cell / count / count];
        let part = Vec3::from(place.map(|number| (number as f64 + 0.5) / count as f64));
        let point = lower + part.component_mul(&edges);
        inside += usize::from(first.holds(&point) && second.holds(&point));
    }
    let found = inside as f64 * edges.product() / count.pow(3) as f64;
    let overlap = first.overlap(&second);
    assert_near(overlap, found, 0.005 * overlap);
}

/// Poses of the reference for the volumes that depletants find between polyhedra.
#[test]
fn overlaps_are_those_of_the_reference() {
    let cube = by_name("cube").unwrap();
    let unit = [1.0, 0.0, 0.0, 0.0];
    for (position, orientations, radius, expected) in [
        ([1.05, 0.0, 0.0], [unit, unit], 0.1, 0.19569289054),
        ([1.05, 0.4, 0.2], [unit, unit], 0.1, 0.111965895367),
        (
            [1.339279084, -0.267855817, 0.669639542],
            [
                [0.017995, 0.715613, 0.644551, -0.268566],
                [-0.35751, -0.632767, 0.68357, -0.067267],
            ],
            0.259807621,
            0.205416713674,
        ),
    ] {
        let bodies = [
            Swept::new(&cube, radius, &turned([0.0; 3], orientations[0])).unwrap(),
            Swept::new(&cube, radius, &turned(position, orientations[1])).unwrap(),
        ];
        assert_near(bodies[0].overlap(&bodies[1]), expected, 2e-7);
    }
}
