//! The tables of a sweep: one row per run, and one row per r0 and κ.

use super::plan::Task;
use super::series::{Coherence, RunOutcome, Series};
use crate::lattice::log::LogRow;
use anyhow::Result;
use protomer_io::csv::{Cell, Table};
use protomer_kernel::statistics::RunningMoments;
use protomer_linkage::analysis::spread::FirstMaximum;
use protomer_linkage::analysis::strain::{PoissonRatio, poisson_ratio};
use protomer_linkage::analysis::synchronisation::{Synchronisation, leading_eigenvalue};
use serde::Serialize;

/// Jackknife blocks per run for the errors of Poisson's ratio.
const BLOCKS: usize = 10;
/// Regularisation: R is mixed with this share of the identity before inversion, because squares
/// that always move together make it singular.
pub const RIDGE: f64 = 1e-6;

/// The results of one run. Undetermined values are NaN.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunRow {
    /// Length of the rods.
    pub r0: f64,
    /// Constant κ of the coherence potential.
    pub kappa: f64,
    /// Seed.
    pub seed: u64,
    /// Collisions per unit of time.
    pub collision_rate: f64,
    /// Largest relative deviation of the energy.
    pub energy_error: f64,
    /// Standard deviation over time of the share of the checkerboard mode in the rotational energy.
    pub checkerboard_deviation: f64,
    /// Mean over time of the share of the checkerboard mode in the rotational energy.
    pub checkerboard_fraction: f64,
    /// The first maximum of the standard deviation of the angles about the coherent state.
    pub largest_spread: f64,
    /// Time of the maximum in `largest_spread`.
    pub largest_spread_time: f64,
    /// Poisson's ratio ν_xy for a load along x, from the strains between rows of the log.
    pub poisson_ratio_xy: f64,
    /// Poisson's ratio ν_yx for a load along y.
    pub poisson_ratio_yx: f64,
    /// Squared correlation of the two strains.
    pub r_squared: f64,
    /// Leading eigenvalue of the matrix of |R|, over the number of squares: 1 if all squares turn
    /// alike.
    pub synchronisation: f64,
    /// Leading eigenvalue of the matrix of the partial indices |P|, over the number of squares.
    pub partial_synchronisation: f64,
    /// Standard deviation over time of the share of the checkerboard mode in all energy.
    pub checkerboard_deviation_of_total: f64,
    /// Mean over time of the share of the checkerboard mode in all energy.
    pub checkerboard_fraction_of_total: f64,
    /// Passages of the checkerboard mode through the open state, per unit of time.
    pub crossing_rate: f64,
    /// Mean angular velocity of the mode at these passages: constant in the coherent motion.
    pub crossing_speed: f64,
    /// Maximal Lyapunov exponent, 1/time, if it was measured.
    pub lyapunov_exponent: f64,
    /// Standard error of the Lyapunov exponent.
    pub lyapunov_error: f64,
    /// Time from which all differences of (-1)^(i+j) θ stay below the bound to the end (eq. 37 of the
    /// preprint); NaN if they do not at the end.
    pub locking_time: f64,
    /// Mean number of domains: squares that rods join and that close to the same side.
    pub domains: f64,
    /// Mean share of the squares in the largest domain.
    pub largest_domain: f64,
    /// Reason why the run could not be completed; its numbers are then NaN.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
}

impl RunRow {
    /// The row of a run that could not be completed.
    pub(super) fn failed(task: &Task, reason: &str) -> Self {
        Self {
            r0: task.settings.r0,
            kappa: task.settings.kappa,
            seed: task.settings.seed,
            collision_rate: f64::NAN,
            energy_error: f64::NAN,
            checkerboard_deviation: f64::NAN,
            checkerboard_fraction: f64::NAN,
            largest_spread: f64::NAN,
            largest_spread_time: f64::NAN,
            poisson_ratio_xy: f64::NAN,
            poisson_ratio_yx: f64::NAN,
            r_squared: f64::NAN,
            synchronisation: f64::NAN,
            partial_synchronisation: f64::NAN,
            checkerboard_deviation_of_total: f64::NAN,
            checkerboard_fraction_of_total: f64::NAN,
            crossing_rate: f64::NAN,
            crossing_speed: f64::NAN,
            lyapunov_exponent: f64::NAN,
            lyapunov_error: f64::NAN,
            locking_time: f64::NAN,
            domains: f64::NAN,
            largest_domain: f64::NAN,
            failure: Some(reason.to_owned()),
        }
    }

