//! Pages of directories of results: what is on them, that they need nothing else, and what is
//! refused.

#![allow(clippy::print_stderr)] // for a person who runs the tests

use crate::common::{CHARGES, TemporaryFolder, contents, is_ok, message};
use protomer_linkage_verbs::frameworks::report::Report;
use protomer_protein_verbs::bodies::body_file;
use protomer_protein_verbs::scattering::ScatteringReport;
use protomer_protein_verbs::stability::reweighting::ReweightingResult;
use protomer_protein_verbs::stability::sweep::result::SweepResult;
use protomer_results::{ResultKind, Row};
use protomer_shape_verbs::dynamics;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const SWEEP: &str = "sweep ring.json --salt 50mM,300mM --cutoff 30A --replicas 2 --sweeps 60 --equilibration 20 --seed 7 \
                     --trajectory-every 20 --quiet -o sweep";

/// What a browser could load from elsewhere, or would have to.
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

#[test]
fn a_sweep_has_its_curve_bodies_conditions_and_simulations() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    let (html, sections) = page(&place, "sweep");
    assert_eq!(
        sections,
        [
            "Status",
            "Results",
            "Bodies",
            "Conditions",
            "Simulations",
            "Provenance"
        ]
    );
    carries(&html, &place.path("sweep/sweep.csv"));
    assert_eq!(
        html.matches("<svg").count(),
        4,
        "curve and traces, each for wide and for narrow screens"
    );
    assert!(
        !html.contains("metadata"),
        "what a figure is drawn from is not carried along"
    );
    assert!(html.contains("<p>Finished; nothing failed and nothing is missing"));
    let status = status(&html);
    assert!(
        status.contains(
            "<p class=\"open\"><strong>Equilibrated: unknown.</strong> All runs start alike"
        ),
        "{status}"
    );
    assert!(!status.contains("class=\"good\""), "{status}");
    let record: serde_json::Value =
        serde_json::from_str(&read(&place.path("sweep/run.json"))).unwrap();
    assert_eq!(record["details"]["assembly"], "../ring.json");
    for key in ["version", "identity", "input_sha256", "exit_reason"] {
        assert!(
            html.contains(record[key].as_str().unwrap()),
            "{key} is not on the page"
        );
    }
    for text in [
        "50 mM",
        "300 mM",
        "<dt>seed</dt><dd>7</dd>",
        "80 × 80 × 80",
        "the end at 50 mM",
        "the start",
    ] {
        assert!(html.contains(text), "{text} is not on the page");
    }
    is_ok(&place.run(
        "simulate ring.json --salt 80mM --cutoff 30A --sweeps 20 --equilibration 5 --quiet -o one",
    ));
    let (html, sections) = page(&place, "one");
    assert_eq!(sections[1..3], ["Results", "Bodies"]);
    assert_eq!(
        html.matches("<svg").count(),
        2,
        "a curve through one point is left out"
    );
    assert!(html.contains("Simulation: one") && html.contains("radius of gyration"));
}

/// What the viewer is called with.
fn viewed(html: &str) -> serde_json::Value {
    let call = html
        .split("viewMeshes(document.querySelector(\".mesh-view\"), ")
        .nth(1)
        .unwrap();
    serde_json::from_str(call.split(");\n").next().unwrap()).unwrap()
}

fn from_base64(text: &str) -> Vec<u8> {
    let digit = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let bits = text
        .trim_end_matches('=')
        .bytes()
        .flat_map(|letter| (0..6).rev().map(move |bit| digit(letter) >> bit & 1));
    let bits: Vec<u8> = bits.collect();
    bits.chunks_exact(8)
        .map(|byte| byte.iter().fold(0, |sum, bit| sum << 1 | bit))
        .collect()
}

