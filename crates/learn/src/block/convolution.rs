//! Convolution, bias, and ReLU and pooling if wanted, as one node of the tensor library's graph.

use super::{contiguous, with_slice};
use crate::convolution::buffers::Buffer;
use crate::convolution::dense::{self, DenseWeights};
use crate::convolution::forward::{self, DEAD, Finish, Forward};
use crate::convolution::geometry::LANES;
use crate::convolution::padded::{Occupied, Padded, channel_last, from_channel_last};
use crate::convolution::sparse::{self, Entries, SparseInput, SparseWeights};
use crate::convolution::{Geometry, Level};
use candle_core::{CpuStorage, CustomOp3, Error, Layout, Result, Shape, Tensor, bail};
use rayon::prelude::*;
use std::sync::OnceLock;

/// What follows convolution and bias in the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finishing {
    /// Nothing.
    Plain,
    /// ReLU.
    Relu,
    /// ReLU and the maximum of every 2 x 2 x 2 window.
    Pool,
}

/// The node: (B, C, D, H, W), (O, C, k, k, k) and (O) to (B, O, D', H', W'). One instance serves
/// one call.
#[derive(Debug)]
pub struct Convolution {
    geometry: Geometry,
    finishing: Finishing,
    level: Level,
    /// Whether a gradient may be asked for.
    tracked: bool,
    /// Whether the input is data, perhaps mostly zeros, and not the output of another layer.
    from_data: bool,
    kept: OnceLock<Kept>,
}

/// What the backward pass needs besides inputs and results.
#[derive(Debug)]
struct Kept {
    /// The corners that pooling chose.
    codes: Vec<u8>,
    /// For every sample, which of its voxels hold anything, if few do.
    occupied: Vec<Option<Occupied>>,
}

impl Convolution {
    /// A node for these arguments.
    ///
    /// # Errors
    /// [`crate::LearnError`] for shapes that do not fit.
    pub(super) fn new(
        level: Level,
        finishing: Finishing,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
    ) -> crate::Result<Self> {
        let (_, channels, depth, height, width) = input.dims5()?;
        let (outputs, weight_channels, kernel, _, _) = weight.dims5()?;
        let geometry = Geometry {
            channels,
            outputs,
            kernel,
            edges: [depth, height, width],
        };
        geometry.check()?;
        if weight_channels != channels
            || weight.elem_count() != geometry.weights()
            || bias.dims() != [outputs]
        {
            return Err(crate::LearnError::Settings(format!(
                "weights {:?} and biases {:?} for grids of {channels} channels",
                weight.dims(),
                bias.dims()
            )));
        }
        Ok(Self {
            geometry,
            finishing,
            level,
            tracked: input.track_op() || weight.track_op() || bias.track_op(),
            from_data: !input.track_op(),
            kept: OnceLock::new(),
        })
    }

    /// The node applied.
    ///
    /// # Errors
    /// [`crate::LearnError`] for shapes that do not fit.
    pub fn apply(
        level: Level,
        finishing: Finishing,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
    ) -> crate::Result<Tensor> {
        let node = Self::new(level, finishing, input, weight, bias)?;
        Ok(input
            .contiguous()?
            .apply_op3(&weight.contiguous()?, &bias.contiguous()?, node)?)
    }

    /// The shape of the convolution.
    pub(super) fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    fn out_edges(&self) -> [usize; 3] {
        match self.finishing {
            Finishing::Pool => self.geometry.edges.map(|edge| edge / 2),
            Finishing::Plain | Finishing::Relu => self.geometry.edges,
        }
    }

    /// Numbers that one sample gives.
    fn out_length(&self) -> usize {
        self.geometry.outputs * self.out_edges().iter().product::<usize>()
    }

