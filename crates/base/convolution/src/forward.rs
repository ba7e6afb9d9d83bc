//! The forward pass of one sample, with what follows it done while the rows are still in the cache.
//!
//! Outputs lie in vectors across channels; a register tile holds P voxels of a row times V vectors.
//! Each step takes V vectors of weights and P single numbers of the padded input, which lie next to
//! each other, and does P V multiply-adds.

use crate::geometry::{Geometry, LANES};
use crate::lanes::{Lanes, Level, Work};
use crate::padded::{Occupied, Padded};

/// Stands for no corner of a window: the ReLU gave 0.
pub const DEAD: u8 = 8;

/// Operation that follows the convolution and its bias.
#[derive(Debug)]
pub enum Finish<'a> {
    /// No further operation: (O, D, H, W).
    Plain(&'a mut [f32]),
    /// ReLU: (O, D, H, W).
    Relu(&'a mut [f32]),
    /// ReLU and the maximum of every 2 x 2 x 2 window, (O, D/2, H/2, W/2), and the corner that had
    /// it: 4 z + 2 y + x, or [`DEAD`]. The first of equals wins.
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
    /// Bias of each output; `None` stands for zeros.
    pub bias: Option<&'a [f32]>,
    /// Operation that follows the convolution and its bias.
    pub finish: Finish<'a>,
    /// Room for four rows of outputs and the biases, [`scratch_length`] numbers.
    pub scratch: &'a mut [f32],
}

/// Numbers of scratch that [`Forward`] wants.
pub fn scratch_length(geometry: &Geometry) -> usize {
    5 * geometry.edges[2] * geometry.padded_outputs()
}

impl Forward<'_> {
    /// Runs on the instructions of `level`.
    ///
    /// # Panics
    /// If the buffers do not fit the geometry.
    pub fn run_on(self, level: Level) {
        level.run(self);
    }
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
        let (geometry, outputs) = (self.geometry, self.geometry.outputs);
        let stride = geometry.padded_outputs();
        // Everything the tiles below touch lies in these lengths; the fields of this struct are not
        // trusted.
        let sound = geometry.kernel == K
            && self.input.numbers.len() == geometry.channels * geometry.padded_voxels()
            && self.weights.len() == geometry.packed_weights()
            && self.scratch.len() == scratch_length(geometry)
            && self.bias.is_none_or(|bias| bias.len() == outputs);
        assert!(sound, "buffers do not fit a convolution of {geometry:?}");
        let (rows, tail) = self.scratch.split_at_mut(4 * geometry.edges[2] * stride);
        // Biases padded with zeros, so that whole vectors may be added.
        let shift = &mut tail[..stride];
        shift.fill(0.0);
        if let Some(bias) = self.bias {
            shift[..outputs].copy_from_slice(bias);
        }
        let convolution = Rows {
            geometry,
            input: self.input,
            weights: self.weights,
        };
        // Taken before `finish` is moved.
        let relu = matches!(self.finish, Finish::Relu(_));
        // SAFETY: lengths are checked above.
        unsafe {
            match self.finish {
                Finish::Pool(out, codes) => convolution.pooled::<S, K>(rows, shift, out, codes),
                Finish::Plain(out) | Finish::Relu(out) => {
                    convolution.all::<S, K>(rows, shift, relu, out);
                }
            }
        }
    }
}

/// A convolution, row of outputs by row.
#[derive(Clone, Copy)]
struct Rows<'a> {
    geometry: &'a Geometry,
    input: &'a Padded,
    weights: &'a [f32],
}

