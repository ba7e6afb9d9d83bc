//! Detailed balance on two bodies, whose averages are known by direct integration or in closed
//! form.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, Rotation, TriangleMesh, Vec3};
use protomer_mc::{BodyType, Interaction, Settings, System};
use std::f64::consts::PI;
use std::sync::Arc;

/// Second virial coefficient of a hard convex body, Å³: B2 = V + S R̄ (Isihara, J. Chem. Phys. 18,
/// 1446 (1950); Kihara, Rev. Mod. Phys. 25, 831 (1953)); for a polyhedron R̄ = Σ over edges of
/// length times exterior angle / 8π.
fn convex_second_virial(mesh: &TriangleMesh) -> f64 {
    let normals: Vec<Vec3> = (0..mesh.triangles.len())
        .map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            (b - a).cross(&(c - a)).normalize()
        })
        .collect();
    let mut mean_radius = 0.0;
    for (first, triangle) in mesh.triangles.iter().enumerate() {
        for (second, other) in mesh.triangles[..first].iter().enumerate() {
            let shared: Vec<u32> = triangle
                .iter()
                .filter(|corner| other.contains(corner))
                .copied()
                .collect();
            if let [a, b] = shared[..] {
                let length = (mesh.vertices[a as usize] - mesh.vertices[b as usize]).norm();
                mean_radius += length * normals[first].angle(&normals[second]) / (8.0 * PI);
            }
        }
    }
    mesh.volume_angstrom3() + mesh.area_angstrom2() * mean_radius
}

fn pair_of(types: [Arc<BodyType>; 2], boundary: Boundary, apart: f64) -> System {
    let pose = |x: f64| Pose {
        position: Vec3::new(x, 0.0, 0.0),
        rotation: Rotation::identity(),
    };
    System::new(
        types.to_vec(),
        &[(0, pose(-0.5 * apart)), (1, pose(0.5 * apart))],
        boundary,
    )
    .unwrap()
}

/// In a periodic box the second body's origin may be anywhere but in the excluded volume 2 B2, so
/// the time that the origins spend within reach of each other measures B2.
#[test]
fn hard_convex_bodies_have_the_second_virial_coefficient_of_kihara() {
    for (name, mesh) in [
        ("tetrahedron", chiral_tetrahedron()),
        ("icosphere", icosphere(6.0, 1)),
    ] {
        let kind = Arc::new(BodyType::new(name, &mesh, &[]).unwrap());
        let reach = 2.0 * mesh.radius_about_origin_angstrom();
        let lengths = Vec3::new(2.02 * reach, 2.1 * reach, 2.3 * reach);
        let boundary = Boundary::periodic(lengths).unwrap();
        let system = pair_of([kind.clone(), kind], boundary, reach);
        let inside_sphere = 4.0 / 3.0 * PI * reach.powi(3);
        let second_virial =
            |near: f64| (inside_sphere - near * lengths.product()) / (2.0 * (1.0 - near));
        for cluster_moves in [0, 2] {
            let settings = settings(Interaction::HardOnly, cluster_moves);
            let [near] = simulate(&system, settings, 8, 60_000, |state| {
                [f64::from(u8::from(distance(state.system()) < reach))]
            });
            let slope =
                (second_virial(near.mean + 1e-4) - second_virial(near.mean - 1e-4)).abs() / 2e-4;
            let measured = Estimate {
                mean: second_virial(near.mean),
                error: slope * near.error,
            };
            let exact = convex_second_virial(&mesh);
            let case = format!("B2 of the {name}, {cluster_moves} cluster moves");
            assert_agree(&case, measured, Estimate::exact(exact), 0.05 * exact);
        }
    }
}

#[test]
fn the_formula_for_convex_bodies_holds_for_spheres() {
    let (radius, level) = (5.0, 3);
    let sphere = 16.0 / 3.0 * PI * f64::powi(radius, 3);
    assert!((convex_second_virial(&icosphere(radius, level)) / sphere - 1.0).abs() < 0.02);
}

