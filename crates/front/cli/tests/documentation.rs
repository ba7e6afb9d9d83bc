//! The documentation shows what the program does: `docs/reference/cli.md` holds the help of every
//! verb, and the commands in the `console` blocks of `docs/guide/*.md` and `docs/tutorial/*.md` give
//! the output printed below them. The blocks of a page run in order in one folder of their own, which
//! holds a link to `data`. In a block marked `console approximate` only the words must agree.
//!
//! Tables of options in the guide and the `run.toml` of `docs/reference/formats.md` follow a default that changes.
//!
//! `python/protomer/_verbs.pyi` holds the types of the verbs as Python functions.
//!
//! `UPDATE_REFERENCE=1 cargo test -p protomer-cli --test documentation` writes all of it anew; read the
//! difference before committing it.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

#[path = "common/cache.rs"]
mod cache;
#[path = "common/defaults.rs"]
mod defaults;

use cache::Cache;
use protomer_protein_verbs::stability::run::RunSettings;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

const PROGRAM: &str = env!("CARGO_BIN_EXE_protomer");
/// Variables that the help shows with their value, or that change what a command does.
const VARIABLES: [&str; 3] = [
    "PROTOMER_THREADS",
    "PROTOMER_FETCH_BASE",
    "ACTION_WALLTIME_IN_MINUTES",
];

/// Held by whoever reads and writes pages of the guide.
static GUIDE: Mutex<()> = Mutex::new(());

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../..")
        .canonicalize()
        .unwrap()
}

/// Writes the file anew if asked to; otherwise it must hold this text.
fn check_or_update(path: &Path, text: &str) -> Result<(), String> {
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(path, text).unwrap();
    }
    let present = std::fs::read_to_string(path).unwrap_or_default();
    let (mut line, mut approximate) = (0, false);
    let mut said = text.lines();
    for expected in present.lines() {
        let found = said.next().unwrap_or("(nothing more)");
        if expected.starts_with("```") {
            approximate = expected == "```console approximate";
        }
        line += 1;
        if !agree(expected, found, approximate) {
            return Err(complaint(path, line, found));
        }
    }
    said.next()
        .map_or(Ok(()), |found| Err(complaint(path, line + 1, found)))
}

fn complaint(path: &Path, line: usize, found: &str) -> String {
    format!(
        "{}:{line}: the program says '{found}'; regenerate with UPDATE_REFERENCE=1 cargo test -p protomer-cli --test \
         documentation",
        path.display()
    )
}

/// Whether two lines say the same, up to the width of the gaps and the last digits of numbers.
fn agree(expected: &str, found: &str, approximate: bool) -> bool {
    let ((words, numbers), (other_words, other_numbers)) =
        (words_and_numbers(expected), words_and_numbers(found));
    let close = |(a, b): (&f64, &f64)| approximate || (a - b).abs() <= 1e-6 + 2e-3 * a.abs();
    words == other_words && numbers.iter().zip(&other_numbers).all(close)
}

/// The line with single spaces and `#` for each number, and the numbers.
fn words_and_numbers(line: &str) -> (String, Vec<f64>) {
    let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
    let (mut words, mut numbers, mut rest) = (String::new(), Vec::new(), line.as_str());
    while let Some(first) = rest.chars().next() {
        let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
        let sign = usize::from(rest.starts_with(['+', '-']));
        let mut length = sign + digits(&rest[sign..]);
        let is_number = length > sign;
        if is_number && rest[length..].starts_with('.') {
            length += 1 + digits(&rest[length + 1..]);
        }
        let exponent = rest[length..]
            .strip_prefix('e')
            .map_or(0, |text| usize::from(text.starts_with(['+', '-'])));
        if is_number
            && rest[length..].starts_with('e')
            && digits(&rest[length + 1 + exponent..]) > 0
        {
            length += 1 + exponent + digits(&rest[length + 1 + exponent..]);
        }
        match rest[..length].parse() {
            Ok(number) if is_number => {
                numbers.push(number);
                words.push('#');
                rest = &rest[length..];
            }
            _ => {
                words.push(first);
                rest = &rest[first.len_utf8()..];
            }
        }
    }
    (words, numbers)
}

#[test]
fn numbers_are_compared_to_a_tolerance_and_words_exactly() {
    assert!(agree(
        "area  3199.411 Å² (1e-8)",
        "area 3199.412 Å² (3e-8)",
        false
    ));
    assert!(!agree("area 3199.411 Å²", "area 3210.0 Å²", false));
    assert!(agree("R_g 18.2 ± 0.3", "R_g -7 ± 1.25e3", true));
    assert!(!agree("R_g 18.2 Å", "R_h 18.2 Å", true));
}

fn help(words: &[String]) -> String {
    let mut command = Command::new(PROGRAM);
    for variable in VARIABLES {
        command.env_remove(variable);
    }
    let output = command
        .args(words)
        .arg("--help")
        .env("COLUMNS", "100")
        .output()
        .unwrap();
    let lines = String::from_utf8(output.stdout).unwrap();
    lines
        .lines()
        .map(|line| line.trim_end().to_owned() + "\n")
        .collect()
}

