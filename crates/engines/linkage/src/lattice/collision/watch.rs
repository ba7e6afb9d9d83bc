//! What could meet: how far apart it is, and how it touches.

use crate::CrystalError;
use crate::lattice::contact::candidates::{Body, Pair};
use crate::lattice::contact::layout::{Layout, sides_at};
use crate::lattice::contact::separation::{
    Along, Moving, Rectangle, at_rest, corner_in_motion, separation, shift_in_motion,
};
use crate::lattice::contact::{Contact, TOUCHING};
use crate::lattice::network::{Corner, Network};
use crate::plane::{Vector, cross, direction, dot, left_of, minus, norm, plus, scaled};
use std::ops::Range;

/// Bodies that could meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Watch {
    /// Two bodies.
    Pair(Pair),
    /// A rod and the square on which it hangs at this end.
    Stop {
        /// The rod.
        rod: usize,
        /// 0 for `from`, 1 for `to`.
        end: u8,
    },
}

impl Watch {
    /// Names of both bodies, in words.
    pub fn names(&self, network: &Network) -> (String, String) {
        match *self {
            Self::Pair(pair) => (
                name(network, Body::Square(pair.first)),
                name(network, pair.second),
            ),
            Self::Stop { rod, end } => {
                let near = network.rods[rod].corner_at(end);
                (
                    name(network, Body::Square(near.square)),
                    name(network, Body::Rod(rod)),
                )
            }
        }
    }

    /// The error that names both bodies.
    pub(crate) fn overlap(&self, network: &Network, depth: f64, time: f64) -> CrystalError {
        let (first, second) = self.names(network);
        CrystalError::Overlap {
            first,
            second,
            depth,
            time,
        }
    }

    /// The separation: positive apart.
    pub fn gap(&self, network: &Network, positions: &[f64]) -> f64 {
        self.gap_of(network, at_rest(positions))
    }

    /// The separation of moving bodies.
    pub(super) fn gap_of(&self, network: &Network, motion: impl Fn(usize) -> Moving + Copy) -> f64 {
        match self {
            Self::Pair(pair) => {
                let (a, b) = bodies(network, pair, motion);
                separation(&a, &b)
            }
            Self::Stop { rod, end } => {
                let [x, y] = stop(network, *rod, *end, motion);
                x.distance.max(y.distance)
            }
        }
    }

    /// Adds the contacts of two bodies that touch. Corners head on are listed from either side.
    pub fn contacts(&self, network: &Network, positions: &[f64], out: &mut Vec<Contact>) {
        let layout = Layout::new(network, positions);
        match *self {
            Self::Pair(Pair {
                first,
                second: Body::Square(second),
                image,
            }) => {
                let back = image.map(|cells| -cells);
                add_corners_on(&layout, first, second, image, out);
                add_corners_on(&layout, second, first, back, out);
            }
            Self::Pair(Pair {
                first,
                second: Body::Rod(rod),
                image,
            }) => add_corners_on_rod(&layout, first, rod, image, out),
            Self::Stop { rod, end } => {
                let [x, y] = stop(network, rod, end, at_rest(positions));
                let [first, second] = sides_at(network.rods[rod].corner_at(end));
                let side = if x.distance >= y.distance {
                    first
                } else {
                    second
                };
                out.push(Contact::RodStop { rod, end, side });
            }
        }
    }
}

fn name(network: &Network, body: Body) -> String {
    match body {
        Body::Square(square) => format!("square {square}"),
        Body::Rod(rod) => {
            let ends = network.rods[rod];
            format!(
                "rod {rod} (squares {} and {})",
                ends.from.square, ends.to.square
            )
        }
    }
}

/// The two bodies of a pair, moving as `motion` says.
pub(super) fn bodies(
    network: &Network,
    pair: &Pair,
    motion: impl Fn(usize) -> Moving + Copy,
) -> (Rectangle, Rectangle) {
    let second = match pair.second {
        Body::Square(q) => Rectangle::square(network, q, motion),
        Body::Rod(r) => Rectangle::rod(network, r, motion),
    };
    let first = Rectangle::square(network, pair.first, motion);
    let shift = shift_in_motion(network, pair.image, motion);
    (first, second.moved(shift))
}