    /// Computes the row from the result of a run, its log and its time series.
    ///
    /// # Errors
    /// If the synchronisation indices cannot be computed from the angles.
    pub fn new(
        task: &Task,
        outcome: &RunOutcome,
        rows: &[LogRow],
        series: &Series,
        coherence: Coherence,
    ) -> Result<Self> {
        let result = &outcome.result;
        let of_rotation =
            MeanAndDeviation::from_values(rows.iter().map(|row| row.checkerboard_fraction));
        let of_total = MeanAndDeviation::from_values(
            rows.iter().map(|row| row.checkerboard_fraction_of_total),
        );
        let speeds = series
            .crossings
            .iter()
            .flatten()
            .map(|crossing| crossing.rate.abs());
        let crossings = MeanAndDeviation::from_values(speeds);
        let (exponent, exponent_error) = match &outcome.exponent {
            Some(estimate) => (estimate.exponent, estimate.standard_error),
            None => (None, None),
        };
        let (largest_spread, largest_spread_time) = first_maximum_of_spread(rows);
        let ratio = poisson_ratio(&series.strains, BLOCKS).unwrap_or(UNKNOWN_RATIO);
        let [whole, partial] = leading(&series.synchronisation)?;
        Ok(Self {
            r0: task.settings.r0,
            kappa: task.settings.kappa,
            seed: task.settings.seed,
            collision_rate: result.events as f64 / result.time,
            energy_error: result.energy_error,
            checkerboard_deviation: of_rotation.deviation,
            checkerboard_fraction: of_rotation.mean,
            largest_spread,
            largest_spread_time,
            poisson_ratio_xy: ratio.xy,
            poisson_ratio_yx: ratio.yx,
            r_squared: ratio.r_squared,
            synchronisation: whole,
            partial_synchronisation: partial,
            checkerboard_deviation_of_total: of_total.deviation,
            checkerboard_fraction_of_total: of_total.mean,
            crossing_rate: crossings.count as f64 / result.time,
            crossing_speed: crossings.mean,
            lyapunov_exponent: exponent.unwrap_or(f64::NAN),
            lyapunov_error: exponent_error.unwrap_or(f64::NAN),
            locking_time: coherence.locking_time,
            domains: coherence.domains,
            largest_domain: coherence.largest_domain,
            failure: None,
        })
    }
}

/// The ratio of strains that do not determine one.
const UNKNOWN_RATIO: PoissonRatio = PoissonRatio {
    xy: f64::NAN,
    xy_error: f64::NAN,
    yx: f64::NAN,
    yx_error: f64::NAN,
    r_squared: f64::NAN,
    samples: 0,
};

/// The first maximum of the spread of the angles and its time; NaN if there is none.
fn first_maximum_of_spread(rows: &[LogRow]) -> (f64, f64) {
    let mut first = FirstMaximum::new(0.0);
    for row in rows {
        first.push(row.time, row.angle_spread);
    }
    match first.found() {
        Some(maximum) => (maximum.value, maximum.time),
        None => (f64::NAN, f64::NAN),
    }
}

/// Mean and standard deviation of the finite numbers of a series; NaN where there are too few.
struct MeanAndDeviation {
    count: u64,
    mean: f64,
    deviation: f64,
}

impl MeanAndDeviation {
    fn from_values(values: impl Iterator<Item = f64>) -> Self {
        let moments = finite_only(values);
        let count = moments.count();
        Self {
            count,
            mean: nan_unless(count > 0, moments.mean()),
            deviation: nan_unless(count > 1, moments.standard_deviation()),
        }
    }
}

fn finite_only(values: impl Iterator<Item = f64>) -> RunningMoments {
    values.filter(|value| value.is_finite()).collect()
}

