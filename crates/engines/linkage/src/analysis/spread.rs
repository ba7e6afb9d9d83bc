//! The first maximum of a quantity in time.
//!
//! The first maximum is the first value from which the quantity falls by more than a given drop.
//! Its time and height are those of the parabola through the largest sample and its two neighbours.
//! For the loss of coherence (fig. 12 of the paper) the quantity is the standard deviation of the
//! orientations, [`orientational_spread`](super::modes::orientational_spread), after every step.

use serde::{Deserialize, Serialize};

/// First maximum of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// Time of the maximum.
    pub time: f64,
    /// Value at the maximum.
    pub value: f64,
}

/// Finds the first maximum of a series sample by sample, in constant memory.
///
/// ```
/// use protomer_linkage::analysis::spread::FirstMaximum;
/// let mut first = FirstMaximum::new(0.0);
/// for step in 0..400 {
///     let time = 0.01 * f64::from(step);
///     first.push(time, time.sin());
/// }
/// let maximum = first.found().unwrap();
/// assert!((maximum.time - std::f64::consts::FRAC_PI_2).abs() < 1e-4);
/// assert!((maximum.value - 1.0).abs() < 1e-8);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FirstMaximum {
    drop: f64,
    /// The largest sample so far, the one before and the one after it.
    before: Option<Maximum>,
    largest: Option<Maximum>,
    after: Option<Maximum>,
    last: Option<Maximum>,
    found: Option<Maximum>,
}

impl FirstMaximum {
    /// Creates a search in which a maximum counts once the quantity has fallen below it by more
    /// than `drop`: 0 for any, more to pass over ripples.
    ///
    /// ```
    /// use protomer_linkage::analysis::spread::FirstMaximum;
    /// let highest = |drop| {
    ///     let mut first = FirstMaximum::new(drop);
    ///     for (step, value) in [0.0, 1.0, 0.9, 3.0, 0.0].into_iter().enumerate() {
    ///         first.push(step as f64, value);
    ///     }
    ///     first.found().map(|maximum| maximum.time.round())
    /// };
    /// assert_eq!((highest(0.0), highest(0.5)), (Some(1.0), Some(3.0)), "a ripple is passed over");
    /// ```
    pub fn new(drop: f64) -> Self {
        Self {
            drop,
            before: None,
            largest: None,
            after: None,
            last: None,
            found: None,
        }
    }

    /// Adds the next value; times must grow.
    pub fn push(&mut self, time: f64, value: f64) {
        if self.found.is_some() || value.is_nan() {
            return;
        }
        let sample = Maximum { time, value };
        match self.largest {
            Some(largest) if value <= largest.value => {
                self.after.get_or_insert(sample);
                if value < largest.value - self.drop {
                    self.found = Some(self.vertex(largest));
                }
            }
            _ => {
                (self.before, self.largest, self.after) = (self.last, Some(sample), None);
            }
        }
        self.last = Some(sample);
    }

    /// The first maximum, once it has passed.
    pub fn found(&self) -> Option<Maximum> {
        self.found
    }

    /// The vertex of the parabola through the largest sample and its neighbours.
    fn vertex(&self, largest: Maximum) -> Maximum {
        let (Some(before), Some(after)) = (self.before, self.after) else {
            return largest;
        };
        let (left, right) = (before.time - largest.time, after.time - largest.time);
        let (fall, rise) = (
            (before.value - largest.value) / left,
            (after.value - largest.value) / right,
        );
        let curvature = (rise - fall) / (right - left);
        let slope = fall - curvature * left;
        if curvature >= 0.0 {
            return largest;
        }
        let shift = -0.5 * slope / curvature;
        Maximum {
            time: largest.time + shift,
            value: largest.value + 0.5 * slope * shift,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_found_exactly_from_uneven_samples() {
        let mut first = FirstMaximum::new(0.0);
        for time in [0.0, 0.3, 0.5, 1.1, 1.3, 2.0] {
            first.push(time, 2.0 - 3.0 * (time - 0.9f64).powi(2));
        }
        let maximum = first.found().unwrap();
        assert!((maximum.time - 0.9).abs() < 1e-14 && (maximum.value - 2.0).abs() < 1e-14);
    }

    #[test]
    fn ripples_are_passed_over_and_later_maxima_ignored() {
        let series = [0.0, 1.0, 0.95, 2.0, 3.0, 2.9, 1.0, 9.0, 0.0];
        let find = |drop| {
            let mut first = FirstMaximum::new(drop);
            series
                .iter()
                .enumerate()
                .for_each(|(step, value)| first.push(step as f64, *value));
            first.found().unwrap().time
        };
        assert!((find(0.0) - 1.0).abs() < 0.5);
        assert!((find(0.2) - 4.0).abs() < 0.5);
    }

    #[test]
    fn a_series_that_only_grows_has_none() {
        let mut first = FirstMaximum::new(0.0);
        (0..10).for_each(|step| first.push(f64::from(step), f64::from(step)));
        assert_eq!(first.found(), None);
    }
}
