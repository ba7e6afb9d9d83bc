//! A folder with two small charged bodies and a square of four of them, and the program to run in
//! it.

#![allow(dead_code, unused_imports)] // each test program uses its part

use protomer_common::input::InputFile;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

mod cache;
#[path = "../../../../verbs/linkage/tests/common/mod.rs"]
mod watcher;
use cache::Cache;
pub use watcher::Watcher;

const CUBE: &str = "OFF\n8 12 0\n-5 -5 -5\n5 -5 -5\n5 5 -5\n-5 5 -5\n-5 -5 5\n5 -5 5\n5 5 5\n-5 5 5\n\
                    3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n\
                    3 3 0 4\n3 3 4 7\n";

const RING: &str = r#"{"box_angstrom": [80, 80, 80],
 "bodies": [{"name": "a", "file": "a.body"}, {"name": "b", "file": "b.body"}],
 "placements": [
  {"body": "a", "position_angstrom": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0]},
  {"body": "b", "position_angstrom": [12, 0, 0], "orientation_wxyz": [1, 0, 0, 0]},
  {"body": "a", "position_angstrom": [12, 12, 0], "orientation_wxyz": [1, 0, 0, 0]},
  {"body": "b", "position_angstrom": [0, 12, 0], "orientation_wxyz": [1, 0, 0, 0]}]}"#;

/// Charges of the two bodies: x, y, z (Å), charge (e).
pub const CHARGES: [&[[f64; 4]]; 2] = [
    &[[0.0, 0.0, 0.0, 4.0], [3.0, 0.0, 0.0, 1.0]],
    &[[0.0, 0.0, 0.0, -4.0], [0.0, 3.0, 0.0, -0.5]],
];

/// A folder that is removed at the end. Programs that run in it find the energy tables of earlier ones.
pub struct TemporaryFolder {
    folder: tempfile::TempDir,
    cache: Cache,
}

impl TemporaryFolder {
    /// With `a.body`, `b.body` and `ring.json` in it.
    pub fn new() -> Self {
        let place = Self {
            folder: tempfile::tempdir().unwrap(),
            cache: Cache::new(),
        };
        std::fs::write(place.path("cube.off"), CUBE).unwrap();
        for (name, charges) in ["a", "b"].into_iter().zip(CHARGES) {
            let lines: Vec<String> = charges
                .iter()
                .map(|[x, y, z, q]| format!("{x} {y} {z} {q}\n"))
                .collect();
            std::fs::write(place.path(&format!("{name}.xyzq")), lines.concat()).unwrap();
            is_ok(&place.run(&format!(
                "body --mesh cube.off --charges {name}.xyzq -o {name}.body"
            )));
        }
        std::fs::write(place.path("ring.json"), RING).unwrap();
        place
    }

    /// The same with the bundled data as `data`.
    pub fn with_data() -> Self {
        let place = Self::new();
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../data");
        std::os::unix::fs::symlink(data, place.path("data")).unwrap();
        place
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The program with these arguments, words separated by spaces.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = program(arguments.split_whitespace());
        command
            .env("PROTOMER_CACHE_DIR", self.cache.path())
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command
    }

    /// Runs the program to its end.
    pub fn run(&self, arguments: &str) -> Output {
        self.command(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .output()
            .unwrap()
    }

    /// JSON that a command prints, which must not fail.
    pub fn answer(&self, arguments: &str) -> serde_json::Value {
        let output = self.run(arguments);
        is_ok(&output);
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// Writes `a.pdb`, `b.pdb` and `both.pdb`: the ends of both chains of the bundled protease, which lie in one sheet.
    pub fn write_sheet(&self) {
        let file = InputFile::read(&self.path("data/structures/4e43.pdb.gz")).unwrap();
        let lines = String::from_utf8(file.bytes).unwrap();
        let is_near = |line: &&str| {
            let number = line
                .get(22..26)
                .and_then(|text| text.trim().parse::<i32>().ok());
            line.starts_with("ATOM") && number.is_some_and(|number| !(9..=90).contains(&number))
        };
        let part = |chain: &str| -> String {
            let atoms = lines.lines().filter(is_near);
            let atoms = atoms.filter(|line| line.get(21..22) == Some(chain));
            atoms.map(|line| format!("{line}\n")).collect()
        };
        std::fs::write(self.path("a.pdb"), part("A")).unwrap();
        std::fs::write(self.path("b.pdb"), part("B")).unwrap();
        std::fs::write(self.path("both.pdb"), part("A") + &part("B")).unwrap();
    }

    /// Runs it with files limited to this many blocks, so that writing beyond fails as on a full
    /// disk.
    #[cfg(unix)]
    pub fn run_limited(&self, blocks: u32, arguments: &str) -> Output {
        let script = format!("ulimit -f {blocks}; exec \"$0\" {arguments}");
        let mut shell = Command::new("sh");
        cleaned(&mut shell);
        shell
            .args(["-c", &script, env!("CARGO_BIN_EXE_protomer")])
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }
}

/// The program with these arguments.
pub fn program(arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_protomer"));
    cleaned(&mut command);
    command.args(arguments);
    command
}

/// Nothing of the tester's own environment may change what is tested.
pub fn cleaned(command: &mut Command) {
    for name in [
        "PROTOMER_THREADS",
        "PROTOMER_FETCH_BASE",
        "ACTION_WALLTIME_IN_MINUTES",
        "COLUMNS",
        "LINES",
    ] {
        command.env_remove(name);
    }
    // Nor may the tests use the tester's cache.
    command.env("NO_COLOR", "1").env("PROTOMER_CACHE_DIR", "");
}

/// What the program said on stderr.
pub fn message(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Panics with what the program said unless it succeeded.
pub fn is_ok(output: &Output) {
    assert!(
        output.status.success(),
        "{:?}: {}",
        output.status,
        message(output)
    );
}

/// Every file below a folder: its path relative to the folder, and its bytes. None if there is no
/// such folder.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop().filter(|folder| folder.exists()) {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path
                    .strip_prefix(folder)
                    .unwrap()
                    .to_string_lossy()
                    .into_owned();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}
