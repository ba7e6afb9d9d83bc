//! Which pairs are near enough to be looked at.
//!
//! A list of all pairs whose circumscribed circles are within a skin of each other, made with a
//! grid over the centres and used until a centre has moved by half the skin. In a periodic cell
//! every image that is near enough is a separate pair.

use super::grid::{Grid, Image};
use super::separation::{Rectangle, at_rest};
use crate::lattice::cell::Cell;
use crate::lattice::network::Network;
use crate::plane::{Vector, dot, minus, plus};
use std::cmp::Ordering;

/// A square or a rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Body {
    /// A square by its index.
    Square(usize),
    /// A rod by its index.
    Rod(usize),
}

/// Two bodies that could meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// A square.
    pub first: usize,
    /// Body that the square could meet: a square of a higher index (or its own image), or a rod
    /// that does not hang on it.
    pub second: Body,
    /// The image of the second body that is meant, in cells along x and y.
    pub image: [i32; 2],
}

/// All pairs within reach.
#[derive(Debug, Clone)]
pub struct Candidates {
    skin: f64,
    with_rods: bool,
    pairs: Vec<Pair>,
    /// Centres of squares when the list was made.
    reference: Vec<f64>,
    /// Centres and radii of squares, then of rods.
    middles: Vec<Vector>,
    radii: Vec<f64>,
    /// The cell when the list was made.
    cell: Cell,
    /// Images within reach, in cells along x and y, or more.
    farthest_image: Vector,
    /// Images of the pairs and of the ends of rods in a flexible cell, at most, in cells along x and y.
    listed_images: Vector,
    rebuilds: u64,
}

impl Candidates {
    /// The pairs at these positions, rods included if wanted.
    pub fn new(network: &Network, positions: &[f64], skin: f64, with_rods: bool) -> Self {
        let mut list = Self {
            skin,
            with_rods,
            pairs: Vec::new(),
            reference: Vec::new(),
            middles: Vec::new(),
            radii: Vec::new(),
            cell: Cell::default(),
            farthest_image: [0.0; 2],
            listed_images: [0.0; 2],
            rebuilds: 0,
        };
        list.rebuild(network, positions);
        list
    }

    /// The pairs, in order of the squares.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Largest distance, in cells along x and y, of an image of a pair or of the end of a rod.
    /// Zero where the cell is fixed.
    pub(crate) fn listed_images(&self) -> Vector {
        self.listed_images
    }

    /// Number of times the list was made.
    pub fn rebuilds(&self) -> u64 {
        self.rebuilds
    }

    /// Whether the list still holds where every centre is within `margin` of these positions.
    pub fn holds(&self, network: &Network, positions: &[f64], margin: f64) -> bool {
        // Bodies may each move by half the skin, less what they will move in the step. An image
        // moves with the cell as well, and so does the end of a rod.
        let strained = match network.cell_mass {
            Some(_) => {
                let cell = Cell::read(network, positions);
                cell.largest_shift_since(&self.cell, self.farthest_image)
            }
            None => 0.0,
        };
        let allowed = 0.5 * self.skin - margin - strained;
        if allowed.is_nan() || allowed <= 0.0 {
            return false;
        }
        // A rod's middle moves at most as its ends, and those also by the turning of the squares,
        // by the chord.
        let turning = if self.with_rods { 1.0 } else { 0.0 };
        let moving = positions
            .chunks_exact(3)
            .zip(self.reference.chunks_exact(3))
            .take(network.squares.len());
        for (s, r) in moving {
            let away = [s[0] - r[0], s[1] - r[1]];
            // A turn by θ moves a corner by 2 sin(θ/2) ≤ min(θ, 2) half-diagonals.
            let displacement = dot(away, away).sqrt() + turning * (s[2] - r[2]).abs().min(2.0);
            if displacement.is_nan() || displacement > allowed {
                return false;
            }
        }
        true
    }

    /// Width of the skin from the next list on.
    pub fn set_skin(&mut self, skin: f64) {
        self.skin = skin;
    }

