//! The step at the cut-off: Σ Z_i q_j p(t_ij) θ(-t_ij) with t = r² - r_cut², for one target leaf and all source leaves.
//!
//! Source leaves wholly inside enter by their moments, in double precision; of the straddling ones, charges that are
//! inside for the whole target leaf enter by the leaf's moments; what is left is compared pair by pair. With c the centre
//! of the target leaf and δ_i its members' offsets,
//!
//! ```text
//! t_ij = t_j + η_ij,   t_j = |y_j - c|² - r_cut² (double precision),   η_ij = |δ_i|² + 2 δ_i·c - 2 δ_i·y_j (single)
//! ```

use super::leaves::{LEAF, Leaves};
use super::near::NearKernel;
use super::split::Split;

/// |t| below which the sign of a single-precision t is not trusted, Å²; also the bound of its error.
pub(super) const T_ERROR: f64 = 3e-4;
/// Entries of a list between two transfers of the sum to double precision.
const CHUNK: usize = 8;
/// Margin of distances in the classification of leaves, Å.
const MARGIN: f64 = 1e-3;
/// Moments of a leaf.
pub(super) const MOMENTS: usize = 14;

/// Source leaves as the loops want them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sources {
    /// Places, charges in single precision.
    pub x: Vec<[f32; LEAF]>,
    pub y: Vec<[f32; LEAF]>,
    pub z: Vec<[f32; LEAF]>,
    pub charge: Vec<[f32; LEAF]>,
    /// The places again, and |y|², in double precision.
    pub exact: Vec<[[f64; LEAF]; 4]>,
    /// Bounding spheres, sixteen leaves at a time; missing ones are infinitely far.
    spheres: Vec<[[f32; LEAF]; 4]>,
    /// Moments about the middle of the charges' box, sixteen leaves at a time.
    moments: Vec<[[f64; LEAF]; MOMENTS]>,
}

/// A leaf of the other body where it stands.
pub(super) struct Target {
    /// Centre and radius of the bounding sphere, Å.
    pub centre: [f64; 3],
    pub radius: f64,
    /// Offsets of the members from the centre, Å.
    pub offset: [[f32; LEAF]; 3],
    pub exact_offset: [[f64; LEAF]; 3],
    /// |δ|² + 2 δ·c, Å².
    pub shift: [f32; LEAF],
    /// |δ|², Å².
    pub square: [f32; LEAF],
    /// Charges, e, and the sum of their magnitudes.
    pub charge: [f64; LEAF],
    pub magnitude: f64,
    /// Bound of the sources' coordinates, Å.
    pub largest_coordinate: f64,
    /// The moments of the leaf about its centre.
    pub moments: [f64; MOMENTS],
}

/// Reusable lists.
#[derive(Debug, Default)]
pub(super) struct Lists {
    leaves: Vec<u32>,
    near_leaves: Vec<u32>,
    /// Charges to compare: where they are among the sources, and x, y, z, charge and t.
    index: Vec<u32>,
    listed: [Vec<f32>; 5],
    count: usize,
}

/// A sum with its bound, kT.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounded {
    pub value: f64,
    pub error: f64,
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
        let single = |values: &Vec<[f64; LEAF]>| values.iter().map(|leaf| leaf.map(|v| v as f32)).collect();
        let blocks = leaves.len().div_ceil(LEAF);
        let (mut spheres, mut all_moments) =
            (vec![[[1e9; LEAF], [1e9; LEAF], [1e9; LEAF], [0.0; LEAF]]; blocks], vec![[[0.0; LEAF]; MOMENTS]; blocks]);
        let mut exact = Vec::new();
        for leaf in 0..leaves.len() {
            let (x, y, z) = (leaves.x[leaf], leaves.y[leaf], leaves.z[leaf]);
            exact.push([x, y, z, std::array::from_fn(|i| x[i] * x[i] + y[i] * y[i] + z[i] * z[i])]);
            for axis in 0..4 {
                spheres[leaf / LEAF][axis][leaf % LEAF] = leaves.spheres[leaf][axis] as f32;
            }
            for (k, moment) in moments([&x, &y, &z], &leaves.charge[leaf]).into_iter().enumerate() {
                all_moments[leaf / LEAF][k][leaf % LEAF] = moment;
            }
        }
        Self {
            x: single(&leaves.x),
            y: single(&leaves.y),
            z: single(&leaves.z),
            charge: single(&leaves.charge),
            exact,
            spheres,
            moments: all_moments,
        }
    }

    pub fn memory_bytes(&self) -> usize {
        4 * size_of_val(&self.x[..])
            + size_of_val(&self.exact[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.moments[..])
    }
}

