//! Group normalisation, ReLU and pooling if wanted, as one node of the tensor library's graph.

use super::convolution::{is_alive, wrong_storage};
use super::{contiguous, with_slice};
use crate::convolution::Level;
use crate::convolution::forward::{DEAD, positive};
use crate::convolution::lanes::{Lanes, Work};
use crate::operations::portable::NORM_EPSILON;
use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor, bail};
use rayon::prelude::*;
use std::sync::OnceLock;

/// The node: (B, O, D, H, W), weight (O) and bias (O) to (B, O, D', H', W'). One instance serves one call.
///
/// With x̂ = (x - mean) / √(variance + ε) over the N numbers of a group, y = weight x̂ + bias, and u = weight ∂L/∂y:
/// ∂L/∂x = (u - (Σ u + x̂ Σ u x̂) / N) / √(variance + ε).
#[derive(Debug)]
pub struct Norm {
    level: Level,
    groups: usize,
    pool: bool,
    channels: usize,
    edges: [usize; 3],
    tracked: bool,
    kept: OnceLock<Kept>,
}

/// What the backward pass needs.
#[derive(Debug)]
struct Kept {
    /// Mean and 1 / √(variance + ε) of every group of every sample.
    moments: Vec<(f32, f32)>,
    /// The corners that pooling chose.
    codes: Vec<u8>,
}

impl Norm {
    /// The node applied.
    ///
    /// # Errors
    /// [`crate::LearnError`] for shapes that do not fit.
    pub fn apply(
        level: Level,
        groups: usize,
        pool: bool,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
    ) -> crate::Result<Tensor> {
        let (_, channels, depth, height, width) = input.dims5()?;
        if groups == 0 || channels % groups != 0 || weight.dims() != [channels] || bias.dims() != [channels] {
            return Err(crate::LearnError::Settings(format!(
                "{channels} channels in {groups} groups, {:?} weights and {:?} biases of the normalisation",
                weight.dims(),
                bias.dims()
            )));
        }
        let tracked = input.track_op() || weight.track_op() || bias.track_op();
        let edges = [depth, height, width];
        let node = Self { level, groups, pool, channels, edges, tracked, kept: OnceLock::new() };
        Ok(input.contiguous()?.apply_op3(&weight.contiguous()?, &bias.contiguous()?, node)?)
    }

    fn out_edges(&self) -> [usize; 3] {
        if self.pool { self.edges.map(|edge| edge / 2) } else { self.edges }
    }

    fn voxels(&self) -> usize {
        self.edges.iter().product()
    }

    fn out_voxels(&self) -> usize {
        self.out_edges().iter().product()
    }

    /// Calls `visit(window, corners)` for every window of a channel, `corners` the places of its eight voxels.
    fn windows(&self, mut visit: impl FnMut(usize, [usize; 8])) {
        let [depth, height, width] = self.out_edges();
        let [_, full_height, full_width] = self.edges;
        for row in 0..depth * height {
            let first = (2 * (row / height) * full_height + 2 * (row % height)) * full_width;
            let corners: [usize; 8] =
                std::array::from_fn(|i| first + (i / 4 * full_height + i / 2 % 2) * full_width + i % 2);
            for x in 0..width {
                visit(row * width + x, corners.map(|corner| corner + 2 * x));
            }
        }
    }
}

/// The forward pass of one group of one sample; gives its mean and 1 / √(variance + ε).
struct Group<'a> {
    node: &'a Norm,
    input: &'a [f32],
    weights: &'a [f32],
    biases: &'a [f32],
    out: &'a mut [f32],
    codes: &'a mut [u8],
}

impl Work for Group<'_> {
    type Output = (f32, f32);

    #[inline(always)]
    unsafe fn run<S: Lanes>(self) -> (f32, f32) {
        let Self { node, input, weights, biases, out, codes } = self;
        let (voxels, out_voxels) = (node.voxels(), node.out_voxels());
        let (mean, inverse) = moments(input);
        let rooms = out.chunks_exact_mut(out_voxels).zip(codes.chunks_exact_mut(out_voxels));
        let mut rows = Rows::new(node.edges[2]);
        for (((weight, bias), channel), (out, codes)) in
            weights.iter().zip(biases).zip(input.chunks_exact(voxels)).zip(rooms)
        {
            let scale = weight * inverse;
            let shift = bias - scale * mean;
            if node.pool {
                pool_channel(node, &mut rows, channel, (scale, shift), out, codes);
            } else {
                for (to, from) in out.iter_mut().zip(channel) {
                    *to = positive(scale * from + shift);
                }
            }
        }
        (mean, inverse)
    }
}

