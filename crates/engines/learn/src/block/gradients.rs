//! The backward pass of a convolution, sample by sample, and the sum over samples.
//!
//! Behind a maximum over windows at most one in eight gradients is not zero. Where few are left
//! they are listed and taken one by one ([`sparse`]); otherwise all are taken ([`dense`], and a
//! forward pass with the weights turned round).

use super::convolution::{Convolution, Finishing};
use crate::numbers::{Numbers, sum};
use candle_core::{Result, Tensor};
use protomer_convolution::Geometry;
use protomer_convolution::buffers::Buffer;
use protomer_convolution::dense::{self, DenseWeights};
use protomer_convolution::forward::{self, DEAD, Finish, Forward};
use protomer_convolution::geometry::LANES;
use protomer_convolution::padded::{
    Occupied, Padded, channel_last, channel_last_length, count_nonzero, from_channel_last,
};
use protomer_convolution::sparse::{self, Entries, SparseInput, SparseWeights};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Gradients of the three arguments of a node.
pub(super) type ThreeGradients = (Option<Tensor>, Option<Tensor>, Option<Tensor>);

/// Data of one sample for the backward pass.
#[derive(Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) input: &'a [f32],
    pub(super) result: &'a [f32],
    pub(super) gradient: &'a [f32],
    pub(super) codes: &'a [u8],
    pub(super) occupied: Option<&'a Occupied>,
}

/// Gradients that one sample gives.
pub(super) struct Gradients {
    weights: WeightGradient,
    /// Gradients of the bias, and of what else the third argument of the node holds.
    pub(super) vectors: Vec<f32>,
}

/// The gradient of the weights, in the order of the kernel that computed it.
enum WeightGradient {
    /// Gradient in the order of [`sparse::pack`].
    Runs(Buffer),
    /// Gradient in the order of [`Geometry::pack`].
    Packed(Buffer),
}

/// The weights in the orders that gradients of the input want, made when first needed.
pub(super) struct Weights {
    plain: Vec<f32>,
    runs: OnceLock<Vec<f32>>,
    transposed: OnceLock<Vec<f32>>,
}

impl Weights {
    fn runs(&self, geometry: &Geometry) -> &[f32] {
        self.runs
            .get_or_init(|| sparse::pack(geometry, &self.plain))
    }

    fn transposed(&self, geometry: &Geometry) -> &[f32] {
        self.transposed
            .get_or_init(|| geometry.pack_transposed(&self.plain))
    }
}

/// The backward pass of one sample.
impl Convolution {
    /// Gradients of one sample. `input_gradient` is overwritten.
    pub(super) fn backward(
        &self,
        sample: Sample<'_>,
        weights: &Weights,
        input_gradient: Option<&mut [f32]>,
    ) -> Gradients {
        // Everything below takes the masked gradient: what ReLU
        // cut off moves neither weights nor bias nor input.
        let masked = self.masked(&sample);
        let gradient = masked.as_deref().unwrap_or(sample.gradient);
        let vectors = self.bias_gradient(gradient, sample.codes);
        let weights = match self.entries(gradient, &sample) {
            Some(entries) if sparse_pays(&self.geometry, entries.count()) => {
                self.backward_sparse(&sample, &entries, weights, input_gradient)
            }
            Some(entries) => {
                // Pooling left too many gradients to list them.
                let mut all = Buffer::zeros(self.geometry.outputs * self.geometry.voxels());
                entries.write_dense(&self.geometry, &mut all);
                self.backward_dense(sample.input, &all, weights, input_gradient)
            }
            None => self.backward_dense(sample.input, gradient, weights, input_gradient),
        };
        Gradients { weights, vectors }
    }

    /// The gradient without what the ReLU cut off. Pooling notes that in its codes.
    fn masked(&self, sample: &Sample<'_>) -> Option<Buffer> {
        if self.finishing != Finishing::Relu {
            return None;
        }
        // Stale memory is enough: every number is overwritten.
        let mut masked = Buffer::stale(sample.gradient.len());
        let pairs = sample.gradient.iter().zip(sample.result);
        for (to, (from, result)) in masked.iter_mut().zip(pairs) {
            *to = if *result <= 0.0 { 0.0 } else { *from };
        }
        Some(masked)
    }

