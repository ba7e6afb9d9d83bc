//! Overlap against the slow obvious oracle and against an independent library.

use crate::overlap_support::*;
use protomer_kernel::overlap::{CarriedBound, comes_within, distance, overlaps, separation_bound};
use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
use rand::RngExt;

/// Signed perturbation of a contact: log-uniform between `smallest` and 1 Å.
fn perturbation(random: &mut impl rand::Rng, smallest: f64) -> f64 {
    let size = 10_f64.powf(random.random_range(smallest.log10()..0.0));
    if random.random_bool(0.5) { size } else { -size }
}

fn shapes_of(meshes: &[TriangleMesh]) -> Vec<CollisionShape> {
    meshes
        .iter()
        .map(|mesh| CollisionShape::new(mesh).unwrap())
        .collect()
}

/// Visits `poses` poses of random pairs: one in ten anywhere, one at contact, eight at a contact
/// perturbed by `smallest` to 1 Å.
fn near_contacts(
    shapes: &[CollisionShape],
    poses: usize,
    seed: u64,
    smallest: f64,
    mut visit: impl FnMut(usize, usize, &RelativePose),
) {
    let mut random = generator(seed);
    for _ in 0..poses.div_ceil(10) {
        let (i, j) = (
            random.random_range(0..shapes.len()),
            random.random_range(0..shapes.len()),
        );
        let reach = shapes[i].bounding_radius_angstrom() + shapes[j].bounding_radius_angstrom();
        let distance = random.random_range(0.1..reach);
        let anywhere = random_pose(&mut random, distance);
        let contact = brought_to_contact(&anywhere, |pose| overlaps(&shapes[i], &shapes[j], pose));
        visit(i, j, &anywhere);
        visit(i, j, &contact);
        (0..8).for_each(|_| visit(i, j, &pushed(&contact, perturbation(&mut random, smallest))));
    }
}

fn compare_with_brute_force(meshes: &[TriangleMesh], poses: usize, seed: u64) {
    let shapes = shapes_of(meshes);
    let mut overlapping = 0;
    near_contacts(&shapes, poses, seed, 1e-9, |i, j, pose| {
        let fast = overlaps(&shapes[i], &shapes[j], pose);
        if fast != brute_force_overlaps(&meshes[i], &meshes[j], pose) {
            // The oracle rounds: it may err within 1e-12 Å of contact, where both must be right on
            // either side, and where every pair of triangles, decided exactly, has the last word.
            assert_eq!(
                fast,
                distance(&shapes[i], &shapes[j], pose) == 0.0,
                "meshes {i} {j}, {pose:?}"
            );
            assert!(
                brute_force_overlaps(&meshes[i], &meshes[j], &pushed(pose, -1e-12)),
                "meshes {i} {j}, {pose:?}"
            );
            assert!(
                !brute_force_overlaps(&meshes[i], &meshes[j], &pushed(pose, 1e-12)),
                "meshes {i} {j}, {pose:?}"
            );
        }
        assert_eq!(
            fast,
            separation_bound(&shapes[i], &shapes[j], pose, 2.0).is_none()
        );
        overlapping += usize::from(fast);
    });
    assert!(
        overlapping * 5 > poses && overlapping * 5 < poses * 4,
        "{overlapping} of {poses} overlap"
    );
}

#[test]
fn agrees_with_brute_force_on_small_meshes() {
    let meshes: Vec<TriangleMesh> = (0..6).map(|seed| bumpy_mesh(2, seed)).collect();
    compare_with_brute_force(&meshes, 10_000, 1);
}

#[test]
#[ignore = "slow: run by name (10 to 60 s)"]
fn agrees_with_brute_force_on_a_hundred_thousand_poses() {
    let meshes: Vec<TriangleMesh> = (0..8).map(|seed| bumpy_mesh(2, seed + 100)).collect();
    compare_with_brute_force(&meshes, 100_000, 2);
}

