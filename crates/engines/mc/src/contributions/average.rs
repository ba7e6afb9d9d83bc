//! Means of contributions over the frames of a run.
//!
//! Frames that follow each other are alike, so the error comes from blocks of frames: the standard
//! deviation of the block means over the root of their number.

use super::state::{Contributions, PairContribution, StateEnergies};
use crate::System;
use crate::energy::terms::{EnergyParts, PAIR_TERMS, PairParts, TERMS};
use protomer_kernel::null;
use protomer_kernel::statistics::RunningMoments;
use serde::{Deserialize, Serialize};

/// A mean with its standard error; none for fewer than two blocks.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Mean {
    /// The mean.
    #[serde(deserialize_with = "null::as_nan")]
    pub mean: f64,
    /// Standard error of the mean.
    pub error: Option<f64>,
}

/// Sums over frames, and over blocks of them.
#[derive(Debug, Clone)]
pub struct Averages {
    kinds: Vec<Kind>,
    pairs: Vec<Pairs>,
    numbers: BlockSums,
    /// Means of each block: energy by terms, part outside the contacts, part between residues
    /// apart, share of the residues that touch nothing.
    blocks: Vec<[f64; TOTALS]>,
}

#[derive(Debug, Clone, Copy)]
struct Kind {
    start: usize,
    residues: usize,
    copies: usize,
}

#[derive(Debug, Clone, Copy)]
struct Pairs {
    kinds: (usize, usize),
    start: usize,
    columns: usize,
}

/// Numbers of a residue: the terms, whether it touches, the sum of the terms.
const OF_RESIDUE: usize = TERMS + 2;
/// Numbers of a pair: the terms of pairs, how many touch, whether any does, the sum of the terms.
const OF_PAIR: usize = PAIR_TERMS + 3;
/// Means of a block, as listed for [`Averages::blocks`].
const TOTALS: usize = TERMS + 3;
/// The first of them, energy of the charges.
const CHARGES: usize = 0;
/// Energy of the charges outside the contacts.
const OUTSIDE: usize = TERMS;
/// Energy of the charges between residues that do not touch each other.
const APART: usize = TERMS + 1;
/// Share of the residues that touch nothing.
const UNTOUCHED: usize = TERMS + 2;

/// Mean contribution of one residue, per copy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidueMean {
    /// The sum of the terms, kT.
    pub energy_kt: Mean,
    /// The energy by terms.
    pub parts: EnergyParts,
    /// Share of frames and copies in which it touches a residue of another body.
    pub touching: f64,
}

/// Mean contribution of one pair of residues, over all pairs of bodies of its kinds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairMean {
    /// The sum of the terms, kT.
    pub energy_kt: Mean,
    /// The energy by terms; `touching` is the mean number of such pairs that touch.
    pub parts: PairContribution,
    /// Share of frames in which at least one such pair touches.
    pub touching: f64,
}

/// Sums of many numbers at once.
#[derive(Debug, Clone)]
struct BlockSums {
    all: Vec<f64>,
    frames: usize,
    block: Vec<f64>,
    in_block: usize,
    blocks: usize,
    /// Means of the ended blocks.
    of_blocks: Vec<RunningMoments>,
}

impl Averages {
    /// Empty averages for states of this system.
    pub fn new(contributions: &Contributions, system: &System) -> Self {
        let (mut kinds, mut pairs, mut start) = (Vec::new(), Vec::new(), 0);
        let of_type = |kind: usize| {
            let copies = (0..system.len()).filter(|copy| system.type_index(*copy) == kind);
            copies.count()
        };
        for (kind, of_kind) in contributions.kinds().iter().enumerate() {
            kinds.push(Kind {
                start,
                residues: of_kind.len(),
                copies: of_type(kind),
            });
            start += OF_RESIDUE * of_kind.len();
        }
        for (first, rows) in contributions.kinds().iter().enumerate() {
            for (second, columns) in contributions.kinds().iter().enumerate().skip(first) {
                pairs.push(Pairs {
                    kinds: (first, second),
                    start,
                    columns: columns.len(),
                });
                start += OF_PAIR * rows.len() * columns.len();
            }
        }
        Self {
            kinds,
            pairs,
            numbers: BlockSums::new(start),
            blocks: vec![[0.0; TOTALS]],
        }
    }

