//! Every flag that takes numbers, with numbers that make no sense: no panic, no hang, no NaN in an answer.

use crate::common::{TemporaryFolder, is_ok, message};
use protomer_cli::{NumberFlag, number_flags};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Numbers that overflow, vanish or are none.
const REAL: [&str; 6] = ["1e308", "-1e308", "1e-308", "nan", "inf", "0"];
const WHOLE: [&str; 3] = ["18446744073709551615", "-1", "0"];
/// A command that takes longer hangs; the cheap commands below take less than a second alone.
const LONGEST: Duration = Duration::from_secs(120);

/// Verbs with arguments that make them cheap; OUT is a new name each time. Verbs that are not here read what only long
/// commands make, and have tests of their own.
const CHEAP: [&str; 40] = [
    "ingest tiny.pdb -o OUT",
    "surface tiny.pqr",
    "potential tiny.pqr --salt 100mM --spacing 1 --margin 5 --no-error-estimate",
    "shape cube",
    "shape contact pairs.json",
    "shape virial tetrahedron --triples 20 --rays 10",
    "shape free-volume cube --packing-fraction 0.1 --depletant-radius 0.1",
    "md run --shape cube --bodies 8 --packing-fraction 0.1 --steps 10 --compress-steps 10 --equilibrate-steps 10 -o OUT",
    "hpmc run --shape cube --bodies 8 --packing-fraction 0.1 --equilibration 5 --sweeps 10 -o OUT",
    "hpmc sweep --shape cube --bodies 8 --packing-fractions 0.1 --equilibration 5 --sweeps 10 --seeds 1 -o OUT",
    "hpmc free-volume --shape cube --crystal simple-cubic --packing-fraction 0.2 --depletant-radius 0.1 --lines 10",
    "free-energy --shape rod:1 --crystal row --bodies 8 --packing-fraction 0.5 --equilibration 5 --sweeps 10 -o OUT",
    "phase-diagram --size-ratio 0.5 --reservoir 0.4",
    "assemble structure complex.pdb --body A --body B --relax --shapes shared -o OUT",
    "assemble ring a.body b.body --members 4 -o OUT.json",
    "assemble fluid a.body b.body --counts 2,2 --box 100 -o OUT.json",
    "candidates a.body b.body --ring 4 --stack 2 -o OUT",
    "inspect ring.json --salt 200mM --energy direct",
    "inspect glycines.json --salt 200mM --interaction response",
    "binding complex.pdb --body A --body B --salt 200mM --spacing 0.9 --margin 5 --exchanges --no-kd",
    "pair a.body b.body --salt 200mM --relative-error 0.5 --most-directions 64",
    "simulate ring.json --salt 200mM --sweeps 10 --equilibration 2 --log-every 5 --energy direct -o OUT",
    "simulate glycines.json --salt 200mM --sweeps 10 --equilibration 2 --log-every 5 --interaction response -o OUT",
    "sweep ring.json --salt 200mM --replicas 1 --sweeps 10 --equilibration 2 --log-every 5 --energy direct -o OUT",
    "residues glycines -o OUT",
    "reweight sweep",
    "scattering sweep --q-points 5",
    "export glycines -o OUT.pdb --salt 200mM",
    "framework honeycomb --theta 60 --kh 50 --ks 10000",
    "framework rotating-squares --angle 20 --ks 10 --kh 1",
    "framework rod-lattice --r0 1.2 --angle 10 --square-ks 10 --ks 1 --kh 1",
    "lattice run --rows 2 --columns 2 --time 0.1 -o OUT",
    "lattice bench --ns 2 --steps 5",
    "lattice sweep --rows 2 --columns 2 --time 0.1 --r0-list 0.2 --kappa-list 0 --seeds 1 -o OUT",
    "lattice replay state.json --longest 1",
    "lattice animate motion -o OUT.html",
    "voxelize --manifest set.csv -o OUT.zarr --size 32 --channels shape",
    "train set.zarr --epochs 1 --widths 8 --batch 4 --least-samples 1 -o OUT",
    "tune set.zarr --trials 1 --epochs 1 --least-samples 1 -o OUT",
    "bench ring.json --salt 200mM --moves 20 --energy direct",
];

/// Two glycines beside each other.
const GLYCINES: &str = r#"{"box_angstrom": [80, 80, 80],
 "bodies": [{"name": "tiny", "file": "bodies/tiny.body"}],
 "placements": [
  {"body": "tiny", "position_angstrom": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0]},
  {"body": "tiny", "position_angstrom": [0, 0, 8], "orientation_wxyz": [1, 0, 0, 0]}]}"#;

/// One body in two classes under many names.
fn set() -> String {
    let line = |number: u32| {
        format!(
            "tiny.pdb,{},c{number},s{number}\n",
            ["a", "b"][number as usize % 2]
        )
    };
    "file,label,cluster,name\n".to_owned() + &(0..16).map(line).collect::<String>()
}

