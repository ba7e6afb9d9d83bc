//! Scores of many complexes: the table, continuation, further complexes and columns, and what fails.

use crate::common::{TemporaryFolder, is_ok, message};
use protomer_io::csv::cells;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

const CHEAP: &str = "--body A --body B --columns quality,charge,contacts,area,affinity -q --json";

/// A folder with a dimer under two names, a monomer, and a file that holds no atoms.
fn designs() -> TemporaryFolder {
    let place = TemporaryFolder::with_data();
    fs::create_dir(place.path("designs")).unwrap();
    let data = |file: &str| place.path("data/structures").join(file);
    for (file, name) in [
        ("4e43.pdb.gz", "first.pdb.gz"),
        ("4e43.pdb.gz", "second.pdb.gz"),
        ("5pti.cif.gz", "monomer.cif.gz"),
    ] {
        fs::copy(data(file), place.path("designs").join(name)).unwrap();
    }
    fs::write(place.path("designs/empty.pdb"), "END\n").unwrap();
    place
}

/// Cells of each complex by heading.
fn table(place: &TemporaryFolder, directory: &str) -> BTreeMap<String, BTreeMap<String, String>> {
    let text = fs::read_to_string(place.path(directory).join("score.csv")).unwrap();
    let mut lines = text
        .lines()
        .map(|line| cells("score.csv", 1, line).unwrap());
    let headings = lines.next().unwrap();
    let rows = lines.map(|row| {
        let named = headings.iter().cloned().zip(row.iter().cloned());
        (row[0].clone(), named.collect())
    });
    rows.collect()
}

#[test]
fn a_folder_becomes_a_table_and_what_fails_is_a_row() {
    let place = designs();
    let found = place.answer(&format!("score designs -o out {CHEAP}"));
    assert_eq!((&found["rows"], &found["failed"]), (&4.into(), &2.into()));
    assert!(found["seconds"].as_f64().unwrap() > 0.0);
    let rows = table(&place, "out");
    assert_eq!(rows["first"]["status"], "ok");
    assert_eq!(rows["first"]["residue_contacts"], "117");
    assert_eq!(rows["first"]["chain_breaks"], "0");
    let charge: f64 = rows["first"]["receptor_charge_e"].parse().unwrap();
    assert!((charge - 2.86).abs() < 0.01, "{charge}");
    assert!(rows["monomer"]["error"].contains("B"));
    assert!(
        rows["empty"]["error"].contains("no atom"),
        "{}",
        rows["empty"]["error"]
    );
    assert_eq!(rows["empty"]["buried_area_angstrom2"], "");
    // The same work again, which is done; on request its failures are the exit code.
    let strict = place.run(&format!("score designs -o out --strict {CHEAP}"));
    assert_eq!(strict.status.code(), Some(1));
    assert!(place.path("out/score.png").exists());
    is_ok(&place.run("report out -q"));
    assert!(
        fs::read_to_string(place.path("out/report.html"))
            .unwrap()
            .contains("class=\"sortable\"")
    );
}

#[test]
fn energies_are_those_of_binding() {
    let place = TemporaryFolder::with_data();
    place.write_sheet();
    fs::write(
        place.path("one.csv"),
        "name,file,receptor_chains,ligand_chains,measured\nprotease,both.pdb,A,B,yes\n",
    )
    .unwrap();
    let columns = "--columns energy,slope --salt 50mM,500mM --spacing 0.9 -q --json";
    place.answer(&format!("score one.csv -o out {columns}"));
    let row = &table(&place, "out")["protease"];
    let command =
        "binding both.pdb --salt 50mM,500mM --body A --body B --spacing 0.9 --no-kd -q --json";
    let binding = place.answer(command);
    let number = |value: &Value| value.as_f64().unwrap();
    for (index, salt) in ["50mM", "500mM"].iter().enumerate() {
        let condition = &binding["conditions"][index];
        let energy: f64 = row[&format!("energy_kt_{salt}")].parse().unwrap();
        assert_eq!(energy, number(&condition["energy_kt"]));
        let charges: f64 = row[&format!("charges_kt_{salt}")].parse().unwrap();
        assert_eq!(charges, number(&condition["terms_kt"]["charges"]));
    }
    let slope: f64 = row["d_ln_k_d_ln_salt"].parse().unwrap();
    assert_eq!(slope, number(&binding["d_ln_k_d_ln_salt"]));
    assert_eq!((&*row["measured"], &*row["overlap"]), ("yes", "no"));
}

