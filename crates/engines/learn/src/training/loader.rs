//! Batches: samples are read, turned, scaled and written into one buffer while the batch before is
//! being worked on.

use crate::augmentation::CubeRotation;
use crate::scaling::{ChannelScaling, read_checked};
use crate::{Result, SampleSource};
use candle_core::{Device, Tensor};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// A sample and the number of its rotation, 0 for none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Item {
    pub sample: usize,
    pub turn: usize,
}

/// Turns samples into tensors.
pub(super) struct Loader<'a> {
    pub source: &'a dyn SampleSource,
    pub scaling: &'a ChannelScaling,
    /// Places of the channels in the source.
    pub channels: &'a [usize],
    pub device: &'a Device,
}

impl Loader<'_> {
    /// Calls `work` with the number of each batch and its tensor, (sample, channel, z, y, x), in
    /// order. Returns whether it went through all of them: `work` may break off.
    pub fn each(
        &self,
        batches: &[&[Item]],
        mut work: impl FnMut(usize, Tensor) -> Result<ControlFlow<()>> + Send,
    ) -> Result<bool> {
        // The first batch has nothing to overlap with.
        let mut loaded = self.read(batches, 0)?;
        for number in 0..batches.len() {
            let batch = self.tensor(batches[number], loaded)?;
            // `work` first: it runs on this thread, and
            // reading is taken by an idle one if there is any.
            let (flow, next) =
                rayon::join(|| work(number, batch), || self.read(batches, number + 1));
            if flow?.is_break() {
                // Before `next?`: an error in a batch that nobody wants must not spoil the end.
                return Ok(false);
            }
            loaded = next?;
        }
        Ok(true)
    }

    /// The numbers of a batch; none behind the last.
    fn read(&self, batches: &[&[Item]], number: usize) -> Result<Vec<f32>> {
        // Behind the last batch there is nothing to read, and an empty answer is not used.
        let items = batches.get(number).copied().unwrap_or_default();
        let of_sample = self.channels.len() * self.source.size().pow(3);
        // All 24 once for a batch: they are small, and `sparse` picks by number.
        let turns = CubeRotation::all();
        let mut numbers = vec![0.0; items.len() * of_sample];
        // Each sample writes to its own slice; zeros stay wherever a sparse grid has nothing.
        numbers
            .par_chunks_mut(of_sample.max(1))
            .zip(items)
            .try_for_each(|(dense, item)| self.write(*item, &turns, dense))?;
        Ok(numbers)
    }

    fn write(&self, item: Item, turns: &[CubeRotation], dense: &mut [f32]) -> Result<()> {
        let mut grid = read_checked(self.source, item.sample)?;
        // Turned while sparse: fewer numbers move, and scaling then writes the dense grid once.
        if item.turn > 0 {
            grid = turns[item.turn].sparse(&grid);
        }
        self.scaling.write_dense(grid, self.channels, dense)
    }

    fn tensor(&self, items: &[Item], numbers: Vec<f32>) -> Result<Tensor> {
        let (channels, size) = (self.channels.len(), self.source.size());
        let shape = (items.len(), channels, size, size, size);
        Ok(Tensor::from_vec(numbers, shape, self.device)?)
    }
}
