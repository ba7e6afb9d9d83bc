//! Whether a structure file is complete, as far as its text tells.
//!
//! A file that was cut off in the middle reads like one of a smaller protein. Its last line shows a
//! cut within a word. A deposited entry was also cut off if it lacks the mark that ends such
//! entries. Files made by hand or by programs often have no such mark, so nothing is known about
//! them, and there is no warning.

/// Ending of a structure file.
///
/// ```
/// use protomer_body::structure::{Ending, Structure};
/// let atom = "ATOM      1  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C\n";
/// let by_hand = Structure::read("one.pdb", atom.as_bytes())?;
/// let complete = Structure::read("one.pdb", format!("{atom}END\n").as_bytes())?;
/// assert_eq!((by_hand.ending, complete.ending), (Ending::Unknown, Ending::Whole));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Ending {
    /// The file is complete.
    Whole,
    /// The file has no mark of its end, as is common in files made by hand.
    #[default]
    Unknown,
    /// The file was cut off; the text says what shows it and what to do.
    CutOff(String),
}

impl Ending {
    /// The warning for a file that may or may not be complete.
    pub const UNKNOWN: &str = "the file has no mark of its end, so that a cut between two lines \
                               cannot be seen; if it is complete, end it with a line END (PDB, \
                               PQR) or # (mmCIF)";

    /// The ending of a PQR file.
    ///
    /// ```
    /// use protomer_body::structure::Ending;
    /// assert_eq!(Ending::of_pqr("ATOM 1 CA ALA 1 0 0 0 -0.25 1.70\nEND\n"), Ending::Whole);
    /// ```
    pub fn of_pqr(text: &str) -> Self {
        if text.lines().any(|line| line.trim_end() == "END") {
            return Self::Whole;
        }
        // Where columns are free, as lines of different lengths show, a shorter line means nothing.
        let mut lengths = atom_line_lengths(text);
        let lines = lengths.len();
        lengths.dedup();
        let is_fixed = lines > 1 && lengths.len() == 1;
        match cut_in_last_line(text) {
            Some(message) if is_fixed => Self::CutOff(message),
            _ => Self::Unknown,
        }
    }
}

fn is_atom(line: &str) -> bool {
    line.starts_with("ATOM") || line.starts_with("HETATM")
}

/// The text before the last line, and the last line, if the file stops in it.
fn open_line(text: &str) -> Option<(&str, &str)> {
    if text.ends_with(['\n', '\r']) {
        return None;
    }
    Some(text.rsplit_once('\n').unwrap_or(("", text)))
}

/// Lengths of the atom lines before the last line.
fn atom_line_lengths(text: &str) -> Vec<usize> {
    let (before, _) = open_line(text).unwrap_or((text, ""));
    let mut lengths = Vec::new();
    for line in before.lines() {
        if is_atom(line) {
            lengths.push(line.trim_end().len());
        }
    }
    lengths
}

/// The evidence that a file of fixed columns was cut in its last line: the line has no line end,
/// and is shorter than every other atom line or stops in the name of its record. A coordinate may then
/// have lost digits and still be a number.
pub(super) fn cut_in_last_line(text: &str) -> Option<String> {
    /// Columns of the name of a record.
    const NAME: usize = 6;
    let (_, last) = open_line(text)?;
    let last = last.trim_end();
    let where_cut = if is_atom(last) {
        let shortest = atom_line_lengths(text).into_iter().min()?;
        (last.len() < shortest).then_some("an atom line, shorter than all others")
    } else {
        let is_partial = last.len() < NAME && !["", "END", "TER"].contains(&last);
        is_partial.then_some("the name of a record")
    }?;
    Some(format!(
        "the file ends within {where_cut}: it may have been cut off; fetch it again, or, if it is \
         complete, end its last line"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_cut(text: &str) -> bool {
        matches!(Ending::of_pqr(text), Ending::CutOff(_))
    }

    #[test]
    fn only_visible_cuts_are_reported() {
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
        // Made by hand, with free columns.
        assert!(!is_cut(
            "ATOM 1 CA ALA 1 0.00 0.0 0.0 -0.25 1.70\nATOM 2 CB ALA 1 1.5 0 0 0 1.7"
        ));
    }
}
