//! Pairs of bodies at the reference poses, made by a program that shares nothing with this one: every
//! energy, force and torque to 1e-10, by the plain sum and by the fast path of the engine.

use crate::common::numbers;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Pose, Rotation, Vec3};
use protomer_md::body::Kind;
use protomer_md::near::{Hint, Law, Turned, felt};
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction, PairForces, Placed};
use serde_json::Value;

const REFERENCE: &str = include_str!("poses.json");
/// Relative to the size of what is compared.
const EXACT: f64 = 1e-10;
/// The gradients of the rescaled central term in the reference are differences, good to 1e-7.
const OF_DIFFERENCES: f64 = 1e-6;

fn vector(value: &Value) -> Vec3 {
    Vec3::from_column_slice(&numbers(value))
}

fn shape(reference: &Value, name: &Value) -> Polytope {
    let corners = &reference["shapes"][name.as_str().unwrap()]["vertices"];
    let corners: Vec<Vec<f64>> = corners.as_array().unwrap().iter().map(numbers).collect();
    let shape = match corners[0].len() {
        2 => Shape::flat(&corners.iter().map(|x| [x[0], x[1]]).collect::<Vec<_>>()),
        _ => Shape::solid(
            &corners
                .iter()
                .map(|x| Vec3::from_column_slice(x))
                .collect::<Vec<_>>(),
        ),
    };
    Polytope::from_shape(&shape.unwrap()).unwrap()
}

fn turn(pose: &Value, body: &str) -> Rotation {
    match pose.get(format!("angle_{body}")) {
        Some(angle) => Rotation::from_scaled_axis(angle.as_f64().unwrap() * Vec3::z()),
        None => {
            let wxyz: [f64; 4] = numbers(&pose[format!("quaternion_{body}")])
                .try_into()
                .unwrap();
            Pose::from_wxyz(Vec3::zeros(), wxyz).rotation
        }
    }
}

/// The two bodies of a reference pose.
struct Pair {
    bodies: [Polytope; 2],
    poses: [Pose; 2],
}

impl Pair {
    fn from_reference(reference: &Value, pose: &Value) -> Self {
        let bodies = ["i", "j"].map(|body| shape(reference, &pose[format!("shape_{body}")]));
        let places = [Vec3::zeros(), vector(&pose["d"])];
        let rotations = ["i", "j"].map(|body| turn(pose, body));
        let poses = [0, 1].map(|n| Pose {
            position: places[n],
            rotation: rotations[n],
        });
        Self { bodies, poses }
    }

    fn plain(&self, interaction: impl Into<Interaction>) -> PairForces {
        let poses = [&self.poses[0], &self.poses[1]];
        let pair = Placed::sharp([&self.bodies[0], &self.bodies[1]], poses);
        pair.forces(interaction).unwrap()
    }

    /// By the engine's path; the distance is not told there.
    fn fast(&self, interaction: impl Into<Interaction>) -> PairForces {
        let interaction = interaction.into();
        // The engine turns bodies to their principal axes; those of the reference are there already.
        let kinds = [0, 1].map(|n| Kind::from_polytope(&self.bodies[n]).unwrap());
        let law = Law::between(&kinds[0].parts[0], &kinds[1].parts[0], &interaction);
        let mut turned = Turned::from_kinds(kinds.iter());
        for (n, kind) in kinds.iter().enumerate() {
            let rotation = self.poses[n].rotation;
            match kind.dimension {
                2 => turned.turn_flat(n, kind, rotation.scaled_axis().z),
                _ => turned.turn_solid(n, kind, &rotation),
            }
        }
        let [first, second] = [0, 1].map(|n| turned.part(n, 0, &kinds[n]));
        let between = self.poses[1].position - self.poses[0].position;
        let mut hint = Hint::default();
        let felt = felt(first, second, between, &law, interaction.form, &mut hint);
        PairForces {
            energy: felt.energy,
            distance: 0.0,
            force: felt.force,
            torques: felt.torques,
        }
    }
}

fn assert_near(found: f64, expected: f64, tolerance: f64, words: &str) {
    let off = (found - expected).abs() / (1.0 + expected.abs());
    assert!(
        off < tolerance,
        "{words}: {found} instead of {expected}, off by {off:.1e}"
    );
}

