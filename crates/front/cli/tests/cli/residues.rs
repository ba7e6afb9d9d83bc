//! Residues of a run: the files, the report, and mutants simulated anew.

use crate::common::{TemporaryFolder, is_ok, message};
use protomer_protein_verbs::stability::residues::ResiduesResult;
use serde_json::Value;
use std::path::Path;

const STRUCTURE: &str = "data/structures/5pti.cif.gz";
/// Exchanges that make BPTI negative.
const MINUS: &str = "A:R17E,A:K26E,A:R39E,A:K41E,A:R42E,A:K46E,A:R53E";

fn ingest(place: &TemporaryFolder, name: &str, mutations: &str) {
    is_ok(&place.run(&format!(
        "ingest -q {STRUCTURE} -o . --name {name} --core surface --charges formal --density 0.5 --mutate {mutations}"
    )));
}

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).unwrap()
}

fn read(path: &Path) -> Value {
    json(&std::fs::read(path).unwrap())
}

/// Two residues of one kind, at coordinates of a chain that is drawn out.
fn dipeptide(residue: &str, ends: [&str; 2]) -> String {
    let backbone = [
        ("N", [0.0, 0.0, 0.0]),
        ("CA", [1.46, 0.0, 0.0]),
        ("C", [2.0, 1.4, 0.0]),
        ("O", [1.2, 2.4, 0.0]),
        ("CB", [2.0, -0.8, 1.2]),
        ("CG", [3.5, -0.9, 1.3]),
        ("CD", [4.1, -1.7, 2.5]),
    ];
    let end_of_chain = [[5.2, -2.4, 2.3], [3.6, -1.7, 3.7]];
    let mut text = String::new();
    let mut serial = 0;
    for number in 1..=2 {
        let atoms = backbone
            .into_iter()
            .chain(ends.into_iter().zip(end_of_chain));
        for (name, [x, y, z]) in atoms {
            serial += 1;
            let (x, y) = (
                x + 3.3 * f64::from(number - 1),
                y + 1.6 * f64::from(number - 1),
            );
            let element = &name[..1];
            text += &format!(
                "ATOM  {serial:5}  {name:<3} {residue} A{number:4}    {x:8.3}{y:8.3}{z:8.3}  1.00  0.00          {element:>2}\n"
            );
        }
    }
    text
}

/// Two glutamates straight above two lysines.
const FACING: [f64; 3] = [0.0, 0.0, 8.5];

/// Two lysines and, at this place, two glutamates in a box of 200 Å; the surfaces are in contact.
fn two_peptides(second_angstrom: [f64; 3]) -> TemporaryFolder {
    let place = TemporaryFolder::new();
    for (name, text) in [
        ("plus", dipeptide("LYS", ["CE", "NZ"])),
        ("minus", dipeptide("GLU", ["OE1", "OE2"])),
    ] {
        std::fs::write(place.path(&format!("{name}.pdb")), text).unwrap();
        is_ok(&place.run(&format!("ingest -q {name}.pdb -o . --charges formal")));
    }
    let placed = |body: &str, position: [f64; 3]| {
        let turned = [1, 0, 0, 0];
        serde_json::json!({"body": body, "position_angstrom": position, "orientation_wxyz": turned})
    };
    let assembly = serde_json::json!({
        "box_angstrom": [200, 200, 200],
        "bodies": [{"name": "plus", "file": "plus.body"}, {"name": "minus", "file": "minus.body"}],
        "placements": [placed("plus", [0.0; 3]), placed("minus", second_angstrom)],
    });
    std::fs::write(place.path("two.json"), assembly.to_string()).unwrap();
    place
}

