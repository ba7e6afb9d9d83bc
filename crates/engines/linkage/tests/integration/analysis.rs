//! Exponents, strains and indices of trajectories whose answers are known.

use crate::common::{drawn_start, lattice, one_square, two_squares};
use protomer_linkage::Result;
use protomer_linkage::analysis::lyapunov::{LyapunovSettings, SteppedFlow, maximal_exponent};
use protomer_linkage::analysis::modes::{ModeEnergies, Modes, OutOf, orientational_spread};
use protomer_linkage::analysis::spread::FirstMaximum;
use protomer_linkage::analysis::strain::{
    biot_strain, centres, corners, deformation_gradient, poisson_ratio,
};
use protomer_linkage::analysis::synchronisation::{Synchronisation, angles, staggered};
use protomer_linkage::lattice::{
    Coherence, CollisionSettings, Dynamics, Engine, Force, Network, Start, StartVelocities, State,
};
use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::Arc;

/// The cat map, (x, y) → (2x + y, x + y) mod 1, has λ = ln((3 + √5)/2) everywhere.
#[test]
fn the_cat_map_has_its_exponent() {
    let cat = |state: &mut State, _: f64| -> Result<()> {
        let (x, y) = (state.positions[0], state.positions[1]);
        state.positions = vec![(2.0 * x + y).rem_euclid(1.0), (x + y).rem_euclid(1.0), 0.0];
        state.velocities = vec![0.0; 3];
        Ok(())
    };
    let mut state = State {
        time: 0.0,
        positions: vec![0.12, 0.41, 0.0],
        velocities: vec![0.0; 3],
    };
    let settings = LyapunovSettings {
        interval: 1.0,
        ..LyapunovSettings::default()
    };
    let found = maximal_exponent(
        &one_square(),
        &mut cat.clone(),
        &mut cat.clone(),
        &mut state,
        &settings,
    )
    .unwrap();
    assert!(
        (found.exponent - (1.5 + 0.5 * 5.0f64.sqrt()).ln()).abs() < 1e-6,
        "{}",
        found.exponent
    );
}

/// Away from the top of a hill, ẍ = k² x, all trajectories part as exp(k t); in a valley, ẍ = -k²
/// x, none do.
#[test]
fn hill_and_valley_have_their_exponents() {
    struct Hill(f64);
    impl Force for Hill {
        fn accelerate(&self, _: &Network, positions: &[f64], accelerations: &mut [f64]) -> f64 {
            accelerations[0] += self.0 * positions[0];
            -0.5 * self.0 * positions[0] * positions[0]
        }
    }
    let network = Arc::new(one_square());
    let run = |stiffness: f64, intervals: usize| {
        let mut state = State {
            time: 0.0,
            positions: vec![1e-6, 0.0, 0.0],
            velocities: vec![0.0; 3],
        };
        let flow = |state: &State| {
            SteppedFlow::new(
                Dynamics::new(network.clone(), vec![Box::new(Hill(stiffness))], state).unwrap(),
                1e-3,
            )
        };
        let (mut first, mut second) = (flow(&state), flow(&state));
        let settings = LyapunovSettings {
            discarded: 20,
            intervals,
            interval: 0.25,
            ..LyapunovSettings::default()
        };
        maximal_exponent(&network, &mut first, &mut second, &mut state, &settings).unwrap()
    };
    let hill = run(1.44, 20);
    assert!((hill.exponent - 1.2).abs() < 1e-4, "{}", hill.exponent);
    // The free directions part linearly: ln(T)/T.
    let valley = run(-1.44, 2000);
    assert!(
        valley.exponent.abs() < 2.0 * 500.0f64.ln() / 500.0,
        "{}",
        valley.exponent
    );
}