    fn forward(&self, input: &[f32], weights: &[f32], bias: &[f32]) -> (Vec<f32>, Kept) {
        let geometry = &self.geometry;
        let packed = geometry.pack(weights);
        let (from, to) = (geometry.channels * geometry.voxels(), self.out_length());
        let samples = input.len() / from;
        let mut out = vec![0.0; samples * to];
        let mut codes = vec![
            0;
            if self.finishing == Finishing::Pool {
                samples * to
            } else {
                0
            }
        ];
        let run = |sample: &[f32], finish| self.forward_sample(sample, &packed, bias, finish);
        let each = input
            .par_chunks_exact(from)
            .zip(out.par_chunks_exact_mut(to.max(1)));
        let occupied = match self.finishing {
            Finishing::Plain => each
                .map(|(sample, out)| run(sample, Finish::Plain(out)))
                .collect(),
            Finishing::Relu => each
                .map(|(sample, out)| run(sample, Finish::Relu(out)))
                .collect(),
            Finishing::Pool => each
                .zip(codes.par_chunks_exact_mut(to.max(1)))
                .map(|((sample, out), codes)| run(sample, Finish::Pool(out, codes)))
                .collect(),
        };
        (out, Kept { codes, occupied })
    }

    /// The forward pass of one sample with packed weights; gives which of its voxels hold anything,
    /// if few do.
    pub(super) fn forward_sample(
        &self,
        sample: &[f32],
        packed: &[f32],
        bias: &[f32],
        finish: Finish<'_>,
    ) -> Option<Occupied> {
        let geometry = &self.geometry;
        let input = Padded::new(geometry, sample, self.from_data);
        let mut scratch = Buffer::stale(forward::scratch_length(geometry));
        let bias = Some(bias);
        self.level.run(Forward {
            geometry,
            input: &input,
            weights: packed,
            bias,
            finish,
            scratch: &mut scratch,
        });
        input.occupied
    }

    /// Gradients of one sample; `input_gradient` is overwritten.
    pub(super) fn backward(
        &self,
        sample: Sample<'_>,
        weights: &Weights,
        input_gradient: Option<&mut [f32]>,
    ) -> Gradients {
        let geometry = &self.geometry;
        let Sample {
            input,
            result,
            gradient,
            codes,
            occupied,
        } = sample;
        let (outputs, voxels) = (geometry.outputs, geometry.voxels());
        let masked = match self.finishing {
            Finishing::Relu => {
                let mut masked = Buffer::stale(gradient.len());
                for ((to, from), result) in masked.iter_mut().zip(gradient).zip(result) {
                    *to = if *result <= 0.0 { 0.0 } else { *from };
                }
                Some(masked)
            }
            Finishing::Plain | Finishing::Pool => None,
        };
        let gradient = masked.as_deref().unwrap_or(gradient);
        let mut bias = vec![0.0; outputs];
        let entries = match self.finishing {
            Finishing::Pool => {
                let windows = (gradient.len() / outputs).max(1);
                let channels = gradient
                    .chunks_exact(windows)
                    .zip(codes.chunks_exact(windows));
                for (bias, (gradient, codes)) in bias.iter_mut().zip(channels) {
                    *bias = sum_alive(gradient, codes) as f32;
                }
                let seen = occupied.and_then(|occupied| occupied.seen(geometry));
                Some(Entries::pooled(geometry, gradient, codes, seen.as_deref()))
            }
            Finishing::Plain | Finishing::Relu => {
                for (bias, gradient) in bias.iter_mut().zip(gradient.chunks_exact(voxels)) {
                    *bias = super::sum(gradient) as f32;
                }
                let count = gradient
                    .chunks(4096)
                    .map(|part| part.iter().map(|v| u32::from(*v != 0.0)).sum::<u32>());
                let count = count.map(|count| count as usize).sum();
                sparse_pays(geometry, count).then(|| Entries::unpooled(geometry, gradient))
            }
        };
        if let Some(entries) = entries
            .as_ref()
            .filter(|entries| sparse_pays(geometry, entries.count()))
        {
            let mut gradients = Buffer::stale(sparse::weights_length(geometry));
            let input = channel_last(geometry, input, occupied);
            self.level.run(SparseWeights {
                geometry,
                input: &input,
                entries,
                weights: &mut gradients,
            });
            drop(input);
            if let Some(to) = input_gradient {
                let mut spread = Buffer::zeros(
                    geometry.channels * geometry.padded_voxels()
                        + crate::convolution::padded::slack(geometry),
                );
                self.level.run(SparseInput {
                    geometry,
                    input: &mut spread,
                    entries,
                    weights: weights.runs(geometry),
                });
                from_channel_last(geometry, &spread, to);
            }
            return Gradients {
                weights: gradients,
                sparse: true,
                bias,
            };
        }
        let full = entries.map(|entries| {
            let mut full = Buffer::zeros(outputs * voxels);
            entries.write_dense(geometry, &mut full);
            full
        });
        let gradient = full.as_deref().unwrap_or(gradient);
        let mut gradients =
            Buffer::zeros(geometry.channels * geometry.taps() * geometry.padded_outputs());
        let mut scratch = Buffer::stale(dense::scratch_length(geometry));
        let padded = Padded::new(geometry, input, self.from_data);
        self.level.run(DenseWeights {
            geometry,
            input: &padded,
            gradient,
            weights: &mut gradients,
            scratch: &mut scratch,
        });
        drop((padded, scratch));
        if let Some(to) = input_gradient {
            let transposed = geometry.transposed();
            let padded = Padded::new(&transposed, gradient, false);
            let mut scratch = Buffer::stale(forward::scratch_length(&transposed));
            self.level.run(Forward {
                geometry: &transposed,
                input: &padded,
                weights: weights.transposed(geometry),
                bias: None,
                finish: Finish::Plain(to),
                scratch: &mut scratch,
            });
        }
        Gradients {
            weights: gradients,
            sparse: false,
            bias,
        }
    }
}

