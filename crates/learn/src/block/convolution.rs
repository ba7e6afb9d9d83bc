//! Convolution, bias, and ReLU and pooling if wanted, as one node of the tensor library's graph.

use super::BlockParameters;
use crate::convolution::buffers::Buffer;
use crate::convolution::forward::{self, Finish, Forward};
use crate::convolution::padded::{Occupied, Padded};
use crate::convolution::{Geometry, Level};
use crate::error::refuse;
use candle_core::Tensor;
use rayon::prelude::*;
use std::sync::OnceLock;

/// What follows convolution and bias in the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Finishing {
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
pub(super) struct Convolution {
    pub(super) geometry: Geometry,
    pub(super) finishing: Finishing,
    pub(super) level: Level,
    /// Whether a gradient may be asked for.
    pub(super) tracked: bool,
    /// Whether the input is data, perhaps mostly zeros, and not the output of another layer.
    pub(super) from_data: bool,
    pub(super) kept: OnceLock<Vec<Kept>>,
}

/// What the backward pass needs of a sample, besides its input and its result.
#[derive(Debug)]
pub(super) struct Kept {
    /// The corners that pooling chose.
    pub codes: Vec<u8>,
    /// Which voxels of the input hold anything, if few do.
    pub occupied: Option<Occupied>,
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
        parameters: &BlockParameters,
    ) -> crate::Result<Self> {
        let BlockParameters { weight, bias, .. } = parameters;
        let (_, channels, depth, height, width) = input.dims5()?;
        let (outputs, weight_channels, kernel, _, _) = weight.dims5()?;
        let geometry = Geometry {
            channels,
            outputs,
            kernel,
            edges: [depth, height, width],
        };
        geometry.check()?;
        let fits = weight_channels == channels
            && weight.elem_count() == geometry.weights()
            && bias.dims() == [outputs];
        if !fits {
            return refuse(format!(
                "weights {:?} and biases {:?} for grids of {channels} channels",
                weight.dims(),
                bias.dims()
            ));
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

    /// Applies the node.
    ///
    /// # Errors
    /// [`crate::LearnError`] for shapes that do not fit.
    pub(super) fn apply(
        level: Level,
        finishing: Finishing,
        input: &Tensor,
        parameters: &BlockParameters,
    ) -> crate::Result<Tensor> {
        let node = Self::new(level, finishing, input, parameters)?;
        let (weight, bias) = (
            parameters.weight.contiguous()?,
            parameters.bias.contiguous()?,
        );
        Ok(input.contiguous()?.apply_op3(&weight, &bias, node)?)
    }

    pub(super) fn out_edges(&self) -> [usize; 3] {
        match self.finishing {
            Finishing::Pool => self.geometry.edges.map(|edge| edge / 2),
            Finishing::Plain | Finishing::Relu => self.geometry.edges,
        }
    }

    /// Numbers that one sample gives.
    pub(super) fn out_length(&self) -> usize {
        self.geometry.outputs * self.out_edges().iter().product::<usize>()
    }

    pub(super) fn forward(
        &self,
        input: &[f32],
        weights: &[f32],
        bias: &[f32],
    ) -> (Vec<f32>, Vec<Kept>) {
        let packed = self.geometry.pack(weights);
        let (from, to) = (self.geometry.inputs(), self.out_length());
        let mut out = vec![0.0; input.len() / from * to];
        let kept = input
            .par_chunks_exact(from)
            .zip(out.par_chunks_exact_mut(to.max(1)))
            .map(|(sample, out)| self.finished_sample(sample, &packed, bias, out))
            .collect();
        (out, kept)
    }

    /// The forward pass of one sample with what follows the convolution.
    fn finished_sample(
        &self,
        sample: &[f32],
        packed: &[f32],
        bias: &[f32],
        out: &mut [f32],
    ) -> Kept {
        let mut codes = Vec::new();
        let finish = match self.finishing {
            Finishing::Plain => Finish::Plain(out),
            Finishing::Relu => Finish::Relu(out),
            Finishing::Pool => {
                codes.resize(out.len(), 0);
                Finish::Pool(out, &mut codes)
            }
        };
        let occupied = self.forward_sample(sample, packed, bias, finish);
        Kept { codes, occupied }
    }

    /// The forward pass of one sample with packed weights. Returns which of its voxels hold
    /// anything, if few do.
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
        self.level.run(Forward {
            geometry,
            input: &input,
            weights: packed,
            bias: Some(bias),
            finish,
            scratch: &mut scratch,
        });
        input.occupied
    }
}
