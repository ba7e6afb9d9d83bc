//! A body swept by a ball as the union of simple convex pieces, and where a line meets it.
//!
//! All places at most r from a polytope are its inside, plates of thickness r on its faces, cylinders of
//! radius r about its edges, and balls about its corners. A line meets their union, which is convex,
//! from the first place at which it is in a piece to the last. In a plane, the cylinders and balls are
//! strips and disks.

use super::super::Shape;
use super::super::hull::Hull;
use super::super::polytope::Polytope;
use crate::{Pose, Vec3};

/// Part of the size below which a line is parallel to a plane or to an axis.
const PARALLEL: f64 = 1e-14;

/// The pieces of a swept body.
#[derive(Debug, Clone)]
pub(super) struct Pieces {
    radius: f64,
    /// The body, and the plates on its faces.
    solids: Vec<Vec<HalfSpace>>,
    rods: Vec<Rod>,
    balls: Vec<Vec3>,
}

/// An edge, to be swept.
#[derive(Debug, Clone, Copy)]
struct Rod {
    from: Vec3,
    /// Direction of the rod, of length one.
    axis: Vec3,
    length: f64,
}

/// All points whose height along a normal is at most a given height.
#[derive(Debug, Clone, Copy)]
struct HalfSpace {
    normal: Vec3,
    height: f64,
}

impl HalfSpace {
    fn below(normal: Vec3, point: &Vec3) -> Self {
        Self {
            normal,
            height: normal.dot(point),
        }
    }
}

impl Pieces {
    /// The corners of a shape about its centroid in a pose, and the pieces.
    pub(super) fn from_shape(shape: &Shape, radius: f64, pose: &Pose) -> (Vec<Vec3>, Self) {
        match Polytope::from_shape(shape) {
            Ok(body) => Self::of_polytope(&body, radius, pose),
            Err(_) => Self::of_thin(shape, radius, pose),
        }
    }

    fn of_polytope(body: &Polytope, radius: f64, pose: &Pose) -> (Vec<Vec3>, Self) {
        let corners = body.corners_at(pose);
        let (mut inside, mut plates, mut rods) = (Vec::new(), Vec::new(), Vec::new());
        for face in &body.faces {
            // For a polygon the strips along its edges are the rods; only solids have plates.
            let normal = pose.rotation * face.normal;
            let rim: Vec<Vec3> = face.corners.iter().map(|corner| corners[*corner]).collect();
            inside.push(HalfSpace::below(normal, &rim[0]));
            match body.dimension {
                2 => rods.extend(Rod::new(rim[0], rim[1])),
                _ => plates.push(plate(&rim, normal, radius)),
            }
        }
        let edge = |[from, to]: &[usize; 2]| Rod::new(corners[*from], corners[*to]);
        rods.extend(body.edges.iter().filter_map(edge));
        let pieces = Self {
            radius,
            solids: std::iter::once(inside).chain(plates).collect(),
            rods,
            balls: corners.clone(),
        };
        (corners, pieces)
    }

    /// The pieces of a point, a segment or, in space, a polygon.
    fn of_thin(shape: &Shape, radius: f64, pose: &Pose) -> (Vec<Vec3>, Self) {
        let corners = shape.corner_points();
        let mean = corners.iter().sum::<Vec3>() / corners.len() as f64;
        let place = |corner: &Vec3| pose.transform_point(&(corner - mean));
        let corners: Vec<Vec3> = corners.iter().map(place).collect();
        let next = corners.iter().cycle().skip(1);
        let rods = corners
            .iter()
            .zip(next)
            .filter_map(|(from, to)| Rod::new(*from, *to));
        let mut pieces = Self {
            radius,
            solids: Vec::new(),
            rods: rods.collect(),
            balls: corners.clone(),
        };
        if matches!(shape, Shape::Solid(Hull::Polygon(_))) {
            let normal = (corners[1] - corners[0])
                .cross(&(corners[2] - corners[0]))
                .normalize();
            let mut back = corners.clone();
            back.reverse();
            pieces.solids = vec![
                // Both sides of a polygon in space; the rim is
                // reversed so that its planes face outwards again.
                plate(&corners, normal, radius),
                plate(&back, -normal, radius),
            ];
        }
        (corners, pieces)
    }

    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    /// Interval of a line between its entry and its exit, as distances from its origin along a
    /// direction of length one.
    pub(super) fn interval(&self, origin: &Vec3, direction: &Vec3) -> Option<[f64; 2]> {
        // The union is convex, so first entry and last exit are all there is: no gaps inside.
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut take = |interval: Option<[f64; 2]>| {
            if let Some([enters, leaves]) = interval {
                from = from.min(enters);
                to = to.max(leaves);
            }
        };
        for solid in &self.solids {
            take(in_solid(solid, origin, direction));
        }
        // Without a radius, balls and rods have no volume, and rounding would let lines graze them.
        if self.radius > 0.0 {
            for centre in &self.balls {
                take(in_ball(centre, self.radius, origin, direction));
            }
            for rod in &self.rods {
                take(rod.interval(self.radius, origin, direction));
            }
        }
        (from <= to).then_some([from, to])
    }
}