/// Fitted charges next to each other may be hundreds of e: a share of them says nothing of a residue.
#[test]
fn effective_charges_are_not_shared_out_among_residues() {
    let place = two_peptides(FACING);
    let plain = place.run("residues two.json --salt 100mM --json");
    is_ok(&plain);
    let plain = json(&plain.stdout);
    assert_eq!(plain["shared_by"], "charges");
    assert!(plain["effective_energy_kt"].is_null() && plain["charges_note"].is_null());
    let effective = "two.json --salt 100mM --interaction effective --inner-permittivity 4";
    let output = place.run(&format!("residues {effective} --json"));
    is_ok(&output);
    let found = json(&output.stdout);
    for key in ["energy", "residues", "pairs"] {
        assert_eq!(found[key], plain[key], "{key}");
    }
    assert_eq!(found["shared_by"], "plain_charges");
    let note = found["charges_note"].as_str().unwrap();
    assert!(note.contains("shared out by the plain charges"), "{note}");
    // The energy of the model itself is that of `inspect`.
    let inspected = json(&place.run(&format!("inspect {effective} --json")).stdout);
    let model_kt = inspected["energy_kT"].as_f64().unwrap();
    let stated_kt = found["effective_energy_kt"].as_f64().unwrap();
    assert!(
        (stated_kt - model_kt).abs() < 1e-9,
        "{stated_kt} {model_kt}"
    );
    assert!((model_kt - plain["energy"]["total_kt"]["mean"].as_f64().unwrap()).abs() > 0.1);
    // A page reads the value that was written.
    let read: ResiduesResult = serde_json::from_value(found.clone()).unwrap();
    assert_eq!(serde_json::to_value(read).unwrap(), found);
}

/// Half of the replicas of a sweep that is not equilibrated never met: they do not halve the energies.
#[test]
fn where_starts_disagree_only_bound_frames_count() {
    let place = two_peptides(FACING);
    is_ok(&place.run(
        "sweep two.json --salt 10mM,50mM --replicas 2 --starts both --sweeps 20 --equilibration 0 \
         --cluster-moves 0 --log-every 1 --trajectory-every 1 --energy direct -q -o run",
    ));
    let sweep = read(&place.path("run/sweep.json"));
    assert_eq!(sweep["equilibrated"], false, "{}", sweep["equilibration"]);
    let output = place.run("residues run --json -q");
    is_ok(&output);
    let found = json(&output.stdout);
    let why = found["salt_chosen"].as_str().unwrap();
    assert!(why.contains("not equilibrated"), "{why}");
    assert_eq!(found["salt_M"].as_f64(), Some(0.01));
    // The rows of the log are those of the frames.
    let (mut bound, mut rows) = (Vec::new(), 0);
    for replica in 0..2 {
        let log = place.path(&format!("run/salt_0.010000M/replica_{replica}/log.csv"));
        let log = std::fs::read_to_string(log).unwrap();
        let mut lines = log.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let heading = lines.next().unwrap();
        let column = |name| heading.iter().position(|cell| *cell == name).unwrap();
        let (contacts, energy) = (column("contacts"), column("energy_kT"));
        for line in lines {
            rows += 1;
            if line[contacts].parse::<f64>().unwrap() > 0.5 {
                bound.push(line[energy].parse::<f64>().unwrap());
            }
        }
    }
    assert!(!bound.is_empty() && bound.len() <= rows / 2, "{bound:?}");
    assert_eq!(found["bound_frames_only"], true);
    assert_eq!(found["frames"], bound.len());
    assert_eq!(found["frames_read"], rows);
    let expected = bound.iter().sum::<f64>() / bound.len() as f64;
    let mean = found["energy"]["total_kt"]["mean"].as_f64().unwrap();
    assert!((mean - expected).abs() < 0.01, "{mean} {expected}");
    let text = place.run("residues run -q --force");
    let text = String::from_utf8(text.stdout).unwrap();
    let frames = format!("{} of {rows} frames", bound.len());
    assert!(text.contains(&frames), "{text}");
}

