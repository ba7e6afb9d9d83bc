use super::*;
use crate::surface::test_support::{clusters, fraction, read_reference, reference_file};
use crate::surface::{ImplicitSolid, SesSolid};
use protomer_kernel::Rotation;
use protomer_kernel::quadrature::points_on_sphere;

fn measure(centres: &[Vec3], radii: &[f64], probe: f64) -> Measure {
    Measure::new(&Arrangement::new(centres, radii, probe).unwrap())
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/surface"]
fn all_reference_surfaces_are_met() {
    let text = reference_file("reference.json");
    let cases: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    for case in &cases {
        let file = case["file"].as_str().unwrap();
        let (centres, radii) = read_reference(file);
        let measured = measure(&centres, &radii, case["probe"].as_f64().unwrap());
        let total = measured.total();
        let tolerance = if centres.len() < 10 { 1e-6 } else { 1e-5 };
        for (key, value) in [
            ("sas_area", total.sas_area_angstrom2),
            ("sas_volume", total.sas_volume_angstrom3),
            ("ses_area", total.ses_area_angstrom2()),
            ("ses_volume", total.ses_volume_angstrom3),
            ("convex", total.convex_area_angstrom2),
            ("toroidal", total.toroidal_area_angstrom2),
            ("concave", total.concave_area_angstrom2),
        ] {
            let expected = case[key].as_f64().unwrap();
            let error = (value - expected).abs() / expected.abs().max(1.0);
            assert!(
                error < tolerance,
                "{file} {key}: {value}, expected {expected}"
            );
        }
        for (key, value) in [
            ("free_tori", measured.free_arcs),
            ("singular_arcs", measured.singular_arcs),
            ("cut_concave", measured.cut_concave_patches),
        ] {
            assert_eq!(case[key].as_u64(), Some(value as u64), "{file} {key}");
        }
        assert_eq!(measured.sampled_patches, 0);
        assert!(total.area_error_estimate_angstrom2 < tolerance * total.ses_area_angstrom2());
        assert!(total.volume_error_estimate_angstrom3 < tolerance * total.ses_volume_angstrom3);
    }
}

/// Volume of {f < 0} on a grid, a cell that the surface cuts counted by its signed distance.
fn grid_volume(solid: &SesSolid, spacing: f64) -> f64 {
    let (low, high) = solid.bounds();
    let counts = ((high - low) / spacing).map(|count| count.ceil() as usize);
    let mut cells = 0.0;
    for x in 0..counts.x {
        for y in 0..counts.y {
            for z in 0..counts.z {
                let point =
                    low + Vec3::new(x as f64 + 0.5, y as f64 + 0.5, z as f64 + 0.5) * spacing;
                cells += (0.5 - solid.signed_distance(&point) / spacing).clamp(0.0, 1.0);
            }
        }
    }
    cells * spacing.powi(3)
}

#[test]
fn volumes_of_clusters_agree_with_a_grid() {
    for (number, (centres, radii)) in clusters(25, 3..40).into_iter().enumerate() {
        let accessible = Arrangement::new(&centres, &radii, 1.4).unwrap();
        let total = Measure::new(&accessible).total();
        let solid = SesSolid::new(&accessible);
        // The grid errs by a multiple of the squared spacing, which two spacings take out.
        let expected = (4.0 * grid_volume(&solid, 0.2) - grid_volume(&solid, 0.4)) / 3.0;
        let error = (total.ses_volume_angstrom3 - expected).abs() / expected;
        assert!(
            error < 1e-3,
            "cluster {number} of {}: {} and {expected}",
            centres.len(),
            total.ses_volume_angstrom3
        );
    }
}

/// Growing all radii by t moves the accessible surface by t along its normal, so dV/dt is its area.
/// Growing the radii by t and shrinking the probe by t moves the excluded surface by t.
#[test]
fn areas_are_the_derivatives_of_volumes() {
    let step = 2e-3;
    for (number, (centres, radii)) in clusters(100, 3..60).into_iter().enumerate() {
        let shifted = |t: f64| -> Vec<f64> { radii.iter().map(|radius| radius + t).collect() };
        let total = measure(&centres, &radii, 1.4).total();
        let slope = |grown: Measure, shrunk: Measure, volume: fn(&SurfaceMeasure) -> f64| {
            (volume(&grown.total()) - volume(&shrunk.total())) / (2.0 * step)
        };
        let accessible = slope(
            measure(&centres, &shifted(step), 1.4),
            measure(&centres, &shifted(-step), 1.4),
            |m| m.sas_volume_angstrom3,
        );
        let excluded = slope(
            measure(&centres, &shifted(step), 1.4 - step),
            measure(&centres, &shifted(-step), 1.4 + step),
            |m| m.ses_volume_angstrom3,
        );
        let sas_error = (accessible - total.sas_area_angstrom2).abs() / total.sas_area_angstrom2;
        let ses_error = (excluded - total.ses_area_angstrom2()).abs() / total.ses_area_angstrom2();
        // Tangent balls begin to touch within the step, where the area has a kink.
        assert!(
            sas_error < 2e-4,
            "cluster {number}: {accessible} {}",
            total.sas_area_angstrom2
        );
        assert!(
            ses_error < 2e-4,
            "cluster {number}: {excluded} {}",
            total.ses_area_angstrom2()
        );
    }
}

#[test]
fn measures_do_not_depend_on_place_and_orientation() {
    for (number, (centres, radii)) in clusters(120, 1..60).into_iter().enumerate() {
        let number = number as u64;
        let axis = Vec3::new(
            fraction(number) - 0.5,
            fraction(number + 500) - 0.5,
            fraction(number + 900) - 0.5,
        );
        let rotation = Rotation::new(axis * 6.0);
        let images: Vec<Vec3> = centres
            .iter()
            .map(|c| rotation * c + Vec3::new(30.0, -200.0, 7.0))
            .collect();
        let (first, second) = (
            measure(&centres, &radii, 1.4),
            measure(&images, &radii, 1.4),
        );
        assert_eq!(first.shells.len(), second.shells.len(), "cluster {number}");
        assert_eq!(first.sampled_patches + second.sampled_patches, 0);
        let (first, second) = (first.total(), second.total());
        for (a, b) in [
            (first.sas_area_angstrom2, second.sas_area_angstrom2),
            (first.sas_volume_angstrom3, second.sas_volume_angstrom3),
            (first.ses_area_angstrom2(), second.ses_area_angstrom2()),
            (first.ses_volume_angstrom3, second.ses_volume_angstrom3),
        ] {
            assert!(
                (a - b).abs() < 1e-6 * a.abs().max(1.0),
                "cluster {number}: {a} {b}"
            );
        }
    }
}

/// Atoms spread over a sphere, near enough to each other to close it.
fn hollow(radius: f64, count: usize) -> Vec<Vec3> {
    points_on_sphere(count)
        .map(|point| point * radius)
        .collect()
}

#[test]
fn a_hollow_ball_has_one_cavity_and_a_guest_in_it_none_of_its_own() {
    let mut centres = hollow(9.0, 150);
    let mut radii = vec![1.7; centres.len()];
    let empty = measure(&centres, &radii, 1.4);
    assert_eq!((empty.shells.len(), empty.cavity_count()), (2, 1));
    let (total, filled) = (empty.total(), empty.without_cavities());
    assert!(
        filled.ses_volume_angstrom3
            > total.ses_volume_angstrom3 + 4.0 / 3.0 * std::f64::consts::PI * 6.5_f64.powi(3)
    );
    assert!(filled.ses_area_angstrom2() < total.ses_area_angstrom2());
    centres.push(Vec3::zeros());
    radii.push(1.7);
    let guest = measure(&centres, &radii, 1.4);
    assert_eq!((guest.shells.len(), guest.cavity_count()), (3, 1));
    let expected = 4.0 / 3.0 * std::f64::consts::PI * 1.7_f64.powi(3);
    assert!(
        (guest.total().ses_volume_angstrom3 - total.ses_volume_angstrom3 - expected).abs() < 1e-5
    );
}

#[test]
fn without_a_probe_both_surfaces_are_the_union_of_the_atoms() {
    for (centres, radii) in clusters(20, 1..30) {
        let total = measure(&centres, &radii, 0.0).total();
        assert!(
            (total.sas_area_angstrom2 - total.ses_area_angstrom2()).abs()
                < 1e-9 * total.sas_area_angstrom2
        );
        assert!(
            (total.sas_volume_angstrom3 - total.ses_volume_angstrom3).abs()
                < 1e-9 * total.sas_volume_angstrom3
        );
    }
}

/// Centres of equal atoms where four and more expanded balls meet in one point, by name.
fn cages() -> Vec<(&'static str, Vec<Vec3>)> {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let signs = |v: [f64; 3]| {
        let mut all = Vec::new();
        for number in 0..8 {
            let sign = |axis: usize| if number >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let place = Vec3::new(v[0] * sign(0), v[1] * sign(1), v[2] * sign(2));
            if !all.contains(&place) {
                all.push(place);
            }
        }
        all
    };
    let permutations = |v: [f64; 3]| {
        let cyclic = (0..3).map(move |step| [v[step % 3], v[(step + 1) % 3], v[(step + 2) % 3]]);
        cyclic.flat_map(signs).collect::<Vec<_>>()
    };
    let ring = |count: u32, radius: f64, height: f64| {
        (0..count).map(move |n| {
            let (sine, cosine) =
                (std::f64::consts::TAU * f64::from(n) / f64::from(count)).sin_cos();
            Vec3::new(radius * cosine, radius * sine, height)
        })
    };
    let prism = |count| {
        ring(count, 2.6, 1.5)
            .chain(ring(count, 2.6, -1.5))
            .collect::<Vec<_>>()
    };
    let scaled = |places: Vec<Vec3>, factor: f64| places.into_iter().map(|v| v * factor).collect();
    let fullerene = [
        permutations([0.0, 1.0, 3.0 * golden]),
        permutations([1.0, 2.0 + golden, 2.0 * golden]),
        permutations([golden, 2.0, 2.0 * golden + 1.0]),
    ];
    vec![
        ("cube", scaled(signs([1.0; 3]), 1.4)),
        ("octahedron", scaled(permutations([1.0, 0.0, 0.0]), 2.1)),
        ("icosahedron", scaled(permutations([0.0, 1.0, golden]), 1.6)),
        ("hexagon", ring(6, 2.4, 0.0).collect()),
        ("wide ring", ring(12, 5.0, 0.0).collect()),
        ("prism of five", prism(5)),
        ("prism of six", prism(6)),
        ("fullerene", scaled(fullerene.concat(), 0.97)),
    ]
}