fn folder() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    let atom = |number: u32, name: &str, chain: &str, [x, y, z]: [f64; 3], rest: &str| {
        format!("ATOM  {number:>5}  {name:<3} GLY {chain}   1    {x:8.3}{y:8.3}{z:8.3}{rest}\n")
    };
    let glycine = |chain: &str, z: f64, rest: &str| {
        [
            ("N", 0.0, 0.0),
            ("CA", 1.46, 0.0),
            ("C", 2.0, 1.42),
            ("O", 1.3, 2.44),
        ]
        .iter()
        .zip(1..)
        .map(|((name, x, y), number)| atom(number, name, chain, [*x, *y, z], rest))
        .collect::<String>()
    };
    let occupied = "  1.00  0.00";
    for (name, text) in [
        ("tiny.pdb", glycine("A", 0.0, occupied)),
        (
            "complex.pdb",
            glycine("A", 0.0, occupied) + &glycine("B", 3.8, occupied),
        ),
        ("tiny.pqr", glycine("A", 0.0, "  0.5000 1.8500")),
        ("glycines.json", GLYCINES.into()),
        (
            "pairs.json",
            r#"[{"a": "cube", "b": "cube", "position": [0, 0, 1.15]}]"#.into(),
        ),
        (
            "state.json",
            r#"{"ns": 1, "r0": 0.05, "s0": [0, 0, 0.785], "v0": [0.1, 0, 0.2], "times": [0.1]}"#
                .into(),
        ),
        ("set.csv", set()),
    ] {
        std::fs::write(place.path(name), text).unwrap();
    }
    for command in [
        "sweep ring.json --salt 200mM,300mM --replicas 1 --sweeps 20 --equilibration 2 --log-every 5 \
         --trajectory-every 5 --energy direct -o sweep -q",
        "ingest tiny.pdb -o bodies -q",
        "sweep glycines.json --salt 200mM,300mM --replicas 1 --sweeps 20 --equilibration 2 --log-every 5 \
         --trajectory-every 5 --energy direct -o glycines -q",
        "lattice run --rows 2 --columns 2 --time 0.1 -o motion -q",
        "voxelize --manifest set.csv -o set.zarr --size 32 --channels shape -q",
    ] {
        is_ok(&place.run(command));
    }
    place
}

/// The cheap command of a verb with this flag set to a value.
fn command(cheap: &str, flag: &NumberFlag, value: &str, number: usize) -> String {
    let name = format!("--{}", flag.flag);
    let mut words: Vec<String> = cheap
        .split_whitespace()
        .map(|word| word.replace("OUT", &format!("out{number}")))
        .collect();
    // One value per body.
    let value = match flag.flag.as_str() {
        "tilt" | "spin" | "counts" => format!("{value},{value}"),
        _ => value.to_owned(),
    };
    match words.iter().position(|word| *word == name) {
        Some(place) => words[place + 1] = value,
        None => words.extend([name, value]),
    }
    words.join(" ") + " --threads 1 --no-progress"
}

/// What is wrong with what a command did.
fn complaint(place: &TemporaryFolder, words: &str) -> Option<String> {
    let mut child = place
        .command(words)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > LONGEST {
            child.kill().unwrap();
            child.wait().unwrap();
            return Some(format!("{words}: does not end"));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    let (code, said) = (output.status.code(), message(&output));
    // A time limit of nothing stops a run at once.
    let may_stop = words.contains("--time-limit");
    if said.contains("panicked") || !(matches!(code, Some(0..=2)) || code == Some(3) && may_stop) {
        return Some(format!("{words}: {:?}: {said}", output.status));
    }
    let answer = String::from_utf8_lossy(&output.stdout).to_lowercase();
    let has = |bad: &str| {
        answer
            .split(|letter: char| !letter.is_alphanumeric())
            .any(|word| word == bad)
    };
    (code == Some(0) && (has("nan") || has("inf"))).then(|| format!("{words}: {answer}"))
}

/// Whether a command begins with the words of a verb.
fn is_of(cheap: &str, verb: &[String]) -> bool {
    let words: Vec<&str> = cheap.split_whitespace().take(verb.len()).collect();
    words == verb
}

/// The command of a verb with each value of each of its flags.
fn commands(cheap: &str, values: impl Fn(&NumberFlag) -> Vec<&'static str>) -> Vec<String> {
    let flags = number_flags()
        .into_iter()
        .filter(|flag| is_of(cheap, &flag.verb));
    let flags: Vec<NumberFlag> = flags.collect();
    // `shape` is a verb, and so is `shape contact`.
    let longest = flags.iter().map(|flag| flag.verb.len()).max().unwrap_or(0);
    let mut found = Vec::new();
    for flag in flags.iter().filter(|flag| flag.verb.len() == longest) {
        for value in values(flag) {
            found.push(command(cheap, flag, value, found.len()));
        }
    }
    found
}

fn check(all: &[String]) {
    let place = folder();
    let wrong: Vec<String> = all
        .iter()
        .filter_map(|words| complaint(&place, words))
        .collect();
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        all.len(),
        wrong.join("\n")
    );
}

