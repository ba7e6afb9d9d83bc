//! A cubic spline through points.

use crate::error::{Error, Result};
use protomer_kernel::jet::Jet;

/// A cubic spline through points, with ends of the third derivative of their neighbours (not a knot).
#[derive(Debug, Clone)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    second: Vec<f64>,
}

/// Smallest number of points; fewer leave the ends undetermined.
const FEWEST_POINTS: usize = 4;

impl Spline {
    /// A spline through four or more points (x, y) whose abscissas ascend.
    ///
    /// ```
    /// use protomer_hpmc::spline::Spline;
    ///
    /// let cube = |x: f64| (x, x.powi(3));
    /// let spline = Spline::through([0.0, 1.0, 2.0, 4.0].map(cube))?;
    /// assert!((spline.integrals()[3] - 64.0).abs() < 1e-12);
    /// assert!(Spline::through([1.0, 0.0, 2.0, 3.0].map(cube)).is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// If there are fewer points, or two do not ascend.
    pub fn through(points: impl IntoIterator<Item = (f64, f64)>) -> Result<Self> {
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        if x.len() < FEWEST_POINTS {
            return Err(Error::FewPoints {
                given: x.len(),
                fewest: FEWEST_POINTS,
            });
        }
        if let Some(pair) = x.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(Error::NotAscending {
                first: pair[0],
                second: pair[1],
            });
        }
        let last = x.len() - 1;
        let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // Rows of the tridiagonal system for the second derivatives at the inner points, from which
        // those at the ends are eliminated.
        let (mut low, mut middle, mut high, mut right) = (
            vec![0.0; last + 1],
            vec![1.0; last + 1],
            vec![0.0; last + 1],
            vec![0.0; last + 1],
        );
        for i in 1..last {
            low[i] = h[i - 1];
            middle[i] = 2.0 * (h[i - 1] + h[i]);
            high[i] = h[i];
            right[i] = 6.0 * ((y[i + 1] - y[i]) / h[i] - (y[i] - y[i - 1]) / h[i - 1]);
        }
        // second[0] = second[1] - (second[2] - second[1]) h[0] / h[1], and alike at the other end.
        let (start, end) = (h[0] / h[1], h[last - 1] / h[last - 2]);
        middle[1] += low[1] * (1.0 + start);
        high[1] -= low[1] * start;
        middle[last - 1] += high[last - 1] * (1.0 + end);
        low[last - 1] -= high[last - 1] * end;
        let mut second = vec![0.0; last + 1];
        for i in 2..last {
            let factor = low[i] / middle[i - 1];
            middle[i] -= factor * high[i - 1];
            right[i] -= factor * right[i - 1];
        }
        for i in (1..last).rev() {
            let beyond = if i + 1 < last {
                high[i] * second[i + 1]
            } else {
                0.0
            };
            second[i] = (right[i] - beyond) / middle[i];
        }
        second[0] = second[1] - (second[2] - second[1]) * start;
        second[last] = second[last - 1] + (second[last - 1] - second[last - 2]) * end;
        Ok(Self { x, y, second })
    }

    /// The abscissas of the first and of the last point.
    ///
    /// ```
    /// use protomer_hpmc::spline::Spline;
    /// let spline = Spline::through([0.5, 1.0, 2.0, 4.0].map(|x: f64| (x, x * x)))?;
    /// assert_eq!(spline.range(), [0.5, 4.0]);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// The value with its derivatives.
    ///
    /// ```
    /// use protomer_hpmc::spline::Spline;
    /// use protomer_kernel::jet::Jet;
    /// let spline = Spline::through([0.0, 1.0, 2.0, 4.0].map(|x: f64| (x, x.powi(3))))?;
    /// let middle = spline.evaluate(Jet::variable(3.0, 0));
    /// assert!((middle.value - 27.0).abs() < 1e-12 && (middle.first() - 27.0).abs() < 1e-12);
    /// assert_eq!(spline.range(), [0.0, 4.0]);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn evaluate(&self, abscissa: Jet) -> Jet {
        let above = self.x.partition_point(|x| *x <= abscissa.value);
        let i = above.clamp(1, self.x.len() - 1) - 1;
        let h = self.x[i + 1] - self.x[i];
        let b = (abscissa + -self.x[i]) * h.recip();
        let a = -b + 1.0;
        a * self.y[i]
            + b * self.y[i + 1]
            + ((a * a * a - a) * self.second[i] + (b * b * b - b) * self.second[i + 1])
                * (h * h / 6.0)
    }

    /// The integral from the first point to each point.
    ///
    /// ```
    /// use protomer_hpmc::spline::Spline;
    /// let spline = Spline::through([0.0, 1.0, 2.0, 4.0].map(|x: f64| (x, 3.0 * x * x)))?;
    /// assert!((spline.integrals()[3] - 64.0).abs() < 1e-12, "x³ at the last point");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn integrals(&self) -> Vec<f64> {
        let mut integrals = vec![0.0];
        for i in 0..self.x.len() - 1 {
            let h = self.x[i + 1] - self.x[i];
            let trapezium = 0.5 * h * (self.y[i] + self.y[i + 1]);
            let bent = h * h * h * (self.second[i] + self.second[i + 1]) / 24.0;
            integrals.push(integrals[i] + trapezium - bent);
        }
        integrals
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn cubic_functions_are_integrated_exactly() {
        let x = [0.0, 0.1, 0.4, 0.5, 0.9];
        let points = x.iter().map(|x| (*x, 1.0 - 2.0 * x + x * x * x));
        let spline = Spline::through(points).unwrap();
        for (x, found) in spline.x.iter().zip(spline.integrals()) {
            let exact = x - x * x + 0.25 * x * x * x * x;
            assert!((found - exact).abs() < 1e-14, "{x}: {found} {exact}");
        }
    }
}
