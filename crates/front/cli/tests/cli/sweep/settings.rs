//! The settings of a sweep: energies, definitions and configuration files.

use super::{SWEEP, assert_same, columns, results, sweep_of};
use crate::common::{TemporaryFolder, contents, is_ok, message};
use protomer_protein_verbs::stability::run::RunSettings;

#[test]
fn calibrated_energies_make_the_trajectories_of_the_direct_sum() {
    let place = TemporaryFolder::new();
    let sweep = sweep_of(80, 20);
    for energy in ["direct", "calibrated"] {
        is_ok(&place.run(&format!("{sweep} --energy {energy} -o {energy}")));
    }
    for replica in ["salt_0.050000M/replica_0", "salt_0.300000M/replica_1"] {
        let log = |energy: &str| columns(&place.path(&format!("{energy}/{replica}/log.csv")));
        let (direct, calibrated) = (log("direct"), log("calibrated"));
        for column in [
            "sweep",
            "r_g_angstrom",
            "native_contacts",
            "largest_cluster",
            "cluster_moved",
        ] {
            assert_eq!(direct[column], calibrated[column], "{replica} {column}");
        }
        let energies = direct["energy_kT"].iter().zip(&calibrated["energy_kT"]);
        assert!(
            energies
                .clone()
                .all(|(sum, middle)| (sum - middle).abs() < 1e-3),
            "{replica}"
        );
        assert!(
            energies.clone().any(|(sum, middle)| sum != middle),
            "{replica}: intervals were used"
        );
    }
}

#[test]
fn a_tolerance_belongs_to_approximate_energies_and_to_the_run() {
    let place = TemporaryFolder::new();
    let short = sweep_of(16, 6);
    let refused = |command: &str, code: i32, words: &[&str]| {
        let output = place.run(command);
        assert_eq!(output.status.code(), Some(code), "{command}");
        assert!(
            words.iter().all(|word| message(&output).contains(word)),
            "{command}: {}",
            message(&output)
        );
    };
    refused(
        &format!("{short} --tolerance 1e-3 -o run"),
        1,
        &["--energy approximate", "direct"],
    );
    for senseless in ["0", "-1e-3", "inf", "NaN"] {
        refused(
            &format!("{short} --energy approximate --tolerance {senseless} -o run"),
            2,
            &["--tolerance", "give 1e-12 to"],
        );
    }
    // The usual tolerance is written down; it can be stated, another one is another run.
    is_ok(&place.run(&format!("{short} --energy approximate -o run")));
    let settings = std::fs::read_to_string(place.path("run/run.toml")).unwrap();
    assert!(
        settings.contains("energy = \"approximate\"\ntolerance_kt = 0.001\n"),
        "{settings}"
    );
    is_ok(&place.run(&format!(
        "{short} --energy approximate --tolerance 1e-3 -o run"
    )));
    refused(
        &format!("{short} --energy approximate --tolerance 1e-4 -o run"),
        1,
        &["other settings"],
    );
    is_ok(&place.run("sweep ring.json --config run/run.toml -o again --quiet"));
    assert_same(&results(&place.path("run")), &results(&place.path("again")));
    // The tolerance of a configuration goes with its energies.
    is_ok(&place.run("sweep ring.json --config run/run.toml --energy direct -o direct --quiet"));
    assert!(
        !std::fs::read_to_string(place.path("direct/run.toml"))
            .unwrap()
            .contains("tolerance")
    );
    let text = settings.replace("tolerance_kt", "tolerance");
    std::fs::write(place.path("misspelt.toml"), text).unwrap();
    refused(
        "sweep ring.json --config misspelt.toml -o misspelt --quiet",
        1,
        &["tolerance"],
    );
    refused(
        &format!("{short} --energy calibrated --memory-limit 1kB -o small"),
        1,
        &["--memory-limit", "salt 0.05 M"],
    );
}

/// The program chooses how energies are computed, writes it down, and keeps to it.
#[test]
fn the_energies_of_a_run_are_chosen_once() {
    let place = TemporaryFolder::new();
    let short =
        "sweep ring.json --salt 50mM,300mM --replicas 2 --sweeps 20 --equilibration 10 --quiet";
    let settings = |directory: &str| {
        std::fs::read_to_string(place.path(&format!("{directory}/run.toml"))).unwrap()
    };
    is_ok(&place.run(&format!("{short} -o run")));
    let chosen = settings("run");
    assert!(chosen.contains("energy = \"direct\""), "{chosen}");
    assert!(chosen.contains("definition = \"no cut-off\""), "{chosen}");
    is_ok(&place.run(&format!("{short} --energy calibrated -o begun")));
    is_ok(&place.run(&format!("{short} -o begun")));
    assert!(settings("begun").contains("energy = \"calibrated\""));
    // Earlier versions cut energies by default, and did not say so in the settings.
    let earlier = chosen.replace("definition = \"no cut-off\"\n", "");
    std::fs::write(place.path("run/run.toml"), earlier).unwrap();
    let output = place.run(&format!("{short} -o run"));
    assert_eq!(output.status.code(), Some(1));
    let said = message(&output);
    assert!(
        said.contains("medium.definition: none there, \"no cut-off\" here"),
        "{said}"
    );
}

/// Contacts of earlier versions were counted from vertices: a run that was begun so is not continued,
/// but its results are read.
#[test]
fn contacts_of_two_definitions_are_not_mixed_in_a_run() {
    let place = TemporaryFolder::new();
    let short = "sweep ring.json --salt 50mM,300mM --replicas 2 --sweeps 20 --equilibration 10 \
                 --log-every 1 --trajectory-every 1 --quiet -o run";
    is_ok(&place.run(short));
    let path = place.path("run/run.toml");
    let begun = std::fs::read_to_string(&path).unwrap();
    let stated = "contact_definition = \"between surfaces\"\n";
    assert!(begun.contains(stated), "{begun}");
    std::fs::write(&path, begun.replace(stated, "")).unwrap();
    let before = contents(&place.path("run"));
    let refused = place.run(short);
    assert_eq!(refused.status.code(), Some(1));
    let said = message(&refused);
    let wanted = "contact_definition: none there, \"between surfaces\" here";
    assert!(said.contains(wanted), "{said}");
    assert!(contents(&place.path("run")) == before);
    for reading in [
        "reweight run",
        "compare run -o compared.svg",
        "report run -o report.html",
    ] {
        is_ok(&place.run(reading));
    }
}

#[test]
fn the_settings_file_of_a_run_is_a_configuration_that_continues_it() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o first")));
    is_ok(&place.run("sweep ring.json --config first/run.toml -o second --quiet"));
    is_ok(&place.run("sweep ring.json --config first/run.toml -o first --quiet"));
    assert_same(
        &results(&place.path("first")),
        &results(&place.path("second")),
    );
    let settings = RunSettings {
        seed: 3,
        log_every: 7,
        contact_gap_angstrom: 0.1 + 0.2,
        ..RunSettings::default()
    };
    assert_eq!(
        toml::from_str::<RunSettings>(&toml::to_string_pretty(&settings).unwrap()).unwrap(),
        settings
    );
    assert!(toml::from_str::<RunSettings>("sweps = 3").is_err());
    assert!(toml::from_str::<RunSettings>("[medium]\nsalt = 3").is_err());
}
