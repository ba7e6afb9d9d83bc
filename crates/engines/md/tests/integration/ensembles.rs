//! Rounded, attractive, oblong and concave bodies and mixtures in motion; constant pressure.

use crate::common::{attractive, polytope, settings};
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Boundary, Vec3};
use protomer_md::Error;
use protomer_md::bath::Ensemble;
use protomer_md::body::Kind;
use protomer_md::drift::Drift;
use protomer_md::engine::{Engine, Settings};
use protomer_md::pair::central::Central;
use protomer_md::pair::radial::Attraction;
use protomer_md::pair::{Form, Interaction};
use protomer_md::start::{free_density, on_a_lattice, set_velocities};
use protomer_md::state::{Bodies, State};

/// Bodies compressed from a lattice by a factor of the free density, with a bath.
fn compressed(bodies: &Bodies, interaction: Interaction, factor: f64, steps: i32) -> Engine {
    let free = free_density(bodies);
    let mut state = on_a_lattice(bodies, free, 5).unwrap();
    set_velocities(&mut state, bodies, 1.0, 5).unwrap();
    let bath = Settings {
        ensemble: Ensemble::Nvt {
            temperature: 1.0,
            relaxation_time: 0.05,
        },
        ..settings(interaction, 5e-4)
    };
    let dimension = bodies.dimension() as f64;
    let scale = factor.powf(-1.0 / (dimension * f64::from(steps)));
    let mut engine = Engine::new(bodies.clone(), state, bath).unwrap();
    for _ in 0..steps {
        engine.step(scale).unwrap();
    }
    engine
}

/// The noise of the energy per body about a straight line at two time steps, and the change along the
/// line at the smaller one.
fn kept(start: &Engine, time: f64) -> [f64; 3] {
    let run = |time_step: f64| {
        let settings = settings(start.settings().interaction, time_step);
        let (bodies, motion) = (start.bodies().clone(), start.motion().clone());
        let count = bodies.count() as f64;
        let mut engine = Engine::continued(bodies, motion, settings).unwrap();
        let mut drift = Drift::default();
        for step in 0..(time / time_step) as usize {
            engine.step(1.0).unwrap();
            if step % 5 == 0 {
                drift.push(step as f64, engine.energy());
            }
        }
        [drift.noise() / count, drift.along_the_line() / count]
    };
    let [coarse, fine] = [run(2e-4), run(1e-4)];
    [coarse[0], fine[0], fine[1]]
}

/// An L of two rectangles, in a plane.
fn angle() -> Kind {
    let part = |corners: [[f64; 2]; 4]| {
        let place: Vec3 = corners
            .iter()
            .map(|x| Vec3::new(x[0], x[1], 0.0))
            .sum::<Vec3>()
            / 4.0;
        (
            Polytope::from_shape(&Shape::flat(&corners).unwrap()).unwrap(),
            place,
        )
    };
    let upright = part([[0.0, 0.0], [0.5, 0.0], [0.5, 1.5], [0.0, 1.5]]);
    let foot = part([[0.5, 0.0], [1.2, 0.0], [1.2, 0.5], [0.5, 0.5]]);
    Kind::union(&[upright, foot], 0.0).unwrap()
}

/// Two cubes side by side and one on top, in space.
fn stairs() -> Kind {
    let cube = polytope("cube");
    let shifted = |x: f64, z: f64| (cube.clone(), Vec3::new(x, 0.0, z));
    Kind::union(
        &[shifted(0.0, 0.0), shifted(1.0, 0.0), shifted(0.0, 1.0)],
        0.0,
    )
    .unwrap()
}

