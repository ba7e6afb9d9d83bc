//! Group normalisation, ReLU and pooling of one sample, forward and backward.
//!
//! With x̂ = (x - mean) / √(variance + ε) over the N numbers of a group, y = weight x̂ + bias, and
//! u = weight ∂L/∂y: ∂L/∂x = (u - (Σ u + x̂ Σ u x̂) / N) / √(variance + ε).

use super::gradients::{Sample, is_alive};
use crate::numbers::{of_sample, sum_of};
use crate::operations::NORM_EPSILON;
use protomer_convolution::Level;
use protomer_convolution::forward::{DEAD, positive};
use protomer_convolution::lanes::{Lanes, Work};
use std::array;

/// Group normalisation, ReLU, and pooling if wanted, of grids of one shape.
#[derive(Debug)]
pub(super) struct GroupNorm {
    pub(super) level: Level,
    pub(super) groups: usize,
    pub(super) pool: bool,
    pub(super) channels: usize,
    pub(super) edges: [usize; 3],
}

/// Mean and 1 / √(variance + ε) of a group.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moments {
    mean: f32,
    inverse: f32,
}

impl GroupNorm {
    pub(super) fn out_edges(&self) -> [usize; 3] {
        if self.pool {
            self.edges.map(|edge| edge / 2)
        } else {
            self.edges
        }
    }

    pub(super) fn voxels(&self) -> usize {
        self.edges.iter().product()
    }

    pub(super) fn out_voxels(&self) -> usize {
        self.out_edges().iter().product()
    }

    /// Channels of a group.
    fn members(&self) -> usize {
        self.channels / self.groups
    }

    /// The forward pass of one sample. `codes` is empty without pooling.
    pub(super) fn forward(
        &self,
        grid: &[f32],
        weights: &[f32],
        biases: &[f32],
        out: &mut [f32],
        codes: &mut [u8],
    ) -> Vec<Moments> {
        let (from, to) = (
            self.members() * self.voxels(),
            self.members() * self.out_voxels(),
        );
        let mut codes = codes.chunks_exact_mut(to.max(1));
        let mut moments = Vec::with_capacity(self.groups);
        for (group, out) in out.chunks_exact_mut(to.max(1)).enumerate() {
            moments.push(self.level.run(Group {
                norm: self,
                input: of_sample(grid, group, from),
                weights: of_sample(weights, group, self.members()),
                biases: of_sample(biases, group, self.members()),
                out,
                codes: codes.next().unwrap_or_default(),
            }));
        }
        moments
    }

    /// The backward pass of one sample: overwrites `grid_gradient`, which holds zeros. Returns the
    /// gradients of weights and biases.
    pub(super) fn backward(
        &self,
        grid: &[f32],
        moments: &[Moments],
        weights: &[f32],
        sample: &Sample<'_>,
        grid_gradient: &mut [f32],
    ) -> [Vec<f64>; 2] {
        let (from, to) = (
            self.members() * self.voxels(),
            self.members() * self.out_voxels(),
        );
        let mut gradients = [Vec::new(), Vec::new()];
        for (group, grid_gradient) in grid_gradient.chunks_exact_mut(from).enumerate() {
            let mut backward = GroupBackward {
                norm: self,
                input: of_sample(grid, group, from),
                weights: of_sample(weights, group, self.members()),
                result: of_sample(sample.result, group, to),
                gradient: of_sample(sample.gradient, group, to),
                codes: of_sample(sample.codes, group, to),
                moments: moments.get(group).copied().unwrap_or_default(),
                spread: grid_gradient,
            };
            backward.run(&mut gradients);
        }
        gradients
    }
}

/// The forward pass of one group of one sample.
struct Group<'a> {
    norm: &'a GroupNorm,
    input: &'a [f32],
    weights: &'a [f32],
    biases: &'a [f32],
    out: &'a mut [f32],
    codes: &'a mut [u8],
}

impl Work for Group<'_> {
    type Output = Moments;

    #[inline(always)]
    unsafe fn run<S: Lanes>(self) -> Moments {
        let (voxels, out_voxels) = (self.norm.voxels(), self.norm.out_voxels());
        // Moments run over all channels of the group; weight and bias belong to each channel.
        let moments = moments(self.input);
        let mut codes = self.codes.chunks_exact_mut(out_voxels.max(1));
        let mut rows = Rows::new(self.norm.edges[2]);
        let rooms = self.out.chunks_exact_mut(out_voxels.max(1));
        for ((i, channel), out) in self.input.chunks_exact(voxels).enumerate().zip(rooms) {
            // weight (x - mean) inverse + bias, folded to scale x +
            // shift: one multiplication and one addition for each voxel.
            let scale = self.weights[i] * moments.inverse;
            let shift = self.biases[i] - scale * moments.mean;
            if self.norm.pool {
                let codes = codes.next().unwrap_or_default();
                rows.pool_channel(self.norm, channel, (scale, shift), out, codes);
            } else {
                for (to, from) in out.iter_mut().zip(channel) {
                    *to = positive(scale * from + shift);
                }
            }
        }
        moments
    }
}

