//! The shape of the workspace: which crate may depend on which, one door per heavy dependency,
//! permissive licences; what its pages may not say any more (`decisions`), and the version that its files state
//! (`versions`). With `UPDATE_REFERENCE=1` it writes the modules of ARCHITECTURE.md.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

#[path = "common/decisions.rs"]
mod decisions;
#[path = "common/versions.rs"]
mod versions;

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What this machine compiles for: packages for others need not be on it.
fn host() -> String {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .find_map(|line| line.strip_prefix("host: "))
        .unwrap()
        .to_owned()
}

fn metadata() -> Value {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../Cargo.toml");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output = Command::new(cargo)
        .args([
            "metadata",
            "--format-version",
            "1",
            "--locked",
            "--offline",
            "--manifest-path",
            manifest,
        ])
        .args(["--filter-platform", &host()])
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The crates of this workspace with what they depend on outside their tests.
fn dependencies(metadata: &Value) -> BTreeMap<String, BTreeSet<String>> {
    let members: BTreeSet<&str> = metadata["workspace_members"]
        .as_array()
        .unwrap()
        .iter()
        .map(|id| id.as_str().unwrap())
        .collect();
    let packages = metadata["packages"].as_array().unwrap().iter();
    packages
        .filter(|package| members.contains(package["id"].as_str().unwrap()))
        .map(|package| {
            let needed = package["dependencies"].as_array().unwrap().iter();
            let normal = needed.filter(|dependency| dependency["kind"].is_null());
            let names = normal
                .map(|dependency| dependency["name"].as_str().unwrap().to_owned())
                .collect();
            (package["name"].as_str().unwrap().to_owned(), names)
        })
        .collect()
}

/// Folder of each layer of crates, from the lowest.
const LAYERS: [&str; 4] = ["base", "engines", "verbs", "front"];

/// Place of a crate among the layers; the Python package stands above all.
fn layer(row: &Row) -> usize {
    let folder = row.folder.parent().unwrap();
    let place = LAYERS.iter().position(|layer| folder.ends_with(layer));
    place.unwrap_or(LAYERS.len())
}

#[test]
fn no_arrow_points_to_a_higher_layer() {
    let rows = rows();
    let layers: BTreeMap<String, usize> = rows.iter().map(|row| (row.name(), layer(row))).collect();
    let mut occupied: Vec<usize> = layers.values().copied().collect();
    occupied.sort_unstable();
    occupied.dedup();
    assert_eq!(occupied, [0, 1, 2, 3, 4], "a layer is empty");
    for row in &rows {
        for need in row.needs() {
            assert!(
                layers[&need] <= layers[&row.name()],
                "{} must not depend on {need}, which is in a higher layer",
                row.name()
            );
        }
    }
}

#[test]
fn heavy_dependencies_have_one_door() {
    let doors = [
        ("candle-core", "protomer-learn"),
        ("zarrs", "protomer-io"),
        ("clap", "protomer-cli"),
        ("indicatif", "protomer-cli"),
        ("tiny-skia", "protomer-plot"),
        ("ureq", "protomer-protein-verbs"),
        ("pyo3", "protomer-python"),
    ];
    let dependencies = dependencies(&metadata());
    for (heavy, door) in doors {
        for (name, needs) in &dependencies {
            assert!(
                name == door || !needs.contains(heavy),
                "{heavy} belongs in {door}, not in {name}"
            );
        }
    }
}

#[test]
fn licences_are_permissive() {
    let deny = include_str!("../../../../deny.toml")
        .parse::<toml::Table>()
        .unwrap();
    let allowed: BTreeSet<&str> = deny["licenses"]["allow"]
        .as_array()
        .unwrap()
        .iter()
        .map(|licence| licence.as_str().unwrap())
        .collect();
    // An SPDX expression holds if every AND term holds; an OR (or the older `/`) term holds if one
    // of its parts does.
    let permits = |expression: &str| {
        expression.split(" AND ").all(|term| {
            let term = term.trim_matches(|c| c == '(' || c == ')');
            term.replace('/', " OR ")
                .split(" OR ")
                .any(|licence| allowed.contains(licence.trim()))
        })
    };
    assert!(
        !permits("GPL-3.0-only")
            && !permits("MIT AND GPL-3.0-only")
            && permits("GPL-3.0-only OR MIT")
    );
    for package in metadata()["packages"].as_array().unwrap() {
        let licence = package["license"].as_str().unwrap_or("none stated");
        assert!(
            permits(licence),
            "{} is under '{licence}', which deny.toml does not list",
            package["name"]
        );
    }
}

/// A row of the architecture's table of crates.
struct Row {
    folder: PathBuf,
    /// The names before, and within, each pair of parentheses.
    modules: BTreeMap<String, BTreeSet<String>>,
    /// Text of these names.
    cell: String,
    needs: String,
}

impl Row {
    /// Name of the package, less the name of the project.
    fn name(&self) -> String {
        let last = self.folder.file_name().unwrap().to_str().unwrap();
        match self.folder.parent().unwrap().ends_with("verbs") {
            true => format!("{last}-verbs"),
            false => last.to_owned(),
        }
    }

    /// Names that the row must have outside of parentheses.
    fn listed(&self) -> BTreeSet<String> {
        match self.folder.ends_with("python") {
            true => self.modules.keys().cloned().collect(),
            false => modules_in(&self.folder.join("src/lib.rs")),
        }
    }

    /// Names that the row must have in the parentheses after a module, if there are any.
    fn inside(&self, module: &str) -> BTreeSet<String> {
        match module {
            "rust" => files_in(&self.folder.join(module), ".rs"),
            "protomer" => files_in(&self.folder.join(module), ".py"),
            _ => modules_in(&self.folder.join("src").join(module).join("mod.rs")),
        }
    }

    /// Names of the crates that this one depends on, as [`Self::name`] has them.
    fn needs(&self) -> BTreeSet<String> {
        match self.needs.as_str() {
            "-" => BTreeSet::new(),
            some => some.split(", ").map(str::to_owned).collect(),
        }
    }
}

/// Names between backticks, each with those in the parentheses after it.
fn modules_of(cell: &str) -> BTreeMap<String, BTreeSet<String>> {
    let (mut modules, mut last, mut is_inner) = (
        BTreeMap::<String, BTreeSet<String>>::new(),
        String::new(),
        false,
    );
    for (place, part) in cell.split('`').enumerate() {
        if place % 2 == 0 {
            let bracket = part.rfind(['(', ')']);
            is_inner = bracket.map_or(is_inner, |start| part[start..].starts_with('('));
        } else if is_inner {
            modules.get_mut(&last).unwrap().insert(part.to_owned());
        } else {
            last = part.to_owned();
            modules.insert(last.clone(), BTreeSet::new());
        }
    }
    modules
}

/// The cell with missing names at the ends of their lists, and without those that are gone.
fn corrected(
    cell: &str,
    listed: &BTreeSet<String>,
    inner: impl Fn(&str) -> BTreeSet<String>,
) -> String {
    let (mut missing, mut missing_inner) = (listed.clone(), BTreeSet::new());
    let (mut text, mut last, mut is_inner) = (String::new(), String::new(), false);
    let add = |text: &mut String, names: &mut BTreeSet<String>| {
        let names = std::mem::take(names);
        text.extend(names.iter().map(|name| format!(" `{name}`")));
    };
    for (place, part) in cell.split('`').enumerate() {
        if place % 2 == 0 {
            let was_inner = is_inner;
            let bracket = part.rfind(['(', ')']);
            is_inner = bracket.map_or(is_inner, |start| part[start..].starts_with('('));
            if is_inner && !was_inner && listed.contains(&last) {
                missing_inner = inner(&last);
            } else if was_inner && !is_inner {
                add(&mut text, &mut missing_inner);
            }
            // Of a name that is gone nothing stays.
            if last.is_empty() || listed.contains(&last) {
                text += part;
            }
            continue;
        }
        let is_there = match is_inner {
            true => missing_inner.remove(part),
            false => {
                part.clone_into(&mut last);
                missing.remove(part)
            }
        };
        match is_there {
            true => text += &format!("`{part}`"),
            false => text.truncate(text.trim_end().len()),
        }
    }
    add(&mut text, &mut missing);
    text.replace("( `", "(`").trim().to_owned()
}

/// Writes the modules that there are into the table of ARCHITECTURE.md.
fn update_architecture() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../ARCHITECTURE.md");
    let mut text = std::fs::read_to_string(&path).unwrap();
    for row in rows() {
        let cell = corrected(&row.cell, &row.listed(), |module| row.inside(module));
        text = text.replace(&format!("| {} |", row.cell), &format!("| {cell} |"));
    }
    std::fs::write(path, text).unwrap();
}

