//! Grids with zeros around them.

use crate::buffers::Buffer;
use crate::geometry::{Geometry, LANES};

/// A sample with zeros around it, channel by channel: (C, D + 2r, H + 2r, W + 2r).
#[derive(Debug)]
pub struct Padded {
    /// The numbers.
    pub numbers: Buffer,
    /// Voxels that hold anything; `None` if there are so many that recording them does not pay.
    pub occupied: Option<Occupied>,
}

/// Voxels of a padded grid that hold anything in any channel.
#[derive(Debug, Clone)]
pub struct Occupied {
    /// Bit mask of every row; bit i stands for the voxels from i `grain` on.
    rows: Vec<u128>,
    /// Voxels per bit.
    grain: usize,
}

impl Occupied {
    fn from_numbers(geometry: &Geometry, numbers: &[f32]) -> Self {
        let [depth, height, width] = geometry.padded_edges();
        // One bit stands for so many voxels that a row fits into 128.
        let grain = width.div_ceil(u128::BITS as usize);
        let mut rows = vec![0; depth * height];
        // Rows of all channels; masks of the same row are united.
        for (i, row) in numbers.chunks_exact(width).enumerate() {
            let mask = &mut rows[i % (depth * height)];
            for (block, part) in row.chunks(LANES * grain).enumerate() {
                *mask |= u128::from(bits(part, grain)) << (block * LANES);
            }
        }
        Self { rows, grain }
    }

    /// The voxels of a row that may hold something, ascending.
    #[inline(always)]
    pub fn of_row(&self, row: usize, width: usize) -> impl Iterator<Item = usize> {
        let (mut bits, grain) = (self.mask(row), self.grain);
        let bits = std::iter::from_fn(move || {
            (bits != 0).then(|| {
                let first = bits.trailing_zeros() as usize;
                // Clears the lowest bit.
                bits &= bits - 1;
                first
            })
        });
        bits.flat_map(move |bit| bit * grain..((bit + 1) * grain).min(width))
    }

    /// Upper limit of the number of voxels of a row that hold something.
    #[inline(always)]
    pub fn count(&self, row: usize) -> usize {
        self.mask(row).count_ones() as usize * self.grain
    }

    /// Whether any of `count` voxels of a row from `first` on may hold something.
    #[inline(always)]
    pub fn any(&self, row: usize, first: usize, count: usize) -> bool {
        let (low, high) = (first / self.grain, (first + count - 1) / self.grain);
        // Bits up to `high`; a shift by 128 would overflow, hence the bound.
        let upto_high = u128::MAX >> (u128::BITS as usize - 1 - high.min(u128::BITS as usize - 1));
        self.mask(row) & upto_high & (u128::MAX << low) != 0
    }

    #[inline(always)]
    fn mask(&self, row: usize) -> u128 {
        self.rows.get(row).copied().unwrap_or(u128::MAX)
    }

    /// Masks of the outputs that see anything, for every row of outputs: bit x stands for voxel x.
    /// `None` for rows longer than a mask.
    pub fn seen(&self, geometry: &Geometry) -> Option<Vec<u128>> {
        if self.grain > 1 {
            return None;
        }
        let [depth, height, _] = geometry.edges;
        let (padded_height, kernel) = (geometry.padded_edges()[1], geometry.kernel);
        let mut masks = Vec::with_capacity(depth * height);
        for row in 0..depth * height {
            // The first tap row of this row of outputs in the padded grid.
            let first = row / height * padded_height + row % height;
            let mut below = 0;
            for tap in 0..kernel * kernel {
                below |= self.mask(first + tap / kernel * padded_height + tap % kernel);
            }
            let mut sees = 0;
            // Output x sees columns x to x + k - 1: shifted masks, united.
            for k in 0..kernel {
                sees |= below >> k;
            }
            masks.push(sees);
        }
        Some(masks)
    }
}

/// Marks the groups of `grain` voxels that are not all zero: bit i stands for the voxels from i
/// `grain` on.
fn bits(part: &[f32], grain: usize) -> u32 {
    // Mostly there is nothing; the sign of a zero does not count.
    let mut any = 0;
    for value in part {
        // Shifting left drops the sign bit, so -0 counts as nothing.
        any |= value.to_bits() << 1;
    }
    if any == 0 {
        return 0;
    }
    let mut bits = 0;
    for (i, voxels) in part.chunks(grain).enumerate() {
        bits |= u32::from(voxels.iter().any(|value| *value != 0.0)) << i;
    }
    bits
}

/// Numbers counted at a time.
const PART: usize = 4096;
/// Largest fraction of nonzero numbers for which it pays to record them.
const LARGEST_FILL: f64 = 0.25;

