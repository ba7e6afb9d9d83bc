//! The page of a training.

use super::{Metrics, NumberMetrics, PREDICTED_NUMBERS, Source, TrainSettings};
use anyhow::Result;
use protomer_common::page::{
    Contents, Part, Section, SettingsText, Verdict, significant, significant_or_dash,
};
use protomer_kernel::setting::Choices;
use protomer_learn::bootstrap::Interval;
use protomer_learn::number_scores::NumberScores;
use protomer_results::{Exit, Record, keys::read_toml};
use std::path::Path;

/// Number of classes beyond which matrices are only in metrics.json.
const MOST_CLASSES: usize = 40;
/// Number of excluded samples that are listed.
const MOST_NAMED: usize = 20;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let settings: TrainSettings = read_toml(&directory.join("settings.toml"))?;
    let metrics = Metrics::read(directory)?;
    let mut contents = Contents::new("Training");
    contents.subtitle = format!(
        "A network that sees {}",
        settings.training.channels.join(", ")
    );
    contents.verdict = metrics.as_ref().and_then(passed);
    contents.problems = problems(metrics.as_ref(), record);
    contents.origin.settings = SettingsText::File("settings.toml");
    contents.origin.more = vec![("seed", settings.training.seed.to_string())];
    match &metrics {
        None => {
            let text = "There are no scores yet: they are written at the end.";
            contents.add(Section::new("Scores", vec![Part::Paragraph(text.into())]));
        }
        Some(metrics) => add_scores(metrics, &mut contents),
    }
    contents.add(conditions(&settings, metrics.as_ref()));
    Ok(contents)
}

fn add_scores(metrics: &Metrics, contents: &mut Contents) {
    let predictions = "predictions.csv";
    if let Some(numbers) = &metrics.numbers {
        let mut parts = tables_of_numbers(numbers);
        parts.push(Part::picture(
            PREDICTED_NUMBERS,
            "Predicted numbers",
            Some(predictions),
        ));
        contents.add(Section::new("Numbers", parts));
    }
    let mut parts = sentences(metrics);
    parts.push(scores(metrics));
    parts.push(Part::Heading(
        "Compared with predictions without voxels".into(),
    ));
    parts.push(table_of_baselines(metrics));
    let history = Some("history.csv");
    parts.push(Part::picture(
        "learning_curve.svg",
        "Learning curve",
        history,
    ));
    parts.push(Part::file(predictions));
    contents.add(Section::new("Scores", parts));
    contents.add(Section::new("Confusion", confusion(metrics)));
    if let Some(control) = control(metrics) {
        contents.add(control);
    }
    if metrics.ablation.is_some() {
        let table = vec![Part::file("ablation.csv")];
        contents.add(Section::new("Ablation", table));
    }
}

/// Whether a control gave what is known beforehand; `None` for other trainings.
fn passed(metrics: &Metrics) -> Option<Verdict> {
    let control = metrics.control.as_ref()?;
    let expected = control.experiments.iter().filter(|one| one.reached).count();
    let reason = format!(
        "{expected} of {} experiments came out as expected",
        control.experiments.len()
    );
    Some(Verdict::control_passed(control.reached, &reason))
}

fn problems(metrics: Option<&Metrics>, record: Option<&Record>) -> Vec<String> {
    // The page itself says how an unfinished run ended. The scores are there before the experiments of a control and
    // the trainings of an ablation.
    let mut problems = Vec::new();
    let Some(metrics) = metrics else {
        if record.is_some_and(|record| record.exit == Exit::Done) {
            problems.push("The training is not finished; the same command continues it.".into());
        }
        return problems;
    };
    if !metrics.quarantined.is_empty() {
        problems.push(format!(
            "{} samples were left out (see Conditions).",
            metrics.quarantined.len()
        ));
    }
    let control = metrics
        .control
        .iter()
        .flat_map(|control| &control.experiments)
        .filter(|one| !one.reached);
    problems.extend(control.map(|one| {
        format!(
            "The control's experiment '{}' did not come out as expected.",
            one.name
        )
    }));
    problems
}

