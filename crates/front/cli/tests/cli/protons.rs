//! Protons that bodies take up: on binding, and in simulations in which charges respond.

use crate::common::{TemporaryFolder, is_ok, message};

const STRUCTURE: &str = "data/structures/5pti.cif.gz";

/// Two chains of one file: what they take up is the difference of the net charges that `titrate` finds.
#[test]
fn protons_taken_up_on_binding_are_those_of_titrations() {
    let place = TemporaryFolder::with_data();
    place.write_sheet();
    let flags = "--ph 3,4.5 --salt 50mM,500mM --spacing 0.9 --no-kd --proton-uptake -q --json";
    let answer = place.answer(&format!("binding a.pdb b.pdb {flags}"));
    let mut largest: f64 = 0.0;
    for condition in answer["conditions"].as_array().unwrap() {
        let [salt, ph] = ["salt_molar", "ph"].map(|key| condition[key].as_f64().unwrap());
        let net_charge_e = |file: &str| {
            let command = format!("titrate -q {file} --ph {ph} --salt {salt}M --json");
            place.answer(&command)["net_charge_e"].as_f64().unwrap()
        };
        let expected = net_charge_e("both.pdb") - net_charge_e("a.pdb") - net_charge_e("b.pdb");
        let found = condition["protons_taken_up"].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        largest = largest.max(found.abs());
    }
    assert!(largest > 0.02, "{largest}");
    let without = place.answer("binding a.pdb b.pdb --salt 0.1M --spacing 0.9 --no-kd -q --json");
    assert!(without["conditions"][0].get("protons_taken_up").is_none());
    is_ok(&place.run("ingest -q a.pdb -o bodies"));
    let refused = place.run("binding bodies/a.body b.pdb --salt 0.1M --no-kd --proton-uptake");
    assert!(
        message(&refused).contains("give the structure file"),
        "{}",
        message(&refused)
    );
}

/// Three bodies whose groups are kept, in a box.
fn inhibitors() -> TemporaryFolder {
    let place = TemporaryFolder::with_data();
    is_ok(&place.run(&format!(
        "ingest -q {STRUCTURE} --ph 4.5 --protonation structure --titratable --charges formal -o bodies"
    )));
    is_ok(
        &place
            .run("assemble fluid bodies/5pti.body --counts 3 --box 120 --seed 1 -o fluid.json -q"),
    );
    place
}

const RUN: &str = "simulate fluid.json --salt 100mM --proton-moves 40 --equilibration 5 --log-every 1 \
                   --trajectory-every 5 -q";

#[test]
fn charges_respond_and_a_continued_run_equals_the_uninterrupted_one() {
    let place = inhibitors();
    is_ok(&place.run(&format!("{RUN} --sweeps 20 -o whole")));
    is_ok(&place.run(&format!("{RUN} --sweeps 7 -o parts")));
    is_ok(&place.run(&format!("{RUN} --sweeps 20 -o parts")));
    let replica = "salt_0.100000M/replica_0";
    for file in ["log.csv", "charges.csv", "trajectory.gsd"] {
        let [whole, parts] = ["whole", "parts"]
            .map(|run| std::fs::read(place.path(&format!("{run}/{replica}/{file}"))).unwrap());
        assert!(whole == parts, "{file} differs");
    }
    let charges =
        std::fs::read_to_string(place.path(&format!("whole/{replica}/charges.csv"))).unwrap();
    let rows: Vec<Vec<f64>> = charges
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 20);
    assert!(
        charges.starts_with("sweep,mean_net_charge_e,lowest_net_charge_e,highest_net_charge_e")
    );
    // Every state has a whole charge, and the bodies have different ones.
    for row in &rows {
        assert!((row[2] - row[2].round()).abs() < 1e-6, "{row:?}");
        assert!(row[2] <= row[1] && row[1] <= row[3]);
    }
    assert!(rows.iter().any(|row| row[3] - row[2] > 0.5), "{rows:?}");
    let mean = rows.iter().map(|row| row[1]).sum::<f64>() / rows.len() as f64;
    let titrated = place.answer(&format!(
        "titrate -q {STRUCTURE} --ph 4.5 --salt 100mM --json"
    ));
    let expected = titrated["net_charge_e"].as_f64().unwrap();
    // Bodies far apart: the deviation of one body is below 1 e, of sixty below 0.2 e.
    assert!((mean - expected).abs() < 0.6, "{mean} {expected}");
    // Analyses with fixed charges refuse the run.
    let refused = place.run("residues whole");
    assert!(
        message(&refused).contains("--proton-moves"),
        "{}",
        message(&refused)
    );
}

#[test]
fn what_holds_for_fixed_charges_only_is_refused() {
    let place = inhibitors();
    for (flags, remedy) in [
        ("--energy calibrated", "choose direct"),
        ("--interaction response", "--interaction bare"),
        ("--interaction effective", "--interaction bare"),
        ("--salt 200mM", "--protonation-salt"),
        ("--temperature 320", "--temperature 298.15"),
    ] {
        let command = format!(
            "{} --sweeps 5 -o refused {flags}",
            RUN.replace("--salt 100mM", "")
        );
        let salt = if flags.contains("--salt") {
            ""
        } else {
            "--salt 100mM"
        };
        let refused = place.run(&format!("{command} {salt}"));
        assert!(!refused.status.success(), "{flags}");
        assert!(message(&refused).contains(remedy), "{}", message(&refused));
    }
    let several = "sweep fluid.json --salt 100mM,200mM --proton-moves 4 --sweeps 10 -o refused";
    assert!(message(&place.run(several)).contains("one salt concentration"));
    for (flags, remedy) in [
        ("--titratable", "--protonation structure"),
        (
            "--titratable --protonation structure --charges none",
            "--charges none",
        ),
        (
            "--titratable --protonation structure --anion-binding 2",
            "leave out --anion-binding",
        ),
    ] {
        let refused = place.run(&format!("ingest {STRUCTURE} {flags} -o refused"));
        assert!(message(&refused).contains(remedy), "{}", message(&refused));
    }
    is_ok(&place.run(&format!("ingest -q {STRUCTURE} -o plain")));
    is_ok(&place.run("assemble fluid plain/5pti.body --counts 2 --box 120 -o plain.json -q"));
    let refused = place.run("simulate plain.json --salt 100mM --proton-moves 4 -o refused");
    assert!(
        message(&refused).contains("no body has any"),
        "{}",
        message(&refused)
    );
}
