//! Sweeps as a process: killed, stopped, continued, on a full disk, in a directory that was
//! tampered with.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use protomer_kernel::statistics::Summary;
use protomer_protein_verbs::stability::run::{AcceptedFractions, Columns, RunSettings, Starts};
use protomer_protein_verbs::stability::sweep::figure::figure;
use protomer_protein_verbs::stability::sweep::result::SweepResult;
use protomer_protein_verbs::stability::sweep::stability::Stability;
use protomer_protein_verbs::stability::sweep::table::{ReplicaResult, SaltRow};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

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
fn calibrated_energies_make_the_trajectories_of_the_direct_sum() {
    let place = TemporaryFolder::new();
    let sweep = sweep_of(80, 20);
    for energy in ["direct", "calibrated"] {
        is_ok(&place.run(&format!("{sweep} --energy {energy} -o {energy}")));
    }
    for replica in ["salt_0.050000M/replica_0", "salt_0.300000M/replica_1"] {
        let log = |energy: &str| columns(&place.path(&format!("{energy}/{replica}/log.csv")));
        let (direct, calibrated) = (log("direct"), log("calibrated"));
        for column in [
            "sweep",
            "r_g_angstrom",
            "native_contacts",
            "largest_cluster",
            "cluster_moved",
        ] {
            assert_eq!(direct[column], calibrated[column], "{replica} {column}");
        }
        let energies = direct["energy_kT"].iter().zip(&calibrated["energy_kT"]);
        assert!(
            energies
                .clone()
                .all(|(sum, middle)| (sum - middle).abs() < 1e-3),
            "{replica}"
        );
        assert!(
            energies.clone().any(|(sum, middle)| sum != middle),
            "{replica}: intervals were used"
        );
    }
}

#[test]
fn a_tolerance_belongs_to_approximate_energies_and_to_the_run() {
    let place = TemporaryFolder::new();
    let short = sweep_of(16, 6);
    let refused = |command: &str, code: i32, words: &[&str]| {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(code), "{command}");
        assert!(
            words.iter().all(|word| message(&output).contains(word)),
            "{command}: {}",
            message(&output)
        );
    };
    refused(
        &format!("{short} --tolerance 1e-3 -o run"),
        1,
        &["--energy approximate", "direct"],
    );
    for senseless in ["0", "-1e-3", "inf", "NaN"] {
        refused(
            &format!("{short} --energy approximate --tolerance {senseless} -o run"),
            2,
            &["--tolerance", "give 1e-12 to"],
        );
    }
    // The usual tolerance is written down; it can be stated, another one is another run.
    is_ok(&place.run(&format!("{short} --energy approximate -o run")));
    let settings = std::fs::read_to_string(place.path("run/run.toml")).unwrap();
    assert!(
        settings.contains("energy = \"approximate\"\ntolerance_kt = 0.001\n"),
        "{settings}"
    );
    is_ok(&place.run(&format!(
        "{short} --energy approximate --tolerance 1e-3 -o run"
    )));
    refused(
        &format!("{short} --energy approximate --tolerance 1e-4 -o run"),
        1,
        &["other settings"],
    );
    is_ok(&place.run("sweep ring.json --config run/run.toml -o again --quiet"));
    assert_same(&results(&place.path("run")), &results(&place.path("again")));
    // The tolerance of a configuration goes with its energies.
    is_ok(&place.run("sweep ring.json --config run/run.toml --energy direct -o direct --quiet"));
    assert!(
        !std::fs::read_to_string(place.path("direct/run.toml"))
            .unwrap()
            .contains("tolerance")
    );
    let text = settings.replace("tolerance_kt", "tolerance");
    std::fs::write(place.path("misspelt.toml"), text).unwrap();
    refused(
        "sweep ring.json --config misspelt.toml -o misspelt --quiet",
        1,
        &["tolerance"],
    );
    refused(
        &format!("{short} --energy calibrated --memory-limit 1kB -o small"),
        1,
        &["--memory-limit", "salt 0.05 M"],
    );
}

