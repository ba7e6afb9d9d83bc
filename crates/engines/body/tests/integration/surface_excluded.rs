//! Meshes of small solvent-excluded surfaces against their exact areas and volumes.

use crate::solids::random::cluster;
use crate::solids::ses::SlowExcluded;
use crate::solids::{Balls, worst};
use protomer_body::surface::{MeshSettings, Target, mesh_solid};

/// Name, atoms, exact area and volume at probe 1.4 Å, components, genus.
type Case = (
    &'static str,
    &'static [(f64, f64, f64, f64)],
    f64,
    f64,
    usize,
    i64,
);

const CASES: [Case; 7] = [
    (
        "one",
        &[(0.0, 0.0, 0.0, 1.7)],
        36.31681108,
        20.57952628,
        1,
        0,
    ),
    (
        "overlap",
        &[(0.0, 0.0, 0.0, 1.7), (0.0, 0.0, 2.5, 1.55)],
        57.53365247,
        35.79288044,
        1,
        0,
    ),
    (
        "cusps",
        &[(0.0, 0.0, 0.0, 1.7), (0.0, 0.0, 5.8, 1.7)],
        72.9442406,
        41.27369151,
        2,
        0,
    ),
    (
        "triangle",
        &[
            (0.0, 0.0, 0.0, 1.7),
            (2.8, 0.0, 0.0, 1.7),
            (1.4, 2.4248711305964283, 0.0, 1.7),
        ],
        85.59082136,
        61.75072336,
        1,
        0,
    ),
    (
        "cut hollow",
        &[
            (0.0, 0.0, 0.0, 1.7),
            (5.0, 0.0, 0.0, 1.7),
            (2.5, 4.330127018922193, 0.0, 1.7),
        ],
        120.03076417,
        67.22084206,
        1,
        1, // the probes above and below overlap: the middle is open
    ),
    (
        "ring",
        &[
            (0.0, 0.0, 0.0, 1.7),
            (4.6, 0.0, 0.0, 1.7),
            (4.6, 4.6, 0.0, 1.7),
            (0.0, 4.6, 0.0, 1.7),
        ],
        156.95359458,
        92.83641939,
        1,
        1,
    ),
    (
        "tetrahedron",
        &[
            (0.0, 0.0, 0.0, 1.7),
            (3.1, 0.2, 0.0, 1.55),
            (1.2, 2.9, 0.3, 1.52),
            (1.5, 1.1, 2.6, 1.8),
        ],
        106.80553576,
        82.23627732,
        1,
        0,
    ),
];

#[test]
fn small_molecules_have_their_exact_area_volume_and_topology() {
    for (name, atoms, area_angstrom2, volume_angstrom3, components, genus) in CASES {
        let solid = SlowExcluded::new(atoms, 1.4);
        let target = Target {
            area_angstrom2,
            volume_angstrom3,
        };
        for density in [0.5, 1.0, 2.0, 4.0, 16.0] {
            for goal in [None, Some(target)] {
                let settings = MeshSettings {
                    density_per_angstrom2: density,
                    ..MeshSettings::default()
                };
                let mesh = mesh_solid(&solid, &settings, goal).unwrap();
                let topology = mesh.topology().unwrap();
                assert_eq!(
                    (topology.components, topology.genus),
                    (components, genus),
                    "{name}"
                );
                assert!(worst(&mesh).0 > 1e-6);
                let area = (mesh.area_angstrom2() / area_angstrom2 - 1.0).abs();
                let volume = (mesh.volume_angstrom3() / volume_angstrom3 - 1.0).abs();
                // The excess of area of flat facets falls as 1/density.
                let tolerance = if goal.is_some() {
                    (0.01, 0.002)
                } else {
                    (0.05 / density.max(1.0), 0.03 / density.max(1.0))
                };
                assert!(
                    area < tolerance.0 && volume < tolerance.1,
                    "{name} {density}: {area} {volume}"
                );
            }
        }
    }
}

#[test]
fn awkward_clusters_give_valid_meshes() {
    for seed in 0..60 {
        let atoms = cluster(seed, 3 + (seed % 8) as usize);
        let mesh = mesh_solid(
            &SlowExcluded::new(&atoms, 1.4),
            &MeshSettings::default(),
            None,
        )
        .unwrap();
        mesh.topology().unwrap();
        assert!(worst(&mesh).0 > 1e-6, "{seed}: {:?}", worst(&mesh));
    }
}

fn assert_unions_of_balls_are_meshed(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let atoms = cluster(seed, 3 + (seed % 58) as usize);
        let mesh = mesh_solid(&Balls::new(&atoms), &MeshSettings::default(), None).unwrap();
        mesh.topology().unwrap();
        assert!(worst(&mesh).0 > 1e-6, "{seed}: {:?}", worst(&mesh));
    }
}

#[test]
fn awkward_unions_of_balls_give_valid_meshes() {
    assert_unions_of_balls_are_meshed(0..60);
}

#[test]
#[ignore = "reason: slow; run by name"]
fn a_thousand_awkward_unions_of_balls_give_valid_meshes() {
    assert_unions_of_balls_are_meshed(0..1000);
}
