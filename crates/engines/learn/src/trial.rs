//! Settings of a trial, drawn at random.

use crate::{BlockSettings, Result};
use protomer_kernel::random::{CounterRng, Purpose};

/// Numbers of blocks, as far as the grid can be halved.
const BLOCKS: [usize; 3] = [2, 3, 4];
/// Widths of the first block.
const WIDTHS: [usize; 4] = [4, 8, 16, 32];
/// Kernels of the first block: 3 twice as often as 5.
const KERNELS: [usize; 3] = [3, 3, 5];
/// Groups of the normalisation, 0 for none.
const GROUPS: [usize; 2] = [0, 4];
/// Smallest and largest learning rate.
const LEARNING_RATES: (f64, f64) = (3e-4, 1e-2);
/// Largest number of channels from which subsets are drawn, the first ones: the number of subsets
/// must not overflow.
const MOST_CHANNELS: usize = 16;

/// Settings that are drawn for a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialSettings {
    /// The blocks of the network.
    pub blocks: Vec<BlockSettings>,
    /// The learning rate after the warm-up.
    pub learning_rate: f64,
    /// A subset of the channels that is not empty, in their order.
    pub channels: Vec<String>,
}

impl TrialSettings {
    /// Draws the settings of a trial on grids of `size` voxels along each edge. They depend on seed
    /// and number only.
    ///
    /// There are 2 to 4 blocks, which double in width from 4, 8, 16 or 32, with kernels 3 or 5 in
    /// the first block and 3 elsewhere, with or without normalisation. The learning rate is drawn
    /// from 3·10⁻⁴ to 10⁻² on a logarithmic scale.
    ///
    /// ```
    /// use protomer_learn::trial::TrialSettings;
    ///
    /// let channels = ["shape".to_owned(), "potential".to_owned()];
    /// let drawn = TrialSettings::draw(1, 0, 32, &channels)?;
    /// assert_eq!(drawn, TrialSettings::draw(1, 0, 32, &channels)?);
    /// assert_eq!(drawn.blocks[1].width, 2 * drawn.blocks[0].width);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if a block makes no sense: none that
    /// is drawn.
    pub fn draw(seed: u64, number: usize, size: usize, channels: &[String]) -> Result<Self> {
        let mut random = CounterRng::for_purpose(seed, 0, number as u64, Purpose::TuningTrial);
        // Each block halves the grid, which must not vanish.
        let deepest = (size.max(4).ilog2() as usize).min(4);
        let depths = &BLOCKS[..deepest - 1];
        let depth = pick(&mut random, depths);
        let first = pick(&mut random, &WIDTHS);
        let kernel = pick(&mut random, &KERNELS);
        let groups = pick(&mut random, &GROUPS);
        let widths: Vec<usize> = (0..depth).map(|block| first << block).collect();
        let mut kernels = vec![3; depth];
        kernels[0] = kernel;
        // The bits of a mask are channels; without names there is nothing to leave out.
        let masks = (1 << channels.len().clamp(1, MOST_CHANNELS)) - 1;
        let mask = 1 + random.index(masks);
        let mut subset = Vec::new();
        for (i, name) in channels.iter().enumerate() {
            if mask >> i & 1 == 1 {
                subset.push(name.clone());
            }
        }
        let (slowest, fastest) = LEARNING_RATES;
        Ok(Self {
            blocks: BlockSettings::chain(&widths, &kernels, groups)?,
            learning_rate: slowest * (fastest / slowest).powf(random.uniform()),
            channels: subset,
        })
    }
}

fn pick(random: &mut CounterRng, choices: &[usize]) -> usize {
    choices[random.index(choices.len())]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(seed: u64, size: usize) -> Vec<TrialSettings> {
        let channels = ["shape", "potential"].map(String::from);
        (0..40)
            .map(|number| TrialSettings::draw(seed, number, size, &channels).unwrap())
            .collect()
    }

    #[test]
    fn draws_depend_on_seed_and_number_only() {
        assert_eq!(drawn(1, 16), drawn(1, 16));
        assert_ne!(drawn(1, 16), drawn(2, 16));
        assert_ne!(drawn(1, 16)[0], drawn(1, 16)[1]);
    }

    #[test]
    fn draws_fit_the_grid() {
        for (size, most) in [(4, 2), (8, 3), (16, 4), (64, 4)] {
            let depths: Vec<usize> = drawn(1, size).iter().map(|t| t.blocks.len()).collect();
            assert_eq!(depths.iter().max(), Some(&most), "{size} voxels");
            assert!(depths.iter().all(|depth| *depth >= 2));
        }
        for trial in drawn(1, 16) {
            assert!((3e-4..=1e-2).contains(&trial.learning_rate));
            assert!(!trial.channels.is_empty());
        }
    }

    #[test]
    fn every_subset_of_the_channels_is_drawn() {
        let all = drawn(1, 16);
        for subset in [&["shape"][..], &["potential"], &["shape", "potential"]] {
            assert!(
                all.iter().any(|trial| trial.channels == subset),
                "{subset:?}"
            );
        }
    }
}
