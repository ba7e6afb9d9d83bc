//! The potential of many charges at the Chebyshev points of a cell.

use super::fine::FINE;
use super::lanes::BLOCK;
use super::motion::{Block, length};
use super::split::Split;
use crate::charges::ChargeCloud;
use crate::energy::SitePotential;
use protomer_kernel::Vec3;
use protomer_kernel::chebyshev::Chebyshev;
use protomer_kernel::fused::add;
use protomer_kernel::vectorised;

/// Bound of the rounding of distances, Å.
const ROUNDING: f32 = 1e-3;

/// The charges in arrays of 16.
pub(super) struct Sites {
    blocks: Vec<Sixteen>,
}

/// Sixteen charges in a sphere around them.
struct Sixteen {
    /// x, y, z (Å) and charges (e).
    charges: Block,
    centre: [f32; 3],
    radius: f32,
}

impl Sixteen {
    fn new(charges: Block) -> Self {
        let [x, y, z, _] = &charges;
        let centre = [x, y, z].map(|coordinates| coordinates.iter().sum::<f32>() / BLOCK as f32);
        let distance = |lane: usize| apart(centre, [x[lane], y[lane], z[lane]]);
        Self {
            centre,
            radius: (0..BLOCK).map(distance).fold(0.0, f32::max),
            charges,
        }
    }
}

fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
    length([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

impl Sites {
    pub fn new(charges: &ChargeCloud) -> Self {
        let sites: Vec<_> = charges.iter().collect();
        let block = |sites: &[(Vec3, f64)]| {
            let mut block = [[0.0; BLOCK]; 4];
            for lane in 0..BLOCK {
                // Empty lanes repeat the last place without a charge.
                let (x, charge) = sites[lane.min(sites.len() - 1)];
                (0..3).for_each(|axis| block[axis][lane] = x[axis] as f32);
                block[3][lane] = if lane < sites.len() {
                    charge as f32
                } else {
                    0.0
                };
            }
            block
        };
        Self {
            blocks: sites.chunks(BLOCK).map(block).map(Sixteen::new).collect(),
        }
    }

    /// The smooth potential at the Chebyshev points of a cell, and how far the nearest charge is
    /// from its centre. Single precision, which is that of the stored series.
    pub fn sample(
        &self,
        split: &Split,
        chebyshev: &Chebyshev<FINE>,
        centre: [f64; 3],
        edge: f64,
    ) -> (Vec<f64>, f64) {
        let coordinate =
            |axis: usize, i: usize| (centre[axis] + 0.5 * edge * chebyshev.points[i]) as f32;
        let middle = centre.map(|x| x as f32);
        // Beyond the near part's range from all of the cell, the smooth part is the potential itself.
        // Range, half the diagonal of the cell, and room for rounding.
        let range = split.radius_angstrom as f32 + 0.5 * edge as f32 * 3.0_f32.sqrt() + ROUNDING;
        // A block as a whole: sixteen charges in a sphere take one test.
        let is_near = |block: &&Sixteen| apart(block.centre, middle) < range + block.radius;
        let (near, far): (Vec<&Sixteen>, Vec<&Sixteen>) = self.blocks.iter().partition(is_near);
        let mut values = Vec::with_capacity(FINE * FINE * FINE);
        // Place = i + 6 (j + 6 k), as `series` expects it.
        for place in 0..FINE * FINE * FINE {
            let [i, j, k] = [place % FINE, place / FINE % FINE, place / (FINE * FINE)];
            let place = [coordinate(0, i), coordinate(1, j), coordinate(2, k)];
            values.push(f64::from(split.potential_of(&near, &far, place)));
        }
        (values, self.nearest(middle))
    }

    vectorised! {
        fused
        /// Distance of a place from the nearest charge, Å.
        pub fn nearest[nearest_avx512, nearest_avx2, least_distance](
            self: &Self,
            x: [f32; 3]
        ) -> f64
    }

    #[inline(always)]
    fn least_distance<const FUSED: bool>(&self, [x, y, z]: [f32; 3]) -> f64 {
        let mut least = [f32::INFINITY; BLOCK];
        for block in &self.blocks {
            let [sx, sy, sz, _] = &block.charges;
            for lane in 0..BLOCK {
                let (dx, dy, dz) = (x - sx[lane], y - sy[lane], z - sz[lane]);
                least[lane] = least[lane].min(dx * dx + dy * dy + dz * dz);
            }
        }
        f64::from(least.into_iter().fold(f32::INFINITY, f32::min)).sqrt()
    }
}

impl Split {
    vectorised! {
        fused
        /// The smooth potential of charges at a place, kT/e: of those that may be within the near
        /// part's range, and of those beyond.
        fn potential_of[potential_avx512, potential_avx2, potential_sum](
            self: &Self,
            near: &[&Sixteen],
            far: &[&Sixteen],
            x: [f32; 3]
        ) -> f32
    }

    #[inline(always)]
    fn potential_sum<const FUSED: bool>(
        &self,
        near: &[&Sixteen],
        far: &[&Sixteen],
        x: [f32; 3],
    ) -> f32 {
        let mut sum = [0.0; BLOCK];
        let smooth = |square| self.smooth_f32::<FUSED>(square);
        // Near blocks need the selection inside the range; the others go without it.
        near.iter()
            .for_each(|block| add_charges::<FUSED>(block, x, smooth, &mut sum));
        let whole = |square| self.potential.at_square_f32::<FUSED>(square);
        far.iter()
            .for_each(|block| add_charges::<FUSED>(block, x, whole, &mut sum));
        sum.iter().sum()
    }
}

/// Adds the potentials of sixteen charges at a place to the lanes of `sum`.
#[inline(always)]
fn add_charges<const FUSED: bool>(
    block: &Sixteen,
    [x, y, z]: [f32; 3],
    potential: impl Fn(f32) -> f32,
    sum: &mut [f32; BLOCK],
) {
    let [sx, sy, sz, charge] = &block.charges;
    for lane in 0..BLOCK {
        let (dx, dy, dz) = (x - sx[lane], y - sy[lane], z - sz[lane]);
        let square = add::<FUSED>(dx, dx, add::<FUSED>(dy, dy, dz * dz));
        sum[lane] = add::<FUSED>(charge[lane], potential(square), sum[lane]);
    }
}
