//! The dissociation constant of the pose by integration over the poses around it.
//!
//! The first salt is sampled. For the others the poses that were drawn are weighted by the change of their energy,
//! which is nearly the same for all of them.

use super::fast::FastMedium;
use anyhow::Result;
use protomer_mc::pair::{BodyPair, BoundState, BoundStateSettings};
use protomer_results::Execution;
use serde::Serialize;
use std::f64::consts::LN_10;

/// Å³ per molecule at 1 mol/L.
const ANGSTROM3_AT_ONE_MOLAR: f64 = 1_660.539_067_2;
/// A lowest pose farther than this from the given one is another pose, Å.
const SAME_POSE_ANGSTROM: f64 = 2.0;
/// The lowest energy met may lie this far above the given pose, kT.
const MISSED_KT: f64 = 1.0;
/// With a larger share of the state near its limit, the limit decides.
const MOST_AT_LIMIT: f64 = 0.1;

/// The bound state about the pose at one pH and the first salt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoundStateSummary {
    /// pH; null where the files have charges of their own.
    pub ph: Option<f64>,
    /// Mean energy, kT.
    pub mean_energy_kt: f64,
    /// Lowest energy, kT.
    pub lowest_energy_kt: f64,
    /// Displacement of the pose of lowest energy from the given one, Å (root mean square).
    pub lowest_displacement_angstrom: f64,
    /// Root mean square displacement from the given pose, Å.
    pub displacement_angstrom: f64,
    /// Loss of entropy of translation and rotation against 1 mol/L, -TΔS in kT.
    pub entropy_loss_kt: f64,
    /// Share of the state beyond four fifths of the limit of 5 Å.
    pub share_at_limit: f64,
    /// Energies that were computed.
    pub evaluations: u64,
}

/// log₁₀ of K_D in mol/L and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dissociation {
    pub log10_kd_molar: f64,
    pub log10_kd_error: f64,
}

/// A sampled bound state, and the bodies that it was sampled with.
pub(super) struct Sampled {
    pair: BodyPair,
    state: BoundState,
    /// Energy of the given pose, kT.
    given_kt: f64,
    /// Whether the hard bodies overlap in the given pose.
    overlaps: bool,
}

impl Sampled {
    /// Samples the poses about the given one; `None` if nothing has room there, or the work was ended.
    ///
    /// # Errors
    /// If the charges have no screening.
    pub fn new(
        medium: &FastMedium,
        overlaps: bool,
        seed: u64,
        execution: &Execution,
    ) -> Result<Option<Self>> {
        let pair = medium.pair(true)?;
        let settings = BoundStateSettings {
            seed,
            ..BoundStateSettings::default()
        };
        let goes_on = || !execution.interrupt.is_requested();
        let state = pair.bound_state(&medium.pose(), &settings, &goes_on)?;
        let given_kt = pair.energy_kt(&medium.pose());
        Ok(state.map(|state| Self {
            pair,
            state,
            given_kt,
            overlaps,
        }))
    }

    /// K_D at the salt that was sampled.
    pub fn dissociation(&self) -> Dissociation {
        dissociation(
            self.state.ln_association_angstrom3,
            self.state.ln_association_error,
        )
    }

    /// K_D in another medium: ln K_A grows by ln <exp(-ΔU)> over the poses.
    ///
    /// # Errors
    /// If the charges have no screening.
    pub fn dissociation_in(&self, medium: &FastMedium) -> Result<Dissociation> {
        let other = medium.pair(false)?;
        let mut factors = Vec::with_capacity(self.state.samples.len());
        for pose in &self.state.samples {
            let change_kt = other.energy_kt(pose) - self.pair.energy_kt(pose);
            factors.push((-change_kt).exp());
        }
        let count = factors.len() as f64;
        let mean = factors.iter().sum::<f64>() / count;
        let spread = factors
            .iter()
            .map(|factor| (factor - mean).powi(2))
            .sum::<f64>();
        let variance = spread / (count * (count - 1.0)) / mean.powi(2);
        Ok(dissociation(
            self.state.ln_association_angstrom3 + mean.ln(),
            (self.state.ln_association_error.powi(2) + variance).sqrt(),
        ))
    }

    pub fn summary(&self, ph: Option<f64>) -> BoundStateSummary {
        let state = &self.state;
        BoundStateSummary {
            ph,
            mean_energy_kt: state.mean_energy_kt,
            lowest_energy_kt: state.lowest_energy_kt,
            lowest_displacement_angstrom: state.lowest_displacement_angstrom,
            displacement_angstrom: state.displacement_angstrom,
            // ΔG = <U> - TΔS, and K_A in units of 1/(mol/L) is exp(-ΔG).
            entropy_loss_kt: -(state.ln_association_angstrom3 - ANGSTROM3_AT_ONE_MOLAR.ln())
                - state.mean_energy_kt,
            share_at_limit: state.share_at_limit,
            evaluations: state.evaluations,
        }
    }

    /// What a user should know of this state.
    pub fn warnings(&self) -> Vec<String> {
        let (state, mut warnings) = (&self.state, Vec::new());
        if !self.overlaps && state.lowest_energy_kt > self.given_kt + MISSED_KT {
            warnings.push(format!(
                "warning: the integration met no pose below {:.1} kT, and the given pose has {:.1} kT: its well is narrower than the \
                 sampling resolves, so the integrated K_D is too large; compare seeds",
                state.lowest_energy_kt, self.given_kt
            ));
        }
        if state.lowest_displacement_angstrom > SAME_POSE_ANGSTROM {
            warnings.push(format!(
                "warning: the given pose is no minimum of the model's energy: the lowest energy nearby ({:.1} kT) lies {:.1} Å away, \
                 so the integrated K_D is that of another pose; compare with the calibrated affinity",
                state.lowest_energy_kt, state.lowest_displacement_angstrom
            ));
        }
        if state.share_at_limit > MOST_AT_LIMIT {
            warnings.push(format!(
                "warning: {:.0} % of the bound state lie more than 4 Å from the given pose, and its limit is 5 Å: the model holds \
                 no well there, so the integrated K_D means little",
                100.0 * state.share_at_limit
            ));
        }
        warnings
    }
}

fn dissociation(ln_association_angstrom3: f64, ln_error: f64) -> Dissociation {
    Dissociation {
        log10_kd_molar: (ANGSTROM3_AT_ONE_MOLAR.ln() - ln_association_angstrom3) / LN_10,
        log10_kd_error: ln_error / LN_10,
    }
}
