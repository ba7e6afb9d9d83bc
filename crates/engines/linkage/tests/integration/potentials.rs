//! Tabulated potentials and loads: forces against differences of the energy, energy in motion, and
//! the response to a load against the fluctuations.

use crate::common::{drawn_start, lattice};
use nalgebra::Matrix2;
use protomer_kernel::random::CounterRng;
use protomer_kernel::spline::{Ends, Spline};
use protomer_kernel::statistics::RunningMoments;
use protomer_linkage::analysis::strain::{biot_strain, corners, deformation_gradient};
use protomer_linkage::lattice::angle_potential::openings;
use protomer_linkage::lattice::load::reference_area;
use protomer_linkage::lattice::{
    Edges, Force, JointPotential, Langevin, Load, Meetings, Motion, Mover, Network,
    OpeningPotential, Square, State, Stress,
};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::sync::Arc;

/// A double well in the opening of a joint, with its barrier in the open state.
fn double_well(depth: f64, points: usize) -> Spline {
    let angles: Vec<f64> = (0..points)
        .map(|k| -0.3 + (PI + 0.6) * k as f64 / (points - 1) as f64)
        .collect();
    let energies: Vec<f64> = angles
        .iter()
        .map(|x| depth * (2.0 * (x - FRAC_PI_2)).cos())
        .collect();
    Spline::through(&angles, &energies, Ends::Straight).unwrap()
}

/// Squares of different mass and inertia, one missing, turned at random off the coherent state.
fn disordered() -> (Network, State) {
    let mut network =
        Network::lattice(3, 4, 0.4, Square::default(), Edges::Open, FRAC_PI_4).unwrap();
    network.squares[2].mass = 2.0;
    network.squares[5].inertia = 0.7;
    let network = network.without_squares(&[7]).unwrap();
    let mut state = State::coherent(&network, 0.5);
    let mut rng = CounterRng::new(5, 0, 0);
    for coordinate in &mut state.positions {
        *coordinate += rng.uniform_in(-0.2, 0.2);
    }
    (network, state)
}

/// The accelerations are minus the differences of the energy, over mass and inertia.
fn agrees_with_differences(force: &dyn Force, network: &Network, positions: &[f64]) {
    let mut accelerations = vec![0.0; positions.len()];
    force.accelerate(network, positions, &mut accelerations);
    let energy = |moved: &[f64]| force.accelerate(network, moved, &mut vec![0.0; moved.len()]);
    let mut largest = 0.0_f64;
    for coordinate in 0..positions.len() {
        let mut moved = positions.to_vec();
        let h = 1e-5;
        moved[coordinate] = positions[coordinate] + h;
        let above = energy(&moved);
        moved[coordinate] = positions[coordinate] - h;
        let slope = (above - energy(&moved)) / (2.0 * h);
        let square = &network.squares[coordinate / 3];
        let weight = if coordinate % 3 == 2 {
            square.inertia
        } else {
            square.mass
        };
        let found = accelerations[coordinate];
        assert!(
            (found + slope / weight).abs() < 1e-7 * (1.0 + found.abs()),
            "coordinate {coordinate}: {found} {slope}"
        );
        largest = largest.max(found.abs());
    }
    assert!(largest > 1e-2, "{largest}");
}

#[test]
fn forces_are_minus_the_slope_of_the_energy() {
    let (network, state) = disordered();
    let spline = double_well(0.7, 40);
    let joints = JointPotential::new(&network, spline.clone()).unwrap();
    agrees_with_differences(&joints, &network, &state.positions);
    let opening = OpeningPotential::new(&network, spline).unwrap();
    agrees_with_differences(&opening, &network, &state.positions);
    let first = State::coherent(&network, 0.6);
    let stress = Stress { xx: 0.3, yy: -0.1 };
    let load = Load::new(&network, stress, &first).unwrap();
    agrees_with_differences(&load, &network, &state.positions);
}

/// The slow twin of the potential of the joints: every pair of neighbours by rows and columns.
#[test]
fn the_energy_of_the_joints_is_that_of_all_neighbours() {
    let network = lattice(4, 0.3);
    let mut state = State::coherent(&network, 0.6);
    let mut rng = CounterRng::new(9, 0, 0);
    for theta in state.positions.iter_mut().skip(2).step_by(3) {
        *theta += rng.uniform_in(-0.4, 0.4);
    }
    let spline = double_well(1.3, 60);
    let mut expected = 0.0;
    let theta = |row: usize, column: usize| state.positions[3 * (4 * row + column) + 2];
    for row in 0..4 {
        for column in 0..4 {
            let sign = if (row + column) % 2 == 0 { 1.0 } else { -1.0 };
            if column < 3 {
                expected +=
                    spline.evaluate(sign * (theta(row, column) - theta(row, column + 1)))[0];
            }
            if row < 3 {
                expected +=
                    spline.evaluate(sign * (theta(row, column) - theta(row + 1, column)))[0];
            }
        }
    }
    let potential = JointPotential::new(&network, spline).unwrap();
    let mut accelerations = vec![0.0; state.positions.len()];
    let found = potential.accelerate(&network, &state.positions, &mut accelerations);
    assert!((found - expected).abs() < 1e-12);
}