/// Headings of what a help text lists beside subcommands, which have several headings.
const OTHER_HEADINGS: [&str; 2] = ["Arguments:", "Options:"];

/// The subcommands that a help text lists.
fn subcommands(help: &str) -> Vec<String> {
    let is_top = help.contains("\nStructures:\n");
    let mut is_listed = false;
    let mut names = Vec::new();
    for line in help.lines() {
        if line.ends_with(':') && !line.starts_with(' ') {
            is_listed = line == "Commands:" || (is_top && !OTHER_HEADINGS.contains(&line));
        } else if is_listed && line.starts_with("  ") && !line.starts_with("   ") {
            names.push(line);
        }
    }
    assert!(!is_top || names.len() > 20, "{names:?}");
    names
        .into_iter()
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

/// The help of a command and, after it, that of its subcommands.
fn describe(words: &[String], page: &mut String) {
    let text = help(words);
    let title = ["protomer".to_owned()]
        .iter()
        .chain(words)
        .cloned()
        .collect::<Vec<_>>()
        .join(" ");
    *page += &format!("\n## {title}\n\n```text\n{text}```\n");
    for name in subcommands(&text) {
        describe(&[words, &[name]].concat(), page);
    }
}

#[test]
fn the_reference_holds_the_help_of_every_verb() {
    let mut page =
        "# Command line\n\nThe output of `--help`, verb by verb. Exit codes: 0 done, 1 error, 2 usage, 3 stopped \
                    early on request and resumable, 130 ended at once by a second Ctrl-C or SIGTERM.\n"
            .to_owned();
    describe(&[], &mut page);
    let path = root().join("docs/reference/cli.md");
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        carry_defaults_over(&before, &page);
    }
    check_or_update(&path, &page).unwrap();
}

/// Writes the defaults that have changed since the reference page was written into the guide.
fn carry_defaults_over(before: &str, after: &str) {
    let [old, new] = [before, after].map(defaults::read);
    let _alone = GUIDE.lock().unwrap_or_else(PoisonError::into_inner);
    for path in pages("guide") {
        let page = std::fs::read_to_string(&path).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy();
        let carried = defaults::carried_over(&page, &name, &old, &new);
        if carried != page {
            std::fs::write(&path, carried).unwrap();
        }
    }
}

#[test]
fn the_settings_in_the_page_of_formats_are_the_defaults() {
    let mut settings = toml::Table::try_from(RunSettings::default()).unwrap();
    if let Some(toml::Value::Table(medium)) = settings.remove("medium") {
        settings.extend(medium);
    }
    let path = root().join("docs/reference/formats.md");
    let page = std::fs::read_to_string(&path).unwrap();
    check_or_update(&path, &defaults::with_settings(&page, &settings)).unwrap();
}

#[test]
fn the_types_of_python_functions_are_those_of_the_program() {
    let text = protomer_cli::python_stub();
    check_or_update(&root().join("python/protomer/_verbs.pyi"), &text).unwrap();
}

/// The page with the output of its commands as they give it now.
fn replay(page: &str, cache: &Path) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root().join("data"), folder.path().join("data")).unwrap();
    let (mut replayed, mut in_console) = (String::new(), false);
    for line in page.lines() {
        let fence = line.starts_with("```");
        if fence {
            in_console = line.starts_with("```console");
        }
        if !in_console || fence || line.starts_with("$ ") {
            replayed += &format!("{line}\n");
        }
        if let Some(command) = line.strip_prefix("$ ").filter(|_| in_console) {
            replayed += &run(command, folder.path(), cache);
        }
    }
    replayed
}

fn run(line: &str, folder: &Path, cache: &Path) -> String {
    let programs = Path::new(PROGRAM).parent().unwrap().display().to_string();
    let path = format!("{programs}:{}", std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new("sh");
    for variable in VARIABLES {
        command.env_remove(variable);
    }
    let output = command
        .arg("-c")
        .arg(format!("{{ {line}; }} 2>&1"))
        .current_dir(folder)
        .env("PATH", path)
        .env("PROTOMER_CACHE_DIR", cache)
        .output();
    String::from_utf8_lossy(&output.unwrap().stdout)
        .lines()
        .map(|line| line.trim_end().to_owned() + "\n")
        .collect()
}

/// The pages of a folder of `docs`.
fn pages(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join("docs").join(folder)).unwrap();
    let mut pages: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    pages.sort();
    assert!(!pages.is_empty());
    pages
}

/// Every page of a folder of `docs` shows what its commands print. Its pages share a cache of energy
/// tables, as they would on a reader's machine.
fn check_pages(folder: &str) {
    let pages = pages(folder);
    let cache = Cache::new();
    let check = |path: &PathBuf| {
        let page = std::fs::read_to_string(path).unwrap();
        check_or_update(path, &replay(&page, cache.path()))
    };
    let wrong: Vec<String> = pages.iter().filter_map(|path| check(path).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_guide_shows_what_its_commands_print() {
    let _alone = GUIDE.lock().unwrap_or_else(PoisonError::into_inner);
    check_pages("guide");
}

#[test]
fn the_tutorials_show_what_their_commands_print() {
    check_pages("tutorial");
}
