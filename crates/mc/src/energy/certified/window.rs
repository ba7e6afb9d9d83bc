//! The step at the cut-off: Σ Z_i q_j p(t_ij) θ(-t_ij) with t = r² - r_cut², for one target leaf and all source leaves.
//!
//! Source leaves wholly inside enter by their moments, in double precision; of the straddling ones, charges that are
//! inside for the whole target leaf enter by the leaf's moments; what is left is compared pair by pair. With c the centre
//! of the target leaf and δ_i its members' offsets, s the centre of a source leaf and ε_j its members' offsets,
//! D = s - c and d_j = ε_j + D,
//!
//! ```text
//! t_ij = t_j + η_ij,   t_j = (|D|² - r_cut²) + |ε_j|² + 2 ε_j·D,   η_ij = |δ_i|² - 2 δ_i·d_j
//! ```
//!
//! D and the bracket are found in double precision, the rest in single: all its parts are at most as large as a leaf's
//! diameter times the cut-off, however large the bodies are.

use super::leaves::{LEAF, Leaves};
use super::near::NearKernel;
use super::split::Split;

/// Entries of a list, and straddling leaves, between two transfers of a sum to double precision.
const CHUNK: usize = 16;
/// Margin of distances in the classification of leaves, Å.
const MARGIN: f64 = 1e-3;
/// Moments of a leaf.
pub(super) const MOMENTS: usize = 14;
/// The t of entries that fill a list up: beyond any cut-off.
const FILLER: f32 = 1e9;

/// Source leaves as the loops want them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sources {
    /// Members by leaf.
    members: Vec<Members>,
    /// The largest radius of a leaf, Å.
    radius: f64,
    /// The members' places in double precision.
    pub exact: Vec<[[f64; LEAF]; 3]>,
    /// The members' charges, e.
    pub charge: Vec<[f64; LEAF]>,
    /// Bounding spheres, sixteen leaves at a time; missing ones are infinitely far.
    spheres: Vec<[[f64; LEAF]; 4]>,
    /// Moments about the middle of the charges' box, sixteen leaves at a time.
    moments: Vec<[[f64; LEAF]; MOMENTS]>,
}

/// Offsets of a leaf's members from its centre, their squares, and charges: x, y, z, |ε|², q.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
struct Members([[f32; LEAF]; 5]);

/// A leaf of the other body where it stands.
#[derive(Default)]
pub(super) struct Target {
    /// Centre and radius of the bounding sphere, Å.
    pub centre: [f64; 3],
    pub radius: f64,
    /// Offsets of the members from the centre, Å.
    pub offset: [[f32; LEAF]; 3],
    pub exact_offset: [[f64; LEAF]; 3],
    /// |δ|², Å².
    pub square: [f64; LEAF],
    /// Charges, e, and the sum of their magnitudes.
    pub charge: [f64; LEAF],
    pub magnitude: f64,
    /// The moments of the leaf about its centre.
    pub moments: [f64; MOMENTS],
}

/// Calls the first function where the processor's vectors are WIDE, the second otherwise.
macro_rules! select {
    ($wide:ident, $vector:path, $any:path, ($($argument:expr),*)) => {{
        #[cfg(target_arch = "x86_64")]
        let result = if $wide {
            // SAFETY: WIDE says that the processor has the features.
            unsafe { $vector($($argument),*) }
        } else {
            $any($($argument),*)
        };
        #[cfg(not(target_arch = "x86_64"))]
        let result = $any($($argument),*);
        result
    }};
}

/// Reusable lists.
#[derive(Debug, Default)]
pub(super) struct Lists {
    /// Leaves that straddle the cut-off, with D and |D|² - r_cut².
    leaves: Vec<u32>,
    shifts: [Vec<f32>; 4],
    straddling: usize,
    /// Leaves that may have near pairs.
    near_leaves: Vec<u32>,
    near: usize,
    /// The charges of straddling leaves by their place in `leaves`; one more place is filled with what has no effect.
    placed: Vec<Placed>,
    /// Charges to compare: [`LEAF`] times the place in `leaves`, and the place in the leaf.
    listed: Vec<u32>,
    count: usize,
}

/// Charges where they stand: d, charge and t.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
struct Placed([[f32; LEAF]; 5]);

