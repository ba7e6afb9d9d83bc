//! The verdict of a run on its own results, which a page says before anything else.

/// A question about the results as a whole, and the answer of the run.
///
/// ```
/// use protomer_common::page::Verdict;
/// let good = Verdict::sampled_enough(true, "each error is below 1 %");
/// let unknown = Verdict::equilibrated(None, "the run is short");
/// assert!(good.is_good() && !unknown.is_good());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Question, as in "*Equilibrated*: yes".
    pub question: &'static str,
    /// Answer of the run; `None` if it does not tell.
    pub answer: Option<bool>,
    /// The reason, as a sentence without its full stop.
    pub reason: String,
}

/// Beginnings of reasons that only repeat the answer.
const REPEATED: [&str; 3] = [
    "not equilibrated: ",
    "no equilibrium: ",
    "whether this is an equilibrium is not known: ",
];

impl Verdict {
    /// The verdict on whether the results are those of an equilibrium.
    ///
    /// ```
    /// use protomer_common::page::Verdict;
    /// let verdict = Verdict::equilibrated(Some(false), "not equilibrated: the energy still falls");
    /// assert_eq!(verdict.reason, "the energy still falls");
    /// ```
    pub fn equilibrated(answer: Option<bool>, reason: &str) -> Self {
        let repeated = REPEATED.iter().find_map(|words| reason.strip_prefix(words));
        Self {
            question: "Equilibrated",
            answer,
            reason: repeated.unwrap_or(reason).to_owned(),
        }
    }

    /// The verdict on whether the samples are enough for the errors that are stated.
    ///
    /// ```
    /// use protomer_common::page::Verdict;
    /// let verdict = Verdict::sampled_enough(false, "ten independent samples are too few");
    /// assert!(!verdict.is_good());
    /// assert_eq!((verdict.question, verdict.answer), ("Enough samples", Some(false)));
    /// ```
    pub fn sampled_enough(answer: bool, reason: &str) -> Self {
        Self {
            question: "Enough samples",
            answer: Some(answer),
            reason: reason.to_owned(),
        }
    }

    /// The verdict on whether a control gave what is known beforehand.
    ///
    /// ```
    /// use protomer_common::page::Verdict;
    /// let verdict = Verdict::control_passed(true, "the ideal gas has the pressure ρ kT");
    /// assert!(verdict.is_good());
    /// assert_eq!(verdict.question, "Control passed");
    /// ```
    pub fn control_passed(answer: bool, reason: &str) -> Self {
        Self {
            question: "Control passed",
            answer: Some(answer),
            reason: reason.to_owned(),
        }
    }

    /// Whether the results may be used as they are.
    ///
    /// ```
    /// use protomer_common::page::Verdict;
    /// let undecided = Verdict::equilibrated(None, "the run is too short");
    /// assert!(!undecided.is_good(), "what is not known is not good");
    /// ```
    pub fn is_good(&self) -> bool {
        self.answer == Some(true)
    }
}
