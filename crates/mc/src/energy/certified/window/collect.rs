//! Charges of straddling leaves that are inside for every member of the target are summed; those in
//! doubt are listed.

use super::super::leaves::LEAF;
use super::super::split::Split;
use super::contraction::Contraction;
use super::lists::Lists;
use super::sources::{Members, Sources, Target};
use super::{Bounded, CHUNK, LARGEST_RADIUS, MARGIN, UNIT};

/// The sums over the charges of straddling leaves.
struct Collected {
    inside: [f64; LEAF],
    inside_magnitude: [f32; LEAF],
    magnitude: [f32; LEAF],
}

/// Where charges of sixteen leaves are inside for the whole target leaf (t below the first) or
/// outside (t not below the second), Å².
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Shells {
    low: [f32; LEAF],
    high: [f32; LEAF],
}

/// What shells are made of: those of the target's bounding sphere, and its members.
struct Extent {
    low: f32,
    high: f32,
    minus_two: [[f32; LEAF]; 3],
    square: [f32; LEAF],
    /// Bound of 2 |δ·ε| and of rounding, Å².
    slack: f32,
}

impl Extent {
    /// The members' η, taken at the centre of a source leaf, and the slack bound t for all of its
    /// charges.
    #[inline(always)]
    fn shells(&self, shifts: [&[f32; LEAF]; 3]) -> Shells {
        let (mut least, mut largest) = ([f32::MAX; LEAF], [f32::MIN; LEAF]);
        for i in 0..LEAF {
            let (x, y, z) = (
                self.minus_two[0][i],
                self.minus_two[1][i],
                self.minus_two[2][i],
            );
            for lane in 0..LEAF {
                let eta = x.mul_add(
                    shifts[0][lane],
                    y.mul_add(shifts[1][lane], z.mul_add(shifts[2][lane], self.square[i])),
                );
                least[lane] = if eta < least[lane] { eta } else { least[lane] };
                largest[lane] = if eta > largest[lane] {
                    eta
                } else {
                    largest[lane]
                };
            }
        }
        let mut shells = Shells {
            low: [self.low; LEAF],
            high: [self.high; LEAF],
        };
        for lane in 0..LEAF {
            let (low, high) = (-largest[lane] - self.slack, self.slack - least[lane]);
            shells.low[lane] = if low > self.low { low } else { self.low };
            shells.high[lane] = if high < self.high { high } else { self.high };
        }
        shells
    }
}

/// Sums the charges of straddling leaves that are inside for every member of the target, and lists
/// those in doubt.
#[inline(always)]
pub fn collect<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    square: f64,
    t_error: f64,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Bounded {
    let (low, high) = (
        split.cutoff - target.radius - MARGIN,
        split.cutoff + target.radius + MARGIN,
    );
    let extent = Extent {
        low: if low > 0.0 {
            (low * low - square) as f32
        } else {
            f32::NEG_INFINITY
        },
        high: (high * high - square) as f32,
        minus_two: target.offset.map(|axis| axis.map(|d| -2.0 * d)),
        square: target.square.map(|v| v as f32),
        slack: (2.0 * target.radius * sources.radius + 4.0 * t_error) as f32,
    };
    let collected = select!(
        WIDE,
        collect_avx512,
        collect_any,
        (sources, &extent, contraction, lists)
    );
    lists.fill();
    let Collected {
        inside,
        inside_magnitude,
        magnitude,
    } = collected;
    let (k0, k1, k2) = (&contraction.k0, &contraction.k1, contraction.k2);
    let total = inside.iter().sum::<f64>();
    let add = |lanes: &[f32; LEAF]| lanes.iter().map(|lane| f64::from(*lane)).sum::<f64>() * 1.0001;
    // p falls with t; a listed charge is at most the target's diameter inside.
    let deepest = (split.cutoff - 2.0 * target.radius - MARGIN)
        .max(0.0)
        .powi(2)
        - square;
    let [c0, c1, c2] = split.step;
    let (largest, steepest) = (
        c0 + deepest * (c1 + deepest * c2),
        (c1 + 2.0 * c2 * deepest).abs(),
    );
    // Roundings of a listed pair's term: of a sum of CHUNK terms on average half of them, of p and
    // the charge, and of t.
    let term = (0.5 * CHUNK as f64 + 5.0) * UNIT * largest + steepest * t_error;
    // Of an inside charge's term: those of the parts of the polynomial, d among them, of the sum
    // and of t.
    let reach = split.cutoff + target.radius;
    let size = |k: &[f32]| k.iter().map(|k| f64::from(k.abs())).sum::<f64>();
    let depth = far_inside(split, target);
    let (slope, curvature) = (
        f64::from(k1[0].abs()) + size(&k1[1..]) * reach,
        f64::from(k2.abs()),
    );
    let constant =
        f64::from(k0[0].abs()) + size(&k0[1..4]) * reach + size(&k0[4..]) * reach * reach;
    let polynomial = constant + depth * (slope + depth * curvature);
    let inner = (0.5 * CHUNK as f64 + 15.0) * UNIT * polynomial
        + (slope + 2.0 * depth * curvature) * t_error;
    Bounded::of_one_part(
        total,
        target.magnitude * add(&magnitude) * term + add(&inside_magnitude) * inner,
    )
}

