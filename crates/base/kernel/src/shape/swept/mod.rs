//! Bodies swept by a ball: the places where the centre of a ball would overlap a body, and the volume
//! that two such regions share. Penetrable depletants of number density n in a reservoir give two bodies
//! the energy -n kT times this volume (Asakura and Oosawa, J. Chem. Phys. 22, 1255 (1954)).
//!
//! A line meets a swept body, which is convex, in an interval. The shared volume is the integral over a
//! plane of the length that the intervals of two bodies have in common, with lines along the line of
//! centres. Polar coordinates about a point inside have the form
//!
//! V = ∫ dφ ∫₀^R(φ) s t(s, φ) ds,
//!
//! where the length t is a concave function that falls to zero at the rim R. It is smooth but for kinks,
//! which the rule of integration finds.

mod pieces;
mod quadrature;

use super::Shape;
use super::closest::{ClosestPoints, closest_points};
use crate::bisection::halved;
use crate::error::require;
use crate::{Pose, Result, Vec3};
use pieces::Pieces;
use quadrature::integral;
use std::f64::consts::PI;

/// The wanted error of an overlap, as a part of it.
const ACCURACY: f64 = 1e-7;
/// The wanted error of the integrals along rays, as a part of them.
const ALONG_A_RAY: f64 = 1e-8;
/// Number of angular sectors that are integrated first.
const SECTORS: usize = 8;
/// Number of halvings that find where a concave function ends.
const HALVINGS: u32 = 45;

/// A convex body in its place, swept by a ball.
///
/// ```
/// use protomer_kernel::shape::{builders::by_name, swept::Swept};
/// use protomer_kernel::{Pose, Vec3};
/// let cube = by_name("cube")?;
/// let neighbour = Pose { position: Vec3::new(1.05, 0.0, 0.0), ..Pose::identity() };
/// let bodies = [Pose::identity(), neighbour].map(|pose| Swept::new(&cube, 0.1, &pose));
/// let [first, second] = bodies;
/// let shared = first?.overlap(&second?);
/// assert!((shared - 0.1956929).abs() < 1e-6);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Swept {
    dimension: usize,
    corners: Vec<Vec3>,
    centre: Vec3,
    pieces: Pieces,
}

impl Swept {
    /// A shape about its centroid, in a pose, with all places at most a radius from it. In a plane, the
    /// ball is a disk.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, swept::Swept};
    /// use protomer_kernel::Pose;
    /// let cube = by_name("cube")?;
    /// assert!(Swept::new(&cube, 0.0, &Pose::identity()).is_ok(), "a body without rounding");
    /// assert!(Swept::new(&cube, -0.1, &Pose::identity()).is_err());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) for a negative radius.
    pub fn new(shape: &Shape, radius: f64, pose: &Pose) -> Result<Self> {
        let holds = radius >= 0.0;
        require("the radius of the ball", radius, "zero or positive", holds)?;
        let (corners, pieces) = Pieces::from_shape(shape, radius, pose);
        Ok(Self {
            dimension: shape.dimension(),
            centre: corners.iter().sum::<Vec3>() / corners.len() as f64,
            corners,
            pieces,
        })
    }

    /// The corners of the body in its place.
    pub fn corners(&self) -> &[Vec3] {
        &self.corners
    }

    /// Whether a point is at most the radius away from the body.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, swept::Swept};
    /// use protomer_kernel::{Pose, Vec3};
    /// let cube = Swept::new(&by_name("cube")?, 0.25, &Pose::identity())?;
    /// assert!(cube.holds(&Vec3::new(0.7, 0.0, 0.0)));
    /// assert!(!cube.holds(&Vec3::new(0.7, 0.7, 0.0)), "its edges are rounded");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn holds(&self, point: &Vec3) -> bool {
        let through = self.pieces.interval(point, &Vec3::x());
        through.is_some_and(|[from, to]| from <= 0.0 && to >= 0.0)
    }

    /// The part of a line that is inside, as distances from its origin along a direction of length one.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, swept::Swept};
    /// use protomer_kernel::{Pose, Vec3};
    /// let cube = Swept::new(&by_name("cube")?, 0.25, &Pose::identity())?;
    /// let interval = cube.interval(&Vec3::new(-2.0, 0.0, 0.0), &Vec3::x());
    /// assert!(interval.is_some_and(|[from, to]| {
    ///     (from - 1.25).abs() < 1e-12 && (to - 2.75).abs() < 1e-12
    /// }));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn interval(&self, origin: &Vec3, direction: &Vec3) -> Option<[f64; 2]> {
        self.pieces.interval(origin, direction)
    }

    /// The volume (in a plane, the area) inside both bodies, to about 1e-7 of it.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, swept::Swept};
    /// use protomer_kernel::{Pose, Vec3};
    /// let cube = by_name("cube")?;
    /// let half_way = Pose { position: Vec3::new(0.5, 0.0, 0.0), ..Pose::identity() };
    /// let first = Swept::new(&cube, 0.0, &Pose::identity())?;
    /// let shared = first.overlap(&Swept::new(&cube, 0.0, &half_way)?);
    /// assert!((shared - 0.5).abs() < 1e-6);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn overlap(&self, other: &Self) -> f64 {
        let shared = Shared::from_bodies([self, other]);
        match shared {
            Some(shared) if self.dimension == 2 => shared.area(),
            Some(shared) => shared.volume(),
            None => 0.0,
        }
    }

    /// The corners drawn together to the centre.
    fn shrunk(&self, part: f64) -> Vec<Vec3> {
        let drawn = |corner: &Vec3| self.centre + part * (corner - self.centre);
        self.corners.iter().map(drawn).collect()
    }
}

