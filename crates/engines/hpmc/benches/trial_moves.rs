//! Trial moves per CPU-second of hard bodies.
//!
//! `cargo bench -p protomer-hpmc --bench trial_moves [-- PART_OF_A_NAME]`
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "test code")]

#[allow(dead_code)]
#[path = "../../../base/kernel/benches/cpu_time/mod.rs"]
mod cpu_time;

use cpu_time::{are_requested, cpu_seconds};
use protomer_hpmc::body::HardBody;
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::simulation::{Settings, Simulation};
use protomer_hpmc::start::Start;
use protomer_kernel::shape::{Shape, builders::by_name};

fn main() {
    if !are_requested() {
        return;
    }
    let disk = Shape::flat(&[[0.0, 0.0]]).unwrap();
    let solid = by_name("truncated-tetrahedron:0.6666666666666666").unwrap();
    let solid = HardBody::<3>::new(&solid, 0.0).unwrap();
    measure(
        "truncated tetrahedra, N = 1000, 0.50",
        &solid,
        &[],
        1000,
        0.5,
    );
    for (q, packing) in [(0.1, 0.1), (0.2, 0.2)] {
        let radius = q * solid.outer_radius;
        let density = packing / (4.0 / 3.0 * std::f64::consts::PI * radius.powi(3));
        let depletants = [Depletant {
            radius,
            fugacity: density,
        }];
        let name = format!("the same, 0.40, depletants q = {q}, reservoir {packing}");
        measure(&name, &solid, &depletants, 1000, 0.4);
    }
    let square = HardBody::<2>::new(&by_name("polygon:4").unwrap(), 0.0).unwrap();
    measure("squares, N = 1024, 0.60", &square, &[], 1024, 0.6);
    let disk = HardBody::<2>::new(&disk, 0.5).unwrap();
    measure("disks, N = 1024, 0.65", &disk, &[], 1024, 0.65);
}

fn measure<const D: usize>(
    name: &str,
    body: &HardBody<D>,
    depletants: &[Depletant],
    bodies: usize,
    packing_fraction: f64,
) {
    let asked = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'));
    if asked.is_some_and(|part| !name.contains(&part)) {
        return;
    }
    let settings = Settings {
        seed: 1,
        equilibration_sweeps: 400,
        ..Settings::default()
    };
    let mut simulation = Simulation::new(
        &settings,
        body,
        depletants,
        &Start::fluid(bodies, packing_fraction),
    )
    .unwrap();
    simulation.run(settings.equilibration_sweeps).unwrap();
    let begin = cpu_seconds();
    while cpu_seconds() - begin < 2.0 {
        simulation.run(20).unwrap();
    }
    let counts = simulation.counts().total();
    let rate = counts.trials as f64 / (cpu_seconds() - begin);
    let acceptance = counts.acceptance();
    println!("{name}: {rate:.3e} trial moves per CPU-second, acceptance {acceptance:.2}");
}