/// The loop over the straddling leaves.
#[inline(always)]
fn collect_any(
    sources: &Sources,
    extent: &Extent,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Collected {
    let (k0, k1, k2) = (&contraction.k0, &contraction.k1, contraction.k2);
    let mut sums = Collected {
        inside: [0.0; LEAF],
        inside_magnitude: [0.0; LEAF],
        magnitude: [0.0; LEAF],
    };
    let mut count = 0;
    for start in (0..lists.straddling).step_by(LEAF) {
        let axis = |axis: usize| lists.shifts[axis][start..].first_chunk::<LEAF>();
        let (Some(x), Some(y), Some(z)) = (axis(0), axis(1), axis(2)) else {
            continue;
        };
        let shells = extent.shells([x, y, z]);
        let mut inside = [0.0f32; LEAF];
        for at in start..(start + LEAF).min(lists.straddling) {
            let leaf = lists.leaves[at] as usize;
            let [shift_x, shift_y, shift_z, depth] =
                [0, 1, 2, 3].map(|axis: usize| lists.shifts[axis][at]);
            let Members([xs, ys, zs, squares, charges]) = &sources.members[leaf];
            for lane in 0..LEAF {
                let (x, y, z, charge) = (xs[lane], ys[lane], zs[lane], charges[lane]);
                let product = x.mul_add(shift_x, y.mul_add(shift_y, z * shift_z));
                let t = product.mul_add(2.0, squares[lane] + depth);
                let (x, y, z) = (x + shift_x, y + shift_y, z + shift_z);
                if t < shells.low[at - start] {
                    let linear = k0[1].mul_add(x, k0[2].mul_add(y, k0[3].mul_add(z, k0[0])));
                    let row_x = k0[4].mul_add(x, k0[7].mul_add(y, k0[8] * z));
                    let row_y = k0[5].mul_add(y, k0[9] * z);
                    let constant =
                        row_x.mul_add(x, row_y.mul_add(y, (k0[6] * z).mul_add(z, linear)));
                    let slope = k1[1].mul_add(x, k1[2].mul_add(y, k1[3].mul_add(z, k1[0])));
                    let value = k2.mul_add(t, slope).mul_add(t, constant);
                    inside[lane] = charge.mul_add(value, inside[lane]);
                    sums.inside_magnitude[lane] += charge.abs();
                } else if t < shells.high[at - start] {
                    sums.magnitude[lane] += charge.abs();
                    for (place, value) in lists.placed[at].0.iter_mut().zip([x, y, z, charge, t]) {
                        place[lane] = value;
                    }
                    lists.listed[count] = (at * LEAF + lane) as u32;
                    count += 1;
                }
            }
        }
        for lane in 0..LEAF {
            sums.inside[lane] += f64::from(inside[lane]);
        }
    }
    lists.count = count;
    sums
}

/// The same operations in the same order, sixteen charges at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi1")]
fn collect_avx512(
    sources: &Sources,
    extent: &Extent,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Collected {
    use std::arch::x86_64::*;
    let Lists {
        leaves,
        shifts: [xs, ys, zs, depths],
        straddling,
        placed,
        listed,
        ..
    } = lists;
    let two = _mm512_set1_ps(2.0);
    let k0 = contraction.k0.map(|k| _mm512_set1_ps(k));
    let k1 = contraction.k1.map(|k| _mm512_set1_ps(k));
    let k2 = _mm512_set1_ps(contraction.k2);
    let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let (mut inside_magnitude, mut magnitude) = (_mm512_setzero_ps(), _mm512_setzero_ps());
    let (mut inside_low, mut inside_high) = (_mm512_setzero_pd(), _mm512_setzero_pd());
    let mut count = 0;
    let blocks = leaves
        .as_chunks::<LEAF>()
        .0
        .iter()
        .zip(placed.as_chunks_mut::<LEAF>().0);
    let shifts = [xs, ys, zs, depths].map(|values| values.as_chunks::<LEAF>().0);
    let shifts = shifts[0]
        .iter()
        .zip(shifts[1])
        .zip(shifts[2])
        .zip(shifts[3]);
    for (block, ((leaves, placed), (((xs, ys), zs), depths))) in blocks.zip(shifts).enumerate() {
        let start = block * LEAF;
        if start >= *straddling {
            break;
        }
        let shells = extent.shells([xs, ys, zs]);
        let mut inside = _mm512_setzero_ps();
        for at in 0..(*straddling - start).min(LEAF) {
            let Some(members) = sources.members.get(leaves[at] as usize) else {
                continue;
            };
            let [shift_x, shift_y, shift_z, depth] =
                [xs[at], ys[at], zs[at], depths[at]].map(|v| _mm512_set1_ps(v));
            let (low, high) = (
                _mm512_set1_ps(shells.low[at]),
                _mm512_set1_ps(shells.high[at]),
            );
            // SAFETY: arrays of sixteen floats.
            let [x, y, z, square, charge] =
                unsafe { [0, 1, 2, 3, 4].map(|k: usize| _mm512_loadu_ps(members.0[k].as_ptr())) };
            let product = _mm512_fmadd_ps(
                x,
                shift_x,
                _mm512_fmadd_ps(y, shift_y, _mm512_mul_ps(z, shift_z)),
            );
            let t = _mm512_fmadd_ps(product, two, _mm512_add_ps(square, depth));
            let within = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, low);
            let doubtful = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, high) & !within;
            if within | doubtful == 0 {
                continue;
            }
            let (x, y, z) = (
                _mm512_add_ps(x, shift_x),
                _mm512_add_ps(y, shift_y),
                _mm512_add_ps(z, shift_z),
            );
            let size = _mm512_abs_ps(charge);
            if within != 0 {
                let fma = |a, b, c| _mm512_fmadd_ps(a, b, c);
                let linear = fma(k0[1], x, fma(k0[2], y, fma(k0[3], z, k0[0])));
                let row_x = fma(k0[4], x, fma(k0[7], y, _mm512_mul_ps(k0[8], z)));
                let row_y = fma(k0[5], y, _mm512_mul_ps(k0[9], z));
                let constant = fma(
                    row_x,
                    x,
                    fma(row_y, y, fma(_mm512_mul_ps(k0[6], z), z, linear)),
                );
                let slope = fma(k1[1], x, fma(k1[2], y, fma(k1[3], z, k1[0])));
                let value = fma(fma(k2, t, slope), t, constant);
                inside = _mm512_mask3_fmadd_ps(charge, value, inside, within);
                inside_magnitude =
                    _mm512_mask_add_ps(inside_magnitude, within, inside_magnitude, size);
            }
            if doubtful != 0 {
                magnitude = _mm512_mask_add_ps(magnitude, doubtful, magnitude, size);
                for (place, values) in placed[at].0.iter_mut().zip([x, y, z, charge, t]) {
                    // SAFETY: an array of sixteen floats.
                    unsafe { _mm512_storeu_ps(place.as_mut_ptr(), values) };
                }
                let places =
                    _mm512_add_epi32(lanes, _mm512_set1_epi32(((start + at) * LEAF) as i32));
                let room = &mut listed[count..count + LEAF];
                // SAFETY: `room` is sixteen integers long.
                unsafe {
                    _mm512_storeu_si512(
                        room.as_mut_ptr().cast(),
                        _mm512_maskz_compress_epi32(doubtful, places),
                    );
                }
                count += doubtful.count_ones() as usize;
            }
        }
        inside_low = _mm512_add_pd(inside_low, _mm512_cvtps_pd(_mm512_castps512_ps256(inside)));
        inside_high = _mm512_add_pd(
            inside_high,
            _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(inside)),
        );
    }
    lists.count = count;
    let mut sums = Collected {
        inside: [0.0; LEAF],
        inside_magnitude: [0.0; LEAF],
        magnitude: [0.0; LEAF],
    };
    // SAFETY: arrays of sixteen floats, and two halves of eight doubles of an array of sixteen.
    unsafe {
        _mm512_storeu_pd(sums.inside.as_mut_ptr(), inside_low);
        _mm512_storeu_pd(sums.inside.as_mut_ptr().add(8), inside_high);
        _mm512_storeu_ps(sums.inside_magnitude.as_mut_ptr(), inside_magnitude);
        _mm512_storeu_ps(sums.magnitude.as_mut_ptr(), magnitude);
    }
    sums
}

/// The largest |t| of a charge in a straddling leaf, Å².
fn far_inside(split: &Split, target: &Target) -> f64 {
    let square = split.cutoff * split.cutoff;
    square
        - (split.cutoff - 2.0 * target.radius - 4.0 * LARGEST_RADIUS)
            .max(0.0)
            .powi(2)
}
