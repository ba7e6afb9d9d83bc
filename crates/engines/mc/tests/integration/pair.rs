//! Two bodies: virial coefficients that are known in closed form or by quadrature.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{TriangleMesh, Vec3};
use protomer_mc::BodyType;
use protomer_mc::pair::{
    BodyPair, Charged, Core, Estimator, PairSettings, PairThermodynamics, Terms,
};
use std::f64::consts::PI;
use std::sync::Arc;

fn estimate(pair: &BodyPair, settings: PairSettings) -> PairThermodynamics {
    let mut estimator = Estimator::new(settings).unwrap();
    while estimator.done() < Estimator::steps(&settings) {
        estimator.advance(pair);
    }
    estimator.thermodynamics(pair)
}

fn pair_of(first: Arc<BodyType>, second: Arc<BodyType>, yukawa: Option<Yukawa>) -> BodyPair {
    let mut potential = Terms::default();
    if let Some(yukawa) = yukawa {
        let charged = Charged::new(yukawa, &first.charges, &second.charges).unwrap();
        potential.0.push(Arc::new(charged));
    }
    BodyPair {
        first,
        second,
        potential,
        core: Core::Surfaces,
        contact_gap_angstrom: 5.0,
    }
}

/// B₂ of a hard convex body (Isihara, J. Chem. Phys. 18, 1446 (1950)): V + S R̄. A cube of edge a
/// has R̄ = 3a/4, a regular tetrahedron of edge a has R̄ = 3a arccos(-1/3)/(4π).
#[test]
fn hard_convex_bodies_have_the_coefficient_of_isihara() {
    let edge: f64 = 10.0 * 2.0_f64.sqrt();
    let mesh = TriangleMesh::tetrahedron(5.0);
    let mean_radius = 3.0 * edge * (-1.0_f64 / 3.0).acos() / (4.0 * PI);
    let expected = mesh.volume_angstrom3() + mesh.area_angstrom2() * mean_radius;
    let body = Arc::new(BodyType::new("tetrahedron", &mesh, &[]).unwrap());
    let found = estimate(&pair_of(body.clone(), body, None), PairSettings::default());
    let deviation = found.b2_angstrom3 - expected;
    assert!(
        deviation.abs() < 3.0 * found.b2_error_angstrom3,
        "{} ± {} but {expected}",
        found.b2_angstrom3,
        found.b2_error_angstrom3
    );
    assert!(found.b2_error_angstrom3 < 0.01 * expected);
    // Without energies the two differ by rays that graze the body only.
    let energetic = found.b2_angstrom3 - found.b2_hard_angstrom3;
    assert!(energetic.abs() < 1e-4 * expected, "{energetic}");
}

/// Fewer rays than for the default error, but enough: thin rods, whose hard part varies more with their orientations than that of
/// proteins.
#[test]
fn fewer_hard_rays_serve_a_larger_error() {
    let corner = Vec3::new(3.0, 3.0, 15.0);
    let mesh = TriangleMesh::cuboid(&-corner, &corner);
    let rod = Arc::new(BodyType::new("rod", &mesh, &[]).unwrap());
    // V + S R̄ with R̄ a quarter of the sum of the edges.
    let expected = mesh.volume_angstrom3() + mesh.area_angstrom2() * 0.5 * corner.sum();
    let rod = pair_of(rod.clone(), rod, None);
    let mut errors = Vec::new();
    for relative_error in [0.004, 0.05, 0.2] {
        let settings = PairSettings {
            relative_error,
            most_directions: 1024,
            ..PairSettings::default()
        };
        let found = estimate(&rod, settings);
        let error = found.b2_hard_error_angstrom3;
        let off = found.b2_hard_angstrom3 - expected;
        assert!(off.abs() < 4.0 * error, "{relative_error}: {off} {error}");
        assert!(error < 0.5 * relative_error.max(0.01) * expected, "{error}");
        errors.push(error);
    }
    assert!(errors[2] > errors[0], "fewer rays say less: {errors:?}");
}

/// A cube of 10 Å: eight vertices, so that faces in contact have none near each other.
fn cube() -> Arc<BodyType> {
    let mesh = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
    Arc::new(BodyType::new("cube", &mesh, &[]).unwrap())
}

/// The poses in which the surfaces of two hard convex bodies are nearer than g: what is excluded if
/// one of them is grown by g, less what is excluded as it is. With V_ex = V₁ + V₂ + S₁R₂ + S₂R₁
/// (Isihara) and Steiner's formulae of the grown body.
#[test]
fn the_contact_volume_of_cubes_is_that_of_their_surfaces() {
    let (edge, gap): (f64, f64) = (10.0, 5.0);
    let (area, radius) = (6.0 * edge * edge, 0.75 * edge);
    let grown_volume = area * gap + 4.0 * PI * radius * gap * gap + 4.0 / 3.0 * PI * gap.powi(3);
    let grown_area = 8.0 * PI * radius * gap + 4.0 * PI * gap * gap;
    let expected = grown_volume + area * gap + grown_area * radius;
    let body = cube();
    let found = estimate(&pair_of(body.clone(), body, None), PairSettings::default());
    let (volume, error) = (
        found.association_volume_angstrom3,
        found.association_volume_error_angstrom3,
    );
    assert!(error < 0.02 * expected, "{error}");
    let deviation = (volume - expected).abs();
    assert!(deviation < 3.0 * error, "{volume} ± {error}, {expected}");
}

