//! Windows between a part whose last body is in its place and one from which it is far away.
//!
//! The coordinates are the displacement d of the last body from its place next to the body that it is attached to (root mean
//! square over its points), and the share λ of its energy U with the others that acts. A body that is pulled over a rough
//! surface with deep contacts is caught in other poses, so the way leads around them:
//!
//! ```text
//! u_k = w_k(d) + λ_k U    w_k = ½ (1.5/s)² (ln d - ln d_k)²     with the spacing s of a leg, in ln d
//!
//! bound --confine-- bound in its place --decouple-- without energy in its place --release-- free
//!    |      λ = 1, d_k inwards              λ from 1 to 0              λ = 0, d_k outwards    |
//!    +------------------ decouple within the limit, λ from 1 to 0 ---------------------------+
//! ```
//!
//! A narrow well is found by the way through the place, a wide one by that within the limit. Where λ > 0, w_k acts beyond
//! d_k only, and there is a wall at the limit. While a body is released it acts on both sides; it is flat below the first
//! d_k and above the last.

use crate::Result;
use crate::error::require;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Settings of windows.
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
    /// Share of the exchanges that were accepted between the two windows that hold up the best way from bound to free.
    pub least_exchanged: f64,
    /// Displacement between these two windows, Å.
    pub least_exchanged_angstrom: f64,
    /// Ways of a simulation from the window of the bound part to that of the free body and back, in all runs.
    pub round_trips: u64,
    /// Frames with equal weights that would say as much of the bound part, in all runs.
    pub bound_frames: f64,
    /// The same for the free body.
    pub free_frames: f64,
}

/// Displacement at which a body is decoupled, of the limit.
const INNERMOST: f64 = 0.1;

/// A window.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    /// ln d_k.
    ln_centre: f64,
    /// (1.5/s)².
    stiffness: f64,
    /// Whether the bias acts below and above d_k.
    sides: [bool; 2],
    /// Share λ of the energy of the last body that acts.
    coupling: f64,
}

impl Window {
    /// A window of a body that is not beyond a displacement.
    fn within(ln_centre: f64, spacing: f64, coupling: f64) -> Self {
        Self {
            ln_centre,
            stiffness: (SPACING / spacing).powi(2),
            sides: [false, true],
            coupling,
        }
    }
}

/// The windows of a part.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Windows {
    /// Windows, that of the bound part first.
    windows: Vec<Window>,
    /// Pairs of windows that exchange their states.
    pub links: Vec<[usize; 2]>,
    /// Number of the window of the free body.
    pub free_window: usize,
    limit_angstrom: f64,
    /// Displacements between which the body is free, Å.
    pub free_angstrom: [f64; 2],
}

impl Windows {
    /// Windows from a body within its limit to one in the middle of the range in which it is free, Å. A sixth of them confine
    /// it, a sixth decouple it in its place and a sixth within the limit; the others release it.
    pub fn new(limit_angstrom: f64, free_angstrom: [f64; 2], count: usize) -> Self {
        let wide = count / 6;
        let leg = wide.max(1);
        let ln_limit = limit_angstrom.ln();
        let inner = ln_limit + INNERMOST.ln();
        let outer = 0.5 * (free_angstrom[0] * free_angstrom[1]).ln();
        let confining = (ln_limit - inner) / leg as f64;
        let mut windows = Vec::with_capacity(count);
        for number in 0..leg {
            let ln_centre = ln_limit - confining * number as f64;
            windows.push(Window::within(ln_centre, confining, 1.0));
        }
        for number in 0..leg {
            let coupling = 1.0 - number as f64 / leg as f64;
            windows.push(Window::within(inner, confining, coupling));
        }
        let released = count - 2 * leg - wide;
        let releasing = (outer - inner) / (released - 1) as f64;
        for number in 0..released {
            windows.push(Window {
                ln_centre: inner + releasing * number as f64,
                stiffness: (SPACING / releasing).powi(2),
                sides: [number > 0, number + 1 < released],
                coupling: 0.0,
            });
        }
        let free_window = windows.len() - 1;
        let mut links: Vec<[usize; 2]> = (0..free_window).map(|k| [k, k + 1]).collect();
        let mut last = 0;
        for number in 0..wide {
            let coupling = 1.0 - (number + 1) as f64 / (wide + 1) as f64;
            links.push([last, windows.len()]);
            last = windows.len();
            windows.push(Window::within(ln_limit, confining, coupling));
        }
        if wide > 0 {
            let steps = ((ln_limit - inner) / releasing).floor() as usize;
            links.push([last, 2 * leg + steps]);
        }
        Self {
            windows,
            links,
            free_window,
            limit_angstrom,
            free_angstrom,
        }
    }

    pub fn count(&self) -> usize {
        self.windows.len()
    }

    /// Displacement in the middle of a window, Å.
    pub fn displacement_angstrom(&self, window: usize) -> f64 {
        self.windows[window].ln_centre.exp()
    }

    /// Share of the energy of the last body with the others that acts in a window.
    pub fn coupling(&self, window: usize) -> f64 {
        self.windows[window].coupling
    }

    /// Displacement beyond which a body never is in a window, Å.
    pub fn wall_angstrom(&self, window: usize) -> f64 {
        match self.coupling(window) > 0.0 {
            true => self.limit_angstrom,
            false => self.free_angstrom[1],
        }
    }

    /// Bias of a window on the displacement, kT; infinite beyond its wall.
    pub fn bias_kt(&self, window: usize, displacement_angstrom: f64) -> f64 {
        if displacement_angstrom >= self.wall_angstrom(window) {
            return f64::INFINITY;
        }
        let window = &self.windows[window];
        let from_centre = displacement_angstrom.ln() - window.ln_centre;
        match window.sides[usize::from(from_centre > 0.0)] {
            true => 0.5 * window.stiffness * from_centre.powi(2),
            false => 0.0,
        }
    }

    /// Energy of a state in a window: its bias, and the share of the energy of the last body that acts, kT.
    pub fn energy_kt(&self, window: usize, displacement_angstrom: f64, meeting_kt: f64) -> f64 {
        let bias_kt = self.bias_kt(window, displacement_angstrom);
        match self.coupling(window) {
            0.0 => bias_kt,
            coupling => bias_kt + coupling * meeting_kt,
        }
    }

    /// A window in words.
    pub fn name(&self, window: usize) -> String {
        let percent = 100.0 * self.coupling(window);
        let angstrom = self.displacement_angstrom(window);
        format!("{angstrom:.1} Å and {percent:.0} % of the energy")
    }

    /// Number of the link that holds up the best way from the bound part to the free body, from the share of accepted
    /// exchanges of each link.
    pub fn narrowest_link(&self, exchanged: &[f64]) -> usize {
        let mut order: Vec<usize> = (0..self.links.len()).collect();
        order.sort_by(|a, b| exchanged[*b].total_cmp(&exchanged[*a]));
        // Links are added, the best first, until they join both ends: groups of windows grow together.
        let mut groups: Vec<usize> = (0..self.count()).collect();
        for link in order {
            let [a, b] = self.links[link].map(|window| groups[window]);
            for group in &mut groups {
                if *group == b {
                    *group = a;
                }
            }
            if groups[0] == groups[self.free_window] {
                return link;
            }
        }
        0
    }
}
