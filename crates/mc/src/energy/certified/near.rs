//! Near pairs: Σ Z_i q_j (f - g)(r_ij) for r_ij < R, one by one. They are few and large, so they
//! are summed in double precision: in single precision their roundings would be most of an
//! interval's width.

use super::leaves::LEAF;
use super::split::{NEAR_DEGREE, Split};
use super::window::{Bounded, Sources, Target};
use protomer_kernel::potential::exp_of_minus;

/// What the loop needs of the kernel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NearKernel {
    radius: f64,
    bjerrum: f64,
    kappa: f64,
    near: [f64; NEAR_DEGREE + 1],
}

/// Bound of the error of one term, relative to (f + |g|) (2 + 40 Å²/t): tests hold the vector loop
/// against the portable one. The second part is that of t, found from parts of up to some 400 Å²,
/// in f.
const RELATIVE_ERROR: f64 = 1e-11;

impl NearKernel {
    pub fn new(split: &Split) -> Self {
        Self {
            radius: split.near_radius,
            bjerrum: split.bjerrum,
            kappa: split.kappa,
            near: split.near,
        }
    }

    /// The sum over the charges of these leaves.
    #[inline(always)]
    pub fn sum(&self, sources: &Sources, target: &Target, leaves: &[u32]) -> Bounded {
        let c = target.centre;
        let (reach, square) = (
            self.radius + target.radius + 1e-3,
            self.radius * self.radius,
        );
        let minus_two = target.exact_offset.map(|axis| axis.map(|d| -2.0 * d));
        // |x - y|² = |y - c|² + η, as at the cut-off.
        let (mut sums, mut bounds) = ([0.0f64; LEAF], [0.0f64; LEAF]);
        for leaf in leaves {
            let leaf = *leaf as usize;
            let exact = &sources.exact[leaf];
            for lane in 0..LEAF {
                let d: [f64; 3] = std::array::from_fn(|axis| exact[axis][lane] - c[axis]);
                let base = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                if base > reach * reach {
                    continue;
                }
                let charge = sources.charge[leaf][lane];
                for i in 0..LEAF {
                    let t = minus_two[0][i].mul_add(
                        d[0],
                        minus_two[1][i]
                            .mul_add(d[1], minus_two[2][i].mul_add(d[2], target.square[i] + base)),
                    );
                    let inverse = 1.0 / t.sqrt();
                    let f = self.bjerrum * exp_of_minus(self.kappa * (t * inverse)) * inverse;
                    let mut g = self.near[NEAR_DEGREE];
                    for k in (0..NEAR_DEGREE).rev() {
                        g = g.mul_add(t - square, self.near[k]);
                    }
                    // A t that is no number must come through.
                    let charge = if t >= square { 0.0 } else { charge };
                    sums[i] += if t >= square { 0.0 } else { charge * (f - g) };
                    let size = (f + g.abs()) * (40.0 * inverse).mul_add(inverse, 2.0);
                    bounds[i] += if t >= square {
                        0.0
                    } else {
                        charge.abs() * size
                    };
                }
            }
        }
        self.total(target, &sums, &bounds)
    }

    #[inline(always)]
    fn total(&self, target: &Target, sums: &[f64; LEAF], bounds: &[f64; LEAF]) -> Bounded {
        let value = sums
            .iter()
            .zip(&target.charge)
            .map(|(sum, charge)| sum * charge)
            .sum();
        let error = bounds
            .iter()
            .zip(&target.charge)
            .map(|(bound, charge)| bound * charge.abs())
            .sum::<f64>();
        Bounded::of_one_part(value, RELATIVE_ERROR * error)
    }

