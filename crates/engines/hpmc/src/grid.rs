//! Which bodies are near a place in a periodic box.
//!
//! Cells hold copies of the positions, in order of arrival, so that a look around reads memory in
//! long runs. They are equal parts of the box, as tilted as it is. A ball about a place meets no cell but the
//! nearest ones if its radius is at most the distance between opposite faces of a cell.

use protomer_kernel::periodic_box::PeriodicBox;

/// A body in a cell.
#[derive(Debug, Clone, Copy)]
struct Entry<const D: usize> {
    position: [f64; D],
    body: u32,
}

/// A body near a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near<const D: usize> {
    /// Number of the body.
    pub body: u32,
    /// Vector from the place to one of the images of the body.
    pub offset: [f64; D],
    /// The squared length of the offset.
    pub squared: f64,
}

/// Smallest number of cells along an edge, unless there is one and all images along it are looked
/// at.
const FEWEST: usize = 3;
/// Cells are wider than the range by what rounding could take from them.
const ROUNDED: f64 = 1.0 - 1e-12;
/// Room for bodies in a cell at first.
const ROOM: usize = 8;

/// Bodies sorted into cells whose opposite faces are at least a range apart.
#[derive(Debug, Clone)]
pub(crate) struct Grid<const D: usize> {
    space: PeriodicBox<D>,
    cells: [usize; D],
    cells_per_length: [f64; D],
    room: usize,
    filled: Vec<u32>,
    entries: Vec<Entry<D>>,
    /// Cell and place in it of each body.
    homes: Vec<(u32, u32)>,
}

impl<const D: usize> Grid<D> {
    /// Sorts bodies into cells for looks as far as a range.
    pub fn new(space: &PeriodicBox<D>, range: f64, positions: &[[f64; D]]) -> Self {
        // More cells than bodies would only be empty.
        let volume = space.volume();
        // About half a body per cell.
        let width = (volume / (2 * positions.len()).max(1) as f64).powf(1.0 / D as f64);
        let (lengths, heights) = (space.lengths(), space.heights());
        let mut cells = [1; D];
        for axis in 0..D {
            let most = (lengths[axis] / width).ceil();
            // By the heights, not the lengths: cells of a tilted box are thinner than their edges.
            let number = (heights[axis] / range * ROUNDED).floor().min(most) as usize;
            if number >= FEWEST {
                cells[axis] = number;
            }
        }
        let mut grid = Self {
            space: *space,
            cells,
            cells_per_length: std::array::from_fn(|axis| cells[axis] as f64 / lengths[axis]),
            // One cell holds everything: room for all from the start.
            room: if cells == [1; D] {
                positions.len()
            } else {
                ROOM
            },
            filled: Vec::new(),
            entries: Vec::new(),
            homes: Vec::new(),
        };
        grid.fill(positions);
        grid
    }

    fn fill(&mut self, positions: &[[f64; D]]) {
        let cells = self.cells.iter().product();
        // Until all bodies find room; a crowded cell doubles the room of all.
        loop {
            self.filled.clear();
            self.filled.resize(cells, 0);
            let empty = Entry {
                position: [0.0; D],
                body: 0,
            };
            self.entries.clear();
            self.entries.resize(cells * self.room, empty);
            self.homes.clear();
            let mut body = 0;
            while body < positions.len() {
                // Cells in a flat list, x fastest: cell · room is where their entries begin.
                let cell = self.cell(&positions[body]);
                if self.filled[cell] as usize == self.room {
                    break;
                }
                let home = self.put(cell, positions[body], body as u32);
                self.homes.push(home);
                body += 1;
            }
            if body == positions.len() {
                return;
            }
            self.room *= 2;
        }
    }

    fn put(&mut self, cell: usize, position: [f64; D], body: u32) -> (u32, u32) {
        let place = self.filled[cell];
        self.entries[cell * self.room + place as usize] = Entry { position, body };
        self.filled[cell] += 1;
        (cell as u32, place)
    }

    /// The place in a rectangular box that is sheared to this one.
    #[inline]
    fn straight(&self, place: &[f64; D]) -> [f64; D] {
        match self.space.is_rectangular() {
            true => *place,
            false => self.space.unsheared(place),
        }
    }

    fn coordinate(&self, axis: usize, straight: f64) -> usize {
        ((straight * self.cells_per_length[axis]) as usize).min(self.cells[axis] - 1)
    }

    fn cell(&self, position: &[f64; D]) -> usize {
        let straight = self.straight(position);
        let mut cell = 0;
        // From the last axis down: ((z) n_y + y) n_x + x.
        for axis in (0..D).rev() {
            cell = cell * self.cells[axis] + self.coordinate(axis, straight[axis]);
        }
        cell
    }

    /// Notes that a body has moved; all bodies are at `positions`.
    pub fn moved(&mut self, body: usize, positions: &[[f64; D]]) {
        let (old, place) = self.homes[body];
        let cell = self.cell(&positions[body]);
        let old = old as usize;
        if cell == old {
            self.entries[old * self.room + place as usize].position = positions[body];
            return;
        }
        // No room: the cells are made again, which is rare.
        if self.filled[cell] as usize == self.room {
            self.room *= 2;
            self.fill(positions);
            return;
        }
        // The last entry fills the gap, so entries of a cell stay together.
        self.filled[old] -= 1;
        let last = self.entries[old * self.room + self.filled[old] as usize];
        self.entries[old * self.room + place as usize] = last;
        self.homes[last.body as usize] = (old as u32, place);
        self.homes[body] = self.put(cell, positions[body], body as u32);
    }