/// The program chooses how energies are computed, writes it down, and keeps to it.
#[test]
fn the_energies_of_a_run_are_chosen_once() {
    let place = TemporaryFolder::new();
    let short =
        "sweep ring.json --salt 50mM,300mM --replicas 2 --sweeps 20 --equilibration 10 --quiet";
    let settings = |directory: &str| {
        std::fs::read_to_string(place.path(&format!("{directory}/run.toml"))).unwrap()
    };
    is_ok(&place.run(&format!("{short} -o run")));
    let chosen = settings("run");
    assert!(chosen.contains("energy = \"direct\""), "{chosen}");
    assert!(chosen.contains("definition = \"no cut-off\""), "{chosen}");
    is_ok(&place.run(&format!("{short} --energy calibrated -o begun")));
    is_ok(&place.run(&format!("{short} -o begun")));
    assert!(settings("begun").contains("energy = \"calibrated\""));
    // Earlier versions cut energies by default, and did not say so in the settings.
    let earlier = chosen.replace("definition = \"no cut-off\"\n", "");
    std::fs::write(place.path("run/run.toml"), earlier).unwrap();
    let output = place.run(&format!("{short} -o run"));
    assert_eq!(output.status.code(), Some(1));
    let said = message(&output);
    assert!(
        said.contains("medium.definition: none there, \"no cut-off\" here"),
        "{said}"
    );
}

/// Contacts of earlier versions were counted from vertices: a run that was begun so is not continued,
/// but its results are read.
#[test]
fn contacts_of_two_definitions_are_not_mixed_in_a_run() {
    let place = TemporaryFolder::new();
    let short = "sweep ring.json --salt 50mM,300mM --replicas 2 --sweeps 20 --equilibration 10 \
                 --log-every 1 --trajectory-every 1 --quiet -o run";
    is_ok(&place.run(short));
    let path = place.path("run/run.toml");
    let begun = std::fs::read_to_string(&path).unwrap();
    let stated = "contact_definition = \"between surfaces\"\n";
    assert!(begun.contains(stated), "{begun}");
    std::fs::write(&path, begun.replace(stated, "")).unwrap();
    let before = contents(&place.path("run"));
    let refused = place.run(short);
    assert_eq!(refused.status.code(), Some(1));
    let said = message(&refused);
    let wanted = "contact_definition: none there, \"between surfaces\" here";
    assert!(said.contains(wanted), "{said}");
    assert!(contents(&place.path("run")) == before);
    for reading in [
        "reweight run",
        "compare run -o compared.svg",
        "report run -o report.html",
    ] {
        is_ok(&place.run(reading));
    }
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

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sample_deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values
        .iter()
        .map(|x| (x - centre) * (x - centre))
        .sum::<f64>()
        / (values.len() as f64 - 1.0))
        .sqrt()
}

#[test]
fn the_table_holds_the_averages_of_the_logs() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o run")));
    let table = columns(&place.path("run/sweep.csv"));
    assert_eq!(table["salt_M"], [0.05, 0.3]);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("run/sweep.json")).unwrap()).unwrap();
    for (row, salt) in ["salt_0.050000M", "salt_0.300000M"].into_iter().enumerate() {
        let logs: Vec<_> = (0..2)
            .map(|replica| columns(&place.path(&format!("run/{salt}/replica_{replica}/log.csv"))))
            .collect();
        for (logged, tabled, unit) in [
            ("r_g_angstrom", "r_g", "_angstrom"),
            ("native_contacts", "native_contacts", ""),
            ("largest_cluster", "largest_cluster", ""),
            ("energy_kT", "energy", "_kT"),
            ("bound_fraction", "bound_fraction", ""),
        ] {
            let means: Vec<f64> = logs.iter().map(|log| mean(&log[logged])).collect();
            assert_eq!(logs[0][logged].len(), 300, "a row every 5 of 1500 sweeps");
            for (kind, expected) in [("mean", mean(&means)), ("sd", sample_deviation(&means))] {
                let column = format!("{tabled}_{kind}{unit}");
                let found = table[&column][row];
                assert!(
                    (found - expected).abs() <= 1e-9 * (1.0 + expected.abs()),
                    "{column}: {found} {expected}"
                );
                let in_json = json["salts"][row][&column].as_f64().unwrap();
                assert!(
                    (in_json - expected).abs() <= 1e-9 * (1.0 + expected.abs()),
                    "{column} of sweep.json"
                );
            }
        }
        assert!(
            logs[0]["r_g_angstrom"] != logs[1]["r_g_angstrom"],
            "replicas differ"
        );
    }
    for figure in ["run/sweep.svg", "run/sweep.png"] {
        assert!(
            std::fs::metadata(place.path(figure)).unwrap().len() > 1000,
            "{figure}"
        );
    }
}

