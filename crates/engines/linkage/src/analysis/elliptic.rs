//! Elliptic integrals of the second kind.
//!
//! Carlson's symmetric integrals (Numer. Math. 33, 1 (1979)) converge by duplication for any
//! argument, however negative the parameter.

use std::f64::consts::{FRAC_PI_2, PI};

/// Duplications after which an argument makes no sense.
const MOST_ITERATIONS: usize = 100;

/// The incomplete elliptic integral of the second kind, E(φ | m) = ∫₀^φ √(1 - m sin²φ') dφ', for
/// any φ and any m ≤ 1, however negative; NaN where the root is not real.
///
/// For |φ| ≤ π/2, with s = sin φ: E = s R_F(1 - s², 1 - m s², 1) - (m/3) s³ R_D(1 - s², 1 - m s²,
/// 1); other φ by E(φ + kπ) = E(φ) + 2k E(π/2).
///
/// ```
/// use protomer_linkage::analysis::elliptic::elliptic_e;
/// assert!((elliptic_e(0.7, 1.0) - 0.7f64.sin()).abs() < 1e-15);
/// ```
pub fn elliptic_e(phi: f64, m: f64) -> f64 {
    let turns = (phi / PI).round();
    let remainder = within_quarter_turn(phi - turns * PI, m);
    if turns == 0.0 {
        remainder
    } else {
        remainder + 2.0 * turns * within_quarter_turn(FRAC_PI_2, m)
    }
}

/// E(φ | m) for |φ| ≤ π/2.
fn within_quarter_turn(phi: f64, m: f64) -> f64 {
    let (sine, cosine) = phi.sin_cos();
    let (x, y) = (cosine * cosine, 1.0 - m * sine * sine);
    if y < 0.0 {
        return f64::NAN;
    }
    sine * carlson_rf(x, y, 1.0) - m / 3.0 * sine.powi(3) * carlson_rd(x, y, 1.0)
}

/// φ with E(φ | m) = e, for m ≤ 0 (or below 1): Newton's method between bounds.
///
/// ```
/// use protomer_linkage::analysis::elliptic::{elliptic_e, inverse_elliptic_e};
/// assert!((inverse_elliptic_e(elliptic_e(0.8, -6.0), -6.0) - 0.8).abs() < 1e-14);
/// ```
pub fn inverse_elliptic_e(e: f64, m: f64) -> f64 {
    let half_turn = 2.0 * elliptic_e(FRAC_PI_2, m);
    let turns = (e / half_turn).round();
    let remainder = e - turns * half_turn;
    let (mut low, mut high) = (-FRAC_PI_2, FRAC_PI_2);
    let mut phi = PI * remainder / half_turn;
    for _ in 0..MOST_ITERATIONS {
        let excess = elliptic_e(phi, m) - remainder;
        if excess > 0.0 {
            high = phi;
        } else {
            low = phi;
        }
        let next = phi - excess / (1.0 - m * phi.sin().powi(2)).sqrt();
        let next = if next > low && next < high {
            next
        } else {
            0.5 * (low + high)
        };
        if (next - phi).abs() <= 2.0 * f64::EPSILON * phi.abs().max(1.0) {
            phi = next;
            break;
        }
        phi = next;
    }
    phi + turns * PI
}

/// R_F(x, y, z) = ½ ∫₀^∞ dt / √((t + x)(t + y)(t + z)), for arguments ≥ 0 of which at most one is
/// 0; by duplication.
///
/// ```
/// use protomer_linkage::analysis::elliptic::carlson_rf;
/// // Of equal arguments: 1/√x.
/// assert!((carlson_rf(4.0, 4.0, 4.0) - 0.5).abs() < 1e-15);
/// // K(0) = π/2
/// assert!((carlson_rf(0.0, 1.0, 1.0) - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
/// ```
pub fn carlson_rf(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    for _ in 0..MOST_ITERATIONS {
        let mean = (x + y + z) / 3.0;
        let [a, b, c] = [x, y, z].map(|number| 1.0 - number / mean);
        if a.abs().max(b.abs()).max(c.abs()) < 2e-3 {
            let (e2, e3) = (a * b - c * c, a * b * c);
            let series = 1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0
                - 3.0 * e2 * e3 / 44.0
                - 5.0 * e2.powi(3) / 208.0
                + 3.0 * e3 * e3 / 104.0;
            return series / mean.sqrt();
        }
        let shift = (x * y).sqrt() + (y * z).sqrt() + (z * x).sqrt();
        [x, y, z] = [x, y, z].map(|number| 0.25 * (number + shift));
    }
    f64::NAN
}

