//! The gradient of the weights where most gradients of the outputs are not zero.
//!
//! ∂w\[o, c, t\] = Σ_p g\[o, p\] x\[c, p + t\]. Outputs lie in vectors, as in the forward pass; a
//! register tile holds J channels times K taps along the width times V vectors, and sums over all
//! rows of a plane.

use crate::geometry::Geometry;
use crate::lanes::{Lanes, Level, Work};
use crate::padded::Padded;

/// Adds the gradient of the weights of one sample.
#[derive(Debug)]
pub struct DenseWeights<'a> {
    /// The shape.
    pub geometry: &'a Geometry,
    /// The input.
    pub input: &'a Padded,
    /// The gradient of the outputs, (O, D, H, W).
    pub gradient: &'a [f32],
    /// The gradient of the weights in the order of [`Geometry::pack`], added to.
    pub weights: &'a mut [f32],
    /// Room for a plane of gradients, [`scratch_length`] numbers.
    pub scratch: &'a mut [f32],
}

/// Numbers of scratch that [`DenseWeights`] wants.
pub fn scratch_length(geometry: &Geometry) -> usize {
    geometry.edges[1] * geometry.edges[2] * geometry.padded_outputs()
}

impl DenseWeights<'_> {
    /// Runs on the instructions of `level`.
    ///
    /// # Panics
    /// If the buffers do not fit the geometry.
    pub fn run_on(self, level: Level) {
        level.run(self);
    }
}

impl Work for DenseWeights<'_> {
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

impl DenseWeights<'_> {
    #[inline(always)]
    unsafe fn run_with<S: Lanes, const K: usize>(self) {
        let Self {
            geometry,
            input,
            gradient,
            weights,
            scratch,
        } = self;
        let [depth, height, width] = geometry.edges;
        let stride = geometry.padded_outputs();
        let sound = geometry.kernel == K
            && input.numbers.len() == geometry.channels * geometry.padded_voxels()
            && gradient.len() == geometry.outputs * geometry.voxels()
            && weights.len() == geometry.packed_weights()
            && scratch.len() == scratch_length(geometry);
        assert!(sound, "buffers do not fit a convolution of {geometry:?}");
        let plane = height * width;
        scratch.fill(0.0);
        for z in 0..depth {
            for o in 0..geometry.outputs {
                let from = &gradient[o * depth * plane + z * plane..][..plane];
                // Channels next to each other, voxel by voxel, as vectors across outputs want them.
                for (to, from) in scratch[o..].iter_mut().step_by(stride).zip(from) {
                    *to = *from;
                }
            }
            // Tap row by tap row: the plane of gradients stays in the cache for all k² of them.
            for row in 0..K * K {
                // SAFETY: lengths are checked above.
                unsafe { add_tap_row::<S, K>(geometry, input, z, row, scratch, weights) };
            }
        }
    }
}

/// Adds what one plane of gradients, voxel by voxel, gives to the weights of one row of taps.
///
/// # Safety
/// The processor has the instructions of `S`; the buffers have the lengths that `run_with` checks.
#[inline(always)]
#[allow(clippy::int_plus_one, reason = "the macro's smallest step is 1")]
unsafe fn add_tap_row<S: Lanes, const K: usize>(
    geometry: &Geometry,
    input: &Padded,
    z: usize,
    row: usize,
    gradient: &[f32],
    weights: &mut [f32],
) {
    let stride = geometry.padded_outputs();
    let [_, padded_height, padded_width] = geometry.padded_edges();
    let first = z * padded_height * padded_width + geometry.tap_row_offset(row);
    let vectors = stride / S::WIDTH;
    let mut vector = 0;
    macro_rules! sweep {
        ($vectors:literal: $($channels:literal)*) => {{
            let mut channel = 0;
            $(while channel + $channels <= geometry.channels {
                // SAFETY: of channels below C the tile reads rows `first / padded width + y`, y <
                // H, which end inside the grid because the row of taps is one of the kernel's, and
                // of these W + K - 1 numbers, a whole padded row; of the gradient H W voxels,
                // vectors below `stride`; it adds to the weights of rows (c K² + row) K + k < C K³,
                // vectors below `stride`.
                unsafe {
                    tile::<S, $channels, $vectors, K>(
                        geometry,
                        input,
                        channel,
                        first,
                        gradient.as_ptr().add(vector * S::WIDTH),
                        weights.as_mut_ptr().add(
                            (channel * K * K + row) * K * stride + vector * S::WIDTH,
                        ),
                    );
                }
                channel += $channels;
            })*
            vector += $vectors;
        }};
    }
    while vector < vectors {
        match (S::MANY, vectors - vector >= 2, K) {
            (true, true, 1) => sweep!(2: 8 4 1),
            (true, true, 3) => sweep!(2: 4 1),
            (true, true, _) => sweep!(2: 2 1),
            (true, false, 1) => sweep!(1: 16 4 1),
            (true, false, 3) => sweep!(1: 8 3 1),
            (true, false, _) => sweep!(1: 4 1),
            // Vectors of eight: their number is even.
            (false, _, 1) => sweep!(2: 4 1),
            (false, _, _) => sweep!(2: 1),
        }
    }
}