/// Central charges: beyond contact the distance is distributed as r² exp(-V(r)) exactly.
#[test]
fn central_charges_give_the_boltzmann_distribution_of_distances() {
    let mesh = icosphere(5.0, 0);
    let yukawa = Yukawa::new(7.0, 0.05, 25.0).unwrap();
    let kinds = [3.0, -3.0]
        .map(|charge| Arc::new(BodyType::new("ion", &mesh, &[(Vec3::zeros(), charge)]).unwrap()));
    let (contact, half) = (10.0, 30.0);
    let boundary = Boundary::periodic(Vec3::repeat(2.0 * half)).unwrap();
    let system = pair_of(kinds, boundary, 20.0);
    let inside = |r: f64| (contact..half).contains(&r);
    let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
        const POINTS: usize = 100_000;
        let width = (half - contact) / POINTS as f64;
        let middle = |k: usize| contact + (k as f64 + 0.5) * width;
        (0..POINTS)
            .map(|k| f(middle(k)) * middle(k).powi(2) * (9.0 * yukawa.energy_kt(middle(k))).exp())
            .sum()
    };
    let all = integral(&|_| 1.0);
    for cluster_moves in [0, 2] {
        let settings = settings(Interaction::YukawaDirect(yukawa), cluster_moves);
        let [within, first, near] = simulate(&system, settings, 8, 60_000, |state| {
            let r = distance(state.system());
            let within = f64::from(u8::from(inside(r)));
            [within, within * r, within * f64::from(u8::from(r < 14.0))]
        });
        let scaled = |sum: Estimate| Estimate {
            mean: sum.mean / within.mean,
            error: sum.error / within.mean,
        };
        let mean_distance = Estimate::exact(integral(&|r| r) / all);
        let name = format!("{cluster_moves} cluster moves");
        // The errors of numerator and denominator add up, so this is generous by at most a factor
        // of two.
        assert_agree(&format!("<r>, {name}"), scaled(first), mean_distance, 0.4);
        let near_share = Estimate::exact(integral(&|r| f64::from(u8::from(r < 14.0))) / all);
        assert_agree(
            &format!("P(r < 14 Å), {name}"),
            scaled(near),
            near_share,
            0.02,
        );
    }
}

/// Nonconvex bodies without symmetry, charges off centre, a box that is no cube, and a spherical
/// wall.
#[test]
fn charged_nonconvex_bodies_agree_with_direct_integration() {
    let mesh = chiral_bump(7.0);
    let sites = |sign: f64| {
        [
            (2.0, -0.7, 1.0, 2.2),
            (-1.5, 1.5, -0.7, -0.6),
            (0.0, -1.5, -1.5, 1.4),
            (-0.7, 0.7, 1.5, 0.4),
        ]
        .map(|(x, y, z, charge)| (Vec3::new(x, y, z), sign * charge))
    };
    let kinds =
        [1.0, -1.0].map(|sign| Arc::new(BodyType::new("bump", &mesh, &sites(sign)).unwrap()));
    let yukawa = Yukawa::new(7.0, 0.08, 14.0).unwrap();
    let reach = 2.0
        * mesh
            .radius_about_origin_angstrom()
            .max(kinds[0].charge_radius_angstrom() + 7.0);
    let boundaries = [
        Boundary::periodic(Vec3::new(2.05 * reach, 2.2 * reach, 2.6 * reach)).unwrap(),
        Boundary::SphereWall {
            radius_angstrom: reach,
        },
    ];
    for boundary in boundaries {
        let near = |system: &System| f64::from(u8::from(distance(system) < 14.0));
        let expected = integrate(&kinds, boundary, Some(yukawa), 400_000, |system, energy| {
            [energy, distance(system), near(system)]
        });
        for cluster_moves in [0, 2] {
            let settings = Settings {
                rotation_fraction: 0.6,
                ..settings(Interaction::YukawaDirect(yukawa), cluster_moves)
            };
            let system = pair_of(kinds.clone(), boundary, 0.9 * reach);
            let measured = simulate(&system, settings, 8, 60_000, |state| {
                let energy = state
                    .pair_energies()
                    .iter()
                    .map(|pair| pair.energy_kt)
                    .sum();
                [energy, distance(state.system()), near(state.system())]
            });
            for (quantity, largest_error, k) in
                [("energy", 0.05, 0), ("distance", 0.3, 1), ("near", 0.02, 2)]
            {
                let name = format!("{quantity}, {cluster_moves} cluster moves, {boundary:?}");
                assert_agree(&name, measured[k], expected[k], largest_error);
            }
        }
    }
}