impl Lists {
    /// Room for everything that these sources can put in; vectors may be stored past the last entry.
    pub fn new(sources: &Sources) -> Self {
        let leaves = sources.spheres.len() * LEAF + LEAF;
        Self {
            leaves: vec![0; leaves],
            shifts: std::array::from_fn(|_| vec![0.0; leaves]),
            near_leaves: vec![0; leaves],
            placed: vec![Placed::default(); leaves],
            listed: vec![0; leaves * LEAF + CHUNK],
            ..Self::default()
        }
    }

    /// Fills the last chunk up with charges of no effect.
    #[inline(always)]
    fn fill(&mut self) {
        self.placed[self.straddling] = Placed([[0.0; LEAF], [0.0; LEAF], [0.0; LEAF], [0.0; LEAF], [FILLER; LEAF]]);
        self.listed[self.count..self.count + CHUNK].fill((self.straddling * LEAF) as u32);
    }
}

/// A sum with its bound, kT, and the sum of the squares of the bounds of its independent parts, kT².
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounded {
    pub value: f64,
    pub error: f64,
    pub square: f64,
}

/// Σ q (1, y, y², y y, |y|² y, |y|⁴) in the order 1, x, y, z, xx, yy, zz, xy, xz, yz, bx, by, bz, bb with b = |y|².
pub(super) fn moments(places: [&[f64; LEAF]; 3], charge: &[f64; LEAF]) -> [f64; MOMENTS] {
    let mut sums = [0.0; MOMENTS];
    for i in 0..LEAF {
        let (x, y, z, q) = (places[0][i], places[1][i], places[2][i], charge[i]);
        let b = x * x + y * y + z * z;
        let values = [1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z, b * x, b * y, b * z, b * b];
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += q * value;
        }
    }
    sums
}

impl Sources {
    pub fn new(leaves: &Leaves) -> Self {
        let blocks = leaves.len().div_ceil(LEAF);
        let (mut spheres, mut all_moments) =
            (vec![[[1e9; LEAF], [1e9; LEAF], [1e9; LEAF], [0.0; LEAF]]; blocks], vec![[[0.0; LEAF]; MOMENTS]; blocks]);
        let (mut exact, mut members) = (Vec::new(), Vec::new());
        for leaf in 0..leaves.len() {
            let places = [leaves.x[leaf], leaves.y[leaf], leaves.z[leaf]];
            let centre = leaves.spheres[leaf];
            let offset: [[f64; LEAF]; 3] =
                std::array::from_fn(|axis| std::array::from_fn(|i| places[axis][i] - centre[axis]));
            let square: [f64; LEAF] = std::array::from_fn(|i| offset.iter().map(|axis| axis[i] * axis[i]).sum());
            let [x, y, z] = offset;
            members.push(Members([x, y, z, square, leaves.charge[leaf]].map(|values| values.map(|v| v as f32))));
            for axis in 0..4 {
                spheres[leaf / LEAF][axis][leaf % LEAF] = centre[axis];
            }
            let [x, y, z] = &places;
            for (k, moment) in moments([x, y, z], &leaves.charge[leaf]).into_iter().enumerate() {
                all_moments[leaf / LEAF][k][leaf % LEAF] = moment;
            }
            exact.push(places);
        }
        let radius = leaves.spheres.iter().map(|sphere| sphere[3]).fold(0.0, f64::max);
        Self { members, radius, exact, charge: leaves.charge.clone(), spheres, moments: all_moments }
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&self.members[..])
            + size_of_val(&self.exact[..])
            + size_of_val(&self.charge[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.moments[..])
    }
}

/// Coefficients of Σ_i Z_i p(t_ij): as a polynomial of y in the order of [`moments`], and for charges one by one.
struct Contraction {
    global: [f64; MOMENTS],
    /// p summed = k0 + t (k1 + t k2), k0 and k1 polynomials of d, t that of the centre.
    k0: [f32; 10],
    k1: [f32; 4],
    k2: f32,
}

