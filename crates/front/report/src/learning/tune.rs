//! The page of a search for settings.

use super::training;
use crate::html::{definitions, escape, folded_text, paragraph, significant, table};
use crate::page::{Page, Section};
use crate::{data, figures, provenance};
use anyhow::{Context, Result};
use protomer_common::page::significant_or_dash;
use protomer_io::csv::cells;
use protomer_learn_verbs::learning::train::TrainSettings;
use protomer_learn_verbs::learning::tune::TuneSettings;
use protomer_results::Record;
use std::path::Path;

/// Number of trials shown unfolded.
const MOST_SHOWN: usize = 10;
/// Number of digits in the table.
const DIGITS: usize = 4;
/// The settings drawn for each trial.
const DRAWN: [&str; 3] = ["blocks (width × kernel)", "epochs at most", "learning rate"];

/// Rows of `trials.csv`, the best first.
struct Trials {
    csv: String,
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// The page of a directory with these settings.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path, settings: &TuneSettings) -> Result<Page> {
    let trials = Trials::read(directory)?;
    let best = Some(directory.join("best.toml")).filter(|path| path.is_file());
    let best = best.map(|path| TrainSettings::read(&path)).transpose()?;
    let mut sections = vec![best_settings(best.as_ref(), trials.as_ref())];
    let mut html = figures::of_file(
        directory,
        "trials.svg",
        "Validation loss against learning rate",
        "",
    )?;
    html += &match &trials {
        Some(trials) => trials.shown() + &data::data("trials.csv", &trials.csv)?,
        None => paragraph(
            "There is no table yet: it is written when the first round of epochs is over.",
        ),
    };
    sections.push(Section::new("Trials", html));
    sections.push(conditions(settings)?);
    let record = Record::read(directory)?;
    let mut provenance = provenance::section(
        directory,
        "settings.toml",
        record.as_ref(),
        vec![("seed", settings.seed.to_string())],
    )?;
    if best.is_some() {
        let text =
            protomer_io::input::read_to_string(directory.join("best.toml")).context("best.toml")?;
        provenance.html += &folded_text("best.toml", &text);
    }
    sections.push(provenance);
    let mut problems = Vec::from_iter(provenance::unfinished(record.as_ref()));
    if best.is_none() && problems.is_empty() {
        problems.push("The search is not finished; the same command continues it.".into());
    }
    problems.extend(trials.as_ref().and_then(Trials::diverged));
    Ok(Page {
        title: format!("Search: {}", provenance::name(directory)),
        subtitle: format!(
            "{} networks that see {}",
            settings.trials,
            settings.base.training.channels.join(", ")
        ),
        verdict: None,
        problems,
        sections,
    })
}

impl Trials {
    fn read(directory: &Path) -> Result<Option<Self>> {
        let path = directory.join("trials.csv");
        if !path.is_file() {
            return Ok(None);
        }
        let csv = protomer_io::input::read_to_string(&path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        let (mut columns, mut rows) = (Vec::new(), Vec::new());
        for (number, line) in csv.lines().enumerate() {
            let cells = cells("trials.csv", number + 1, line)?;
            match number {
                0 => columns = cells,
                _ => rows.push(cells),
            }
        }
        Ok(Some(Self { csv, columns, rows }))
    }

    fn cell(&self, row: usize, column: &str) -> Option<&str> {
        let place = self.columns.iter().position(|name| name == column)?;
        self.rows.get(row)?.get(place).map(String::as_str)
    }

    fn number(&self, row: usize, column: &str) -> Option<f64> {
        let value: f64 = self.cell(row, column)?.parse().ok()?;
        value.is_finite().then_some(value)
    }

    /// The text of a cell, or a dash.
    fn text(&self, row: usize, column: &str) -> String {
        self.cell(row, column).unwrap_or("–").to_owned()
    }

    /// The number in a cell, rounded, or a dash.
    fn rounded(&self, row: usize, column: &str) -> String {
        significant_or_dash(self.number(row, column), DIGITS)
    }

    /// The cells of a trial on the page.
    fn cells(&self, row: usize) -> Vec<String> {
        let loss = match self.number(row, "validation_loss_nats") {
            Some(loss) => significant(loss, DIGITS),
            None => "diverged".into(),
        };
        vec![
            self.text(row, "trial"),
            self.text(row, "epochs"),
            loss,
            self.rounded(row, "validation_balanced_accuracy"),
            self.text(row, "widths"),
            self.text(row, "kernels"),
            self.text(row, "groups"),
            self.rounded(row, "learning_rate"),
            self.text(row, "channels").replace('+', ", "),
        ]
    }

    fn diverged(&self) -> Option<String> {
        let trials = self.rows.len();
        let mut count = 0;
        for row in 0..trials {
            count += usize::from(self.number(row, "validation_loss_nats").is_none());
        }
        match count {
            0 => None,
            _ => Some(format!("{count} of {trials} trials diverged.")),
        }
    }

    /// A table of the best trials.
    fn shown(&self) -> String {
        let head = [
            "trial",
            "epochs",
            "validation loss (nats)",
            "balanced accuracy",
            "widths",
            "kernels",
            "groups",
            "learning rate",
            "channels",
        ];
        let count = self.rows.len();
        let title = if count > MOST_SHOWN {
            format!("The best {MOST_SHOWN} of {count}")
        } else {
            "Best first".into()
        };
        let mut rows = Vec::new();
        for row in 0..count.min(MOST_SHOWN) {
            rows.push(self.cells(row));
        }
        let table = table(&head.map(str::to_owned), &rows);
        format!("<h3>{}</h3>\n{table}", escape(&title))
    }
}

fn best_settings(best: Option<&TrainSettings>, trials: Option<&Trials>) -> Section {
    let Some(best) = best else {
        return Section::new(
            "Best settings",
            paragraph("They are written when the search is finished."),
        );
    };
    let mut rows = Vec::new();
    if let Some(trials) = trials {
        let loss = trials.rounded(0, "validation_loss_nats");
        let accuracy = trials.rounded(0, "validation_balanced_accuracy");
        rows.push(("trial", trials.text(0, "trial")));
        rows.push(("validation loss", format!("{loss} nats")));
        rows.push(("balanced accuracy on the validation part", accuracy));
    }
    for (name, value) in training::describe(best) {
        if DRAWN.contains(&name) || name == "channels" {
            rows.push((name, value));
        }
    }
    let note = "The best trial was chosen on the validation part, so its scores there are biased. For scores on the test part: \
                protomer train SET --config best.toml -o DIRECTORY.";
    Section::new("Best settings", definitions(&rows) + &paragraph(note))
}

fn conditions(settings: &TuneSettings) -> Result<Section> {
    let rungs = settings.halving()?.rungs();
    let rounds: Vec<String> = rungs.iter().map(usize::to_string).collect();
    let mut rows = vec![
        ("trials", settings.trials.to_string()),
        (
            "rounds",
            format!(
                "after {} epochs; a third of the trials continues each time",
                rounds.join(", ")
            ),
        ),
        ("drawn for each trial", {
            let channels = if settings.vary_channels {
                ", channels"
            } else {
                ""
            };
            format!("number, widths and kernels of blocks, normalisation, learning rate{channels}")
        }),
    ];
    let differs =
        |name: &str| DRAWN.contains(&name) || (settings.vary_channels && name == "channels");
    rows.extend(
        training::describe(&settings.base)
            .into_iter()
            .filter(|(name, _)| !differs(name)),
    );
    Ok(Section::new("Conditions", definitions(&rows)))
}