fn rows() -> Vec<Row> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let text = std::fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let table = text
        .lines()
        .skip_while(|line| !line.starts_with("| crate |"))
        .skip(2);
    table
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let [_, folder, _, modules, needs, _] =
                line.split('|').map(str::trim).collect::<Vec<_>>()[..]
            else {
                panic!("a row of ARCHITECTURE.md has other columns: {line}")
            };
            let (folder, needs) = (root.join(folder.trim_matches('`')), needs.to_owned());
            Row {
                folder,
                modules: modules_of(modules),
                cell: modules.to_owned(),
                needs,
            }
        })
        .collect()
}

/// Names of the `mod` lines of a library, less its errors.
fn modules_in(library: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(library).unwrap();
    let names = text.lines().filter_map(|line| {
        line.trim_start_matches("pub ")
            .strip_prefix("mod ")?
            .strip_suffix(';')
    });
    names
        .filter(|name| *name != "error")
        .map(str::to_owned)
        .collect()
}

/// Names of the files with this ending in a folder, less those that Rust or Python ask for.
fn files_in(folder: &Path, ending: &str) -> BTreeSet<String> {
    let names = folder
        .read_dir()
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let stems = names.filter_map(|name| name.strip_suffix(ending).map(str::to_owned));
    stems
        .filter(|stem| stem != "lib" && !stem.starts_with("__"))
        .collect()
}

