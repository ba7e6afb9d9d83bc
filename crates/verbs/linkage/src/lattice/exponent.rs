//! `lyapunov.json`: the maximal Lyapunov exponent of one run of a sweep.
//!
//! The exponent belongs to the trajectory from the start of the run, with the run's integrator and
//! the steps that it took.

use super::settings::LatticeSettings;
use super::start::begin;
use anyhow::{Context, Result};
use protomer_io::atomic::write_atomically;
use protomer_linkage::analysis::lyapunov::{
    LyapunovExponent, LyapunovSettings, Neighbours, SteppedFlow,
};
use protomer_linkage::lattice::Mover;
use protomer_results::{End, Interrupt, keys};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = "lyapunov.json";

/// A maximal Lyapunov exponent, or the reason why it could not be measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exponent {
    /// Settings of the measurement.
    pub settings: LyapunovSettings,
    /// The time step.
    #[serde(default)]
    pub time_step: f64,
    /// Exponent λ, 1/time.
    pub exponent: Option<f64>,
    /// Standard error of the exponent.
    pub standard_error: Option<f64>,
    /// Reason why the trajectory or its neighbour could not be completed.
    pub failure: Option<String>,
}

/// Measures the exponent of a run and writes it into the run's directory, or reads it if it is
/// already there.
///
/// # Errors
/// For invalid settings, a damaged file, or a file that cannot be written. A trajectory that cannot
/// be completed is not an error; the file states the reason.
pub fn measure(
    settings: &LatticeSettings,
    time_step: f64,
    lyapunov: &LyapunovSettings,
    directory: &Path,
    interrupt: &Interrupt,
) -> Result<End<Exponent>> {
    let lyapunov = LyapunovSettings {
        seed: lyapunov.seed.wrapping_add(settings.seed),
        ..*lyapunov
    };
    let path = directory.join(FILE);
    if let Some(present) = read(&path)?
        && present.settings == lyapunov
        && present.time_step == time_step
    {
        return Ok(End::Finished(present));
    }
    let exponent = match follow(settings, time_step, &lyapunov, interrupt) {
        Ok(End::Stopped) => return Ok(End::Stopped),
        Ok(End::Finished(estimate)) => Exponent {
            settings: lyapunov,
            time_step,
            exponent: Some(estimate.exponent),
            standard_error: Some(estimate.standard_error),
            failure: None,
        },
        Err(error) => Exponent {
            settings: lyapunov,
            time_step,
            exponent: None,
            standard_error: None,
            failure: Some(format!("{error:#}")),
        },
    };
    let text = serde_json::to_string_pretty(&exponent).context(FILE)?;
    write_atomically(&path, |file| writeln!(file, "{text}"))?;
    Ok(End::Finished(exponent))
}

fn read(path: &Path) -> Result<Option<Exponent>> {
    if !path.exists() {
        return Ok(None);
    }
    let bytes = protomer_io::input::read(path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    Ok(Some(keys::from_json(path, &bytes)?))
}

fn follow(
    settings: &LatticeSettings,
    time_step: f64,
    lyapunov: &LyapunovSettings,
    interrupt: &Interrupt,
) -> Result<End<LyapunovExponent>> {
    let begun = begin(settings)?;
    let (network, motion) = (Arc::new(begun.network), settings.motion()?);
    let mut state = begun.state;
    let mut flow = SteppedFlow::new(Mover::new(&motion, network.clone(), &state)?, time_step);
    let neighbour = Mover::new(&motion, network.clone(), &state)?;
    let mut neighbour_flow = SteppedFlow::new(neighbour, time_step);
    let mut neighbours = Neighbours::new(
        &network,
        &mut flow,
        &mut neighbour_flow,
        &mut state,
        lyapunov,
    )?;
    while !neighbours.is_done() {
        if interrupt.is_requested() {
            return Ok(End::Stopped);
        }
        neighbours.advance()?;
    }
    Ok(End::Finished(neighbours.exponent()))
}
