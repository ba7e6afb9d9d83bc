//! Cubic splines through points, with their exact derivatives and integrals.
//!
//! Between two points the function is a cubic; value, slope and curvature are continuous. The ends decide the two curvatures
//! that this leaves open.

use crate::error::{KernelError, Result};

/// Conditions at the ends of a spline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    /// No curvature at the ends, and straight lines beyond them, so that the function has two continuous derivatives
    /// everywhere (a natural spline).
    Straight,
    /// Cubics through three points at each end, which go on beyond it (not a knot): exact for cubic functions.
    Cubic,
    /// No slope at the ends, and constant beyond them.
    Level,
    /// No curvature at the first point and a straight line before it; no slope at the last point and constant after it.
    LevelAtLast,
}

impl Ends {
    /// Smallest number of points; fewer leave the ends undetermined.
    const fn fewest_points(self) -> usize {
        match self {
            Ends::Straight | Ends::LevelAtLast => 2,
            Ends::Level => 3,
            Ends::Cubic => 4,
        }
    }
}

/// A cubic spline through points.
///
/// ```
/// use protomer_kernel::spline::{Ends, Spline};
/// let spline = Spline::through(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0], Ends::Straight)?;
/// assert_eq!(spline.evaluate(1.0)[..2], [1.0, 0.0]);
/// // Straight beyond the last point.
/// assert!((spline.evaluate(3.0)[0] + 1.5).abs() < 1e-12);
/// assert!(Spline::through(&[0.0, 0.0], &[1.0, 2.0], Ends::Straight).is_err());
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the points.
    curvature: Vec<f64>,
    ends: Ends,
}

impl Spline {
    /// The spline through points in the order of ascending x: two or more for straight ends, four or more for cubic ones.
    ///
    /// ```
    /// use protomer_kernel::spline::{Ends, Spline};
    /// let x = [0.0, 1.0, 2.0, 4.0];
    /// let cube = Spline::through(&x, &x.map(|x: f64| x.powi(3)), Ends::Cubic)?;
    /// let [value, slope, curvature] = cube.evaluate(3.0);
    /// assert!((value - 27.0).abs() < 1e-12 && (slope - 27.0).abs() < 1e-12 && (curvature - 18.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadTable`] says which points are missing, not finite or out of order.
    pub fn through(x: &[f64], y: &[f64], ends: Ends) -> Result<Self> {
        check(x, y, ends.fewest_points())?;
        Ok(Self {
            x: x.to_vec(),
            y: y.to_vec(),
            curvature: curvatures(x, y, ends),
            ends,
        })
    }

    /// First and last abscissa.
    ///
    /// ```
    /// use protomer_kernel::spline::{Ends, Spline};
    /// let spline = Spline::through(&[0.5, 1.0, 4.0], &[0.0, 1.0, 0.0], Ends::Straight)?;
    /// assert_eq!(spline.range(), [0.5, 4.0]);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// Value, slope and curvature at this abscissa.
    pub fn evaluate(&self, x: f64) -> [f64; 3] {
        let [first, last] = self.range();
        let end = x.clamp(first, last);
        if self.ends == Ends::Cubic || x == end {
            return self.inside(x);
        }
        let [value, slope, _] = self.inside(end);
        let is_level = match self.ends {
            Ends::Level => true,
            Ends::LevelAtLast => x > last,
            Ends::Straight | Ends::Cubic => false,
        };
        match is_level {
            true => [value, 0.0, 0.0],
            false => [value + slope * (x - end), slope, 0.0],
        }
    }

    fn inside(&self, x: f64) -> [f64; 3] {
        let after = self.x.partition_point(|point| *point <= x);
        let i = after.clamp(1, self.x.len() - 1) - 1;
        let h = self.x[i + 1] - self.x[i];
        let (b, a) = ((x - self.x[i]) / h, (self.x[i + 1] - x) / h);
        let [left, right] = [self.curvature[i], self.curvature[i + 1]];
        let bend = h * h / 6.0;
        let value = a * self.y[i]
            + b * self.y[i + 1]
            + bend * ((a * a * a - a) * left + (b * b * b - b) * right);
        let slope = (self.y[i + 1] - self.y[i]) / h
            + h / 6.0 * ((3.0 * b * b - 1.0) * right - (3.0 * a * a - 1.0) * left);
        [value, slope, a * left + b * right]
    }

    /// The integral from the first point to each point.
    ///
    /// ```
    /// use protomer_kernel::spline::{Ends, Spline};
    /// let x = [0.0, 1.0, 2.0, 4.0];
    /// let spline = Spline::through(&x, &x.map(|x| 3.0 * x * x), Ends::Cubic)?;
    /// assert!((spline.integrals()[3] - 64.0).abs() < 1e-12, "x³ at the last point");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn integrals(&self) -> Vec<f64> {
        let mut integrals = vec![0.0];
        for i in 0..self.x.len() - 1 {
            let h = self.x[i + 1] - self.x[i];
            let trapezium = 0.5 * h * (self.y[i] + self.y[i + 1]);
            let bent = h * h * h * (self.curvature[i] + self.curvature[i + 1]) / 24.0;
            integrals.push(integrals[i] + trapezium - bent);
        }
        integrals
    }
}