#[test]
fn the_architecture_lists_the_modules_that_there_are() {
    assert_eq!(
        modules_of("`a` (of `b` `c`), `d` (E)"),
        BTreeMap::from([
            (
                "a".to_owned(),
                BTreeSet::from(["b".to_owned(), "c".to_owned()])
            ),
            ("d".to_owned(), BTreeSet::new()),
        ])
    );
    let (listed, inside) = (["a", "c"], ["d", "e"]);
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    assert_eq!(
        corrected("`b` (`x`), `a` (`f` `d`)", &names(&listed), |_| names(
            &inside
        )),
        "`a` (`d` `e`) `c`"
    );
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        update_architecture();
    }
    let rows = rows();
    let crates = dependencies(&metadata()).len();
    assert_eq!(rows.len(), crates, "a crate has no row, or a row no crate");
    let advice = "write them with UPDATE_REFERENCE=1 cargo test -p protomer-cli --test workspace";
    for row in rows {
        let name = row.folder.display();
        let listed: BTreeSet<String> = row.modules.keys().cloned().collect();
        assert_eq!(listed, row.listed(), "{name}; {advice}");
        for (module, inner) in row.modules.iter().filter(|(_, inner)| !inner.is_empty()) {
            assert_eq!(*inner, row.inside(module), "{name}: {module}; {advice}");
        }
    }
}

#[test]
fn the_architecture_lists_the_arrows_that_there_are() {
    let dependencies = dependencies(&metadata());
    let short = |package: &str| package.trim_start_matches("protomer-").to_owned();
    let crates: BTreeSet<String> = dependencies.keys().map(|name| short(name)).collect();
    for row in rows() {
        let name = row.name();
        let (_, needed) = dependencies
            .iter()
            .find(|(package, _)| short(package) == name)
            .unwrap();
        let ours: BTreeSet<String> = needed
            .iter()
            .map(|need| short(need))
            .filter(|need| crates.contains(need))
            .collect();
        assert_eq!(ours, row.needs(), "{name}");
    }
}

/// Name and version of every package of a build, with its features.
fn features(selection: &[&str]) -> BTreeMap<String, String> {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../Cargo.toml");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output = Command::new(cargo)
        .args(["tree", "--locked", "--offline", "--manifest-path", manifest])
        .args(["--prefix", "none", "--no-dedupe", "-f", "{p}|{f}"])
        .args(selection)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let packages = text.lines().filter_map(|line| line.split_once('|'));
    packages
        .map(|(package, features)| (package.to_owned(), features.to_owned()))
        .collect()
}

/// `test.sh` builds the Python package from what the tests have built. With other features, cargo
/// would compile most of it again; `python/Cargo.toml` names those that only tests turn on.
#[test]
fn tests_and_the_python_package_share_one_build() {
    let tests = features(&["--workspace"]);
    let package = features(&["-p", "protomer-python", "-e", "normal,build"]);
    assert!(package.len() > 100, "cargo tree says nothing");
    for (name, features) in package {
        assert_eq!(
            Some(&features),
            tests.get(&name),
            "{name}: add the features of the tests to python/Cargo.toml"
        );
    }
}

/// Rust files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found
}

