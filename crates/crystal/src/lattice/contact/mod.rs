//! Who touches whom, and how.
//!
//! | module | one idea |
//! |---|---|
//! | [`separation`] | how far apart two rectangles are: squares, and rods as rectangles without width |
//! | [`candidates`] | which pairs are near enough to be looked at |
//!
//! A [`Contact`] is a point at which two bodies touch and a direction in which they may only move
//! apart. Its gap is a function of the positions, and the rate of the gap is linear in the
//! velocities of the squares: ġ = n · v with the [`Row`] n.

pub mod candidates;
pub mod separation;

use super::network::{Corner, Network, corner_direction};
use std::f64::consts::FRAC_1_SQRT_2;

/// Bodies nearer than this touch; a corner this near to another corner meets it head on.
pub const TOUCHING: f64 = 1e-9;

/// One touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// A corner of one square on a side of another.
    VertexSide {
        /// The corner.
        striker: Corner,
        /// The square whose side is struck.
        target: usize,
        /// The side, 0 to 3: outward normal at θ + 0°, 90°, 180°, 270°.
        side: u8,
        /// From the target to the periodic image of it that is struck.
        shift: [f64; 2],
    },
    /// Two corners head on. The normal is the bisector ρ_target - ρ_striker.
    VertexVertex {
        /// One corner.
        striker: Corner,
        /// The other.
        target: Corner,
        /// From the target to the periodic image of it that is struck.
        shift: [f64; 2],
    },
    /// A corner of a square on a rod. The rod has no mass: what it feels, its two ends feel, split
    /// by the lever.
    RodCorner {
        /// The corner.
        striker: Corner,
        /// The rod.
        rod: usize,
        /// Whether the corner is on the left of the rod (seen along it) or on its right.
        left: bool,
        /// From the rod to the periodic image of it that is struck.
        shift: [f64; 2],
    },
    /// A rod flat along a side of the square it hangs on: 135° from the diagonal.
    RodStop {
        /// The rod.
        rod: usize,
        /// Which end hangs on the square: 0 is `from`, 1 is `to`.
        end: u8,
        /// The side, as for `VertexSide`.
        side: u8,
    },
}

/// n: how fast a gap opens per velocity of up to three squares.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Row {
    squares: [usize; 3],
    entries: [[f64; 3]; 3],
    count: usize,
}

impl Row {
    /// A force along `normal` at `arm` from the centre of a square, its share of the row.
    fn push(&mut self, square: usize, weight: f64, normal: [f64; 2], arm: [f64; 2]) {
        let torque = arm[0] * normal[1] - arm[1] * normal[0];
        let entry = [weight * normal[0], weight * normal[1], weight * torque];
        // A square may meet its own periodic image.
        if let Some(place) = self.squares[..self.count]
            .iter()
            .position(|other| *other == square)
        {
            for (sum, x) in self.entries[place].iter_mut().zip(entry) {
                *sum += x;
            }
        } else if self.count < self.squares.len() {
            self.squares[self.count] = square;
            self.entries[self.count] = entry;
            self.count += 1;
        }
    }

    /// Two squares pushed apart along a normal that leads from the second to the first, at these
    /// arms.
    pub(crate) fn along(
        [first, second]: [usize; 2],
        normal: [f64; 2],
        arms: [[f64; 2]; 2],
    ) -> Self {
        let mut row = Self::default();
        row.push(first, 1.0, normal, arms[0]);
        row.push(second, -1.0, normal, arms[1]);
        row
    }

    /// The squares and their numbers (along x, y and θ).
    pub fn entries(&self) -> impl Iterator<Item = (usize, &[f64; 3])> {
        self.squares
            .iter()
            .copied()
            .zip(&self.entries)
            .take(self.count)
    }

    /// n · x for a vector over the squares.
    pub fn dot(&self, x: &[f64]) -> f64 {
        self.entries()
            .map(|(p, n)| n[0] * x[3 * p] + n[1] * x[3 * p + 1] + n[2] * x[3 * p + 2])
            .sum()
    }
}

