//! Neighbour finding: which bodies are near a point.

use crate::{Boundary, KernelError, Result, Vec3};
use rustc_hash::FxHashMap;

/// Number of bodies up to which looking at all of them is cheaper than any grid.
const ALL_PAIRS_UP_TO: usize = 64;

/// Smallest number of cells along an edge: with fewer, a cell would be the neighbour of its own
/// neighbour.
const FEWEST_CELLS: f64 = 4.0;

/// Checks that every interaction of this range involves at most one image of a body.
///
/// ```
/// use protomer_kernel::{Boundary, Vec3, cells::require_minimum_image};
/// let space = Boundary::periodic(Vec3::repeat(100.0))?;
/// assert!(require_minimum_image(&space, 50.0).is_ok());
/// assert!(require_minimum_image(&space, 51.0).is_err());
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
///
/// # Errors
/// [`KernelError::BoxTooSmall`] when the range exceeds half of the smallest box length.
pub fn require_minimum_image(boundary: &Boundary, range_angstrom: f64) -> Result<()> {
    let smallest_length_angstrom = boundary.smallest_length_angstrom();
    let unbounded = smallest_length_angstrom == f64::INFINITY;
    if unbounded || 2.0 * range_angstrom <= smallest_length_angstrom {
        return Ok(());
    }
    Err(KernelError::BoxTooSmall {
        range_angstrom,
        smallest_length_angstrom,
    })
}

/// Points sorted into cells at least as wide as the range of interest, so that everything in range
/// of a place lies in the 27 cells around it. For small systems, small boxes and infinite ranges
/// every point is a candidate.
///
/// ```
/// use protomer_kernel::{Boundary, Vec3, cells::CellList};
/// let space = Boundary::periodic(Vec3::repeat(100.0))?;
/// let places: Vec<Vec3> = (0..100).map(|i| Vec3::new(f64::from(i) - 50.0, 0.0, 0.0)).collect();
/// let cells = CellList::new(&space, 5.0, &places);
/// let mut near = Vec::new();
/// cells.candidates(&Vec3::new(-50.0, 0.0, 0.0), &mut near);
/// assert!(near.contains(&99) && near.contains(&5) && !near.contains(&50));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct CellList {
    count: usize,
    grid: Option<Grid>,
}

#[derive(Debug, Clone)]
struct Grid {
    boundary: Boundary,
    cell_lengths: Vec3,
    /// Cells along each edge of a periodic box; `None` for unbounded space.
    cells_per_edge: Option<[i64; 3]>,
    members: FxHashMap<[i64; 3], Vec<u32>>,
}

impl CellList {
    /// Sorts the positions (Å) into cells for this range (Å). Whether a body meets several images
    /// of another is the caller's business ([`require_minimum_image`]).
    pub fn new(boundary: &Boundary, range_angstrom: f64, positions: &[Vec3]) -> Self {
        let mut list = Self {
            count: positions.len(),
            grid: None,
        };
        if positions.len() > ALL_PAIRS_UP_TO
            && let Some(mut grid) = Grid::new(boundary, range_angstrom)
        {
            for (index, position) in positions.iter().enumerate() {
                grid.insert(index, position);
            }
            list.grid = Some(grid);
        }
        list
    }

    /// Writes the indices of every point that may lie in range of `position` into `candidates`,
    /// ascending. They do not depend on the history of moves.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3, cells::CellList};
    /// let places: Vec<Vec3> = (0..100).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
    /// let cells = CellList::new(&Boundary::Open, 5.0, &places);
    /// let mut near = vec![7; 3];
    /// cells.candidates(&places[50], &mut near);
    /// assert!(near.is_sorted() && (45..=55).all(|index| near.contains(&index)));
    /// assert!(near.len() < 20, "most of the hundred need no look");
    /// ```
    pub fn candidates(&self, position: &Vec3, candidates: &mut Vec<usize>) {
        candidates.clear();
        match &self.grid {
            None => candidates.extend(0..self.count),
            Some(grid) => {
                grid.collect(position, candidates);
                // The cells are visited in the order of the grid;
                // ascending indices hide what moved before.
                candidates.sort_unstable();
            }
        }
    }

    /// Updates the list after a point has moved.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3, cells::CellList};
    /// let mut places: Vec<Vec3> = (0..100).map(|i| Vec3::new(f64::from(i), 0.0, 0.0)).collect();
    /// let mut cells = CellList::new(&Boundary::Open, 5.0, &places);
    /// let from = std::mem::replace(&mut places[99], Vec3::new(2.0, 1.0, 0.0));
    /// cells.moved(99, &from, &places[99]);
    /// let mut near = Vec::new();
    /// cells.candidates(&Vec3::zeros(), &mut near);
    /// assert!(near.contains(&99) && !near.contains(&98));
    /// ```
    pub fn moved(&mut self, index: usize, from: &Vec3, to: &Vec3) {
        if let Some(grid) = &mut self.grid {
            grid.relocate(index, from, to);
        }
    }
}

