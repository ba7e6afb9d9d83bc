//! Which source leaves are inside the cut-off for a target leaf, straddle it, or have near pairs.

use super::super::leaves::LEAF;
use super::super::split::Split;
use super::MARGIN;
use super::lists::Lists;
use super::sources::{MOMENTS, Sources, Target};

/// How leaves lie to a target leaf.
#[derive(Clone, Copy)]
struct Reach {
    cutoff: f64,
    near: f64,
    /// Of the target, and a margin.
    radius: f64,
    square: f64,
}

impl Reach {
    /// Without a cut-off every leaf is inside.
    fn new(target: &Target, split: &Split) -> Self {
        let cutoff = if split.cutoff.is_finite() {
            split.cutoff
        } else {
            1e8
        };
        Self {
            cutoff,
            near: split.near_radius,
            radius: target.radius + MARGIN,
            square: cutoff * cutoff,
        }
    }
}

/// Sums the leaves wholly inside; lists those that straddle the cut-off and those with near pairs.
#[inline(always)]
pub fn classify<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    global: &[f64; MOMENTS],
    lists: &mut Lists,
) -> f64 {
    select!(
        WIDE,
        classify_avx512,
        classify_any,
        (sources, target, split, global, lists)
    )
}

/// Leaf by leaf.
#[inline(always)]
fn classify_any(
    sources: &Sources,
    target: &Target,
    split: &Split,
    global: &[f64; MOMENTS],
    lists: &mut Lists,
) -> f64 {
    let (c, of) = (target.centre, Reach::new(target, split));
    let mut inside = [0.0f64; LEAF];
    (lists.straddling, lists.near) = (0, 0);
    for (block, (sphere, moments)) in sources.spheres.iter().zip(&sources.moments).enumerate() {
        let mut weight = [0.0f64; LEAF];
        for lane in 0..LEAF {
            let d: [f64; 3] = std::array::from_fn(|axis| sphere[axis][lane] - c[axis]);
            let square = d[0].mul_add(d[0], d[1].mul_add(d[1], d[2] * d[2]));
            let reach = of.radius + sphere[3][lane];
            let (high, low, close) = (
                of.cutoff + reach,
                (of.cutoff - reach).max(0.0),
                of.near + reach,
            );
            let within = square < low * low;
            weight[lane] = if within { 1.0 } else { 0.0 };
            let leaf = (block * LEAF + lane) as u32;
            if square < high * high && !within {
                lists.leaves[lists.straddling] = leaf;
                for (list, value) in
                    lists
                        .shifts
                        .iter_mut()
                        .zip([d[0], d[1], d[2], square - of.square])
                {
                    list[lists.straddling] = value as f32;
                }
                lists.straddling += 1;
            }
            if square < close * close {
                lists.near_leaves[lists.near] = leaf;
                lists.near += 1;
            }
        }
        if weight.iter().any(|w| *w > 0.0) {
            let mut value = [0.0f64; LEAF];
            for (coefficient, moment) in global.iter().zip(moments) {
                for lane in 0..LEAF {
                    value[lane] = coefficient.mul_add(moment[lane], value[lane]);
                }
            }
            for lane in 0..LEAF {
                inside[lane] += weight[lane] * value[lane];
            }
        }
    }
    (0..LEAF / 2)
        .map(|lane| inside[lane] + inside[lane + LEAF / 2])
        .sum()
}

