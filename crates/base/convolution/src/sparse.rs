//! Gradients of weights and input where most gradients of the outputs are zero. Behind a maximum
//! over windows at most one in eight is not, and the ReLU cuts off more.
//!
//! The gradients that are not zero are listed for each output. Each gives k² runs of k C numbers,
//! which lie next to each other in a channel-last grid:
//!
//! ∂w\[o, run\] += g x\[p + run\] and ∂x\[p + run\] += g w\[o, run\].

use crate::forward::DEAD;
use crate::geometry::{Geometry, LANES};
use crate::lanes::{Lanes, Level, Work};
use crate::padded::channel_last_length;
use std::array;

/// One gradient that is not zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Entry {
    /// Voxel of the padded grid at which the taps of the output begin.
    pub voxel: u32,
    /// The gradient.
    pub value: f32,
}

/// The gradients of a sample that are not zero.
#[derive(Debug, Default)]
pub struct Entries {
    list: Vec<Entry>,
    /// Index in the list at which each row of each output begins, and the end of the last row.
    starts: Vec<usize>,
    rows: usize,
}

impl Entries {
    /// Lists the entries of the gradient of the pooled outputs, (O, D/2, H/2, W/2), with the
    /// corners that pooling chose.
    ///
    /// `masks`, if known, say row by row which outputs see anything of the input. The others do not
    /// change the weights and are left out.
    pub fn pooled(
        geometry: &Geometry,
        gradient: &[f32],
        codes: &[u8],
        masks: Option<&[u128]>,
    ) -> Self {
        let [depth, height, width] = geometry.edges.map(|edge| edge / 2);
        let [_, padded_height, padded_width] = geometry.padded_edges();
        // Offsets of the eight corners of a window: 4 z + 2 y + x, as in the codes.
        let corners: [u32; 8] =
            array::from_fn(|i| ((i / 4 * padded_height + i / 2 % 2) * padded_width + i % 2) as u32);
        let mut entries = Lister::new(geometry, depth * height, gradient.len());
        let rows = gradient.chunks_exact(width).zip(codes.chunks_exact(width));
        for (i, (gradient, codes)) in rows.enumerate() {
            entries.begin_row();
            // Rows of pooled outputs: channel, plane, row; windows begin at even places.
            let (z, y) = (2 * (i % (depth * height) / height), 2 * (i % height));
            let below = masks.map(|masks| rows_below(geometry, masks, z, y));
            // No output of these rows sees anything: their gradients change no weight.
            if below == Some([0; 4]) {
                continue;
            }
            let first = ((z * padded_height + y) * padded_width) as u32;
            for (x, (value, code)) in gradient.iter().zip(codes).enumerate() {
                if below.is_some_and(|below| !sees(below, x, *code)) {
                    continue;
                }
                let voxel = first + 2 * x as u32 + corners[usize::from(code & 7)];
                // `&`, not `&&`: both are computed, and no branch is mispredicted.
                entries.push_if((*code != DEAD) & (*value != 0.0), voxel, *value);
            }
        }
        entries.finish()
    }

    /// Lists the entries of the gradient of all outputs, (O, D, H, W).
    pub fn unpooled(geometry: &Geometry, gradient: &[f32]) -> Self {
        let [depth, height, width] = geometry.edges;
        let [_, padded_height, padded_width] = geometry.padded_edges();
        let mut entries = Lister::new(geometry, depth * height, gradient.len());
        for (i, gradient) in gradient.chunks_exact(width).enumerate() {
            entries.begin_row();
            let (z, y) = (i % (depth * height) / height, i % height);
            let first = ((z * padded_height + y) * padded_width) as u32;
            for (x, value) in gradient.iter().enumerate() {
                entries.push_if(*value != 0.0, first + x as u32, *value);
            }
        }
        entries.finish()
    }

