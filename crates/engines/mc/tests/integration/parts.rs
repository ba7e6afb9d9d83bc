//! The closure of a ring of hard bodies with patches: by growing it body by body, and by a ladder of simulations in which the
//! energy of the closing contacts is switched on step by step.

use protomer_kernel::overlap::overlaps;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Rotation, TriangleMesh, Vec3};
use protomer_mc::BodyType;
use protomer_mc::pair::{Charged, PairPotential};
use protomer_mc::parts::{
    Arrangement, BodyEnergies, GrowthSettings, PartKind, PlacedBody, attach, connected_parts,
    free_body,
};
use std::f64::consts::FRAC_PI_2;

pub(super) const LIMIT_ANGSTROM: f64 = 5.0;
const BODIES: usize = 4;

/// A cube of 10 Å with four positive charges near one face and four negative ones near the next.
pub(super) fn patchy(charge: f64) -> BodyType {
    let corner = |bits: usize| {
        Vec3::new(
            bits as f64 % 2.0,
            (bits / 2) as f64 % 2.0,
            (bits / 4) as f64,
        ) * 10.0
    };
    let vertices = (0..8)
        .map(|bits| corner(bits) - Vec3::repeat(5.0))
        .collect();
    let triangles = vec![
        [0, 3, 1],
        [0, 2, 3],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 7, 3],
        [2, 6, 7],
        [1, 3, 7],
        [1, 7, 5],
        [0, 4, 6],
        [0, 6, 2],
    ];
    let mut charges = Vec::new();
    for a in [-3.0, 3.0] {
        for b in [-3.0, 3.0] {
            charges.push((Vec3::new(4.2, a, b), charge));
            charges.push((Vec3::new(a, 4.2, b), -charge));
        }
    }
    BodyType::new(
        "patchy",
        &TriangleMesh {
            vertices,
            triangles,
        },
        &charges,
    )
    .unwrap()
}

/// Cubes whose contacts outside the tree of a part have a part of their energy.
pub(super) struct Cubes {
    pub kind: BodyType,
    pub charged: Charged,
    /// Pairs of bodies that are attached to each other.
    pub tree: Vec<(usize, usize)>,
    /// Part of the energy of all other pairs.
    pub closing: f64,
}

impl Cubes {
    fn relative(a: &Pose, b: &Pose) -> RelativePose {
        RelativePose::new(a, b, &(b.position - a.position))
    }

    fn whole_kt(&self, a: &Pose, b: &Pose) -> f64 {
        self.charged.energy_kt(&Self::relative(a, b))
    }

    fn is_in_tree(&self, i: usize, j: usize) -> bool {
        self.tree.contains(&(i.min(j), i.max(j)))
    }
}

impl BodyEnergies for Cubes {
    fn overlap(&self, _: usize, _: usize, a: &Pose, b: &Pose) -> bool {
        overlaps(&self.kind.shape, &self.kind.shape, &Self::relative(a, b))
    }

    fn energy_kt(&self, i: usize, j: usize, a: &Pose, b: &Pose) -> f64 {
        let share = if self.is_in_tree(i, j) {
            1.0
        } else {
            self.closing
        };
        share * self.whole_kt(a, b)
    }
}

/// Four cubes around an axis, the positive patch of each on the negative one of the next.
pub(super) fn ring(kind: &BodyType) -> Arrangement {
    let corners = [[0.0, 0.0], [10.4, 0.0], [10.4, 10.4], [0.0, 10.4]];
    let body = |number: usize| {
        let [x, y] = corners[number];
        let pose = Pose {
            position: Vec3::new(x, y, 0.0),
            rotation: Rotation::new(Vec3::z() * (FRAC_PI_2 * number as f64)),
        };
        PlacedBody {
            species: 0,
            pose,
            frame: pose,
            square_of_gyration_angstrom2: kind.square_of_gyration_angstrom2(),
        }
    };
    let neighbours: Vec<Vec<usize>> = (0..BODIES)
        .map(|i| vec![(i + 1) % BODIES, (i + 3) % BODIES])
        .collect();
    let energy = |i: usize, j: usize| {
        if neighbours[i].contains(&j) {
            -20.0
        } else {
            0.0
        }
    };
    Arrangement {
        bodies: (0..BODIES).map(body).collect(),
        energies_kt: (0..BODIES)
            .map(|i| (0..BODIES).map(|j| energy(i, j)).collect())
            .collect(),
        neighbours,
    }
}