/// Coefficients of Σ_i Z_i p(t_ij): as a polynomial of y in the order of [`moments`], and for charges one by one.
struct Contraction {
    global: [f64; MOMENTS],
    /// p summed = k0 + t (k1 + t k2), k0 and k1 polynomials of y.
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
        let mut k0 = [constant as f32; 10];
        for i in 0..3 {
            k0[1 + i] = linear[i] as f32;
        }
        for n in 0..6 {
            k0[4 + n] = own[n] as f32;
        }
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
    let mut sum = classify(sources, target, split, &contraction.global, finite, lists);
    if !lists.leaves.is_empty() {
        let room = lists.leaves.len() * LEAF + LEAF;
        if lists.index.len() < room {
            lists.index.resize(room, 0);
            lists.listed.iter_mut().for_each(|list| list.resize(room, 0.0));
        }
        let straddling = collect::<WIDE>(sources, target, split, square, &contraction, lists);
        let window = compare::<WIDE>(sources, target, split, lists);
        sum.value += straddling.value + window.value;
        sum.error += straddling.error + window.error;
    }
    if !lists.near_leaves.is_empty() {
        let close = near.sum(sources, target, &lists.near_leaves);
        sum.value += close.value;
        sum.error += close.error;
    }
    sum
}

/// Sums the leaves wholly inside; lists those that straddle the cut-off and those with near pairs.
#[inline(always)]
fn classify(
    sources: &Sources,
    target: &Target,
    split: &Split,
    global: &[f64; MOMENTS],
    finite: bool,
    lists: &mut Lists,
) -> Bounded {
    lists.leaves.clear();
    lists.near_leaves.clear();
    let c = target.centre.map(|c| c as f32);
    let cutoff = if finite { split.cutoff as f32 } else { 0.0 };
    let (radius, margin, near) = (target.radius as f32, MARGIN as f32, split.near_radius as f32);
    let mut inside = [0.0f64; LEAF];
    for (block, (sphere, moments)) in sources.spheres.iter().zip(&sources.moments).enumerate() {
        let mut kind = [0u8; LEAF];
        let mut weight = [0.0f64; LEAF];
        for lane in 0..LEAF {
            let (dx, dy, dz) = (sphere[0][lane] - c[0], sphere[1][lane] - c[1], sphere[2][lane] - c[2]);
            let square = dx * dx + dy * dy + dz * dz;
            let reach = radius + sphere[3][lane] + margin;
            let (high, low, close) = (cutoff + reach, (cutoff - reach).max(0.0), near + reach);
            let within = square < low * low;
            let touched = finite & (square < high * high);
            weight[lane] = if within { 1.0 } else { 0.0 };
            kind[lane] = u8::from(touched & !within) + 2 * u8::from(square < close * close);
        }
        if weight.iter().any(|w| *w > 0.0) {
            let mut value = [0.0f64; LEAF];
            for (coefficient, moment) in global.iter().zip(moments) {
                for lane in 0..LEAF {
                    value[lane] += coefficient * moment[lane];
                }
            }
            for lane in 0..LEAF {
                inside[lane] += weight[lane] * value[lane];
            }
        }
        if kind != [0; LEAF] {
            for (lane, kind) in kind.into_iter().enumerate() {
                if kind & 1 == 1 {
                    lists.leaves.push((block * LEAF + lane) as u32);
                }
                if kind & 2 == 2 {
                    lists.near_leaves.push((block * LEAF + lane) as u32);
                }
            }
        }
    }
    Bounded { value: inside.iter().sum(), error: 0.0 }
}

