//! Rates of the overlap kernel in processor time: trial moves of hard bodies, and single queries
//! compared with other methods.
//!
//! ```text
//! cargo bench -p protomer-kernel --bench overlap
//! ```

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr
)]

mod cpu_time;
#[path = "../tests/integration/overlap_support/mod.rs"]
mod overlap_support;

use cpu_time::{are_requested, cpu_seconds, seconds_per_call};
use overlap_support::*;
use protomer_kernel::overlap::{CarriedBound, comes_within, distance, overlaps, separation_bound};
use protomer_kernel::{Boundary, CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
use rand::RngExt;
use rand::rngs::SmallRng;
use std::hint::black_box;

/// Reported bounds reach this far, Å: a few trial steps.
const CEILING: f64 = 1.0;
/// Moves from the saved state before it is restored; hard bodies alone drift apart.
const STRETCH: usize = 2000;

fn main() {
    if !are_requested() {
        return;
    }
    for (name, mesh) in meshes() {
        let shape = CollisionShape::new(&mesh).unwrap();
        trial_moves(name, &shape);
        bound_quality(name, &shape, &mesh);
        single_queries(name, &shape, &mesh);
        nearness(name, &shape);
    }
}

/// A file of the benchmark states, which are not part of the repository.
fn state(name: &str) -> String {
    let root = std::env::var("PROTOMER_TEST_DATA").unwrap_or_default();
    format!("{root}/bench/data/{name}")
}

/// The two benchmark meshes, or a generated one where they are missing.
fn meshes() -> Vec<(&'static str, TriangleMesh)> {
    let read = |name| read_off(&state(&format!("{name}.off"))).map(|mesh| (name, mesh));
    let found: Vec<_> = ["bumpy_1620", "bumpy_5120"]
        .into_iter()
        .filter_map(read)
        .collect();
    if found.is_empty() {
        vec![("generated_2048", bumpy_mesh(4, 1))]
    } else {
        found
    }
}

/// Trial moves of sixteen hard bodies per CPU-second, half translations, half rotations.
fn trial_moves(name: &str, shape: &CollisionShape) {
    let Some(start_poses) = read_cluster() else {
        eprintln!(
            "skipped: trial moves, no saved state; PROTOMER_TEST_DATA names the folder with bench/data"
        );
        return;
    };
    let mut chain = Chain::new(shape, start_poses.clone());
    for _repeat in 0..3 {
        chain.counts = Counts::default();
        let (start, mut moves) = (cpu_seconds(), 0);
        while moves < 100_000 {
            chain.poses.clone_from(&start_poses);
            chain.run(STRETCH);
            moves += STRETCH;
        }
        let seconds = cpu_seconds() - start;
        let Counts {
            tried,
            accepted,
            queries,
        } = &chain.counts;
        println!(
            "{name}: {:.0} trial moves per CPU-second; accepted {:.3} of translations, {:.3} of \
             rotations; {:.2} queries per move",
            moves as f64 / seconds,
            accepted[0] as f64 / tried[0] as f64,
            accepted[1] as f64 / tried[1] as f64,
            *queries as f64 / moves as f64,
        );
    }
}

fn contacts(shape: &CollisionShape, count: usize) -> Vec<RelativePose> {
    let mut random = generator(7);
    let contact = |_| {
        let pose = random_pose(&mut random, 30.0);
        brought_to_contact(&pose, |pose| overlaps(shape, shape, pose))
    };
    (0..count).map(contact).collect()
}

/// How much of the true distance the bound reaches.
fn bound_quality(name: &str, shape: &CollisionShape, mesh: &TriangleMesh) {
    if mesh.triangles.len() > 3000 {
        return;
    }
    for gap in [0.1, 1.0, 5.0] {
        let poses = contacts(shape, 4);
        let share = |pose: &RelativePose| {
            let pose = pushed(pose, gap);
            separation_bound(shape, shape, &pose, 10.0).unwrap() / distance(shape, shape, &pose)
        };
        let mean = poses.iter().map(share).sum::<f64>() / poses.len() as f64;
        println!(
            "{name}: gap {gap} Å: the bound is {:.0} % of the distance",
            100.0 * mean
        );
    }
}

/// Microseconds per query of a decision, of a bound, and of two other methods.
fn single_queries(name: &str, shape: &CollisionShape, mesh: &TriangleMesh) {
    let contacts = contacts(shape, 100);
    let (naive, parry) = (NaiveTree::new(mesh), parry_mesh(mesh));
    for gap in [0.1, 1.0, 5.0, -2.0] {
        let poses: Vec<RelativePose> = contacts.iter().map(|pose| pushed(pose, gap)).collect();
        let decision = microseconds(&poses, |pose| overlaps(shape, shape, pose));
        let bound = microseconds(&poses, |pose| {
            separation_bound(shape, shape, pose, CEILING).is_none()
        });
        let naive = microseconds(&poses, |pose| naive.intersects(&naive, pose));
        let parry = microseconds(&poses, |pose| parry_intersects(&parry, &parry, pose));
        println!(
            "{name}: gap {gap} Å: overlaps {decision:.2} µs, separation_bound {bound:.2} µs, \
             naive descent {naive:.2} µs, parry {parry:.2} µs"
        );
    }
}

/// Microseconds of the decision whether surfaces are nearer than the contact gap of 5 Å.
fn nearness(name: &str, shape: &CollisionShape) {
    let contacts = contacts(shape, 100);
    for gap in [0.1, 3.0, 4.9, 5.1, 7.0, 15.0] {
        let poses: Vec<RelativePose> = contacts.iter().map(|pose| pushed(pose, gap)).collect();
        let decision = microseconds(&poses, |pose| comes_within(shape, shape, pose, 5.0));
        println!("{name}: pushed {gap} Å from contact: comes_within {decision:.2} µs");
    }
}

/// The mean time of a query over some poses.
fn microseconds(poses: &[RelativePose], query: impl Fn(&RelativePose) -> bool) -> f64 {
    let seconds = seconds_per_call(|| {
        for pose in poses {
            black_box(query(black_box(pose)));
        }
    });
    1e6 * seconds / poses.len() as f64
}

/// The plain way: two binary trees of boxes descended together, the larger box first, box tests by
/// the separating axes of the faces, separating axes for the triangles.
struct NaiveTree {
    corners: Vec<[Vec3; 3]>,
    nodes: Vec<NaiveNode>,
}

struct NaiveNode {
    centre: Vec3,
    half: Vec3,
    /// Children, or a triangle twice.
    children: [usize; 2],
    is_leaf: bool,
}

impl NaiveTree {
    fn new(mesh: &TriangleMesh) -> Self {
        let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let mut tree = Self {
            corners,
            nodes: Vec::new(),
        };
        tree.build(&mut (0..mesh.triangles.len()).collect::<Vec<_>>());
        tree
    }

    fn build(&mut self, triangles: &mut [usize]) -> usize {
        let points = || triangles.iter().flat_map(|&t| self.corners[t]);
        let low = points().fold(Vec3::repeat(f64::MAX), |low, p| low.inf(&p));
        let high = points().fold(Vec3::repeat(f64::MIN), |high, p| high.sup(&p));
        let is_leaf = triangles.len() == 1;
        let children = if is_leaf {
            [triangles[0]; 2]
        } else {
            let axis = (high - low).imax();
            let height = |t: &usize| self.corners[*t].iter().map(|p| p[axis]).sum::<f64>();
            triangles.sort_by(|a, b| height(a).total_cmp(&height(b)));
            let (left, right) = triangles.split_at_mut(triangles.len() / 2);
            [self.build(left), self.build(right)]
        };
        self.nodes.push(NaiveNode {
            centre: (low + high) * 0.5,
            half: (high - low) * 0.5,
            children,
            is_leaf,
        });
        self.nodes.len() - 1
    }

    fn intersects(&self, other: &NaiveTree, pose: &RelativePose) -> bool {
        let absolute = pose.rotation.abs();
        let mut stack = vec![(self.nodes.len() - 1, other.nodes.len() - 1)];
        while let Some((i, j)) = stack.pop() {
            let (a, b) = (&self.nodes[i], &other.nodes[j]);
            let offset = pose.transform_point(&b.centre) - a.centre;
            let apart = |offset: Vec3, reach: Vec3| (0..3).any(|k| offset[k].abs() > reach[k]);
            if apart(offset, a.half + absolute * b.half)
                || apart(
                    pose.rotation.transpose() * offset,
                    b.half + absolute.transpose() * a.half,
                )
            {
                continue;
            }
            if a.is_leaf && b.is_leaf {
                let moved =
                    other.corners[b.children[0]].map(|corner| pose.transform_point(&corner));
                if !axis_separates(&self.corners[a.children[0]], &moved) {
                    return true;
                }
            } else if b.is_leaf || (!a.is_leaf && a.half.norm_squared() > b.half.norm_squared()) {
                stack.extend(a.children.map(|child| (child, j)));
            } else {
                stack.extend(b.children.map(|child| (i, child)));
            }
        }
        false
    }
}

fn axis_separates(first: &[Vec3; 3], second: &[Vec3; 3]) -> bool {
    let edges = |t: &[Vec3; 3]| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (e, f) = (edges(first), edges(second));
    let separates = |axis: Vec3| {
        let (p, q) = (first.map(|v| v.dot(&axis)), second.map(|v| v.dot(&axis)));
        let low = |x: [f64; 3]| x[0].min(x[1]).min(x[2]);
        let high = |x: [f64; 3]| x[0].max(x[1]).max(x[2]);
        low(p) > high(q) || low(q) > high(p)
    };
    separates(e[0].cross(&e[1]))
        || separates(f[0].cross(&f[1]))
        || e.iter().any(|u| f.iter().any(|v| separates(u.cross(v))))
}

#[derive(Default)]
struct Counts {
    tried: [usize; 2],
    accepted: [usize; 2],
    queries: usize,
}

/// A minimal chain of trial moves of equal hard bodies, with separations carried from trial to
/// trial.
struct Chain<'a> {
    shape: &'a CollisionShape,
    space: Boundary,
    poses: Vec<Pose>,
    carried: Vec<CarriedBound>,
    random: SmallRng,
    counts: Counts,
    /// Pairs the trial may have brought to overlap: what remains of their bounds, the two bodies.
    doubtful: Vec<(f64, usize, usize)>,
    fresh: Vec<(usize, CarriedBound)>,
}