#[test]
fn the_viewer_has_the_shapes_and_the_potential_of_every_charge() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    let viewed = viewed(&page(&place, "sweep").0);
    let names = |key: &str| -> Vec<String> {
        viewed[key]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| one["name"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(names("meshes"), ["a", "b"]);
    assert_eq!(
        names("colourings"),
        ["potential at 50 mM", "potential at 300 mM"],
        "bare charges have no hydropathy"
    );
    assert_eq!(
        names("scenes"),
        [
            "body a",
            "body b",
            "the start",
            "the end at 50 mM",
            "the end at 300 mM",
            "film at 50 mM",
            "film at 300 mM"
        ]
    );
    assert_eq!(viewed["scenes"][2]["bodies"].as_array().unwrap().len(), 4);
    let limit: f64 = viewed["colourings"][0]["labels"][2]
        .as_str()
        .unwrap()
        .trim_start_matches('+')
        .parse()
        .unwrap();
    for (mesh, charges) in viewed["meshes"].as_array().unwrap().iter().zip(CHARGES) {
        let places = from_base64(mesh["places"].as_str().unwrap());
        let numbers: Vec<f64> = places
            .chunks_exact(2)
            .map(|two| f64::from(u16::from_le_bytes([two[0], two[1]])))
            .collect();
        let span = mesh["span"].as_f64().unwrap();
        for (salt, values) in [0.05, 0.3]
            .into_iter()
            .zip(mesh["values"].as_array().unwrap())
        {
            let electrolyte = protomer_kernel::Electrolyte::in_water(298.15, salt).unwrap();
            let levels = from_base64(values.as_str().unwrap());
            assert_eq!((levels.len(), numbers.len()), (8, 24), "a cube");
            for (corner, level) in numbers.chunks_exact(3).zip(levels) {
                // The plain sum over the charges, from the cube's corner as the page has it.
                let at: Vec<f64> = (0..3)
                    .map(|k| mesh["low"][k].as_f64().unwrap() + span * corner[k] / 65535.0)
                    .collect();
                assert!(at.iter().all(|x| (x.abs() - 5.0).abs() < 1e-3), "{at:?}");
                let potential: f64 = charges
                    .iter()
                    .map(|[x, y, z, charge]| {
                        let away =
                            ((at[0] - x).powi(2) + (at[1] - y).powi(2) + (at[2] - z).powi(2))
                                .sqrt();
                        let screening = (-away / electrolyte.debye_length_angstrom()).exp();
                        charge * electrolyte.bjerrum_length_angstrom() * screening / away
                    })
                    .sum();
                let expected = 128.0 + 127.0 * (potential / limit).clamp(-1.0, 1.0);
                assert!(
                    (f64::from(level) - expected).abs() < 0.6,
                    "{level}, and the sum gives {expected}"
                );
            }
        }
    }
}

/// Two copies of the bundled peptide at two salts and two pH values.
fn pair() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../data/structures");
    std::fs::copy(data.join("1bd2_short.pdb.gz"), place.path("peptide.pdb.gz")).unwrap();
    is_ok(&place.run(
        "pair peptide.pdb.gz --salt 30mM,300mM --ph 4,9 --contacts calvados3 --relative-error 0.5 \
         --most-directions 256 --seed 3 -q -o pair",
    ));
    place
}

/// Energies (kT) of the residues of a body in the best pose, by chain, number, insertion code and
/// name, split by hand: no cell of this table has a comma.
fn best_energies(table: &str, body: &str) -> BTreeMap<String, f64> {
    let rows = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').collect::<Vec<&str>>());
    rows.filter(|row| row[0] == "1" && row[1] == body)
        .map(|row| (row[2..6].join(" "), row[6].parse().unwrap()))
        .collect()
}

/// One pair for all that its page shows, since it takes seconds to compute.
#[test]
fn a_pair_has_a_map_and_surfaces_as_long_as_its_files_are_there() {
    let place = pair();
    has_a_map_and_surfaces_with_the_energies_of_residues(&place);
    has_no_surfaces_without_its_files(&place);
}

