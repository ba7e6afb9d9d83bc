//! Sweeps over rod lengths and potentials.

use crate::support::{finish_sweep, nearly_coherent, small};
use protomer_linkage::analysis::domains::{Domains, sides};
use protomer_linkage::analysis::grima::CoherentOrbit;
use protomer_linkage::analysis::lyapunov::{LyapunovSettings, SteppedFlow, maximal_exponent};
use protomer_linkage::lattice::{Mover, Square, State};
use protomer_linkage_verbs::lattice::settings::{LatticeSettings, SweepAxes, TimeStep, Velocities};
use protomer_linkage_verbs::lattice::start::{begin, network};
use protomer_linkage_verbs::lattice::sweep::run_sweep;
use protomer_linkage_verbs::lattice::trajectory::read_states;
use protomer_results::{End, Execution};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// A run that fails is a row with the reason; the others are tabulated, and the same sweep again says
/// the same.
#[test]
fn a_failed_run_leaves_the_table_of_the_others() {
    let settings = LatticeSettings {
        rows: 2,
        columns: 2,
        steps: Some(60),
        time_step: TimeStep::Fixed(0.1),
        start: "closed".parse().unwrap(),
        velocities: Velocities::Checkerboard,
        log_every: 2,
        trajectory_every: 5,
        sweep: Some(SweepAxes {
            r0: vec![0.02, 1.0],
            kappa: vec![0.0],
            seeds: vec![1, 2],
            lyapunov: None,
            locked_within: None,
        }),
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = finish_sweep(&settings, folder.path());
    let [failed, done] = &sweep.conditions[..] else {
        panic!("{:?}", sweep.conditions)
    };
    assert_eq!((failed.r0, failed.runs, failed.failed_runs), (0.02, 0, 2));
    assert_eq!((done.r0, done.runs, done.failed_runs), (1.0, 2, 0));
    assert!(failed.synchronisation.mean.is_nan() && done.synchronisation.mean > 0.9);
    let reasons = sweep.failed_runs();
    assert_eq!(reasons.len(), 2);
    assert!(
        reasons[0].starts_with("r0 = 0.02, κ = 0, seed 1 failed: step "),
        "{reasons:?}"
    );
    assert!(reasons[0].contains("is too large"), "{reasons:?}");
    let table = || std::fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let first = table();
    assert_eq!(first.lines().count(), 5);
    assert!(
        first.contains("0.02,0,2,NaN") && first.contains("is too large"),
        "{first}"
    );
    assert!(folder.path().join("indices.svg").exists());
    assert_eq!(
        finish_sweep(&settings, folder.path()).failed_runs(),
        reasons
    );
    assert_eq!(table(), first);
}

/// A sweep says when phases lock, how many domains there are, and how far sides are correlated.
#[test]
fn sweeps_tell_of_domains_and_locking() {
    let settings = LatticeSettings {
        steps: Some(400),
        sweep: Some(SweepAxes {
            r0: vec![0.02, 2.0],
            seeds: vec![1, 2],
            ..SweepAxes::default()
        }),
        time_step: TimeStep::AUTO,
        trajectory_every: 10,
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = finish_sweep(&settings, folder.path());
    let [short, long] = &sweep.conditions[..] else {
        panic!("{:?}", sweep.conditions)
    };
    // Short rods keep squares in step from the start, in one domain.
    assert_eq!((short.locked_share, short.locking_time.mean), (1.0, 0.0));
    assert_eq!((short.domains.mean, short.largest_domain.mean), (1.0, 1.0));
    assert!(short.correlation_length.is_nan());
    assert!(long.domains.mean >= 1.0 && long.largest_domain.mean <= 1.0);
    let table = std::fs::read_to_string(folder.path().join("correlation.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 2 * 4);
    for figure in ["correlation", "domains", "orbits"] {
        assert!(
            folder.path().join(format!("{figure}.svg")).is_file(),
            "{figure}"
        );
    }
    // The slow twin, from the frames.
    let frames = read_states(&folder.path().join("r0_2_kappa_0/seed_1/trajectory.gsd")).unwrap();
    let net = network(&LatticeSettings { r0: 2.0, ..small() }).unwrap();
    let mut counts = 0.0;
    for (_, positions) in &frames {
        counts += Domains::find(&net, &sides(&net, positions)).count as f64 / frames.len() as f64;
    }
    let run = sweep
        .runs
        .iter()
        .find(|run| run.r0 == 2.0 && run.seed == 1)
        .unwrap();
    assert!((run.domains - counts).abs() < 1e-12);
}

#[test]
fn sweeps_do_not_depend_on_threads_and_are_taken_up_again() {
    let settings = LatticeSettings {
        rows: 2,
        columns: 2,
        steps: Some(300),
        log_every: 4,
        trajectory_every: 4,
        sweep: Some(SweepAxes {
            r0: vec![0.2, 1.0],
            kappa: vec![0.0, 1.0, 10.0],
            seeds: vec![1, 2],
            lyapunov: None,
            locked_within: None,
        }),
        ..small()
    };
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: usize, name: &str, execution: &Execution| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run_sweep(&settings, &folder.path().join(name), execution))
            .unwrap()
    };
    let End::Finished(sweep) = run(1, "one", &Execution::default()) else {
        panic!("it was not asked to stop")
    };
    assert_eq!((sweep.conditions.len(), sweep.runs.len()), (6, 12));
    let stopped = Execution::default();
    stopped.interrupt.request();
    assert_eq!(run(2, "two", &stopped), End::Stopped);
    run(2, "two", &Execution::default());
    for file in [
        "lattice.csv",
        "runs.csv",
        "crossings.csv",
        "lattice.json",
        "indices.svg",
        "spread.svg",
        "poisson.png",
    ] {
        let read = |name: &str| std::fs::read(folder.path().join(name).join(file)).expect(file);
        assert!(read("one") == read("two"), "{file} differs");
    }
    // The force that draws the squares together keeps them together.
    let spread = |kappa: f64| {
        let row = sweep
            .conditions
            .iter()
            .find(|row| row.r0 == 1.0 && row.kappa == kappa)
            .unwrap();
        row.largest_spread.mean
    };
    assert!(
        spread(10.0) < spread(1.0),
        "{} {}",
        spread(10.0),
        spread(1.0)
    );
}

/// The exponent of the sweep is the one that the library finds for the same trajectory, it is
/// chaotic, it is kept, and settings of another exponent are another sweep.
#[test]
fn sweeps_measure_lyapunov_exponents() {
    let lyapunov = LyapunovSettings {
        intervals: 60,
        discarded: 10,
        ..LyapunovSettings::default()
    };
    let settings = LatticeSettings {
        velocity_spread: 0.1,
        sweep: Some(SweepAxes {
            r0: vec![0.5, 1.0],
            seeds: vec![1, 2],
            lyapunov: Some(lyapunov),
            ..SweepAxes::default()
        }),
        ..nearly_coherent()
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = finish_sweep(&settings, folder.path());
    assert!(sweep.runs.iter().all(|run| run.lyapunov_exponent > 0.2));
    assert!(folder.path().join("lyapunov.svg").exists());

    let run = LatticeSettings {
        r0: 1.0,
        seed: 2,
        sweep: None,
        ..settings.clone()
    };
    let begun = begin(&run).unwrap();
    let (network, mut state) = (Arc::new(begun.network), begun.state);
    let flow = |state: &State| {
        let motion = run.motion().unwrap();
        SteppedFlow::new(Mover::new(&motion, network.clone(), state).unwrap(), 5e-3)
    };
    let (mut first, mut second) = (flow(&state), flow(&state));
    let seeded = LyapunovSettings {
        seed: 2,
        ..lyapunov
    };
    let found = maximal_exponent(&network, &mut first, &mut second, &mut state, &seeded).unwrap();
    let of_sweep = sweep.runs.iter().find(|run| run.r0 == 1.0 && run.seed == 2);
    assert_eq!(of_sweep.unwrap().lyapunov_exponent, found.exponent);

    // A second look reads what is there.
    let file = folder.path().join("r0_1_kappa_0/seed_2/lyapunov.json");
    let text = std::fs::read_to_string(&file).unwrap();
    let other = text.replace(
        &format!("\"exponent\": {}", found.exponent),
        "\"exponent\": 7.5",
    );
    assert_ne!(other, text);
    std::fs::write(&file, other).unwrap();
    let again = finish_sweep(&settings, folder.path());
    assert!(again.runs.iter().any(|run| run.lyapunov_exponent == 7.5));

    let noisy = LatticeSettings {
        temperature: Some(0.1),
        friction: 1.0,
        ..settings
    };
    assert!(noisy.check().unwrap_err().to_string().contains("noise"));
}

/// In the coherent motion the checkerboard mode passes the open state at the same speed every time,
/// and as often as the exact orbit does; disorder ends that at the first contact.
#[test]
fn sweeps_follow_the_mode_through_the_open_state() {
    let exact = CoherentOrbit::new(2, 2, Square::default(), 1.0, FRAC_PI_4, -1.0).unwrap();
    let mut expected = 0;
    let mut before = exact.state(1e-9)[0];
    for step in 1..=1000 {
        let angle = exact.state(0.01 * f64::from(step))[0];
        expected += usize::from((angle - FRAC_PI_4) * (before - FRAC_PI_4) < 0.0);
        before = angle;
    }
    assert!(expected >= 2, "{expected}");
    let coherent = LatticeSettings {
        r0: 1.0,
        ..nearly_coherent()
    };
    let disordered = LatticeSettings {
        velocity_spread: 0.3,
        ..coherent.clone()
    };
    let folder = tempfile::tempdir().unwrap();
    let run = |settings: &LatticeSettings, name: &str| {
        let directory = folder.path().join(name);
        let row = finish_sweep(settings, &directory).runs.remove(0);
        (
            row,
            std::fs::read_to_string(directory.join("crossings.csv")).unwrap(),
        )
    };
    let (row, table) = run(&coherent, "coherent");
    assert_eq!(table.lines().count(), 1 + expected, "{table}");
    assert!((row.crossing_rate - 0.1 * expected as f64).abs() < 1e-12);
    assert!((row.crossing_speed - 1.0).abs() < 1e-3, "{row:?}");
    let (row, _) = run(&disordered, "disordered");
    assert!(row.crossing_speed < 0.9, "{row:?}");
    assert!(folder.path().join("disordered/crossings.svg").exists());
}
