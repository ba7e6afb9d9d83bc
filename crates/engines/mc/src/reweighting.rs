//! One answer from the frames of several simulations: multistate reweighting (MBAR, Shirts and
//! Chodera, J. Chem. Phys. 129, 124105 (2008)).
//!
//! Simulation k gave N_k frames from exp(-u_k). All frames together are a sample of the mixture
//! Σ_k N_k exp(f_k - u_k), where exp(-f_k) is the partition function of state k. Hence
//!
//! exp(-f_k) = Σ_n exp(-u_k(x_n)) / Σ_l N_l exp(f_l - u_l(x_n)),
//!
//! which is solved for the f by putting them in on the right and taking them from the left until they
//! stay. Between two rounds Newton's method tries a longer step: with the share p_kn of state k in the
//! density at frame n, the states should have Σ_n p_kn = N_k frames, whose derivatives are
//! ∂Σ_n p_kn/∂f_l = Σ_n p_kn (δ_kl - p_ln). It counts if the f settle faster by it.
//!
//! An average in any state u, simulated or not, is Σ_n w_n A(x_n) / Σ_n w_n with the weights
//! w_n = exp(-u(x_n)) / Σ_l N_l exp(f_l - u_l(x_n)). Everything is kept as logarithms, so that nothing
//! overflows.

use crate::contributions::Reweighted;
use crate::{McError, Result};
use nalgebra::{DMatrix, DVector};

/// Largest change of the f at which they count as settled.
const TOLERANCE: f64 = 1e-10;
/// Largest number of rounds until they settle.
const MOST_ROUNDS: usize = 100_000;

/// Frames of several states, of which each has its share in every answer.
///
/// ```
/// use protomer_mc::reweighting::Mixture;
/// // Two frames from each of two states, with their energies in both.
/// let energies_kt = [vec![0.0, 1.0, 1.5, 2.0], vec![1.0, 1.0, 0.5, 0.0]];
/// let mixture = Mixture::solve(&energies_kt, &[2, 2])?;
/// let (values, between_kt) = ([1.0, 1.0, 0.0, 0.0], [0.5, 1.0, 1.0, 1.0]);
/// // The second state mirrors the first, and so does the one between.
/// assert!((mixture.average(&between_kt, &values).mean - 0.5).abs() < 1e-9);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Mixture {
    free_energies_kt: Vec<f64>,
    /// ln Σ_l N_l exp(f_l - u_l) at each frame.
    ln_densities: Vec<f64>,
}

impl Mixture {
    /// Solves for the free energies, from the energy of every frame in every state,
    /// `energies_kt[state][frame]`, and the number of frames that came from each state; which ones
    /// does not matter.
    ///
    /// ```
    /// use protomer_mc::reweighting::Mixture;
    /// // The second state lies 2 kT higher everywhere.
    /// let mixture = Mixture::solve(&[vec![0.0; 3], vec![2.0; 3]], &[2, 1])?;
    /// assert!((mixture.free_energies_kt()[1] - 2.0).abs() < 1e-9);
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    ///
    /// # Errors
    /// [`McError::BadSystem`] for no frames, numbers that do not match, energies that are not finite,
    /// and states whose frames have so little in common that the free energies do not settle.
    pub fn solve(energies_kt: &[Vec<f64>], counts: &[usize]) -> Result<Self> {
        let frames: usize = counts.iter().sum();
        let is_matched = energies_kt.len() == counts.len()
            && energies_kt.iter().all(|of_state| of_state.len() == frames);
        let is_finite = energies_kt
            .iter()
            .flatten()
            .all(|energy| energy.is_finite());
        if frames == 0 || !is_matched || !is_finite {
            return Err(McError::BadSystem(
                "frames are weighted by their energies in every state; one is missing or not finite"
                    .into(),
            ));
        }
        let ln_counts: Vec<f64> = counts.iter().map(|count| (*count as f64).ln()).collect();
        let mut mixture = Self {
            free_energies_kt: vec![0.0; counts.len()],
            ln_densities: vec![0.0; frames],
        };
        for _ in 0..MOST_ROUNDS {
            let largest = mixture.round(energies_kt, &ln_counts);
            if largest < TOLERANCE {
                return Ok(mixture);
            }
            let Some(leap) = mixture.leap(energies_kt, &ln_counts) else {
                continue;
            };
            let mut further = Self {
                free_energies_kt: leap,
                ln_densities: mixture.ln_densities.clone(),
            };
            if further.round(energies_kt, &ln_counts) < largest {
                mixture = further;
            }
        }
        Err(McError::BadSystem(
            "the frames of neighbouring states have too little in common to be weighted; simulate \
             states between them"
                .into(),
        ))
    }

