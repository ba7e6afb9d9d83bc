//! Successive halving (Jamieson and Talwalkar, AISTATS 2016): all trials train for a few epochs,
//! the better third goes on to three times as many, and so on.
//!
//! Trials are compared by their smallest validation loss. Who goes on follows from what each trial
//! had reached at each rung, and from nothing else, so processes that train different trials only
//! have to share these records.

use crate::Result;
use crate::error::refuse;
use crate::training::EpochRecord;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::result;

/// Number of trials of which one goes on.
const KEPT_ONE_OF: usize = 3;
/// Largest number of trials: more would not end, and their settings would fill the memory.
const MOST_TRIALS: usize = 100_000;

/// A plan of trials and epochs.
///
/// ```
/// use protomer_learn::halving::Halving;
///
/// let plan = Halving::new(27, 27)?;
/// assert_eq!(plan.rungs(), [1, 3, 9, 27]);
/// // 27 + 9 x 2 + 3 x 6 + 1 x 18, where 27 full trainings take 729.
/// assert_eq!(plan.total_epochs(), 81);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Halving {
    trials: usize,
    epochs: usize,
}

/// Result of a trial at a rung.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reached {
    /// Epochs done.
    pub epochs: usize,
    /// Smallest validation loss so far, nats; `None` if training diverged.
    pub validation_loss_nats: Option<f64>,
    /// Balanced accuracy on the validation part in that epoch.
    pub validation_balanced_accuracy: Option<f64>,
}

/// State of a search.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Standing {
    /// Trials that are still in, best first; in their order before the first rung.
    pub running: Vec<(usize, Reached)>,
    /// Trials that are out, best first.
    pub ended: Vec<(usize, Reached)>,
    /// The epochs to the rung that some have not reached; `None` at the end.
    pub rung: Option<Range<usize>>,
    /// Places in `running` of the trials that have not reached the end of `rung`.
    pub behind: Vec<usize>,
    /// Epochs of all records.
    pub epochs: u64,
}

impl Halving {
    /// A plan of so many trials, one of which trains for all epochs.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for no trials, no epochs, or too many
    /// trials.
    pub fn new(trials: usize, epochs: usize) -> Result<Self> {
        if trials == 0 || epochs == 0 {
            return refuse(format!(
                "{trials} trials of {epochs} epochs; give at least one of each"
            ));
        }
        if trials > MOST_TRIALS {
            return refuse(format!("{trials} trials; give at most {MOST_TRIALS}"));
        }
        Ok(Self { trials, epochs })
    }

