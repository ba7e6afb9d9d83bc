//! Every verb on damaged files: an answer or an error, never a panic, a hang or more memory than a
//! machine has.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking
#![allow(clippy::print_stderr)] // the long form says how far it is

mod common;
mod damage;

use common::TemporaryFolder;
use damage::{CHECKSUM, LARGEST_BLOCK, damaged, damaged_document, sign};
use protomer_cli::{Host, call};
use protomer_io::container::Container;
use protomer_kernel::random::CounterRng;
use protomer_results::Interrupt;
use serde_json::Value;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// No input may take a larger block, bytes.
const LARGEST_ALLOWED_BLOCK: usize = 2 << 30;
/// Work that goes on for so long is asked to stop,
const PATIENCE: Duration = Duration::from_secs(20);
/// and must stop by then.
const LAST_PATIENCE: Duration = Duration::from_secs(100);

/// How a file is damaged.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Bytes,
    Json,
    Toml,
    /// A container whose header is JSON, signed again.
    Checkpoint,
}

/// A file and the command that reads it.
struct Case {
    /// The commands that make what the case needs, in the folder.
    prepared_by: &'static [&'static str],
    /// The file that is damaged, in the folder.
    file: &'static str,
    form: Form,
    /// `{}` is the folder.
    command: &'static str,
    /// Whether long work stops at once: only what it reads is tested.
    stops_at_once: bool,
}

const CUBE_OBJ: &str = "v -5 -5 -5\nv 5 -5 -5\nv 5 5 -5\nv -5 5 -5\nv -5 -5 5\nv 5 -5 5\nv 5 5 5\nv -5 5 5\n\
                        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const TETRAHEDRON_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
                               property double z\nelement face 4\nproperty list uchar uint vertex_indices\nend_header\n\
                               0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
const TETRAHEDRON_STL: &str = "solid t\nfacet\nouter loop\nvertex 0 0 0\nvertex 0 9 0\nvertex 9 0 0\nendloop\nendfacet\n\
                               facet\nouter loop\nvertex 0 0 0\nvertex 9 0 0\nvertex 0 0 9\nendloop\nendfacet\n\
                               facet\nouter loop\nvertex 9 0 0\nvertex 0 9 0\nvertex 0 0 9\nendloop\nendfacet\n\
                               facet\nouter loop\nvertex 0 9 0\nvertex 0 0 0\nvertex 0 0 9\nendloop\nendfacet\n\
                               endsolid\n";
const BALLS: &str = "0 0 0 1.7\n1.5 0 0 1.7\n0 1.5 0.2 1.5\n";
const IONS: &str = "ATOM 1 I ION 1 0.0 0.0 0.0 1.0 3.0\nATOM 2 I ION 1 4.0 1.0 0.0 -1.0 2.0\n";
const ION: &str = "ATOM 1 I ION 1 0.0 0.0 7.0 1.0 2.0\n";
const LATTICE: &str =
    "rows = 2\ncolumns = 2\nr0 = 0.2\nsteps = 40\ntime_step = 1e-2\ntrajectory_every = 10\n";
const NET: &str = "cell_angstrom = [[2.0, 0.0], [0.0, 4.0]]\nnodes_angstrom = [[0.0, 0.0]]\nrods = [\n\
                   { from = 0, to = { node = 0, image = [1, 0] }, stiffness_kcal_mol_angstrom2 = 5.0 },\n\
                   { from = 0, to = { node = 0, image = [0, 1] }, stiffness_kcal_mol_angstrom2 = 5.0 },\n]\n";
const DISKS: &str = "shape = [\"disk\"]\nbodies = 36\npacking_fraction = 0.2\nsteps = 20\n";
const SWEEP: &str = "salt_M = [0.1]\nsweeps = 10\nequilibration_sweeps = 0\nreplicas = 1\n";
const CELL: &str = "# two bodies\ncell 1 1 1\nsite 0 0 0\nsite 0.5 0.5 0.5\n";
const CORNERS: &str = "-0.5 -0.5\n0.5 -0.5\n0.5 0.5\n-0.5 0.5\n";
const BRANCH: &str =
    "0.0 0.0\n0.1 0.01\n0.2 0.04\n0.3 0.09\n0.4 0.16\n0.5 0.25\n0.6 0.36\n0.7 0.49\n0.8 0.64\n";

