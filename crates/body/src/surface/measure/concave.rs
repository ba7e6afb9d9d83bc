//! The concave patch at a vertex: the part of the probe's sphere within the cone of its three
//! atoms.
//!
//! A probe nearer to the plane of its atoms than its radius may reach through and meet other
//! probes. Its patch is then the unit sphere less half-spaces: the three planes of the cone, and
//! for each probe u within 2 p the half-space of points nearer to u. The layer is that part of the
//! ball: ⅓ (p³ Ω + Σ h A) with A the area of the plane face half-way to each probe, h = |u - v| /
//! 2.

use crate::surface::arrangement::circle::{
    Cap, CircleArc, CircleFrame, Exposure, counter_clockwise_angle, exposed_arcs,
};
use crate::surface::arrangement::{Arrangement, CellList, hashed_fraction, spherical};
use protomer_kernel::Vec3;
use std::f64::consts::{PI, TAU};

/// Shifts of the cutting planes, in probe radii, tried in turn: probes on one circle all cut
/// through its cusps, a coincidence that shifts of this size resolve.
const SHIFTS: [f64; 6] = [1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5];
/// How much larger than the whole cone a cut patch may seem.
const SOLID_ANGLE_TOLERANCE: f64 = 1e-6;
/// Points of the sphere where the closed form fails.
const SAMPLES: u32 = 100_000;
/// The planes of the cone bear the numbers 0 to 2, cutting probes the following.
const CONE_PLANES: usize = 3;

/// All vertices of an arrangement with a cell list over them.
pub(super) struct Probes<'a> {
    accessible: &'a Arrangement,
    positions: Vec<Vec3>,
    cells: CellList,
}

/// Area and layer of a concave patch and the vertices whose probes cut it.
pub(super) struct Patch {
    pub(super) area: f64,
    pub(super) layer_volume: f64,
    pub(super) cut_by: Vec<u32>,
    pub(super) area_error: f64,
    /// Whether the area had to be sampled.
    pub(super) is_sampled: bool,
}

impl<'a> Probes<'a> {
    pub(super) fn new(accessible: &'a Arrangement) -> Self {
        let positions: Vec<Vec3> = accessible
            .vertices()
            .iter()
            .map(|vertex| vertex.position)
            .collect();
        let reach = 2.0 * accessible.probe_radius_angstrom();
        let cells = CellList::new(&positions, 0..positions.len() as u32, reach);
        Self {
            accessible,
            positions,
            cells,
        }
    }

    /// The patch at vertex `number`.
    pub(super) fn patch(&self, number: u32) -> Patch {
        let probe = self.accessible.probe_radius_angstrom();
        let place = self.positions[number as usize];
        let atoms = self.accessible.vertices()[number as usize].atoms;
        let legs = atoms.map(|atom| self.accessible.centres()[atom as usize] - place);
        let directions = legs.map(|leg| leg.normalize());
        let whole = cone_solid_angle(&directions);
        let uncut = |solid_angle: f64| Patch {
            area: probe.powi(2) * solid_angle,
            layer_volume: probe.powi(3) * solid_angle / 3.0,
            cut_by: Vec::new(),
            area_error: 0.0,
            is_sampled: false,
        };
        let [a, b, c] = legs;
        let volume = a.dot(&b.cross(&c)).abs();
        if volume >= probe * (b - a).cross(&(c - a)).norm() {
            return uncut(whole);
        }
        let cutters = self.cutters(number);
        if cutters.is_empty() {
            return uncut(whole);
        }
        for shift in SHIFTS {
            let caps = self.caps(&directions, &place, &cutters, shift);
            let Some((solid_angle, cuts)) = cut_solid_angle(&caps) else {
                continue;
            };
            if !(-SOLID_ANGLE_TOLERANCE..=whole + SOLID_ANGLE_TOLERANCE).contains(&solid_angle) {
                continue;
            }
            if cuts.is_empty() && solid_angle > 0.0 {
                return uncut(whole);
            }
            return Self::cut(
                probe,
                solid_angle.max(0.0),
                &caps,
                &cutters,
                TAU * probe * probe * shift,
            );
        }
        let caps = self.caps(&directions, &place, &cutters, 0.0);
        let (solid_angle, error) = sampled_solid_angle(&caps);
        Patch {
            is_sampled: true,
            ..Self::cut(probe, solid_angle, &caps, &cutters, probe * probe * error)
        }
    }

    fn cut(probe: f64, solid_angle: f64, caps: &[Cap], cutters: &[u32], area_error: f64) -> Patch {
        let mut moment = solid_angle;
        let mut cut_by = Vec::new();
        for (index, cap) in caps
            .iter()
            .enumerate()
            .filter(|(_, cap)| cap.owner as usize >= CONE_PLANES)
        {
            let area = plane_face_area(caps, index);
            moment += cap.height * area;
            if area > 1e-12 {
                cut_by.push(cutters[cap.owner as usize - CONE_PLANES]);
            }
        }
        Patch {
            area: probe.powi(2) * solid_angle,
            layer_volume: probe.powi(3) * moment / 3.0,
            cut_by,
            area_error,
            is_sampled: false,
        }
    }

    /// Other vertices whose probes overlap the probe of this one.
    fn cutters(&self, number: u32) -> Vec<u32> {
        let place = self.positions[number as usize];
        let reach = 2.0 * self.accessible.probe_radius_angstrom();
        let mut cutters = Vec::new();
        self.cells.for_each_near(&place, |other| {
            if other != number && (self.positions[other as usize] - place).norm() < reach {
                cutters.push(other);
            }
        });
        cutters
    }

