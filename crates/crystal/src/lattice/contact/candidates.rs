//! Which pairs are near enough to be looked at.
//!
//! A list of all pairs whose circumscribed circles are within a skin of each other, made with a
//! grid over the centres and used until a centre has moved by half the skin. In a periodic cell
//! every image that is near enough is a pair of its own.

use super::separation::{Rectangle, at_rest};
use crate::lattice::network::Network;

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
    /// What it could meet: a square of a higher index (or its own image), or a rod that does not
    /// hang on it.
    pub second: Body,
    /// From the second to the image of it that is meant.
    pub shift: [f64; 2],
}

/// All pairs within reach.
#[derive(Debug, Clone)]
pub struct Candidates {
    skin: f64,
    with_rods: bool,
    pairs: Vec<Pair>,
    /// Centres of squares when the list was made.
    reference: Vec<f64>,
    middles: Vec<[f64; 2]>,
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
            rebuilds: 0,
        };
        list.rebuild(network, positions);
        list
    }

    /// The pairs, in order of the squares.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// How often the list was made.
    pub fn rebuilds(&self) -> u64 {
        self.rebuilds
    }

    /// Whether the list still holds where every centre is within `margin` of these positions.
    pub fn holds(&self, positions: &[f64], margin: f64) -> bool {
        let allowed = 0.5 * self.skin - margin;
        // A rod's middle moves at most as its ends, and those also by the turning of the squares:
        // rods ask for the chord.
        let turning = if self.with_rods { 1.0 } else { 0.0 };
        allowed > 0.0
            && positions
                .chunks_exact(3)
                .zip(self.reference.chunks_exact(3))
                .all(|(s, r)| {
                    let (x, y) = (s[0] - r[0], s[1] - r[1]);
                    let moved = (x * x + y * y).sqrt() + turning * (s[2] - r[2]).abs().min(2.0);
                    moved <= allowed
                })
    }

    /// Width of the skin from the next list on.
    pub fn set_skin(&mut self, skin: f64) {
        self.skin = skin;
    }

    /// Makes the list anew.
    pub fn rebuild(&mut self, network: &Network, positions: &[f64]) {
        self.rebuilds += 1;
        self.reference.clear();
        self.reference.extend_from_slice(positions);
        self.pairs.clear();
        self.middles.clear();
        let mut radii: Vec<f64> = Vec::with_capacity(network.squares.len() + network.rods.len());
        for (square, s) in network.squares.iter().zip(positions.chunks_exact(3)) {
            self.middles.push([s[0], s[1]]);
            radii.push(square.half_diagonal);
        }
        if self.with_rods {
            for (index, rod) in network.rods.iter().enumerate() {
                self.middles
                    .push(Rectangle::rod(network, index, at_rest(positions)).centre);
                radii.push(0.5 * rod.length);
            }
        }
        let squares = network.squares.len();
        let largest = radii[..squares]
            .iter()
            .fold(0.0_f64, |largest, x| largest.max(*x));
        let other = radii.iter().fold(0.0_f64, |largest, x| largest.max(*x));
        let reach = largest + other + self.skin;
        let grid = Grid::new(&self.middles, reach, network.cell);
        let mut found: Vec<Pair> = Vec::new();
        let mut near: Vec<(usize, [f64; 2])> = Vec::new();
        for (p, place) in self.middles[..squares].iter().enumerate() {
            found.clear();
            grid.near(&self.middles, *place, reach, &mut near);
            for (q, shift) in &near {
                let (q, shift) = (*q, *shift);
                let middle = self.middles[q];
                let (x, y) = (
                    middle[0] + shift[0] - place[0],
                    middle[1] + shift[1] - place[1],
                );
                let within = radii[p] + radii[q] + self.skin;
                if x * x + y * y > within * within {
                    continue;
                }
                if q < squares {
                    // Every pair once; of a square and its images, one of each two opposite ones.
                    if q > p || (q == p && shift > [0.0, 0.0]) {
                        found.push(Pair {
                            first: p,
                            second: Body::Square(q),
                            shift,
                        });
                    }
                } else if !hangs_on(network, q - squares, p, shift) {
                    found.push(Pair {
                        first: p,
                        second: Body::Rod(q - squares),
                        shift,
                    });
                }
            }
            found.sort_by(|a, b| {
                a.second
                    .cmp(&b.second)
                    .then(a.shift[0].total_cmp(&b.shift[0]))
                    .then(a.shift[1].total_cmp(&b.shift[1]))
            });
            self.pairs.extend_from_slice(&found);
        }
    }
}

