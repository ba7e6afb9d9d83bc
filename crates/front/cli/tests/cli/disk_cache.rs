//! Energy tables kept from one process to the next.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use std::process::{Command, Output, Stdio};

const BENCH: &str = "bench ring.json --debye 9.6A --moves 100 --json --energy calibrated";

fn command(place: &TemporaryFolder, arguments: &str) -> Command {
    let mut command = place.command(arguments);
    command.env("PROTOMER_CACHE_DIR", place.path("cache"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Whether all tables came from the cache, and the decisions.
fn result(output: &Output) -> (bool, String) {
    is_ok(output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    (
        found["tables_from_cache"].as_bool().unwrap(),
        found["decisions_sha256"].as_str().unwrap().to_owned(),
    )
}

#[test]
fn the_second_process_computes_no_tables_and_decides_alike() {
    let place = TemporaryFolder::new();
    let run = || command(&place, BENCH).output().unwrap();
    let cold = run();
    let kept = contents(&place.path("cache"));
    // One for each kind of body, and their comparison.
    assert_eq!(kept.len(), 3);
    let warm = run();
    assert_eq!((result(&cold).0, result(&warm).0), (false, true));
    assert_eq!(result(&cold).1, result(&warm).1);
    assert_eq!(message(&warm), "");
    assert!(contents(&place.path("cache")) == kept);
}

#[test]
fn a_changed_byte_is_said_and_mended() {
    let place = TemporaryFolder::new();
    let run = |more: &str| command(&place, &format!("{BENCH}{more}")).output().unwrap();
    let cold = run("");
    let kept = contents(&place.path("cache"));
    assert_eq!(kept.len(), 3);
    // Only a table that is changed makes tables anew.
    let length_of_a_table = kept.values().map(Vec::len).max().unwrap() / 2;
    for (name, bytes) in &kept {
        let is_table = bytes.len() > length_of_a_table;
        let expected = (!is_table, result(&cold).1);
        let file = place.path("cache").join(name);
        let mut changed = bytes.clone();
        changed[bytes.len() / 2] ^= 1;
        std::fs::write(&file, &changed).unwrap();
        let mended = run("");
        assert!(
            message(&mended).contains(name) && message(&mended).contains("checksum"),
            "{}",
            message(&mended)
        );
        assert_eq!(result(&mended), expected);
        assert!(contents(&place.path("cache")) == kept);
        // Another file under this name.
        let other = kept.keys().find(|other| *other != name).unwrap();
        std::fs::copy(place.path("cache").join(other), &file).unwrap();
        let quiet = run(" --quiet");
        assert_eq!(message(&quiet), "");
        assert_eq!(result(&quiet), expected);
        assert!(contents(&place.path("cache")) == kept);
    }
}

#[test]
fn without_the_cache_nothing_is_read_or_written() {
    let place = TemporaryFolder::new();
    let output = command(&place, &format!("{BENCH} --no-cache"))
        .output()
        .unwrap();
    assert!(!result(&output).0);
    assert!(!place.path("cache").exists());
}

#[test]
fn a_folder_that_is_none_is_a_warning() {
    let place = TemporaryFolder::new();
    std::fs::write(place.path("cache"), "a file").unwrap();
    let output = command(&place, BENCH).output().unwrap();
    assert!(!result(&output).0);
    assert!(
        message(&output).contains("warning") && message(&output).contains("cache"),
        "{}",
        message(&output)
    );
}

#[test]
fn processes_at_once_do_each_other_no_harm() {
    let place = TemporaryFolder::new();
    let running: Vec<_> = (0..4)
        .map(|_| command(&place, BENCH).spawn().unwrap())
        .collect();
    let outputs: Vec<Output> = running
        .into_iter()
        .map(|child| child.wait_with_output().unwrap())
        .collect();
    // Whoever makes the folder says so, once, with how to empty it.
    let said: String = outputs.iter().map(message).collect();
    assert_eq!(said.lines().count(), 1, "{said}");
    for words in [
        "what takes long to make is kept in ",
        "at most 2 GB",
        "empty it with rm -r ",
    ] {
        assert!(said.contains(words), "{said}");
    }
    for output in &outputs {
        assert_eq!(result(output).1, result(&outputs[0]).1);
    }
    let last = command(&place, BENCH).output().unwrap();
    assert_eq!(message(&last), "");
    assert_eq!(result(&last), (true, result(&outputs[0]).1));
    assert_eq!(
        contents(&place.path("cache")).len(),
        3,
        "no partial files stay"
    );
}