    /// Densities from the present f, then f from the densities: one round of the fixed point. Returns the
    /// largest change.
    fn round(&mut self, energies_kt: &[Vec<f64>], ln_counts: &[f64]) -> f64 {
        self.ln_densities = self.densities(energies_kt, ln_counts);
        let of_states = energies_kt.iter();
        let mut next: Vec<f64> = of_states
            .map(|of_state| self.free_energy_kt(of_state))
            .collect();
        let first = next[0];
        // Only differences of free energies count; without this they would drift together.
        next.iter_mut().for_each(|energy| *energy -= first);
        let before = std::mem::replace(&mut self.free_energies_kt, next);
        let changes = before.iter().zip(&self.free_energies_kt);
        let of_states = changes.map(|(a, b)| (a - b).abs());
        // No number is no end: a maximum would pass over it.
        of_states.fold(0.0, |most: f64, change| match change.is_nan() {
            true => f64::INFINITY,
            false => most.max(change),
        })
    }

    /// Free energies after a step of Newton's method; `None` where states have too little in common.
    fn leap(&self, energies_kt: &[Vec<f64>], ln_counts: &[f64]) -> Option<Vec<f64>> {
        // The first f stays zero.
        let states = ln_counts.len() - 1;
        if states == 0 {
            return None;
        }
        let mut missing =
            DVector::from_iterator(states, ln_counts[1..].iter().map(|ln_count| ln_count.exp()));
        let mut derivatives = DMatrix::zeros(states, states);
        let mut shares = DVector::zeros(states);
        for (frame, ln_density) in self.densities(energies_kt, ln_counts).iter().enumerate() {
            for state in 0..states {
                let free_kt = self.free_energies_kt[state + 1];
                let ln_share = ln_counts[state + 1] + free_kt - energies_kt[state + 1][frame];
                shares[state] = (ln_share - ln_density).exp();
                missing[state] -= shares[state];
                derivatives[(state, state)] += shares[state];
            }
            derivatives.ger(-1.0, &shares, &shares, 1.0);
        }
        let step = derivatives.cholesky()?.solve(&missing);
        let is_finite = step.iter().all(|change| change.is_finite());
        let moved = self.free_energies_kt[1..].iter().zip(&step);
        let leap = std::iter::once(0.0).chain(moved.map(|(free, change)| free + change));
        is_finite.then(|| leap.collect())
    }

    fn densities(&self, energies_kt: &[Vec<f64>], ln_counts: &[f64]) -> Vec<f64> {
        let of_frame = |frame: usize| {
            let states = energies_kt.iter().zip(ln_counts);
            // ln N_l + f_l - u_l: what state l adds to the density of the mixture at this frame.
            let exponents = states.zip(&self.free_energies_kt);
            ln_sum_exp(
                exponents.map(|((energies, ln_count), free)| ln_count + free - energies[frame]),
            )
        };
        (0..self.ln_densities.len()).map(of_frame).collect()
    }

    /// The free energies of the states, kT, that of the first being zero.
    pub fn free_energies_kt(&self) -> &[f64] {
        &self.free_energies_kt
    }

