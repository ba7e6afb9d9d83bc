//! A sweep that was killed, stopped, shared or tampered with.

use super::{SWEEP, assert_same, results, sweep_of};
use crate::common::{TemporaryFolder, contents, is_ok, message};
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

/// Starts the command and waits until it has written a checkpoint below `directory`, or has ended.
fn spawn_until_saved(place: &TemporaryFolder, command: &str, directory: &str) -> Child {
    let checkpoints = || {
        // Files come and go while the process works.
        let salts = ["salt_0.050000M", "salt_0.300000M"];
        let paths = salts
            .iter()
            .flat_map(|salt| (0..2).map(move |replica| format!("{salt}/replica_{replica}")));
        let ladders = (0..2).map(|replica| format!("ladder_{replica}"));
        paths
            .chain(ladders)
            .map(|path| {
                std::fs::read(place.path(&format!("{directory}/{path}/checkpoint.bin"))).ok()
            })
            .collect()
    };
    let before: Vec<Option<Vec<u8>>> = checkpoints();
    let mut child = place.command(command).spawn().unwrap();
    while checkpoints() == before && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

/// Starts the command and ends it by a signal after its first checkpoint.
#[cfg(unix)]
fn stop(place: &TemporaryFolder, command: &str, directory: &str) {
    let mut child = spawn_until_saved(place, command, directory);
    // The process may just have ended by itself; then there is nobody to hear the signal.
    let _ = Command::new("sh")
        .args(["-c", "kill -TERM \"$0\" 2>&1", &child.id().to_string()])
        .output();
    assert_eq!(child.wait().unwrap().code(), Some(3), "{command}");
}

#[test]
fn a_killed_sweep_goes_on_as_if_nothing_had_happened_on_any_number_of_threads() {
    is_killed_and_goes_on("direct", 1500, &[0, 1, 2, 4, 8, 16]);
}

#[test]
fn a_killed_sweep_with_calibrated_energies_goes_on_too() {
    is_killed_and_goes_on("calibrated", 40, &[4, 64]);
}

#[test]
fn a_killed_sweep_with_approximate_energies_goes_on_too() {
    is_killed_and_goes_on("approximate --tolerance 1e-5", 40, &[4, 64]);
}

#[test]
fn a_killed_sweep_with_exchange_goes_on_too() {
    let options = "calibrated --exchange-every 7 --starts both";
    is_killed_and_goes_on(options, 40, &[4, 64]);
}

/// Kills a sweep again and again, each time so long after its next checkpoint, then lets it end. Bodies
/// with few charges move about ten times as fast by direct sums as by levels: their runs are longer.
fn is_killed_and_goes_on(energy: &str, sweeps: u32, milliseconds: &[u64]) {
    let place = TemporaryFolder::new();
    let sweep = sweep_of(sweeps, sweeps / 7);
    is_ok(&place.run(&format!("{sweep} --energy {energy} --threads 1 -o whole")));
    let whole = results(&place.path("whole"));
    let mut caught_at_work = 0;
    for threads in [1, 2] {
        let command = format!(
            "{sweep} --energy {energy} --threads {threads} --checkpoint-every 0.005 -o killed{threads}"
        );
        for &extra_milliseconds in milliseconds {
            let mut child = spawn_until_saved(&place, &command, &format!("killed{threads}"));
            std::thread::sleep(Duration::from_millis(extra_milliseconds));
            child.kill().unwrap();
            child.wait().unwrap();
            let left = contents(&place.path(&format!("killed{threads}")));
            let begun = left.keys().any(|name| name.ends_with("checkpoint.bin"));
            caught_at_work += u32::from(begun && !left.contains_key("sweep.csv"));
        }
        is_ok(&place.run(&command));
        assert_same(&whole, &results(&place.path(&format!("killed{threads}"))));
    }
    assert!(
        caught_at_work > 0,
        "every kill came too early or too late to test anything"
    );
}

#[test]
fn parts_in_many_processes_make_the_same_sweep_and_a_killed_one_costs_its_own() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o whole")));
    let part =
        |number: usize| format!("{SWEEP} --checkpoint-every 0.005 -o parts --shard {number}/3");
    let mut others = [2, 3].map(|number| place.command(&part(number)).spawn().unwrap());
    let mut killed = spawn_until_saved(&place, &part(1), "parts");
    killed.kill().unwrap();
    killed.wait().unwrap();
    // While a part is at work nobody has the directory alone. The others may end at any time: this
    // process stands for one.
    let at_work = std::fs::File::open(place.path("parts/.lock")).unwrap();
    at_work.lock_shared().unwrap();
    assert!(message(&place.run(&format!("{SWEEP} -o parts"))).contains("another process"));
    drop(at_work);
    assert!(
        others
            .iter_mut()
            .all(|other| other.wait().unwrap().success())
    );
    for folder in ["", "salt_0.050000M/replica_0/", "salt_0.300000M/replica_1/"] {
        // The first part may have been killed before it made its folders.
        let folder = place.path(&format!("parts/{folder}"));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(".checkpoint.bin.1-0.partial"), "cut sho").unwrap();
    }
    is_ok(&place.run(&part(1)));
    assert!(!place.path("parts/sweep.csv").exists());
    is_ok(&place.run(&format!("{SWEEP} -o parts")));
    assert_same(
        &results(&place.path("whole")),
        &results(&place.path("parts")),
    );
    assert!(message(&place.run(&format!("{} --force", part(1)))).contains("cannot start again"));
    assert_eq!(
        place
            .run(&format!("{SWEEP} -o parts --shard 4/3"))
            .status
            .code(),
        Some(2)
    );
}

