//! Bodies in motion: collisions and tops with known ends, what is conserved, threads, continuing.

use crate::common::{kind, numbers, settings};
use protomer_kernel::{Boundary, Pose, Rotation, Vec3};
use protomer_md::Error;
use protomer_md::bath::Ensemble;
use protomer_md::body::Kind;
use protomer_md::drift::Drift;
use protomer_md::engine::{Engine, Motion, Settings};
use protomer_md::pair::Form;
use protomer_md::rotation::turn;
use protomer_md::start::{free_density, on_a_lattice, set_velocities};
use protomer_md::state::{Bodies, State};
use serde_json::Value;

/// Collisions integrated by RK4 at a time step of 2e-6, and tops, by a program that shares nothing
/// with this one.
const REFERENCE: &str = include_str!("two_bodies.json");

fn state_of(bodies: &Bodies, numbers: &[f64]) -> State {
    let place = |from: usize| Vec3::new(numbers[from], numbers[from + 1], 0.0);
    let mut state = State::at_rest(bodies, Boundary::Open, vec![place(0), place(3)]);
    for body in 0..2 {
        state.angles_rad[body] = numbers[3 * body + 2];
        state.velocities[body] = place(6 + 3 * body);
        state.spins[body].z = numbers[6 + 3 * body + 2] * bodies.kind(body).moments.z;
    }
    state
}

/// The numbers of a state, in the order of the reference.
fn numbers_of(bodies: &Bodies, state: &State) -> Vec<f64> {
    let mut numbers = Vec::new();
    for body in 0..2 {
        let place = state.positions[body];
        numbers.extend([place.x, place.y, state.angles_rad[body]]);
    }
    for body in 0..2 {
        let velocity = state.velocities[body];
        let turning = state.spins[body].z / bodies.kind(body).moments.z;
        numbers.extend([velocity.x, velocity.y, turning]);
    }
    numbers
}

#[test]
fn collisions_end_as_the_reference_says() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    for collision in reference["collisions"].as_array().unwrap() {
        let name = match collision["shape_i"].as_str().unwrap() {
            "4gon" => "polygon:4",
            "6gon" => "polygon:6",
            other => panic!("{other}"),
        };
        let form = match collision["potential"].as_str().unwrap() {
            "contact + central_unscaled" => Form::Contact,
            _ => Form::FaceSum,
        };
        let expected = numbers(&collision["final"]);
        let time = collision["time"].as_f64().unwrap();
        for row in collision["velocity_verlet"].as_array().unwrap() {
            let step = row["dt"].as_f64().unwrap();
            let bodies = Bodies::of_one_kind(kind(name), 2);
            let start = state_of(&bodies, &numbers(&collision["initial"]));
            let mut engine = Engine::new(bodies.clone(), start, settings(form, step)).unwrap();
            let first = engine.energy();
            let mut worst = 0.0_f64;
            for _ in 0..(time / step).round() as usize {
                engine.step(1.0).unwrap();
                worst = worst.max((engine.energy() - first).abs());
            }
            let found = numbers_of(&bodies, &engine.motion().state);
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f64::max);
            let tabled = |key: &str| row[key].as_f64().unwrap();
            // Four digits are tabled; the reference itself is good to 2e-8.
            let energy = tabled("max_energy_error");
            assert!(
                (worst / energy - 1.0).abs() < 2e-3,
                "{name} {step} {worst} {energy}"
            );
            let state = tabled("final_state_error");
            assert!(
                (off - state).abs() < 2e-3 * state + 5e-8,
                "{name} {step} {off} {state}"
            );
        }
    }
}

#[test]
fn free_tops_turn_as_the_reference_says() {
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    for top in reference["free_tops"].as_array().unwrap() {
        let inertia = numbers(&top["inertia_body"]);
        let mut body = kind("cube");
        body.moments = Vec3::from_column_slice(&inertia);
        let omega = Vec3::from_column_slice(&numbers(&top["omega_body_initial"]));
        let mut spin = omega.component_mul(&body.moments);
        let mut rotation = Rotation::identity();
        let before = rotation * spin;
        let energy = |spin: &Vec3| 0.5 * spin.dot(&spin.component_div(&body.moments));
        let start = energy(&spin);
        let time = top["time"].as_f64().unwrap();
        const STEP: f64 = 1e-3;
        for _ in 0..(time / STEP).round() as usize {
            turn(&body, &mut rotation, &mut spin, STEP);
        }
        let found = Pose {
            position: Vec3::zeros(),
            rotation,
        }
        .wxyz();
        let expected = numbers(&top["quaternion"]);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
        let expected = Vec3::from_column_slice(&numbers(&top["omega_body"]));
        assert!((spin.component_div(&body.moments) - expected).norm() < 1e-8);
        assert!((rotation * spin - before).norm() < 1e-12 * before.norm());
        assert!((energy(&spin) / start - 1.0).abs() < 1e-10);
    }
}

