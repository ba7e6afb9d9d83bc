//! The table of a sweep: one row per salt concentration, from the logs of its replicas.

use crate::stability::effective::EffectiveBody;
use crate::stability::interaction::ScreenedCoulomb;
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
    /// Radius of gyration, averaged over production, Å.
    pub r_g_angstrom: Summary,
    /// Fraction of the native contacts, those of the assembly, that are left; `None` without any.
    pub native_contacts: Option<Summary>,
    /// Bodies in the largest cluster.
    pub largest_cluster: Summary,
    /// Total energy, kT.
    #[serde(rename = "energy_kT")]
    pub energy_kt: Summary,
    /// Acceptance ratios in production.
    #[serde(flatten)]
    pub accepted: AcceptedFractions,
    /// Mean number of bodies moved per cluster move.
    #[serde(deserialize_with = "null::as_nan")]
    pub cluster_moved_mean: f64,
    /// Pairs of bodies in contact; `None` in logs of earlier versions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<Summary>,
    /// Fraction of the bodies that touch another; `None` in logs of earlier versions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound_fraction: Option<Summary>,
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
        let mut text = format!(
            "R_g {} Å, energy {} kT, largest cluster {:.2}",
            with_error(&self.r_g_angstrom),
            with_error(&self.energy_kt),
            self.largest_cluster.mean
        );
        if !self.r_g_angstrom.standard_error.is_finite() {
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
        let mut series: [Vec<f64>; 7] = Default::default();
        for row in rows {
            let values = [
                row.r_g_angstrom,
                row.native_contacts,
                row.largest_cluster as f64,
                row.energy_kt,
                row.cluster_moved,
                row.contacts,
                row.bound_fraction,
            ];
            for (series, value) in series.iter_mut().zip(values) {
                series.push(value);
            }
        }
        let [
            r_g,
            native,
            largest_cluster,
            energy,
            cluster_moved,
            contacts,
            bound,
        ] = series;
        let if_known = |series: &[f64]| {
            let is_known = series.iter().all(|value| value.is_finite());
            is_known.then(|| summarize(series))
        };
        Self {
            replica,
            r_g_angstrom: summarize(&r_g),
            native_contacts: if_known(&native),
            largest_cluster: summarize(&largest_cluster),
            energy_kt: summarize(&energy),
            accepted,
            cluster_moved_mean: mean(&cluster_moved),
            contacts: if_known(&contacts),
            bound_fraction: if_known(&bound),
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
    /// Mean radius of gyration over replicas, Å.
    pub r_g_mean_angstrom: f64,
    /// Standard deviation of the radius of gyration over replicas, Å.
    pub r_g_sd_angstrom: f64,
    /// Standard error of the mean radius of gyration from the correlated series, Å.
    #[serde(deserialize_with = "null::as_infinity")]
    pub r_g_se_angstrom: f64,
    /// Mean fraction of the native contacts that are left; NaN if the assembly has none.
    #[serde(deserialize_with = "null::as_nan")]
    pub native_contacts_mean: f64,
    /// Standard deviation of the fraction of native contacts over replicas.
    #[serde(deserialize_with = "null::as_nan")]
    pub native_contacts_sd: f64,
    /// Mean number of bodies in the largest cluster.
    pub largest_cluster_mean: f64,
    /// Standard deviation of the size of the largest cluster over replicas.
    pub largest_cluster_sd: f64,
    /// Mean energy, kT.
    #[serde(rename = "energy_mean_kT")]
    pub energy_mean_kt: f64,
    /// Standard deviation of the energy over replicas, kT.
    #[serde(rename = "energy_sd_kT")]
    pub energy_sd_kt: f64,
    /// Acceptance ratio of translations.
    #[serde(deserialize_with = "null::as_nan")]
    pub translation_acceptance: f64,
    /// Acceptance ratio of rotations.
    #[serde(deserialize_with = "null::as_nan")]
    pub rotation_acceptance: f64,
    /// Mean number of bodies moved per cluster move.
    #[serde(deserialize_with = "null::as_nan")]
    pub cluster_moved_mean: f64,
    /// Mean fraction of the bodies that touch another; NaN in results of earlier versions.
    #[serde(default = "null::nan", deserialize_with = "null::as_nan")]
    pub bound_fraction_mean: f64,
    /// Standard deviation of the bound fraction over replicas.
    #[serde(default = "null::nan", deserialize_with = "null::as_nan")]
    pub bound_fraction_sd: f64,
    /// Mean number of pairs of bodies in contact; NaN in results of earlier versions.
    #[serde(default = "null::nan", deserialize_with = "null::as_nan")]
    pub contacts_mean: f64,
    /// Standard deviation of the number of contacts over replicas.
    #[serde(default = "null::nan", deserialize_with = "null::as_nan")]
    pub contacts_sd: f64,
    /// Number of replicas.
    pub replicas: usize,
    /// Effective charges of each kind of body, where they interact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_bodies: Option<Vec<EffectiveBody>>,
}

impl SaltRow {
    /// Averages over replicas.
    pub fn new(salt_molar: f64, interaction: &ScreenedCoulomb, replicas: &[ReplicaResult]) -> Self {
        let mut columns: [Vec<f64>; 9] = Default::default();
        let mut squared_errors = 0.0;
        for replica in replicas {
            let native = replica.native_contacts.as_ref();
            let values = [
                replica.r_g_angstrom.mean,
                native.map_or(f64::NAN, |summary| summary.mean),
                replica.largest_cluster.mean,
                replica.energy_kt.mean,
                replica.accepted.translation_acceptance,
                replica.accepted.rotation_acceptance,
                replica.cluster_moved_mean,
                replica.bound_fraction.map_or(f64::NAN, |bound| bound.mean),
                replica.contacts.map_or(f64::NAN, |contacts| contacts.mean),
            ];
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
            squared_errors += replica.r_g_angstrom.standard_error.powi(2);
        }
        let [
            r_g,
            native,
            largest,
            energy,
            translation,
            rotation,
            cluster_moved,
            bound,
            contacts,
        ] = columns;
        Self {
            salt_molar,
            debye_length_angstrom: interaction.electrolyte.debye_length_angstrom(),
            cutoff_angstrom: interaction.cutoff_angstrom,
            r_g_mean_angstrom: mean(&r_g),
            r_g_sd_angstrom: standard_deviation(&r_g),
            r_g_se_angstrom: squared_errors.sqrt() / replicas.len() as f64,
            native_contacts_mean: mean(&native),
            native_contacts_sd: standard_deviation(&native),
            largest_cluster_mean: mean(&largest),
            largest_cluster_sd: standard_deviation(&largest),
            energy_mean_kt: mean(&energy),
            energy_sd_kt: standard_deviation(&energy),
            translation_acceptance: mean(&translation),
            rotation_acceptance: mean(&rotation),
            cluster_moved_mean: mean(&cluster_moved),
            bound_fraction_mean: mean(&bound),
            bound_fraction_sd: standard_deviation(&bound),
            contacts_mean: mean(&contacts),
            contacts_sd: standard_deviation(&contacts),
            replicas: replicas.len(),
            effective_bodies: None,
        }
    }
}

impl SaltRow {
    /// The cells by the names of their columns, in the order of the table.
    fn cells(&self) -> [(&'static str, Cell); 20] {
        [
            ("salt_M", self.salt_molar.into()),
            ("debye_length_angstrom", self.debye_length_angstrom.into()),
            ("cutoff_angstrom", self.cutoff_angstrom.into()),
            ("replicas", Cell::Integer(self.replicas as i64)),
            ("r_g_mean_angstrom", self.r_g_mean_angstrom.into()),
            ("r_g_sd_angstrom", self.r_g_sd_angstrom.into()),
            ("r_g_se_angstrom", self.r_g_se_angstrom.into()),
            ("native_contacts_mean", self.native_contacts_mean.into()),
            ("native_contacts_sd", self.native_contacts_sd.into()),
            ("largest_cluster_mean", self.largest_cluster_mean.into()),
            ("largest_cluster_sd", self.largest_cluster_sd.into()),
            ("energy_mean_kT", self.energy_mean_kt.into()),
            ("energy_sd_kT", self.energy_sd_kt.into()),
            ("translation_acceptance", self.translation_acceptance.into()),
            ("rotation_acceptance", self.rotation_acceptance.into()),
            ("cluster_moved_mean", self.cluster_moved_mean.into()),
            ("bound_fraction_mean", self.bound_fraction_mean.into()),
            ("bound_fraction_sd", self.bound_fraction_sd.into()),
            ("contacts_mean", self.contacts_mean.into()),
            ("contacts_sd", self.contacts_sd.into()),
        ]
    }
}

/// The table as CSV, one row per salt concentration.
///
/// # Errors
/// Never for the rows built here, which all have the same length.
pub fn to_csv(rows: &[SaltRow]) -> Result<String> {
    let mut heading = Vec::new();
    for (name, _) in rows.first().map(SaltRow::cells).into_iter().flatten() {
        heading.push(name);
    }
    let mut table = Table::new(heading);
    for row in rows {
        let mut cells = Vec::new();
        for (_, cell) in row.cells() {
            cells.push(cell);
        }
        table.push(cells)?;
    }
    Ok(table.to_csv()?)
}

/// The mean with its standard error; without one, if it is not known.
fn with_error(summary: &Summary) -> String {
    match summary.standard_error.is_finite() {
        true => format!("{:.2} ± {:.2}", summary.mean, summary.standard_error),
        false => format!("{:.2}", summary.mean),
    }
}

/// Sample standard deviation; zero for a single value.
pub(super) fn standard_deviation(values: &[f64]) -> f64 {
    RunningMoments::in_two_passes(values).standard_deviation()
}