#[test]
fn a_time_limit_stops_resumably() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o whole")));
    let command = format!("{SWEEP} -o limited");
    assert_eq!(
        place
            .run(&format!("{command} --time-limit 0"))
            .status
            .code(),
        Some(3)
    );
    assert!(!place.path("limited/sweep.csv").exists());
    is_ok(&place.run(&command));
    assert_same(
        &results(&place.path("whole")),
        &results(&place.path("limited")),
    );
    // Once more finds everything done and leaves it as it is.
    is_ok(&place.run(&format!("{command} --time-limit 0")));
    assert_same(
        &results(&place.path("whole")),
        &results(&place.path("limited")),
    );
}

#[test]
fn a_finished_sweep_can_be_run_on() {
    let place = TemporaryFolder::new();
    let longer = SWEEP.replace("--sweeps 1500", "--sweeps 1800");
    assert_ne!(longer, SWEEP);
    is_ok(&place.run(&format!("{longer} -o whole")));
    is_ok(&place.run(&format!("{SWEEP} -o parts")));
    is_ok(&place.run(&format!("{longer} -o parts")));
    assert_same(
        &results(&place.path("whole")),
        &results(&place.path("parts")),
    );
    let shorter = place.run(&format!("{SWEEP} -o parts"));
    assert_eq!(shorter.status.code(), Some(1));
    assert!(
        message(&shorter).contains("ask for at least as many"),
        "{}",
        message(&shorter)
    );
}

#[cfg(unix)]
#[test]
fn a_signal_stops_resumably_also_after_the_time_limit() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o whole")));
    let command = format!("{SWEEP} --threads 1 --checkpoint-every 0.005 -o signalled");
    stop(&place, &command, "signalled");
    stop(&place, &format!("{command} --time-limit 0"), "signalled");
    is_ok(&place.run(&command));
    assert_same(
        &results(&place.path("whole")),
        &results(&place.path("signalled")),
    );
}

#[cfg(unix)]
#[test]
fn what_was_tampered_with_is_refused_and_left_alone() {
    let place = TemporaryFolder::new();
    let command = format!("{SWEEP} --threads 1 --checkpoint-every 0.005 -o run");
    stop(&place, &command, "run");
    let replica = "run/salt_0.050000M/replica_0";
    let tamper = |file: &str, change: fn(&mut Vec<u8>)| {
        let path = place.path(&format!("{replica}/{file}"));
        let sound = std::fs::read(&path).unwrap();
        let mut changed = sound.clone();
        change(&mut changed);
        assert_ne!(sound, changed);
        std::fs::write(&path, changed).unwrap();
        let before = contents(&place.path(replica));
        let output = place.run(&command);
        assert_eq!(
            output.status.code(),
            Some(1),
            "{file}: {}",
            message(&output)
        );
        let said = message(&output);
        assert!(
            said.contains(file) && said.contains("--force") && said.contains("salt 0.05 M"),
            "{said}"
        );
        assert_same(&before, &contents(&place.path(replica)));
        std::fs::write(&path, sound).unwrap();
    };
    let flip = |bytes: &mut Vec<u8>| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
    };
    tamper("checkpoint.bin", flip);
    tamper("checkpoint.bin", |bytes| bytes.truncate(bytes.len() / 2));
    tamper("checkpoint.bin", Vec::clear);
    tamper("log.csv", flip);
    tamper("log.csv", |bytes| bytes.truncate(bytes.len() - 3));
    is_ok(&place.run(&command));
    // Also once all is done: the table must not be made of something else.
    tamper("log.csv", flip);
    is_ok(&place.run(&format!("{SWEEP} -o whole")));
    assert_same(&results(&place.path("whole")), &results(&place.path("run")));
}

