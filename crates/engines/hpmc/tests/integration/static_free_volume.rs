//! Free volumes of static diamonds of truncated tetrahedra against an independent program.

use protomer_hpmc::body::HardBody;
use protomer_hpmc::crystal::{Crystal, UnitCell};
use protomer_hpmc::static_free_volume::{StaticFreeVolume, static_free_volume};
use protomer_kernel::Vec3;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::polytope::Polytope;

fn truncated_tetrahedron() -> Shape {
    by_name("truncated-tetrahedron:0.6666666666666666").unwrap()
}

fn measured(crystal: &str, packing: f64, q: f64, lines_per_length: f64) -> StaticFreeVolume {
    let shape = truncated_tetrahedron();
    let body = HardBody::<3>::new(&shape, 0.0).unwrap();
    let cell = UnitCell::by_name(crystal).unwrap();
    let crystal = Crystal::new(&cell, &body, 8, packing).unwrap();
    let radius = q * Polytope::from_shape(&shape).unwrap().circumradius();
    static_free_volume(&crystal, &shape, 0.0, radius, lines_per_length).unwrap()
}

fn compare(rows: &[(f64, f64, f64, f64, f64)], lines_per_length: f64, floor: f64) {
    for (packing, q, cubic, hexagonal, error) in rows.iter().copied() {
        for (name, expected) in [("diamond", cubic), ("hexagonal-diamond", hexagonal)] {
            let found = measured(name, packing, q, lines_per_length);
            let allowed = (3.0 * found.error.hypot(error)).max(floor);
            let off = (found.fraction - expected).abs();
            assert!(off < allowed, "{name} {packing} {q}: {expected}, {found:?}");
            assert!(allowed < 2e-3, "{found:?}");
        }
    }
}

/// The same spheres in a cubic cell and in the primitive one, with angles of 60 degrees.
#[test]
fn the_free_volume_is_that_of_the_crystal_and_not_of_its_cell() {
    let point = Shape::solid(&[Vec3::zeros()]).unwrap();
    let ball = HardBody::<3>::ball(0.5).unwrap();
    let primitive = UnitCell {
        space: PeriodicBox::with_angles(&[1.0; 3], &[60.0; 3]).unwrap(),
        ..UnitCell::by_name("simple-cubic").unwrap()
    };
    let free = |cell: &UnitCell<3>| {
        let crystal = Crystal::new(cell, &ball, cell.sites.len(), 0.5).unwrap();
        static_free_volume(&crystal, &point, 0.5, 0.2, 150.0).unwrap()
    };
    let [cubic, rhombohedral] =
        [UnitCell::by_name("fcc").unwrap(), primitive].map(|cell| free(&cell));
    let error = cubic.error.hypot(rhombohedral.error);
    assert!(error < 1e-3 * cubic.fraction, "{cubic:?} {rhombohedral:?}");
    let off = (cubic.fraction - rhombohedral.fraction).abs();
    assert!(off < 4.0 * error, "{cubic:?} {rhombohedral:?}");
}

#[test]
fn lines_that_nobody_can_wait_for_are_refused() {
    let shape = truncated_tetrahedron();
    let body = HardBody::<3>::new(&shape, 0.0).unwrap();
    let crystal = Crystal::new(&UnitCell::by_name("diamond").unwrap(), &body, 8, 0.5).unwrap();
    for lines_per_length in [1e6, 1e19, 1e300] {
        let refused = static_free_volume(&crystal, &shape, 0.0, 0.1, lines_per_length);
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains("lines"), "{refused}");
    }
}

#[test]
fn bodies_that_overlap_are_named() {
    let shape = truncated_tetrahedron();
    let body = HardBody::<3>::new(&shape, 0.0).unwrap();
    let cell = UnitCell::by_name("diamond").unwrap();
    let crystal = Crystal::new(&cell, &body, 8, 0.97).unwrap();
    let refused = static_free_volume(&crystal, &shape, 0.0, 0.1, 10.0).unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("bodies 1 and 2 of the unit cell overlap"),
        "{refused}"
    );
}

#[test]
fn static_diamonds_have_the_free_volumes_of_the_reference() {
    compare(
        &[
            (0.52, 0.28, 0.009454077592, 0.01475939124, 2e-5),
            (0.62, 0.12, 0.05314458563, 0.05314344316, 2.7e-5),
        ],
        25.0,
        5e-4,
    );
}

#[test]
#[ignore = "all rows of the reference, on a finer grid; a minute in a release build"]
fn static_diamonds_have_all_free_volumes_of_the_reference() {
    compare(
        &[
            (0.52, 0.08, 0.238954186, 0.2390574083, 0.00012),
            (0.52, 0.12, 0.1053826261, 0.1054016312, 0.00011),
            (0.52, 0.18, 0.05357583935, 0.05357232692, 3.1e-5),
            (0.52, 0.22, 0.02951387145, 0.03237570455, 2.1e-5),
            (0.52, 0.28, 0.009454077592, 0.01475939124, 2e-5),
            (0.58, 0.08, 0.1511827851, 0.1511576981, 0.00016),
            (0.58, 0.12, 0.07070280896, 0.07069130088, 7.7e-5),
            (0.58, 0.18, 0.02998563487, 0.03271771409, 2.3e-5),
            (0.58, 0.22, 0.01439541055, 0.0194948858, 1.8e-5),
            (0.58, 0.28, 0.002872945569, 0.00722223858, 1.3e-5),
            (0.62, 0.08, 0.09266147351, 0.09259544421, 0.00014),
            (0.62, 0.12, 0.05314458563, 0.05314344316, 2.7e-5),
            (0.62, 0.18, 0.01986520007, 0.02435075912, 2e-5),
            (0.62, 0.22, 0.008235298548, 0.01350740396, 1.2e-5),
            (0.62, 0.28, 0.0009592935993, 0.004143725536, 1e-5),
            (0.75, 0.08, 0.03791297063, 0.03883662377, 2.7e-5),
            (0.75, 0.12, 0.01807561071, 0.02279011287, 2e-5),
            (0.75, 0.18, 0.003534027489, 0.008111142536, 1e-5),
            (0.75, 0.22, 0.0004905566876, 0.003104846045, 1e-5),
            (0.75, 0.28, 8.28448421e-13, 0.000253332706, 1e-5),
        ],
        80.0,
        1e-5,
    );
}
