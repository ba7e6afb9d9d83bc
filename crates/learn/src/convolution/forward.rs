//! The forward pass of one sample, with what follows it done while the rows are still in the cache.
//!
//! Outputs lie in vectors across channels; a register tile holds P voxels of a row times V vectors.
//! Each step takes V vectors of weights and P single numbers of the padded input, which lie next to
//! each other, and does P V multiply-adds.

use super::geometry::{Geometry, LANES};
use super::lanes::{Lanes, Work};
use super::padded::{Occupied, Padded};

/// The corner of a window that pooling chose, or this: none, because the ReLU gave 0.
pub const DEAD: u8 = 8;

/// What follows the convolution and its bias.
#[derive(Debug)]
pub enum Finish<'a> {
    /// Nothing: (O, D, H, W).
    Plain(&'a mut [f32]),
    /// ReLU: (O, D, H, W).
    Relu(&'a mut [f32]),
    /// ReLU and the maximum of every 2 x 2 x 2 window, (O, D/2, H/2, W/2), and the corner that had
    /// it, 4 z + 2 y + x, or [`DEAD`]. The first of equals wins.
    Pool(&'a mut [f32], &'a mut [u8]),
}

/// The forward pass of one sample.
#[derive(Debug)]
pub struct Forward<'a> {
    /// The shape.
    pub geometry: &'a Geometry,
    /// The input.
    pub input: &'a Padded,
    /// The weights as [`Geometry::pack`] gives them.
    pub weights: &'a [f32],
    /// One per output; none stands for zeros.
    pub bias: Option<&'a [f32]>,
    /// What follows.
    pub finish: Finish<'a>,
    /// Room for four rows of outputs, [`scratch_length`] numbers.
    pub scratch: &'a mut [f32],
}

/// Numbers of scratch that [`Forward`] wants.
pub fn scratch_length(geometry: &Geometry) -> usize {
    5 * geometry.edges[2] * geometry.padded_outputs()
}

impl Work for Forward<'_> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Lanes>(self) {
        // SAFETY: the caller has the instructions.
        unsafe {
            match self.geometry.kernel {
                1 => self.run_with::<S, 1>(),
                3 => self.run_with::<S, 3>(),
                _ => self.run_with::<S, 5>(),
            }
        }
    }
}

impl Forward<'_> {
    #[inline(always)]
    unsafe fn run_with<S: Lanes, const K: usize>(self) {
        let Self {
            geometry,
            input,
            weights,
            bias,
            finish,
            scratch,
        } = self;
        let [depth, height, width] = geometry.edges;
        let (outputs, stride) = (geometry.outputs, geometry.padded_outputs());
        let length = width * stride;
        // Everything the tiles below touch lies in these lengths; what comes in by the public
        // fields is not trusted.
        let sound = geometry.kernel == K
            && input.numbers.len() == geometry.channels * geometry.padded_voxels()
            && weights.len() == geometry.channels * geometry.taps() * stride
            && scratch.len() == scratch_length(geometry)
            && bias.is_none_or(|bias| bias.len() == outputs);
        assert!(sound, "buffers do not fit a convolution of {geometry:?}");
        let (rows, tail) = scratch.split_at_mut(4 * length);
        let shift = &mut tail[..stride];
        shift.fill(0.0);
        if let Some(bias) = bias {
            shift[..outputs].copy_from_slice(bias);
        }
        match finish {
            Finish::Plain(out) => {
                for row in 0..depth * height {
                    // SAFETY: lengths are checked above.
                    unsafe {
                        convolve_row::<S, K>(
                            geometry,
                            input,
                            weights,
                            row / height,
                            row % height,
                            &mut rows[..length],
                        )
                    };
                    for (o, shift) in shift.iter().enumerate().take(outputs) {
                        let to = &mut out[(o * depth * height + row) * width..][..width];
                        for (to, from) in to.iter_mut().zip(rows[o..length].iter().step_by(stride))
                        {
                            *to = from + shift;
                        }
                    }
                }
            }
            Finish::Relu(out) => {
                for row in 0..depth * height {
                    // SAFETY: lengths are checked above.
                    unsafe {
                        convolve_row::<S, K>(
                            geometry,
                            input,
                            weights,
                            row / height,
                            row % height,
                            &mut rows[..length],
                        )
                    };
                    for (o, shift) in shift.iter().enumerate().take(outputs) {
                        let to = &mut out[(o * depth * height + row) * width..][..width];
                        for (to, from) in to.iter_mut().zip(rows[o..length].iter().step_by(stride))
                        {
                            *to = positive(from + shift);
                        }
                    }
                }
            }
            Finish::Pool(out, codes) => {
                let [d, h, w] = [depth / 2, height / 2, width / 2];
                let mut chosen = vec![0u8; w * stride];
                let nothing = shift[..outputs].to_vec();
                for row in 0..d * h {
                    let (z, y) = (2 * (row / h), 2 * (row % h));
                    let mut any = false;
                    for (corner, to) in rows.chunks_exact_mut(length).enumerate() {
                        // SAFETY: lengths are checked above.
                        any |= unsafe {
                            convolve_row::<S, K>(
                                geometry,
                                input,
                                weights,
                                z + corner / 2,
                                y + corner % 2,
                                to,
                            )
                        };
                    }
                    if !any {
                        for (o, value) in nothing.iter().enumerate() {
                            let first = (o * d * h + row) * w;
                            out[first..first + w].fill(positive(*value));
                            codes[first..first + w].fill(if *value <= 0.0 { DEAD } else { 0 });
                        }
                        continue;
                    }
                    pool_rows(rows, length, stride, shift, &mut chosen);
                    for o in 0..outputs {
                        let first = (o * d * h + row) * w;
                        let to = &mut out[first..first + w];
                        for (to, from) in to.iter_mut().zip(rows[o..].iter().step_by(stride)) {
                            *to = *from;
                        }
                        let to = &mut codes[first..first + w];
                        for (to, from) in to.iter_mut().zip(chosen[o..].iter().step_by(stride)) {
                            *to = *from;
                        }
                    }
                }
            }
        }
    }
}