    /// The same with approximate roots, improved once, and a shorter series; rounds differently in
    /// the last places.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi1")]
    pub fn sum_avx512(&self, sources: &Sources, target: &Target, leaves: &[u32]) -> Bounded {
        use std::arch::x86_64::*;
        /// 1/n!, from n = 10 down.
        const SERIES: [f64; 11] = [
            1.0 / 3_628_800.0,
            1.0 / 362_880.0,
            1.0 / 40_320.0,
            1.0 / 5_040.0,
            1.0 / 720.0,
            1.0 / 120.0,
            1.0 / 24.0,
            1.0 / 6.0,
            0.5,
            1.0,
            1.0,
        ];
        const HALF: usize = LEAF / 2;
        let set = |value: f64| _mm512_set1_pd(value);
        let c = target.centre.map(set);
        let reach = self.radius + target.radius + 1e-3;
        let (reach, square) = (set(reach * reach), set(self.radius * self.radius));
        // SAFETY: eight doubles from 0 or 8 of an array of sixteen.
        let load = |values: &[f64; LEAF], half: usize| unsafe {
            _mm512_loadu_pd(values.as_ptr().add(HALF * half))
        };
        let minus_two = [0, 1].map(|half| {
            [0, 1, 2]
                .map(|axis: usize| _mm512_mul_pd(set(-2.0), load(&target.exact_offset[axis], half)))
        });
        let own = [0, 1].map(|half| load(&target.square, half));
        let (mut sums, mut bounds) = ([_mm512_setzero_pd(); 2], [_mm512_setzero_pd(); 2]);
        for leaf in leaves {
            let leaf = *leaf as usize;
            let (exact, charges) = (&sources.exact[leaf], &sources.charge[leaf]);
            let mut places = [[0.0f64; LEAF]; 4];
            let mut close = 0u16;
            for half in 0..2 {
                let d =
                    [0, 1, 2].map(|axis: usize| _mm512_sub_pd(load(&exact[axis], half), c[axis]));
                let base = _mm512_fmadd_pd(
                    d[0],
                    d[0],
                    _mm512_fmadd_pd(d[1], d[1], _mm512_mul_pd(d[2], d[2])),
                );
                close |= u16::from(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(base, reach)) << (HALF * half);
                for (place, value) in places.iter_mut().zip([d[0], d[1], d[2], base]) {
                    // SAFETY: eight doubles from 0 or 8 of an array of sixteen.
                    unsafe { _mm512_storeu_pd(place.as_mut_ptr().add(HALF * half), value) };
                }
            }
            while close != 0 {
                let lane = close.trailing_zeros() as usize;
                close &= close - 1;
                let [x, y, z, base] = [0, 1, 2, 3].map(|k: usize| set(places[k][lane]));
                let charge = set(charges[lane]);
                for half in 0..2 {
                    let [ax, ay, az] = minus_two[half];
                    let t = _mm512_fmadd_pd(az, z, _mm512_add_pd(own[half], base));
                    let t = _mm512_fmadd_pd(ax, x, _mm512_fmadd_pd(ay, y, t));
                    // "Not above" keeps a t that is no number.
                    let within = _mm512_cmp_pd_mask::<_CMP_NGE_UQ>(t, square);
                    if within == 0 {
                        continue;
                    }
                    // y (1 + h/2 + 3 h²/8) with h = 1 - t y²: an error of 2⁻¹⁴ becomes one of
                    // 5e-13.
                    let rough = _mm512_rsqrt14_pd(t);
                    let h = _mm512_fnmadd_pd(_mm512_mul_pd(t, rough), rough, set(1.0));
                    let correction = _mm512_mul_pd(h, _mm512_fmadd_pd(set(0.375), h, set(0.5)));
                    let inverse = _mm512_fmadd_pd(rough, correction, rough);
                    let x = _mm512_mul_pd(set(-self.kappa), _mm512_mul_pd(t, inverse));
                    let n =
                        _mm512_roundscale_pd::<0>(_mm512_mul_pd(x, set(std::f64::consts::LOG2_E)));
                    let rest = _mm512_fnmadd_pd(n, set(std::f64::consts::LN_2), x);
                    let mut series = set(SERIES[0]);
                    for coefficient in &SERIES[1..] {
                        series = _mm512_fmadd_pd(series, rest, set(*coefficient));
                    }
                    let f = _mm512_mul_pd(
                        _mm512_scalef_pd(series, n),
                        _mm512_mul_pd(set(self.bjerrum), inverse),
                    );
                    let s = _mm512_sub_pd(t, square);
                    let mut g = set(self.near[NEAR_DEGREE]);
                    for k in (0..NEAR_DEGREE).rev() {
                        g = _mm512_fmadd_pd(g, s, set(self.near[k]));
                    }
                    sums[half] =
                        _mm512_mask3_fmadd_pd(charge, _mm512_sub_pd(f, g), sums[half], within);
                    let slope =
                        _mm512_fmadd_pd(_mm512_mul_pd(set(40.0), inverse), inverse, set(2.0));
                    let size = _mm512_mul_pd(_mm512_add_pd(f, _mm512_abs_pd(g)), slope);
                    bounds[half] =
                        _mm512_mask3_fmadd_pd(_mm512_abs_pd(charge), size, bounds[half], within);
                }
            }
        }
        let store = |halves: [__m512d; 2]| {
            let mut values = [0.0; LEAF];
            // SAFETY: two halves of eight doubles of an array of sixteen.
            unsafe {
                _mm512_storeu_pd(values.as_mut_ptr(), halves[0]);
                _mm512_storeu_pd(values.as_mut_ptr().add(HALF), halves[1]);
            }
            values
        };
        self.total(target, &store(sums), &store(bounds))
    }
}