/// A load neither pushes nor turns the lattice as a whole, and a lattice that turned has the same
/// energy.
#[test]
fn a_load_keeps_momentum_and_is_blind_to_rotation() {
    let (network, state) = disordered();
    let first = State::coherent(&network, 0.6);
    let load = Load::new(&network, Stress { xx: 0.4, yy: 0.1 }, &first).unwrap();
    let mut accelerations = vec![0.0; state.positions.len()];
    let energy = load.accelerate(&network, &state.positions, &mut accelerations);
    let (mut push, mut turn) = ([0.0; 2], 0.0);
    for (p, square) in network.squares.iter().enumerate() {
        let [x, y, theta] = [0, 1, 2].map(|c| accelerations[3 * p + c]);
        push[0] += square.mass * x;
        push[1] += square.mass * y;
        turn += square.inertia * theta
            + square.mass * (state.positions[3 * p] * y - state.positions[3 * p + 1] * x);
    }
    assert!(push[0].abs() < 1e-12 && push[1].abs() < 1e-12 && turn.abs() < 1e-11);
    let mut turned = state.clone();
    let (sine, cosine) = 0.7f64.sin_cos();
    for square in turned.positions.chunks_exact_mut(3) {
        let [x, y] = [square[0], square[1]];
        square[0] = cosine * x - sine * y;
        square[1] = sine * x + cosine * y;
        square[2] += 0.7;
    }
    let after = load.accelerate(&network, &turned.positions, &mut accelerations);
    assert!((energy - after).abs() < 1e-10);
    // And the energy is that of the strain of the log.
    let gradient: Matrix2<f64> = deformation_gradient(
        &corners(&network, &first.positions),
        &corners(&network, &state.positions),
    )
    .unwrap();
    let strain = biot_strain(&gradient);
    let area = reference_area(&network, &first);
    let expected = -area * (0.4 * strain[(0, 0)] + 0.1 * strain[(1, 1)]);
    assert!((energy - expected).abs() < 1e-11);
}

/// Squares in a double well with collisions: the error of the energy falls with the square of the
/// step.
#[test]
fn the_energy_is_kept_to_second_order_under_tabulated_potentials() {
    let network = lattice(4, 0.5);
    let state = drawn_start(&network, 3, None);
    for motion in [
        Motion {
            angle_potential: Some(double_well(0.2, 80)),
            ..Motion::default()
        },
        Motion {
            opening_potential: Some(double_well(0.2, 80)),
            ..Motion::default()
        },
        Motion {
            stress: Stress {
                xx: -0.05,
                yy: 0.02,
            },
            ..Motion::default()
        },
    ] {
        let motion = Motion {
            meeting: Meetings::Ignored,
            ..motion
        };
        let error = |steps: u32| {
            let mut state = state.clone();
            let mut mover = Mover::new(&motion, network.clone(), &state).unwrap();
            let first = mover.energy(&state);
            let mut largest = 0.0_f64;
            for number in 0..steps {
                let step = 2.0 / f64::from(steps);
                mover.step(&mut state, step, u64::from(number)).unwrap();
                largest = largest.max((mover.energy(&state) - first).abs());
            }
            largest / first.abs()
        };
        let (coarse, fine) = (error(1000), error(2000));
        assert!(fine < 1e-3, "{coarse} {fine}");
        assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
    }
}

/// Two squares on a short rod in a heat bath: the opening follows exp(-V/kT) times the share of the
/// rods, which for one rod does not depend on a rotation of both but on the angle between them: the
/// mean energy is that of a direct sum over the same distribution, drawn by Metropolis from the
/// angles with the determinant of the rod.
#[test]
fn a_heat_bath_samples_the_angle_potential() {
    let network = crate::common::two_squares([2, 1], 0.5);
    let first = State {
        time: 0.0,
        positions: vec![0.0, 0.0, -FRAC_PI_4, 2.5, 0.0, FRAC_PI_4],
        velocities: vec![0.0; 6],
    };
    let kt = 0.5;
    let angles: Vec<f64> = (0..200).map(|k| -4.0 + 0.04 * f64::from(k)).collect();
    let energies: Vec<f64> = angles
        .iter()
        .map(|x| 0.5 * 4.0 * (x + 0.4).powi(2))
        .collect();
    let spline = Spline::through(&angles, &energies, Ends::Straight).unwrap();
    let motion = Motion {
        angle_potential: Some(spline.clone()),
        meeting: Meetings::Ignored,
        bath: Some(Langevin::new(kt, 1.0, 4, 0).unwrap()),
        ..Motion::default()
    };
    let mut state = first.clone();
    let mut mover = Mover::new(&motion, network.clone(), &first).unwrap();
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for number in 0..400_000 {
        mover.step(&mut state, 0.02, number).unwrap();
        let opening = openings(&network, &state.positions).unwrap()[0];
        sum += opening;
        squares += opening * opening;
        count += 1.0;
    }
    let mean: f64 = sum / count;
    let variance = squares / count - mean * mean;
    // The rod's length constrains positions; √det A = √(2/m + (τ² + τ'²)/I), with τ the arms across
    // the rod: averaged over the directions of the rod at either end, here by a sum.
    let (mut norm, mut first_moment, mut second_moment) = (0.0, 0.0, 0.0);
    for k in 0..4000 {
        let opening = -4.0 + 0.002 * f64::from(k);
        let mut share = 0.0;
        for n in 0..720 {
            let rod = f64::from(n) * 2.0 * PI / 720.0;
            // φ = θ - θ' with the sign of the first: arms at θ + 45° and θ' + 135°.
            let (a, b) = (FRAC_PI_4 + opening - rod, 3.0 * FRAC_PI_4 - rod);
            share += (2.0 + 3.0 * (a.sin().powi(2) + b.sin().powi(2))).sqrt();
        }
        let weight = share * (-spline.evaluate(opening)[0] / kt).exp();
        norm += weight;
        first_moment += weight * opening;
        second_moment += weight * opening * opening;
    }
    let expected = first_moment / norm;
    let spread = second_moment / norm - expected * expected;
    // Some 2000 independent openings: errors of 0.008 and 3 %.
    assert!((mean - expected).abs() < 0.03, "{mean} {expected}");
    assert!(
        (variance / spread - 1.0).abs() < 0.12,
        "{variance} {spread}"
    );
}