/// The comparison with the best baseline, and the classes that the test part lacks.
fn sentences(metrics: &Metrics) -> Vec<Part> {
    // A control has a verdict of its own, on whether it came out as expected.
    let verdict = metrics.verdict.iter().filter(|_| metrics.control.is_none());
    let verdict = verdict.map(|verdict| format!("Verdict: {verdict}."));
    let absent = metrics.absent_classes();
    let absent = absent.map(|absent| format!("About the test part: {absent}."));
    verdict.chain(absent).map(Part::Paragraph).collect()
}

fn scores(metrics: &Metrics) -> Part {
    let interval = |interval: &Interval| {
        format!(
            "95 %: {} to {}",
            significant(interval.low, 3),
            significant(interval.high, 3)
        )
    };
    let rounded = |value: f64| significant(value, 4);
    let calibration = metrics.calibration();
    let calibration = calibration.map(|(name, value)| (name, rounded(value)));
    Part::Values(vec![
        (
            "balanced accuracy",
            format!(
                "{} ({})",
                rounded(metrics.balanced_accuracy),
                interval(&metrics.bootstrap_95.balanced_accuracy)
            ),
        ),
        (
            "accuracy",
            format!(
                "{} ({}); always predicting the most frequent class gives {}",
                rounded(metrics.accuracy),
                interval(&metrics.bootstrap_95.accuracy),
                rounded(metrics.majority_accuracy)
            ),
        ),
        (
            "nats gained over the prior",
            format!(
                "{} ({})",
                rounded(metrics.nats_gained_over_prior),
                interval(&metrics.bootstrap_95.nats_gained_over_prior)
            ),
        ),
        ("permutation test", metrics.permutation_test()),
        (
            "Matthews' correlation",
            rounded(metrics.matthews_correlation),
        ),
        calibration[0].clone(),
        calibration[1].clone(),
        calibration[2].clone(),
        (
            "epochs",
            format!(
                "{}, of which {} was kept",
                metrics.epochs, metrics.best_epoch
            ),
        ),
    ])
}

fn table_of_baselines(metrics: &Metrics) -> Part {
    let columns = vec![
        "",
        "accuracy",
        "balanced accuracy",
        "macro F1",
        "top 3",
        "cross entropy (nats)",
        "gained over the prior (nats)",
    ];
    let mut rows = Vec::new();
    for scores in metrics.score_rows() {
        let mut row = vec![scores.name];
        row.extend(scores.shares.map(|share| significant(share, 4)));
        row.push(significant_or_dash(scores.log_loss_nats, 4));
        row.push(significant_or_dash(scores.gained_nats, 3));
        rows.push(row);
    }
    Part::Table { columns, rows }
}

fn tables_of_numbers(numbers: &NumberMetrics) -> Vec<Part> {
    let mut columns = vec![""];
    columns.extend(NumberMetrics::HEADINGS);
    let row = |name: &str, scores: &NumberScores| {
        let values = [
            scores.rms_error,
            scores.mean_absolute_error,
            scores.variance_explained,
            scores.rank_correlation,
        ];
        let mut row = vec![name.to_owned()];
        row.extend(values.map(|value| significant(value, 4)));
        row
    };
    let mut rows = vec![row("this network", &numbers.scores)];
    for (name, scores) in numbers.of_baselines() {
        rows.push(row(&name, scores));
    }
    let range = |interval: &Interval| {
        let ends = [interval.low, interval.high].map(|end| significant(end, 3));
        format!("95 %: {} to {}", ends[0], ends[1])
    };
    let intervals = &numbers.bootstrap_95;
    let mut defined = vec![
        ("rms error", range(&intervals.rms_error)),
        ("variance explained", range(&intervals.variance_explained)),
        ("rank correlation", range(&intervals.rank_correlation)),
    ];
    if let Some(spread) = &numbers.spread {
        let rounded = |value: f64| significant(value, 3);
        defined.push((
            "predicted spread",
            format!(
                "{} on average; {} of the numbers within it (0.683 if honest), {} within twice (0.954)",
                rounded(spread.mean_spread),
                rounded(spread.within_one),
                rounded(spread.within_two)
            ),
        ));
    }
    vec![Part::Table { columns, rows }, Part::Values(defined)]
}

