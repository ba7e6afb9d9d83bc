//! Scattering against known answers: gases, pairs, lattices, spheres.

use protomer_body::Body;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Rotation, TriangleMesh, Vec3};
use protomer_mc::scattering::experiment::{Experiment, Settings};
use protomer_mc::scattering::scatterers::Scatterers;
use protomer_mc::scattering::structure_factor::{evaluate, open};
use protomer_mc::scattering::wave_vectors::shells;
use protomer_mc::{BodyType, System};
use std::f64::consts::{LN_2, TAU};
use std::sync::Arc;

/// A sphere of triangles: rings of equal height and the poles. Its volume is that of the radius.
fn sphere(radius: f64) -> TriangleMesh {
    let (rings, around) = (40_u32, 80_u32);
    let mut vertices = vec![Vec3::z() * radius];
    for ring in 1..rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for step in 0..around {
            let (sine, cosine) = (TAU * f64::from(step) / f64::from(around)).sin_cos();
            vertices
                .push(Vec3::new(polar.sin() * cosine, polar.sin() * sine, polar.cos()) * radius);
        }
    }
    vertices.push(-Vec3::z() * radius);
    let last = vertices.len() as u32 - 1;
    let place = |ring: u32, step: u32| 1 + (ring - 1) * around + step % around;
    let mut triangles = Vec::new();
    for step in 0..around {
        triangles.push([0, place(1, step), place(1, step + 1)]);
        triangles.push([last, place(rings - 1, step + 1), place(rings - 1, step)]);
        for ring in 1..rings - 1 {
            let (a, b) = (place(ring, step), place(ring, step + 1));
            let (c, d) = (place(ring + 1, step), place(ring + 1, step + 1));
            triangles.push([a, c, d]);
            triangles.push([a, d, b]);
        }
    }
    let mut mesh = TriangleMesh {
        vertices,
        triangles,
    };
    let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let scale = (exact / mesh.volume_angstrom3()).cbrt();
    for vertex in &mut mesh.vertices {
        *vertex *= scale;
    }
    mesh
}

fn ball(radius: f64) -> Arc<Body> {
    Arc::new(Body {
        name: "ball".into(),
        ..solid(sphere(radius))
    })
}

fn system(body: &Body, places: &[Vec3], boundary: Boundary) -> System {
    let kind = Arc::new(BodyType::from_body(body).unwrap());
    let placed = |position: &Vec3| {
        let pose = Pose {
            position: *position,
            ..Pose::identity()
        };
        (0, pose)
    };
    System::new(
        vec![kind],
        &places.iter().map(placed).collect::<Vec<_>>(),
        boundary,
    )
    .unwrap()
}

/// 9 (sin x - x cos x)²/x⁶.
fn sphere_form_factor(x: f64) -> f64 {
    9.0 * (x.sin() - x * x.cos()).powi(2) / x.powi(6)
}

#[test]
fn an_ideal_gas_has_a_structure_factor_of_one() {
    let length = 200.0;
    let shells = shells([length; 3], 0.3, 6, 20, 1);
    let frames = 2000;
    let mut sums = vec![(0.0, 0.0); shells.len()];
    for frame in 0..frames {
        let mut rng = CounterRng::new(11, 0, frame);
        let gas: Vec<Vec3> = (0..30)
            .map(|_| Vec3::from_fn(|_, _| length * rng.uniform()))
            .collect();
        for (sum, shell) in sums.iter_mut().zip(&shells) {
            let mean: f64 = shell
                .vectors
                .iter()
                .map(|vector| evaluate(&gas, vector))
                .sum::<f64>()
                / shell.vectors.len() as f64;
            *sum = (sum.0 + mean, sum.1 + mean * mean);
        }
    }
    for ((sum, squares), shell) in sums.into_iter().zip(&shells) {
        let n = frames as f64;
        let mean = sum / n;
        let error = ((squares / n - mean * mean) / n).sqrt();
        assert!(
            error < 0.02 && (mean - 1.0).abs() < 4.0 * error,
            "{shell:?}: {mean} ± {error}"
        );
    }
}

