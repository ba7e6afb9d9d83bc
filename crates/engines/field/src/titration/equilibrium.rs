//! Protonation equilibrium of interacting groups.
//!
//! With n_i = 1 where group i has its charged form, the free energy of a state is
//!
//! G(n) = Σ n_i g_i + Σ_{i<j} n_i n_j W_ij,  g_i = z_i ln 10 (pH - pKa_i) + A_i,
//!
//! z_i = 1 for a base and -1 for an acid, A_i the shift by the surroundings and W_ij the interaction of
//! two charges, all in kT (Bashford and Karplus, J. Phys. Chem. 95, 9556 (1991)). The mean state of a
//! group is exact over the group and the neighbours with the strongest interactions; all others act
//! with their mean charge, until the means agree (Yang, Gunner, Sampogna, Sharp and Honig, Proteins 15,
//! 252 (1993), call it the hybrid method). A protein with no more groups than one cluster holds is exact.
//!
//! A positive group may bind an anion of the salt, with the constant K in water, and has no charge then:
//! a third form, whose weight is K c times that of the charged form alone in water. It has the
//! surroundings of the neutral form, so a positive potential favours it. The ion feels the mean of the
//! other charges, times a factor: what scales pairs of groups, whose side chains may part, does not scale
//! the field in which ions gather.

use rayon::prelude::*;
use std::f64::consts::LN_10;

/// Neighbours of a group whose states are summed exactly: 2⁷ states for a group and six of them.
pub const EXACT_NEIGHBOURS: usize = 6;
/// Iterations of the means at most.
const MOST_ITERATIONS: usize = 200;
/// Largest change of a mean at which the iteration ends.
const TOLERANCE: f64 = 1e-6;
/// Share of Nδ-H among the neutral forms of histidine in water (Tanokura, Biochim. Biophys. Acta 742,
/// 576 (1983): 0.2 and 0.8).
pub const DELTA_SHARE: f64 = 0.2;

/// A system of titratable groups, energies in kT.
///
/// ```
/// use protomer_field::titration::TitratingGroups;
/// let histidine_in_water = TitratingGroups {
///     model_pka: vec![6.5],
///     charge_e: vec![1.0],
///     shift_kt: vec![0.0],
///     tautomer_kt: vec![None],
///     pair_kt: vec![0.0],
///     tautomer_pair_kt: vec![0.0],
///     bound_ion_weight: vec![0.0],
///     ion_pair_factor: 1.0,
/// };
/// assert!((histidine_in_water.charged_shares(7.5)[0] - 1.0 / 11.0).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TitratingGroups {
    /// pKa of each group in water.
    pub model_pka: Vec<f64>,
    /// Charge of the charged form, e: 1 or -1.
    pub charge_e: Vec<f64>,
    /// Free energy of the charged form in its surroundings less that in water.
    pub shift_kt: Vec<f64>,
    /// Half the free energy difference of the tautomers of the neutral form, Nδ-H less Nε-H; `None` for
    /// a group with one neutral form.
    pub tautomer_kt: Vec<Option<f64>>,
    /// Interaction of two charged forms, `groups × groups`, symmetric, zero on the diagonal.
    pub pair_kt: Vec<f64>,
    /// Interaction of half the tautomer difference of a group (row) with the charged form of another.
    pub tautomer_pair_kt: Vec<f64>,
    /// Weight K c of the form with a bound counter-ion over the charged form, in water, by group.
    pub bound_ion_weight: Vec<f64>,
    /// Factor that takes [`pair_kt`](Self::pair_kt) to the interaction with a bound ion.
    pub ion_pair_factor: f64,
}

impl TitratingGroups {
    /// Number of groups.
    pub fn len(&self) -> usize {
        self.model_pka.len()
    }

    /// Whether there are no groups.
    pub fn is_empty(&self) -> bool {
        self.model_pka.is_empty()
    }