/// Two squares and a rod in one line that turn about their middle: centrifugal forces hold the
/// line, and neighbours do not part faster than linearly. Folded inwards over the rod they are
/// balanced as a pencil on its tip: with the corners at a = 1.5 from the middle and Ω = l = 1,
/// Lagrange's equations for small angles α against the rod give α̈ = al (a² - 2al + l² + I) / (a²
/// I) α for both turned alike and α̈ = (a - l) l / I α for both turned oppositely, so that
/// neighbours part at rates between √(7/6) and √(3/2).
#[test]
fn a_turning_line_of_squares_is_regular_and_a_folded_one_is_not() {
    let network = two_squares([2, 2], 3.0);
    let run = |outwards: f64, step: f64| {
        // The corners at ±1.5, the centres beyond them or before.
        let turned = if outwards > 0.0 { PI } else { 0.0 };
        let x = 1.5 + outwards;
        let positions = vec![-x, 0.0, turned + PI - FRAC_PI_4, x, 0.0, turned - FRAC_PI_4];
        let velocities = vec![0.0, -x, 1.0, 0.0, x, 1.0];
        let mut state = State {
            time: 0.0,
            positions,
            velocities,
        };
        let flow = |state: &State| {
            SteppedFlow::new(
                Dynamics::new(network.clone(), Vec::new(), state).unwrap(),
                step,
            )
        };
        let (mut first, mut second) = (flow(&state), flow(&state));
        // The steps themselves disturb the balance by their square, so it does not last.
        let (intervals, discarded) = if outwards > 0.0 { (1000, 20) } else { (8, 16) };
        let settings = LyapunovSettings {
            interval: 0.25,
            intervals,
            discarded,
            ..LyapunovSettings::default()
        };
        maximal_exponent(&network, &mut first, &mut second, &mut state, &settings)
            .unwrap()
            .exponent
    };
    let (line, folded) = (run(1.0, 0.01), run(-1.0, 1e-3));
    eprintln!("{line} {folded}");
    assert!(line.abs() < 2.0 * 250.0f64.ln() / 250.0, "{line}");
    assert!(
        folded > (7.0f64 / 6.0).sqrt() && folded < 1.5f64.sqrt() + 1e-3,
        "{folded}"
    );
}

fn lattice_exponent(
    rod_length: f64,
    kappa: f64,
    settings: &LyapunovSettings,
    step: f64,
) -> (f64, f64) {
    let network = lattice(2, rod_length);
    let mut state = drawn_start(&network, 4, Some(4.0));
    let flow = |state: &State| {
        let forces: Vec<Box<dyn Force>> = vec![Box::new(Coherence { kappa })];
        SteppedFlow::new(Dynamics::new(network.clone(), forces, state).unwrap(), step)
    };
    let (mut first, mut second) = (flow(&state), flow(&state));
    let found = maximal_exponent(&network, &mut first, &mut second, &mut state, settings).unwrap();
    (found.exponent, found.standard_error)
}

/// Four squares that pass through each other (no collisions) and turn at random are chaotic, and
/// the exponent does not depend on how it is measured.
#[test]
fn four_squares_on_rods_are_chaotic_however_it_is_measured() {
    let base = LyapunovSettings {
        interval: 0.5,
        discarded: 40,
        intervals: 1200,
        ..LyapunovSettings::default()
    };
    let found = [
        lattice_exponent(1.0, 0.0, &base, 0.01),
        lattice_exponent(
            1.0,
            0.0,
            &LyapunovSettings {
                separation: 1e-9,
                ..base
            },
            0.01,
        ),
        lattice_exponent(
            1.0,
            0.0,
            &LyapunovSettings {
                interval: 0.25,
                intervals: 2400,
                seed: 7,
                ..base
            },
            0.005,
        ),
    ];
    eprintln!("{found:?}");
    for (exponent, error) in found {
        assert!(exponent > 6.0 * error);
        let [a, b] = [found[0], (exponent, error)];
        assert!((a.0 - b.0).abs() <= 4.0 * a.1.hypot(b.1));
    }
}

/// Four squares that collide are chaotic too.
#[test]
fn colliding_squares_are_chaotic() {
    let network = lattice(2, 0.5);
    let mut state = drawn_start(&network, 4, Some(4.0));
    let flow = |state: &State| {
        SteppedFlow::new(
            Engine::new(
                network.clone(),
                Vec::new(),
                state,
                CollisionSettings::default(),
            )
            .unwrap(),
            0.005,
        )
    };
    let (mut first, mut second) = (flow(&state), flow(&state));
    let settings = LyapunovSettings {
        interval: 0.25,
        discarded: 20,
        intervals: 400,
        ..LyapunovSettings::default()
    };
    let found = maximal_exponent(&network, &mut first, &mut second, &mut state, &settings).unwrap();
    eprintln!(
        "{} ± {}, {:?}",
        found.exponent,
        found.standard_error,
        first.stepper().statistics()
    );
    assert!(first.stepper().statistics().impacts > 50);
    assert!(found.exponent > 6.0 * found.standard_error);
}

