//! Scores of the validation part, as `history.csv` has them.

use anyhow::Result;
use protomer_io::csv::cells;
use std::path::Path;

/// File with a row for each epoch.
pub(super) const HISTORY: &str = "history.csv";

/// Scores of the validation part at one epoch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Validation {
    /// Loss, nats.
    pub loss_nats: Option<f64>,
    /// Balanced accuracy.
    pub balanced_accuracy: Option<f64>,
}

impl Validation {
    /// Scores at an epoch, counted from 1, of the training in a directory; none without the file or the row.
    ///
    /// # Errors
    /// If the file cannot be read or is no table.
    pub fn read(directory: &Path, epoch: usize) -> Result<Self> {
        let path = directory.join(HISTORY);
        if !path.exists() {
            return Ok(Self::default());
        }
        let text = protomer_io::input::read_to_string(&path)?;
        let file = path.display().to_string();
        let mut lines = text.lines().enumerate();
        let heading = match lines.next() {
            Some((number, line)) => cells(&file, number, line)?,
            None => return Ok(Self::default()),
        };
        let place = |name: &str| heading.iter().position(|column| column == name);
        for (number, line) in lines {
            let row = cells(&file, number, line)?;
            let value = |name: &str| row.get(place(name)?)?.parse::<f64>().ok();
            if value("epoch") == Some(epoch as f64) {
                return Ok(Self {
                    loss_nats: value("validation_loss_nats"),
                    balanced_accuracy: value("validation_balanced_accuracy"),
                });
            }
        }
        Ok(Self::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_row_of_the_epoch_is_read_by_its_headings() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(
            Validation::read(folder.path(), 1).unwrap(),
            Validation::default()
        );
        let text = "epoch,training_loss_nats,validation_loss_nats,validation_balanced_accuracy\n1,0.7,0.6,0.5\n2,0.5,0.4,\n";
        std::fs::write(folder.path().join(HISTORY), text).unwrap();
        let second = Validation {
            loss_nats: Some(0.4),
            balanced_accuracy: None,
        };
        assert_eq!(Validation::read(folder.path(), 2).unwrap(), second);
        assert_eq!(
            Validation::read(folder.path(), 3).unwrap(),
            Validation::default()
        );
    }
}