/// ReLU that lets what is not a number through.
#[inline(always)]
pub fn positive(value: f32) -> f32 {
    if value <= 0.0 { 0.0 } else { value }
}

/// Maxima over windows of four rows (z, y) in {0, 1}², of `length` numbers each, voxel by voxel;
/// the results, with the bias added and negative ones cut off, overwrite the front of the first
/// row, and `codes` says which corner had each.
#[inline(always)]
fn pool_rows(rows: &mut [f32], length: usize, stride: usize, shift: &[f32], codes: &mut [u8]) {
    for (w, codes) in codes.chunks_exact_mut(stride).enumerate() {
        for (block, codes) in codes.chunks_exact_mut(LANES).enumerate() {
            let first = 2 * w * stride + block * LANES;
            let mut best = lanes_at(rows, first);
            let mut code = [0u32; LANES];
            for corner in 1..8 {
                let place = corner / 2 * length + first + corner % 2 * stride;
                let value = lanes_at(rows, place);
                for i in 0..LANES {
                    // What is not a number wins, and then loses to nothing.
                    let better = (value[i] > best[i]) | value[i].is_nan();
                    best[i] = if better { value[i] } else { best[i] };
                    code[i] = if better { corner as u32 } else { code[i] };
                }
            }
            let shift = lanes_at(shift, block * LANES);
            for i in 0..LANES {
                let value = best[i] + shift[i];
                codes[i] = if value <= 0.0 { DEAD } else { code[i] as u8 };
                best[i] = positive(value);
            }
            let to = w * stride + block * LANES;
            rows[to..to + LANES].copy_from_slice(&best);
        }
    }
}

#[inline(always)]
fn lanes_at(numbers: &[f32], first: usize) -> [f32; LANES] {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&numbers[first..first + LANES]);
    lanes
}

/// A row of taps of a tile: where its input and its weights begin, from the first channel on.
#[derive(Debug, Clone, Copy, Default)]
struct TapRow {
    input: usize,
    weights: usize,
}

/// One row of outputs, voxel by voxel: `out` is (W, padded O). False if it holds nothing but zeros
/// because the input does.
///
/// # Safety
/// The processor has the instructions of `S`; the buffers have the lengths that `run_with` checks;
/// `out` is W x padded O.
#[inline(always)]
#[allow(clippy::int_plus_one, reason = "the macro's smallest step is 1")]
unsafe fn convolve_row<S: Lanes, const K: usize>(
    geometry: &Geometry,
    input: &Padded,
    weights: &[f32],
    z: usize,
    y: usize,
    out: &mut [f32],
) -> bool {
    let stride = geometry.padded_outputs();
    let width = geometry.edges[2];
    let [_, padded_height, padded_width] = geometry.padded_edges();
    let first = (z * padded_height + y) * padded_width;
    let mut all = [TapRow::default(); 25];
    for (row, tap) in all.iter_mut().enumerate().take(K * K) {
        *tap = TapRow {
            input: first + geometry.tap_row_offset(row),
            weights: row * K * stride,
        };
    }
    if let Some(occupied) = &input.occupied {
        let count: usize = all[..K * K]
            .iter()
            .map(|tap| occupied.count(tap.input / padded_width))
            .sum();
        if count == 0 {
            out.fill(0.0);
            return false;
        }
        if SCATTER_BELOW * count < K * K * width {
            // SAFETY: as this function's.
            unsafe { scatter_row::<S, K>(geometry, input, occupied, weights, &all[..K * K], out) };
            return true;
        }
    }
    let mut active = all;
    let vectors = stride / S::WIDTH;
    let mut vector = 0;
    macro_rules! sweep {
        ($vectors:literal: $($voxels:literal)*) => {{
            let mut x = 0;
            $(while x + $voxels <= width {
                let mut taps = &all[..K * K];
                if let Some(occupied) = &input.occupied {
                    let mut count = 0;
                    for tap in taps {
                        active[count] = *tap;
                        let row = tap.input / padded_width;
                        count += usize::from(occupied.any(row, x, $voxels + K - 1));
                    }
                    taps = &active[..count];
                }
                // SAFETY: the tile reads, of channel c < C, the numbers from tap.input + x on,
                // $voxels + K - 1 of them: a tap row begins at a row of the padded grid and x +
                // $voxels <= W, so they end inside that row. It reads weights of rows (c K² + row)
                // K + k < C K³, vectors below `stride`. It writes voxels x to x + $voxels <= W of
                // `out`, vectors below `stride`.
                unsafe {
                    tile::<S, $voxels, $vectors, K>(
                        input.numbers.as_ptr().add(x),
                        geometry.padded_voxels(),
                        geometry.channels,
                        taps,
                        weights.as_ptr().add(vector * S::WIDTH),
                        stride,
                        out.as_mut_ptr().add(x * stride + vector * S::WIDTH),
                    );
                }
                x += $voxels;
            })*
            vector += $vectors;
        }};
    }
    while vector < vectors {
        let left = vectors - vector;
        if S::MANY && left >= 4 && width < 8 {
            sweep!(4: 4 2 1);
        } else if S::MANY && left >= 2 {
            sweep!(2: 8 4 2 1);
        } else if S::MANY {
            sweep!(1: 16 8 4 2 1);
        } else {
            // Vectors of eight: their number is even.
            sweep!(2: 4 2 1);
        }
    }
    true
}

