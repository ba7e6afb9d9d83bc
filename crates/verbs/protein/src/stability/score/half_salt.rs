//! Salt concentration at which half of a complex is bound.
//!
//! Two different partners A and B at the same total concentration c each bind by
//! (1 - y)² c / y = K_D, so the share that is bound is
//!
//! y = 1 + k/2 - √(k²/4 + k),   k = K_D/c,
//!
//! and half of them are where K_D = c/2. ln K_D is interpolated linearly in the logarithm of the salt
//! concentration between the salts that were solved.

use super::record::number;
use super::settings::salt_in_heading;
use serde_json::Value;

/// Dissociation constant at one salt, as the calibrated energy gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dissociation {
    /// Salt concentration, mol/L.
    pub salt_molar: f64,
    /// ln(K_D / (1 mol/L)).
    pub ln_kd: f64,
}

/// Columns of the bound share at each salt, and of the salt of half binding with the interval that the
/// error of ln K_D leaves.
pub(super) fn columns(
    constants: &[Dissociation],
    ln_kd_error: f64,
    concentration_molar: f64,
) -> Vec<(String, Value)> {
    let mut columns: Vec<(String, Value)> = constants
        .iter()
        .map(|constant| {
            let heading = format!("bound_share_{}", salt_in_heading(constant.salt_molar));
            number(
                heading,
                bound_share(constant.ln_kd.exp() / concentration_molar),
            )
        })
        .collect();
    let half = |shift: f64| {
        let target = (0.5 * concentration_molar).ln() + shift;
        salt_at(constants, target).unwrap_or(f64::NAN)
    };
    let ends = [half(-ln_kd_error), half(ln_kd_error)];
    columns.push(number("half_salt_molar", half(0.0)));
    // Where salt strengthens a complex, the larger K_D belongs to the lower salt.
    columns.push(number("half_salt_low_molar", ends[0].min(ends[1])));
    columns.push(number("half_salt_high_molar", ends[0].max(ends[1])));
    columns
}

/// Share of the partners that is bound, for K_D over the concentration of each.
fn bound_share(ratio: f64) -> f64 {
    // The product with the conjugate: no difference of large numbers where little is bound.
    1.0 / (1.0 + 0.5 * ratio + (0.25 * ratio * ratio + ratio).sqrt())
}

/// Lowest salt at which ln K_D has a value; `None` where no interval of the salts holds it.
fn salt_at(constants: &[Dissociation], ln_kd: f64) -> Option<f64> {
    let mut salted: Vec<Dissociation> = constants
        .iter()
        .copied()
        .filter(|constant| constant.salt_molar > 0.0)
        .collect();
    salted.sort_by(|a, b| a.salt_molar.total_cmp(&b.salt_molar));
    let inside = |pair: &&[Dissociation]| {
        let [low, high] = [pair[0].ln_kd - ln_kd, pair[1].ln_kd - ln_kd];
        low != high && low * high <= 0.0
    };
    let pair = salted.windows(2).find(inside)?;
    let part = (ln_kd - pair[0].ln_kd) / (pair[1].ln_kd - pair[0].ln_kd);
    let ln_salts = [pair[0].salt_molar.ln(), pair[1].salt_molar.ln()];
    Some((ln_salts[0] + part * (ln_salts[1] - ln_salts[0])).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_share_obeys_the_law_of_mass_action() {
        for ratio in [1e-9, 0.1, 0.5, 3.0, 1e6] {
            let bound = bound_share(ratio);
            let found = (1.0 - bound).powi(2) / bound;
            // Near y = 1 the square of a small difference has lost digits.
            assert!((found / ratio - 1.0).abs() < 1e-6, "{ratio}: {found}");
        }
        assert!((bound_share(0.5) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn half_salt_of_a_power_law_is_exact() {
        // ln K_D = a + s ln c crosses ln(c_half/2) at a known salt, for either sign of s.
        for slope in [4.0, -1.5] {
            let concentration_molar = 1e-6_f64;
            let half_salt: f64 = 0.21;
            let intercept = (0.5 * concentration_molar).ln() - slope * half_salt.ln();
            let constants = [0.05, 0.15, 0.5].map(|salt_molar: f64| Dissociation {
                salt_molar,
                ln_kd: intercept + slope * salt_molar.ln(),
            });
            let error = 0.5;
            let columns = columns(&constants, error, concentration_molar);
            let value = |name: &str| {
                let found = columns.iter().find(|(heading, _)| heading == name);
                found.and_then(|(_, value)| value.as_f64())
            };
            let close = |name: &str, exact: f64| {
                let found = value(name);
                assert!(
                    found.is_some_and(|found| (found / exact - 1.0).abs() < 1e-12),
                    "{name}: {found:?} for {exact}"
                );
            };
            let width = error / slope.abs();
            close("half_salt_molar", half_salt);
            close("half_salt_low_molar", half_salt * (-width).exp());
            close("half_salt_high_molar", half_salt * width.exp());
            let bound = value("bound_share_50mM");
            assert!(bound.is_some_and(|bound| (bound > 0.5) == (slope > 0.0)));
        }
    }

    #[test]
    fn a_constant_that_never_reaches_half_binding_has_no_half_salt() {
        let constants = [0.0, 0.1, 1.0].map(|salt_molar| Dissociation {
            salt_molar,
            ln_kd: -30.0,
        });
        let columns = columns(&constants, 2.0, 1e-6);
        let half = columns.iter().find(|(name, _)| name == "half_salt_molar");
        assert!(half.is_some_and(|(_, value)| value.is_null()));
    }
}