/// Common part of two bodies, seen along a line.
struct Shared<'a> {
    bodies: [&'a Swept; 2],
    /// A point inside both bodies.
    inside: Vec3,
    axis: Vec3,
    transverse: [Vec3; 2],
    /// A length longer than any length across.
    reach: f64,
}

impl<'a> Shared<'a> {
    /// The common part of two bodies; `None` if no point is inside both.
    fn from_bodies(bodies: [&'a Swept; 2]) -> Option<Self> {
        // A point inside both is the pole of the polar coordinates; without one nothing is shared.
        let inside = common_point(bodies)?;
        if !bodies.iter().all(|body| body.holds(&inside)) {
            return None;
        }
        let axis = (bodies[1].centre - bodies[0].centre)
            .try_normalize(0.0)
            .unwrap_or(Vec3::x());
        let x = match bodies[0].dimension {
            2 => Vec3::z().cross(&axis),
            // The axis least along the line of centres: its cross product with it is never short.
            _ => axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize(),
        };
        let longest = |corner: &Vec3| (corner - inside).norm();
        let reach = bodies[0].corners.iter().map(longest).fold(0.0, f64::max);
        Some(Self {
            bodies,
            inside,
            axis,
            transverse: [x, axis.cross(&x)],
            reach: reach + bodies[0].pieces.radius(),
        })
    }

    /// The length of the part of a line inside both bodies; negative if there is none.
    fn length(&self, offset: &Vec3) -> f64 {
        let origin = self.inside + offset;
        let intervals = self
            .bodies
            .map(|body| body.pieces.interval(&origin, &self.axis));
        match intervals {
            // Negative where the intervals do not meet, so `rim` can bisect on the sign.
            [Some(a), Some(b)] => a[1].min(b[1]) - a[0].max(b[0]),
            _ => -1.0,
        }
    }

    /// Largest distance from the inner point, in a direction, of lines that cross the common part.
    fn rim(&self, direction: &Vec3) -> f64 {
        // The shared part is convex: along a ray the length
        // is positive up to the rim, then never again.
        let crosses = |distance: f64| self.length(&(distance * direction)) > 0.0;
        halved([0.0, self.reach], HALVINGS, crosses)[0]
    }

    /// The integral from the inside to the rim of the length times a power of the distance. With
    /// s = R (1 - u²) it has no root at the rim.
    fn on_ray(&self, direction: &Vec3, power: i32) -> f64 {
        let rim = self.rim(direction);
        let integrand = |u: f64| {
            // The root at the rim, t ~ √(R - s), becomes linear in u.
            let distance = rim * (1.0 - u * u);
            let length = self.length(&(distance * direction)).max(0.0);
            // ds = 2 R u du; the sign is absorbed by running u from the rim outwards.
            2.0 * rim * u * distance.powi(power) * length
        };
        integral(integrand, &[0.0, 1.0], ALONG_A_RAY)
    }

    fn area(&self) -> f64 {
        // Both rays: in a plane, φ takes two values and there is no factor s.
        let x = self.transverse[0];
        self.on_ray(&x, 0) + self.on_ray(&-x, 0)
    }

    fn volume(&self) -> f64 {
        let ray = |angle: f64| {
            let (sine, cosine) = angle.sin_cos();
            // The power 1 is the factor s of polar coordinates.
            self.on_ray(
                &(cosine * self.transverse[0] + sine * self.transverse[1]),
                1,
            )
        };
        // Sectors first: a rule on the whole circle could miss a kink between its nodes.
        let bounds = |sector: usize| 2.0 * PI * sector as f64 / SECTORS as f64;
        let sectors: Vec<f64> = (0..=SECTORS).map(bounds).collect();
        integral(ray, &sectors, ACCURACY)
    }
}

/// A point between two bodies, inside of both once they are swept, if there is any. Bodies that overlap
/// are drawn together to their centres until they touch: they touch at a point of both.
fn common_point(bodies: [&Swept; 2]) -> Option<Vec3> {
    let apart = |part: f64| -> Option<ClosestPoints> {
        closest_points(&bodies[0].shrunk(part), &bodies[1].shrunk(part))
    };
    let radii = bodies.map(|body| body.pieces.radius());
    // The swept bodies share a part of the line between the closest points, if they share anything.
    let middle = |points: ClosestPoints| {
        let length = points.distance();
        // From where the second body's ball begins to where the first one's ends.
        let shared = [(length - radii[1]).max(0.0), length.min(radii[0])];
        let part = f64::midpoint(shared[0], shared[1]) / length;
        points.on_first + part * (points.on_second - points.on_first)
    };
    if let Some(points) = apart(1.0) {
        return Some(middle(points));
    }
    let Some(mut best) = apart(0.0) else {
        // The centres are one point.
        return Some(bodies[0].centre);
    };
    // Invariant: at `clear` the bodies are apart, at `touching` they are not.
    let (mut clear, mut touching) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let part = f64::midpoint(clear, touching);
        match apart(part) {
            Some(points) => (clear, best) = (part, points),
            None => touching = part,
        }
    }
    Some(0.5 * (best.on_first + best.on_second))
}
