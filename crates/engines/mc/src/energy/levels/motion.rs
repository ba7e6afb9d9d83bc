//! Relative poses and points in single precision, in arrays that vector units like.

use super::lanes::BLOCK;
use protomer_kernel::pose::RelativePose;

/// Points in arrays of 16: x, y, z (Å) and charge (e).
pub(super) type Block = [[f32; BLOCK]; 4];
const EMPTY: Block = [[0.0; BLOCK]; 4];

/// A relative pose in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    r: [[f32; 3]; 3],
    t: [f32; 3],
}

impl Motion {
    pub fn new(pose: &RelativePose) -> Self {
        let r = [0, 1, 2].map(|i| [0, 1, 2].map(|j| pose.rotation[(i, j)] as f32));
        let t = [0, 1, 2].map(|i| pose.translation[i] as f32);
        Self { r, t }
    }

    /// The displacement of every point from one pose to another.
    pub fn between(from: &RelativePose, to: &RelativePose) -> Self {
        Self::new(&RelativePose {
            // A difference of rotations is no rotation, but it gives each point's displacement.
            rotation: to.rotation - from.rotation,
            translation: to.translation - from.translation,
        })
    }

    /// A bound on how far points within `radius` of `centre` move by a
    /// [displacement](Self::between), Å.
    #[inline(always)]
    pub fn distance(&self, centre: [f32; 3], radius: f32) -> f32 {
        length(self.apply(centre)) + self.turn() * radius
    }

    /// Distance that a [displacement](Self::between) moves points at a distance of one from its
    /// axis: 2 sin(φ/2) for a turn by φ.
    #[inline(always)]
    pub fn turn(&self) -> f32 {
        let squares = self
            .r
            .iter()
            .map(|row| row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
        // The Frobenius norm is 2√2 sin(φ/2).
        (squares.sum::<f32>() / 2.0).sqrt()
    }

    #[inline(always)]
    pub fn apply(&self, x: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = self.r;
        let coordinate = |row: [f32; 3], t: f32| row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + t;
        [
            coordinate(a, self.t[0]),
            coordinate(b, self.t[1]),
            coordinate(c, self.t[2]),
        ]
    }

    /// Each row of the rotation, and after it that of where a point goes.
    #[inline(always)]
    pub fn elements(&self, point: [f32; 3]) -> [[f32; 4]; 3] {
        let image = self.apply(point);
        [0, 1, 2].map(|a: usize| [self.r[a][0], self.r[a][1], self.r[a][2], image[a]])
    }

    /// The displacement of a body that turns by a small `angle` (rad) about an axis through its
    /// `centre`, which moves by `step` (Å).
    pub fn displacement(
        &self,
        centre: [f32; 3],
        step: [f32; 3],
        axis: [f32; 3],
        angle: f32,
    ) -> Self {
        let mut displacement = Self {
            r: [[0.0; 3]; 3],
            t: [0.0; 3],
        };
        for column in 0..3 {
            // d(R e)/dφ = axis × R e, column by column.
            let tangent = cross(axis, [0, 1, 2].map(|row: usize| self.r[row][column]));
            (0..3).for_each(|row| displacement.r[row][column] = angle * tangent[row]);
        }
        // The shift of the centre by the turn is taken back, so the turn is about it.
        let shift = displacement.apply(centre);
        (0..3).for_each(|row| displacement.t[row] = step[row] - shift[row]);
        displacement
    }

    #[inline(always)]
    pub fn apply_block(&self, block: &Block) -> [[f32; BLOCK]; 3] {
        let [x, y, z, _] = block;
        self.apply_lanes([x, y, z])
    }

    /// Moves sixteen points.
    #[inline(always)]
    pub fn apply_lanes(&self, [x, y, z]: [&[f32; BLOCK]; 3]) -> [[f32; BLOCK]; 3] {
        let places = [x, y, z];
        [
            along_lanes(self.r[0], self.t[0], places),
            along_lanes(self.r[1], self.t[1], places),
            along_lanes(self.r[2], self.t[2], places),
        ]
    }
}

/// One coordinate of sixteen moved points.
#[inline(always)]
fn along_lanes([a, b, c]: [f32; 3], t: f32, [x, y, z]: [&[f32; BLOCK]; 3]) -> [f32; BLOCK] {
    // Loops over one row of coordinates each: loads of sixteen, no shuffles.
    let mut coordinates = [t; BLOCK];
    for lane in 0..BLOCK {
        coordinates[lane] += a * x[lane];
    }
    for lane in 0..BLOCK {
        coordinates[lane] += b * y[lane];
    }
    for lane in 0..BLOCK {
        coordinates[lane] += c * z[lane];
    }
    coordinates
}

/// The length of a vector.
#[inline(always)]
pub(super) fn length([x, y, z]: [f32; 3]) -> f32 {
    (x * x + y * y + z * z).sqrt()
}

/// The vector product.
pub(super) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Points in arrays; empty lanes repeat the last place without a charge.
pub(super) fn blocks(points: &[[f32; 4]]) -> Vec<Block> {
    let block = |points: &[[f32; 4]]| {
        let mut block = EMPTY;
        for lane in 0..BLOCK {
            let [x, y, z, charge] = points[lane.min(points.len() - 1)];
            let charge = if lane < points.len() { charge } else { 0.0 };
            (block[0][lane], block[1][lane], block[2][lane]) = (x, y, z);
            block[3][lane] = charge;
        }
        block
    };
    points.chunks(BLOCK).map(block).collect()
}