impl<'a> Chain<'a> {
    fn new(shape: &'a CollisionShape, poses: Vec<Pose>) -> Self {
        Self {
            shape,
            space: Boundary::periodic(Vec3::repeat(600.0)).unwrap(),
            carried: vec![CarriedBound::unknown(); poses.len() * poses.len()],
            poses,
            random: generator(3),
            counts: Counts::default(),
            doubtful: Vec::new(),
            fresh: Vec::new(),
        }
    }

    fn run(&mut self, moves: usize) {
        for _ in 0..moves {
            let kind = usize::from(self.random.random_bool(0.5));
            let body = self.random.random_range(0..self.poses.len());
            let trial = self.trial(kind, body);
            self.counts.tried[kind] += 1;
            if self.try_move(body, trial) {
                self.counts.accepted[kind] += 1;
            }
        }
    }

    fn trial(&mut self, kind: usize, body: usize) -> Pose {
        let old = self.poses[body];
        if kind == 0 {
            let length = 0.3 * self.random.random::<f64>().cbrt();
            let step = random_direction(&mut self.random) * length;
            Pose {
                position: old.position + step,
                ..old
            }
        } else {
            let q = random_orientation(&mut self.random);
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            let now = old.wxyz();
            Pose::from_wxyz(
                old.position,
                std::array::from_fn(|i| now[i] + 0.02 * q[i] / norm),
            )
        }
    }

