//! Where corners, sides and rods are.

use crate::lattice::cell::Cell;
use crate::lattice::network::{Corner, Network};
use crate::plane::{Vector, direction, left_of, minus, plus, turned};

/// A network at some positions.
#[derive(Clone, Copy)]
pub(crate) struct Layout<'a> {
    pub network: &'a Network,
    /// x, y, θ of square after square.
    pub positions: &'a [f64],
}

impl<'a> Layout<'a> {
    pub fn new(network: &'a Network, positions: &'a [f64]) -> Self {
        Self { network, positions }
    }

    pub fn centre(&self, square: usize) -> Vector {
        [self.positions[3 * square], self.positions[3 * square + 1]]
    }

    /// Vector ρ from the centre of a square to its corner.
    pub fn arm(&self, corner: Corner) -> Vector {
        let half_diagonal = self.network.squares[corner.square].half_diagonal;
        let at_rest = corner.direction().map(|x| x * half_diagonal);
        turned(at_rest, direction(self.positions[3 * corner.square + 2]))
    }

    pub fn place(&self, corner: Corner) -> Vector {
        plus(self.centre(corner.square), self.arm(corner))
    }

    /// Vector from a body to its image of this number.
    pub fn shift(&self, image: [i32; 2]) -> Vector {
        Cell::read(self.network, self.positions).shift(image.map(f64::from))
    }

    /// Vector from the centre of an image of a square to a point.
    pub fn seen_from_centre(&self, square: usize, image: [i32; 2], point: Vector) -> Vector {
        minus(minus(point, self.shift(image)), self.centre(square))
    }

    /// The outward normal of a side, 0 to 3: at θ + 0°, 90°, 180°, 270°.
    pub fn side_normal(&self, square: usize, side: u8) -> Vector {
        let axis = direction(self.positions[3 * square + 2]);
        let [cosine, sine] = axis;
        match side % 4 {
            0 => axis,
            1 => left_of(axis),
            2 => [-cosine, -sine],
            _ => [sine, -cosine],
        }
    }

    /// The two ends of a rod, the second as the image to which the rod leads.
    pub fn rod_ends(&self, rod: usize) -> [Vector; 2] {
        let ends = self.network.rods[rod];
        [
            self.place(ends.from),
            plus(self.place(ends.to), self.shift(ends.image)),
        ]
    }

    /// Vector from the end of a rod that hangs on a square (0 is `from`, 1 is `to`) to its other
    /// end.
    pub fn along_rod(&self, rod: usize, end: u8) -> Vector {
        let [from, to] = self.rod_ends(rod);
        if end == 0 {
            minus(to, from)
        } else {
            minus(from, to)
        }
    }
}

/// The two sides that meet at a corner.
pub(crate) fn sides_at(corner: Corner) -> [u8; 2] {
    let [x, y] = corner.direction();
    [if x > 0.0 { 0 } else { 2 }, if y > 0.0 { 1 } else { 3 }]
}