#[test]
fn a_free_rotation_goes_back() {
    let body = kind("cuboid:1,2,3");
    let mut rotation = Rotation::from_scaled_axis(Vec3::new(0.2, 1.0, -0.4));
    let mut spin = Vec3::new(3.0, -2.0, 1.0);
    let (first, first_spin) = (rotation, spin);
    for step in [0.1, -0.1] {
        for _ in 0..100 {
            turn(&body, &mut rotation, &mut spin, step);
        }
    }
    assert!(first.angle_to(&rotation) < 1e-12 && (spin - first_spin).norm() < 1e-12);
}

/// Bodies compressed from a lattice, with a bath that takes the heat of the compression.
fn compressed(name: &str, count: usize, density: f64, form: Form) -> Engine {
    let bodies = Bodies::of_one_kind(kind(name), count);
    let start = free_density(&bodies).min(density);
    let mut state = on_a_lattice(&bodies, start, 5).unwrap();
    set_velocities(&mut state, &bodies, 1.0, 5).unwrap();
    let bath = Settings {
        ensemble: Ensemble::Nvt {
            temperature: 1.0,
            relaxation_time: 0.05,
        },
        ..settings(form, 1e-3)
    };
    let dimension = bodies.dimension() as f64;
    let steps = 3000;
    let scale = (start / density).powf(1.0 / (dimension * f64::from(steps)));
    let mut engine = Engine::new(bodies, state, bath).unwrap();
    for _ in 0..steps {
        engine.step(scale).unwrap();
    }
    engine
}

/// The same motion without a bath, with another step.
fn free(engine: &Engine, time_step: f64) -> Engine {
    let settings = settings(engine.settings().interaction.form, time_step);
    Engine::continued(engine.bodies().clone(), engine.motion().clone(), settings).unwrap()
}

#[test]
fn momentum_and_angular_momentum_are_kept_to_rounding() {
    let start = compressed("octahedron", 64, 0.35, Form::Smooth);
    let mut engine = free(&start, 2e-4);
    for _ in 0..2000 {
        engine.step(1.0).unwrap();
    }
    let momentum = engine.motion().state.momentum(engine.bodies());
    assert!(momentum.norm() < 1e-12 * 64.0, "{momentum}");

    // A cluster in open space: eight octahedra fly at each other.
    let bodies = Bodies::of_one_kind(kind("octahedron"), 8);
    let corner = |n: usize| Vec3::from_fn(|axis, _| 2.0 * f64::from((n >> axis & 1) as u32) - 1.0);
    let places: Vec<Vec3> = (0..8)
        .map(|n| 1.1 * corner(n) + 0.1 * n as f64 * Vec3::x())
        .collect();
    let mut state = State::at_rest(&bodies, Boundary::Open, places.clone());
    set_velocities(&mut state, &bodies, 1.0, 2).unwrap();
    for (velocity, place) in state.velocities.iter_mut().zip(&places) {
        *velocity -= place;
    }
    let mut engine = Engine::new(bodies, state, settings(Form::Smooth, 1e-4)).unwrap();
    let before = engine.motion().state.angular_momentum(engine.bodies());
    let mut highest = 0.0_f64;
    for _ in 0..10_000 {
        engine.step(1.0).unwrap();
        highest = highest.max(engine.motion().potential_energy);
    }
    let after = engine.motion().state.angular_momentum(engine.bodies());
    assert!(highest > 0.5, "they met: {highest}");
    assert!(
        (after - before).norm() < 1e-11 * (1.0 + before.norm()),
        "{before} {after}"
    );
}

#[test]
fn the_error_of_the_energy_falls_with_the_square_of_the_step() {
    let bodies = Bodies::of_one_kind(kind("cube"), 2);
    let mut state = State::at_rest(
        &bodies,
        Boundary::Open,
        vec![Vec3::zeros(), Vec3::new(1.5, 0.2, 0.1)],
    );
    state.rotations[1] = Rotation::from_scaled_axis(Vec3::new(0.3, 0.5, 0.2));
    state.velocities[1].x = -1.5;
    state.spins[0] = Vec3::new(0.1, -0.2, 0.1);
    let worst = |step: f64| {
        let mut engine =
            Engine::new(bodies.clone(), state.clone(), settings(Form::Smooth, step)).unwrap();
        let first = engine.energy();
        let mut worst = 0.0_f64;
        for _ in 0..(0.6 / step) as usize {
            engine.step(1.0).unwrap();
            worst = worst.max((engine.energy() - first).abs());
        }
        worst
    };
    let errors = [2e-4, 1e-4, 5e-5, 2.5e-5].map(worst);
    for pair in errors.windows(2) {
        assert!(
            pair[0] / pair[1] > 2.8 && pair[0] / pair[1] < 5.5,
            "{errors:?}"
        );
    }
    assert!(errors[0] < 1e-3 && errors[3] > 0.0, "{errors:?}");
}