fn has_a_map_and_surfaces_with_the_energies_of_residues(place: &TemporaryFolder) {
    let (html, sections) = page(place, "pair");
    assert_eq!(
        sections,
        [
            "Status",
            "Results",
            "Potential of mean force",
            "Bound poses",
            "Bodies",
            "Provenance"
        ]
    );
    assert!(html.contains("nothing failed and nothing is missing"));
    for name in ["pair_map.svg", "pair_map.png"] {
        assert!(place.path(&format!("pair/{name}")).is_file(), "{name}");
    }
    assert_eq!(
        html.matches("aria-label=\"Second virial coefficient against salt and pH\"")
            .count(),
        1
    );
    assert!(
        html.contains(
            "Second virial coefficient against salt and pH"
                .replace(' ', "\u{a0}")
                .as_str()
        )
    );
    carries(&html, &place.path("pair/pair.csv"));

    let viewed = viewed(&html);
    let conditions = [
        ("pH 4, 30 mM", 4.0, "ph_4.00_salt_0.030000M"),
        ("pH 4, 300 mM", 4.0, "ph_4.00_salt_0.300000M"),
        ("pH 9, 30 mM", 9.0, "ph_9.00_salt_0.030000M"),
        ("pH 9, 300 mM", 9.0, "ph_9.00_salt_0.300000M"),
    ];
    let (colourings, scenes) = (&viewed["colourings"], &viewed["scenes"]);
    let label = colourings[0]["labels"][2].as_str().unwrap();
    let limit: f64 = label.trim_start_matches('+').parse().unwrap();
    assert_eq!(colourings[0]["labels"][0], format!("−{limit}"));
    assert!(colourings[0]["unit"].as_str().unwrap().contains("kT"));
    // The surface does not depend on the pH, so there are two: of the first and the second body.
    assert_eq!(viewed["meshes"].as_array().unwrap().len(), 2);
    let names: Vec<&str> = scenes
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s["name"].as_str().unwrap())
        .collect();
    assert_eq!(names[4..], ["first body, peptide", "second body, peptide"]);
    let mut largest: f64 = 0.0;
    for (number, (name, ph, folder)) in conditions.into_iter().enumerate() {
        assert_eq!(colourings[number]["name"], format!("residues, {name}"));
        assert_eq!(names[number], format!("best pose, {name}"));
        assert_eq!(scenes[number]["colouring"], number);
        // The second body stands where the best pose has it.
        let json: serde_json::Value =
            serde_json::from_str(&read(&place.path(&format!("pair/{folder}/condition.json"))))
                .unwrap();
        let bodies = &scenes[number]["bodies"];
        assert_eq!(
            bodies[0],
            serde_json::json!([0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        );
        for (k, key) in [(0, "position_angstrom"), (3, "orientation_wxyz")] {
            let expected = json["poses"][0][key].as_array().unwrap();
            for (part, expected) in expected.iter().enumerate() {
                let found = bodies[1][1 + k + part].as_f64().unwrap();
                assert!((found - expected.as_f64().unwrap()).abs() < 6e-4, "{key}");
            }
        }
        let table = read(&place.path(&format!("pair/{folder}/residues.csv")));
        carries(&html, &place.path(&format!("pair/{folder}/residues.csv")));
        // The colour of every vertex, from the table and the atoms of a body made here.
        is_ok(&place.run(&format!("ingest -q peptide.pdb.gz --ph {ph} --force -o .")));
        let body = body_file::read(&place.path("peptide.body")).unwrap().0;
        let mut coloured = 0;
        for (mesh, body_number) in viewed["meshes"].as_array().unwrap().iter().zip(["1", "2"]) {
            let energies = best_energies(&table, body_number);
            let sum: f64 = energies.values().sum();
            let energy_kt = json["poses"][0]["energy_kt"].as_f64().unwrap();
            // Up to 0.01 kT of each of nine residues is not in the table.
            assert!((sum - energy_kt).abs() < 0.09, "{sum} {energy_kt}");
            largest = energies
                .values()
                .fold(largest, |most, energy| most.max(energy.abs()));
            let levels = from_base64(mesh["values"][number].as_str().unwrap());
            assert_eq!(levels.len(), body.mesh.vertices.len());
            for (vertex, level) in body.mesh.vertices.iter().zip(levels) {
                let away = |site: &&protomer_body::Site| (site.position - vertex).norm();
                let sites = body.sites.iter().filter(|site| site.residue.is_some());
                let nearest = sites.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
                let residue = &body.residues[nearest.residue.unwrap() as usize];
                let key = format!(
                    "{} {} {} {}",
                    residue.chain, residue.number, residue.insertion_code, residue.name
                );
                let energy_kt = energies.get(&key).copied().unwrap_or(0.0);
                let expected = 128.0 + 127.0 * energy_kt / limit;
                assert!(
                    (f64::from(level) - expected).abs() < 0.6,
                    "{key}: {level} {expected}"
                );
                coloured += usize::from(level < 120);
            }
        }
        assert!(coloured > 20, "{name}: something holds the bodies together");
    }
    assert!(
        limit >= largest && limit <= 2.6 * largest,
        "{limit} {largest}"
    );
}

fn has_no_surfaces_without_its_files(place: &TemporaryFolder) {
    std::fs::rename(place.path("peptide.pdb.gz"), place.path("moved.pdb.gz")).unwrap();
    let (html, sections) = page(place, "pair");
    assert!(html.contains("the files of the bodies were not found"));
    assert!(
        !sections.contains(&"Bodies".to_owned()) && sections.contains(&"Bound poses".to_owned())
    );
    // Another protein under the same name is not shown as if it were this one.
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../data/structures");
    std::fs::copy(data.join("4e43.pdb.gz"), place.path("peptide.pdb.gz")).unwrap();
    assert!(
        page(place, "pair")
            .0
            .contains("is not what these results were made from")
    );
    std::fs::rename(place.path("moved.pdb.gz"), place.path("peptide.pdb.gz")).unwrap();
    let table = place.path("pair/ph_4.00_salt_0.300000M/residues.csv");
    let damaged = read(&table).replace("LYS", "TRP");
    std::fs::write(&table, damaged).unwrap();
    let refused = message(&place.run("report pair --force"));
    assert!(
        refused.contains("residues.csv:") && refused.contains("names the residue TRP"),
        "{refused}"
    );
}

#[test]
fn bodies_that_are_gone_are_taken_from_the_trajectory_and_the_page_says_so() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    std::fs::rename(place.path("a.body"), place.path("moved.body")).unwrap();
    let (html, sections) = page(&place, "sweep");
    assert!(
        html.contains("The body files were not found") && sections.contains(&"Bodies".to_owned())
    );
    let viewed = viewed(&html);
    assert_eq!(viewed["colourings"].as_array().unwrap().len(), 0);
    assert_eq!(
        from_base64(viewed["meshes"][0]["corners"].as_str().unwrap()).len(),
        2 * 36,
        "twelve triangles"
    );
    assert_eq!(
        viewed["scenes"].as_array().unwrap().len(),
        6,
        "two bodies, two ends, two films"
    );
    // Other bodies under the same name are not shown as if they were these.
    std::fs::copy(place.path("b.body"), place.path("a.body")).unwrap();
    assert!(
        page(&place, "sweep")
            .0
            .contains("is not what these results were made from")
    );
    let refused = place.run("report sweep --assembly ring.json --force");
    assert!(
        message(&refused).contains("is not what these results were made from"),
        "{}",
        message(&refused)
    );
    // Without a trajectory there is nothing to show, and the rest is there.
    for salt in ["salt_0.050000M", "salt_0.300000M"] {
        std::fs::remove_file(place.path(&format!("sweep/{salt}/replica_0/trajectory.gsd")))
            .unwrap();
    }
    let (html, sections) = page(&place, "sweep");
    assert!(html.contains("No shapes are known") && !sections.contains(&"Bodies".to_owned()));
    // Back in its place by the flag.
    std::fs::rename(place.path("moved.body"), place.path("a.body")).unwrap();
    std::fs::create_dir(place.path("elsewhere")).unwrap();
    for file in ["a.body", "b.body", "ring.json"] {
        std::fs::rename(place.path(file), place.path("elsewhere").join(file)).unwrap();
    }
    assert!(page(&place, "sweep").0.contains("No shapes are known"));
    is_ok(&place.run("report sweep --assembly elsewhere/ring.json --force"));
    assert!(read(&place.path("sweep/report.html")).contains("potential at 50 mM"));
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

/// Takes keys out of a value, wherever they are.
fn without(value: &mut serde_json::Value, keys: &[&str]) {
    match value {
        serde_json::Value::Object(object) => {
            object.retain(|key, _| !keys.contains(&key.as_str()));
            object.values_mut().for_each(|value| without(value, keys));
        }
        serde_json::Value::Array(values) => {
            values.iter_mut().for_each(|value| without(value, keys));
        }
        _ => {}
    }
}

#[test]
fn a_sweep_of_an_earlier_version_has_a_page() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    let file = place.path("sweep/sweep.json");
    let mut result: serde_json::Value = serde_json::from_str(&read(&file)).unwrap();
    let later = [
        "model",
        "equilibrated",
        "equilibration",
        "half_salt_molar",
        "half_salt_interval_molar",
        "half_bound_salt_molar",
        "half_bound_salt_interval_molar",
        "half_salt_contacts",
        "contacts",
        "bound_fraction",
        "contacts_mean",
        "contacts_sd",
        "bound_fraction_mean",
        "bound_fraction_sd",
    ];
    without(&mut result, &later);
    std::fs::write(&file, result.to_string()).unwrap();
    let (html, sections) = page(&place, "sweep");
    assert!(sections.contains(&"Conditions".to_owned()));
    let status = status(&html);
    assert!(
        status.contains("An earlier version, which did not compare starts, ran this."),
        "{status}"
    );
}

