//! Numbers that carry their first and second derivatives.
//!
//! A [`Jet`] of N variables holds f, ∂f/∂x_i and ∂²f/∂x_i∂x_j; arithmetic follows the rules of
//! differentiation, so a formula written once gives its exact gradient and Hessian (forward
//! differentiation of second order; Griewank and Walther, *Evaluating Derivatives*, SIAM 2008).

use std::ops::{Add, Mul, Neg, Sub};

/// A value with its gradient and Hessian over N variables.
///
/// ```
/// use protomer_crystal::framework::jet::Jet;
/// let (x, y) = (Jet::<2>::variable(3.0, 0), Jet::<2>::variable(4.0, 1));
/// let length = (x.square() + y.square()).sqrt();
/// assert_eq!(length.value, 5.0);
/// assert!((length.gradient[0] - 0.6).abs() < 1e-15);
/// assert!((length.hessian[0][1] + 12.0 / 125.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const N: usize> {
    /// f.
    pub value: f64,
    /// ∂f/∂x_i.
    pub gradient: [f64; N],
    /// ∂²f/∂x_i∂x_j.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
        }
    }

    /// The variable of this index.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut jet = Self::constant(value);
        jet.gradient[index] = 1.0;
        jet
    }

    /// g(f) from g, g' and g'' at f.
    pub fn chain(&self, value: f64, first: f64, second: f64) -> Self {
        let mut jet = Self::constant(value);
        for i in 0..N {
            jet.gradient[i] = first * self.gradient[i];
            for j in 0..N {
                jet.hessian[i][j] =
                    first * self.hessian[i][j] + second * self.gradient[i] * self.gradient[j];
            }
        }
        jet
    }

    /// √f.
    pub fn sqrt(&self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }

    /// 1/f.
    pub fn recip(&self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(
            inverse,
            -inverse * inverse,
            2.0 * inverse * inverse * inverse,
        )
    }

    /// f².
    pub fn square(&self) -> Self {
        *self * *self
    }

    /// The angle of the vector (x, y), in (-π, π]; derivatives ∂θ = (x ∂y - y ∂x)/(x² + y²).
    pub fn atan2(y: &Self, x: &Self) -> Self {
        let square = x.value * x.value + y.value * y.value;
        let (tx, ty) = (-y.value / square, x.value / square);
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
    pub fn arcsine_of_root_squared(&self) -> Self {
        let z = self.value;
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
        self + other * -1.0
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

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor, 0.0)
    }
}

// The product rule adds.
#[allow(clippy::suspicious_arithmetic_impl)]
impl<const N: usize> Mul for Jet<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (a, b) = (self.value, other.value);
        let mut jet = Self::constant(a * b);
        for i in 0..N {
            jet.gradient[i] = a * other.gradient[i] + b * self.gradient[i];
            for j in 0..N {
                jet.hessian[i][j] = a * other.hessian[i][j]
                    + b * self.hessian[i][j]
                    + self.gradient[i] * other.gradient[j]
                    + other.gradient[i] * self.gradient[j];
            }
        }
        jet
    }
}

/// The scalar product.
pub fn dot<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> Jet<N> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
pub fn cross<const N: usize>(a: &[Jet<N>; 3], b: &[Jet<N>; 3]) -> [Jet<N>; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