/// The scan knows the charge of a residue, and nothing of a contact that it is buried in.
#[test]
fn exchanges_in_a_contact_are_marked_and_not_recommended() {
    let place = two_peptides([4.0, 2.0, 8.5]);
    let scan = "residues two.json --salt 100mM --mutations --touching 6A";
    let result = json(&place.run(&format!("{scan} --json")).stdout);
    let rows = result["mutations"].as_array().unwrap();
    let touches = |row: &&Value| row["touching"].as_f64().unwrap() > 0.1;
    let in_contact: Vec<&Value> = rows.iter().filter(touches).collect();
    assert!(
        !in_contact.is_empty() && in_contact.len() < rows.len(),
        "{rows:?}"
    );
    for row in rows {
        assert_eq!(row["recommended"], !touches(&row), "{row}");
    }
    let listed = |options: &str| {
        let output = place.run(&format!("{scan} {options}"));
        is_ok(&output);
        let text = String::from_utf8(output.stdout).unwrap();
        let exchanges = text
            .split("exchanges of one charge")
            .nth(1)
            .unwrap()
            .to_owned();
        let is_listed = |row: &&&Value| exchanges.contains(row["mutation"].as_str().unwrap());
        (in_contact.iter().filter(is_listed).count(), text)
    };
    let (none, text) = listed("");
    assert_eq!(none, 0, "{text}");
    let left_out = format!(
        "{} of {} exchanges are left out",
        in_contact.len(),
        rows.len()
    );
    assert!(text.contains(&left_out), "{text}");
    assert_eq!(listed("--include-touching").0, in_contact.len());
}

/// The energy of the run's log is that of the shares; files and report are there.
#[test]
fn a_run_is_shared_out_and_shown() {
    let place = TemporaryFolder::with_data();
    ingest(&place, "plus", "A:D3K,A:E49K");
    ingest(&place, "minus", MINUS);
    is_ok(&place.run("assemble ring -q plus.body minus.body --members 4 --box 200 -o four.json"));
    is_ok(&place.run(
        "sweep four.json --salt 30mM,300mM --replicas 2 --energy direct --equilibration 20 --sweeps 60 \
         --log-every 10 --trajectory-every 10 -q -o run --contacts calvados3",
    ));
    let output = place.run("residues run --salt 30mM --script chimerax --json -q");
    is_ok(&output);
    let result = json(&output.stdout);
    assert_eq!(
        (&result["frames"], &result["blocks"]),
        (&12.into(), &6.into())
    );
    let sweep = read(&place.path("run/sweep.json"));
    let expected = sweep["salts"][0]["energy_mean_kT"].as_f64().unwrap();
    let found = result["energy"]["total_kt"]["mean"].as_f64().unwrap();
    // The rows of the log are those of the frames, whose poses have single precision.
    assert!((found - expected).abs() < 0.01, "{found} {expected}");
    for name in [
        "residues.csv",
        "residue_pairs.csv",
        "residues.png",
        "contact_map.svg",
        "energy_map.png",
        "residues.cif",
        "residues.cxc",
        "residues.json",
    ] {
        assert!(place.path("run/residues").join(name).is_file(), "{name}");
    }
    let changed = place.run("residues run --mutations --salt 30mM --json -q -o elsewhere");
    is_ok(&changed);
    let changed = json(&changed.stdout);
    let of_minus = |row: &&Value| row["body"] == "minus" && row["mutation"] == "A:D50K";
    let row = changed["mutations"]
        .as_array()
        .unwrap()
        .iter()
        .find(of_minus)
        .unwrap();
    assert!(
        row["energy_change_kt"]["mean"].as_f64().unwrap() > 1.0,
        "{row}"
    );
    assert!(
        row["first_order_half_salt_molar"].as_f64().unwrap()
            < sweep["half_salt_molar"].as_f64().unwrap()
    );
    // All start alike, so nothing is known of an equilibrium.
    assert!(row["half_salt_molar"].is_null());
    assert!(
        changed["mutations_note"]
            .as_str()
            .unwrap()
            .contains("not known to be in equilibrium")
    );
    let script = std::fs::read_to_string(place.path("run/residues/residues.cxc")).unwrap();
    assert!(script.contains("color byattribute bfactor"), "{script}");
    let again = place.run("residues run --salt 30mM -q");
    assert!(message(&again).contains("--force"));
    is_ok(&place.run("report run"));
    let page = std::fs::read_to_string(place.path("run/report.html")).unwrap();
    assert!(page.contains("What holds it") && page.contains("energy of residues at 30 mM"));
    // A run that is begun anew takes its residues with it.
    is_ok(&place.run(
        "sweep four.json --salt 30mM --replicas 1 --energy direct --equilibration 20 --sweeps 60 \
         --log-every 10 -q -o run --force",
    ));
    assert!(!place.path("run/residues").exists());
}