    /// Makes the list again.
    pub fn rebuild(&mut self, network: &Network, positions: &[f64]) {
        self.rebuilds += 1;
        self.reference.clear();
        self.reference.extend_from_slice(positions);
        self.measure_bodies(network, positions);
        let squares = network.squares.len();
        let largest = largest_of(&self.radii[..squares]) + largest_of(&self.radii);
        let reach = largest + self.skin;
        self.cell = Cell::read(network, positions);
        self.farthest_image = self.farthest_image_within(reach);
        let cell = network.cell.map(|_| self.cell);
        let grid = Grid::new(&self.middles, reach, cell);
        let (mut near, mut pairs) = (Vec::new(), Vec::new());
        self.pairs.clear();
        for first in 0..squares {
            grid.near(self.middles[first], &mut near);
            pairs.clear();
            for image in &near {
                // Sorted per square: the list does not depend on the grid.
                pairs.extend(self.pair(network, first, *image));
            }
            pairs.sort_by(in_order);
            self.pairs.extend_from_slice(&pairs);
        }
        self.listed_images = self.farthest_listed_image(network);
    }

    fn farthest_listed_image(&self, network: &Network) -> Vector {
        let mut farthest = [0_i32; 2];
        if network.cell_mass.is_none() {
            return [0.0; 2];
        }
        let rods = network.rods.iter().map(|rod| rod.image);
        for image in rods.chain(self.pairs.iter().map(|pair| pair.image)) {
            for (farthest, cells) in farthest.iter_mut().zip(image) {
                *farthest = (*farthest).max(cells.abs());
            }
        }
        farthest.map(f64::from)
    }

    /// Bound of the distance, in cells, of an image within reach: the extent of all bodies and one
    /// more cell.
    fn farthest_image_within(&self, reach: f64) -> Vector {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for middle in &self.middles {
            for axis in 0..2 {
                low[axis] = low[axis].min(middle[axis]);
                high[axis] = high[axis].max(middle[axis]);
            }
        }
        let up = 1.0 + (high[1] - low[1] + reach) / self.cell.yy;
        let leaning = up * self.cell.xy.abs();
        let right = 1.0 + (high[0] - low[0] + reach + leaning) / self.cell.xx;
        [right, up]
    }

    /// Centre and circumscribed radius of every body.
    fn measure_bodies(&mut self, network: &Network, positions: &[f64]) {
        self.middles.clear();
        self.radii.clear();
        for (square, s) in network.squares.iter().zip(positions.chunks_exact(3)) {
            self.middles.push([s[0], s[1]]);
            self.radii.push(square.half_diagonal);
        }
        if self.with_rods {
            for (index, rod) in network.rods.iter().enumerate() {
                let body = Rectangle::rod(network, index, at_rest(positions));
                self.middles.push(body.centre);
                self.radii.push(0.5 * rod.length);
            }
        }
    }

    /// The pair of a square and the image of another body, if they are near and the list should
    /// have it.
    fn pair(&self, network: &Network, first: usize, (body, image): Image) -> Option<Pair> {
        let shift = self.cell.shift(image.map(f64::from));
        let away = minus(plus(self.middles[body], shift), self.middles[first]);
        let within = self.radii[first] + self.radii[body] + self.skin;
        if dot(away, away) > within * within {
            return None;
        }
        let squares = network.squares.len();
        let (second, is_listed) = if body < squares {
            // Every pair once; of a square and its images, one of each two opposite ones.
            let once = body > first || (body == first && image > [0, 0]);
            (Body::Square(body), once)
        } else {
            let rod = body - squares;
            (Body::Rod(rod), !hangs_on(network, rod, first, image))
        };
        is_listed.then_some(Pair {
            first,
            second,
            image,
        })
    }
}

fn largest_of(radii: &[f64]) -> f64 {
    radii.iter().copied().fold(0.0, f64::max)
}

fn in_order(a: &Pair, b: &Pair) -> Ordering {
    (a.second, a.image).cmp(&(b.second, b.image))
}

/// Whether this image of a rod ends at a corner of this square.
fn hangs_on(network: &Network, rod: usize, square: usize, image: [i32; 2]) -> bool {
    let ends = network.rods[rod];
    let end_image = [image[0] + ends.image[0], image[1] + ends.image[1]];
    (ends.from.square == square && image == [0, 0])
        || (ends.to.square == square && end_image == [0, 0])
}