/// R_D(x, y, z) = 3/2 ∫₀^∞ dt / (√((t + x)(t + y)) (t + z)^(3/2)), for x, y ≥ 0 not both 0 and z >
/// 0; by duplication.
///
/// ```
/// use protomer_linkage::analysis::elliptic::carlson_rd;
/// // Of equal arguments: x to the power -3/2.
/// assert!((carlson_rd(4.0, 4.0, 4.0) - 0.125).abs() < 1e-15);
/// ```
pub fn carlson_rd(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    let (mut sum, mut scale) = (0.0, 1.0);
    for _ in 0..MOST_ITERATIONS {
        let mean = (x + y + 3.0 * z) / 5.0;
        let [a, b, c] = [x, y, z].map(|number| 1.0 - number / mean);
        if a.abs().max(b.abs()).max(c.abs()) < 1e-3 {
            let (e2, e3) = (a * b - 6.0 * c * c, (3.0 * a * b - 8.0 * c * c) * c);
            let (e4, e5) = (3.0 * (a * b - c * c) * c * c, a * b * c.powi(3));
            let series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0
                - 3.0 * e4 / 22.0
                - 9.0 * e2 * e3 / 52.0
                + 3.0 * e5 / 26.0;
            return 3.0 * sum + scale * series / (mean * mean.sqrt());
        }
        let shift = (x * y).sqrt() + (y * z).sqrt() + (z * x).sqrt();
        sum += scale / (z.sqrt() * (z + shift));
        scale *= 0.25;
        [x, y, z] = [x, y, z].map(|number| 0.25 * (number + shift));
    }
    f64::NAN
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    /// Composite Gauss-Legendre quadrature with three points an interval, summed in groups against
    /// rounding.
    fn quadrature(phi: f64, m: f64) -> f64 {
        const INTERVALS: usize = 20_000;
        let width = phi / INTERVALS as f64;
        let root = |x: f64| (1.0 - m * x.sin().powi(2)).sqrt();
        let part = |index: usize| {
            let middle = (index as f64 + 0.5) * width;
            let aside = 0.5 * width * 0.6f64.sqrt();
            width / 18.0
                * (5.0 * root(middle - aside) + 8.0 * root(middle) + 5.0 * root(middle + aside))
        };
        (0..INTERVALS / 100)
            .map(|group| (100 * group..100 * group + 100).map(part).sum::<f64>())
            .sum()
    }

    #[test]
    fn the_elliptic_integral_agrees_with_quadrature() {
        for m in [0.9, 0.5, 0.0, -0.1, -6.0, -30.0, -198.0, -2e4, -2e6] {
            for phi in [1e-3, 0.3, FRAC_PI_4, 1.5, FRAC_PI_2, 1.8, 4.0, -0.7, -7.0] {
                let (found, expected) = (elliptic_e(phi, m), quadrature(phi, m));
                assert!(
                    (found - expected).abs() < 2e-13 * expected.abs(),
                    "{phi} {m}: {found} {expected}"
                );
                assert!(
                    (inverse_elliptic_e(found, m) - phi).abs() < 2e-14 * phi.abs().max(1.0),
                    "{phi} {m}"
                );
            }
        }
        assert!(elliptic_e(1.0, 4.0).is_nan());
    }

    #[test]
    fn known_values() {
        // E(φ | 0) = φ, E(φ | 1) = sin φ, E(π/2 | ½) from tables.
        assert_eq!(
            elliptic_e(0.7, 0.0),
            0.7f64.sin() * carlson_rf(0.7f64.cos().powi(2), 1.0, 1.0)
        );
        assert!((elliptic_e(0.7, 0.0) - 0.7).abs() < 1e-15);
        assert!((elliptic_e(0.7, 1.0) - 0.7f64.sin()).abs() < 1e-15);
        assert!((elliptic_e(FRAC_PI_2, 0.5) - 1.350_643_881_047_675_5).abs() < 1e-15);
    }
}
