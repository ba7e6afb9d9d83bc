//! Numbers that carry their first and second derivatives.
//!
//! A [`Jet`] of N variables holds f, ∂f/∂x_i and ∂²f/∂x_i∂x_j; arithmetic follows the rules of
//! differentiation, so a formula written once gives its exact gradient and Hessian (forward
//! differentiation of second order; Griewank and Walther, *Evaluating Derivatives*, SIAM 2008).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with its gradient and Hessian over N variables; over one, if no number is given.
///
/// ```
/// use protomer_kernel::jet::Jet;
/// let (x, y) = (Jet::<2>::variable(3.0, 0), Jet::<2>::variable(4.0, 1));
/// let length = (x.square() + y.square()).sqrt();
/// assert_eq!(length.value, 5.0);
/// assert!((length.gradient[0] - 0.6).abs() < 1e-15);
/// assert!((length.hessian[0][1] + 12.0 / 125.0).abs() < 1e-15);
///
/// let x = Jet::<1>::variable(2.0, 0);
/// let f = x * x * x - x.ln();
/// assert!((f.first() - (12.0 - 0.5)).abs() < 1e-14 && (f.second() - (12.0 + 0.25)).abs() < 1e-14);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const N: usize = 1> {
    /// f.
    pub value: f64,
    /// ∂f/∂x_i.
    pub gradient: [f64; N],
    /// ∂²f/∂x_i∂x_j.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// A constant.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let x = Jet::<1>::variable(3.0, 0);
    /// let product = x * Jet::constant(2.0);
    /// assert_eq!((product.value, product.first()), (6.0, 2.0));
    /// ```
    pub fn constant(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
        }
    }

    /// The variable of this index.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let (x, y) = (Jet::<2>::variable(3.0, 0), Jet::<2>::variable(5.0, 1));
    /// assert_eq!((x * y).gradient, [5.0, 3.0]);
    /// ```
    pub fn variable(value: f64, index: usize) -> Self {
        let mut jet = Self::constant(value);
        jet.gradient[index] = 1.0;
        jet
    }

    /// g(f) from g, g' and g'' at f.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// // sin(2x) at x = 0 has the slope 2.
    /// let argument = Jet::<1>::variable(0.0, 0) * 2.0;
    /// let (sine, cosine) = argument.value.sin_cos();
    /// assert_eq!(argument.chain(sine, cosine, -sine).first(), 2.0);
    /// ```
    pub fn chain(&self, value: f64, first: f64, second: f64) -> Self {
        let mut jet = Self::constant(value);
        for i in 0..N {
            jet.gradient[i] = first * self.gradient[i];
            for j in 0..N {
                // g'(f) f_ij + g''(f) f_i f_j.
                jet.hessian[i][j] =
                    first * self.hessian[i][j] + second * self.gradient[i] * self.gradient[j];
            }
        }
        jet
    }

    /// √f.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let root = Jet::<1>::variable(4.0, 0).sqrt();
    /// assert_eq!((root.value, root.first(), root.second()), (2.0, 0.25, -1.0 / 32.0));
    /// ```
    pub fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }

    /// ln f.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let logarithm = Jet::<1>::variable(2.0, 0).ln();
    /// assert_eq!((logarithm.first(), logarithm.second()), (0.5, -0.25));
    /// ```
    pub fn ln(&self) -> Self {
        let inverse = self.value.recip();
        self.chain(self.value.ln(), inverse, -inverse * inverse)
    }

    /// ln(1 + f), accurate for small f.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let small = Jet::<1>::variable(1e-18, 0);
    /// assert_eq!(small.ln_1p().value, 1e-18, "ln(1.0 + 1e-18) would be zero");
    /// assert_eq!((small.ln_1p().first(), small.ln_1p().second()), (1.0, -1.0));
    /// ```
    pub fn ln_1p(&self) -> Self {
        let inverse = (1.0 + self.value).recip();
        self.chain(self.value.ln_1p(), inverse, -inverse * inverse)
    }

    /// exp(f) - 1, accurate for small f.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let small = Jet::<1>::variable(1e-18, 0).exp_m1();
    /// assert_eq!((small.value, small.first(), small.second()), (1e-18, 1.0, 1.0));
    /// ```
    pub fn exp_m1(&self) -> Self {
        let exponential = self.value.exp();
        self.chain(self.value.exp_m1(), exponential, exponential)
    }

    /// 1/f.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let inverse = Jet::<1>::variable(2.0, 0).recip();
    /// assert_eq!((inverse.value, inverse.first(), inverse.second()), (0.5, -0.25, 0.25));
    /// ```
    pub fn recip(&self) -> Self {
        let inverse = self.value.recip();
        self.chain(
            inverse,
            -inverse * inverse,
            2.0 * inverse * inverse * inverse,
        )
    }

    /// f².
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let square = Jet::<1>::variable(3.0, 0).square();
    /// assert_eq!((square.value, square.first(), square.second()), (9.0, 6.0, 2.0));
    /// ```
    pub fn square(&self) -> Self {
        *self * *self
    }

    /// The angle of the vector (x, y), in (-π, π]; derivatives ∂θ = (x ∂y - y ∂x)/(x² + y²).
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let (x, y) = (Jet::<2>::variable(2.0, 0), Jet::<2>::variable(0.0, 1));
    /// assert_eq!(Jet::atan2(&y, &x).gradient, [0.0, 0.5]);
    /// ```
    pub fn atan2(y: &Self, x: &Self) -> Self {
        let square = x.value * x.value + y.value * y.value;
        let (tx, ty) = (-y.value / square, x.value / square);
        // Second derivatives of the angle: θ_xx = -θ_yy = -2 t_x t_y, θ_xy = t_x² - t_y².
        let (xx, xy) = (-2.0 * tx * ty, tx * tx - ty * ty);
        let mut angle = Self::constant(y.value.atan2(x.value));
        for i in 0..N {
            angle.gradient[i] = tx * x.gradient[i] + ty * y.gradient[i];
            for j in 0..N {
                angle.hessian[i][j] = tx * x.hessian[i][j]
                    + ty * y.hessian[i][j]
                    + xx * (x.gradient[i] * x.gradient[j] - y.gradient[i] * y.gradient[j])
                    + xy * (x.gradient[i] * y.gradient[j] + y.gradient[i] * x.gradient[j]);
            }
        }
        angle
    }

    /// (arcsin √f)² for 0 ≤ f < 1, smooth at zero.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let arc = Jet::<1>::variable(0.25, 0).arcsine_of_root_squared();
    /// let thirty_degrees = std::f64::consts::PI / 6.0;
    /// assert!((arc.value - thirty_degrees * thirty_degrees).abs() < 1e-15);
    /// ```
    pub fn arcsine_of_root_squared(&self) -> Self {
        let z = self.value;
        // Near zero the closed form cancels, and at zero it is 0/0.
        if z < 1e-4 {
            // z + z²/3 + 8 z³/45 + 4 z⁴/35
            let value = z * (1.0 + z * (1.0 / 3.0 + z * (8.0 / 45.0 + z * 4.0 / 35.0)));
            let first = 1.0 + z * (2.0 / 3.0 + z * (8.0 / 15.0 + z * 16.0 / 35.0));
            let second = 2.0 / 3.0 + z * (16.0 / 15.0 + z * 48.0 / 35.0);
            return self.chain(value, first, second);
        }
        let (arc, product) = (z.sqrt().asin(), z * (1.0 - z));
        let first = arc / product.sqrt();
        let second = (1.0 - (1.0 - 2.0 * z) * first) / (2.0 * product);
        self.chain(arc * arc, first, second)
    }
}