fn nan_unless(is_known: bool, value: f64) -> f64 {
    if is_known { value } else { f64::NAN }
}

/// Leading eigenvalues of |R| and |P|, over the number of squares; NaN without frames.
fn leading(angles: &Synchronisation) -> Result<[f64; 2]> {
    if angles.samples() == 0 {
        return Ok([f64::NAN; 2]);
    }
    let partial = angles.partial(RIDGE).ok();
    Ok([
        leading_eigenvalue(&angles.index()?),
        partial.as_ref().map_or(f64::NAN, leading_eigenvalue),
    ])
}

/// A mean over runs with its standard error, which is NaN for a single run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Mean over the runs with a finite value.
    pub mean: f64,
    /// Standard error of the mean.
    pub error: f64,
}

impl Estimate {
    fn from_values(values: impl Iterator<Item = f64>) -> Self {
        let moments = finite_only(values);
        Self {
            mean: nan_unless(moments.count() > 0, moments.mean()),
            error: nan_unless(moments.count() > 1, moments.independent_standard_error()),
        }
    }
}

/// Results at one r0 and κ, averaged over the runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConditionRow {
    /// Length of the rods.
    pub r0: f64,
    /// Constant κ of the coherence potential.
    pub kappa: f64,
    /// Number of completed runs, over which everything is averaged.
    pub runs: usize,
    /// Number of runs that could not be completed.
    pub failed_runs: usize,
    /// Mean of [`RunRow::collision_rate`].
    pub collision_rate: Estimate,
    /// Mean of [`RunRow::checkerboard_deviation`].
    pub checkerboard_deviation: Estimate,
    /// Mean of [`RunRow::checkerboard_fraction`].
    pub checkerboard_fraction: Estimate,
    /// Mean of [`RunRow::largest_spread`].
    pub largest_spread: Estimate,
    /// Mean of [`RunRow::largest_spread_time`].
    pub largest_spread_time: Estimate,
    /// Poisson's ratio ν_xy from the strains of all runs together; the error is from a jackknife
    /// over blocks.
    pub poisson_ratio_xy: Estimate,
    /// Poisson's ratio ν_yx from the strains of all runs together; the error is from a jackknife
    /// over blocks.
    pub poisson_ratio_yx: Estimate,
    /// Squared correlation of the strains of all runs together; without error.
    pub r_squared: Estimate,
    /// Mean of [`RunRow::synchronisation`].
    pub synchronisation: Estimate,
    /// Mean of [`RunRow::partial_synchronisation`].
    pub partial_synchronisation: Estimate,
    /// Leading eigenvalue of the indices of all runs together, over the number of squares.
    pub pooled_synchronisation: f64,
    /// Leading eigenvalue of the partial indices of all runs together, over the number of squares.
    pub pooled_partial_synchronisation: f64,
    /// Largest relative deviation of the energy in any run.
    pub energy_error: f64,
    /// Mean of [`RunRow::checkerboard_deviation_of_total`].
    pub checkerboard_deviation_of_total: Estimate,
    /// Mean of [`RunRow::checkerboard_fraction_of_total`].
    pub checkerboard_fraction_of_total: Estimate,
    /// Mean of [`RunRow::crossing_rate`].
    pub crossing_rate: Estimate,
    /// Mean of [`RunRow::crossing_speed`].
    pub crossing_speed: Estimate,
    /// Mean of [`RunRow::lyapunov_exponent`].
    pub lyapunov_exponent: Estimate,
    /// Mean of [`RunRow::locking_time`] over the runs that are locked at the end.
    pub locking_time: Estimate,
    /// Share of the runs whose phases are locked at the end.
    pub locked_share: f64,
    /// Mean of [`RunRow::domains`].
    pub domains: Estimate,
    /// Mean of [`RunRow::largest_domain`].
    pub largest_domain: Estimate,
    /// Distance in squares at which the correlation of the sides of all runs together falls to 1/e;
    /// NaN where it does not within the lattice.
    pub correlation_length: f64,
}