    /// Writes the entries into the gradient of all outputs, (O, D, H, W), which holds zeros.
    pub fn write_dense(&self, geometry: &Geometry, gradient: &mut [f32]) {
        let [_, height, width] = geometry.edges;
        let [_, padded_height, padded_width] = geometry.padded_edges();
        for (output, gradient) in gradient.chunks_exact_mut(geometry.voxels()).enumerate() {
            for entry in self.of_output(output) {
                let voxel = entry.voxel as usize;
                // From the padded voxel of the first tap to
                // the output: both count from the same corner.
                let (z, y) = (
                    voxel / padded_width / padded_height,
                    voxel / padded_width % padded_height,
                );
                gradient[(z * height + y) * width + voxel % padded_width] = entry.value;
            }
        }
    }

    /// Number of entries.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Entries of an output.
    #[inline(always)]
    pub fn of_output(&self, output: usize) -> &[Entry] {
        self.of_rows(output * self.rows, (output + 1) * self.rows)
    }

    #[inline(always)]
    fn of_rows(&self, first: usize, end: usize) -> &[Entry] {
        match (self.starts.get(first), self.starts.get(end)) {
            (Some(first), Some(end)) => self.list.get(*first..*end).unwrap_or_default(),
            // A row that was never begun has no entries.
            _ => &[],
        }
    }
}

/// Masks of the outputs that see anything of the input, for the four rows of outputs below a row of
/// windows.
#[inline(always)]
fn rows_below(geometry: &Geometry, masks: &[u128], z: usize, y: usize) -> [u128; 4] {
    array::from_fn(|i| {
        let row = (z + i / 2) * geometry.edges[1] + y + i % 2;
        // Without a mask, everything counts as seen.
        masks.get(row).copied().unwrap_or(u128::MAX)
    })
}

/// Whether the chosen corner of window `x` sees anything.
#[inline(always)]
fn sees(below: [u128; 4], x: usize, code: u8) -> bool {
    let row = below[usize::from((code / 2) & 3)];
    row & (1 << (2 * x + usize::from(code & 1))) != 0
}

/// Makes a list of entries row by row.
struct Lister {
    entries: Entries,
    count: usize,
}

impl Lister {
    /// A lister for at most `most` entries in `rows` rows of each output.
    fn new(geometry: &Geometry, rows: usize, most: usize) -> Self {
        Self {
            entries: Entries {
                // One more than can count: the last entry that does not count is written, too.
                list: vec![Entry::default(); most + 1],
                starts: Vec::with_capacity(geometry.outputs * rows + 1),
                rows,
            },
            count: 0,
        }
    }

    #[inline(always)]
    fn begin_row(&mut self) {
        self.entries.starts.push(self.count);
    }

    /// Writes an entry in any case and keeps it if it counts: there is no branch to mispredict.
    #[inline(always)]
    fn push_if(&mut self, counts: bool, voxel: u32, value: f32) {
        self.entries.list[self.count] = Entry { voxel, value };
        self.count += usize::from(counts);
    }

    fn finish(mut self) -> Entries {
        self.entries.starts.push(self.count);
        self.entries.list.truncate(self.count);
        self.entries
    }
}

/// Numbers of a run of k C, rounded up to whole vectors.
pub fn run_length(geometry: &Geometry) -> usize {
    (geometry.kernel * geometry.channels).next_multiple_of(LANES)
}

/// Numbers of the weights of one output in runs: k² of them.
fn weights_per_output(geometry: &Geometry) -> usize {
    geometry.tap_rows() * run_length(geometry)
}

/// Numbers of all weights in runs.
pub fn weights_length(geometry: &Geometry) -> usize {
    geometry.outputs * weights_per_output(geometry)
}

/// The weights (O, C, taps) in runs: (O, k², k C and zeros).
pub fn pack(geometry: &Geometry, weights: &[f32]) -> Vec<f32> {
    let mut packed = vec![0.0; weights_length(geometry)];
    each_weight(geometry, |plain, run| packed[run] = weights[plain]);
    packed
}

/// Undoes [`pack`], adding to `weights`.
pub fn add_unpacked(geometry: &Geometry, packed: &[f32], weights: &mut [f32]) {
    each_weight(geometry, |plain, run| weights[plain] += packed[run]);
}