fn assert_vector(found: &Vec3, expected: &Vec3, size: f64, tolerance: f64, words: &str) {
    let off = (found - expected).norm() / (1.0 + size);
    assert!(
        off < tolerance,
        "{words}: {found} instead of {expected}, off by {off:.1e}"
    );
}

/// Energy, force and torques of a row.
fn assert_row(found: &PairForces, row: &Value, words: &str) {
    assert_near(found.energy, row["energy"].as_f64().unwrap(), EXACT, words);
    let force = vector(&row["force_i"]);
    let size = force.norm();
    assert_vector(&found.force, &force, size, EXACT, words);
    for (torque, key) in found.torques.iter().zip(["torque_i", "torque_j"]) {
        assert_vector(
            torque,
            &vector(&row[key]),
            size,
            EXACT,
            &format!("{words} {key}"),
        );
    }
}

#[test]
fn all_reference_poses_are_met_by_both_paths() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let poses = reference["poses"].as_array().unwrap();
    assert_eq!(poses.len(), 21);
    for pose in poses {
        let name = pose["name"].as_str().unwrap();
        let pair = Pair::from_reference(&reference, pose);
        for (form, key) in [(Form::Contact, "contact"), (Form::FaceSum, "face_sum")] {
            let plain = pair.plain(form);
            assert_near(plain.distance, pose["r_c"].as_f64().unwrap(), EXACT, name);
            assert_row(&plain, &pose[key], &format!("{name} {key} plain"));
            assert_row(&pair.fast(form), &pose[key], &format!("{name} {key} fast"));
        }
        // The reference has no smooth sum; there the two paths are held against each other.
        let (plain, fast) = (pair.plain(Form::Smooth), pair.fast(Form::Smooth));
        let size = plain.force.norm();
        assert_near(fast.energy, plain.energy, EXACT, name);
        assert_vector(&fast.force, &plain.force, size, EXACT, name);
        for n in 0..2 {
            assert_vector(&fast.torques[n], &plain.torques[n], size, EXACT, name);
        }
    }
}

/// What the central term adds to the contact term.
fn central_alone(pair: &Pair, central: Central, attraction: Attraction) -> PairForces {
    let interaction = |central: Central| Interaction {
        form: Form::Contact,
        attraction,
        central,
    };
    let with = pair.plain(interaction(central));
    let without = pair.plain(interaction(Central::None));
    PairForces {
        energy: with.energy - without.energy,
        distance: with.distance,
        force: with.force - without.force,
        torques: [0, 1].map(|n| with.torques[n] - without.torques[n]),
    }
}

#[test]
fn the_central_terms_are_those_of_the_reference() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let mut active = 0;
    for pose in reference["poses"].as_array().unwrap() {
        let name = pose["name"].as_str().unwrap();
        let pair = Pair::from_reference(&reference, pose);
        // The difference of two sums is as exact as the sums.
        let contact = pair.plain(Form::Contact);
        let lost = 1.0 + contact.energy.abs() + contact.force.norm();
        let near = |found: f64, row: &Value| {
            let off = (found - row.as_f64().unwrap()).abs();
            assert!(off < EXACT * lost, "{name} {found} {row}");
        };
        let alone = |central: Central| central_alone(&pair, central, Attraction::NONE);
        let conservative = alone(Central::Conservative);
        let row = &pose["central_unscaled"];
        near(conservative.energy, &row["energy"]);
        let off = (conservative.force - vector(&row["force_i"])).norm();
        assert!(off < EXACT * lost, "{name} {}", conservative.force);
        let row = &pose["central_rescaled"];
        let printed = alone(Central::Printed);
        near(printed.energy, &row["energy"]);
        let expected = vector(&row["force_i_at_fixed_eps_s"]);
        let size = lost + expected.norm();
        assert!(
            (printed.force - expected).norm() < EXACT * size,
            "{name} {}",
            printed.force
        );
        assert!(
            printed.torques[0].norm() < EXACT * lost,
            "{name} {:?}",
            printed.torques
        );
        let gradient = alone(Central::Gradient);
        near(gradient.energy, &row["energy"]);
        let expected = vector(&row["gradient_force_i"]);
        let size = expected.norm();
        assert_vector(&gradient.force, &expected, size, OF_DIFFERENCES, name);
        for (torque, key) in gradient
            .torques
            .iter()
            .zip(["gradient_torque_i", "gradient_torque_j"])
        {
            assert_vector(torque, &vector(&row[key]), size, OF_DIFFERENCES, name);
        }
        active += usize::from(!row["L1"].is_null());
    }
    assert!(active > 0, "{active}");
}