    /// Adds a frame.
    pub fn push(&mut self, state: &StateEnergies, system: &System) {
        let mut numbers = vec![0.0; self.numbers.all.len()];
        let (mut residues, mut alone) = (0, 0);
        for (copy, of_copy) in state.residues.iter().enumerate() {
            let kind = self.kinds[system.type_index(copy)];
            let per_copy = 1.0 / kind.copies as f64;
            let rows = numbers[kind.start..].chunks_exact_mut(OF_RESIDUE);
            for (row, residue) in rows.zip(of_copy) {
                let touches = f64::from(u8::from(residue.touches));
                let terms = residue.parts.values().into_iter();
                let values = terms.chain([touches, residue.parts.total_kt()]);
                for (sum, value) in row.iter_mut().zip(values) {
                    *sum += per_copy * value;
                }
                residues += 1;
                alone += usize::from(!residue.touches);
            }
        }
        for (place, pairs) in self.pairs.iter().zip(&state.pairs) {
            let rows = numbers[place.start..].chunks_exact_mut(OF_PAIR);
            for (row, pair) in rows.zip(&pairs.pairs) {
                let any = f64::from(u8::from(pair.touching > 0.0));
                let (terms, others) = row.split_at_mut(PAIR_TERMS);
                terms.copy_from_slice(&pair.parts.values());
                others.copy_from_slice(&[pair.touching, any, pair.total_kt()]);
            }
        }
        let terms = state.parts.values().into_iter();
        let alone = alone as f64 / residues as f64;
        let totals = terms.chain([state.outside_kt, state.apart_kt, alone]);
        if let Some(block) = self.blocks.last_mut() {
            for (sum, total) in block.iter_mut().zip(totals) {
                *sum += total;
            }
        }
        self.numbers.push(&numbers);
    }

    /// Ends a block; the frames after it are taken for independent of those before.
    pub fn end_block(&mut self) {
        if self.numbers.in_block == 0 {
            return;
        }
        let frames = self.numbers.in_block as f64;
        if let Some(block) = self.blocks.last_mut() {
            for total in block.iter_mut() {
                *total /= frames;
            }
        }
        self.blocks.push([0.0; TOTALS]);
        self.numbers.end_block();
    }

    /// Frames so far.
    pub fn frames(&self) -> usize {
        self.numbers.frames
    }

    /// Ended blocks.
    pub fn blocks(&self) -> usize {
        self.numbers.blocks
    }

    /// A residue of a kind of body.
    pub fn residue(&self, kind: usize, residue: usize) -> ResidueMean {
        let start = self.kinds[kind].start + residue * OF_RESIDUE;
        let mean = |offset: usize| self.numbers.mean(start + offset);
        ResidueMean {
            energy_kt: self.numbers.mean_with_error(start + TERMS + 1),
            parts: EnergyParts::from_values(std::array::from_fn(mean)),
            touching: mean(TERMS),
        }
    }

    /// The pairs of kinds, the smaller number first.
    pub fn pairs_of_kinds(&self) -> Vec<(usize, usize)> {
        self.pairs.iter().map(|pairs| pairs.kinds).collect()
    }

    /// A pair of residues of two kinds of bodies, in the order of
    /// [`pairs_of_kinds`](Self::pairs_of_kinds); of one kind, the first residue not after the
    /// second.
    pub fn pair(&self, pairs: usize, first: usize, second: usize) -> PairMean {
        let place = self.pairs[pairs];
        let start = place.start + (first * place.columns + second) * OF_PAIR;
        let mean = |offset: usize| self.numbers.mean(start + offset);
        PairMean {
            energy_kt: self.numbers.mean_with_error(start + PAIR_TERMS + 2),
            parts: PairContribution {
                parts: PairParts::from_values(std::array::from_fn(mean)),
                touching: mean(PAIR_TERMS),
            },
            touching: mean(PAIR_TERMS + 1),
        }
    }

    /// The number of residues of a kind.
    pub fn residues(&self, kind: usize) -> usize {
        self.kinds[kind].residues
    }

