//! A dimer, a trimer and a ring of four patchy cubes by three ways: nested sampling, windows, and a plain simulation in
//! which the last body comes and goes.

use crate::parts::{Cubes, LIMIT_ANGSTROM, patchy, ring};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Rotation};
use protomer_mc::pair::Charged;
use protomer_mc::parts::{
    Arrangement, Attached, BodyEnergies, GrowthSettings, PartKind, PartSamples, WindowSettings,
    attach, connected_parts, free_body,
};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Displacements between which the last body is free of all others, Å; the outer one is a wall.
const FREE_ANGSTROM: [f64; 2] = [36.0, 42.0];
const RUNS: u32 = 8;
const SWEEPS: u64 = 300_000;

/// Square of the displacement of a body from its place next to another, Å².
fn square_displacement(arrangement: &Arrangement, pair: (usize, usize), poses: [&Pose; 2]) -> f64 {
    let (child, parent) = pair;
    let bodies = &arrangement.bodies;
    let native = bodies[child].pose.then(&bodies[parent].pose.inverse());
    let relative = poses[0].then(&poses[1].inverse());
    let angle = (relative.rotation * native.rotation.inverse()).angle();
    (relative.position - native.position).norm_squared()
        + 4.0 / 3.0 * (1.0 - angle.cos()) * bodies[child].square_of_gyration_angstrom2
}

/// ∫ d³R dΩ/8π² over displacements up to a limit beyond half a turn, Å³.
fn volume_angstrom3(square_of_gyration_angstrom2: f64, limit_angstrom: f64) -> f64 {
    const INTERVALS: u32 = 4000;
    let step = PI / f64::from(INTERVALS);
    let slice = |number: u32| {
        let angle = (f64::from(number) + 0.5) * step;
        let turned = 4.0 / 3.0 * (1.0 - angle.cos()) * square_of_gyration_angstrom2;
        let radius = (limit_angstrom.powi(2) - turned).sqrt();
        (1.0 - angle.cos()) / PI * 4.0 / 3.0 * PI * radius.powi(3) * step
    };
    (0..INTERVALS).map(slice).sum()
}

/// A part whose last body comes and goes, without any bias.
struct Plain<'a> {
    arrangement: &'a Arrangement,
    part: &'a PartKind,
    cubes: &'a Cubes,
}

impl Plain<'_> {
    fn square_displacement(&self, place: usize, poses: &[Pose]) -> f64 {
        let parent = self.part.attached_to[place];
        let pair = (self.part.bodies[place], self.part.bodies[parent]);
        square_displacement(self.arrangement, pair, [&poses[place], &poses[parent]])
    }

    fn is_allowed(&self, poses: &[Pose]) -> bool {
        let last = poses.len() - 1;
        (1..=last).all(|place| {
            let limit = if place == last {
                FREE_ANGSTROM[1]
            } else {
                LIMIT_ANGSTROM
            };
            self.square_displacement(place, poses) < limit.powi(2)
        })
    }

    /// Energies of a body with the others, kT; `None` at overlap.
    fn energies_kt(&self, poses: &[Pose], place: usize, pose: &Pose) -> Option<Vec<f64>> {
        let bodies = &self.part.bodies;
        let described = |(other, other_pose): (usize, &Pose)| {
            if other == place {
                return Some(0.0);
            }
            let (i, j) = (bodies[place], bodies[other]);
            let overlap = self.cubes.overlap(i, j, pose, other_pose);
            (!overlap).then(|| self.cubes.energy_kt(i, j, pose, other_pose))
        };
        poses.iter().enumerate().map(described).collect()
    }

    /// ln of the ratio of the bound part to a free body, with the volume of the latter.
    fn ln_ratio(&self, run: u32) -> f64 {
        let bodies = &self.part.bodies;
        let mut poses: Vec<Pose> = bodies
            .iter()
            .map(|body| self.arrangement.bodies[*body].pose)
            .collect();
        let last = poses.len() - 1;
        let (mut bound, mut free) = (0.0, 0.0);
        for sweep in 0..SWEEPS + SWEEPS / 10 {
            let mut rng = CounterRng::new(11 + bodies.len() as u64, run, sweep);
            for trial in 0..4 + last {
                // Four trials of the last body, one of each other.
                let place = if trial < 4 { last } else { trial - 4 };
                if last == 1 && place == 0 {
                    continue;
                }
                let widest = if place == last {
                    (40.0, PI)
                } else {
                    (2.0, 0.4)
                };
                let mut size = || 0.003_f64.powf(rng.uniform());
                let (of_shift, of_turn) = (size(), size());
                let shift = rng.vector_in_ball(widest.0 * of_shift);
                let turn = rng.vector_in_ball(widest.1 * of_turn);
                let threshold = rng.uniform();
                let mut moved = poses.clone();
                moved[place].position += shift;
                moved[place].rotation = Rotation::new(turn) * moved[place].rotation;
                if !self.is_allowed(&moved) {
                    continue;
                }
                let Some(after) = self.energies_kt(&moved, place, &moved[place]) else {
                    continue;
                };
                let before = self.energies_kt(&poses, place, &poses[place]).unwrap();
                let rise_kt = after.iter().sum::<f64>() - before.iter().sum::<f64>();
                if threshold < (-rise_kt).exp() {
                    poses = moved;
                }
            }
            if sweep < SWEEPS / 10 {
                continue;
            }
            let square = self.square_displacement(last, &poses);
            if square < LIMIT_ANGSTROM.powi(2) {
                bound += 1.0;
            } else if square > FREE_ANGSTROM[0].powi(2) {
                let meeting = self.energies_kt(&poses, last, &poses[last]).unwrap();
                // The weight of a body without energy.
                free += meeting.iter().sum::<f64>().exp();
            }
        }
        let square = self.arrangement.bodies[0].square_of_gyration_angstrom2;
        let [inner, outer] = FREE_ANGSTROM.map(|limit| volume_angstrom3(square, limit));
        f64::ln(bound / free * (outer - inner))
    }

    /// Mean of several runs with its error.
    fn mean_over_runs(&self) -> (f64, f64) {
        let values: Vec<f64> = (0..RUNS)
            .into_par_iter()
            .map(|run| self.ln_ratio(run))
            .collect();
        let count = f64::from(RUNS);
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (mean, (squares / (count - 1.0) / count).sqrt())
    }
}

