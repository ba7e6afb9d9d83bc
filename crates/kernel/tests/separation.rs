//! The fast test of overlap against all separating axes, and against the closest points.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::closest::closest_points;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::separation::{Pair, overlap_on_all_axes, pack};
use protomer_kernel::{Rotation, Vec3};

fn turned(vectors: &[Vec3], rotation: &Rotation) -> Vec<[f64; 3]> {
    let turn = |vector: &Vec3| (rotation * vector).into();
    vectors.iter().map(turn).collect()
}

/// Corners, normals and edges of a body.
struct Parts(Vec<Vec3>, Vec<Vec3>, Vec<Vec3>);

fn parts(name: &str) -> Parts {
    let body = Polytope::of(&by_name(name).unwrap()).unwrap();
    let edge = |[from, to]: &[usize; 2]| body.corners[*to] - body.corners[*from];
    Parts(
        body.corners.clone(),
        body.faces.iter().map(|face| face.normal).collect(),
        body.edges.iter().map(edge).collect(),
    )
}

/// Compares decisions at these distances from contact along a random line; distances of zero are
/// random poses.
fn compare(names: [&str; 2], gaps: &[f64], poses: u64) -> usize {
    let bodies = names.map(parts);
    let mut undecided = 0;
    for number in 0..poses {
        let mut rng = CounterRng::new(11, 0, number);
        let rotations = [rng.rotation(), rng.rotation()];
        // Half of the poses have parallel faces.
        let rotations = match number % 2 {
            0 => rotations,
            _ => [rotations[0], rotations[0]],
        };
        let corners = [0, 1].map(|n: usize| turned(&bodies[n].0, &rotations[n]));
        let normals = [0, 1].map(|n: usize| turned(&bodies[n].1, &rotations[n]));
        let edges = [0, 1].map(|n: usize| turned(&bodies[n].2, &rotations[n]));
        let packed = [pack(&corners[0]), pack(&corners[1])];
        let line = rng.unit_vector();
        let at = |distance: f64| Pair {
            first: &packed[0],
            second: &packed[1],
            offset: (line * distance).into(),
            reach: 0.0,
        };
        let exact = |pair: &Pair<'_, 3>| {
            overlap_on_all_axes(pair, [&normals[0], &normals[1]], [&edges[0], &edges[1]])
        };
        let (mut inside, mut outside) = (0.0, 10.0);
        while outside - inside > 4e-16 * outside {
            let middle = f64::midpoint(inside, outside);
            if middle == inside || middle == outside {
                break;
            }
            if exact(&at(middle)) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        for gap in gaps {
            for distance in [outside + gap, outside - gap] {
                let pair = at(distance);
                let expected = exact(&pair);
                let mut asked = 0;
                for start in [pair.offset, rng.unit_vector().into()] {
                    let mut direction = start;
                    let found = pair.overlap(&mut direction, || {
                        asked += 1;
                        expected
                    });
                    assert_eq!(found, expected, "{names:?} {number} {distance} {gap}");
                    assert!(found || asked > 0 || pair.is_separated_along(&direction));
                }
                undecided += asked;
            }
        }
    }
    undecided
}

#[test]
fn decisions_are_those_of_all_axes() {
    for names in [
        ["cube", "cube"],
        ["tetrahedron", "octahedron"],
        ["truncated-tetrahedron:0.5", "truncated-tetrahedron:0.5"],
        ["dodecahedron", "prism:3,0.2"],
    ] {
        let far = compare(names, &[0.3, 0.1, 1e-2, 1e-4], 1500);
        // Rarely the origin lies on the surface of a simplex inside of the difference.
        assert!(
            far < 10,
            "{names:?} asked {far} times for the last word far from contact"
        );
        compare(names, &[1e-6, 1e-8, 1e-10, 1e-13], 500);
    }
}

#[test]
fn rounded_bodies_overlap_where_the_distance_of_their_cores_says_so() {
    let Parts(corners, ..) = parts("truncated-tetrahedron:0.5");
    let mut apart = 0;
    for number in 0..4000 {
        let mut rng = CounterRng::new(12, 0, number);
        let (first, second) = (rng.rotation(), rng.rotation());
        let offset = rng.unit_vector() * rng.uniform_in(0.3, 1.4);
        let (first, second) = (turned(&corners, &first), turned(&corners, &second));
        let places = |corners: &[[f64; 3]], shift: Vec3| -> Vec<Vec3> {
            corners.iter().map(|x| Vec3::from(*x) + shift).collect()
        };
        let found = closest_points(&places(&first, Vec3::zeros()), &places(&second, offset));
        let distance = found.map_or(0.0, |points| points.distance());
        let reach = rng.uniform_in(1e-3, 0.4);
        let pair = Pair {
            first: &pack(&first),
            second: &pack(&second),
            offset: offset.into(),
            reach,
        };
        let overlap = pair.overlap(&mut { pair.offset }, || true);
        assert_eq!(overlap, distance < reach, "{number}: {distance} {reach}");
        apart += usize::from(!overlap);
        if distance > 0.0 {
            for (reach, expected) in [(distance * 0.999_999, false), (distance * 1.000_001, true)] {
                let pair = Pair { reach, ..pair };
                assert_eq!(pair.overlap(&mut { pair.offset }, || true), expected);
            }
        }
    }
    assert!((500..3500).contains(&apart), "{apart}");
}

#[test]
fn polygons_are_decided_in_the_plane() {
    let body = Polytope::of(&by_name("polygon:5").unwrap()).unwrap();
    let flat = |vectors: &[Vec3], angle: f64| -> Vec<[f64; 2]> {
        let turn = Rotation::from_scaled_axis(angle * Vec3::z());
        let turned = vectors.iter().map(|vector| turn * vector);
        turned.map(|vector| [vector.x, vector.y]).collect()
    };
    let normals: Vec<Vec3> = body.faces.iter().map(|face| face.normal).collect();
    let mut overlaps = 0;
    for number in 0..20_000 {
        let mut rng = CounterRng::new(13, 0, number);
        let angles = [rng.uniform_in(0.0, 7.0), rng.uniform_in(0.0, 7.0)];
        let offset = rng.unit_vector() * 1.3;
        let pair = Pair {
            first: &pack(&flat(&body.corners, angles[0])),
            second: &pack(&flat(&body.corners, angles[1])),
            offset: [offset.x, offset.y],
            reach: 0.0,
        };
        let normals = angles.map(|angle| flat(&normals, angle));
        let expected = overlap_on_all_axes(&pair, [&normals[0], &normals[1]], [&[], &[]]);
        assert_eq!(pair.overlap(&mut { pair.offset }, || expected), expected);
        overlaps += usize::from(expected);
    }
    assert!((4000..19_000).contains(&overlaps), "{overlaps}");
}