/// The far end of a rod over the lines of the two sides that meet where it hangs.
pub(super) fn stop(
    network: &Network,
    rod: usize,
    end: u8,
    motion: impl Fn(usize) -> Moving,
) -> [Along; 2] {
    let ends = network.rods[rod];
    let (near, far) = (ends.corner_at(end), ends.corner_at(1 - end));
    let (shift, shift_rate) = shift_in_motion(network, ends.image, &motion);
    let near_motion = motion(near.square);
    let (near_place, near_rate) = corner_in_motion(network, near, near_motion);
    let (far_place, far_rate) = corner_in_motion(network, far, motion(far.square));
    let sign = if end == 0 { 1.0 } else { -1.0 };
    let rod_vector = plus(minus(far_place, near_place), scaled(shift, sign));
    let speed = plus(minus(far_rate, near_rate), scaled(shift_rate, sign));
    let (axis, spin) = (direction(near_motion.0[2]), near_motion.1[2]);
    let [x, y] = near.direction().map(f64::signum);
    [scaled(axis, x), scaled(left_of(axis), y)].map(|normal| {
        // The normal turns with the square.
        let rate = dot(speed, normal) + spin * cross(normal, rod_vector);
        Along {
            distance: dot(rod_vector, normal),
            rate,
            worst_rate: rate,
        }
    })
}

/// Contacts of the corners of one square with another.
fn add_corners_on(
    layout: &Layout,
    striker: usize,
    target: usize,
    image: [i32; 2],
    out: &mut Vec<Contact>,
) {
    let at_rest = at_rest(layout.positions);
    let shift = shift_in_motion(layout.network, image, at_rest);
    let body = Rectangle::square(layout.network, target, at_rest).moved(shift);
    for corner in corners_of(striker) {
        if height_above(&body, layout.place(corner)) <= TOUCHING {
            let (network, positions) = (layout.network, layout.positions);
            out.push(Contact::of_corner(
                network, positions, corner, target, image,
            ));
        }
    }
}

fn corners_of(square: usize) -> impl Iterator<Item = Corner> {
    (1..=4).map(move |vertex| Corner { square, vertex })
}

/// Height of a point above the sides of a rectangle (eq. 12 of the paper, less l², over √2 l):
/// negative inside.
fn height_above(body: &Rectangle, point: Vector) -> f64 {
    let [x, y] = minus(point, body.centre);
    let [c, s] = body.axis;
    ((c * x + s * y).abs() - body.half[0]).max((c * y - s * x).abs() - body.half[1])
}

/// Contacts of the corners of a square with a rod.
fn add_corners_on_rod(
    layout: &Layout,
    square: usize,
    rod: usize,
    image: [i32; 2],
    out: &mut Vec<Contact>,
) {
    // At the very end of a rod there is a corner, and that has its own contacts.
    const INSIDE: Range<f64> = TOUCHING..1.0 - TOUCHING;
    let (line, shift) = (RodLine::new(layout.rod_ends(rod)), layout.shift(image));
    let (height, _) = line.height_and_share(minus(layout.centre(square), shift));
    let left = height > 0.0;
    for striker in corners_of(square) {
        let (distance, share) = line.height_and_share(minus(layout.place(striker), shift));
        // Where only an end of the rod touches, corners may lie beyond its prolongation.
        if INSIDE.contains(&share) && distance.abs() <= TOUCHING {
            out.push(Contact::RodCorner {
                striker,
                rod,
                left,
                image,
            });
        }
    }
}

/// The line from one end of a rod to the other.
struct RodLine {
    begin: Vector,
    unit: Vector,
    length: f64,
}

impl RodLine {
    fn new([begin, end]: [Vector; 2]) -> Self {
        let rod_vector = minus(end, begin);
        let length = norm(rod_vector);
        Self {
            begin,
            unit: [rod_vector[0] / length, rod_vector[1] / length],
            length,
        }
    }

    /// The height of a point on the left of the line, and its place along the rod, 0 to 1.
    fn height_and_share(&self, point: Vector) -> (f64, f64) {
        let away = minus(point, self.begin);
        (cross(self.unit, away), dot(self.unit, away) / self.length)
    }
}