#[inline(always)]
fn moments(group: &[f32]) -> Moments {
    let count = group.len().max(1) as f64;
    // The mean first, then squared deviations: Σ x² - N mean² would cancel where the mean is large.
    let mean = (sum_of(group, |value| value) / count) as f32;
    let squares = sum_of(group, |value| (value - mean) * (value - mean));
    Moments {
        mean,
        inverse: (1.0 / (squares / count + NORM_EPSILON).sqrt()) as f32,
    }
}

/// A row of maxima over (z, y), and the row that each comes from.
struct Rows {
    best: Vec<f32>,
    code: Vec<u32>,
}

impl Rows {
    fn new(width: usize) -> Self {
        Self {
            best: vec![0.0; width],
            code: vec![0; width],
        }
    }

    /// ReLU(scale x + shift) and the maximum of every window of a channel, first down the rows,
    /// then along them.
    #[inline(always)]
    fn pool_channel(
        &mut self,
        norm: &GroupNorm,
        channel: &[f32],
        scale_and_shift: (f32, f32),
        out: &mut [f32],
        codes: &mut [u8],
    ) {
        let [_, full_height, full_width] = norm.edges;
        let [_, height, width] = norm.out_edges();
        let rooms = out
            .chunks_exact_mut(width)
            .zip(codes.chunks_exact_mut(width));
        for (i, (out, codes)) in rooms.enumerate() {
            // Reset for each row of windows. The code needs
            // no reset: the first value beats -∞, or is NaN.
            self.best.fill(f32::NEG_INFINITY);
            // The four rows of a window one after another: each pass runs along
            // memory and vectorises, where a loop over windows would gather.
            for corner in 0..4 {
                let (z, y) = (2 * (i / height) + corner / 2, 2 * (i % height) + corner % 2);
                let row = of_sample(channel, z * full_height + y, full_width);
                self.take(row, corner as u32, scale_and_shift);
            }
            self.finish(out, codes);
        }
    }

    /// Compares a row with the best values so far and keeps the better ones.
    #[inline(always)]
    fn take(&mut self, row: &[f32], corner: u32, (scale, shift): (f32, f32)) {
        for ((best, code), x) in self.best.iter_mut().zip(&mut self.code).zip(row) {
            // ReLU waits until the maximum is known: both
            // are monotone, so the order does not matter.
            let value = scale * x + shift;
            // NaN must win, or a diverged network would look sound behind
            // its pooling. `>` is false for NaN, so once kept it stays.
            let better = (value > *best) | value.is_nan();
            *best = if better { value } else { *best };
            // Corners count as 4 z + 2 y + x; here x is still open.
            *code = if better { 2 * corner } else { *code };
        }
    }

    /// The better of each pair of neighbours, and which of the eight corners it is.
    #[inline(always)]
    fn finish(&self, out: &mut [f32], codes: &mut [u8]) {
        let pairs = self.best.chunks_exact(2).zip(self.code.chunks_exact(2));
        for ((out, chosen), (best, code)) in out.iter_mut().zip(codes).zip(pairs) {
            let ([left, right], [left_code, right_code]) =
                ([best[0], best[1]], [code[0], code[1] + 1]);
            // The first of equals wins, and equals may lie in different rows.
            let better =
                (right > left) | ((right == left) & (right_code < left_code)) | right.is_nan();
            let value = if better { right } else { left };
            let code = if better { right_code } else { left_code };
            *out = positive(value);
            // Zero passes no gradient either, as without
            // pooling. NaN is not `<= 0` and stays alive.
            *chosen = if value <= 0.0 { DEAD } else { code as u8 };
        }
    }
}

/// The backward pass of one group of one sample.
struct GroupBackward<'a> {
    norm: &'a GroupNorm,
    input: &'a [f32],
    weights: &'a [f32],
    result: &'a [f32],
    gradient: &'a [f32],
    codes: &'a [u8],
    moments: Moments,
    /// The gradient of the input, zeros at first.
    spread: &'a mut [f32],
}

