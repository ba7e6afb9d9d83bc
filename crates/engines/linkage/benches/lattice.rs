//! Collision-free steps of open square lattices per second of processor time on one core, and where
//! the time goes:
//!
//! ```text
//! cargo bench -p protomer-linkage --bench lattice [-- sizes...]
//! ```
//!
//! The start is the open coherent state with angular velocities U(-1, 1), projected onto the rods
//! and scaled so that the rod that turns fastest turns by 0.005 in a step: every size is resolved
//! alike. Times are the best of several blocks of a quarter of a second or more; the slowest block
//! tells what other work on the machine costs.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use protomer_kernel::random::CounterRng;
use protomer_linkage::lattice::{Dynamics, Edges, Network, Square, State};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;
use std::time::Instant;

const STEP: f64 = 1e-3;
const ROD_LENGTH: f64 = 0.136;
const TURN_PER_STEP: f64 = 0.005;
const BLOCKS: usize = 4;
const SECONDS_PER_BLOCK: f64 = 0.25;

/// Measures processor time of this thread; where the system does not tell, wall-clock time.
struct Clock {
    origin: Instant,
    /// Calls between two looks at the clock.
    calls_per_look: u32,
}

/// Milliseconds per call in the best and in the slowest block.
#[derive(Clone, Copy)]
struct Timing {
    best: f64,
    slowest: f64,
}

impl Clock {
    fn for_size(size: usize) -> Self {
        Self {
            origin: Instant::now(),
            calls_per_look: (10_000 / (size * size)).max(1) as u32,
        }
    }

    fn seconds(&self) -> f64 {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
        let nanoseconds = text.split_whitespace().next();
        match nanoseconds.and_then(|word| word.parse::<f64>().ok()) {
            Some(nanoseconds) => 1e-9 * nanoseconds,
            None => self.origin.elapsed().as_secs_f64(),
        }
    }

    fn time(&self, mut work: impl FnMut()) -> Timing {
        let mut timing = Timing {
            best: f64::INFINITY,
            slowest: 0.0,
        };
        for _ in 0..BLOCKS {
            let milliseconds = self.time_block(&mut work);
            timing.best = timing.best.min(milliseconds);
            timing.slowest = timing.slowest.max(milliseconds);
        }
        timing
    }

    fn time_block(&self, work: &mut impl FnMut()) -> f64 {
        let (begin, mut calls) = (self.seconds(), 0_u32);
        loop {
            for _ in 0..self.calls_per_look {
                work();
            }
            calls += self.calls_per_look;
            let seconds = self.seconds() - begin;
            if seconds > SECONDS_PER_BLOCK {
                return 1e3 * seconds / f64::from(calls);
            }
        }
    }
}

/// The start, after a few steps.
fn start(size: usize) -> (Dynamics, State) {
    let square = Square::default();
    let network = Network::lattice(size, size, ROD_LENGTH, square, Edges::Open, FRAC_PI_4).unwrap();
    let mut state = State::coherent(&network, FRAC_PI_4);
    let mut dynamics = Dynamics::new(Arc::new(network), Vec::new(), &state).unwrap();
    let mut rng = CounterRng::new(1, 0, 0);
    for velocity in state.velocities.chunks_exact_mut(3) {
        velocity[2] = rng.uniform_in(-1.0, 1.0);
    }
    dynamics.project_velocities(&mut state.velocities);
    let rods = dynamics.rods();
    let rate = rods.largest_turning_rate(&state.positions, &state.velocities);
    for velocity in &mut state.velocities {
        *velocity *= TURN_PER_STEP / STEP / rate;
    }
    dynamics.prepare(&state).unwrap();
    for _ in 0..3 {
        dynamics.step(&mut state, STEP).unwrap();
    }
    (dynamics, state)
}

fn measure(size: usize) {
    let (mut dynamics, mut state) = start(size);
    let clock = Clock::for_size(size);
    let (before, mut steps) = (dynamics.corrections(), 0_u32);
    let step = clock.time(|| {
        dynamics.step(&mut state, STEP).unwrap();
        steps += 1;
    });
    let corrections = (dynamics.corrections() - before) as f64 / f64::from(steps);
    let rods = dynamics.rods();
    let mut rng = CounterRng::new(2, 0, 0);
    let mut vector: Vec<f64> = (0..rods.len()).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
    let factor = clock.time(|| rods.linearize(&state.positions, 0.0).unwrap());
    let solve = clock.time(|| rods.solve(&mut vector));
    let mut worst = (0, 0.0);
    let violations = clock.time(|| worst = rods.violations(&state.positions, &mut vector));
    rods.apply(&state.velocities, &mut vector);
    let left = vector.iter().fold(0.0_f64, |left, x| left.max(x.abs()));
    let factored = rods.factor();
    let fill = factored.fill() as f64 / factored.dimension() as f64;
    println!(
        "{size:4} {:9.2} {:9.2} {corrections:5.2} | {:.4} {:.4} {:.4} {:.4} | {fill:.1} {:.2e} {} \
         | {:.1e} {left:.1e}",
        1e3 / step.best,
        1e3 / step.slowest,
        step.best,
        factor.best,
        solve.best,
        violations.best,
        factored.multiplications(),
        factored.fronts(),
        worst.1
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // Nothing is timed under `cargo test`.
    if !arguments.iter().any(|argument| argument == "--bench") {
        return;
    }
    let mut sizes: Vec<usize> = Vec::new();
    for argument in &arguments {
        sizes.extend(argument.parse::<usize>());
    }
    if sizes.is_empty() {
        sizes = vec![10, 32, 100, 316];
    }
    println!(
        "size steps/s slowest corrections/step | ms: step factor+J solve violations | fill per \
         rod, multiplications, fronts | worst rod, worst J v"
    );
    for size in sizes {
        measure(size);
    }
}