#[test]
fn a_stopped_sweep_says_what_is_not_done() {
    let place = TemporaryFolder::new();
    assert_eq!(
        place.run(&format!("{SWEEP} --time-limit 0")).status.code(),
        Some(3)
    );
    let (html, _) = page(&place, "sweep");
    for text in [
        "It was stopped by the time limit; the same command continues it",
        "There is no result yet",
        "50 mM, replica 1: no record; it was not started",
    ] {
        assert!(html.contains(text), "{text} is not on the page");
    }
    assert!(!html.contains("nothing failed"));
    // A killed run may leave half a line.
    let replica = place.path("sweep/salt_0.050000M/replica_0");
    std::fs::create_dir_all(&replica).unwrap();
    std::fs::write(
        replica.join("log.csv"),
        "sweep,r_g_angstrom,native_contacts,largest_cluster,energy_kT,cluster_moved\n10,8.5,1,4,-3,2\n20,8.",
    )
    .unwrap();
    let (html, _) = page(&place, "sweep");
    assert!(html.contains("0.05,0,10,8.5,1,4,-3,2,,%0A") && html.contains("traces.csv: 1 row<"));
    // What was shown of the unfinished one goes when the work starts anew.
    is_ok(&place.run(&format!("{SWEEP} --force")));
    assert!(!place.path("sweep/report.html").exists());
}

