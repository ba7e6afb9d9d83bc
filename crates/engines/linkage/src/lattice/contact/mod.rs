//! Who touches whom, and how.
//!
//! | module | one idea |
//! |---|---|
//! | [`separation`] | how far apart two rectangles are: squares, and rods as rectangles without width |
//! | [`candidates`] | which pairs are near enough to be looked at |
//! | [`row`] | how fast a gap opens |
//! | `layout` | where corners, sides and rods are |
//! | `grid` | points sorted into cells |
//!
//! A [`Contact`] is a point at which two bodies touch and a direction in which they may only move
//! apart. Its gap is a function of the positions, and the rate of the gap is linear in the
//! velocities of the squares: ġ = n · v with the [`Row`] n.

pub mod candidates;
mod grid;
pub(crate) mod layout;
pub mod row;
pub mod separation;

use super::network::{Corner, Network};
use crate::plane::{Vector, dot, left_of, minus, norm, plus, unit};
use layout::Layout;
pub use row::Row;
use std::f64::consts::FRAC_1_SQRT_2;

/// Bodies nearer than this touch.
pub const TOUCHING: f64 = 1e-9;
/// Corners nearer than this many half-diagonals meet head on.
const HEAD_ON: f64 = 10.0 * TOUCHING;

/// A contact of two bodies.
///
/// ```
/// use protomer_linkage::lattice::{Contact, Corner, Edges, Network, Square, State};
/// // Two closed squares side by side, brought together along x.
/// let network = Network::lattice(1, 2, 0.5, Square::default(), Edges::Open, 0.0)?;
/// let mut positions = State::coherent(&network, 0.0).positions;
/// positions[0] += 0.5;
/// let upper_right = Corner { square: 0, vertex: 2 };
/// let contact = Contact::of_corner(&network, &positions, upper_right, 1, [0, 0]);
/// assert!(contact.gap(&network, &positions).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
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
        /// The periodic image of the target that is struck, in cells along x and y.
        image: [i32; 2],
    },
    /// Two corners head on. The normal is the bisector ρ_target - ρ_striker.
    VertexVertex {
        /// One corner.
        striker: Corner,
        /// The other corner.
        target: Corner,
        /// The periodic image of the target that is struck, in cells along x and y.
        image: [i32; 2],
    },
    /// A corner of a square on a rod. The rod has no mass: it passes the impulse on to its two
    /// ends, split by the lever.
    RodCorner {
        /// The corner.
        striker: Corner,
        /// The rod.
        rod: usize,
        /// Whether the corner is on the left of the rod (seen along it) or on its right.
        left: bool,
        /// The periodic image of the rod that is struck.
        image: [i32; 2],
    },
    /// A rod flat along a side of the square on which it hangs: 135° from the diagonal.
    RodStop {
        /// The rod.
        rod: usize,
        /// The end that hangs on the square: 0 is `from`, 1 is `to`.
        end: u8,
        /// The side, as for `VertexSide`.
        side: u8,
    },
}

impl Contact {
    /// The touch of the corner `striker` and the square `target` (this image of it): on a corner
    /// of the target where it is at one, else on the nearest side.
    pub fn of_corner(
        network: &Network,
        positions: &[f64],
        striker: Corner,
        target: usize,
        image: [i32; 2],
    ) -> Self {
        let layout = Layout::new(network, positions);
        let from_target = layout.seen_from_centre(target, image, layout.place(striker));
        let half_diagonal = network.squares[target].half_diagonal;
        // A corner at a corner has no side: the bisector is its normal.
        for vertex in 1..=4 {
            let corner = Corner {
                square: target,
                vertex,
            };
            let away = minus(from_target, layout.arm(corner));
            if norm(away) <= HEAD_ON * half_diagonal {
                return Self::VertexVertex {
                    striker,
                    target: corner,
                    image,
                };
            }
        }
        Self::VertexSide {
            striker,
            target,
            side: nearest_side(&layout, target, from_target),
            image,
        }
    }

    /// Distance along the normal: positive apart, negative overlapping.
    pub fn gap(&self, network: &Network, positions: &[f64]) -> f64 {
        let layout = Layout::new(network, positions);
        match *self {
            Self::VertexSide {
                striker,
                target,
                side,
                image,
            } => {
                let from_target = layout.seen_from_centre(target, image, layout.place(striker));
                let apothem = network.squares[target].half_diagonal * FRAC_1_SQRT_2;
                // Half the side: the distance of a side from the centre.
                dot(from_target, layout.side_normal(target, side)) - apothem
            }
            Self::VertexVertex {
                striker,
                target,
                image,
            } => {
                let place = layout.place(striker);
                let from_target = layout.seen_from_centre(target.square, image, place);
                let (rho, striker_arm) = (layout.arm(target), layout.arm(striker));
                dot(minus(from_target, rho), unit(minus(rho, striker_arm)))
            }
            Self::RodCorner {
                striker,
                rod,
                left,
                image,
            } => {
                let [begin, end] = layout.rod_ends(rod);
                let from_begin = minus(minus(layout.place(striker), layout.shift(image)), begin);
                dot(from_begin, rod_normal(minus(end, begin), left))
            }
            Self::RodStop { rod, end, side } => {
                let near = network.rods[rod].corner_at(end);
                dot(
                    layout.along_rod(rod, end),
                    layout.side_normal(near.square, side),
                )
            }
        }
    }