/// A function that is compiled for more instructions than were asked for is unsound.
#[test]
fn processor_features_are_named_in_one_place() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let mut named = BTreeSet::new();
    for source in ["crates", "python/rust"]
        .iter()
        .flat_map(|folder| sources(&root.join(folder)))
    {
        let text = std::fs::read_to_string(&source).unwrap();
        // In two parts, so that this file does not name them.
        let names_features = text.contains(concat!("target_", "feature("))
            || text.contains(concat!("feature_", "detected!"));
        if names_features {
            named.insert(source.strip_prefix(&root).unwrap().to_owned());
        }
    }
    assert_eq!(
        named,
        BTreeSet::from(["crates/base/kernel/src/vectorised.rs".into()])
    );
}

#[test]
fn no_crate_is_more_than_a_fifth_of_the_house() {
    let lines_of = |row: &Row| -> usize {
        let files = sources(&row.folder);
        files
            .iter()
            .map(|file| std::fs::read_to_string(file).unwrap().lines().count())
            .sum()
    };
    let sizes: Vec<(PathBuf, usize)> = rows()
        .iter()
        .map(|row| (row.folder.clone(), lines_of(row)))
        .collect();
    let all: usize = sizes.iter().map(|(_, lines)| lines).sum();
    for (folder, lines) in sizes {
        assert!(
            5 * lines <= all,
            "{}: {lines} of {all} lines",
            folder.display()
        );
    }
}

/// A pipe or a device that somebody names as an input must not be waited for; `io::input` sees to it, wherever a file
/// of a user is read.
#[test]
fn files_are_opened_for_reading_in_one_place() {
    // The door itself; a folder that is synchronised; pages that the program has just written.
    const OWN: [&str; 3] = [
        "base/io/src/input.rs",
        "base/io/src/atomic.rs",
        "front/cli/src/verbs/generate.rs",
    ];
    const READS: [&str; 3] = ["fs::read(", "fs::read_to_string(", "File::open("];
    // Types of our own that open a file by the door.
    const TYPES: [&str; 2] = ["GsdFile::open(", "WorkFile::open("];
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../crates");
    let mut found = Vec::new();
    let rows = rows();
    let libraries = rows.iter().filter(|row| layer(row) < LAYERS.len());
    for folder in libraries.map(|row| row.folder.join("src")) {
        for path in sources(&folder) {
            let name = path.strip_prefix(&crates).unwrap().display().to_string();
            let is_of_tests = ["tests.rs", "test_support.rs"]
                .iter()
                .any(|end| name.ends_with(end));
            if OWN.contains(&name.as_str()) || is_of_tests || name.contains("/tests/") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for line in code
                .lines()
                .filter(|line| !line.trim_start().starts_with("//"))
            {
                let plain = TYPES
                    .iter()
                    .fold(line.to_owned(), |line, own| line.replace(own, ""));
                if READS.iter().any(|read| plain.contains(read)) {
                    found.push(format!("{name}: {}", line.trim()));
                }
            }
        }
    }
    assert!(
        found.is_empty(),
        "open these by protomer_io::input:\n{}",
        found.join("\n")
    );
}

/// Scripts that run the program and build it first, build the crate with the binary.
#[test]
fn scripts_build_the_crate_with_the_binary() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let mut scripts = vec![root.join("demo.sh"), root.join("test.sh")];
    for folder in ["tests/validation", "docs", "docs/cluster"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            scripts.push(entry.unwrap().path());
        }
    }
    let mut builds = 0;
    for script in scripts {
        let is_script = script.extension().is_some_and(|e| e == "sh" || e == "py");
        let text = if is_script {
            std::fs::read_to_string(&script).unwrap()
        } else {
            String::new()
        };
        if !text.contains("target/release/protomer") {
            continue;
        }
        for line in text.lines().filter(|line| line.contains("cargo build")) {
            let builds_all = !line.contains(" -p ");
            assert!(
                builds_all || line.contains(" -p protomer-cli"),
                "{}: {line}",
                script.display()
            );
            builds += 1;
        }
    }
    assert!(builds > 2);
}

/// Files of the libraries, without their tests, benchmarks and examples.
fn library_sources() -> Vec<PathBuf> {
    let folders = rows()
        .into_iter()
        .flat_map(|row| ["src", "rust"].map(|name| row.folder.join(name)));
    folders
        .filter(|folder| folder.is_dir())
        .flat_map(|folder| sources(&folder))
        .collect()
}

/// First words of doc comments that do not say what they are about. Rustdoc and Python show each comment alone.
const HEADLESS: &[&str] = &[
    "Also", "As", "Both", "How", "If", "It", "Its", "None", "Not", "Nothing", "Of", "So", "Such",
    "That", "Their", "These", "They", "This", "Those", "What", "When", "Where", "Which",
];