    /// Calls `visit` with every image of every body but one within a squared range of a place,
    /// until it returns `true`, and returns whether it did.
    #[inline]
    pub fn any_near(
        &self,
        place: &[f64; D],
        squared_range: f64,
        but: u32,
        mut visit: impl FnMut(Near<D>) -> bool,
    ) -> bool {
        // One cell along an edge: the same cell would be
        // its own neighbour, and images need a search.
        if self.cells.contains(&1) {
            return self.any_image(place, squared_range, but, visit);
        }
        let (mut cells, mut times) = ([[0_usize; 3]; D], [[0.0; 3]; D]);
        let mut shifts = [[0.0; 3]; D];
        let straight = self.straight(place);
        let is_tilted = !self.space.is_rectangular();
        let mut stride = 1;
        for axis in 0..D {
            let n = self.cells[axis];
            let home = self.coordinate(axis, straight[axis]);
            // The cell below, at home and above, by steps that stay positive.
            for (number, step) in [n - 1, 0, 1].into_iter().enumerate() {
                let cell = home + step;
                let beyond = cell >= n;
                cells[axis][number] = stride * if beyond { cell - n } else { cell };
                let is_below = number == 0 && home == 0;
                let is_above = number == 2 && beyond;
                // Periodic images: an edge is subtracted below the box and added above it.
                times[axis][number] = f64::from(u8::from(is_above)) - f64::from(u8::from(is_below));
                // The place is subtracted here, once per cell and not once per body.
                shifts[axis][number] =
                    times[axis][number] * self.space.lengths()[axis] - place[axis];
            }
            stride *= n;
        }
        // All neighbours but those along x, which lie side by side in memory.
        let rows = 3_usize.pow(D as u32 - 1);
        for row in 0..rows {
            let (mut base, mut shift, mut quotient) = (0, [0.0; D], row);
            for axis in 1..D {
                base += cells[axis][quotient % 3];
                shift[axis] = shifts[axis][quotient % 3];
                quotient /= 3;
            }
            // Edges that were passed also overhang along earlier axes.
            if is_tilted {
                self.add_overhangs(&mut shift, &times, row);
            }
            let sideways = shift[0];
            for number in 0..3 {
                let cell = base + cells[0][number];
                shift[0] = sideways + shifts[0][number];
                let from = cell * self.room;
                let entries = &self.entries[from..from + self.filled[cell] as usize];
                // The innermost loop: a sum, a square and a comparison per body.
                for entry in entries {
                    let (mut offset, mut squared) = ([0.0; D], 0.0);
                    for axis in 0..D {
                        offset[axis] = entry.position[axis] + shift[axis];
                        squared += offset[axis] * offset[axis];
                    }
                    if squared < squared_range && entry.body != but {
                        let near = Near {
                            body: entry.body,
                            offset,
                            squared,
                        };
                        if visit(near) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }

    /// Adds what the edges, passed so many times, overhang along earlier axes, for one row of cells.
    fn add_overhangs(&self, shift: &mut [f64; D], times: &[[f64; 3]; D], row: usize) {
        let mut quotient = row;
        for (axis, times) in times.iter().enumerate().skip(1) {
            let edge = self.space.edge(axis);
            for (x, part) in shift.iter_mut().zip(edge).take(axis) {
                *x += times[quotient % 3] * part;
            }
            quotient /= 3;
        }
    }

    /// Variant of [`any_near`](Self::any_near) where an edge has one cell. In a small box a body
    /// has several images within the range.
    fn any_image(
        &self,
        place: &[f64; D],
        squared_range: f64,
        but: u32,
        mut visit: impl FnMut(Near<D>) -> bool,
    ) -> bool {
        let steps = self.cells.map(|cells| if cells == 1 { 1 } else { 3 });
        let range = squared_range.sqrt();
        let straight = self.straight(place);
        for number in 0..steps.iter().product() {
            let (mut cell, mut quotient, mut stride) = (0, number, 1);
            for axis in 0..D {
                let n = self.cells[axis];
                let home = self.coordinate(axis, straight[axis]);
                // Three cells along an edge that has several, all images along one that has one.
                cell += stride * ((home + n - 1 + quotient % steps[axis]) % n);
                quotient /= steps[axis];
                stride *= n;
            }
            let from = cell * self.room;
            for entry in &self.entries[from..from + self.filled[cell] as usize] {
                if entry.body == but {
                    continue;
                }
                let apart = std::array::from_fn(|axis| entry.position[axis] - place[axis]);
                let is_found = self.space.any_image_within(&apart, range, |offset| {
                    let squared = offset.iter().map(|x| x * x).sum();
                    squared < squared_range
                        && visit(Near {
                            body: entry.body,
                            offset,
                            squared,
                        })
                });
                if is_found {
                    return true;
                }
            }
        }
        false
    }
}