#[test]
fn starts_that_disagree_head_the_page_and_are_told_apart() {
    let place = TemporaryFolder::new();
    // Four bodies in contact, and a fluid in which none touch: a few sweeps change neither.
    is_ok(&place.run(
        "sweep ring.json --salt 50mM,300mM --replicas 4 --starts both --sweeps 12 --equilibration 2 \
         --cluster-moves 0 --log-every 1 --seed 7 --quiet -o both",
    ));
    let (html, _) = page(&place, "both");
    let status = status(&html);
    assert!(
        status.contains("<p class=\"bad\"><strong>Equilibrated: no.</strong> At "),
        "{status}"
    );
    assert!(
        status.contains("in runs from the assembly") && !status.contains("class=\"good\""),
        "{status}"
    );
    let curve = read(&place.path("both/sweep.svg"));
    for start in ["from\u{a0}the\u{a0}assembly", "from\u{a0}a\u{a0}fluid"] {
        assert!(curve.contains(&format!(">{start}<")), "{start}");
    }
    let sections = html.replace('\u{a0}', " ");
    assert!(sections.contains(">50 mM, from a fluid<"));
    // All columns of the logs, whatever they are.
    let log = read(&place.path("both/salt_0.050000M/replica_0/log.csv"));
    let log: Vec<&str> = log.lines().next().unwrap().split(',').collect();
    assert_eq!(columns_of(&html, "traces.csv")[2..], log);
    for column in ["contacts", "bound_fraction"] {
        assert!(log.contains(&column), "{column}");
    }
    // At one salt there is no curve: averages, each start in its column.
    is_ok(&place.run(
        "sweep ring.json --salt 50mM --replicas 2 --starts both --sweeps 12 --equilibration 2 \
         --log-every 1 --seed 7 --quiet -o one_salt",
    ));
    let (html, _) = page(&place, "one_salt");
    for text in [
        "<th>from the assembly</th><th>from a fluid</th>",
        "<td>pairs of bodies in contact</td>",
        "<td>bodies that touch another</td>",
    ] {
        assert!(html.contains(text), "{text}");
    }
}

#[test]
fn a_sweep_with_one_start_has_a_legend_only_where_a_half_salt_is_drawn() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(SWEEP));
    let result: serde_json::Value =
        serde_json::from_str(&read(&place.path("sweep/sweep.json"))).unwrap();
    let curve = read(&place.path("sweep/sweep.svg")).replace('\u{a0}', " ");
    let is_drawn = curve.contains("half, and its interval");
    let has_half = ["half_salt_molar", "half_bound_salt_molar"]
        .into_iter()
        .any(|key| result[key].is_number());
    assert_eq!(is_drawn, has_half);
    assert!(
        !curve.contains("fraction of the bodies") && !curve.contains("fraction of the contacts")
    );
}

