//! What follows from a measured equation of state.

use crate::spline::Spline;

/// Fewer packing fractions do not carry a spline; the point at zero comes to them.
pub const FEWEST_TO_INTEGRATE: usize = 3;

/// A measured compressibility factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// The part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Z = βP/ρ.
    pub value: f64,
    /// Its standard error; not a number where it is not known.
    pub standard_error: f64,
}

/// The excess free energy per body (kT) of a fluid at each packing fraction, with its standard error,
///
/// f(φ) = ∫₀^φ (Z - 1)/φ' dφ',
///
/// by a cubic spline through (Z - 1)/φ, which begins at B2 over the volume of a body. It is linear in
/// the factors, so their errors propagate. The packing fractions ascend from above zero; fewer than
/// [`FEWEST_TO_INTEGRATE`] give nothing.
///
/// ```
/// use protomer_hpmc::equation_of_state::{Factor, excess_free_energies};
///
/// // Z = 1 + 4φ + 10φ²: f = 4φ + 5φ².
/// let factors = [0.1_f64, 0.2, 0.3].map(|packing_fraction| Factor {
///     packing_fraction,
///     value: 1.0 + 4.0 * packing_fraction + 10.0 * packing_fraction.powi(2),
///     standard_error: 0.01,
/// });
/// let (free_energy_kt, _) = excess_free_energies(&factors, 4.0)[2];
/// assert!((free_energy_kt - 1.65).abs() < 1e-12);
/// ```
pub fn excess_free_energies(factors: &[Factor], b2_over_volume: f64) -> Vec<(f64, f64)> {
    if factors.len() < FEWEST_TO_INTEGRATE {
        return Vec::new();
    }
    let (mut x, mut y, mut errors) = (vec![0.0], vec![b2_over_volume], vec![0.0]);
    for factor in factors {
        x.push(factor.packing_fraction);
        y.push((factor.value - 1.0) / factor.packing_fraction);
        errors.push(factor.standard_error / factor.packing_fraction);
    }
    let integrals = Spline::through(x.clone(), y).integrals();
    let mut variances = vec![0.0; x.len()];
    for (number, error) in errors.iter().enumerate().skip(1) {
        let mut one = vec![0.0; x.len()];
        one[number] = *error;
        let moved = Spline::through(x.clone(), one).integrals();
        for (variance, part) in variances.iter_mut().zip(moved) {
            *variance += part * part;
        }
    }
    let errors = variances.iter().map(|variance| variance.sqrt());
    integrals.into_iter().zip(errors).skip(1).collect()
}