#[cfg(test)]
mod tests {
    use super::super::leaves::Leaves;
    use super::*;
    use crate::charges::ChargeCloud;
    use protomer_kernel::Vec3;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;

    /// Against the double loop over places, with a bound that is far below the sum of the terms'
    /// magnitudes.
    #[test]
    fn every_instruction_set_gives_the_double_loop_within_the_bound() {
        let mut rng = CounterRng::new(43, 0, 0);
        for kappa in [0.0, 1.0 / 9.6, 1.0] {
            let Ok(yukawa) = Yukawa::new(7.0, kappa, 48.0) else {
                continue;
            };
            let split = Split::new(&yukawa, 10.0);
            let kernel = NearKernel::new(&split);
            let charges: Vec<(Vec3, f64)> = (0..200)
                .map(|_| (rng.vector_in_ball(12.0), rng.uniform_in(-0.6, 0.6)))
                .collect();
            let leaves = Leaves::new(&ChargeCloud::new(&charges), 5.0);
            let sources = Sources::new(&leaves);
            let every: Vec<u32> = (0..leaves.len() as u32).collect();
            for _ in 0..50 {
                let centre: [f64; 3] = rng.vector_in_ball(20.0).into();
                let mut target = Target {
                    centre,
                    radius: 4.0,
                    ..Target::default()
                };
                for lane in 0..LEAF {
                    let offset: [f64; 3] = rng.vector_in_ball(4.0).into();
                    target.charge[lane] = rng.uniform_in(-0.6, 0.6);
                    target.square[lane] = offset.iter().map(|d| d * d).sum();
                    for axis in 0..3 {
                        target.exact_offset[axis][lane] = offset[axis];
                    }
                }
                let (mut sum, mut size) = (0.0, 0.0);
                for (leaf, lane, i) in every_pair(leaves.len()) {
                    let place = [
                        leaves.x[leaf][lane],
                        leaves.y[leaf][lane],
                        leaves.z[leaf][lane],
                    ];
                    let t: f64 = (0..3)
                        .map(|axis| {
                            (centre[axis] + target.exact_offset[axis][i] - place[axis]).powi(2)
                        })
                        .sum();
                    if t < 100.0 {
                        let g = (0..=NEAR_DEGREE)
                            .rev()
                            .fold(0.0, |g, k| g * (t - 100.0) + split.near[k]);
                        let term = target.charge[i]
                            * leaves.charge[leaf][lane]
                            * (split.bjerrum * (-kappa * t.sqrt()).exp() / t.sqrt() - g);
                        sum += term;
                        size += term.abs();
                    }
                }
                let check = |found: Bounded| {
                    assert!(
                        (found.value - sum).abs() <= found.error + 1e-14 * size,
                        "{found:?} {sum}"
                    );
                    assert!(found.error <= 1e-6 * size + 1e-9, "{found:?} {size}");
                };
                check(kernel.sum(&sources, &target, &every));
                #[cfg(target_arch = "x86_64")]
                if is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("popcnt")
                    && is_x86_feature_detected!("bmi1")
                {
                    // SAFETY: the processor has the features the function is compiled for.
                    check(unsafe { kernel.sum_avx512(&sources, &target, &every) });
                }
            }
        }
    }

    /// Every leaf, lane and member.
    fn every_pair(leaves: usize) -> impl Iterator<Item = (usize, usize, usize)> {
        (0..leaves * LEAF * LEAF).map(|n| (n / LEAF / LEAF, n / LEAF % LEAF, n % LEAF))
    }
}
