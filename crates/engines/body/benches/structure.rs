//! Reading, selecting and charging: time per file.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a benchmark"
)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use flate2::read::GzDecoder;
use protomer_body::chemistry::{SiteSettings, build_sites};
use protomer_body::structure::{SelectionSettings, Structure};
use std::io::Read;
use std::path::{Path, PathBuf};

fn read_select_charge(criterion: &mut Criterion) {
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
        let mut group =
            criterion.benchmark_group(Path::new(name).file_name().unwrap().to_string_lossy());
        group
            .throughput(Throughput::Elements(structure.models[0].atoms.len() as u64))
            .sample_size(10);
        group.bench_function("read", |bencher| {
            bencher.iter(|| Structure::read(name, &bytes).unwrap())
        });
        group.bench_function("select", |bencher| {
            bencher.iter(|| structure.select(&SelectionSettings::default()).unwrap())
        });
        group.bench_function("charge", |bencher| {
            bencher.iter(|| build_sites(&selection, &SiteSettings::default()).unwrap())
        });
        group.finish();
    }
}

criterion_group!(benches, read_select_charge);
criterion_main!(benches);