#[test]
fn bodies_of_all_kinds_keep_their_energy() {
    let one = |kind: Kind, count: usize| Bodies::of_one_kind(kind.of_unit_volume().unwrap(), count);
    let mixture = |kinds: Vec<Kind>, count: usize| Bodies {
        kind_of: (0..count).map(|body| body % kinds.len()).collect(),
        kinds: kinds
            .iter()
            .map(|kind| kind.of_unit_volume().unwrap())
            .collect(),
    };
    let smooth: Interaction = Form::Smooth.into();
    let cases = [
        (
            "rounded squares",
            one(Kind::rounded(&polytope("polygon:4"), 0.1).unwrap(), 36),
            smooth,
            1.3,
        ),
        (
            "ellipses",
            one(Kind::ellipsoid(2, Vec3::new(2.0, 1.0, 0.0)).unwrap(), 36),
            smooth,
            1.5,
        ),
        ("angles", one(angle(), 36), smooth, 1.8),
        (
            "pentagons that attract each other",
            one(Kind::from_polytope(&polytope("polygon:5")).unwrap(), 36),
            attractive(Form::Smooth, 1.0, Central::Conservative),
            1.1,
        ),
        (
            "triangles, squares and disks",
            mixture(
                vec![
                    Kind::from_polytope(&polytope("polygon:3")).unwrap(),
                    Kind::from_polytope(&polytope("polygon:4")).unwrap(),
                    Kind::ball(2, 0.5).unwrap(),
                ],
                36,
            ),
            smooth,
            1.3,
        ),
        (
            "ellipsoids",
            one(Kind::ellipsoid(3, Vec3::new(1.0, 1.0, 2.0)).unwrap(), 64),
            smooth,
            2.0,
        ),
        (
            "rounded octahedra",
            one(Kind::rounded(&polytope("octahedron"), 0.1).unwrap(), 64),
            smooth,
            1.5,
        ),
    ];
    for (name, bodies, interaction, factor) in cases {
        let start = compressed(&bodies, interaction, factor, 600);
        let [coarse, fine, change] = kept(&start, 0.15);
        assert!(start.motion().potential_energy != 0.0, "{name}");
        assert!(
            fine < 2e-4 && change.abs() < 4e-4,
            "{name} {coarse} {fine} {change}"
        );
        assert!(coarse > 1.8 * fine, "{name} {coarse} {fine}");
    }
}

#[test]
fn spins_about_axes_of_revolution_are_drawn_and_then_kept() {
    let kind = Kind::ellipsoid(3, Vec3::new(2.0, 1.0, 1.0)).unwrap();
    let bodies = Bodies::of_one_kind(kind.of_unit_volume().unwrap(), 125);
    let mut engine = compressed(&bodies, Form::Smooth.into(), 4.0, 600);
    let temperature_about = |engine: &Engine| {
        let spins = engine.motion().state.spins.iter();
        let squares = spins.map(|spin| spin.x * spin.x / bodies.kinds[0].moments.x);
        squares.sum::<f64>() / 125.0
    };
    // The bath takes the heat of the compression from all momenta.
    let cold = temperature_about(&engine);
    assert!(cold < 0.6, "{cold}");
    let kept = engine.energy() - engine.motion().heat;
    engine.draw_free_spins(1.0);
    let drawn = temperature_about(&engine);
    // Three standard errors of the mean of 125 squares.
    assert!((drawn - 1.0).abs() < 0.38, "{drawn}");
    assert!((engine.energy() - engine.motion().heat - kept).abs() < 1e-10);
    let settings = settings(Form::Smooth, 1e-4);
    engine.change_settings(settings).unwrap();
    for _ in 0..200 {
        engine.step(1.0).unwrap();
    }
    assert!((temperature_about(&engine) - drawn).abs() < 1e-10);
}

#[test]
fn bodies_with_fixed_orientations_keep_them_and_their_energy() {
    for (name, count) in [("polygon:4", 36), ("octahedron", 64)] {
        let kind = Kind::from_polytope(&polytope(name)).unwrap();
        let turning = Bodies::of_one_kind(kind.of_unit_volume().unwrap(), count);
        let mut first = on_a_lattice(&turning, free_density(&turning), 5).unwrap();
        let fixed = kind.with_fixed_orientation().of_unit_volume().unwrap();
        let bodies = Bodies::of_one_kind(fixed, count);
        let engine = compressed(&bodies, Form::Smooth.into(), 1.3, 600);
        let state = &engine.motion().state;
        assert_eq!(state.angles_rad, first.angles_rad, "{name}");
        assert_eq!(state.rotations, first.rotations, "{name}");
        assert!(engine.motion().potential_energy != 0.0, "{name}");
        let [_, fine, change] = kept(&engine, 0.15);
        assert!(fine < 2e-4 && change.abs() < 4e-4, "{name} {fine} {change}");
        // Spins of a state that is given end.
        first.spins.fill(Vec3::z());
        let engine = Engine::new(bodies, first, *engine.settings()).unwrap();
        assert_eq!(
            engine.motion().state.kinetic_energies(engine.bodies())[1],
            0.0
        );
    }
}

