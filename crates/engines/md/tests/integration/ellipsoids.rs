//! Ellipses and ellipsoids: closest points against a slow search, forces against differences.

use protomer_kernel::bisection::halved;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Rotation, Vec3};
use protomer_md::body::Kind;
use protomer_md::near::{Felt, Hint, Law, Turned, felt};
use protomer_md::pair::Form;

fn feel(kinds: [&Kind; 2], poses: [&Pose; 2], hint: &mut Hint) -> Felt {
    let mut turned = Turned::from_kinds(kinds.into_iter());
    for (n, kind) in kinds.iter().enumerate() {
        match kind.dimension {
            2 => turned.turn_flat(n, kind, poses[n].rotation.scaled_axis().z),
            _ => turned.turn_solid(n, kind, &poses[n].rotation),
        }
    }
    let law = Law::between(
        &kinds[0].parts[0],
        &kinds[1].parts[0],
        &Form::Contact.into(),
    );
    let [first, second] = [0, 1].map(|n| turned.part(n, 0, kinds[n]));
    let between = poses[1].position - poses[0].position;
    felt(first, second, between, &law, Form::Contact, hint)
}

/// The point of an ellipsoid nearest to a point outside: x_k = a_k² p_k/(a_k² + t) with the root t of
/// Σ (a_k p_k/(a_k² + t))² = 1, by halving.
fn nearest(kind: &Kind, pose: &Pose, point: &Vec3) -> Vec3 {
    let Some(axes) = kind.parts[0].half_axes else {
        let way = point - pose.position;
        return pose.position + way * (kind.parts[0].radius / way.norm());
    };
    let own = pose.rotation.inverse() * (point - pose.position);
    let dimension = kind.dimension;
    let sum = |t: f64| {
        let share = |k: usize| (axes[k] * own[k] / (axes[k] * axes[k] + t)).powi(2);
        (0..dimension).map(share).sum::<f64>()
    };
    let ends = [0.0, kind.circumradius() * own.norm()];
    let low = halved(ends, 200, |t| sum(t) > 1.0)[0];
    let mut foot = Vec3::zeros();
    for k in 0..dimension {
        foot[k] = axes[k] * axes[k] * own[k] / (axes[k] * axes[k] + low);
    }
    pose.position + pose.rotation * foot
}

/// The distance of two ellipsoids by going to and fro between nearest points; slow and obvious. For a
/// point inside the sum does not reach one.
fn distance(kinds: [&Kind; 2], poses: [&Pose; 2]) -> f64 {
    let mut on_first = poses[0].position;
    let mut length = f64::INFINITY;
    for _ in 0..20_000 {
        let on_second = nearest(kinds[1], poses[1], &on_first);
        on_first = nearest(kinds[0], poses[0], &on_second);
        let shorter = (on_first - on_second).norm();
        if length - shorter < 1e-16 {
            return shorter;
        }
        length = shorter;
    }
    length
}

fn pose(rng: &mut CounterRng, reach: f64, is_flat: bool) -> Pose {
    let mut position = reach * rng.unit_vector();
    let mut rotation = rng.rotation();
    if is_flat {
        position.z = 0.0;
        position = reach * position.normalize();
        rotation = Rotation::from_scaled_axis(7.0 * rng.uniform() * Vec3::z());
    }
    Pose { position, rotation }
}

fn kinds(dimension: usize) -> [Kind; 3] {
    [
        Kind::ellipsoid(dimension, Vec3::new(0.5, 0.5, 1.0)).unwrap(),
        Kind::ellipsoid(dimension, Vec3::new(0.3, 0.8, 0.5)).unwrap(),
        Kind::ball(dimension, 0.4).unwrap(),
    ]
}