    /// The gradient of the bias: the sum over each output channel.
    fn bias_gradient(&self, gradient: &[f32], codes: &[u8]) -> Vec<f32> {
        let outputs = self.geometry.outputs;
        let length = (gradient.len() / outputs).max(1);
        let channels = gradient.chunks_exact(length);
        let mut bias = vec![0.0; outputs];
        // A window whose maximum was cut off by ReLU has a gradient in memory that goes nowhere.
        if self.finishing == Finishing::Pool {
            let channels = channels.zip(codes.chunks_exact(length));
            for (bias, (gradient, codes)) in bias.iter_mut().zip(channels) {
                *bias = sum_alive(gradient, codes) as f32;
            }
        } else {
            for (bias, gradient) in bias.iter_mut().zip(channels) {
                *bias = sum(gradient) as f32;
            }
        }
        bias
    }

    /// The gradients that are not zero: always behind pooling, else if listing them pays.
    fn entries(&self, gradient: &[f32], sample: &Sample<'_>) -> Option<Entries> {
        let geometry = &self.geometry;
        if self.finishing == Finishing::Pool {
            // With few occupied voxels, most taps see nothing
            // but zeros and add nothing to the weights.
            let masks = sample.occupied.and_then(|occupied| occupied.seen(geometry));
            let codes = sample.codes;
            return Some(Entries::pooled(geometry, gradient, codes, masks.as_deref()));
        }
        // Counting first costs one pass; building a list that is then thrown away costs far more.
        sparse_pays(geometry, count_nonzero(gradient))
            .then(|| Entries::unpooled(geometry, gradient))
    }

    fn backward_sparse(
        &self,
        sample: &Sample<'_>,
        entries: &Entries,
        weights: &Weights,
        input_gradient: Option<&mut [f32]>,
    ) -> WeightGradient {
        let geometry = &self.geometry;
        // Stale, as `SparseWeights` overwrites what it returns.
        let mut gradient = Buffer::stale(sparse::weights_length(geometry));
        // One voxel's channels lie together, so that a
        // tap of a listed gradient is one run of memory.
        SparseWeights {
            geometry,
            input: &channel_last(geometry, sample.input, sample.occupied),
            entries,
            weights: &mut gradient,
        }
        .run_on(self.level);
        if let Some(to) = input_gradient {
            // Zeros, as listed gradients overlap in the input and are added.
            let mut channel_last = Buffer::zeros(channel_last_length(geometry));
            SparseInput {
                geometry,
                input: &mut channel_last,
                entries,
                // Filled once for all samples by whichever comes first; see `Weights`.
                weights: weights.runs(geometry),
            }
            .run_on(self.level);
            from_channel_last(geometry, &channel_last, to);
        }
        WeightGradient::Runs(gradient)
    }

    fn backward_dense(
        &self,
        input: &[f32],
        gradient: &[f32],
        weights: &Weights,
        input_gradient: Option<&mut [f32]>,
    ) -> WeightGradient {
        let weight_gradient = self.dense_weight_gradient(input, gradient);
        if let Some(to) = input_gradient {
            // The gradient of the input is the convolution of the gradient
            // with the kernel turned round and inputs and outputs exchanged.
            let transposed = self.geometry.transposed();
            let mut scratch = Buffer::stale(forward::scratch_length(&transposed));
            // Few gradients are zero here: looking for them would cost more than it saves.
            Forward {
                geometry: &transposed,
                input: &Padded::new(&transposed, gradient, false),
                weights: weights.transposed(&self.geometry),
                bias: None,
                finish: Finish::Plain(to),
                scratch: &mut scratch,
            }
            .run_on(self.level);
        }
        WeightGradient::Packed(weight_gradient)
    }

    fn dense_weight_gradient(&self, input: &[f32], gradient: &[f32]) -> Buffer {
        let geometry = &self.geometry;
        let mut weights = Buffer::zeros(geometry.packed_weights());
        let mut scratch = Buffer::stale(dense::scratch_length(geometry));
        DenseWeights {
            geometry,
            input: &Padded::new(geometry, input, self.from_data),
            gradient,
            weights: &mut weights,
            scratch: &mut scratch,
        }
        .run_on(self.level);
        weights
    }
}

/// Whether listing `entries` gradients is cheaper than taking all. Multiply-adds of vectors are
/// compared; those from the list count twice because each loads a separate vector. The answer
/// does not depend on the processor.
fn sparse_pays(geometry: &Geometry, entries: usize) -> bool {
    // Both sides count vector operations: taps times runs for
    // the list, all voxels times all packed weights without.
    let listed = 2 * entries * geometry.tap_rows() * sparse::run_length(geometry) / LANES;
    let all = geometry.voxels() * geometry.packed_weights() / LANES;
    listed < all
}