/// A row of maxima over (z, y), and which row had each.
struct Rows {
    best: Vec<f32>,
    code: Vec<u32>,
}

impl Rows {
    fn new(width: usize) -> Self {
        Self { best: vec![0.0; width], code: vec![0; width] }
    }
}

/// ReLU(scale x + shift) and the maximum of every window of a channel, first down the rows, then along them.
#[inline(always)]
fn pool_channel(
    node: &Norm,
    rows: &mut Rows,
    channel: &[f32],
    (scale, shift): (f32, f32),
    out: &mut [f32],
    codes: &mut [u8],
) {
    let [_, full_height, full_width] = node.edges;
    let [_, height, width] = node.out_edges();
    for (i, (out, codes)) in out.chunks_exact_mut(width).zip(codes.chunks_exact_mut(width)).enumerate() {
        rows.best.fill(f32::NEG_INFINITY);
        for corner in 0..4u32 {
            let (z, y) = (2 * (i / height) + corner as usize / 2, 2 * (i % height) + corner as usize % 2);
            let row = channel.chunks_exact(full_width).nth(z * full_height + y).unwrap_or_default();
            for ((best, code), x) in rows.best.iter_mut().zip(&mut rows.code).zip(row) {
                let value = scale * x + shift;
                let better = (value > *best) | value.is_nan();
                *best = if better { value } else { *best };
                *code = if better { 2 * corner } else { *code };
            }
        }
        let pairs = rows.best.chunks_exact(2).zip(rows.code.chunks_exact(2));
        for ((out, chosen), (best, code)) in out.iter_mut().zip(codes).zip(pairs) {
            let ([left, right], [left_code, right_code]) = ([best[0], best[1]], [code[0], code[1] + 1]);
            // The first of equals wins, and equals may lie in different rows.
            let better = (right > left) | ((right == left) & (right_code < left_code)) | right.is_nan();
            let value = if better { right } else { left };
            *out = positive(value);
            *chosen = if value <= 0.0 { DEAD } else { (if better { right_code } else { left_code }) as u8 };
        }
    }
}

/// Mean and 1 / √(variance + ε).
#[inline(always)]
fn moments(group: &[f32]) -> (f32, f32) {
    let count = group.len().max(1) as f64;
    let mean = super::sum_of(group, |value| value) / count;
    let centre = mean as f32;
    let squares = super::sum_of(group, |value| (value - centre) * (value - centre));
    (centre, (1.0 / (squares / count + NORM_EPSILON).sqrt()) as f32)
}

impl CustomOp3 for Norm {
    fn name(&self) -> &'static str {
        "group-norm-relu-pool"
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
        let (weight, bias) = (contiguous(weight, weight_layout)?, contiguous(bias, bias_layout)?);
        let (voxels, out_voxels) = (self.voxels(), self.out_voxels());
        if voxels == 0 || out_voxels == 0 {
            return Err(wrong_storage());
        }
        let members = self.channels / self.groups;
        let (from, to) = (members * voxels, members * out_voxels);
        let count = input.len() / from;
        let mut out = vec![0.0; count * to];
        let mut codes = vec![0; count * to];
        let moments = out
            .par_chunks_exact_mut(to)
            .zip(codes.par_chunks_exact_mut(to))
            .zip(input.par_chunks_exact(from))
            .enumerate()
            .map(|(i, ((out, codes), group))| {
                let own = i % self.groups * members..(i % self.groups + 1) * members;
                self.level.run(Group {
                    node: self,
                    input: group,
                    weights: weight.get(own.clone()).unwrap_or_default(),
                    biases: bias.get(own).unwrap_or_default(),
                    out,
                    codes,
                })
            })
            .collect();
        if !self.pool {
            codes.clear();
        }
        if self.tracked && self.kept.set(Kept { moments, codes }).is_err() {
            bail!("a node of the graph was run twice");
        }
        let samples = input_layout.dims().first().copied().unwrap_or(0);
        let [depth, height, width] = self.out_edges();
        Ok((CpuStorage::F32(out), Shape::from((samples, self.channels, depth, height, width))))
    }

    fn bwd(
        &self,
        input: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        result: &Tensor,
        gradient: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let Some(kept) = self.kept.get() else { bail!("a gradient was asked for, but nothing was tracked") };
        let (voxels, out_voxels) = (self.voxels(), self.out_voxels());
        let members = self.channels / self.groups;
        let (from, to) = (members * voxels, members * out_voxels);
        let weights = with_slice(weight, |weight| Ok(weight.to_vec()))?;
        let mut input_gradient = vec![0.0; input.elem_count()];
        let sums = with_slice(input, |input| {
            with_slice(result, |result| {
                with_slice(&gradient.contiguous()?, |gradient| {
                    let each = input_gradient.par_chunks_exact_mut(from).enumerate().map(|(i, spread)| {
                        let part = Part {
                            input: input.get(i * from..(i + 1) * from).unwrap_or_default(),
                            result: result.get(i * to..(i + 1) * to).unwrap_or_default(),
                            gradient: gradient.get(i * to..(i + 1) * to).unwrap_or_default(),
                            codes: kept.codes.get(i * to..(i + 1) * to).unwrap_or_default(),
                            moments: kept.moments.get(i).copied().unwrap_or_default(),
                        };
                        let first = i % self.groups * members;
                        self.backward(part, weights.get(first..first + members).unwrap_or_default(), spread)
                    });
                    Ok(each.collect::<Vec<_>>())
                })
            })
        })?;
        let mut parameters = [vec![0.0f64; self.channels], vec![0.0f64; self.channels]];
        for (i, sums) in sums.into_iter().enumerate() {
            let first = i % self.groups * members;
            for (total, sums) in parameters.iter_mut().zip(sums) {
                total.iter_mut().skip(first).zip(sums).for_each(|(total, value)| *total += value);
            }
        }
        let device = input.device();
        let [weight_gradient, bias_gradient] =
            parameters.map(|total| total.into_iter().map(|value| value as f32).collect::<Vec<_>>());
        Ok((
            Some(Tensor::from_vec(input_gradient, input.shape(), device)?),
            Some(Tensor::from_vec(weight_gradient, weight.shape(), device)?),
            Some(Tensor::from_vec(bias_gradient, bias.shape(), device)?),
        ))
    }
}

