//! Energies of pairs and of heights in addition to the contacts: plain sums, exact orbits and averages, what is kept.

use crate::common::polytope;
use protomer_kernel::height_energy::{HeightCurve, HeightTable};
use protomer_kernel::pair_energy::{PairPotential, PosedPair, Sum, Term};
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::statistics::summarize;
use protomer_kernel::{Boundary, Rotation, Vec3};
use protomer_md::Error;
use protomer_md::added::Added;
use protomer_md::bath::Ensemble;
use protomer_md::body::Kind;
use protomer_md::drift::Drift;
use protomer_md::engine::{Engine, Motion, Settings};
use protomer_md::pair::Form;
use protomer_md::start::{on_a_lattice, set_velocities};
use protomer_md::state::{Bodies, State};

const NVE: Settings = Settings {
    interaction: protomer_md::pair::Interaction {
        form: Form::Smooth,
        attraction: protomer_md::pair::radial::Attraction::NONE,
        central: protomer_md::pair::central::Central::None,
    },
    time_step: 1e-3,
    ensemble: Ensemble::Nve,
    seed: 1,
    is_threaded: false,
};

/// A well with a wall inside of it, as a table whose spline has no swing.
fn table(wall: f64, depth: f64, range: f64) -> Term {
    let distances: Vec<f64> = (0..=24)
        .map(|row| 0.9 + (range - 0.9) * f64::from(row) / 24.0)
        .collect();
    let energy = |r: &f64| {
        let part = (range - r) / (range - 0.9);
        part * part * (wall * part * part - depth * 6.0 * (1.0 - part))
    };
    Term::Radial {
        energies_kt: distances.iter().map(energy).collect(),
        distances,
        curve: None,
    }
}

/// Charges of both signs at four corners of a body, three of them off its planes of symmetry.
fn charges(dimension: usize, cut_off: f64) -> Term {
    let sites = [
        [0.3, 0.1, 0.2],
        [-0.3, 0.2, 0.1],
        [0.1, -0.3, -0.2],
        [0.0, 0.0, 0.0],
    ];
    Term::Charges {
        positions: sites.map(|site| site[..dimension].to_vec()).to_vec(),
        charges_e: vec![1.0, -2.0, 1.5, 0.5],
        bjerrum_length: 0.7,
        debye_length: 0.5,
        cut_off,
    }
}

fn valley(length: f64) -> HeightTable {
    let heights: Vec<f64> = (0..=20).map(|row| length * f64::from(row) / 20.0).collect();
    let mut energies_kt: Vec<f64> = heights
        .iter()
        .map(|z| (std::f64::consts::TAU * z / length).cos())
        .collect();
    energies_kt[20] = energies_kt[0];
    HeightTable {
        heights,
        energies_kt,
    }
}

fn fluid(kind: Kind, count: usize, density: f64) -> (Bodies, State) {
    let bodies = Bodies::of_one_kind(kind, count);
    let mut state = on_a_lattice(&bodies, density, 3).unwrap();
    set_velocities(&mut state, &bodies, 1.0, 3).unwrap();
    (bodies, state)
}