    /// The half-spaces that bound the patch on the unit sphere, largest cap first.
    fn caps(&self, directions: &[Vec3; 3], place: &Vec3, cutters: &[u32], shift: f64) -> Vec<Cap> {
        let reach = 2.0 * self.accessible.probe_radius_angstrom();
        let [a, b, c] = directions;
        let side = a.dot(&b.cross(c)).signum();
        let planes =
            [(a, b), (b, c), (c, a)].map(|(first, second)| second.cross(first).normalize() * side);
        let mut caps: Vec<Cap> = (0..)
            .zip(planes)
            .map(|(owner, axis)| Cap {
                axis,
                height: 0.0,
                owner,
            })
            .collect();
        for (owner, &cutter) in (CONE_PLANES as u32..).zip(cutters) {
            let offset = self.positions[cutter as usize] - place;
            let distance = offset.norm();
            let height = distance / reach + shift * hashed_fraction(u64::from(cutter));
            if distance > 0.0 && height < 1.0 {
                caps.push(Cap {
                    axis: offset / distance,
                    height,
                    owner,
                });
            }
        }
        caps.sort_by(|a, b| a.height.total_cmp(&b.height));
        caps
    }
}

/// Solid angle of the cone of three unit vectors: tan(Ω/2) = |a·(b×c)| / (1 + a·b + b·c + c·a)
/// (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 125 (1983)).
fn cone_solid_angle([a, b, c]: &[Vec3; 3]) -> f64 {
    2.0 * a
        .dot(&b.cross(c))
        .abs()
        .atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Solid angle of the unit sphere less caps, and the owners of cutting caps on its boundary; `None`
/// if the boundary does not close.
fn cut_solid_angle(caps: &[Cap]) -> Option<(f64, Vec<u32>)> {
    let loops = spherical::boundary_loops(caps)?;
    let numbers = spherical::regions(&loops.edges);
    let parts = numbers.iter().max().map_or(0, |last| last + 1);
    let mut total = 0.0;
    for part in 0..parts {
        let boundary: Vec<_> = loops
            .edges
            .iter()
            .zip(&numbers)
            .filter(|(_, number)| **number == part)
            .map(|(edges, _)| edges)
            .collect();
        let solid_angle = spherical::solid_angle(&boundary);
        if !(-SOLID_ANGLE_TOLERANCE..=4.0 * PI).contains(&solid_angle) {
            return None;
        }
        total += solid_angle;
    }
    let cuts = loops
        .owners
        .into_iter()
        .filter(|owner| *owner as usize >= CONE_PLANES)
        .collect();
    Some((total, cuts))
}

/// Area of the part of the plane of a cap that lies in the unit ball and outside all other caps.
///
/// It is convex, bounded by arcs of the cap's rim and by chords: ½ Σ s² φ + ½ Σ (distance of the
/// chord) (its length).
fn plane_face_area(caps: &[Cap], index: usize) -> f64 {
    let frame = CircleFrame::new(&caps[index]);
    let mut arcs: Vec<CircleArc> = Vec::new();
    let turned = match exposed_arcs(caps, index, &frame, &mut arcs) {
        Exposure::Whole => TAU,
        Exposure::Arcs => arcs
            .iter()
            .map(|arc| counter_clockwise_angle(&arc.ends[0], &arc.ends[1]))
            .sum(),
    };
    // Half-planes n·x <= d in the plane of the face, about the centre of the disc.
    let others = caps.iter().enumerate().filter(|(other, _)| *other != index);
    let half_planes: Vec<([f64; 2], f64)> = others
        .filter_map(|(_, cap)| {
            let (x, y) = (cap.axis.dot(&frame.e1), cap.axis.dot(&frame.e2));
            let (length, distance) = (
                x.hypot(y),
                cap.height - frame.height * cap.axis.dot(&frame.axis),
            );
            (length > 1e-14).then(|| ([x / length, y / length], distance / length))
        })
        .collect();
    let chords: f64 = (0..half_planes.len())
        .map(|chord| half_planes[chord].1 * chord_length(&half_planes, chord, frame.radius))
        .sum();
    0.5 * (frame.radius * frame.radius * turned + chords)
}

/// Length of the part of a half-plane's edge within the disc and all other half-planes.
fn chord_length(half_planes: &[([f64; 2], f64)], chord: usize, radius: f64) -> f64 {
    let ([x, y], distance) = half_planes[chord];
    let square = radius * radius - distance * distance;
    if square <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (-square.sqrt(), square.sqrt());
    for (other, &([nx, ny], limit)) in half_planes.iter().enumerate() {
        if other == chord {
            continue;
        }
        // The edge's points are d (x, y) + t (-y, x).
        let slope = ny * x - nx * y;
        let room = limit - distance * (nx * x + ny * y);
        if slope.abs() < 1e-14 {
            if room < 0.0 {
                return 0.0;
            }
        } else if slope > 0.0 {
            high = high.min(room / slope);
        } else {
            low = low.max(room / slope);
        }
    }
    (high - low).max(0.0)
}

/// Solid angle by counting points spread evenly over the sphere, and its statistical error.
fn sampled_solid_angle(caps: &[Cap]) -> (f64, f64) {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let inside = (0..SAMPLES)
        .filter(|&n| {
            let z = 1.0 - (2.0 * f64::from(n) + 1.0) / f64::from(SAMPLES);
            let (sine, cosine) = (golden * f64::from(n)).sin_cos();
            let out = (1.0 - z * z).sqrt();
            let u = Vec3::new(out * cosine, out * sine, z);
            caps.iter().all(|cap| cap.axis.dot(&u) <= cap.height)
        })
        .count();
    let step = 4.0 * PI / f64::from(SAMPLES);
    (step * inside as f64, step * (inside as f64).sqrt().max(1.0))
}