impl GroupBackward<'_> {
    /// Overwrites `spread` and appends the gradients of weight and bias of each channel.
    fn run(&mut self, gradients: &mut [Vec<f64>; 2]) {
        // Σ u and Σ u x̂ over the group.
        let (mut sum_u, mut sum_u_x) = (0.0, 0.0);
        for i in 0..self.weights.len() {
            let (of_weight, of_bias) = self.spread_channel(i);
            // weight times the gradient of the bias is Σ u of the channel,
            // times that of the weight Σ u x̂: no further pass over the voxels.
            sum_u += f64::from(self.weights[i]) * of_bias;
            sum_u_x += f64::from(self.weights[i]) * of_weight;
            gradients[0].push(of_weight);
            gradients[1].push(of_bias);
        }
        let count = self.spread.len().max(1) as f64;
        // Every x moves mean and variance and so every y: this
        // reaches also the voxels that got no gradient themselves.
        self.norm.level.run(Correction {
            spread: self.spread,
            input: self.input,
            moments: self.moments,
            mean_u: (sum_u / count) as f32,
            mean_u_x: (sum_u_x / count) as f32,
        });
    }

    /// Writes u = weight ∂L/∂y of a channel where it is not zero. Returns the gradients of its
    /// weight and bias, Σ ∂L/∂y x̂ and Σ ∂L/∂y.
    fn spread_channel(&mut self, i: usize) -> (f64, f64) {
        let (voxels, out_voxels) = (self.norm.voxels(), self.norm.out_voxels());
        let gradient = of_sample(self.gradient, i, out_voxels);
        let mut channel = Channel {
            input: of_sample(self.input, i, voxels),
            spread: &mut self.spread[i * voxels..(i + 1) * voxels],
            weight: self.weights[i],
            moments: self.moments,
            of_weight: 0.0,
            of_bias: 0.0,
        };
        // Behind pooling at most one voxel in eight gets anything; the others keep their zeros.
        if self.norm.pool {
            channel.take_pooled(self.norm, gradient, of_sample(self.codes, i, out_voxels));
        } else {
            let result = of_sample(self.result, i, out_voxels);
            for (voxel, (value, result)) in gradient.iter().zip(result).enumerate() {
                // ReLU is judged by the result, so no mask has to be kept from the forward pass.
                channel.take(voxel, if *result <= 0.0 { 0.0 } else { *value });
            }
        }
        (channel.of_weight, channel.of_bias)
    }
}

/// A channel in the backward pass.
struct Channel<'a> {
    input: &'a [f32],
    spread: &'a mut [f32],
    weight: f32,
    moments: Moments,
    of_weight: f64,
    of_bias: f64,
}

impl Channel<'_> {
    /// Takes ∂L/∂y of one voxel.
    #[inline(always)]
    fn take(&mut self, voxel: usize, value: f32) {
        let Moments { mean, inverse } = self.moments;
        if let (Some(x), Some(to)) = (self.input.get(voxel), self.spread.get_mut(voxel)) {
            self.of_weight += f64::from(value * (x - mean) * inverse);
            // f64: a channel may have tens of thousands of voxels.
            self.of_bias += f64::from(value);
            *to = value * self.weight;
        }
    }

    /// Takes the gradient of every window to the corner that pooling chose.
    #[inline(always)]
    fn take_pooled(&mut self, norm: &GroupNorm, gradient: &[f32], codes: &[u8]) {
        let [_, height, width] = norm.out_edges();
        let [_, full_height, full_width] = norm.edges;
        let corners: [usize; 8] =
            // Offsets of the corners 4 z + 2 y + x from the first voxel of a window.
            array::from_fn(|i| (i / 4 * full_height + i / 2 % 2) * full_width + i % 2);
        let width = width.max(1);
        let rows = gradient.chunks_exact(width).zip(codes.chunks_exact(width));
        for (row, (gradient, codes)) in rows.enumerate() {
            // `row` counts rows of windows, z height + y;
            // each begins two planes and two rows apart.
            let first = (2 * (row / height) * full_height + 2 * (row % height)) * full_width;
            for (x, (value, code)) in gradient.iter().zip(codes).enumerate() {
                if is_alive(*code) {
                    self.take(first + corners[usize::from(code & 7)] + 2 * x, *value);
                }
            }
        }
    }
}

/// Correction of the gradient of the input for mean and variance, which depend on the input.
struct Correction<'a> {
    spread: &'a mut [f32],
    input: &'a [f32],
    moments: Moments,
    mean_u: f32,
    mean_u_x: f32,
}

impl Work for Correction<'_> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Lanes>(self) {
        let Moments { mean, inverse } = self.moments;
        for (to, x) in self.spread.iter_mut().zip(self.input) {
            // In place: here `to` holds u.
            *to = inverse * (*to - self.mean_u - (x - mean) * inverse * self.mean_u_x);
        }
    }
}
