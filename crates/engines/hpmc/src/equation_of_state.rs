//! What follows from a measured equation of state.

use crate::error::Result;
use protomer_kernel::spline::{Ends, Spline};

/// Smallest number of packing fractions for a spline; the point at zero is added to them.
pub const FEWEST_TO_INTEGRATE: usize = 3;

/// A measured compressibility factor.
///
/// ```
/// use protomer_hpmc::equation_of_state::{Factor, excess_free_energies};
/// // Without interactions Z = 1, at any density.
/// let ideal = [0.1, 0.2, 0.3].map(|packing_fraction| Factor {
///     packing_fraction,
///     value: 1.0,
///     standard_error: 0.01,
/// });
/// let energies = excess_free_energies(&ideal, 0.0)?;
/// assert!(energies.iter().all(|(free_energy_kt, error)| *free_energy_kt == 0.0 && *error > 0.0));
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// The part of the box that the bodies fill.
    pub packing_fraction: f64,
    /// Z = βP/ρ.
    pub value: f64,
    /// Standard error of the factor; not a number where it is not known.
    pub standard_error: f64,
}

/// The excess free energy per body (kT) of a fluid at each packing fraction, with its standard error,
///
/// f(φ) = ∫₀^φ (Z - 1)/φ' dφ',
///
/// by a cubic spline through (Z - 1)/φ, which begins at B2 over the volume of a body. It is linear in
/// the factors, so their errors propagate. Fewer factors than [`FEWEST_TO_INTEGRATE`] give nothing.
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
/// let (free_energy_kt, _) = excess_free_energies(&factors, 4.0)?[2];
/// assert!((free_energy_kt - 1.65).abs() < 1e-12);
/// # Ok::<(), protomer_hpmc::Error>(())
/// ```
///
/// # Errors
/// If the packing fractions do not ascend from above zero.
pub fn excess_free_energies(factors: &[Factor], b2_over_volume: f64) -> Result<Vec<(f64, f64)>> {
    if factors.len() < FEWEST_TO_INTEGRATE {
        return Ok(Vec::new());
    }
    let energies = integrals(factors, b2_over_volume, |_, factor| {
        (factor.value - 1.0) / factor.packing_fraction
    })?;
    let mut variances = vec![0.0; factors.len()];
    for perturbed_index in 0..factors.len() {
        let moves = integrals(factors, 0.0, |number, factor| {
            match number == perturbed_index {
                true => factor.standard_error / factor.packing_fraction,
                false => 0.0,
            }
        })?;
        for (variance, part) in variances.iter_mut().zip(moves) {
            *variance += part * part;
        }
    }
    let errors = variances.iter().map(|variance| variance.sqrt());
    Ok(energies.into_iter().zip(errors).collect())
}

/// The integrals from zero to each packing fraction of the spline through a value at zero and at each.
fn integrals(
    factors: &[Factor],
    at_zero: f64,
    value: impl Fn(usize, &Factor) -> f64,
) -> Result<Vec<f64>> {
    let (mut x, mut y) = (vec![0.0], vec![at_zero]);
    for (number, factor) in factors.iter().enumerate() {
        x.push(factor.packing_fraction);
        y.push(value(number, factor));
    }
    Ok(Spline::through(&x, &y, Ends::Cubic)?
        .integrals()
        .split_off(1))
}
