//! The arithmetic of discs, eight at a time.
//!
//! These are plain loops over eight lanes. The compiler turns them into vector instructions of the
//! width that the calling function may use; the results do not depend on that width.

use super::disc::Disc;
use crate::pose::RelativePose;
use wide::f32x8;

/// Children per node: the lanes of one 256-bit register of `f32`.
pub(super) const WIDTH: usize = 8;

/// One number per child.
pub(super) type Lanes = [f32; WIDTH];

/// Eight discs, component by component.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct DiscBlock {
    pub centre: [[f32; WIDTH]; 3],
    pub normal: [[f32; WIDTH]; 3],
    pub radius: [f32; WIDTH],
    pub half_thickness: [f32; WIDTH],
}

impl DiscBlock {
    /// Eight lanes that no disc uses.
    pub const EMPTY: DiscBlock = DiscBlock {
        centre: [[0.0; WIDTH]; 3],
        normal: [[0.0; WIDTH]; 3],
        radius: [Disc::EMPTY.radius; WIDTH],
        half_thickness: [Disc::EMPTY.half_thickness; WIDTH],
    };

    pub fn from_discs(discs: &[Disc]) -> Self {
        // Lanes without a child keep the empty disc, which every test rejects.
        let mut block = Self::EMPTY;
        for (lane, disc) in discs.iter().enumerate() {
            for axis in 0..3 {
                block.centre[axis][lane] = disc.centre[axis];
                block.normal[axis][lane] = disc.normal[axis];
            }
            block.radius[lane] = disc.radius;
            block.half_thickness[lane] = disc.half_thickness;
        }
        block
    }

    /// The disc of a lane.
    #[inline(always)]
    pub fn disc(&self, lane: usize) -> Disc {
        Disc {
            centre: self.centre.map(|axis| axis[lane]),
            normal: self.normal.map(|axis| axis[lane]),
            radius: self.radius[lane],
            half_thickness: self.half_thickness[lane],
        }
    }
}

/// Allowance added to the squares under a root that cancels, relative to their size. It is more
/// than their rounding error and that of the root, so that the half-extent across a disc is never
/// underestimated, and costs at most 0.2 % of the radius.
const ROOT_SLACK: f32 = 4e-6;

/// The motion into the frame of the first body, in the precision of the discs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    rotation: [[f32; 3]; 3],
    translation: [f32; 3],
}

impl Motion {
    pub fn new(pose: &RelativePose) -> Self {
        // nalgebra keeps columns, so the transpose has the rows.
        Self {
            rotation: pose.rotation.transpose().cast().into(),
            translation: pose.translation.cast().into(),
        }
    }

    /// The discs of the second body in the frame of the first.
    #[inline(always)]
    pub fn block(&self, block: &DiscBlock) -> DiscBlock {
        // The radii are copied with the rest: a rotation does not change them.
        let mut image = block.clone();
        for row in 0..3 {
            let [x, y, z] = self.rotation[row];
            for lane in 0..WIDTH {
                let (centre, normal) = (&block.centre, &block.normal);
                image.centre[row][lane] = x.mul_add(
                    centre[0][lane],
                    y.mul_add(
                        centre[1][lane],
                        z.mul_add(centre[2][lane], self.translation[row]),
                    ),
                );
                image.normal[row][lane] = x.mul_add(
                    normal[0][lane],
                    y.mul_add(normal[1][lane], z * normal[2][lane]),
                );
            }
        }
        image
    }

    /// A disc of the second body in the frame of the first.
    #[inline(always)]
    pub fn disc(&self, disc: &Disc) -> Disc {
        let mut image = *disc;
        for row in 0..3 {
            let [x, y, z] = self.rotation[row];
            let (centre, normal) = (&disc.centre, &disc.normal);
            // Not fused, unlike the eight lanes: `block` and
            // `disc` differ by roundings within the allowance.
            image.centre[row] =
                x * centre[0] + y * centre[1] + z * centre[2] + self.translation[row];
            image.normal[row] = x * normal[0] + y * normal[1] + z * normal[2];
        }
        image
    }
}

/// Lower bounds on the distances between one disc and eight others, Å.
///
/// Three axes are tried: the two normals m and n, and the line of the centres d: |d·m| - t_m -
/// e_n(m), |d·n| - t_n - e_m(n) and |d| - e_m(d) - e_n(d), with e the half-extent of a disc.
#[inline(always)]
pub(super) fn separations(disc: &Disc, block: &DiscBlock, rounding: f32) -> Lanes {
    let [cx, cy, cz] = disc.centre;
    let [mx, my, mz] = disc.normal;
    let mut result = [0.0; WIDTH];
    // The loop has no branch and no early end, so that
    // each line becomes one instruction for eight lanes.
    for (lane, result) in result.iter_mut().enumerate() {
        let (dx, dy, dz) = (
            block.centre[0][lane] - cx,
            block.centre[1][lane] - cy,
            block.centre[2][lane] - cz,
        );
        let (nx, ny, nz) = (
            block.normal[0][lane],
            block.normal[1][lane],
            block.normal[2][lane],
        );
        let (radius, half_thickness) = (block.radius[lane], block.half_thickness[lane]);
        let along_m = dx.mul_add(mx, dy.mul_add(my, dz * mz)).abs();
        let along_n = dx.mul_add(nx, dy.mul_add(ny, dz * nz)).abs();
        // Enlarged, so that the differences of squares
        // below never fall under the true half-extents.
        let squared = dx.mul_add(dx, dy.mul_add(dy, dz * dz)) * (1.0 + ROOT_SLACK);
        let cosine = mx.mul_add(nx, my.mul_add(ny, mz * nz)).abs();
        let sine = root(cosine.mul_add(-cosine, 1.0 + ROOT_SLACK));
        // Half-extent of the other disc along m: t |m·n| + r √(1 - (m·n)²).
        let on_m = along_m - disc.half_thickness - radius.mul_add(sine, half_thickness * cosine);
        let on_n =
            along_n - half_thickness - disc.radius.mul_add(sine, disc.half_thickness * cosine);
        // Half-extents along d, each times |d|: t |d·m| + r √(|d|² - (d·m)²).
        let across_m = root(along_m.mul_add(-along_m, squared));
        let across_n = root(along_n.mul_add(-along_n, squared));
        let extents = disc.radius.mul_add(
            across_m,
            disc.half_thickness
                .mul_add(along_m, radius.mul_add(across_n, half_thickness * along_n)),
        );
        // All terms are |d| times too large. Where the sum
        // is positive, an inverse root that is too small
        // keeps the bound below the true gap; where it is negative, the sign stays.
        let on_d = (squared - extents) * inverse_root_below(squared);
        // One allowance for all three axes: each is a sum of the same few dozen operations.
        *result = larger(larger(on_m, on_n), on_d) - rounding;
    }
    result
}

