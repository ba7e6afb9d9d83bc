//! The potential of mean force of two bodies against the distance of their origins,
//!
//! ```text
//! exp(-w(r)) = <exp(-U)> over directions and rotations,   U = ∞ at overlap.
//! ```

use super::radial::RadialPoint;
use super::replicas::mean_and_error;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The width of a bin, Å.
pub const BIN_ANGSTROM: f64 = 0.5;

/// Sums over random points of one replica, in bins of the distance.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Bins(Vec<f64>);

impl Bins {
    /// Adds a point of a ray with this weight.
    pub fn add(&mut self, point: &RadialPoint, weight: f64) {
        let bin = (point.distance_angstrom / BIN_ANGSTROM) as usize;
        if self.0.len() <= bin {
            self.0.resize(bin + 1, 0.0);
        }
        self.0[bin] += weight * point.volume_angstrom3 * (-point.energy_kt).exp();
    }

    /// The same sums over a number.
    pub fn divided_by(&self, number: f64) -> Self {
        Self(self.0.iter().map(|sum| sum / number).collect())
    }

    /// <exp(-U)> in a bin.
    fn boltzmann(&self, bin: usize) -> f64 {
        let (near, far) = (bin as f64, (bin + 1) as f64);
        // ∫ r² dr over the bin, without 4π, as the points have it.
        let shell = BIN_ANGSTROM.powi(3) * (far.powi(3) - near.powi(3)) / 3.0;
        self.0.get(bin).map_or(0.0, |sum| sum / shell)
    }
}

/// One distance of a potential of mean force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeanForceRow {
    /// The middle of the bin, Å.
    pub distance_angstrom: f64,
    /// Potential of mean force w, kT.
    pub w_kt: f64,
    /// Standard error of w, kT.
    pub w_error_kt: f64,
}

/// w(r) from the replicas, for distances that any of them reached.
pub(super) fn mean_force(replicas: &[Bins]) -> Vec<MeanForceRow> {
    let bins = replicas.iter().map(|bins| bins.0.len()).max().unwrap_or(0);
    let mut rows = Vec::new();
    // The last bin is only partly covered.
    for bin in 0..bins.saturating_sub(1) {
        let values: Vec<f64> = replicas.iter().map(|bins| bins.boltzmann(bin)).collect();
        let (mean, error) = mean_and_error(&values);
        // A bin in which all poses overlap has w = ∞ and no row.
        if mean > 0.0 {
            rows.push(MeanForceRow {
                distance_angstrom: (bin as f64 + 0.5) * BIN_ANGSTROM,
                w_kt: -mean.ln(),
                // d(ln x) = dx/x.
                w_error_kt: error / mean,
            });
        }
    }
    rows
}

/// The integral over all directions of a mean along one of them.
pub(super) fn over_directions(mean_angstrom3: f64) -> f64 {
    4.0 * PI * mean_angstrom3
}