/// The sum of the gradients that go to some corner.
fn sum_alive(gradient: &[f32], codes: &[u8]) -> f64 {
    let mut total = 0.0;
    for (gradient, codes) in gradient.chunks(1024).zip(codes.chunks(1024)) {
        // f32 in lanes over 1024 numbers, f64 across:
        // vectorises, and loses no more than the gradients have.
        let mut lanes = [0.0f32; 16];
        for (gradient, codes) in gradient.chunks(16).zip(codes.chunks(16)) {
            for ((lane, value), code) in lanes.iter_mut().zip(gradient).zip(codes) {
                // Without a branch: dead and alive windows mix at random.
                *lane += if is_alive(*code) { *value } else { 0.0 };
            }
        }
        total += lanes.into_iter().map(f64::from).sum::<f64>();
    }
    total
}

/// Whether a code stands for a corner.
pub(super) fn is_alive(code: u8) -> bool {
    code != DEAD
}

/// The backward pass of all samples.
impl Convolution {
    /// The gradients of input, weight and third argument from those that `of_sample` gives for each
    /// sample: its number, its input, the weights, and room for the gradient of its input if that
    /// is wanted.
    pub(super) fn gradients(
        &self,
        input: &Tensor,
        weight: &Tensor,
        vectors: &Tensor,
        of_sample: impl Fn(usize, &[f32], &Weights, Option<&mut [f32]>) -> Gradients + Sync,
    ) -> Result<ThreeGradients> {
        let numbers = Numbers::from_tensor(input);
        let samples: Vec<&[f32]> = numbers
            .slice()?
            .chunks_exact(self.geometry.inputs())
            .collect();
        // Room for the gradient only where someone asks: the first block's input is data.
        let mut input_gradient = match input.track_op() {
            true => vec![0.0; input.elem_count()],
            false => Vec::new(),
        };
        let weights = Weights {
            plain: Numbers::from_tensor(weight).slice()?.to_vec(),
            runs: OnceLock::new(),
            transposed: OnceLock::new(),
        };
        let parts: Vec<Gradients> = self
            .rooms(&mut input_gradient, samples.len())
            .into_par_iter()
            .zip(samples)
            .enumerate()
            // Collected in the order of samples, not added as they finish:
            // sums of floating-point numbers must not depend on the threads.
            .map(|(i, (room, sample))| of_sample(i, sample, &weights, room))
            .collect();
        let mut sums = Sums::new(vectors.elem_count());
        for part in parts {
            sums.add(part);
        }
        let weight_gradient = sums.weights(&self.geometry);
        let device = input.device();
        let input_gradient = match input.track_op() {
            true => Some(Tensor::from_vec(input_gradient, input.shape(), device)?),
            false => None,
        };
        Ok((
            input_gradient,
            Some(Tensor::from_vec(weight_gradient, weight.shape(), device)?),
            Some(Tensor::from_vec(sums.vectors, vectors.shape(), device)?),
        ))
    }

    /// Room for the gradient of the input of each sample; none if it is not wanted.
    fn rooms<'a>(&self, gradient: &'a mut [f32], samples: usize) -> Vec<Option<&'a mut [f32]>> {
        let rooms = gradient.chunks_exact_mut(self.geometry.inputs());
        let mut rooms: Vec<_> = rooms.map(Some).collect();
        // `zip` ends at the shorter one, so an empty gradient still needs one entry a sample.
        rooms.resize_with(samples, || None);
        rooms
    }
}

/// Gradients summed in the order of the samples, whichever thread had them.
struct Sums {
    runs: Option<Buffer>,
    packed: Option<Buffer>,
    vectors: Vec<f32>,
}

impl Sums {
    fn new(vectors: usize) -> Self {
        Self {
            runs: None,
            packed: None,
            vectors: vec![0.0; vectors],
        }
    }

    fn add(&mut self, part: Gradients) {
        add(&mut self.vectors, &part.vectors);
        // The two layouts are added up apart: unpacking each
        // sample would cost a pass over the weights each.
        let (sum, weights) = match part.weights {
            WeightGradient::Runs(weights) => (&mut self.runs, weights),
            WeightGradient::Packed(weights) => (&mut self.packed, weights),
        };
        match sum {
            Some(sum) => add(sum, &weights),
            None => *sum = Some(weights),
        }
    }

    /// The gradient of the weights, (O, C, k, k, k).
    fn weights(&self, geometry: &Geometry) -> Vec<f32> {
        let mut weights = vec![0.0; geometry.weights()];
        // Some samples may have been sparse and others dense; both layouts count.
        if let Some(runs) = &self.runs {
            sparse::add_unpacked(geometry, runs, &mut weights);
        }
        if let Some(packed) = &self.packed {
            geometry.add_unpacked(packed, &mut weights);
        }
        weights
    }
}

fn add(sums: &mut [f32], values: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}