/// A bit for each lane with a negative number.
#[inline(always)]
pub(super) fn negative_lanes(lanes: Lanes) -> u32 {
    f32x8::new(lanes).to_bitmask()
}

/// The indices of the bits set.
pub(super) struct Bits(pub u32);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lowest = self.0.trailing_zeros();
        // Clears the lowest bit; zero stays zero, as the subtraction wraps.
        self.0 &= self.0.wrapping_sub(1);
        (lowest < WIDTH as u32).then_some(lowest as usize)
    }
}

/// The larger of two numbers that are not NaN, in one instruction.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    // Not `f32::max`, which must care for NaN and takes more than one instruction.
    if a > b { a } else { b }
}

/// A lower bound on 1/√x, no more than 0.18 % below it: the exponent is halved in integer
/// arithmetic, and one Newton step follows, which always ends below. A root and a quotient would
/// keep the divider busy, which the other roots need, and the discs are not sharper than that.
#[inline(always)]
pub(super) fn inverse_root_below(x: f32) -> f32 {
    let guess = f32::from_bits(0x5f37_5a86_u32.wrapping_sub(x.to_bits() >> 1));
    guess * (0.5 * x * guess).mul_add(-guess, 1.5)
}

/// The root √x; zero for x ≤ 0.
#[inline(always)]
pub(super) fn root(x: f32) -> f32 {
    larger(x, 0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use crate::random::CounterRng;

    #[test]
    fn the_approximate_inverse_root_errs_on_the_safe_side() {
        // The relative error repeats with every factor of four.
        for bits in (1.0_f32.to_bits()..=4.0_f32.to_bits()).step_by(7) {
            let x = f32::from_bits(bits);
            let below = 1.0 - f64::from(inverse_root_below(x)) * f64::from(x).sqrt();
            assert!((-1e-6..2e-3).contains(&below), "1/√{x}: {below}");
        }
        assert_eq!(root(-1.0), 0.0);
        assert_eq!(root(0.0), 0.0);
    }

    fn some_disc(rng: &mut CounterRng) -> Disc {
        Disc {
            centre: rng.vector_in_ball(10.0).cast::<f32>().into(),
            normal: rng.unit_vector().cast::<f32>().into(),
            radius: (8.0 * rng.uniform()) as f32,
            half_thickness: (2.0 * rng.uniform()) as f32,
        }
    }

    /// The widest gap along the three axes, as the equations say it.
    fn plain_separation(first: &Disc, second: &Disc) -> f64 {
        let vector = |x: [f32; 3]| Vec3::from(x.map(f64::from));
        let half_extent = |disc: &Disc, axis: &Vec3| {
            let cosine = vector(disc.normal).normalize().dot(axis).abs().min(1.0);
            f64::from(disc.half_thickness) * cosine
                + f64::from(disc.radius) * (1.0 - cosine * cosine).sqrt()
        };
        let between = vector(second.centre) - vector(first.centre);
        let gap = |axis: Vec3| {
            let axis = axis.normalize();
            between.dot(&axis).abs() - half_extent(first, &axis) - half_extent(second, &axis)
        };
        gap(vector(first.normal))
            .max(gap(vector(second.normal)))
            .max(gap(between))
    }

    #[test]
    fn separations_are_those_of_the_equations_or_a_little_less() {
        let mut rng = CounterRng::new(5, 0, 0);
        let rounding = 3e-4;
        let mut apart = 0;
        for _ in 0..500 {
            let disc = some_disc(&mut rng);
            let others: [Disc; WIDTH] = std::array::from_fn(|_| some_disc(&mut rng));
            let found = separations(&disc, &DiscBlock::from_discs(&others), rounding);
            for (found, other) in found.into_iter().zip(&others) {
                let plain = plain_separation(&disc, other);
                let lost = plain - f64::from(found);
                // The root of the slack under a root is 0.2 % of the two radii; the inverse root
                // errs by 0.2 % of the separation.
                let allowed = 4e-4 + 2e-3 * (f64::from(disc.radius + other.radius) + plain.abs());
                assert!(lost <= allowed, "{plain} {found}");
                // Of discs that the axes do not separate only the sign is meant.
                assert!(
                    lost >= 0.0 || (plain < 0.0 && found < 0.0),
                    "{plain} {found}"
                );
                apart += usize::from(found > 0.0);
            }
        }
        assert!((400..3900).contains(&apart), "{apart}");
    }
}
