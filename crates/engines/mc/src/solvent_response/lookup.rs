//! Four numbers at each point of a grid, and between the points.

use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;

/// Energies per charge (e), per volume of low permittivity and per volume without ions (Å³) and per capacitance
/// (e²), kT, or the amounts that they multiply: a point is one load of a vector unit.
pub(super) type Lanes = [f32; 4];

/// A grid with four numbers per point, x running fastest.
#[derive(Debug)]
pub(super) struct Lookup {
    pub origin_angstrom: Vec3,
    pub spacing_angstrom: f64,
    pub shape: [usize; 3],
    pub values: Vec<Lanes>,
}

/// Charge and volume at a place of a body (Å).
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    pub place: [f32; 3],
    pub amounts: Lanes,
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
        let mut number = 0;
        for axis in [2, 1, 0] {
            match usize::try_from(point[axis]) {
                Ok(place) if place < self.shape[axis] => {
                    number = number * self.shape[axis] + place;
                }
                _ => return [0.0; 4],
            }
        }
        self.values[number]
    }

    /// The energy of one site of another body, interpolated linearly, kT; zero beyond the grid.
    // Tables of two bodies are larger than the near caches, and a site costs its eight loads: a point is one load
    // of four lanes. All is in one loop over the lanes, which compilers turn into vector instructions.
    #[inline(always)]
    pub fn energy_kt(&self, site: &Site, pose: &SinglePose) -> f64 {
        let place = pose.transform(&site.place);
        let per_angstrom = (1.0 / self.spacing_angstrom) as f32;
        let (mut corner, mut part) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let steps = (place[axis] - self.origin_angstrom[axis] as f32) * per_angstrom;
            // NaN counts as beyond.
            if !(steps >= 0.0 && steps < (self.shape[axis] - 1) as f32) {
                return 0.0;
            }
            let whole = steps as u32;
            corner[axis] = whole as usize;
            part[axis] = steps - whole as f32;
        }
        let [nx, ny, _] = self.shape;
        // The cell's lowest corner; its rows along x follow each other by nx and nx ny.
        let first = (corner[2] * ny + corner[1]) * nx + corner[0];
        let row = |start: usize| &self.values[start..start + 2];
        let rows = [first, first + nx, first + nx * ny, first + nx * ny + nx].map(row);
        let mut energy_kt = [0.0; 4];
        for lane in 0..4 {
            let along_x = |row: &[Lanes]| mixed(row[0][lane], row[1][lane], part[0]);
            let low = mixed(along_x(rows[0]), along_x(rows[1]), part[1]);
            let high = mixed(along_x(rows[2]), along_x(rows[3]), part[1]);
            energy_kt[lane] = site.amounts[lane] * mixed(low, high, part[2]);
        }
        // In pairs, a fixed order for the same bits.
        f64::from((energy_kt[0] + energy_kt[1]) + (energy_kt[2] + energy_kt[3]))
    }
}

#[inline(always)]
fn mixed(low: f32, high: f32, part: f32) -> f32 {
    low + part * (high - low)
}