#[test]
fn the_attractive_energies_are_those_of_the_reference() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let attraction = Attraction {
        strength: 1.0,
        cut_off: f64::INFINITY,
    };
    for pose in reference["poses"].as_array().unwrap() {
        let name = pose["name"].as_str().unwrap();
        let pair = Pair::from_reference(&reference, pose);
        let row = &pose["attractive"];
        let energies = |form: Form| {
            pair.plain(Interaction {
                form,
                attraction,
                central: Central::None,
            })
        };
        let contact = energies(Form::Contact);
        let energy = |key: &str| row[key].as_f64().unwrap();
        assert_near(contact.energy, energy("contact_energy"), EXACT, name);
        let force = vector(&row["contact_force_i"]);
        assert_vector(&contact.force, &force, force.norm(), EXACT, name);
        // There the rays leave through an edge, to rounding: either face is right, and only terms
        // without a cut-off tell them apart.
        if name != "tetrahedron_edge_edge" {
            assert_near(
                energies(Form::FaceSum).energy,
                energy("face_sum_energy"),
                EXACT,
                name,
            );
        }
        for (central, key) in [
            (Central::Conservative, "central_unscaled_energy"),
            (Central::Gradient, "central_rescaled_energy"),
        ] {
            let found = central_alone(&pair, central, attraction).energy;
            let off = (found - energy(key)).abs();
            assert!(
                off < EXACT * (1.0 + contact.energy.abs() + found.abs()),
                "{name} {key} {found}"
            );
        }
    }
}

#[test]
fn squares_and_cubes_through_parallel_faces() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let families = reference["parallel_faces"].as_object().unwrap();
    assert!(!families.is_empty());
    let mut rows = 0;
    for (family, table) in families {
        let (name, first_turn) = match family.as_str() {
            "squares" => ("4gon", std::f64::consts::FRAC_PI_4),
            "cubes" => ("cube", 0.0),
            other => panic!("{other}"),
        };
        let body = shape(&reference, &Value::from(name));
        for row in table.as_array().unwrap() {
            let tilt = row["tilt"].as_f64().unwrap();
            let turned = |angle: f64| Rotation::from_scaled_axis(angle * Vec3::z());
            let sigma = 2.0 * body.inradius();
            let pair = Pair {
                bodies: [body.clone(), body.clone()],
                poses: [
                    Pose {
                        position: Vec3::zeros(),
                        rotation: turned(first_turn),
                    },
                    Pose {
                        position: Vec3::new(1.14 * sigma, 0.0, 0.0),
                        rotation: turned(first_turn + tilt),
                    },
                ],
            };
            for (form, key) in [(Form::Contact, "contact"), (Form::FaceSum, "face_sum")] {
                let found = [pair.plain(form), pair.fast(form)];
                for found in found {
                    let words = format!("{family} {tilt} {key}");
                    let Some(energy) = row[format!("{key}_energy")].as_f64() else {
                        continue;
                    };
                    assert_near(found.energy, energy, EXACT, &words);
                    // Parallel faces have no one contact point, and parallel edges no one pair.
                    let is_degenerate = row["degenerate"].as_bool().unwrap();
                    let torque = row[format!("{key}_torque_j_z")].as_f64().unwrap();
                    if !is_degenerate {
                        let size = found.force.norm();
                        let off = (found.torques[1].z - torque).abs() / (1.0 + size);
                        assert!(off < EXACT, "{words}: {} {torque}", found.torques[1].z);
                    }
                    rows += 1;
                }
            }
        }
    }
    assert!(rows > 20, "{rows}");
}
