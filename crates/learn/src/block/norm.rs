//! Convolution, bias, group normalisation, ReLU and pooling if wanted, as one node of the tensor
//! library's graph.

use super::convolution::{Convolution, Finishing};
use super::gradients::{Gradients, Sample, ThreeGradients, Weights};
use super::group_norm::{GroupNorm, Moments};
use super::{BlockParameters, BlockSettings};
use crate::convolution::Level;
use crate::convolution::buffers::Buffer;
use crate::convolution::forward::Finish;
use crate::convolution::padded::Occupied;
use crate::error::refuse;
use crate::numbers::{Numbers, contiguous, of_sample, wrong_storage};
use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor, bail};
use rayon::prelude::*;
use std::sync::OnceLock;

/// The node: (B, C, D, H, W), weight (O, C, k, k, k), and the bias of the convolution, the weight
/// and the bias of the normalisation one after the other, (3 O), to (B, O, D', H', W').
#[derive(Debug)]
pub(super) struct NormedConvolution {
    convolution: Convolution,
    norm: GroupNorm,
    /// Whether a gradient may be asked for.
    tracked: bool,
    kept: OnceLock<Vec<Kept>>,
}

/// What the backward pass needs of a sample.
#[derive(Debug)]
struct Kept {
    /// What the convolution gave.
    grid: Buffer,
    /// One for every group.
    moments: Vec<Moments>,
    /// The corners that pooling chose.
    codes: Vec<u8>,
    /// Which voxels of the input hold anything, if few do.
    occupied: Option<Occupied>,
}

impl NormedConvolution {
    /// Applies the node.
    ///
    /// # Errors
    /// [`crate::LearnError`] for shapes that do not fit.
    pub(super) fn apply(
        level: Level,
        input: &Tensor,
        parameters: &BlockParameters,
        settings: &BlockSettings,
    ) -> crate::Result<Tensor> {
        let (Some(groups), Some((scale, shift))) = (settings.groups, &parameters.norm) else {
            return refuse("a normalisation without groups or parameters");
        };
        let convolution = Convolution::new(level, Finishing::Plain, input, parameters)?;
        let channels = convolution.geometry.outputs;
        let fits = groups != 0
            && channels % groups == 0
            && scale.dims() == [channels]
            && shift.dims() == [channels];
        if !fits {
            return refuse(format!(
                "{channels} channels in {groups} groups, {:?} weights and {:?} biases of the \
                 normalisation",
                scale.dims(),
                shift.dims()
            ));
        }
        let weight = parameters.weight.contiguous()?;
        let vectors = Tensor::cat(&[&parameters.bias, scale, shift], 0)?;
        let node = Self {
            norm: GroupNorm {
                level,
                groups,
                pool: settings.pool,
                channels,
                edges: convolution.geometry.edges,
            },
            convolution,
            tracked: input.track_op() || weight.track_op() || vectors.track_op(),
            kept: OnceLock::new(),
        };
        Ok(input.contiguous()?.apply_op3(&weight, &vectors, node)?)
    }

    /// The forward pass of one sample.
    fn forward(&self, sample: &[f32], packed: &[f32], vectors: &[f32], out: &mut [f32]) -> Kept {
        let norm = &self.norm;
        let [bias, weights, biases] = [0, 1, 2].map(|i| of_sample(vectors, i, norm.channels));
        let mut grid = Buffer::stale(norm.channels * norm.voxels());
        let finish = Finish::Plain(&mut grid);
        let occupied = self
            .convolution
            .forward_sample(sample, packed, bias, finish);
        let mut codes = vec![0; if norm.pool { out.len() } else { 0 }];
        let moments = norm.forward(&grid, weights, biases, out, &mut codes);
        Kept {
            grid,
            moments,
            codes,
            occupied,
        }
    }

    /// Gradients of one sample. `input_gradient` is overwritten.
    fn backward(
        &self,
        kept: &Kept,
        scale: &[f32],
        sample: Sample<'_>,
        weights: &Weights,
        input_gradient: Option<&mut [f32]>,
    ) -> Gradients {
        let mut grid_gradient = Buffer::zeros(self.norm.channels * self.norm.voxels());
        let norm_gradients = self.norm.backward(
            &kept.grid,
            &kept.moments,
            scale,
            &sample,
            &mut grid_gradient,
        );
        let sample = Sample {
            gradient: &grid_gradient,
            ..sample
        };
        let mut gradients = self.convolution.backward(sample, weights, input_gradient);
        for value in norm_gradients.into_iter().flatten() {
            gradients.vectors.push(value as f32);
        }
        gradients
    }
}

impl CustomOp3 for NormedConvolution {
    fn name(&self) -> &'static str {
        "convolution-bias-norm-relu-pool"
    }

    fn cpu_fwd(
        &self,
        input: &CpuStorage,
        input_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
        vectors: &CpuStorage,
        vectors_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let input = contiguous(input, input_layout)?;
        let weight = contiguous(weight, weight_layout)?;
        let vectors = contiguous(vectors, vectors_layout)?;
        let (norm, geometry) = (&self.norm, &self.convolution.geometry);
        let packed = geometry.pack(weight);
        let to = norm.channels * norm.out_voxels();
        let samples = input_layout.dims().first().copied().unwrap_or(0);
        let mut out = vec![0.0; samples * to];
        let kept: Vec<Option<Kept>> = input
            .par_chunks_exact(geometry.inputs())
            .zip(out.par_chunks_exact_mut(to.max(1)))
            .map(|(sample, out)| {
                let kept = self.forward(sample, &packed, vectors, out);
                // Without a gradient the grid goes back to the buffers at once.
                self.tracked.then_some(kept)
            })
            .collect();
        if self.tracked && self.kept.set(kept.into_iter().flatten().collect()).is_err() {
            bail!("a node of the graph was run twice");
        }
        let [depth, height, width] = norm.out_edges();
        let shape = Shape::from((samples, norm.channels, depth, height, width));
        Ok((CpuStorage::F32(out), shape))
    }

    fn bwd(
        &self,
        input: &Tensor,
        weight: &Tensor,
        vectors: &Tensor,
        result: &Tensor,
        gradient: &Tensor,
    ) -> Result<ThreeGradients> {
        let Some(kept) = self.kept.get() else {
            bail!("a gradient was asked for, but nothing was tracked")
        };
        if Some(kept.len()) != input.dims().first().copied() {
            return Err(wrong_storage());
        }
        let gradient = gradient.contiguous()?;
        let (gradient, result) = (Numbers::of(&gradient), Numbers::of(result));
        let (gradient, result) = (gradient.slice()?, result.slice()?);
        let numbers = Numbers::of(vectors);
        let scale = of_sample(numbers.slice()?, 1, self.norm.channels);
        let to = self.norm.channels * self.norm.out_voxels();
        let convolution = &self.convolution;
        convolution.gradients(
            input,
            weight,
            vectors,
            |i, input, weights, input_gradient| {
                let kept = &kept[i];
                let sample = Sample {
                    input,
                    result: of_sample(result, i, to),
                    gradient: of_sample(gradient, i, to),
                    codes: &kept.codes,
                    occupied: kept.occupied.as_ref(),
                };
                self.backward(kept, scale, sample, weights, input_gradient)
            },
        )
    }
}
