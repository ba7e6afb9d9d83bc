//! Collision-free steps of open square lattices per second of processor time on one core, and where
//! the time goes:
//!
//! ```text
//! cargo bench -p protomer-crystal --bench lattice [-- sizes...]
//! ```
//!
//! The start is the open coherent state with angular velocities U(-1, 1), projected onto the rods
//! and scaled so that the rod that turns fastest turns by 0.005 in a step: every size is resolved
//! alike. Times are the best of several blocks of a quarter of a second or more.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use protomer_crystal::lattice::{Dynamics, Edges, Network, Square, State};
use protomer_kernel::random::CounterRng;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;
use std::time::Instant;

const STEP: f64 = 1e-3;
const BLOCKS: usize = 4;
const TURN_PER_STEP: f64 = 0.005;

/// Processor time of this thread in seconds; where the system does not tell, the time since
/// `origin`.
fn thread_seconds(origin: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text
        .split_whitespace()
        .next()
        .and_then(|word| word.parse::<f64>().ok());
    nanoseconds.map_or_else(|| origin.elapsed().as_secs_f64(), |count| 1e-9 * count)
}

fn main() {
    // Nothing is timed under `cargo test`.
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|argument| argument == "--bench") {
        return;
    }
    let mut sizes: Vec<usize> = arguments
        .iter()
        .filter_map(|argument| argument.parse().ok())
        .collect();
    if sizes.is_empty() {
        sizes = vec![10, 32, 100, 316];
    }
    let origin = Instant::now();
    println!(
        "size steps/s corrections/step | ms: step factor+J solve violations | fill per rod, multiplications, fronts | worst rod, worst J v"
    );
    for size in sizes {
        let network =
            Network::lattice(size, size, 0.136, Square::default(), Edges::Open, FRAC_PI_4).unwrap();
        let network = Arc::new(network);
        let mut state = State::coherent(&network, FRAC_PI_4);
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
        let mut rng = CounterRng::new(1, 0, 0);
        for velocity in state.velocities.chunks_exact_mut(3) {
            velocity[2] = rng.uniform_in(-1.0, 1.0);
        }
        dynamics.project_velocities(&mut state.velocities);
        let rate = dynamics
            .rods()
            .largest_turning_rate(&state.positions, &state.velocities);
        state
            .velocities
            .iter_mut()
            .for_each(|velocity| *velocity *= TURN_PER_STEP / STEP / rate);
        dynamics.prepare(&state).unwrap();
        for _ in 0..3 {
            dynamics.step(&mut state, STEP).unwrap();
        }
        // The best of some blocks, in milliseconds per call.
        let time = |work: &mut dyn FnMut()| {
            let mut block = || {
                let (begin, mut calls) = (thread_seconds(origin), 0_u32);
                loop {
                    (0..(10_000 / (size * size)).max(1)).for_each(|_| work());
                    calls += (10_000 / (size * size)).max(1) as u32;
                    let seconds = thread_seconds(origin) - begin;
                    if seconds > 0.25 {
                        return 1e3 * seconds / f64::from(calls);
                    }
                }
            };
            (0..BLOCKS).map(|_| block()).fold(f64::INFINITY, f64::min)
        };
        let (before, mut steps) = (dynamics.corrections(), 0_u32);
        let per_step = time(&mut || {
            dynamics.step(&mut state, STEP).unwrap();
            steps += 1;
        });
        let corrections = (dynamics.corrections() - before) as f64 / f64::from(steps);
        let rods = dynamics.rods();
        let mut vector: Vec<f64> = (0..rods.len()).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let factor = time(&mut || rods.linearize(&state.positions).unwrap());
        let solve = time(&mut || rods.solve(&mut vector));
        let mut worst = (0, 0.0);
        let violations = time(&mut || worst = rods.violations(&state.positions, &mut vector));
        rods.apply(&state.velocities, &mut vector);
        let left = vector.iter().fold(0.0_f64, |left, x| left.max(x.abs()));
        let factored = dynamics.rods().factor();
        let fill = factored.fill() as f64 / factored.dimension() as f64;
        println!(
            "{size:4} {:9.2} {corrections:5.2} | {per_step:.4} {factor:.4} {solve:.4} {violations:.4} | {fill:.1} {:.2e} {} | \
             {:.1e} {left:.1e}",
            1e3 / per_step,
            factored.multiplications(),
            factored.fronts(),
            worst.1
        );
    }
}