/// The points over a face, not higher than the radius.
fn plate(rim: &[Vec3], normal: Vec3, radius: f64) -> Vec<HalfSpace> {
    let mut planes = vec![
        // Starts at the face, not below: the inside is a solid of its own.
        HalfSpace::below(-normal, &rim[0]),
        HalfSpace::below(normal, &(rim[0] + radius * normal)),
    ];
    for (from, to) in rim.iter().zip(rim.iter().cycle().skip(1)) {
        // Outward normals that are not of length one; `in_solid` needs only signs and quotients.
        planes.push(HalfSpace::below((to - from).cross(&normal), from));
    }
    planes
}

fn in_solid(planes: &[HalfSpace], origin: &Vec3, direction: &Vec3) -> Option<[f64; 2]> {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for plane in planes {
        let speed = plane.normal.dot(direction);
        let room = plane.height - plane.normal.dot(origin);
        // Parallel: the line is on one side for its whole length.
        if speed.abs() <= PARALLEL * plane.normal.norm() {
            if room < 0.0 {
                return None;
            }
        } else if speed > 0.0 {
            to = to.min(room / speed);
        } else {
            from = from.max(room / speed);
        }
    }
    (from <= to).then_some([from, to])
}

fn in_ball(centre: &Vec3, radius: f64, origin: &Vec3, direction: &Vec3) -> Option<[f64; 2]> {
    let to_centre = centre - origin;
    let middle = to_centre.dot(direction);
    // r² less the squared distance of the line from the centre.
    let squared = radius * radius - (to_centre - middle * direction).norm_squared();
    (squared >= 0.0).then(|| [middle - squared.sqrt(), middle + squared.sqrt()])
}

impl Rod {
    /// The rod between two points; `None` without length, as its balls cover it then.
    fn new(from: Vec3, to: Vec3) -> Option<Self> {
        let length = (to - from).norm();
        let axis = (to - from).try_normalize(0.0)?;
        Some(Self { from, axis, length })
    }

    /// The part of a line in a cylinder with flat ends.
    fn interval(&self, radius: f64, origin: &Vec3, direction: &Vec3) -> Option<[f64; 2]> {
        let to_start = self.from - origin;
        let (speed_along, start) = (direction.dot(&self.axis), to_start.dot(&self.axis));
        // At right angles to the axis.
        let speed_squared = 1.0 - speed_along * speed_along;
        // Distances along the line: where it is nearest to the axis, and what is left across it.
        let middle = to_start.dot(direction) - start * speed_along;
        let away_squared = to_start.norm_squared() - start * start;
        let (mut enters, mut leaves) = (f64::NEG_INFINITY, f64::INFINITY);
        // Along the axis: inside for ever or never.
        if speed_squared <= PARALLEL {
            if away_squared > radius * radius {
                return None;
            }
        } else {
            let middle = middle / speed_squared;
            let squared = radius * radius - away_squared + middle * middle * speed_squared;
            if squared < 0.0 {
                return None;
            }
            let half = (squared / speed_squared).sqrt();
            (enters, leaves) = (middle - half, middle + half);
        }
        // Across the axis: the flat ends are not met, and one sign decides.
        if speed_along.abs() <= PARALLEL {
            return (start <= 0.0 && start + self.length >= 0.0).then_some([enters, leaves]);
        }
        // The order of the ends depends on the sense of the line.
        let ends = [start / speed_along, (start + self.length) / speed_along];
        enters = enters.max(ends[0].min(ends[1]));
        leaves = leaves.min(ends[0].max(ends[1]));
        (enters <= leaves).then_some([enters, leaves])
    }
}