#[test]
fn a_shortened_trajectory_is_refused_and_left_alone() {
    let place = TemporaryFolder::new();
    let command = "simulate ring.json --salt 50mM --sweeps 100000000 --equilibration 0 --trajectory-every 5 \
                   -o run --time-limit 0.01";
    assert_eq!(place.run(command).status.code(), Some(3));
    let path = place.path("run/salt_0.050000M/replica_0/trajectory.gsd");
    let sound = std::fs::read(&path).unwrap();
    std::fs::write(&path, &sound[..sound.len() / 2]).unwrap();
    let before = contents(&place.path("run/salt_0.050000M/replica_0"));
    let output = place.run(command);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message(&output).contains("trajectory.gsd"),
        "{}",
        message(&output)
    );
    assert_same(
        &before,
        &contents(&place.path("run/salt_0.050000M/replica_0")),
    );
}

#[test]
fn force_removes_the_results_of_protomer_and_nothing_else() {
    let place = TemporaryFolder::new();
    std::fs::create_dir(place.path("mine")).unwrap();
    std::fs::write(place.path("mine/thesis.tex"), "years of work").unwrap();
    let output = place.run(&format!("{SWEEP} -o mine --force"));
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message(&output).contains("does not hold a sweep"),
        "{}",
        message(&output)
    );
    assert_eq!(contents(&place.path("mine")).len(), 1);

    let (other, senseless) = (
        SWEEP.replace("--seed 7", "--seed 8"),
        format!("{SWEEP} --cutoff 1000A"),
    );
    // The directory of the input may be the directory of the results.
    is_ok(&place.run(&format!("{SWEEP} -o .")));
    let first = std::fs::read(place.path("sweep.csv")).unwrap();
    let output = place.run(&format!("{other} -o ."));
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message(&output).contains("other settings"),
        "{}",
        message(&output)
    );
    // A new run that makes no sense costs the old one nothing.
    assert_eq!(
        place
            .run(&format!("{senseless} -o . --force"))
            .status
            .code(),
        Some(1)
    );
    assert_eq!(std::fs::read(place.path("sweep.csv")).unwrap(), first);
    is_ok(&place.run(&format!("{other} -o . --force")));
    assert_ne!(std::fs::read(place.path("sweep.csv")).unwrap(), first);
    assert!(place.path("ring.json").exists() && place.path("a.body").exists());
}

#[test]
fn other_input_in_the_same_directory_is_refused() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o run")));
    let text = std::fs::read_to_string(place.path("ring.json")).unwrap();
    std::fs::write(
        place.path("ring.json"),
        text.replace("[12, 0, 0]", "[12.5, 0, 0]"),
    )
    .unwrap();
    let before = contents(&place.path("run"));
    let output = place.run(&format!("{SWEEP} -o run"));
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message(&output).contains("other input"),
        "{}",
        message(&output)
    );
    assert_same(&before, &contents(&place.path("run")));
}

