//! The law of mass action over all parts of an assembly.
//!
//! ```text
//! c_S = K_S Π_k c_k^n_Sk,     Σ_S n_Sk c_S = T_k
//! ```
//!
//! With x_k = ln c_k the free concentrations minimise the convex function Σ_S c_S - Σ_k T_k x_k (its gradient is the
//! balance of the kinds), so Newton's method with shorter steps where the function would rise finds them from anywhere.

use nalgebra::{DMatrix, DVector};

/// A part in chemical equilibrium with free bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Species {
    /// Number of bodies of each kind.
    pub composition: Vec<usize>,
    /// Logarithm of the equilibrium constant, in units of a concentration to the power 1 - n.
    pub ln_constant: f64,
}

/// Steps of Newton's method at most.
const MOST_STEPS: usize = 500;
/// Balance of a kind, relative to its total, that ends the search.
const BALANCED: f64 = 1e-12;

/// Logarithms of the free concentrations of each kind at total concentrations, in the unit of those.
///
/// Free bodies must be among the species, with a constant of one. Every total must be positive.
///
/// ```
/// use protomer_mc::parts::{Species, free_concentrations};
/// // Two equal bodies with a dimer: K = 2, so c + 2 · 2 c² = 3 has the root c = 0.75.
/// let free = Species { composition: vec![1], ln_constant: 0.0 };
/// let dimer = Species { composition: vec![2], ln_constant: 2.0_f64.ln() };
/// let ln_free = free_concentrations(&[free, dimer], &[3.0]);
/// assert!((ln_free[0].exp() - 0.75).abs() < 1e-9);
/// ```
pub fn free_concentrations(species: &[Species], totals: &[f64]) -> Vec<f64> {
    let totals = DVector::from_column_slice(totals);
    let mut ln_free = start(species, &totals);
    let mut present = Balance::new(species, &totals, &ln_free);
    for _ in 0..MOST_STEPS {
        let unbalanced = present.gradient.component_div(&totals).amax();
        if unbalanced < BALANCED {
            break;
        }
        // Positive definite because every free body is a species.
        let Some(factor) = present.curvature.clone().cholesky() else {
            break;
        };
        let newton = -factor.solve(&present.gradient);
        let Some((next_ln_free, next)) = shorter(species, &totals, &ln_free, &newton, &present)
        else {
            break;
        };
        (ln_free, present) = (next_ln_free, next);
    }
    ln_free.iter().copied().collect()
}

/// Concentration of each species at these free concentrations, in their unit.
///
/// ```
/// use protomer_mc::parts::{Species, species_concentrations};
/// let dimer = Species { composition: vec![2], ln_constant: 2.0_f64.ln() };
/// assert!((species_concentrations(&[dimer], &[0.75_f64.ln()])[0] - 1.125).abs() < 1e-12);
/// ```
pub fn species_concentrations(species: &[Species], ln_free: &[f64]) -> Vec<f64> {
    let concentration = |one: &Species| {
        let counts = one.composition.iter().zip(ln_free);
        let ln_product: f64 = counts.map(|(count, ln_free)| *count as f64 * ln_free).sum();
        (one.ln_constant + ln_product).exp()
    };
    species.iter().map(concentration).collect()
}

/// A start at which no species holds more than its kinds have.
fn start(species: &[Species], totals: &DVector<f64>) -> DVector<f64> {
    let mut ln_free = totals.map(f64::ln);
    let lowest = ln_free.min();
    for one in species {
        let bodies: usize = one.composition.iter().sum();
        // All its kinds at one concentration c: K cⁿ is at most the smallest total.
        let highest = (lowest - one.ln_constant) / bodies.max(1) as f64;
        for (kind, count) in one.composition.iter().enumerate() {
            if *count > 0 {
                ln_free[kind] = ln_free[kind].min(highest);
            }
        }
    }
    ln_free
}

/// A step towards the minimum that lowers the function.
fn shorter(
    species: &[Species],
    totals: &DVector<f64>,
    ln_free: &DVector<f64>,
    newton: &DVector<f64>,
    present: &Balance,
) -> Option<(DVector<f64>, Balance)> {
    /// Share of the fall along the gradient that a step must reach (Armijo).
    const ENOUGH: f64 = 1e-4;
    let slope = newton.dot(&present.gradient);
    let mut length = 1.0;
    // 2⁻⁶⁰ of a step is none.
    for _ in 0..60 {
        let next_ln_free = ln_free + length * newton;
        let next = Balance::new(species, totals, &next_ln_free);
        // Near the minimum rounding hides the fall; the full step is right there.
        let rounding = 1e-14 * (1.0 + present.value.abs());
        if next.value <= present.value + ENOUGH * length * slope + rounding {
            return Some((next_ln_free, next));
        }
        length *= 0.5;
    }
    None
}

/// The function, its gradient and its second derivatives.
struct Balance {
    value: f64,
    gradient: DVector<f64>,
    curvature: DMatrix<f64>,
}

impl Balance {
    fn new(species: &[Species], totals: &DVector<f64>, ln_free: &DVector<f64>) -> Self {
        let kinds = totals.len();
        let mut balance = Self {
            value: -totals.dot(ln_free),
            gradient: -totals.clone(),
            curvature: DMatrix::zeros(kinds, kinds),
        };
        let concentrations = species_concentrations(species, ln_free.as_slice());
        for (one, concentration) in species.iter().zip(concentrations) {
            balance.value += concentration;
            for (row, count) in one.composition.iter().enumerate() {
                balance.gradient[row] += *count as f64 * concentration;
                for (column, other) in one.composition.iter().enumerate() {
                    balance.curvature[(row, column)] += (count * other) as f64 * concentration;
                }
            }
        }
        balance
    }
}
