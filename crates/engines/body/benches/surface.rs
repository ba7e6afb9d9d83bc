//! CPU time for the accessible surface, the signed distance, the exact measures and the whole surface of
//! a protein-like body.
//!
//! `cargo bench -p protomer-body --bench surface`; the argument of the environment variable
//! `PROTOMER_XYZR` (rows of x y z radius) replaces the synthetic globule of 1000 atoms.

#![allow(clippy::print_stdout, reason = "a benchmark")]

#[path = "../../../base/kernel/benches/cpu_time/mod.rs"]
mod cpu_time;

use cpu_time::{are_requested, seconds_per_call};
use protomer_body::surface::{
    Arrangement, ImplicitSolid, Measure, MeshSettings, SesSolid, solvent_excluded_surface,
};
use protomer_kernel::Vec3;
use std::hint::black_box;

/// Atoms at protein density (one per 18 Å³) on a disturbed lattice within a ball.
fn globule(atoms: usize) -> (Vec<Vec3>, Vec<f64>) {
    let spacing = 18.0_f64.cbrt();
    let radius = (atoms as f64 * 18.0 * 0.75 / std::f64::consts::PI).cbrt();
    let reach = (radius / spacing) as i32 + 1;
    let mut state = 7_u64;
    let mut jitter = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
    };
    let mut centres = Vec::new();
    for x in -reach..=reach {
        for y in -reach..=reach {
            for z in -reach..=reach {
                let place = Vec3::new(f64::from(x), f64::from(y), f64::from(z)) * spacing;
                if place.norm() < radius {
                    centres.push(place + Vec3::new(jitter(), jitter(), jitter()) * 1.5);
                }
            }
        }
    }
    let radii = (0..centres.len())
        .map(|n| [1.7, 1.55, 1.52, 1.7][n % 4])
        .collect();
    (centres, radii)
}

fn read_xyzr(path: &str) -> Option<(Vec<Vec3>, Vec<f64>)> {
    let text = std::fs::read_to_string(path).ok()?;
    let rows = text.lines().map(|line| {
        line.split_whitespace()
            .filter_map(|word| word.parse::<f64>().ok())
            .collect()
    });
    let atoms = rows.filter(|row: &Vec<f64>| row.len() == 4);
    Some(
        atoms
            .map(|row| (Vec3::new(row[0], row[1], row[2]), row[3]))
            .unzip(),
    )
}

fn main() {
    if !are_requested() {
        return;
    }
    let given = std::env::var("PROTOMER_XYZR")
        .ok()
        .and_then(|path| read_xyzr(&path));
    let (centres, radii) = given.unwrap_or_else(|| globule(1000));
    let Ok(accessible) = Arrangement::new(&centres, &radii, 1.4) else {
        return;
    };
    let solid = SesSolid::new(&accessible);
    println!("{} atoms, milliseconds:", centres.len());
    let tell = |work: &str, seconds: f64| println!("{work:<16} {:10.4}", 1e3 * seconds);
    let arrange = || {
        drop(black_box(Arrangement::new(
            black_box(&centres),
            &radii,
            1.4,
        )))
    };
    tell("arrangement", seconds_per_call(arrange));
    let make_solid = || drop(black_box(SesSolid::new(black_box(&accessible))));
    tell("solid", seconds_per_call(make_solid));
    let measure = || drop(black_box(Measure::new(black_box(&accessible))));
    tell("measure", seconds_per_call(measure));
    let settings = MeshSettings::default();
    let whole = || {
        drop(black_box(solvent_excluded_surface(
            &centres, &radii, 1.4, &settings,
        )))
    };
    tell("whole", seconds_per_call(whole));
    let points = near_surface(&solid, &accessible);
    let mut places = points.iter().cycle();
    let mut each_of_thousand = |work: &dyn Fn(&Vec3)| {
        let seconds = seconds_per_call(|| places.by_ref().take(1000).for_each(work));
        seconds / 1000.0
    };
    let measure_distance = |point: &Vec3| {
        black_box(solid.signed_distance(black_box(point)));
    };
    tell("signed distance", each_of_thousand(&measure_distance));
    let project = |point: &Vec3| {
        black_box(solid.project(black_box(point)));
    };
    tell("project", each_of_thousand(&project));
}

/// Grid points within 0.7 Å of the surface, in grid order as a mesher visits them.
fn near_surface(solid: &SesSolid, accessible: &Arrangement) -> Vec<Vec3> {
    let (low, high) = solid.bounds();
    let steps = ((high - low) / 0.7).map(|count| count.ceil() as usize);
    let mut points = Vec::new();
    for x in 0..steps.x {
        for y in 0..steps.y {
            for z in 0..steps.z {
                let point = low + Vec3::new(x as f64, y as f64, z as f64) * 0.7;
                if solid.signed_distance(&point).abs() < 0.7 {
                    points.push(point);
                }
            }
        }
    }
    assert!(points.len() > accessible.faces().len());
    points
}