impl Rows<'_> {
    /// All rows, with the bias added and the ReLU taken if requested.
    ///
    /// # Safety
    /// As for [`Rows::convolve`]; `scratch` holds a row or more.
    #[inline(always)]
    unsafe fn all<S: Lanes, const K: usize>(
        self,
        scratch: &mut [f32],
        shift: &[f32],
        relu: bool,
        out: &mut [f32],
    ) {
        let [depth, height, width] = self.geometry.edges;
        let stride = self.geometry.padded_outputs();
        let scratch = &mut scratch[..width * stride];
        for row in 0..depth * height {
            // SAFETY: the caller's promise.
            unsafe { self.convolve::<S, K>(row / height, row % height, scratch) };
            // Out of the vectors across channels into rows of each channel.
            for (o, shift) in shift.iter().enumerate().take(self.geometry.outputs) {
                let to = &mut out[(o * depth * height + row) * width..][..width];
                for (to, from) in to.iter_mut().zip(scratch[o..].iter().step_by(stride)) {
                    let value = from + shift;
                    *to = if relu { positive(value) } else { value };
                }
            }
        }
    }

    /// All rows of windows: the bias added, the ReLU taken, the maximum of each window.
    ///
    /// # Safety
    /// As for [`Rows::convolve`]; `scratch` holds four rows.
    #[inline(always)]
    unsafe fn pooled<S: Lanes, const K: usize>(
        self,
        scratch: &mut [f32],
        shift: &[f32],
        out: &mut [f32],
        codes: &mut [u8],
    ) {
        let (outputs, stride) = (self.geometry.outputs, self.geometry.padded_outputs());
        let length = self.geometry.edges[2] * stride;
        let [depth, height, width] = self.geometry.edges.map(|edge| edge / 2);
        // Corners for all channels, in the order of the row; sorted by channel afterwards.
        let mut chosen = vec![0u8; width * stride];
        for row in 0..depth * height {
            let (z, y) = (2 * (row / height), 2 * (row % height));
            let mut any = false;
            // The four rows of outputs that a row of windows
            // covers, in scratch that stays in the cache.
            for (corner, to) in scratch.chunks_exact_mut(length).enumerate() {
                // SAFETY: the caller's promise.
                any |= unsafe { self.convolve::<S, K>(z + corner / 2, y + corner % 2, to) };
            }
            // Rows without any input are left to the bias.
            if any {
                pool_rows(scratch, length, stride, shift, &mut chosen);
            }
            for (o, shift) in shift.iter().enumerate().take(outputs) {
                let first = (o * depth * height + row) * width;
                let (out, codes) = (&mut out[first..][..width], &mut codes[first..][..width]);
                if any {
                    gather(&scratch[o..], stride, out);
                    gather(&chosen[o..], stride, codes);
                } else {
                    // Where the input holds nothing, only the bias is left.
                    out.fill(positive(*shift));
                    codes.fill(if *shift <= 0.0 { DEAD } else { 0 });
                }
            }
        }
    }
}

/// Copies every `stride`-th element.
#[inline(always)]
fn gather<T: Copy>(from: &[T], stride: usize, to: &mut [T]) {
    for (to, from) in to.iter_mut().zip(from.iter().step_by(stride)) {
        *to = *from;
    }
}

