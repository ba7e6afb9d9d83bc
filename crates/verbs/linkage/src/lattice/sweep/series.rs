//! The result of a run, and how it went: averages over the runs of a condition are made of these.

use super::plan::Task;
use crate::lattice::exponent::Exponent;
use crate::lattice::log::LogRow;
use crate::lattice::run::LatticeResult;
use crate::lattice::start::network;
use crate::lattice::trajectory::read_states;
use anyhow::Result;
use protomer_kernel::statistics::RunningMoments;
use protomer_linkage::analysis::crossings::{Crossing, crossings};
use protomer_linkage::analysis::domains::{Domains, SideCorrelation, sides};
use protomer_linkage::analysis::locking::Locking;
use protomer_linkage::analysis::synchronisation::{
    Synchronisation, root_mean_square_difference, staggered,
};
use std::f64::consts::FRAC_PI_4;

/// Outcome of one run of the sweep.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// The run was completed.
    Done(Box<RunOutcome>),
    /// The run could not be completed, for this reason.
    Failed(String),
}

impl Outcome {
    pub(super) fn done(result: LatticeResult, exponent: Option<Exponent>) -> Self {
        Self::Done(Box::new(RunOutcome { result, exponent }))
    }
}

/// The result of one run of the sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOutcome {
    /// Result of the run.
    pub result: LatticeResult,
    /// Lyapunov exponent of the run, if measured.
    pub exponent: Option<Exponent>,
}

/// Coherence of the frames of one run; NaN without frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coherence {
    /// Time from which all phases are locked; NaN if they are not at the end.
    pub locking_time: f64,
    /// Mean number of domains.
    pub domains: f64,
    /// Mean share of the squares in the largest domain.
    pub largest_domain: f64,
}

/// The time series of a run or, once merged, of all runs of a condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Pairs of a time and the root mean square difference of two angles, averaged over runs.
    pub phase_differences: Vec<[f64; 2]>,
    /// Strains along x and y since the last row of the log.
    pub strains: Vec<[f64; 2]>,
    /// Averages of exp i(θ_a - θ_b).
    pub synchronisation: Synchronisation,
    /// Correlation of the sides to which squares close, against their distance.
    pub correlation: SideCorrelation,
    /// Pairs of the amplitude of the checkerboard mode and its rate, run by run.
    pub orbits: Vec<Vec<[f64; 2]>>,
    /// Passages of the checkerboard mode through the open state, run by run.
    pub crossings: Vec<Vec<Crossing>>,
}

impl Series {
    /// The time series of a condition without any completed run.
    pub(super) fn empty(task: &Task) -> Result<Self> {
        let network = network(&task.settings)?;
        let squares = network.squares.len();
        Ok(Self {
            phase_differences: Vec::new(),
            strains: Vec::new(),
            synchronisation: Synchronisation::new(squares),
            correlation: SideCorrelation::new(&network),
            orbits: Vec::new(),
            crossings: Vec::new(),
        })
    }

    /// Reads the log and the trajectory of a run.
    pub(super) fn of_run(task: &Task, rows: &[LogRow], bound: f64) -> Result<(Self, Coherence)> {
        let network = network(&task.settings)?;
        let mut synchronisation = Synchronisation::new(network.squares.len());
        let mut phase_differences = Vec::new();
        let mut correlation = SideCorrelation::new(&network);
        let mut locking = Locking::within(bound);
        let (mut count, mut largest) = (RunningMoments::default(), RunningMoments::default());
        if task.settings.trajectory_every > 0 {
            for (time, positions) in read_states(&task.directory.join("trajectory.gsd"))? {
                let angles = staggered(&network, &positions);
                synchronisation.push(&angles)?;
                phase_differences.push([time, root_mean_square_difference(&angles)]);
                locking.push(time, &angles);
                let sides = sides(&network, &positions);
                correlation.push(&sides)?;
                let domains = Domains::find(&network, &sides);
                count.push(domains.count as f64);
                largest.push(domains.largest as f64 / sides.len() as f64);
            }
        }
        let (mut amplitudes, mut strains) = (Vec::new(), Vec::new());
        let mut orbit = Vec::with_capacity(rows.len());
        for (number, row) in rows.iter().enumerate() {
            amplitudes.push([row.time, row.checkerboard]);
            orbit.push([row.checkerboard, row.checkerboard_rate]);
            if number > 0 {
                strains.push([row.step_strain_xx, row.step_strain_yy]);
            }
        }
        let mean = |moments: &RunningMoments| match moments.count() {
            0 => f64::NAN,
            _ => moments.mean(),
        };
        let coherence = Coherence {
            locking_time: locking.since().unwrap_or(f64::NAN),
            domains: mean(&count),
            largest_domain: mean(&largest),
        };
        let series = Self {
            phase_differences,
            strains,
            synchronisation,
            correlation,
            orbits: vec![orbit],
            crossings: vec![crossings(&amplitudes, FRAC_PI_4)],
        };
        Ok((series, coherence))
    }

    /// Merges a run into the mean over `runs` others. Phase differences are a running mean over
    /// frames of equal index, because time steps may differ slightly.
    pub(super) fn merge(&mut self, other: Self, earlier_runs: usize) -> Result<()> {
        let runs = earlier_runs as f64 + 1.0;
        let frames = self.phase_differences.iter_mut();
        for (mean, [_, new]) in frames.zip(&other.phase_differences) {
            mean[1] += (new - mean[1]) / runs;
        }
        self.strains.extend(other.strains);
        self.synchronisation.merge(&other.synchronisation)?;
        self.correlation.merge(&other.correlation)?;
        self.orbits.extend(other.orbits);
        self.crossings.extend(other.crossings);
        Ok(())
    }
}
