//! Convolution, bias, and ReLU and pooling if wanted, of one sample.

use super::BlockParameters;
use crate::error::refuse;
use candle_core::Tensor;
use protomer_convolution::buffers::Buffer;
use protomer_convolution::forward::{self, Finish, Forward};
use protomer_convolution::padded::{Occupied, Padded};
use protomer_convolution::{Geometry, Level};

/// Operations that follow convolution and bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Finishing {
    /// No operation.
    Plain,
    /// ReLU.
    Relu,
    /// ReLU and the maximum of every 2 x 2 x 2 window.
    Pool,
}

/// A convolution of grids of one shape.
#[derive(Debug)]
pub(super) struct Convolution {
    pub(super) geometry: Geometry,
    pub(super) finishing: Finishing,
    pub(super) level: Level,
    /// Whether the input is data, perhaps mostly zeros, and not the output of another layer.
    pub(super) from_data: bool,
}

impl Convolution {
    /// A convolution for these arguments.
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
            from_data: !input.track_op(),
        })
    }

    pub(super) fn out_edges(&self) -> [usize; 3] {
        match self.finishing {
            Finishing::Pool => self.geometry.edges.map(|edge| edge / 2),
            Finishing::Plain | Finishing::Relu => self.geometry.edges,
        }
    }

    /// The forward pass of one sample with what follows the convolution. Returns the corners that
    /// pooling chose, and the voxels of the sample that hold anything, if they are few.
    pub(super) fn finished_sample(
        &self,
        sample: &[f32],
        packed: &[f32],
        bias: &[f32],
        out: &mut [f32],
    ) -> (Vec<u8>, Option<Occupied>) {
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
        (codes, occupied)
    }

    /// The forward pass of one sample with packed weights. Returns the voxels of the sample that
    /// hold anything, if they are few.
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
        Forward {
            geometry,
            input: &input,
            weights: packed,
            bias: Some(bias),
            finish,
            scratch: &mut scratch,
        }
        .run_on(self.level);
        input.occupied
    }
}