#[test]
fn the_answer_names_the_half_salt_or_says_why_not() {
    let place = TemporaryFolder::new();
    for (name, charge) in [("a", 6), ("b", -6)] {
        std::fs::write(place.path("charge.xyzq"), format!("0 0 0 {charge}\n")).unwrap();
        let body = format!("body --mesh cube.off --charges charge.xyzq -o {name}.body --force");
        is_ok(&place.run(&body));
    }
    let answer = |options: &str, directory: &str| -> serde_json::Value {
        let sweep = "sweep ring.json --salt 50mM,300mM --replicas 2 --seed 7 --log-every 5 --json";
        let output = place.run(&format!("{sweep} {options} -o {directory}"));
        is_ok(&output);
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let alike = answer("--sweeps 400 --equilibration 100", "alike");
    let half = alike["half_salt_molar"].as_f64().unwrap();
    assert!(half > 0.05 && half < 0.3, "{half}");
    let interval = &alike["half_salt_interval_molar"];
    assert!(interval[0].as_f64().is_none_or(|low| low <= half));
    assert!(interval[1].as_f64().is_none_or(|high| high >= half));
    assert!(alike["equilibrated"].is_null());
    // So short a run keeps its start.
    let apart = answer("--sweeps 40 --equilibration 0 --starts both", "apart");
    assert_eq!(apart["equilibrated"], serde_json::json!(false));
    assert_eq!(
        (&alike["equilibrium"], &apart["equilibrium"]),
        (&"unknown".into(), &"no".into())
    );
    assert!(apart["half_salt_molar"].is_null());
    let words = apart["equilibration"].as_str().unwrap();
    assert!(words.starts_with("not equilibrated: at "), "{words}");
    let exchanged = answer(
        "--sweeps 40 --equilibration 0 --exchange-every 5",
        "exchanged",
    );
    let acceptance = &exchanged["exchanges"][1]["acceptance"];
    assert_eq!(acceptance.as_array().map(Vec::len), Some(1));
    for (options, wanted) in [
        ("--exchange-every 5 --salt 50mM", "list several"),
        ("--starts both --replicas 1 --salt 50mM", "--replicas 2"),
        (
            "--exchange-every 5 --energy none --salt 50mM,300mM",
            "--exchange-every",
        ),
    ] {
        let words = message(&place.run(&format!("sweep ring.json {options} -o refused")));
        assert!(words.contains(wanted), "{options}: {words}");
    }
}

/// Open space has no equilibrium: that is said before the run, answers that need one are refused at
/// once, and the box that is advised works.
#[test]
fn open_space_is_said_before_the_run_and_the_advice_works() {
    let place = TemporaryFolder::new();
    let ring = std::fs::read_to_string(place.path("ring.json")).unwrap();
    let mut assembly: serde_json::Value = serde_json::from_str(&ring).unwrap();
    assembly["box_angstrom"] = serde_json::Value::Null;
    std::fs::write(place.path("open.json"), assembly.to_string()).unwrap();
    let short = "--salt 50mM,300mM --replicas 2 --sweeps 20 --equilibration 0";
    let open = place.run(&format!("sweep open.json {short} -o open"));
    is_ok(&open);
    let words = message(&open);
    // Stopped before the first simulation, it has said so already.
    let stopped = place.run(&format!(
        "sweep open.json {short} --time-limit 0 -o stopped"
    ));
    assert_eq!(stopped.status.code(), Some(3));
    assert!(
        message(&stopped).contains("no box"),
        "{}",
        message(&stopped)
    );
    assert!(!place.path("stopped/sweep.csv").exists());
    let result = std::fs::read(place.path("open/sweep.json")).unwrap();
    let result: serde_json::Value = serde_json::from_slice(&result).unwrap();
    assert_eq!(result["equilibrated"], false);
    assert!(result["half_salt_molar"].is_null());
    assert!(result["equilibration"].as_str().unwrap().contains("no box"));
    // Before any simulation, and before any fit.
    for options in ["--starts both", "--exchange-every 5"] {
        let refused = place.run(&format!("sweep open.json {short} {options} -o refused"));
        assert_eq!(refused.status.code(), Some(1));
        assert!(message(&refused).contains("\"box_angstrom\": ["));
        assert!(!place.path("refused").exists());
    }
    let edge = words.split("\"box_angstrom\": [").nth(1).unwrap();
    let edge: f64 = edge.split(',').next().unwrap().parse().unwrap();
    assembly["box_angstrom"] = serde_json::json!([edge, edge, edge]);
    std::fs::write(place.path("boxed.json"), assembly.to_string()).unwrap();
    let advised = format!("sweep boxed.json {short} --starts both --exchange-every 5 -o boxed");
    is_ok(&place.run(&advised));
}

/// `--starts both` is advised with as many replicas as it needs.
#[test]
fn the_advice_to_one_replica_works_when_followed() {
    let place = TemporaryFolder::new();
    let short = "sweep ring.json --salt 50mM,300mM --sweeps 20 --equilibration 0";
    let output = place.run(&format!("{short} --replicas 1 -o one --json"));
    is_ok(&output);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let words = result["equilibration"].as_str().unwrap();
    let advice = "--starts both --replicas 4";
    assert!(words.contains(advice), "{words}");
    is_ok(&place.run(&format!("{short} {advice} -o both")));
}

#[test]
fn the_settings_file_of_a_run_is_a_configuration_that_continues_it() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o first")));
    is_ok(&place.run("sweep ring.json --config first/run.toml -o second --quiet"));
    is_ok(&place.run("sweep ring.json --config first/run.toml -o first --quiet"));
    assert_same(
        &results(&place.path("first")),
        &results(&place.path("second")),
    );
    let settings = RunSettings {
        seed: 3,
        log_every: 7,
        contact_gap_angstrom: 0.1 + 0.2,
        ..RunSettings::default()
    };
    assert_eq!(
        toml::from_str::<RunSettings>(&toml::to_string_pretty(&settings).unwrap()).unwrap(),
        settings
    );
    assert!(toml::from_str::<RunSettings>("sweps = 3").is_err());
    assert!(toml::from_str::<RunSettings>("[medium]\nsalt = 3").is_err());
}

