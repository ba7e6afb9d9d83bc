//! Sweeps as a process: killed, stopped, continued, on a full disk, in a directory that was
//! tampered with.

mod answers;
mod continuation;
mod settings;

use crate::common::contents;
use std::collections::BTreeMap;
use std::path::Path;

/// Two salts, two replicas; long enough to be killed in the middle, short enough for a test.
const SWEEP: &str = "sweep ring.json --salt 50mM,300mM --replicas 2 --sweeps 1500 --equilibration 200 \
                     --seed 7 --log-every 5 --trajectory-every 50 --quiet";

/// The same with another number of sweeps.
fn sweep_of(sweeps: u32, equilibration: u32) -> String {
    SWEEP
        .replace("--sweeps 1500", &format!("--sweeps {sweeps}"))
        .replace(
            "--equilibration 200",
            &format!("--equilibration {equilibration}"),
        )
}

/// What must not depend on how the sweep came to its end: everything but the records' own history.
fn results(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = contents(directory);
    files.retain(|name, _| !name.ends_with(".lock"));
    assert!(
        files
            .keys()
            .filter(|name| name.ends_with("trajectory.gsd"))
            .count()
            == 4,
        "{:?}",
        files.keys()
    );
    assert!(
        files.keys().all(|name| !name.contains("partial")),
        "{:?}",
        files.keys()
    );
    files
}

fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in a {
        assert!(*bytes == b[name], "{name} differs");
    }
}

/// The columns of a CSV file by name.
fn columns(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut columns: BTreeMap<String, Vec<f64>> = names
        .iter()
        .map(|name| ((*name).to_owned(), vec![]))
        .collect();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), names.len(), "{line}");
        for (name, cell) in names.iter().zip(cells) {
            columns.get_mut(*name).unwrap().push(cell.parse().unwrap());
        }
    }
    columns
}
