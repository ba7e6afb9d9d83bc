//! Time, error and bound of one pair energy by distance, on the benchmark state: direct sum and certified interval.
//!
//! `cargo bench -p protomer-mc --bench pair_energy`

#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, TriangleMesh, Vec3};
use protomer_mc::charges::ChargeCloud;
use protomer_mc::energy::certified::{Accuracy, ChargeTable};
use protomer_mc::energy::yukawa_energy_kt;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[allow(dead_code)]
type Unused = TriangleMesh;

fn main() {
    let Some(folder) = bench_folder() else {
        println!("skipped: the benchmark states (../shared/bench/data) are absent");
        return;
    };
    let rays: usize = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(10);
    let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0).expect("lengths are positive");
    let clouds = ["a", "b"].map(|name| ChargeCloud::new(&read_charges(&folder.join(format!("charges_{name}.xyzq")))));
    let start = Instant::now();
    let tables = clouds.each_ref().map(|cloud| ChargeTable::new(cloud, &yukawa, rays));
    println!(
        "set-up {:.2} s, {:?} MB",
        start.elapsed().as_secs_f64(),
        tables.each_ref().map(|t| t.memory_bytes() / 1_000_000)
    );
    let (boundary, bodies) = read_assembly(&folder.join("cluster16.json"));
    let mut rows: Vec<[f64; 6]> = Vec::new();
    for i in 0..bodies.len() {
        for j in i + 1..bodies.len() {
            let displacement = boundary.displacement(&bodies[i].1.position, &bodies[j].1.position);
            let relative = RelativePose::new(&bodies[i].1, &bodies[j].1, &displacement);
            let (a, b) = (bodies[i].0, bodies[j].0);
            let time = Instant::now();
            let direct = yukawa_energy_kt(&yukawa, &clouds[a], &clouds[b], &relative);
            let direct_time = time.elapsed().as_secs_f64();
            let mut row = vec![displacement.norm(), direct_time];
            for accuracy in [Accuracy::Fast, Accuracy::Fine] {
                let mut interval = None;
                let repeats = 20;
                let time = Instant::now();
                for _ in 0..repeats {
                    interval = tables[a].energy_interval(&tables[b], black_box(&relative), accuracy);
                }
                let seconds = time.elapsed().as_secs_f64() / f64::from(repeats);
                let interval = interval.expect("the cut-off is large");
                let error = (interval.middle_kt - direct).abs();
                assert!(error <= interval.error_kt, "{i} {j} {direct} {interval:?}");
                row.push(seconds);
                row.push(interval.error_kt);
                if accuracy == Accuracy::Fast {
                    println!(
                        "{i:2} {j:2} D {:5.1} direct {direct:10.6} {:.2} ms, fast {:.1} us error {error:.1e} bound {:.1e}",
                        row[0],
                        direct_time * 1e3,
                        seconds * 1e6,
                        interval.error_kt
                    );
                } else {
                    println!(
                        "                    fine {:.1} us error {error:.1e} bound {:.1e}",
                        seconds * 1e6,
                        interval.error_kt
                    );
                }
            }
            rows.push(row.try_into().expect("six numbers"));
        }
    }
    let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64;
    println!(
        "mean: direct {:.2} ms, fast {:.1} us bound {:.1e}, fine {:.1} us bound {:.1e}",
        mean(1) * 1e3,
        mean(2) * 1e6,
        mean(3),
        mean(4) * 1e6,
        mean(5)
    );
}

fn bench_folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/bench/data");
    folder.is_dir().then_some(folder)
}

include!("../tests/common/bench_states.rs");
