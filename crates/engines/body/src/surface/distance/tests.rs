use super::*;
use crate::surface::test_support::{clusters, probe_contacts, read_reference};

/// The obvious twin: every radial projection, every nearest point of a circle, every probe contact
/// of three atoms, of which those in no ball are allowed probe positions.
fn brute_force_distance(point: &Vec3, centres: &[Vec3], radii: &[f64], contacts: &[Vec3]) -> f64 {
    let outside = |x: &Vec3| {
        centres
            .iter()
            .zip(radii)
            .all(|(c, r)| (x - c).norm() >= r - 1e-6)
    };
    if outside(point) {
        return 0.0;
    }
    let mut best = f64::INFINITY;
    let mut offer = |x: Vec3| {
        if (x - point).norm() < best && outside(&x) {
            best = (x - point).norm();
        }
    };
    contacts.iter().for_each(|contact| offer(*contact));
    for (i, (ci, ri)) in centres.iter().zip(radii).enumerate() {
        offer(ci + (point - ci).normalize() * *ri);
        for (cj, rj) in centres.iter().zip(radii).skip(i + 1) {
            let d = (cj - ci).norm();
            let h = (d * d + ri * ri - rj * rj) / (2.0 * d);
            if d > 0.0 && ri * ri > h * h {
                let n = (cj - ci) / d;
                let out = point - ci - n * n.dot(&(point - ci));
                offer(ci + n * h + out.normalize() * (ri * ri - h * h).sqrt());
            }
        }
    }
    best
}

#[test]
fn the_distance_agrees_with_brute_force() {
    let mut near = 0;
    for (number, (centres, radii)) in clusters(60, 3..14).into_iter().enumerate() {
        let probe = [1.4, 0.9, 2.5][number % 3];
        let accessible = Arrangement::new(&centres, &radii, probe).unwrap();
        let solid = SesSolid::new(&accessible);
        let expanded = accessible.expanded_radii_angstrom();
        let contacts = probe_contacts(&centres, expanded);
        let (low, high) = solid.bounds();
        for step in 0..400 {
            let fraction = |axis: u64| {
                super::super::test_support::fraction(number as u64 * 7919 + step * 3 + axis) * 1.4
                    - 0.2
            };
            let point = Vec3::new(
                low.x + (high.x - low.x) * fraction(0),
                low.y + (high.y - low.y) * fraction(1),
                low.z + (high.z - low.z) * fraction(2),
            );
            let expected = probe - brute_force_distance(&point, &centres, expanded, &contacts);
            let value = solid.signed_distance(&point);
            if expected >= probe - 1e-9 {
                assert!(
                    value >= probe - 1e-9,
                    "cluster {number}: {value} where the probe may be"
                );
            } else {
                near += i32::from(expected.abs() < 0.5);
                assert!(
                    (value - expected.max(-BAND_ANGSTROM)).abs() < 1e-5,
                    "cluster {number}: {value} {expected}"
                );
            }
        }
    }
    assert!(near > 2000, "{near} points near the surface");
}

/// The slow twin: one by one.
#[test]
fn many_points_have_the_distances_of_each() {
    let mut at_edges = 0;
    for (number, (centres, radii)) in clusters(30, 1..30).into_iter().enumerate() {
        // Every third cluster is that of large spheres, for which single precision errs by more.
        let scale = [1.0, 1.0, 40.0][number % 3];
        let centres: Vec<Vec3> = centres.iter().map(|centre| centre * scale).collect();
        let radii: Vec<f64> = radii.iter().map(|radius| radius * scale).collect();
        let probe = 1.4 * scale;
        let solid = SesSolid::new(&Arrangement::new(&centres, &radii, probe).unwrap());
        let allowed = solid.error_angstrom();
        let (low, high) = solid.bounds();
        let fraction = |seed: u64| super::super::test_support::fraction(number as u64 * 31 + seed);
        let points: Vec<Vec3> = (0..1000)
            .map(|step| {
                let place = Vec3::from([0, 1, 2].map(|axis| 1.6 * fraction(3 * step + axis) - 0.3));
                low + (high - low).component_mul(&place)
            })
            .collect();
        let (mut values, mut found) = (Vec::new(), Vec::new());
        solid.signed_distances(&points, &mut values);
        solid.signed_distances_and_empty_balls(&points, &mut found);
        for (number, point) in points.iter().enumerate() {
            let (value, ball) = solid.signed_distance_and_empty_ball(point);
            let fast = values[number];
            assert!((fast - value).abs() < allowed, "{point}: {fast} {value}");
            assert_eq!(fast < 0.0, value < 0.0);
            assert_eq!(found[number].0, fast);
            assert_eq!(
                found[number].1.is_some(),
                ball.is_some(),
                "{point}: {value} {fast}"
            );
            if let (Some((fast, radius)), Some((centre, _))) = (found[number].1, ball) {
                // Another probe may be as near.
                let distances = [fast, centre].map(|probe| (probe - point).norm());
                assert!((distances[0] - distances[1]).abs() < allowed && radius == probe);
                at_edges += i32::from(value < 0.9 * probe);
            }
        }
    }
    assert!(at_edges > 1000, "{at_edges}");
}

