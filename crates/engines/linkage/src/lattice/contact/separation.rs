//! How far apart two rectangles are.
//!
//! Two convex bodies are apart exactly if they are apart along the normal of one of their sides.
//! For rectangles with centres d apart, half edges h along axes e, and the relative angle φ, the
//! separation along the axis e_i of B is
//!
//! m = |d · e_i| - h_i(B) - (h₁(A) |e_i · a₁| + h₂(A) |e_i · a₂|),
//!
//! and likewise along those of A: the separation is the greatest of four numbers. It is zero where
//! the bodies touch, never more than their distance, and for two squares its sign is that of eq. 13
//! of the paper over all corners and both roles. A rod is a rectangle of no width.

use crate::lattice::cell::Cell;
use crate::lattice::network::{Corner, Network};
use crate::plane::{Vector, cross, direction, dot, left_of, minus, norm, plus, turned};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

/// A rectangle in motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rectangle {
    /// Centre.
    pub centre: [f64; 2],
    /// Half the lengths of the edges.
    pub half: [f64; 2],
    /// First axis of the rectangle: cosine and sine of its angle.
    pub axis: [f64; 2],
    /// Velocity of the centre.
    pub velocity: [f64; 2],
    /// Angular velocity.
    pub spin: f64,
}

/// The separation along one axis and its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Along {
    /// Separation m.
    pub distance: f64,
    /// Rate of the separation, dm/dt.
    pub rate: f64,
    /// The lowest dm/dt once another corner leads.
    pub worst_rate: f64,
}

/// Position and velocity (x, y, θ) of one square, or (xx, yy, xy) of a flexible cell, the body after
/// the last square.
pub type Moving = ([f64; 3], [f64; 3]);

/// The squares at rest at these positions.
pub fn at_rest(positions: &[f64]) -> impl Fn(usize) -> Moving + Copy + '_ {
    |p| {
        let s = [positions[3 * p], positions[3 * p + 1], positions[3 * p + 2]];
        (s, [0.0; 3])
    }
}

/// Vector to an image of a body, and its rate.
pub(crate) fn shift_in_motion(
    network: &Network,
    image: [i32; 2],
    motion: impl Fn(usize) -> Moving,
) -> (Vector, Vector) {
    if image == [0, 0] {
        return ([0.0; 2], [0.0; 2]);
    }
    let image = image.map(f64::from);
    if network.cell_mass.is_none() {
        return (Cell::coherent(network).shift(image), [0.0; 2]);
    }
    let (cell, rate) = motion(network.squares.len());
    let [cell, rate] = [cell, rate].map(|[xx, yy, xy]| Cell { xx, yy, xy });
    (cell.shift(image), rate.shift(image))
}

/// Place and velocity of a corner.
pub(crate) fn corner_in_motion(
    network: &Network,
    corner: Corner,
    (s, v): Moving,
) -> (Vector, Vector) {
    let half_diagonal = network.squares[corner.square].half_diagonal;
    let rho = turned(
        corner.direction().map(|x| x * half_diagonal),
        direction(s[2]),
    );
    let velocity = [v[0] - v[2] * rho[1], v[1] + v[2] * rho[0]];
    (plus([s[0], s[1]], rho), velocity)
}

impl Rectangle {
    /// A square, moving as `motion` says.
    pub fn square(network: &Network, square: usize, motion: impl Fn(usize) -> Moving) -> Self {
        let (s, v) = motion(square);
        Self {
            centre: [s[0], s[1]],
            half: [network.squares[square].half_diagonal * FRAC_1_SQRT_2; 2],
            axis: direction(s[2]),
            velocity: [v[0], v[1]],
            spin: v[2],
        }
    }

    /// A rod, its first axis from its first to its second end, its squares moving as `motion` says.
    pub fn rod(network: &Network, rod: usize, motion: impl Fn(usize) -> Moving) -> Self {
        let ends = network.rods[rod];
        let (shift, shift_rate) = shift_in_motion(network, ends.image, &motion);
        let (a, va) = corner_in_motion(network, ends.from, motion(ends.from.square));
        let (b, vb) = corner_in_motion(network, ends.to, motion(ends.to.square));
        let (b, vb) = (plus(b, shift), plus(vb, shift_rate));
        let rod_vector = minus(b, a);
        let length = norm(rod_vector);
        let u = [rod_vector[0] / length, rod_vector[1] / length];
        Self {
            centre: [a[0] + 0.5 * rod_vector[0], a[1] + 0.5 * rod_vector[1]],
            half: [0.5 * length, 0.0],
            axis: u,
            velocity: [0.5 * (va[0] + vb[0]), 0.5 * (va[1] + vb[1])],
            spin: cross(u, minus(vb, va)) / length,
        }
    }