    /// The energy by terms, kT.
    pub fn energy_kt(&self) -> EnergyParts<Mean> {
        EnergyParts::from_values(std::array::from_fn(|term| self.total(term)))
    }

    /// The energy, kT.
    pub fn total_kt(&self) -> Mean {
        let of_block = |block: &[f64; TOTALS]| block[..TERMS].iter().sum();
        let blocks: Vec<f64> = self.ended().iter().map(of_block).collect();
        mean_of_blocks(&blocks)
    }

    /// The part of the energy of the charges that comes from residues that touch nothing, kT.
    pub fn outside_kt(&self) -> Mean {
        self.total(OUTSIDE)
    }

    /// The share of the energy of the charges that comes from residues that touch nothing; `None`
    /// where that energy is not known to be negative.
    pub fn outside_share(&self) -> Option<Mean> {
        self.share_of_charges(OUTSIDE)
    }

    /// The share of the energy of the charges between residues that do not touch each other.
    pub fn apart_share(&self) -> Option<Mean> {
        self.share_of_charges(APART)
    }

    /// The share of the residues that touch nothing, over copies and frames.
    pub fn untouched_share(&self) -> Mean {
        self.total(UNTOUCHED)
    }

    fn ended(&self) -> &[[f64; TOTALS]] {
        &self.blocks[..self.blocks.len() - 1]
    }

    fn total(&self, index: usize) -> Mean {
        let blocks: Vec<f64> = self.ended().iter().map(|block| block[index]).collect();
        mean_of_blocks(&blocks)
    }

    /// Computes a share of the energy of the charges; the error is that of the ratio to first
    /// order.
    fn share_of_charges(&self, index: usize) -> Option<Mean> {
        const STANDARD_ERRORS: f64 = 3.0;
        let charges = self.total(CHARGES);
        let limit = STANDARD_ERRORS * charges.error.unwrap_or(0.0);
        if charges.mean >= -limit {
            return None;
        }
        let share = self.total(index).mean / charges.mean;
        let residual =
            |block: &[f64; TOTALS]| (block[index] - share * block[CHARGES]) / charges.mean;
        let residuals: Vec<f64> = self.ended().iter().map(residual).collect();
        Some(Mean {
            mean: share,
            error: mean_of_blocks(&residuals).error,
        })
    }
}

/// The mean of independent blocks of equal length.
///
/// ```
/// use protomer_mc::contributions::mean_of_blocks;
/// let mean = mean_of_blocks(&[1.0, 3.0]);
/// assert_eq!((mean.mean, mean.error), (2.0, Some(1.0)));
/// assert_eq!(mean_of_blocks(&[1.0]).error, None);
/// ```
pub fn mean_of_blocks(blocks: &[f64]) -> Mean {
    let moments: RunningMoments = blocks.iter().copied().collect();
    let error = moments.independent_standard_error();
    Mean {
        mean: moments.mean(),
        error: error.is_finite().then_some(error),
    }
}

impl BlockSums {
    fn new(numbers: usize) -> Self {
        Self {
            all: vec![0.0; numbers],
            frames: 0,
            block: vec![0.0; numbers],
            in_block: 0,
            blocks: 0,
            of_blocks: vec![RunningMoments::default(); numbers],
        }
    }

    fn push(&mut self, numbers: &[f64]) {
        self.frames += 1;
        self.in_block += 1;
        for ((all, block), number) in self.all.iter_mut().zip(&mut self.block).zip(numbers) {
            *all += number;
            *block += number;
        }
    }

    fn end_block(&mut self) {
        self.blocks += 1;
        let frames = self.in_block as f64;
        for (sum, of_blocks) in self.block.iter_mut().zip(&mut self.of_blocks) {
            of_blocks.push(*sum / frames);
            *sum = 0.0;
        }
        self.in_block = 0;
    }

    fn mean(&self, index: usize) -> f64 {
        self.all[index] / self.frames as f64
    }

    fn mean_with_error(&self, index: usize) -> Mean {
        let of_blocks = &self.of_blocks[index];
        Mean {
            mean: self.mean(index),
            error: (self.blocks > 1).then(|| of_blocks.independent_standard_error()),
        }
    }
}