const PAIRS: &str = r#"[{"a": "cube", "b": "cube", "position": [0, 0, 1.15]}]"#;
const STATE: &str =
    r#"{"ns": 1, "r0": 0.05, "s0": [0, 0, 0.785], "v0": [0.1, 0, 0.2], "times": [0.1]}"#;
const GLYCINE: &str = "ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  0.00\n\
                       ATOM      2  CA  GLY A   1       1.460   0.000   0.000  1.00  0.00\n\
                       ATOM      3  C   GLY A   1       2.000   1.420   0.000  1.00  0.00\n\
                       ATOM      4  O   GLY A   1       1.300   2.440   0.000  1.00  0.00\n";
/// Two glycines that touch, in two chains.
const COMPLEX: &str = "ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  0.00\n\
                       ATOM      2  CA  GLY A   1       1.460   0.000   0.000  1.00  0.00\n\
                       ATOM      3  C   GLY A   1       2.000   1.420   0.000  1.00  0.00\n\
                       ATOM      4  O   GLY A   1       1.300   2.440   0.000  1.00  0.00\n\
                       ATOM      5  N   GLY B   1       0.000   0.000   3.800  1.00  0.00\n\
                       ATOM      6  CA  GLY B   1       1.460   0.000   3.800  1.00  0.00\n\
                       ATOM      7  C   GLY B   1       2.000   1.420   3.800  1.00  0.00\n\
                       ATOM      8  O   GLY B   1       1.300   2.440   3.800  1.00  0.00\n";
const MANIFEST: &str = "file,label,cluster,name\nglycine.pdb,a,c1,s1\nglycine.pdb,b,c2,s2\n\
                        glycine.pdb,a,c3,s3\nglycine.pdb,b,c4,s4\nglycine.pdb,a,c5,s5\nglycine.pdb,b,c6,s6\n\
                        glycine.pdb,a,c7,s7\nglycine.pdb,b,c8,s8\nglycine.pdb,a,c9,s9\nglycine.pdb,b,c10,s10\n";

const FILES: [(&str, &str); 18] = [
    ("x.obj", CUBE_OBJ),
    ("x.ply", TETRAHEDRON_PLY),
    ("x.stl", TETRAHEDRON_STL),
    ("x.xyzr", BALLS),
    ("x.pqr", IONS),
    ("ion.pqr", ION),
    ("lattice.toml", LATTICE),
    ("net.toml", NET),
    ("md.toml", DISKS),
    ("sweep.toml", SWEEP),
    ("cell.txt", CELL),
    ("corners.txt", CORNERS),
    ("branch.txt", BRANCH),
    ("pairs.json", PAIRS),
    ("state.json", STATE),
    ("glycine.pdb", GLYCINE),
    ("complex.pdb", COMPLEX),
    ("manifest.csv", MANIFEST),
];

const HPMC: &str = "hpmc run --shape cube --bodies 27 --packing-fraction 0.1 --equilibration 10 --sweeps 20 -o hpmc";
const MD: &str =
    "md run --shape disk --bodies 36 --packing-fraction 0.2 --equilibrate-steps 5 --steps 20 -o md";
const LATTICE_RUN: &str = "lattice run lattice.toml -o lattice";
const FREE_ENERGY: &str = "free-energy --shape rod:1 --crystal row --bodies 8 --packing-fraction 0.5 \
                           --equilibration 10 --sweeps 40 -o rods";
const SIMULATE: &str =
    "simulate ring.json --salt 100mM --sweeps 10 --equilibration 0 --trajectory-every 5 -o run";