    /// The free energy of a state in which the frames have these energies, kT.
    ///
    /// ```
    /// use protomer_mc::reweighting::Mixture;
    /// let mixture = Mixture::solve(&[vec![0.0, 0.0]], &[2])?;
    /// let half = mixture.free_energy_kt(&[0.0, f64::INFINITY]);
    /// assert!((half - 2.0_f64.ln()).abs() < 1e-12, "half of the frames are left");
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    pub fn free_energy_kt(&self, energies_kt: &[f64]) -> f64 {
        -ln_sum_exp(self.ln_weights(energies_kt))
    }

    /// The average of a value of each frame in a state in which the frames have these energies, and
    /// how many frames carry it.
    ///
    /// ```
    /// use protomer_mc::reweighting::Mixture;
    /// let mixture = Mixture::solve(&[vec![0.0, 0.0]], &[2])?;
    /// let favoured = mixture.average(&[0.0, 3.0_f64.ln()], &[1.0, 0.0]);
    /// assert!((favoured.mean - 0.75).abs() < 1e-12);
    /// assert!((favoured.effective_frames - 1.6).abs() < 1e-12);
    /// # Ok::<(), protomer_mc::McError>(())
    /// ```
    pub fn average(&self, energies_kt: &[f64], values: &[f64]) -> Reweighted {
        let ln_all = ln_sum_exp(self.ln_weights(energies_kt));
        let (mut mean, mut squares) = (0.0, 0.0);
        for (ln_weight, value) in self.ln_weights(energies_kt).zip(values) {
            let weight = (ln_weight - ln_all).exp();
            mean += weight * value;
            squares += weight * weight;
        }
        Reweighted {
            mean,
            // Kish: (Σw)²/Σw² with weights that add up to one.
            effective_frames: 1.0 / squares,
        }
    }

    /// ln of the weight of each frame in a state in which the frames have these energies, kT; weights
    /// have no common scale until they are divided by their sum, exp(-f).
    pub(crate) fn ln_weights<'a>(
        &'a self,
        energies_kt: &'a [f64],
    ) -> impl Iterator<Item = f64> + Clone + 'a {
        let of_frames = energies_kt.iter().zip(&self.ln_densities);
        of_frames.map(|(energy_kt, ln_density)| -energy_kt - ln_density)
    }
}

