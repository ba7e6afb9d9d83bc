//! The maximal Lyapunov exponent of a run from the time series of a column of its log.

use super::log::LogRow;
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_linkage::analysis::divergence::{Embedding, Neighbourhood, divergence, slope};
use protomer_results::{Row, log};
use serde::Serialize;
use std::path::Path;

/// Most samples whose pairs are compared.
const MOST_SAMPLES: usize = 50_000;

/// Settings of an estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct DivergenceSettings {
    /// Column of the log.
    pub column: String,
    /// Embedding of the series.
    pub embedding: Embedding,
    /// Radius of Kantz's neighbours in standard deviations; `None` for Rosenstein's nearest neighbour.
    pub radius: Option<f64>,
    /// First and last sample of the straight part.
    pub fit: [usize; 2],
}

/// A curve of divergence and its slope.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DivergenceAnswer {
    /// Column of the log.
    pub column: String,
    /// Method: Rosenstein or Kantz.
    pub method: &'static str,
    /// Number of samples.
    pub samples: usize,
    /// Time between samples.
    pub time_between_samples: f64,
    /// Slope over the fitted part, 1/time.
    pub exponent: f64,
    /// Root mean square distance of the curve from the line.
    pub residual: f64,
    /// First and last sample of the fitted part.
    pub fit: [usize; 2],
    /// Mean logarithm of the distance after 0, 1, 2, ... samples.
    pub mean_log_distance: Vec<f64>,
}

/// Estimates the exponent from the log of a run.
///
/// # Errors
/// For a directory without a log, an unknown column, and a series too short for the embedding.
pub fn from_log(directory: &Path, settings: &DivergenceSettings) -> Result<DivergenceAnswer> {
    let rows: Vec<LogRow> = log::read(&directory.join(log::FILE))?;
    let names = LogRow::columns();
    let Some(column) = names.iter().position(|name| *name == settings.column) else {
        bail!(
            "the log has no column '{}'; its columns are {}",
            settings.column,
            names.join(", ")
        );
    };
    if rows.len() > MOST_SAMPLES {
        bail!(
            "the log has {} rows, and every pair is compared; give at most {MOST_SAMPLES}, with a larger --log-every",
            rows.len()
        );
    }
    let mut series = Vec::with_capacity(rows.len());
    for row in &rows {
        let cell = row.to_cells().swap_remove(column);
        series.push(cell.parse().unwrap_or(f64::NAN));
    }
    let [Some(first), Some(second)] = [0, 1].map(|index| rows.get(index)) else {
        bail!("{} has fewer than two rows", log::FILE);
    };
    let time_between_samples = second.time - first.time;
    let (method, neighbourhood) = match settings.radius {
        Some(radius) => ("Kantz", Neighbourhood::Within(radius)),
        None => ("Rosenstein", Neighbourhood::Nearest),
    };
    let curve = divergence(&series, &settings.embedding, neighbourhood)
        .with_context(|| directory.display().to_string())?;
    let line = slope(
        &curve,
        time_between_samples,
        settings.fit[0]..=settings.fit[1],
    )?;
    Ok(DivergenceAnswer {
        column: settings.column.clone(),
        method,
        samples: series.len(),
        time_between_samples,
        exponent: line.exponent,
        residual: line.residual,
        fit: settings.fit,
        mean_log_distance: curve,
    })
}

impl Answer for DivergenceAnswer {
    fn text(&self) -> String {
        let [first, last] = self
            .fit
            .map(|sample| sample as f64 * self.time_between_samples);
        format!(
            "exponent {:.3} from {} samples of {} ({}), over times {first:.4} to {last:.4}; the curve is {:.2} off a straight \
             line",
            self.exponent, self.samples, self.column, self.method, self.residual
        )
    }
}