    /// Row n of the contact: the rate of the gap is n · v.
    pub fn row(&self, network: &Network, positions: &[f64]) -> Row {
        let layout = Layout::new(network, positions);
        match *self {
            Self::VertexSide {
                striker,
                target,
                side,
                image,
            } => {
                let normal = layout.side_normal(target, side);
                let from_target = layout.seen_from_centre(target, image, layout.place(striker));
                let arms = [layout.arm(striker), from_target];
                let mut row = Row::along([striker.square, target], normal, arms);
                row.push_image(network, normal, opposite(image));
                row
            }
            Self::VertexVertex {
                striker,
                target,
                image,
            } => {
                let (rho, striker_arm) = (layout.arm(target), layout.arm(striker));
                let normal = unit(minus(rho, striker_arm));
                let squares = [striker.square, target.square];
                let mut row = Row::along(squares, normal, [striker_arm, rho]);
                row.push_image(network, normal, opposite(image));
                row
            }
            Self::RodCorner {
                striker,
                rod,
                left,
                image,
            } => rod_corner_row(&layout, striker, rod, left, image),
            Self::RodStop { rod, end, side } => rod_stop_row(&layout, rod, end, side),
        }
    }

    /// Whether two entries of a list describe the same touch: two corners head on, seen from either
    /// side.
    pub fn is_same_touch(&self, other: &Self) -> bool {
        let (
            Self::VertexVertex {
                striker,
                target,
                image,
            },
            Self::VertexVertex {
                striker: of_other,
                target: by_other,
                image: back,
            },
        ) = (self, other)
        else {
            return self == other;
        };
        let are_opposite = *image == back.map(|cells| -cells);
        let seen_from_either = striker == by_other && target == of_other && are_opposite;
        let the_same = striker == of_other && target == by_other && image == back;
        seen_from_either || the_same
    }
}

fn nearest_side(layout: &Layout, square: usize, from_centre: Vector) -> u8 {
    let (mut nearest, mut highest) = (0, f64::NEG_INFINITY);
    for side in 0..4 {
        let height = dot(from_centre, layout.side_normal(square, side));
        if height > highest {
            (nearest, highest) = (side, height);
        }
    }
    nearest
}

/// The unit normal of a rod on its left or right, seen along it.
fn rod_normal(rod_vector: Vector, left: bool) -> Vector {
    let u = unit(rod_vector);
    if left { left_of(u) } else { [u[1], -u[0]] }
}

/// The impulse on a rod goes to its ends in the shares of the lever rule.
fn rod_corner_row(
    layout: &Layout,
    striker: Corner,
    rod: usize,
    left: bool,
    image: [i32; 2],
) -> Row {
    let [begin, end] = layout.rod_ends(rod);
    let rod_vector = minus(end, begin);
    let normal = rod_normal(rod_vector, left);
    let point = minus(layout.place(striker), layout.shift(image));
    // The lever rule: where along the rod the corner pushes.
    let share = dot(minus(point, begin), rod_vector) / dot(rod_vector, rod_vector);
    let ends = layout.network.rods[rod];
    let mut row = Row::default();
    row.push(striker.square, 1.0, normal, layout.arm(striker));
    row.push(ends.from.square, share - 1.0, normal, layout.arm(ends.from));
    row.push(ends.to.square, -share, normal, layout.arm(ends.to));
    // The rod's own image pulls by the lever, too.
    let [right, up] = [0, 1].map(|axis| {
        let [rod_image, end_image] = [image[axis], ends.image[axis]].map(f64::from);
        -rod_image - share * end_image
    });
    row.push_image(layout.network, normal, [right, up]);
    row
}

/// The far end of the rod touches the (prolonged) side where it is.
fn rod_stop_row(layout: &Layout, rod: usize, end: u8, side: u8) -> Row {
    let ends = layout.network.rods[rod];
    let (near, far) = (ends.corner_at(end), ends.corner_at(1 - end));
    let normal = layout.side_normal(near.square, side);
    let far_from_near = plus(layout.arm(near), layout.along_rod(rod, end));
    let mut row = Row::along(
        [far.square, near.square],
        normal,
        [layout.arm(far), far_from_near],
    );
    let image = if end == 0 {
        ends.image.map(f64::from)
    } else {
        opposite(ends.image)
    };
    row.push_image(layout.network, normal, image);
    row
}

/// -n.
fn opposite(image: [i32; 2]) -> Vector {
    image.map(|cells| f64::from(-cells))
}

/// Leaves every touch in a list once.
pub fn without_repetitions(contacts: &[Contact]) -> Vec<Contact> {
    let mut distinct_contacts: Vec<Contact> = Vec::with_capacity(contacts.len());
    for contact in contacts {
        if !distinct_contacts
            .iter()
            .any(|other| other.is_same_touch(contact))
        {
            distinct_contacts.push(*contact);
        }
    }
    distinct_contacts
}