#[test]
fn a_pair_has_the_structure_factor_of_its_distance() {
    let body = ball(15.0);
    let settings = Settings {
        largest_q_per_angstrom: 0.4,
        wave_numbers: 40,
        directions: 4000,
        ..Settings::default()
    };
    let distance = 33.0;
    let pair = [
        Vec3::new(5.0, -3.0, 2.0),
        Vec3::new(5.0, -3.0 + distance, 2.0),
    ];
    let experiment = Experiment::new(&[Arc::clone(&body)], &Boundary::Open, settings).unwrap();
    let state = system(&body, &pair, Boundary::Open);
    let measured = experiment.measure(&state, 0);
    for (place, q) in experiment.q_per_angstrom().iter().enumerate() {
        let exact = 1.0 + (q * distance).sin() / (q * distance);
        assert!(
            (measured.structure_factor[place] - exact).abs() < 1e-12,
            "{q}"
        );
        // Spheres scatter as their form factor times the structure factor of their centres.
        let form = experiment.form_factor(0)[place];
        let sphere = sphere_form_factor(q * 15.0);
        assert!((form - sphere).abs() < 2e-3, "{q}: {form} {sphere}");
        let whole = sphere * exact;
        assert!(
            (measured.intensity[place] - whole).abs() < 3e-3,
            "{q}: {} {whole}",
            measured.intensity[place]
        );
    }
}

#[test]
fn the_intensity_of_few_turned_directions_has_no_systematic_error() {
    let body = ball(10.0);
    let settings = |directions| Settings {
        largest_q_per_angstrom: 0.2,
        wave_numbers: 2,
        directions,
        ..Settings::default()
    };
    let places = [
        Vec3::zeros(),
        Vec3::new(60.0, 0.0, 0.0),
        Vec3::new(0.0, 25.0, 70.0),
    ];
    let state = system(&body, &places, Boundary::Open);
    let experiment = |directions| {
        Experiment::new(&[Arc::clone(&body)], &Boundary::Open, settings(directions)).unwrap()
    };
    let exact = experiment(5000).measure(&state, 0).intensity;
    let few = experiment(8);
    let frames = 400;
    for (place, exact) in exact.into_iter().enumerate() {
        let values: Vec<f64> = (0..frames)
            .map(|n| few.measure(&state, n).intensity[place])
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        let error = (spread / values.len() as f64).sqrt();
        assert!(
            (mean - exact).abs() < 4.0 * error,
            "{mean} ± {error}, not {exact}"
        );
    }
}

#[test]
fn a_lattice_has_bragg_peaks_and_nothing_else() {
    // Simple cubic, 4 x 3 x 2 cells of 50 Å, in a separate box.
    let cells = [4, 3, 2];
    let lengths = cells.map(|count| 50.0 * f64::from(count));
    let mut places = Vec::new();
    for x in 0..cells[0] {
        for y in 0..cells[1] {
            for z in 0..cells[2] {
                places.push(Vec3::new(f64::from(x), f64::from(y), f64::from(z)) * 50.0);
            }
        }
    }
    let mut peaks = 0;
    for shell in shells(lengths, 0.4, 4, 100_000, 1) {
        for vector in &shell.vectors {
            let waves = vector * (50.0 / TAU);
            let is_peak = (waves - waves.map(f64::round)).norm() < 1e-9;
            let expected = if is_peak { places.len() as f64 } else { 0.0 };
            assert!(
                (evaluate(&places, vector) - expected).abs() < 1e-9,
                "{waves}"
            );
            peaks += usize::from(is_peak);
        }
    }
    assert!(peaks > 50, "{peaks}");
    // The same in an experiment: the mean over a shell is the share of the peaks in it.
    let body = ball(10.0);
    let boundary = Boundary::periodic(Vec3::from(lengths)).unwrap();
    let settings = Settings {
        largest_q_per_angstrom: 0.2,
        wave_numbers: 10,
        directions: 100_000,
        ..Settings::default()
    };
    let experiment = Experiment::new(&[Arc::clone(&body)], &boundary, settings).unwrap();
    let measured = experiment.measure(&system(&body, &places, boundary), 0);
    let shells = shells(lengths, 0.2, 10, 100_000, 1);
    for (shell, found) in shells.iter().zip(&measured.structure_factor) {
        let is_peak = |vector: &&Vec3| {
            let waves = *vector * (50.0 / TAU);
            (waves - waves.map(f64::round)).norm() < 1e-9
        };
        let peaks = shell.vectors.iter().filter(is_peak).count();
        let exact = (places.len() * peaks) as f64 / shell.vectors.len() as f64;
        assert!(
            (found - exact).abs() < 1e-9,
            "{}: {found} {exact}",
            shell.q_per_angstrom
        );
    }
}