/// A sweep whose replicas have these fractions of bound bodies and of contacts at three salts.
fn drawn(starts: Starts, fractions: impl Fn(u32, usize) -> f64) -> Value {
    let settings = RunSettings {
        salt_molar: vec![0.05, 0.1, 0.2],
        replicas: 4,
        starts,
        ..RunSettings::default()
    };
    let summary = |mean| Summary {
        mean,
        standard_deviation: 0.01,
        standard_error: 0.01,
        autocorrelation_time: 0.5,
        effective_samples: 100.0,
    };
    let replica = |replica, salt| ReplicaResult {
        replica,
        averages: Columns {
            r_g_angstrom: Some(summary(50.0)),
            native_contacts: Some(summary(fractions(replica, salt))),
            contacts: Some(summary(8.0 * fractions(replica, salt))),
            bound_fraction: Some(summary(fractions(replica, salt))),
            ..Columns::default()
        },
        accepted: AcceptedFractions {
            translation_acceptance: 0.4,
            rotation_acceptance: 0.4,
        },
        effective_bodies: None,
        warnings: Vec::new(),
    };
    let replicas: Vec<Vec<ReplicaResult>> = (0..3)
        .map(|salt| (0..4).map(|number| replica(number, salt)).collect())
        .collect();
    let mut salts = Vec::new();
    for (salt_molar, replicas) in settings.salt_molar.iter().zip(&replicas) {
        let interaction = settings.medium.interaction(Some(*salt_molar)).unwrap();
        salts.push(SaltRow::new(*salt_molar, &interaction, replicas));
    }
    let figure = figure(&SweepResult {
        equilibrium: "unknown".into(),
        warnings: Vec::new(),
        version: String::new(),
        model: "thesis".into(),
        input_sha256: String::new(),
        bodies: 8,
        concentration_molar: 1e-4,
        box_angstrom: Some([500.0; 3]),
        stability: Stability::new(&settings, &replicas, 8, false),
        settings,
        salts,
        replicas,
        exchanges: Vec::new(),
        time_series: Vec::new(),
    });
    assert!(figure.to_svg().is_ok());
    serde_json::to_value(figure).unwrap()
}