impl Jet {
    /// df/dx over the only variable.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let x = Jet::<1>::variable(3.0, 0);
    /// assert_eq!((x * x * x).first(), 27.0, "3 x²");
    /// ```
    pub fn first(&self) -> f64 {
        self.gradient[0]
    }

    /// d²f/dx² over the only variable.
    ///
    /// ```
    /// use protomer_kernel::jet::Jet;
    /// let x = Jet::<1>::variable(3.0, 0);
    /// assert_eq!((x * x * x).second(), 18.0, "6 x");
    /// ```
    pub fn second(&self) -> f64 {
        self.hessian[0][0]
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let mut jet = Self::constant(self.value + other.value);
        for i in 0..N {
            jet.gradient[i] = self.gradient[i] + other.gradient[i];
            for j in 0..N {
                jet.hessian[i][j] = self.hessian[i][j] + other.hessian[i][j];
            }
        }
        jet
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self {
            value: self.value + other,
            ..self
        }
    }
}

impl<const N: usize> Sub<f64> for Jet<N> {
    type Output = Self;

    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        let mut jet = Self::constant(self.value * factor);
        for i in 0..N {
            jet.gradient[i] = self.gradient[i] * factor;
            for j in 0..N {
                jet.hessian[i][j] = self.hessian[i][j] * factor;
            }
        }
        jet
    }
}

