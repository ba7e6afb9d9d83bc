//! Titration of a structure: the answer for scripts, the files, and what is refused.

use crate::common::{TemporaryFolder, is_ok, message};

const STRUCTURE: &str = "data/structures/5pti.cif.gz";
/// A peptide, for what samples poses of pairs.
const PEPTIDE: &str = "data/structures/1bd2_short.pdb.gz";

#[test]
fn a_titration_says_what_shifts_each_pka_and_writes_its_tables() {
    let place = TemporaryFolder::with_data();
    let answer = place.answer(&format!(
        "titrate -q {STRUCTURE} --ph 2..12/21 --salt 100mM --json -o titration"
    ));
    let groups = answer["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 20);
    let mut net_charge_e = 0.0;
    for group in groups {
        net_charge_e += group["charge_e"].as_f64().unwrap();
        let [pka, model_pka, desolvation, background, neighbours] = [
            "pka",
            "model_pka",
            "shift_desolvation",
            "shift_background",
            "shift_neighbours",
        ]
        .map(|key| group[key].as_f64().unwrap());
        let sum = model_pka + desolvation + background + neighbours;
        assert!((pka - sum).abs() < 1e-9, "{group}");
    }
    assert!((net_charge_e - answer["net_charge_e"].as_f64().unwrap()).abs() < 1e-9);
    assert_eq!(answer["curve"].as_array().unwrap().len(), 21);
    // Tyrosine 23, in the protein's core: 11.7 is measured.
    let buried = groups
        .iter()
        .find(|group| group["residue"] == "TYR" && group["residue_number"] == 23)
        .unwrap();
    assert!(buried["pka"].as_f64().unwrap() > 11.0, "{buried}");
    for name in [
        "titration.csv",
        "curve.csv",
        "titration.json",
        "titration.svg",
        "run.json",
    ] {
        assert!(place.path("titration").join(name).is_file(), "{name}");
    }
    is_ok(&place.run("report titration"));
    let page = std::fs::read_to_string(place.path("titration/report.html")).unwrap();
    for words in ["A TYR 23", "isoelectric point", "desolvation"] {
        assert!(page.contains(words), "{words}");
    }
    // The second run is refused before it computes anything.
    let again = place.run(&format!("titrate {STRUCTURE} --salt 0.1M -o titration"));
    assert!(message(&again).contains("already exists"));
}

#[test]
fn conditions_outside_the_fit_are_named() {
    let place = TemporaryFolder::with_data();
    let output = place.run(&format!(
        "titrate {STRUCTURE} --salt 0.1M --temperature 350 --inner-permittivity 4 --json"
    ));
    is_ok(&output);
    let told = message(&output);
    assert!(
        told.contains("permittivity of 20") && told.contains("25 °C"),
        "{told}"
    );
}

/// A body that is made with the protonation of its structure has the charges of the titration, residue by
/// residue, also with mutations and bound anions, and says so.
#[test]
fn a_body_carries_the_protonation_of_its_structure() {
    let place = TemporaryFolder::with_data();
    let conditions = "--ph 4 --anion-binding 2";
    let answer = place.answer(&format!(
        "titrate -q {STRUCTURE} {conditions} --salt 50mM --json"
    ));
    is_ok(&place.run(&format!(
        "ingest -q {STRUCTURE} {conditions} --protonation structure --protonation-salt 50mM -o bodies"
    )));
    let (body, _) =
        protomer_protein_verbs::bodies::body_file::read(&place.path("bodies/5pti.body")).unwrap();
    let net_charge_e = answer["net_charge_e"].as_f64().unwrap();
    assert!(
        (body.net_charge_e() - net_charge_e).abs() < 1e-6,
        "{}",
        body.net_charge_e()
    );
    for residue in &body.residues {
        let mut charge_e = 0.0;
        for group in answer["groups"].as_array().unwrap() {
            if group["residue_number"] == residue.number {
                charge_e += group["charge_e"].as_f64().unwrap();
            }
        }
        let difference = residue.charge_e - charge_e;
        assert!(difference.abs() < 1e-6, "{} {difference}", residue.number);
    }
    let said = &body.provenance.settings["protonation"];
    assert!(said.contains("0.05 M") && said.contains("2 /M"), "{said}");
    // Without the flag, charges are those in water.
    is_ok(&place.run(&format!("ingest -q {STRUCTURE} --ph 4 -o water")));
    let (water, _) =
        protomer_protein_verbs::bodies::body_file::read(&place.path("water/5pti.body")).unwrap();
    assert!((water.net_charge_e() - net_charge_e).abs() > 0.5);
    let refused = place.run(&format!("ingest {STRUCTURE} --anion-binding 2 -o refused"));
    assert!(message(&refused).contains("add --protonation structure"));
}

/// Bodies of a pair are titrated in the salt of each condition, with the bound anions of the model.
#[test]
fn a_pair_is_titrated_in_each_salt() {
    let place = TemporaryFolder::with_data();
    let conditions = "--ph 7 --salt 20mM,200mM --relative-error 0.5 --most-directions 64";
    let pair = place.answer(&format!(
        "pair -q {PEPTIDE} {conditions} --model solution-2 --json"
    ));
    assert_eq!(pair["model"], "solution-2");
    let mut charges_e = Vec::new();
    for condition in pair["conditions"].as_array().unwrap() {
        let salt_molar = condition["salt_M"].as_f64().unwrap();
        let titration = place.answer(&format!(
            "titrate -q {PEPTIDE} --ph 7 --anion-binding 12 --salt {salt_molar}M --json"
        ));
        let expected = titration["net_charge_e"].as_f64().unwrap();
        for net_charge_e in condition["net_charge_e"].as_array().unwrap() {
            let net_charge_e = net_charge_e.as_f64().unwrap();
            let difference = net_charge_e - expected;
            assert!(difference.abs() < 1e-6, "{salt_molar} M: {difference}");
            charges_e.push(net_charge_e);
        }
    }
    // More salt, more anions.
    assert!(charges_e[2] < charges_e[0] - 0.2, "{charges_e:?}");
    is_ok(&place.run(&format!("ingest -q {STRUCTURE} -o bodies")));
    let refused = place.run("pair bodies/5pti.body --salt 0.1M --protonation structure");
    assert!(message(&refused).contains("ingest them with --protonation"));
}

/// A model with a titration names itself for bodies that have it, and for no others.
#[test]
fn bodies_of_another_titration_are_not_those_of_the_model() {
    let place = TemporaryFolder::with_data();
    for (flags, expected) in [
        ("--anion-binding 12", "solution-2"),
        ("--anion-binding 1", "own terms"),
    ] {
        is_ok(&place.run(&format!(
            "ingest -q {STRUCTURE} --protonation structure {flags} -o bodies --force"
        )));
        is_ok(
            &place
                .run("assemble fluid bodies/5pti.body --counts 2 --box 200 -o two.json --force -q"),
        );
        let inspected = place.answer("inspect two.json --salt 100mM --model solution-2 --json");
        assert_eq!(inspected["model"], expected, "{flags}");
    }
}

/// Charges that follow the potential of another body lower the energy, most at low salt.
#[test]
fn regulated_charges_repel_less() {
    let place = TemporaryFolder::with_data();
    let b22 = |flags: &str| {
        let conditions = "--ph 3.5 --salt 20mM --most-directions 64 --interaction response";
        let answer = place.answer(&format!("pair -q {PEPTIDE} --json {conditions} {flags}"));
        answer["conditions"][0]["b22_mol_ml_per_g2"]
            .as_f64()
            .unwrap()
    };
    let fixed = b22("--protonation structure");
    let regulated = b22("--protonation structure --regulation");
    // 8 %, with the same random numbers in both.
    assert!(regulated < 0.97 * fixed, "{regulated} {fixed}");
    for (flags, remedy) in [
        ("--interaction response", "ingest --protonation structure"),
        (
            "--interaction effective --protonation structure",
            "--interaction response",
        ),
        ("--protonation structure", "--interaction response"),
    ] {
        let refused = place.run(&format!(
            "pair {STRUCTURE} --salt 0.1M --regulation {flags}"
        ));
        assert!(!refused.status.success(), "{flags}");
        assert!(message(&refused).contains(remedy), "{}", message(&refused));
    }
}

/// Salt weakens what groups do to each other: of this positive protein, aspartate 50 moves towards its
/// pKa in water.
#[test]
fn salt_screens_the_shifts_by_neighbours() {
    let place = TemporaryFolder::with_data();
    let pka = |salt: &str| {
        let answer = place.answer(&format!("titrate -q {STRUCTURE} --salt {salt} --json"));
        let groups = answer["groups"].as_array().unwrap().clone();
        let group = groups
            .into_iter()
            .find(|group| group["residue_number"] == 50)
            .unwrap();
        group["pka"].as_f64().unwrap()
    };
    assert!(pka("1M") > pka("10mM") + 0.2);
}

#[test]
fn what_cannot_be_titrated_is_refused_with_a_remedy() {
    let place = TemporaryFolder::with_data();
    std::fs::write(
        place.path("glycine.pdb"),
        "ATOM      1  N   GLY A   2       0.000   0.000   0.000  1.00  0.00           N\n\
         ATOM      2  CA  GLY A   2       1.460   0.000   0.000  1.00  0.00           C\n\
         HETATM    3 ZN    ZN B   3       9.000   0.000   0.000  1.00  0.00          ZN\n",
    )
    .unwrap();
    std::fs::write(
        place.path("point.pqr"),
        "ATOM 1 N LYS 1 0.0 0.0 0.0 1.0 2.0\n",
    )
    .unwrap();
    for (words, told) in [
        (
            "glycine.pdb --chain B --keep-ligands --salt 0.1M",
            "no titratable group",
        ),
        ("point.pqr --salt 0.1M", "give PDB or mmCIF"),
        ("glycine.pdb --salt 0.1M --ph 20", "0 to 14"),
        ("glycine.pdb --salt 0.1M --ph 12..2", "lower pH first"),
        ("glycine.pdb", "--salt"),
    ] {
        let output = place.run(&format!("titrate {words}"));
        assert!(!output.status.success(), "{words}");
        assert!(
            message(&output).contains(told),
            "{words}: {}",
            message(&output)
        );
    }
}
