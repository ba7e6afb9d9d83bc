//! Cases of the command line: each folder of `tests/golden` holds a `command` (one `protomer` call
//! per line, words separated by spaces, `$DATA` for the folder of the bundled data), its input
//! files, and the `expected` transcript: exit code, stdout and stderr of each call. The calls run
//! in a copy of the folder, so that no path of the machine is shown. A line `settings DIR` prints what
//! identifies a result: its stored settings, kind, verb and hash.
//!
//! `UPDATE_GOLDEN=1 cargo test -p protomer-cli --test golden` writes the transcripts anew; read the
//! difference before committing it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../..")
        .canonicalize()
        .unwrap()
}

/// A link where the system has them, so that messages name `data` and not the way to it.
fn link(target: &Path, link: &Path) {
    #[cfg(unix)]
    std::os::unix::fs::symlink(target, link).unwrap();
    #[cfg(not(unix))]
    panic!(
        "cannot link {} to {}: run these cases on Unix",
        link.display(),
        target.display()
    );
}

/// The settings file of a result, and the lines of its record that say which result it is.
fn identity(directory: &Path) -> String {
    let mut text = std::fs::read_to_string(directory.join("run.toml")).unwrap();
    let record = std::fs::read_to_string(directory.join("run.json")).unwrap();
    for key in ["kind", "verb", "identity"] {
        let start = format!("  \"{key}\": ");
        let lines = record.lines().filter(|line| line.starts_with(&start));
        text.extend(lines.map(|line| format!("{line}\n")));
    }
    text
}

/// Runs every line of the case's command in a copy of its folder and writes down what happened.
fn transcript(case: &Path) -> String {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(case).unwrap().map(Result::unwrap) {
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    link(&root().join("data"), &folder.path().join("data"));
    let command = std::fs::read_to_string(case.join("command")).unwrap();
    let mut transcript = String::new();
    for line in command.lines().filter(|line| !line.trim().is_empty()) {
        if let Some(directory) = line.strip_prefix("settings ") {
            transcript += &format!("$ {line}\n{}", identity(&folder.path().join(directory)));
            continue;
        }
        let mut program = Command::new(env!("CARGO_BIN_EXE_protomer"));
        common::cleaned(&mut program);
        program.args(
            line.split_whitespace()
                .map(|word| word.replace("$DATA", "data")),
        );
        let output = program.current_dir(folder.path()).output().unwrap();
        let plain = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        transcript += &format!(
            "$ protomer {line}\nexit {}\n",
            output.status.code().unwrap_or(-1)
        );
        for (name, bytes) in [("stdout", &output.stdout), ("stderr", &output.stderr)] {
            for text in plain(bytes).lines() {
                transcript += format!("{name}: {text}").trim_end();
                transcript += "\n";
            }
        }
    }
    transcript
}

#[test]
fn the_command_line_says_what_it_said() {
    let mut different = Vec::new();
    let mut cases: Vec<PathBuf> = std::fs::read_dir(root().join("tests/golden"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
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
            different.push(format!(
                "== {}\n-- expected\n{expected}\n-- found\n{found}",
                case.display()
            ));
        }
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
}