#[test]
fn doc_comments_begin_with_a_noun_or_a_verb() {
    let mut headless = Vec::new();
    for path in library_sources() {
        let text = std::fs::read_to_string(&path).unwrap();
        let mut goes_on = false;
        for (number, line) in text.lines().enumerate() {
            let comment = line.trim_start().strip_prefix("///");
            let first = comment.and_then(|words| words.split_whitespace().next());
            let first = first.map(|word| word.trim_matches(['.', ',', ':', ';']));
            if !goes_on && first.is_some_and(|word| HEADLESS.contains(&word)) {
                headless.push(format!(
                    "{}:{}: {}",
                    path.display(),
                    number + 1,
                    line.trim()
                ));
            }
            goes_on = comment.is_some();
        }
    }
    assert!(
        headless.is_empty(),
        "begin these comments with what they describe:\n{}",
        headless.join("\n")
    );
}

/// Prepositions, adverbs and participles that say nothing of what a variable, a parameter or a field holds.
const NOT_NOUNS: &[&str] = &[
    "across", "along", "at", "by", "found", "here", "kept", "known", "left", "moved", "of", "own",
    "rest", "seen", "there", "turned", "what",
];
/// Prepositions and adverbs that say nothing of what a function does or returns.
const NO_FUNCTIONS: &[&str] = &[
    "at", "beside", "by", "here", "known", "of", "on", "there", "to",
];
/// Most such names in 1000 lines of code; keys of files and `left` next to `right` are among them.
const MOST_PER_THOUSAND_LINES: f64 = 3.0;

/// Number of such names that a line of code binds: after `let` and `for`, between bars, and before a colon.
fn bindings_without_noun(line: &str) -> usize {
    let is_separator = |character: char| !character.is_ascii_alphanumeric() && character != '_';
    let (mut number, mut end) = (0, 0);
    for piece in line.split_inclusive(is_separator) {
        let word = piece.trim_end_matches(is_separator);
        let before = &line[..end];
        end += piece.len();
        if !NOT_NOUNS.contains(&word) {
            continue;
        }
        let after = &line[before.len() + word.len()..];
        let is_in_closure = before.matches('|').count() % 2 == 1 && after.contains('|');
        let is_declared = ["let ", "let mut ", "for "]
            .iter()
            .any(|keyword| before.ends_with(keyword));
        let is_before_colon =
            after.starts_with(": ") && (before.is_empty() || before.ends_with(['(', ' ']));
        number += usize::from(is_in_closure || is_declared || is_before_colon);
    }
    number
}

#[test]
fn bindings_are_named_by_what_they_hold() {
    assert_eq!(bindings_without_noun("let at = rows.map(|of| of.left);"), 2);
    assert_eq!(
        bindings_without_noun("for (index, row) in rows_of(left) {"),
        0
    );
    let (mut lines, mut number) = (0, 0);
    for path in library_sources() {
        let text = std::fs::read_to_string(&path).unwrap();
        let code = text.lines().map(str::trim);
        for line in code.filter(|line| !line.is_empty() && !line.starts_with("//")) {
            // Text in quotation marks is for users.
            let unquoted: String = line.split('"').step_by(2).collect();
            lines += 1;
            number += bindings_without_noun(&unquoted);
        }
    }
    let per_thousand = 1000.0 * number as f64 / f64::from(lines);
    assert!(
        per_thousand < MOST_PER_THOUSAND_LINES,
        "{per_thousand:.2} names of 1000 lines are prepositions, adverbs or participles; name what is held"
    );
}

/// Name of the function that a line of code begins to declare.
fn declared_function(line: &str) -> Option<&str> {
    let (_, after) = line.split_once("fn ")?;
    let is_in_name = |character: char| character.is_ascii_alphanumeric() || character == '_';
    after.split(|character| !is_in_name(character)).next()
}

#[test]
fn functions_are_named_by_what_they_do_or_return() {
    assert_eq!(declared_function("pub fn of(body: &Body)"), Some("of"));
    let mut found = Vec::new();
    for path in library_sources() {
        let text = std::fs::read_to_string(&path).unwrap();
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            let name = declared_function(line).filter(|_| !line.starts_with("//"));
            if name.is_some_and(|name| NO_FUNCTIONS.contains(&name)) {
                found.push(format!("{}:{}: {line}", path.display(), number + 1));
            }
        }
    }
    assert!(
        found.is_empty(),
        "name these functions by a noun or a verb:\n{}",
        found.join("\n")
    );
}
