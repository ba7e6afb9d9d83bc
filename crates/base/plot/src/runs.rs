//! Texts in parts: subscripts and superscripts.

/// Level of a part of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Level {
    Base,
    Subscript,
    Superscript,
}

impl Level {
    /// Size and height above the baseline, in terms of the base text.
    pub fn scale_and_raise(self) -> (f64, f64) {
        match self {
            Level::Base => (1.0, 0.0),
            Level::Subscript => (0.72, -0.2),
            Level::Superscript => (0.72, 0.36),
        }
    }
}

/// A part of a text that is drawn in one go.
pub(crate) struct Run {
    pub text: String,
    pub level: Level,
}

/// A name from elsewhere, such as that of a file, as a label: `_` and `^` in it are drawn as they are.
///
/// ```
/// assert_eq!(protomer_plot::literal("salt_0.1"), r"salt\_0.1");
/// ```
pub fn literal(name: &str) -> String {
    let mut label = String::with_capacity(name.len());
    for character in name.chars() {
        if matches!(character, '_' | '^' | '\\') {
            label.push('\\');
        }
        label.push(character);
    }
    label
}

/// Splits a text such as `R_g` or `10^{-3}` into runs: `_` and `^` lower and raise the next
/// character or the next group in braces. A character after a backslash stands for itself.
pub(crate) fn runs(text: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = vec![Run {
        text: String::new(),
        level: Level::Base,
    }];
    let mut characters = text.chars().peekable();
    while let Some(character) = characters.next() {
        let level = match character {
            '_' => Level::Subscript,
            '^' => Level::Superscript,
            other => {
                let other = match other {
                    // A backslash at the end stands for itself.
                    '\\' => characters.next().unwrap_or(other),
                    _ => other,
                };
                // Base text after a subscript begins a run of its own; else it joins the last.
                match runs.last_mut().filter(|run| run.level == Level::Base) {
                    Some(run) => run.text.push(other),
                    None => runs.push(Run {
                        text: other.into(),
                        level: Level::Base,
                    }),
                }
                continue;
            }
        };
        let text = match characters.next() {
            // Without a closing brace the group reaches to the end.
            Some('{') => characters.by_ref().take_while(|c| *c != '}').collect(),
            Some(single) => single.into(),
            // A sign with nothing after it is a sign.
            None => character.into(),
        };
        runs.push(Run { text, level });
    }
    runs.retain(|run| !run.text.is_empty());
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn subscripts_and_superscripts_are_found() {
        let found = |text: &str| {
            runs(text)
                .into_iter()
                .map(|run| (run.text, run.level))
                .collect::<Vec<_>>()
        };
        assert_eq!(
            found("R_g / Å"),
            [
                ("R".into(), Level::Base),
                ("g".into(), Level::Subscript),
                (" / Å".into(), Level::Base)
            ]
        );
        assert_eq!(
            found("10^{−3}"),
            [
                ("10".into(), Level::Base),
                ("−3".into(), Level::Superscript)
            ]
        );
        assert_eq!(found("plain"), [("plain".into(), Level::Base)]);
        assert_eq!(
            found(&literal(r"a_b^c\")),
            [(r"a_b^c\".into(), Level::Base)]
        );
        assert_eq!(found("_{}^"), [("^".into(), Level::Superscript)]);
        assert!(found("").is_empty());
    }
}
