//! Friction, noise and charges against what is known of them.

use crate::common::{drawn_start, engine, lattice, one_square, two_squares};
use nalgebra::{DMatrix, DVector};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::statistics::summarize;
use protomer_linkage::lattice::pair::{ScreenedCharges, SquareCharge, pairs_within, rings};
use protomer_linkage::lattice::{
    Corner, Drag, Dynamics, Edges, Force, Langevin, Network, Rod, Square, Start, State,
};
use std::f64::consts::TAU;
use std::sync::Arc;

/// -k s on every coordinate of the first square.
struct Spring(f64);

impl Force for Spring {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        let square = network.squares[0];
        let weights = [square.mass, square.mass, square.inertia];
        (0..3)
            .map(|c| {
                accelerations[c] -= self.0 * positions[c] / weights[c];
                0.5 * self.0 * positions[c] * positions[c]
            })
            .sum()
    }
}

/// V = strength · (1 - cos(θ₀ - θ₁)).
struct Alignment(f64);

impl Force for Alignment {
    fn accelerate(&self, network: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
        let apart = positions[2] - positions[5];
        accelerations[2] -= self.0 * apart.sin() / network.squares[0].inertia;
        accelerations[5] += self.0 * apart.sin() / network.squares[1].inertia;
        self.0 * (1.0 - apart.cos())
    }
}

fn free_square() -> (Arc<Network>, State) {
    (
        Arc::new(one_square()),
        State {
            time: 0.0,
            positions: vec![0.0; 3],
            velocities: vec![0.0; 3],
        },
    )
}

#[test]
fn drag_without_forces_is_exact_and_takes_momentum_evenly() {
    let (network, mut state) = free_square();
    state.velocities = vec![1.0, -2.0, 3.0];
    let mut dynamics = Dynamics::new(network, Vec::new(), &state).unwrap();
    let drag = Drag::uniform(0.7).unwrap();
    for _ in 0..100 {
        drag.step(&mut dynamics, &mut state, 0.05).unwrap();
    }
    let kept = (-0.7f64 * 5.0).exp();
    for (found, start) in state.velocities.iter().zip([1.0, -2.0, 3.0]) {
        assert!((found - kept * start).abs() < 1e-13);
    }
    // On rods: momentum and angular momentum decay as exp(-γ t), whatever the rods do.
    let network = lattice(3, 0.6);
    let mut state = drawn_start(&network, 1, None);
    state
        .velocities
        .chunks_exact_mut(3)
        .for_each(|v| v[0] += 0.3);
    let (momentum, spin) = (state.momentum(&network), state.angular_momentum(&network));
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    for _ in 0..200 {
        drag.step(&mut dynamics, &mut state, 0.005).unwrap();
    }
    let kept = (-0.7f64).exp();
    assert!((state.momentum(&network)[0] - kept * momentum[0]).abs() < 1e-12);
    assert!((state.angular_momentum(&network) - kept * spin).abs() < 1e-4 * spin.abs().max(1.0));
}

/// A lattice with friction against the same with a step so short that it is exact: the error falls
/// by 4 with half the step, for one rate and for two.
#[test]
fn drag_is_of_second_order() {
    let network = lattice(3, 0.6);
    for drag in [Drag::uniform(0.8).unwrap(), Drag::new(0.3, 1.5).unwrap()] {
        let run = |step: f64| {
            let mut state = drawn_start(&network, 2, None);
            let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
            for _ in 0..(1.0 / step).round() as u64 {
                drag.step(&mut dynamics, &mut state, step).unwrap();
            }
            state.positions
        };
        let exact = run(1.25e-4);
        let [coarse, fine] = [4e-3, 2e-3].map(|step| {
            run(step)
                .iter()
                .zip(&exact)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        });
        eprintln!("{drag:?}: {coarse:e} {fine:e} ratio {}", coarse / fine);
        assert!((3.8..4.2).contains(&(coarse / fine)));
    }
    assert!(Drag::new(-1.0, 0.0).is_err());
}

