//! The table of a sweep: one row per salt concentration, from the logs of its replicas.

use crate::stability::effective::EffectiveBody;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::columns::{Column, Columns, Spread};
use crate::stability::run::{AcceptedFractions, LogRow};
use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_io::csv::{Cell, Table};
use protomer_kernel::null;
use protomer_kernel::statistics::{RunningMoments, Summary, mean, summarize};
use serde::{Deserialize, Serialize};

/// The result of one replica.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReplicaResult {
    /// Index of the replica.
    pub replica: u32,
    /// Averages over production; `None` without a value, as in logs of earlier versions.
    #[serde(flatten)]
    pub averages: Columns<Option<Summary>>,
    /// Acceptance ratios in production.
    #[serde(flatten)]
    pub accepted: AcceptedFractions,
    /// Effective charges of each kind of body, where they interact: in the answer of a single
    /// simulation. Those of a sweep are in its rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_bodies: Option<Vec<EffectiveBody>>,
    /// Warnings about the energies, in the answer of a single simulation. The warnings of a sweep
    /// are its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

impl Answer for ReplicaResult {
    fn text(&self) -> String {
        let averages = &self.averages;
        let mut text = format!(
            "R_g {} Å, energy {} kT, largest cluster {:.2}",
            with_error(averages.r_g_angstrom),
            with_error(averages.energy_kt),
            averages.largest_cluster.map_or(f64::NAN, |size| size.mean)
        );
        let error = averages.r_g_angstrom.map(|r_g| r_g.standard_error);
        if !error.is_some_and(f64::is_finite) {
            text.push_str(
                "\none row in the log: no error bar; run longer (--sweeps), or log more often \
                 (--log-every)",
            );
        }
        text
    }
}

impl ReplicaResult {
    /// Averages a log, with errors corrected for autocorrelation.
    pub fn new(replica: u32, rows: &[LogRow], accepted: AcceptedFractions) -> Self {
        let averages = Columns::new(|column| {
            let series: Vec<f64> = rows.iter().map(|row| row.numbers.get(column)).collect();
            let is_complete = series.iter().all(|value| value.is_finite());
            is_complete.then(|| summarize(&series))
        });
        Self {
            replica,
            averages,
            accepted,
            effective_bodies: None,
            warnings: Vec::new(),
        }
    }
}

/// One salt concentration, averaged over its replicas. The standard deviation is over replicas, as
/// in figure 3.3 of the thesis; the standard error combines the replicas' own, which are corrected
/// for autocorrelation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SaltRow {
    /// Salt concentration, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// Debye length, Å; infinite without salt.
    #[serde(deserialize_with = "null::as_infinity")]
    pub debye_length_angstrom: f64,
    /// Cut-off, Å; infinite for none.
    #[serde(deserialize_with = "null::as_infinity")]
    pub cutoff_angstrom: f64,
    /// Averages over replicas; NaN without a value, as in results of earlier versions.
    #[serde(flatten)]
    pub averages: Columns<Spread>,
    /// Acceptance ratio of translations.
    #[serde(deserialize_with = "null::as_nan")]
    pub translation_acceptance: f64,
    /// Acceptance ratio of rotations.
    #[serde(deserialize_with = "null::as_nan")]
    pub rotation_acceptance: f64,
    /// Number of replicas.
    pub replicas: usize,
    /// Effective charges of each kind of body, where they interact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_bodies: Option<Vec<EffectiveBody>>,
}

impl SaltRow {
    /// Averages over replicas.
    pub fn new(salt_molar: f64, interaction: &ScreenedCoulomb, replicas: &[ReplicaResult]) -> Self {
        let accepted = |value: fn(&AcceptedFractions) -> f64| {
            let values: Vec<f64> = replicas.iter().map(|one| value(&one.accepted)).collect();
            mean(&values)
        };
        Self {
            salt_molar,
            debye_length_angstrom: interaction.electrolyte.debye_length_angstrom(),
            cutoff_angstrom: interaction.cutoff_angstrom,
            averages: Columns::new(|column| spread(column, replicas)),
            translation_acceptance: accepted(|accepted| accepted.translation_acceptance),
            rotation_acceptance: accepted(|accepted| accepted.rotation_acceptance),
            replicas: replicas.len(),
            effective_bodies: None,
        }
    }
}

/// The average of a column over replicas.
fn spread(column: &Column, replicas: &[ReplicaResult]) -> Spread {
    let (mut means, mut squares) = (Vec::with_capacity(replicas.len()), 0.0);
    for replica in replicas {
        let summary = replica.averages.get(column);
        means.push(summary.map_or(f64::NAN, |summary| summary.mean));
        squares += summary.map_or(f64::NAN, |summary| summary.standard_error.powi(2));
    }
    Spread {
        mean: mean(&means),
        deviation: standard_deviation(&means),
        error: squares.sqrt() / replicas.len() as f64,
    }
}

/// Columns of the first versions, which keep their places; later ones follow.
const FIRST: [&str; 20] = [
    "salt_M",
    "debye_length_angstrom",
    "cutoff_angstrom",
    "replicas",
    "r_g_mean_angstrom",
    "r_g_sd_angstrom",
    "r_g_se_angstrom",
    "native_contacts_mean",
    "native_contacts_sd",
    "largest_cluster_mean",
    "largest_cluster_sd",
    "energy_mean_kT",
    "energy_sd_kT",
    "translation_acceptance",
    "rotation_acceptance",
    "cluster_moved_mean",
    "bound_fraction_mean",
    "bound_fraction_sd",
    "contacts_mean",
    "contacts_sd",
];

impl SaltRow {
    /// The cells by the names of their columns, in the order of the table.
    fn cells(&self) -> Vec<(String, Cell)> {
        let named = |name: &str, cell: Cell| (name.to_owned(), cell);
        let mut cells = vec![
            named("salt_M", self.salt_molar.into()),
            named("debye_length_angstrom", self.debye_length_angstrom.into()),
            named("cutoff_angstrom", self.cutoff_angstrom.into()),
            named("replicas", Cell::Integer(self.replicas as i64)),
        ];
        let averages = self.averages.cells().into_iter();
        cells.extend(averages.map(|(name, number)| (name, number.into())));
        cells.push(named(
            "translation_acceptance",
            self.translation_acceptance.into(),
        ));
        cells.push(named(
            "rotation_acceptance",
            self.rotation_acceptance.into(),
        ));
        let place = |(name, _): &(String, Cell)| FIRST.iter().position(|first| first == name);
        cells.sort_by_key(|cell| place(cell).unwrap_or(FIRST.len()));
        cells
    }
}

/// The table as CSV, one row per salt concentration.
///
/// # Errors
/// Never for the rows built here, which all have the same length.
pub fn to_csv(rows: &[SaltRow]) -> Result<String> {
    let heading = rows.first().map(SaltRow::cells).into_iter().flatten();
    let mut table = Table::new(heading.map(|(name, _)| name));
    for row in rows {
        table.push(row.cells().into_iter().map(|(_, cell)| cell))?;
    }
    Ok(table.to_csv()?)
}

/// The mean with its standard error; without one, if it is not known.
fn with_error(summary: Option<Summary>) -> String {
    match summary {
        None => "-".into(),
        Some(one) if one.standard_error.is_finite() => {
            format!("{:.2} ± {:.2}", one.mean, one.standard_error)
        }
        Some(one) => format!("{:.2}", one.mean),
    }
}

/// Sample standard deviation; zero for a single value.
pub(super) fn standard_deviation(values: &[f64]) -> f64 {
    RunningMoments::in_two_passes(values).standard_deviation()
}
