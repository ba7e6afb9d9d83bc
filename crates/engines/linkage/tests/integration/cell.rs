//! A flexible periodic cell: its rows against finite differences, its energy, the coherent motion in
//! closed form, and the heat bath.

use crate::common::brute_force::{corner, smallest_height};
use crate::common::{engine, loose};
use nalgebra::DMatrix;
use protomer_kernel::random::CounterRng;
use protomer_kernel::spline::{Ends, Spline};
use protomer_kernel::statistics::summarize;
use protomer_linkage::analysis::elastic::{LoadedRun, response};
use protomer_linkage::analysis::strain::{biot_strain, gradient_between};
use protomer_linkage::lattice::contact::candidates::{Body, Candidates};
use protomer_linkage::lattice::force::coherent_part;
use protomer_linkage::lattice::load::reference_area;
use protomer_linkage::lattice::pair::SquareCharge;
use protomer_linkage::lattice::rods::RodSystem;
use protomer_linkage::lattice::{
    Cell, Charges, Contact, Corner, Dynamics, Edges, Langevin, Load, Meetings, Motion, Mover,
    Network, Projector, Screening, Square, Start, StartVelocities, State, Stress,
};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// The opening at which the lattices start: rows and columns are not straight there.
const ANGLE: f64 = 0.3;

fn flexible(rows: usize, columns: usize, rod_length: f64, mass: f64) -> Network {
    Network::lattice(
        rows,
        columns,
        rod_length,
        Square::default(),
        Edges::Periodic,
        ANGLE,
    )
    .unwrap()
    .with_flexible_cell(mass)
    .unwrap()
}

/// Squares of different mass on their rods, off the coherent state, in a sheared cell.
fn disordered(mass: f64) -> (Network, State) {
    let mut network = flexible(2, 4, 0.6, mass);
    network.squares[2].mass = 2.0;
    network.squares[5].inertia = 0.7;
    let mut state = State::coherent(&network, ANGLE);
    let mut rng = CounterRng::new(5, 0, 0);
    for coordinate in &mut state.positions {
        *coordinate += rng.uniform_in(-0.05, 0.05);
    }
    Projector::new(&network)
        .positions(&mut state.positions)
        .unwrap();
    assert!(Cell::read(&network, &state.positions).xy.abs() > 1e-3);
    (network, state)
}

fn masses(network: &Network) -> Vec<f64> {
    let mut masses = Vec::new();
    for square in &network.squares {
        masses.extend([square.mass, square.mass, square.inertia]);
    }
    masses.extend([network.cell_mass.unwrap(); 3]);
    masses
}

/// J by differences of σ.
fn jacobian(network: &Network, positions: &[f64]) -> DMatrix<f64> {
    let mut rods = RodSystem::new(network);
    let (count, h) = (network.rods.len(), 1e-4);
    let mut jacobian = DMatrix::zeros(count, positions.len());
    for coordinate in 0..positions.len() {
        let mut column = vec![0.0; count];
        for sign in [1.0, -1.0] {
            let mut moved = positions.to_vec();
            moved[coordinate] += sign * h;
            let mut sigma = vec![0.0; count];
            rods.violations(&moved, &mut sigma);
            for (column, sigma) in column.iter_mut().zip(sigma) {
                *column += sign * sigma / (2.0 * h);
            }
        }
        for (rod, slope) in column.into_iter().enumerate() {
            jacobian[(rod, coordinate)] = slope;
        }
    }
    jacobian
}