#[test]
fn going_on_from_a_saved_motion_changes_no_bit() {
    for (name, count, density) in [("polygon:5", 100, 0.5), ("octahedron", 64, 0.35)] {
        let start = compressed(name, count, density, Form::FaceSum);
        let mut through = free(&start, 1e-4);
        for _ in 0..300 {
            through.step(1.0).unwrap();
        }
        let text = serde_json::to_string(through.motion()).unwrap();
        let saved: Motion = serde_json::from_str(&text).unwrap();
        assert_eq!(&saved, through.motion());
        let settings = *through.settings();
        let mut again = Engine::continued(through.bodies().clone(), saved, settings).unwrap();
        for _ in 0..500 {
            through.step(1.0).unwrap();
            again.step(1.0).unwrap();
        }
        assert_eq!(through.motion(), again.motion(), "{name}");
        assert!(through.motion().potential_energy > 0.0);
    }
}

#[test]
fn threads_change_no_bit() {
    let start = compressed("polygon:4", 1600, 0.5, Form::FaceSum);
    assert!(start.motion().neighbours.pairs.len() > 2000);
    let mut one = free(&start, 1e-4);
    let threaded = Settings {
        is_threaded: true,
        ..*one.settings()
    };
    let mut many = Engine::continued(one.bodies().clone(), one.motion().clone(), threaded).unwrap();
    for _ in 0..50 {
        one.step(1.0).unwrap();
        many.step(1.0).unwrap();
    }
    assert_eq!(one.motion(), many.motion());
}

#[test]
fn baths_keep_the_temperature_and_account_for_their_heat() {
    let start = compressed("polygon:6", 64, 0.4, Form::Smooth);
    for ensemble in [
        Ensemble::Nvt {
            temperature: 1.5,
            relaxation_time: 0.1,
        },
        Ensemble::Langevin {
            temperature: 1.5,
            friction: 5.0,
        },
    ] {
        let mut engine = free(&start, 5e-4);
        let with_bath = Settings {
            ensemble,
            ..*engine.settings()
        };
        engine.change_settings(with_bath).unwrap();
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        let first = engine.kept_energy();
        for step in 0..12_000 {
            engine.step(1.0).unwrap();
            if step > 2000 && step % 10 == 0 {
                for (sum, temperature) in sum.iter_mut().zip(engine.temperatures()) {
                    *sum += temperature;
                }
                count += 1.0;
            }
        }
        for sum in sum {
            // Five time units and 64 bodies: 2 % is three standard errors and more.
            assert!(
                (sum / count / 1.5 - 1.0).abs() < 0.06,
                "{ensemble:?} {}",
                sum / count
            );
        }
        let drift = (engine.kept_energy() - first).abs() / 64.0;
        assert!(drift < 5e-3, "{ensemble:?} {drift}");
        assert!(engine.motion().heat.abs() > 1.0);
    }
}

#[test]
fn langevin_and_brownian_bodies_diffuse_as_single_ones_do() {
    // Far apart: the mean squared displacement of free Langevin motion in a plane, 4 kT/(m γ²)
    // (γ t - 1 + exp(-γ t)), and of overdamped motion, 4 kT t/(m γ).
    let bodies = Bodies::of_one_kind(Kind::ball(2, 0.564_189_583_547_756_3).unwrap(), 2500);
    let mut state = on_a_lattice(&bodies, 0.01, 3).unwrap();
    set_velocities(&mut state, &bodies, 1.0, 3).unwrap();
    let (friction, temperature, time) = (2.0, 1.0, 1.0);
    let langevin = Ensemble::Langevin {
        temperature,
        friction,
    };
    let brownian = Ensemble::Brownian {
        temperature,
        friction,
    };
    for (ensemble, expected) in [(langevin, 1.135_335_283_236_612_8), (brownian, 2.0)] {
        let bath = Settings {
            ensemble,
            ..settings(Form::Contact, 0.01)
        };
        let mut engine = Engine::new(bodies.clone(), state.clone(), bath).unwrap();
        for _ in 0..(time / 0.01_f64).round() as usize {
            engine.step(1.0).unwrap();
        }
        let moved = engine.motion().state.positions.iter().zip(&state.positions);
        let squared = moved.map(|(here, there)| (here - there).norm_squared());
        let mean = squared.sum::<f64>() / bodies.count() as f64;
        // The standard error of the mean over 2500 bodies is 2 %.
        assert!(
            (mean / expected - 1.0).abs() < 0.07,
            "{ensemble:?} {mean} {expected}"
        );
    }
}

