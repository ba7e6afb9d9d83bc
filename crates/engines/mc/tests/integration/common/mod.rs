//! Small bodies, and means with honest errors.

use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::statistics::RunningMoments;
use protomer_kernel::{Boundary, Pose, TriangleMesh, Vec3};
use protomer_mc::energy::{DirectSum, EnergyModel};
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

include!("bench_states.rs");

use crate::test_data;

/// The benchmark states, which are not part of the repository.
pub fn bench_folder() -> std::path::PathBuf {
    test_data::test_data("bench/data")
}

/// The sixteen charged bodies of the benchmark.
pub fn bench_system(folder: &Path, mesh: &str) -> System {
    let mesh = read_off(&folder.join(mesh));
    let kind = |name: &str| {
        Arc::new(
            BodyType::new(
                name,
                &mesh,
                &read_charges(&folder.join(format!("charges_{name}.xyzq"))),
            )
            .unwrap(),
        )
    };
    let (boundary, bodies) = read_assembly(&folder.join("cluster16.json"));
    System::new(vec![kind("a"), kind("b")], &bodies, boundary).unwrap()
}

/// A sphere of this radius with 20 · 4^level triangles.
pub fn icosphere(radius: f64, level: usize) -> TriangleMesh {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut vertices: Vec<Vec3> = Vec::new();
    for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
        vertices.extend([
            Vec3::new(0.0, a, b),
            Vec3::new(a, b, 0.0),
            Vec3::new(b, 0.0, a),
        ]);
    }
    let mut triangles = hull_faces(&vertices);
    for _ in 0..level {
        let mut middles = HashMap::new();
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let mut middle = |i: u32, j: u32| {
                    *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                        vertices.push(
                            (vertices[i as usize] + vertices[j as usize]).normalize()
                                * (1.0 + g * g).sqrt(),
                        );
                        vertices.len() as u32 - 1
                    })
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    TriangleMesh {
        vertices: vertices
            .iter()
            .map(|vertex| vertex.normalize() * radius)
            .collect(),
        triangles,
    }
}