/// If fewer than one in this many voxels that a row of outputs sees hold anything, these are spread
/// over the outputs.
const SCATTER_BELOW: usize = 4;

/// One row of outputs from the few voxels that hold anything.
///
/// # Safety
/// As for [`convolve_row`].
#[inline(always)]
unsafe fn scatter_row<S: Lanes, const K: usize>(
    geometry: &Geometry,
    input: &Padded,
    occupied: &Occupied,
    weights: &[f32],
    taps: &[TapRow],
    out: &mut [f32],
) {
    let stride = geometry.padded_outputs();
    let (width, padded_width) = (geometry.edges[2], geometry.padded_edges()[2]);
    out.fill(0.0);
    for tap in taps {
        for at in occupied.of_row(tap.input / padded_width, padded_width) {
            for k in 0..K.min(at + 1) {
                let x = at - k;
                if x >= width {
                    continue;
                }
                for first in (0..stride).step_by(S::WIDTH) {
                    // SAFETY: voxel `at` < padded width of row tap.input of every channel lies in
                    // the padded grid; the weights are those of rows (c K² + row) K + k < C K³;
                    // voxel x < W of `out` is written.
                    unsafe {
                        let to = out.as_mut_ptr().add(x * stride + first);
                        let mut sum = S::load(to);
                        for channel in 0..geometry.channels {
                            let value = input
                                .numbers
                                .as_ptr()
                                .add(channel * geometry.padded_voxels() + tap.input + at);
                            let weight =
                                channel * K * K * K * stride + tap.weights + k * stride + first;
                            sum = S::multiply_add(
                                S::splat(value),
                                S::load(weights.as_ptr().add(weight)),
                                sum,
                            );
                        }
                        S::store(to, sum);
                    }
                }
            }
        }
    }
}

/// P voxels times V vectors of outputs.
///
/// # Safety
/// The processor has the instructions of `S`; reads and writes stay inside, as argued where it is
/// called.
#[inline(always)]
unsafe fn tile<S: Lanes, const P: usize, const V: usize, const K: usize>(
    input: *const f32,
    plane: usize,
    channels: usize,
    taps: &[TapRow],
    weights: *const f32,
    stride: usize,
    out: *mut f32,
) {
    // SAFETY: the caller's promise.
    unsafe {
        let mut sums = [[S::zero(); V]; P];
        for channel in 0..channels {
            let input = input.add(channel * plane);
            let weights = weights.add(channel * K * K * K * stride);
            for tap in taps {
                let input = input.add(tap.input);
                let weights = weights.add(tap.weights);
                for k in 0..K {
                    let mut vectors = [S::zero(); V];
                    for (v, vector) in vectors.iter_mut().enumerate() {
                        *vector = S::load(weights.add(k * stride + v * S::WIDTH));
                    }
                    for (p, sums) in sums.iter_mut().enumerate() {
                        let value = S::splat(input.add(p + k));
                        for (sum, vector) in sums.iter_mut().zip(vectors) {
                            *sum = S::multiply_add(value, vector, *sum);
                        }
                    }
                }
            }
        }
        for (p, sums) in sums.iter().enumerate() {
            for (v, sum) in sums.iter().enumerate() {
                S::store(out.add(p * stride + v * S::WIDTH), *sum);
            }
        }
    }
}
