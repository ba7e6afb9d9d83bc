//! pKa values, net charge and isoelectric point.

use super::equilibrium::TitratingGroups;
use protomer_kernel::bisection::narrowed;
use rayon::prelude::*;
use std::f64::consts::LN_10;

/// Lowest pH at which groups are titrated.
const LOWEST_PH: f64 = -2.0;
/// Highest pH at which groups are titrated.
const HIGHEST_PH: f64 = 16.0;
/// Difference of the pH over which the slope of a charge is taken.
const SLOPE_PH: f64 = 0.1;
/// Step of the pH between which protonation is interpolated.
const STEP_PH: f64 = 0.25;

impl TitratingGroups {
    /// The pH at which a group is half protonated, for each group; `None` outside -2 to 16. A group that
    /// crosses one half several times has the crossing of its first charge: the highest for an acid, the
    /// lowest for a base.
    ///
    /// ```
    /// # use protomer_field::titration::TitratingGroups;
    /// let acid_and_base = TitratingGroups {
    ///     model_pka: vec![4.0, 10.0],
    ///     charge_e: vec![-1.0, 1.0],
    ///     shift_kt: vec![10_f64.ln(), 0.0],
    /// #   tautomer_kt: vec![None; 2],
    /// #   pair_kt: vec![0.0; 4],
    /// #   tautomer_pair_kt: vec![0.0; 4],
    /// #   bound_ion_weight: vec![0.0; 2],
    /// #   ion_pair_factor: 1.0,
    ///     // ...
    /// };
    /// // A shift of ln 10 kT, which is against the charge, is worth one unit of the pH.
    /// let pka: Vec<f64> = acid_and_base.pka_values().into_iter().flatten().collect();
    /// assert!((pka[0] - 5.0).abs() < 1e-6 && (pka[1] - 10.0).abs() < 1e-6);
    /// ```
    pub fn pka_values(&self) -> Vec<Option<f64>> {
        let steps = ((HIGHEST_PH - LOWEST_PH) / STEP_PH).round() as usize;
        let phs: Vec<f64> = (0..=steps)
            .map(|step| LOWEST_PH + STEP_PH * step as f64)
            .collect();
        let shares: Vec<Vec<f64>> = phs.par_iter().map(|ph| self.charged_shares(*ph)).collect();
        let mut values = Vec::with_capacity(self.len());
        for (group, charge_e) in self.charge_e.iter().enumerate() {
            let charged: Vec<f64> = shares.iter().map(|shares| shares[group]).collect();
            values.push(half_protonation(&phs, &charged, *charge_e > 0.0));
        }
        values
    }

    /// Capacitance of each group at a pH, e²: the fall of its mean charge per kT/e of a potential that all
    /// groups feel. A potential φ acts on protons as a pH that is lower by φ/ln 10, so it is
    /// -dq/dpH/ln 10 (Lund and Jönsson, Biochemistry 44, 5722 (2005)).
    ///
    /// ```
    /// # use protomer_field::titration::TitratingGroups;
    /// # let acid = TitratingGroups {
    /// #     model_pka: vec![4.0],
    /// #     charge_e: vec![-1.0],
    /// #     shift_kt: vec![0.0],
    /// #     tautomer_kt: vec![None],
    /// #     pair_kt: vec![0.0],
    /// #     tautomer_pair_kt: vec![0.0],
    /// #     bound_ion_weight: vec![0.0],
    /// #     ion_pair_factor: 1.0,
    /// # };
    /// // An acid with a pKa of 4: the variance of its charge is ¼ e² where it is half charged.
    /// assert!((acid.capacitances_e2(4.0)[0] - 0.25).abs() < 1e-3);
    /// assert!(acid.capacitances_e2(8.0)[0] < 1e-3);
    /// ```
    pub fn capacitances_e2(&self, ph: f64) -> Vec<f64> {
        let [low, high] = [ph - 0.5 * SLOPE_PH, ph + 0.5 * SLOPE_PH];
        let shares = [low, high].map(|ph| self.charged_shares(ph));
        let mut capacitances = Vec::with_capacity(self.len());
        for (group, charge_e) in self.charge_e.iter().enumerate() {
            let change_e = charge_e * (shares[0][group] - shares[1][group]);
            // Groups that are coupled may have a slope of the other sign, which holds no charge.
            capacitances.push((change_e / (SLOPE_PH * LN_10)).max(0.0));
        }
        capacitances
    }