/// The same, sixteen leaves at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi1")]
fn classify_avx512(
    sources: &Sources,
    target: &Target,
    split: &Split,
    global: &[f64; MOMENTS],
    lists: &mut Lists,
) -> f64 {
    use std::arch::x86_64::*;
    let of = Reach::new(target, split);
    let c = target.centre.map(|c| _mm512_set1_pd(c));
    let [cutoff, near, radius, cut_square] =
        [of.cutoff, of.near, of.radius, of.square].map(|value| _mm512_set1_pd(value));
    let zero = _mm512_setzero_pd();
    let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let mut inside = [zero; 2];
    (lists.straddling, lists.near) = (0, 0);
    for (block, (sphere, moments)) in sources.spheres.iter().zip(&sources.moments).enumerate() {
        let mut shifts = [[_mm256_setzero_ps(); 2]; 4];
        let (mut within, mut touched, mut close) = ([0u8; 2], [0u8; 2], [0u8; 2]);
        for half in 0..2 {
            // SAFETY: eight doubles from 0 or 8 of an array of sixteen.
            let [x, y, z, size] = [0, 1, 2, 3]
                .map(|axis: usize| unsafe { _mm512_loadu_pd(sphere[axis].as_ptr().add(8 * half)) });
            let d = [
                _mm512_sub_pd(x, c[0]),
                _mm512_sub_pd(y, c[1]),
                _mm512_sub_pd(z, c[2]),
            ];
            let square = _mm512_fmadd_pd(
                d[0],
                d[0],
                _mm512_fmadd_pd(d[1], d[1], _mm512_mul_pd(d[2], d[2])),
            );
            let reach = _mm512_add_pd(radius, size);
            let (high, close_to) = (_mm512_add_pd(cutoff, reach), _mm512_add_pd(near, reach));
            let low = _mm512_max_pd(_mm512_sub_pd(cutoff, reach), zero);
            within[half] = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, _mm512_mul_pd(low, low));
            touched[half] =
                _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, _mm512_mul_pd(high, high)) & !within[half];
            close[half] =
                _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, _mm512_mul_pd(close_to, close_to));
            let values = [d[0], d[1], d[2], _mm512_sub_pd(square, cut_square)];
            for (shift, value) in shifts.iter_mut().zip(values) {
                shift[half] = _mm512_cvtpd_ps(value);
            }
        }
        let places = _mm512_add_epi32(lanes, _mm512_set1_epi32((block * LEAF) as i32));
        let touched = u16::from_le_bytes(touched);
        if touched != 0 {
            let room = &mut lists.leaves[lists.straddling..lists.straddling + LEAF];
            // SAFETY: `room` is sixteen integers long.
            unsafe {
                _mm512_storeu_si512(
                    room.as_mut_ptr().cast(),
                    _mm512_maskz_compress_epi32(touched, places),
                )
            };
            for (list, [low, high]) in lists.shifts.iter_mut().zip(shifts) {
                let values = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high);
                let room = &mut list[lists.straddling..lists.straddling + LEAF];
                // SAFETY: `room` is sixteen floats long.
                unsafe {
                    _mm512_storeu_ps(room.as_mut_ptr(), _mm512_maskz_compress_ps(touched, values))
                };
            }
            lists.straddling += touched.count_ones() as usize;
        }
        let close = u16::from_le_bytes(close);
        if close != 0 {
            let room = &mut lists.near_leaves[lists.near..lists.near + LEAF];
            // SAFETY: `room` is sixteen integers long.
            unsafe {
                _mm512_storeu_si512(
                    room.as_mut_ptr().cast(),
                    _mm512_maskz_compress_epi32(close, places),
                )
            };
            lists.near += close.count_ones() as usize;
        }
        for half in 0..2 {
            if within[half] == 0 {
                continue;
            }
            let mut value = zero;
            for (coefficient, moment) in global.iter().zip(moments) {
                // SAFETY: eight doubles from 0 or 8 of an array of sixteen.
                let moment = unsafe { _mm512_loadu_pd(moment.as_ptr().add(8 * half)) };
                value = _mm512_fmadd_pd(_mm512_set1_pd(*coefficient), moment, value);
            }
            inside[half] = _mm512_mask_add_pd(inside[half], within[half], inside[half], value);
        }
    }
    let mut sums = [0.0; LEAF / 2];
    // SAFETY: an array of eight doubles.
    unsafe { _mm512_storeu_pd(sums.as_mut_ptr(), _mm512_add_pd(inside[0], inside[1])) };
    sums.iter().sum()
}