/// ReLU. NaN must propagate.
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
                // Corner = 4 z + 2 y + x: z and y choose one of four rows, x the voxel.
                let place = corner / 2 * length + first + corner % 2 * stride;
                let value = lanes_at(rows, place);
                for i in 0..LANES {
                    // NaN wins, and then loses to nothing.
                    // Strictly better, so the first of equals
                    // wins; NaN beats numbers once and stays.
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
            // The results overwrite the front of the first
            // row, of which later windows need nothing.
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

impl Rows<'_> {
    /// One row of outputs, voxel by voxel: `out` is (W, padded O). False if it holds nothing but
    /// zeros because the input does.
    ///
    /// # Safety
    /// The processor has the instructions of `S`; the buffers have the lengths that `run_with`
    /// checks; `out` is W x padded O.
    #[inline(always)]
    unsafe fn convolve<S: Lanes, const K: usize>(
        self,
        z: usize,
        y: usize,
        out: &mut [f32],
    ) -> bool {
        let all = self.tap_rows::<K>(z, y);
        let taps = &all[..K * K];
        if let Some(occupied) = &self.input.occupied {
            let [_, _, width] = self.geometry.edges;
            let [_, _, padded_width] = self.geometry.padded_edges();
            // An upper limit: several voxels may share a bit.
            let mut count = 0;
            for tap in taps {
                count += occupied.count(tap.input / padded_width);
            }
            // Nothing to sum: the row is zeros.
            if count == 0 {
                out.fill(0.0);
                return false;
            }
            // Few voxels: their products are added one by one, which skips the zeros.
            if SCATTER_BELOW * count < K * K * width {
                // SAFETY: the caller's promise.
                unsafe { self.scatter::<S, K>(taps, occupied, out) };
                return true;
            }
        }
        // In one place for both kinds of input: what it inlines is most of this crate's code.
        // SAFETY: the caller's promise.
        unsafe { self.sweep::<S, K>(taps, self.input.occupied.as_ref(), out) };
        true
    }

    /// The rows of taps of a row of outputs, K² of them.
    #[inline(always)]
    fn tap_rows<const K: usize>(self, z: usize, y: usize) -> [TapRow; 25] {
        let [_, height, width] = self.geometry.padded_edges();
        let mut taps = [TapRow::default(); 25];
        for (row, tap) in taps.iter_mut().enumerate().take(K * K) {
            *tap = TapRow {
                // Input and weights of a tap row, for the first
                // channel; others follow at fixed strides.
                input: (z * height + y) * width + self.geometry.tap_row_offset(row),
                weights: row * K * self.geometry.padded_outputs(),
            };
        }
        taps
    }

    /// One row of outputs, register tile by register tile. With `occupied`, rows of taps that see
    /// nothing are left out.
    ///
    /// # Safety
    /// As for [`Rows::convolve`].
    #[inline(always)]
    #[allow(clippy::int_plus_one, reason = "the macro's smallest step is 1")]
    unsafe fn sweep<S: Lanes, const K: usize>(
        self,
        all: &[TapRow],
        occupied: Option<&Occupied>,
        out: &mut [f32],
    ) {
        let (geometry, width) = (self.geometry, self.geometry.edges[2]);
        let [_, _, padded_width] = geometry.padded_edges();
        let stride = geometry.padded_outputs();
        let vectors = stride / S::WIDTH;
        // At most 25 rows of taps; those that see only zeros are left out for this tile.
        let mut active = [TapRow::default(); 25];
        let mut vector = 0;
        macro_rules! sweep {
            ($vectors:literal: $($voxels:literal)*) => {{
                let mut x = 0;
                $(while x + $voxels <= width {
                    let mut taps = all;
                    if let Some(occupied) = occupied {
                        let mut count = 0;
                        for tap in all {
                            active[count] = *tap;
                            let row = tap.input / padded_width;
                            count += usize::from(occupied.any(row, x, $voxels + K - 1));
                        }
                        taps = &active[..count];
                    }
                    // SAFETY: the tile reads, of channel c < C, the numbers from tap.input + x on,
                    // $voxels + K - 1 of them: a tap row begins at a row of the padded grid and x +
                    // $voxels <= W, so they end inside that row. It reads weights of rows (c K² +
                    // row) K + k < C K³, vectors below `stride`. It writes voxels x to x + $voxels
                    // <= W of `out`, vectors below `stride`.
                    unsafe {
                        tile::<S, $voxels, $vectors, K>(
                            self.input.numbers.as_ptr().add(x),
                            geometry.padded_voxels(),
                            geometry.channels,
                            taps,
                            self.weights.as_ptr().add(vector * S::WIDTH),
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
            let remaining_vectors = vectors - vector;
            // Wide tiles first; what is left of a row takes smaller ones.
            if S::MANY && remaining_vectors >= 4 && width < 8 {
                sweep!(4: 4 2 1);
            } else if S::MANY && remaining_vectors >= 2 {
                sweep!(2: 8 4 2 1);
            } else if S::MANY {
                sweep!(1: 16 8 4 2 1);
            } else {
                // Vectors of eight: their number is even.
                sweep!(2: 4 2 1);
            }
        }
    }

    /// One row of outputs from the few voxels that hold anything.
    ///
    /// # Safety
    /// As for [`Rows::convolve`].
    #[inline(always)]
    unsafe fn scatter<S: Lanes, const K: usize>(
        self,
        taps: &[TapRow],
        occupied: &Occupied,
        out: &mut [f32],
    ) {
        let [_, _, width] = self.geometry.edges;
        let [_, _, padded_width] = self.geometry.padded_edges();
        let stride = self.geometry.padded_outputs();
        out.fill(0.0);
        for tap in taps {
            for column in occupied.of_row(tap.input / padded_width, padded_width) {
                // Voxel `column` is seen by output x through tap k if x + k = column.
                for k in 0..K.min(column + 1) {
                    let x = column - k;
                    if x < width {
                        // SAFETY: voxel `column` < padded width of row tap.input lies in the padded
                        // grid, k < K, and x < W.
                        unsafe {
                            self.scatter_voxel::<S, K>(tap, column, k, &mut out[x * stride..])
                        };
                    }
                }
            }
        }
    }

    /// Adds what tap `k` of a row of taps gives to one voxel of outputs, the first of `out`, when
    /// it sees voxel `at` of its row.
    ///
    /// # Safety
    /// As for [`Rows::convolve`]; the voxel lies in the padded grid, k < K, and `out` holds padded
    /// O numbers or more.
    #[inline(always)]
    unsafe fn scatter_voxel<S: Lanes, const K: usize>(
        self,
        tap: &TapRow,
        column: usize,
        k: usize,
        out: &mut [f32],
    ) {
        let (plane, stride) = (
            self.geometry.padded_voxels(),
            self.geometry.padded_outputs(),
        );
        for first in (0..stride).step_by(S::WIDTH) {
            // SAFETY: the caller's promise; the weights are those of rows (c K² + row) K + k < C
            // K³, vectors below `stride`.
            unsafe {
                let to = out.as_mut_ptr().add(first);
                let mut sum = S::load(to);
                for channel in 0..self.geometry.channels {
                    let value = self
                        .input
                        .numbers
                        .as_ptr()
                        .add(channel * plane + tap.input + column);
                    let row = channel * K * K * K + k;
                    let weight = self
                        .weights
                        .as_ptr()
                        .add(row * stride + tap.weights + first);
                    sum = S::multiply_add(S::splat(value), S::load(weight), sum);
                }
                S::store(to, sum);
            }
        }
    }
}

/// Inverse of the fraction of occupied voxels in the input of a row of outputs below which these
/// voxels are spread over the outputs one by one.
const SCATTER_BELOW: usize = 4;

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
        // P V sums in registers, P + V loads per step for P V multiply-adds.
        let mut sums = [[S::zero(); V]; P];
        for channel in 0..channels {
            let input = input.add(channel * plane);
            let weights = weights.add(channel * K * K * K * stride);
            for tap in taps {
                // Channels outside, taps, then the step along the row: weights are read in order.
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