/// -½ ∫ (exp(-U) - 1) 4π r² dr beyond a distance, for central charges.
fn soft_part(from: f64, product: f64, yukawa: &Yukawa) -> f64 {
    let (steps, end) = (400_000, 400.0);
    let width = (end - from) / f64::from(steps);
    let mut sum = 0.0;
    for step in 0..steps {
        let r = from + (f64::from(step) + 0.5) * width;
        let mayer = (-product * yukawa.energy_kt(r)).exp_m1();
        sum += mayer * 4.0 * PI * r * r * width;
    }
    -0.5 * sum
}

#[test]
fn spheres_with_central_charges_follow_quadrature() {
    let mesh = icosphere(10.0, 2);
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    for (first, second) in [(3.0, 3.0), (4.0, -5.0)] {
        let body = |charge| {
            let charges = [(Vec3::zeros(), charge)];
            Arc::new(BodyType::new("sphere", &mesh, &charges).unwrap())
        };
        let pair = pair_of(body(first), body(second), Some(yukawa));
        let found = estimate(&pair, PairSettings::default());
        // The distance of touching spheres with the same excluded volume as the polyhedra.
        let touching = (1.5 * found.b2_hard_angstrom3 / PI).cbrt();
        let soft = soft_part(touching, first * second, &yukawa);
        let expected = found.b2_hard_angstrom3 + soft;
        // Polyhedra touch at 19.2 to 20 Å: the average over them is not that of spheres.
        let allowed = 3.0 * found.b2_error_angstrom3 + 0.01 * soft.abs();
        let deviation = found.b2_angstrom3 - expected;
        assert!(
            deviation.abs() < allowed,
            "{first} {second}: {} ± {} but {expected}",
            found.b2_angstrom3,
            found.b2_error_angstrom3
        );
        // Far away, w is the energy of the two charges.
        for row in found
            .mean_force
            .iter()
            .filter(|row| row.distance_angstrom > 25.0)
        {
            let energy = first * second * yukawa.energy_kt(row.distance_angstrom);
            let allowed = 4.0 * row.w_error_kt + 0.03 * energy.abs() + 1e-3;
            assert!((row.w_kt - energy).abs() < allowed, "{row:?} but {energy}");
        }
        let is_attractive = first * second < 0.0;
        let is_bound = found.association_volume_angstrom3 > found.contact_volume_angstrom3;
        assert_eq!(is_bound, is_attractive);
    }
}

/// A pair with wells: opposite charges below the faces of a tetrahedron.
fn pair_with_wells() -> BodyPair {
    let mesh = chiral_tetrahedron();
    let yukawa = Yukawa::uncut(7.0, 1.0 / 5.0).unwrap();
    let places = [[6.0, -0.6, -1.4], [-2.6, 4.6, -1.4], [0.2, 0.5, 3.6]];
    let body = |charges: [f64; 3]| {
        let sites: Vec<(Vec3, f64)> = places.map(Vec3::from).into_iter().zip(charges).collect();
        Arc::new(BodyType::new("body", &mesh, &sites).unwrap())
    };
    let (first, second) = (body([1.5, -1.0, 1.0]), body([-1.5, 1.0, -1.0]));
    pair_of(first, second, Some(yukawa))
}

#[test]
fn forty_repeats_spread_as_their_errors_say() {
    let pair = pair_with_wells();
    let mut repeats = Vec::new();
    for seed in 0..40 {
        let settings = PairSettings {
            seed,
            relative_error: 0.1,
            pilot_directions: 64,
            hard_directions: 64,
            ..PairSettings::default()
        };
        let found = estimate(&pair, settings);
        repeats.push((found.b2_angstrom3, found.b2_error_angstrom3));
    }
    let mean = repeats.iter().map(|(b2, _)| b2).sum::<f64>() / 40.0;
    let mut sum = 0.0;
    let mut covered = 0;
    for (b2, error) in &repeats {
        sum += ((b2 - mean) / error).powi(2);
        covered += u32::from((b2 - mean).abs() < 1.03 * error);
    }
    // χ²/39 with errors of fifteen degrees of freedom each: 1.15 on average; 0.5 and 2.1 are missed
    // once in a thousand times. The error bar covers 68 % of cases: 27 ± 3 of 40.
    assert!((0.5..2.1).contains(&(sum / 39.0)), "{}", sum / 39.0);
    assert!((17..=37).contains(&covered), "{covered}");
}

#[test]
fn an_estimate_continues_and_does_not_depend_on_threads() {
    let pair = pair_with_wells();
    let settings = PairSettings {
        replicas: 4,
        pilot_directions: 128,
        hard_directions: 64,
        most_directions: 256,
        ..PairSettings::default()
    };
    let whole = estimate(&pair, settings);
    let mut half = Estimator::new(settings).unwrap();
    while half.done() < 8 {
        half.advance(&pair);
    }
    let json = serde_json::to_string(&half).unwrap();
    let mut half: Estimator = serde_json::from_str(&json).unwrap();
    let one_thread = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    one_thread.install(|| {
        while half.done() < Estimator::steps(&settings) {
            half.advance(&pair);
        }
    });
    assert_eq!(half.thermodynamics(&pair), whole);
}

#[test]
fn unscreened_charges_are_refused() {
    let pair = pair_with_wells();
    let bare = Yukawa::uncut(7.0, 0.0).unwrap();
    let refused = Charged::new(bare, &pair.first.charges, &pair.second.charges);
    let message = refused.err().unwrap().to_string();
    assert!(message.contains("add salt"), "{message}");
}
