//! Steps per CPU-second of a lattice, and their accuracy.
//!
//! The start is half open, θ = ± 0.4, with random angular velocities, ω drawn evenly from -1 to 1;
//! the time step is the automatic one (`time_step = "auto"`). In this state rods of every length
//! and lattices of every size are well resolved. The fully open state would be a poor start: it is
//! the state of largest extension, and squares that leave it independently strain their rods, the
//! more the larger the lattice.

use super::settings::{LatticeSettings, Start, TimeStep, Velocities};
use super::start::{begin, time_step};
use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_common::cpu_time::ThreadClock;
use protomer_common::range;
use protomer_linkage::lattice::Mover;
use serde::Serialize;
use std::sync::Arc;

/// The result of [`bench()`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticeBench {
    /// Number of rows and of columns.
    pub ns: usize,
    /// Number of squares.
    pub squares: usize,
    /// Number of rods.
    pub rods: usize,
    /// Length of the rods.
    pub r0: f64,
    /// Amplitude of the initial orientations: θ is plus or minus this angle.
    pub start_angle: f64,
    /// Time step.
    pub time_step: f64,
    /// Number of steps.
    pub steps: u64,
    /// Whether squares collided.
    pub collisions: bool,
    /// Steps per second of the thread's CPU time, without set-up.
    pub steps_per_cpu_second: f64,
    /// CPU time of the set-up, s.
    pub setup_seconds: f64,
    /// Largest deviation of a rod from its length, sampled a hundred times and at the end.
    pub max_rod_violation: f64,
    /// Largest relative deviation of the energy from its initial value, sampled as often.
    pub energy_error: f64,
    /// Number of collisions.
    pub events: u64,
}

impl Answer for LatticeBench {
    fn text(&self) -> String {
        format!(
            "{:.0} steps of {} per CPU-second, {} squares, {} rods, rods off by at most {:.1e}, energy \
             by {:.1e}, {} collisions",
            self.steps_per_cpu_second,
            self.time_step,
            self.squares,
            self.rods,
            self.max_rod_violation,
            self.energy_error,
            self.events
        )
    }
}

/// Initial angle, between closed (0) and open (π/4).
const START_ANGLE_RAD: f64 = 0.4;

/// Number of samples per benchmark.
const LOOKS: u64 = 100;
/// The longest automatic step: that of the replays, which conserves the energy to about 1e-5.
const LONGEST_AUTOMATIC_STEP: f64 = 1e-3;

/// Runs and measures the steps.
///
/// # Errors
/// For invalid settings, or a step that fails.
pub fn bench(settings: &LatticeSettings, steps: u64) -> Result<LatticeBench> {
    range::MOVES.require("--steps", steps)?;
    let setup = ThreadClock::start();
    let start_angle = Start::Angle(START_ANGLE_RAD);
    let settings = LatticeSettings {
        velocities: Velocities::Random,
        start: start_angle,
        ..settings.clone()
    };
    let begun = begin(&settings)?;
    let time_step = match (settings.time_step, time_step(&settings, &begun)?) {
        (TimeStep::Fixed(step), _) => step,
        (TimeStep::Named(_), step) => step.min(LONGEST_AUTOMATIC_STEP),
    };
    let mut state = begun.state.clone();
    let mut mover = Mover::new(&settings.motion()?, Arc::new(begun.network), &state)?;
    let first_energy = mover.energy(&state);
    let setup_seconds = setup.seconds();
    let (mut max_rod_violation, mut energy_error, mut done) = (0.0_f64, 0.0_f64, 0);
    let clock = ThreadClock::start();
    while done < steps {
        let until = (done + steps.div_ceil(LOOKS)).min(steps);
        for step in done..until {
            mover.step(&mut state, time_step, step)?;
        }
        done = until;
        max_rod_violation = max_rod_violation.max(mover.rod_violation(&state));
        energy_error = energy_error.max((mover.energy(&state) / first_energy - 1.0).abs());
    }
    // This includes the samples, each of which costs less than a step.
    let seconds = clock.seconds();
    Ok(LatticeBench {
        ns: settings.rows,
        squares: mover.network().squares.len(),
        rods: mover.network().rods.len(),
        r0: settings.r0,
        start_angle: START_ANGLE_RAD,
        time_step,
        steps,
        collisions: settings.collisions,
        steps_per_cpu_second: steps as f64 / seconds,
        setup_seconds,
        max_rod_violation,
        energy_error,
        events: mover.events(),
    })
}