#[test]
fn agrees_with_brute_force_on_large_and_mixed_meshes() {
    // Up to 2048 triangles, and trees of different depth in one query.
    let mut meshes: Vec<TriangleMesh> = (0..4)
        .map(|level| bumpy_mesh(level, level as u64 + 10))
        .collect();
    meshes.push(bumpy_mesh(4, 14));
    meshes.push(bumpy_mesh(3, 15).map_vertices(|v| v * 0.2));
    compare_with_brute_force(&meshes, 300, 3);
}

#[test]
fn agrees_with_an_independent_library_on_surface_intersection() {
    let meshes: Vec<TriangleMesh> = (0..4).map(|seed| bumpy_mesh(2, seed + 20)).collect();
    let (shapes, others) = (
        shapes_of(&meshes),
        meshes.iter().map(parry_mesh).collect::<Vec<_>>(),
    );
    // The library takes surfaces nearer than about 1e-9 Å for intersecting and rounds rotations
    // differently.
    near_contacts(&shapes, 3000, 4, 1e-6, |i, j, pose| {
        let fast = overlaps(&shapes[i], &shapes[j], pose);
        let surfaces = parry_intersects(&others[i], &others[j], pose);
        let moved = || meshes[j].map_vertices(|vertex| pose.transform_point(vertex));
        if fast != surfaces {
            // Permitted where one body is inside the other, or at the very contact.
            let nested = fast && !surfaces_intersect(&meshes[i], &moved());
            let touching = surfaces && !fast && distance(&shapes[i], &shapes[j], pose) < 1e-8;
            assert!(nested || touching, "meshes {i} {j}, {pose:?}");
        }
    });
}

#[test]
fn the_distance_is_that_of_an_independent_library() {
    let meshes: Vec<TriangleMesh> = (0..4).map(|seed| bumpy_mesh(1, seed + 30)).collect();
    let shapes = shapes_of(&meshes);
    let mut random = generator(5);
    for _ in 0..60 {
        let (i, j) = (random.random_range(0..4), random.random_range(0..4));
        let pose = random_pose(&mut random, 32.0);
        let (first, second) = (parry_mesh(&meshes[i]), parry_mesh(&meshes[j]));
        let origin = parry3d_f64::math::Pose::IDENTITY;
        let theirs = parry3d_f64::query::distance(&origin, &first, &parry_pose(&pose), &second)
            .unwrap()
            .distance;
        let ours = distance(&shapes[i], &shapes[j], &pose);
        assert!((ours - theirs).abs() < 1e-6, "{ours} {theirs}");
    }
}

#[test]
fn nearness_is_that_of_all_pairs_of_triangles() {
    // Coarse and fine meshes, and one whose faces are far wider than the gap.
    let mut meshes: Vec<TriangleMesh> = (0..4).map(|level| bumpy_mesh(level, 60)).collect();
    meshes.push(star_mesh(0, |_| 20.0));
    let shapes = shapes_of(&meshes);
    let mut random = generator(8);
    let (mut near, cases) = (0, 200);
    for _ in 0..cases {
        let (i, j) = (random.random_range(0..5), random.random_range(0..5));
        let pose = random_pose(&mut random, 30.0);
        let contact = brought_to_contact(&pose, |pose| overlaps(&shapes[i], &shapes[j], pose));
        let pose = pushed(&contact, random.random_range(-1.0..6.0));
        let is_overlap = overlaps(&shapes[i], &shapes[j], &pose);
        let truth = distance(&shapes[i], &shapes[j], &pose);
        let within = |gap| comes_within(&shapes[i], &shapes[j], &pose, gap);
        for gap in [0.0, 1.0, 3.0, 5.0, 100.0] {
            assert_eq!(within(gap), is_overlap || truth < gap, "{truth} {gap}");
        }
        if !is_overlap {
            assert!(within(truth + 1e-9) && !within(truth - 1e-9), "{truth}");
        }
        near += usize::from(within(3.0));
    }
    assert!((40..160).contains(&near), "{near} of {cases}");
}

