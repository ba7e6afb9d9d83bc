//! Meshes of solids whose area, volume and topology are known in closed form.

use crate::solids;

use protomer_body::surface::{ImplicitSolid, MeshSettings, Target, mesh_solid, without_cavities};
use protomer_kernel::mesh::Topology;
use protomer_kernel::{TriangleMesh, Vec3};
use solids::{Balls, Shell, Torus, worst};
use std::f64::consts::PI;

fn at_density(density_per_angstrom2: f64) -> MeshSettings {
    MeshSettings {
        density_per_angstrom2,
        ..MeshSettings::default()
    }
}

fn ball(radius: f64) -> Target {
    Target {
        area_angstrom2: 4.0 * PI * radius * radius,
        volume_angstrom3: 4.0 / 3.0 * PI * radius.powi(3),
    }
}

/// Relative errors of area and volume.
fn errors(mesh: &TriangleMesh, exact: Target) -> (f64, f64) {
    (
        (mesh.area_angstrom2() / exact.area_angstrom2 - 1.0).abs(),
        (mesh.volume_angstrom3() / exact.volume_angstrom3 - 1.0).abs(),
    )
}

fn mesh_of(
    solid: &dyn ImplicitSolid,
    density: f64,
    target: Option<Target>,
) -> (TriangleMesh, Topology) {
    let mesh = mesh_solid(solid, &at_density(density), target).unwrap();
    let topology = mesh.topology().unwrap();
    assert!(worst(&mesh).0 > 1e-6);
    (mesh, topology)
}

#[test]
fn balls_keep_their_area_and_volume() {
    for radius in [1.2, 1.7, 5.0, 12.0] {
        let exact = ball(radius);
        for density in [1.0, 4.0] {
            for target in [None, Some(exact)] {
                let solid = Balls::new(&[(0.1, 0.2, 0.3, radius)]);
                let (mesh, topology) = mesh_of(&solid, density, target);
                assert_eq!(
                    topology,
                    Topology {
                        components: 1,
                        euler_number: 2,
                        genus: 0,
                        cavities: 0
                    }
                );
                let (area, volume) = errors(&mesh, exact);
                assert!(
                    area < 0.01 && volume < if target.is_some() { 1e-6 } else { 0.002 },
                    "{radius}: {area} {volume}"
                );
            }
        }
    }
}

/// The first mesh of a large shell is coarse; that of a small one next to it is not.
#[test]
fn a_small_ball_beside_a_large_one_keeps_its_shape() {
    let solid = Balls::new(&[(0.1, 0.2, 0.3, 12.0), (16.0, 0.0, 0.0, 1.2)]);
    let (mesh, _) = mesh_of(&solid, 1.0, None);
    let shells = mesh.shells().unwrap();
    assert_eq!(shells.len(), 2);
    for shell in shells {
        let is_small = shell.vertices[0].x > 14.0;
        let radius = if is_small { 1.2 } else { 12.0 };
        let (area, volume) = errors(&shell, ball(radius));
        assert!(area < 0.01 && volume < 0.002, "{radius}: {area} {volume}");
    }
}

/// Its few triangles are in no plane: the first mesh is not coarse, and vertices do not stay in the plane
/// of their neighbours.
#[test]
fn a_small_ball_of_few_vertices_keeps_its_shape() {
    let settings = MeshSettings {
        fewest_vertices_per_shell: 0,
        ..at_density(1.0)
    };
    let solid = Balls::new(&[(0.1, 0.2, 0.3, 1.2)]);
    let mesh = mesh_solid(&solid, &settings, None).unwrap();
    let (area, _) = errors(&mesh, ball(1.2));
    assert!(mesh.vertices.len() >= 12 && area < 0.02, "{area}");
}

#[test]
fn the_number_of_vertices_follows_the_density() {
    for density in [0.25, 1.0, 4.0, 16.0] {
        let (mesh, _) = mesh_of(&Balls::new(&[(0.0, 0.0, 0.0, 8.0)]), density, None);
        let wanted = density * ball(8.0).area_angstrom2;
        assert!(
            (mesh.vertices.len() as f64 / wanted - 1.0).abs() < 0.25,
            "{density}: {}",
            mesh.vertices.len()
        );
    }
}

#[test]
fn area_and_volume_converge_with_the_density() {
    let torus = Torus {
        major: 8.0,
        minor: 2.0,
    };
    for target in [None, Some(torus.exact())] {
        let deviations = |density: f64| {
            let (mesh, topology) = mesh_of(&torus, density, target);
            assert_eq!(topology.genus, 1);
            errors(&mesh, torus.exact())
        };
        let (coarse, fine) = (deviations(1.0), deviations(16.0));
        assert!(fine.0 < 1e-3 && fine.1 < 1e-4, "{fine:?}");
        assert!(
            fine.0 <= coarse.0 && (target.is_some() || fine.1 <= coarse.1),
            "{coarse:?} {fine:?}"
        );
    }
}