fn each_weight(geometry: &Geometry, mut pair: impl FnMut(usize, usize)) {
    let (taps, kernel, channels) = (geometry.taps(), geometry.kernel, geometry.channels);
    for output in 0..geometry.outputs {
        for channel in 0..channels {
            for tap in 0..taps {
                // Tap row of the weights: k taps along the width lie together, channel by channel.
                let run = (output * kernel * kernel + tap / kernel) * run_length(geometry);
                pair(
                    (output * channels + channel) * taps + tap,
                    run + tap % kernel * channels + channel,
                );
            }
        }
    }
}

/// The gradient of the weights of one sample, which overwrites `weights`.
#[derive(Debug)]
pub struct SparseWeights<'a> {
    /// The shape.
    pub geometry: &'a Geometry,
    /// The input, channel last.
    pub input: &'a [f32],
    /// The gradients.
    pub entries: &'a Entries,
    /// The gradient of the weights in the order of [`pack`].
    pub weights: &'a mut [f32],
}

/// Adds the gradient of the input of one sample.
#[derive(Debug)]
pub struct SparseInput<'a> {
    /// The shape.
    pub geometry: &'a Geometry,
    /// The gradient of the input, channel last.
    pub input: &'a mut [f32],
    /// The gradients of the outputs.
    pub entries: &'a Entries,
    /// The weights in the order of [`pack`].
    pub weights: &'a [f32],
}

/// Whether all buffers have the lengths that the kernels count on.
fn fits(geometry: &Geometry, input: usize, entries: &Entries, weights: usize) -> bool {
    let [depth, height, width] = geometry.edges;
    let [_, padded_height, padded_width] = geometry.padded_edges();
    // The voxel of the last output; larger ones would lead runs out of the grid.
    let last = ((depth - 1) * padded_height + height - 1) * padded_width + width - 1;
    input == channel_last_length(geometry)
        && weights == weights_length(geometry)
        && entries
            .list
            .iter()
            .all(|entry| entry.voxel as usize <= last)
}

impl SparseWeights<'_> {
    /// Runs on the instructions of `level`.
    ///
    /// # Panics
    /// If the buffers do not fit the geometry.
    pub fn run_on(self, level: Level) {
        level.run(self);
    }
}

impl Work for SparseWeights<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::int_plus_one, reason = "the macro's smallest step is 1")]
    unsafe fn run<S: Lanes>(self) {
        let Self {
            geometry,
            input,
            entries,
            weights,
        } = self;
        assert!(
            fits(geometry, input.len(), entries, weights.len()),
            "buffers do not fit a convolution of {geometry:?}"
        );
        let vectors = run_length(geometry) / S::WIDTH;
        let kernel = geometry.kernel;
        for (output, weights) in weights
            .chunks_exact_mut(weights_per_output(geometry))
            .enumerate()
        {
            let list = entries.of_output(output);
            // Rows of taps from `row` on and vectors from `vector` on, as many as the registers
            // hold.
            macro_rules! sweep {
                ($rows:literal: $($vectors:literal)*) => {
                    for row in (0..kernel * kernel).step_by($rows) {
                        let mut vector = 0;
                        $(while vector + $vectors <= vectors {
                            // SAFETY: an entry's voxel is at most that of the last output, checked
                            // above, so its runs begin inside the padded grid, and the slack behind
                            // the grid covers what whole vectors run over; $rows divides k², and
                            // the weights hold k² runs of `vectors` vectors.
                            unsafe {
                                gather::<S, $rows, $vectors>(
                                    geometry, input, list, row, vector, weights,
                                );
                            }
                            vector += $vectors;
                        })*
                    }
                };
            }
            // As many sums as there are registers, less those for the value and a load.
            match (S::MANY, kernel, vectors) {
                (true, 3, 1..=3) => sweep!(9: 3 2 1),
                (true, 3, _) => sweep!(3: 8 6 3 2 1),
                (true, 5, _) => sweep!(5: 4 3 2 1),
                (true, _, _) => sweep!(1: 8 4 2 1),
                (false, 3, _) => sweep!(3: 4 3 2 1),
                (false, 5, _) => sweep!(5: 2 1),
                (false, _, _) => sweep!(1: 8 4 2 1),
            }
        }
    }
}

