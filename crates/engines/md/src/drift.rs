//! How well a quantity is kept: a straight line through its values, and the noise about it.

use serde::{Deserialize, Serialize};

/// Sums over values at times; both are taken from the first, so that nothing is lost to rounding.
///
/// ```
/// use protomer_md::drift::Drift;
/// let mut drift = Drift::default();
/// for (time, value) in [(0.0, 5.0), (1.0, 7.0), (2.0, 9.0)] {
///     drift.push(time, value);
/// }
/// assert_eq!((drift.count(), drift.change()), (3.0, 4.0));
/// assert!(drift.noise() < 1e-12, "all lie on a line");
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    count: f64,
    first: [f64; 2],
    last: [f64; 2],
    /// Means of time and value.
    means: [f64; 2],
    /// Sums of the squares and of the product of the deviations.
    squares: [f64; 2],
    product: f64,
}

impl Drift {
    /// Adds a value.
    ///
    /// ```
    /// use protomer_md::drift::Drift;
    /// let mut drift = Drift::default();
    /// for step in 0..101 {
    ///     let time = f64::from(step);
    ///     drift.push(time, 7.0 + 0.01 * time + if step % 2 == 0 { 1e-3 } else { -1e-3 });
    /// }
    /// assert!((drift.along_the_line() - 1.0).abs() < 1e-4);
    /// assert!((drift.noise() - 1e-3).abs() < 1e-5);
    /// ```
    pub fn push(&mut self, time: f64, value: f64) {
        if self.count == 0.0 {
            self.first = [time, value];
        }
        self.count += 1.0;
        let point = [time - self.first[0], value - self.first[1]];
        self.last = point;
        // Welford's update for both means, squares and the product.
        let before = [point[0] - self.means[0], point[1] - self.means[1]];
        for axis in 0..2 {
            self.means[axis] += before[axis] / self.count;
            self.squares[axis] += before[axis] * (point[axis] - self.means[axis]);
        }
        self.product += before[0] * (point[1] - self.means[1]);
    }

    /// Number of values so far.
    pub fn count(&self) -> f64 {
        self.count
    }

    /// The last value minus the first.
    ///
    /// ```
    /// use protomer_md::drift::Drift;
    /// let mut drift = Drift::default();
    /// [(0.0, 5.0), (1.0, 9.0), (2.0, 6.0)].map(|(time, value)| drift.push(time, value));
    /// assert_eq!(drift.change(), 1.0, "the value in between does not count");
    /// ```
    pub fn change(&self) -> f64 {
        self.last[1]
    }

    /// The change over the whole time along the straight line through the values.
    ///
    /// ```
    /// use protomer_md::drift::Drift;
    /// let mut drift = Drift::default();
    /// [(0.0, 0.0), (1.0, 3.0), (2.0, 0.0)].map(|(time, value)| drift.push(time, value));
    /// assert!(drift.along_the_line().abs() < 1e-12, "it rises as much as it falls");
    /// ```
    pub fn along_the_line(&self) -> f64 {
        match self.squares[0] > 0.0 {
            true => self.product / self.squares[0] * self.last[0],
            false => 0.0,
        }
    }

    /// The root of the mean squared deviation from the line.
    ///
    /// ```
    /// use protomer_md::drift::Drift;
    /// let mut drift = Drift::default();
    /// [(0.0, 1.0), (1.0, -1.0), (2.0, -1.0), (3.0, 1.0)].map(|(time, value)| drift.push(time, value));
    /// assert!((drift.noise() - 1.0).abs() < 1e-12);
    /// ```
    pub fn noise(&self) -> f64 {
        // Sum of squares that the line leaves.
        if self.squares[0] <= 0.0 {
            return 0.0;
        }
        let residual = self.squares[1] - self.product * self.product / self.squares[0];
        // Rounding may leave less than nothing. Not `max`, which would turn NaN into no noise at all.
        let residual = if residual < 0.0 { 0.0 } else { residual };
        (residual / self.count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_no_numbers_are_not_kept_well() {
        let mut drift = Drift::default();
        for (time, value) in [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0)] {
            drift.push(time, value);
        }
        assert!(drift.noise().is_nan() && drift.along_the_line().is_nan());
        // Points on a line, up to rounding.
        let mut line = Drift::default();
        for step in 0..1000 {
            line.push(f64::from(step), 0.1 * f64::from(step));
        }
        assert!(line.noise() < 1e-4);
    }
}