fn check(x: &[f64], y: &[f64], fewest: usize) -> Result<()> {
    let refuse = |problem: String| Err(KernelError::BadTable(problem));
    if x.len() != y.len() {
        return refuse(format!(
            "{} abscissas have {} values; give one value for each",
            x.len(),
            y.len()
        ));
    }
    if x.len() < fewest {
        return refuse(format!(
            "a curve needs at least {fewest} points, and the table has {}; add points",
            x.len()
        ));
    }
    if let Some(row) = x.iter().zip(y).position(|(x, y)| !(x + y).is_finite()) {
        return refuse(format!(
            "point {} of the table is not finite; remove it",
            row + 1
        ));
    }
    match x.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(row) => refuse(format!(
            "points {} and {} do not ascend ({} and {}); sort the table, with each abscissa once",
            row + 1,
            row + 2,
            x[row],
            x[row + 1]
        )),
        None => Ok(()),
    }
}

/// Second derivatives at the points, from a tridiagonal system.
fn curvatures(x: &[f64], y: &[f64], ends: Ends) -> Vec<f64> {
    let last = x.len() - 1;
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut curvature = vec![0.0; last + 1];
    let mut above = vec![0.0; last + 1];
    for i in 1..last {
        let (mut before, mut after) = (h[i - 1], h[i]);
        let mut middle = 2.0 * (before + after);
        // The third derivatives of the first two pieces are equal, and those of the last two: this gives the curvature of
        // an end by those of the next two points, and takes it out of the row.
        if ends == Ends::Cubic && i == 1 {
            let ratio = h[0] / h[1];
            middle += before * (1.0 + ratio);
            after -= before * ratio;
        }
        if ends == Ends::Cubic && i == last - 1 {
            let ratio = h[last - 1] / h[last - 2];
            middle += after * (1.0 + ratio);
            before -= after * ratio;
        }
        let mut bend = 6.0 * ((y[i + 1] - y[i]) / h[i] - (y[i] - y[i - 1]) / h[i - 1]);
        // A level end has a curvature that follows from that of the next point, which takes it out of the row.
        if ends == Ends::Level && i == 1 {
            middle -= 0.5 * before;
            bend -= before * level_bend(y[1] - y[0], h[0]);
        }
        if matches!(ends, Ends::Level | Ends::LevelAtLast) && i == last - 1 {
            middle -= 0.5 * after;
            bend -= after * level_bend(y[last - 1] - y[last], h[last - 1]);
        }
        // Elimination downwards; nothing comes from the ends, whose curvature is zero so far.
        let pivot = middle - before * above[i - 1];
        above[i] = after / pivot;
        curvature[i] = (bend - before * curvature[i - 1]) / pivot;
    }
    for i in (1..last).rev() {
        curvature[i] -= above[i] * curvature[i + 1];
    }
    if ends == Ends::Cubic {
        let (start, end) = (h[0] / h[1], h[last - 1] / h[last - 2]);
        curvature[0] = curvature[1] - (curvature[2] - curvature[1]) * start;
        curvature[last] = curvature[last - 1] + (curvature[last - 1] - curvature[last - 2]) * end;
    }
    if ends == Ends::Level {
        curvature[0] = level_bend(y[1] - y[0], h[0]) - 0.5 * curvature[1];
    }
    if matches!(ends, Ends::Level | Ends::LevelAtLast) {
        let bend = level_bend(y[last - 1] - y[last], h[last - 1]);
        curvature[last] = bend - 0.5 * curvature[last - 1];
    }
    curvature
}

