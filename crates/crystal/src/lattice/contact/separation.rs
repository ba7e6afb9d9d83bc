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

use super::rod_shift;
use crate::lattice::network::{Corner, Network, corner_direction};

/// A rectangle in motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rectangle {
    /// Centre.
    pub centre: [f64; 2],
    /// Half its edges.
    pub half: [f64; 2],
    /// Its first axis, cos and sin of its angle.
    pub axis: [f64; 2],
    /// Velocity of the centre.
    pub velocity: [f64; 2],
    /// Angular velocity.
    pub spin: f64,
}

/// The separation along one axis and its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Along {
    /// m.
    pub distance: f64,
    /// dm/dt.
    pub rate: f64,
    /// What dm/dt can be once another corner leads.
    pub worst_rate: f64,
}

/// Position and velocity (x, y, θ) of one square.
pub type Moving = ([f64; 3], [f64; 3]);

/// The squares at rest at these positions.
pub fn at_rest(positions: &[f64]) -> impl Fn(usize) -> Moving + Copy + '_ {
    |p| {
        (
            [positions[3 * p], positions[3 * p + 1], positions[3 * p + 2]],
            [0.0; 3],
        )
    }
}

/// Place and velocity of a corner.
pub(crate) fn corner_in_motion(
    network: &Network,
    corner: Corner,
    (s, v): Moving,
) -> ([f64; 2], [f64; 2]) {
    let [x, y] =
        corner_direction(corner.vertex).map(|x| x * network.squares[corner.square].half_diagonal);
    let (sine, cosine) = s[2].sin_cos();
    let rho = [cosine * x - sine * y, sine * x + cosine * y];
    (
        [s[0] + rho[0], s[1] + rho[1]],
        [v[0] - v[2] * rho[1], v[1] + v[2] * rho[0]],
    )
}

impl Rectangle {
    /// A square, moving as `at` says.
    pub fn square(network: &Network, square: usize, at: impl Fn(usize) -> Moving) -> Self {
        let (s, v) = at(square);
        let (sine, cosine) = s[2].sin_cos();
        Self {
            centre: [s[0], s[1]],
            half: [network.squares[square].half_diagonal * std::f64::consts::FRAC_1_SQRT_2; 2],
            axis: [cosine, sine],
            velocity: [v[0], v[1]],
            spin: v[2],
        }
    }

    /// A rod, the first axis from its first to its second end, its squares moving as `at` says.
    pub fn rod(network: &Network, rod: usize, at: impl Fn(usize) -> Moving) -> Self {
        let (ends, shift) = (network.rods[rod], rod_shift(network, rod));
        let (a, va) = corner_in_motion(network, ends.from, at(ends.from.square));
        let (b, vb) = corner_in_motion(network, ends.to, at(ends.to.square));
        let along = [b[0] + shift[0] - a[0], b[1] + shift[1] - a[1]];
        let length = along[0].hypot(along[1]);
        let u = [along[0] / length, along[1] / length];
        Self {
            centre: [a[0] + 0.5 * along[0], a[1] + 0.5 * along[1]],
            half: [0.5 * length, 0.0],
            axis: u,
            velocity: [0.5 * (va[0] + vb[0]), 0.5 * (va[1] + vb[1])],
            spin: (u[0] * (vb[1] - va[1]) - u[1] * (vb[0] - va[0])) / length,
        }
    }

    /// The same, moved.
    pub fn moved(mut self, shift: [f64; 2]) -> Self {
        self.centre[0] += shift[0];
        self.centre[1] += shift[1];
        self
    }
}

/// The separation: the greatest along the four axes.
pub fn separation(a: &Rectangle, b: &Rectangle) -> f64 {
    along_axes(a, b)
        .iter()
        .fold(f64::NEG_INFINITY, |most, along| most.max(along.distance))
}

/// The separations along the axes of `a` and of `b`.
pub fn along_axes(a: &Rectangle, b: &Rectangle) -> [Along; 4] {
    let d = [a.centre[0] - b.centre[0], a.centre[1] - b.centre[1]];
    let v = [a.velocity[0] - b.velocity[0], a.velocity[1] - b.velocity[1]];
    let (cosine, sine) = (
        a.axis[0] * b.axis[0] + a.axis[1] * b.axis[1],
        a.axis[0] * b.axis[1] - a.axis[1] * b.axis[0],
    );
    let turning = b.spin - a.spin;
    let (c, s) = (cosine.abs(), sine.abs());
    // d|cos φ|/dt and d|sin φ|/dt.
    let (c_rate, s_rate) = (
        -sine * cosine.signum() * turning,
        cosine * sine.signum() * turning,
    );
    let one = |axis: [f64; 2], spin: f64, own: f64, reach: f64, reach_rate: f64, largest: f64| {
        let height = d[0] * axis[0] + d[1] * axis[1];
        // The axis turns: de/dt = spin × e.
        let height_rate =
            v[0] * axis[0] + v[1] * axis[1] + spin * (d[1] * axis[0] - d[0] * axis[1]);
        let rate = if height >= 0.0 {
            height_rate
        } else {
            -height_rate
        } - reach_rate;
        Along {
            distance: height.abs() - own - reach,
            rate,
            worst_rate: rate - 2.0 * largest * turning.abs(),
        }
    };
    let left = |axis: [f64; 2]| [-axis[1], axis[0]];
    let of = |other: &Rectangle| {
        let [x, y] = other.half;
        let largest = x.max(y);
        (
            (x * c + y * s, x * c_rate + y * s_rate),
            (x * s + y * c, x * s_rate + y * c_rate),
            largest,
        )
    };
    let (first_of_b, second_of_b, largest_b) = of(b);
    let (first_of_a, second_of_a, largest_a) = of(a);
    [
        one(
            a.axis,
            a.spin,
            a.half[0],
            first_of_b.0,
            first_of_b.1,
            largest_b,
        ),
        one(
            left(a.axis),
            a.spin,
            a.half[1],
            second_of_b.0,
            second_of_b.1,
            largest_b,
        ),
        one(
            b.axis,
            b.spin,
            b.half[0],
            first_of_a.0,
            first_of_a.1,
            largest_a,
        ),
        one(
            left(b.axis),
            b.spin,
            b.half[1],
            second_of_a.0,
            second_of_a.1,
            largest_a,
        ),
    ]
}

/// How long until another corner of the turning bodies leads, from the relative angle and its rate.
pub fn time_to_next_corner(a: &Rectangle, b: &Rectangle) -> f64 {
    let sine = a.axis[0] * b.axis[1] - a.axis[1] * b.axis[0];
    let cosine = a.axis[0] * b.axis[0] + a.axis[1] * b.axis[1];
    let quarter = std::f64::consts::FRAC_PI_2;
    let angle = sine.atan2(cosine).rem_euclid(quarter);
    let turning = b.spin - a.spin;
    let left = if turning > 0.0 {
        quarter - angle
    } else {
        angle
    };
    if turning == 0.0 {
        f64::INFINITY
    } else {
        left / turning.abs()
    }
}