/// For a harmonic potential k/2 x² on a mass m the splitting samples the velocities exactly, ⟨v²⟩ =
/// kT/m, and positions with ⟨x²⟩ = kT / (k (1 - h² k / 4m)), so that the error is of second order
/// in h: the step keeps m v²/2 + k (1 - h² k / 4m) x²/2 exactly, and the half steps of friction and
/// noise keep the distribution of v.
#[test]
fn a_harmonic_oscillator_has_the_known_error_of_second_order() {
    for (step, seed) in [(1.0f64, 3), (0.5, 4)] {
        let (network, mut state) = free_square();
        let mut dynamics = Dynamics::new(network, vec![Box::new(Spring(1.0))], &state).unwrap();
        let langevin = Langevin::new(0.6, 1.5, seed, 0).unwrap();
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for number in 0..400_000 {
            langevin
                .step(&mut dynamics, &mut state, step, number)
                .unwrap();
            positions.push(0.5 * (state.positions[0].powi(2) + state.positions[1].powi(2)));
            velocities.push(state.kinetic_energy(dynamics.network()));
        }
        let (x, v) = (summarize(&positions), summarize(&velocities));
        let expected = 0.6 / (1.0 - step * step / 4.0);
        eprintln!(
            "h = {step}: <x2> {} ± {} ({expected}), <K> {} ± {} (0.9)",
            x.mean, x.standard_error, v.mean, v.standard_error
        );
        assert!((x.mean - expected).abs() < 3.0 * x.standard_error);
        assert!((v.mean - 0.9).abs() < 3.0 * v.standard_error);
        // Sharp enough to see the error it predicts.
        assert!(expected - 0.6 > 6.0 * x.standard_error);
    }
}

#[test]
fn kinetic_energy_is_half_kt_per_degree_of_freedom() {
    for (size, rod_length, kt, seed) in [(2, 1.0, 0.02, 5), (4, 0.5, 0.01, 6)] {
        let network = lattice(size, rod_length);
        let mut state = Start::default().build(&network, 0).unwrap().state;
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
        let langevin = Langevin::new(kt, 2.0, seed, 0).unwrap();
        langevin.draw_velocities(&mut dynamics, &mut state);
        let mut energies = Vec::new();
        let mut sigma = vec![0.0; network.rods.len()];
        for number in 0..200_000 {
            langevin
                .step(&mut dynamics, &mut state, 0.02, number)
                .unwrap();
            energies.push(state.kinetic_energy(&network));
            if number % 1000 == 0 {
                let (_, violation) = dynamics.rods().violations(&state.positions, &mut sigma);
                assert!(violation.abs() < 1e-12);
                dynamics.rods().apply(&state.velocities, &mut sigma);
                assert!(sigma.iter().all(|rate| rate.abs() < 1e-12));
            }
        }
        let degrees = (3 * network.squares.len() - network.rods.len()) as f64;
        let found = summarize(&energies);
        let expected = 0.5 * degrees * kt;
        eprintln!(
            "{size}: {} ± {} expected {expected}",
            found.mean, found.standard_error
        );
        assert!((found.mean - expected).abs() < 3.0 * found.standard_error);
        assert!(found.standard_error < 0.01 * expected);
    }
}

/// Elastic collisions leave the canonical ensemble as it is.
#[test]
fn kinetic_energy_is_the_same_with_collisions() {
    let network = lattice(2, 0.5);
    let mut state = Start::default().build(&network, 0).unwrap().state;
    let mut engine = engine(&network, &state);
    let langevin = Langevin::new(0.05, 1.0, 13, 0).unwrap();
    langevin.draw_velocities(engine.dynamics(), &mut state);
    let mut energies = Vec::new();
    for number in 0..300_000 {
        langevin.before(engine.dynamics(), &mut state, 0.01, number);
        engine.step(&mut state, 0.01).unwrap();
        langevin.after(engine.dynamics(), &mut state, 0.01, number);
        energies.push(state.kinetic_energy(&network));
    }
    let found = summarize(&energies);
    eprintln!(
        "{} ± {}, {:?}",
        found.mean,
        found.standard_error,
        engine.statistics()
    );
    assert!(engine.statistics().impacts > 1000);
    assert!((found.mean - 0.2).abs() < 3.0 * found.standard_error && found.standard_error < 0.003);
}