const LADDER: &str = "sweep ring.json --salt 100mM,200mM --exchange-every 5 --sweeps 10 --equilibration 0 --replicas 1 -o ladder";
const PAIR: &str =
    "pair a.body b.body --salt 100mM --relative-error 0.5 --most-directions 512 -o pair";

const VOXELS: &str =
    "voxelize --manifest manifest.csv --size 16 --spacing 2 --channels shape -o set.zarr";
const TRAIN: &str = "train set.zarr --epochs 2 --widths 8 --batch 4 --least-samples 1 -o network";
const PREDICT: &str = "predict {}/network {}/set.zarr";

const fn of_file(file: &'static str, form: Form, command: &'static str) -> Case {
    Case {
        prepared_by: &[],
        file,
        form,
        command,
        stops_at_once: true,
    }
}

const fn of_checkpoint(
    prepared_by: &'static [&'static str],
    file: &'static str,
    command: &'static str,
) -> Case {
    Case {
        prepared_by,
        file,
        form: Form::Checkpoint,
        command,
        stops_at_once: false,
    }
}

const fn of_results(
    prepared_by: &'static [&'static str],
    file: &'static str,
    form: Form,
    command: &'static str,
) -> Case {
    Case {
        prepared_by,
        file,
        form,
        command,
        stops_at_once: false,
    }
}

