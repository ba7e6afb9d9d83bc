//! Groups of samples dealt out to the parts of a split.

use super::shuffle;
use crate::Result;
use crate::error::refuse;
use protomer_kernel::random::{CounterRng, Purpose};
use std::array;
use std::cmp::Reverse;

/// Parts of a split.
const PARTS: usize = 3;
/// A gain must exceed another by more than this to count as larger: rounding does not decide.
const LEAST_GAIN: f64 = 1e-12;

/// Distributes groups over parts, largest first, each to the part p where it lowers most
///
/// E = Σ_p [ Σ_k (n_pk - f_p N_k)² / N_k + K (n_p - f_p N)² / N ]
///
/// with n_pk samples of the label k in the part p, N_k in all, K labels, and f_p the share the part
/// should have. Groups of one size go in a random order.
pub(super) fn assign(
    groups: &[impl AsRef<[usize]>],
    labels: &[u32],
    seed: u64,
    shares: [f64; PARTS],
) -> Result<[Vec<usize>; PARTS]> {
    check(&shares)?;
    let counter = Counter::new(labels);
    let mut filling = Filling::new(shares, counter.all());
    let mut parts: [Vec<usize>; PARTS] = array::from_fn(|_| Vec::new());
    for group in largest_first(groups, seed) {
        let part = filling.add(&counter.count(group));
        parts[part].extend_from_slice(group);
    }
    for (part, share) in parts.iter_mut().zip(shares) {
        if part.is_empty() && share > 0.0 {
            return refuse(format!(
                "{} groups are too few for the shares {shares:?}: a part stays empty; take more \
                 of them, or other shares",
                groups.len()
            ));
        }
        part.sort_unstable();
    }
    Ok(parts)
}

fn check(shares: &[f64; PARTS]) -> Result<()> {
    let in_range = shares.iter().all(|share| (0.0..=1.0).contains(share));
    if !in_range || (shares.iter().sum::<f64>() - 1.0).abs() > 1e-9 {
        return refuse(format!(
            "the shares {shares:?} of a split must be 0 to 1 and sum to 1"
        ));
    }
    Ok(())
}

fn largest_first(groups: &[impl AsRef<[usize]>], seed: u64) -> Vec<&[usize]> {
    let mut order: Vec<&[usize]> = groups.iter().map(AsRef::as_ref).collect();
    shuffle(
        &mut order,
        &mut CounterRng::for_purpose(seed, 0, 0, Purpose::Split),
    );
    // A stable sort: groups of one size stay shuffled.
    order.sort_by_key(|group| Reverse(group.len()));
    order
}

/// Counts samples by label.
struct Counter<'a> {
    /// The rank of the label of each sample.
    labels: &'a [u32],
    count: usize,
}

impl<'a> Counter<'a> {
    fn new(labels: &'a [u32]) -> Self {
        let count = labels.iter().max().map_or(0, |last| *last as usize + 1);
        Self { labels, count }
    }

    /// Samples of each label, and in the last place all of them.
    fn count(&self, samples: &[usize]) -> Vec<f64> {
        let mut counts = vec![0.0; self.count + 1];
        for sample in samples {
            counts[self.labels[*sample] as usize] += 1.0;
        }
        counts[self.count] = samples.len() as f64;
        counts
    }

    fn all(&self) -> Vec<f64> {
        let samples: Vec<usize> = (0..self.labels.len()).collect();
        self.count(&samples)
    }
}

/// Filling of the parts. Counts are those of [`Counter`].
struct Filling {
    shares: [f64; PARTS],
    total: Vec<f64>,
    filled: [Vec<f64>; PARTS],
}

impl Filling {
    fn new(shares: [f64; PARTS], total: Vec<f64>) -> Self {
        let empty = vec![0.0; total.len()];
        Self {
            shares,
            total,
            filled: [empty.clone(), empty.clone(), empty],
        }
    }

    /// Adds a group to the part where it gains most, and returns that part.
    fn add(&mut self, group: &[f64]) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for part in 0..PARTS {
            let gain = self.gain(part, group);
            if self.shares[part] > 0.0 && gain > best.1 + LEAST_GAIN {
                best = (part, gain);
            }
        }
        for (filled, added) in self.filled[best.0].iter_mut().zip(group) {
            *filled += added;
        }
        best.0
    }

    /// Decrease of E. Adding c samples to n lowers (n - f N)² / N by c (2 (f N - n) - c) / N.
    fn gain(&self, part: usize, group: &[f64]) -> f64 {
        let labels = group.len() - 1;
        let mut gain = 0.0;
        for (column, added) in group.iter().enumerate() {
            let weight = if column == labels { labels as f64 } else { 1.0 };
            let shortage = self.shares[part] * self.total[column] - self.filled[part][column];
            gain += weight * added * (2.0 * shortage - added) / f64::max(self.total[column], 1.0);
        }
        gain
    }
}
