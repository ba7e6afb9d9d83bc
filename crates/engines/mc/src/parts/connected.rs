//! The different connected parts of an assembly.
//!
//! Two parts are one if a rotation with a shift maps one onto the other: a ring of six bodies has one part of each
//! size. A part of n + 1 bodies is one of n with another body that touches it, so all parts are found size by size.
//! Where an assembly has more parts of a size than allowed, those of the lowest energies are kept: the others are
//! rarer by their Boltzmann factors.

use super::Arrangement;
use std::collections::HashSet;

/// A part of an assembly, one for all that motions map onto it.
#[derive(Debug, Clone, PartialEq)]
pub struct PartKind {
    /// Bodies, in the order in which they are attached.
    pub bodies: Vec<usize>,
    /// Number of the body in `bodies` that each body is attached to; that of the first means nothing.
    pub attached_to: Vec<usize>,
    /// Index of the part without the last body; `None` for a single body.
    pub grown_from: Option<usize>,
    /// Motions that map the part onto itself, the identity among them.
    pub symmetry_number: usize,
    /// Energy at the poses of the assembly, kT.
    pub energy_kt: f64,
}

/// The different connected parts of an assembly.
#[derive(Debug, Clone, PartialEq)]
pub struct ConnectedParts {
    /// Parts, by size; the last is the whole assembly.
    pub parts: Vec<PartKind>,
    /// Number of parts of each size that were left out, from one body on.
    pub omitted: Vec<usize>,
}

/// Positions of bodies that a motion maps onto each other are nearer than this, Å.
const SAME_ANGSTROM: f64 = 3.0;
/// Energies of parts that can be one differ by less than this share, or by less than one kT.
const SAME_ENERGY: f64 = 0.2;

/// The different connected parts of an assembly, at most a number of each size; `None` if the assembly itself is
/// not connected.
///
/// ```
/// use protomer_kernel::{Pose, Rotation, Vec3};
/// use protomer_mc::parts::{Arrangement, PlacedBody, connected_parts};
/// // Four bodies around an axis: a single body, a pair, three, and the ring.
/// let body = |number: f64| {
///     let turn = Rotation::new(Vec3::z() * (std::f64::consts::FRAC_PI_2 * number));
///     let pose = Pose { position: turn * Vec3::new(20.0, 0.0, 0.0), rotation: turn };
///     PlacedBody { species: 0, pose, frame: pose, square_of_gyration_angstrom2: 100.0 }
/// };
/// let neighbours: Vec<Vec<usize>> = (0..4).map(|i| vec![(i + 1) % 4, (i + 3) % 4]).collect();
/// let energy = |i: usize, j: usize| if neighbours[i].contains(&j) { -10.0 } else { 0.0 };
/// let ring = Arrangement {
///     bodies: [0.0, 1.0, 2.0, 3.0].map(body).to_vec(),
///     energies_kt: (0..4).map(|i| (0..4).map(|j| energy(i, j)).collect()).collect(),
///     neighbours,
/// };
/// let found = connected_parts(&ring, 100).unwrap();
/// let symmetries: Vec<usize> = found.parts.iter().map(|part| part.symmetry_number).collect();
/// assert_eq!(symmetries, [1, 1, 1, 4]);
/// ```
pub fn connected_parts(arrangement: &Arrangement, most_of_a_size: usize) -> Option<ConnectedParts> {
    let bodies = arrangement.bodies.len();
    let mut found = ConnectedParts {
        parts: Vec::new(),
        omitted: Vec::new(),
    };
    let mut of_size = single_bodies(arrangement);
    for size in 1..=bodies {
        of_size.sort_by(|a, b| a.energy_kt.total_cmp(&b.energy_kt));
        // Single bodies are the source of all others: never left out.
        let kept = match size {
            1 => of_size.len(),
            _ => of_size.len().min(most_of_a_size.max(1)),
        };
        found.omitted.push(of_size.len() - kept);
        of_size.truncate(kept);
        let first = found.parts.len();
        found.parts.append(&mut of_size);
        if size < bodies {
            of_size = grown(arrangement, &found.parts, first);
        }
    }
    let is_whole = |part: &PartKind| part.bodies.len() == bodies;
    found.parts.last().is_some_and(is_whole).then_some(found)
}

/// A body of each species.
fn single_bodies(arrangement: &Arrangement) -> Vec<PartKind> {
    let mut singles = Vec::new();
    for species in 0..arrangement.species() {
        let first = arrangement
            .bodies
            .iter()
            .position(|body| body.species == species);
        singles.extend(first.map(|body| PartKind {
            bodies: vec![body],
            attached_to: vec![0],
            grown_from: None,
            symmetry_number: 1,
            energy_kt: 0.0,
        }));
    }
    singles
}

/// The different parts with one body more than those from `first` on.
fn grown(arrangement: &Arrangement, parts: &[PartKind], first: usize) -> Vec<PartKind> {
    let mut grown: Vec<PartKind> = Vec::new();
    let mut tried: HashSet<Vec<usize>> = HashSet::new();
    // Parts of low energy first: whatever can grow from them does.
    for (number, part) in parts.iter().enumerate().skip(first) {
        let touching = part
            .bodies
            .iter()
            .flat_map(|body| &arrangement.neighbours[*body]);
        let mut attachable: Vec<usize> = touching
            .copied()
            .filter(|body| !part.bodies.contains(body))
            .collect();
        attachable.sort_unstable();
        attachable.dedup();
        for body in attachable {
            let mut sorted = part.bodies.clone();
            sorted.push(body);
            sorted.sort_unstable();
            if !tried.insert(sorted) {
                continue;
            }
            let candidate = with_body(arrangement, part, number, body);
            if !grown
                .iter()
                .any(|other| is_same(arrangement, other, &candidate))
            {
                grown.push(candidate);
            }
        }
    }
    grown
}

/// A part with another body, attached to the neighbour that binds it best.
fn with_body(arrangement: &Arrangement, part: &PartKind, number: usize, body: usize) -> PartKind {
    let energies_kt = &arrangement.energies_kt[body];
    let neighbours = &arrangement.neighbours[body];
    let binding = |place: &usize| energies_kt[part.bodies[*place]];
    let attached_to = (0..part.bodies.len())
        .filter(|place| neighbours.contains(&part.bodies[*place]))
        .min_by(|a, b| binding(a).total_cmp(&binding(b)))
        .unwrap_or(0);
    let mut grown = PartKind {
        grown_from: Some(number),
        ..part.clone()
    };
    grown.bodies.push(body);
    grown.attached_to.push(attached_to);
    grown.energy_kt = arrangement.energy_kt(&grown.bodies);
    grown.symmetry_number = arrangement
        .motions(&grown.bodies, &grown.bodies, SAME_ANGSTROM)
        .max(1);
    grown
}

/// Whether a motion maps one part onto the other.
fn is_same(arrangement: &Arrangement, a: &PartKind, b: &PartKind) -> bool {
    let allowed_kt = (SAME_ENERGY * a.energy_kt.abs()).max(1.0);
    // Cheap tests first: most parts differ in them.
    (a.energy_kt - b.energy_kt).abs() <= allowed_kt
        && arrangement.composition(&a.bodies) == arrangement.composition(&b.bodies)
        && arrangement.motions(&a.bodies, &b.bodies, SAME_ANGSTROM) > 0
}