/// What one sample brings to the backward pass.
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
    weights: Buffer,
    /// Whether the weights are in runs.
    sparse: bool,
    /// Of the bias, and of what else the third argument holds.
    pub(super) bias: Vec<f32>,
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

/// Whether listing `entries` gradients is cheaper than using all: multiply-adds of vectors either
/// way, those from the list counted twice because each loads a vector of its own. The answer does
/// not depend on the processor.
fn sparse_pays(geometry: &Geometry, entries: usize) -> bool {
    let listed = 2 * entries * geometry.tap_rows() * sparse::run_length(geometry) / LANES;
    let all =
        geometry.voxels() * geometry.taps() * geometry.channels * geometry.padded_outputs() / LANES;
    listed < all
}

impl CustomOp3 for Convolution {
    fn name(&self) -> &'static str {
        "convolution-bias-relu-pool"
    }

    fn cpu_fwd(
        &self,
        input: &CpuStorage,
        input_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
        bias: &CpuStorage,
        bias_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let input = contiguous(input, input_layout)?;
        let (weight, bias) = (
            contiguous(weight, weight_layout)?,
            contiguous(bias, bias_layout)?,
        );
        let samples = input_layout.dims().first().copied().unwrap_or(0);
        let [depth, height, width] = self.out_edges();
        let (out, kept) = self.forward(input, weight, bias);
        if self.tracked && self.kept.set(kept).is_err() {
            bail!("a node of the graph was run twice");
        }
        Ok((
            CpuStorage::F32(out),
            Shape::from((samples, self.geometry.outputs, depth, height, width)),
        ))
    }

    fn bwd(
        &self,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        result: &Tensor,
        gradient: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let Some(Kept { codes, occupied }) = self.kept.get() else {
            bail!("a gradient was asked for, but nothing was tracked")
        };
        let to = self.out_length();
        with_slice(result, |result| {
            with_slice(&gradient.contiguous()?, |gradient| {
                self.gradients(input, weight, bias, |i, input, weights, input_gradient| {
                    let sample = Sample {
                        input,
                        result: result.get(i * to..(i + 1) * to).unwrap_or_default(),
                        gradient: gradient.get(i * to..(i + 1) * to).unwrap_or_default(),
                        codes: codes.get(i * to..(i + 1) * to).unwrap_or_default(),
                        occupied: occupied.get(i).and_then(Option::as_ref),
                    };
                    self.backward(sample, weights, input_gradient)
                })
            })
        })
    }
}