    /// Epochs at which losers stop, ascending. The last is that of trials that are never stopped.
    ///
    /// ```
    /// use protomer_learn::halving::Halving;
    /// assert_eq!(Halving::new(1, 50)?.rungs(), [50], "a trial alone is never stopped");
    /// assert_eq!(Halving::new(9, 90)?.rungs(), [10, 30, 90]);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub fn rungs(&self) -> Vec<usize> {
        let (mut rung, mut trials) = (self.epochs, self.trials);
        let mut rungs = vec![rung];
        // One rung for each time that the trials can be cut to a third, down to one epoch.
        while trials > 1 && rung > 1 {
            trials = kept(trials);
            rung = (rung / KEPT_ONE_OF).max(1);
            rungs.push(rung);
        }
        rungs.reverse();
        rungs
    }

    /// Epochs of all trials together, at most.
    ///
    /// ```
    /// use protomer_learn::halving::Halving;
    /// // All nine for 10 epochs, three for 20 more, one for 60 more.
    /// assert_eq!(Halving::new(9, 90)?.total_epochs(), 90 + 60 + 60);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub fn total_epochs(&self) -> u64 {
        let (mut trials, mut before, mut total) = (self.trials, 0, 0);
        for rung in self.rungs() {
            // Those who go on have done the epochs of the rung before: only the rest counts.
            total += trials * (rung - before);
            (trials, before) = (kept(trials), rung);
        }
        total as u64
    }

    /// State of a search, from what `reached` knows of each trial at each rung.
    ///
    /// ```
    /// use protomer_learn::LearnError;
    /// use protomer_learn::halving::{Halving, Reached};
    ///
    /// // Three trials are past the first rung; the first of them did best.
    /// let reached = |trial: usize, rung: usize| {
    ///     Ok::<_, LearnError>((rung == 1).then_some(Reached {
    ///         epochs: 1,
    ///         validation_loss_nats: Some(0.5 + trial as f64),
    ///         validation_balanced_accuracy: None,
    ///     }))
    /// };
    /// let standing = Halving::new(3, 3)?.standing(reached)?;
    /// assert_eq!((standing.running.len(), standing.running[0].0), (1, 0));
    /// assert_eq!(standing.rung, Some(1..3));
    /// # Ok::<(), LearnError>(())
    /// ```
    ///
    /// # Errors
    /// Those of `reached`.
    pub fn standing<E>(
        &self,
        mut reached: impl FnMut(usize, usize) -> result::Result<Option<Reached>, E>,
    ) -> result::Result<Standing, E> {
        let mut standing = Standing::default();
        for trial in 0..self.trials {
            standing.running.push((trial, Reached::default()));
        }
        let mut before = 0;
        for rung in self.rungs() {
            let mut contenders = Vec::with_capacity(standing.running.len());
            // Only the rung that is not finished matters; at earlier ones nobody was behind.
            standing.behind.clear();
            for (place, (trial, _)) in standing.running.iter().enumerate() {
                match reached(*trial, rung)? {
                    Some(outcome) => contenders.push((*trial, outcome)),
                    None => standing.behind.push(place),
                }
            }
            standing.epochs += (contenders.len() * (rung - before)) as u64;
            // A rung is judged only when all have reached it, so
            // the outcome does not depend on which trial was fast.
            if !standing.behind.is_empty() {
                standing.rung = Some(before..rung);
                return Ok(standing);
            }
            contenders.sort_by(|(a, at_a), (b, at_b)| {
                // Diverged trials count as infinite loss and come last; equals keep their order.
                let by_loss = at_a.loss().total_cmp(&at_b.loss());
                by_loss.then(a.cmp(b))
            });
            // Nobody leaves at the last rung: everyone there is a result.
            let is_last = rung == self.epochs;
            let on = if is_last {
                contenders.len()
            } else {
                kept(contenders.len())
            };
            // Losers of later rounds stand before those of earlier ones.
            standing.ended.splice(0..0, contenders.split_off(on));
            (standing.running, before) = (contenders, rung);
        }
        Ok(standing)
    }
}

impl Reached {
    /// Result at a rung of a training with this history. Epochs beyond the rung do not count: a
    /// search that goes on finds checkpoints that are further, and what came later must not decide
    /// who goes on from here.
    pub fn from_history(history: &[EpochRecord], rung: usize) -> Self {
        let history = history.get(..rung).unwrap_or(history);
        let mut reached = Self {
            epochs: history.len(),
            ..Self::default()
        };
        for record in history {
            let loss = record.validation_loss_nats.unwrap_or(f64::INFINITY);
            // Strictly smaller: of equal losses the earlier epoch counts. NaN is never smaller.
            if loss < reached.loss() {
                reached.validation_loss_nats = Some(loss);
                reached.validation_balanced_accuracy = record.validation_balanced_accuracy;
            }
        }
        reached
    }

    /// Loss by which trials are compared.
    fn loss(&self) -> f64 {
        self.validation_loss_nats.unwrap_or(f64::INFINITY)
    }
}

