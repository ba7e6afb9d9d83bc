//! Cases of the command line: each folder of `tests/golden` holds a `command` (one `protomer` call per line, words
//! separated by spaces), its input files, and the `expected` transcript: exit code, stdout and stderr of each call.
//!
//! `UPDATE_GOLDEN=1 cargo test -p protomer --test golden` writes the transcripts anew; read the difference before
//! committing it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Runs every line of the case's command in a copy of its folder and writes down what happened.
fn transcript(case: &Path) -> String {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(case).unwrap().map(Result::unwrap) {
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    let command = std::fs::read_to_string(case.join("command")).unwrap();
    let data = root().join("data").display().to_string();
    let mut transcript = String::new();
    for line in command.lines().filter(|line| !line.trim().is_empty()) {
        let words = line.split_whitespace().map(|word| word.replace("$DATA", &data));
        let output = Command::new(env!("CARGO_BIN_EXE_protomer"))
            .args(words)
            .current_dir(folder.path())
            .env("NO_COLOR", "1")
            .output()
            .unwrap();
        let plain = |bytes: &[u8]| {
            String::from_utf8_lossy(bytes).replace(&data, "$DATA").replace(&*folder.path().to_string_lossy(), "$FOLDER")
        };
        transcript += &format!("$ protomer {line}\nexit {}\n", output.status.code().unwrap_or(-1));
        for (name, bytes) in [("stdout", &output.stdout), ("stderr", &output.stderr)] {
            for text in plain(bytes).lines() {
                transcript += &format!("{name}: {text}\n");
            }
        }
    }
    transcript
}

#[test]
fn the_command_line_says_what_it_said() {
    let mut different = Vec::new();
    let mut cases: Vec<PathBuf> =
        std::fs::read_dir(root().join("tests/golden")).unwrap().map(|entry| entry.unwrap().path()).collect();
    cases.sort();
    assert!(!cases.is_empty());
    for case in cases {
        let found = transcript(&case);
        let path = case.join("expected");
        if std::env::var_os("UPDATE_GOLDEN").is_some() {
            std::fs::write(&path, &found).unwrap();
        }
        let expected = std::fs::read_to_string(&path).unwrap_or_default();
        if found != expected {
            different.push(format!("== {}\n-- expected\n{expected}\n-- found\n{found}", case.display()));
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
}
