//! Sites gathered in blocks: where the table of the other body is smooth, the moments of a block stand for its sites.
//!
//! A block whose sites carry amounts w at distances r from its centre has, with the centre at u from the point g of a
//! [polynomial](super::quadratics) and turned by R, the energy
//!
//! ```text
//! Σ w V(g + u + R r) = V(g + u) Σ w + (b + 2 C u) · R Σ w r + tr(Rᵀ C R Σ w r rᵀ)
//! ```
//!
//! without a further error: what the polynomial leaves of the table is all that is left out. That
//! is σ √(Σ w²) for independent sites and a remainder σ; where it is too much, the parts of the
//! block count one by one.

use super::Room;
use super::lookup::{Lanes, SinglePose, Site};
use super::quadratics::{COEFFICIENTS, Polynomial, Quadratics, Remainders, Resolution, monomials};
use crate::prefetch::prefetch;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::vectorised;
use std::ops::Range;

/// Blocks between the request for a polynomial and its use.
const AHEAD: usize = 12;

/// Levels of blocks, the largest blocks first.
pub(super) const LEVELS: usize = 3;
/// Edges of the blocks, Å: 8, 4 and 2 sites of the lattice on which bodies are gathered.
const EDGES_ANGSTROM: [f64; LEVELS] = [24.0, 12.0, 6.0];
/// The grids of polynomials for them: (spacing, radius of the balls), Å. A ball reaches about as far as the sites of
/// a block do from their centre, and half of the way to the next polynomial.
const GRIDS_ANGSTROM: [(f64, f64); LEVELS] = [(8.0, 18.0), (4.0, 9.0), (3.0, 4.0)];
/// Largest estimate of what a block may leave out, kT. Pairs of bodies then leave out 0.02 to
/// 0.04 kT (docs/validation/solvent-response.md).
const TOLERANCE_KT: f32 = 2e-2;
/// The lowest block starts this part of the smallest edge below the lowest site, so that sites of a lattice lie
/// within blocks and not on their faces.
const PART_BELOW: f64 = 0.25;

/// Sites that are near each other.
#[derive(Debug)]
pub(super) struct Block {
    /// Mean place of the sites, Å.
    pub centre: [f32; 3],
    /// Σ w times the monomials of r.
    moments: [Lanes; COEFFICIENTS],
    /// √(Σ w²)
    weight: Lanes,
    /// Blocks of the next level, or sites.
    pub parts: Range<usize>,
}

/// A pose of the other body, and what it does to quadratic terms.
pub(super) struct View {
    pub pose: SinglePose,
    /// From C to Rᵀ C R, both as coefficients of monomials.
    turned_squares: [[f32; 6]; 6],
}

/// The grid of polynomials for blocks of a level.
pub(super) fn resolution(level: usize) -> Resolution {
    let (spacing_angstrom, radius_angstrom) = GRIDS_ANGSTROM[level];
    Resolution {
        spacing_angstrom,
        radius_angstrom,
        // Half of the diagonal of a block: beyond it none of its sites is in the table.
        margin_angstrom: 0.5 * 3.0_f64.sqrt() * EDGES_ANGSTROM[level],
    }
}

impl Quadratics {
    vectorised!(
        /// The energy of the open ranges of blocks by their moments, kT. The parts of blocks for which the polynomials are
        /// not enough are open afterwards.
        pub fn energy_of_blocks_kt[energy_avx512, energy_avx2, energy_any](
            self: &Self,
            blocks: &[Block],
            view: &View,
            room: &mut Room,
        ) -> f64
    );

