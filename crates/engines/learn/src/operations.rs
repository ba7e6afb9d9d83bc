//! The operations of the network on grids, (sample, channel, depth, height, width), on any device.
//!
//! They are composed of the tensor library's own operations. That is the route on devices other
//! than the processor, and in the tests the twin of the fused route of [`crate::block`].
//!
//! Pooling picks the first of equal values, through an index and a gather: the tensor library's
//! reductions would give the gradient to every one of equal values.

use crate::Result;
use crate::error::refuse;
use crate::numbers::{contiguous, sum_in_lanes};
use candle_core::{CpuStorage, CustomOp1, DType, Layout, Shape, Tensor};

/// Constant ε that is added to a variance before its root is taken.
pub(crate) const NORM_EPSILON: f64 = 1e-5;

/// Cross-correlation with zero padding that keeps the shape:
///
/// y\[b, o, p\] = bias\[o\] + Σ over c and taps t of weight\[o, c, t\] x\[b, c, p + t - radius\].
///
/// `input` is (B, C, D, H, W), `weight` (O, C, k, k, k) with k odd, `bias` (O). The patches are
/// laid out as one matrix, k³ C rows, and multiplied by the weights.
///
/// ```
/// use candle_core::{Device, Tensor};
/// use protomer_learn::operations::convolution3d;
/// let ones = |shape: &[usize]| Tensor::ones(shape, candle_core::DType::F32, &Device::Cpu);
/// let bias = Tensor::new(&[0.5_f32], &Device::Cpu)?;
/// let sums = convolution3d(&ones(&[1, 1, 3, 3, 3])?, &ones(&[1, 1, 3, 3, 3])?, &bias)?;
/// let sums: Vec<f32> = sums.flatten_all()?.to_vec1()?;
/// assert_eq!((sums[13], sums[0]), (27.5, 8.5), "a corner sees eight voxels");
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) for an even kernel,
/// [`LearnError::Tensor`](crate::LearnError::Tensor) for shapes that do not fit.
pub fn convolution3d(input: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let (samples, channels, depth, height, width) = input.dims5()?;
    let (outputs, _, kernel, _, _) = weight.dims5()?;
    if kernel % 2 == 0 {
        return refuse(format!(
            "a kernel of edge {kernel}: it must be odd, take 1, 3 or 5"
        ));
    }
    let patches = patches(input, kernel)?;
    let matrix = weight
        .permute((0, 2, 3, 4, 1))?
        .reshape((outputs, kernel.pow(3) * channels))?;
    let product = matrix
        .matmul(&patches)?
        .broadcast_add(&bias.reshape((outputs, 1))?)?;
    Ok(product
        .reshape((outputs, samples, depth, height, width))?
        .transpose(0, 1)?
        .contiguous()?)
}

/// Values that each tap of the kernel sees, tap after tap in the order (z, y, x): a matrix (k³ C, B
/// D H W).
fn patches(input: &Tensor, kernel: usize) -> Result<Tensor> {
    let (samples, channels, depth, height, width) = input.dims5()?;
    let (radius, positions) = (kernel / 2, samples * depth * height * width);
    let mut padded = input.transpose(0, 1)?;
    for axis in 2..5 {
        padded = padded.pad_with_zeros(axis, radius, radius)?;
    }
    let mut rows = Vec::with_capacity(kernel.pow(3));
    for tap in 0..kernel.pow(3) {
        let shifted = padded
            .narrow(2, tap / (kernel * kernel), depth)?
            .narrow(3, tap / kernel % kernel, height)?
            .narrow(4, tap % kernel, width)?;
        rows.push(shifted.reshape((channels, positions))?);
    }
    Ok(Tensor::cat(&rows, 0)?)
}

/// The eight corners of every 2 x 2 x 2 window, (8, B, C, D/2, H/2, W/2), in the order (z, y, x). A
/// last odd plane, row or column belongs to no window.
fn windows(input: &Tensor) -> Result<Tensor> {
    let (samples, channels, depth, height, width) = input.dims5()?;
    let (d, h, w) = (depth / 2, height / 2, width / 2);
    let even = input
        .narrow(2, 0, 2 * d)?
        .narrow(3, 0, 2 * h)?
        .narrow(4, 0, 2 * w)?;
    let split = even
        .contiguous()?
        .reshape(vec![samples * channels, d, 2, h, 2, w, 2])?;
    let corners = split.permute(vec![2, 4, 6, 0, 1, 3, 5])?.contiguous()?;
    Ok(corners.reshape(vec![8, samples, channels, d, h, w])?)
}

/// The largest number of each column of an (n, m) matrix, (m); the first of equals.
fn first_maximum(columns: &Tensor) -> Result<Tensor> {
    let columns = columns.contiguous()?;
    let place = columns.detach().argmax_keepdim(0)?;
    Ok(columns.gather(&place, 0)?.squeeze(0)?)
}

