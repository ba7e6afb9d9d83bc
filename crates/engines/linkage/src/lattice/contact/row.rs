//! How fast a gap opens.

use crate::lattice::cell::cell_gradient;
use crate::lattice::network::Network;
use crate::plane::{Vector, cross};

/// n, the rate of a gap per velocity of up to three squares and of a flexible cell: ġ = n · v.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Row {
    /// The squares, and the cell as the body after the last one.
    bodies: [usize; 4],
    entries: [[f64; 3]; 4],
    count: usize,
}

impl Row {
    /// Two squares pushed apart along a normal that leads from the second to the first, at these
    /// arms.
    pub(crate) fn along([first, second]: [usize; 2], normal: Vector, arms: [Vector; 2]) -> Self {
        let mut row = Self::default();
        row.push(first, 1.0, normal, arms[0]);
        row.push(second, -1.0, normal, arms[1]);
        row
    }

    /// Adds a share of a force along `normal` at `arm` from the centre of a square.
    pub(crate) fn push(&mut self, square: usize, weight: f64, normal: Vector, arm: Vector) {
        let torque = cross(arm, normal);
        let entry = [weight * normal[0], weight * normal[1], weight * torque];
        self.add(square, entry);
    }

    /// Adds a force along `normal` on the image H n of a body, as it moves a flexible cell.
    pub(crate) fn push_image(&mut self, network: &Network, normal: Vector, image: Vector) {
        if network.cell_mass.is_some() && image != [0.0; 2] {
            self.add(network.squares.len(), cell_gradient(normal, image));
        }
    }

    fn add(&mut self, body: usize, entry: [f64; 3]) {
        let bodies = &self.bodies[..self.count];
        // A square may meet its own periodic image.
        if let Some(place) = bodies.iter().position(|other| *other == body) {
            for (sum, x) in self.entries[place].iter_mut().zip(entry) {
                *sum += x;
            }
        } else if self.count < self.bodies.len() {
            self.bodies[self.count] = body;
            self.entries[self.count] = entry;
            self.count += 1;
        }
    }

    /// The squares and their numbers (along x, y and θ), and the cell (xx, yy and xy) as the body
    /// after the last square.
    pub fn entries(&self) -> impl Iterator<Item = (usize, &[f64; 3])> {
        let bodies = self.bodies.iter().copied();
        bodies.zip(&self.entries).take(self.count)
    }

    /// n · x for a vector over the coordinates.
    pub fn dot(&self, x: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (p, n) in self.entries() {
            sum += n[0] * x[3 * p] + n[1] * x[3 * p + 1] + n[2] * x[3 * p + 2];
        }
        sum
    }
}