#[test]
fn work_goes_on_where_it_stopped_and_takes_further_complexes_and_columns() {
    let place = designs();
    fs::remove_file(place.path("designs/second.pdb.gz")).unwrap();
    let stopped = place.run(&format!("score designs -o out --time-limit 0 {CHEAP}"));
    assert_eq!(stopped.status.code(), Some(3), "{}", message(&stopped));
    let found = place.answer(&format!("score designs -o out {CHEAP}"));
    assert_eq!(
        (&found["rows"], &found["taken_over"]),
        (&3.into(), &0.into())
    );
    // A further complex, and a further column of the earlier ones.
    fs::copy(
        place.path("designs/first.pdb.gz"),
        place.path("designs/second.pdb.gz"),
    )
    .unwrap();
    let found = place.answer(&format!("score designs -o out {CHEAP}"));
    assert_eq!(
        (&found["rows"], &found["taken_over"]),
        (&4.into(), &3.into())
    );
    let rows = table(&place, "out");
    assert_eq!(
        rows["first"]["buried_area_angstrom2"],
        rows["second"]["buried_area_angstrom2"]
    );
    place.answer("score designs -o out --body A --body B --columns area,shape -q --json");
    let rows = table(&place, "out");
    let fit: f64 = rows["second"]["shape_complementarity"].parse().unwrap();
    assert!(fit > 0.6 && fit < 0.85, "{fit}");
    assert!(!rows["second"].contains_key("residue_contacts"));
    // A failure in one group does not keep the others away.
    let failing = "score failing.csv -o failing --columns exchange --salt 50mM -q --json";
    fs::write(
        place.path("failing.csv"),
        "name,file,receptor_chains,ligand_chains\nx,designs/monomer.cif.gz,A,B\n",
    )
    .unwrap();
    assert_eq!(place.answer(failing)["failed"], 1);
    let again = place.answer(&failing.replace("exchange", "exchange,area"));
    assert_eq!(
        (&again["failed"], &again["taken_over"]),
        (&1.into(), &0.into())
    );
    let same = place.answer(&failing.replace("exchange", "exchange,area"));
    assert_eq!(same["taken_over"], 1);
    // A file that has changed is scored again.
    fs::copy(
        place.path("data/structures/5pti.cif.gz"),
        place.path("designs/second.pdb.gz"),
    )
    .unwrap();
    place.answer("score designs -o out --body A --body B --columns area -q --json");
    assert_eq!(table(&place, "out")["second"]["status"], "failed");
    let other = place.run("score designs -o out --body A --body B --salt 10mM -q");
    assert!(message(&other).contains("salt_M"), "{}", message(&other));
}

#[test]
fn every_contact_of_a_crystal_is_a_row() {
    let place = TemporaryFolder::with_data();
    let command =
        "score data/structures/4e43.pdb.gz --crystal -o out --columns contacts,charge -q --json";
    let found = place.answer(command);
    assert_eq!(found["failed"], 0);
    let rows = table(&place, "out");
    let dimers: Vec<_> = rows
        .values()
        .filter(|row| row["in_assembly"] == "yes")
        .collect();
    assert_eq!(dimers.len(), 1);
    assert_eq!(
        (&*dimers[0]["chains"], &*dimers[0]["symmetry"]),
        ("A:B", "x,y,z")
    );
    assert_eq!(dimers[0]["residue_contacts"], "117");
    assert!(rows.len() > 4);
}

#[test]
fn parts_of_the_work_make_the_same_table() {
    let place = designs();
    place.answer(&format!("score designs -o whole {CHEAP}"));
    for part in ["2/2", "1/2"] {
        place.answer(&format!("score designs -o parts --shard {part} {CHEAP}"));
    }
    let found = place.answer(&format!("score designs -o parts {CHEAP}"));
    assert_eq!(found["taken_over"], 4);
    let text = |directory: &str| fs::read(place.path(directory).join("score.csv")).unwrap();
    assert_eq!(text("whole"), text("parts"));
}