/// The same measures in every orientation and with every rounding of the coordinates, and the volume
/// of a grid.
#[test]
fn cages_of_equal_atoms_measure_the_same_in_every_orientation() {
    for (name, centres) in cages() {
        let radii = vec![1.7; centres.len()];
        let solid = SesSolid::new(&Arrangement::new(&centres, &radii, 1.4).unwrap());
        let volume = (4.0 * grid_volume(&solid, 0.15) - grid_volume(&solid, 0.3)) / 3.0;
        let first = measure(&centres, &radii, 1.4).total();
        let error = (first.ses_volume_angstrom3 - volume).abs() / volume;
        assert!(
            error < 1e-3,
            "{name}: {} and {volume}",
            first.ses_volume_angstrom3
        );
        for number in 0..24_u64 {
            let axis = Vec3::from_fn(|row, _| fraction(10 * number + row as u64) - 0.5);
            let rotation = Rotation::new(axis * 6.0);
            let decimals = 9 + number as i32 % 8;
            let rounded = |x: f64| (x * 10_f64.powi(decimals)).round() / 10_f64.powi(decimals);
            let images: Vec<Vec3> = centres
                .iter()
                .map(|c| (rotation * c).map(rounded))
                .collect();
            let second = measure(&images, &radii, 1.4);
            assert_eq!(second.sampled_patches, 0, "{name} {number}");
            let second = second.total();
            for (a, b) in [
                (first.sas_area_angstrom2, second.sas_area_angstrom2),
                (first.sas_volume_angstrom3, second.sas_volume_angstrom3),
                (first.ses_area_angstrom2(), second.ses_area_angstrom2()),
                (first.ses_volume_angstrom3, second.ses_volume_angstrom3),
            ] {
                assert!(
                    (a - b).abs() < 1e-6 * a,
                    "{name}, orientation {number}: {a} {b}"
                );
            }
            let error = second.area_error_estimate_angstrom2;
            assert!(
                error < 1e-6 * second.sas_area_angstrom2,
                "{name} {number}: {error}"
            );
        }
    }
}