/// Inverse of the fraction of occupied voxels in a row of the input below which only these voxels
/// are processed.
const SCATTER_BELOW: usize = 4;

/// The sums of a register tile: J channels times K taps times V vectors.
type Sums<S, const J: usize, const V: usize, const K: usize> = [[[<S as Lanes>::Vector; V]; K]; J];

/// J channels times K taps times V vectors.
///
/// # Safety
/// The processor has the instructions of `S`; reads and writes stay inside, as argued where it is
/// called.
#[inline(always)]
unsafe fn tile<S: Lanes, const J: usize, const V: usize, const K: usize>(
    geometry: &Geometry,
    input: &Padded,
    channel: usize,
    first: usize,
    gradient: *const f32,
    weights: *mut f32,
) {
    let [_, height, width] = geometry.edges;
    let [_, _, padded_width] = geometry.padded_edges();
    let (plane, stride) = (geometry.padded_voxels(), geometry.padded_outputs());
    // SAFETY: the caller's promise.
    unsafe {
        // Sums over a whole plane in registers; weights are touched once per tile and plane.
        let mut sums: Sums<S, J, V, K> = [[[S::zero(); V]; K]; J];
        for y in 0..height {
            let number = first / padded_width + y;
            let row = Row {
                input: input
                    .numbers
                    .as_ptr()
                    .add(channel * plane + number * padded_width),
                plane,
                gradient: gradient.add(y * width * stride),
                stride,
                width,
            };
            let occupied = input.occupied.as_ref();
            match occupied.filter(|occupied| SCATTER_BELOW * occupied.count(number) < width) {
                Some(occupied) => {
                    for column in occupied.of_row(number, padded_width) {
                        row.add_voxel::<S, J, V, K>(column, &mut sums);
                    }
                }
                None => row.add_all::<S, J, V, K>(&mut sums),
            }
        }
        add_to_weights::<S, J, V, K>(&sums, weights, stride);
    }
}

/// A row of the input from the first channel of a tile on, and the row of gradients that it meets.
#[derive(Clone, Copy)]
struct Row {
    input: *const f32,
    /// Numbers from one channel of the input to the next.
    plane: usize,
    gradient: *const f32,
    /// Numbers from one voxel of the gradient to the next.
    stride: usize,
    width: usize,
}

impl Row {
    /// Adds what one voxel of the input gives, with every tap that sees it.
    ///
    /// # Safety
    /// As for [`tile`].
    #[inline(always)]
    unsafe fn add_voxel<S: Lanes, const J: usize, const V: usize, const K: usize>(
        self,
        column: usize,
        sums: &mut Sums<S, J, V, K>,
    ) {
        for k in 0..K.min(column + 1) {
            let x = column - k;
            if x >= self.width {
                continue;
            }
            // SAFETY: the caller's promise.
            unsafe {
                for (j, sums) in sums.iter_mut().enumerate() {
                    let value = S::splat(self.input.add(j * self.plane + column));
                    for (v, sum) in sums[k].iter_mut().enumerate() {
                        let vector = S::load(self.gradient.add(x * self.stride + v * S::WIDTH));
                        *sum = S::multiply_add(value, vector, *sum);
                    }
                }
            }
        }
    }

    /// Adds what all voxels of the row give.
    ///
    /// # Safety
    /// As for [`tile`].
    #[inline(always)]
    unsafe fn add_all<S: Lanes, const J: usize, const V: usize, const K: usize>(
        self,
        sums: &mut Sums<S, J, V, K>,
    ) {
        for x in 0..self.width {
            // SAFETY: the caller's promise.
            unsafe {
                let mut vectors = [S::zero(); V];
                for (v, vector) in vectors.iter_mut().enumerate() {
                    *vector = S::load(self.gradient.add(x * self.stride + v * S::WIDTH));
                }
                for (j, sums) in sums.iter_mut().enumerate() {
                    let input = self.input.add(j * self.plane + x);
                    for (k, sums) in sums.iter_mut().enumerate() {
                        let value = S::splat(input.add(k));
                        for (sum, vector) in sums.iter_mut().zip(vectors) {
                            *sum = S::multiply_add(value, vector, *sum);
                        }
                    }
                }
            }
        }
    }
}

/// Adds the sums of a tile to the weights.
///
/// # Safety
/// As for [`tile`].
#[inline(always)]
unsafe fn add_to_weights<S: Lanes, const J: usize, const V: usize, const K: usize>(
    sums: &Sums<S, J, V, K>,
    weights: *mut f32,
    stride: usize,
) {
    let one = 1.0f32;
    for (j, sums) in sums.iter().enumerate() {
        for (k, sums) in sums.iter().enumerate() {
            for (v, sum) in sums.iter().enumerate() {
                // SAFETY: the caller's promise.
                unsafe {
                    let to = weights.add((j * K * K * K + k) * stride + v * S::WIDTH);
                    let old = S::load(to);
                    S::store(to, S::multiply_add(S::splat(&raw const one), old, *sum));
                }
            }
        }
    }
}