#[test]
fn spindle_tori_have_cusps_and_are_closed_all_the_same() {
    for minor in [1.0001, 1.2, 2.0] {
        let (_, topology) = mesh_of(&Torus { major: 1.0, minor }, 4.0, None);
        assert_eq!(
            (topology.components - topology.cavities, topology.genus),
            (1, 0)
        );
    }
}

#[test]
fn a_cavity_is_meshed_and_can_be_dropped() {
    let shell = Shell {
        outer: 8.0,
        inner: 3.0,
    };
    let exact = Target {
        area_angstrom2: ball(8.0).area_angstrom2 + ball(3.0).area_angstrom2,
        volume_angstrom3: ball(8.0).volume_angstrom3 - ball(3.0).volume_angstrom3,
    };
    let (mesh, topology) = mesh_of(&shell, 1.0, Some(exact));
    assert_eq!(
        (topology.components, topology.cavities, topology.genus),
        (2, 1, 0)
    );
    let (area, volume) = errors(&mesh, exact);
    assert!(area < 0.01 && volume < 1e-6);
    let (outside, dropped) = without_cavities(&mesh).unwrap();
    assert_eq!((dropped, outside.topology().unwrap().components), (1, 1));
    assert!(errors(&outside, ball(8.0)).1 < 0.002);
}

#[test]
fn balls_just_apart_and_just_overlapping_are_both_valid() {
    for gap in [-0.5, -1e-3, -1e-12, 0.0, 1e-12, 1e-3, 0.5] {
        let solid = Balls::new(&[(0.0, 0.0, 0.0, 2.0), (4.0 + gap, 0.0, 0.0, 2.0)]);
        let (_, topology) = mesh_of(&solid, 1.0, None);
        // Where the gap is thinner than the lattice the two surfaces may be joined, even more than
        // once.
        let components = if gap < 0.0 { 1 } else { 2 };
        assert!(
            gap.abs() < 0.1 || (topology.components, topology.genus) == (components, 0),
            "{gap} {topology:?}"
        );
    }
}

#[test]
fn balls_far_apart_cost_no_more_than_their_own_size() {
    let solid = Balls::new(&[(-9e5, 0.0, 0.0, 2.0), (9e5, 3e5, 0.0, 2.0)]);
    assert_eq!(mesh_of(&solid, 1.0, None).1.components, 2);
}

#[test]
fn meshes_turn_with_the_body() {
    for cluster in [0, 3, 4, 6, 7] {
        let atoms = solids::random::cluster(cluster, 12);
        let place = |seed: u64| {
            let mut dice = solids::random::Dice(seed);
            let mut angle = || std::f64::consts::TAU * dice.unit();
            let turn = protomer_kernel::Rotation::from_euler_angles(angle(), angle(), angle());
            let shift = Vec3::new(angle(), -10.0 * angle(), 30.0);
            Balls(
                atoms
                    .iter()
                    .map(|&(x, y, z, r)| (turn * Vec3::new(x, y, z) + shift, r))
                    .collect(),
            )
        };
        let (first, topology) = mesh_of(&place(0), 1.0, None);
        for seed in 1..8 {
            let (mesh, turned) = mesh_of(&place(seed), 1.0, None);
            assert_eq!(turned, topology);
            assert_eq!(mesh.vertices.len(), first.vertices.len());
            assert!((mesh.area_angstrom2() / first.area_angstrom2() - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn nonsense_is_refused_with_a_remedy() {
    let solid = Balls::new(&[(0.0, 0.0, 0.0, 2.0)]);
    let default = MeshSettings::default();
    for density_per_angstrom2 in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let settings = MeshSettings {
            density_per_angstrom2,
            ..default
        };
        assert!(
            mesh_solid(&solid, &settings, None)
                .unwrap_err()
                .to_string()
                .contains("ask for a")
        );
    }
    for base_spacing_angstrom in [0.0, -0.5, f64::NAN, f64::INFINITY, 1e-9] {
        let settings = MeshSettings {
            base_spacing_angstrom,
            ..default
        };
        assert!(
            mesh_solid(&solid, &settings, None)
                .unwrap_err()
                .to_string()
                .contains("spacing")
        );
    }
    let settings = MeshSettings {
        fewest_vertices_per_shell: usize::MAX,
        ..default
    };
    assert!(mesh_solid(&solid, &settings, None).is_err());
    for empty in [
        Balls::new(&[]),
        Balls::new(&[(0.0, 0.0, 0.0, 1e-3), (1.0, 2.0, 0.5, 1e-3)]),
        Balls::new(&[(f64::NAN, 0.0, 0.0, 1.0)]),
    ] {
        assert!(mesh_solid(&empty, &default, None).is_err());
    }
}
