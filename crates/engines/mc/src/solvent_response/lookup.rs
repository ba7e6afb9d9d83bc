//! Four numbers at each point of a grid, and between the points.

use super::ResponseGrid;
use crate::prefetch::prefetch;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::{Vec3, vectorised};
use std::ops::Range;

/// Sites between the request for points of the grid and their use.
const AHEAD: usize = 8;

/// Energies per charge (e), per volume of low permittivity and per volume without ions (Å³) and per capacitance
/// (e²), kT, or the amounts that they multiply: a point is one load of a vector unit.
pub(super) type Lanes = [f32; 4];

/// A grid with four numbers per point, x running fastest.
#[derive(Debug)]
pub(super) struct Lookup {
    pub origin_angstrom: Vec3,
    pub spacing_angstrom: f64,
    pub shape: [usize; 3],
    values: Vec<Lanes>,
}

/// Charge and volume at a place of a body (Å).
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    pub place: [f32; 3],
    pub amounts: Lanes,
}

/// A cell of the grid, and a place in it as parts of its edges.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Point of the cell with the smallest coordinates.
    lowest: usize,
    part: [f32; 3],
}

/// A pose of another body in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct SinglePose {
    pub rotation: [[f32; 3]; 3],
    pub translation: [f32; 3],
}

impl SinglePose {
    pub fn new(pose: &RelativePose) -> Self {
        let row = |row: usize| [0, 1, 2].map(|column| pose.rotation[(row, column)] as f32);
        Self {
            rotation: [0, 1, 2].map(row),
            translation: [0, 1, 2].map(|axis| pose.translation[axis] as f32),
        }
    }

    /// A place of the other body in the frame of the table, Å.
    #[inline(always)]
    pub fn transform(&self, place: &[f32; 3]) -> [f32; 3] {
        let [x, y, z] = *place;
        std::array::from_fn(|axis| {
            let row = &self.rotation[axis];
            row[0] * x + row[1] * y + row[2] * z + self.translation[axis]
        })
    }
}

impl Lookup {
    /// The table of a grid that has a value for each point.
    pub fn new(grid: ResponseGrid) -> Self {
        Self {
            origin_angstrom: grid.origin_angstrom,
            spacing_angstrom: grid.spacing_angstrom,
            shape: grid.shape,
            values: grid.values,
        }
    }