/// Gradients of the three arguments of a node.
pub(super) type ThreeGradients = (Option<Tensor>, Option<Tensor>, Option<Tensor>);

impl Convolution {
    /// The gradients of input, weight and bias from those that `of_sample` gives sample by sample.
    pub(super) fn gradients(
        &self,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        of_sample: impl Fn(usize, &[f32], &Weights, Option<&mut [f32]>) -> Gradients + Sync,
    ) -> Result<ThreeGradients> {
        let geometry = &self.geometry;
        let from = geometry.channels * geometry.voxels();
        let plain = with_slice(weight, |weight| Ok(weight.to_vec()))?;
        let weights = Weights {
            plain,
            runs: OnceLock::new(),
            transposed: OnceLock::new(),
        };
        let wanted = input.track_op();
        let mut input_gradient = vec![0.0; if wanted { input.elem_count() } else { 0 }];
        let found = with_slice(input, |input| {
            let samples = input.len() / from;
            let mut parts: Vec<Option<&mut [f32]>> = if wanted {
                input_gradient.chunks_exact_mut(from).map(Some).collect()
            } else {
                (0..samples).map(|_| None).collect()
            };
            let each = parts
                .par_iter_mut()
                .zip(input.par_chunks_exact(from))
                .enumerate();
            Ok(each
                .map(|(i, (part, input))| of_sample(i, input, &weights, part.take()))
                .collect::<Vec<_>>())
        })?;
        // Summed in the order of the samples, whichever thread had them.
        let mut runs: Option<Buffer> = None;
        let mut packed: Option<Buffer> = None;
        let mut bias_gradient = vec![0.0; bias.elem_count()];
        for part in found {
            bias_gradient
                .iter_mut()
                .zip(&part.bias)
                .for_each(|(sum, value)| *sum += value);
            match if part.sparse { &mut runs } else { &mut packed } {
                Some(sum) => sum
                    .iter_mut()
                    .zip(part.weights.iter())
                    .for_each(|(sum, value)| *sum += value),
                empty => *empty = Some(part.weights),
            }
        }
        let mut weight_gradient = vec![0.0; geometry.weights()];
        if let Some(runs) = runs {
            sparse::add_unpacked(geometry, &runs, &mut weight_gradient);
        }
        if let Some(packed) = packed {
            geometry.add_unpacked(&packed, &mut weight_gradient);
        }
        let device = input.device();
        let input_gradient = if wanted {
            Some(Tensor::from_vec(input_gradient, input.shape(), device)?)
        } else {
            None
        };
        let weight_gradient = Tensor::from_vec(weight_gradient, weight.shape(), device)?;
        Ok((
            input_gradient,
            Some(weight_gradient),
            Some(Tensor::from_vec(bias_gradient, bias.shape(), device)?),
        ))
    }
}

/// The sum of the gradients that go to some corner.
fn sum_alive(gradient: &[f32], codes: &[u8]) -> f64 {
    let mut total = 0.0;
    for (gradient, codes) in gradient.chunks(1024).zip(codes.chunks(1024)) {
        let mut lanes = [0.0f32; 16];
        for (gradient, codes) in gradient.chunks(16).zip(codes.chunks(16)) {
            for ((lane, value), code) in lanes.iter_mut().zip(gradient).zip(codes) {
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

/// An error of the tensor library for storage of the wrong kind.
pub(super) fn wrong_storage() -> Error {
    Error::Msg("grids on the processor must be contiguous f32".into())
}