const CASES: [Case; 42] = [
    of_file(
        "cube.off",
        Form::Bytes,
        "body --mesh {}/cube.off -o {}/o.body --force",
    ),
    of_file(
        "x.obj",
        Form::Bytes,
        "body --mesh {}/x.obj -o {}/o.body --force",
    ),
    of_file(
        "x.ply",
        Form::Bytes,
        "body --mesh {}/x.ply -o {}/o.body --force",
    ),
    of_file(
        "x.stl",
        Form::Bytes,
        "body --mesh {}/x.stl -o {}/o.body --force",
    ),
    of_file(
        "a.xyzq",
        Form::Bytes,
        "body --mesh {}/cube.off --charges {}/a.xyzq -o {}/o.body --force",
    ),
    of_file("x.xyzr", Form::Bytes, "surface {}/x.xyzr --density 0.2"),
    of_file(
        "x.pqr",
        Form::Bytes,
        "potential {}/x.pqr --salt 0.1M --spacing 1 --margin 2 --no-error-estimate",
    ),
    of_file(
        "x.pqr",
        Form::Bytes,
        "ingest {}/x.pqr --density 0.2 -o {}/o",
    ),
    of_file(
        "complex.pdb",
        Form::Bytes,
        "binding {}/complex.pdb --body A --body B --salt 100mM --spacing 0.9 --margin 2 --no-kd",
    ),
    of_file(
        "ion.pqr",
        Form::Bytes,
        "binding {}/glycine.pdb {}/ion.pqr --salt 100mM --spacing 0.9 --margin 2 --no-kd",
    ),
    of_file(
        "complex.pdb",
        Form::Bytes,
        "assemble structure {}/complex.pdb --body A --body B --relax --shapes shared -o {}/o --force",
    ),
    of_file("ring.json", Form::Json, "inspect {}/ring.json"),
    of_file("ring.json", Form::Bytes, "inspect {}/ring.json"),
    of_file(
        "lattice.toml",
        Form::Toml,
        "lattice run {}/lattice.toml -o {}/o",
    ),
    of_file("net.toml", Form::Toml, "framework {}/net.toml"),
    of_file("md.toml", Form::Toml, "md run {}/md.toml -o {}/o"),
    of_file(
        "sweep.toml",
        Form::Toml,
        "sweep {}/ring.json --config {}/sweep.toml -o {}/o",
    ),
    of_file(
        "cell.txt",
        Form::Bytes,
        "hpmc run --shape cube --bodies 54 --packing-fraction 0.2 --start {}/cell.txt -o {}/o",
    ),
    of_file("corners.txt", Form::Bytes, "shape {}/corners.txt"),
    of_file(
        "branch.txt",
        Form::Bytes,
        "phase-diagram --branch {}/branch.txt",
    ),
    of_checkpoint(
        &[HPMC],
        "hpmc/checkpoint.bin",
        "hpmc run --shape cube --bodies 27 --packing-fraction 0.1 --equilibration 10 --sweeps 20 -o {}/hpmc",
    ),
    of_checkpoint(
        &[MD],
        "md/checkpoint.bin",
        "md run --shape disk --bodies 36 --packing-fraction 0.2 --equilibrate-steps 5 --steps 20 -o {}/md",
    ),
    of_checkpoint(
        &[LATTICE_RUN],
        "lattice/checkpoint.bin",
        "lattice run {}/lattice.toml -o {}/lattice",
    ),
    of_checkpoint(
        &[FREE_ENERGY],
        "rods/checkpoint.bin",
        "free-energy --shape rod:1 --crystal row --bodies 8 --packing-fraction 0.5 --equilibration 10 --sweeps 40 -o {}/rods",
    ),
    of_checkpoint(
        &[SIMULATE],
        "run/salt_0.100000M/replica_0/checkpoint.bin",
        "simulate {}/ring.json --salt 100mM --sweeps 10 --equilibration 0 --trajectory-every 5 -o {}/run",
    ),
    of_results(&[HPMC], "hpmc/log.csv", Form::Bytes, "report {}/hpmc"),
    of_results(&[HPMC], "hpmc/run.json", Form::Json, "report {}/hpmc"),
    of_results(&[HPMC], "hpmc/run.toml", Form::Toml, "report {}/hpmc"),
    of_results(
        &[LATTICE_RUN],
        "lattice/trajectory.gsd",
        Form::Bytes,
        "lattice animate {}/lattice",
    ),
    of_results(
        &[LATTICE_RUN],
        "lattice/log.csv",
        Form::Bytes,
        "report {}/lattice",
    ),
    of_results(
        &[SIMULATE],
        "run/salt_0.100000M/replica_0/trajectory.gsd",
        Form::Bytes,
        "scattering {}/run --q-points 2",
    ),
    of_results(
        &[SIMULATE],
        "run/salt_0.100000M/replica_0/log.csv",
        Form::Bytes,
        "report {}/run",
    ),
    of_results(
        &[SIMULATE],
        "run/salt_0.100000M/replica_0/run.json",
        Form::Json,
        "report {}/run",
    ),
    of_file("a.body", Form::Checkpoint, "inspect {}/ring.json"),
    of_file("pairs.json", Form::Json, "shape contact {}/pairs.json"),
    of_file(
        "state.json",
        Form::Json,
        "lattice replay {}/state.json --longest 1",
    ),
    of_results(
        &[],
        "manifest.csv",
        Form::Bytes,
        "voxelize --manifest {}/manifest.csv --size 16 --spacing 2 --channels shape -o {}/set.zarr",
    ),
    of_results(
        &[VOXELS],
        "set.zarr/zarr.json",
        Form::Json,
        "report {}/set.zarr",
    ),
    of_results(
        &[VOXELS, TRAIN],
        "set.zarr/index/zarr.json",
        Form::Json,
        PREDICT,
    ),
    of_results(&[VOXELS, TRAIN], "set.zarr/index/c/0", Form::Bytes, PREDICT),
    of_results(
        &[VOXELS, TRAIN],
        "set.zarr/properties/c/0/0",
        Form::Bytes,
        PREDICT,
    ),
    of_results(
        &[VOXELS, TRAIN],
        "network/model.safetensors",
        Form::Bytes,
        PREDICT,
    ),
];