/// Sums R rows of taps times V vectors over the entries of an output.
///
/// # Safety
/// The processor has the instructions of `S`; reads and writes stay inside, as argued where it is
/// called.
#[inline(always)]
unsafe fn gather<S: Lanes, const R: usize, const V: usize>(
    geometry: &Geometry,
    input: &[f32],
    list: &[Entry],
    row: usize,
    vector: usize,
    weights: &mut [f32],
) {
    let mut offsets = [0; R];
    for (i, offset) in offsets.iter_mut().enumerate() {
        *offset = geometry.tap_row_offset(row + i) * geometry.channels + vector * S::WIDTH;
    }
    // SAFETY: the caller's promise.
    unsafe {
        // Sums stay in registers over all entries; weights are written once at the end.
        let mut sums = [[S::zero(); V]; R];
        for entry in list {
            let value = S::splat(&raw const entry.value);
            let from = input.as_ptr().add(entry.voxel as usize * geometry.channels);
            for (sums, offset) in sums.iter_mut().zip(offsets) {
                for (v, sum) in sums.iter_mut().enumerate() {
                    *sum = S::multiply_add(value, S::load(from.add(offset + v * S::WIDTH)), *sum);
                }
            }
        }
        for (i, sums) in sums.iter().enumerate() {
            for (v, sum) in sums.iter().enumerate() {
                let to = (row + i) * run_length(geometry) + (vector + v) * S::WIDTH;
                S::store(weights.as_mut_ptr().add(to), *sum);
            }
        }
    }
}

impl SparseInput<'_> {
    /// Runs on the instructions of `level`.
    ///
    /// # Panics
    /// If the buffers do not fit the geometry.
    pub fn run_on(self, level: Level) {
        level.run(self);
    }
}

impl Work for SparseInput<'_> {
    type Output = ();

    #[inline(always)]
    unsafe fn run<S: Lanes>(self) {
        let Self {
            geometry,
            input,
            entries,
            weights,
        } = self;
        assert!(
            fits(geometry, input.len(), entries, weights.len()),
            "buffers do not fit a convolution of {geometry:?}"
        );
        // 25 rows at most, for a kernel of edge five.
        let mut offsets = [0; 25];
        for (row, offset) in offsets.iter_mut().enumerate().take(geometry.tap_rows()) {
            *offset = geometry.tap_row_offset(row) * geometry.channels;
        }
        let offsets = &offsets[..geometry.tap_rows()];
        let (length, of_output) = (run_length(geometry), weights_per_output(geometry));
        // A row of windows at a time, so that the part of the input it reaches stays in the cache.
        for row in 0..entries.rows {
            for (output, weights) in weights.chunks_exact(of_output).enumerate() {
                let place = output * entries.rows + row;
                for entry in entries.of_rows(place, place + 1) {
                    let first = entry.voxel as usize * geometry.channels;
                    // SAFETY: as for the weights: runs begin inside the padded grid, and the slack
                    // covers the rest; past its k C weights a run adds the zeros it was packed
                    // with.
                    unsafe { spread::<S>(entry, weights, length, offsets, &mut input[first..]) };
                }
            }
        }
    }
}

/// Adds a gradient times the weights to all that it reaches: a run of `length` weights from each of
/// the offsets on.
///
/// # Safety
/// The processor has the instructions of `S`; `weights` holds as many runs as there are offsets,
/// and `to` a run from the largest offset on.
#[inline(always)]
unsafe fn spread<S: Lanes>(
    entry: &Entry,
    weights: &[f32],
    length: usize,
    offsets: &[usize],
    to: &mut [f32],
) {
    // SAFETY: the caller's promise.
    unsafe {
        let value = S::splat(&raw const entry.value);
        // Runs of weights and of the input have the same order, so vectors match.
        for (i, offset) in offsets.iter().enumerate() {
            let to = to.as_mut_ptr().add(*offset);
            let from = weights.as_ptr().add(i * length);
            for first in (0..length).step_by(S::WIDTH) {
                let old = S::load(to.add(first));
                let sum = S::multiply_add(value, S::load(from.add(first)), old);
                S::store(to.add(first), sum);
            }
        }
    }
}
