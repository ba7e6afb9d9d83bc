//! Fast forces against the plain ones, on random pairs and along paths.

use crate::common::{FORMS, attractive, kind, polytope};
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Rotation, Vec3};
use protomer_md::body::Kind;
use protomer_md::near::{Felt, Hint, Law, Turned, felt};
use protomer_md::pair::central::Central;
use protomer_md::pair::{Form, Interaction, Placed};

fn fast(
    kinds: [&Kind; 2],
    poses: [&Pose; 2],
    interaction: impl Into<Interaction>,
    hint: &mut Hint,
) -> Felt {
    let interaction = interaction.into();
    let mut turned = Turned::from_kinds(kinds.into_iter());
    let law = Law::between(&kinds[0].parts[0], &kinds[1].parts[0], &interaction);
    for body in 0..2 {
        let rotation = poses[body].rotation;
        match kinds[body].dimension {
            2 => turned.turn_flat(body, kinds[body], rotation.scaled_axis().z),
            _ => turned.turn_solid(body, kinds[body], &rotation),
        }
    }
    let [first, second] = [0, 1].map(|body| turned.part(body, 0, kinds[body]));
    let between = poses[1].position - poses[0].position;
    felt(first, second, between, &law, interaction.form, hint)
}

/// The same pair for the plain sum.
fn plain<'a>(kinds: [&'a Kind; 2], poses: [&'a Pose; 2]) -> Placed<'a> {
    Placed {
        bodies: kinds.map(|kind| &kind.parts[0].polytope),
        radii: kinds.map(|kind| kind.parts[0].radius),
        poses,
    }
}

/// The pose moved and turned a little.
fn moved(pose: &Pose, rng: &mut CounterRng, is_flat: bool) -> Pose {
    let mut along = 0.004 * rng.unit_vector();
    let mut turn = 0.01 * rng.unit_vector();
    if is_flat {
        along.z = 0.0;
        turn = turn.z * Vec3::z();
    }
    Pose {
        position: pose.position + along,
        // Thousands of products would leave the unit length, and two ways to turn would differ.
        rotation: Rotation::new_normalize(
            (Rotation::from_scaled_axis(turn) * pose.rotation).into_inner(),
        ),
    }
}

/// Walks two bodies past each other, and compares at every step; counts the steps at which they
/// felt each other, and those at which they overlapped.
fn compare(
    kinds: [&Kind; 2],
    interaction: impl Into<Interaction>,
    steps: usize,
    seed: u64,
) -> [usize; 2] {
    let interaction = interaction.into();
    let form = interaction.form;
    let mut rng = CounterRng::new(seed, 0, 0);
    let is_flat = kinds[0].dimension == 2;
    let mut hint = Hint::default();
    let mut poses = [Pose::identity(); 2];
    poses[1].position.x = kinds[0].circumradius() + kinds[1].circumradius() + 0.1;
    let mut last = f64::INFINITY;
    let mut counted = [0, 0];
    for step in 0..steps {
        let tried = poses.map(|pose| moved(&pose, &mut rng, is_flat));
        let pair = plain(kinds, [&tried[0], &tried[1]]);
        let found = fast(kinds, [&tried[0], &tried[1]], interaction, &mut hint);
        let Ok(expected) = pair.forces(interaction) else {
            assert_eq!(found.energy, f64::INFINITY, "{step}");
            counted[1] += 1;
            continue;
        };
        // Nearer than this the forces amplify the rounding of the distance beyond measure.
        if expected.distance < 0.02 {
            continue;
        }
        let size = 1.0 + expected.force.norm();
        let errors = [
            (found.energy - expected.energy).abs() / (1.0 + expected.energy.abs()),
            (found.force - expected.force).norm() / size,
            (found.torques[0] - expected.torques[0]).norm() / size,
            (found.torques[1] - expected.torques[1]).norm() / size,
        ];
        let error = errors.into_iter().fold(0.0, f64::max);
        assert!(
            error < 1e-10,
            "{form:?} {step}: {error} {found:?} {expected:?}"
        );
        counted[0] += usize::from(expected.energy != 0.0);
        // They stay near each other, and mostly apart.
        let gap = expected.distance;
        if gap > 0.02 && (gap < 0.25 || gap < last) {
            (poses, last) = (tried, gap);
        }
    }
    counted
}

#[test]
fn bodies_feel_what_the_plain_sum_says() {
    for (number, names, steps, fewest) in [
        (0, ["polygon:3", "polygon:3"], 12_000, 1000),
        (1, ["polygon:4", "polygon:4"], 12_000, 1000),
        (2, ["polygon:4", "polygon:7"], 12_000, 1000),
        (3, ["polygon:6", "polygon:3"], 12_000, 1000),
        (0, ["cube", "cube"], 3000, 60),
        (1, ["octahedron", "octahedron"], 3000, 60),
        (2, ["tetrahedron", "octahedron"], 3000, 60),
        (3, ["prism:5,0.6", "truncated-tetrahedron:0.6667"], 3000, 60),
    ] {
        let [first, second] = names.map(kind);
        for form in FORMS {
            let [felt, _] = compare([&first, &second], form, steps, number);
            assert!(felt > fewest, "{names:?} {form:?} {felt}");
        }
    }
}

fn rounded(name: &str, radius: f64) -> Kind {
    Kind::rounded(&polytope(name), radius).unwrap()
}

#[test]
fn rounded_and_attractive_bodies_feel_what_the_plain_sum_says() {
    let pairs = [
        [rounded("polygon:4", 0.1), rounded("polygon:5", 0.0)],
        [rounded("octahedron", 0.08), rounded("cube", 0.2)],
    ];
    for (number, [first, second]) in pairs.iter().enumerate() {
        for form in FORMS {
            for interaction in [form.into(), attractive(form, 0.7, Central::Conservative)] {
                let [felt, _] = compare([first, second], interaction, 1500, number as u64);
                assert!(felt > 40, "{number} {interaction:?} {felt}");
            }
        }
    }
}

#[test]
fn overlaps_are_told() {
    for name in ["polygon:5", "polygon:4", "octahedron", "cube"] {
        let body = kind(name);
        let mut rng = CounterRng::new(3, 0, 0);
        let mut overlaps = 0;
        for _ in 0..3000 {
            let pose = |rng: &mut CounterRng, reach: f64| {
                let mut position = rng.vector_in_ball(reach);
                let mut rotation = rng.rotation();
                if body.dimension == 2 {
                    position.z = 0.0;
                    rotation = Rotation::from_scaled_axis(7.0 * rng.uniform() * Vec3::z());
                }
                Pose { position, rotation }
            };
            let poses = [pose(&mut rng, 0.1), pose(&mut rng, 1.6)];
            let pair = plain([&body; 2], [&poses[0], &poses[1]]);
            let found = fast(
                [&body; 2],
                [&poses[0], &poses[1]],
                Form::Smooth,
                &mut Hint::default(),
            );
            let expected = pair.forces(Form::Smooth);
            assert_eq!(
                found.energy.is_infinite(),
                expected.is_err(),
                "{name} {poses:?}"
            );
            overlaps += usize::from(expected.is_err());
        }
        assert!(overlaps > 300 && overlaps < 2900, "{name} {overlaps}");
    }
}

#[test]
fn disks_and_balls_repel_along_the_line_of_their_centres() {
    for dimension in [2, 3] {
        let ball = Kind::ball(dimension, 0.5).unwrap();
        let second = Pose {
            position: Vec3::new(0.0, 1.15, 0.0),
            ..Pose::identity()
        };
        for form in FORMS {
            let poses = [&Pose::identity(), &second];
            let found = fast([&ball; 2], poses, form, &mut Hint::default());
            assert!((found.energy - 1.0).abs() < 1e-9, "{form:?} {found:?}");
            assert!((found.force.y + 24.0 / 0.15).abs() < 1e-6);
            assert_eq!(found.torques[0].norm(), 0.0);
        }
        // A disk next to a square, a ball next to a cube: the distance counts, and the flat
        // one turns.
        let name = ["polygon:4", "cube"][dimension - 2];
        let body = kind(name);
        let turn = [std::f64::consts::FRAC_PI_4, 0.0][dimension - 2];
        let rotation = Rotation::from_scaled_axis(turn * Vec3::z());
        let beside = Pose {
            position: Vec3::new(0.3, 1.14, 0.0),
            rotation,
        };
        let poses = [&Pose::identity(), &beside];
        let found = fast([&ball, &body], poses, Form::Smooth, &mut Hint::default());
        let back = Pose {
            position: -beside.position,
            ..Pose::identity()
        };
        let turned = Pose {
            rotation,
            ..Pose::identity()
        };
        let mirrored = fast(
            [&body, &ball],
            [&turned, &back],
            Form::Smooth,
            &mut Hint::default(),
        );
        assert!(found.energy > 0.5 && (found.energy - mirrored.energy).abs() < 1e-9);
        assert!(
            (found.torques[1].z + 0.3 * found.force.y.abs()).abs() < 1e-9,
            "{found:?}"
        );
        assert!((found.torques[1] - mirrored.torques[0]).norm() < 1e-9);
    }
}
