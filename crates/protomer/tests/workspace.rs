//! The shape of the workspace: which crate may depend on which, one door per heavy dependency, permissive licences.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// What this machine compiles for: packages for others need not be on it.
fn host() -> String {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().find_map(|line| line.strip_prefix("host: ")).unwrap().to_owned()
}

fn metadata() -> Value {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--locked", "--offline", "--manifest-path", manifest])
        .args(["--filter-platform", &host()])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The crates of this workspace with what they depend on outside their tests.
fn dependencies(metadata: &Value) -> BTreeMap<String, BTreeSet<String>> {
    let members: BTreeSet<&str> =
        metadata["workspace_members"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    let packages = metadata["packages"].as_array().unwrap().iter();
    packages
        .filter(|package| members.contains(package["id"].as_str().unwrap()))
        .map(|package| {
            let needed = package["dependencies"].as_array().unwrap().iter();
            let normal = needed.filter(|dependency| dependency["kind"].is_null());
            let names = normal.map(|dependency| dependency["name"].as_str().unwrap().to_owned()).collect();
            (package["name"].as_str().unwrap().to_owned(), names)
        })
        .collect()
}

#[test]
fn arrows_point_the_way_the_architecture_says() {
    let allowed: BTreeMap<&str, &[&str]> = BTreeMap::from([
        ("protomer-kernel", &[][..]),
        ("protomer-io", &["protomer-kernel"]),
        ("protomer-body", &["protomer-io", "protomer-kernel"]),
        ("protomer-mc", &["protomer-body", "protomer-kernel"]),
        ("protomer-crystal", &["protomer-kernel"]),
        ("protomer-field", &["protomer-body", "protomer-kernel"]),
        ("protomer-learn", &["protomer-kernel"]),
        (
            "protomer",
            &[
                "protomer-body",
                "protomer-crystal",
                "protomer-field",
                "protomer-io",
                "protomer-kernel",
                "protomer-learn",
                "protomer-mc",
            ],
        ),
        // The crates below only for their error types.
        (
            "protomer-python",
            &[
                "protomer",
                "protomer-body",
                "protomer-crystal",
                "protomer-field",
                "protomer-io",
                "protomer-kernel",
                "protomer-learn",
                "protomer-mc",
            ],
        ),
    ]);
    for (name, needs) in dependencies(&metadata()) {
        let allowed = allowed.get(name.as_str()).unwrap_or_else(|| panic!("{name} has no place in the architecture"));
        for need in needs.iter().filter(|need| need.starts_with("protomer")) {
            assert!(allowed.contains(&need.as_str()), "{name} must not depend on {need}");
        }
    }
}

#[test]
fn heavy_dependencies_have_one_door() {
    let doors = [
        ("candle-core", "protomer-learn"),
        ("zarrs", "protomer-io"),
        ("clap", "protomer"),
        ("indicatif", "protomer"),
        ("plotters", "protomer"),
        ("ureq", "protomer"),
        ("pyo3", "protomer-python"),
    ];
    let dependencies = dependencies(&metadata());
    for (heavy, door) in doors {
        for (name, needs) in &dependencies {
            assert!(name == door || !needs.contains(heavy), "{heavy} belongs in {door}, not in {name}");
        }
    }
}

#[test]
fn licences_are_permissive() {
    let deny = include_str!("../../../deny.toml").parse::<toml::Table>().unwrap();
    let allowed: BTreeSet<&str> =
        deny["licenses"]["allow"].as_array().unwrap().iter().map(|licence| licence.as_str().unwrap()).collect();
    // An SPDX expression holds if every AND term holds; an OR (or the older `/`) term holds if one of its parts does.
    let permits = |expression: &str| {
        expression.split(" AND ").all(|term| {
            let term = term.trim_matches(|c| c == '(' || c == ')');
            term.replace('/', " OR ").split(" OR ").any(|licence| allowed.contains(licence.trim()))
        })
    };
    assert!(!permits("GPL-3.0-only") && !permits("MIT AND GPL-3.0-only") && permits("GPL-3.0-only OR MIT"));
    for package in metadata()["packages"].as_array().unwrap() {
        let licence = package["license"].as_str().unwrap_or("none stated");
        assert!(permits(licence), "{} is under '{licence}', which deny.toml does not list", package["name"]);
    }
}