/// The sums over the charges of straddling leaves.
struct Collected {
    inside: [f32; LEAF],
    inside_magnitude: [f32; LEAF],
    magnitude: [f32; LEAF],
}

/// Where a charge is inside for the whole target leaf (t below the first) or outside (t not below the second), Å².
#[derive(Clone, Copy)]
struct Shell {
    /// |c|² - r_cut².
    constant: f64,
    low: f32,
    high: f32,
}

/// Sums the charges of straddling leaves that are inside for every member of the target, and lists those in doubt.
#[inline(always)]
fn collect<const WIDE: bool>(
    sources: &Sources,
    target: &Target,
    split: &Split,
    square: f64,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Bounded {
    let c = target.centre;
    let (low, high) = (split.cutoff - target.radius - MARGIN, split.cutoff + target.radius + MARGIN);
    let shell = Shell {
        constant: c[0] * c[0] + c[1] * c[1] + c[2] * c[2] - square,
        low: if low > 0.0 { (low * low - square) as f32 } else { f32::NEG_INFINITY },
        high: (high * high - square) as f32,
    };
    #[cfg(target_arch = "x86_64")]
    let collected = if WIDE {
        // SAFETY: WIDE says that the processor has the features.
        unsafe { collect_avx512(sources, &c, shell, contraction, lists) }
    } else {
        collect_any(sources, &c, shell, contraction, lists)
    };
    #[cfg(not(target_arch = "x86_64"))]
    let collected = collect_any(sources, &c, shell, contraction, lists);
    let Collected { inside, inside_magnitude, magnitude } = collected;
    let (k0, k1, k2) = (&contraction.k0, &contraction.k1, contraction.k2);
    let total = inside.iter().map(|v| f64::from(*v)).sum::<f64>();
    let add = |lanes: &[f32; LEAF]| lanes.iter().map(|lane| f64::from(*lane)).sum::<f64>();
    // p falls with t; a listed charge is at most the target's diameter inside.
    let deepest = (split.cutoff - 2.0 * target.radius - MARGIN).max(0.0).powi(2) - square;
    let [c0, c1, c2] = split.step;
    let (largest, steepest) = (c0 + deepest * (c1 + deepest * c2), (c1 + 2.0 * c2 * deepest).abs());
    // Roundings of a listed pair's term: of a sum of CHUNK terms on average half of them, of p, the charge and t.
    let term = (0.5 * CHUNK as f64 + 5.0) * UNIT * largest + steepest * T_ERROR * 0.5;
    // Of an inside charge's term: those of the largest parts of the polynomial.
    let reach = target.largest_coordinate;
    let size = |k: &[f32], from: usize| k[from..].iter().map(|k| f64::from(k.abs())).sum::<f64>();
    let slope = f64::from(k1[0].abs()) + size(&k1[1..], 0) * reach;
    let polynomial = f64::from(k0[0].abs()) + size(&k0[1..4], 0) * reach + size(k0, 4) * reach * reach;
    let depth = square.max(1.0);
    let polynomial = polynomial
        + slope * depth.min(far_inside(split, target))
        + f64::from(k2.abs()) * far_inside(split, target).powi(2);
    let error = target.magnitude * add(&magnitude) * term + add(&inside_magnitude) * polynomial * 30.0 * UNIT;
    Bounded { value: total, error }
}

/// The loop over the straddling leaves.
#[inline(always)]
fn collect_any(
    sources: &Sources,
    c: &[f64; 3],
    shell: Shell,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Collected {
    let (k0, k1, k2) = (&contraction.k0, &contraction.k1, contraction.k2);
    let mut sums = Collected { inside: [0.0; LEAF], inside_magnitude: [0.0; LEAF], magnitude: [0.0; LEAF] };
    let mut count = 0;
    for leaf in &lists.leaves {
        let leaf = *leaf as usize;
        let exact = &sources.exact[leaf];
        let (x, y, z, charge) = (&sources.x[leaf], &sources.y[leaf], &sources.z[leaf], &sources.charge[leaf]);
        for lane in 0..LEAF {
            let product = c[0].mul_add(exact[0][lane], c[1].mul_add(exact[1][lane], c[2] * exact[2][lane]));
            let t = (-2.0f64).mul_add(product, exact[3][lane] + shell.constant) as f32;
            let (x, y, z, charge) = (x[lane], y[lane], z[lane], charge[lane]);
            if t < shell.low {
                let linear = k0[1].mul_add(x, k0[2].mul_add(y, k0[3].mul_add(z, k0[0])));
                let row_x = k0[4].mul_add(x, k0[7].mul_add(y, k0[8] * z));
                let row_y = k0[5].mul_add(y, k0[9] * z);
                let constant = row_x.mul_add(x, row_y.mul_add(y, (k0[6] * z).mul_add(z, linear)));
                let slope = k1[1].mul_add(x, k1[2].mul_add(y, k1[3].mul_add(z, k1[0])));
                let value = k2.mul_add(t, slope).mul_add(t, constant);
                sums.inside[lane] = charge.mul_add(value, sums.inside[lane]);
                sums.inside_magnitude[lane] += charge.abs();
            } else if t < shell.high {
                sums.magnitude[lane] += charge.abs();
                lists.index[count] = (leaf * LEAF + lane) as u32;
                for (list, value) in lists.listed.iter_mut().zip([x, y, z, charge, t]) {
                    list[count] = value;
                }
                count += 1;
            }
        }
    }
    lists.count = count;
    sums
}

/// The same operations in the same order, sixteen charges at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma")]
#[inline]
fn collect_avx512(
    sources: &Sources,
    c: &[f64; 3],
    shell: Shell,
    contraction: &Contraction,
    lists: &mut Lists,
) -> Collected {
    use std::arch::x86_64::*;
    let Lists { leaves, index, listed: [list_x, list_y, list_z, list_charge, list_t], .. } = lists;
    let centre = c.map(|c| _mm512_set1_pd(c));
    let (constant, minus_two) = (_mm512_set1_pd(shell.constant), _mm512_set1_pd(-2.0));
    let (low, high) = (_mm512_set1_ps(shell.low), _mm512_set1_ps(shell.high));
    let k0 = contraction.k0.map(|k| _mm512_set1_ps(k));
    let k1 = contraction.k1.map(|k| _mm512_set1_ps(k));
    let k2 = _mm512_set1_ps(contraction.k2);
    let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let (mut inside, mut inside_magnitude, mut magnitude) =
        (_mm512_setzero_ps(), _mm512_setzero_ps(), _mm512_setzero_ps());
    let mut count = 0;
    for leaf in leaves.iter() {
        let leaf = *leaf as usize;
        let exact = &sources.exact[leaf];
        let half = |from: usize| {
            // SAFETY: eight doubles from 0 or 8 of an array of sixteen.
            let at = |axis: usize| unsafe { _mm512_loadu_pd(exact[axis].as_ptr().add(from)) };
            let product =
                _mm512_fmadd_pd(centre[0], at(0), _mm512_fmadd_pd(centre[1], at(1), _mm512_mul_pd(centre[2], at(2))));
            _mm512_cvtpd_ps(_mm512_fmadd_pd(minus_two, product, _mm512_add_pd(at(3), constant)))
        };
        let t = _mm512_insertf32x8::<1>(_mm512_castps256_ps512(half(0)), half(8));
        let within = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, low);
        let doubtful = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, high) & !within;
        if within | doubtful == 0 {
            continue;
        }
        // SAFETY: arrays of sixteen floats.
        let [x, y, z, charge] = unsafe {
            [&sources.x[leaf], &sources.y[leaf], &sources.z[leaf], &sources.charge[leaf]]
                .map(|lanes| _mm512_loadu_ps(lanes.as_ptr()))
        };
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
            let lists = [&mut *list_x, &mut *list_y, &mut *list_z, &mut *list_charge, &mut *list_t];
            for (list, values) in lists.into_iter().zip([x, y, z, charge, t]) {
                let room = &mut list[count..count + LEAF];
                // SAFETY: `room` is sixteen floats long.
                unsafe { _mm512_storeu_ps(room.as_mut_ptr(), _mm512_maskz_compress_ps(doubtful, values)) };
            }
            let places = _mm512_add_epi32(lanes, _mm512_set1_epi32((leaf * LEAF) as i32));
            let room = &mut index[count..count + LEAF];
            // SAFETY: `room` is sixteen integers long.
            unsafe {
                _mm512_storeu_si512(room.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(doubtful, places));
            }
            count += doubtful.count_ones() as usize;
        }
    }
    lists.count = count;
    let mut sums = Collected { inside: [0.0; LEAF], inside_magnitude: [0.0; LEAF], magnitude: [0.0; LEAF] };
    // SAFETY: arrays of sixteen floats.
    unsafe {
        _mm512_storeu_ps(sums.inside.as_mut_ptr(), inside);
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
fn compare<const WIDE: bool>(sources: &Sources, target: &Target, split: &Split, lists: &Lists) -> Bounded {
    let step = split.step.map(|c| c as f32);
    let mut sums = [0.0f64; LEAF];
    let mut doubt = Bounded::default();
    let minus_two = target.offset.map(|axis| axis.map(|d| -2.0 * d));
    #[cfg(target_arch = "x86_64")]
    if WIDE {
        let mut exactly = |indices: &[u32]| doubt.add(compare_exactly(sources, target, split, indices));
        // SAFETY: WIDE says that the processor has the features.
        unsafe { compare_avx512(&minus_two, &target.shift, &step, lists, &mut sums, &mut exactly) };
    } else {
        let mut exactly = |indices: &[u32]| doubt.add(compare_exactly(sources, target, split, indices));
        compare_any(&minus_two, &target.shift, &step, lists, &mut sums, &mut exactly);
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let mut exactly = |indices: &[u32]| doubt.add(compare_exactly(sources, target, split, indices));
        compare_any(&minus_two, &target.shift, &step, lists, &mut sums, &mut exactly);
    }
    let value: f64 = sums.iter().zip(&target.charge).map(|(sum, charge)| sum * charge).sum();
    Bounded { value: value + doubt.value, error: doubt.error }
}

impl Bounded {
    fn add(&mut self, other: Self) {
        self.value += other.value;
        self.error += other.error;
    }
}

/// The loop over the listed charges; chunks with a t too close to zero go to `exactly`.
#[inline(always)]
fn compare_any(
    minus_two: &[[f32; LEAF]; 3],
    shift: &[f32; LEAF],
    step: &[f32; 3],
    lists: &Lists,
    sums: &mut [f64; LEAF],
    exactly: &mut impl FnMut(&[u32]),
) {
    let [xs, ys, zs, charges, ts] = &lists.listed;
    for start in (0..lists.count).step_by(CHUNK) {
        let chunk = start..(start + CHUNK).min(lists.count);
        let mut sum = [0.0f32; LEAF];
        let mut nearest = [f32::MAX; LEAF];
        for at in chunk.clone() {
            let (x, y, z, charge, t) = (xs[at], ys[at], zs[at], charges[at], ts[at]);
            for i in 0..LEAF {
                let t =
                    minus_two[0][i].mul_add(x, minus_two[1][i].mul_add(y, minus_two[2][i].mul_add(z, shift[i] + t)));
                let p = step[2].mul_add(t, step[1]).mul_add(t, step[0]);
                sum[i] = if t < 0.0 { charge.mul_add(p, sum[i]) } else { sum[i] };
                let magnitude = t.abs();
                nearest[i] = if magnitude < nearest[i] { magnitude } else { nearest[i] };
            }
        }
        if nearest.iter().any(|t| *t < T_ERROR as f32) {
            exactly(&lists.index[chunk]);
        } else {
            for i in 0..LEAF {
                sums[i] += f64::from(sum[i]);
            }
        }
    }
}

/// The same operations in the same order, for sixteen members at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma")]
#[inline]
fn compare_avx512(
    minus_two: &[[f32; LEAF]; 3],
    shift: &[f32; LEAF],
    step: &[f32; 3],
    lists: &Lists,
    sums: &mut [f64; LEAF],
    exactly: &mut impl FnMut(&[u32]),
) {
    use std::arch::x86_64::*;
    let [xs, ys, zs, charges, ts] = &lists.listed;
    // SAFETY: arrays of sixteen floats.
    let (d, shift) = unsafe {
        ([0, 1, 2].map(|axis: usize| _mm512_loadu_ps(minus_two[axis].as_ptr())), _mm512_loadu_ps(shift.as_ptr()))
    };
    let step = step.map(|c| _mm512_set1_ps(c));
    let (zero, doubt) = (_mm512_setzero_ps(), _mm512_set1_ps(T_ERROR as f32));
    let (mut low, mut high) = (_mm512_setzero_pd(), _mm512_setzero_pd());
    for start in (0..lists.count).step_by(CHUNK) {
        let chunk = start..(start + CHUNK).min(lists.count);
        let places = xs[chunk.clone()].iter().zip(&ys[chunk.clone()]).zip(&zs[chunk.clone()]);
        let rest = charges[chunk.clone()].iter().zip(&ts[chunk.clone()]);
        let (mut sum, mut nearest) = (zero, _mm512_set1_ps(f32::MAX));
        for (((x, y), z), (charge, t)) in places.zip(rest) {
            let t = _mm512_add_ps(shift, _mm512_set1_ps(*t));
            let t = _mm512_fmadd_ps(d[2], _mm512_set1_ps(*z), t);
            let t = _mm512_fmadd_ps(d[1], _mm512_set1_ps(*y), t);
            let t = _mm512_fmadd_ps(d[0], _mm512_set1_ps(*x), t);
            let p = _mm512_fmadd_ps(_mm512_fmadd_ps(step[2], t, step[1]), t, step[0]);
            let inside = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, zero);
            sum = _mm512_mask3_fmadd_ps(_mm512_set1_ps(*charge), p, sum, inside);
            nearest = _mm512_min_ps(_mm512_abs_ps(t), nearest);
        }
        if _mm512_cmp_ps_mask::<_CMP_LT_OQ>(nearest, doubt) != 0 {
            exactly(&lists.index[chunk]);
        } else {
            low = _mm512_add_pd(low, _mm512_cvtps_pd(_mm512_castps512_ps256(sum)));
            high = _mm512_add_pd(high, _mm512_cvtps_pd(_mm512_extractf32x8_ps::<1>(sum)));
        }
    }
    // SAFETY: two halves of eight doubles of an array of sixteen.
    unsafe {
        _mm512_storeu_pd(sums.as_mut_ptr(), low);
        _mm512_storeu_pd(sums.as_mut_ptr().add(8), high);
    }
}

/// The same for a few charges, in double precision; a pair within rounding of the cut-off counts as error.
#[cold]
fn compare_exactly(sources: &Sources, target: &Target, split: &Split, indices: &[u32]) -> Bounded {
    let square = split.cutoff * split.cutoff;
    let [c0, c1, c2] = split.step;
    let mut sum = Bounded::default();
    for index in indices {
        let (leaf, lane) = (*index as usize / LEAF, *index as usize % LEAF);
        let exact = &sources.exact[leaf];
        let charge = f64::from(sources.charge[leaf][lane]);
        for i in 0..LEAF {
            let d: [f64; 3] = std::array::from_fn(|a| target.centre[a] + target.exact_offset[a][i] - exact[a][lane]);
            let t = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - square;
            let term = target.charge[i] * charge * (c0 + t * (c1 + t * c2));
            if t.abs() < 1e-8 {
                sum.error += term.abs();
            }
            if t < 0.0 {
                sum.value += term;
            }
        }
    }
    sum
}