#[test]
fn a_body_inside_another_is_near_it_and_one_in_a_cavity_only_by_its_surface() {
    let sphere = |radius: f64| star_mesh(3, move |_| radius);
    let inner = CollisionShape::new(&sphere(2.0)).unwrap();
    let solid = CollisionShape::new(&sphere(20.0)).unwrap();
    let pose = RelativePose::new(&Pose::identity(), &Pose::identity(), &Vec3::zeros());
    assert!(comes_within(&solid, &inner, &pose, 1.0));
    assert!(comes_within(&inner, &solid, &pose, 1.0));
    // A shell of 10 Å about the inner body, which lies free within it.
    let mut hollow = sphere(20.0);
    let cavity = sphere(12.0);
    let offset = hollow.vertices.len() as u32;
    let inwards = |[a, b, c]: &[u32; 3]| [a + offset, c + offset, b + offset];
    hollow
        .triangles
        .extend(cavity.triangles.iter().map(inwards));
    hollow.vertices.extend(&cavity.vertices);
    let hollow = CollisionShape::new(&hollow).unwrap();
    let gap = distance(&hollow, &inner, &pose);
    assert!((9.5..10.0).contains(&gap), "{gap}");
    assert!(!comes_within(&hollow, &inner, &pose, gap - 0.01));
    assert!(comes_within(&hollow, &inner, &pose, gap + 0.01));
}

