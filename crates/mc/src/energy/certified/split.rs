//! The kernel in three parts: what happens at short distance, what happens at the cut-off, and the
//! smooth rest.
//!
//! With f(t) = λ_B exp(-κ√t)/√t, t = r², and two Taylor polynomials of f, g about R² (a short
//! distance) and p about r_cut²,
//!
//! ```text
//! f θ(r_cut - r) = (f - g) θ(R - r)  +  [ g θ(R - r) + f θ(r - R) - p ] θ(r_cut - r)  +  p θ(r_cut - r)
//!                  near pairs           smooth: C⁴ at R, C² at r_cut, bounded at 0        the step, times a polynomial
//! ```

use protomer_kernel::potential::Yukawa;

/// Degree of g.
pub(super) const NEAR_DEGREE: usize = 5;
/// Degree of p.
pub(super) const STEP_DEGREE: usize = 2;

/// The parts of one Yukawa potential.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Split {
    /// λ_B, Å.
    pub bjerrum: f64,
    /// κ, 1/Å.
    pub kappa: f64,
    /// r_cut, Å.
    pub cutoff: f64,
    /// R, Å.
    pub near_radius: f64,
    /// g in powers of t - R², kT/e².
    pub near: [f64; NEAR_DEGREE + 1],
    /// p in powers of t - r_cut², kT/e²; zero without a cut-off.
    pub step: [f64; STEP_DEGREE + 1],
}

impl Split {
    pub fn new(yukawa: &Yukawa, near_radius: f64) -> Self {
        let (bjerrum, kappa) = (
            yukawa.bjerrum_length_angstrom,
            yukawa.inverse_debye_length_per_angstrom,
        );
        let cutoff = yukawa.cutoff_angstrom;
        let mut near = taylor::<{ NEAR_DEGREE + 1 }>(kappa, near_radius);
        near.iter_mut().for_each(|c| *c *= bjerrum);
        let mut step = [0.0; STEP_DEGREE + 1];
        if cutoff.is_finite() {
            step = taylor(kappa, cutoff);
            step.iter_mut().for_each(|c| *c *= bjerrum);
        }
        Self {
            bjerrum,
            kappa,
            cutoff,
            near_radius,
            near,
            step,
        }
    }

    /// The smooth part at a squared distance beyond R, continued beyond the cut-off.
    pub fn beyond_near(&self, t: f64) -> f64 {
        let cut_square = self.cutoff * self.cutoff;
        let value = self.bjerrum * (-self.kappa * t.sqrt()).exp() / t.sqrt();
        value
            - if cut_square.is_finite() {
                horner(&self.step, t - cut_square)
            } else {
                0.0
            }
    }

    /// The smooth part's departure from smoothness within `depth` (Å) of R or of the cut-off: the
    /// first term in which the two sides differ there, kT/e². So much of one charge's potential may
    /// hide between samples of that distance.
    pub fn hidden(&self, depth: f64) -> f64 {
        let term = |coefficient: f64, radius: f64, degree: usize| {
            (coefficient * ((2.0 * radius + depth) * depth).powi(degree as i32)).abs()
        };
        let near = taylor::<{ NEAR_DEGREE + 2 }>(self.kappa, self.near_radius)[NEAR_DEGREE + 1];
        let mut sum = term(near, self.near_radius, NEAR_DEGREE + 1);
        if self.cutoff.is_finite() {
            let step = taylor::<{ STEP_DEGREE + 2 }>(self.kappa, self.cutoff)[STEP_DEGREE + 1];
            sum += term(step, self.cutoff, STEP_DEGREE + 1);
        }
        self.bjerrum * sum
    }

    /// The smooth part at a squared distance.
    pub fn smooth(&self, t: f64) -> f64 {
        let (near_square, cut_square) = (
            self.near_radius * self.near_radius,
            self.cutoff * self.cutoff,
        );
        if t >= cut_square {
            return 0.0;
        }
        let value = if t < near_square {
            horner(&self.near, t - near_square)
        } else {
            self.bjerrum * (-self.kappa * t.sqrt()).exp() / t.sqrt()
        };
        value
            - if cut_square.is_finite() {
                horner(&self.step, t - cut_square)
            } else {
                0.0
            }
    }
}

#[inline(always)]
fn horner<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let mut value = coefficients[N - 1];
    for degree in (0..N - 1).rev() {
        value = value * x + coefficients[degree];
    }
    value
}

/// Taylor coefficients of exp(-κ√t)/√t in powers of t - r². The derivatives are f⁽ⁿ⁾ = (-1/2)ⁿ
/// exp(-κr) θ_n(κr)/r²ⁿ⁺¹ with the reverse Bessel polynomials θ_n = (2n-1) θ_(n-1) + x² θ_(n-2).
fn taylor<const N: usize>(kappa: f64, r: f64) -> [f64; N] {
    let x = kappa * r;
    let (mut before, mut theta, mut scale) = (1.0, 1.0, (-x).exp() / r);
    let mut coefficients = [0.0; N];
    for (n, coefficient) in coefficients.iter_mut().enumerate() {
        match n {
            0 => {}
            1 => theta = x + 1.0,
            _ => (before, theta) = (theta, (2 * n - 1) as f64 * theta + x * x * before),
        }
        if n > 0 {
            scale *= -0.5 / (r * r * n as f64);
        }
        *coefficient = scale * theta;
    }
    coefficients
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomials_touch_the_kernel_where_they_should() {
        for (debye, cutoff) in [(9.6, 48.0), (30.0, 150.0), (f64::INFINITY, 60.0)] {
            let yukawa = Yukawa::new(7.0, 1.0 / debye, cutoff).unwrap();
            let split = Split::new(&yukawa, 10.0);
            let f = |r: f64| 7.0 * (-r / debye).exp() / r;
            for h in [-1e-2, 1e-2f64] {
                let r = cutoff + h;
                assert!((horner(&split.step, r * r - cutoff * cutoff) / f(r) - 1.0).abs() < 3e-9);
                let r = 10.0 + h;
                assert!((horner(&split.near, r * r - 100.0) / f(r) - 1.0).abs() < 1e-12);
            }
            // The smooth part is continuous at R and vanishes at the cut-off.
            let smooth = |r: f64| split.smooth(r * r);
            assert!((smooth(10.0 - 1e-9) - smooth(10.0 + 1e-9)).abs() < 1e-9);
            assert!(smooth(cutoff - 1e-3).abs() < 1e-12 && smooth(cutoff + 1e-3) == 0.0);
        }
    }
}
