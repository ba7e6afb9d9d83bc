//! Ranges of residues by chain and number.

use super::report::{SelectionReport, reason};
use super::selected::SelectedResidue;
use crate::{BodyError, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Residues of a chain from one number to another, both included. Written `A:5-120`, `A:5-` without an end, or
/// `A:45` for one residue.
///
/// ```
/// use protomer_body::structure::ResidueRange;
/// let range: ResidueRange = "A:5-120".parse()?;
/// assert!(range.holds(120) && !range.holds(4));
/// assert_eq!(range.to_string(), "A:5-120");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ResidueRange {
    /// Chain identifier (author's).
    pub chain: String,
    /// First number.
    pub first: i32,
    /// Last number; `None` for the end of the chain.
    pub last: Option<i32>,
}

impl ResidueRange {
    /// Whether a residue number of the chain is in the range.
    ///
    /// ```
    /// use protomer_body::structure::ResidueRange;
    /// let to_the_end: ResidueRange = "A:5-".parse()?;
    /// assert!(to_the_end.holds(1000) && !to_the_end.holds(4));
    /// let below_zero: ResidueRange = "A:-3-2".parse()?;
    /// assert!(below_zero.holds(-3) && !below_zero.holds(3));
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn holds(&self, number: i32) -> bool {
        number >= self.first && self.last.is_none_or(|last| number <= last)
    }
}

impl FromStr for ResidueRange {
    type Err = BodyError;

    fn from_str(text: &str) -> Result<Self> {
        let invalid = || BodyError::Invalid {
            cause: format!("`{text}` is no range of residues"),
            remedy: "give a chain and numbers, such as A:5-120, A:5- or A:45".into(),
        };
        let (chain, numbers) = text.trim().split_once(':').ok_or_else(invalid)?;
        if chain.is_empty() || numbers.is_empty() {
            return Err(invalid());
        }
        let number = |text: &str| text.parse::<i32>().map_err(|_| invalid());
        // The sign of a first number is no dash: the search begins behind it.
        let dash = numbers
            .char_indices()
            .skip(1)
            .find(|(_, letter)| *letter == '-');
        let (first, last) = match dash {
            Some((place, _)) => {
                let last = match &numbers[place + 1..] {
                    "" => None,
                    last => Some(number(last)?),
                };
                (number(&numbers[..place])?, last)
            }
            None => (number(numbers)?, Some(number(numbers)?)),
        };
        if last.is_some_and(|last| first > last) {
            return Err(invalid());
        }
        Ok(Self {
            chain: chain.into(),
            first,
            last,
        })
    }
}

impl fmt::Display for ResidueRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.chain, self.first)?;
        match self.last {
            Some(last) if last == self.first => Ok(()),
            Some(last) => write!(f, "-{last}"),
            None => write!(f, "-"),
        }
    }
}

impl TryFrom<String> for ResidueRange {
    type Error = BodyError;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<ResidueRange> for String {
    fn from(range: ResidueRange) -> Self {
        range.to_string()
    }
}

/// Leaves out the residues of the chains that the ranges name which are in none of them. Other chains stay
/// whole.
///
/// # Errors
/// [`BodyError::Invalid`] for a range without residues.
pub(super) fn keep_ranges(
    residues: Vec<SelectedResidue>,
    ranges: &[ResidueRange],
    report: &mut SelectionReport,
) -> Result<Vec<SelectedResidue>> {
    for range in ranges {
        let mut keys = residues.iter().map(|residue| &residue.key);
        if !keys.any(|key| *key.chain == *range.chain && range.holds(key.number)) {
            return Err(BodyError::Invalid {
                cause: format!("no residue of {range} in the selection"),
                remedy: "give a range of a chain that the file has, such as A:5-120".into(),
            });
        }
    }
    let mut kept = Vec::with_capacity(residues.len());
    for residue in residues {
        let key = &residue.key;
        let mut of_chain = ranges
            .iter()
            .filter(|range| *range.chain == *key.chain)
            .peekable();
        if of_chain.peek().is_none() || of_chain.any(|range| range.holds(key.number)) {
            kept.push(residue);
        } else {
            report.skip(reason::RANGE, residue.atoms.len());
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_read_back_as_they_are_written() {
        for text in ["A:5-120", "A:45", "B:5-", "C:-3-7", "AA:-9"] {
            let range: ResidueRange = text.parse().unwrap();
            assert_eq!(range.to_string(), text);
        }
        let negative: ResidueRange = "C:-3-7".parse().unwrap();
        assert_eq!((negative.first, negative.last), (-3, Some(7)));
        let from_negative: ResidueRange = "C:-5--2".parse().unwrap();
        assert_eq!((from_negative.first, from_negative.last), (-5, Some(-2)));
        for text in ["A", "A:", ":5", "A:x", "A:7-5", "A:5-x"] {
            assert!(text.parse::<ResidueRange>().is_err(), "{text}");
        }
    }
}