/// The faces of the convex hull of a few points in general position, by trying all triples.
pub fn hull_faces(points: &[Vec3]) -> Vec<[u32; 3]> {
    let mut faces = Vec::new();
    for a in 0..points.len() {
        for b in 0..points.len() {
            for c in 0..points.len() {
                let lowest_first = a < b && a < c && b != c;
                let normal = (points[b] - points[a]).cross(&(points[c] - points[a]));
                let behind = |k: usize| {
                    k == a || k == b || k == c || normal.dot(&(points[k] - points[a])) < -1e-9
                };
                if lowest_first && (0..points.len()).all(behind) {
                    faces.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    faces
}

/// A convex body without any symmetry.
pub fn chiral_tetrahedron() -> TriangleMesh {
    let vertices = vec![
        Vec3::new(9.0, -1.0, -2.0),
        Vec3::new(-4.0, 7.0, -2.0),
        Vec3::new(-4.0, -5.0, -3.0),
        Vec3::new(0.5, 1.0, 6.0),
    ];
    let triangles = hull_faces(&vertices);
    TriangleMesh {
        vertices,
        triangles,
    }
}

/// A nonconvex body without any symmetry.
pub fn chiral_bump(radius: f64) -> TriangleMesh {
    icosphere(1.0, 1).map_vertices(|v| {
        v * (radius
            * (1.0 + 0.35 * v.x * v.y + 0.5 * v.y * v.z * v.z - 0.3 * v.z * v.x
                + 0.9 * v.x * v.y * v.z))
    })
}

/// A mean and its standard error.
#[derive(Debug, Clone, Copy)]
pub struct Estimate {
    pub mean: f64,
    pub error: f64,
}

impl Estimate {
    /// From independent samples.
    pub fn from_samples(samples: &[f64]) -> Self {
        let moments = RunningMoments::in_two_passes(samples);
        Self {
            mean: moments.mean(),
            error: moments.independent_standard_error(),
        }
    }

    pub fn exact(mean: f64) -> Self {
        Self { mean, error: 0.0 }
    }

    /// The difference in standard errors.
    pub fn sigmas_from(&self, other: &Estimate) -> f64 {
        (self.mean - other.mean).abs() / self.error.hypot(other.error)
    }
}

/// Holds estimates against each other: at most 3 standard errors apart, and sharp enough to mean
/// something.
#[track_caller]
pub fn assert_agree(name: &str, measured: Estimate, expected: Estimate, largest_error: f64) {
    let sigmas = measured.sigmas_from(&expected);
    eprintln!(
        "{name}: {:.5} ± {:.5} against {:.5} ± {:.5}: {sigmas:.2} sigma",
        measured.mean, measured.error, expected.mean, expected.error
    );
    assert!(
        measured.error < largest_error,
        "{name}: the error {} is too large to decide",
        measured.error
    );
    assert!(
        sigmas < 3.0,
        "{name}: {measured:?} against {expected:?} is {sigmas:.2} sigma"
    );
}

/// Averages of `measure` over production sweeps, one estimate per quantity from independent
/// replicas.
pub fn simulate<const N: usize>(
    system: &System,
    settings: Settings,
    replicas: u32,
    sweeps: u64,
    measure: impl Fn(&Simulation) -> [f64; N],
) -> [Estimate; N] {
    let means: Vec<[f64; N]> = (0..replicas)
        .map(|replica| {
            let mut simulation = Simulation::new(system.clone(), settings, 20, replica).unwrap();
            let equilibration = settings.equilibration_sweeps;
            simulation
                .run_until(equilibration, &mut |_| ControlFlow::Continue(()))
                .unwrap();
            let mut sums = [0.0; N];
            simulation
                .run_until(equilibration + sweeps, &mut |state| {
                    measure(state)
                        .iter()
                        .zip(&mut sums)
                        .for_each(|(value, sum)| *sum += value);
                    ControlFlow::Continue(())
                })
                .unwrap();
            assert_eq!(overlapping_pairs(simulation.system()), []);
            sums.map(|sum| sum / sweeps as f64)
        })
        .collect();
    std::array::from_fn(|k| {
        Estimate::from_samples(&means.iter().map(|mean| mean[k]).collect::<Vec<_>>())
    })
}

/// Boltzmann averages over uniformly drawn states of two bodies: the direct integral, in
/// independent batches.
pub fn integrate<const N: usize>(
    types: &[Arc<BodyType>; 2],
    boundary: Boundary,
    yukawa: Option<Yukawa>,
    states: u32,
    measure: impl Fn(&System, f64) -> [f64; N],
) -> [Estimate; N] {
    const BATCHES: u32 = 16;
    let mut energy_model = yukawa.map(DirectSum::new);
    let means: Vec<[f64; N]> = (0..BATCHES)
        .map(|batch| {
            let mut rng = CounterRng::new(77, batch, 0);
            let (mut sums, mut weights) = ([0.0; N], 0.0);
            for _ in 0..states / BATCHES {
                let mut pose = || Pose {
                    position: uniform_in(&boundary, &mut rng),
                    rotation: rng.rotation(),
                };
                let system =
                    System::new(types.to_vec(), &[(0, pose()), (1, pose())], boundary).unwrap();
                if !overlapping_pairs(&system).is_empty() {
                    continue;
                }
                let energy = energy_model.as_mut().map_or(0.0, |model| {
                    model.reset(&system).unwrap();
                    model.total_kt(&system)
                });
                let weight = (-energy).exp();
                weights += weight;
                measure(&system, energy)
                    .iter()
                    .zip(&mut sums)
                    .for_each(|(value, sum)| *sum += weight * value);
            }
            sums.map(|sum| sum / weights)
        })
        .collect();
    std::array::from_fn(|k| {
        Estimate::from_samples(&means.iter().map(|mean| mean[k]).collect::<Vec<_>>())
    })
}

fn uniform_in(boundary: &Boundary, rng: &mut CounterRng) -> Vec3 {
    match boundary {
        Boundary::Periodic { lengths_angstrom } => {
            lengths_angstrom.map(|length| length * rng.uniform_in(-0.5, 0.5))
        }
        Boundary::SphereWall { radius_angstrom } => rng.vector_in_ball(*radius_angstrom),
        Boundary::Open => panic!("open space has no uniform distribution"),
    }
}

/// The distance between the origins of bodies 0 and 1, Å.
pub fn distance(system: &System) -> f64 {
    system.pair(0, 1).displacement.norm()
}

/// Settings for small test systems: tuned briefly, `cluster_moves` per sweep.
pub fn settings(interaction: Interaction, cluster_moves: u32) -> Settings {
    Settings {
        translation_step_angstrom: 4.0,
        rotation_step_rad: 0.5,
        equilibration_sweeps: 500,
        cluster_moves_per_sweep: cluster_moves,
        ..Settings::new(interaction)
    }
}
