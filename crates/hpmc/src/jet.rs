//! Numbers that carry their first and second derivative with respect to one variable.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with two derivatives.
///
/// ```
/// use protomer_hpmc::jet::Jet;
/// let x = Jet::variable(2.0);
/// let f = x * x * x - x.ln();
/// assert!((f.first - (12.0 - 0.5)).abs() < 1e-14 && (f.second - (12.0 + 0.25)).abs() < 1e-14);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet {
    /// The value.
    pub value: f64,
    /// The first derivative.
    pub first: f64,
    /// The second derivative.
    pub second: f64,
}

impl Jet {
    /// The variable itself.
    pub fn variable(value: f64) -> Self {
        Self {
            value,
            first: 1.0,
            second: 0.0,
        }
    }

    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self {
            value,
            first: 0.0,
            second: 0.0,
        }
    }

    /// A function of this number, from its value and two derivatives there.
    fn chain(self, value: f64, first: f64, second: f64) -> Self {
        Self {
            value,
            first: first * self.first,
            second: second * self.first * self.first + first * self.second,
        }
    }

    /// The natural logarithm.
    #[must_use]
    pub fn ln(self) -> Self {
        let inverse = self.value.recip();
        self.chain(self.value.ln(), inverse, -inverse * inverse)
    }

    /// ln(1 + x), accurate for small x.
    #[must_use]
    pub fn ln_1p(self) -> Self {
        let inverse = (1.0 + self.value).recip();
        self.chain(self.value.ln_1p(), inverse, -inverse * inverse)
    }

    /// eˣ - 1, accurate for small x.
    #[must_use]
    pub fn exp_m1(self) -> Self {
        let exponential = self.value.exp();
        self.chain(self.value.exp_m1(), exponential, exponential)
    }

    /// One over the number.
    #[must_use]
    pub fn recip(self) -> Self {
        let inverse = self.value.recip();
        self.chain(
            inverse,
            -inverse * inverse,
            2.0 * inverse * inverse * inverse,
        )
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }
}

impl Neg for Jet {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value
                + 2.0 * self.first * other.first
                + self.value * other.second,
        }
    }
}

impl Div for Jet {
    type Output = Self;

    #[allow(
        clippy::suspicious_arithmetic_impl,
        reason = "that is what division is"
    )]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl Add<f64> for Jet {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        self + Self::constant(other)
    }
}

impl Sub<f64> for Jet {
    type Output = Self;

    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl Mul<f64> for Jet {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            first: self.first * factor,
            second: self.second * factor,
        }
    }
}
