//! Steps per second of processor time on one core, for bodies that have been compressed and brought
//! to a temperature:
//!
//! ```text
//! cargo bench -p protomer-md --bench dynamics [-- packing fraction in a plane, in space]
//! ```
//!
//! The packing fraction counts bodies with a layer of half the repulsion's length. Times are the
//! best of several blocks.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use protomer_kernel::shape::builders::by_name;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::shape::{Shape, measures::Measures};
use protomer_md::bath::Ensemble;
use protomer_md::body::Kind;
use protomer_md::engine::{Engine, Settings};
use protomer_md::pair::{CONTACT_RATIO, Form};
use protomer_md::start::{free_density, on_a_lattice, set_velocities};
use protomer_md::state::Bodies;
use std::time::Instant;

const BLOCKS: usize = 5;
const SECONDS_PER_BLOCK: f64 = 1.0;
const TIME_STEP: f64 = 1e-4;

/// Processor time of this thread; where the system does not tell, wall-clock time.
fn seconds(origin: &Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next();
    match nanoseconds.and_then(|word| word.parse::<f64>().ok()) {
        Some(nanoseconds) => 1e-9 * nanoseconds,
        None => origin.elapsed().as_secs_f64(),
    }
}

/// The number density at which bodies with their layer fill this part of the space.
fn density(kind: &Kind, packing_fraction: f64) -> f64 {
    let corners = &kind.parts[0].polytope.corners;
    let shape = match kind.dimension {
        2 => Shape::flat(&corners.iter().map(|x| [x.x, x.y]).collect::<Vec<_>>()),
        _ => Shape::solid(corners),
    };
    let layer = CONTACT_RATIO * kind.inradius();
    packing_fraction / Measures::from_shape(&shape.unwrap(), layer).unwrap().volume
}

fn compressed(name: &str, count: usize, packing_fraction: f64) -> Engine {
    let kind =
        Kind::from_polytope(&Polytope::from_shape(&by_name(name).unwrap()).unwrap()).unwrap();
    let kind = kind.of_unit_volume().unwrap();
    let density = density(&kind, packing_fraction);
    let bodies = Bodies::of_one_kind(kind, count);
    let start = free_density(&bodies).min(density);
    let mut state = on_a_lattice(&bodies, start, 5).unwrap();
    set_velocities(&mut state, &bodies, 1.0, 5).unwrap();
    let settings = Settings {
        interaction: Form::FaceSum.into(),
        time_step: 1e-3,
        ensemble: Ensemble::Nvt {
            temperature: 1.0,
            relaxation_time: 0.05,
        },
        seed: 1,
        is_threaded: false,
    };
    const STEPS: i32 = 8000;
    let dimension = bodies.dimension() as f64;
    let scale = (start / density).powf(1.0 / (dimension * f64::from(STEPS)));
    let mut engine = Engine::new(bodies, state, settings).unwrap();
    for _ in 0..STEPS {
        engine.step(scale).unwrap();
    }
    for _ in 0..4000 {
        engine.step(1.0).unwrap();
    }
    engine
}

fn measure(start: &Engine, form: Form) -> f64 {
    let settings = Settings {
        interaction: form.into(),
        time_step: TIME_STEP,
        ensemble: Ensemble::Nve,
        ..*start.settings()
    };
    let motion = start.motion().clone();
    let mut engine = Engine::continued(start.bodies().clone(), motion, settings).unwrap();
    let origin = Instant::now();
    let mut best = 0.0_f64;
    for _ in 0..BLOCKS {
        let began = seconds(&origin);
        let (mut steps, mut spent) = (0, 0.0);
        while spent < SECONDS_PER_BLOCK {
            for _ in 0..50 {
                engine.step(1.0).unwrap();
            }
            steps += 50;
            spent = seconds(&origin) - began;
        }
        best = best.max(f64::from(steps) / spent);
    }
    best
}

fn main() {
    let given: Vec<f64> = std::env::args()
        .skip(1)
        .filter_map(|word| word.parse().ok())
        .collect();
    let fraction = |place: usize, default: f64| given.get(place).copied().unwrap_or(default);
    for (name, count, packing_fraction) in [
        ("polygon:4", 1000, fraction(0, 0.6)),
        ("octahedron", 500, fraction(1, 0.5)),
    ] {
        let start = compressed(name, count, packing_fraction);
        for form in [Form::Contact, Form::FaceSum, Form::Smooth] {
            let steps = measure(&start, form);
            println!(
                "{count} {name} at {packing_fraction}, {form:?}: {steps:.0} steps per CPU-second, \
                 {:.2e} body-steps",
                steps * count as f64
            );
        }
    }
}