#[test]
fn the_least_radius_is_that_of_faces_and_not_of_corners() {
    let octahedron = CollisionShape::new(&star_mesh(0, |_| 3.0)).unwrap();
    assert!((octahedron.least_radius_angstrom() - 3.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_separation_bound_never_exceeds_the_distance() {
    let meshes: Vec<TriangleMesh> = (0..4).map(|seed| bumpy_mesh(2, seed + 40)).collect();
    let shapes = shapes_of(&meshes);
    let mut random = generator(6);
    let (mut bounds, mut truths) = (0.0, 0.0);
    for _ in 0..150 {
        let (i, j) = (random.random_range(0..4), random.random_range(0..4));
        let pose = random_pose(&mut random, 30.0);
        let contact = brought_to_contact(&pose, |pose| overlaps(&shapes[i], &shapes[j], pose));
        let gap = 10_f64.powf(random.random_range(-9.0..1.2));
        let pose = pushed(&contact, gap);
        let truth = distance(&shapes[i], &shapes[j], &pose);
        for ceiling in [0.0, 0.3, 1.0, 5.0, 100.0] {
            let bound = separation_bound(&shapes[i], &shapes[j], &pose, ceiling).unwrap();
            assert!(
                (0.0..=ceiling).contains(&bound) && bound <= truth,
                "{bound} {truth} {ceiling}"
            );
            if ceiling == 5.0 && truth > 0.5 {
                bounds += bound;
                truths += truth.min(5.0);
            }
        }
    }
    assert!(
        bounds > 0.25 * truths,
        "on average only {} of the distance",
        bounds / truths
    );
}

#[test]
fn a_carried_bound_outlives_only_motions_that_cannot_overlap() {
    let shape = CollisionShape::new(&bumpy_mesh(2, 50)).unwrap();
    let radius = shape.bounding_radius_angstrom();
    let mut random = generator(7);
    let mut kept = 0;
    for _ in 0..2000 {
        let place =
            |random: &mut _, position: Vec3| Pose::from_wxyz(position, random_orientation(random));
        let first = place(&mut random, Vec3::zeros());
        let direction = random_direction(&mut random);
        let apart = random.random_range(22.0..40.0);
        let second = place(&mut random, direction * apart);
        let relative = RelativePose::new(&first, &second, &second.position);
        let Some(bound) = separation_bound(&shape, &shape, &relative, 4.0) else {
            continue;
        };
        let carried = CarriedBound::new(bound, &first, &second, &second.position);
        let mut jiggled = |pose: &Pose, sign: f64| {
            let (turn, step) = (
                random_direction(&mut random) * 0.03,
                random_direction(&mut random) * 0.2,
            );
            let [w, x, y, z] = pose.wxyz();
            Pose::from_wxyz(
                pose.position + step,
                [w, x + turn.x, y + turn.y, z + turn.z].map(|q| q * sign),
            )
        };
        let (first, second) = (jiggled(&first, 1.0), jiggled(&second, -1.0));
        let displacement = second.position - first.position;
        let remaining = carried.remaining_angstrom(&first, &second, &displacement, [radius; 2]);
        if remaining > 0.0 {
            kept += 1;
            let relative = RelativePose::new(&first, &second, &displacement);
            assert!(!overlaps(&shape, &shape, &relative));
            assert!(remaining <= distance(&shape, &shape, &relative));
        }
    }
    assert!(kept > 50, "{kept}");
    let unknown = CarriedBound::unknown();
    let pose = Pose::identity();
    assert!(unknown.remaining_angstrom(&pose, &pose, &Vec3::zeros(), [1.0; 2]) < 0.0);
}

/// A box with two triangles to each face, turned inside out for a cavity.
fn block(low: Vec3, high: Vec3, inside_out: bool) -> TriangleMesh {
    let mut mesh = TriangleMesh::cuboid(&low, &high);
    if inside_out {
        for [a, b, _] in &mut mesh.triangles {
            std::mem::swap(a, b);
        }
    }
    mesh
}

fn cube(half: f64) -> TriangleMesh {
    block(Vec3::repeat(-half), Vec3::repeat(half), false)
}

fn union(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let offset = first.vertices.len() as u32;
    let shifted = second.triangles.iter().map(|t| t.map(|v| v + offset));
    TriangleMesh {
        vertices: first
            .vertices
            .iter()
            .chain(&second.vertices)
            .copied()
            .collect(),
        triangles: first.triangles.iter().copied().chain(shifted).collect(),
    }
}

fn moved_by(x: f64, y: f64, z: f64) -> RelativePose {
    RelativePose {
        rotation: nalgebra::Matrix3::identity(),
        translation: Vec3::new(x, y, z),
    }
}

#[track_caller]
fn expect(first: &TriangleMesh, second: &TriangleMesh, pose: RelativePose, expected: bool) {
    let (a, b) = (
        CollisionShape::new(first).unwrap(),
        CollisionShape::new(second).unwrap(),
    );
    assert_eq!(overlaps(&a, &b, &pose), expected);
    assert_eq!(
        overlaps(&b, &a, &pose.inverse()),
        expected,
        "with the bodies exchanged"
    );
    assert_eq!(separation_bound(&a, &b, &pose, 1.0).is_none(), expected);
}

#[test]
fn touching_is_overlap() {
    let unit = cube(1.0);
    expect(&unit, &unit, moved_by(0.0, 0.0, 0.0), true); // identical
    expect(&unit, &unit, moved_by(2.0, 0.0, 0.0), true); // face on face
    expect(&unit, &unit, moved_by(2.0, 0.5, 0.3), true); // part of a face
    expect(&unit, &unit, moved_by(2.0, 2.0, 0.3), true); // edge on edge
    expect(&unit, &unit, moved_by(2.0, 2.0, 2.0), true); // corner on corner
    let gap = 4.0 * f64::EPSILON;
    expect(&unit, &unit, moved_by(2.0 + gap, 0.0, 0.0), false);
    expect(&unit, &unit, moved_by(2.0 + gap, 2.0, 0.3), false);
    expect(&unit, &unit, moved_by(2.0 + gap, 2.0, 2.0), false);
    expect(&unit, &cube(0.25), moved_by(1.25, 0.1, 0.1), true); // a small face inside a large triangle's plane
    expect(&unit, &cube(0.25), moved_by(0.75, 0.1, 0.1), true); // the same from within
    expect(&unit, &cube(0.25), moved_by(1.25 + gap, 0.1, 0.1), false);
    let bumpy = bumpy_mesh(3, 60);
    expect(&bumpy, &bumpy, moved_by(0.0, 0.0, 0.0), true);
}

#[test]
fn one_inside_the_other_is_overlap_unless_in_a_cavity() {
    let (large, small) = (cube(10.0), cube(1.0));
    expect(&large, &small, moved_by(3.0, -2.0, 1.0), true);
    let hollow = union(&large, &block(Vec3::repeat(-4.0), Vec3::repeat(4.0), true));
    expect(&hollow, &small, moved_by(0.0, 0.0, 0.0), false); // in the cavity
    expect(&hollow, &small, moved_by(1.5, -2.0, 2.5), false);
    expect(&hollow, &small, moved_by(3.5, 0.0, 0.0), true); // in its wall
    expect(&hollow, &small, moved_by(7.0, 0.0, 0.0), true); // in the flesh
    expect(&hollow, &cube(5.0), moved_by(0.0, 0.0, 0.0), true); // around the cavity
    expect(&hollow, &small, moved_by(30.0, 0.0, 0.0), false);
    let filled = union(&hollow, &small); // a loose piece in the cavity, of one body
    expect(&filled, &cube(2.0), moved_by(0.0, 0.0, 0.0), true); // around the piece
    expect(&filled, &cube(0.5), moved_by(0.0, 0.0, 0.0), true); // in the piece
    expect(&filled, &cube(0.5), moved_by(2.5, 0.0, 0.0), false); // next to it
    let far_piece = union(
        &small,
        &block(
            Vec3::new(20.0, -1.0, -1.0),
            Vec3::new(22.0, 1.0, 1.0),
            false,
        ),
    );
    expect(&far_piece, &cube(0.5), moved_by(21.0, 0.0, 0.0), true);
    expect(&far_piece, &cube(0.5), moved_by(10.0, 0.0, 0.0), false);
}

#[test]
fn points_inside_are_those_the_surface_winds_around() {
    let mesh = union(
        &bumpy_mesh(3, 70),
        &bumpy_mesh(2, 71).map_vertices(|v| v * 0.2 + Vec3::new(40.0, 0.0, 0.0)),
    );
    let shape = CollisionShape::new(&mesh).unwrap();
    let mut random = generator(8);
    let mut inside = 0;
    for _ in 0..2000 {
        let reach = if random.random_bool(0.2) { 45.0 } else { 15.0 };
        let point = Vec3::from_fn(|_, _| random.random_range(-reach..reach));
        let wound = winding_number(&mesh, &point).round() != 0.0;
        assert_eq!(shape.contains_point(&point), wound, "{point}");
        inside += usize::from(wound);
    }
    assert!((300..1700).contains(&inside), "{inside}");
    let block = CollisionShape::new(&cube(1.0)).unwrap();
    for (point, expected) in [
        (Vec3::zeros(), true),
        (Vec3::new(1.0, 0.0, 0.0), true),
        (Vec3::repeat(1.0), true),
        (Vec3::new(1.0 + 1e-15, 0.3, 0.2), false),
    ] {
        assert_eq!(block.contains_point(&point), expected, "{point}");
    }
}

#[test]
fn meshes_that_bound_no_solid_are_refused() {
    assert!(CollisionShape::new(&TriangleMesh::default()).is_err());
    let mut open = cube(1.0);
    open.triangles.pop();
    assert!(CollisionShape::new(&open).is_err());
    assert!(CollisionShape::new(&block(Vec3::zeros(), Vec3::repeat(1.0), true)).is_err());
    let shape = CollisionShape::new(&cube(1.0)).unwrap();
    assert!((shape.bounding_radius_angstrom() - 3_f64.sqrt()).abs() < 1e-15);
    assert!(shape.memory_bytes() > 12 * 12 && shape.mesh() == &cube(1.0));
}