/// ln q of the ring with its error, grown body by body.
fn grown(arrangement: &Arrangement, parts: &[PartKind], cubes: &Cubes) -> (f64, f64) {
    let settings = GrowthSettings {
        live_states: 100,
        runs: 16,
        ..GrowthSettings::default()
    };
    let mut samples = free_body(arrangement.bodies[parts[0].bodies[0]].pose, &settings);
    for (number, part) in (0..).zip(parts).skip(1) {
        samples = attach(
            arrangement,
            (number, part),
            &samples,
            cubes,
            &settings,
            &|| true,
        )
        .unwrap()
        .unwrap();
    }
    (
        samples.attached().ln_partition,
        samples.attached().ln_partition_error,
    )
}

/// A simulation of the four bodies near their places, with a part of the closing energy.
struct Window {
    poses: Vec<Pose>,
    closing: f64,
}

/// Bodies that each body is attached to, as numbers of bodies.
struct Tree<'a> {
    arrangement: &'a Arrangement,
    parents: Vec<(usize, usize)>,
}

impl Tree<'_> {
    /// Whether all bodies are within the limit of the body that they are attached to.
    fn holds(&self, poses: &[Pose]) -> bool {
        self.parents.iter().all(|(child, parent)| {
            let bodies = &self.arrangement.bodies;
            let native = bodies[*child].pose.then(&bodies[*parent].pose.inverse());
            let relative = poses[*child].then(&poses[*parent].inverse());
            let angle = (relative.rotation * native.rotation.inverse()).angle();
            let square = (relative.position - native.position).norm_squared()
                + 4.0 / 3.0 * (1.0 - angle.cos()) * bodies[*child].square_of_gyration_angstrom2;
            square < LIMIT_ANGSTROM.powi(2)
        })
    }
}

impl Window {
    /// Energies inside and outside the tree, kT; `None` at overlap.
    fn energies_kt(cubes: &Cubes, poses: &[Pose]) -> Option<(f64, f64)> {
        let (mut inside_kt, mut closing_kt) = (0.0, 0.0);
        for j in 0..BODIES {
            for i in 0..j {
                if cubes.overlap(i, j, &poses[i], &poses[j]) {
                    return None;
                }
                match cubes.is_in_tree(i, j) {
                    true => inside_kt += cubes.whole_kt(&poses[i], &poses[j]),
                    false => closing_kt += cubes.whole_kt(&poses[i], &poses[j]),
                }
            }
        }
        Some((inside_kt, closing_kt))
    }

    /// A trial move of each body; returns the closing energy afterwards, kT.
    fn sweep(&mut self, cubes: &Cubes, tree: &Tree, rng: &mut CounterRng) -> f64 {
        let mut present = Self::energies_kt(cubes, &self.poses).unwrap();
        for _ in 0..BODIES {
            let body = rng.index(BODIES);
            // Steps of several sizes, as the ring is tight and the chain wide.
            let size = 0.1_f64.powf(rng.uniform());
            let shift = rng.vector_in_ball(2.0 * size);
            let turn = rng.vector_in_ball(0.4 * size);
            let threshold = rng.uniform();
            let mut moved = self.poses.clone();
            moved[body].position += shift;
            moved[body].rotation = Rotation::new(turn) * moved[body].rotation;
            if !tree.holds(&moved) {
                continue;
            }
            let Some(next) = Self::energies_kt(cubes, &moved) else {
                continue;
            };
            let change_kt = next.0 - present.0 + self.closing * (next.1 - present.1);
            if threshold < (-change_kt).exp() {
                self.poses = moved;
                present = next;
            }
        }
        present.1
    }
}

/// ln of the ratio of two integrals whose energies differ by a part of the closing energy, by Bennett's acceptance ratio.
fn bennett(lower_kt: &[f64], upper_kt: &[f64], part: f64) -> f64 {
    let fermi = |x: f64| 1.0 / (1.0 + x.exp());
    let (mut low, mut high) = (-200.0, 200.0);
    for _ in 0..200 {
        let ln_ratio = 0.5 * (low + high);
        // Both windows have as many samples; the sums are equal at the ratio.
        let forward: f64 = lower_kt.iter().map(|kt| fermi(part * kt + ln_ratio)).sum();
        let backward: f64 = upper_kt.iter().map(|kt| fermi(-part * kt - ln_ratio)).sum();
        match forward > backward {
            true => low = ln_ratio,
            false => high = ln_ratio,
        }
    }
    0.5 * (low + high)
}