/// ρ: from the centre of a square to its corner.
pub(crate) fn arm(network: &Network, positions: &[f64], corner: Corner) -> [f64; 2] {
    let [x, y] =
        corner_direction(corner.vertex).map(|x| x * network.squares[corner.square].half_diagonal);
    let (sine, cosine) = positions[3 * corner.square + 2].sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// Where a corner is.
pub(crate) fn place(network: &Network, positions: &[f64], corner: Corner) -> [f64; 2] {
    let rho = arm(network, positions, corner);
    [
        positions[3 * corner.square] + rho[0],
        positions[3 * corner.square + 1] + rho[1],
    ]
}

/// From the image of a rod at `to` back to the square: the shift of the second end of a rod.
pub(crate) fn rod_shift(network: &Network, rod: usize) -> [f64; 2] {
    let cell = network.cell.unwrap_or([0.0; 2]);
    let image = network.rods[rod].image;
    [f64::from(image[0]) * cell[0], f64::from(image[1]) * cell[1]]
}

/// Both ends of a rod, the second as the image the rod leads to.
pub(crate) fn rod_ends(network: &Network, positions: &[f64], rod: usize) -> [[f64; 2]; 2] {
    let (ends, shift) = (network.rods[rod], rod_shift(network, rod));
    let to = place(network, positions, ends.to);
    [
        place(network, positions, ends.from),
        [to[0] + shift[0], to[1] + shift[1]],
    ]
}

fn side_normal(angle: f64, side: u8) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    match side % 4 {
        0 => [cosine, sine],
        1 => [-sine, cosine],
        2 => [-cosine, -sine],
        _ => [sine, -cosine],
    }
}

/// The two sides that meet at a corner.
pub(crate) fn sides_at(vertex: u8) -> [u8; 2] {
    let [x, y] = corner_direction(vertex);
    [if x > 0.0 { 0 } else { 2 }, if y > 0.0 { 1 } else { 3 }]
}

pub(crate) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn unit(a: [f64; 2]) -> [f64; 2] {
    let length = a[0].hypot(a[1]);
    [a[0] / length, a[1] / length]
}

fn centre(positions: &[f64], square: usize) -> [f64; 2] {
    [positions[3 * square], positions[3 * square + 1]]
}

/// From the centre of a square (its image at `shift`) to a point.
fn from_centre(positions: &[f64], square: usize, shift: [f64; 2], point: [f64; 2]) -> [f64; 2] {
    minus(minus(point, shift), centre(positions, square))
}

impl Contact {
    /// The touch of the corner `striker` and the square `target`: on its corner where it is one,
    /// else on the nearest side.
    pub fn of_corner(
        network: &Network,
        positions: &[f64],
        striker: Corner,
        target: usize,
        shift: [f64; 2],
    ) -> Self {
        let u = from_centre(positions, target, shift, place(network, positions, striker));
        let l = network.squares[target].half_diagonal;
        for vertex in 1..=4 {
            let corner = Corner {
                square: target,
                vertex,
            };
            let away = minus(u, arm(network, positions, corner));
            if away[0].hypot(away[1]) <= 10.0 * TOUCHING * l {
                return Self::VertexVertex {
                    striker,
                    target: corner,
                    shift,
                };
            }
        }
        let angle = positions[3 * target + 2];
        let height = |side: u8| dot(u, side_normal(angle, side));
        let side = (1..4).fold(0, |best, side| {
            if height(side) > height(best) {
                side
            } else {
                best
            }
        });
        Self::VertexSide {
            striker,
            target,
            side,
            shift,
        }
    }

    /// Distance along the normal: positive apart, negative overlapping.
    pub fn gap(&self, network: &Network, positions: &[f64]) -> f64 {
        match *self {
            Self::VertexSide {
                striker,
                target,
                side,
                shift,
            } => {
                let u = from_centre(positions, target, shift, place(network, positions, striker));
                let apothem = network.squares[target].half_diagonal * FRAC_1_SQRT_2;
                dot(u, side_normal(positions[3 * target + 2], side)) - apothem
            }
            Self::VertexVertex {
                striker,
                target,
                shift,
            } => {
                let u = from_centre(
                    positions,
                    target.square,
                    shift,
                    place(network, positions, striker),
                );
                let (rho, own) = (
                    arm(network, positions, target),
                    arm(network, positions, striker),
                );
                dot(minus(u, rho), unit(minus(rho, own)))
            }
            Self::RodCorner {
                striker,
                rod,
                left,
                shift,
            } => {
                let [a, b] = rod_ends(network, positions, rod);
                let u = unit(minus(b, a));
                let normal = if left { [-u[1], u[0]] } else { [u[1], -u[0]] };
                dot(
                    minus(minus(place(network, positions, striker), shift), a),
                    normal,
                )
            }
            Self::RodStop { rod, end, side } => {
                let ends = rod_ends(network, positions, rod);
                let (near, far) = if end == 0 {
                    (ends[0], ends[1])
                } else {
                    (ends[1], ends[0])
                };
                dot(
                    minus(far, near),
                    side_normal(positions[3 * self.rod_square(network, rod, end) + 2], side),
                )
            }
        }
    }