/// What `inspect` prints by terms adds up to the energy, and `residues` shares out the same terms.
#[test]
fn the_response_of_the_solvent_is_shared_out_among_residues() {
    let place = two_peptides(FACING);
    let pose = "two.json --salt 50mM --interaction response --contacts calvados3 --json";
    let inspected = json(&place.run(&format!("inspect {pose}")).stdout);
    let energy_kt = inspected["energy_kT"].as_f64().unwrap();
    let terms = inspected["terms_kt"].as_object().unwrap();
    let term = |name: &str| terms[name].as_f64().unwrap();
    assert_eq!(terms.len(), 3);
    let sum: f64 = terms.values().map(|term| term.as_f64().unwrap()).sum();
    assert!((sum - energy_kt).abs() < 1e-9, "{sum} {energy_kt}");
    assert_eq!(
        inspected["pair_terms"][0]["terms_kt"],
        inspected["terms_kt"]
    );

    let shared = json(&place.run(&format!("residues {pose}")).stdout);
    assert_eq!(shared["shared_by"], "charges");
    assert_eq!(shared["effective_energy_kt"], inspected["energy_kT"]);
    let whole = |name: &str| shared["energy"][name]["mean"].as_f64().unwrap();
    assert!((whole("charges_kt") - term("charges")).abs() < 1e-9);
    assert!((whole("contacts_kt") - term("contacts")).abs() < 1e-9);
    let mut of_residues = 0.0;
    for row in shared["residues"].as_array().unwrap() {
        of_residues += row["solvent_response_kt"].as_f64().unwrap();
    }
    let response_kt = whole("solvent_response_kt");
    assert!((of_residues - response_kt).abs() < 1e-9);
    // The energy of the run gathers charges on a lattice of 3 Å.
    let gathered_kt = term("solvent_response");
    assert!(gathered_kt.abs() > 0.1, "{gathered_kt}");
    assert!(
        (response_kt - gathered_kt).abs() < 0.2,
        "{response_kt} {gathered_kt}"
    );
}

/// The surface of a body belongs to its residues, and those without any are marked.
#[test]
fn buried_residues_are_marked() {
    let place = TemporaryFolder::with_data();
    ingest(&place, "bpti", "A:D3K");
    is_ok(&place.run("assemble ring -q bpti.body --members 2 -o two.json"));
    let found = json(&place.run("residues two.json --salt 100mM --json").stdout);
    let (mut area, mut buried) = (0.0, Vec::new());
    for row in found["residues"].as_array().unwrap() {
        area += row["surface_angstrom2"].as_f64().unwrap();
        if row["buried"] == true {
            buried.push(row["number"].as_i64().unwrap());
        }
    }
    // As `ingest` prints it for this mesh.
    assert!((area - 3173.37).abs() < 0.01, "{area}");
    // Cysteines of the three disulfides, which lie in the middle.
    assert_eq!(buried, [5, 51, 55]);
}

/// A model is its terms: every verb has the energies of the flags it stands for, and names it.
#[test]
fn a_model_stands_for_its_terms() {
    let place = two_peptides(FACING);
    let terms = "--interaction response --contacts calvados3 --contact-strength 1.9";
    for verb in ["inspect two.json", "residues two.json"] {
        let of_flags = |flags: &str| {
            let output = place.run(&format!("{verb} --salt 100mM {flags} --json"));
            is_ok(&output);
            json(&output.stdout)
        };
        let named = of_flags("--model natural-1");
        assert_eq!(named["model"], "natural-1", "{verb}");
        assert_eq!(named, of_flags(terms), "{verb}");
        let single = of_flags("--model natural-1 --contact-strength 0.5");
        assert_eq!(single["model"], "own terms", "{verb}");
        // Bodies with native cores have the terms of the thesis, and are not its bodies.
        assert_eq!(of_flags("--interaction bare")["model"], "own terms");
    }
    let output = place.run("inspect two.json --salt 100mM --model thesis --json");
    is_ok(&output);
    assert!(
        message(&output).contains("ingest it again"),
        "{}",
        message(&output)
    );
}

