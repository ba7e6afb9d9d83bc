//! Batches: samples are read, turned, scaled and spread into one buffer while the batch before is
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
    pub channels: &'a [usize],
    pub device: &'a Device,
}

impl Loader<'_> {
    /// The batch as (sample, channel, z, y, x). Memory is that of one batch: sparse samples are
    /// spread where they belong.
    pub fn read(&self, items: &[Item]) -> Result<Vec<f32>> {
        let stride = self.channels.len() * self.source.size().pow(3);
        let turns = CubeRotation::all();
        let mut buffer = vec![0.0; items.len() * stride];
        let read = |(dense, item): (&mut [f32], &Item)| {
            let mut grid = read_checked(self.source, item.sample)?;
            if let Some(turn) = turns.get(item.turn).filter(|_| item.turn > 0) {
                grid = turn.sparse(&grid);
            }
            self.scaling.write_dense(grid, self.channels, dense)
        };
        buffer
            .par_chunks_mut(stride.max(1))
            .zip(items)
            .try_for_each(read)?;
        Ok(buffer)
    }

    /// Calls `work` with each batch in order; whether it went through without a break.
    pub fn each(
        &self,
        batches: &[&[Item]],
        mut work: impl FnMut(usize, Tensor) -> Result<ControlFlow<()>> + Send,
    ) -> Result<bool> {
        let size = self.source.size();
        let load = |number: usize| {
            batches
                .get(number)
                .map(|items| self.read(items))
                .transpose()
        };
        let mut next = load(0)?;
        for (number, items) in batches.iter().enumerate() {
            let Some(values) = next.take() else { break };
            let batch = Tensor::from_vec(
                values,
                (items.len(), self.channels.len(), size, size, size),
                self.device,
            )?;
            let (done, loaded) = rayon::join(|| work(number, batch), || load(number + 1));
            if done?.is_break() {
                return Ok(false);
            }
            next = loaded?;
        }
        Ok(true)
    }
}
