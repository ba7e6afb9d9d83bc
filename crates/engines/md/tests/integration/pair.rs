//! Energies, forces and torques of two bodies: gradients, symmetry, and what happens where features
//! change.

use crate::common::{FORMS, polytope as body};
use protomer_kernel::random::CounterRng;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Pose, Rotation, Vec3};
use protomer_md::Error;
use protomer_md::pair::{Form, PairForces, Placed};

fn forces(body: &Polytope, poses: [&Pose; 2], form: Form) -> Option<PairForces> {
    Placed::sharp([body, body], poses).forces(form).ok()
}

/// Axes along which a body moves and turns.
fn axes(dimension: usize) -> (Vec<Vec3>, Vec<Vec3>) {
    match dimension {
        2 => (vec![Vec3::x(), Vec3::y()], vec![Vec3::z()]),
        _ => {
            let all = vec![Vec3::x(), Vec3::y(), Vec3::z()];
            (all.clone(), all)
        }
    }
}

/// The pose moved by a step along and turned by an angle about an axis in space.
fn moved(pose: &Pose, along: Vec3, turn: Vec3) -> Pose {
    Pose {
        position: pose.position + along,
        rotation: Rotation::from_scaled_axis(turn) * pose.rotation,
    }
}

/// The largest difference between forces and torques, and the energy's differences, over the size of
/// the forces; `None` where the bodies overlap or do not feel each other.
fn error_of_gradient(body: &Polytope, poses: [Pose; 2], form: Form) -> Option<f64> {
    const STEP: f64 = 1e-6;
    let centre = forces(body, [&poses[0], &poses[1]], form)?;
    if centre.energy == 0.0 || centre.energy > 1e3 {
        return None;
    }
    let energy = |first: Pose, second: Pose| Some(forces(body, [&first, &second], form)?.energy);
    let (along, about) = axes(body.dimension);
    let zero = Vec3::zeros();
    let size = centre.force.norm() + 1.0;
    let mut worst = 0.0_f64;
    let mut compare = |found: f64, up: f64, down: f64| {
        worst = worst.max((found + (up - down) / (2.0 * STEP)).abs() / size);
    };
    for axis in along {
        let step = |sign: f64| moved(&poses[0], sign * STEP * axis, zero);
        let [up, down] = [1.0, -1.0].map(|sign| energy(step(sign), poses[1]));
        compare(centre.force.dot(&axis), up?, down?);
    }
    for axis in about {
        let turn = |pose: &Pose, sign: f64| moved(pose, zero, sign * STEP * axis);
        let [up, down] = [1.0, -1.0].map(|sign| energy(turn(&poses[0], sign), poses[1]));
        compare(centre.torques[0].dot(&axis), up?, down?);
        let [up, down] = [1.0, -1.0].map(|sign| energy(poses[0], turn(&poses[1], sign)));
        compare(centre.torques[1].dot(&axis), up?, down?);
    }
    Some(worst)
}

/// A pose at which the bodies nearly touch.
fn near(rng: &mut CounterRng, body: &Polytope) -> [Pose; 2] {
    let is_flat = body.dimension == 2;
    let rotation = |rng: &mut CounterRng| match is_flat {
        true => Rotation::from_scaled_axis(7.0 * rng.uniform() * Vec3::z()),
        false => rng.rotation(),
    };
    let first = Pose {
        position: Vec3::zeros(),
        rotation: rotation(rng),
    };
    let mut direction = rng.unit_vector();
    if is_flat {
        direction.z = 0.0;
        direction.normalize_mut();
    }
    let second = rotation(rng);
    let reach = 2.0 * (body.inradius() + rng.uniform() * (body.circumradius() - body.inradius()));
    let place = |distance: f64| Pose {
        position: distance * direction,
        rotation: second,
    };
    [first, place(reach + 0.15 * body.inradius())]
}

#[test]
fn forces_and_torques_are_the_gradient() {
    let mut rng = CounterRng::new(4, 0, 0);
    for name in [
        "polygon:3",
        "polygon:4",
        "polygon:6",
        "cube",
        "octahedron",
        "prism:5,0.6",
    ] {
        let body = body(name);
        let mut compared = [0; 3];
        for _ in 0..2000 {
            let poses = near(&mut rng, &body);
            for (form, count) in FORMS.iter().zip(&mut compared) {
                if let Some(error) = error_of_gradient(&body, poses, *form) {
                    assert!(error < 1e-5, "{name} {form:?} {error} {poses:?}");
                    *count += 1;
                }
            }
        }
        assert!(
            compared.iter().all(|count| *count > 30),
            "{name} {compared:?}"
        );
    }
}

/// Parallel faces and edges, and the places where a face gives way to the next.
fn special_poses(dimension: usize) -> Vec<[Pose; 2]> {
    let mut poses = Vec::new();
    let first = Pose::identity();
    for turn in [0.0, 0.25, 0.5] {
        for [x, y] in [[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.97, 0.0]] {
            let turn = turn * std::f64::consts::PI;
            let (position, rotation) = match dimension {
                2 => (Vec3::new(1.13, x, 0.0), Vec3::zeros()),
                _ => (Vec3::new(x, y, 1.13), turn * Vec3::z()),
            };
            let rotation = Rotation::from_scaled_axis(rotation);
            poses.push([first, Pose { position, rotation }]);
        }
    }
    poses
}