    /// Number of a point in memory.
    #[inline(always)]
    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.shape[1] + y) * self.shape[0] + x
    }

    /// The corner with the largest coordinates, Å.
    pub fn high_angstrom(&self) -> Vec3 {
        let steps = self.shape.map(|points| (points - 1) as f64);
        self.origin_angstrom + self.spacing_angstrom * Vec3::from(steps)
    }

    /// Whether a sphere touches the grid.
    pub fn touches_sphere(&self, centre: &Vec3, radius_angstrom: f64) -> bool {
        // The nearest point of the box to the centre, by clamping.
        let nearest = centre.sup(&self.origin_angstrom).inf(&self.high_angstrom());
        (centre - nearest).norm_squared() <= radius_angstrom * radius_angstrom
    }

    /// The numbers at a point; zeros beyond the grid.
    pub fn at_point(&self, point: [i64; 3]) -> Lanes {
        let mut place = [0; 3];
        for axis in 0..3 {
            match usize::try_from(point[axis]) {
                Ok(along) if along < self.shape[axis] => place[axis] = along,
                _ => return [0.0; 4],
            }
        }
        self.values[self.number(place)]
    }

    /// The cell around a place (Å); none beyond the grid.
    #[inline(always)]
    pub fn cell(&self, place: &[f32; 3]) -> Option<Cell> {
        let per_angstrom = (1.0 / self.spacing_angstrom) as f32;
        let (mut corner, mut part) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let steps = (place[axis] - self.origin_angstrom[axis] as f32) * per_angstrom;
            // NaN counts as beyond.
            if !(steps >= 0.0 && steps < (self.shape[axis] - 1) as f32) {
                return None;
            }
            let whole = steps as u32;
            corner[axis] = whole as usize;
            part[axis] = steps - whole as f32;
        }
        Some(Cell {
            lowest: self.number(corner),
            part,
        })
    }

    /// The lowest points of the four rows of a cell, which lie along x.
    #[inline(always)]
    fn rows(&self, cell: &Cell) -> [usize; 4] {
        let [nx, ny, _] = self.shape;
        let lowest = cell.lowest;
        [lowest, lowest + nx, lowest + nx * ny, lowest + nx * ny + nx]
    }

    /// Asks for the eight points of a cell.
    #[inline(always)]
    fn prefetch(&self, cell: &Cell) {
        for start in self.rows(cell) {
            // A row of two points may lie in two lines of the cache.
            prefetch(&self.values[start]);
            prefetch(&self.values[start + 1]);
        }
    }

    /// The energy of amounts in a cell, interpolated linearly, kT.
    // All is in loops over the lanes of both points of a row, which compilers turn into vector instructions.
    #[inline(always)]
    fn energy_in_cell_kt(&self, cell: &Cell, amounts: &Lanes) -> f64 {
        let row = |start: usize| self.values[start..start + 2].as_flattened();
        let rows = self.rows(cell).map(row);
        let [along_x, along_y, along_z] = cell.part;
        let mut ends = [0.0; 8];
        for (lane, end) in ends.iter_mut().enumerate() {
            let low = mixed(rows[0][lane], rows[1][lane], along_y);
            let high = mixed(rows[2][lane], rows[3][lane], along_y);
            *end = mixed(low, high, along_z);
        }
        let mut energy_kt = [0.0; 4];
        for lane in 0..4 {
            energy_kt[lane] = amounts[lane] * mixed(ends[lane], ends[lane + 4], along_x);
        }
        // In pairs, a fixed order for the same bits.
        f64::from((energy_kt[0] + energy_kt[1]) + (energy_kt[2] + energy_kt[3]))
    }

    /// The energy of one site of another body, kT; zero beyond the grid.
    pub fn energy_kt(&self, site: &Site, pose: &SinglePose) -> f64 {
        self.cell(&pose.transform(&site.place))
            .map_or(0.0, |cell| self.energy_in_cell_kt(&cell, &site.amounts))
    }

    vectorised!(
        /// The energy of ranges of sites of another body, kT; `cells` is room to work in.
        pub fn energy_of_sites_kt[energy_avx512, energy_avx2, energy_any](
            self: &Self,
            sites: &[Site],
            ranges: &[Range<usize>],
            pose: &SinglePose,
            cells: &mut Vec<(Cell, Lanes)>,
        ) -> f64
    );

    // Tables of two bodies are larger than the near caches, and a site costs eight loads from anywhere in a table. So
    // all cells are found first, and the points of a cell are requested some sites before their turn.
    #[inline(always)]
    fn energy_any(
        &self,
        sites: &[Site],
        ranges: &[Range<usize>],
        pose: &SinglePose,
        cells: &mut Vec<(Cell, Lanes)>,
    ) -> f64 {
        cells.clear();
        for range in ranges {
            for site in &sites[range.clone()] {
                if let Some(cell) = self.cell(&pose.transform(&site.place)) {
                    cells.push((cell, site.amounts));
                }
            }
        }
        let mut sum_kt = 0.0;
        for (cell, _) in cells.iter().take(AHEAD) {
            self.prefetch(cell);
        }
        for (number, (cell, amounts)) in cells.iter().enumerate() {
            if let Some((next, _)) = cells.get(number + AHEAD) {
                self.prefetch(next);
            }
            sum_kt += self.energy_in_cell_kt(cell, amounts);
        }
        sum_kt
    }
}

#[inline(always)]
fn mixed(low: f32, high: f32, part: f32) -> f32 {
    low + part * (high - low)
}