    /// Mean share of the charged form of each group at a pH, 0 to 1.
    ///
    /// ```
    /// use protomer_field::titration::TitratingGroups;
    /// // Two equal acids that repel each other by 2 kT, exactly: x² e⁻² and 2 x against 1.
    /// let acids = TitratingGroups {
    ///     model_pka: vec![4.0; 2],
    ///     charge_e: vec![-1.0; 2],
    ///     shift_kt: vec![0.0; 2],
    ///     tautomer_kt: vec![None; 2],
    ///     pair_kt: vec![0.0, 2.0, 2.0, 0.0],
    ///     tautomer_pair_kt: vec![0.0; 4],
    ///     bound_ion_weight: vec![0.0; 2],
    ///     ion_pair_factor: 1.0,
    /// };
    /// let x = 10_f64.powf(0.5);
    /// let both = x * x * (-2_f64).exp();
    /// let exact = (x + both) / (1.0 + 2.0 * x + both);
    /// assert!((acids.charged_shares(4.5)[0] - exact).abs() < 1e-9);
    /// ```
    pub fn charged_shares(&self, ph: f64) -> Vec<f64> {
        let clusters = self.clusters();
        let mut means = vec![0.0; self.len()];
        for (group, mean) in means.iter_mut().enumerate() {
            *mean = logistic(-self.free_energy_kt(group, ph, 0.0, 0.0));
        }
        // The means are mixed half and half: strong pairs would swing otherwise.
        let mut mixing = 1.0;
        for _ in 0..MOST_ITERATIONS {
            let next: Vec<f64> = clusters
                .par_iter()
                .map(|cluster| self.mean_in_cluster(cluster, &means, ph))
                .collect();
            let mut change: f64 = 0.0;
            for (mean, next) in means.iter_mut().zip(next) {
                change = change.max((next - *mean).abs());
                *mean += mixing * (next - *mean);
            }
            mixing = 0.5;
            if change < TOLERANCE {
                break;
            }
        }
        means
    }

    /// Mean number of protons on all groups at a pH: a base has one in its charged form and with a bound ion,
    /// an acid in its neutral form. It is the slope d(F/kT)/d pH / ln 10 of the free energy F of protonation
    /// from the state without protons. A complex has more of them than its parts by the number Δν that they
    /// take up on binding, and d log₁₀ K_D / d pH = Δν (Wyman, Adv. Protein Chem. 19, 223 (1964)).
    ///
    /// ```
    /// # use protomer_field::titration::TitratingGroups;
    /// # let groups = |shift_kt: f64| TitratingGroups {
    /// #     model_pka: vec![4.0, 10.0],
    /// #     charge_e: vec![-1.0, 1.0],
    /// #     shift_kt: vec![shift_kt, 0.0],
    /// #     tautomer_kt: vec![None; 2],
    /// #     pair_kt: vec![0.0; 4],
    /// #     tautomer_pair_kt: vec![0.0; 4],
    /// #     bound_ion_weight: vec![0.0; 2],
    /// #     ion_pair_factor: 1.0,
    /// # };
    /// // An acid with a pKa of 4 and a base of 10. Binding raises the pKa of the acid to 5.
    /// let [apart, bound] = [groups(0.0), groups(10_f64.ln())];
    /// assert!((apart.protons(4.0) - 1.5).abs() < 1e-5);
    /// let taken_up = bound.protons(4.0) - apart.protons(4.0);
    /// assert!((taken_up - (10.0 / 11.0 - 0.5)).abs() < 1e-5);
    /// ```
    pub fn protons(&self, ph: f64) -> f64 {
        let charged = self.charged_shares(ph);
        let mut protons = 0.0;
        for (group, share) in charged.iter().enumerate() {
            protons += match self.charge_e[group] > 0.0 {
                true => share + (1.0 - share) * self.bound_ion_share(group, ph, &charged),
                false => 1.0 - share,
            };
        }
        protons
    }

    /// Share of the form with a bound ion among the two forms of a base without charge.
    fn bound_ion_share(&self, group: usize, ph: f64, charged: &[f64]) -> f64 {
        if self.bound_ion_weight[group] == 0.0 {
            return 0.0;
        }
        let row = &self.pair_kt[group * self.len()..][..self.len()];
        let field_kt: f64 = row
            .iter()
            .zip(charged)
            .map(|(pair, mean)| pair * mean)
            .sum();
        let proton_kt = LN_10 * (ph - self.model_pka[group]);
        logistic(self.bound_ion_exponent(group, proton_kt, field_kt))
    }

    /// Free energy of the neutral form of a group by its tautomers, with all other groups neutral, less
    /// that in water, kT; zero for a group with one neutral form.
    pub fn neutral_form_kt(&self, group: usize) -> f64 {
        self.tautomer_kt[group].map_or(0.0, tautomers_kt)
    }

    /// Each group, first, with its strongest neighbours.
    fn clusters(&self) -> Vec<Vec<usize>> {
        let mut clusters = Vec::with_capacity(self.len());
        for group in 0..self.len() {
            let mut others: Vec<usize> = (0..self.len()).filter(|other| *other != group).collect();
            let strength = |other: &usize| self.pair_kt[group * self.len() + other].abs();
            // By index where the strength is equal, so that the order is always the same.
            others.sort_by(|a, b| strength(b).total_cmp(&strength(a)).then(a.cmp(b)));
            others.truncate(EXACT_NEIGHBOURS);
            others.insert(0, group);
            clusters.push(others);
        }
        clusters
    }

