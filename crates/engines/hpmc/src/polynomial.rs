//! Polynomials fitted to measured values, as smooth as the errors of the values allow.

use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};
use protomer_kernel::jet::Jet;

/// No polynomial of a higher degree is tried.
const HIGHEST_DEGREE: usize = 8;
/// χ² may exceed its mean, the degrees of freedom, by this many of its standard deviations.
const MOST_DEVIATIONS: f64 = 1.0;
/// Singular values below this part of the largest count as zero.
const LEAST_SINGULAR_VALUE: f64 = 1e-12;

/// A measured value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Abscissa at which the value was measured.
    pub x: f64,
    /// The value.
    pub value: f64,
    /// Standard error of the value, above zero.
    pub standard_error: f64,
}

/// A polynomial in t = (x - middle) / half width, which is between -1 and 1 where it was fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    middle: f64,
    half_width: f64,
    /// Coefficients of the powers of t, ascending.
    coefficients: Vec<f64>,
}

impl Polynomial {
    /// The polynomial of the lowest degree whose χ² is not above what errors alone explain:
    /// χ² ≤ ν + √(2ν), with ν the number of values less that of the coefficients. If there is none, it
    /// goes through all values or has the highest degree that is tried.
    ///
    /// ```
    /// use protomer_hpmc::polynomial::{Measured, Polynomial};
    ///
    /// let values = [0.1_f64, 0.2, 0.3, 0.4, 0.5, 0.6].map(|x| Measured {
    ///     x,
    ///     value: 1.0 - x * x,
    ///     standard_error: 1e-6,
    /// });
    /// let parabola = Polynomial::as_smooth_as(&values)?;
    /// assert_eq!(parabola.degree(), 2);
    /// assert!((parabola.value(0.25) - 0.9375).abs() < 1e-9);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// Without values, or for an error that is not above zero.
    pub fn as_smooth_as(values: &[Measured]) -> Result<Self> {
        let highest = HIGHEST_DEGREE.min(values.len().saturating_sub(1));
        let mut degree = 0;
        loop {
            let fitted = Self::of_degree(values, degree)?;
            let freedom = values.len() as f64 - degree as f64 - 1.0;
            let most = freedom + MOST_DEVIATIONS * (2.0 * freedom).sqrt();
            if degree == highest || fitted.chi_square(values) <= most {
                return Ok(fitted);
            }
            degree += 1;
        }
    }

    /// The polynomial of this degree with the least χ².
    ///
    /// ```
    /// use protomer_hpmc::polynomial::{Measured, Polynomial};
    /// let measured = |x, value| Measured { x, value, standard_error: 0.1 };
    /// let line = Polynomial::of_degree(&[measured(0.0, 1.0), measured(2.0, 5.0)], 1)?;
    /// assert!((line.value(1.0) - 3.0).abs() < 1e-12);
    /// assert!(Polynomial::of_degree(&[measured(0.0, 1.0)], 1).is_err());
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    ///
    /// # Errors
    /// With fewer values than coefficients, and for an error that is not above zero.
    pub fn of_degree(values: &[Measured], degree: usize) -> Result<Self> {
        if values.len() <= degree {
            return Err(Error::FewPoints {
                given: values.len(),
                fewest: degree + 1,
            });
        }
        for measured in values {
            crate::error::require(
                "the standard error of a value",
                measured.standard_error,
                "above zero",
                measured.standard_error > 0.0,
            )?;
        }
        let low = values.iter().fold(f64::INFINITY, |low, v| low.min(v.x));
        let high = values
            .iter()
            .fold(f64::NEG_INFINITY, |high, v| high.max(v.x));
        let empty = Self {
            middle: 0.5 * (low + high),
            half_width: (0.5 * (high - low)).max(f64::MIN_POSITIVE),
            coefficients: Vec::new(),
        };
        let design = DMatrix::from_fn(values.len(), degree + 1, |row, power| {
            empty.scaled(values[row].x).powi(power as i32) / values[row].standard_error
        });
        let right = DVector::from_iterator(
            values.len(),
            values.iter().map(|v| v.value / v.standard_error),
        );
        let singular = design.svd(true, true);
        let least = LEAST_SINGULAR_VALUE * singular.singular_values.max();
        let solution = singular.solve(&right, least);
        // Both sets of singular vectors are there, so there is a solution.
        let coefficients = solution.map(|c| c.iter().copied().collect());
        Ok(Self {
            coefficients: coefficients.unwrap_or_default(),
            ..empty
        })
    }

    fn scaled(&self, x: f64) -> f64 {
        (x - self.middle) / self.half_width
    }

    /// Σ (value - polynomial)² / error².
    ///
    /// ```
    /// use protomer_hpmc::polynomial::{Measured, Polynomial};
    /// let values = [1.0, 3.0].map(|value| Measured { x: 0.0, value, standard_error: 0.5 });
    /// let mean = Polynomial::of_degree(&values, 0)?;
    /// assert!((mean.chi_square(&values) - 8.0).abs() < 1e-12, "each is two errors off");
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn chi_square(&self, values: &[Measured]) -> f64 {
        let residual = |v: &Measured| (v.value - self.value(v.x)) / v.standard_error;
        values.iter().map(|v| residual(v).powi(2)).sum()
    }