/// Whether the image of a rod at this shift ends at a corner of this square.
pub(crate) fn hangs_on(network: &Network, rod: usize, square: usize, shift: [f64; 2]) -> bool {
    let ends = network.rods[rod];
    let image = super::rod_shift(network, rod);
    let near = |shift: [f64; 2]| shift[0].abs() + shift[1].abs() < 1e-9;
    (ends.from.square == square && near(shift))
        || (ends.to.square == square && near([shift[0] + image[0], shift[1] + image[1]]))
}

/// Points sorted into cells at least as wide as the reach.
struct Grid {
    low: [f64; 2],
    counts: [usize; 2],
    width: [f64; 2],
    periodic: Option<[f64; 2]>,
    /// First point of every cell, and the points cell by cell.
    starts: Vec<usize>,
    points: Vec<usize>,
}

impl Grid {
    fn new(places: &[[f64; 2]], reach: f64, periodic: Option<[f64; 2]>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in places {
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        let extent = |axis: usize| {
            periodic
                .map_or(high[axis] - low[axis], |cell| cell[axis])
                .max(1e-9)
        };
        // Squares that have flown far apart must not ask for more cells than there are points.
        let most = 2.0 * (places.len() as f64).sqrt().ceil() + 1.0;
        let count = |axis: usize| (extent(axis) / reach).floor().clamp(1.0, most) as usize;
        let counts = [count(0), count(1)];
        let width = [extent(0) / counts[0] as f64, extent(1) / counts[1] as f64];
        let mut grid = Self {
            low,
            counts,
            width,
            periodic,
            starts: Vec::new(),
            points: vec![0; places.len()],
        };
        let cells: Vec<usize> = places.iter().map(|place| grid.cell(*place)).collect();
        let mut starts = vec![0; counts[0] * counts[1] + 1];
        for cell in &cells {
            starts[cell + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        for (point, cell) in cells.iter().enumerate() {
            grid.points[next[*cell]] = point;
            next[*cell] += 1;
        }
        grid.starts = starts;
        grid
    }

    fn column(&self, place: f64, axis: usize) -> usize {
        let at = ((place - self.low[axis]) / self.width[axis]).floor();
        if self.periodic.is_some() {
            at.rem_euclid(self.counts[axis] as f64) as usize % self.counts[axis]
        } else {
            at.clamp(0.0, (self.counts[axis] - 1) as f64) as usize
        }
    }

    fn cell(&self, place: [f64; 2]) -> usize {
        self.column(place[1], 1) * self.counts[0] + self.column(place[0], 0)
    }

    /// Points, with the shifts of their images, that may be within reach of a place.
    fn near(
        &self,
        places: &[[f64; 2]],
        place: [f64; 2],
        reach: f64,
        out: &mut Vec<(usize, [f64; 2])>,
    ) {
        out.clear();
        let columns = |axis: usize| {
            let count = self.counts[axis] as isize;
            let middle = self.column(place[axis], axis) as isize;
            if self.periodic.is_some() {
                if count < 3 {
                    return (0..count).collect::<Vec<isize>>();
                }
                (middle - 1..=middle + 1)
                    .map(|at| at.rem_euclid(count))
                    .collect()
            } else {
                ((middle - 1).max(0)..=(middle + 1).min(count - 1)).collect()
            }
        };
        let across = columns(0);
        for row in columns(1) {
            for column in &across {
                let cell = (row * self.counts[0] as isize + column) as usize;
                for point in &self.points[self.starts[cell]..self.starts[cell + 1]] {
                    match self.periodic {
                        None => out.push((*point, [0.0; 2])),
                        Some(edges) => {
                            let images = |axis: usize| {
                                let away = places[*point][axis] - place[axis];
                                let low = ((-reach - away) / edges[axis]).ceil() as i64;
                                let high = ((reach - away) / edges[axis]).floor() as i64;
                                (low..=high).map(move |image| image as f64 * edges[axis])
                            };
                            for x in images(0) {
                                for y in images(1) {
                                    out.push((*point, [x, y]));
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