    /// Free energy of the charged form less that of the neutral one without other charges, kT;
    /// `tautomer_field_kt` is what other charges add to half the tautomer difference, `field_kt` their
    /// mean interaction with the charged form.
    fn free_energy_kt(&self, group: usize, ph: f64, tautomer_field_kt: f64, field_kt: f64) -> f64 {
        let proton = self.charge_e[group] * LN_10 * (ph - self.model_pka[group]);
        let neutral = match self.tautomer_kt[group] {
            Some(half_kt) => tautomers_kt(half_kt + tautomer_field_kt),
            None => 0.0,
        };
        proton + self.shift_kt[group] - neutral + self.bound_ion_kt(group, proton, field_kt)
    }

    /// Addition of a bound ion to the free energy of the charged form against all others, kT: the form with
    /// the ion has no charge, as the neutral one, and e^-g of the charged form counts K c times,
    /// ln(1 + K c e^-g). `proton_kt` is g in water, `field_kt` as in
    /// [`free_energy_kt`](Self::free_energy_kt).
    fn bound_ion_kt(&self, group: usize, proton_kt: f64, field_kt: f64) -> f64 {
        if self.bound_ion_weight[group] == 0.0 {
            return 0.0;
        }
        let exponent = self.bound_ion_exponent(group, proton_kt, field_kt);
        // ln(1 + e^x) without overflow.
        exponent.max(0.0) + (-exponent.abs()).exp().ln_1p()
    }

    /// Logarithm of the weight of the form with an ion over the form without a proton.
    fn bound_ion_exponent(&self, group: usize, proton_kt: f64, field_kt: f64) -> f64 {
        // The pairs of the equilibrium hold once the factor; an ion feels the whole field.
        let excess_kt = (self.ion_pair_factor - 1.0) * field_kt;
        self.bound_ion_weight[group].ln() - proton_kt + excess_kt
    }

    /// Mean of the first group of a cluster: exact over the cluster, in the mean field of the others.
    fn mean_in_cluster(&self, cluster: &[usize], means: &[f64], ph: f64) -> f64 {
        let count = self.len();
        let mut single_kt = Vec::with_capacity(cluster.len());
        for &member in cluster {
            let (mut field, mut whole_field, mut tautomer_field) = (0.0, 0.0, 0.0);
            for (other, mean) in means.iter().enumerate() {
                let pair_kt = mean * self.pair_kt[member * count + other];
                whole_field += pair_kt;
                if !cluster.contains(&other) {
                    field += pair_kt;
                }
                tautomer_field += mean * self.tautomer_pair_kt[member * count + other];
            }
            let alone_kt = self.free_energy_kt(member, ph, tautomer_field, whole_field);
            single_kt.push(alone_kt + field);
        }
        let mut energies_kt = vec![0.0; 1 << cluster.len()];
        let mut lowest_kt: f64 = 0.0;
        for state in 1..energies_kt.len() {
            // The state without its highest charge has been computed before.
            let highest = state.ilog2() as usize;
            let rest = state ^ (1 << highest);
            let mut energy = energies_kt[rest] + single_kt[highest];
            for member in 0..highest {
                if rest >> member & 1 == 1 {
                    energy += self.pair_kt[cluster[highest] * count + cluster[member]];
                }
            }
            energies_kt[state] = energy;
            lowest_kt = lowest_kt.min(energy);
        }
        let (mut charged, mut sum) = (0.0, 0.0);
        for (state, energy) in energies_kt.iter().enumerate() {
            let weight = (lowest_kt - energy).exp();
            sum += weight;
            if state & 1 == 1 {
                charged += weight;
            }
        }
        charged / sum
    }
}

/// Free energy of two tautomers that differ by ± `half_kt`, relative to their mixture in water, kT.
fn tautomers_kt(half_kt: f64) -> f64 {
    let lower = -half_kt.abs();
    // Taken relative to the lower of the two, so that nothing overflows.
    let delta = DELTA_SHARE * (lower - half_kt).exp();
    let epsilon = (1.0 - DELTA_SHARE) * (lower + half_kt).exp();
    lower - (delta + epsilon).ln()
}

fn logistic(value: f64) -> f64 {
    1.0 / (1.0 + (-value).exp())
}
