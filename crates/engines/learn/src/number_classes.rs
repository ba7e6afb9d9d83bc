//! Numbers as ordered classes, so that a network of classes predicts a number.
//!
//! The numbers are cut into classes of about equally many samples. What is predicted for a sample is
//! the mean
//!
//! ```text
//! x = Σ_k p_k m_k
//! ```
//!
//! of the numbers m_k that the classes stand for, weighted by the probabilities p_k of the classes. The
//! cross entropy of such classes can teach a network a number better than the squared error does (Imani and
//! White, ICML 2018). No prediction lies beyond the m_k of the first and the last class.

use crate::Result;
use crate::error::refuse;
use serde::{Deserialize, Serialize};

/// Fewest and most classes that numbers are cut into.
pub const COUNT_RANGE: (usize, usize) = (2, 100);

/// Classes of a number, lowest first.
///
/// ```
/// use protomer_learn::number_classes::NumberClasses;
///
/// let classes = NumberClasses::from_numbers(&[1.0, 2.0, 3.0, 10.0], 2)?;
/// assert_eq!(classes.names(), ["below 2.5", "from 2.5"]);
/// assert_eq!(classes.means, [1.5, 6.5]);
/// assert_eq!(classes.class_of(2.5), 1);
/// // Sample after sample: the mean over the probabilities.
/// assert_eq!(classes.predicted(&[1.0, 0.0, 0.5, 0.5]), [1.5, 4.0]);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumberClasses {
    /// Bounds between neighbouring classes, ascending. A number that equals a bound is above it.
    pub bounds: Vec<f64>,
    /// The number that each class stands for.
    pub means: Vec<f64>,
}

impl NumberClasses {
    /// At most `count` classes of about equally many of these numbers; fewer if many of them are equal.
    /// Each class stands for the mean of its numbers.
    ///
    /// ```
    /// use protomer_learn::number_classes::NumberClasses;
    /// let classes = NumberClasses::from_numbers(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3)?;
    /// assert_eq!((classes.count(), &classes.means[..]), (3, &[1.5, 3.5, 5.5][..]));
    /// assert!(NumberClasses::from_numbers(&[2.0, 2.0], 2).is_err(), "all are the same");
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for a count out of [`COUNT_RANGE`], and for
    /// numbers that are not finite or all the same.
    pub fn from_numbers(numbers: &[f64], count: usize) -> Result<Self> {
        let (fewest, most) = COUNT_RANGE;
        if !(fewest..=most).contains(&count) {
            return refuse(format!(
                "numbers cannot be cut into {count} classes; give {fewest} to {most}"
            ));
        }
        if let Some(wrong) = numbers.iter().find(|number| !number.is_finite()) {
            return refuse(format!("{wrong} cannot be learnt; give finite numbers"));
        }
        let mut sorted = numbers.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let mut bounds: Vec<f64> = Vec::new();
        for class in 1..count {
            let place = class * sorted.len() / count;
            // The bound is between two different numbers, so that no class is empty.
            let Some(above) = sorted.get(place) else {
                continue;
            };
            let lesser = sorted.partition_point(|number| number < above);
            let Some(below) = lesser.checked_sub(1).map(|place| sorted[place]) else {
                continue;
            };
            let bound = bound_between(below, *above);
            if bounds.last().is_none_or(|last| *last < bound) {
                bounds.push(bound);
            }
        }
        if bounds.is_empty() {
            return refuse(match sorted.first() {
                Some(number) => format!(
                    "all {} numbers are {number}, so there is nothing to learn; give different ones",
                    sorted.len()
                ),
                None => "there are no numbers to learn from".to_owned(),
            });
        }
        let classes = Self {
            means: vec![0.0; bounds.len() + 1],
            bounds,
        };
        let weighted: Vec<(f64, f64)> = numbers.iter().map(|number| (*number, 1.0)).collect();
        Ok(classes.with_means_of(&weighted))
    }

