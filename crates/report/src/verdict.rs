//! The verdict of a run on its own results, which a page says before anything else.

use super::html::escape;

/// A question about the results as a whole, and the answer of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Question, as in "*Equilibrated*: yes".
    question: &'static str,
    /// Answer of the run; `None` if it does not tell.
    answer: Option<bool>,
    /// The reason, as a sentence without its full stop.
    reason: String,
}

/// Beginnings of reasons that only repeat the answer.
const REPEATED: [&str; 2] = [
    "not equilibrated: ",
    "whether this is an equilibrium is not known: ",
];

impl Verdict {
    /// The verdict on whether the results are those of an equilibrium.
    pub fn equilibrated(answer: Option<bool>, reason: &str) -> Self {
        let repeated = REPEATED.iter().find_map(|words| reason.strip_prefix(words));
        Self {
            question: "Equilibrated",
            answer,
            reason: repeated.unwrap_or(reason).to_owned(),
        }
    }

    /// The verdict on whether the samples are enough for the errors that are stated.
    pub fn sampled_enough(answer: bool, reason: &str) -> Self {
        Self {
            question: "Enough samples",
            answer: Some(answer),
            reason: reason.to_owned(),
        }
    }

    /// The verdict on whether a control gave what is known beforehand.
    #[cfg(feature = "learning")]
    pub fn control_passed(answer: bool, reason: &str) -> Self {
        Self {
            question: "Control passed",
            answer: Some(answer),
            reason: reason.to_owned(),
        }
    }

    /// Whether the results may be used as they are.
    pub fn is_good(&self) -> bool {
        self.answer == Some(true)
    }

    /// A paragraph in the colour of the answer.
    pub fn to_html(&self) -> String {
        let (answer, class) = match self.answer {
            Some(true) => ("yes", "good"),
            Some(false) => ("no", "bad"),
            None => ("unknown", "open"),
        };
        let mut letters = self.reason.chars();
        let first = letters.next().map(char::to_uppercase);
        let reason: String = first.into_iter().flatten().chain(letters).collect();
        format!(
            "<p class=\"{class}\"><strong>{}: {answer}.</strong> {}.</p>\n",
            self.question,
            escape(reason.trim_end_matches('.'))
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_comes_first_in_its_colour_and_is_not_repeated() {
        for (answer, reason, html) in [
            (
                Some(false),
                "not equilibrated: at 65 mM <2 pairs touch",
                "<p class=\"bad\"><strong>Equilibrated: no.</strong> At 65 mM &lt;2 pairs touch.</p>\n",
            ),
            (
                None,
                "whether this is an equilibrium is not known: all runs start alike",
                "<p class=\"open\"><strong>Equilibrated: unknown.</strong> All runs start alike.</p>\n",
            ),
            (
                Some(true),
                "runs agree.",
                "<p class=\"good\"><strong>Equilibrated: yes.</strong> Runs agree.</p>\n",
            ),
        ] {
            let verdict = Verdict::equilibrated(answer, reason);
            assert_eq!(verdict.to_html(), html);
            assert_eq!(verdict.is_good(), answer == Some(true));
        }
    }
}