/// ln q of the ring less that of the ring without closing energies, by windows that exchange their states.
fn staged(arrangement: &Arrangement, parts: &[PartKind], cubes: &Cubes, sweeps: u64) -> (f64, f64) {
    const WINDOWS: usize = 20;
    let whole = parts.last().unwrap();
    let parents =
        (1..BODIES).map(|place| (whole.bodies[place], whole.bodies[whole.attached_to[place]]));
    let tree = Tree {
        arrangement,
        parents: parents.collect(),
    };
    let window = |number: usize| Window {
        poses: arrangement.bodies.iter().map(|body| body.pose).collect(),
        closing: number as f64 / (WINDOWS - 1) as f64,
    };
    let mut windows: Vec<Window> = (0..WINDOWS).map(window).collect();
    const BLOCKS: u64 = 8;
    let mut energies_kt = vec![vec![Vec::new(); WINDOWS]; BLOCKS as usize];
    let mut last_kt = [0.0; WINDOWS];
    for sweep in 0..sweeps {
        for (number, window) in windows.iter_mut().enumerate() {
            let mut rng = CounterRng::new(7, number as u32, sweep);
            last_kt[number] = window.sweep(cubes, &tree, &mut rng);
        }
        let mut rng = CounterRng::new(7, WINDOWS as u32, sweep);
        // Neighbouring windows exchange their states, even and odd pairs in turn.
        for number in ((sweep % 2) as usize..WINDOWS - 1).step_by(2) {
            let part = windows[number + 1].closing - windows[number].closing;
            let change_kt = part * (last_kt[number] - last_kt[number + 1]);
            if rng.uniform() < (-change_kt).exp() {
                let (left, right) = windows.split_at_mut(number + 1);
                std::mem::swap(&mut left[number].poses, &mut right[0].poses);
                last_kt.swap(number, number + 1);
            }
        }
        // The first fifth lets the closed ring open.
        if sweep >= sweeps / 5 {
            let block = (sweep - sweeps / 5) * BLOCKS / (sweeps - sweeps / 5);
            for (number, kt) in last_kt.iter().enumerate() {
                energies_kt[block as usize][number].push(*kt);
            }
        }
    }
    let of_block = |block: &Vec<Vec<f64>>| -> f64 {
        let pairs = block.windows(2);
        pairs
            .map(|pair| bennett(&pair[0], &pair[1], 1.0 / (WINDOWS - 1) as f64))
            .sum()
    };
    let values: Vec<f64> = energies_kt.iter().map(of_block).collect();
    let mean = values.iter().sum::<f64>() / BLOCKS as f64;
    let variance = values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / (BLOCKS - 1) as f64;
    (mean, (variance / BLOCKS as f64).sqrt())
}

#[test]
#[ignore = "takes three minutes of processor time"]
fn a_ring_of_patchy_cubes_closes_as_a_ladder_of_simulations_finds() {
    let kind = patchy(1.4);
    let arrangement = ring(&kind);
    let found = connected_parts(&arrangement, 10).unwrap();
    let whole = found.parts.last().unwrap();
    let tree = (1..BODIES)
        .map(|place| (whole.bodies[place], whole.bodies[whole.attached_to[place]]))
        .map(|(child, parent)| (child.min(parent), child.max(parent)))
        .collect();
    let yukawa = Yukawa::new(7.15, 1.0 / 4.3, f64::INFINITY).unwrap();
    let mut cubes = Cubes {
        charged: Charged::new(yukawa, &kind.charges, &kind.charges).unwrap(),
        kind,
        tree,
        closing: 1.0,
    };
    // Parts of a chain that ends in the ring: single, pair, three, ring.
    let (closed, closed_error) = grown(&arrangement, &found.parts, &cubes);
    cubes.closing = 0.0;
    let (open, open_error) = grown(&arrangement, &found.parts, &cubes);
    let (by_ladder, ladder_error) = staged(&arrangement, &found.parts, &cubes, 8_000);
    let by_growth = closed - open;
    let error = (closed_error.powi(2) + open_error.powi(2) + ladder_error.powi(2)).sqrt();
    println!(
        "growth {by_growth:.2} ± {:.2}, ladder {by_ladder:.2} ± {ladder_error:.2}",
        closed_error.hypot(open_error)
    );
    assert!(error < 0.4, "{closed_error} {open_error} {ladder_error}");
    assert!(
        (by_growth - by_ladder).abs() < 3.0 * error,
        "{by_growth} {by_ladder} {error}"
    );
}
