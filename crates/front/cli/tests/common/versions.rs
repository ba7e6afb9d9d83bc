//! One version in every file that states it. `release/version.py` writes them.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..")
}

fn text(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap()
}

fn table(name: &str) -> toml::Table {
    text(name).parse().unwrap()
}

/// Value behind a word at the beginning of a line, without blanks and quotation marks.
fn stated<'a>(text: &'a str, word: &str) -> Option<&'a str> {
    let value = text.lines().find_map(|line| line.strip_prefix(word))?;
    Some(value.trim_matches([' ', '"']))
}

/// Version and date of the newest release in the changelog.
fn released(changelog: &str) -> Option<(&str, &str)> {
    changelog
        .lines()
        .find_map(|line| line.strip_prefix("## [")?.split_once("] - "))
}

/// Files that disagree with the version of the workspace.
fn disagreements(version: &str, citation: &str, recipe: &str, changelog: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (name, value) in [
        ("CITATION.cff", stated(citation, "version:")),
        ("release/recipe.yaml", stated(recipe, "  version:")),
    ] {
        if value != Some(version) {
            found.push(format!("{name} has {value:?}"));
        }
    }
    let date = stated(citation, "date-released:");
    let newest = released(changelog);
    if newest != date.map(|date| (version, date)) {
        found.push(format!(
            "CHANGELOG.md has {newest:?}, CITATION.cff the date {date:?}"
        ));
    }
    found
}

#[test]
fn files_state_one_version() {
    let manifest = table("Cargo.toml");
    let version = manifest["workspace"]["package"]["version"]
        .as_str()
        .unwrap();
    let (citation, recipe, changelog) = (
        text("CITATION.cff"),
        text("release/recipe.yaml"),
        text("CHANGELOG.md"),
    );
    let found = disagreements(version, &citation, &recipe, &changelog);
    assert!(
        found.is_empty(),
        "Cargo.toml has {version}, but {}; run python3 release/version.py {version}",
        found.join(", ")
    );
}

#[test]
fn a_version_that_differs_is_named() {
    let recipe = "context:\n  version: \"0.2.0\"\n";
    let citation = "version: 0.2.0\ndate-released: 2027-01-02\n";
    let changelog = "## [Unreleased]\n\n## [0.2.0] - 2027-01-02\n\n## [0.1.0] - 2026-12-01\n";
    let number =
        |version, citation, changelog| disagreements(version, citation, recipe, changelog).len();
    assert_eq!(number("0.2.0", citation, changelog), 0);
    assert_eq!(number("0.3.0", citation, changelog), 3);
    assert_eq!(number("0.2.0", "version: 0.2.0", changelog), 1);
    assert_eq!(number("0.2.0", "version: 0.2.0", "## [Unreleased]\n"), 0);
    assert_eq!(number("0.2.0", citation, "## [Unreleased]\n"), 1);
}

/// Without a version beside the path, `cargo publish` refuses a crate.
#[test]
fn our_crates_depend_on_each_other_by_version() {
    let manifest = table("Cargo.toml");
    let workspace = &manifest["workspace"];
    let own = workspace["dependencies"].as_table().unwrap().iter();
    let own: Vec<_> = own
        .filter(|(_, dependency)| dependency.get("path").is_some())
        .collect();
    assert!(own.len() > 10);
    for (name, dependency) in own {
        assert_eq!(
            dependency.get("version"),
            Some(&workspace["package"]["version"]),
            "{name}"
        );
    }
}

/// The page for users names the oldest Rust and Python that the manifests ask for.
#[test]
fn the_page_of_versions_names_what_is_supported() {
    let page = text("docs/versions.md");
    let rust = &table("Cargo.toml")["workspace"]["package"]["rust-version"];
    let python = &table("python/pyproject.toml")["project"]["requires-python"];
    let python = python.as_str().unwrap().trim_start_matches(">=");
    let feature = format!("abi3-py{}", python.replace('.', ""));
    assert!(page.contains(&format!("Rust {}", rust.as_str().unwrap())));
    assert!(page.contains(&format!("CPython {python}")));
    assert!(text("python/Cargo.toml").contains(&feature), "{feature}");
}