/// The names of the series in each panel.
fn names(figure: &Value) -> Vec<Vec<&str>> {
    fn series(panel: &Value) -> Vec<&str> {
        let series = panel["series"].as_array().unwrap();
        series
            .iter()
            .map(|series| series["name"].as_str().unwrap())
            .collect()
    }
    figure["panels"]
        .as_array()
        .unwrap()
        .iter()
        .map(series)
        .collect()
}

#[test]
fn the_figure_tells_starts_apart_and_marks_the_half_salt() {
    let falling = [0.95, 0.75, 0.05];
    let agree = drawn(Starts::Both, |_, salt| falling[salt]);
    let starts = ["from the assembly", "from a fluid"];
    let half = "half, and its interval of 95 %";
    assert_eq!(
        names(&agree),
        [
            starts.to_vec(),
            [starts.as_slice(), &[half]].concat(),
            [starts.as_slice(), &[half]].concat()
        ]
    );
    for panel in [1, 2] {
        let span = &agree["panels"][panel]["series"][2]["spans"][0];
        let [x, y, from, to] = ["x", "y", "from", "to"].map(|key| span[key].as_f64().unwrap());
        // Between 100 mM, where 0.75 are left, and 200 mM.
        assert!((100.0..200.0).contains(&x) && y == 0.5, "{span}");
        assert!(from < x && x < to, "{span}");
    }

    // The mean of starts that disagree is a state of neither: each has its curve, and there is no half.
    let apart = drawn(Starts::Both, |replica, _| match replica % 2 {
        0 => 0.9,
        _ => 0.1,
    });
    assert_eq!(names(&apart), vec![starts.to_vec(); 3]);
    let curves = &apart["panels"][2]["series"];
    for (start, height) in [(0, 0.9), (1, 0.1)] {
        let found = curves[start]["points"][0]["y"].as_f64().unwrap();
        assert!((found - height).abs() < 1e-12, "{found}");
        assert_eq!(curves[start]["replicas"].as_array().unwrap().len(), 6);
    }
    assert!(
        apart["caption"]
            .as_str()
            .unwrap()
            .contains("not equilibrated")
    );

    // A single curve has one name in all panels, and so no legend.
    let alike = drawn(Starts::Assembly, |_, _| 0.9);
    assert_eq!(names(&alike), vec![vec!["mean of the replicas"]; 3]);
}

#[test]
fn frames_of_an_assembly_without_contacts_are_reweighted() {
    let place = TemporaryFolder::new();
    let ring = std::fs::read_to_string(place.path("ring.json")).unwrap();
    std::fs::write(place.path("far.json"), ring.replace("12", "30")).unwrap();
    is_ok(&place.run(
        "sweep far.json --salt 50mM,300mM --energy direct --replicas 2 --sweeps 60 --equilibration 10 \
         --trajectory-every 10 -q -o run",
    ));
    let output = place.run("reweight run -o curves");
    is_ok(&output);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("no two bodies touch"), "{text}");
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("curves/reweighting.json")).unwrap())
            .unwrap();
    let point = &json["concentrations"][0]["points"][0];
    assert!(point["contacts_left"].is_null() && point["bound_fraction"]["mean"].is_number());
    let csv = std::fs::read_to_string(place.path("curves/reweighting.csv")).unwrap();
    assert!(!csv.contains("NaN"), "{csv}");
    is_ok(&place.run("report run"));
}