    /// Sum of the mean charges of all groups at a pH, e.
    ///
    /// ```
    /// # use protomer_field::titration::TitratingGroups;
    /// # let acid_and_base = TitratingGroups {
    /// #     model_pka: vec![4.0, 10.0],
    /// #     charge_e: vec![-1.0, 1.0],
    /// #     shift_kt: vec![0.0; 2],
    /// #     tautomer_kt: vec![None; 2],
    /// #     pair_kt: vec![0.0; 4],
    /// #     tautomer_pair_kt: vec![0.0; 4],
    /// #     bound_ion_weight: vec![0.0; 2],
    /// #     ion_pair_factor: 1.0,
    /// # };
    /// // An acid with a pKa of 4, half charged, and a base of 10.
    /// assert!((acid_and_base.net_charge_e(4.0) - 0.5).abs() < 1e-5);
    /// ```
    pub fn net_charge_e(&self, ph: f64) -> f64 {
        let shares = self.charged_shares(ph);
        let mut sum = 0.0;
        for (share, charge_e) in shares.iter().zip(&self.charge_e) {
            sum += share * charge_e;
        }
        sum
    }

    /// The pH at which groups and fixed charges add up to zero, to 0.001; `None` if they do nowhere
    /// from 0 to 14.
    ///
    /// ```
    /// # use protomer_field::titration::TitratingGroups;
    /// # let acid_and_base = TitratingGroups {
    /// #     model_pka: vec![4.0, 10.0],
    /// #     charge_e: vec![-1.0, 1.0],
    /// #     shift_kt: vec![0.0; 2],
    /// #     tautomer_kt: vec![None; 2],
    /// #     pair_kt: vec![0.0; 4],
    /// #     tautomer_pair_kt: vec![0.0; 4],
    /// #     bound_ion_weight: vec![0.0; 2],
    /// #     ion_pair_factor: 1.0,
    /// # };
    /// // An acid with a pKa of 4 and a base of 10: half-way, and where a fixed charge is outweighed.
    /// let neutral_ph = |fixed_charge_e| acid_and_base.isoelectric_point(fixed_charge_e);
    /// assert!(neutral_ph(0.0).is_some_and(|ph| (ph - 7.0).abs() < 1e-3));
    /// assert!(neutral_ph(-0.5).is_some_and(|ph| (ph - 4.0).abs() < 1e-3));
    /// assert_eq!(neutral_ph(2.0), None);
    /// ```
    pub fn isoelectric_point(&self, fixed_charge_e: f64) -> Option<f64> {
        let total = |ph: f64| self.net_charge_e(ph) + fixed_charge_e;
        let ends = [0.0, 14.0];
        if total(ends[0]) <= 0.0 || total(ends[1]) >= 0.0 {
            return None;
        }
        let [low, high] = narrowed(ends, 5e-4, |ph| total(ph) > 0.0);
        Some(0.5 * (low + high))
    }
}

/// The pH at which a group is half protonated, from its charged share at these values of the pH.
fn half_protonation(phs: &[f64], charged: &[f64], is_base: bool) -> Option<f64> {
    let mut crossing = None;
    for (phs, shares) in phs.windows(2).zip(charged.windows(2)) {
        // Log-odds of the proton, which fall linearly with the pH for a group alone.
        let [first, second] = [shares[0], shares[1]].map(|share| {
            let odds = (share / (1.0 - share)).ln();
            if is_base { odds } else { -odds }
        });
        let falls = first >= 0.0 && second < 0.0;
        if falls && (crossing.is_none() || !is_base) {
            let part = first / (first - second);
            // Infinite odds have no part; the middle is within an eighth of a unit.
            let part = if part.is_finite() { part } else { 0.5 };
            crossing = Some(phs[0] + (phs[1] - phs[0]) * part);
        }
    }
    crossing
}