/// The maximum of every 2 x 2 x 2 window: (B, C, D, H, W) to (B, C, D/2, H/2, W/2), rounded down.
///
/// ```
/// use candle_core::{Device, Tensor};
/// use protomer_learn::operations::max_pool3d;
/// let grid = Tensor::arange(0_f32, 8.0, &Device::Cpu)?.reshape((1, 1, 2, 2, 2))?;
/// assert_eq!(max_pool3d(&grid)?.flatten_all()?.to_vec1::<f32>()?, [7.0]);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Tensor`](crate::LearnError::Tensor) for an input of another rank.
pub fn max_pool3d(input: &Tensor) -> Result<Tensor> {
    let corners = windows(input)?;
    let shape = corners.dims().get(1..).unwrap_or_default().to_vec();
    Ok(first_maximum(&corners.flatten_from(1)?)?.reshape(shape)?)
}

/// Group normalisation (Wu and He, ECCV 2018): over each group of channels of a sample,
///
/// y = weight (x - mean) / √(variance + ε) + bias, with weight and bias per channel and ε =
/// 10⁻⁵.
///
/// ```
/// use candle_core::{Device, Tensor};
/// use protomer_learn::operations::group_norm;
/// let grid = Tensor::new(&[1_f32, 3.0], &Device::Cpu)?.reshape((1, 1, 1, 1, 2))?;
/// let [weight, bias] = [2_f32, 10.0].map(|number| Tensor::new(&[number], &Device::Cpu));
/// let normal = group_norm(&grid, 1, &weight?, &bias?)?.flatten_all()?.to_vec1::<f32>()?;
/// assert!((normal[0] - 8.0).abs() < 1e-4 && (normal[1] - 12.0).abs() < 1e-4);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if the channels do not divide into the
/// groups.
pub fn group_norm(input: &Tensor, groups: usize, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let shape = input.dims().to_vec();
    let (samples, channels, ..) = input.dims5()?;
    if groups == 0 || channels % groups != 0 {
        return refuse(format!(
            "{channels} channels do not divide into {groups} groups"
        ));
    }
    let grouped = input.contiguous()?.reshape((samples, groups, ()))?;
    let centred = grouped.broadcast_sub(&row_means(&grouped)?.unsqueeze(2)?)?;
    let variance = row_means(&centred.sqr()?)?.unsqueeze(2)?;
    let deviation = (variance + NORM_EPSILON)?.sqrt()?;
    let normal = centred.broadcast_div(&deviation)?.reshape(shape)?;
    let per_channel = (1, channels, 1, 1, 1);
    let scaled = normal.broadcast_mul(&weight.reshape(per_channel)?)?;
    Ok(scaled.broadcast_add(&bias.reshape(per_channel)?)?)
}

/// The mean over all voxels: (B, C, D, H, W) to (B, C).
///
/// ```
/// use candle_core::{Device, Tensor};
/// use protomer_learn::operations::{global_average_pool, global_maximum_pool};
/// let grid = Tensor::arange(0_f32, 8.0, &Device::Cpu)?.reshape((1, 1, 2, 2, 2))?;
/// assert_eq!(global_average_pool(&grid)?.to_vec2::<f32>()?, [[3.5]]);
/// assert_eq!(global_maximum_pool(&grid)?.to_vec2::<f32>()?, [[7.0]]);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Tensor`](crate::LearnError::Tensor) for an input of another rank.
pub fn global_average_pool(input: &Tensor) -> Result<Tensor> {
    let (samples, channels, ..) = input.dims5()?;
    row_means(&input.contiguous()?.reshape((samples, channels, ()))?)
}

/// The mean over the last of three axes of a contiguous tensor.
fn row_means(rows: &Tensor) -> Result<Tensor> {
    let (_, _, length) = rows.dims3()?;
    let sums = if rows.device().is_cpu() && rows.dtype() == DType::F32 {
        rows.apply_op1(RowSums)?
    } else {
        rows.sum(2)?
    };
    Ok((sums * (1.0 / length as f64))?)
}

/// Sums over the last of three axes on the processor. Those of the tensor library depend on the
/// instructions it was compiled for, and add up rounding errors over long rows.
struct RowSums;

impl CustomOp1 for RowSums {
    fn name(&self) -> &'static str {
        "row-sums"
    }

    fn cpu_fwd(
        &self,
        storage: &CpuStorage,
        layout: &Layout,
    ) -> candle_core::Result<(CpuStorage, Shape)> {
        let (samples, channels, length) = layout.shape().dims3()?;
        let mut sums = Vec::with_capacity(samples * channels);
        for row in contiguous(storage, layout)?.chunks_exact(length.max(1)) {
            sums.push(sum_in_lanes(row, |value| value));
        }
        Ok((CpuStorage::F32(sums), Shape::from((samples, channels))))
    }

    fn bwd(
        &self,
        rows: &Tensor,
        _sums: &Tensor,
        gradient: &Tensor,
    ) -> candle_core::Result<Option<Tensor>> {
        Ok(Some(gradient.unsqueeze(2)?.broadcast_as(rows.shape())?))
    }
}

/// The maximum over all voxels: (B, C, D, H, W) to (B, C).
///
/// # Errors
/// [`LearnError::Tensor`](crate::LearnError::Tensor) for an input of another rank.
pub fn global_maximum_pool(input: &Tensor) -> Result<Tensor> {
    let (samples, channels, ..) = input.dims5()?;
    let columns = input
        .contiguous()?
        .reshape((samples * channels, ()))?
        .transpose(0, 1)?;
    Ok(first_maximum(&columns)?.reshape((samples, channels))?)
}