#[test]
fn a_union_moves_as_its_parts_say() {
    // A square in two halves has the mass, the moment and, in the contact form, the closest points of
    // the whole. The repulsion's length is that of the half, so it is compared in free flight and by
    // what is kept in a collision.
    let bodies = Bodies::of_one_kind(stairs(), 2);
    let places = vec![Vec3::zeros(), Vec3::new(3.2, 0.3, 0.2)];
    let mut state = State::at_rest(&bodies, Boundary::Open, places);
    state.velocities[1] = Vec3::new(-2.0, 0.0, 0.0);
    state.spins[0] = Vec3::new(0.3, 1.0, -0.4);
    let settings = settings(Form::Smooth, 1e-4);
    let mut engine = Engine::new(bodies.clone(), state, settings).unwrap();
    let energy = engine.energy();
    let momentum = engine.motion().state.momentum(&bodies);
    let spin = engine.motion().state.angular_momentum(&bodies);
    let (mut highest, mut worst) = (0.0_f64, 0.0_f64);
    for _ in 0..15_000 {
        engine.step(1.0).unwrap();
        highest = highest.max(engine.motion().potential_energy);
        worst = worst.max((engine.energy() - energy).abs());
    }
    assert!(highest > 0.5, "they met: {highest}");
    assert!(worst < 2e-3, "{worst}");
    let state = &engine.motion().state;
    assert!((state.momentum(&bodies) - momentum).norm() < 1e-11);
    assert!((state.angular_momentum(&bodies) - spin).norm() < 1e-10);
}

#[test]
fn what_bodies_cannot_feel_is_refused() {
    let square = Kind::from_polytope(&polytope("polygon:4")).unwrap();
    let ellipse = Kind::ellipsoid(2, Vec3::new(0.5, 1.0, 0.0)).unwrap();
    let mixture = Bodies {
        kinds: vec![square.clone(), ellipse],
        kind_of: vec![0, 1],
    };
    let place = |bodies: &Bodies| {
        State::at_rest(
            bodies,
            Boundary::Open,
            vec![Vec3::zeros(), Vec3::new(5.0, 0.0, 0.0)],
        )
    };
    let smooth: Interaction = Form::Smooth.into();
    let refused = Engine::new(mixture.clone(), place(&mixture), settings(smooth, 1e-3));
    assert!(matches!(refused, Err(Error::EllipsoidBesideFaces)));
    let squares = Bodies::of_one_kind(square, 2);
    for (central, strength, cut_off) in [
        (Central::Printed, 1.0, 2.5),
        (Central::Gradient, 1.0, 2.5),
        (Central::None, -1.0, 2.5),
        (Central::None, 1.0, 1.0),
        (Central::None, 1.0, f64::INFINITY),
    ] {
        let interaction = Interaction {
            form: Form::Contact,
            attraction: Attraction { strength, cut_off },
            central,
        };
        let refused = Engine::new(
            squares.clone(),
            place(&squares),
            settings(interaction, 1e-3),
        );
        assert!(refused.is_err(), "{interaction:?}");
    }
}

