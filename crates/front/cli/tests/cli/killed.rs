//! Every kind of work, killed before each of its writes, ends as it would have without: the same bytes,
//! and a record and a page that agree.
//!
//! A small library, loaded before the C library, counts what changes files and kills the process before a
//! given one.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

const LIBRARY: &str = r#"
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static long changes = 0;

static void change(void) {
    const char *last = getenv("KILL_BEFORE");
    long number = __sync_add_and_fetch(&changes, 1);
    if (last && number == atol(last)) raise(SIGKILL);
}

static int is_file(int file) {
    struct stat status;
    return fstat(file, &status) == 0 && S_ISREG(status.st_mode);
}

#define REAL(type, name, ...) ((type(*)(__VA_ARGS__))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void *bytes, size_t count) {
    if (is_file(file)) change();
    return REAL(ssize_t, write, int, const void *, size_t)(file, bytes, count);
}

ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t place) {
    if (is_file(file)) change();
    return REAL(ssize_t, pwrite64, int, const void *, size_t, off64_t)(file, bytes, count, place);
}

int rename(const char *from, const char *to) {
    change();
    return REAL(int, rename, const char *, const char *)(from, to);
}

int unlink(const char *path) {
    change();
    return REAL(int, unlink, const char *)(path);
}

__attribute__((destructor)) static void report(void) {
    const char *path = getenv("COUNT_IN");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "%ld", changes);
    fclose(file);
}
"#;

/// Kills of one kind of work: all if it has not many more changes, else evenly spread, and the last ones.
const MOST_KILLS: u64 = 24;

/// The numbers of the changes before which to kill.
fn kills(changes: u64) -> Vec<u64> {
    let last = changes.saturating_sub(MOST_KILLS / 2)..changes;
    let before = last.start;
    let step = (before / (MOST_KILLS / 2)).max(1);
    let mut numbers: Vec<u64> = (1..=before).step_by(step as usize).collect();
    numbers.extend(last.map(|number| number + 1));
    numbers
}

/// What work leaves, but for locks and speeds.
fn results(place: &TemporaryFolder, name: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = contents(&place.path(name));
    files.retain(|name, _| !name.contains(".lock"));
    if let Some(record) = files.get_mut("run.json") {
        let text = String::from_utf8_lossy(record).into_owned();
        let lines = text.lines().filter(|line| !line.contains("per_cpu_second"));
        *record = lines.collect::<Vec<_>>().join("\n").into_bytes();
    }
    files
}

/// One thread: the order of changes is always the same.
const WORK: [(&str, &str); 9] = [
    (
        "train",
        "train --control orientation --short --epochs 2 --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "tune",
        "tune set.zarr --least-samples 5 --trials 2 --epochs 3 --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "sweep",
        "sweep ring.json --salt 50mM,300mM --energy direct --replicas 1 --equilibration 3 --sweeps 20 \
         --trajectory-every 10 --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "pair",
        "pair a.body b.body --salt 100mM --relative-error 0.5 --interaction bare --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "hpmc",
        "hpmc run --shape cube --bodies 64 --packing-fraction 0.1 --sweeps 6 --equilibration 2 \
         --trajectory-every 3 --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "md",
        "md run --shape polygon:4 --bodies 36 --packing-fraction 0.2 --compress-steps 20 \
         --equilibrate-steps 20 --steps 40 --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "lattice",
        "lattice sweep --ns 2 --time 0.2 --r0-list 0.1 --kappa-list 0 --seeds 1 --checkpoint-every 0 -j 1 -q -o",
    ),
    (
        "voxels",
        "voxelize --manifest set.csv --size 16 --spacing 2 --channels shape --bodies bodies -j 1 -q -o",
    ),
    ("stream", "ingest in --stream --density 2 -j 1 -q -o"),
];

#[test]
#[ignore = "needs a C compiler, and takes some minutes: hundreds of processes are killed"]
fn work_that_was_killed_before_any_of_its_writes_ends_as_if_it_had_not_been() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("kill.c"), LIBRARY).unwrap();
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .args([&path("kill.so"), &path("kill.c")])
        .arg("-ldl")
        .status();
    assert!(compiled.unwrap().success());
    let chosen = std::env::var("PROTOMER_TEST_KILLED").ok();
    for (kind, command) in WORK {
        if chosen.as_deref().is_none_or(|chosen| chosen == kind) {
            is_killed_everywhere(kind, command, &path("kill.so"));
        }
    }
}

fn is_killed_everywhere(kind: &str, command: &str, library: &Path) {
    let place = match kind {
        "tune" => crate::tune::place(),
        _ => crate::writing::place(),
    };
    let run = |kill: Option<u64>| {
        let mut command = place.command(&format!("{command} work"));
        command
            .env("LD_PRELOAD", library)
            .env("COUNT_IN", place.path("count"))
            .stderr(Stdio::piped());
        if let Some(number) = kill {
            command.env("KILL_BEFORE", number.to_string());
        }
        command.output().unwrap()
    };
    is_ok(&run(None));
    let (whole, bodies) = (results(&place, "work"), results(&place, "bodies"));
    let count = std::fs::read_to_string(place.path("count")).unwrap();
    let count: u64 = count.parse().unwrap();
    assert!(count > 3, "{kind}: {count}");
    for number in kills(count) {
        for folder in ["work", "bodies", "work.partial"] {
            let _ = std::fs::remove_dir_all(place.path(folder));
        }
        let _ = std::fs::remove_file(place.path("work.work"));
        let killed = run(Some(number));
        let said = message(&killed);
        assert_eq!(killed.status.code(), None, "{kind} {number}: {said}");
        agree(&place, kind, number);
        let continued = run(None);
        let said = message(&continued);
        assert!(continued.status.success(), "{kind} {number}: {said}");
        let after = results(&place, "work");
        let names = whole.keys().chain(after.keys());
        let differing: Vec<&String> = names
            .filter(|name| whole.get(*name) != after.get(*name))
            .collect();
        assert!(
            differing.is_empty(),
            "{kind} killed before change {number}: {differing:?}"
        );
        assert!(results(&place, "bodies") == bodies, "{kind} {number}");
        assert!(!place.path("work.work").exists(), "{kind} {number}");
    }
}

/// A page calls finished only what the record does.
fn agree(place: &TemporaryFolder, kind: &str, number: u64) {
    let Ok(record) = std::fs::read_to_string(place.path("work/run.json")) else {
        return;
    };
    let is_done = record.contains("\"exit_reason\": \"done\"");
    if !place.run("report work -q --force").status.success() {
        // Too early for a page.
        assert!(!is_done, "{kind} {number}");
        return;
    }
    let page = std::fs::read_to_string(place.path("work/report.html")).unwrap();
    let is_finished = page.contains("nothing failed and nothing is missing");
    assert!(
        is_done || !is_finished,
        "{kind} {number}: the page says finished, and the record {record}"
    );
    std::fs::remove_file(place.path("work/report.html")).unwrap();
}
