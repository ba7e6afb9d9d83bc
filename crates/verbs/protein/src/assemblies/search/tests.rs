//! The search finds wells that are known beforehand, and its energies are the sums over all pairs.

use super::*;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::inspect::{inspect, inspection_settings};
use crate::stability::interaction::{InteractionSettings, ScreenedCoulomb};
use crate::stability::run::{EnergyMode, Engine};
use protomer_body::assembly::{HardBody, RecipeSite};
use protomer_body::{Body, Source, SurfaceSettings, build_body_of_points};
use protomer_kernel::{Boundary, PointRecord, Pose, Vec3};
use std::sync::Arc;

/// A rod of balls along x with these charges, e.
fn rod(charges: &[f64]) -> Arc<Body> {
    let middle = 0.5 * (charges.len() as f64 - 1.0);
    let balls: Vec<PointRecord> = charges
        .iter()
        .enumerate()
        .map(|(number, charge_e)| PointRecord {
            position: Vec3::new(4.0 * (number as f64 - middle), 0.0, 0.0),
            radius_angstrom: 4.0,
            charge_e: *charge_e,
            ..PointRecord::default()
        })
        .collect();
    let source = Source {
        file: "rod.pqr",
        sha256: "",
    };
    let settings = SurfaceSettings::default();
    let draft = build_body_of_points("rod", source, &balls, &settings).unwrap();
    Arc::new(draft.body)
}

fn medium() -> ScreenedCoulomb {
    InteractionSettings::default()
        .interaction(Some(0.05))
        .unwrap()
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
) -> Found {
    let kinds: Vec<usize> = (0..bodies.len()).collect();
    let poses = vec![Pose::identity(); bodies.len()];
    let engine = Engine::new(assembly(bodies, kinds, poses)).unwrap();
    let potentials = engine.pair_potentials(&medium()).unwrap();
    let hard = bodies.iter().map(|body| HardBody::of(body).unwrap());
    let up = recipe.rings.iter().flatten().map(|site| site.up).collect();
    let settings = SearchSettings {
        tilts_degrees: tilts.to_vec(),
        spins_degrees: spins.to_vec(),
        refined,
        gap_angstrom: 0.5,
    };
    let hard = HardBodies::new(hard.collect());
    let patterns = [Pattern { up, recipe }];
    let execution = Execution::default();
    let found = search(&hard, potentials, &patterns, &settings, &execution).unwrap();
    found.unwrap()
}

/// Two rods with a dipole along their axis, one the other turned about the axis of the ring by half a turn:
/// upright they are parallel and repel each other, across the axis they are antiparallel, side by side.
#[test]
fn two_dipoles_lie_across_the_axis() {
    let body = rod(&[2.0, 0.0, 0.0, 0.0, -2.0]);
    let ring = Recipe::ring(2, &[RecipeSite::upright(0)]);
    let found = found(&[body], ring, &[0.0, 40.0], &[0.0], 1);
    let best = &found.arrangements[0];
    assert!((best.tilt_degrees[0].abs() - 90.0).abs() < 2.0, "{best:?}");
    assert!(best.energy_kt < -1.0 && best.is_refined);
    assert!(best.opening_angstrom < 0.1, "{best:?}");
    let upright = found.arrangements.last().unwrap();
    assert!(upright.energy_kt > 0.5, "{upright:?}");
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
        let hard = HardBodies::new(bodies.iter().map(|b| HardBody::of(b).unwrap()).collect());
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
    let from_grid = first.arrangements.iter().filter(|each| !each.is_refined);
    assert!(from_grid.count() > 0);
}