/// An ideal gas: bodies so small that they practically never meet.
#[test]
fn the_volume_of_an_ideal_gas_is_gamma_distributed() {
    const COUNT: usize = 12;
    let bodies = Bodies::of_one_kind(Kind::ball(3, 1e-4).unwrap(), COUNT);
    let mut state = on_a_lattice(&bodies, 1.0, 3).unwrap();
    set_velocities(&mut state, &bodies, 0.5, 3).unwrap();
    let npt = Settings {
        ensemble: Ensemble::Npt {
            temperature: 0.5,
            relaxation_time: 0.1,
            pressure: 0.4,
        },
        ..settings(Form::Contact, 1e-7)
    };
    let mut engine = Engine::new(bodies, state, npt).unwrap();
    let (mut mean, mut square, mut count) = (0.0, 0.0, 0.0);
    for step in 0..400_000 {
        engine.step(1.0).unwrap();
        if step > 20_000 && step % 10 == 0 {
            let volume = engine.motion().state.volume(3);
            mean += volume;
            square += volume * volume;
            count += 1.0;
        }
    }
    mean /= count;
    let variance = square / count - mean * mean;
    // p(V) ∝ V^N exp(-P V/kT): mean (N + 1) kT/P, variance (N + 1) (kT/P)². 38 000 trials, correlated
    // over some hundred of them, leave about 2 % and 15 %.
    let expected = (COUNT + 1) as f64 * 1.25;
    assert!((mean / expected - 1.0).abs() < 0.06, "{mean} {expected}");
    assert!(
        (variance / (expected * 1.25) - 1.0).abs() < 0.35,
        "{variance}"
    );
    let [refused, accepted] = engine.motion().volume_trials;
    assert!(accepted > 5 * refused, "{refused} {accepted}");
}

#[test]
fn constant_pressure_and_constant_volume_agree() {
    // Squares: the mean density at the pressure that was measured at a density is that density.
    let bodies = Bodies::of_one_kind(Kind::from_polytope(&polytope("polygon:4")).unwrap(), 36);
    let start = compressed(&bodies, Form::FaceSum.into(), 1.05, 500);
    let volume = start.motion().state.volume(2);
    let bath = |ensemble: Ensemble| Settings {
        ensemble,
        ..settings(Form::FaceSum, 1e-3)
    };
    let (temperature, relaxation_time) = (1.0, 0.2);
    let nvt = bath(Ensemble::Nvt {
        temperature,
        relaxation_time,
    });
    let mut engine = Engine::continued(bodies.clone(), start.motion().clone(), nvt).unwrap();
    let mut pressure = 0.0;
    for _ in 0..20_000 {
        engine.step(1.0).unwrap();
        pressure += engine.pressure() / 20_000.0;
    }
    let npt = bath(Ensemble::Npt {
        temperature,
        relaxation_time,
        pressure,
    });
    engine.change_settings(npt).unwrap();
    let (mut mean, mut measured) = (0.0, 0.0);
    for step in 0..44_000 {
        engine.step(1.0).unwrap();
        if step >= 4000 {
            mean += engine.motion().state.volume(2) / 40_000.0;
            measured += engine.pressure() / 40_000.0;
        }
    }
    assert!((mean / volume - 1.0).abs() < 0.05, "{mean} {volume}");
    // The virial pressure at constant pressure averages to it.
    assert!(
        (measured / pressure - 1.0).abs() < 0.06,
        "{measured} {pressure}"
    );
    assert!(
        engine
            .motion()
            .volume_trials
            .iter()
            .all(|count| *count > 100)
    );
}

#[test]
fn constant_pressure_goes_on_bit_for_bit() {
    let bodies = Bodies::of_one_kind(Kind::from_polytope(&polytope("octahedron")).unwrap(), 64);
    let start = compressed(&bodies, Form::Smooth.into(), 1.2, 300);
    let npt = Settings {
        ensemble: Ensemble::Npt {
            temperature: 1.0,
            relaxation_time: 0.2,
            pressure: 0.5,
        },
        ..settings(Form::Smooth, 1e-3)
    };
    let mut through = Engine::continued(bodies.clone(), start.motion().clone(), npt).unwrap();
    for _ in 0..105 {
        through.step(1.0).unwrap();
    }
    let text = serde_json::to_string(through.motion()).unwrap();
    let saved = serde_json::from_str(&text).unwrap();
    let mut again = Engine::continued(bodies, saved, npt).unwrap();
    for _ in 0..200 {
        through.step(1.0).unwrap();
        again.step(1.0).unwrap();
    }
    assert_eq!(through.motion(), again.motion());
    assert!(through.motion().volume_trials[1] > 0);
}