/// The estimate of the affinity at another salt and pH moves by what charges do; a tiny interface is refused
/// as a number.
#[test]
fn an_affinity_moves_with_salt_and_ph() {
    let place = two_peptides(FACING);
    let minus = std::fs::read_to_string(place.path("minus.pdb")).unwrap();
    let mut lifted = String::new();
    for line in minus.lines() {
        let z: f64 = line[46..54].trim().parse().unwrap();
        lifted += &format!("{}{:8.3}{}\n", &line[..46], z + 6.5, &line[54..]);
    }
    std::fs::write(place.path("lifted.pdb"), lifted).unwrap();
    let output =
        place.run("binding plus.pdb lifted.pdb --salt 50mM,1M --ph 7.4,2 --spacing 0.9 --json");
    is_ok(&output);
    assert!(
        message(&output).contains("extrapolation"),
        "{}",
        message(&output)
    );
    let found = json(&output.stdout);
    let of = |index: usize, key: &str| found["conditions"][index][key].as_f64().unwrap();
    let kcal_per_kt = 1.987_204e-3 * 298.15;
    let change = of(1, "delta_g_kcal_per_mol") - of(0, "delta_g_kcal_per_mol");
    let by_salt = kcal_per_kt * of(1, "salt_effect_kt");
    assert!(
        (change - by_salt).abs() < 1e-6 && change > 0.1,
        "{change} {by_salt}"
    );
    // At pH 2 the glutamates are neutral: nothing holds the peptides by charges.
    assert!(of(2, "delta_g_kcal_per_mol") > of(0, "delta_g_kcal_per_mol") + 0.3);
    assert_eq!(found["model"], "natural-1");
    // Two seeds of the integrated constant agree within their errors; one is weighted from the other salt.
    let again = place.run("binding plus.pdb lifted.pdb --salt 1M --seed 2 --spacing 0.9 --json");
    is_ok(&again);
    let again = json(&again.stdout);
    let other = again["conditions"][0]["log10_kd_molar"].as_f64().unwrap();
    let error = of(1, "log10_kd_error");
    assert!(error < 0.3, "{error}");
    let apart = (of(1, "log10_kd_molar") - other).abs();
    assert!(
        apart < 4.0 * 2.0_f64.sqrt() * error.max(0.05),
        "{apart} {error}"
    );
    let none = place.run("binding plus.pdb lifted.pdb --salt 1M --no-kd --spacing 0.9 --json");
    assert!(json(&none.stdout)["conditions"][0]["log10_kd_molar"].is_null());
}

/// The chains of the protease interlock: within 5 Å hardly a pose is free, so the state has a narrower limit.
#[test]
#[ignore = "takes half a minute of processor time"]
fn interlocked_chains_have_a_constant() {
    let place = TemporaryFolder::with_data();
    let output = place.run(
        "binding data/structures/4e43.pdb.gz --body A --body B --salt 150mM --spacing 0.9 --json",
    );
    is_ok(&output);
    let found = json(&output.stdout);
    let state = &found["bound_states"][0];
    assert!(state["limit_angstrom"].as_f64().unwrap() < 5.0);
    assert!(state["share_at_limit"].as_f64().unwrap() < 0.05);
    let condition = &found["conditions"][0];
    assert!(condition["log10_kd_error"].as_f64().unwrap() < 0.3);
    // The pose has -64 kT, and binding costs 12 to 25 kT of freedom.
    let log10_kd = condition["log10_kd_molar"].as_f64().unwrap();
    assert!((-24.0..-16.0).contains(&log10_kd), "{log10_kd}");
}