    // Most of the time goes to waiting for memory. So places, judgements and energies are three loops, and the first two
    // request what the next one needs: remainders, which are small, and of the polynomials only those that serve.
    #[inline(always)]
    fn energy_any(&self, blocks: &[Block], view: &View, room: &mut Room) -> f64 {
        let Room {
            open,
            parts,
            places,
            ..
        } = room;
        places.clear();
        for number in open.drain(..).flatten() {
            let near = self.near(&view.pose.transform(&blocks[number].centre));
            // Beyond the grid no site of the block reaches the table, by the margin of the grid.
            if !self.is_beyond(&near) {
                prefetch(self.remainders(&near));
                places.push((near, number));
            }
        }
        places.retain(|(near, number)| {
            let block = &blocks[*number];
            let is_enough = block.is_enough(self.remainders(near));
            if !is_enough {
                parts.push(block.parts.clone());
            }
            is_enough
        });
        for (near, _) in places.iter().take(AHEAD) {
            prefetch(self.polynomial(near));
        }
        let mut sum_kt = 0.0;
        for (turn, (near, number)) in places.iter().enumerate() {
            if let Some((next, _)) = places.get(turn + AHEAD) {
                prefetch(self.polynomial(next));
            }
            let (block, polynomial) = (&blocks[*number], self.polynomial(near));
            sum_kt += f64::from(block.energy_kt(polynomial, &near.offset_angstrom, view));
        }
        std::mem::swap(open, parts);
        sum_kt
    }
}

impl View {
    pub fn new(pose: &RelativePose) -> Self {
        const AXES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let turn = &pose.rotation;
        let coefficient = |(j, k): (usize, usize), (a, b): (usize, usize)| {
            // Rᵀ C R, for symmetric C: off-diagonal elements come from both orders.
            let one_way = turn[(a, j)] * turn[(b, k)];
            match j == k {
                true => one_way as f32,
                false => (one_way + turn[(a, k)] * turn[(b, j)]) as f32,
            }
        };
        Self {
            pose: SinglePose::new(pose),
            turned_squares: AXES.map(|to| AXES.map(|from| coefficient(to, from))),
        }
    }
}

impl Block {
    /// Blocks of each level, and the sites in their order.
    pub fn gather(sites: &[Site]) -> ([Vec<Self>; LEVELS], Vec<Site>) {
        let lowest = sites.iter().fold([f32::INFINITY; 3], |low, site| {
            [0, 1, 2].map(|axis| low[axis].min(site.place[axis]))
        });
        let below = PART_BELOW * EDGES_ANGSTROM[LEVELS - 1];
        let cell = |site: &Site, edge: f64| -> [u32; 3] {
            let steps = |axis: usize| (f64::from(site.place[axis] - lowest[axis]) + below) / edge;
            // z first: cells sort by planes, rows and places, as the table lies in memory.
            [2, 1, 0].map(|axis| steps(axis) as u32)
        };
        let mut ordered: Vec<([[u32; 3]; LEVELS], Site)> = sites
            .iter()
            // Cells of all levels, largest first: one sort gives blocks of blocks.
            .map(|site| (EDGES_ANGSTROM.map(|edge| cell(site, edge)), *site))
            .collect();
        ordered.sort_by_key(|(cells, _)| *cells);
        let sites: Vec<Site> = ordered.iter().map(|(_, site)| *site).collect();
        let mut levels: [Vec<Self>; LEVELS] = Default::default();
        // From the smallest blocks up: the parts of a block start where one of its sites does.
        let mut starts: Vec<usize> = (0..=sites.len()).collect();
        for level in (0..LEVELS).rev() {
            let is_start = |site: &usize| match *site {
                0 => true,
                site if site == sites.len() => true,
                // A new block starts where the cell of this level or of any larger one changes.
                site => ordered[site].0[..=level] != ordered[site - 1].0[..=level],
            };
            let own: Vec<usize> = (0..=sites.len()).filter(is_start).collect();
            // Where a block of this level starts, one of its
            // parts does; its number is found by bisection.
            let part = |site: usize| starts.partition_point(|start| *start < site);
            for ends in own.windows(2) {
                let parts = part(ends[0])..part(ends[1]);
                levels[level].push(Self::new(&sites[ends[0]..ends[1]], parts));
            }
            starts = own;
        }
        (levels, sites)
    }