/// Cases whose runs take longer.
const SLOW_CASES: [Case; 2] = [
    of_checkpoint(
        &[LADDER],
        "ladder/ladder_0/checkpoint.bin",
        "sweep {}/ring.json --salt 100mM,200mM --exchange-every 5 --sweeps 10 --equilibration 0 --replicas 1 -o {}/ladder",
    ),
    of_checkpoint(
        &[PAIR],
        "pair/salt_0.100000M/checkpoint.bin",
        "pair {}/a.body {}/b.body --salt 100mM --relative-error 0.5 --most-directions 512 -o {}/pair",
    ),
];

/// The bytes of a file, damaged in one way or another.
fn damage(bytes: &[u8], form: Form, random: &mut CounterRng) -> Vec<u8> {
    let is_bytewise = form == Form::Bytes || random.uniform() < 0.2;
    match form {
        Form::Checkpoint if is_bytewise => sign(damaged(&bytes[..bytes.len() - CHECKSUM], random)),
        _ if is_bytewise => damaged(bytes, random),
        Form::Json | Form::Bytes => {
            let document: Value = serde_json::from_slice(bytes).unwrap();
            damaged_document(&document, random).to_string().into_bytes()
        }
        Form::Toml => {
            let text = std::str::from_utf8(bytes).unwrap();
            let document: Value = toml::from_str(text).unwrap();
            let changed = damaged_document(&document, random);
            toml::to_string(&changed).map_or_else(|_| b"x =".to_vec(), String::into_bytes)
        }
        Form::Checkpoint => {
            let mut container = container(bytes);
            container.header = damaged_document(&container.header, random);
            container.to_bytes().unwrap()
        }
    }
}

fn container(bytes: &[u8]) -> Container {
    let length = u16::from_le_bytes([bytes[20], bytes[21]]) as usize;
    let kind = std::str::from_utf8(&bytes[22..22 + length]).unwrap();
    Container::from_bytes("x", kind, bytes).unwrap()
}

/// Copies all files, and the folders with a wanted name.
fn copy(from: &Path, to: &Path, is_wanted: &dyn Fn(&str) -> bool) {
    std::fs::create_dir_all(to).unwrap();
    for entry in from.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap();
        let target = to.join(name);
        if !path.is_dir() {
            std::fs::copy(&path, &target).unwrap();
        } else if is_wanted(name.to_str().unwrap()) {
            copy(&path, &target, &|_| true);
        }
    }
}

/// Does work within its time; a hang ends the program.
fn watched<T>(what: &str, interrupt: &Interrupt, work: impl FnOnce() -> T) -> T {
    let (done, end) = channel::<()>();
    let (interrupt, what) = (interrupt.clone(), what.to_owned());
    let watch = std::thread::spawn(move || {
        if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
            interrupt.request();
            if end.recv_timeout(LAST_PATIENCE) == Err(RecvTimeoutError::Timeout) {
                eprintln!("{what} hangs");
                std::process::abort();
            }
        }
    });
    let out = work();
    drop(done);
    watch.join().unwrap();
    out
}

/// Outcome of a command.
enum Outcome {
    Answer,
    Error(String),
    Panic,
}

/// Runs the command of a case in a folder, on one thread; the outcome, and the largest block of memory
/// that it took, bytes.
fn outcome(what: &str, case: &Case, folder: &Path) -> (Outcome, usize) {
    let command = case.command.replace("{}", folder.to_str().unwrap());
    let words: Vec<&str> = ["-j", "1"].into_iter().chain(command.split(' ')).collect();
    let interrupt = Interrupt::default();
    if case.stops_at_once {
        interrupt.request();
    }
    let host = Host {
        interrupt: Some(interrupt.clone()),
        ..Host::default()
    };
    LARGEST_BLOCK.store(0, Ordering::Relaxed);
    let work = AssertUnwindSafe(|| call(&words, host).map(drop));
    let ended = watched(what, &interrupt, || std::panic::catch_unwind(work));
    let outcome = match ended {
        Ok(Ok(())) => Outcome::Answer,
        Ok(Err(error)) => Outcome::Error(format!("{error:#}")),
        Err(_) => Outcome::Panic,
    };
    (outcome, LARGEST_BLOCK.load(Ordering::Relaxed))
}

