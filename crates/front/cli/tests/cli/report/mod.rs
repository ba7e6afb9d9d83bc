//! Pages of directories of results: what is on them, that they need nothing else, and what is
//! refused.

#![allow(clippy::print_stderr)] // for a person who runs the tests

mod assemblies;
mod others;

use crate::common::{TemporaryFolder, is_ok, message};
use protomer_linkage_verbs::frameworks::report::Report;
use protomer_protein_verbs::scattering::ScatteringReport;
use protomer_protein_verbs::stability::reweighting::ReweightingResult;
use protomer_protein_verbs::stability::sweep::result::SweepResult;
use protomer_results::ResultKind;
use serde::Serialize;
use std::path::Path;
use std::process::Command;

const SWEEP: &str = "sweep ring.json --salt 50mM,300mM --cutoff 30A --replicas 2 --sweeps 60 --equilibration 20 --seed 7 \
                     --trajectory-every 20 --quiet -o sweep";

/// Addresses that a browser could load, or would have to, from elsewhere.
const OUTSIDE: [&str; 6] = [
    "https://",
    "src=",
    "@import",
    "url(",
    "fetch(",
    "XMLHttpRequest",
];

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Makes the page of a directory and checks what holds for every page; returns the page and its
/// sections.
fn page(place: &TemporaryFolder, directory: &str) -> (String, Vec<String>) {
    let output = place.run(&format!("report {directory} --json --force"));
    is_ok(&output);
    let written: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let html = read(&place.path(&format!("{directory}/report.html")));
    assert_eq!(written["bytes"].as_u64().unwrap(), html.len() as u64);
    let plain = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    assert!(!plain.contains("http://"), "{directory} names an address");
    for outside in OUTSIDE {
        assert!(!plain.contains(outside), "{directory} has {outside}");
    }
    assert!(
        html.starts_with("<!DOCTYPE html>")
            && html.contains("default-src 'none'")
            && html.contains("width=device-width")
    );
    assert_eq!(
        html.matches("<section").count(),
        html.matches("</section>").count()
    );
    is_ok(&place.run(&format!("report {directory} -o again.html --force --quiet")));
    assert_eq!(
        read(&place.path("again.html")),
        html,
        "{directory} gave two different pages"
    );
    let sections = written["sections"]
        .as_array()
        .unwrap()
        .iter()
        .map(|title| title.as_str().unwrap().to_owned());
    (html, sections.collect())
}

/// The first section of a page.
fn status(html: &str) -> &str {
    let (_, rest) = html.split_once("<section id=\"status\">").unwrap();
    rest.split_once("</section>").unwrap().0
}