impl Contraction {
    fn new(target: &Target, split: &Split, square: f64) -> Self {
        let [c0, c1, c2] = split.step;
        let c = target.centre;
        let m = &target.moments;
        let (q, d, o, h) = (m[0], [m[1], m[2], m[3]], [m[10], m[11], m[12]], m[13]);
        let quadratic = [[m[4], m[7], m[8]], [m[7], m[5], m[9]], [m[8], m[9], m[6]]];
        let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let qc = [dot(&quadratic[0], &c), dot(&quadratic[1], &c), dot(&quadratic[2], &c)];
        let e = m[4] + m[5] + m[6] + 2.0 * dot(&d, &c);
        let f: [f64; 3] = std::array::from_fn(|i| o[i] + 2.0 * qc[i]);
        let ee = h + 4.0 * dot(&o, &c) + 4.0 * dot(&c, &qc);
        let (k, k2) = (c1 * q + 2.0 * c2 * e, c2 * q);
        let l = d.map(|d| -4.0 * c2 * d);
        let g = c.map(|c| -2.0 * c);
        let a = dot(&c, &c) - square;
        let constant = c0 * q + c1 * e + c2 * ee;
        let linear: [f64; 3] = std::array::from_fn(|i| -2.0 * c1 * d[i] - 4.0 * c2 * f[i]);
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        // Off the diagonal both orders count.
        let twice = |i: usize, j: usize| if i == j { 1.0 } else { 2.0 };
        let own: [f64; 6] = pairs.map(|(i, j)| 4.0 * c2 * twice(i, j) * quadratic[i][j]);
        let mut global = [0.0; MOMENTS];
        global[0] = constant + k * a + k2 * a * a;
        for i in 0..3 {
            global[1 + i] = linear[i] + k * g[i] + a * l[i] + 2.0 * k2 * a * g[i];
            global[10 + i] = l[i] + 2.0 * k2 * g[i];
        }
        for (n, (i, j)) in pairs.into_iter().enumerate() {
            let mixed = if i == j { l[i] * g[i] } else { l[i] * g[j] + l[j] * g[i] };
            global[4 + n] = own[n] + mixed + k2 * twice(i, j) * g[i] * g[j];
            if i == j {
                global[4 + n] += k + 2.0 * k2 * a;
            }
        }
        global[13] = k2;
        let trace = m[4] + m[5] + m[6];
        let mut k0 = [(c0 * q + c1 * trace + c2 * h) as f32; 10];
        for i in 0..3 {
            k0[1 + i] = (-2.0 * c1 * d[i] - 4.0 * c2 * o[i]) as f32;
        }
        for n in 0..6 {
            k0[4 + n] = own[n] as f32;
        }
        let k = c1 * q + 2.0 * c2 * trace;
        Self { global, k0, k1: [k as f32, l[0] as f32, l[1] as f32, l[2] as f32], k2: k2 as f32 }
    }
}

/// The step's and the near pairs' contributions of one target leaf, kT.
#[inline(always)]
pub(super) fn sum_target<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    near: &NearKernel,
    lists: &mut Lists,
) -> Bounded {
    let finite = split.cutoff.is_finite();
    let square = if finite { split.cutoff * split.cutoff } else { 0.0 };
    let contraction = Contraction::new(target, split, square);
    let inside = select!(WIDE, classify_avx512, classify_any, (sources, target, split, &contraction.global, lists));
    let mut sum = Bounded { value: inside, ..Bounded::default() };
    if lists.straddling > 0 {
        let t_error = t_error(split, target.radius.max(sources.radius));
        sum.add(collect::<WIDE>(sources, target, split, square, t_error, &contraction, lists));
        sum.add(compare::<WIDE>(sources, target, split, t_error, lists));
    }
    if lists.near > 0 {
        let leaves = &lists.near_leaves[..lists.near];
        sum.add(select!(WIDE, NearKernel::sum_avx512, NearKernel::sum, (near, sources, target, leaves)));
    }
    sum
}

/// Bound of the error of a single-precision t, Å²; below it its sign is not trusted. With the largest part
/// W = 2 radius (r_cut + 2 radius), which bounds |t_j| of listed charges, 2 |ε·D|, and 2 |δ·d|, the roundings are those of
/// D, ε, |ε|² (3 W), of the terms of t_j (3 W) and its last sum (4 W: |D|² - r_cut² is at most 2 W), of d and δ (3 W), of
/// the sum with |δ|² (1 W) and of the three products (6 W).
fn t_error(split: &Split, radius: f64) -> f64 {
    20.0 * UNIT * 2.0 * radius * (split.cutoff + 2.0 * radius)
}

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
        let cutoff = if split.cutoff.is_finite() { split.cutoff } else { 1e8 };
        Self { cutoff, near: split.near_radius, radius: target.radius + MARGIN, square: cutoff * cutoff }
    }
}

