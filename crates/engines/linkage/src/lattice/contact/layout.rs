//! Where corners, sides and rods are.

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

    /// Vector from the centre of a square (its image at `shift`) to a point.
    pub fn seen_from_centre(&self, square: usize, shift: Vector, point: Vector) -> Vector {
        minus(minus(point, shift), self.centre(square))
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
            plus(self.place(ends.to), rod_shift(self.network, rod)),
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

/// Vector from the square at the second end of a rod to the periodic image at which the rod ends.
pub(crate) fn rod_shift(network: &Network, rod: usize) -> Vector {
    let cell = network.cell.unwrap_or([0.0; 2]);
    let image = network.rods[rod].image;
    [f64::from(image[0]) * cell[0], f64::from(image[1]) * cell[1]]
}

/// The two sides that meet at a corner.
pub(crate) fn sides_at(corner: Corner) -> [u8; 2] {
    let [x, y] = corner.direction();
    [if x > 0.0 { 0 } else { 2 }, if y > 0.0 { 1 } else { 3 }]
}
