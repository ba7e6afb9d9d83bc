//! Bodies of several kinds against exact results; short runs.

use crate::common::{assert_mean, pressed};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::box_moves::Freedom;
use protomer_hpmc::mixture::Mixture;
use protomer_hpmc::simulation::{Settings, Simulation};
use protomer_hpmc::start::{Placed, Start};
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::shape::Shape;
use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::measures::Measures;
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::PI;

fn begin<const D: usize>(settings: &Settings, mixture: &Mixture<D>, packing: f64) -> Simulation<D> {
    let start = Start::fluid(mixture.len(), packing);
    Simulation::of_mixture(settings, mixture, &[], &start, &|| false).unwrap()
}

fn cube() -> HardBody<3> {
    HardBody::new(&by_name("cube").unwrap(), 0.0).unwrap()
}

/// Two bodies in a box of volume V: Z = (1 + V/(V - 2 B₁₂))/2.
fn two_bodies(first: HardBody<3>, second: HardBody<3>, b12: f64) {
    // So wide that no image of a body comes in the way of another one.
    let edge = 2.05 * (first.outer_radius + second.outer_radius);
    let volume = edge.powi(3);
    let packing = (first.volume + second.volume) / volume;
    let mixture = Mixture::new(vec![first, second], vec![0, 1]).unwrap();
    let settings = Settings {
        equilibration_sweeps: 500,
        ..Settings::default()
    };
    let mut simulation = begin(&settings, &mixture, packing);
    simulation.run(500).unwrap();
    let mut factors = Vec::new();
    for _ in 0..60_000 {
        simulation.run(4).unwrap();
        factors.push(simulation.sample().compressibility_factor);
    }
    assert_eq!(simulation.system().overlaps(), 0);
    let exact = 0.5 * (1.0 + volume / (volume - 2.0 * b12));
    assert_mean(&factors, exact, 0.02, "compressibility factor");
}

#[test]
fn a_small_and_a_large_ball_have_their_cross_coefficient() {
    let [small, large] = [0.3, 0.6].map(|radius| HardBody::ball(radius).unwrap());
    two_bodies(small, large, 2.0 * PI / 3.0 * 0.9_f64.powi(3));
}

/// B₁₂ = (V₁ + V₂ + (M₁ S₂ + M₂ S₁)/4π)/2 for convex bodies that turn (Isihara and Hayashida), with M = 4π R for a ball and 3π for
/// a cube of edge one.
#[test]
fn a_cube_and_a_ball_have_their_cross_coefficient() {
    let measures = Measures::from_shape(&by_name("cube").unwrap(), 0.0).unwrap();
    assert!((measures.volume - 1.0).abs() < 1e-12);
    let radius = 0.4_f64;
    let ball = (
        4.0 * PI / 3.0 * radius.powi(3),
        4.0 * PI * radius.powi(2),
        4.0 * PI * radius,
    );
    let (surface, curvature) = (6.0, 3.0 * PI);
    let b12 = 0.5 * (1.0 + ball.0 + (curvature * ball.1 + ball.2 * surface) / (4.0 * PI));
    two_bodies(cube(), HardBody::ball(radius).unwrap(), b12);
}

/// Rods of two lengths on a ring, in any order: L (L - Σℓ)^(N-1) exp(-βPL).
#[test]
fn rods_of_two_lengths_have_their_mean_length() {
    let [short, long] = [0.25, 0.75].map(|radius| HardBody::<1>::ball(radius).unwrap());
    let mixture = Mixture::new(vec![short, long], [0, 1, 1, 0].repeat(3)).unwrap();
    let settings = Settings {
        swaps: 4,
        ..pressed(3.0, Freedom::Volume)
    };
    let mut simulation = begin(&settings, &mixture, 0.4);
    simulation.run(2000).unwrap();
    let mut lengths = Vec::new();
    for _ in 0..20_000 {
        simulation.run(5).unwrap();
        lengths.push(simulation.system().volume());
    }
    assert_eq!(simulation.system().overlaps(), 0);
    assert!(simulation.swap_counts().accepted > 100);
    let (n, p, filled) = (12.0, 3.0, 12.0);
    let (first, second) = (n / p, n * (n + 1.0) / (p * p));
    let exact = (second + 2.0 * filled * first + filled * filled) / (first + filled);
    assert_mean(&lengths, exact, 0.003, "length");
}

