//! Convolution, bias, group normalisation, ReLU and pooling if wanted, as one node of the tensor
//! library's graph.

use super::convolution::{Convolution, Finishing, Sample, is_alive, wrong_storage};
use super::{BlockParameters, BlockSettings, contiguous, with_slice};
use crate::convolution::Level;
use crate::convolution::buffers::Buffer;
use crate::convolution::forward::{DEAD, Finish, positive};
use crate::convolution::lanes::{Lanes, Work};
use crate::convolution::padded::Occupied;
use crate::operations::portable::NORM_EPSILON;
use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor, bail};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Group normalisation, ReLU and pooling of one sample.
///
/// With x̂ = (x - mean) / √(variance + ε) over the N numbers of a group, y = weight x̂ + bias, and
/// u = weight ∂L/∂y: ∂L/∂x = (u - (Σ u + x̂ Σ u x̂) / N) / √(variance + ε).
#[derive(Debug)]
struct Norm {
    level: Level,
    groups: usize,
    pool: bool,
    channels: usize,
    edges: [usize; 3],
}

impl Norm {
    fn out_edges(&self) -> [usize; 3] {
        if self.pool {
            self.edges.map(|edge| edge / 2)
        } else {
            self.edges
        }
    }

    fn voxels(&self) -> usize {
        self.edges.iter().product()
    }

    fn out_voxels(&self) -> usize {
        self.out_edges().iter().product()
    }