    /// The same classes, each standing for the weighted mean of those of these numbers, given with their
    /// weights, that are in it. A class without one stands for the same number as before.
    ///
    /// ```
    /// use protomer_learn::number_classes::NumberClasses;
    /// let classes = NumberClasses::from_numbers(&[1.0, 2.0, 3.0, 4.0], 2)?;
    /// let weighted = classes.with_means_of(&[(1.0, 3.0), (2.0, 1.0)]);
    /// assert_eq!(weighted.means, [1.25, 3.5]);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub fn with_means_of(&self, weighted: &[(f64, f64)]) -> Self {
        let (mut sums, mut totals) = (vec![0.0; self.count()], vec![0.0; self.count()]);
        for (number, weight) in weighted {
            let class = self.class_of(*number);
            sums[class] += weight * number;
            totals[class] += weight;
        }
        let mut means = self.means.clone();
        for (mean, (sum, total)) in means.iter_mut().zip(sums.iter().zip(totals)) {
            if total > 0.0 {
                *mean = sum / total;
            }
        }
        Self {
            bounds: self.bounds.clone(),
            means,
        }
    }

    /// Number of classes.
    pub fn count(&self) -> usize {
        self.bounds.len() + 1
    }

    /// The class of a number.
    pub fn class_of(&self, number: f64) -> usize {
        self.bounds.partition_point(|bound| *bound <= number)
    }

    /// A name for each class, in their order.
    ///
    /// ```
    /// use protomer_learn::number_classes::NumberClasses;
    /// let classes = NumberClasses { bounds: vec![1.5, 3.0], means: vec![1.0, 2.0, 4.0] };
    /// assert_eq!(classes.names(), ["below 1.5", "1.5 to 3", "from 3"]);
    /// ```
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::with_capacity(self.count());
        if let (Some(first), Some(last)) = (self.bounds.first(), self.bounds.last()) {
            names.push(format!("below {first}"));
            let between = self.bounds.windows(2);
            names.extend(between.map(|ends| format!("{} to {}", ends[0], ends[1])));
            names.push(format!("from {last}"));
        }
        names
    }

    /// The numbers that probabilities predict, sample after sample.
    ///
    /// ```
    /// use protomer_learn::number_classes::NumberClasses;
    /// let classes = NumberClasses { bounds: vec![5.0], means: vec![2.0, 10.0] };
    /// assert_eq!(classes.predicted(&[0.75, 0.25]), [4.0]);
    /// ```
    pub fn predicted(&self, probabilities: &[f64]) -> Vec<f64> {
        let of_samples = probabilities.chunks(self.count());
        let mean = |p: &[f64]| p.iter().zip(&self.means).map(|(p, mean)| p * mean).sum();
        of_samples.map(mean).collect()
    }
}

/// A bound with few digits above one number and not above a greater one.
fn bound_between(below: f64, above: f64) -> f64 {
    let middle = below + 0.5 * (above - below);
    let rounded = |digits: usize| format!("{middle:.digits$e}").parse::<f64>().ok();
    let fits = |bound: &f64| below < *bound && *bound <= above;
    (0..17).filter_map(rounded).find(fits).unwrap_or(above)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_hold_about_equally_many_and_bounds_have_few_digits() {
        let numbers: Vec<f64> = (0..1000)
            .map(|i| (f64::from(i) * 0.618).fract().exp())
            .collect();
        let classes = NumberClasses::from_numbers(&numbers, 5).unwrap();
        let mut counts = vec![0; classes.count()];
        for number in &numbers {
            counts[classes.class_of(*number)] += 1;
        }
        assert_eq!(counts, [200; 5]);
        assert!(classes.names().iter().all(|name| name.len() < 20));
        // The slow twin of a mean.
        for (class, mean) in classes.means.iter().enumerate() {
            let of_class: Vec<f64> = numbers
                .iter()
                .copied()
                .filter(|number| classes.class_of(*number) == class)
                .collect();
            let expected = of_class.iter().sum::<f64>() / of_class.len() as f64;
            assert!((mean - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn equal_numbers_share_a_class() {
        let classes = NumberClasses::from_numbers(&[0.0, 0.0, 0.0, 0.0, 1.0, 2.0], 3).unwrap();
        assert_eq!(classes.names(), ["below 0.5", "from 0.5"]);
        let classes = NumberClasses::from_numbers(&[-1.0, 5.0, 5.0, 5.0], 4).unwrap();
        assert_eq!(classes.names(), ["below 2", "from 2"]);
        assert_eq!(classes.means, [-1.0, 5.0]);
        let next = f64::from_bits(1.0_f64.to_bits() + 1);
        let classes = NumberClasses::from_numbers(&[1.0, next], 2).unwrap();
        assert_eq!((classes.class_of(1.0), classes.class_of(next)), (0, 1));
    }

    #[test]
    fn a_class_without_numbers_keeps_what_it_stands_for() {
        let classes = NumberClasses::from_numbers(&[1.0, 2.0, 3.0, 4.0], 2).unwrap();
        let again = classes.with_means_of(&[(1.0, 2.0)]);
        assert_eq!(again.means, [1.0, 3.5]);
    }

    #[test]
    fn what_cannot_be_learnt_is_refused() {
        let refusal = |numbers: &[f64], count| {
            NumberClasses::from_numbers(numbers, count)
                .unwrap_err()
                .to_string()
        };
        assert!(refusal(&[1.0, 2.0], 1).contains("2 to 100"));
        assert!(refusal(&[2.5; 3], 2).contains("all 3 numbers are 2.5"));
        assert!(refusal(&[1.0, f64::NAN], 2).contains("NaN"));
        assert!(refusal(&[], 2).contains("no numbers"));
    }
}