/// The confusion matrix. Rows are true classes, columns predicted ones.
fn confusion(metrics: &Metrics) -> Vec<Part> {
    let count = metrics.classes.len();
    if count > MOST_CLASSES {
        let text = format!("{count} classes; the matrix is in metrics.json.");
        return vec![Part::Paragraph(text)];
    }
    let note = "Weight of test samples: the true class by row, the predicted one by column.";
    vec![
        Part::Shares {
            corner: "true \\ predicted",
            names: metrics.classes.clone(),
            rows: metrics.confusion_matrix.clone(),
        },
        Part::Paragraph(note.into()),
    ]
}

/// The expected outcome of a control, and whether it was met.
fn control(metrics: &Metrics) -> Option<Section> {
    let control = metrics.control.as_ref()?;
    let columns = vec![
        "experiment",
        "channels",
        "balanced accuracy",
        "at least",
        "at most",
        "as expected",
    ];
    let rows = control.experiments.iter().map(|one| {
        vec![
            one.name.clone(),
            one.channels.join(", "),
            significant(one.balanced_accuracy, 4),
            significant(one.at_least, 4),
            significant(one.at_most, 4),
            if one.reached { "yes" } else { "no" }.to_owned(),
        ]
    });
    Some(Section::new(
        "Control",
        vec![
            Part::Paragraph(control.shows.clone()),
            Part::Table {
                columns,
                rows: rows.collect(),
            },
        ],
    ))
}

/// The settings, as names and values.
pub(in crate::learning) fn describe(settings: &TrainSettings) -> Vec<(&'static str, String)> {
    let source = match &settings.source {
        Source::Set { path, digest } => {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            format!("the set {name} (digest {digest})")
        }
        Source::Control {
            name,
            samples,
            size,
            seed,
            ..
        } => {
            format!(
                "the control {}: {samples} samples of {size}³ voxels, seed {seed}",
                name.name()
            )
        }
    };
    let labels = match &settings.labels {
        None => "those of the set".to_owned(),
        Some(table) => {
            let name = table.path.file_name().unwrap_or_default().to_string_lossy();
            format!(
                "the column {} of {name} (SHA-256 {})",
                table.column, table.sha256
            )
        }
    };
    vec![
        ("samples", source),
        ("labels", labels),
        ("target", format!("{:?}", settings.target).to_lowercase()),
        ("loss", settings.training.loss.name().to_owned()),
        ("channels", settings.training.channels.join(", ")),
        (
            "split by",
            format!("{:?}", settings.split_by).to_lowercase(),
        ),
        ("blocks (width × kernel)", {
            let blocks = settings
                .blocks
                .iter()
                .map(|block| format!("{} × {}³", block.width, block.kernel));
            blocks.collect::<Vec<_>>().join(", ")
        }),
        ("epochs at most", settings.training.epochs.to_string()),
        (
            "learning rate",
            significant(settings.training.learning_rate, 6),
        ),
        ("batch", settings.training.batch.to_string()),
    ]
}

fn conditions(settings: &TrainSettings, metrics: Option<&Metrics>) -> Section {
    let mut rows = describe(settings);
    let mut left_out = Vec::new();
    if let Some(metrics) = metrics {
        let parts = &metrics.samples;
        let text = format!(
            "{} training, {} validation, {} test in {} clusters",
            parts.training, parts.validation, parts.test, parts.test_clusters
        );
        rows.push(("parts", text));
        rows.push(("fitted parameters", metrics.parameters.to_string()));
        if !metrics.quarantined.is_empty() {
            let named = metrics
                .quarantined
                .iter()
                .take(MOST_NAMED)
                .map(|one| format!("{}: {}", one.name, one.reason));
            let title = match metrics.quarantined.len() {
                many if many > MOST_NAMED => format!("Left out: {many} samples, among them"),
                few => format!("Left out: {few} samples"),
            };
            left_out = vec![Part::Heading(title), Part::List(named.collect())];
        }
    }
    let cautions = metrics.map(Metrics::cautions).unwrap_or_default();
    let mut parts = vec![Part::Values(rows)];
    for caution in cautions {
        parts.push(Part::Paragraph(format!("In this training {caution}.")));
    }
    parts.extend(left_out);
    Section::new("Conditions", parts)
}
