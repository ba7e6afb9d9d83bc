//! The page of a training.

use crate::html::{definitions, escape, list, paragraph, significant, table};
use crate::page::{Page, Section};
use crate::{data, figures, provenance};
use anyhow::Result;
use protomer_common::page::{Verdict, significant_or_dash};
use protomer_kernel::setting::Choices;
use protomer_learn::bootstrap::Interval;
use protomer_learn::number_scores::NumberScores;
use protomer_learn_verbs::learning::train::{
    Metrics, NumberMetrics, PREDICTED_NUMBERS, Source, TrainSettings,
};
use protomer_results::Record;
use std::path::Path;

/// Number of classes beyond which matrices are only in metrics.json.
const MOST_CLASSES: usize = 40;
/// Number of excluded samples that are listed.
const MOST_NAMED: usize = 20;

/// The page of a directory with these settings.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path, settings: &TrainSettings) -> Result<Page> {
    let metrics = Metrics::read(directory)?;
    let record = Record::read(directory)?;
    let mut sections = Vec::new();
    let curve = data::of_file(directory, "history.csv")?;
    match &metrics {
        None => sections.push(Section::new(
            "Scores",
            paragraph("There are no scores yet: they are written at the end."),
        )),
        Some(metrics) => {
            let mut html = sentence(metrics) + &scores(metrics) + &table_of_baselines(metrics);
            html += &figures::of_file(directory, "learning_curve.svg", "Learning curve", &curve)?;
            let predictions = data::of_file(directory, "predictions.csv")?;
            if let Some(numbers) = &metrics.numbers {
                let title = "Predicted numbers";
                let html = table_of_numbers(numbers)
                    + &figures::of_file(directory, PREDICTED_NUMBERS, title, &predictions)?;
                sections.push(Section::new("Numbers", html));
            }
            html += &predictions;
            sections.push(Section::new("Scores", html));
            sections.push(Section::new("Confusion", confusion(metrics)));
            sections.extend(verdict(metrics));
            if metrics.ablation.is_some() {
                sections.push(Section::new(
                    "Ablation",
                    data::of_file(directory, "ablation.csv")?,
                ));
            }
        }
    }
    sections.push(conditions(settings, metrics.as_ref()));
    let more = vec![("seed", settings.training.seed.to_string())];
    let record = record.as_ref();
    sections.push(provenance::section(
        directory,
        "settings.toml",
        record,
        more,
    )?);
    Ok(Page {
        title: format!("Training: {}", provenance::name(directory)),
        subtitle: format!(
            "A network that sees {}",
            settings.training.channels.join(", ")
        ),
        verdict: metrics.as_ref().and_then(passed),
        problems: problems(metrics.as_ref(), record),
        sections,
    })
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
    // The scores are there before the experiments of a control and the trainings of an ablation.
    let mut problems = Vec::from_iter(provenance::unfinished(record));
    let Some(metrics) = metrics else {
        if problems.is_empty() {
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
fn sentence(metrics: &Metrics) -> String {
    // A control has a verdict of its own, on whether it came out as expected.
    let verdict = metrics.verdict.iter().filter(|_| metrics.control.is_none());
    let verdict = verdict.map(|verdict| format!("Verdict: {verdict}."));
    let absent = metrics.absent_classes();
    let absent = absent.map(|absent| format!("About the test part: {absent}."));
    let sentences = verdict.chain(absent);
    sentences.map(|text| paragraph(&text)).collect()
}

fn scores(metrics: &Metrics) -> String {
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
    definitions(&[
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

fn table_of_baselines(metrics: &Metrics) -> String {
    let head = [
        "",
        "accuracy",
        "balanced accuracy",
        "macro F1",
        "top 3",
        "cross entropy (nats)",
        "gained over the prior (nats)",
    ]
    .map(str::to_owned);
    let mut rows = Vec::new();
    for scores in metrics.score_rows() {
        let mut row = vec![scores.name];
        row.extend(scores.shares.map(|share| significant(share, 4)));
        row.push(significant_or_dash(scores.log_loss_nats, 4));
        row.push(significant_or_dash(scores.gained_nats, 3));
        rows.push(row);
    }
    format!(
        "<h3>Compared with predictions without voxels</h3>\n{}",
        table(&head, &rows)
    )
}

fn table_of_numbers(numbers: &NumberMetrics) -> String {
    let mut head = vec![String::new()];
    head.extend(NumberMetrics::HEADINGS.map(str::to_owned));
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
    table(&head, &rows) + &definitions(&defined)
}

/// The confusion matrix. Rows are true classes, columns predicted ones; the shade is the share of
/// the row.
fn confusion(metrics: &Metrics) -> String {
    if metrics.classes.len() > MOST_CLASSES {
        return paragraph(&format!(
            "{} classes; the matrix is in metrics.json.",
            metrics.classes.len()
        ));
    }
    let head: String = metrics
        .classes
        .iter()
        .map(|class| format!("<th>{}</th>", escape(class)))
        .collect();
    let rows = metrics
        .classes
        .iter()
        .zip(&metrics.confusion_matrix)
        .map(|(class, row)| {
            let sum: f64 = row.iter().sum();
            let cell = |value: &f64| {
                let share = if sum > 0.0 { value / sum } else { 0.0 };
                format!(
                    "<td style=\"--share:{share:.3}\">{}</td>",
                    significant(*value, 3)
                )
            };
            format!(
                "<tr><th>{}</th>{}</tr>\n",
                escape(class),
                row.iter().map(cell).collect::<String>()
            )
        });
    let note = "Weight of test samples: the true class by row, the predicted one by column.";
    format!(
        "<div class=\"scroll\"><table class=\"heat\">\n<thead><tr><th>true \\ predicted</th>{head}</tr></thead>\n<tbody>\n{}\
         </tbody>\n</table></div>\n{}",
        rows.collect::<String>(),
        paragraph(note)
    )
}

/// The expected outcome of a control, and whether it was met.
fn verdict(metrics: &Metrics) -> Option<Section> {
    let control = metrics.control.as_ref()?;
    let head = [
        "experiment",
        "channels",
        "balanced accuracy",
        "at least",
        "at most",
        "as expected",
    ]
    .map(str::to_owned);
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
        paragraph(&control.shows) + &table(&head, &rows.collect::<Vec<_>>()),
    ))
}

/// The settings, as names and values.
pub fn describe(settings: &TrainSettings) -> Vec<(&'static str, String)> {
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
    let mut left_out = String::new();
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
            left_out = format!(
                "<h3>Left out: {} samples{}</h3>\n{}",
                metrics.quarantined.len(),
                if metrics.quarantined.len() > MOST_NAMED {
                    ", among them"
                } else {
                    ""
                },
                list(&named.collect::<Vec<_>>())
            );
        }
    }
    let cautions = metrics.map(Metrics::cautions).unwrap_or_default();
    let joined = cautions.iter();
    let joined = joined.map(|caution| paragraph(&format!("In this training {caution}.")));
    let joined: String = joined.collect();
    Section::new("Conditions", definitions(&rows) + &joined + &left_out)
}