/// The texts of the first figure of a page; those of a label that is broken into lines follow each other.
fn words(html: &str) -> String {
    let (_, figure) = html.split_once("<svg").unwrap();
    let (figure, _) = figure.split_once("</svg>").unwrap();
    let pieces = figure.replace('\u{a0}', " ");
    let texts = pieces.split('<').filter_map(|piece| piece.split_once('>'));
    let texts = texts.map(|(_, text)| text.trim());
    texts
        .filter(|text| !text.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The columns of a table that a page carries.
fn columns_of(html: &str, table: &str) -> Vec<String> {
    let (_, rest) = html
        .split_once(&format!(
            "download=\"{table}\" href=\"data:text/csv;charset=utf-8,"
        ))
        .unwrap();
    let (head, _) = rest.split_once("%0A").unwrap();
    head.split(',').map(str::to_owned).collect()
}

/// Every row of a table of the directory is in the link that saves it, digit for digit.
fn carries(html: &str, table: &Path) {
    for line in read(table).lines() {
        let coded = line
            .replace('"', "%22")
            .replace(' ', "%20")
            .replace('+', "%2B");
        assert!(
            html.contains(&format!("{coded}%0A")),
            "{line} of {} is not on the page",
            table.display()
        );
    }
}

/// No key of a result is lost and no number changes when a page reads it.
#[test]
fn results_are_read_back_as_they_were_written() {
    fn same<T: Serialize>(file: &Path, value: T) {
        let written: serde_json::Value = serde_json::from_str(&read(file)).unwrap();
        let value = serde_json::to_value(value).unwrap();
        assert_eq!(value, written, "{}", file.display());
    }
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    is_ok(&place.run("reweight sweep -q -o curves"));
    is_ok(&place.run("scattering sweep --q-points 5 -q -o light"));
    is_ok(&place.run(
        "framework honeycomb --theta 60 --kh 50 --ks 10000 --load y --stress 20GPa,40GPa -q -o pulled",
    ));
    let sweep = SweepResult::read(&place.path("sweep")).unwrap();
    same(&place.path("sweep/sweep.json"), sweep.unwrap());
    let curves = ReweightingResult::read(&place.path("curves")).unwrap();
    same(&place.path("curves/reweighting.json"), curves.unwrap());
    let light = ScatteringReport::read(&place.path("light")).unwrap();
    same(&place.path("light/scattering.json"), light.unwrap());
    let pulled = Report::read(&place.path("pulled")).unwrap();
    same(&place.path("pulled/result.json"), pulled);
}

#[test]
fn the_guide_lists_the_verbs_whose_results_have_a_page() {
    let guide = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../docs/guide/report.md"));
    let (_, rows) = guide
        .split_once("| directory of | on the page |\n|---|---|\n")
        .unwrap();
    let mut listed = Vec::new();
    for row in rows.lines().take_while(|row| row.starts_with('|')) {
        let cell = row.split('|').nth(1).unwrap();
        listed.extend(cell.split('`').skip(1).step_by(2));
    }
    let verbs: Vec<&str> = ResultKind::all()
        .flat_map(ResultKind::verbs)
        .copied()
        .collect();
    assert_eq!(listed, verbs);
}

#[test]
fn what_is_no_result_is_refused_and_nothing_is_overwritten_unasked() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    let refused = |arguments: &str| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments}");
        message(&output)
    };
    std::fs::create_dir(place.path("empty")).unwrap();
    assert!(refused("report empty").contains("holds no results that a report can show"));
    assert!(!place.path("empty/report.html").exists());
    assert!(refused("report ring.json").contains("is an assembly: 'protomer sweep'"));
    assert!(refused("report missing").contains("is not a directory"));
    assert!(
        refused("report sweep/salt_0.050000M/replica_0")
            .contains("give the directory of the sweep")
    );
    std::fs::write(place.path("page.html"), "mine").unwrap();
    assert!(refused("report sweep -o page.html").contains("overwrite it with --force"));
    assert_eq!(read(&place.path("page.html")), "mine");
    is_ok(&place.run("report sweep -o page.html --force"));
    // A picture that would run something is not put on the page.
    let svg =
        read(&place.path("sweep/sweep.svg")).replace("</svg>", "<script>alert(1)</script></svg>");
    std::fs::write(place.path("sweep/sweep.svg"), svg).unwrap();
    assert!(refused("report sweep").contains("sweep.svg is not a figure"));
}

#[test]
fn the_scripts_are_small_and_parse() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    is_ok(
        &place.run("lattice run --rows 3 --columns 3 --steps 20 --trajectory-every 10 -q -o run"),
    );
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (script, bytes) in [
        ("front/report/src/mesh_view.js", 13_000),
        ("verbs/linkage/src/lattice/player.js", 10_000),
    ] {
        assert!(
            read(&crates.join(script)).len() < bytes,
            "{script} is longer than {bytes} bytes"
        );
    }
    if Command::new("node").arg("--version").output().is_err() {
        eprintln!("SKIPPED: there is no node here to parse the scripts with");
        return;
    }
    for directory in ["sweep", "run"] {
        let html = page(&place, directory).0;
        let script = html
            .split("<script>")
            .nth(1)
            .unwrap()
            .split("</script>")
            .next()
            .unwrap();
        std::fs::write(place.path("page.js"), script).unwrap();
        let output = Command::new("node")
            .arg("--check")
            .arg(place.path("page.js"))
            .output()
            .unwrap();
        is_ok(&output);
    }
}
