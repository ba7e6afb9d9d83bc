//! Which charges of a body are near a point.

use super::lanes::BLOCK;
use super::motion::Block;
use crate::charges::ChargeCloud;
use protomer_kernel::Vec3;
use std::ops::Range;

/// Distance (Å) that points may have moved before new ones are chosen; charges that can come within
/// the near part's range until then are listed, and nodes hold until then.
pub(super) const SKIN_ANGSTROM: f32 = 2.2;

/// Charges within a distance of any point of each cell of a grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Neighbours {
    low: [f32; 3],
    inverse_edge: f32,
    cells: [i32; 3],
    /// Start of each cell's blocks; one more at the end.
    starts: Vec<u32>,
    blocks: Vec<Block>,
}

/// Coordinate of the charges of unused lanes, Å: out of every range.
const NOWHERE: f32 = 1e4;

impl Neighbours {
    pub fn new(charges: &ChargeCloud, distance: f64) -> Self {
        let (low, high) = charges.bounds_angstrom();
        // Half the distance: smaller cells would list fewer charges in excess but take more memory.
        let edge = distance / 2.0;
        // Points farther from the charges than the distance have no neighbours.
        let (low, high) = (low.add_scalar(-distance), high.add_scalar(distance));
        let cells = ((high - low) / edge).map(|cells| cells.ceil().max(1.0) as i32);
        let mut members = vec![Vec::new(); cells.map(|n| n as usize).product()];
        for (place, charge) in charges.iter() {
            let site = [
                place.x as f32,
                place.y as f32,
                place.z as f32,
                charge as f32,
            ];
            let first = ((place - low).add_scalar(-distance) / edge).map(|x| x.floor() as i32);
            let last = ((place - low).add_scalar(distance) / edge).map(|x| x.floor() as i32);
            // Only the cells that the ball around the charge can reach.
            let range = |axis: usize| first[axis].max(0)..=last[axis].min(cells[axis] - 1);
            for z in range(2) {
                for y in range(1) {
                    for x in range(0) {
                        let corner = low + Vec3::new(x.into(), y.into(), z.into()) * edge;
                        // Vector from the cell to the charge, zero along axes where it is within.
                        let from_low = (corner - place).sup(&Vec3::zeros());
                        let from_high = (place - corner).add_scalar(-edge).sup(&Vec3::zeros());
                        if (from_low + from_high).norm() < distance {
                            members[((z * cells.y + y) * cells.x + x) as usize].push(site);
                        }
                    }
                }
            }
        }
        // One array of blocks with the start of each cell's: a look-up is two reads.
        let mut starts = vec![0];
        let mut blocks = Vec::new();
        for cell in members {
            blocks.extend(cell.chunks(BLOCK).map(block));
            starts.push(blocks.len() as u32);
        }
        Self {
            low: low.map(|x| x as f32).into(),
            inverse_edge: (1.0 / edge) as f32,
            cells: cells.into(),
            starts,
            blocks,
        }
    }

    /// Position (Å) and charge (e) of all charges that may be near the point, and others.
    #[inline(always)]
    pub fn blocks(&self, x: [f32; 3]) -> &[Block] {
        &self.blocks[self.range(x)]
    }

    #[inline(always)]
    fn range(&self, x: [f32; 3]) -> Range<usize> {
        let mut cell = 0;
        for axis in (0..3).rev() {
            let place = ((x[axis] - self.low[axis]) * self.inverse_edge).floor() as i32;
            // Outside the grid no charge is near.
            if !(0..self.cells[axis]).contains(&place) {
                return 0..0;
            }
            // (z n_y + y) n_x + x, built from z down.
            cell = cell * self.cells[axis] + place;
        }
        let cell = cell as usize;
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }

    pub fn memory_bytes(&self) -> usize {
        4 * self.starts.len() + size_of::<Block>() * self.blocks.len()
    }
}

/// Up to sixteen charges in lanes.
fn block(charges: &[[f32; 4]]) -> Block {
    let mut block = [
        [NOWHERE; BLOCK],
        [NOWHERE; BLOCK],
        [NOWHERE; BLOCK],
        [0.0; BLOCK],
    ];
    for (lane, charge) in charges.iter().enumerate() {
        (0..4).for_each(|row| block[row][lane] = charge[row]);
    }
    block
}

/// The squared distances (Å²) of the charges of a block from a place.
#[inline(always)]
pub(super) fn squares(block: &Block, [x, y, z]: [f32; 3]) -> [f32; BLOCK] {
    let [bx, by, bz, _] = block;
    let mut squares = [0.0; BLOCK];
    for lane in 0..BLOCK {
        let (dx, dy, dz) = (bx[lane] - x, by[lane] - y, bz[lane] - z);
        squares[lane] = dx * dx + dy * dy + dz * dz;
    }
    squares
}
