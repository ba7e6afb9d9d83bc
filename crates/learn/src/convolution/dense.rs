//! The gradient of the weights where most gradients of the outputs are not zero.
//!
//! ∂w\[o, c, t\] = Σ_p g\[o, p\] x\[c, p + t\]. Outputs lie in vectors, as in the forward pass; a
//! register tile holds J channels times K taps along the width times V vectors, and sums over all
//! rows of a plane.

use super::geometry::Geometry;
use super::lanes::{Lanes, Work};
use super::padded::Padded;

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
            && weights.len() == geometry.channels * geometry.taps() * stride
            && scratch.len() == scratch_length(geometry);
        assert!(sound, "buffers do not fit a convolution of {geometry:?}");
        let plane = height * width;
        scratch.fill(0.0);
        for z in 0..depth {
            for o in 0..geometry.outputs {
                let from = &gradient[o * depth * plane + z * plane..][..plane];
                for (to, from) in scratch[o..].iter_mut().step_by(stride).zip(from) {
                    *to = *from;
                }
            }
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
                        weights.as_mut_ptr().add((channel * K * K + row) * K * stride + vector * S::WIDTH),
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

/// If fewer than one in this many voxels of a row of the input hold anything, only these are gone
/// through.
const SCATTER_BELOW: usize = 4;

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
    let stride = geometry.padded_outputs();
    let plane = geometry.padded_voxels();
    let [_, height, width] = geometry.edges;
    let padded_width = geometry.padded_edges()[2];
    // SAFETY: the caller's promise.
    unsafe {
        let input_of_channel = input.numbers.as_ptr().add(channel * plane);
        let mut sums = [[[S::zero(); V]; K]; J];
        for y in 0..height {
            let row = first / padded_width + y;
            let occupied = input
                .occupied
                .as_ref()
                .filter(|occupied| SCATTER_BELOW * occupied.count(row) < width);
            let input = input_of_channel.add(row * padded_width);
            let gradient = gradient.add(y * width * stride);
            if let Some(occupied) = occupied {
                for at in occupied.of_row(row, padded_width) {
                    for k in 0..K.min(at + 1) {
                        let x = at - k;
                        if x >= width {
                            continue;
                        }
                        for (j, sums) in sums.iter_mut().enumerate() {
                            let value = S::splat(input.add(j * plane + at));
                            for (v, sum) in sums[k].iter_mut().enumerate() {
                                let vector = S::load(gradient.add(x * stride + v * S::WIDTH));
                                *sum = S::multiply_add(value, vector, *sum);
                            }
                        }
                    }
                }
                continue;
            }
            for x in 0..width {
                let mut vectors = [S::zero(); V];
                for (v, vector) in vectors.iter_mut().enumerate() {
                    *vector = S::load(gradient.add(x * stride + v * S::WIDTH));
                }
                for (j, sums) in sums.iter_mut().enumerate() {
                    let input = input.add(j * plane + x);
                    for (k, sums) in sums.iter_mut().enumerate() {
                        let value = S::splat(input.add(k));
                        for (sum, vector) in sums.iter_mut().zip(vectors) {
                            *sum = S::multiply_add(value, vector, *sum);
                        }
                    }
                }
            }
        }
        for (j, sums) in sums.iter().enumerate() {
            for (k, sums) in sums.iter().enumerate() {
                for (v, sum) in sums.iter().enumerate() {
                    let to = weights.add((j * K * K * K + k) * stride + v * S::WIDTH);
                    let one = [1.0f32];
                    let old = S::load(to);
                    S::store(to, S::multiply_add(S::splat(one.as_ptr()), old, *sum));
                }
            }
        }
    }
}