/// Every instruction set finds the same.
#[test]
fn lanes_do_not_depend_on_the_processor() {
    let (centres, radii) = clusters(1, 29..30).remove(0);
    let solid = SesSolid::new(&Arrangement::new(&centres, &radii, 1.4).unwrap());
    batch::tests::lanes_do_not_depend_on_the_processor(&solid);
}

#[test]
fn projected_points_lie_on_the_surface_nearest_to_the_point() {
    for (number, (centres, radii)) in clusters(40, 3..30).into_iter().enumerate() {
        let solid = SesSolid::new(&Arrangement::new(&centres, &radii, 1.4).unwrap());
        let (low, high) = solid.bounds();
        for step in 0..300 {
            let fraction = |axis: u64| {
                super::super::test_support::fraction(number as u64 * 104_729 + step * 3 + axis)
            };
            let point =
                low + (high - low).component_mul(&Vec3::new(fraction(0), fraction(1), fraction(2)));
            let value = solid.signed_distance(&point);
            let (onto, normal) = solid.project(&point);
            assert!(
                solid.signed_distance(&onto).abs() < 1e-5,
                "{} from {value}: {point} to {onto} in {number}",
                solid.signed_distance(&onto)
            );
            assert!(
                (normal.norm() - 1.0).abs() < 1e-9,
                "{normal} for {point} in cluster {number}, value {value}, onto {onto}"
            );
            if value < 0.0 && value > -BAND_ANGSTROM {
                assert!(((onto - point).norm() + value).abs() < 1e-9);
                assert!((onto - normal * value.abs() - point).norm() < 1e-9);
            }
        }
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/surface"]
fn the_function_is_1_lipschitz() {
    let (centres, radii) = read_reference("1crn_heavy.xyzr");
    let solid = SesSolid::new(&Arrangement::new(&centres, &radii, 1.4).unwrap());
    let (low, high) = solid.bounds();
    for step in 0..20_000 {
        let fraction = |axis: u64| super::super::test_support::fraction(step * 6 + axis);
        let point =
            low + (high - low).component_mul(&Vec3::new(fraction(0), fraction(1), fraction(2)));
        let other = point
            + Vec3::new(fraction(3) - 0.5, fraction(4) - 0.5, fraction(5) - 0.5)
                * fraction(step % 7);
        let change = (solid.signed_distance(&point) - solid.signed_distance(&other)).abs();
        assert!(
            change <= (point - other).norm() + 1e-9,
            "{change} over {}",
            (point - other).norm()
        );
    }
}

#[test]
fn every_place_has_an_answer() {
    let centres = [Vec3::zeros(), Vec3::new(1e9, 0.0, 0.0)];
    let solid = SesSolid::new(&Arrangement::new(&centres, &[1.7, 1.7], 1.4).unwrap());
    for point in [
        Vec3::zeros(),
        Vec3::repeat(1e8),
        Vec3::new(1e9, 0.0, 0.0),
        Vec3::new(0.0, 3.1, 0.0),
    ] {
        let (onto, normal) = solid.project(&point);
        assert!(onto.iter().chain(normal.iter()).all(|x| x.is_finite()));
        assert!(solid.signed_distance(&onto).abs() < 1e-6);
    }
}
