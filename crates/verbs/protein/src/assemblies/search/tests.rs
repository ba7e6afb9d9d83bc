//! The search finds wells that are known beforehand, and its energies are the sums over all pairs.

use super::cage::{CageSamples, search_cages};
use super::ring::{FoundRing, Pattern, RingGrid, search_rings};
use super::*;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::inspect::{inspect, inspection_settings};
use crate::stability::interaction::{InteractionSettings, ScreenedCoulomb};
use crate::stability::run::{EnergyMode, Engine};
use protomer_body::assembly::{Cage, CageSite, CubicGroup, HardBody, Recipe, RecipeSite};
use protomer_body::{Body, Source, SurfaceSettings, build_body_of_points};
use protomer_kernel::{Boundary, PointRecord, Pose, Rotation, Vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A ball with a charge, e, at its centre.
fn ball(position: Vec3, radius_angstrom: f64, charge_e: f64) -> PointRecord {
    PointRecord {
        position,
        radius_angstrom,
        charge_e,
        ..PointRecord::default()
    }
}

fn body(balls: &[PointRecord]) -> Arc<Body> {
    let source = Source {
        file: "balls.pqr",
        sha256: "",
    };
    let settings = SurfaceSettings::default();
    let draft = build_body_of_points("balls", source, balls, &settings).unwrap();
    Arc::new(draft.body)
}

/// A rod of balls along x with these charges, e.
fn rod(charges: &[f64]) -> Arc<Body> {
    let middle = 0.5 * (charges.len() as f64 - 1.0);
    let along = |number: usize| Vec3::x() * (4.0 * (number as f64 - middle));
    let charged = charges.iter().enumerate();
    let balls: Vec<PointRecord> = charged
        .map(|(number, charge_e)| ball(along(number), 4.0, *charge_e))
        .collect();
    body(&balls)
}

fn medium() -> ScreenedCoulomb {
    InteractionSettings::default()
        .interaction(Some(0.05))
        .unwrap()
}

/// A medium in which only charges in contact feel each other.
fn concentrated() -> ScreenedCoulomb {
    let settings = InteractionSettings::default();
    settings.interaction(Some(0.15)).unwrap()
}

fn assembly(bodies: &[Arc<Body>], kinds: Vec<usize>, poses: Vec<Pose>) -> Assembly {
    Assembly {
        bodies: bodies.to_vec(),
        kinds,
        poses,
        boundary: Boundary::Open,
        sha256: String::new(),
        path: None,
    }
}

fn found(
    bodies: &[Arc<Body>],
    recipe: Recipe,
    tilts: &[f64],
    spins: &[f64],
    refined: usize,
) -> Found<FoundRing> {
    let kinds: Vec<usize> = (0..bodies.len()).collect();
    let poses = vec![Pose::identity(); bodies.len()];
    let engine = Engine::new(assembly(bodies, kinds, poses)).unwrap();
    let potentials = engine.pair_potentials(&medium()).unwrap();
    let hard = bodies.iter().map(|body| HardBody::from_body(body).unwrap());
    let up = recipe.rings.iter().flatten().map(|site| site.up).collect();
    let grid = RingGrid {
        tilts_degrees: tilts.to_vec(),
        spins_degrees: spins.to_vec(),
    };
    let hard = HardBodies::new(hard.collect());
    let patterns = [Pattern { up, recipe }];
    let searched = Searched {
        bodies: &hard,
        potentials,
        gap_angstrom: 0.5,
        refined,
    };
    let found = search_rings(searched, &patterns, &grid, &Execution::default());
    found.unwrap().unwrap()
}

/// Two rods with a dipole along their axis, one the other turned about the axis of the ring by half a turn:
/// upright they are parallel and repel each other, across the axis they are antiparallel, side by side.
#[test]
fn two_dipoles_lie_across_the_axis() {
    let body = rod(&[2.0, 0.0, 0.0, 0.0, -2.0]);
    let ring = Recipe::ring(2, &[RecipeSite::upright(0)]);
    let bodies = [body];
    let upright = found(&bodies, ring.clone(), &[0.0], &[0.0], 0);
    assert!(upright.arrangements[0].energy_kt > 0.5, "{upright:?}");
    let found = found(&bodies, ring, &[0.0, 40.0], &[0.0], 1);
    let best = &found.arrangements[0];
    assert!((best.tilt_degrees[0].abs() - 90.0).abs() < 2.0, "{best:?}");
    assert!(best.energy_kt < -1.0 && best.is_refined);
    assert!(best.opening_angstrom < 0.1, "{best:?}");
}

/// Energies by orbits are the sums over all pairs of bodies, as `inspect` makes them.
#[test]
fn energies_are_those_of_all_pairs() {
    let bodies = [
        rod(&[1.0, 0.5, 0.0, -2.0]),
        rod(&[1.5, -1.0, 0.0, 0.0, 0.3]),
    ];
    let pattern = [RecipeSite::upright(0), RecipeSite::upright(1)];
    let stack = Recipe::dihedral(4, &pattern);
    let mixed = Recipe {
        rings: vec![stack.rings[0].clone(), stack.rings[0].clone()],
        ..stack.clone()
    };
    for recipe in [stack, Recipe::ring(4, &pattern), mixed] {
        let found = found(&bodies, recipe, &[20.0], &[0.0, 50.0], 3);
        assert!(found.arrangements.iter().any(|each| each.is_refined));
        let hard = HardBodies::new(
            bodies
                .iter()
                .map(|b| HardBody::from_body(b).unwrap())
                .collect(),
        );
        for arrangement in found.arrangements.iter().filter(|each| each.is_refined) {
            let placements = hard.close(&arrangement.recipe, 0.5).unwrap().placements;
            let (kinds, poses) = placements.into_iter().unzip();
            let engine = Engine::new(assembly(&bodies, kinds, poses)).unwrap();
            let settings = inspection_settings(EnergyMode::Direct, None, 5.0);
            let direct = inspect(&engine, &settings, Some(medium())).unwrap();
            assert!(direct.overlaps.is_empty());
            let energy_kt = direct.energy_kt.unwrap();
            assert!((arrangement.energy_kt - energy_kt).abs() < 1e-9 + 1e-6 * energy_kt.abs());
        }
    }
}

/// Refinement lowers energies and never leaves bodies in each other; the same search gives the same.
#[test]
fn a_search_is_ordered_and_reproducible() {
    let bodies = [
        rod(&[1.0, 0.5, 0.0, -2.0]),
        rod(&[-1.5, 1.0, 0.0, 0.0, 0.3]),
    ];
    let pattern = [RecipeSite::upright(0), RecipeSite::upright(1)];
    let search = || {
        found(
            &bodies,
            Recipe::dihedral(4, &pattern),
            &[0.0, 45.0],
            &[0.0, 60.0],
            3,
        )
    };
    let (first, second) = (search(), search());
    assert_eq!(first.arrangements, second.arrangements);
    let energies: Vec<f64> = first
        .arrangements
        .iter()
        .map(|each| each.energy_kt)
        .collect();
    assert!(energies.is_sorted());
    assert!(first.arrangements[0].is_refined);
    assert!(first.evaluated > 16 + 3 * 12);
}

/// A ball with charges where it touches its neighbours in a snub cube: opposite ones about the three-fold and the
/// four-fold axes next to it, so that rings of three and of four close. It has its lowest energy in O.
#[test]
fn a_body_designed_for_a_snub_cube_finds_its_group() {
    const RADIUS_ANGSTROM: f64 = 10.0;
    // Vertex of a snub cube: even permutations of (1, 1/t, t) with the tribonacci constant t.
    let tribonacci = 1.839_286_755_214_161;
    let vertex = Vec3::new(1.0, 1.0 / tribonacci, tribonacci);
    let rotations = CubicGroup::Octahedral.rotations();
    let neighbour = |angle: f64| {
        let turned = rotations
            .iter()
            .filter(|rotation| (rotation.angle() - angle).abs() < 1e-6)
            .min_by(|a, b| {
                let apart = |rotation: &&Rotation| (**rotation * vertex - vertex).norm();
                apart(a).total_cmp(&apart(b))
            });
        *turned.unwrap()
    };
    let mut balls = vec![ball(Vec3::zeros(), RADIUS_ANGSTROM, 0.0)];
    for angle in [TAU / 3.0, TAU / 4.0] {
        let forth = neighbour(angle);
        for (rotation, charge_e) in [(forth, 4.0), (forth.inverse(), -4.0)] {
            let outward = (rotation * vertex - vertex).normalize();
            // The body's origin is the centroid of its points: those opposite keep it at the centre.
            for (side, charge_e) in [(1.0, charge_e), (-1.0, 0.0)] {
                balls.push(ball(
                    side * outward * (RADIUS_ANGSTROM - 2.0),
                    2.0,
                    charge_e,
                ));
            }
        }
    }
    let bodies = [body(&balls)];
    let lowest = |group: CubicGroup| {
        let engine = Engine::new(assembly(&bodies, vec![0], vec![Pose::identity()])).unwrap();
        let hard = HardBodies::new(vec![HardBody::from_body(&bodies[0]).unwrap()]);
        let searched = Searched {
            bodies: &hard,
            potentials: engine.pair_potentials(&concentrated()).unwrap(),
            gap_angstrom: 0.1,
            refined: 16,
        };
        let samples = CageSamples {
            group,
            kinds: 1,
            samples: 400,
            seed: 1,
        };
        let found = search_cages(searched, &samples, &Execution::default()).unwrap();
        found.arrangements[0].energy_per_body_kt
    };
    let designed = {
        let site = CageSite {
            body: 0,
            position: vertex.normalize(),
            rotation: Rotation::identity(),
        };
        let cage = Cage {
            group: CubicGroup::Octahedral,
            sites: vec![site],
        };
        let engine = Engine::new(assembly(&bodies, vec![0], vec![Pose::identity()])).unwrap();
        let hard = HardBodies::new(vec![HardBody::from_body(&bodies[0]).unwrap()]);
        let closed = Arrangement::close(&cage, &hard, 0.1, 1e-3).unwrap();
        let energies = PairEnergies(engine.pair_potentials(&concentrated()).unwrap());
        energies
            .energy(&closed.placements, &closed.orbits)
            .total_kt()
            / 24.0
    };
    let [tetrahedral, octahedral, icosahedral] = [
        CubicGroup::Tetrahedral,
        CubicGroup::Octahedral,
        CubicGroup::Icosahedral,
    ]
    .map(lowest);
    assert!(octahedral < designed + 0.05 * designed.abs());
    assert!(octahedral < tetrahedral - 0.5 && octahedral < icosahedral - 0.5);
}