/// Two squares and a rod of length r: with α the angles between the rod and the two arms, A = J M⁻¹
/// Jᵀ = 2/m + l² (sin²α + sin²α') / I = 2 + 3 (sin²α + sin²α'). Rigid rods give the distribution √A
/// exp(-V/kT) of α and α', stiff springs would give exp(-V/kT); V = ε (1 - cos(θ - θ')).
#[test]
fn two_squares_on_a_rod_are_distributed_as_rigid_rods_must_be() {
    let network = two_squares([4, 3], 1.0);
    let angle = |vertex: u8| [135.0f64, 45.0, 225.0, -45.0][usize::from(vertex) - 1].to_radians();
    let (kt, strength) = (0.5, 0.6);
    // Quadrature over the two arms' directions from the rod; θ - θ' differs from their difference
    // by the corners' angles.
    let quadrature = |power: f64| {
        let count = 400;
        let (mut total, mut sums) = (0.0, [0.0; 2]);
        for a in 0..count {
            for b in 0..count {
                let (alpha, beta) = (
                    TAU * f64::from(a) / f64::from(count),
                    TAU * f64::from(b) / f64::from(count),
                );
                let (first, second) = (alpha.sin().powi(2), beta.sin().powi(2));
                let aligned = (alpha - angle(4) - (beta - angle(3))).cos();
                let weight = (2.0 + 3.0 * (first + second)).powf(power)
                    * (-strength * (1.0 - aligned) / kt).exp();
                total += weight;
                sums[0] += weight * 0.5 * (first + second);
                sums[1] += weight * aligned;
            }
        }
        sums.map(|sum| sum / total)
    };
    let (rigid, springs) = (quadrature(0.5), quadrature(0.0));
    let mut state = State {
        time: 0.0,
        positions: vec![
            0.0,
            0.0,
            -angle(4),
            3.0,
            0.0,
            std::f64::consts::PI - angle(3),
        ],
        velocities: vec![0.0; 6],
    };
    let mut dynamics =
        Dynamics::new(network.clone(), vec![Box::new(Alignment(strength))], &state).unwrap();
    let langevin = Langevin::new(kt, 1.0, 8, 0).unwrap();
    langevin.draw_velocities(&mut dynamics, &mut state);
    let (mut series, mut weights) = ([Vec::new(), Vec::new()], Vec::new());
    for number in 0..2_500_000 {
        langevin
            .step(&mut dynamics, &mut state, 0.025, number)
            .unwrap();
        if number % 10 == 0 {
            let s = &state.positions;
            let arms = [s[2] + angle(4), s[5] + angle(3)];
            let along = [
                s[3] + arms[1].cos() - s[0] - arms[0].cos(),
                s[4] + arms[1].sin() - s[1] - arms[0].sin(),
            ];
            let squares = arms.map(|arm| (arm.cos() * along[1] - arm.sin() * along[0]).powi(2));
            series[0].push(0.5 * (squares[0] + squares[1]));
            series[1].push((s[2] - s[5]).cos());
            weights.push((-0.5 * dynamics.rods().log_determinant()).exp());
            let expected = 2.0 + 3.0 * (squares[0] + squares[1]);
            assert!((dynamics.rods().log_determinant() - expected.ln()).abs() < 1e-9);
        }
    }
    for (which, series) in series.iter().enumerate() {
        let found = summarize(series);
        eprintln!(
            "{which}: {} ± {}; rigid {}, springs {}",
            found.mean, found.standard_error, rigid[which], springs[which]
        );
        assert!((found.mean - rigid[which]).abs() < 3.0 * found.standard_error);
        // Fixman's weights turn one average into the other.
        let total: f64 = weights.iter().sum();
        let weighted = series.iter().zip(&weights).map(|(x, w)| x * w).sum::<f64>() / total;
        eprintln!("   weighted {weighted}");
        assert!((weighted - springs[which]).abs() < 4.0 * found.standard_error);
    }
    let found = summarize(&series[0]);
    assert!(
        (found.mean - springs[0]).abs() > 8.0 * found.standard_error,
        "the test could not tell the two apart"
    );
}