    fn try_move(&mut self, body: usize, trial: Pose) -> bool {
        let old = std::mem::replace(&mut self.poses[body], trial);
        let accepted = self.is_free(body);
        if accepted {
            self.fresh
                .iter()
                .for_each(|&(slot, carried)| self.carried[slot] = carried);
        } else {
            self.poses[body] = old;
        }
        accepted
    }

    /// Whether a body overlaps none of the others; leaves the new bounds in `fresh`.
    fn is_free(&mut self, body: usize) -> bool {
        let n = self.poses.len();
        let radii = [self.shape.bounding_radius_angstrom(); 2];
        self.doubtful.clear();
        self.fresh.clear();
        for other in (0..n).filter(|&other| other != body) {
            let (i, j) = (body.min(other), body.max(other));
            let (first, second) = (&self.poses[i], &self.poses[j]);
            let displacement = self.space.displacement(&first.position, &second.position);
            let remaining =
                self.carried[i * n + j].remaining_angstrom(first, second, &displacement, radii);
            if remaining <= 0.0 {
                self.doubtful.push((remaining, i, j));
            }
        }
        // The pair most likely to overlap first: a rejected move then costs little more than one
        // query.
        self.doubtful
            .sort_unstable_by(|left, right| left.0.total_cmp(&right.0));
        for &(_, i, j) in &self.doubtful {
            let (first, second) = (&self.poses[i], &self.poses[j]);
            let displacement = self.space.displacement(&first.position, &second.position);
            let pose = RelativePose::new(first, second, &displacement);
            self.counts.queries += 1;
            let Some(bound) = separation_bound(self.shape, self.shape, &pose, CEILING) else {
                return false;
            };
            self.fresh.push((
                i * n + j,
                CarriedBound::new(bound, first, second, &displacement),
            ));
        }
        true
    }
}

fn read_off(path: &str) -> Option<TriangleMesh> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut words = text.split_whitespace().skip(1);
    let mut number = || words.next().unwrap().parse::<f64>().unwrap();
    let (vertices, triangles, _) = (number() as usize, number() as usize, number());
    let vertices = (0..vertices)
        .map(|_| Vec3::new(number(), number(), number()))
        .collect();
    let triangles = (0..triangles)
        .map(|_| {
            number();
            [number() as u32, number() as u32, number() as u32]
        })
        .collect();
    Some(TriangleMesh {
        vertices,
        triangles,
    })
}

/// The numbers of the state file in order: box, then position and orientation of each body.
fn read_cluster() -> Option<Vec<Pose>> {
    let text = std::fs::read_to_string(state("cluster16.json")).ok()?;
    let numbers: Vec<f64> = text
        .split(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
        .filter_map(|word| word.parse().ok())
        .collect();
    let poses = numbers[3..].chunks_exact(7);
    Some(
        poses
            .map(|p| Pose::from_wxyz(Vec3::new(p[0], p[1], p[2]), [p[3], p[4], p[5], p[6]]))
            .collect(),
    )
}
