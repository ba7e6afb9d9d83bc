//! What sums, tables and trees of charges need to know of their potential.
//!
//! The energy is a sum of a pair potential over sites: E = Σ q_k q_l v(r_kl) over the sites k, l of
//! different bodies. [`Yukawa`] is the only v so far. Types name it: types generic over v would be
//! compiled and optimised again in every crate that uses them. What they need of v is in one trait,
//! `SitePotential`.

use protomer_kernel::exponential::{exp_of_minus, exp_of_minus_f32};
use protomer_kernel::potential::Yukawa;

/// A pair potential v(r) of sites of unit strength, a smooth function of the squared distance t = r²
/// for t > 0.
pub(crate) trait SitePotential {
    /// v at a squared distance (Å²), kT. Compiled into vector loops: without branches and calls.
    fn at_square(&self, square_angstrom2: f64) -> f64;

    /// [`at_square`](Self::at_square) in single precision, to a few units in the last place. `FUSED`:
    /// where multiply-add is one instruction.
    fn at_square_f32<const FUSED: bool>(&self, square_angstrom2: f32) -> f32;

    /// The first Taylor coefficients of v as a function of t = r², about this squared distance.
    fn taylor<const N: usize>(&self, square_angstrom2: f64) -> [f64; N];

    /// The largest |∂ⁿv|/n!, along any line, at this distance and all larger ones, kT/Åⁿ.
    fn derivative_bound(&self, order: usize, distance_angstrom: f64) -> f64;

    /// The distance at which the potential jumps to zero, if it does.
    fn cutoff_angstrom(&self) -> Option<f64>;

    /// Parameters that shape the potential, for fingerprints of tables.
    fn parameters(&self) -> Vec<f64>;
}

/// λ_B exp(-κ r)/r.
impl SitePotential for Yukawa {
    #[inline(always)]
    fn at_square(&self, square_angstrom2: f64) -> f64 {
        let distance = square_angstrom2.sqrt();
        let screening = exp_of_minus(self.inverse_debye_length_per_angstrom * distance);
        let energy = self.bjerrum_length_angstrom * screening / distance;
        if distance < self.cutoff_angstrom {
            energy
        } else {
            0.0
        }
    }

    #[inline(always)]
    fn at_square_f32<const FUSED: bool>(&self, square_angstrom2: f32) -> f32 {
        let inverse = 1.0 / square_angstrom2.sqrt();
        let distance = square_angstrom2 * inverse;
        let kappa = self.inverse_debye_length_per_angstrom as f32;
        let screening = exp_of_minus_f32::<FUSED>(kappa * distance);
        self.bjerrum_length_angstrom as f32 * screening * inverse
    }

    /// With f = λ_B exp(-κ√t)/√t and g = λ_B exp(-κ√t): 2 t f' = -f - κ g and 2 g' = -κ f, which
    /// give the coefficients of both power series one by one.
    fn taylor<const N: usize>(&self, square_angstrom2: f64) -> [f64; N] {
        let (t, kappa) = (square_angstrom2, self.inverse_debye_length_per_angstrom);
        let g_0 = self.bjerrum_length_angstrom * (-kappa * t.sqrt()).exp();
        let (mut f, mut g) = ([0.0; N], g_0);
        let mut coefficient = g_0 / t.sqrt();
        for (n, f) in f.iter_mut().enumerate() {
            *f = coefficient;
            // Of (t + s): 2 (n+1) t f_{n+1} + 2 n f_n = -f_n - κ g_n.
            let next = -((2 * n + 1) as f64 * coefficient + kappa * g) / (2.0 * (n + 1) as f64 * t);
            g = -kappa * coefficient / (2.0 * (n + 1) as f64);
            coefficient = next;
        }
        f
    }

    /// By the addition theorem, the series of v in powers of a step s is
    ///
    /// v(|x - s|) = λ_B κ Σ_l (2l+1) i_l(κs) k_l(κr) P_l(cos γ).
    ///
    /// The powers of s in i_l have no negative coefficient, nor has k_l a negative value: no coefficient of
    /// sⁿ is larger than for γ = 0, towards the origin, where it is |dⁿv/drⁿ|/n!. That falls with r:
    ///
    /// λ_B / rⁿ⁺¹ · exp(-κr) Σ_{j≤n} (κr)^j / j!.
    fn derivative_bound(&self, order: usize, distance_angstrom: f64) -> f64 {
        if self.is_cut() {
            return f64::INFINITY;
        }
        let screened = self.inverse_debye_length_per_angstrom * distance_angstrom;
        let (mut term, mut sum) = (1.0, 1.0);
        for j in 1..=order {
            term *= screened / j as f64;
            sum += term;
        }
        let power = distance_angstrom.powi(order as i32 + 1);
        self.bjerrum_length_angstrom * (-screened).exp() * sum / power
    }

    fn cutoff_angstrom(&self) -> Option<f64> {
        self.is_cut().then_some(self.cutoff_angstrom)
    }

    fn parameters(&self) -> Vec<f64> {
        vec![
            self.bjerrum_length_angstrom,
            self.inverse_debye_length_per_angstrom,
            self.cutoff_angstrom,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_precisions_give_the_formula() {
        for kappa in [0.0, 0.03, 1.0 / 9.6, 1.0 / 3.0] {
            let yukawa = Yukawa::uncut(7.0, kappa).unwrap();
            for step in 1..800 {
                let r = 0.1 * f64::from(step);
                let expected = 7.0 * (-kappa * r).exp() / r;
                assert!((yukawa.at_square(r * r) / expected - 1.0).abs() < 1e-14);
                let square = (r * r) as f32;
                let singles = [
                    yukawa.at_square_f32::<false>(square),
                    yukawa.at_square_f32::<true>(square),
                ];
                for single in singles.map(f64::from) {
                    assert!((single / expected - 1.0).abs() < 1e-5, "{kappa} {r}");
                }
            }
        }
    }

    #[test]
    fn the_taylor_coefficients_are_those_of_a_fit_nearby() {
        for kappa in [0.0, 1.0 / 9.6, 1.0 / 3.0] {
            let yukawa = Yukawa::uncut(7.0, kappa).unwrap();
            let coefficients = yukawa.taylor::<9>(36.0);
            for s in [-3.0, -0.5, 0.7, 2.5] {
                let series = coefficients.iter().rev().fold(0.0, |sum, c| sum * s + c);
                assert!(
                    (series - yukawa.at_square(36.0 + s)).abs() < 1e-10,
                    "{kappa} {s}"
                );
            }
        }
    }
}
