//! Whether a structure file is whole, as far as its text tells.
//!
//! A file that was cut off in the middle reads like one of a smaller protein. Its last line tells
//! where it ended in a word; a deposited entry that lacks the mark with which such entries end was
//! cut as well. Files made by hand or by programs often have no such mark: of those nothing can be
//! known, and nothing is held against them.

/// How a structure file ends.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Ending {
    /// As whole files do.
    Whole,
    /// Without a mark of its end, as files by hand have none.
    #[default]
    Unknown,
    /// In the middle: what shows it, and what to do.
    CutOff(String),
}

impl Ending {
    /// What a careful user should know of a file of which nothing can be known.
    pub const UNKNOWN: &str = "the file has no mark of its end, so that a cut between two lines cannot be seen; if it is \
                               whole, end it so: with a line END (PDB, PQR) or # (mmCIF)";

    /// The ending of a PQR file.
    pub fn of_pqr(text: &str) -> Self {
        if text.lines().any(|line| line.trim_end() == "END") {
            return Self::Whole;
        }
        // Where columns are free, as lines of different lengths show, a shorter line means nothing.
        let lengths = lengths(text);
        let is_fixed =
            lengths.len() > 1 && lengths.iter().all(|length| Some(length) == lengths.first());
        let cut = cut_in_last_line(text).filter(|_| is_fixed);
        cut.map_or(Self::Unknown, Self::CutOff)
    }
}

fn is_atom(line: &str) -> bool {
    line.starts_with("ATOM") || line.starts_with("HETATM")
}

/// What is before the last line, and the last line, if the file stops in it.
fn open_line(text: &str) -> Option<(&str, &str)> {
    let is_open = !text.ends_with(['\n', '\r']);
    is_open.then(|| text.rsplit_once('\n').unwrap_or(("", text)))
}

/// Lengths of the atom lines before the last line.
fn lengths(text: &str) -> Vec<usize> {
    let before = open_line(text).map_or(text, |(before, _)| before);
    before
        .lines()
        .filter(|line| is_atom(line))
        .map(|line| line.trim_end().len())
        .collect()
}

/// What shows that a file of fixed columns was cut in its last line: the line has no end, and is
/// shorter than every other atom line, or stops in the name of its record. A coordinate may then
/// have lost digits and still be a number.
pub(super) fn cut_in_last_line(text: &str) -> Option<String> {
    /// Columns of the name of a record.
    const NAME: usize = 6;
    let (_, last) = open_line(text)?;
    let last = last.trim_end();
    let remedy = "fetch it again, or, if it is whole, end its last line";
    if is_atom(last) {
        let cut = last.len() < lengths(text).into_iter().min()?;
        return cut.then(|| {
            format!("the file ends within an atom line, shorter than all others: it may have been cut off; {remedy}")
        });
    }
    let cut = last.len() < NAME && !["", "END", "TER"].contains(&last);
    cut.then(|| {
        format!("the file ends within the name of a record: it may have been cut off; {remedy}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_cut(text: &str) -> bool {
        matches!(Ending::of_pqr(text), Ending::CutOff(_))
    }

    #[test]
    fn only_what_shows_a_cut_is_held_against_a_file() {
        let line = "ATOM      1 CA   ALA A     1     0.00000     1.00000    -2.00000 -0.25000000  1.7000\n";
        let whole = line.repeat(3);
        assert_eq!(Ending::of_pqr(&format!("{whole}END\n")), Ending::Whole);
        assert_eq!(Ending::of_pqr(&whole), Ending::Unknown);
        // Without the last line's end, and cut between two lines.
        assert_eq!(Ending::of_pqr(whole.trim_end()), Ending::Unknown);
        assert_eq!(Ending::of_pqr(&line.repeat(2)), Ending::Unknown);
        let last = 2 * line.len();
        for cut in [1, 3, 4, 6, 30, line.len() - 2] {
            assert!(is_cut(&whole[..last + cut]), "{cut}");
        }
        assert!(is_cut(&format!("{whole}EN")) && !is_cut(&format!("{whole}TER")));
        // By hand, with columns as they come.
        assert!(!is_cut(
            "ATOM 1 CA ALA 1 0.00 0.0 0.0 -0.25 1.70\nATOM 2 CB ALA 1 1.5 0 0 0 1.7"
        ));
    }
}