impl Grid {
    /// A grid without members; `None` where it would not pay or has too few cells.
    fn new(boundary: &Boundary, range: f64) -> Option<Self> {
        if !(range.is_finite() && range > 0.0) {
            // An infinite range has no cells, and one of zero would divide by zero.
            return None;
        }
        let (cell_lengths, cells_per_edge) = match boundary {
            Boundary::Periodic { lengths_angstrom } => {
                // Rounded down, so that a cell is at least as wide as the range.
                let cells = lengths_angstrom.map(|length| (length / range).floor());
                if cells.min() < FEWEST_CELLS {
                    return None;
                }
                (
                    lengths_angstrom.component_div(&cells),
                    Some([cells.x as i64, cells.y as i64, cells.z as i64]),
                )
            }
            Boundary::Open | Boundary::SphereWall { .. } => (Vec3::repeat(range), None),
        };
        Some(Self {
            boundary: *boundary,
            cell_lengths,
            cells_per_edge,
            members: FxHashMap::default(),
        })
    }

    fn cell(&self, position: &Vec3) -> [i64; 3] {
        // The position may have left the box by a move; its image inside names the cell.
        let wrapped = self.boundary.wrap(position);
        let [x, y, z] = wrapped.component_div(&self.cell_lengths).into();
        self.periodic([x.floor() as i64, y.floor() as i64, z.floor() as i64])
    }

    /// The cell, wrapped into the periodic box. The cells start at the origin and go around the
    /// box. If their number is odd, the one at a face of the box continues behind the opposite
    /// face.
    fn periodic(&self, mut cell: [i64; 3]) -> [i64; 3] {
        if let Some(cells) = self.cells_per_edge {
            for axis in 0..3 {
                cell[axis] = cell[axis].rem_euclid(cells[axis]);
            }
        }
        cell
    }

    fn insert(&mut self, index: usize, position: &Vec3) {
        let cell = self.cell(position);
        self.members.entry(cell).or_default().push(index as u32);
    }

    fn relocate(&mut self, index: usize, from: &Vec3, to: &Vec3) {
        let (old, new) = (self.cell(from), self.cell(to));
        // Most trial moves stay in their cell.
        if old == new {
            return;
        }
        if let Some(members) = self.members.get_mut(&old) {
            members.retain(|member| *member as usize != index);
            // Empty cells go: unbounded space would otherwise collect every cell ever visited.
            if members.is_empty() {
                self.members.remove(&old);
            }
        }
        self.members.entry(new).or_default().push(index as u32);
    }

    /// Adds the members of the 27 cells around a position.
    fn collect(&self, position: &Vec3, candidates: &mut Vec<usize>) {
        let [x, y, z] = self.cell(position);
        // A cell is at least one range wide: nothing in
        // range is further than the next cell. With four
        // cells along an edge and more, the 27 are all different, so no index comes twice.
        for dx in -1..=1 {
            for dy in -1..=1 {
                for dz in -1..=1 {
                    let cell = self.periodic([x + dx, y + dy, z + dz]);
                    if let Some(members) = self.members.get(&cell) {
                        candidates.extend(members.iter().map(|member| *member as usize));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    fn check_against_all_pairs(boundary: Boundary, extent: Vec3, range: f64, expect_grid: bool) {
        let mut rng = CounterRng::new(5, 0, 0);
        let mut place = || Vec3::from_fn(|axis, _| extent[axis] * rng.uniform_in(-0.5, 0.5));
        let mut positions: Vec<Vec3> = (0..300).map(|_| place()).collect();
        let mut cells = CellList::new(&boundary, range, &positions);
        assert_eq!(cells.grid.is_some(), expect_grid);
        for (index, position) in positions.iter_mut().enumerate().take(200) {
            let to = place();
            cells.moved(index, position, &to);
            *position = to;
        }
        let mut near = Vec::new();
        for _ in 0..200 {
            let centre = place();
            cells.candidates(&centre, &mut near);
            assert!(
                near.windows(2).all(|pair| pair[0] < pair[1]),
                "ascending and unique"
            );
            for (index, position) in positions.iter().enumerate() {
                if boundary.displacement(&centre, position).norm() <= range {
                    assert!(near.contains(&index));
                }
            }
            assert!(!expect_grid || near.len() < positions.len());
        }
    }

    #[test]
    fn everything_in_range_is_found() {
        let edges = Vec3::new(41.0, 57.3, 90.0);
        check_against_all_pairs(Boundary::periodic(edges).unwrap(), edges, 8.1, true);
        check_against_all_pairs(Boundary::periodic(edges).unwrap(), edges, 20.0, false);
        check_against_all_pairs(Boundary::Open, edges, 8.1, true);
        check_against_all_pairs(Boundary::Open, edges, f64::INFINITY, false);
        check_against_all_pairs(
            Boundary::SphereWall {
                radius_angstrom: 100.0,
            },
            edges,
            8.1,
            true,
        );
    }

    #[test]
    fn a_box_that_needs_two_images_is_refused_with_the_box_that_would_do() {
        let small = Boundary::periodic(Vec3::new(100.0, 30.0, 100.0)).unwrap();
        let message = require_minimum_image(&small, 20.0).unwrap_err().to_string();
        assert!(
            message.contains("40") && message.contains("30"),
            "{message}"
        );
    }
}
