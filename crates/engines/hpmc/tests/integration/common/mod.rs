//! What several tests share.

use protomer_hpmc::body::HardBody;
use protomer_hpmc::box_moves::{Freedom, Pressure};
use protomer_hpmc::reservoir::Depletant;
use protomer_hpmc::simulation::{Sample, Settings, Simulation};
use protomer_hpmc::start::Start;
use protomer_kernel::periodic_box::PeriodicBox;
use protomer_kernel::statistics::summarize;

/// A run at a constant pressure, kT per volume.
pub fn pressed(kt_per_volume: f64, freedom: Freedom) -> Settings {
    Settings {
        equilibration_sweeps: 2000,
        pressure: Some(Pressure {
            kt_per_volume,
            freedom,
            changes_per_sweep: None,
        }),
        ..Settings::default()
    }
}

/// A sample after every fifth sweep of a run.
pub fn samples<const D: usize>(
    settings: &Settings,
    body: &HardBody<D>,
    start: &Start<D>,
    count: usize,
) -> (Vec<Sample>, Simulation<D>) {
    samples_among(&[], settings, body, start, count)
}

/// Variant of [`samples`] for bodies among depletants.
pub fn samples_among<const D: usize>(
    depletants: &[Depletant],
    settings: &Settings,
    body: &HardBody<D>,
    start: &Start<D>,
    count: usize,
) -> (Vec<Sample>, Simulation<D>) {
    let mut simulation = Simulation::new(settings, body, depletants, start).unwrap();
    simulation.run(settings.equilibration_sweeps).unwrap();
    let mut samples = Vec::new();
    for _ in 0..count {
        simulation.run(5).unwrap();
        samples.push(simulation.sample());
    }
    assert_eq!(simulation.system().overlaps(), 0);
    (samples, simulation)
}

/// Asserts the mean of a series within four errors, which are less than a part of it.
pub fn assert_mean(series: &[f64], exact: f64, precision: f64, what: &str) {
    let found = summarize(series);
    let (off, error) = ((found.mean - exact).abs(), found.standard_error);
    assert!(error < precision * exact.abs(), "{what}: {found:?}");
    assert!(off < 4.0 * error, "{what}: {exact}, {found:?}");
}

/// The logarithm of a length at a volume of one.
pub fn logarithm<const D: usize>(space: &PeriodicBox<D>, axis: usize) -> f64 {
    (space.lengths()[axis] / space.volume().powf(1.0 / D as f64)).ln()
}

/// Mean length of a ring of hard rods whose gaps, up to 20, have this weight each; the ring has its length as a weight once more.
pub fn mean_length(rods: f64, weight: impl Fn(f64) -> f64) -> f64 {
    let [norm, first, second] = [0, 1, 2].map(|power| {
        let step = 1e-4;
        let moment = |cell: i32| {
            let gap = step * (f64::from(cell) + 0.5);
            gap.powi(power) * weight(gap) * step
        };
        (0..200_000).map(moment).sum::<f64>()
    });
    let (gap, variance) = (first / norm, second / norm - (first / norm).powi(2));
    let mean = rods * (1.0 + gap);
    mean + rods * variance / mean
}
