//! Pages of sweeps, simulations and pairs.

use super::{SWEEP, carries, columns_of, page, read, status};
use crate::common::{CHARGES, TemporaryFolder, is_ok, message};
use protomer_protein_verbs::bodies::body_file;
use std::collections::BTreeMap;
use std::path::Path;

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
                let vertex: Vec<f64> = (0..3)
                    .map(|k| mesh["low"][k].as_f64().unwrap() + span * corner[k] / 65535.0)
                    .collect();
                assert!(
                    vertex.iter().all(|x| (x.abs() - 5.0).abs() < 1e-3),
                    "{vertex:?}"
                );
                let potential: f64 = charges
                    .iter()
                    .map(|[x, y, z, charge]| {
                        let away = ((vertex[0] - x).powi(2)
                            + (vertex[1] - y).powi(2)
                            + (vertex[2] - z).powi(2))
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
         --most-directions 64 --seed 3 -q -o pair",
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
