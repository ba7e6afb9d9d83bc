//! The shape of a convolution and of the buffers around it.

use crate::{ConvolutionError, Result};

/// Channel counts of outputs are rounded up to this: the widest vector, and two of the narrower
/// ones.
pub const LANES: usize = 16;

/// A convolution of one sample, stride 1, zero padding that keeps the shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Geometry {
    /// Channels in.
    pub channels: usize,
    /// Channels out.
    pub outputs: usize,
    /// Edge of the kernel: 1, 3 or 5.
    pub kernel: usize,
    /// Depth, height and width of the grid.
    pub edges: [usize; 3],
}

impl Geometry {
    /// Checks that the kernel is one of those compiled, and nothing is empty.
    ///
    /// # Errors
    /// [`ConvolutionError`] says what is wrong.
    pub fn check(&self) -> Result<()> {
        if !matches!(self.kernel, 1 | 3 | 5) {
            return Err(ConvolutionError::Kernel(self.kernel));
        }
        if self.channels == 0 || self.outputs == 0 || self.voxels() == 0 {
            return Err(ConvolutionError::Empty(*self));
        }
        // Padded voxels are counted in u32.
        if u32::try_from(self.padded_voxels()).is_err() {
            return Err(ConvolutionError::TooLarge(self.edges));
        }
        Ok(())
    }

    /// Voxels that the padding adds on each side.
    pub fn radius(&self) -> usize {
        self.kernel / 2
    }

    /// Voxels of a channel.
    pub fn voxels(&self) -> usize {
        self.edges.iter().product()
    }

    /// Numbers of the input of a sample.
    pub fn inputs(&self) -> usize {
        self.channels * self.voxels()
    }

    /// Edges with the padding.
    pub fn padded_edges(&self) -> [usize; 3] {
        self.edges.map(|edge| edge + 2 * self.radius())
    }

    /// Voxels with the padding.
    pub fn padded_voxels(&self) -> usize {
        self.padded_edges().iter().product()
    }

    /// Rows of taps, k²: each is k taps along the width.
    pub fn tap_rows(&self) -> usize {
        self.kernel * self.kernel
    }

    /// Taps, k³.
    pub fn taps(&self) -> usize {
        self.kernel.pow(3)
    }

    /// Outputs rounded up to whole vectors.
    pub fn padded_outputs(&self) -> usize {
        self.outputs.next_multiple_of(LANES)
    }

    /// Numbers of the weights: O C k³.
    pub fn weights(&self) -> usize {
        self.outputs * self.channels * self.taps()
    }

    /// Numbers of the weights as [`Geometry::pack`] gives them.
    pub fn packed_weights(&self) -> usize {
        self.channels * self.taps() * self.padded_outputs()
    }

    /// Offset of tap row `row` of output voxel (0, 0, 0) in the padded grid, in voxels.
    pub fn tap_row_offset(&self, row: usize) -> usize {
        let [_, height, width] = self.padded_edges();
        (row / self.kernel * height + row % self.kernel) * width
    }

    /// The convolution whose forward pass is this one's gradient of the input.
    pub fn transposed(&self) -> Self {
        Self {
            channels: self.outputs,
            outputs: self.channels,
            ..*self
        }
    }

    /// The weights (O, C, taps) as (C, taps, padded O), zeros behind the last output.
    pub fn pack(&self, weights: &[f32]) -> Vec<f32> {
        // (O, C k³) to (C k³, O): outputs become the innermost index, where vectors lie.
        let (rows, stride) = (self.channels * self.taps(), self.padded_outputs());
        let mut packed = vec![0.0; rows * stride];
        for (output, row) in weights.chunks_exact(rows).enumerate().take(self.outputs) {
            for (i, value) in row.iter().enumerate() {
                packed[i * stride + output] = *value;
            }
        }
        packed
    }

    /// The weights for the transposed convolution, packed: (O, reversed taps, padded C).
    pub fn pack_transposed(&self, weights: &[f32]) -> Vec<f32> {
        let (taps, stride) = (self.taps(), self.transposed().padded_outputs());
        let mut packed = vec![0.0; self.outputs * taps * stride];
        for (i, kernel) in weights.chunks_exact(taps).enumerate() {
            let (output, channel) = (i / self.channels, i % self.channels);
            for (tap, value) in kernel.iter().enumerate() {
                // The kernel turned round: tap t becomes k³ -
                // 1 - t, outputs and channels change places.
                packed[(output * taps + taps - 1 - tap) * stride + channel] = *value;
            }
        }
        packed
    }

    /// Undoes [`Geometry::pack`], adding to `weights`.
    pub fn add_unpacked(&self, packed: &[f32], weights: &mut [f32]) {
        let (rows, stride) = (self.channels * self.taps(), self.padded_outputs());
        for (output, row) in weights
            .chunks_exact_mut(rows)
            .enumerate()
            .take(self.outputs)
        {
            for (i, value) in row.iter_mut().enumerate() {
                *value += packed[i * stride + output];
            }
        }
    }
}