impl Padded {
    /// The sample (C, D, H, W) with zeros around it. With `look_for_zeros`, it is noted which
    /// voxels hold anything.
    pub fn new(geometry: &Geometry, sample: &[f32], look_for_zeros: bool) -> Self {
        let radius = geometry.radius();
        let [_, height, width] = geometry.edges;
        let [padded_depth, padded_height, padded_width] = geometry.padded_edges();
        let mut numbers = Buffer::stale(geometry.channels * geometry.padded_voxels());
        let mut rows = sample.chunks_exact(width);
        for (i, row) in numbers.chunks_exact_mut(padded_width).enumerate() {
            let (z, y) = (i / padded_height % padded_depth, i % padded_height);
            let inside = (radius..padded_depth - radius).contains(&z)
                && (radius..radius + height).contains(&y);
            let source = if inside { rows.next() } else { None };
            match source {
                Some(source) => {
                    // Stale memory: every number is written here, so it need not be cleared first.
                    row[..radius].fill(0.0);
                    row[radius..radius + width].copy_from_slice(source);
                    row[radius + width..].fill(0.0);
                }
                None => row.fill(0.0),
            }
        }
        let occupied = (look_for_zeros && is_sparse(sample, LARGEST_FILL))
            .then(|| Occupied::from_numbers(geometry, &numbers));
        Self { numbers, occupied }
    }
}

/// Whether at most this share of the numbers is not zero.
fn is_sparse(sample: &[f32], share: f64) -> bool {
    let most = (share * sample.len() as f64) as usize;
    let mut filled = 0;
    sample.chunks(PART).all(|part| {
        // Ends with the first part that makes it too full.
        filled += count_nonzero(part);
        filled <= most
    })
}

/// Counts the numbers that are not zero.
pub fn count_nonzero(numbers: &[f32]) -> usize {
    let mut count = 0;
    // In u32 over short parts, which the compiler vectorises.
    for part in numbers.chunks(PART) {
        count += part
            .iter()
            .map(|value| u32::from(*value != 0.0))
            .sum::<u32>() as usize;
    }
    count
}

/// Numbers behind the last voxel of a channel-last grid that whole vectors may run into.
fn slack(geometry: &Geometry) -> usize {
    LANES * (1 + geometry.kernel)
}

/// Numbers of a channel-last grid with zeros around it, and the slack behind.
pub fn channel_last_length(geometry: &Geometry) -> usize {
    geometry.channels * geometry.padded_voxels() + slack(geometry)
}

/// The sample (C, D, H, W) with zeros around it, voxel by voxel: (D + 2r, H + 2r, W + 2r, C), and
/// slack behind, [`channel_last_length`] numbers. `occupied`, if known, says which voxels hold
/// anything.
pub fn channel_last(geometry: &Geometry, sample: &[f32], occupied: Option<&Occupied>) -> Buffer {
    let mut numbers = Buffer::zeros(channel_last_length(geometry));
    let (width, channels, voxels) = (geometry.edges[2], geometry.channels, geometry.voxels());
    for row in 0..voxels / width {
        if let Some(occupied) = occupied {
            copy_occupied(geometry, sample, row, occupied, &mut numbers);
            continue;
        }
        let to = first_of_row(geometry, row) * channels;
        for channel in 0..channels {
            let from = &sample[channel * voxels + row * width..][..width];
            let to = numbers[to + channel..].iter_mut().step_by(channels);
            for (to, from) in to.zip(from) {
                *to = *from;
            }
        }
    }
    numbers
}

/// Copies the voxels of a row that may hold something into a channel-last grid.
fn copy_occupied(
    geometry: &Geometry,
    sample: &[f32],
    row: usize,
    occupied: &Occupied,
    numbers: &mut [f32],
) {
    let (radius, width, channels) = (geometry.radius(), geometry.edges[2], geometry.channels);
    let padded_width = geometry.padded_edges()[2];
    // `first` is where the padded row begins; x counts from there.
    let first = first_of_row(geometry, row) - radius;
    for x in occupied.of_row(first / padded_width, padded_width) {
        if !(radius..radius + width).contains(&x) {
            continue;
        }
        for channel in 0..channels {
            let from = channel * geometry.voxels() + row * width + x - radius;
            numbers[(first + x) * channels + channel] = sample[from];
        }
    }
}

/// Undoes [`channel_last`]: writes the inner voxels to `sample`.
pub fn from_channel_last(geometry: &Geometry, numbers: &[f32], sample: &mut [f32]) {
    let (width, channels) = (geometry.edges[2], geometry.channels);
    let voxels = geometry.voxels();
    for row in 0..voxels / width {
        let from = first_of_row(geometry, row) * channels;
        for channel in 0..channels {
            let to = &mut sample[channel * voxels + row * width..][..width];
            let from = numbers[from + channel..].iter().step_by(channels);
            for (to, from) in to.iter_mut().zip(from) {
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