#[test]
fn contact_dynamics_has_its_course_and_bodies_of_every_kind() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(
        "md run --shape ellipsoid:2,1,1 --bodies 32 --packing-fraction 0.1 --steps 40 \
         --compress-steps 20 --equilibrate-steps 20 --log-every 10 --trajectory-every 20 -q -o ellipsoids",
    ));
    let (html, sections) = page(&place, "ellipsoids");
    assert_eq!(sections, ["Status", "Results", "Bodies", "Provenance"]);
    assert!(status(&html).contains("<strong>Equilibrated: unknown.</strong>"));
    carries(&html, &place.path("ellipsoids/log.csv"));
    assert!(html.contains("after 40 steps") && html.contains("<dt>Pressure</dt>"));
    assert_eq!(html.matches("<svg").count(), 2, "the course in two shapes");
    let words = words(&html);
    for curve in dynamics::log::LogRow::curves() {
        for name in [curve.panel, curve.name] {
            assert!(words.contains(name), "{name}");
        }
    }

    let mixture = "md run --shape polygon:4 --shape polygon:5 --share 3 --share 1 --bodies 36 --packing-fraction 0.3 \
                   --steps 20 --compress-steps 20 --equilibrate-steps 20 --trajectory-every 20 -q -o";
    is_ok(&place.run(&format!("{mixture} mixture")));
    let (html, _) = page(&place, "mixture");
    assert!(html.contains("body 1") && html.contains("body 2"));
    assert_eq!(
        place
            .run(&format!("{mixture} stopped --time-limit 0"))
            .status
            .code(),
        Some(3)
    );
    assert!(message(&place.run("report stopped")).contains("work that has not begun"));
}