    /// The rectangle moved by a shift that changes at this rate.
    pub fn moved(mut self, (shift, rate): ([f64; 2], [f64; 2])) -> Self {
        self.centre = plus(self.centre, shift);
        self.velocity = plus(self.velocity, rate);
        self
    }

    /// The longer of its half edges.
    fn longest_half(&self) -> f64 {
        self.half[0].max(self.half[1])
    }
}

/// The separation: the greatest along the four axes.
pub fn separation(a: &Rectangle, b: &Rectangle) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for projection in along_axes(a, b) {
        most = most.max(projection.distance);
    }
    most
}

/// The relative motion of two rectangles.
struct Relative {
    /// Vector from the centre of B to that of A, and its rate.
    d: Vector,
    v: Vector,
    /// |cos φ| and |sin φ| of the relative angle φ, and their rates.
    cosine: [f64; 2],
    sine: [f64; 2],
    turning: f64,
}

impl Relative {
    #[inline(always)]
    fn new(a: &Rectangle, b: &Rectangle) -> Self {
        let (cosine, sine) = (dot(a.axis, b.axis), cross(a.axis, b.axis));
        let turning = b.spin - a.spin;
        Self {
            d: minus(a.centre, b.centre),
            v: minus(a.velocity, b.velocity),
            // |cos φ| and its rate: the sign of the cosine times that of its derivative.
            cosine: [cosine.abs(), -sine * cosine.signum() * turning],
            sine: [sine.abs(), cosine * sine.signum() * turning],
            turning,
        }
    }

    /// Reach of a rectangle along the first and the second axis of the other one, and its rates.
    #[inline(always)]
    fn reaches(&self, body: &Rectangle) -> [[f64; 2]; 2] {
        let [x, y] = body.half;
        let (c, s) = (self.cosine, self.sine);
        [
            [0, 1].map(|order| x * c[order] + y * s[order]),
            [0, 1].map(|order| x * s[order] + y * c[order]),
        ]
    }

    /// The separation along an axis that turns at `spin`, where the bodies reach `half_extent` and
    /// `other` along it.
    #[inline(always)]
    fn along(
        &self,
        axis: Vector,
        spin: f64,
        half_extent: f64,
        other: [f64; 2],
        longest: f64,
    ) -> Along {
        let (d, v) = (self.d, self.v);
        let height = dot(d, axis);
        // The axis turns: de/dt = spin × e.
        let height_rate =
            v[0] * axis[0] + v[1] * axis[1] + spin * (d[1] * axis[0] - d[0] * axis[1]);
        // |height|: its rate has the sign of the height.
        let sign = if height >= 0.0 { 1.0 } else { -1.0 };
        let [reach, reach_rate] = other;
        let rate = sign * height_rate - reach_rate;
        Along {
            distance: height.abs() - half_extent - reach,
            rate,
            // Another corner that takes the lead may approach
            // faster by twice its reach times the turning.
            worst_rate: rate - 2.0 * longest * self.turning.abs(),
        }
    }
}

/// The separations along the axes of `a` and of `b`.
pub fn along_axes(a: &Rectangle, b: &Rectangle) -> [Along; 4] {
    let relative = Relative::new(a, b);
    let [b_first, b_second] = relative.reaches(b);
    let [a_first, a_second] = relative.reaches(a);
    let (a_longest, b_longest) = (a.longest_half(), b.longest_half());
    [
        relative.along(a.axis, a.spin, a.half[0], b_first, b_longest),
        relative.along(left_of(a.axis), a.spin, a.half[1], b_second, b_longest),
        relative.along(b.axis, b.spin, b.half[0], a_first, a_longest),
        relative.along(left_of(b.axis), b.spin, b.half[1], a_second, a_longest),
    ]
}

/// Time until another corner of the turning bodies leads, from the relative angle and its rate.
pub fn time_to_next_corner(a: &Rectangle, b: &Rectangle) -> f64 {
    let turning = b.spin - a.spin;
    if turning == 0.0 {
        return f64::INFINITY;
    }
    let (cosine, sine) = (dot(a.axis, b.axis), cross(a.axis, b.axis));
    // Corners of rectangles repeat every quarter turn.
    let angle = sine.atan2(cosine).rem_euclid(FRAC_PI_2);
    let remaining_angle = if turning > 0.0 {
        FRAC_PI_2 - angle
    } else {
        angle
    };
    remaining_angle / turning.abs()
}