    fn rod_square(&self, network: &Network, rod: usize, end: u8) -> usize {
        let rod = network.rods[rod];
        if end == 0 {
            rod.from.square
        } else {
            rod.to.square
        }
    }

    /// n: the rate of the gap is n · v.
    pub fn row(&self, network: &Network, positions: &[f64]) -> Row {
        let mut row = Row::default();
        match *self {
            Self::VertexSide {
                striker,
                target,
                side,
                shift,
            } => {
                let normal = side_normal(positions[3 * target + 2], side);
                let u = from_centre(positions, target, shift, place(network, positions, striker));
                row.push(
                    striker.square,
                    1.0,
                    normal,
                    arm(network, positions, striker),
                );
                row.push(target, -1.0, normal, u);
            }
            Self::VertexVertex {
                striker, target, ..
            } => {
                let (rho, own) = (
                    arm(network, positions, target),
                    arm(network, positions, striker),
                );
                let normal = unit(minus(rho, own));
                row.push(striker.square, 1.0, normal, own);
                row.push(target.square, -1.0, normal, rho);
            }
            Self::RodCorner {
                striker,
                rod,
                left,
                shift,
            } => {
                let [a, b] = rod_ends(network, positions, rod);
                let along = minus(b, a);
                let u = unit(along);
                let normal = if left { [-u[1], u[0]] } else { [u[1], -u[0]] };
                let point = minus(place(network, positions, striker), shift);
                let share = dot(minus(point, a), along) / dot(along, along);
                let ends = network.rods[rod];
                row.push(
                    striker.square,
                    1.0,
                    normal,
                    arm(network, positions, striker),
                );
                row.push(
                    ends.from.square,
                    share - 1.0,
                    normal,
                    arm(network, positions, ends.from),
                );
                row.push(
                    ends.to.square,
                    -share,
                    normal,
                    arm(network, positions, ends.to),
                );
            }
            Self::RodStop { rod, end, side } => {
                let ends = network.rods[rod];
                let (near, far) = if end == 0 {
                    (ends.from, ends.to)
                } else {
                    (ends.to, ends.from)
                };
                let normal = side_normal(positions[3 * near.square + 2], side);
                // The far end on the line of the side: it touches the (prolonged) side where it is.
                let places = rod_ends(network, positions, rod);
                let along = if end == 0 {
                    minus(places[1], places[0])
                } else {
                    minus(places[0], places[1])
                };
                let own = arm(network, positions, near);
                row.push(far.square, 1.0, normal, arm(network, positions, far));
                row.push(
                    near.square,
                    -1.0,
                    normal,
                    [own[0] + along[0], own[1] + along[1]],
                );
            }
        }
        row
    }

    /// Whether two entries of a list describe the same touch: two corners head on, seen from
    /// either.
    pub fn is_same_touch(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::VertexVertex {
                    striker,
                    target,
                    shift,
                },
                Self::VertexVertex {
                    striker: of_other,
                    target: by_other,
                    shift: back,
                },
            ) => {
                let opposite = (shift[0] + back[0]).abs() + (shift[1] + back[1]).abs() < 1e-9;
                (striker == by_other && target == of_other && opposite)
                    || (striker == of_other && target == by_other && shift == back)
            }
            _ => self == other,
        }
    }
}

/// Leaves every touch in a list once.
pub fn without_repetitions(contacts: &[Contact]) -> Vec<Contact> {
    let mut kept: Vec<Contact> = Vec::with_capacity(contacts.len());
    for contact in contacts {
        if !kept.iter().any(|other| other.is_same_touch(contact)) {
            kept.push(*contact);
        }
    }
    kept
}