/// ln Σ exp(x), relative to the largest x.
fn ln_sum_exp(exponents: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = exponents.clone().fold(f64::NEG_INFINITY, f64::max);
    // All weights are zero: -∞ less -∞ would be no number.
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    // The largest exponent in front: every exp is at most one.
    largest + exponents.map(|x| (x - largest).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::bisection::halved;
    use protomer_kernel::random::CounterRng;
    use std::f64::consts::TAU;

    /// Frames of harmonic wells k (x - c)²/2, and their energies in each well.
    fn wells(wells: &[(f64, f64)], counts: &[usize]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut rng = CounterRng::new(4, 0, 0);
        let mut places = Vec::new();
        for ((k, centre), count) in wells.iter().zip(counts) {
            for _ in 0..*count {
                let radius = (-2.0 * (1.0 - rng.uniform()).ln()).sqrt();
                places.push(centre + radius * (TAU * rng.uniform()).cos() / k.sqrt());
            }
        }
        let energy = |(k, c): &(f64, f64)| -> Vec<f64> {
            places.iter().map(|x| 0.5 * k * (x - c).powi(2)).collect()
        };
        (wells.iter().map(energy).collect(), places)
    }

    /// The slow twin: the same equations without logarithms.
    fn plainly(energies: &[Vec<f64>], counts: &[usize]) -> Vec<f64> {
        let mut parts = vec![1.0; counts.len()];
        for _ in 0..20_000 {
            let mut next = vec![0.0; counts.len()];
            for frame in 0..energies[0].len() {
                let weights: Vec<f64> = energies.iter().map(|row| (-row[frame]).exp()).collect();
                let mut density = 0.0;
                for (state, weight) in weights.iter().enumerate() {
                    density += counts[state] as f64 * weight / parts[state];
                }
                for (next, weight) in next.iter_mut().zip(&weights) {
                    *next += weight / density;
                }
            }
            parts = next.iter().map(|part| part / next[0]).collect();
        }
        parts.iter().map(|part: &f64| -part.ln()).collect()
    }

    /// Two states by another way: the f at which as many frames are expected from each state as came
    /// from it (Bennett, J. Comput. Phys. 22, 245 (1976)), by halving.
    fn bennett(energies: &[Vec<f64>], counts: [usize; 2]) -> f64 {
        let from_first = |f: f64| -> f64 {
            let [first, second] = counts.map(|count| count as f64);
            let frames = energies[0].iter().zip(&energies[1]);
            frames
                .map(|(a, b)| first / (first + second * (f + a - b).exp()))
                .sum()
        };
        let [low, high] = halved([-50.0, 50.0], 200, |f| from_first(f) > counts[0] as f64);
        0.5 * (low + high)
    }

    #[test]
    fn the_plain_equations_have_the_same_solution() {
        let counts = [40, 70, 20];
        let (energies, _) = wells(&[(1.0, 0.0), (2.0, 1.0), (0.5, 2.5)], &counts);
        let mixture = Mixture::solve(&energies, &counts).unwrap();
        for (fast, slow) in mixture
            .free_energies_kt()
            .iter()
            .zip(plainly(&energies, &counts))
        {
            assert!((fast - slow).abs() < 1e-7, "{fast} {slow}");
        }
        let two = [energies[0].clone(), energies[2].clone()];
        let two: Vec<Vec<f64>> = two.iter().map(|row| row[..60].to_vec()).collect();
        let mixture = Mixture::solve(&two, &[40, 20]).unwrap();
        let by_halving = bennett(&two, [40, 20]);
        assert!((mixture.free_energies_kt()[1] - by_halving).abs() < 1e-7);
    }

    #[test]
    fn wells_have_their_free_energies_and_their_means() {
        let pairs: Vec<(f64, f64)> = (0..6)
            .map(|k| (1.0 + f64::from(k), 0.6 * f64::from(k)))
            .collect();
        let counts = [3000; 6];
        let (energies, places) = wells(&pairs, &counts);
        // Any constant may be added to a state, however large.
        let mut shifted = energies.clone();
        shifted[3].iter_mut().for_each(|energy| *energy += 2000.0);
        let mixture = Mixture::solve(&shifted, &counts).unwrap();
        for (state, (k, centre)) in pairs.iter().enumerate() {
            let shift = if state == 3 { 2000.0 } else { 0.0 };
            let free = mixture.free_energies_kt()[state] - shift;
            assert!((free - 0.5 * k.ln()).abs() < 0.05, "{state}: {free}");
            let mean = mixture.average(&energies[state], &places).mean;
            assert!((mean - centre).abs() < 0.05, "{mean} {centre}");
        }
        // A state between two that were simulated.
        let between: Vec<f64> = places
            .iter()
            .map(|x| 1.25 * (x - 0.9_f64).powi(2))
            .collect();
        let average = mixture.average(&between, &places);
        assert!((average.mean - 0.9).abs() < 0.03, "{average:?}");
        assert!(average.effective_frames > 3000.0, "{average:?}");
        let free = mixture.free_energy_kt(&between);
        assert!((free - 0.5 * 2.5_f64.ln()).abs() < 0.05, "{free}");
    }

    #[test]
    fn one_state_has_equal_weights() {
        let mixture = Mixture::solve(&[vec![3.0, 700.0, -5.0]], &[3]).unwrap();
        let average = mixture.average(&[3.0, 700.0, -5.0], &[1.0, 2.0, 6.0]);
        assert!((average.mean - 3.0).abs() < 1e-12);
        assert!((average.effective_frames - 3.0).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_weighted_is_refused() {
        assert!(Mixture::solve(&[], &[]).is_err());
        assert!(Mixture::solve(&[vec![0.0; 2]], &[3]).is_err());
        assert!(Mixture::solve(&[vec![0.0, f64::NAN]], &[2]).is_err());
    }
}