/// Sums the leaves wholly inside; lists those that straddle the cut-off and those with near pairs.
#[inline(always)]
fn classify_any(sources: &Sources, target: &Target, split: &Split, global: &[f64; MOMENTS], lists: &mut Lists) -> f64 {
    let (c, of) = (target.centre, Reach::new(target, split));
    let mut inside = [0.0f64; LEAF];
    (lists.straddling, lists.near) = (0, 0);
    for (block, (sphere, moments)) in sources.spheres.iter().zip(&sources.moments).enumerate() {
        let mut weight = [0.0f64; LEAF];
        for lane in 0..LEAF {
            let d: [f64; 3] = std::array::from_fn(|axis| sphere[axis][lane] - c[axis]);
            let square = d[0].mul_add(d[0], d[1].mul_add(d[1], d[2] * d[2]));
            let reach = of.radius + sphere[3][lane];
            let (high, low, close) = (of.cutoff + reach, (of.cutoff - reach).max(0.0), of.near + reach);
            let within = square < low * low;
            weight[lane] = if within { 1.0 } else { 0.0 };
            let leaf = (block * LEAF + lane) as u32;
            if square < high * high && !within {
                lists.leaves[lists.straddling] = leaf;
                for (list, value) in lists.shifts.iter_mut().zip([d[0], d[1], d[2], square - of.square]) {
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
    (0..LEAF / 2).map(|lane| inside[lane] + inside[lane + LEAF / 2]).sum()
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
            let [x, y, z, size] =
                [0, 1, 2, 3].map(|axis: usize| unsafe { _mm512_loadu_pd(sphere[axis].as_ptr().add(8 * half)) });
            let d = [_mm512_sub_pd(x, c[0]), _mm512_sub_pd(y, c[1]), _mm512_sub_pd(z, c[2])];
            let square = _mm512_fmadd_pd(d[0], d[0], _mm512_fmadd_pd(d[1], d[1], _mm512_mul_pd(d[2], d[2])));
            let reach = _mm512_add_pd(radius, size);
            let (high, close_to) = (_mm512_add_pd(cutoff, reach), _mm512_add_pd(near, reach));
            let low = _mm512_max_pd(_mm512_sub_pd(cutoff, reach), zero);
            within[half] = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, _mm512_mul_pd(low, low));
            touched[half] = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, _mm512_mul_pd(high, high)) & !within[half];
            close[half] = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(square, _mm512_mul_pd(close_to, close_to));
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
            unsafe { _mm512_storeu_si512(room.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(touched, places)) };
            for (list, [low, high]) in lists.shifts.iter_mut().zip(shifts) {
                let values = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high);
                let room = &mut list[lists.straddling..lists.straddling + LEAF];
                // SAFETY: `room` is sixteen floats long.
                unsafe { _mm512_storeu_ps(room.as_mut_ptr(), _mm512_maskz_compress_ps(touched, values)) };
            }
            lists.straddling += touched.count_ones() as usize;
        }
        let close = u16::from_le_bytes(close);
        if close != 0 {
            let room = &mut lists.near_leaves[lists.near..lists.near + LEAF];
            // SAFETY: `room` is sixteen integers long.
            unsafe { _mm512_storeu_si512(room.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(close, places)) };
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

/// The sums over the charges of straddling leaves.
struct Collected {
    inside: [f64; LEAF],
    inside_magnitude: [f32; LEAF],
    magnitude: [f32; LEAF],
}

/// Where charges of sixteen leaves are inside for the whole target leaf (t below the first) or outside (t not below the
/// second), Å².
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
    /// The members' η, taken at the centre of a source leaf, and the slack bound t for all of its charges.
    #[inline(always)]
    fn shells(&self, shifts: [&[f32; LEAF]; 3]) -> Shells {
        let (mut least, mut largest) = ([f32::MAX; LEAF], [f32::MIN; LEAF]);
        for i in 0..LEAF {
            let (x, y, z) = (self.minus_two[0][i], self.minus_two[1][i], self.minus_two[2][i]);
            for lane in 0..LEAF {
                let eta =
                    x.mul_add(shifts[0][lane], y.mul_add(shifts[1][lane], z.mul_add(shifts[2][lane], self.square[i])));
                least[lane] = if eta < least[lane] { eta } else { least[lane] };
                largest[lane] = if eta > largest[lane] { eta } else { largest[lane] };
            }
        }
        let mut shells = Shells { low: [self.low; LEAF], high: [self.high; LEAF] };
        for lane in 0..LEAF {
            let (low, high) = (-largest[lane] - self.slack, self.slack - least[lane]);
            shells.low[lane] = if low > self.low { low } else { self.low };
            shells.high[lane] = if high < self.high { high } else { self.high };
        }
        shells
    }
}

/// Sums the charges of straddling leaves that are inside for every member of the target, and lists those in doubt.
#[inline(always)]
fn collect<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    square: f64,
    t_error: f64,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Bounded {
    let (low, high) = (split.cutoff - target.radius - MARGIN, split.cutoff + target.radius + MARGIN);
    let extent = Extent {
        low: if low > 0.0 { (low * low - square) as f32 } else { f32::NEG_INFINITY },
        high: (high * high - square) as f32,
        minus_two: target.offset.map(|axis| axis.map(|d| -2.0 * d)),
        square: target.square.map(|v| v as f32),
        slack: (2.0 * target.radius * sources.radius + 4.0 * t_error) as f32,
    };
    let collected = select!(WIDE, collect_avx512, collect_any, (sources, &extent, contraction, lists));
    lists.fill();
    let Collected { inside, inside_magnitude, magnitude } = collected;
    let (k0, k1, k2) = (&contraction.k0, &contraction.k1, contraction.k2);
    let total = inside.iter().sum::<f64>();
    let add = |lanes: &[f32; LEAF]| lanes.iter().map(|lane| f64::from(*lane)).sum::<f64>() * 1.0001;
    // p falls with t; a listed charge is at most the target's diameter inside.
    let deepest = (split.cutoff - 2.0 * target.radius - MARGIN).max(0.0).powi(2) - square;
    let [c0, c1, c2] = split.step;
    let (largest, steepest) = (c0 + deepest * (c1 + deepest * c2), (c1 + 2.0 * c2 * deepest).abs());
    // Roundings of a listed pair's term: of a sum of CHUNK terms on average half of them, of p and the charge, and of t.
    let term = (0.5 * CHUNK as f64 + 5.0) * UNIT * largest + steepest * t_error;
    // Of an inside charge's term: those of the parts of the polynomial, d among them, of the sum and of t.
    let reach = split.cutoff + target.radius;
    let size = |k: &[f32]| k.iter().map(|k| f64::from(k.abs())).sum::<f64>();
    let depth = far_inside(split, target);
    let (slope, curvature) = (f64::from(k1[0].abs()) + size(&k1[1..]) * reach, f64::from(k2.abs()));
    let constant = f64::from(k0[0].abs()) + size(&k0[1..4]) * reach + size(&k0[4..]) * reach * reach;
    let polynomial = constant + depth * (slope + depth * curvature);
    let inner = (0.5 * CHUNK as f64 + 15.0) * UNIT * polynomial + (slope + 2.0 * depth * curvature) * t_error;
    Bounded::of_one_part(total, target.magnitude * add(&magnitude) * term + add(&inside_magnitude) * inner)
}

/// The loop over the straddling leaves.
#[inline(always)]
fn collect_any(sources: &Sources, extent: &Extent, contraction: &Contraction, lists: &mut Lists) -> Collected {
    let (k0, k1, k2) = (&contraction.k0, &contraction.k1, contraction.k2);
    let mut sums = Collected { inside: [0.0; LEAF], inside_magnitude: [0.0; LEAF], magnitude: [0.0; LEAF] };
    let mut count = 0;
    for start in (0..lists.straddling).step_by(LEAF) {
        let axis = |axis: usize| lists.shifts[axis][start..].first_chunk::<LEAF>();
        let (Some(x), Some(y), Some(z)) = (axis(0), axis(1), axis(2)) else { continue };
        let shells = extent.shells([x, y, z]);
        let mut inside = [0.0f32; LEAF];
        for at in start..(start + LEAF).min(lists.straddling) {
            let leaf = lists.leaves[at] as usize;
            let [shift_x, shift_y, shift_z, depth] = [0, 1, 2, 3].map(|axis: usize| lists.shifts[axis][at]);
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
                    let constant = row_x.mul_add(x, row_y.mul_add(y, (k0[6] * z).mul_add(z, linear)));
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
fn collect_avx512(sources: &Sources, extent: &Extent, contraction: &Contraction, lists: &mut Lists) -> Collected {
    use std::arch::x86_64::*;
    let Lists { leaves, shifts: [xs, ys, zs, depths], straddling, placed, listed, .. } = lists;
    let two = _mm512_set1_ps(2.0);
    let k0 = contraction.k0.map(|k| _mm512_set1_ps(k));
    let k1 = contraction.k1.map(|k| _mm512_set1_ps(k));
    let k2 = _mm512_set1_ps(contraction.k2);
    let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let (mut inside_magnitude, mut magnitude) = (_mm512_setzero_ps(), _mm512_setzero_ps());
    let (mut inside_low, mut inside_high) = (_mm512_setzero_pd(), _mm512_setzero_pd());
    let mut count = 0;
    let blocks = leaves.as_chunks::<LEAF>().0.iter().zip(placed.as_chunks_mut::<LEAF>().0);
    let shifts = [xs, ys, zs, depths].map(|values| values.as_chunks::<LEAF>().0);
    let shifts = shifts[0].iter().zip(shifts[1]).zip(shifts[2]).zip(shifts[3]);
    for (block, ((leaves, placed), (((xs, ys), zs), depths))) in blocks.zip(shifts).enumerate() {
        let start = block * LEAF;
        if start >= *straddling {
            break;
        }
        let shells = extent.shells([xs, ys, zs]);
        let mut inside = _mm512_setzero_ps();
        for at in 0..(*straddling - start).min(LEAF) {
            let Some(members) = sources.members.get(leaves[at] as usize) else { continue };
            let [shift_x, shift_y, shift_z, depth] = [xs[at], ys[at], zs[at], depths[at]].map(|v| _mm512_set1_ps(v));
            let (low, high) = (_mm512_set1_ps(shells.low[at]), _mm512_set1_ps(shells.high[at]));
            // SAFETY: arrays of sixteen floats.
            let [x, y, z, square, charge] =
                unsafe { [0, 1, 2, 3, 4].map(|k: usize| _mm512_loadu_ps(members.0[k].as_ptr())) };
            let product = _mm512_fmadd_ps(x, shift_x, _mm512_fmadd_ps(y, shift_y, _mm512_mul_ps(z, shift_z)));
            let t = _mm512_fmadd_ps(product, two, _mm512_add_ps(square, depth));
            let within = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, low);
            let doubtful = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, high) & !within;
            if within | doubtful == 0 {
                continue;
            }
            let (x, y, z) = (_mm512_add_ps(x, shift_x), _mm512_add_ps(y, shift_y), _mm512_add_ps(z, shift_z));
            let size = _mm512_abs_ps(charge);
            if within != 0 {
                let fma = |a, b, c| _mm512_fmadd_ps(a, b, c);
                let linear = fma(k0[1], x, fma(k0[2], y, fma(k0[3], z, k0[0])));
                let row_x = fma(k0[4], x, fma(k0[7], y, _mm512_mul_ps(k0[8], z)));
                let row_y = fma(k0[5], y, _mm512_mul_ps(k0[9], z));
                let constant = fma(row_x, x, fma(row_y, y, fma(_mm512_mul_ps(k0[6], z), z, linear)));
                let slope = fma(k1[1], x, fma(k1[2], y, fma(k1[3], z, k1[0])));
                let value = fma(fma(k2, t, slope), t, constant);
                inside = _mm512_mask3_fmadd_ps(charge, value, inside, within);
                inside_magnitude = _mm512_mask_add_ps(inside_magnitude, within, inside_magnitude, size);
            }
            if doubtful != 0 {
                magnitude = _mm512_mask_add_ps(magnitude, doubtful, magnitude, size);
                for (place, values) in placed[at].0.iter_mut().zip([x, y, z, charge, t]) {
                    // SAFETY: an array of sixteen floats.
                    unsafe { _mm512_storeu_ps(place.as_mut_ptr(), values) };
                }
                let places = _mm512_add_epi32(lanes, _mm512_set1_epi32(((start + at) * LEAF) as i32));
                let room = &mut listed[count..count + LEAF];
                // SAFETY: `room` is sixteen integers long.
                unsafe {
                    _mm512_storeu_si512(room.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(doubtful, places));
                }
                count += doubtful.count_ones() as usize;
            }
        }
        inside_low = _mm512_add_pd(inside_low, _mm512_cvtps_pd(_mm512_castps512_ps256(inside)));
        inside_high = _mm512_add_pd(inside_high, _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(inside)));
    }
    lists.count = count;
    let mut sums = Collected { inside: [0.0; LEAF], inside_magnitude: [0.0; LEAF], magnitude: [0.0; LEAF] };
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
    square - (split.cutoff - 2.0 * target.radius - 4.0 * LARGEST_RADIUS).max(0.0).powi(2)
}

/// Unit roundoff of single precision.
const UNIT: f64 = 5.97e-8;

/// Leaves are no larger than this, Å.
pub(super) const LARGEST_RADIUS: f64 = 5.0;

/// Compares the listed charges with every member of the target.
#[inline(always)]
fn compare<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    t_error: f64,
    lists: &Lists,
) -> Bounded {
    let minus_two = target.offset.map(|axis| axis.map(|d| -2.0 * d));
    let members = Offsets { minus_two, square: target.square.map(|v| v as f32), doubt: t_error as f32 * 1.0001 };
    let step = split.step.map(|c| c as f32);
    let mut doubt = Bounded::default();
    let mut exactly = |listed: &[u32]| doubt.add(compare_exactly(sources, target, split, &lists.leaves, listed));
    let sums = select!(WIDE, compare_avx512, compare_any, (&members, &step, lists, &mut exactly));
    let value: f64 = sums.iter().zip(&target.charge).map(|(sum, charge)| sum * charge).sum();
    Bounded { value: value + doubt.value, ..doubt }
}

