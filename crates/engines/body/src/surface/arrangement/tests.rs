use super::*;
use crate::surface::test_support::{clusters, fraction, probe_contacts};
use crate::surface::{ImplicitSolid, Measure, SesSolid};

/// Everything that is built on an arrangement comes out finite and unspoilt.
fn check(centres: &[Vec3], radii: &[f64], probe: f64) -> Measure {
    let accessible = Arrangement::new(centres, radii, probe).unwrap();
    assert_eq!(accessible.defects(), 0);
    let measure = Measure::new(&accessible);
    assert_eq!(measure.sampled_patches, 0);
    let total = measure.total();
    assert!(total.ses_volume_angstrom3.is_finite() && total.ses_area_angstrom2().is_finite());
    assert!(total.ses_volume_angstrom3 <= total.sas_volume_angstrom3 * (1.0 + 1e-9));
    let error = total.area_error_estimate_angstrom2;
    assert!(
        error < 1e-6 * total.sas_area_angstrom2,
        "{error} of {}",
        total.sas_area_angstrom2
    );
    measure
}

#[test]
fn a_thousand_awkward_clusters_are_arranged() {
    for (centres, radii) in clusters(1000, 3..60) {
        check(&centres, &radii, 1.4);
    }
}

#[test]
fn vertices_are_the_probe_contacts_that_touch_no_fourth_ball() {
    for (centres, radii) in clusters(100, 3..25) {
        let accessible = Arrangement::new(&centres, &radii, 1.4).unwrap();
        let expanded = accessible.expanded_radii_angstrom();
        let inside = |x: &Vec3| {
            centres
                .iter()
                .zip(expanded)
                .filter(|(c, r)| (x - *c).norm() < *r - 1e-10)
                .count()
        };
        let allowed = probe_contacts(&centres, expanded)
            .into_iter()
            .filter(|x| inside(x) == 0)
            .count();
        assert_eq!(accessible.vertices().len(), allowed);
    }
}

#[test]
fn perfect_lattices_are_arranged() {
    let cubic: Vec<Vec3> = (0..512)
        .map(|n| Vec3::new((n % 8) as f64, (n / 8 % 8) as f64, (n / 64) as f64))
        .collect();
    let face_centred: Vec<Vec3> = (cubic.iter())
        .flat_map(|c| {
            [
                [0.0, 0.0, 0.0],
                [0.5, 0.5, 0.0],
                [0.5, 0.0, 0.5],
                [0.0, 0.5, 0.5],
            ]
            .map(|s| c + Vec3::from(s))
        })
        .collect();
    for lattice in [&cubic, &face_centred] {
        for spacing in [1.5, 2.0, 2.8, 3.1, 3.4, 4.0, 4.4, 5.0, 6.2, 7.0] {
            let centres: Vec<Vec3> = lattice.iter().map(|c| c * spacing).collect();
            check(&centres, &vec![1.7; centres.len()], 1.4);
        }
    }
}

#[test]
fn small_symmetric_inputs_are_arranged() {
    let square = [
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
    ]
    .map(Vec3::from);
    let octahedron: Vec<Vec3> = [Vec3::x(), Vec3::y(), Vec3::z()]
        .iter()
        .flat_map(|e| [*e, -e])
        .collect();
    let line: Vec<Vec3> = (0..5).map(|n| Vec3::x() * f64::from(n)).collect();
    for shape in [&square[..], &octahedron, &line] {
        for step in 1..140 {
            let centres: Vec<Vec3> = shape.iter().map(|c| c * (0.05 * f64::from(step))).collect();
            check(&centres, &vec![1.7; centres.len()], 1.4);
        }
        for scale in [
            3.1,
            3.1 / 2.0,
            3.1 / 2.0_f64.sqrt(),
            1.7,
            1e-12,
            1e-9,
            1e-7,
            1e-5,
        ] {
            let centres: Vec<Vec3> = shape.iter().map(|c| c * scale).collect();
            check(&centres, &vec![1.7; centres.len()], 1.4);
        }
    }
}

#[test]
fn tangent_and_nested_balls_are_arranged() {
    for distance in [
        0.0,
        1e-15,
        1e-8,
        0.4,
        0.5,
        0.6,
        3.7,
        6.7,
        6.7 - 1e-12,
        6.7 + 1e-12,
    ] {
        let measure = check(
            &[Vec3::zeros(), Vec3::new(distance, 0.0, 0.0)],
            &[1.7, 2.2],
            1.4,
        );
        assert_eq!(
            measure.shells.len(),
            if distance < 6.7 {
                1
            } else {
                measure.shells.len()
            }
        );
    }
    let total = check(&[Vec3::zeros(), Vec3::new(0.3, 0.0, 0.0)], &[1.0, 2.0], 1.4).total();
    assert!((total.ses_area_angstrom2() - 16.0 * std::f64::consts::PI).abs() < 1e-6);
}

#[test]
fn a_pile_of_duplicates_is_one_atom() {
    let centres = vec![Vec3::new(1.0, 2.0, 3.0); 200_000];
    let total = check(&centres, &vec![1.7; centres.len()], 1.4).total();
    assert!((total.ses_area_angstrom2() - 36.316_811_08).abs() < 1e-5);
}

#[test]
fn a_heap_without_order_is_refused() {
    let centres: Vec<Vec3> = (0..60_000)
        .map(|n| Vec3::new(fraction(n), fraction(n + 70_000), 0.0))
        .collect();
    assert!(Arrangement::new(&centres, &vec![1.7; centres.len()], 1.4).is_err());
}

#[test]
fn atoms_far_apart_need_no_more_memory_than_atoms_close_together() {
    let centres: Vec<Vec3> = (0..2000)
        .map(|n| Vec3::new(fraction(n), fraction(n + 9000), 0.3) * 1e9)
        .collect();
    let accessible = Arrangement::new(&centres, &vec![1.7; centres.len()], 1.4).unwrap();
    assert_eq!(accessible.shell_count(), 2000);
    let solid = SesSolid::new(&accessible);
    assert!((solid.signed_distance(&(centres[7] + Vec3::new(0.0, 1.5, 0.0))) + 0.2).abs() < 1e-5);
    let area = Measure::new(&accessible).total().ses_area_angstrom2();
    assert!((area - 2000.0 * 36.316_811_08).abs() < 1e-2);
}

#[test]
fn nonsense_is_refused() {
    let origin = [Vec3::zeros()];
    assert!(Arrangement::new(&[], &[], 1.4).is_err());
    assert!(Arrangement::new(&origin, &[1.0, 1.0], 1.4).is_err());
    for coordinate in [f64::NAN, f64::INFINITY, 1e300] {
        assert!(Arrangement::new(&[Vec3::new(0.0, coordinate, 0.0)], &[1.7], 1.4).is_err());
    }
    for radius in [-1.0, f64::NAN, f64::INFINITY, 1e6] {
        assert!(Arrangement::new(&origin, &[radius], 1.4).is_err());
        assert!(Arrangement::new(&origin, &[1.7], radius).is_err());
    }
    assert!(Arrangement::new(&origin, &[0.0], 0.0).is_err());
    assert!(Arrangement::new(&origin, &[0.0], 1.4).is_ok());
}