/// What became of the damaged files of a case.
#[derive(Default)]
struct Found {
    errors: u64,
    /// Panics and large blocks.
    faults: Vec<String>,
}

/// Damages the file of a case many times. Without damage there is an answer.
fn fuzz(place: &TemporaryFolder, number: usize, case: &Case, inputs: u64) -> Found {
    let folder: PathBuf = place.path("");
    let valid = std::fs::read(place.path(case.file)).unwrap();
    let scratch = tempfile::tempdir().unwrap();
    let work = scratch.path().join("work");
    let is_used = |name: &str| {
        let path = format!("{{}}/{name}");
        case.file.starts_with(name) || case.command.split(' ').any(|word| word == path)
    };
    copy(&folder, &work, &is_used);
    if let (Outcome::Error(message), _) = outcome("an undamaged input", case, &work) {
        panic!("{}: {message}", case.command);
    }
    let mut found = Found::default();
    for input in 0..inputs {
        let mut random = CounterRng::new(number as u64, 0, input);
        std::fs::remove_dir_all(&work).unwrap();
        copy(&folder, &work, &is_used);
        std::fs::write(work.join(case.file), damage(&valid, case.form, &mut random)).unwrap();
        let what = format!("input {input} of case {number}, {}", case.command);
        let (outcome, largest) = outcome(&what, case, &work);
        if largest > LARGEST_ALLOWED_BLOCK {
            found
                .faults
                .push(format!("{what}: a block of {largest} bytes"));
        }
        match outcome {
            Outcome::Answer => {}
            Outcome::Error(_) => found.errors += 1,
            Outcome::Panic => found.faults.push(format!("{what} panics")),
        }
    }
    found
}

/// A folder with everything that some cases need.
fn prepared(cases: &[Case]) -> TemporaryFolder {
    let place = TemporaryFolder::new();
    for (name, text) in FILES {
        std::fs::write(place.path(name), text).unwrap();
    }
    let mut done: Vec<&str> = Vec::new();
    for command in cases.iter().flat_map(|case| case.prepared_by) {
        if !done.contains(command) {
            let output = place.run(command);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{command}: {message}");
            done.push(command);
        }
    }
    place
}

fn run(cases: &[Case], first: usize, inputs_per_case: u64) {
    let place = prepared(cases);
    let (mut all_errors, mut faults) = (0, Vec::new());
    for (number, case) in (first..).zip(cases) {
        let begin = Instant::now();
        let found = fuzz(&place, number, case, inputs_per_case);
        eprintln!(
            "{} errors of {inputs_per_case} in {:.1} s: {}, {}",
            found.errors,
            begin.elapsed().as_secs_f64(),
            case.file,
            case.command
        );
        all_errors += found.errors;
        faults.extend(found.faults);
    }
    assert!(
        faults.is_empty(),
        "{} faults:\n{}",
        faults.len(),
        faults.join("\n")
    );
    let all = inputs_per_case * cases.len() as u64;
    assert!(
        4 * all_errors > all,
        "{all_errors} errors of {all}: the damage is too soft to test anything"
    );
}

#[test]
fn damaged_inputs_give_answers_or_errors() {
    run(&CASES, 0, 5);
}

/// Inputs per case of the long tests: 60 000 over all cases.
fn inputs_per_case() -> u64 {
    let inputs = std::env::var("PROTOMER_DAMAGED_INPUTS").ok();
    let inputs = inputs.and_then(|count| count.parse().ok());
    inputs.unwrap_or(1464)
}

#[test]
#[ignore = "61 488 inputs, seven minutes of processor time"]
fn many_damaged_inputs_give_answers_or_errors() {
    run(&CASES, 0, inputs_per_case());
}

#[test]
#[ignore = "2928 inputs, each of which takes longer"]
fn many_damaged_inputs_of_slow_runs_give_answers_or_errors() {
    run(&SLOW_CASES, CASES.len(), inputs_per_case());
}