#[test]
fn hard_bodies_have_their_averages_their_course_and_their_bodies() {
    let place = TemporaryFolder::new();
    let cubes = "--shape cube --bodies 27 --equilibration 10 --sweeps 40 -q";
    is_ok(&place.run(&format!(
        "hpmc run --packing-fraction 0.1 --insertions 10 {cubes} -o cubes"
    )));
    let (html, sections) = page(&place, "cubes");
    assert_eq!(sections, ["Status", "Results", "Bodies", "Provenance"]);
    carries(&html, &place.path("cubes/log.csv"));
    let words = words(&html);
    for panel in ["compressibility factor", "insertion probability"] {
        assert!(words.contains(panel), "{panel}");
    }
    assert!(!words.contains("mean height"), "there are no walls");

    is_ok(&place.run(&format!(
        "hpmc sweep --packing-fractions 0.05,0.1 {cubes} -o equation"
    )));
    let (html, sections) = page(&place, "equation");
    assert_eq!(sections, ["Status", "Results", "Bodies", "Provenance"]);
    carries(&html, &place.path("equation/equation.csv"));
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

#[cfg(unix)]
#[test]
fn a_failed_sweep_says_why() {
    let place = TemporaryFolder::new();
    let sweep = SWEEP.replace("--sweeps 60", "--sweeps 4000 --checkpoint-every 0.005");
    assert_eq!(place.run_limited(16, &sweep).status.code(), Some(1));
    let (html, _) = page(&place, "sweep");
    let said: Vec<&str> = html
        .lines()
        .filter(|line| line.starts_with("<li>"))
        .collect();
    assert!(
        said.iter()
            .any(|line| line.contains("It failed: salt 0.") && line.contains("cannot write")),
        "{said:?}"
    );
    let of_replica =
        |line: &&str| line.contains("mM, replica") && line.contains("of 4020 sweeps: cannot write");
    assert!(said.iter().any(of_replica), "{said:?}");
    assert!(html.contains("<td>failed</td>"));
    // A damaged checkpoint is left alone, and the sweep's own record says what is wrong with it.
    let damaged = place.path("sweep/salt_0.050000M/replica_0/checkpoint.bin");
    std::fs::write(&damaged, "damaged").unwrap();
    assert_eq!(place.run(&sweep).status.code(), Some(1));
    assert!(
        page(&place, "sweep")
            .0
            .contains("It failed: salt 0.05 M, replica 0: ")
    );
    std::fs::remove_file(&damaged).unwrap();
    is_ok(&place.run(&sweep));
    assert!(
        page(&place, "sweep")
            .0
            .contains("nothing failed and nothing is missing")
    );

    let settings =
        "rows = 4\ncolumns = 4\nsteps = 300\ntrajectory_every = 1\n[sweep]\nr0 = [0.1, 0.2]\n";
    std::fs::write(place.path("sweep.toml"), settings).unwrap();
    let lattices = "lattice sweep sweep.toml --threads 1 -q -o lattices";
    assert_eq!(place.run_limited(40, lattices).status.code(), Some(1));
    let (html, _) = page(&place, "lattices");
    let said: Vec<&str> = html
        .lines()
        .filter(|line| line.starts_with("<li>"))
        .collect();
    assert!(
        said.iter()
            .any(|line| line.contains("It failed: lattices/r0_0.1_kappa_0")),
        "{said:?}"
    );
    let of_run = |line: &&str| {
        line.contains("r0 = 0.1, κ = 0, seed 1: failed after") && line.contains("cannot write")
    };
    assert!(said.iter().any(of_run), "{said:?}");
    is_ok(&place.run(lattices));
    assert!(
        page(&place, "lattices")
            .0
            .contains("nothing failed and nothing is missing")
    );
}

#[test]
fn lattices_frameworks_and_trainings_have_pages_too() {
    let place = TemporaryFolder::new();
    let lattice = "lattice run --rows 4 --columns 4 --velocities random --steps 60 --log-every 5";
    is_ok(&place.run(&format!("{lattice} --trajectory-every 10 -q -o run")));
    let (html, sections) = page(&place, "run");
    assert_eq!(
        sections,
        ["Status", "Animation", "History", "Conditions", "Provenance"]
    );
    carries(&html, &place.path("run/log.csv"));
    assert!(html.contains("7 frames") && html.contains("playLattice("));
    is_ok(&place.run(&format!("{lattice} --trajectory-every 0 -q -o still")));
    let (html, sections) = page(&place, "still");
    assert!(
        html.contains("The run cannot be played") && !sections.contains(&"Animation".to_owned())
    );
    assert!(
        !html.contains("playLattice("),
        "what is not needed is not carried"
    );

    std::fs::write(
        place.path("sweep.toml"),
        "rows = 3\ncolumns = 3\nsteps = 40\n[sweep]\nr0 = [0.1, 0.2]\nseeds = [1, 2]\n",
    )
    .unwrap();
    is_ok(&place.run("lattice sweep sweep.toml -q -o lattices"));
    let (html, sections) = page(&place, "lattices");
    assert_eq!(
        sections,
        [
            "Status",
            "Results",
            "Animation",
            "Conditions",
            "Runs",
            "Provenance"
        ]
    );
    carries(&html, &place.path("lattices/lattice.csv"));
    carries(&html, &place.path("lattices/runs.csv"));
    std::fs::remove_dir_all(place.path("lattices/r0_0.2_kappa_0/seed_2")).unwrap();
    assert!(
        page(&place, "lattices")
            .0
            .contains("r0 = 0.2, κ = 0, seed 2: no record; it was not started")
    );

    is_ok(&place.run("framework honeycomb --theta 60 --kh 50 --ks 10000 --load y --stress 20GPa,40GPa -q -o pulled"));
    let (html, sections) = page(&place, "pulled");
    assert_eq!(
        sections,
        ["Status", "Results", "Network", "Conditions", "Provenance"]
    );
    for table in ["polar.csv", "stiffness.csv", "curve.csv"] {
        carries(&html, &place.path(&format!("pulled/{table}")));
    }
    assert_eq!(
        html.matches("<svg").count(),
        6,
        "polar plot and curve in two shapes, drawing, deformation"
    );
    assert!(
        html.contains("<div class=\"narrow\">\n<p>honeycomb"),
        "the drawing's texts stand below it"
    );

    let trained = place.run("train --control orientation --short --epochs 3 -q -o training");
    is_ok(&trained);
    let (html, sections) = page(&place, "training");
    assert!(status(&html).contains("<strong>Control passed: "));
    // The terminal and the page say the same of a prediction with certainty.
    assert!(html.contains("<td>majority</td>"));
    let (_, row) = html.split_once("<td>majority</td>").unwrap();
    let (row, _) = row.split_once("</tr>").unwrap();
    assert!(row.ends_with("<td>–</td><td>–</td>"), "{row}");
    assert!(html.contains("does not test the gain over the prior"));
    assert_eq!(
        sections,
        [
            "Status",
            "Scores",
            "Confusion",
            "Control",
            "Conditions",
            "Provenance"
        ]
    );
    carries(&html, &place.path("training/history.csv"));
    std::fs::remove_file(place.path("training/metrics.json")).unwrap();
    assert!(
        page(&place, "training")
            .0
            .contains("The training is not finished")
    );
}

#[test]
fn tables_of_networks_have_a_page() {
    let place = TemporaryFolder::new();
    is_ok(&place.run("framework tables -q -o tables"));
    let (html, sections) = page(&place, "tables");
    assert_eq!(
        sections,
        ["Status", "Results", "How to read the tables", "Provenance"]
    );
    // Every number that is printed, as the terminal shows it, and every one computed, digit for
    // digit.
    let rows: serde_json::Value =
        serde_json::from_str(&read(&place.path("tables/tables.json"))).unwrap();
    let values: Vec<&serde_json::Value> = rows
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row["values"].as_array().unwrap())
        .collect();
    assert_eq!(values.len(), 168);
    for value in values {
        let printed = value["printed"].as_str().unwrap();
        assert!(html.contains(&format!(" | {printed} ")), "{printed}");
        assert!(
            html.contains(&format!(",{},{printed},", value["computed"])),
            "{value}"
        );
    }
    std::fs::write(place.path("tables/tables.json"), "[{\"table\": 2}]").unwrap();
    assert!(message(&place.run("report tables --force")).contains("tables.json"));
}