/// Number of trials that go on, out of this many.
fn kept(trials: usize) -> usize {
    trials.div_ceil(KEPT_ONE_OF)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::LearnError;
    use std::collections::BTreeMap;

    #[test]
    fn a_third_goes_on_to_three_times_as_many_epochs() {
        let cases: [(usize, usize, &[usize], u64); 7] = [
            // 27 + 9 x 2 + 3 x 6 + 1 x 18.
            (27, 27, &[1, 3, 9, 27], 81),
            // 9 x 3 + 3 x 6 + 1 x 18.
            (9, 27, &[3, 9, 27], 63),
            // 5 + 2 x 3.
            (5, 4, &[1, 4], 11),
            (4, 9, &[1, 3, 9], 14),
            (1, 27, &[27], 27),
            (27, 1, &[1], 27),
            (3, 2, &[1, 2], 4),
        ];
        for (trials, epochs, rungs, total) in cases {
            let plan = Halving::new(trials, epochs).unwrap();
            assert_eq!(
                (plan.rungs().as_slice(), plan.total_epochs()),
                (rungs, total),
                "{trials}, {epochs}"
            );
        }
        assert!(Halving::new(0, 3).is_err() && Halving::new(3, 0).is_err());
        assert!(Halving::new(MOST_TRIALS + 1, 3).is_err());
    }

    fn at_loss(epochs: usize, loss: Option<f64>) -> Reached {
        Reached {
            epochs,
            validation_loss_nats: loss,
            validation_balanced_accuracy: None,
        }
    }

    /// Four trials, nine epochs: rungs 1, 3, 9; two trials see three epochs, one sees nine.
    #[test]
    fn who_goes_on_follows_from_the_records() {
        let plan = Halving::new(4, 9).unwrap();
        let mut records = BTreeMap::new();
        let standing = |records: &BTreeMap<(usize, usize), Reached>| {
            plan.standing(|trial, rung| Ok::<_, LearnError>(records.get(&(trial, rung)).copied()))
                .unwrap()
        };
        let start = standing(&records);
        assert_eq!((start.rung, start.behind), (Some(0..1), vec![0, 1, 2, 3]));
        for (trial, loss) in [Some(0.6), Some(0.4), None, Some(0.6)]
            .into_iter()
            .enumerate()
        {
            records.insert((trial, 1), at_loss(1, loss));
        }
        // Of equal losses the smaller number goes on; a trial that diverged is last.
        let first = standing(&records);
        let numbers = |trials: &[(usize, Reached)]| {
            trials.iter().map(|(trial, _)| *trial).collect::<Vec<_>>()
        };
        assert_eq!(numbers(&first.running), [1, 0]);
        assert_eq!(numbers(&first.ended), [3, 2]);
        assert_eq!(
            (first.rung, first.behind, first.epochs),
            (Some(1..3), vec![0, 1], 4)
        );
        records.insert((0, 3), at_loss(3, Some(0.3)));
        let half = standing(&records);
        assert_eq!((half.behind, half.epochs), (vec![0], 6));
        records.insert((1, 3), at_loss(3, Some(0.4)));
        records.insert((0, 9), at_loss(9, Some(0.2)));
        let end = standing(&records);
        assert_eq!((end.rung.clone(), end.epochs), (None, plan.total_epochs()));
        assert_eq!(numbers(&end.running), [0]);
        assert_eq!(numbers(&end.ended), [1, 3, 2]);
    }

    #[test]
    fn a_trial_stands_where_it_stood_at_its_rung() {
        let record = |epoch: usize, loss: f64| EpochRecord {
            epoch,
            training_loss_nats: 1.0,
            validation_loss_nats: Some(loss),
            validation_balanced_accuracy: Some(epoch as f64),
            gradient_norm: 1.0,
            largest_gradient_norm: 1.0,
            learning_rate: 1e-3,
            skipped_steps: 0,
        };
        let history = [
            record(1, 0.7),
            record(2, f64::NAN),
            record(3, 0.6),
            record(4, 0.1),
        ];
        let state = |rung| {
            let reached = Reached::from_history(&history, rung);
            (
                reached.epochs,
                reached.validation_loss_nats,
                reached.validation_balanced_accuracy,
            )
        };
        assert_eq!(state(1), (1, Some(0.7), Some(1.0)));
        assert_eq!(state(3), (3, Some(0.6), Some(3.0)));
        // Ended early, the history is shorter than the rung.
        assert_eq!(state(9), (4, Some(0.1), Some(4.0)));
        assert_eq!(
            Reached::from_history(&[record(1, f64::NAN)], 1).loss(),
            f64::INFINITY
        );
    }
}
