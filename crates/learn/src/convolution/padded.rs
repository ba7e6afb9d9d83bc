//! Grids with zeros around them.

use super::buffers::Buffer;
use super::geometry::{Geometry, LANES};

/// A sample with zeros around it, channel by channel: (C, D + 2r, H + 2r, W + 2r).
#[derive(Debug)]
pub struct Padded {
    /// The numbers.
    pub numbers: Buffer,
    /// For every row, which of its voxels hold anything in any channel: bit i stands for the voxels from i `grain` on.
    /// None if too few rows are empty for it to pay.
    pub occupied: Option<Vec<u64>>,
    /// Voxels per bit.
    pub grain: usize,
}

/// Above this share of numbers that are not zero, no occupation is noted.
const LARGEST_FILL: f64 = 0.25;

impl Padded {
    /// The sample (C, D, H, W) with zeros around it; `look_for_zeros`: note which voxels hold anything.
    pub fn new(geometry: &Geometry, sample: &[f32], look_for_zeros: bool) -> Self {
        let radius = geometry.radius();
        let [_, height, width] = geometry.edges;
        let [padded_depth, padded_height, padded_width] = geometry.padded_edges();
        let mut numbers = Buffer::stale(geometry.channels * geometry.padded_voxels());
        let mut rows = sample.chunks_exact(width);
        for (i, row) in numbers.chunks_exact_mut(padded_width).enumerate() {
            let (z, y) = (i / padded_height % padded_depth, i % padded_height);
            let inside = (radius..padded_depth - radius).contains(&z) && (radius..radius + height).contains(&y);
            let source = if inside { rows.next() } else { None };
            match source {
                Some(source) => {
                    row[..radius].fill(0.0);
                    row[radius..radius + width].copy_from_slice(source);
                    row[radius + width..].fill(0.0);
                }
                None => row.fill(0.0),
            }
        }
        let grain = padded_width.div_ceil(u64::BITS as usize);
        let mut padded = Self { numbers, occupied: None, grain };
        if look_for_zeros && fill(sample) < LARGEST_FILL {
            let rows = padded_depth * padded_height;
            let mut occupied = vec![0; rows];
            for (i, row) in padded.numbers.chunks_exact(padded_width).enumerate() {
                let mask = &mut occupied[i % rows];
                for (x, value) in row.iter().enumerate() {
                    *mask |= u64::from(*value != 0.0) << (x / grain);
                }
            }
            padded.occupied = Some(occupied);
        }
        padded
    }

    /// Whether any of `count` voxels of row `row` from `first` on may hold something.
    #[inline(always)]
    pub fn any(occupied: &[u64], grain: usize, row: usize, first: usize, count: usize) -> bool {
        let (low, high) = (first / grain, (first + count - 1) / grain);
        let upto_high = u64::MAX >> (u64::BITS as usize - 1 - high.min(u64::BITS as usize - 1));
        occupied.get(row).is_none_or(|mask| mask & upto_high & (u64::MAX << low) != 0)
    }
}

fn fill(sample: &[f32]) -> f64 {
    let filled: usize =
        sample.chunks(4096).map(|part| part.iter().map(|v| u32::from(*v != 0.0)).sum::<u32>() as usize).sum();
    filled as f64 / sample.len().max(1) as f64
}

/// Numbers behind the last voxel of a channel-last grid that whole vectors may run into.
pub fn slack(geometry: &Geometry) -> usize {
    LANES * (1 + geometry.kernel)
}

/// The sample (C, D, H, W) with zeros around it, voxel by voxel: (D + 2r, H + 2r, W + 2r, C), and [`slack`] behind.
pub fn channel_last(geometry: &Geometry, sample: &[f32]) -> Buffer {
    let mut numbers = Buffer::zeros(geometry.channels * geometry.padded_voxels() + slack(geometry));
    let (width, channels) = (geometry.edges[2], geometry.channels);
    let voxels = geometry.voxels();
    for row in 0..voxels / width {
        let to = first_of_row(geometry, row) * channels;
        for channel in 0..channels {
            let from = &sample[channel * voxels + row * width..][..width];
            for (to, from) in numbers[to + channel..].iter_mut().step_by(channels).zip(from) {
                *to = *from;
            }
        }
    }
    numbers
}

/// Undoes [`channel_last`]: writes the inner voxels to `sample`.
pub fn from_channel_last(geometry: &Geometry, numbers: &[f32], sample: &mut [f32]) {
    let (width, channels) = (geometry.edges[2], geometry.channels);
    let voxels = geometry.voxels();
    for row in 0..voxels / width {
        let from = first_of_row(geometry, row) * channels;
        for channel in 0..channels {
            let to = &mut sample[channel * voxels + row * width..][..width];
            for (to, from) in to.iter_mut().zip(numbers[from + channel..].iter().step_by(channels)) {
                *to = *from;
            }
        }
    }
}

/// The padded voxel where a row of the grid begins.
fn first_of_row(geometry: &Geometry, row: usize) -> usize {
    let [_, height, width] = geometry.padded_edges();
    let radius = geometry.radius();
    let (z, y) = (row / geometry.edges[1], row % geometry.edges[1]);
    ((z + radius) * height + y + radius) * width + radius
}