/// The product rule. The two mixed terms are added first, so that a product of symmetric Hessians is
/// symmetric to the last bit.
impl<const N: usize> Mul for Jet<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        let mut jet = Self::constant(a * b);
        for i in 0..N {
            jet.gradient[i] = a * other.gradient[i] + b * self.gradient[i];
            for j in 0..N {
                let mixed =
                    self.gradient[i] * other.gradient[j] + other.gradient[i] * self.gradient[j];
                jet.hessian[i][j] = b * self.hessian[i][j] + mixed + a * other.hessian[i][j];
            }
        }
        jet
    }
}

impl<const N: usize> Div for Jet<N> {
    type Output = Self;

    #[allow(
        clippy::suspicious_arithmetic_impl,
        reason = "that is what division is"
    )]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

/// The scalar product.
///
/// ```
/// use protomer_kernel::jet::{Jet, dot};
/// let a: [Jet<3>; 3] = std::array::from_fn(|axis| Jet::variable(axis as f64, axis));
/// let square = dot(&a, &a);
/// assert_eq!((square.value, square.gradient), (5.0, [0.0, 2.0, 4.0]));
/// ```
pub fn dot<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> Jet<N> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
///
/// ```
/// use protomer_kernel::jet::{Jet, cross};
/// let vector = |numbers: [f64; 3]| numbers.map(Jet::<1>::constant);
/// let z = cross(&vector([1.0, 0.0, 0.0]), &vector([0.0, 1.0, 0.0]));
/// assert_eq!(z.map(|component| component.value), [0.0, 0.0, 1.0]);
/// ```
pub fn cross<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> [Jet<N>; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives of a function of one variable from values at equal distances on both sides.
    fn differences(function: impl Fn(Jet) -> Jet, x: f64) -> [f64; 2] {
        const STEP: f64 = 1e-4;
        let value = |x: f64| function(Jet::constant(x)).value;
        let (below, middle, above) = (value(x - STEP), value(x), value(x + STEP));
        [
            (above - below) / (2.0 * STEP),
            (above - 2.0 * middle + below) / (STEP * STEP),
        ]
    }

    #[test]
    fn functions_of_one_variable_have_the_derivatives_of_differences() {
        let functions: [fn(Jet) -> Jet; 7] = [
            |x| x.ln(),
            |x| (x * 0.5).ln_1p(),
            |x| (-x).exp_m1(),
            |x| x.recip(),
            |x| x.sqrt() * x,
            |x| (x.square() - 1.0) / (x + 2.0),
            |x| (x * 0.3).arcsine_of_root_squared(),
        ];
        for (number, function) in functions.into_iter().enumerate() {
            for x in [0.4, 1.0, 2.3] {
                let jet = function(Jet::variable(x, 0));
                let [first, second] = differences(function, x);
                assert!((jet.first() - first).abs() < 1e-6, "{number} {x}: {first}");
                assert!(
                    (jet.second() - second).abs() < 1e-5,
                    "{number} {x}: {second}"
                );
            }
        }
    }

    #[test]
    fn products_have_hessians_that_are_symmetric_to_the_last_bit() {
        let vectors = [[0.3, -1.7, 0.9], [1.1, 0.2, -0.6]];
        let [a, b] = [0, 1].map(|index: usize| {
            [0, 1, 2].map(|axis| Jet::<6>::variable(vectors[index][axis], 3 * index + axis))
        });
        let normal = cross(&a, &b);
        let product = dot(&normal, &normal) * (normal[0] - a[1] * 0.7);
        for i in 0..6 {
            for j in 0..i {
                assert_eq!(product.hessian[i][j], product.hessian[j][i], "{i} {j}");
            }
        }
    }
}
