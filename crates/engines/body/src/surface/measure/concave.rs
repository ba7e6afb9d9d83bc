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
use crate::surface::arrangement::spherical::{self, Loop};
use crate::surface::arrangement::{Arrangement, CellList, hashed_fraction};
use protomer_kernel::Vec3;
use protomer_kernel::quadrature::points_on_sphere;
use std::f64::consts::{PI, TAU};

/// Shifts of the cutting planes, in probe radii, tried in turn: probes on one circle all cut
/// through its cusps, a coincidence that shifts of this size resolve.
const SHIFTS: [f64; 6] = [1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5];
/// Tolerance of the solid angle of a cut patch, which may seem larger than the whole cone.
const SOLID_ANGLE_TOLERANCE: f64 = 1e-6;
/// Number of sample points on the sphere where the closed form fails.
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
        let mut positions = Vec::with_capacity(accessible.vertices().len());
        for vertex in accessible.vertices() {
            positions.push(vertex.position);
        }
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
        let [a, b, c] = legs;
        let volume = a.dot(&b.cross(&c)).abs();
        // Volume of the parallelepiped over its base area: the probe's height above the plane.
        let reaches_through = volume < probe * (b - a).cross(&(c - a)).norm();
        if !reaches_through {
            return Patch::uncut(probe, whole);
        }
        let cutters = self.cutters(number);
        if cutters.is_empty() {
            return Patch::uncut(probe, whole);
        }
        let possible = -SOLID_ANGLE_TOLERANCE..=whole + SOLID_ANGLE_TOLERANCE;
        for shift in SHIFTS {
            let caps = self.caps(&directions, &place, &cutters, shift);
            let Some((solid_angle, is_cut)) = cut_solid_angle(&caps) else {
                continue;
            };
            // More than the whole cone: the loops were put together wrongly, try another shift.
            if !possible.contains(&solid_angle) {
                continue;
            }
            if !is_cut && solid_angle > 0.0 {
                return Patch::uncut(probe, whole);
            }
            // A plane shifted by s moves its circle, at most 2π p long, by p s.
            let error = TAU * probe * probe * shift;
            return Patch::cut(probe, solid_angle.max(0.0), &caps, &cutters, error);
        }
        let caps = self.caps(&directions, &place, &cutters, 0.0);
        let (solid_angle, error) = sampled_solid_angle(&caps);
        Patch {
            is_sampled: true,
            ..Patch::cut(probe, solid_angle, &caps, &cutters, probe * probe * error)
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
        // The cone's planes face outwards whichever way the three atoms run.
        let side = a.dot(&b.cross(c)).signum();
        let mut caps = Vec::with_capacity(CONE_PLANES + cutters.len());
        for (owner, (first, second)) in (0..).zip([(a, b), (b, c), (c, a)]) {
            caps.push(Cap {
                axis: second.cross(first).normalize() * side,
                height: 0.0,
                owner,
            });
        }
        for (owner, &cutter) in (CONE_PLANES as u32..).zip(cutters) {
            let offset = self.positions[cutter as usize] - place;
            // Half-way to the other probe, in probe radii: |u - v| / (2 p).
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

impl Patch {
    /// A patch that no other probe cuts.
    fn uncut(probe: f64, solid_angle: f64) -> Self {
        Self {
            area: probe.powi(2) * solid_angle,
            layer_volume: probe.powi(3) * solid_angle / 3.0,
            cut_by: Vec::new(),
            area_error: 0.0,
            is_sampled: false,
        }
    }

    fn cut(probe: f64, solid_angle: f64, caps: &[Cap], cutters: &[u32], area_error: f64) -> Self {
        let mut moment = solid_angle;
        let mut cut_by = Vec::new();
        for (index, cap) in caps.iter().enumerate() {
            let Some(cutter) = (cap.owner as usize).checked_sub(CONE_PLANES) else {
                continue;
            };
            let area = plane_face_area(caps, index);
            moment += cap.height * area;
            // Rounding may leave a plane that only touches; it cuts nothing.
            if area > 1e-12 {
                cut_by.push(cutters[cutter]);
            }
        }
        Self {
            area: probe.powi(2) * solid_angle,
            layer_volume: probe.powi(3) * moment / 3.0,
            cut_by,
            area_error,
            is_sampled: false,
        }
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

/// Solid angle of the unit sphere less caps, and whether a cutting cap is on its boundary; `None`
/// if the boundary does not close.
fn cut_solid_angle(caps: &[Cap]) -> Option<(f64, bool)> {
    let boundary = spherical::boundary_loops(caps)?;
    let mut total = 0.0;
    for region in spherical::regions(&boundary.edges) {
        let loops: Vec<&Loop> = region
            .iter()
            .map(|&number| &boundary.edges[number])
            .collect();
        let solid_angle = spherical::solid_angle(&loops);
        if !(-SOLID_ANGLE_TOLERANCE..=4.0 * PI).contains(&solid_angle) {
            return None;
        }
        total += solid_angle;
    }
    let is_cut = boundary
        .owners
        .iter()
        .any(|owner| *owner as usize >= CONE_PLANES);
    Some((total, is_cut))
}

/// Area of the part of the plane of a cap that lies in the unit ball and outside all other caps.
///
/// It is convex, bounded by arcs of the cap's rim and by chords: ½ Σ s² φ + ½ Σ (distance of the
/// chord) (its length).
fn plane_face_area(caps: &[Cap], index: usize) -> f64 {
    let frame = CircleFrame::new(&caps[index]);
    let mut arcs: Vec<CircleArc> = Vec::new();
    let mut angle = 0.0;
    match exposed_arcs(caps, index, &frame, &mut arcs) {
        Exposure::Whole => angle = TAU,
        Exposure::Arcs => {
            for arc in &arcs {
                angle += counter_clockwise_angle(&arc.ends[0], &arc.ends[1]);
            }
        }
    }
    let half_planes = half_planes(caps, index, &frame);
    let mut chords = 0.0;
    for (chord, half_plane) in half_planes.iter().enumerate() {
        // Green's theorem: a straight edge at distance d adds d · length / 2, an arc s² angle / 2.
        chords += half_plane.distance * chord_length(&half_planes, chord, frame.radius);
    }
    0.5 * (frame.radius * frame.radius * angle + chords)
}

/// The points n·x <= d of a plane.
struct HalfPlane {
    normal: [f64; 2],
    distance: f64,
}

/// The half-planes that the other caps leave of the plane of a cap, about the centre of its disc.
fn half_planes(caps: &[Cap], index: usize, frame: &CircleFrame) -> Vec<HalfPlane> {
    // Below this the plane is parallel and has no line in this one.
    const PARALLEL: f64 = 1e-14;
    let mut half_planes = Vec::with_capacity(caps.len());
    for (other, cap) in caps.iter().enumerate() {
        let (x, y) = (cap.axis.dot(&frame.e1), cap.axis.dot(&frame.e2));
        let length = (x * x + y * y).sqrt();
        if other != index && length > PARALLEL {
            // A line of the plane of the cap: points at h n
            // + s with s·axis <= cap.height - h (n·axis).
            let distance = cap.height - frame.height * cap.axis.dot(&frame.axis);
            half_planes.push(HalfPlane {
                normal: [x / length, y / length],
                distance: distance / length,
            });
        }
    }
    half_planes
}

/// Length of the part of a half-plane's edge within the disc and all other half-planes.
fn chord_length(half_planes: &[HalfPlane], chord: usize, radius: f64) -> f64 {
    let HalfPlane {
        normal: [x, y],
        distance,
    } = half_planes[chord];
    // The line misses the disc.
    let square = radius * radius - distance * distance;
    if square <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (-square.sqrt(), square.sqrt());
    for (other, half_plane) in half_planes.iter().enumerate() {
        if other == chord {
            continue;
        }
        let [nx, ny] = half_plane.normal;
        let limit = half_plane.distance;
        // The edge's points are d (x, y) + t (-y, x).
        let slope = ny * x - nx * y;
        let room = limit - distance * (nx * x + ny * y);
        // Parallel lines: either all of this one is kept, or nothing.
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
    let mut inside = 0_u32;
    for u in points_on_sphere(SAMPLES as usize) {
        let is_inside = caps.iter().all(|cap| cap.axis.dot(&u) <= cap.height);
        inside += u32::from(is_inside);
    }
    let step = 4.0 * PI / f64::from(SAMPLES);
    let inside = f64::from(inside);
    // Counting: about √n of n points.
    (step * inside, step * inside.sqrt().max(1.0))
}