/// Poisson's ratio of a lattice that only opens and closes is -1, from its centres as from its
/// corners.
#[test]
fn a_coherent_trajectory_is_auxetic() {
    let network = lattice(2, 0.5);
    let start = Start {
        angle: 0.3,
        velocities: StartVelocities::Checkerboard { rate: 1.0 },
        ..Start::default()
    };
    let mut state = start.build(&network, 0).unwrap().state;
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    let (mut by_centres, mut by_corners) = (Vec::new(), Vec::new());
    let mut sync = [Synchronisation::new(4), Synchronisation::new(4)];
    for _ in 0..80 {
        let before = state.positions.clone();
        for _ in 0..5 {
            dynamics.step(&mut state, 0.002).unwrap();
        }
        let diagonal = |before: &[[f64; 2]], after: &[[f64; 2]]| {
            let strain = biot_strain(&deformation_gradient(before, after).unwrap());
            [strain[(0, 0)], strain[(1, 1)]]
        };
        by_centres.push(diagonal(&centres(&before), &centres(&state.positions)));
        by_corners.push(diagonal(
            &corners(&network, &before),
            &corners(&network, &state.positions),
        ));
        sync[0].push(&angles(&state.positions)).unwrap();
        sync[1]
            .push(&staggered(&network, &state.positions))
            .unwrap();
    }
    for strains in [&by_centres, &by_corners] {
        let found = poisson_ratio(strains, 8).unwrap();
        assert!(
            (found.xy + 1.0).abs() < 1e-9 && (found.yx + 1.0).abs() < 1e-9,
            "{found:?}"
        );
    }
    let [plain, staggered] = sync.map(|sync| sync.index().unwrap());
    assert!((staggered[(0, 1)].norm() - 1.0).abs() < 1e-12 && plain[(0, 1)].norm() < 0.95);
    assert!((plain[(0, 3)].norm() - 1.0).abs() < 1e-12);
}

/// From the closed state at ω_c = 1, a stronger coherence potential keeps the squares closer together
/// (fig. 12): lower and earlier first maxima of the spread.
#[test]
fn stronger_coherence_gives_lower_and_earlier_maxima_of_the_spread() {
    let network = lattice(4, 0.5);
    let start = Start {
        velocities: StartVelocities::Checkerboard { rate: 1.0 },
        ..Start::closed()
    };
    let found = [30.0, 100.0, 300.0].map(|kappa| {
        let mut state = start.build(&network, 0).unwrap().state;
        let mut dynamics =
            Dynamics::new(network.clone(), vec![Box::new(Coherence { kappa })], &state).unwrap();
        let mut first = FirstMaximum::new(0.0);
        while first.found().is_none() && state.time < 2.0 {
            dynamics.step(&mut state, 1e-3).unwrap();
            first.push(state.time, orientational_spread(&network, &state.positions));
        }
        first.found().unwrap()
    });
    eprintln!("{found:?}");
    assert!(found[0].value > found[1].value && found[1].value > found[2].value);
    assert!(found[0].time > found[1].time && found[1].time > found[2].time);
}

#[test]
fn a_coherent_motion_has_all_its_rotation_in_the_checkerboard_mode() {
    let network = lattice(2, 1.0);
    let start = Start {
        velocities: StartVelocities::Checkerboard { rate: 1.0 },
        ..Start::default()
    };
    let mut state = start.build(&network, 0).unwrap().state;
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    for _ in 0..100 {
        dynamics.step(&mut state, 0.005).unwrap();
    }
    let energies = ModeEnergies::from_state(&network, &state);
    let fraction = |which| energies.checkerboard_fraction(which, 0.0).unwrap();
    assert!((fraction(OutOf::Rotational) - 1.0).abs() < 1e-9);
    // The rest is in the translations: 1/(1 - μ sin²(π/4 - θ)) with μ = -6.
    let angle = Modes::from_coordinates(&network, &state.positions).checkerboard;
    let share = 1.0 / (1.0 + 6.0 * (FRAC_PI_4 - angle).sin().powi(2));
    assert!((fraction(OutOf::Total) - share).abs() < 1e-4 && share < 0.9);
}
