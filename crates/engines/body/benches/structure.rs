//! Reading, selecting and charging: CPU time for each atom.
//!
//! `cargo bench -p protomer-body --bench structure`

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a benchmark"
)]

#[path = "../../../base/kernel/benches/cpu_time/mod.rs"]
mod cpu_time;

use cpu_time::{are_requested, seconds_per_call};
use flate2::read::GzDecoder;
use protomer_body::chemistry::{SiteSettings, build_sites};
use protomer_body::structure::{SelectionSettings, Structure};
use std::hint::black_box;
use std::io::Read;
use std::path::{Path, PathBuf};

fn main() {
    if !are_requested() {
        return;
    }
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let others = std::env::var_os("PROTOMER_TEST_DATA").map(PathBuf::from);
    let others = others.unwrap_or_default();
    let files = [
        (&bundled, "data/structures/5pti.cif.gz"),
        (&bundled, "data/structures/4e43.pdb.gz"),
        (&others, "data/structures/4v8r_hybrid36.pdb.gz"),
        (&others, "data/structures/5a9z.cif.gz"),
    ];
    for (root, name) in files {
        let Ok(file) = std::fs::File::open(root.join(name)) else {
            eprintln!("skipped: {name}, which is looked for in PROTOMER_TEST_DATA");
            continue;
        };
        let mut bytes = Vec::new();
        GzDecoder::new(file).read_to_end(&mut bytes).unwrap();
        let structure = Structure::read(name, &bytes).unwrap();
        let selection = structure.select(&SelectionSettings::default()).unwrap();
        let atoms = structure.models[0].atoms.len();
        let tell = |work: &str, seconds: f64| {
            let microseconds = 1e6 * seconds / atoms as f64;
            println!("{name}: {work} {microseconds:.3} µs per atom of {atoms}");
        };
        let read = || drop(black_box(Structure::read(name, &bytes).unwrap()));
        tell("read", seconds_per_call(read));
        let select = || {
            drop(black_box(
                structure.select(&SelectionSettings::default()).unwrap(),
            ))
        };
        tell("select", seconds_per_call(select));
        let charge = || {
            drop(black_box(
                build_sites(&selection, &SiteSettings::default()).unwrap(),
            ))
        };
        tell("charge", seconds_per_call(charge));
    }
}