impl ConditionRow {
    /// Averages over the completed runs of one r0 and κ.
    ///
    /// # Errors
    /// If the synchronisation indices cannot be computed from the angles.
    pub fn new(
        [r0, kappa]: [f64; 2],
        runs: &[RunRow],
        failed_runs: usize,
        series: &Series,
    ) -> Result<Self> {
        let estimate = |value: fn(&RunRow) -> f64| Estimate::from_values(runs.iter().map(value));
        let blocks = BLOCKS * runs.len();
        let ratio = poisson_ratio(&series.strains, blocks).unwrap_or(UNKNOWN_RATIO);
        let [pooled_synchronisation, pooled_partial_synchronisation] =
            leading(&series.synchronisation)?;
        Ok(Self {
            r0,
            kappa,
            runs: runs.len(),
            failed_runs,
            collision_rate: estimate(|run| run.collision_rate),
            checkerboard_deviation: estimate(|run| run.checkerboard_deviation),
            checkerboard_fraction: estimate(|run| run.checkerboard_fraction),
            largest_spread: estimate(|run| run.largest_spread),
            largest_spread_time: estimate(|run| run.largest_spread_time),
            poisson_ratio_xy: Estimate {
                mean: ratio.xy,
                error: ratio.xy_error,
            },
            poisson_ratio_yx: Estimate {
                mean: ratio.yx,
                error: ratio.yx_error,
            },
            r_squared: Estimate {
                mean: ratio.r_squared,
                error: f64::NAN,
            },
            synchronisation: estimate(|run| run.synchronisation),
            partial_synchronisation: estimate(|run| run.partial_synchronisation),
            pooled_synchronisation,
            pooled_partial_synchronisation,
            energy_error: runs
                .iter()
                .map(|run| run.energy_error)
                .fold(f64::NAN, f64::max),
            checkerboard_deviation_of_total: estimate(|run| run.checkerboard_deviation_of_total),
            checkerboard_fraction_of_total: estimate(|run| run.checkerboard_fraction_of_total),
            crossing_rate: estimate(|run| run.crossing_rate),
            crossing_speed: estimate(|run| run.crossing_speed),
            lyapunov_exponent: estimate(|run| run.lyapunov_exponent),
            locking_time: estimate(|run| run.locking_time),
            locked_share: locked_share(runs),
            domains: estimate(|run| run.domains),
            largest_domain: estimate(|run| run.largest_domain),
            correlation_length: series.correlation.length().unwrap_or(f64::NAN),
        })
    }
}

/// Share of the runs with frames that are locked at the end; NaN if none has frames.
fn locked_share(runs: &[RunRow]) -> f64 {
    let with_frames = runs.iter().filter(|run| run.domains.is_finite()).count();
    let locked = runs
        .iter()
        .filter(|run| run.locking_time.is_finite())
        .count();
    nan_unless(with_frames > 0, locked as f64 / with_frames as f64)
}

/// Fields of a row with their names.
macro_rules! named {
    ($row:ident, $($field:ident),*) => { [$((stringify!($field), $row.$field)),*] };
}

/// The columns of both tables, and those that a table has before and after them.
macro_rules! columns {
    ($row:ident, [$($before:ident),*], [$($after:ident),*]) => {
        named!(
            $row,
            $($before,)*
            checkerboard_deviation,
            checkerboard_fraction,
            largest_spread,
            largest_spread_time,
            poisson_ratio_xy,
            poisson_ratio_yx,
            r_squared,
            synchronisation,
            partial_synchronisation,
            checkerboard_deviation_of_total,
            checkerboard_fraction_of_total,
            crossing_rate,
            crossing_speed,
            lyapunov_exponent
            $(, $after)*
        )
    };
}

