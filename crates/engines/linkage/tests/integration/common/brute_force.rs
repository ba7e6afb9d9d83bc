//! Slow twins of contacts: corners in squares and rods through squares, pair by pair.

use protomer_linkage::lattice::{Corner, Network};
use std::f64::consts::FRAC_1_SQRT_2;

/// Places of the four corners of a square.
pub fn corners(positions: &[f64], square: usize) -> [[f64; 2]; 4] {
    let s = &positions[3 * square..3 * square + 3];
    [45.0_f64, 135.0, 225.0, 315.0].map(|degrees| {
        let angle = s[2] + degrees.to_radians();
        [s[0] + angle.cos(), s[1] + angle.sin()]
    })
}

/// Place of a corner.
pub fn corner(positions: &[f64], corner: Corner) -> [f64; 2] {
    let degrees = [135.0_f64, 45.0, 225.0, -45.0][usize::from(corner.vertex) - 1];
    let s = &positions[3 * corner.square..3 * corner.square + 3];
    let angle = s[2] + degrees.to_radians();
    [s[0] + angle.cos(), s[1] + angle.sin()]
}

/// Height of a point above a square, eq. 13 of the paper over √2 l: negative inside.
pub fn outside(point: [f64; 2], positions: &[f64], square: usize) -> f64 {
    let s = &positions[3 * square..3 * square + 3];
    let (x, y) = (point[0] - s[0], point[1] - s[1]);
    let (sine, cosine) = s[2].sin_cos();
    (cosine * x + sine * y)
        .abs()
        .max((cosine * y - sine * x).abs())
        - FRAC_1_SQRT_2
}

/// Share of a segment that lies inside a square, by clipping at its four sides.
pub fn share_inside(
    a: [f64; 2],
    b: [f64; 2],
    positions: &[f64],
    square: usize,
    margin: f64,
) -> f64 {
    let s = &positions[3 * square..3 * square + 3];
    let (sine, cosine) = s[2].sin_cos();
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in [
        [cosine, sine],
        [-sine, cosine],
        [-cosine, -sine],
        [sine, -cosine],
    ] {
        let height = |p: [f64; 2]| {
            axis[0] * (p[0] - s[0]) + axis[1] * (p[1] - s[1]) - (FRAC_1_SQRT_2 - margin)
        };
        let (ha, hb) = (height(a), height(b));
        if ha > 0.0 && hb > 0.0 {
            return 0.0;
        } else if ha > 0.0 {
            from = from.max(ha / (ha - hb));
        } else if hb > 0.0 {
            to = to.min(ha / (ha - hb));
        }
    }
    (to - from).max(0.0)
}

/// Height of the deepest corner of any square above any other: positive if none overlap.
pub fn smallest_height(network: &Network, positions: &[f64]) -> f64 {
    let mut smallest = f64::INFINITY;
    for p in 0..network.squares.len() {
        for q in (0..network.squares.len()).filter(|q| *q != p) {
            for corner in corners(positions, p) {
                smallest = smallest.min(outside(corner, positions, q));
            }
        }
    }
    smallest
}

/// Rods that run through squares, their own included.
pub fn cut_squares(network: &Network, positions: &[f64]) -> Vec<(usize, usize)> {
    let mut cuts = Vec::new();
    for (index, rod) in network.rods.iter().enumerate() {
        let (a, b) = (corner(positions, rod.from), corner(positions, rod.to));
        for p in 0..network.squares.len() {
            if share_inside(a, b, positions, p, 1e-8) > 1e-6 {
                cuts.push((index, p));
            }
        }
    }
    cuts
}