/// Velocities drawn at a temperature have the covariance kT P M⁻¹, with P = 1 - M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁻¹
/// J from dense matrices and J from differences of the rods' lengths.
#[test]
fn drawn_velocities_have_the_covariance_of_the_constrained_ensemble() {
    let network = lattice(2, 0.7);
    let mut state = Start {
        angle_spread: 0.3,
        seed: 1,
        ..Start::default()
    }
    .build(&network, 0)
    .unwrap()
    .state;
    let lengths = |s: &[f64]| -> Vec<f64> {
        let corner = |c: Corner| {
            let ((sine, cosine), [x, y]) = (s[3 * c.square + 2].sin_cos(), c.direction());
            [
                s[3 * c.square] + cosine * x - sine * y,
                s[3 * c.square + 1] + sine * x + cosine * y,
            ]
        };
        let length = |rod: &Rod| {
            let (a, b) = (corner(rod.from), corner(rod.to));
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        network.rods.iter().map(length).collect()
    };
    let jacobian = DMatrix::from_fn(4, 12, |rod, k| {
        let moved = |shift: f64| {
            let mut s = state.positions.clone();
            s[k] += shift;
            lengths(&s)[rod]
        };
        (moved(1e-5) - moved(-1e-5)) / 2e-5
    });
    let inverse_mass = DMatrix::from_fn(12, 12, |a, b| {
        if a != b {
            0.0
        } else if a % 3 == 2 {
            3.0
        } else {
            1.0
        }
    });
    let coupling = (&jacobian * &inverse_mass * jacobian.transpose())
        .try_inverse()
        .unwrap();
    let kept =
        DMatrix::identity(12, 12) - &inverse_mass * jacobian.transpose() * coupling * &jacobian;
    let expected = kept * inverse_mass * 0.3;
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    let draws = 40_000;
    let mut found = DMatrix::<f64>::zeros(12, 12);
    for seed in 0..draws {
        Langevin::new(0.3, 1.0, seed, 0)
            .unwrap()
            .draw_velocities(&mut dynamics, &mut state);
        let v = DVector::from_column_slice(&state.velocities);
        found += &v * v.transpose() / draws as f64;
    }
    for a in 0..12 {
        for b in 0..12 {
            let error = ((expected[(a, a)] * expected[(b, b)] + expected[(a, b)].powi(2))
                / draws as f64)
                .sqrt();
            let away = found[(a, b)] - expected[(a, b)];
            assert!(
                away.abs() < 4.5 * error,
                "{a} {b}: {} {} ± {error}",
                found[(a, b)],
                expected[(a, b)]
            );
        }
    }
    assert!(Langevin::new(-1.0, 1.0, 0, 0).is_err() && Langevin::new(1.0, f64::NAN, 0, 0).is_err());
}

#[test]
fn a_run_resumed_from_its_state_goes_on_bit_for_bit() {
    let network = lattice(4, 0.4);
    let mut state = Start::default().build(&network, 0).unwrap().state;
    let langevin = Langevin::new(0.02, 1.0, 11, 2).unwrap();
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    let mut saved = None;
    for number in 0..400 {
        if number == 150 {
            saved = Some(serde_json::to_string(&state).unwrap());
        }
        langevin
            .step(&mut dynamics, &mut state, 0.01, number)
            .unwrap();
    }
    let mut resumed: State = serde_json::from_str(&saved.unwrap()).unwrap();
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &resumed).unwrap();
    for number in 150..400 {
        langevin
            .step(&mut dynamics, &mut resumed, 0.01, number)
            .unwrap();
    }
    assert_eq!(state, resumed);
    let other = Langevin {
        replica: 3,
        ..langevin
    };
    other.step(&mut dynamics, &mut resumed, 0.01, 400).unwrap();
    langevin
        .step(
            &mut Dynamics::new(network, Vec::new(), &state).unwrap(),
            &mut state,
            0.01,
            400,
        )
        .unwrap();
    assert_ne!(state, resumed);
}

