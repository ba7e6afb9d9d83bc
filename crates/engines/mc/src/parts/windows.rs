//! Umbrella windows between a part whose last body is in its place and one from which it is far away.
//!
//! The coordinate is the displacement d of the last body from its place next to the body that it is attached to (root mean
//! square over its points). Windows are even in ln d, in which the room grows steadily:
//!
//! ```text
//! w_k = ½ (1.5/s)² (ln d - ln d_k)²     with the spacing s; flat below the first d_k and above the last
//! ```

use crate::Result;
use crate::error::require;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Settings of umbrella windows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WindowSettings {
    /// Windows of one run.
    pub windows: usize,
    /// Sweeps of each window that count; a quarter as many come first.
    pub sweeps: u64,
}

impl Default for WindowSettings {
    fn default() -> Self {
        Self {
            windows: 24,
            sweeps: 4000,
        }
    }
}

/// Spacing in standard deviations of a window on level ground. Wider windows hold two states where a well ends, and hop between them
/// rarely; for narrower ones exchanges are rare: 0.29 of them are accepted here, and 0.16 with a spacing of two.
const SPACING: f64 = 1.5;
/// Fewest and most windows.
const WINDOWS: RangeInclusive<usize> = 4..=400;
/// Fewest and most sweeps.
const SWEEPS: RangeInclusive<u64> = 100..=1_000_000;

impl WindowSettings {
    /// Refuses settings out of range.
    ///
    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) names the setting and its range.
    pub fn check(&self) -> Result<()> {
        let count = self.windows as f64;
        require(
            "number of windows",
            count,
            "4 to 400",
            WINDOWS.contains(&self.windows),
        )?;
        let sweeps = self.sweeps as f64;
        let range = "100 to 1 000 000";
        require(
            "sweeps of a window",
            sweeps,
            range,
            SWEEPS.contains(&self.sweeps),
        )
    }
}

/// Connection of the windows of all runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindowsFound {
    /// Smallest share of the exchanges between two neighbouring windows that were accepted.
    pub least_exchanged: f64,
    /// Displacement between these two windows, Å.
    pub least_exchanged_angstrom: f64,
    /// Ways of a simulation from the innermost window to the outermost and back, in all runs.
    pub round_trips: u64,
    /// Frames with equal weights that would say as much of the bound part, in all runs.
    pub bound_frames: f64,
    /// The same for the free body.
    pub free_frames: f64,
}

/// The windows of a part.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Windows {
    /// ln d_k.
    centres: Vec<f64>,
    /// (1.5/s)².
    stiffness: f64,
    /// Displacements between which the body is free, Å.
    pub free_angstrom: [f64; 2],
}

impl Windows {
    /// Windows from a displacement within the well to the middle of the range in which the body is free, Å.
    pub fn new(inner_angstrom: f64, free_angstrom: [f64; 2], count: usize) -> Self {
        let outer_angstrom = (free_angstrom[0] * free_angstrom[1]).sqrt();
        let spacing = (outer_angstrom / inner_angstrom).ln() / (count - 1) as f64;
        let centre = |number: usize| inner_angstrom.ln() + spacing * number as f64;
        Self {
            centres: (0..count).map(centre).collect(),
            stiffness: (SPACING / spacing).powi(2),
            free_angstrom,
        }
    }

    pub fn count(&self) -> usize {
        self.centres.len()
    }

    /// Displacement in the middle of a window, Å.
    pub fn displacement_angstrom(&self, window: usize) -> f64 {
        self.centres[window].exp()
    }

    /// Bias of a window, kT; infinite beyond the outer wall.
    pub fn bias_kt(&self, window: usize, displacement_angstrom: f64) -> f64 {
        if displacement_angstrom >= self.free_angstrom[1] {
            return f64::INFINITY;
        }
        let from_centre = displacement_angstrom.ln() - self.centres[window];
        let is_flat =
            (window == 0 && from_centre < 0.0) || (window + 1 == self.count() && from_centre > 0.0);
        match is_flat {
            true => 0.0,
            false => 0.5 * self.stiffness * from_centre.powi(2),
        }
    }
}
