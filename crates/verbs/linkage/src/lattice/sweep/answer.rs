//! The answer of a sweep.

use super::plan::axes;
use super::table::{ConditionRow, Estimate, RunRow};
use crate::lattice::run::LARGEST_ENERGY_ERROR;
use crate::lattice::settings::LatticeSettings;
use protomer_common::answer::{Answer, columns};
use serde::Serialize;

/// The result of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticeSweep {
    /// Version of the program.
    pub version: String,
    /// The resolved settings.
    pub settings: LatticeSettings,
    /// Rows of the conditions, one per r0 and κ.
    pub conditions: Vec<ConditionRow>,
    /// Rows of the runs, one per run.
    pub runs: Vec<RunRow>,
}

impl LatticeSweep {
    /// A line for every run that could not be completed.
    pub fn failed_runs(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for run in &self.runs {
            if let Some(reason) = &run.failure {
                lines.push(format!(
                    "r0 = {}, κ = {}, seed {} failed: {reason}",
                    run.r0, run.kappa, run.seed
                ));
            }
        }
        lines
    }

    /// The warning of runs that should have conserved their energy and did not.
    pub fn energy_warning(&self) -> Option<String> {
        if !self.settings.conserves_energy() {
            return None;
        }
        let (mut count, mut largest) = (0, 0.0_f64);
        for run in &self.runs {
            if run.energy_error > LARGEST_ENERGY_ERROR {
                count += 1;
                largest = largest.max(run.energy_error);
            }
        }
        (count > 0).then(|| {
            format!(
                "the energy is off by more than {LARGEST_ENERGY_ERROR} in {count} of {} runs, at most by {largest:.1e} \
                 (energy_error in runs.csv); give a smaller --dt",
                self.runs.len()
            )
        })
    }
}

impl Answer for LatticeSweep {
    fn text(&self) -> String {
        let mut heading = vec![
            "r0",
            "κ",
            "runs",
            "ν_xy",
            "r²",
            "σ_max",
            "σ of checkerboard",
            "synchronisation",
        ];
        let has_exponents = axes(&self.settings).lyapunov.is_some();
        if has_exponents {
            heading.push("λ_max");
        }
        let mut rows: Vec<Vec<String>> = vec![heading.into_iter().map(str::to_owned).collect()];
        for row in &self.conditions {
            let mut cells = vec![
                format!("{:.4}", row.r0),
                row.kappa.to_string(),
                match row.failed_runs {
                    0 => row.runs.to_string(),
                    failed => format!("{} ({failed} failed)", row.runs),
                },
                shown(row.poisson_ratio_xy),
                shown(row.r_squared),
                shown(row.largest_spread),
                shown(row.checkerboard_deviation),
                shown(row.synchronisation),
            ];
            if has_exponents {
                cells.push(shown(row.lyapunov_exponent));
            }
            rows.push(cells);
        }
        columns(&rows)
    }
}

fn shown(Estimate { mean, error }: Estimate) -> String {
    match (mean.is_finite(), error.is_finite()) {
        (false, _) => "-".to_owned(),
        (true, false) => format!("{mean:.3}"),
        (true, true) => format!("{mean:.3} ± {error:.3}"),
    }
}
