//! What all figures share: lattices, the choice of the time step, threads, tables.

use protomer_kernel::statistics::RunningMoments;
use protomer_linkage::lattice::{CollisionSettings, Edges, Engine, Force, Network, Square, State};
use std::f64::consts::FRAC_PI_4;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// Anything that can go wrong.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// The step of the papers, after which states are looked at.
pub const FRAME: f64 = 0.01;
/// r0 / l of the lattices that are compared.
pub const LENGTHS: [f64; 7] = [0.02, 0.05, 3.0 / 22.0, 0.25, 0.5, 1.0, 2.0];

/// What to compute.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Where the tables go.
    pub folder: PathBuf,
    /// Random trajectories of 10 x 10 per rod length.
    pub random: usize,
    /// Trajectories of 10 x 10 from frames of a random one, per rod length.
    pub reseeded: usize,
    /// Trajectories of 2 x 2 per point.
    pub small: usize,
    /// Threads.
    pub jobs: usize,
}

/// The longest divisor of a frame that is at most r0 / 50 and 0.005: the error of the energy is
/// then some 2e-3 for any r0.
pub fn time_step(rod_length: f64) -> f64 {
    FRAME / (FRAME / (rod_length / 50.0).min(0.005)).ceil()
}

/// An open lattice of unit squares.
pub fn lattice(size: usize, rod_length: f64) -> Result<Arc<Network>, Failure> {
    Ok(Arc::new(Network::lattice(
        size,
        size,
        rod_length,
        Square::default(),
        Edges::Open,
        FRAC_PI_4,
    )?))
}

/// A run, looked at every so often.
pub struct Run {
    /// The engine.
    pub engine: Engine,
    /// Where it is.
    pub state: State,
    step: f64,
}

impl Run {
    /// From this state, in steps of at most `step`.
    pub fn new(
        network: &Arc<Network>,
        forces: Vec<Box<dyn Force>>,
        state: State,
        step: f64,
        settings: CollisionSettings,
    ) -> Result<Self, Failure> {
        let engine = Engine::new(network.clone(), forces, &state, settings)?;
        Ok(Self {
            engine,
            state,
            step,
        })
    }

    /// Continues for this time.
    pub fn advance(&mut self, duration: f64) -> Result<(), Failure> {
        let steps = (duration / self.step - 1e-9).ceil().max(1.0);
        for _ in 0..steps as u64 {
            self.engine.step(&mut self.state, duration / steps)?;
        }
        Ok(())
    }
}

/// f(0), f(1), ..., in this order whatever the number of threads.
pub fn map<T: Send>(
    jobs: usize,
    count: usize,
    work: impl Fn(usize) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Result<T, Failure>)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..jobs.min(count) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        return;
                    }
                    let result = work(index);
                    if let Ok(mut done) = done.lock() {
                        done.push((index, result));
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().map_err(|_| "a thread has died")?;
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

/// Mean and its standard error over independent numbers.
pub fn mean(numbers: &[f64]) -> [f64; 2] {
    let moments = RunningMoments::in_two_passes(numbers);
    [
        moments.mean(),
        if numbers.len() > 1 {
            moments.independent_standard_error()
        } else {
            f64::NAN
        },
    ]
}

/// Standard deviation of a series about its mean.
pub fn deviation(numbers: &[f64]) -> f64 {
    RunningMoments::in_two_passes(numbers).root_mean_square_deviation()
}

/// Writes a table with a head.
pub fn table(
    settings: &Settings,
    name: &str,
    head: &str,
    rows: &[Vec<f64>],
) -> Result<(), Failure> {
    let mut text = format!("{head}\n");
    for row in rows {
        for (index, number) in row.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            let size = number.abs();
            if number.fract() == 0.0 && size < 1e6 {
                write!(text, "{comma}{number}")?;
            } else if (1e-2..1e4).contains(&size) {
                write!(text, "{comma}{number:.4}")?;
            } else {
                write!(text, "{comma}{number:.4e}")?;
            }
        }
        text.push('\n');
    }
    Ok(std::fs::write(
        settings.folder.join(format!("{name}.csv")),
        text,
    )?)
}

/// Processor time of all threads so far, in seconds; 0 where the system does not tell.
pub fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = text
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .collect();
    // utime and stime in ticks of 1/100 s.
    let ticks = |index: usize| {
        fields
            .get(index)
            .and_then(|field| field.parse::<f64>().ok())
            .unwrap_or(0.0)
    };
    0.01 * (ticks(11) + ticks(12))
}