/// Sixteen times one protein in two classes, and a file that is not there.
fn voxels(place: &TemporaryFolder) {
    let structure =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../data/structures/5pti.cif.gz");
    let mut manifest = "file,label,cluster,name\n".to_owned();
    for number in 0..16 {
        let label = if number % 2 == 0 { "even" } else { "odd" };
        manifest += &format!(
            "{},{label},c{},s{number}\n",
            structure.display(),
            number / 2
        );
    }
    manifest += "missing.pdb,odd,c,<gone>\n";
    std::fs::write(place.path("set.csv"), manifest).unwrap();
}

const VOXELIZE: &str = "voxelize --manifest set.csv -o set.zarr --size 24 --spacing 2 --channels shape,potential --potential debye-hueckel -q";

#[test]
fn a_set_of_voxels_and_a_search_have_pages_too() {
    let place = TemporaryFolder::new();
    voxels(&place);
    assert_eq!(
        place
            .run(&format!("{VOXELIZE} --time-limit 0"))
            .status
            .code(),
        Some(3)
    );
    assert!(message(&place.run("report set.zarr")).contains("not complete yet"));
    is_ok(&place.run(VOXELIZE));
    let before = contents(&place.path("set.zarr"));
    let output = place.run("report set.zarr");
    is_ok(&output);
    assert!(
        String::from_utf8_lossy(&output.stdout)
            .starts_with("set.zarr.report.html: Status, Samples, ")
    );
    assert_eq!(
        contents(&place.path("set.zarr")),
        before,
        "nothing is added to the group"
    );
    let html = read(&place.path("set.zarr.report.html"));
    assert!(html.contains("1 of 17 structures were left out (unreadable: 1)."));
    assert!(html.contains("<td>&lt;gone&gt;</td><td>odd</td><td>unreadable</td>"));
    // label, samples, clusters, left out; the first cluster; the channel that is 1 everywhere.
    assert!(
        html.contains("<td>odd</td><td>8</td><td>8</td><td>1</td>"),
        "labels"
    );
    assert!(
        html.contains("<td>c0</td><td>2</td><td>even, odd</td>"),
        "clusters"
    );
    assert!(
        html.contains("<td>1</td><td>1</td><td>0</td><td>1</td><td>unchanged</td>"),
        "channels"
    );
    assert!(
        html.contains("arcsinh(x / ") && html.contains("2 Å") && html.contains("debye-hueckel")
    );
    // The occupied voxels that the page has are those of the set.
    let group: serde_json::Value =
        serde_json::from_str(&read(&place.path("set.zarr/zarr.json"))).unwrap();
    let attributes = &group["attributes"];
    for key in ["identity", "manifest_sha256", "made_by"] {
        assert!(html.contains(attributes[key].as_str().unwrap()), "{key}");
    }
    let set =
        protomer_learn_verbs::voxels::samples::VoxelSet::open(&place.path("set.zarr")).unwrap();
    let voxels: usize = (0..16).map(|sample| set.reader().voxels(sample)).sum();
    assert!(html.contains(&format!("<dd>{voxels}, {} per sample</dd>", voxels / 16)));
    assert_eq!(
        html.matches("s15,odd,c7,").count(),
        1,
        "the table of samples"
    );

    is_ok(&place.run("tune set.zarr --least-samples 5 --trials 3 --epochs 3 -q -o search"));
    let (html, sections) = page(&place, "search");
    assert_eq!(
        sections,
        [
            "Status",
            "Best settings",
            "Trials",
            "Conditions",
            "Provenance"
        ]
    );
    carries(&html, &place.path("search/trials.csv"));
    assert_eq!(html.matches("<svg").count(), 2);
    let best = read(&place.path("search/trials.csv"))
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .next()
        .unwrap()
        .to_owned();
    assert!(html.contains(&format!("<dt>trial</dt><dd>{best}</dd>")) && html.contains("best.toml"));
    assert!(html.contains("nothing failed and nothing is missing"));
    std::fs::remove_file(place.path("search/best.toml")).unwrap();
    assert!(
        page(&place, "search")
            .0
            .contains("The search is not finished")
    );
    std::fs::remove_file(place.path("search/trials.csv")).unwrap();
    assert!(page(&place, "search").0.contains("There is no table yet"));
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
