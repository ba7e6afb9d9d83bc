//! The answer of a sweep: its table, half salts and figure.

use super::{SWEEP, columns};
use crate::common::{TemporaryFolder, is_ok, message};
use protomer_kernel::statistics::Summary;
use protomer_protein_verbs::stability::run::{AcceptedFractions, Columns, RunSettings, Starts};
use protomer_protein_verbs::stability::sweep::figure::figure;
use protomer_protein_verbs::stability::sweep::result::SweepResult;
use protomer_protein_verbs::stability::sweep::stability::Stability;
use protomer_protein_verbs::stability::sweep::table::{ReplicaResult, SaltRow};
use serde_json::Value;

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn sample_deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values
        .iter()
        .map(|x| (x - centre) * (x - centre))
        .sum::<f64>()
        / (values.len() as f64 - 1.0))
        .sqrt()
}

#[test]
fn the_table_holds_the_averages_of_the_logs() {
    let place = TemporaryFolder::new();
    is_ok(&place.run(&format!("{SWEEP} -o run")));
    let table = columns(&place.path("run/sweep.csv"));
    assert_eq!(table["salt_M"], [0.05, 0.3]);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("run/sweep.json")).unwrap()).unwrap();
    for (row, salt) in ["salt_0.050000M", "salt_0.300000M"].into_iter().enumerate() {
        let logs: Vec<_> = (0..2)
            .map(|replica| columns(&place.path(&format!("run/{salt}/replica_{replica}/log.csv"))))
            .collect();
        for (logged, tabled, unit) in [
            ("r_g_angstrom", "r_g", "_angstrom"),
            ("native_contacts", "native_contacts", ""),
            ("largest_cluster", "largest_cluster", ""),
            ("energy_kT", "energy", "_kT"),
            ("bound_fraction", "bound_fraction", ""),
        ] {
            let means: Vec<f64> = logs.iter().map(|log| mean(&log[logged])).collect();
            assert_eq!(logs[0][logged].len(), 300, "a row every 5 of 1500 sweeps");
            for (kind, expected) in [("mean", mean(&means)), ("sd", sample_deviation(&means))] {
                let column = format!("{tabled}_{kind}{unit}");
                let found = table[&column][row];
                assert!(
                    (found - expected).abs() <= 1e-9 * (1.0 + expected.abs()),
                    "{column}: {found} {expected}"
                );
                let in_json = json["salts"][row][&column].as_f64().unwrap();
                assert!(
                    (in_json - expected).abs() <= 1e-9 * (1.0 + expected.abs()),
                    "{column} of sweep.json"
                );
            }
        }
        assert!(
            logs[0]["r_g_angstrom"] != logs[1]["r_g_angstrom"],
            "replicas differ"
        );
    }
    for figure in ["run/sweep.svg", "run/sweep.png"] {
        assert!(
            std::fs::metadata(place.path(figure)).unwrap().len() > 1000,
            "{figure}"
        );
    }
}

