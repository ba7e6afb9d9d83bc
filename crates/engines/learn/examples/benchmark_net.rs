//! CPU time and memory of a small network: 8 x 3 x 32³ random numbers; convolutions 3 x 3 x 3 to
//! 16, 32 and 64 channels, each with ReLU and pooling; global average; a linear layer to 10; Adam,
//! cross entropy, f32.
//!
//! ```text
//! RAYON_NUM_THREADS=1 cargo run --release -p protomer-learn --example benchmark_net
//! ```
//!
//! Arguments: edge (32), samples (8), seconds (3), share of voxels that hold anything (1; less:
//! those of a spherical shell), groups of a group normalisation (0: none).
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "an example prints, and stops at what is wrong"
)]

use candle_core::{Device, Tensor};
use protomer_kernel::random::CounterRng;
use protomer_learn::{
    Adam, AdamSettings, BlockSettings, GlobalPooling, Network, NetworkSettings, cross_entropy,
};

/// CPU time of this process with all its threads, and its largest resident set.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // utime and stime, fields 14 and 15, in hundredths of a second; the name before them may hold
    // blanks.
    let after = stat.rsplit(')').next().unwrap_or_default();
    let ticks: f64 = after
        .split_whitespace()
        .skip(11)
        .take(2)
        .filter_map(|field| field.parse::<f64>().ok())
        .sum();
    ticks / 100.0
}

fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmHWM:"))
        .unwrap_or_default();
    line.split_whitespace()
        .nth(1)
        .and_then(|kib| kib.parse::<f64>().ok())
        .unwrap_or(f64::NAN)
        / 1024.0
}

/// Repeats `work` for about `seconds`; CPU ms per sample.
fn measure(samples: usize, seconds: f64, mut work: impl FnMut()) -> f64 {
    for _ in 0..3 {
        work();
    }
    let (start, mut repeats) = (cpu_seconds(), 0);
    while cpu_seconds() - start < seconds {
        work();
        repeats += 1;
    }
    1e3 * (cpu_seconds() - start) / (repeats * samples) as f64
}

fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .map(|text| text.parse::<f64>().unwrap());
    let mut next = |default: f64| arguments.next().unwrap_or(default);
    let (edge, samples, seconds) = (next(32.0) as usize, next(8.0) as usize, next(3.0));
    let (fill, groups) = (next(1.0), next(0.0) as usize);
    let groups = (groups > 0).then_some(groups);
    let block = |width| BlockSettings {
        width,
        kernel: 3,
        groups,
        pool: true,
    };
    let blocks = vec![block(16), block(32), block(64)];
    let settings = NetworkSettings {
        channels: 3,
        classes: 10,
        blocks,
        pooling: GlobalPooling::Average,
    };
    let network = Network::new(&settings, 1, &Device::Cpu).unwrap();
    let mut adam = Adam::new(network.parameters(), AdamSettings::default()).unwrap();
    let mut random = CounterRng::new(1, 0, 0);
    let voxels = edge.pow(3);
    let mut values = vec![0.0f32; samples * 3 * voxels];
    for sample in values.chunks_exact_mut(3 * voxels) {
        for voxel in 0..voxels {
            let half = 0.5 * edge as f64;
            let place = [voxel / edge / edge, voxel / edge % edge, voxel % edge]
                .map(|i| i as f64 + 0.5 - half);
            let distance = place.iter().map(|x| x * x).sum::<f64>().sqrt();
            let (radius, area) = (
                0.35 * edge as f64,
                4.0 * std::f64::consts::PI * (0.35 * edge as f64).powi(2),
            );
            if fill >= 1.0 || (distance - radius).abs() < 0.5 * fill * voxels as f64 / area {
                (0..3).for_each(|channel| {
                    sample[channel * voxels + voxel] = random.uniform_in(-1.7, 1.7) as f32
                });
            }
        }
    }
    let batch = Tensor::from_vec(values, (samples, 3, edge, edge, edge), &Device::Cpu).unwrap();
    let labels: Vec<u32> = (0..samples as u32).map(|i| i % 10).collect();
    let weights = vec![1.0; samples];
    let infer = measure(samples, seconds, || drop(network.predict(&batch).unwrap()));
    let infer_mib = peak_mib();
    let train = measure(samples, seconds, || {
        let loss = cross_entropy(&network.forward(&batch).unwrap(), &labels, &weights).unwrap();
        adam.step(&loss.backward().unwrap(), 1e-3, None).unwrap();
    });
    println!(
        "{samples} x 3 x {edge}^3, fill {fill}, groups {groups:?}, {} threads",
        rayon::current_num_threads()
    );
    println!("inference  {infer:8.2} CPU ms per sample, peak {infer_mib:6.0} MiB");
    println!(
        "training   {train:8.2} CPU ms per sample, peak {:6.0} MiB",
        peak_mib()
    );
}
