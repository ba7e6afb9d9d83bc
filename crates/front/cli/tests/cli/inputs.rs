//! What an input may be, and what becomes of output that cannot be written.
#![cfg(unix)]

use crate::common::{TemporaryFolder, message, program};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::process::Command;

/// Every verb that reads a file, with PIPE for it.
const READERS: [&str; 16] = [
    "ingest PIPE.pdb -o out",
    "surface PIPE.pqr",
    "potential PIPE.pqr --salt 100mM",
    "shape PIPE.txt",
    "shape virial PIPE.txt",
    "shape contact PIPE.json",
    "body --mesh PIPE.off -o p.body",
    "body --mesh cube.off --charges PIPE.xyzq -o p.body",
    "assemble structure PIPE.pdb -o out",
    "assemble ring PIPE.body --members 4 -o r.json",
    "inspect PIPE.json",
    "sweep ring.json --config PIPE.toml --salt 100mM -o out",
    "pair PIPE.body --salt 100mM",
    "export PIPE.json -o out.pdb",
    "framework PIPE.toml",
    "voxelize --manifest PIPE.csv -o out.zarr",
];

#[test]
fn pipes_and_devices_are_refused_and_not_waited_for() {
    let place = TemporaryFolder::new();
    for ending in [
        "pdb", "pqr", "txt", "json", "off", "xyzq", "body", "toml", "csv",
    ] {
        let made = Command::new("mkfifo")
            .arg(place.path(&format!("pipe.{ending}")))
            .status();
        assert!(made.unwrap().success());
    }
    for arguments in READERS {
        // A program that waits for the pipe would wait for ever, so `timeout` ends it.
        let words = arguments.replace("PIPE", "pipe");
        let mut command = Command::new("timeout");
        let output = command
            .args(["30", env!("CARGO_BIN_EXE_protomer")])
            .args(words.split_whitespace())
            .env("PROTOMER_CACHE_DIR", "")
            .current_dir(place.path(""))
            .output()
            .unwrap();
        let said = message(&output);
        assert_eq!(output.status.code(), Some(1), "{words}: {said}");
        assert!(said.contains("it is a pipe, not a file"), "{words}: {said}");
    }
    let said = message(&place.run("surface /dev/zero"));
    assert!(said.contains("it is a device, not a file"), "{said}");
}

#[test]
fn names_that_are_not_text_are_refused_wherever_they_stand() {
    let place = TemporaryFolder::new();
    let name = OsStr::from_bytes(b"caf\xe9.pdb");
    std::fs::write(place.path("").join(name), "END\n").unwrap();
    for words in [
        ["ingest", "NAME", "-o", "out"],
        ["ingest", "cube.off", "-o", "NAME"],
        ["shape", "cube", "-o", "NAME"],
    ] {
        let words = words.map(|word| {
            if word == "NAME" {
                name
            } else {
                OsStr::new(word)
            }
        });
        let output = program(words).current_dir(place.path("")).output().unwrap();
        let said = message(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("not UTF-8; rename the file"), "{said}");
    }
    let output = place.run("ingest . -o out");
    let said = message(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("caf") && said.contains("not UTF-8; rename the file"),
        "{said}"
    );
}

#[test]
fn a_limit_of_the_size_of_files_is_an_error_that_says_what_to_do() {
    let place = TemporaryFolder::new();
    let output = place.run_limited(1, "shape prism:200,2 -o large.off");
    let said = message(&output);
    assert_eq!(output.status.code(), Some(1), "{:?} {said}", output.status);
    assert!(
        said.contains("large.off") && said.contains("ulimit -f"),
        "{said}"
    );
}