impl ConditionRow {
    /// The estimates by the names of their columns, in the order of the table.
    pub(super) fn estimates(&self) -> [(&'static str, Estimate); 18] {
        columns!(
            self,
            [collision_rate],
            [locking_time, domains, largest_domain]
        )
    }
}

/// A table with one row per r0 and κ; every estimate with its standard error, NaN if unavailable.
///
/// # Errors
/// Never for the rows built here, which all have the same length.
pub fn conditions_to_csv(rows: &[ConditionRow]) -> Result<String> {
    let mut table = Table::new(heading_of_conditions(rows));
    for row in rows {
        let mut cells: Vec<Cell> = vec![row.r0.into(), row.kappa.into(), row.runs.into()];
        for (_, Estimate { mean, error }) in row.estimates() {
            cells.extend([Cell::from(mean), error.into()]);
        }
        cells.push(row.pooled_synchronisation.into());
        cells.push(row.pooled_partial_synchronisation.into());
        cells.push(row.energy_error.into());
        cells.push(row.failed_runs.into());
        cells.push(row.locked_share.into());
        cells.push(row.correlation_length.into());
        table.push(cells)?;
    }
    Ok(table.to_csv()?)
}

fn heading_of_conditions(rows: &[ConditionRow]) -> Vec<String> {
    let mut heading = ["r0", "kappa", "runs"].map(str::to_owned).to_vec();
    let estimates = rows.first().map(ConditionRow::estimates);
    for (name, _) in estimates.into_iter().flatten() {
        heading.extend([name.to_owned(), format!("{name}_error")]);
    }
    let pooled = [
        "pooled_synchronisation",
        "pooled_partial_synchronisation",
        "energy_error",
        "failed_runs",
        "locked_share",
        "correlation_length",
    ];
    heading.extend(pooled.map(str::to_owned));
    heading
}

impl RunRow {
    /// The values by the names of their columns, in the order of the table.
    pub(super) fn values(&self) -> [(&'static str, f64); 20] {
        columns!(
            self,
            [collision_rate, energy_error],
            [lyapunov_error, locking_time, domains, largest_domain]
        )
    }
}

/// A table with one row per run.
///
/// # Errors
/// Never for the rows built here, which all have the same length.
pub fn runs_to_csv(rows: &[RunRow]) -> Result<String> {
    let mut heading = vec!["r0", "kappa", "seed"];
    let values = rows.first().map(RunRow::values);
    for (name, _) in values.into_iter().flatten() {
        heading.push(name);
    }
    heading.push("failure");
    let mut table = Table::new(heading);
    for row in rows {
        // As text, because the cells of a table hold signed numbers.
        let seed = Cell::Text(row.seed.to_string());
        let mut cells: Vec<Cell> = vec![row.r0.into(), row.kappa.into(), seed];
        for (_, value) in row.values() {
            cells.push(value.into());
        }
        cells.push(Cell::Text(row.failure.clone().unwrap_or_default()));
        table.push(cells)?;
    }
    Ok(table.to_csv()?)
}

/// A table with one row per condition and distance.
///
/// # Errors
/// Never for the rows built here, which all have the same length.
pub fn correlations_to_csv(conditions: &[ConditionRow], series: &[Series]) -> Result<String> {
    let mut table = Table::new(["r0", "kappa", "distance_squares", "correlation"]);
    for (condition, series) in conditions.iter().zip(series) {
        for (distance, correlation) in series.correlation.values().into_iter().enumerate() {
            if correlation.is_finite() {
                table.push([
                    condition.r0.into(),
                    condition.kappa.into(),
                    distance.into(),
                    correlation.into(),
                ])?;
            }
        }
    }
    Ok(table.to_csv()?)
}

/// A table with one row per passage of the checkerboard mode through the open state.
///
/// # Errors
/// Never for the rows built here, which all have the same length.
pub fn crossings_to_csv(conditions: &[ConditionRow], series: &[Series]) -> Result<String> {
    let mut table = Table::new(["r0", "kappa", "run", "time", "rate"]);
    for (condition, series) in conditions.iter().zip(series) {
        for (run, crossings) in series.crossings.iter().enumerate() {
            for crossing in crossings {
                let cells: [Cell; 5] = [
                    condition.r0.into(),
                    condition.kappa.into(),
                    (run + 1).into(),
                    crossing.time.into(),
                    crossing.rate.into(),
                ];
                table.push(cells)?;
            }
        }
    }
    Ok(table.to_csv()?)
}