/// The fast path is the list of neighbours with splines and turned sites; its twin is a plain double loop over all bodies
/// with the energies of Monte Carlo.
#[test]
fn the_energy_is_a_plain_sum_over_all_pairs_and_heights() {
    let temperature = 1.7;
    for (name, count, density) in [("polygon:5", 49, 0.3), ("octahedron", 64, 0.2)] {
        let kind = Kind::from_polytope(&polytope(name)).unwrap();
        let (bodies, state) = fluid(kind, count, density);
        let dimension = bodies.dimension();
        let terms = [table(2.0, 1.0, 2.2), charges(dimension, 1.2)];
        let Boundary::Periodic { lengths_angstrom } = state.space else {
            panic!("a periodic box");
        };
        let length = lengths_angstrom[dimension - 1];
        let field = valley(length);
        let added = Added::new(&terms, Some(&field), dimension, temperature).unwrap();
        let plain = |state: &State| -> [f64; 3] {
            let curve = HeightCurve::through(&field).unwrap();
            let heights = state.positions.iter().map(|place| {
                let height = place[dimension - 1] + 0.5 * length;
                curve.evaluate(height - length * (height / length).floor())[0]
            });
            let of_heights: f64 = heights.sum();
            let (mut of_pairs, mut virial) = (0.0, 0.0);
            for first in 0..count {
                for second in first + 1..count {
                    let between = state.positions[second] - state.positions[first];
                    let nearest =
                        between.zip_map(&lengths_angstrom, |x, edge| x - edge * (x / edge).round());
                    let turns = [state.rotation(first), state.rotation(second)];
                    let both = [&turns[0], &turns[1]];
                    let smooth = as_splines(&terms);
                    let [u, w] = match dimension {
                        2 => of_pair(
                            &Sum::<2>::new(&smooth).unwrap(),
                            [nearest.x, nearest.y],
                            both,
                        ),
                        _ => of_pair(&Sum::<3>::new(&smooth).unwrap(), nearest.into(), both),
                    };
                    of_pairs += u;
                    virial += w;
                }
            }
            [of_pairs, of_heights, virial].map(|sum| temperature * sum)
        };
        let mut engine = Engine::with_added(bodies, state, NVE, added).unwrap();
        for _ in 0..3 {
            let [of_pairs, of_heights, virial] = plain(&engine.motion().state);
            let energy = of_pairs + of_heights;
            let parts = engine.added_energies();
            for (part, plain) in [(parts.pairs, of_pairs), (parts.heights, of_heights)] {
                assert!(
                    (part.unwrap() - plain).abs() < 1e-9 * energy.abs(),
                    "{name}: {part:?} {plain}"
                );
            }
            let found = engine.motion();
            assert!(
                (found.potential_energy - energy).abs() < 1e-9 * energy.abs(),
                "{name}"
            );
            assert!(
                (found.virial - virial).abs() < 1e-9 * virial.abs(),
                "{name}"
            );
            engine.step(1.0).unwrap();
        }
    }
}

fn as_splines(terms: &[Term]) -> Vec<Term> {
    let mut terms = terms.to_vec();
    for term in &mut terms {
        if let Term::Radial { curve, .. } = term {
            *curve = Some(protomer_kernel::pair_energy::Curve::Spline);
        }
    }
    terms
}

fn of_pair<const D: usize>(sum: &Sum<D>, offset: [f64; D], turns: [&Rotation; 2]) -> [f64; 2] {
    let pair = PosedPair::new(offset, turns);
    match pair.distance < sum.range() {
        true => [sum.energy_kt(&pair), sum.virial_kt(&pair)],
        false => [0.0; 2],
    }
}

/// A body whose file has it askew is turned to its principal axes, and its sites with it.
#[test]
fn sites_are_in_the_frame_of_the_file() {
    let askew = Rotation::from_scaled_axis(Vec3::new(0.4, -0.3, 0.8));
    let corners: Vec<Vec3> = by_name("cuboid:0.6,0.8,1")
        .unwrap()
        .corner_points()
        .iter()
        .map(|corner| askew * corner)
        .collect();
    let shape = Shape::solid(&corners).unwrap();
    let kind = Kind::from_polytope(&Polytope::from_shape(&shape).unwrap()).unwrap();
    assert!(kind.frame.angle() > 0.1);
    // Turned back, the corners are those of the file.
    let back = kind.frame.inverse();
    for corner in &kind.parts[0].polytope.corners {
        let nearest = corners.iter().map(|other| (back * corner - other).norm());
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-9);
    }
    let bodies = Bodies::of_one_kind(kind, 2);
    let apart = Vec3::new(1.9, 0.3, -0.2);
    let mut state = State::at_rest(&bodies, Boundary::Open, vec![Vec3::zeros(), apart]);
    let turns = [
        Rotation::identity(),
        Rotation::from_scaled_axis(Vec3::new(0.1, 1.0, 0.3)),
    ];
    for (rotation, turn) in state.rotations.iter_mut().zip(&turns) {
        *rotation = turn * back;
    }
    let terms = [charges(3, 4.0)];
    let added = Added::new(&terms, None, 3, 1.0).unwrap();
    let engine = Engine::with_added(bodies, state, NVE, added).unwrap();
    let pair = PosedPair::new(apart.into(), [&turns[0], &turns[1]]);
    let expected = Sum::<3>::new(&terms).unwrap().energy_kt(&pair);
    assert!(
        (engine.motion().potential_energy - expected).abs() < 1e-12,
        "{expected}"
    );
    assert!(expected.abs() > 1e-4);
}

