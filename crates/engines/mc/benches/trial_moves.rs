//! Trial moves per CPU-second on the sixteen bodies of the benchmark states.
//!
//! `cargo bench -p protomer-mc --bench trial_moves [-- RUNS]`
//!
//! The bodies drift apart as they move, and moves become easy; so the benchmark makes many short
//! runs, each from the saved state with its own seed, and counts the processor time of the
//! moves alone.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "test code"
)]

use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, TriangleMesh, Vec3};
use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn main() {
    let Some(folder) = bench_folder() else {
        println!(
            "skipped: the benchmark states are absent; PROTOMER_TEST_DATA names the folder with bench/data"
        );
        return;
    };
    let runs: u32 = std::env::args()
        .skip(1)
        .find_map(|argument| argument.parse().ok())
        .unwrap_or(40);
    let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0).expect("lengths are positive");
    for mesh in ["bumpy_1620.off", "bumpy_5120.off"] {
        for sweeps in [20, 200] {
            measure(
                &format!("hard only, {mesh}"),
                &system(&folder, mesh),
                Interaction::HardOnly,
                sweeps,
                runs,
            );
        }
    }
    let charged = Interaction::YukawaDirect(yukawa);
    measure(
        "3000 charges, direct sum, bumpy_1620.off",
        &system(&folder, "bumpy_1620.off"),
        charged,
        4,
        1,
    );
}

/// Steps as in the benchmark's protocol: 0.3 Å and, as root mean square, the angle of a quaternion
/// step of 0.02.
fn measure(name: &str, system: &System, interaction: Interaction, sweeps: u64, runs: u32) {
    let settings = Settings {
        translation_step_angstrom: 0.3,
        rotation_step_rad: 0.0447,
        equilibration_sweeps: 0,
        cluster_moves_per_sweep: 0,
        ..Settings::new(interaction)
    };
    let (mut seconds, mut trials, mut accepted) = (0.0, 0, 0);
    for run in 0..runs {
        let mut simulation = Simulation::new(system.clone(), settings, 1, run)
            .expect("the benchmark state is valid");
        let before = cpu_seconds();
        simulation
            .run_until(sweeps, &mut |_| ControlFlow::Continue(()))
            .expect("energies are finite");
        seconds += cpu_seconds() - before;
        let statistics = simulation.statistics();
        for kind in statistics.translation.iter().chain(&statistics.rotation) {
            trials += kind.trials;
            accepted += kind.accepted;
        }
    }
    let (rate, acceptance) = (trials as f64 / seconds, accepted as f64 / trials as f64);
    println!(
        "{name}: {rate:.1} trial moves per CPU-second ({runs} runs of {sweeps} sweeps, acceptance {acceptance:.3})"
    );
}

fn bench_folder() -> Option<PathBuf> {
    let root = std::env::var_os("PROTOMER_TEST_DATA")?;
    let folder = Path::new(&root).join("bench/data");
    folder.is_dir().then_some(folder)
}

fn system(folder: &Path, mesh: &str) -> System {
    let mesh = read_off(&folder.join(mesh));
    let kind = |name: &str| {
        let charges = read_charges(&folder.join(format!("charges_{name}.xyzq")));
        Arc::new(BodyType::new(name, &mesh, &charges).expect("the mesh bounds a solid"))
    };
    let (boundary, bodies) = read_assembly(&folder.join("cluster16.json"));
    System::new(vec![kind("a"), kind("b")], &bodies, boundary).expect("the state is valid")
}

include!("../tests/integration/common/bench_states.rs");

/// Processor time of this thread.
fn cpu_seconds() -> f64 {
    let statistics =
        std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux scheduler statistics");
    let nanoseconds = statistics
        .split_whitespace()
        .next()
        .and_then(|field| field.parse::<f64>().ok());
    nanoseconds.expect("the first field is a time") * 1e-9
}