/// Partition functions of all parts.
fn sampled(
    arrangement: &Arrangement,
    parts: &[PartKind],
    cubes: &Cubes,
    windows: Option<WindowSettings>,
) -> Vec<Attached> {
    let settings = GrowthSettings {
        live_states: 100,
        runs: 6,
        windows,
        ..GrowthSettings::default()
    };
    let first = arrangement.bodies[parts[0].bodies[0]].pose;
    let mut samples: PartSamples = free_body(first, &settings);
    let mut found = vec![*samples.attached()];
    for (number, part) in (0..).zip(parts).skip(1) {
        let grown = attach(
            arrangement,
            (number, part),
            &samples,
            cubes,
            &settings,
            &|| true,
        );
        samples = grown.unwrap().unwrap();
        found.push(*samples.attached());
    }
    found
}

#[test]
#[ignore = "takes eight minutes of processor time"]
fn a_dimer_a_trimer_and_a_ring_of_four_are_the_same_by_three_ways() {
    let kind = patchy(1.2);
    let arrangement = ring(&kind);
    let parts = connected_parts(&arrangement, 10).unwrap().parts;
    let yukawa = Yukawa::new(7.15, 1.0 / 4.3, f64::INFINITY).unwrap();
    let cubes = Cubes {
        charged: Charged::new(yukawa, &kind.charges, &kind.charges).unwrap(),
        kind,
        tree: Vec::new(),
        closing: 1.0,
    };
    let windows = WindowSettings {
        windows: 24,
        sweeps: 8000,
    };
    let grown = sampled(&arrangement, &parts, &cubes, None);
    let pulled = sampled(&arrangement, &parts, &cubes, Some(windows));
    let (mut plain, mut variance) = (0.0, 0.0);
    for (number, part) in parts.iter().enumerate().skip(1) {
        let run = Plain {
            arrangement: &arrangement,
            part,
            cubes: &cubes,
        };
        let (ln_ratio, error) = run.mean_over_runs();
        plain += ln_ratio;
        variance += error.powi(2);
        let (a, b) = (&grown[number], &pulled[number]);
        println!(
            "{} bodies: nested {:.2} ± {:.2}, windows {:.2} ± {:.2}, plain {plain:.2} ± {:.2}; {:?}",
            number + 1,
            a.ln_partition,
            a.ln_partition_error,
            b.ln_partition,
            b.ln_partition_error,
            variance.sqrt(),
            b.windows.unwrap()
        );
        for way in [a, b] {
            let error = way.ln_partition_error.hypot(variance.sqrt());
            // The plain simulation of the ring sets the limit: its last body comes and goes rarely.
            assert!(error < 0.7, "{way:?} {variance}");
            assert!(
                (way.ln_partition - plain).abs() < 3.0 * error,
                "{way:?} {plain} {variance}"
            );
        }
    }
}