#[test]
fn the_pressure_of_a_dilute_gas_is_that_of_its_second_virial_coefficient() {
    // Octagons at number density 0.12: nearly disks of a diameter a little below the range.
    let engine = compressed("polygon:8", 256, 0.12, Form::Contact);
    let mut engine = free(&engine, 1e-3);
    let mut sum = 0.0;
    for _ in 0..8000 {
        engine.step(1.0).unwrap();
        sum += engine.pressure() / engine.temperatures()[0];
    }
    let ratio = sum / 8000.0 / 0.12;
    // B2 of a disk of diameter d is π d²/2. The repulsion is 1 kT at d = 1.25 to 1.29, so B2 times the
    // density is 0.29 to 0.31; the third coefficient adds 0.07.
    assert!(ratio > 1.33 && ratio < 1.42, "{ratio}");
}

#[test]
fn what_cannot_be_is_refused() {
    let bodies = Bodies::of_one_kind(kind("cube"), 8);
    assert!(matches!(
        on_a_lattice(&bodies, 0.9, 1),
        Err(Error::OutOfRange { .. })
    ));
    let state = on_a_lattice(&bodies, 0.1, 1).unwrap();
    let small = Engine::new(bodies.clone(), state.clone(), settings(Form::Smooth, 1e-3));
    assert!(matches!(small, Err(Error::SmallBox { .. })));
    let state = State {
        space: Boundary::Open,
        ..state
    };
    let no_time = Engine::new(bodies.clone(), state.clone(), settings(Form::Smooth, 0.0));
    assert!(matches!(
        no_time,
        Err(Error::OutOfRange {
            what: "the time step",
            ..
        })
    ));
    let mut crossed = state.clone();
    crossed.positions[1] = crossed.positions[0];
    let met = Engine::new(bodies.clone(), crossed, settings(Form::Smooth, 1e-3));
    assert!(matches!(
        met,
        Err(Error::Met {
            first: 0,
            second: 1
        })
    ));
    let fewer = Bodies::of_one_kind(kind("cube"), 7);
    let other = Engine::new(fewer, state, settings(Form::Smooth, 1e-3));
    assert!(other.is_err());
}

/// The noise of the energy per body about a straight line, and its change along the line.
fn kept(start: &Engine, form: Form, time_step: f64, steps: usize) -> [f64; 2] {
    let settings = settings(form, time_step);
    let motion = start.motion().clone();
    let bodies = start.bodies().clone();
    let count = bodies.count() as f64;
    let mut engine = Engine::continued(bodies, motion, settings).unwrap();
    let mut drift = Drift::default();
    // The first step leaves the forces of another form behind.
    engine.step(1.0).unwrap();
    for step in 0..steps {
        engine.step(1.0).unwrap();
        if step % 10 == 0 {
            drift.push(step as f64, engine.energy());
        }
    }
    [drift.noise() / count, drift.along_the_line() / count]
}

#[test]
fn squares_keep_their_energy_with_the_sums_and_lose_it_with_the_contact_point() {
    // 36 squares of which 0.6 of the plane is filled, layers counted.
    let start = compressed("polygon:4", 36, 0.6 / 1.317_671, Form::FaceSum);
    for form in [Form::FaceSum, Form::Smooth] {
        let [noise, change] = kept(&start, form, 1e-4, 100_000);
        assert!(
            noise < 2e-5 && change.abs() < 5e-5,
            "{form:?} {noise} {change}"
        );
    }
    let [noise, _] = kept(&start, Form::Contact, 1e-4, 100_000);
    assert!(noise > 1e-4, "{noise}");
}

#[test]
fn dense_octahedra_keep_their_energy_with_the_smooth_sum_and_lose_it_with_the_contact_point() {
    let start = compressed("octahedron", 64, 0.38, Form::Smooth);
    let smooth = [1e-4, 5e-5].map(|step| kept(&start, Form::Smooth, step, (0.8 / step) as usize));
    // All 64 together gain less than 0.05, and the error falls with the step.
    assert!(64.0 * smooth[0][1].abs() < 0.05, "{smooth:?}");
    assert!(smooth[1][0] < 0.5 * smooth[0][0], "{smooth:?}");
    let [noise, _] = kept(&start, Form::Contact, 5e-5, 16_000);
    assert!(noise > 5.0 * smooth[1][0], "{noise} {smooth:?}");
}