/// Curvature of a level end if the next point, by so much higher and so far away, had none.
fn level_bend(rise: f64, distance: f64) -> f64 {
    3.0 * rise / (distance * distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    fn uneven() -> (Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..12)
            .map(|k| f64::from(k) + 0.3 * f64::from(k).sin())
            .collect();
        let y = x.iter().map(|x| (0.7 * x).cos() + 0.05 * x * x).collect();
        (x, y)
    }

    /// The slow twin: all coefficients of all pieces from one dense system of conditions.
    #[test]
    fn pieces_are_those_of_a_dense_system_of_conditions() {
        let (x, y) = uneven();
        let pieces = x.len() - 1;
        let mut conditions = DMatrix::zeros(4 * pieces, 4 * pieces);
        let mut right = DVector::zeros(4 * pieces);
        let mut row = 0;
        let mut add = |entries: &[(usize, f64)], value: f64| {
            for (column, entry) in entries {
                conditions[(row, *column)] += entry;
            }
            right[row] = value;
            row += 1;
        };
        for i in 0..pieces {
            let (c, h) = (4 * i, x[i + 1] - x[i]);
            add(&[(c, 1.0)], y[i]);
            add(
                &[(c, 1.0), (c + 1, h), (c + 2, h * h), (c + 3, h * h * h)],
                y[i + 1],
            );
            if i + 1 < pieces {
                add(
                    &[
                        (c + 1, 1.0),
                        (c + 2, 2.0 * h),
                        (c + 3, 3.0 * h * h),
                        (c + 5, -1.0),
                    ],
                    0.0,
                );
                add(&[(c + 2, 2.0), (c + 3, 6.0 * h), (c + 6, -2.0)], 0.0);
            } else {
                add(&[(c + 2, 2.0), (c + 3, 6.0 * h)], 0.0);
            }
        }
        add(&[(2, 2.0)], 0.0);
        let coefficients = conditions.lu().solve(&right).unwrap();
        let spline = Spline::through(&x, &y, Ends::Straight).unwrap();
        for i in 0..pieces {
            for part in 0..8 {
                let t = (x[i + 1] - x[i]) * f64::from(part) / 8.0;
                let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| coefficients[4 * i + k]);
                let value = c0 + t * (c1 + t * (c2 + t * c3));
                let slope = c1 + t * (2.0 * c2 + 3.0 * t * c3);
                let curvature = 2.0 * c2 + 6.0 * t * c3;
                let found = spline.evaluate(x[i] + t).into_iter();
                for (found, exact) in found.zip([value, slope, curvature]) {
                    assert!((found - exact).abs() < 1e-11, "{found} {exact}");
                }
            }
        }
    }

    #[test]
    fn the_slope_is_the_derivative_also_beyond_the_ends() {
        let (x, y) = uneven();
        let spline = Spline::through(&x, &y, Ends::Straight).unwrap();
        for k in -40..180 {
            let (place, h) = (0.1 * f64::from(k), 1e-5);
            let difference =
                (spline.evaluate(place + h)[0] - spline.evaluate(place - h)[0]) / (2.0 * h);
            assert!(
                (spline.evaluate(place)[1] - difference).abs() < 1e-8,
                "{place}"
            );
        }
        for (place, value) in x.iter().zip(&y) {
            assert!((spline.evaluate(*place)[0] - value).abs() < 1e-13);
        }
    }

    #[test]
    fn level_ends_are_level_and_the_curve_is_smooth_at_its_points() {
        let (x, y) = uneven();
        for (ends, is_level) in [
            (Ends::Level, [true, true]),
            (Ends::LevelAtLast, [false, true]),
        ] {
            let spline = Spline::through(&x, &y, ends).unwrap();
            let h = 1e-6;
            for (place, value) in x.iter().zip(&y) {
                let [left, right] = [-h, h].map(|step| spline.evaluate(place + step));
                assert!((spline.evaluate(*place)[0] - value).abs() < 1e-12);
                assert!((left[1] - right[1]).abs() < 1e-4, "{ends:?} {place}");
            }
            for (end, is_level) in [x[0], x[x.len() - 1]].into_iter().zip(is_level) {
                assert_eq!(
                    spline.evaluate(end)[1].abs() < 1e-12,
                    is_level,
                    "{ends:?} {end}"
                );
            }
            let beyond = spline.evaluate(x[x.len() - 1] + 3.0);
            assert!((beyond[0] - y[y.len() - 1]).abs() < 1e-12 && beyond[1] == 0.0);
        }
        // Two points and a level end: the parabola is not a cubic of this kind, but its slopes are.
        let pair = Spline::through(&[0.0, 1.0], &[1.0, 0.0], Ends::LevelAtLast).unwrap();
        let [value, slope, _] = pair.evaluate(0.5);
        assert!((value - 0.3125).abs() < 1e-12 && (slope + 1.125).abs() < 1e-12);
    }

    #[test]
    fn cubic_functions_are_those_of_cubic_ends() {
        let x = [0.0, 0.1, 0.4, 0.5, 0.9];
        let y = x.map(|x| 1.0 - 2.0 * x + x * x * x);
        let spline = Spline::through(&x, &y, Ends::Cubic).unwrap();
        for (x, found) in x.iter().zip(spline.integrals()) {
            let exact = x - x * x + 0.25 * x * x * x * x;
            assert!((found - exact).abs() < 1e-14, "{x}: {found} {exact}");
        }
        for x in [-0.5, 0.05, 0.3, 0.45, 0.8, 1.5_f64] {
            let exact = [1.0 - 2.0 * x + x * x * x, 3.0 * x * x - 2.0, 6.0 * x];
            for (found, exact) in spline.evaluate(x).into_iter().zip(exact) {
                assert!((found - exact).abs() < 1e-12, "{x}: {found} {exact}");
            }
        }
    }

    #[test]
    fn tables_that_are_none_are_refused() {
        for (x, y, ends, part) in [
            (vec![0.0], vec![1.0], Ends::Straight, "least 2 points"),
            (vec![0.0, 1.0], vec![1.0], Ends::Straight, "one value"),
            (
                vec![0.0, 1.0, 2.0],
                vec![1.0; 3],
                Ends::Cubic,
                "least 4 points",
            ),
            (
                vec![0.0, f64::NAN],
                vec![1.0, 2.0],
                Ends::Straight,
                "point 2",
            ),
            (
                vec![1.0, 0.5],
                vec![1.0, 2.0],
                Ends::Straight,
                "points 1 and 2",
            ),
        ] {
            let message = Spline::through(&x, &y, ends).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