#[test]
fn rows_of_rods_are_those_of_finite_differences() {
    let (network, state) = disordered(0.7);
    let expected = jacobian(&network, &state.positions);
    let mut rods = RodSystem::new(&network);
    rods.linearize(&state.positions, 0.0).unwrap();
    let (count, coordinates) = (network.rods.len(), network.coordinates());
    let mut largest = 0.0_f64;
    for coordinate in 0..coordinates {
        let mut unit = vec![0.0; coordinates];
        unit[coordinate] = 1.0;
        let mut column = vec![0.0; count];
        rods.apply(&unit, &mut column);
        for (rod, slope) in column.into_iter().enumerate() {
            largest = largest.max((slope - expected[(rod, coordinate)]).abs());
        }
    }
    assert!(largest < 1e-7, "{largest:e}");
    // A of the sparse factors is J M⁻¹ Jᵀ of the dense matrices.
    let masses = masses(&network);
    let mut scaled = expected.clone();
    for (coordinate, mass) in masses.iter().enumerate() {
        scaled.column_mut(coordinate).scale_mut(1.0 / mass);
    }
    let gram = &scaled * expected.transpose();
    for rod in 0..count {
        let mut solution = vec![0.0; count];
        solution[rod] = 1.0;
        rods.solve(&mut solution);
        let product = &gram * DMatrix::from_column_slice(count, 1, &solution);
        for (other, number) in product.iter().enumerate() {
            let unit = if other == rod { 1.0 } else { 0.0 };
            assert!((number - unit).abs() < 1e-6, "{rod} {other}: {number}");
        }
    }
    // And M⁻¹ Jᵀ λ.
    let multipliers: Vec<f64> = (0..count).map(|rod| (rod as f64).cos()).collect();
    let mut response = vec![0.0; coordinates];
    rods.add_response(&multipliers, 1.0, &mut response);
    let expected = scaled.transpose() * DMatrix::from_column_slice(count, 1, &multipliers);
    for (found, expected) in response.iter().zip(expected.iter()) {
        assert!((found - expected).abs() < 1e-6);
    }
}

/// Charges at the sides of the squares.
fn charges() -> Charges {
    let charge = |x, y, charge| SquareCharge {
        position: [x, y],
        charge,
    };
    Charges {
        on_square: vec![charge(0.5, 0.1, 1.0), charge(-0.2, 0.4, -2.0)],
        screening: Screening {
            bjerrum_length_angstrom: 7.0,
            debye_length_angstrom: 9.6,
            kt: 0.1,
        },
        scale_angstrom: 14.0,
    }
}

#[test]
fn forces_on_the_cell_are_those_of_finite_differences() {
    let (network, state) = disordered(0.7);
    let motion = Motion {
        charges: Some(charges()),
        stress: Stress { xx: 0.3, yy: -0.2 },
        ..Motion::default()
    };
    let first = State::coherent(&network, ANGLE);
    let masses = masses(&network);
    for force in motion.forces(&network, &first).unwrap() {
        let mut accelerations = vec![0.0; network.coordinates()];
        force.accelerate(&network, &state.positions, &mut accelerations);
        for (coordinate, (acceleration, mass)) in accelerations.iter().zip(&masses).enumerate() {
            let energy = |change: f64| {
                let mut moved = state.positions.clone();
                moved[coordinate] += change;
                force.accelerate(&network, &moved, &mut vec![0.0; moved.len()])
            };
            let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
            let difference = (acceleration * mass + slope).abs();
            assert!(difference < 1e-8, "{coordinate}: {difference:e}");
        }
    }
}

/// Largest deviations of energy and momentum, and of rods and their rates, in a run without a bath.
fn deviations(step: f64) -> [f64; 4] {
    let (network, mut state) = disordered(2.0);
    let mut rng = CounterRng::new(8, 0, 0);
    for velocity in &mut state.velocities {
        *velocity = rng.uniform_in(-1.0, 1.0);
    }
    Projector::new(&network)
        .velocities(&state.positions, &mut state.velocities)
        .unwrap();
    let load = Load::new(&network, Stress { xx: 0.3, yy: 0.1 }, &state).unwrap();
    let network = Arc::new(network);
    let mut dynamics = Dynamics::new(network.clone(), vec![Box::new(load)], &state).unwrap();
    let energy = |dynamics: &Dynamics, state: &State| {
        state.kinetic_energy(&network) + dynamics.potential_energy()
    };
    let (first, momentum) = (energy(&dynamics, &state), state.momentum(&network));
    let mut largest = [0.0_f64; 4];
    let mut numbers = vec![0.0; network.rods.len()];
    for _ in 0..(2.0 / step).round() as usize {
        dynamics.step(&mut state, step).unwrap();
        let [x, y] = state.momentum(&network);
        let (_, violation) = dynamics.rods().violations(&state.positions, &mut numbers);
        dynamics.rods().apply(&state.velocities, &mut numbers);
        let rate = numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (largest, deviation) in largest.iter_mut().zip([
            energy(&dynamics, &state) - first,
            (x - momentum[0]).abs() + (y - momentum[1]).abs(),
            violation,
            rate,
        ]) {
            *largest = largest.max(deviation.abs());
        }
    }
    let strain = gradient_between(
        &network,
        &State::coherent(&network, ANGLE).positions,
        &state.positions,
    );
    assert!(
        biot_strain(&strain.unwrap()).norm() > 0.01,
        "the cell moves"
    );
    largest
}

