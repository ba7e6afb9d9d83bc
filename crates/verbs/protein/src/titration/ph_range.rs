//! The values of the pH, read from text.

use anyhow::{Result, bail};
use std::str::FromStr;

/// Lowest pH that is titrated.
const LOWEST_PH: f64 = 0.0;
/// Highest pH that is titrated.
const HIGHEST_PH: f64 = 14.0;
/// pH of the table where the range holds it.
const TABLE_PH: f64 = 7.4;
/// Step of a curve whose number of values is not stated.
const STEP_PH: f64 = 0.25;

/// A single pH, or a range of it: `7`, `2..12` in steps of 0.25, or `2..12/21` for 21 values.
///
/// ```
/// use protomer_protein_verbs::titration::PhRange;
/// let range: PhRange = "2..12/21".parse()?;
/// assert_eq!((range.curve().len(), range.table_ph()), (21, 7.4));
/// let single: PhRange = "4.5".parse()?;
/// assert_eq!(single.table_ph(), 4.5);
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhRange {
    first: f64,
    last: f64,
    values: usize,
    table: f64,
}

impl Default for PhRange {
    /// From 0 to 14, and the table at 7.4.
    fn default() -> Self {
        Self::single(TABLE_PH)
    }
}

impl PhRange {
    /// The table at a pH, and the curve from 0 to 14.
    fn single(table: f64) -> Self {
        Self {
            first: LOWEST_PH,
            last: HIGHEST_PH,
            values: values_between(LOWEST_PH, HIGHEST_PH),
            table,
        }
    }

    /// The pH of the charges in the table.
    pub fn table_ph(&self) -> f64 {
        self.table
    }

    /// The values of the pH of the curve, ascending.
    ///
    /// ```
    /// use protomer_protein_verbs::titration::PhRange;
    /// let range: PhRange = "4..5".parse()?;
    /// assert_eq!(range.curve(), [4.0, 4.25, 4.5, 4.75, 5.0]);
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn curve(&self) -> Vec<f64> {
        let step = (self.last - self.first) / (self.values - 1) as f64;
        let mut values = Vec::with_capacity(self.values);
        for index in 0..self.values {
            values.push(self.first + step * index as f64);
        }
        values
    }
}

fn values_between(first: f64, last: f64) -> usize {
    ((last - first) / STEP_PH).ceil() as usize + 1
}

impl FromStr for PhRange {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let Some((first, remainder)) = text.split_once("..") else {
            return Ok(Self::single(ph(text)?));
        };
        let (last, count) = match remainder.split_once('/') {
            Some((last, count)) => (last, Some(count)),
            None => (remainder, None),
        };
        let (first, last) = (ph(first)?, ph(last)?);
        if last <= first {
            bail!("the range '{text}' does not increase; put the lower pH first, as in 2..12");
        }
        let values = match count {
            None => values_between(first, last),
            Some(count) => match count.trim().parse() {
                Ok(count) if (2..=10_000).contains(&count) => count,
                _ => bail!(
                    "the range '{text}' asks for '{count}' values; give a number from 2 to 10000"
                ),
            },
        };
        let table = if (first..=last).contains(&TABLE_PH) {
            TABLE_PH
        } else {
            first
        };
        Ok(Self {
            first,
            last,
            values,
            table,
        })
    }
}

fn ph(text: &str) -> Result<f64> {
    match text.trim().parse::<f64>() {
        Ok(value) if (LOWEST_PH..=HIGHEST_PH).contains(&value) => Ok(value),
        _ => bail!(
            "'{text}' is no pH; give a number from 0 to 14, such as 7.4, or a range such as 2..12"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_without_a_number_of_values_has_steps_of_a_quarter() {
        let range: PhRange = "2..12".parse().unwrap();
        let curve = range.curve();
        assert_eq!(
            (curve.len(), curve[0], curve[1], curve[40]),
            (41, 2.0, 2.25, 12.0)
        );
        let acid: PhRange = "2..5".parse().unwrap();
        assert_eq!(acid.table_ph(), 2.0);
    }

    #[test]
    fn what_is_no_ph_is_named() {
        for text in ["20", "-1", "seven", "12..2", "2..12/1", "2..15", "nan", ""] {
            let error = text.parse::<PhRange>().unwrap_err().to_string();
            assert!(
                error.contains("give") || error.contains("put"),
                "{text}: {error}"
            );
        }
    }
}
