//! The page of a search for settings.

use super::{BEST, FIGURE, TuneSettings};
use crate::learning::train::{TrainSettings, page::describe};
use anyhow::{Context, Result};
use protomer_common::page::{
    Contents, Data, Part, Section, SettingsText, significant, significant_or_dash,
};
use protomer_io::csv::cells;
use protomer_results::{Exit, Record, keys::read_toml};
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

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let settings: TuneSettings = read_toml(&directory.join("settings.toml"))?;
    let trials = Trials::read(directory)?;
    let best = Some(directory.join(BEST)).filter(|path| path.is_file());
    let best = best.map(|path| TrainSettings::read(&path)).transpose()?;
    let mut contents = Contents::new("Search");
    contents.subtitle = format!(
        "{} networks that see {}",
        settings.trials,
        settings.base.training.channels.join(", ")
    );
    // The page itself says how an unfinished search ended.
    if best.is_none() && record.is_some_and(|record| record.exit == Exit::Done) {
        let text = "The search is not finished; the same command continues it.";
        contents.problems.push(text.into());
    }
    contents
        .problems
        .extend(trials.as_ref().and_then(Trials::diverged));
    contents.origin.settings = SettingsText::File("settings.toml");
    contents.origin.more = vec![("seed", settings.seed.to_string())];
    let mut parts = best_settings(best.as_ref(), trials.as_ref());
    if best.is_some() {
        let text = protomer_io::input::read_to_string(directory.join(BEST)).context(BEST)?;
        parts.push(Part::Text { name: BEST, text });
    }
    contents.add(Section::new("Best settings", parts));
    let title = "Validation loss against learning rate";
    let mut parts = vec![Part::picture(FIGURE, title, None)];
    match trials {
        Some(trials) => {
            parts.extend(trials.shown());
            parts.push(Part::Data(Data::Table {
                name: "trials.csv".into(),
                csv: trials.csv,
            }));
        }
        None => parts.push(Part::Paragraph(
            "There is no table yet: it is written when the first round of epochs is over.".into(),
        )),
    }
    contents.add(Section::new("Trials", parts));
    contents.add(conditions(&settings)?);
    Ok(contents)
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
    fn shown(&self) -> [Part; 2] {
        let columns = vec![
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
        [Part::Heading(title), Part::Table { columns, rows }]
    }
}

fn best_settings(best: Option<&TrainSettings>, trials: Option<&Trials>) -> Vec<Part> {
    let Some(best) = best else {
        let text = "They are written when the search is finished.";
        return vec![Part::Paragraph(text.into())];
    };
    let mut rows = Vec::new();
    if let Some(trials) = trials {
        let loss = trials.rounded(0, "validation_loss_nats");
        let accuracy = trials.rounded(0, "validation_balanced_accuracy");
        rows.push(("trial", trials.text(0, "trial")));
        rows.push(("validation loss", format!("{loss} nats")));
        rows.push(("balanced accuracy on the validation part", accuracy));
    }
    for (name, value) in describe(best) {
        if DRAWN.contains(&name) || name == "channels" {
            rows.push((name, value));
        }
    }
    let note = "The best trial was chosen on the validation part, so its scores there are biased. For scores on the test part: \
                protomer train SET --config best.toml -o DIRECTORY.";
    vec![Part::Values(rows), Part::Paragraph(note.into())]
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
        describe(&settings.base)
            .into_iter()
            .filter(|(name, _)| !differs(name)),
    );
    Ok(Section::new("Conditions", vec![Part::Values(rows)]))
}