fn charges() -> Vec<SquareCharge> {
    [([0.5, 0.1], 1.0), ([-0.3, 0.4], -2.0), ([0.1, -0.6], 0.7)]
        .map(|(position, charge)| SquareCharge { position, charge })
        .to_vec()
}

#[test]
fn charges_push_down_the_slope_of_their_energy() {
    for edges in [Edges::Open, Edges::Periodic] {
        let square = Square {
            half_diagonal: 1.0,
            mass: 1.3,
            inertia: 0.4,
        };
        let network = Network::lattice(4, 2, 0.4, square, edges, 0.6).unwrap();
        let yukawa = Yukawa::uncut(7.0, 0.1).unwrap();
        let force =
            ScreenedCharges::on_every_square(&network, yukawa, 22.0, 0.8, &charges()).unwrap();
        let mut positions = State::coherent(&network, 0.6).positions;
        positions
            .iter_mut()
            .enumerate()
            .for_each(|(k, s)| *s += 0.05 * (1.3 * k as f64).sin());
        let mut accelerations = vec![0.0; positions.len()];
        let energy = force.accelerate(&network, &positions, &mut accelerations);
        // The slow twin: every charge with every other of every neighbouring square and image, from
        // distances alone.
        let place = |s: &[f64], square: usize, charge: &SquareCharge, image: [i32; 2]| {
            let (sine, cosine) = s[3 * square + 2].sin_cos();
            let ([x, y], cell) = (charge.position, network.cell.unwrap_or([0.0; 2]));
            [
                s[3 * square] + cosine * x - sine * y + f64::from(image[0]) * cell[0],
                s[3 * square + 1] + sine * x + cosine * y + f64::from(image[1]) * cell[1],
            ]
        };
        let twin = |s: &[f64]| -> f64 {
            let plain = |r: f64| 7.0 * (-0.1 * r).exp() / r;
            let mut total = 0.0;
            for pair in force.pairs() {
                for a in &charges() {
                    for b in &charges() {
                        let (p, q) = (
                            place(s, pair.squares[0], a, [0; 2]),
                            place(s, pair.squares[1], b, pair.image),
                        );
                        let r = 22.0 * ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2)).sqrt();
                        total += 0.8 * a.charge * b.charge * plain(r);
                    }
                }
            }
            total
        };
        assert!((energy - twin(&positions)).abs() < 1e-12 * energy.abs().max(1.0));
        for k in 0..positions.len() {
            let moved = |shift: f64| {
                let mut s = positions.clone();
                s[k] += shift;
                twin(&s)
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            let mass = if k % 3 == 2 { 0.4 } else { 1.3 };
            assert!(
                (slope + mass * accelerations[k]).abs() < 1e-8,
                "{k}: {slope} {}",
                mass * accelerations[k]
            );
        }
    }
}