/// Two charged balls go around each other in a circle: m ω² r/2 = |F(r)|.
#[test]
fn charges_in_a_table_circle_each_other_with_their_exact_period() {
    let (charge, length, cut_off, radius) = (2.0_f64, 1.5_f64, 9.0, 0.3);
    let ball = Kind::ball(3, radius).unwrap();
    let mass = ball.mass;
    let bodies = Bodies {
        kinds: vec![ball],
        kind_of: vec![0, 0],
    };
    // Sites of all bodies are equal, so a repulsive pair of charges is held by a table.
    let slope = 3.0;
    let hold = Term::Radial {
        distances: vec![0.5, 8.0, 9.0, 10.0],
        energies_kt: vec![-slope * 9.5, -slope * 2.0, -slope, 0.0],
        curve: None,
    };
    let site = Term::Charges {
        positions: vec![vec![0.0; 3]],
        charges_e: vec![charge],
        bjerrum_length: 1.0,
        debye_length: length,
        cut_off,
    };
    let distance = 1.4_f64;
    let decay = charge * charge * (-distance / length).exp() / distance;
    let repulsion = decay * (1.0 / length + 1.0 / distance);
    let h = 1e-5;
    let held = Sum::<3>::new(&as_splines(std::slice::from_ref(&hold))).unwrap();
    let turn = Rotation::identity();
    let energy = |r: f64| held.energy_kt(&PosedPair::new([r, 0.0, 0.0], [&turn, &turn]));
    let pull = (energy(distance + h) - energy(distance - h)) / (2.0 * h) - repulsion;
    assert!(pull > 0.5, "{pull}");
    let rate = (2.0 * pull / (mass * distance)).sqrt();
    let period = std::f64::consts::TAU / rate;
    let place = 0.5 * distance * Vec3::x();
    let mut state = State::at_rest(&bodies, Boundary::Open, vec![place, -place]);
    state.velocities = vec![
        0.5 * distance * rate * Vec3::y(),
        -0.5 * distance * rate * Vec3::y(),
    ];
    let off = |steps: u32| {
        let settings = Settings {
            time_step: period / f64::from(steps),
            ..NVE
        };
        let added = Added::new(&[hold.clone(), site.clone()], None, 3, 1.0).unwrap();
        let mut engine =
            Engine::with_added(bodies.clone(), state.clone(), settings, added).unwrap();
        let mut farthest = 0.0_f64;
        for _ in 0..steps {
            engine.step(1.0).unwrap();
            let [first, second] = [0, 1].map(|body| engine.motion().state.positions[body]);
            farthest = farthest.max(((first - second).norm() - distance).abs());
        }
        let end = (engine.motion().state.positions[0] - place).norm();
        [end, farthest]
    };
    let [coarse, fine] = [off(500), off(1000)];
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        assert!((coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
        assert!(fine < 1e-4, "{fine}");
    }
}

/// Velocity Verlet: the noise falls with the square of the step, and nothing drifts.
#[test]
fn the_energy_is_kept_with_tables_charges_and_heights() {
    for (name, count, density) in [("polygon:4", 36, 0.3), ("cube", 27, 0.14)] {
        let kind = Kind::from_polytope(&polytope(name)).unwrap();
        let (bodies, state) = fluid(kind, count, density);
        let dimension = bodies.dimension();
        let Boundary::Periodic { lengths_angstrom } = state.space else {
            panic!("a periodic box");
        };
        let field = valley(lengths_angstrom[dimension - 1]);
        let terms = [table(2.0, 1.0, 2.2), charges(dimension, 1.6)];
        let noise = |time_step: f64| {
            let settings = Settings { time_step, ..NVE };
            let added = Added::new(&terms, Some(&field), dimension, 1.0).unwrap();
            let mut engine =
                Engine::with_added(bodies.clone(), state.clone(), settings, added).unwrap();
            let mut drift = Drift::default();
            let mut lowest = 0.0_f64;
            for step in 0..(0.6 / time_step).round() as usize {
                engine.step(1.0).unwrap();
                drift.push(step as f64 * time_step, engine.energy());
                lowest = lowest.min(engine.motion().potential_energy);
            }
            assert!(lowest.abs() > 1.0, "{name}: {lowest}");
            [drift.noise(), drift.along_the_line()].map(|x| x / count as f64)
        };
        let [coarse, fine] = [noise(4e-4), noise(2e-4)];
        assert!(fine[0] < 2e-5 && fine[1].abs() < 2e-5, "{name} {fine:?}");
        assert!(coarse[0] / fine[0] > 2.5, "{name} {coarse:?} {fine:?}");
    }
}

/// Two balls in a periodic box: the share of time within the range of the table is that of exp(-u).
#[test]
fn two_balls_meet_as_often_as_their_table_says() {
    let (radius, range, depth) = (0.4, 1.9, 1.2);
    let ball = Kind::ball(3, radius).unwrap();
    let mass = ball.mass;
    let bodies = Bodies::of_one_kind(ball, 2);
    let edge = 4.4_f64;
    let space = Boundary::Periodic {
        lengths_angstrom: Vec3::repeat(edge),
    };
    let mut state = State::at_rest(
        &bodies,
        space,
        vec![Vec3::zeros(), Vec3::new(1.5, 0.5, 0.0)],
    );
    set_velocities(&mut state, &bodies, 1.0, 1).unwrap();
    let term = table(3.0, depth, range);
    let settings = Settings {
        time_step: 1e-3,
        ensemble: Ensemble::Langevin {
            temperature: 1.0,
            friction: 2.0 / mass.sqrt(),
        },
        ..NVE
    };
    let added = Added::new(std::slice::from_ref(&term), None, 3, 1.0).unwrap();
    let mut engine = Engine::with_added(bodies, state, settings, added).unwrap();
    let (mut shares, mut energies) = (Vec::new(), Vec::new());
    for _ in 0..60_000 {
        for _ in 0..20 {
            engine.step(1.0).unwrap();
        }
        let places = &engine.motion().state.positions;
        let between = (places[1] - places[0]).map(|x| x - edge * (x / edge).round());
        shares.push(f64::from(u8::from(between.norm() < range)));
        energies.push(engine.motion().potential_energy);
    }
    // The contact repulsion of two balls whose surfaces are x apart, with σ_c = 0.15 of their diameter.
    let sigma = 0.15 * 2.0 * radius;
    let held = Sum::<3>::new(&as_splines(&[term])).unwrap();
    let turn = Rotation::identity();
    let energy = |r: f64| {
        let gap = r - 2.0 * radius;
        let contact = match gap {
            gap if gap <= 0.0 => return f64::INFINITY,
            gap if gap < 2.0_f64.powf(1.0 / 6.0) * sigma => {
                let sixth = (sigma / gap).powi(6);
                4.0 * (sixth * sixth - sixth) + 1.0
            }
            _ => 0.0,
        };
        contact + held.energy_kt(&PosedPair::new([r, 0.0, 0.0], [&turn, &turn]))
    };
    let (mut inside, mut mean) = (0.0, 0.0);
    let step = 1e-4;
    for cell in 0..(range / step) as usize {
        let r = step * (cell as f64 + 0.5);
        let weight = 4.0 * std::f64::consts::PI * r * r * step * (-energy(r)).exp();
        inside += weight;
        if weight > 0.0 {
            mean += weight * energy(r);
        }
    }
    let outside = edge.powi(3) - 4.0 / 3.0 * std::f64::consts::PI * range.powi(3);
    let total = inside + outside;
    for (series, exact) in [(shares, inside / total), (energies, mean / total)] {
        let found = summarize(&series);
        assert!(
            found.standard_error < 0.06 * exact.abs(),
            "{exact} {found:?}"
        );
        assert!(
            (found.mean - exact).abs() < 4.0 * found.standard_error,
            "{exact} {found:?}"
        );
    }
}

/// A thin gas between walls of a table with a slope between them: the density falls with the barometric formula.
#[test]
fn a_thin_gas_has_its_barometric_profile() {
    const COUNT: usize = 32;
    let bodies = Bodies::of_one_kind(Kind::ball(3, 0.1).unwrap(), COUNT);
    let edge = 6.0_f64;
    let mut state = on_a_lattice(&bodies, COUNT as f64 / edge.powi(3), 1).unwrap();
    set_velocities(&mut state, &bodies, 1.0, 1).unwrap();
    // Walls of 10 kT at both ends; the weight is half a kT per length.
    let wall = |x: f64, high: f64| high * (1.0 - x / 0.75).max(0.0).powi(3);
    let heights: Vec<f64> = (0..=80).map(|row| edge * f64::from(row) / 80.0).collect();
    let energy = |z: &f64| 0.5 * z + wall(*z, 10.0) + wall(edge - z, 7.0);
    let mut energies_kt: Vec<f64> = heights.iter().map(energy).collect();
    energies_kt[80] = energies_kt[0];
    let field = HeightTable {
        heights,
        energies_kt,
    };
    let curve = HeightCurve::through(&field).unwrap();
    let settings = Settings {
        time_step: 5e-5,
        ensemble: Ensemble::Langevin {
            temperature: 1.0,
            friction: 5.0,
        },
        ..NVE
    };
    let added = Added::new(&[], Some(&field), 3, 1.0).unwrap();
    let mut engine = Engine::with_added(bodies, state, settings, added).unwrap();
    let run = |engine: &mut Engine, steps: usize| {
        for _ in 0..steps {
            engine.step(1.0).unwrap();
        }
    };
    run(&mut engine, 40_000);
    let mut series = vec![Vec::new(); 4];
    for _ in 0..12_000 {
        run(&mut engine, 80);
        let mut shares = [0.0; 4];
        for place in &engine.motion().state.positions {
            let height = (place.z + 0.5 * edge).rem_euclid(edge);
            shares[((height / edge * 4.0) as usize).min(3)] += 1.0 / COUNT as f64;
        }
        for (series, share) in series.iter_mut().zip(shares) {
            series.push(share);
        }
    }
    let weight = |from: f64, to: f64| -> f64 {
        let step = (to - from) / 10_000.0;
        let middle = |cell: i32| from + step * (f64::from(cell) + 0.5);
        (0..10_000)
            .map(|cell| step * (-curve.evaluate(middle(cell))[0]).exp())
            .sum()
    };
    let total = weight(0.0, edge);
    for (layer, series) in series.iter().enumerate() {
        let from = edge * layer as f64 / 4.0;
        let exact = weight(from, from + 0.25 * edge) / total;
        let found = summarize(series);
        assert!(
            found.standard_error < 0.1 * exact,
            "{layer} {exact} {found:?}"
        );
        assert!(
            (found.mean - exact).abs() < 4.0 * found.standard_error,
            "{layer} {exact} {found:?}"
        );
    }
}

/// The momentum along the last axis is free, and with it one more degree of freedom.
#[test]
fn a_field_takes_momentum_along_the_last_axis_alone() {
    let (bodies, state) = fluid(Kind::from_polytope(&polytope("cube")).unwrap(), 27, 0.14);
    let Boundary::Periodic { lengths_angstrom } = state.space else {
        panic!("a periodic box");
    };
    let field = valley(lengths_angstrom.z);
    let added = Added::new(&[], Some(&field), 3, 1.0).unwrap();
    let mut engine = Engine::with_added(bodies.clone(), state.clone(), NVE, added).unwrap();
    assert_eq!(engine.movements(), 3 * 26 + 1);
    assert_eq!(Engine::new(bodies, state, NVE).unwrap().movements(), 3 * 26);
    for _ in 0..200 {
        engine.step(1.0).unwrap();
    }
    let momentum = engine.motion().state.momentum(engine.bodies());
    assert!(
        momentum.xy().norm() < 1e-12 && momentum.z.abs() > 1e-3,
        "{momentum}"
    );
}

#[test]
fn threads_and_going_on_change_no_bit() {
    let kind = Kind::from_polytope(&polytope("cube")).unwrap();
    let (bodies, state) = fluid(kind, 729, 0.14);
    let Boundary::Periodic { lengths_angstrom } = state.space else {
        panic!("a periodic box");
    };
    let field = valley(lengths_angstrom.z);
    let added = Added::new(
        &[charges(3, 1.6), table(2.0, 1.0, 2.2)],
        Some(&field),
        3,
        1.0,
    )
    .unwrap();
    let mut one = Engine::with_added(bodies.clone(), state, NVE, added.clone()).unwrap();
    assert!(one.motion().neighbours.pairs.len() > 2000);
    for _ in 0..20 {
        one.step(1.0).unwrap();
    }
    let text = serde_json::to_string(one.motion()).unwrap();
    let saved: Motion = serde_json::from_str(&text).unwrap();
    let threaded = Settings {
        is_threaded: true,
        ..NVE
    };
    let mut many = Engine::continued_with_added(bodies, saved, threaded, added).unwrap();
    for _ in 0..40 {
        one.step(1.0).unwrap();
        many.step(1.0).unwrap();
    }
    assert_eq!(one.motion(), many.motion());
}

#[test]
fn energies_that_cannot_move_bodies_say_why() {
    let new =
        |terms: &[Term], field: Option<&HeightTable>| Added::new(terms, field, 3, 1.0).map(|_| ());
    let said = |result: Result<(), Error>| result.unwrap_err().to_string();
    let well = Term::SquareWell {
        range: 1.5,
        depth_kt: 1.0,
    };
    let message = said(new(&[well], None));
    assert!(
        message.contains("no finite force") && message.contains("hpmc"),
        "{message}"
    );
    let patches = Term::Patches {
        range: 1.5,
        depth_kt: 1.0,
        half_angle_degrees: 30.0,
        directions: vec![vec![0.0, 0.0, 1.0]],
    };
    assert!(said(new(&[patches], None)).contains("patches"));
    let lines = Term::Radial {
        distances: vec![1.0, 2.0],
        energies_kt: vec![1.0, 0.0],
        curve: Some(protomer_kernel::pair_energy::Curve::Lines),
    };
    assert!(said(new(&[lines], None)).contains("spline"));
    let step = HeightTable {
        heights: vec![0.0, 1.0, 2.0],
        energies_kt: vec![1.0, 0.0, 0.0],
    };
    assert!(said(new(&[], Some(&step))).contains("must be the first one"));

    let (bodies, state) = fluid(Kind::from_polytope(&polytope("cube")).unwrap(), 27, 0.14);
    let with = |bodies: &Bodies, state: &State, settings: Settings, added: Added| {
        Engine::with_added(bodies.clone(), state.clone(), settings, added).map(|_| ())
    };
    let high = Added::new(&[], Some(&valley(100.0)), 3, 1.0).unwrap();
    assert!(said(with(&bodies, &state, NVE, high)).contains("heights from 0 to 100"));
    let field = Added::new(&[], Some(&valley(1.0)), 3, 1.0).unwrap();
    let pressed = Settings {
        ensemble: Ensemble::Npt {
            temperature: 1.0,
            relaxation_time: 0.5,
            pressure: 1.0,
        },
        ..NVE
    };
    assert_eq!(
        with(&bodies, &state, pressed, field.clone()),
        Err(Error::FieldAtPressure)
    );
    let open = State::at_rest(&bodies, Boundary::Open, state.positions.clone());
    assert_eq!(with(&bodies, &open, NVE, field), Err(Error::NoBox));
    let far = Added::new(&[charges(3, 9.0)], None, 3, 1.0).unwrap();
    assert!(matches!(
        with(&bodies, &state, NVE, far),
        Err(Error::SmallBox { .. })
    ));
    let (balls, state) = fluid(Kind::ball(3, 0.5).unwrap(), 27, 0.14);
    let sites = Added::new(&[charges(3, 1.2)], None, 3, 1.0).unwrap();
    assert_eq!(with(&balls, &state, NVE, sites), Err(Error::BallWithSites));
}