/// A body whose faces stand along the axes.
fn aligned(dimension: usize) -> Polytope {
    use protomer_kernel::shape::Shape;
    match dimension {
        2 => {
            let square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
            Polytope::from_shape(&Shape::flat(&square).unwrap()).unwrap()
        }
        _ => body("cube"),
    }
}

#[test]
fn the_smooth_sum_has_its_gradient_through_parallel_faces_and_edges() {
    for dimension in [2, 3] {
        let body = aligned(dimension);
        for poses in special_poses(dimension) {
            let error = error_of_gradient(&body, poses, Form::Smooth).unwrap();
            assert!(error < 1e-4, "{dimension} {error} {poses:?}");
        }
    }
}

#[test]
fn torques_jump_at_parallel_faces_but_for_the_smooth_sum() {
    let turned = |angle: f64| Pose {
        position: Vec3::new(1.14, 0.0, 0.0),
        rotation: Rotation::from_scaled_axis(angle * Vec3::z()),
    };
    let jump = |dimension: usize, form: Form| {
        let body = aligned(dimension);
        let torque = |angle: f64| {
            let poses = [&Pose::identity(), &turned(angle)];
            forces(&body, poses, form).unwrap().torques[1].z
        };
        (torque(1e-7) - torque(-1e-7)).abs()
    };
    assert!(jump(2, Form::Contact) > 500.0 && jump(3, Form::Contact) > 500.0);
    assert!(jump(2, Form::FaceSum) < 0.1 && jump(3, Form::FaceSum) > 500.0);
    assert!(jump(2, Form::Smooth) < 0.1 && jump(3, Form::Smooth) < 0.1);
}

#[test]
fn torques_of_the_smooth_sum_are_continuous_where_edges_become_parallel_from_any_side() {
    // A small tilt may bring the closest points of two nearly parallel edges anywhere along them.
    let cube = body("cube");
    let mut rng = CounterRng::new(12, 0, 0);
    for _ in 0..40 {
        let place = Vec3::new(1.13, 0.1 * rng.uniform() - 0.05, 0.5 * rng.uniform());
        let torque = |turn: Vec3| {
            let second = Pose {
                position: place,
                rotation: Rotation::from_scaled_axis(turn),
            };
            let poses = [&Pose::identity(), &second];
            forces(&cube, poses, Form::Smooth).unwrap().torques[0]
        };
        let parallel = torque(Vec3::zeros());
        for _ in 0..20 {
            let axis = rng.unit_vector();
            let size = 1.0 + parallel.norm();
            // What is continuous, and has a slope, changes a hundred times less.
            let jumps = [1e-4, 1e-6].map(|tilt| (torque(tilt * axis) - parallel).norm() / size);
            assert!(jumps[1] < 0.1 * jumps[0] + 1e-6, "{place} {axis} {jumps:?}");
        }
    }
}

#[test]
fn squares_count_four_corners_in_both_sums() {
    let square = aligned(2);
    let second = Pose {
        position: Vec3::new(1.15, 0.0, 0.0),
        ..Pose::identity()
    };
    for form in [Form::FaceSum, Form::Smooth] {
        let found = forces(&square, [&Pose::identity(), &second], form).unwrap();
        assert!((found.energy - 4.0).abs() < 1e-9, "{form:?}");
    }
}

#[test]
fn momentum_is_kept_to_the_last_bit_and_angular_momentum_to_rounding() {
    let mut rng = CounterRng::new(9, 0, 0);
    let octahedron = body("octahedron");
    let mut seen = 0;
    for _ in 0..300 {
        let [first, second] = near(&mut rng, &octahedron);
        for form in FORMS {
            let Some(found) = forces(&octahedron, [&first, &second], form) else {
                continue;
            };
            let lever = second.position - first.position;
            let sum = found.torques[0] + found.torques[1] + lever.cross(&-found.force);
            assert!(
                sum.norm() <= 1e-12 * (1.0 + found.force.norm()),
                "{form:?} {sum}"
            );
            seen += usize::from(found.energy > 0.0);
        }
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn overlaps_and_mixed_dimensions_are_refused_and_far_bodies_feel_nothing() {
    let (cube, square) = (body("cube"), body("polygon:4"));
    let (near, far) = (
        Pose::identity(),
        moved(&Pose::identity(), 3.0 * Vec3::x(), Vec3::zeros()),
    );
    let pair = Placed::sharp;
    let overlap = pair([&cube, &cube], [&near, &near]).forces(Form::Smooth);
    assert_eq!(overlap, Err(Error::Overlap));
    let mixed = pair([&cube, &square], [&near, &far]).forces(Form::Contact);
    assert_eq!(mixed, Err(Error::MixedDimensions));
    let apart = pair([&cube, &cube], [&near, &far])
        .forces(Form::FaceSum)
        .unwrap();
    assert_eq!((apart.energy, apart.force), (0.0, Vec3::zeros()));
    assert!((apart.distance - 2.0).abs() < 1e-12);
}