#[test]
fn charges_keep_energy_and_momentum() {
    let network = lattice(3, 0.5);
    let yukawa = Yukawa::uncut(7.0, 0.1).unwrap();
    let drift = |step: f64| {
        let mut state = drawn_start(&network, 3, None);
        let force =
            ScreenedCharges::on_every_square(&network, yukawa, 22.0, 0.5, &charges()).unwrap();
        let mut dynamics = Dynamics::new(network.clone(), vec![Box::new(force)], &state).unwrap();
        let energy = |dynamics: &Dynamics, state: &State| {
            state.kinetic_energy(&network) + dynamics.potential_energy()
        };
        let (before, spin) = (energy(&dynamics, &state), state.angular_momentum(&network));
        let mut worst = 0.0_f64;
        for _ in 0..(2.0 / step).round() as u64 {
            dynamics.step(&mut state, step).unwrap();
            worst = worst.max((energy(&dynamics, &state) - before).abs());
        }
        let momentum = state.momentum(&network);
        assert!(momentum[0].hypot(momentum[1]) < 1e-12);
        assert!((state.angular_momentum(&network) - spin).abs() < 1e-4);
        worst / state.kinetic_energy(&network)
    };
    let (coarse, fine) = (drift(2e-3), drift(1e-3));
    eprintln!("energy: {coarse:e} {fine:e} ratio {}", coarse / fine);
    assert!(fine < 1e-4 && (3.5..4.5).contains(&(coarse / fine)));
}

/// In a row of eight squares with a net charge, all squares act on all at a Debye length of two
/// squares. At a tenth of a square what is left out is below the stated share of what is kept.
#[test]
fn squares_act_as_far_as_their_charges_reach() {
    let network = Network::lattice(1, 8, 0.4, Square::default(), Edges::Open, 0.0).unwrap();
    let state = State::coherent(&network, 0.0);
    assert_eq!(rings(&network, 3.0), 8);
    assert_eq!(pairs_within(&network, 8).len(), 8 * 7 / 2);
    for (debye_length, within) in [(0.14, 1), (0.3, 2), (0.5, 3)] {
        assert_eq!(rings(&network, debye_length), within);
        let yukawa = Yukawa::uncut(1.0, 1.0 / debye_length).unwrap();
        let energy = |rings: usize| {
            let (charges, pairs) = (vec![charges(); 8], pairs_within(&network, rings));
            let force = ScreenedCharges::new(&network, yukawa, 1.0, 1.0, charges, pairs).unwrap();
            force.accelerate(&network, &state.positions, &mut [0.0; 24])
        };
        let (kept, all) = (energy(within), energy(8));
        assert!(
            (kept - all).abs() < 2e-3 * all.abs(),
            "{debye_length}: {kept} {all}"
        );
    }
    let periodic = Network::lattice(2, 2, 0.4, Square::default(), Edges::Periodic, 0.6).unwrap();
    let yukawa = Yukawa::uncut(7.0, 1e-4).unwrap();
    let error = ScreenedCharges::on_every_square(&periodic, yukawa, 22.0, 0.8, &charges());
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("debye_length_angstrom is 10000")
    );
}

#[test]
fn neighbours_are_the_eight_around_once_each() {
    let open = Network::lattice(4, 5, 0.4, Square::default(), Edges::Open, 0.6).unwrap();
    assert_eq!(pairs_within(&open, 1).len(), 4 * 4 + 3 * 5 + 2 * 3 * 4);
    let periodic = Network::lattice(2, 4, 0.4, Square::default(), Edges::Periodic, 0.6).unwrap();
    assert_eq!(pairs_within(&periodic, 1).len(), 4 * 8);
    // All pairs and images are within the diagonal distance of the coherent state.
    let state = State::coherent(&periodic, 0.6);
    let (cell, spacing) = (periodic.cell.unwrap(), periodic.cell.unwrap()[0] / 4.0);
    for pair in pairs_within(&periodic, 1) {
        let [p, q] = pair.squares;
        let apart = [0, 1].map(|axis| {
            state.positions[3 * q + axis] + f64::from(pair.image[axis]) * cell[axis]
                - state.positions[3 * p + axis]
        });
        assert!(apart[0].hypot(apart[1]) < 1.5 * spacing, "{pair:?}");
    }
}