#[test]
fn energy_is_kept_to_second_order() {
    let [coarse, fine] = [4e-3, 2e-3].map(deviations);
    let order = (coarse[0] / fine[0]).log2();
    assert!(
        (order - 2.0).abs() < 0.2,
        "order {order}: {coarse:?} {fine:?}"
    );
    for run in [coarse, fine] {
        assert!(
            run[1] < 1e-11 && run[2] < 1e-12 && run[3] < 1e-11,
            "{run:?}"
        );
    }
}

/// Distance of neighbours at an angle, and its slope.
fn spacing(rod_length: f64, angle: f64) -> [f64; 2] {
    let (sine, cosine) = (angle - FRAC_PI_4).sin_cos();
    [2.0 * cosine + rod_length, -2.0 * sine]
}

#[test]
fn coherent_motion_has_its_closed_form() {
    for (rows, columns, rod_length) in [(2, 2, 0.01), (2, 2, 0.35), (4, 6, 3.0 / 22.0)] {
        let network = Arc::new(flexible(rows, columns, rod_length, 3.0));
        let start = Start {
            angle: ANGLE,
            velocities: StartVelocities::Checkerboard { rate: -1.0 },
            ..Start::default()
        };
        let mut state = start.build(&network, 0).unwrap().state;
        let first = state.positions.clone();
        let [from, _] = spacing(rod_length, ANGLE);
        // ½ ω² (Σ I + d'² (Σ m x² + W (columns² + rows²))) is constant.
        let (r, c) = (rows as f64, columns as f64);
        let spread = r * c * (c * c - 1.0 + r * r - 1.0) / 12.0 + 3.0 * (c * c + r * r);
        let inertia = |angle: f64| r * c / 3.0 + spacing(rod_length, angle)[1].powi(2) * spread;
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
        for _ in 0..600 {
            dynamics.step(&mut state, 1e-3).unwrap();
        }
        let [_, angle] = coherent_part(&network, &state.positions);
        let [uniform, rate] = coherent_part(&network, &state.velocities);
        assert!(
            uniform.abs() < 1e-10 && (angle - ANGLE).abs() > 0.3,
            "{angle}"
        );
        let expected = (inertia(ANGLE) / inertia(angle)).sqrt();
        assert!(
            (rate.abs() / expected - 1.0).abs() < 1e-5,
            "{rate} {expected}"
        );
        let [distance, _] = spacing(rod_length, angle);
        let cell = Cell::read(&network, &state.positions);
        for (found, expected) in [
            (cell.xx, c * distance),
            (cell.yy, r * distance),
            (cell.xy, 0.0),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        // Poisson's ratio is -1: both strains are that of the distance.
        let gradient = gradient_between(&network, &first, &state.positions).unwrap();
        let strain = biot_strain(&gradient);
        for axis in 0..2 {
            assert!((strain[(axis, axis)] - (distance / from - 1.0)).abs() < 1e-10);
        }
        assert!((strain[(1, 1)] / strain[(0, 0)] - 1.0).abs() < 1e-8);
    }
}

/// A harmonic potential of every joint about the opening of the start.
fn harmonic(stiffness: f64) -> Spline {
    let angles: Vec<f64> = (0..400).map(|k| -1.5 + 0.01 * f64::from(k)).collect();
    let energy = |angle: &f64| 0.5 * stiffness * (angle - 2.0 * ANGLE).powi(2);
    let energies: Vec<f64> = angles.iter().map(energy).collect();
    Spline::through(&angles, &energies, Ends::Straight).unwrap()
}

/// A lattice in a heat bath without collisions, with springs in its joints: the strains, and the
/// kinetic energies in kT of everything and of each component of the cell, less what the constraints
/// leave of kT/2.
fn bath(stress: f64, steps: u64) -> (Vec<[f64; 2]>, Vec<[f64; 4]>, f64) {
    let network = Arc::new(flexible(4, 4, 0.35, 1.0));
    let (kt, step) = (0.1, 0.02);
    let start = Start {
        angle: ANGLE,
        ..Start::default()
    };
    let mut state = start.build(&network, 0).unwrap().state;
    let first = state.clone();
    let motion = Motion {
        angle_potential: Some(harmonic(2.0)),
        stress: Stress {
            xx: stress,
            yy: 0.0,
        },
        meeting: Meetings::Ignored,
        bath: Some(Langevin::new(kt, 1.0, 3, 0).unwrap()),
        ..Motion::default()
    };
    let mut mover = Mover::new(&motion, network.clone(), &state).unwrap();
    let mut projector = Projector::new(&network);
    let place = 3 * network.squares.len();
    let (mut strains, mut energies) = (Vec::new(), Vec::new());
    for number in 0..steps {
        mover.step(&mut state, step, number).unwrap();
        if number < 1000 || number % 10 > 0 {
            continue;
        }
        let gradient = gradient_between(&network, &first.positions, &state.positions).unwrap();
        let strain = biot_strain(&gradient);
        strains.push([strain[(0, 0)], strain[(1, 1)]]);
        let mut parts = [state.kinetic_energy(&network) / kt, 0.0, 0.0, 0.0];
        for component in 0..3 {
            let rate = state.velocities[place + component];
            let mut unit = vec![0.0; network.coordinates()];
            unit[place + component] = 1.0;
            projector.velocities(&state.positions, &mut unit).unwrap();
            parts[1 + component] = 0.5 * rate * rate / kt - 0.5 * unit[place + component];
        }
        energies.push(parts);
    }
    (strains, energies, reference_area(&network, &first))
}

#[test]
fn the_heat_bath_gives_the_cell_its_share() {
    let (_, energies, _) = bath(0.0, 40_000);
    // 48 coordinates of squares and three of the cell, less 32 rods.
    for (part, expected) in [9.5, 0.0, 0.0, 0.0].into_iter().enumerate() {
        let series: Vec<f64> = energies.iter().map(|parts| parts[part]).collect();
        let summary = summarize(&series);
        let away = (summary.mean - expected).abs() / summary.standard_error;
        assert!(
            away < 4.0 && summary.standard_error < 0.15,
            "{part}: {summary:?}"
        );
    }
}

#[test]
fn a_stress_strains_the_cell_as_its_fluctuations_say() {
    let runs = [-0.05, 0.0, 0.05].map(|stress| (stress, bath(stress, 20_000)));
    let mut loaded = Vec::new();
    for (stress, (strains, ..)) in &runs {
        loaded.push(LoadedRun {
            stress: *stress,
            strains,
        });
    }
    let area = runs[0].1.2;
    let found = response(&loaded, area, 0.1, 20).unwrap();
    eprintln!("{found:?}");
    assert!(found.deviation.abs() < 4.0, "{found:?}");
    let [first, second] = [found.compliance, found.fluctuation_compliance];
    assert!(first.error < 0.1 * first.value, "{found:?}");
    let error = first.error.hypot(second.error);
    assert!(
        (first.value - second.value).abs() < 4.0 * error,
        "{found:?}"
    );
}

/// The rate of every kind of gap across an edge by central differences.
#[test]
fn rows_of_contacts_are_the_gradients_of_gaps() {
    let network = flexible(2, 2, 1.7, 0.7);
    let mut rng = CounterRng::new(3, 0, 0);
    let vertex = |square, vertex| Corner { square, vertex };
    let image = [1, -1];
    // Rods of the last square to the right and below lead across an edge.
    let crossing = |rod: &usize| network.rods[*rod].image != [0, 0];
    let rods: Vec<usize> = (0..network.rods.len()).filter(crossing).collect();
    assert_eq!(rods.len(), 4);
    let coordinates = network.coordinates();
    let mut random = |size: f64| -> Vec<f64> {
        (0..coordinates)
            .map(|_| rng.uniform_in(-size, size))
            .collect()
    };
    for round in 0..200 {
        let (mut positions, velocities) = (random(3.0), random(1.0));
        let check = |contact: Contact, positions: &[f64]| {
            let gap = |time: f64| {
                let moved = positions.iter().zip(&velocities).map(|(s, v)| s + time * v);
                contact.gap(&network, &moved.collect::<Vec<f64>>())
            };
            let rate = (gap(1e-5) - gap(-1e-5)) / 2e-5;
            let row = contact.row(&network, positions).dot(&velocities);
            let close = (rate - row).abs() < 1e-6 * (1.0 + rate.abs());
            assert!(close, "{contact:?}: {rate} {row}");
        };
        let rod = rods[round % rods.len()];
        for side in 0..4 {
            let (striker, target) = (vertex(1, 2), 3);
            check(
                Contact::VertexSide {
                    striker,
                    target,
                    side,
                    image,
                },
                &positions,
            );
            for end in [0, 1] {
                check(Contact::RodStop { rod, end, side }, &positions);
            }
        }
        // Two corners head on, and a corner on a rod: rows are rates where they touch.
        let cell = Cell::read(&network, &positions);
        let [x, y] = cell.shift(image.map(f64::from));
        let (striker, target) = (vertex(1, 2), vertex(3, 4));
        let (from, to) = (corner(&positions, striker), corner(&positions, target));
        positions[3] += to[0] + x - from[0];
        positions[4] += to[1] + y - from[1];
        let head_on = Contact::VertexVertex {
            striker,
            target,
            image,
        };
        assert!(head_on.gap(&network, &positions).abs() < 1e-13);
        check(head_on, &positions);
        let ends = network.rods[rod];
        let free = (0..4).find(|p| *p != ends.from.square && *p != ends.to.square);
        let striker = vertex(free.unwrap(), 3);
        let [dx, dy] = cell.shift(ends.image.map(f64::from));
        let (a, b) = (corner(&positions, ends.from), corner(&positions, ends.to));
        let share = 0.3;
        let from = corner(&positions, striker);
        let place = 3 * striker.square;
        positions[place] += a[0] + share * (b[0] + dx - a[0]) + x - from[0];
        positions[place + 1] += a[1] + share * (b[1] + dy - a[1]) + y - from[1];
        for left in [false, true] {
            let on_rod = Contact::RodCorner {
                striker,
                rod,
                left,
                image,
            };
            assert!(on_rod.gap(&network, &positions).abs() < 1e-13);
            check(on_rod, &positions);
        }
    }
}

#[test]
fn pairs_in_a_leaning_cell_are_those_of_brute_force() {
    let mut rng = CounterRng::new(2, 0, 0);
    for (count, xx, yy, xy) in [
        (60, 30.0, 14.0, 9.0),
        (60, 30.0, 14.0, -40.0),
        (12, 6.5, 5.2, 4.0),
        (3, 3.1, 2.9, -1.2),
    ] {
        let network = loose(count, Some([1.0, 1.0]))
            .with_flexible_cell(1.0)
            .unwrap();
        let cell = Cell { xx, yy, xy };
        for _ in 0..20 {
            let mut positions = Vec::new();
            for _ in 0..count {
                let place = [rng.uniform_in(-1.0, 2.0), rng.uniform_in(-1.0, 1.0)];
                positions.extend(cell.shift(place));
                positions.push(rng.uniform_in(-9.0, 9.0));
            }
            positions.extend(cell.components());
            let list = Candidates::new(&network, &positions, 0.4, true);
            let mut found = Vec::new();
            for pair in list.pairs() {
                found.push((pair.first, pair.second, pair.image));
            }
            let mut expected = Vec::new();
            for (p, q) in (0..count).flat_map(|p| (p..count).map(move |q| (p, q))) {
                for (i, j) in (-12..=12).flat_map(|i| (-12..=12).map(move |j| (i, j))) {
                    let [x, y] = cell.shift([f64::from(i), f64::from(j)]);
                    let x = positions[3 * q] + x - positions[3 * p];
                    let y = positions[3 * q + 1] + y - positions[3 * p + 1];
                    let once = q > p || i > 0 || (i == 0 && j > 0);
                    if x.hypot(y) <= 2.4 && once {
                        expected.push((p, Body::Square(q), [i, j]));
                    }
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected);
        }
    }
}

/// All squares with their nearest images, as squares without a cell.
fn with_images(network: &Network, positions: &[f64]) -> Vec<f64> {
    let cell = Cell::read(network, positions);
    let mut everything = Vec::new();
    for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
        let [x, y] = cell.shift([f64::from(i), f64::from(j)]);
        for square in positions.chunks_exact(3).take(network.squares.len()) {
            everything.extend([square[0] + x, square[1] + y, square[2]]);
        }
    }
    everything
}

#[test]
fn squares_collide_across_the_edges_of_a_flexible_cell() {
    for rod_length in [0.15, 0.7] {
        let network = Arc::new(flexible(4, 4, rod_length, 2.0));
        let mut state = State::coherent(&network, ANGLE);
        let mut rng = CounterRng::new(11, 0, 0);
        for velocity in &mut state.velocities {
            *velocity = rng.uniform_in(-1.0, 1.0);
        }
        Projector::new(&network)
            .velocities(&state.positions, &mut state.velocities)
            .unwrap();
        let mut engine = engine(&network, &state);
        let (energy, momentum) = (state.kinetic_energy(&network), state.momentum(&network));
        let first = state.positions.clone();
        for step in 0..3000 {
            engine.step(&mut state, 0.0025).unwrap();
            if step % 20 == 0 {
                let everything = with_images(&network, &state.positions);
                let height = smallest_height(&loose(144, None), &everything);
                assert!(height > -1e-9, "step {step}: {height:e}");
            }
        }
        let statistics = engine.statistics();
        let change = state.kinetic_energy(&network) / energy - 1.0;
        eprintln!("{rod_length}: {change:e} {statistics:?}");
        assert!(statistics.impacts > 20);
        assert!(change.abs() < 3e-3, "{change:e}");
        assert!(statistics.largest_relative_energy_change < 1e-9);
        let [x, y] = state.momentum(&network);
        assert!((x - momentum[0]).hypot(y - momentum[1]) < 1e-10);
        let gradient = gradient_between(&network, &first, &state.positions).unwrap();
        assert!(biot_strain(&gradient).norm() > 1e-3);
    }
}

/// Free squares in a cell on which only they push: the cell takes the impulses at its edges.
#[test]
fn free_squares_push_the_cell() {
    let network = Arc::new(loose(4, Some([5.0, 5.0])).with_flexible_cell(1.0).unwrap());
    let mut state = State {
        time: 0.0,
        positions: Vec::new(),
        velocities: Vec::new(),
    };
    for (x, y, angle, velocity) in [
        (0.0, 0.0, 0.1, [0.3, -0.2, 0.5]),
        (2.5, 0.1, 0.4, [-0.4, 0.3, -0.3]),
        (0.1, 2.5, 0.2, [0.2, 0.5, 0.1]),
        (2.6, 2.5, 0.7, [-0.1, -0.6, 0.4]),
    ] {
        state.positions.extend([x, y, angle]);
        state.velocities.extend(velocity.map(|rate| 3.0 * rate));
    }
    state.positions.extend([5.0, 5.0, 0.0]);
    state.velocities.extend([-0.1, -0.2, 0.05]);
    let mut engine = engine(&network, &state);
    let (energy, momentum) = (state.kinetic_energy(&network), state.momentum(&network));
    for _ in 0..2000 {
        engine.step(&mut state, 0.005).unwrap();
        let everything = with_images(&network, &state.positions);
        assert!(smallest_height(&loose(36, None), &everything) > -1e-9);
    }
    let impacts = engine.statistics().impacts;
    assert!(impacts >= 5, "{impacts}");
    // Nothing but impacts changes anything, and they keep the energy.
    assert!((state.kinetic_energy(&network) / energy - 1.0).abs() < 1e-11);
    let [x, y] = state.momentum(&network);
    assert!((x - momentum[0]).hypot(y - momentum[1]) < 1e-12);
    assert_ne!(state.velocities[12..], [-0.1, -0.2, 0.05]);
}
