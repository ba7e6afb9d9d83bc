//! What a simulation leaves behind while it runs: `log.csv` and `trajectory.gsd`.

use super::columns::Measured;
use super::log::ChargeRow;
use super::trajectory::Trajectory;
use super::{Engine, LogRow, RunSettings};
use anyhow::Result;
use protomer_mc::Simulation;
use protomer_results::{Log, LogMark, log};
use serde::{Deserialize, Serialize};
use std::path::Path;

const LOG: &str = "log.csv";
/// Net charges of the bodies, where they change.
const CHARGES: &str = "charges.csv";
const TRAJECTORY: &str = "trajectory.gsd";

/// The open files of a simulation.
pub struct Outputs {
    log: Log,
    charges: Option<Log>,
    trajectory: Option<Trajectory>,
    cluster_moves_logged: (u64, u64),
}

/// The part of the files that belongs to a checkpoint.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedOutputs {
    /// The rows of the log.
    pub log: LogMark,
    /// The rows of the charges; empty where they are fixed.
    #[serde(default, skip_serializing_if = "LogMark::is_empty")]
    pub charges: LogMark,
    /// Frames of the trajectory.
    pub trajectory_frames: u64,
    /// Cluster moves, and bodies they moved, at the last row of the log.
    pub cluster_moves_logged: (u64, u64),
}

impl Outputs {
    /// Opens the files in a directory, cut to the saved part.
    ///
    /// # Errors
    /// If a file cannot be written, was changed since, or has columns of another version.
    pub fn open(
        directory: &Path,
        engine: &Engine,
        settings: &RunSettings,
        saved: &SavedOutputs,
    ) -> Result<Self> {
        let path = directory.join(LOG);
        let log = Log::open::<LogRow>(&path, &saved.log)?;
        let charges = match settings.proton_moves_per_sweep {
            0 => None,
            _ => Some(Log::open::<ChargeRow>(
                &directory.join(CHARGES),
                &saved.charges,
            )?),
        };
        let trajectory = match settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                let frames = saved.trajectory_frames;
                Some(Trajectory::open(&path, engine.assembly(), frames)?)
            }
        };
        Ok(Self {
            log,
            charges,
            trajectory,
            cluster_moves_logged: saved.cluster_moves_logged,
        })
    }

    /// Writes the row and the frame that are due. Equilibration writes neither.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&mut self, settings: &RunSettings, simulation: &Simulation) -> Result<()> {
        let sweep = simulation.sweep();
        let production = sweep.saturating_sub(settings.equilibration_sweeps);
        if production == 0 {
            self.cluster_moves_logged = (0, 0);
            return Ok(());
        }
        if production.is_multiple_of(settings.log_every) {
            let row = self.row(production, simulation);
            self.log.append(&row)?;
            if let (Some(log), Some(charges_e)) = (&mut self.charges, simulation.net_charges_e()) {
                log.append(&ChargeRow::new(production, &charges_e))?;
            }
        }
        if let Some(trajectory) = &mut self.trajectory
            && production.is_multiple_of(settings.trajectory_every)
        {
            trajectory.append(production, simulation)?;
        }
        Ok(())
    }

    /// Flushes everything to disk.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn save(&mut self) -> Result<SavedOutputs> {
        let trajectory_frames = match &mut self.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        Ok(SavedOutputs {
            log: self.log.sync()?,
            charges: match &mut self.charges {
                Some(log) => log.sync()?,
                None => LogMark::default(),
            },
            trajectory_frames,
            cluster_moves_logged: self.cluster_moves_logged,
        })
    }

    fn row(&mut self, production: u64, simulation: &Simulation) -> LogRow {
        let state = Measured {
            observables: simulation.observables(),
            cluster_moved: self.bodies_per_cluster_move(simulation),
        };
        LogRow::new(production, &state)
    }

    /// Mean number of bodies moved per cluster move since the last row.
    fn bodies_per_cluster_move(&mut self, simulation: &Simulation) -> f64 {
        let statistics = simulation.statistics();
        let counted = (statistics.cluster_moves, statistics.cluster_bodies);
        let before = std::mem::replace(&mut self.cluster_moves_logged, counted);
        let (moves, bodies) = (counted.0 - before.0, counted.1 - before.1);
        if moves == 0 {
            0.0
        } else {
            bodies as f64 / moves as f64
        }
    }
}

impl SavedOutputs {
    /// Checks the log against the saved part.
    ///
    /// # Errors
    /// If it was changed or lost.
    pub fn check(&self, directory: &Path) -> Result<()> {
        if !self.charges.is_empty() {
            log::check(&directory.join(CHARGES), &self.charges)?;
        }
        Ok(log::check(&directory.join(LOG), &self.log)?)
    }
}