impl Bounded {
    /// A sum whose errors may all point the same way.
    #[inline(always)]
    pub fn of_one_part(value: f64, error: f64) -> Self {
        Self { value, error, square: error * error }
    }

    #[inline(always)]
    pub fn add(&mut self, other: Self) {
        self.value += other.value;
        self.error += other.error;
        self.square += other.square;
    }
}

/// The members of a target leaf for comparison: -2 δ, |δ|², and the |t| below which a sign is in doubt.
struct Offsets {
    minus_two: [[f32; LEAF]; 3],
    square: [f32; LEAF],
    doubt: f32,
}

/// The loop over the listed charges; chunks with a t too close to zero go to `exactly`.
#[inline(always)]
fn compare_any(
    Offsets { minus_two, square, doubt }: &Offsets,
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
                let t =
                    minus_two[0][i].mul_add(x, minus_two[1][i].mul_add(y, minus_two[2][i].mul_add(z, square[i] + t)));
                let p = step[2].mul_add(t, step[1]).mul_add(t, step[0]);
                sum[i] = if t < 0.0 { charge.mul_add(p, sum[i]) } else { sum[i] };
                let magnitude = t.abs();
                nearest[i] = if magnitude < nearest[i] { magnitude } else { nearest[i] };
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
fn compare_avx512(members: &Offsets, step: &[f32; 3], lists: &Lists, exactly: &mut impl FnMut(&[u32])) -> [f64; LEAF] {
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
    let chunks = lists.listed.as_chunks::<CHUNK>().0.iter().take(lists.count.div_ceil(CHUNK));
    for (chunk, places) in chunks.enumerate() {
        let (mut sum, mut nearest) = (zero, _mm512_set1_ps(f32::MAX));
        for place in places {
            let (leaf, lane) = (*place as usize / LEAF, *place as usize % LEAF);
            let Some(Placed([x, y, z, charge, t])) = lists.placed.get(leaf) else { continue };
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

/// The same for a few charges, in double precision; a pair within rounding of the cut-off counts as error.
#[cold]
fn compare_exactly(sources: &Sources, target: &Target, split: &Split, leaves: &[u32], listed: &[u32]) -> Bounded {
    let square = split.cutoff * split.cutoff;
    let [c0, c1, c2] = split.step;
    let mut sum = Bounded::default();
    for place in listed {
        let (leaf, lane) = (leaves[*place as usize / LEAF] as usize, *place as usize % LEAF);
        let exact = &sources.exact[leaf];
        let charge = sources.charge[leaf][lane];
        for i in 0..LEAF {
            let d: [f64; 3] = std::array::from_fn(|a| target.centre[a] + target.exact_offset[a][i] - exact[a][lane]);
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
