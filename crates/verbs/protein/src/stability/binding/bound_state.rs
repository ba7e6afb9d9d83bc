//! The dissociation constant of the pose by integration over the poses around it.
//!
//! The poses are sampled at the first salt, without the response of the solvent: it costs most of an energy, and is
//! nearly the same for all poses of a well. Each salt then weights the poses by the change of their energy.

use super::fast::FastMedium;
use anyhow::Result;
use protomer_common::answer::counted;
use protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR;
use protomer_mc::pair::{BodyPair, BoundState, BoundStateSettings};
use protomer_results::Execution;
use serde::Serialize;
use std::f64::consts::LN_10;

/// Limits of the state that are tried, Å: bodies that interlock leave room to hardly any pose within the widest.
const LIMITS_ANGSTROM: [f64; 3] = [5.0, 2.5, 1.25];
/// A lowest pose farther than this from the given one is another pose, Å.
const SAME_POSE_ANGSTROM: f64 = 2.0;
/// The lowest energy met may lie this far above the given pose, kT.
const MISSED_KT: f64 = 1.0;
/// Fewest poses, by weight, that a constant may rest on.
const FEWEST_POSES: f64 = 20.0;
/// Largest share of the state near its limit; with more, the limit decides.
const MOST_AT_LIMIT: f64 = 0.1;

/// The bound state about the pose at one pH and the first salt.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoundStateSummary {
    /// pH; null where the files have their own charges.
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
    /// Poses nearer than this to the given one are the state, Å (root mean square displacement).
    pub limit_angstrom: f64,
    /// Share of the state beyond four fifths of the limit of 5 Å.
    pub share_at_limit: f64,
    /// Energies that were computed.
    pub evaluations: u64,
}

/// A sampled bound state, and the bodies that it was sampled with.
pub(super) struct Sampled {
    /// The bodies without the response of the solvent.
    pair: BodyPair,
    state: BoundState,
    limit_angstrom: f64,
    /// Energy of the given pose without the response, kT.
    given_kt: f64,
    /// Whether the hard bodies overlap in the given pose.
    overlaps: bool,
}

/// A sampled state in one medium.
pub(super) struct Weighted {
    pub log10_kd_molar: f64,
    pub log10_kd_error: f64,
    ln_association_angstrom3: f64,
    mean_energy_kt: f64,
    /// Energy of the lowest pose that was sampled, kT.
    lowest_energy_kt: f64,
    /// Number of poses that would carry the same information with equal weights.
    effective_poses: f64,
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
        let pair = medium.pair_without_response()?;
        let given_kt = pair.energy_kt(&medium.pose());
        let goes_on = || !execution.interrupt.is_requested();
        // The widest that has room: too narrow a limit would cut the state off.
        for limit_angstrom in LIMITS_ANGSTROM {
            let settings = BoundStateSettings {
                seed,
                limit_angstrom,
                ..BoundStateSettings::default()
            };
            if let Some(state) = pair.bound_state(&medium.pose(), &settings, &goes_on)? {
                return Ok(Some(Self {
                    pair,
                    state,
                    limit_angstrom,
                    given_kt,
                    overlaps,
                }));
            }
        }
        Ok(None)
    }

    /// The state in a medium: ln K_A grows by ln <exp(-ΔU)> over the poses.
    ///
    /// # Errors
    /// If the charges have no screening.
    pub fn in_medium(&self, medium: &FastMedium) -> Result<Weighted> {
        let whole = medium.pair()?;
        let (mut sum, mut squares, mut energies) = (0.0, 0.0, 0.0);
        for pose in &self.state.samples {
            let energy_kt = whole.energy_kt(pose);
            // ΔU = U_with - U_without, and the poses were drawn without.
            let weight = (self.pair.energy_kt(pose) - energy_kt).exp();
            sum += weight;
            squares += weight * weight;
            energies += weight * energy_kt;
        }
        let count = self.state.samples.len() as f64;
        let mean = sum / count;
        // Of the mean of weights, relative to its square.
        let variance = (squares / count / mean.powi(2) - 1.0) / (count - 1.0);
        let ln_association_angstrom3 = self.state.ln_association_angstrom3 + mean.ln();
        let ln_error = (self.state.ln_association_error.powi(2) + variance).sqrt();
        Ok(Weighted {
            log10_kd_molar: -(NUMBER_DENSITY_PER_MOLAR.ln() + ln_association_angstrom3) / LN_10,
            log10_kd_error: ln_error / LN_10,
            ln_association_angstrom3,
            mean_energy_kt: energies / sum,
            lowest_energy_kt: whole.energy_kt(&self.state.lowest_pose),
            // (Σ w)² / Σ w²: poses of equal weight that would say as much.
            effective_poses: sum.powi(2) / squares,
        })
    }

    /// The state in the medium that it was sampled in.
    pub fn summary(&self, ph: Option<f64>, weighted: &Weighted) -> BoundStateSummary {
        let state = &self.state;
        BoundStateSummary {
            ph,
            mean_energy_kt: weighted.mean_energy_kt,
            lowest_energy_kt: weighted.lowest_energy_kt,
            lowest_displacement_angstrom: state.lowest_displacement_angstrom,
            displacement_angstrom: state.displacement_angstrom,
            // ΔG = <U> - TΔS, and K_A in units of 1/(mol/L) is exp(-ΔG).
            entropy_loss_kt: -NUMBER_DENSITY_PER_MOLAR.ln()
                - weighted.ln_association_angstrom3
                - weighted.mean_energy_kt,
            limit_angstrom: self.limit_angstrom,
            share_at_limit: state.share_at_limit,
            evaluations: state.evaluations,
        }
    }

    /// Warnings about this state.
    pub fn warnings(&self) -> Vec<String> {
        let (state, mut warnings) = (&self.state, Vec::new());
        // An overlapping pose has no energy to compare with.
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
                "warning: {:.0} % of the bound state lie more than {} Å from the given pose, and its limit is {} Å: the model \
                 holds no well there, so the integrated K_D means little",
                100.0 * state.share_at_limit,
                0.8 * self.limit_angstrom,
                self.limit_angstrom
            ));
        }
        warnings
    }
}

/// Message for a pose around which no state could be sampled.
pub(super) const NO_ROOM: &str = "warning: no K_D is integrated: the bodies interlock, and of the poses within 1.25 Å \
    of the given one fewer than one in 2000 is free of overlap; the calibrated affinity does not need it";

impl Weighted {
    /// A warning if too few poses carry the weight.
    pub fn warning(&self, salt_molar: f64) -> Option<String> {
        (self.effective_poses < FEWEST_POSES).then(|| {
            format!(
                "warning: at {salt_molar} M the integrated K_D rests on {} of the first salt, and its error is \
                 uncertain; give this salt first, or alone",
                counted(self.effective_poses.round() as usize, "pose", "poses")
            )
        })
    }
}