/// Moves decide by remembered directions, `overlaps` looks at every pair again; bodies of several pieces are among those of one.
#[test]
fn dense_mixtures_stay_free_of_overlaps_and_go_on_from_their_state() {
    let square_from =
        |x: f64| Shape::flat(&[[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]]).unwrap();
    let (square, shifted) = (square_from(0.0), square_from(1.0));
    let kinds = vec![
        HardBody::<2>::in_pieces(&[square.clone(), shifted], 0.0).unwrap(),
        HardBody::in_pieces(std::slice::from_ref(&square), 0.0).unwrap(),
        HardBody::in_pieces(&[by_name("polygon:3").unwrap()], 0.1).unwrap(),
    ];
    let mixture = Mixture::new(kinds, [0, 1, 2, 1].repeat(12)).unwrap();
    let settings = Settings {
        swaps: 10,
        ..pressed(6.0, Freedom::Volume)
    };
    let mut simulation = begin(&settings, &mixture, 0.3);
    for _ in 0..30 {
        simulation.run(20).unwrap();
        assert_eq!(simulation.system().overlaps(), 0);
    }
    let state = simulation.state();
    let mut resumed = Simulation::resume_mixture(&settings, &mixture, &[], &state).unwrap();
    simulation.refresh();
    for simulation in [&mut simulation, &mut resumed] {
        simulation.run(40).unwrap();
    }
    assert_eq!(simulation.state(), resumed.state());
    assert!(simulation.system().packing_fraction() > 0.4);
}

/// Equal bodies as a mixture of one kind, or of two kinds that are alike, move as before.
#[test]
fn kinds_that_are_alike_change_nothing() {
    let settings = Settings {
        equilibration_sweeps: 100,
        ..Settings::default()
    };
    let places = |mixture: &Mixture<3>| {
        let mut simulation = begin(&settings, mixture, 0.2);
        simulation.run(200).unwrap();
        simulation.state().positions
    };
    let one = Mixture::equal(cube(), 64);
    let two = Mixture::new(vec![cube(), cube()], [0, 1].repeat(32)).unwrap();
    assert_eq!(places(&one), places(&two));
}

#[test]
fn mixtures_that_cannot_be_say_why() {
    assert!(Mixture::new(vec![cube()], vec![0, 1]).is_err());
    assert!(Mixture::<3>::new(Vec::new(), Vec::new()).is_err());
    let dumbbell = [-0.5, 0.5].map(|x| Shape::solid(&[Vec3::new(x, 0.0, 0.0)]).unwrap());
    let concave = HardBody::<3>::of_pieces(&dumbbell, 0.5).unwrap();
    let mixed = Mixture::new(vec![cube(), concave], vec![0, 1]).unwrap_err();
    assert!(mixed.to_string().contains("none or all"), "{mixed}");
    let mixture = Mixture::new(vec![cube(), cube()], vec![0, 1]).unwrap();
    let start = Start::Placed(Placed {
        space: PeriodicBox::rectangular([5.0; 3]).unwrap(),
        positions: vec![[1.0; 3]],
        rotations: vec![Rotation::identity()],
        has_walls: false,
    });
    let few = Simulation::of_mixture(&Settings::default(), &mixture, &[], &start, &|| false);
    assert!(few.unwrap_err().to_string().contains("that of the start"));
    let inserted = Settings {
        insertions: 5,
        ..Settings::default()
    };
    let start = Start::fluid(2, 0.05);
    let refused = Simulation::of_mixture(&inserted, &mixture, &[], &start, &|| false);
    assert!(refused.unwrap_err().to_string().contains("insertions"));
}