#[test]
fn the_energy_is_that_of_the_slow_distance_and_forces_are_its_gradient() {
    const STEP: f64 = 1e-6;
    for dimension in [2, 3] {
        let kinds = kinds(dimension);
        let mut rng = CounterRng::new(6, dimension as u32, 0);
        let (mut felt_count, mut touching) = (0, 0);
        for number in 0..3000 {
            let pair = [&kinds[number % 2], &kinds[number % 3]];
            let reach = pair[0].inradius() + pair[1].inradius();
            let most = pair[0].circumradius() + pair[1].circumradius();
            let place = reach + rng.uniform() * (most - reach) + 0.1;
            let poses = [
                pose(&mut rng, 0.0, dimension == 2),
                pose(&mut rng, place, dimension == 2),
            ];
            let poses = [
                Pose {
                    position: Vec3::zeros(),
                    ..poses[0]
                },
                poses[1],
            ];
            let found = feel(pair, [&poses[0], &poses[1]], &mut Hint::default());
            if found.energy.is_infinite() {
                touching += 1;
                continue;
            }
            if found.energy == 0.0 || found.energy > 1e4 {
                continue;
            }
            felt_count += 1;
            let sigma = 0.15 * reach;
            let slow = distance(pair, [&poses[0], &poses[1]]);
            let sixth = (sigma / slow).powi(6);
            let expected = (2.0 * sixth - 1.0).powi(2);
            let off = (found.energy - expected).abs() / (1.0 + expected);
            assert!(off < 1e-8, "{number} {} {expected}", found.energy);
            let energy = |first: Pose, second: Pose| {
                feel(pair, [&first, &second], &mut Hint::default()).energy
            };
            let size = 1.0 + found.force.norm();
            for axis in 0..dimension {
                let along = STEP * Vec3::ith(axis, 1.0);
                let moved = |sign: f64| Pose {
                    position: sign * along,
                    ..poses[0]
                };
                let slope =
                    (energy(moved(1.0), poses[1]) - energy(moved(-1.0), poses[1])) / (2.0 * STEP);
                assert!((found.force[axis] + slope).abs() < 1e-5 * size, "{number}");
            }
            for axis in if dimension == 2 { 2..3 } else { 0..3 } {
                let turned = |n: usize, sign: f64| Pose {
                    rotation: Rotation::from_scaled_axis(sign * STEP * Vec3::ith(axis, 1.0))
                        * poses[n].rotation,
                    ..poses[n]
                };
                let first = (energy(turned(0, 1.0), poses[1]) - energy(turned(0, -1.0), poses[1]))
                    / (2.0 * STEP);
                let second = (energy(poses[0], turned(1, 1.0)) - energy(poses[0], turned(1, -1.0)))
                    / (2.0 * STEP);
                assert!(
                    (found.torques[0][axis] + first).abs() < 1e-5 * size,
                    "{number}"
                );
                assert!(
                    (found.torques[1][axis] + second).abs() < 1e-5 * size,
                    "{number}"
                );
            }
            let lever = poses[1].position.cross(&-found.force);
            let sum = found.torques[0] + found.torques[1] + lever;
            assert!(sum.norm() < 1e-11 * size, "{number} {sum}");
        }
        assert!(
            felt_count > 150 && touching > 50,
            "{dimension}: {felt_count} {touching}"
        );
    }
}

/// Without a direction between the centres the bodies overlap all the same.
#[test]
fn bodies_with_one_centre_touch() {
    for dimension in [2, 3] {
        let kinds = kinds(dimension);
        for pair in [[&kinds[0], &kinds[1]], [&kinds[0], &kinds[2]]] {
            let middle = Pose::identity();
            let apart = Pose {
                position: Vec3::new(1.4, 0.0, 0.0),
                ..middle
            };
            let mut remembered = Hint::default();
            feel(pair, [&middle, &apart], &mut remembered);
            for mut hint in [Hint::default(), remembered] {
                let felt = feel(pair, [&middle, &middle], &mut hint);
                assert_eq!(felt, Felt::touching());
            }
        }
    }
}

#[test]
fn what_was_learnt_changes_nothing() {
    let kinds = kinds(3);
    let mut rng = CounterRng::new(7, 0, 0);
    let mut hint = Hint::default();
    let mut poses = [Pose::identity(), pose(&mut rng, 1.3, false)];
    let mut met = 0;
    for _ in 0..4000 {
        poses = poses.map(|pose| Pose {
            position: pose.position + 0.01 * rng.unit_vector(),
            rotation: rng.small_rotation(0.05) * pose.rotation,
        });
        let between = poses[1].position - poses[0].position;
        poses[1].position =
            poses[0].position + between * (between.norm().clamp(0.9, 1.25) / between.norm());
        let pair = [&kinds[0], &kinds[1]];
        let kept = feel(pair, [&poses[0], &poses[1]], &mut hint);
        let fresh = feel(pair, [&poses[0], &poses[1]], &mut Hint::default());
        assert_eq!(kept.energy.is_infinite(), fresh.energy.is_infinite());
        if kept.energy.is_finite() && kept.energy < 1e6 {
            let off =
                (kept.force - fresh.force).norm() + (kept.torques[0] - fresh.torques[0]).norm();
            assert!(
                off < 1e-10 * (1.0 + fresh.force.norm()),
                "{kept:?} {fresh:?}"
            );
            met += usize::from(fresh.energy > 0.0);
        }
    }
    assert!(met > 40, "{met}");
}