    /// The highest power.
    pub fn degree(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    /// The value.
    pub fn value(&self, x: f64) -> f64 {
        self.evaluate(Jet::constant(x)).value
    }

    /// The value with its derivatives.
    ///
    /// ```
    /// use protomer_hpmc::polynomial::{Measured, Polynomial};
    /// use protomer_kernel::jet::Jet;
    /// let values = [0.0, 1.0, 2.0].map(|x| Measured { x, value: x * x, standard_error: 0.1 });
    /// let slope = Polynomial::of_degree(&values, 2)?.evaluate(Jet::variable(3.0, 0)).first();
    /// assert!((slope - 6.0).abs() < 1e-9);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    pub fn evaluate(&self, x: Jet) -> Jet {
        let t = (x + -self.middle) * self.half_width.recip();
        let powers = self.coefficients.iter().rev();
        powers.fold(Jet::<1>::constant(0.0), |sum, c| sum * t + *c)
    }

    /// The polynomial times x, plus a constant.
    ///
    /// ```
    /// use protomer_hpmc::polynomial::{Measured, Polynomial};
    /// let values = [0.0, 1.0].map(|x| Measured { x, value: 2.0 + x, standard_error: 0.1 });
    /// let line = Polynomial::of_degree(&values, 1)?;
    /// assert!((line.times_x_plus(1.0).value(3.0) - (5.0 * 3.0 + 1.0)).abs() < 1e-9);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    #[must_use]
    pub fn times_x_plus(&self, constant: f64) -> Self {
        let mut coefficients = vec![0.0; self.coefficients.len() + 1];
        for (power, c) in self.coefficients.iter().enumerate() {
            coefficients[power] += self.middle * c;
            coefficients[power + 1] += self.half_width * c;
        }
        coefficients[0] += constant;
        Self {
            coefficients,
            ..*self
        }
    }

    /// The antiderivative that has this value at `x`.
    ///
    /// ```
    /// use protomer_hpmc::polynomial::{Measured, Polynomial};
    /// let values = [0.0, 1.0].map(|x| Measured { x, value: 2.0 * x, standard_error: 0.1 });
    /// let square = Polynomial::of_degree(&values, 1)?.integral(0.0, 5.0);
    /// assert!((square.value(3.0) - (5.0 + 9.0)).abs() < 1e-9);
    /// # Ok::<(), protomer_hpmc::Error>(())
    /// ```
    #[must_use]
    pub fn integral(&self, x: f64, value: f64) -> Self {
        let mut coefficients = vec![0.0];
        for (power, c) in self.coefficients.iter().enumerate() {
            coefficients.push(self.half_width * c / (power as f64 + 1.0));
        }
        let mut integral = Self {
            coefficients,
            ..*self
        };
        integral.coefficients[0] = value - integral.value(x);
        integral
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    fn measured(rng: &mut CounterRng, standard_error: f64) -> Vec<Measured> {
        let x = (1..=12).map(|n| 0.05 * f64::from(n));
        x.map(|x| Measured {
            x,
            value: 2.0 - x + 3.0 * x.powi(3) + standard_error * rng.normal(),
            standard_error,
        })
        .collect()
    }

    /// The normal equations, solved by elimination, are the slow twin.
    #[test]
    fn least_squares_solve_the_normal_equations() {
        let values = measured(&mut CounterRng::new(1, 0, 0), 0.01);
        let fitted = Polynomial::of_degree(&values, 3).unwrap();
        let rows = DMatrix::from_fn(values.len(), 4, |row, power| {
            values[row].x.powi(power as i32)
        });
        let right = DVector::from_iterator(values.len(), values.iter().map(|v| v.value));
        let solved = (rows.transpose() * &rows)
            .lu()
            .solve(&(rows.transpose() * right));
        for x in [0.05, 0.2, 0.55_f64] {
            let expected: f64 = (0..4)
                .map(|n| solved.as_ref().unwrap()[n] * x.powi(n as i32))
                .sum();
            assert!((fitted.value(x) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn errors_decide_how_smooth_it_is() {
        let mut rng = CounterRng::new(2, 0, 0);
        let degree = |values: &[Measured]| Polynomial::as_smooth_as(values).unwrap().degree();
        assert_eq!(degree(&measured(&mut rng, 1e-5)), 3);
        assert!(degree(&measured(&mut rng, 0.05)) < 3);
        let two = [0.0, 1.0].map(|x| Measured {
            x,
            value: x,
            standard_error: 1e-9,
        });
        assert_eq!(degree(&two), 1);
        assert!(Polynomial::as_smooth_as(&[]).is_err());
        assert!(
            Polynomial::of_degree(
                &[Measured {
                    x: 0.0,
                    value: 0.0,
                    standard_error: 0.0
                }],
                0
            )
            .is_err()
        );
    }

    #[test]
    fn polynomials_are_multiplied_and_integrated_exactly() {
        let line = [0.2, 0.6].map(|x| Measured {
            x,
            value: 3.0 - 2.0 * x,
            standard_error: 1.0,
        });
        let line = Polynomial::of_degree(&line, 1).unwrap();
        let parabola = line.times_x_plus(5.0);
        let integral = parabola.integral(0.1, 7.0);
        for x in [0.0, 0.3, 0.9_f64] {
            assert!((parabola.value(x) - (5.0 + 3.0 * x - 2.0 * x * x)).abs() < 1e-12);
            let from = |x: f64| 5.0 * x + 1.5 * x * x - 2.0 / 3.0 * x.powi(3);
            assert!((integral.value(x) - (7.0 + from(x) - from(0.1))).abs() < 1e-12);
            let jet = integral.evaluate(Jet::variable(x, 0));
            assert!((jet.first() - parabola.value(x)).abs() < 1e-12);
        }
    }
}