    fn new(sites: &[Site], parts: Range<usize>) -> Self {
        let mut centre = [0.0; 3];
        for site in sites {
            for (centre, along) in centre.iter_mut().zip(site.place) {
                *centre += f64::from(along) / sites.len() as f64;
            }
        }
        // The centre as the fast sums see it.
        // Offsets must be from the rounded centre, or moments and place would not fit.
        let centre = centre.map(|along| along as f32);
        // Summed in double, stored in single precision.
        let (mut moments, mut squares) = ([[0.0_f64; 4]; COEFFICIENTS], [0.0_f64; 4]);
        for site in sites {
            let from_centre = [0, 1, 2].map(|axis| f64::from(site.place[axis] - centre[axis]));
            let monomials = monomials(from_centre);
            for lane in 0..4 {
                let amount = f64::from(site.amounts[lane]);
                squares[lane] += amount * amount;
                for (moment, monomial) in moments.iter_mut().zip(monomials) {
                    moment[lane] += amount * monomial;
                }
            }
        }
        Self {
            centre,
            moments: moments.map(|moment| moment.map(|lane| lane as f32)),
            weight: squares.map(|lane| lane.sqrt() as f32),
            parts,
        }
    }

    /// Whether a polynomial near the centre may stand for the table: a bound of what it leaves out.
    #[inline(always)]
    fn is_enough(&self, remainders: &Remainders) -> bool {
        let mut left_out_kt = 0.0;
        for (weight, remainder) in self.weight.iter().zip(remainders.kt_per_amount()) {
            // σ √(Σ w²) for each amount, and the amounts add at worst.
            left_out_kt += weight * remainder;
        }
        left_out_kt <= TOLERANCE_KT
    }

    /// The energy by a polynomial, kT.
    // One loop over the lanes with all of the work in it: compilers turn it into vector instructions, but shorter
    // ones into single numbers. The fourth lane is there for this only: capacitances are no part of blocks.
    #[inline(always)]
    fn energy_kt(&self, polynomial: &Polynomial, offset_angstrom: &[f32; 3], view: &View) -> f32 {
        let m = &self.moments;
        let ([x, y, z], r) = (*offset_angstrom, &view.pose.rotation);
        let mut energy_kt = [0.0; 4];
        for lane in 0..4 {
            let c = |number: usize| polynomial.coefficient(number, lane);
            let (of_x, of_y, of_z) = (c(1), c(2), c(3));
            let (xx, yy, zz, xy, xz, yz) = (c(4), c(5), c(6), c(7), c(8), c(9));
            // The gradient of the polynomial at the block's centre.
            let along_x = of_x + 2.0 * x * xx + y * xy + z * xz;
            let along_y = of_y + 2.0 * y * yy + x * xy + z * yz;
            let along_z = of_z + 2.0 * z * zz + x * xz + y * yz;
            // b·u + u·C u is half of u·(b + gradient).
            let twice = x * (of_x + along_x) + y * (of_y + along_y) + z * (of_z + along_z);
            let mut sum = m[0][lane] * (c(0) + 0.5 * twice);
            for axis in 0..3 {
                // Rᵀ g: the gradient in the frame in which the moments are.
                let along = r[0][axis] * along_x + r[1][axis] * along_y + r[2][axis] * along_z;
                sum += m[1 + axis][lane] * along;
            }
            for (term, turned) in view.turned_squares.iter().enumerate() {
                let squares = turned[0] * xx + turned[1] * yy + turned[2] * zz;
                let products = turned[3] * xy + turned[4] * xz + turned[5] * yz;
                sum += m[4 + term][lane] * (squares + products);
            }
            energy_kt[lane] = sum;
        }
        energy_kt[0] + energy_kt[1] + energy_kt[2]
    }
}
