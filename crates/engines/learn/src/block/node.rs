//! A block as one node of the tensor library's graph: convolution and bias, group normalisation if
//! wanted, ReLU, pooling if wanted; forward, and backward sample by sample.

use super::convolution::{Convolution, Finishing};
use super::gradients::{Gradients, Sample, ThreeGradients, Weights};
use super::group_norm::{GroupNorm, Moments};
use super::{BlockParameters, BlockSettings};
use crate::error::refuse;
use crate::numbers::{Numbers, contiguous, of_sample, wrong_storage};
use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor, bail};
use protomer_convolution::Level;
use protomer_convolution::buffers::Buffer;
use protomer_convolution::forward::Finish;
use protomer_convolution::padded::Occupied;
use rayon::prelude::*;
use std::sync::OnceLock;

/// The node: (B, C, D, H, W), weight (O, C, k, k, k), and the vectors to (B, O, D', H', W'). The
/// vectors are the bias of the convolution, (O); with normalisation its weight and bias follow,
/// (3 O). One instance serves one call.
#[derive(Debug)]
pub(super) struct Node {
    convolution: Convolution,
    norm: Option<GroupNorm>,
    /// Whether a gradient may be requested.
    tracked: bool,
    records: OnceLock<Vec<Kept>>,
}

/// Data of a sample that the backward pass needs, besides its input and its result.
#[derive(Debug)]
struct Kept {
    /// The corners that pooling chose.
    codes: Vec<u8>,
    /// Voxels of the input that hold anything, if they are few.
    occupied: Option<Occupied>,
    normed: Option<Normed>,
}

/// Data of a sample that the normalisation keeps.
#[derive(Debug)]
struct Normed {
    /// Result of the convolution.
    grid: Buffer,
    /// Moments of every group.
    moments: Vec<Moments>,
}

impl Node {
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
        let finishing = match (settings.groups, settings.pool) {
            // With a normalisation the ReLU and the pooling come after
            // it, so the convolution must deliver plain numbers.
            (Some(_), _) => Finishing::Plain,
            (None, true) => Finishing::Pool,
            (None, false) => Finishing::Relu,
        };
        let convolution = Convolution::new(level, finishing, input, parameters)?;
        let norm = match settings.groups {
            Some(groups) => Some(norm(groups, settings.pool, &convolution, parameters)?),
            None => None,
        };
        let weight = parameters.weight.contiguous()?;
        let vectors = match (&norm, &parameters.norm) {
            // An operation of the graph takes three arguments
            // at most: the three vectors travel as one.
            (Some(_), Some((scale, shift))) => Tensor::cat(&[&parameters.bias, scale, shift], 0)?,
            _ => parameters.bias.contiguous()?,
        };
        let node = Self {
            convolution,
            norm,
            // Without a gradient to come, the forward pass keeps nothing.
            tracked: input.track_op() || weight.track_op() || vectors.track_op(),
            records: OnceLock::new(),
        };
        Ok(input.contiguous()?.apply_op3(&weight, &vectors, node)?)
    }

    fn out_edges(&self) -> [usize; 3] {
        match &self.norm {
            Some(norm) => norm.out_edges(),
            None => self.convolution.out_edges(),
        }
    }

    /// Numbers that one sample gives.
    fn out_length(&self) -> usize {
        self.convolution.geometry.outputs * self.out_edges().iter().product::<usize>()
    }

    /// The forward pass of one sample.
    fn forward(&self, sample: &[f32], packed: &[f32], vectors: &[f32], out: &mut [f32]) -> Kept {
        let Some(norm) = &self.norm else {
            let (codes, occupied) = self
                .convolution
                .finished_sample(sample, packed, vectors, out);
            return Kept {
                codes,
                occupied,
                normed: None,
            };
        };
        let [bias, weights, biases] = [0, 1, 2].map(|i| of_sample(vectors, i, norm.channels));
        // The plain grid is kept for the backward pass, which needs x̂ again.
        let mut grid = Buffer::stale(norm.channels * norm.voxels());
        let finish = Finish::Plain(&mut grid);
        let occupied = self
            .convolution
            .forward_sample(sample, packed, bias, finish);
        let mut codes = vec![0; if norm.pool { out.len() } else { 0 }];
        let moments = norm.forward(&grid, weights, biases, out, &mut codes);
        Kept {
            codes,
            occupied,
            normed: Some(Normed { grid, moments }),
        }
    }

    /// Gradients of one sample. `input_gradient` is overwritten.
    fn backward(
        &self,
        normed: Option<&Normed>,
        vectors: &[f32],
        sample: Sample<'_>,
        weights: &Weights,
        input_gradient: Option<&mut [f32]>,
    ) -> Gradients {
        let (Some(norm), Some(Normed { grid, moments })) = (&self.norm, normed) else {
            // Nothing was kept for a normalisation, so there is none.
            return self.convolution.backward(sample, weights, input_gradient);
        };
        let scale = of_sample(vectors, 1, norm.channels);
        // Zeros: `GroupNorm::backward` writes only where a gradient arrives.
        let mut grid_gradient = Buffer::zeros(norm.channels * norm.voxels());
        let norm_gradients = norm.backward(grid, moments, scale, &sample, &mut grid_gradient);
        // The convolution before the normalisation sees its gradient in place of the block's.
        let sample = Sample {
            gradient: &grid_gradient,
            ..sample
        };
        let mut gradients = self.convolution.backward(sample, weights, input_gradient);
        // In the order in which `apply` joined the vectors: bias, scale, shift.
        for value in norm_gradients.into_iter().flatten() {
            gradients.vectors.push(value as f32);
        }
        gradients
    }
}