/// What once panicked, hung or printed nonsense: one case of each kind.
#[test]
fn numbers_that_overflow_are_refused() {
    check(
        &[
            "assemble ring a.body b.body --members 4 --tilt 1e300,0 -o out.json",
            "assemble ring a.body b.body --members 1000000000000 -o out.json",
            "assemble structure tiny.pdb -o out --box 1e308",
            "scattering sweep --q-max 1e308",
            "scattering sweep --light-q 1e12",
            "pair a.body b.body --salt 100mM --relative-error 0.5 --most-directions 64 --bjerrum 1e-308",
            "pair a.body b.body --salt 100mM --relative-error 0.5 --most-directions 64 --cutoff 1e308",
            "pair a.body b.body --salt 1e-308M --relative-error 0.5 --most-directions 64",
            "md run --shape cube --bodies 8 --packing-fraction 0.1 --steps 18446744073709551615 -o out",
            "hpmc free-volume --shape cube --crystal simple-cubic --packing-fraction 0.2 --depletant-radius 0.1 \
             --lines 18446744073709551615",
            "lattice bench --ns 2 --steps 18446744073709551615",
            "simulate ring.json --salt 200mM --sweeps 18446744073709551615 --energy direct -o out",
            "shape contact pairs.json --attraction 1e308",
            "train --control shapes --short -o out --widths 18446744073709551615",
            "train --control shapes --short -o out --permutations 18446744073709551615",
        ]
        .map(str::to_owned),
    );
}

#[test]
fn charges_that_overflow_are_refused_with_their_line() {
    let place = folder();
    for (file, text, command) in [
        (
            "c.xyzq",
            "0 0 0 1\n1 0 0 1e308\n",
            "body --mesh cube.off --charges c.xyzq -o c.body",
        ),
        (
            "c.pqr",
            "ATOM 1 N ALA 1 0 0 0 -1e308 1.5\n",
            "potential c.pqr --salt 100mM",
        ),
        ("d.pqr", "ATOM 1 N ALA 1 0 0 1e300 1 1.5\n", "surface d.pqr"),
        ("e.xyzr", "0 0 0 1e308\n", "surface e.xyzr"),
    ] {
        std::fs::write(place.path(file), text).unwrap();
        let output = place.run(command);
        let said = message(&output);
        assert_eq!(output.status.code(), Some(1), "{command}: {said}");
        assert!(
            said.contains(&format!("{file}:")) && said.contains("give at most"),
            "{said}"
        );
    }
    let config = "salt_M = [0.2]\nequilibration_sweeps = 18446744073709551\n";
    std::fs::write(place.path("run.toml"), config).unwrap();
    let said = message(&place.run("sweep ring.json --config run.toml -o out"));
    assert!(
        said.contains("equilibration_sweeps is 18446744073709551; give"),
        "{said}"
    );
}

/// Removes what a command wrote, a file with some ending or a folder.
fn remove(place: &TemporaryFolder, name: &str) {
    for entry in place.path("").read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.file_stem().is_some_and(|stem| stem == name) {
            match path.is_dir() {
                true => std::fs::remove_dir_all(path).unwrap(),
                false => std::fs::remove_file(path).unwrap(),
            }
        }
    }
}

#[test]
#[ignore = "2000 commands, a quarter of an hour"]
fn no_number_of_any_flag_panics_hangs_or_becomes_nonsense() {
    let all: Vec<String> = CHEAP
        .iter()
        .flat_map(|cheap| {
            commands(cheap, |flag| match flag.is_whole {
                true => WHOLE.to_vec(),
                false => REAL.to_vec(),
            })
        })
        .collect();
    assert!(all.len() > 1000, "{}", all.len());
    // What is refused without a strange number says nothing about it.
    let place = folder();
    for cheap in CHEAP {
        is_ok(&place.run(&cheap.replace("OUT", "usual")));
        remove(&place, "usual");
    }
    check(&all);
}

/// Words in the place of a number are refused in words of the program, not of the standard library.
#[test]
fn a_word_for_a_number_says_what_to_write() {
    let flags = number_flags();
    assert!(flags.len() > 100);
    for flag in flags {
        let name = format!("--{}", flag.flag);
        let mut words: Vec<&str> = flag.verb.iter().map(String::as_str).collect();
        words.extend([name.as_str(), "many"]);
        let called = protomer_cli::call(&words, protomer_cli::Host::default());
        let error = called.err().unwrap();
        let text = error.to_string();
        let is_plain = !text.contains("literal") && !text.contains("digit found");
        assert!(text.contains("many") && is_plain, "{words:?}: {text}");
    }
}
