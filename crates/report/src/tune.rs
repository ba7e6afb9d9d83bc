//! The page of a search for settings.

use super::html::{definitions, escape, folded_text, paragraph, significant, table};
use super::page::{Page, Section};
use super::{data, figures, provenance, training};
use anyhow::{Context, Result};
use protomer::learning::train::TrainSettings;
use protomer::learning::tune::TuneSettings;
use protomer_io::csv::cells;
use std::path::Path;

/// Number of trials shown unfolded.
const MOST_SHOWN: usize = 10;
/// Digits of numbers in the table.
const DIGITS: usize = 4;
/// The settings drawn for each trial.
const DRAWN: [&str; 3] = ["blocks (width × kernel)", "epochs at most", "learning rate"];

/// `trials.csv`, best first.
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
    let mut provenance = provenance::section(
        directory,
        "settings.toml",
        None,
        vec![("seed", settings.seed.to_string())],
    )?;
    if best.is_some() {
        let text = std::fs::read_to_string(directory.join("best.toml")).context("best.toml")?;
        provenance.html += &folded_text("best.toml", &text);
    }
    sections.push(provenance);
    let mut problems = Vec::new();
    if best.is_none() {
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
        let csv = std::fs::read_to_string(&path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        let lines = csv
            .lines()
            .enumerate()
            .map(|(number, line)| cells("trials.csv", number + 1, line));
        let mut rows = lines.collect::<Result<Vec<_>, _>>()?;
        let columns = if rows.is_empty() {
            Vec::new()
        } else {
            rows.remove(0)
        };
        Ok(Some(Self { csv, columns, rows }))
    }

    fn cell(&self, row: usize, column: &str) -> Option<&str> {
        let place = self.columns.iter().position(|name| name == column)?;
        self.rows.get(row)?.get(place).map(String::as_str)
    }

    fn number(&self, row: usize, column: &str) -> Option<f64> {
        self.cell(row, column)?
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
    }

    fn diverged(&self) -> Option<String> {
        let count = (0..self.rows.len())
            .filter(|row| self.number(*row, "validation_loss_nats").is_none())
            .count();
        (count > 0).then(|| format!("{count} of {} trials diverged.", self.rows.len()))
    }

    /// The best ones.
    fn shown(&self) -> String {
        let head = [
            "trial",
            "epochs",
            "validation loss (nats)",
            "balanced accuracy",
            "widths",
            "kernels",
            "groups",
        ];
        let head: Vec<String> = head
            .iter()
            .chain(&["learning rate", "channels"])
            .map(ToString::to_string)
            .collect();
        let row = |row: usize| -> Vec<String> {
            let text = |column: &str| self.cell(row, column).unwrap_or("–").to_owned();
            let number = |column: &str| {
                self.number(row, column)
                    .map_or_else(|| "–".into(), |x| significant(x, DIGITS))
            };
            let loss = self.number(row, "validation_loss_nats");
            vec![
                text("trial"),
                text("epochs"),
                loss.map_or_else(|| "diverged".into(), |loss| significant(loss, DIGITS)),
                number("validation_balanced_accuracy"),
                text("widths"),
                text("kernels"),
                text("groups"),
                number("learning_rate"),
                text("channels").replace('+', ", "),
            ]
        };
        let count = self.rows.len();
        let title = if count > MOST_SHOWN {
            format!("The best {MOST_SHOWN} of {count}")
        } else {
            "Best first".into()
        };
        let rows: Vec<Vec<String>> = (0..count.min(MOST_SHOWN)).map(row).collect();
        format!("<h3>{}</h3>\n{}", escape(&title), table(&head, &rows))
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
        let number = |column: &str| {
            trials
                .number(0, column)
                .map_or_else(|| "–".into(), |x| significant(x, DIGITS))
        };
        rows.push(("trial", trials.cell(0, "trial").unwrap_or("–").to_owned()));
        rows.push((
            "validation loss",
            format!("{} nats", number("validation_loss_nats")),
        ));
        rows.push((
            "balanced accuracy on the validation part",
            number("validation_balanced_accuracy"),
        ));
    }
    let described = training::describe(best);
    rows.extend(
        described
            .into_iter()
            .filter(|(name, _)| DRAWN.contains(name) || *name == "channels"),
    );
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
