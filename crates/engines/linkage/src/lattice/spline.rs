//! A potential given at points: a natural cubic spline, and its exact derivative.
//!
//! Between two points the potential is a cubic; value, slope and curvature are continuous. The
//! curvature is zero at both ends, and beyond them the potential goes on as a straight line, so that
//! it has two continuous derivatives everywhere and a Störmer-Verlet step keeps its order.

use crate::error::{CrystalError, Result};

/// A natural cubic spline through points.
///
/// ```
/// use protomer_linkage::lattice::Spline;
/// let spline = Spline::through(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0])?;
/// assert_eq!(spline.evaluate(1.0), [1.0, 0.0]);
/// // Straight beyond the last point.
/// assert!((spline.evaluate(3.0)[0] + 1.5).abs() < 1e-12);
/// assert!(Spline::through(&[0.0, 0.0], &[1.0, 2.0]).is_err());
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the points.
    curvature: Vec<f64>,
}

impl Spline {
    /// The spline through two or more points, in the order of ascending x.
    ///
    /// # Errors
    /// [`CrystalError::BadTable`] says which points are missing, not finite or out of order.
    pub fn through(x: &[f64], y: &[f64]) -> Result<Self> {
        check(x, y)?;
        Ok(Self {
            x: x.to_vec(),
            y: y.to_vec(),
            curvature: curvatures(x, y),
        })
    }

    /// First and last abscissa.
    pub fn range(&self) -> [f64; 2] {
        [self.x[0], self.x[self.x.len() - 1]]
    }

    /// Value and slope at this abscissa.
    pub fn evaluate(&self, x: f64) -> [f64; 2] {
        let [first, last] = self.range();
        if x < first || x > last {
            let end = if x < first { first } else { last };
            let [value, slope] = self.inside(end);
            return [value + slope * (x - end), slope];
        }
        self.inside(x)
    }

    fn inside(&self, x: f64) -> [f64; 2] {
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
        [value, slope]
    }
}

fn check(x: &[f64], y: &[f64]) -> Result<()> {
    let refuse = |problem: String| Err(CrystalError::BadTable(problem));
    if x.len() != y.len() || x.len() < 2 {
        return refuse(format!(
            "{} angles and {} energies are no table; give two points or more, each with an angle \
             and an energy",
            x.len(),
            y.len()
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
            "the angles of points {} and {} do not ascend ({} and {}); sort the table, with each \
             angle once",
            row + 1,
            row + 2,
            x[row],
            x[row + 1]
        )),
        None => Ok(()),
    }
}

/// Second derivatives at the points: a tridiagonal system, with zero at both ends.
fn curvatures(x: &[f64], y: &[f64]) -> Vec<f64> {
    let last = x.len() - 1;
    let mut curvature = vec![0.0; last + 1];
    let mut above = vec![0.0; last + 1];
    for i in 1..last {
        let (before, after) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let bend = 6.0 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before);
        // Elimination downwards; nothing comes from the end, whose curvature is zero.
        let pivot = 2.0 * (before + after) - before * above[i - 1];
        above[i] = after / pivot;
        curvature[i] = (bend - before * curvature[i - 1]) / pivot;
    }
    for i in (1..last).rev() {
        curvature[i] -= above[i] * curvature[i + 1];
    }
    curvature
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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
        let spline = Spline::through(&x, &y).unwrap();
        for i in 0..pieces {
            for part in 0..8 {
                let t = (x[i + 1] - x[i]) * f64::from(part) / 8.0;
                let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| coefficients[4 * i + k]);
                let value = c0 + t * (c1 + t * (c2 + t * c3));
                let slope = c1 + t * (2.0 * c2 + 3.0 * t * c3);
                let at_place = spline.evaluate(x[i] + t);
                assert!((at_place[0] - value).abs() < 1e-11 && (at_place[1] - slope).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn the_slope_is_the_derivative_also_beyond_the_ends() {
        let (x, y) = uneven();
        let spline = Spline::through(&x, &y).unwrap();
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
    fn tables_that_are_none_are_refused() {
        for (x, y, part) in [
            (vec![0.0], vec![1.0], "no table"),
            (vec![0.0, 1.0], vec![1.0], "no table"),
            (vec![0.0, f64::NAN], vec![1.0, 2.0], "point 2"),
            (vec![1.0, 0.5], vec![1.0, 2.0], "points 1 and 2"),
        ] {
            let message = Spline::through(&x, &y).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