/// One group of one sample.
struct Part<'a> {
    input: &'a [f32],
    result: &'a [f32],
    gradient: &'a [f32],
    codes: &'a [u8],
    moments: (f32, f32),
}

impl Norm {
    /// Overwrites `spread`, which holds zeros, with the gradient of the input of a group; returns the gradients of
    /// weight and bias of its channels.
    fn backward(&self, part: Part<'_>, weights: &[f32], spread: &mut [f32]) -> [Vec<f64>; 2] {
        let (voxels, out_voxels) = (self.voxels(), self.out_voxels());
        let (mean, inverse) = part.moments;
        let mut gradients = [Vec::with_capacity(weights.len()), Vec::with_capacity(weights.len())];
        let (mut plain, mut along) = (0.0, 0.0);
        for (i, weight) in weights.iter().enumerate() {
            let spread = spread.get_mut(i * voxels..(i + 1) * voxels).unwrap_or_default();
            let input = part.input.get(i * voxels..(i + 1) * voxels).unwrap_or_default();
            let out = i * out_voxels..(i + 1) * out_voxels;
            let gradient = part.gradient.get(out.clone()).unwrap_or_default();
            let (mut of_weight, mut of_bias) = (0.0f64, 0.0f64);
            let mut take = |place: usize, value: f32| {
                if let (Some(x), Some(to)) = (input.get(place), spread.get_mut(place)) {
                    of_weight += f64::from(value * (x - mean) * inverse);
                    of_bias += f64::from(value);
                    *to = value * weight;
                }
            };
            if self.pool {
                let codes = part.codes.get(out).unwrap_or_default();
                self.windows(|window, corners| {
                    if let (Some(code), Some(value)) = (codes.get(window), gradient.get(window))
                        && is_alive(*code)
                        && let Some(corner) = corners.get(usize::from(*code))
                    {
                        take(*corner, *value);
                    }
                });
            } else {
                let result = part.result.get(out).unwrap_or_default();
                for (place, (value, result)) in gradient.iter().zip(result).enumerate() {
                    take(place, if *result <= 0.0 { 0.0 } else { *value });
                }
            }
            plain += f64::from(*weight) * of_bias;
            along += f64::from(*weight) * of_weight;
            gradients[0].push(of_weight);
            gradients[1].push(of_bias);
        }
        let count = spread.len().max(1) as f64;
        let (plain, along) = ((plain / count) as f32, (along / count) as f32);
        self.level.run(Correction { spread, input: part.input, plain, along, mean, inverse });
        gradients
    }
}

/// What mean and variance take from the gradient of the input.
struct Correction<'a> {
    spread: &'a mut [f32],
    input: &'a [f32],
    plain: f32,
    along: f32,
    mean: f32,
    inverse: f32,
}

impl Work for Correction<'_> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Lanes>(self) {
        let Self { spread, input, plain, along, mean, inverse } = self;
        for (to, x) in spread.iter_mut().zip(input) {
            *to = inverse * (*to - plain - (x - mean) * inverse * along);
        }
    }
}