#[test]
fn what_light_sees_of_spheres_is_their_radius() {
    let body = ball(20.0);
    let settings = Settings {
        hydration_angstrom: 0.0,
        contact_gap_angstrom: 3.0,
        ..Settings::default()
    };
    let experiment = Experiment::new(&[Arc::clone(&body)], &Boundary::Open, settings).unwrap();
    // One alone, and two that touch: the second across the border of a box.
    let length = 400.0;
    let boundary = Boundary::periodic(Vec3::repeat(length)).unwrap();
    let places = [
        Vec3::zeros(),
        Vec3::new(190.0, 0.0, 0.0),
        Vec3::new(-170.0, 0.0, 0.0),
    ];
    let state = system(&body, &places, boundary);
    let measured = experiment.measure(&state, 0);
    let sizes: Vec<usize> = measured
        .clusters
        .iter()
        .map(|cluster| cluster.bodies)
        .collect();
    assert_eq!(sizes, [1, 2]);
    let radii: Vec<f64> = measured
        .clusters
        .iter()
        .map(|cluster| cluster.hydrodynamic_radius_angstrom.unwrap() / 20.0)
        .collect();
    println!("radii {radii:?}");
    assert!((radii[0] - 1.0).abs() < 0.003, "{radii:?}");
    assert!((radii[1] - 2.0 * LN_2).abs() < 0.005, "{radii:?}");
    let q = settings.light_q_per_angstrom;
    let volume = body.mass_properties.volume_angstrom3;
    let single = volume * volume * sphere_form_factor(q * 20.0);
    let double = 2.0 * single * (1.0 + (q * 40.0).sin() / (q * 40.0));
    for (cluster, exact) in measured.clusters.iter().zip([single, double]) {
        assert!((cluster.light_angstrom6 / exact - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_chain_through_the_box_has_no_radius() {
    let body = ball(20.0);
    let boundary = Boundary::periodic(Vec3::new(120.0, 300.0, 300.0)).unwrap();
    let chain = [-40.0, 0.0, 40.0].map(|x| Vec3::new(x, 0.0, 0.0));
    let experiment = Experiment::new(&[Arc::clone(&body)], &boundary, Settings::default()).unwrap();
    let measured = experiment.measure(&system(&body, &chain, boundary), 0);
    assert_eq!(measured.clusters.len(), 1);
    assert_eq!(measured.clusters[0].hydrodynamic_radius_angstrom, None);
    // In a longer box it has an end.
    let boundary = Boundary::periodic(Vec3::repeat(300.0)).unwrap();
    let experiment = Experiment::new(&[Arc::clone(&body)], &boundary, Settings::default()).unwrap();
    let measured = experiment.measure(&system(&body, &chain, boundary), 0);
    assert!(measured.clusters[0].hydrodynamic_radius_angstrom.is_some());
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let body = ball(10.0);
    let mut settings = Settings {
        wave_numbers: 0,
        ..Settings::default()
    };
    let refusal =
        |settings| Experiment::new(&[Arc::clone(&body)], &Boundary::Open, settings).unwrap_err();
    assert!(refusal(settings).to_string().contains("wave_numbers is 0"));
    settings = Settings {
        largest_q_per_angstrom: 1e-4,
        ..Settings::default()
    };
    let boundary = Boundary::periodic(Vec3::repeat(100.0)).unwrap();
    let error = Experiment::new(&[body], &boundary, settings).unwrap_err();
    assert!(error.to_string().contains("2π over its length"), "{error}");
    assert!((open(&[Vec3::zeros()], 0.1) - 1.0).abs() < 1e-15);
}

/// A prism over a polygon in the plane z = 0, from below to above it.
fn prism(polygon: &[[f64; 2]], height: f64) -> TriangleMesh {
    let count = polygon.len() as u32;
    let level = |z: f64| polygon.iter().map(move |[x, y]| Vec3::new(*x, *y, z));
    let mut triangles = Vec::new();
    for corner in 1..count - 1 {
        triangles.push([0, corner + 1, corner]);
        triangles.push([count, count + corner, count + corner + 1]);
    }
    for corner in 0..count {
        let next = (corner + 1) % count;
        triangles.push([corner, next, count + next]);
        triangles.push([corner, count + next, count + corner]);
    }
    TriangleMesh {
        vertices: level(-0.5 * height).chain(level(0.5 * height)).collect(),
        triangles,
    }
}

fn cuboid([a, b, c]: [f64; 3]) -> TriangleMesh {
    let (x, y) = (0.5 * a, 0.5 * b);
    prism(&[[-x, -y], [x, -y], [x, y], [-x, y]], c)
}

fn solid(mesh: TriangleMesh) -> Body {
    Body::of_mesh("solid", mesh, Vec::new()).unwrap()
}

/// The radius of gyration that P(q) = 1 - (q R)²/3 shows.
fn radius_of_gyration(body: &Body) -> f64 {
    let q = 1e-3 / body.mesh.radius_about_origin_angstrom();
    let form_factor = Scatterers::of_body(body).unwrap().form_factor(q);
    (3.0 * (1.0 - form_factor)).sqrt() / q
}

#[test]
fn bodies_without_atoms_have_the_radius_of_gyration_of_their_solid() {
    let turn = Rotation::new(Vec3::new(0.3, -0.8, 0.5));
    for edges in [
        [30.0; 3],
        [20.0, 33.0, 47.0],
        [100.0, 100.0, 3.0],
        [4.0, 4.0, 170.0],
    ] {
        let squares: f64 = edges.iter().map(|edge: &f64| edge * edge).sum();
        let exact = (squares / 12.0).sqrt();
        let plain = cuboid(edges);
        let moved = plain.map_vertices(|vertex| turn * vertex + Vec3::new(7.0, 1.0, -3.0));
        for mesh in [plain, moved] {
            let found = radius_of_gyration(&solid(mesh));
            assert!(
                (found / exact - 1.0).abs() < 1e-4,
                "{edges:?}: {found} {exact}"
            );
        }
    }
    // A rod over a regular polygon of side s: R² = s² (2 + cos(2π/n))/(24 sin²(π/n)) + L²/12.
    for (count, radius, length) in [(6_u32, 10.0, 40.0), (48, 8.0, 90.0)] {
        let angle = TAU / f64::from(count);
        let corners: Vec<[f64; 2]> = (0..count)
            .map(|n| {
                [
                    radius * (angle * f64::from(n)).cos(),
                    radius * (angle * f64::from(n)).sin(),
                ]
            })
            .collect();
        let square = radius * radius * (2.0 + angle.cos()) / 6.0 + length * length / 12.0;
        let found = radius_of_gyration(&solid(prism(&corners, length)));
        assert!(
            (found / square.sqrt() - 1.0).abs() < 1e-4,
            "{found} {}",
            square.sqrt()
        );
    }
    let found = radius_of_gyration(&ball(30.0));
    let inertia = ball(30.0).mass_properties;
    let square = 0.5 * inertia.inertia_angstrom5.trace() / inertia.volume_angstrom3;
    assert!((found / square.sqrt() - 1.0).abs() < 1e-4);
}

/// P(q) of a box: (Π sin(q_i a_i/2)/(q_i a_i/2))² over all directions.
fn cuboid_form_factor(q: f64, edges: [f64; 3]) -> f64 {
    const STEPS: u32 = 200;
    let wave = |x: f64| if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
    let mut sum = 0.0;
    for height in 0..STEPS {
        let z = (f64::from(height) + 0.5) / f64::from(STEPS);
        let across = (1.0 - z * z).sqrt();
        for turn in 0..STEPS {
            let (sine, cosine) =
                (0.25 * TAU * (f64::from(turn) + 0.5) / f64::from(STEPS)).sin_cos();
            let direction = [across * cosine, across * sine, z];
            let factors = direction
                .iter()
                .zip(edges)
                .map(|(u, edge)| wave(0.5 * q * u * edge));
            sum += factors.product::<f64>().powi(2);
        }
    }
    sum / f64::from(STEPS * STEPS)
}

#[test]
fn boxes_without_atoms_have_the_form_factor_of_their_solid() {
    let turn = Rotation::new(Vec3::new(0.3, -0.8, 0.5));
    for edges in [[30.0; 3], [20.0, 33.0, 47.0]] {
        let plain = cuboid(edges);
        for mesh in [plain.clone(), plain.map_vertices(|vertex| turn * vertex)] {
            let distances = Scatterers::of_body(&solid(mesh)).unwrap().distances();
            for step in 1..=20 {
                let q = 0.01 * f64::from(step);
                let (found, exact) = (distances.form_factor(q), cuboid_form_factor(q, edges));
                assert!(
                    (found - exact).abs() < 1e-3,
                    "{edges:?}, q = {q}: {found} {exact}"
                );
            }
        }
    }
}