/// A pull along x and its fluctuations: the change of the mean strains with the load is that of the
/// covariances, within errors. Squares pass through each other, and joints hold them half open, so
/// that the response is linear.
#[test]
fn the_response_to_a_load_is_that_of_the_fluctuations() {
    let network: Arc<Network> = lattice(3, 0.5);
    let first = State::coherent(&network, 0.5);
    let kt = 0.05;
    let angles: Vec<f64> = (0..200).map(|k| -3.0 + 0.04 * f64::from(k)).collect();
    let energies: Vec<f64> = angles.iter().map(|x| 0.5 * (x - 1.0).powi(2)).collect();
    let spline = Spline::through(&angles, &energies, Ends::Straight).unwrap();
    let run = |stress: Stress, seed: u64| {
        let motion = Motion {
            angle_potential: Some(spline.clone()),
            stress,
            meeting: Meetings::Ignored,
            bath: Some(Langevin::new(kt, 1.0, seed, 0).unwrap()),
            ..Motion::default()
        };
        let mut state = first.clone();
        let mut mover = Mover::new(&motion, network.clone(), &first).unwrap();
        let before = corners(&network, &first.positions);
        let mut strains = Vec::new();
        for number in 0..160_000u64 {
            mover.step(&mut state, 0.02, number).unwrap();
            if number > 2000 && number % 10 == 0 {
                let now = corners(&network, &state.positions);
                let strain = biot_strain(&deformation_gradient(&before, &now).unwrap());
                strains.push([strain[(0, 0)], strain[(1, 1)]]);
            }
        }
        let blocks: Vec<[f64; 2]> = strains
            .chunks(strains.len() / 20)
            .take(20)
            .map(|block| {
                let mean = |axis: usize| {
                    block.iter().map(|strain| strain[axis]).sum::<f64>() / block.len() as f64
                };
                [mean(0), mean(1)]
            })
            .collect();
        (strains, blocks)
    };
    let pull = 0.012;
    let area = reference_area(&network, &first);
    let (up, up_blocks) = run(Stress { xx: pull, yy: 0.0 }, 1);
    let (down, down_blocks) = run(Stress { xx: -pull, yy: 0.0 }, 2);
    let mut own = 0.0;
    for axis in 0..2 {
        let responses: Vec<f64> = up_blocks
            .iter()
            .zip(&down_blocks)
            .map(|(up, down)| (up[axis] - down[axis]) / (2.0 * pull))
            .collect();
        let moments = RunningMoments::in_two_passes(&responses);
        let (response, response_error) = (moments.mean(), moments.independent_standard_error());
        let covariance = |strains: &[[f64; 2]]| {
            let count = strains.len() as f64;
            let [x, y] = [0, axis].map(|a| strains.iter().map(|s| s[a]).sum::<f64>() / count);
            strains
                .iter()
                .map(|s| (s[0] - x) * (s[axis] - y))
                .sum::<f64>()
                / count
        };
        let of_blocks: Vec<f64> = up
            .chunks(up.len() / 10)
            .chain(down.chunks(down.len() / 10))
            .filter(|block| block.len() > 100)
            .map(|block| area * covariance(block) / kt)
            .collect();
        let moments = RunningMoments::in_two_passes(&of_blocks);
        let (fluctuation, error) = (
            area * 0.5 * (covariance(&up) + covariance(&down)) / kt,
            moments.independent_standard_error(),
        );
        eprintln!("axis {axis}: {response} ± {response_error}, {fluctuation} ± {error}");
        assert!(
            (response - fluctuation).abs() < 4.0 * response_error.hypot(error),
            "{response} ± {response_error}, {fluctuation} ± {error}"
        );
        if axis == 0 {
            own = fluctuation;
        }
        assert!(response_error.hypot(error) < 0.1 * own);
    }
}
