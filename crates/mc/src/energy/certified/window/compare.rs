//! The charges in doubt, pair by pair.

use super::super::leaves::LEAF;
use super::super::split::Split;
use super::lists::{Lists, Placed};
use super::sources::{Sources, Target};
use super::{Bounded, CHUNK};

/// Compares the listed charges with every member of the target.
#[inline(always)]
pub fn compare<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    t_error: f64,
    lists: &Lists,
) -> Bounded {
    let minus_two = target.offset.map(|axis| axis.map(|d| -2.0 * d));
    let members = Offsets {
        minus_two,
        square: target.square.map(|v| v as f32),
        doubt: t_error as f32 * 1.0001,
    };
    let step = split.step.map(|c| c as f32);
    let mut doubt = Bounded::default();
    let mut exactly = |listed: &[u32]| {
        doubt.add(compare_exactly(
            sources,
            target,
            split,
            &lists.leaves,
            listed,
        ))
    };
    let sums = select!(
        WIDE,
        compare_avx512,
        compare_any,
        (&members, &step, lists, &mut exactly)
    );
    let value: f64 = sums
        .iter()
        .zip(&target.charge)
        .map(|(sum, charge)| sum * charge)
        .sum();
    Bounded {
        value: value + doubt.value,
        ..doubt
    }
}

/// The members of a target leaf for comparison: -2 δ, |δ|², and the |t| below which a sign is in
/// doubt.
struct Offsets {
    minus_two: [[f32; LEAF]; 3],
    square: [f32; LEAF],
    doubt: f32,
}

/// The loop over the listed charges; chunks with a t too close to zero go to `exactly`.
#[inline(always)]
fn compare_any(
    Offsets {
        minus_two,
        square,
        doubt,
    }: &Offsets,
    step: &[f32; 3],
    lists: &Lists,
    exactly: &mut impl FnMut(&[u32]),
) -> [f64; LEAF] {
    let mut sums = [0.0; LEAF];
    for start in (0..lists.count).step_by(CHUNK) {
        let mut sum = [0.0f32; LEAF];
        let mut nearest = [f32::MAX; LEAF];
        for place in &lists.listed[start..start + CHUNK] {
            let (leaf, lane) = (*place as usize / LEAF, *place as usize % LEAF);
            let [x, y, z, charge, t] = lists.placed[leaf].0.map(|values| values[lane]);
            for i in 0..LEAF {
                let t = minus_two[0][i].mul_add(
                    x,
                    minus_two[1][i].mul_add(y, minus_two[2][i].mul_add(z, square[i] + t)),
                );
                let p = step[2].mul_add(t, step[1]).mul_add(t, step[0]);
                sum[i] = if t < 0.0 {
                    charge.mul_add(p, sum[i])
                } else {
                    sum[i]
                };
                let magnitude = t.abs();
                nearest[i] = if magnitude < nearest[i] {
                    magnitude
                } else {
                    nearest[i]
                };
            }
        }
        if nearest.iter().any(|t| t < doubt) {
            exactly(&lists.listed[start..(start + CHUNK).min(lists.count)]);
        } else {
            for i in 0..LEAF {
                sums[i] += f64::from(sum[i]);
            }
        }
    }
    sums
}

/// The same operations in the same order, for sixteen members at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi1")]
fn compare_avx512(
    members: &Offsets,
    step: &[f32; 3],
    lists: &Lists,
    exactly: &mut impl FnMut(&[u32]),
) -> [f64; LEAF] {
    use std::arch::x86_64::*;
    // SAFETY: arrays of sixteen floats.
    let (d, square) = unsafe {
        (
            [0, 1, 2].map(|axis: usize| _mm512_loadu_ps(members.minus_two[axis].as_ptr())),
            _mm512_loadu_ps(members.square.as_ptr()),
        )
    };
    let step = step.map(|c| _mm512_set1_ps(c));
    let (zero, doubt) = (_mm512_setzero_ps(), _mm512_set1_ps(members.doubt));
    let (mut low, mut high) = (_mm512_setzero_pd(), _mm512_setzero_pd());
    let chunks = lists
        .listed
        .as_chunks::<CHUNK>()
        .0
        .iter()
        .take(lists.count.div_ceil(CHUNK));
    for (chunk, places) in chunks.enumerate() {
        let (mut sum, mut nearest) = (zero, _mm512_set1_ps(f32::MAX));
        for place in places {
            let (leaf, lane) = (*place as usize / LEAF, *place as usize % LEAF);
            let Some(Placed([x, y, z, charge, t])) = lists.placed.get(leaf) else {
                continue;
            };
            let t = _mm512_add_ps(square, _mm512_set1_ps(t[lane]));
            let t = _mm512_fmadd_ps(d[2], _mm512_set1_ps(z[lane]), t);
            let t = _mm512_fmadd_ps(d[1], _mm512_set1_ps(y[lane]), t);
            let t = _mm512_fmadd_ps(d[0], _mm512_set1_ps(x[lane]), t);
            let p = _mm512_fmadd_ps(_mm512_fmadd_ps(step[2], t, step[1]), t, step[0]);
            let inside = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, zero);
            sum = _mm512_mask3_fmadd_ps(_mm512_set1_ps(charge[lane]), p, sum, inside);
            // The smaller magnitude, without its sign.
            nearest = _mm512_range_ps::<0b1010>(t, nearest);
        }
        if _mm512_cmp_ps_mask::<_CMP_LT_OQ>(nearest, doubt) != 0 {
            exactly(&lists.listed[chunk * CHUNK..((chunk + 1) * CHUNK).min(lists.count)]);
        } else {
            low = _mm512_add_pd(low, _mm512_cvtps_pd(_mm512_castps512_ps256(sum)));
            high = _mm512_add_pd(high, _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(sum)));
        }
    }
    let mut sums = [0.0; LEAF];
    // SAFETY: two halves of eight doubles of an array of sixteen.
    unsafe {
        _mm512_storeu_pd(sums.as_mut_ptr(), low);
        _mm512_storeu_pd(sums.as_mut_ptr().add(8), high);
    }
    sums
}

/// The same for a few charges, in double precision; a pair within rounding of the cut-off counts as
/// error.
#[cold]
fn compare_exactly(
    sources: &Sources,
    target: &Target,
    split: &Split,
    leaves: &[u32],
    listed: &[u32],
) -> Bounded {
    let square = split.cutoff * split.cutoff;
    let [c0, c1, c2] = split.step;
    let mut sum = Bounded::default();
    for place in listed {
        let (leaf, lane) = (
            leaves[*place as usize / LEAF] as usize,
            *place as usize % LEAF,
        );
        let exact = &sources.exact[leaf];
        let charge = sources.charge[leaf][lane];
        for i in 0..LEAF {
            let d: [f64; 3] = std::array::from_fn(|a| {
                target.centre[a] + target.exact_offset[a][i] - exact[a][lane]
            });
            let t = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - square;
            let term = target.charge[i] * charge * (c0 + t * (c1 + t * c2));
            if t.abs() < 1e-8 {
                sum.error += term.abs();
                sum.square += term * term;
            }
            if t < 0.0 {
                sum.value += term;
            }
        }
    }
    sum
}
