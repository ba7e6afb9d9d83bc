//! The potential of mean force of hard polygons in the limit of no density, by angles at which two
//! polygons are free, against an independent program.

use protomer_kernel::bisection::halved;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::exact::overlap_exactly;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::{PI, TAU};

/// Angles at which it is tried whether the second polygon is free, before the ends are halved.
const ANGLES: usize = 720;

/// The part of all angles at which a second polygon at a place overlaps none of the first, which has a
/// face along +x.
fn free_fraction(corners: usize, place: [f64; 2]) -> f64 {
    let body = Polytope::from_shape(&by_name(&format!("polygon:{corners}")).unwrap()).unwrap();
    let edges: Vec<Vec<usize>> = body.faces.iter().map(|face| face.corners.clone()).collect();
    let turned = |angle: f64| {
        let rotation = Rotation::from_scaled_axis(angle * Vec3::z());
        let turn = |corner: &Vec3| {
            let corner = rotation * corner;
            [corner.x, corner.y]
        };
        pack(&body.corners.iter().map(turn).collect::<Vec<[f64; 2]>>())
    };
    // The first corner of a polygon by name is on +x.
    let first = turned(PI / corners as f64);
    let is_free = |angle: f64| {
        let pair = Pair {
            first: &first,
            second: &turned(angle),
            offset: place,
            reach: 0.0,
            error: error_of_heights(8.0 * body.circumradius()),
        };
        !pair.overlap(&mut { place }, || overlap_exactly(&pair, [&edges, &edges]))
    };
    let mut free = 0.0;
    for number in 0..ANGLES {
        let [from, to] = [number, number + 1].map(|n| TAU * n as f64 / ANGLES as f64);
        let ends = [is_free(from), is_free(to)];
        if ends[0] == ends[1] {
            free += if ends[0] { to - from } else { 0.0 };
            continue;
        }
        let [low, high] = halved([from, to], 40, |angle| is_free(angle) == ends[0]);
        free += if ends[0] { low - from } else { to - high };
    }
    free / TAU
}

#[test]
fn free_angles_are_those_of_the_reference() {
    for (corners, x, y, expected) in [
        (4, 1.02, 0.0, 0.05200599685760207),
        (4, 1.1, 0.1, 0.29004312374822105),
        (4, 1.2, 0.3, 0.8193310587965317),
        (4, 1.03, 0.5, 0.25466661792375145),
        (4, 1.15, 0.6, 0.7896867348201672),
        (6, 1.1, 0.0, 0.16986832430875495),
        (6, 1.12, 0.2, 0.4043635803346058),
        (6, 1.15, 0.35, 0.8939371967598211),
        (3, 0.95, 0.1, 0.09761239727184846),
        (3, 1.2, -0.3, 0.5032157140112844),
        (3, -1.0, 0.4, 0.0),
    ] {
        let found = free_fraction(corners, [x, y]);
        let off = (found - expected).abs();
        assert!(
            off < 1e-9,
            "{corners} {x} {y}: {found} instead of {expected}"
        );
    }
}