    /// Calls `visit(window, corners)` for every window of a channel, `corners` the places of its
    /// eight voxels.
    fn windows(&self, mut visit: impl FnMut(usize, [usize; 8])) {
        let [depth, height, width] = self.out_edges();
        let [_, full_height, full_width] = self.edges;
        for row in 0..depth * height {
            let first = (2 * (row / height) * full_height + 2 * (row % height)) * full_width;
            let corners: [usize; 8] = std::array::from_fn(|i| {
                first + (i / 4 * full_height + i / 2 % 2) * full_width + i % 2
            });
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
        let Self {
            node,
            input,
            weights,
            biases,
            out,
            codes,
        } = self;
        let (voxels, out_voxels) = (node.voxels(), node.out_voxels());
        let (mean, inverse) = moments(input);
        let mut codes = codes.chunks_exact_mut(out_voxels.max(1));
        let rooms = out.chunks_exact_mut(out_voxels.max(1));
        let mut rows = Rows::new(node.edges[2]);
        for (((weight, bias), channel), out) in weights
            .iter()
            .zip(biases)
            .zip(input.chunks_exact(voxels))
            .zip(rooms)
        {
            let scale = weight * inverse;
            let shift = bias - scale * mean;
            let codes = codes.next().unwrap_or_default();
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
        Self {
            best: vec![0.0; width],
            code: vec![0; width],
        }
    }
}

/// ReLU(scale x + shift) and the maximum of every window of a channel, first down the rows, then
/// along them.
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
    for (i, (out, codes)) in out
        .chunks_exact_mut(width)
        .zip(codes.chunks_exact_mut(width))
        .enumerate()
    {
        rows.best.fill(f32::NEG_INFINITY);
        for corner in 0..4u32 {
            let (z, y) = (
                2 * (i / height) + corner as usize / 2,
                2 * (i % height) + corner as usize % 2,
            );
            let row = channel
                .chunks_exact(full_width)
                .nth(z * full_height + y)
                .unwrap_or_default();
            for ((best, code), x) in rows.best.iter_mut().zip(&mut rows.code).zip(row) {
                let value = scale * x + shift;
                let better = (value > *best) | value.is_nan();
                *best = if better { value } else { *best };
                *code = if better { 2 * corner } else { *code };
            }
        }
        let pairs = rows.best.chunks_exact(2).zip(rows.code.chunks_exact(2));
        for ((out, chosen), (best, code)) in out.iter_mut().zip(codes).zip(pairs) {
            let ([left, right], [left_code, right_code]) =
                ([best[0], best[1]], [code[0], code[1] + 1]);
            // The first of equals wins, and equals may lie in different rows.
            let better =
                (right > left) | ((right == left) & (right_code < left_code)) | right.is_nan();
            let value = if better { right } else { left };
            *out = positive(value);
            *chosen = if value <= 0.0 {
                DEAD
            } else {
                (if better { right_code } else { left_code }) as u8
            };
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
    (
        centre,
        (1.0 / (squares / count + NORM_EPSILON).sqrt()) as f32,
    )
}

/// Convolution and normalisation as one node: (B, C, D, H, W), weight (O, C, k, k, k), and the bias
/// of the convolution, the weight and the bias of the normalisation one after the other, (3 O), to
/// (B, O, D', H', W').
#[derive(Debug)]
pub struct NormedConvolution {
    convolution: Convolution,
    norm: Norm,
    tracked: bool,
    kept: OnceLock<Vec<Kept>>,
}

/// What the backward pass needs of a sample.
#[derive(Debug)]
struct Kept {
    /// What the convolution gave.
    grid: Buffer,
    /// Mean and 1 / √(variance + ε) of every group.
    moments: Vec<(f32, f32)>,
    /// The corners that pooling chose.
    codes: Vec<u8>,
    /// Which voxels of the input hold anything, if few do.
    occupied: Option<Occupied>,
}

impl NormedConvolution {
    /// The node applied.
    ///
    /// # Errors
    /// [`crate::LearnError`] for shapes that do not fit.
    pub fn apply(
        level: Level,
        input: &Tensor,
        parameters: &BlockParameters,
        settings: &BlockSettings,
    ) -> crate::Result<Tensor> {
        let BlockParameters { weight, bias, norm } = parameters;
        let (Some(groups), Some((scale, shift))) = (settings.groups, norm) else {
            return Err(crate::LearnError::Settings(
                "a normalisation without groups or parameters".into(),
            ));
        };
        let convolution = Convolution::new(level, Finishing::Plain, input, weight, bias)?;
        let (channels, edges) = (convolution.geometry().outputs, convolution.geometry().edges);
        if groups == 0
            || channels % groups != 0
            || scale.dims() != [channels]
            || shift.dims() != [channels]
        {
            return Err(crate::LearnError::Settings(format!(
                "{channels} channels in {groups} groups, {:?} weights and {:?} biases of the normalisation",
                scale.dims(),
                shift.dims()
            )));
        }
        let vectors = Tensor::cat(&[bias, scale, shift], 0)?;
        let tracked = input.track_op() || weight.track_op() || vectors.track_op();
        let norm = Norm {
            level,
            groups,
            pool: settings.pool,
            channels,
            edges,
        };
        let node = Self {
            convolution,
            norm,
            tracked,
            kept: OnceLock::new(),
        };
        Ok(input
            .contiguous()?
            .apply_op3(&weight.contiguous()?, &vectors, node)?)
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
        let (weight, vectors) = (
            contiguous(weight, weight_layout)?,
            contiguous(vectors, vectors_layout)?,
        );
        let (norm, geometry) = (&self.norm, self.convolution.geometry());
        let vector = |i: usize| {
            vectors
                .get(i * norm.channels..(i + 1) * norm.channels)
                .unwrap_or_default()
        };
        let packed = geometry.pack(weight);
        let to = norm.channels * norm.out_voxels();
        let samples = input_layout.dims().first().copied().unwrap_or(0);
        let mut out = vec![0.0; samples * to];
        let each = input
            .par_chunks_exact(geometry.channels * geometry.voxels())
            .zip(out.par_chunks_exact_mut(to.max(1)));
        let kept: Vec<_> = each
            .map(|(sample, out)| {
                let mut grid = Buffer::stale(norm.channels * norm.voxels());
                let occupied = self.convolution.forward_sample(
                    sample,
                    &packed,
                    vector(0),
                    Finish::Plain(&mut grid),
                );
                let mut codes = vec![0; if norm.pool { to } else { 0 }];
                let moments = norm.forward(&grid, vector(1), vector(2), out, &mut codes);
                self.tracked.then_some(Kept {
                    grid,
                    moments,
                    codes,
                    occupied,
                })
            })
            .collect();
        if self.tracked && self.kept.set(kept.into_iter().flatten().collect()).is_err() {
            bail!("a node of the graph was run twice");
        }
        let [depth, height, width] = norm.out_edges();
        Ok((
            CpuStorage::F32(out),
            Shape::from((samples, norm.channels, depth, height, width)),
        ))
    }

    fn bwd(
        &self,
        input: &Tensor,
        weight: &Tensor,
        vectors: &Tensor,
        result: &Tensor,
        gradient: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let Some(kept) = self.kept.get() else {
            bail!("a gradient was asked for, but nothing was tracked")
        };
        let norm = &self.norm;
        let to = norm.channels * norm.out_voxels();
        let all = with_slice(vectors, |vectors| Ok(vectors.to_vec()))?;
        let scale = all
            .get(norm.channels..2 * norm.channels)
            .unwrap_or_default();
        if Some(kept.len()) != input.dims().first().copied() {
            return Err(wrong_storage());
        }
        with_slice(result, |result| {
            with_slice(&gradient.contiguous()?, |gradient| {
                self.convolution.gradients(
                    input,
                    weight,
                    vectors,
                    |i, input, weights, input_gradient| {
                        let (mut spread, mut ends) = (
                            Buffer::zeros(norm.channels * norm.voxels()),
                            [Vec::new(), Vec::new()],
                        );
                        let mut occupied = None;
                        if let Some(kept) = kept.get(i) {
                            let out = i * to..(i + 1) * to;
                            let result = result.get(out.clone()).unwrap_or_default();
                            ends = norm.backward(
                                kept,
                                scale,
                                result,
                                gradient.get(out).unwrap_or_default(),
                                &mut spread,
                            );
                            occupied = kept.occupied.as_ref();
                        }
                        let sample = Sample {
                            input,
                            result: &[],
                            gradient: &spread,
                            codes: &[],
                            occupied,
                        };
                        let mut gradients =
                            self.convolution.backward(sample, weights, input_gradient);
                        gradients
                            .bias
                            .extend(ends.into_iter().flatten().map(|value| value as f32));
                        gradients
                    },
                )
            })
        })
    }
}

impl Norm {
    /// The forward pass of one sample; gives mean and 1 / √(variance + ε) of every group. `codes`
    /// is empty without pooling.
    fn forward(
        &self,
        grid: &[f32],
        weights: &[f32],
        biases: &[f32],
        out: &mut [f32],
        codes: &mut [u8],
    ) -> Vec<(f32, f32)> {
        let members = self.channels / self.groups;
        let (from, to) = (members * self.voxels(), members * self.out_voxels());
        let mut codes = codes.chunks_exact_mut(to.max(1));
        let groups = grid.chunks_exact(from).zip(out.chunks_exact_mut(to.max(1)));
        let parameters = weights
            .chunks_exact(members)
            .zip(biases.chunks_exact(members));
        groups
            .zip(parameters)
            .map(|((input, out), (weights, biases))| {
                let codes = codes.next().unwrap_or_default();
                self.level.run(Group {
                    node: self,
                    input,
                    weights,
                    biases,
                    out,
                    codes,
                })
            })
            .collect()
    }

    /// Overwrites `spread`, which holds zeros, with the gradient of the grid of a sample; returns
    /// the gradients of weights and biases.
    fn backward(
        &self,
        kept: &Kept,
        weights: &[f32],
        result: &[f32],
        gradient: &[f32],
        spread: &mut [f32],
    ) -> [Vec<f64>; 2] {
        let members = self.channels / self.groups;
        let (from, to) = (members * self.voxels(), members * self.out_voxels());
        let mut gradients = [
            Vec::with_capacity(self.channels),
            Vec::with_capacity(self.channels),
        ];
        for (i, (spread, weights)) in spread
            .chunks_exact_mut(from)
            .zip(weights.chunks_exact(members))
            .enumerate()
        {
            let (grid, out) = (i * from..(i + 1) * from, i * to..(i + 1) * to);
            let part = Part {
                input: kept.grid.get(grid).unwrap_or_default(),
                result: result.get(out.clone()).unwrap_or_default(),
                gradient: gradient.get(out.clone()).unwrap_or_default(),
                codes: kept.codes.get(out).unwrap_or_default(),
                moments: kept.moments.get(i).copied().unwrap_or_default(),
            };
            let found = self.backward_group(part, weights, spread);
            gradients
                .iter_mut()
                .zip(found)
                .for_each(|(all, found)| all.extend(found));
        }
        gradients
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
    /// Overwrites `spread`, which holds zeros, with the gradient of the input of a group; returns
    /// the gradients of weight and bias of its channels.
    fn backward_group(&self, part: Part<'_>, weights: &[f32], spread: &mut [f32]) -> [Vec<f64>; 2] {
        let (voxels, out_voxels) = (self.voxels(), self.out_voxels());
        let (mean, inverse) = part.moments;
        let mut gradients = [
            Vec::with_capacity(weights.len()),
            Vec::with_capacity(weights.len()),
        ];
        let (mut plain, mut along) = (0.0, 0.0);
        for (i, weight) in weights.iter().enumerate() {
            let spread = spread
                .get_mut(i * voxels..(i + 1) * voxels)
                .unwrap_or_default();
            let input = part
                .input
                .get(i * voxels..(i + 1) * voxels)
                .unwrap_or_default();
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
        self.level.run(Correction {
            spread,
            input: part.input,
            plain,
            along,
            mean,
            inverse,
        });
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
        let Self {
            spread,
            input,
            plain,
            along,
            mean,
            inverse,
        } = self;
        for (to, x) in spread.iter_mut().zip(input) {
            *to = inverse * (*to - plain - (x - mean) * inverse * along);
        }
    }
}