#[test]
fn two_processes_do_not_work_in_one_directory() {
    let place = TemporaryFolder::new();
    let long = "simulate ring.json --salt 50mM --sweeps 100000000 -o run";
    let mut first = place.command(long).spawn().unwrap();
    while !place.path("run/run.json").exists() {
        assert!(
            first.try_wait().unwrap().is_none(),
            "the first process ended"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = place.run(long);
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        message(&output).contains("another process"),
        "{}",
        message(&output)
    );
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_costs_nothing() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o whole")));
    let whole = results(&place.path("whole"));
    let command = format!("{SWEEP} --checkpoint-every 0.005 -o full");
    let output = place.run_limited(16, &command);
    let said = message(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("cannot write") && said.contains("full/salt_0"),
        "{said}"
    );
    // The records say the same to whoever looks later.
    let ends = [
        exit_reasons(&place.path("full"), ""),
        exit_reasons(&place.path("full"), "replica_"),
    ];
    assert!(
        ends.iter()
            .all(|ends| ends.iter().any(|end| end.contains("cannot write"))),
        "{ends:?}"
    );
    is_ok(&place.run(&command));
    assert_same(&whole, &results(&place.path("full")));
    // Nothing of a finished sweep is lost when its table and figure cannot be written again.
    let output = place.run_limited(1, &command);
    assert_eq!(output.status.code(), Some(1), "{}", message(&output));
    let mut after = contents(&place.path("full"));
    after.remove(".lock");
    assert_same(&whole, &after);
}

/// How the runs ended whose directory's name begins with this; the sweep itself where it is empty.
fn exit_reasons(directory: &Path, name: &str) -> Vec<String> {
    let files = contents(directory);
    let of_run = |path: &str| match name {
        "" => path == "run.json",
        name => path.contains(&format!("/{name}")) && path.ends_with("run.json"),
    };
    let reason = |bytes: &Vec<u8>| {
        let record: serde_json::Value = serde_json::from_slice(bytes).unwrap();
        let (word, error) = (&record["exit_reason"], &record["error"]);
        error.as_str().or(word.as_str()).unwrap().to_owned()
    };
    files
        .iter()
        .filter(|(path, _)| of_run(path))
        .map(|(_, bytes)| reason(bytes))
        .collect()
}

#[test]
fn a_start_that_fails_leaves_its_reason_and_can_be_tried_again() {
    let place = TemporaryFolder::new();
    let short = sweep_of(16, 6);
    is_ok(&place.run(&format!("{short} --energy calibrated -o whole")));
    let output = place.run(&format!(
        "{short} --energy calibrated --memory-limit 1kB --threads 1 -o small"
    ));
    assert_eq!(output.status.code(), Some(1));
    let small = place.path("small");
    let reasons = exit_reasons(&small, "replica_");
    assert!(
        reasons
            .iter()
            .any(|reason| reason.contains("--memory-limit")),
        "{reasons:?}"
    );
    assert!(
        exit_reasons(&small, "")[0].contains("salt 0.05 M, replica 0"),
        "{:?}",
        exit_reasons(&small, "")
    );
    is_ok(&place.run(&format!("{short} --energy calibrated -o small")));
    assert_same(&results(&place.path("whole")), &results(&small));
}

#[cfg(unix)]
#[test]
fn a_stopped_sweep_knows_what_stopped_it() {
    let place = TemporaryFolder::new();
    let command = format!("{SWEEP} --threads 1 --checkpoint-every 0.005 -o run");
    stop(&place, &command, "run");
    let end_of = |file: &str| {
        let bytes = std::fs::read(place.path(file)).unwrap();
        let record: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
        let by = record["details"]["stopped_by"].clone();
        (record["exit_reason"].clone(), by)
    };
    let stopped_by = |what: &str| ("stopped".into(), what.into());
    assert_eq!(end_of("run/run.json"), stopped_by("a signal"));
    let replica = "run/salt_0.050000M/replica_0/run.json";
    assert_eq!(end_of(replica), stopped_by("a signal"));
    // What is not begun again keeps its record.
    let limited = place.run(&format!("{command} --time-limit 0"));
    assert_eq!(limited.status.code(), Some(3));
    assert_eq!(end_of("run/run.json"), stopped_by("the time limit"));
    assert_eq!(end_of(replica), stopped_by("a signal"));
    // A sweep at work does not say that it was stopped.
    let mut child = spawn_until_saved(
        &place,
        &format!("{SWEEP} --threads 1 --checkpoint-every 0.005 -o run"),
        "run",
    );
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(exit_reasons(&place.path("run"), ""), ["running"]);
    assert!(exit_reasons(&place.path("run"), "replica_").contains(&"running".to_owned()));
}