#[test]
fn the_answer_names_the_half_salt_or_says_why_not() {
    let place = TemporaryFolder::new();
    for (name, charge) in [("a", 6), ("b", -6)] {
        std::fs::write(place.path("charge.xyzq"), format!("0 0 0 {charge}\n")).unwrap();
        let body = format!("body --mesh cube.off --charges charge.xyzq -o {name}.body --force");
        is_ok(&place.run(&body));
    }
    let answer = |options: &str, directory: &str| -> serde_json::Value {
        let sweep = "sweep ring.json --salt 50mM,300mM --replicas 2 --seed 7 --log-every 5 --json";
        let output = place.run(&format!("{sweep} {options} -o {directory}"));
        is_ok(&output);
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let alike = answer("--sweeps 400 --equilibration 100", "alike");
    let half = alike["half_salt_molar"].as_f64().unwrap();
    assert!(half > 0.05 && half < 0.3, "{half}");
    let interval = &alike["half_salt_interval_molar"];
    assert!(interval[0].as_f64().is_none_or(|low| low <= half));
    assert!(interval[1].as_f64().is_none_or(|high| high >= half));
    assert!(alike["equilibrated"].is_null());
    // So short a run keeps its start.
    let apart = answer("--sweeps 40 --equilibration 0 --starts both", "apart");
    assert_eq!(apart["equilibrated"], serde_json::json!(false));
    assert_eq!(
        (&alike["equilibrium"], &apart["equilibrium"]),
        (&"unknown".into(), &"no".into())
    );
    assert!(apart["half_salt_molar"].is_null());
    let words = apart["equilibration"].as_str().unwrap();
    assert!(words.starts_with("not equilibrated: at "), "{words}");
    let exchanged = answer(
        "--sweeps 40 --equilibration 0 --exchange-every 5",
        "exchanged",
    );
    let acceptance = &exchanged["exchanges"][1]["acceptance"];
    assert_eq!(acceptance.as_array().map(Vec::len), Some(1));
    for (options, wanted) in [
        ("--exchange-every 5 --salt 50mM", "list several"),
        ("--starts both --replicas 1 --salt 50mM", "--replicas 2"),
        (
            "--exchange-every 5 --energy none --salt 50mM,300mM",
            "--exchange-every",
        ),
    ] {
        let words = message(&place.run(&format!("sweep ring.json {options} -o refused")));
        assert!(words.contains(wanted), "{options}: {words}");
    }
}

/// Open space has no equilibrium: that is said before the run, answers that need one are refused at
/// once, and the box that is advised works.
#[test]
fn open_space_is_said_before_the_run_and_the_advice_works() {
    let place = TemporaryFolder::new();
    let ring = std::fs::read_to_string(place.path("ring.json")).unwrap();
    let mut assembly: serde_json::Value = serde_json::from_str(&ring).unwrap();
    assembly["box_angstrom"] = serde_json::Value::Null;
    std::fs::write(place.path("open.json"), assembly.to_string()).unwrap();
    let short = "--salt 50mM,300mM --replicas 2 --sweeps 20 --equilibration 0";
    let open = place.run(&format!("sweep open.json {short} -o open"));
    is_ok(&open);
    let words = message(&open);
    // Stopped before the first simulation, it has said so already.
    let stopped = place.run(&format!(
        "sweep open.json {short} --time-limit 0 -o stopped"
    ));
    assert_eq!(stopped.status.code(), Some(3));
    assert!(
        message(&stopped).contains("no box"),
        "{}",
        message(&stopped)
    );
    assert!(!place.path("stopped/sweep.csv").exists());
    let result = std::fs::read(place.path("open/sweep.json")).unwrap();
    let result: serde_json::Value = serde_json::from_slice(&result).unwrap();
    assert_eq!(result["equilibrated"], false);
    assert!(result["half_salt_molar"].is_null());
    assert!(result["equilibration"].as_str().unwrap().contains("no box"));
    // Before any simulation, and before any fit.
    for options in ["--starts both", "--exchange-every 5"] {
        let refused = place.run(&format!("sweep open.json {short} {options} -o refused"));
        assert_eq!(refused.status.code(), Some(1));
        assert!(message(&refused).contains("\"box_angstrom\": ["));
        assert!(!place.path("refused").exists());
    }
    let edge = words.split("\"box_angstrom\": [").nth(1).unwrap();
    let edge: f64 = edge.split(',').next().unwrap().parse().unwrap();
    assembly["box_angstrom"] = serde_json::json!([edge, edge, edge]);
    std::fs::write(place.path("boxed.json"), assembly.to_string()).unwrap();
    let advised = format!("sweep boxed.json {short} --starts both --exchange-every 5 -o boxed");
    is_ok(&place.run(&advised));
}

/// `--starts both` is advised with as many replicas as it needs.
#[test]
fn the_advice_to_one_replica_works_when_followed() {
    let place = TemporaryFolder::new();
    let short = "sweep ring.json --salt 50mM,300mM --sweeps 20 --equilibration 0";
    let output = place.run(&format!("{short} --replicas 1 -o one --json"));
    is_ok(&output);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let words = result["equilibration"].as_str().unwrap();
    let advice = "--starts both --replicas 4";
    assert!(words.contains(advice), "{words}");
    is_ok(&place.run(&format!("{short} {advice} -o both")));
}

/// A sweep whose replicas have these fractions of bound bodies and of contacts at three salts.
fn drawn(starts: Starts, fractions: impl Fn(u32, usize) -> f64) -> Value {
    let settings = RunSettings {
        salt_molar: vec![0.05, 0.1, 0.2],
        replicas: 4,
        starts,
        ..RunSettings::default()
    };
    let summary = |mean| Summary {
        mean,
        standard_deviation: 0.01,
        standard_error: 0.01,
        autocorrelation_time: 0.5,
        effective_samples: 100.0,
    };
    let replica = |replica, salt| ReplicaResult {
        replica,
        averages: Columns {
            r_g_angstrom: Some(summary(50.0)),
            native_contacts: Some(summary(fractions(replica, salt))),
            contacts: Some(summary(8.0 * fractions(replica, salt))),
            bound_fraction: Some(summary(fractions(replica, salt))),
            ..Columns::default()
        },
        accepted: AcceptedFractions {
            translation_acceptance: 0.4,
            rotation_acceptance: 0.4,
        },
        effective_bodies: None,
        warnings: Vec::new(),
    };
    let replicas: Vec<Vec<ReplicaResult>> = (0..3)
        .map(|salt| (0..4).map(|number| replica(number, salt)).collect())
        .collect();
    let mut salts = Vec::new();
    for (salt_molar, replicas) in settings.salt_molar.iter().zip(&replicas) {
        let interaction = settings.medium.interaction(Some(*salt_molar)).unwrap();
        salts.push(SaltRow::new(*salt_molar, &interaction, replicas));
    }
    let figure = figure(&SweepResult {
        equilibrium: "unknown".into(),
        warnings: Vec::new(),
        version: String::new(),
        model: "thesis".into(),
        input_sha256: String::new(),
        bodies: 8,
        concentration_molar: 1e-4,
        box_angstrom: Some([500.0; 3]),
        stability: Stability::new(&settings, &replicas, 8, false),
        settings,
        salts,
        replicas,
        exchanges: Vec::new(),
        time_series: Vec::new(),
    });
    assert!(figure.to_svg().is_ok());
    serde_json::to_value(figure).unwrap()
}

/// The names of the series in each panel.
fn names(figure: &Value) -> Vec<Vec<&str>> {
    fn series(panel: &Value) -> Vec<&str> {
        let series = panel["series"].as_array().unwrap();
        series
            .iter()
            .map(|series| series["name"].as_str().unwrap())
            .collect()
    }
    figure["panels"]
        .as_array()
        .unwrap()
        .iter()
        .map(series)
        .collect()
}

#[test]
fn the_figure_tells_starts_apart_and_marks_the_half_salt() {
    let falling = [0.95, 0.75, 0.05];
    let agree = drawn(Starts::Both, |_, salt| falling[salt]);
    let starts = ["from the assembly", "from a fluid"];
    let half = "half, and its interval of 95 %";
    assert_eq!(
        names(&agree),
        [
            starts.to_vec(),
            [starts.as_slice(), &[half]].concat(),
            [starts.as_slice(), &[half]].concat()
        ]
    );
    for panel in [1, 2] {
        let span = &agree["panels"][panel]["series"][2]["spans"][0];
        let [x, y, from, to] = ["x", "y", "from", "to"].map(|key| span[key].as_f64().unwrap());
        // Between 100 mM, where 0.75 are left, and 200 mM.
        assert!((100.0..200.0).contains(&x) && y == 0.5, "{span}");
        assert!(from < x && x < to, "{span}");
    }

    // The mean of starts that disagree is a state of neither: each has its curve, and there is no half.
    let apart = drawn(Starts::Both, |replica, _| match replica % 2 {
        0 => 0.9,
        _ => 0.1,
    });
    assert_eq!(names(&apart), vec![starts.to_vec(); 3]);
    let curves = &apart["panels"][2]["series"];
    for (start, height) in [(0, 0.9), (1, 0.1)] {
        let found = curves[start]["points"][0]["y"].as_f64().unwrap();
        assert!((found - height).abs() < 1e-12, "{found}");
        assert_eq!(curves[start]["replicas"].as_array().unwrap().len(), 6);
    }
    assert!(
        apart["caption"]
            .as_str()
            .unwrap()
            .contains("not equilibrated")
    );

    // A single curve has one name in all panels, and so no legend.
    let alike = drawn(Starts::Assembly, |_, _| 0.9);
    assert_eq!(names(&alike), vec![vec!["mean of the replicas"]; 3]);
}

#[test]
fn frames_of_an_assembly_without_contacts_are_reweighted() {
    let place = TemporaryFolder::new();
    let ring = std::fs::read_to_string(place.path("ring.json")).unwrap();
    std::fs::write(place.path("far.json"), ring.replace("12", "30")).unwrap();
    is_ok(&place.run(
        "sweep far.json --salt 50mM,300mM --energy direct --replicas 2 --sweeps 60 --equilibration 10 \
         --trajectory-every 10 -q -o run",
    ));
    let output = place.run("reweight run -o curves");
    is_ok(&output);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("no two bodies touch"), "{text}");
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path("curves/reweighting.json")).unwrap())
            .unwrap();
    let point = &json["concentrations"][0]["points"][0];
    assert!(point["contacts_left"].is_null() && point["bound_fraction"]["mean"].is_number());
    let csv = std::fs::read_to_string(place.path("curves/reweighting.csv")).unwrap();
    assert!(!csv.contains("NaN"), "{csv}");
    is_ok(&place.run("report run"));
}
