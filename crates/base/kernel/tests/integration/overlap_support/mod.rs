//! What the tests and benchmarks of overlap share: bumpy meshes, random poses, and the slow obvious
//! oracle.
#![allow(dead_code, missing_docs, reason = "benchmarks use a part of it")]

use protomer_kernel::{Pose, RelativePose, TriangleMesh, Vec3};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use std::collections::HashMap;

pub fn generator(seed: u64) -> SmallRng {
    SmallRng::seed_from_u64(seed)
}

/// An octahedron subdivided `level` times (8 · 4^level triangles) with its corners at distance
/// `radius` of their direction.
pub fn star_mesh(level: usize, radius: impl Fn(&Vec3) -> f64) -> TriangleMesh {
    let TriangleMesh {
        mut vertices,
        mut triangles,
    } = TriangleMesh::octahedron(1.0);
    for _ in 0..level {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    TriangleMesh {
        vertices: vertices.iter().map(|v| v * radius(v)).collect(),
        triangles,
    }
}

/// A bumpy, nonconvex body of mean radius 10 Å, longer along z, different for each seed.
pub fn bumpy_mesh(level: usize, seed: u64) -> TriangleMesh {
    let mut random = generator(seed);
    let waves: Vec<(Vec3, f64)> = (0..6)
        .map(|_| {
            (
                random_rotation_vector(&mut random) * 2.0,
                random.random_range(0.0..std::f64::consts::TAU),
            )
        })
        .collect();
    let bumps = |v: &Vec3| {
        waves
            .iter()
            .map(|(k, phase)| (3.0 * k.dot(v) + phase).sin())
            .sum::<f64>()
    };
    star_mesh(level, |v| 10.0 + 0.8 * bumps(v) + 4.0 * v.z * v.z)
}

fn random_rotation_vector(random: &mut SmallRng) -> Vec3 {
    loop {
        let v = Vec3::from_fn(|_, _| random.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&v.norm_squared()) {
            return v.normalize();
        }
    }
}

pub fn random_direction(random: &mut SmallRng) -> Vec3 {
    random_rotation_vector(random)
}

/// A uniformly random orientation.
pub fn random_orientation(random: &mut SmallRng) -> [f64; 4] {
    loop {
        let q: [f64; 4] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
        let squared: f64 = q.iter().map(|x| x * x).sum();
        if (0.01..1.0).contains(&squared) {
            return q;
        }
    }
}

/// A random orientation at a distance along a random direction.
pub fn random_pose(random: &mut SmallRng, distance: f64) -> RelativePose {
    let second = Pose::from_wxyz(
        random_direction(random) * distance,
        random_orientation(random),
    );
    RelativePose::from(&second)
}

/// The same pose with its translation scaled so that it is `extra` longer.
pub fn pushed(pose: &RelativePose, extra: f64) -> RelativePose {
    let translation = pose.translation * (1.0 + extra / pose.translation.norm());
    RelativePose {
        translation,
        ..*pose
    }
}

/// Moves the second body along its translation to the outermost contact, to within 1e-12 Å: the
/// pose just clear of it.
pub fn brought_to_contact(
    pose: &RelativePose,
    overlap: impl Fn(&RelativePose) -> bool,
) -> RelativePose {
    let shifted = |length: f64| RelativePose {
        translation: pose.translation.normalize() * length,
        ..*pose
    };
    let mut clear = 80.0;
    // Step inwards so as to find the outermost contact of nonconvex bodies.
    while clear > 0.5 && !overlap(&shifted(clear - 0.5)) {
        clear -= 0.5;
    }
    let mut inside = (clear - 0.5).max(0.0);
    while clear - inside > 1e-12 * clear.max(1.0) {
        let middle = 0.5 * (clear + inside);
        if middle <= inside || middle >= clear {
            break;
        }
        if overlap(&shifted(middle)) {
            inside = middle
        } else {
            clear = middle
        }
    }
    shifted(clear)
}

/// The slow obvious twin: every pair of triangles, then the winding number of a corner of every
/// body.
pub fn brute_force_overlaps(
    first: &TriangleMesh,
    second: &TriangleMesh,
    pose: &RelativePose,
) -> bool {
    let moved = second.map_vertices(|vertex| pose.transform_point(vertex));
    surfaces_intersect(first, &moved)
        || any_shell_inside(first, &moved)
        || any_shell_inside(&moved, first)
}

pub fn surfaces_intersect(first: &TriangleMesh, second: &TriangleMesh) -> bool {
    let bounds: Vec<(Vec3, Vec3)> = (0..second.triangles.len())
        .map(|t| bounds(&second.corners(t)))
        .collect();
    (0..first.triangles.len()).any(|a| {
        let a = first.corners(a);
        let (low, high) = self::bounds(&a);
        bounds.iter().enumerate().any(|(b, (b_low, b_high))| {
            let apart = (0..3).any(|k| low[k] > b_high[k] || b_low[k] > high[k]);
            !apart && edges_cross(&a, &second.corners(b))
        })
    })
}

fn bounds(corners: &[Vec3; 3]) -> (Vec3, Vec3) {
    let [a, b, c] = corners;
    (a.inf(b).inf(c), a.sup(b).sup(c))
}

/// Whether an edge of one triangle passes through the other (Möller-Trumbore), for triangles in
/// general position.
fn edges_cross(first: &[Vec3; 3], second: &[Vec3; 3]) -> bool {
    (0..3).any(|i| {
        segment_crosses(&first[i], &first[(i + 1) % 3], second)
            || segment_crosses(&second[i], &second[(i + 1) % 3], first)
    })
}

fn segment_crosses(from: &Vec3, to: &Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    let (u, v, direction, w) = (b - a, c - a, to - from, from - a);
    let across = direction.cross(&v);
    let determinant = u.dot(&across);
    if determinant == 0.0 {
        return false;
    }
    let first = w.dot(&across) / determinant;
    let around = w.cross(&u);
    let second = direction.dot(&around) / determinant;
    let along = v.dot(&around) / determinant;
    first >= 0.0 && second >= 0.0 && first + second <= 1.0 && (0.0..=1.0).contains(&along)
}

/// Whether a shell of one mesh has its first corner inside another mesh.
fn any_shell_inside(mesh: &TriangleMesh, other: &TriangleMesh) -> bool {
    let radius = mesh.radius_about_origin_angstrom();
    other.shells().expect("closed").iter().any(|shell| {
        let corner = shell.vertices[0];
        corner.norm() <= radius && winding_number(mesh, &corner).round() != 0.0
    })
}

/// Turns of a closed mesh around a point: 1 inside, 0 outside. Solid angles by van Oosterom and
/// Strackee (1983).
pub fn winding_number(mesh: &TriangleMesh, point: &Vec3) -> f64 {
    let solid_angle = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(below)
    };
    (0..mesh.triangles.len()).map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// The same mesh for the library that serves as second oracle.
pub fn parry_mesh(mesh: &TriangleMesh) -> parry3d_f64::shape::TriMesh {
    let vertices = mesh
        .vertices
        .iter()
        .map(|v| parry3d_f64::math::Vector::new(v.x, v.y, v.z))
        .collect();
    parry3d_f64::shape::TriMesh::new(vertices, mesh.triangles.clone()).expect("a mesh")
}

pub fn parry_pose(pose: &RelativePose) -> parry3d_f64::math::Pose {
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(pose.rotation);
    let quaternion = nalgebra::UnitQuaternion::from_rotation_matrix(&rotation);
    let q = quaternion.quaternion();
    let t = pose.translation;
    parry3d_f64::math::Pose::from_parts(
        parry3d_f64::math::Vector::new(t.x, t.y, t.z),
        parry3d_f64::math::Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    )
}

pub fn parry_intersects(
    first: &parry3d_f64::shape::TriMesh,
    second: &parry3d_f64::shape::TriMesh,
    pose: &RelativePose,
) -> bool {
    let origin = parry3d_f64::math::Pose::IDENTITY;
    parry3d_f64::query::intersection_test(&origin, first, &parry_pose(pose), second)
        .expect("supported")
        .intersecting
}
