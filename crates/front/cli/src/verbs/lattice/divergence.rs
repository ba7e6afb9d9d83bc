//! `protomer lattice divergence`: the Lyapunov exponent from the series of a log.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_linkage::analysis::divergence::Embedding;
use protomer_linkage_verbs::lattice::divergence::{DivergenceSettings, from_log};
use std::path::PathBuf;

/// The maximal Lyapunov exponent of a run from the time series of a column of its log, as Rosenstein or
/// as Kantz estimate it.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "lattice divergence chaos --column checkerboard",
    "lattice divergence chaos --radius 0.1 --fit-to 8"
))]
pub struct DivergenceArgs {
    /// Directory of a run.
    directory: PathBuf,
    /// Column of the log.
    #[arg(long, default_value = "checkerboard")]
    column: String,
    /// Dimension of the embedding.
    #[arg(long, default_value_t = 4)]
    dimension: usize,
    /// Delay of the embedding, in rows of the log.
    #[arg(long, default_value_t = 5)]
    delay: usize,
    /// Neighbours are more than so many rows apart.
    #[arg(long, default_value_t = 50)]
    window: usize,
    /// Rows for which neighbours are followed.
    #[arg(long, default_value_t = 50)]
    horizon: usize,
    /// First row of the straight part of the curve.
    #[arg(long, default_value_t = 0)]
    fit_from: usize,
    /// Last row of the straight part of the curve.
    #[arg(long, default_value_t = 10)]
    fit_to: usize,
    /// Follow all neighbours within this radius, in standard deviations of the column, as Kantz does
    /// [default: the nearest neighbour, as Rosenstein does].
    #[arg(long)]
    radius: Option<f64>,
}

impl DivergenceArgs {
    pub fn run(&self) -> Result<Reply> {
        let settings = DivergenceSettings {
            column: self.column.clone(),
            embedding: Embedding {
                dimension: self.dimension,
                delay: self.delay,
                window: self.window,
                horizon: self.horizon,
            },
            radius: self.radius,
            fit: [self.fit_from, self.fit_to],
        };
        Ok(Reply::data(from_log(&self.directory, &settings)?))
    }
}
