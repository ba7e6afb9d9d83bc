//! The page around the sections.

use super::html::{escape, list};
use protomer_common::page::{Program, Verdict};

const STYLE: &str = include_str!("page.css");
/// Security policy of the page: nothing may be loaded; inline scripts and styles may run.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; \
                      base-uri 'none'; form-action 'none'";

/// A part of the page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Heading of the section.
    pub title: String,
    /// Content of the section.
    pub html: String,
    /// The programs in it, whose HTML is part of the content.
    pub programs: Vec<Program>,
}

impl Section {
    /// A section of text and pictures.
    pub fn new(title: &str, html: String) -> Self {
        Self {
            title: title.into(),
            html,
            programs: Vec::new(),
        }
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// A line below the title.
    pub subtitle: String,
    /// The verdict of the run on its results; `None` for a kind of results that has none.
    pub verdict: Option<Verdict>,
    /// Descriptions of what failed or is missing.
    pub problems: Vec<String>,
    /// Sections of the page.
    pub sections: Vec<Section>,
}

impl Page {
    /// The titles of the sections in order.
    pub fn titles(&self) -> Vec<String> {
        std::iter::once("Status")
            .map(str::to_owned)
            .chain(self.sections.iter().map(|s| s.title.clone()))
            .collect()
    }

    /// The text of the file.
    pub fn to_html(&self) -> String {
        let title = escape(&self.title);
        let links: String = (self.titles().iter())
            .map(|title| format!("<a href=\"#{}\">{}</a>\n", anchor(title), escape(title)))
            .collect();
        let body: String = self
            .sections
            .iter()
            .map(|section| wrap(&section.title, &section.html))
            .collect();
        let styles = self.distinct(|program| &program.style);
        let libraries = self.distinct(|program| program.library);
        let scripts: String = self
            .programs()
            .map(|program| program.script.as_str())
            .collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<link rel=\"icon\" href=\"data:,\">\n\
             <style>\n{STYLE}{styles}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n<p>{}</p>\n<nav>\n{links}</nav>\n\
             </header>\n<main>\n{}{body}</main>\n<script>\n{libraries}{scripts}document.documentElement.dataset.ready = \"yes\";\n\
             </script>\n</body>\n</html>\n",
            escape(&self.subtitle),
            wrap("Status", &self.status()),
        )
    }

    /// The verdict, then whether the work is complete. Complete work is green only if its verdict
    /// is good: a finished run may still be far from equilibrium.
    fn status(&self) -> String {
        let verdict = self.verdict.as_ref().map(paragraph_of);
        let is_good = self.verdict.as_ref().is_none_or(Verdict::is_good);
        let completeness = match (self.problems.as_slice(), is_good) {
            ([], true) => {
                "<p class=\"good\">Finished; nothing failed and nothing is missing.</p>\n".into()
            }
            ([], false) => "<p>Finished; nothing failed and nothing is missing.</p>\n".into(),
            (problems, _) => format!("<div class=\"bad\">{}</div>\n", list(problems)),
        };
        verdict.unwrap_or_default() + &completeness
    }

    fn programs(&self) -> impl Iterator<Item = &Program> {
        self.sections.iter().flat_map(|section| &section.programs)
    }

    fn distinct(&self, part: fn(&Program) -> &str) -> String {
        let mut parts: Vec<&str> = Vec::new();
        for text in self.programs().map(part) {
            if !parts.contains(&text) {
                parts.push(text);
            }
        }
        parts.concat()
    }
}

/// A verdict in a paragraph of the colour of its answer.
fn paragraph_of(verdict: &Verdict) -> String {
    let (answer, class) = match verdict.answer {
        Some(true) => ("yes", "good"),
        Some(false) => ("no", "bad"),
        None => ("unknown", "open"),
    };
    let mut letters = verdict.reason.chars();
    let first = letters.next().map(char::to_uppercase);
    let reason: String = first.into_iter().flatten().chain(letters).collect();
    format!(
        "<p class=\"{class}\"><strong>{}: {answer}.</strong> {}.</p>\n",
        verdict.question,
        escape(reason.trim_end_matches('.'))
    )
}

fn wrap(title: &str, html: &str) -> String {
    format!(
        "<section id=\"{}\">\n<h2>{}</h2>\n{html}</section>\n",
        anchor(title),
        escape(title)
    )
}

fn anchor(title: &str) -> String {
    title
        .to_lowercase()
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect()
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
            assert_eq!(paragraph_of(&verdict), html);
            assert_eq!(verdict.is_good(), answer == Some(true));
        }
    }

    fn page(verdict: Option<Verdict>, problems: &[&str]) -> String {
        let page = Page {
            title: "a".into(),
            subtitle: String::new(),
            verdict,
            problems: problems
                .iter()
                .map(|problem| (*problem).to_owned())
                .collect(),
            sections: Vec::new(),
        };
        page.status()
    }

    #[test]
    fn finished_work_is_green_only_with_a_good_verdict() {
        let green = "<p class=\"good\">Finished;";
        let equilibrated = |answer| Some(Verdict::equilibrated(answer, "why"));
        assert!(page(None, &[]).starts_with(green));
        assert!(page(equilibrated(Some(true)), &[]).contains(green));
        for answer in [Some(false), None] {
            let status = page(equilibrated(answer), &[]);
            assert!(
                !status.contains("good") && status.contains("<p>Finished;"),
                "{status}"
            );
            assert!(status.find("Equilibrated:") < status.find("Finished;"));
        }
        let failed = page(equilibrated(Some(true)), &["It failed: why"]);
        assert!(failed.contains("class=\"bad\"") && !failed.contains("Finished"));
    }
}