/// The normalisation behind a convolution.
fn norm(
    groups: usize,
    pool: bool,
    convolution: &Convolution,
    parameters: &BlockParameters,
) -> crate::Result<GroupNorm> {
    let Some((scale, shift)) = &parameters.norm else {
        return refuse("a normalisation without parameters");
    };
    let channels = convolution.geometry.outputs;
    let fits = groups != 0
        && channels.is_multiple_of(groups)
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
    Ok(GroupNorm {
        level: convolution.level,
        groups,
        pool,
        channels,
        edges: convolution.geometry.edges,
    })
}

impl CustomOp3 for Node {
    fn name(&self) -> &'static str {
        match self.norm {
            Some(_) => "convolution-bias-norm-relu-pool",
            None => "convolution-bias-relu-pool",
        }
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
        let geometry = &self.convolution.geometry;
        // Packed once for all samples of the batch, outside the parallel loop.
        let packed = geometry.pack(weight);
        let to = self.out_length();
        let samples = input_layout.dims().first().copied().unwrap_or(0);
        let mut out = vec![0.0; samples * to];
        let records: Vec<Option<Kept>> = input
            .par_chunks_exact(geometry.inputs())
            .zip(out.par_chunks_exact_mut(to.max(1)))
            .map(|(sample, out)| {
                let record = self.forward(sample, &packed, vectors, out);
                // Without a gradient the grid goes back to the buffers at once.
                self.tracked.then_some(record)
            })
            .collect();
        // A node belongs to one place of one graph. Run
        // twice, its records would be those of another input.
        if self.tracked
            && self
                .records
                .set(records.into_iter().flatten().collect())
                .is_err()
        {
            bail!("a node of the graph was run twice");
        }
        let [depth, height, width] = self.out_edges();
        let shape = Shape::from((samples, geometry.outputs, depth, height, width));
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
        // Shape and records must be of the same batch, or samples would be mixed up.
        let Some(records) = self.records.get() else {
            bail!("a gradient was requested, but nothing was tracked")
        };
        if Some(records.len()) != input.dims().first().copied() {
            return Err(wrong_storage());
        }
        // The gradient of a view may arrive strided, while the kernels read rows.
        let gradient = gradient.contiguous()?;
        let numbers = [result, &gradient, vectors].map(Numbers::from_tensor);
        let [result, gradient, of_vectors] = &numbers;
        let (result, gradient, of_vectors) =
            (result.slice()?, gradient.slice()?, of_vectors.slice()?);
        let to = self.out_length();
        let of_one = |i: usize, input: &[f32], weights: &Weights, room: Option<&mut [f32]>| {
            let record: &Kept = &records[i];
            let sample = Sample {
                input,
                result: of_sample(result, i, to),
                gradient: of_sample(gradient, i, to),
                codes: &record.codes,
                occupied: record.occupied.as_ref(),
            };
            self.backward(record.normed.as_ref(), of_vectors, sample, weights, room)
        };
        self.convolution.gradients(input, weight, vectors, of_one)
    }
}
