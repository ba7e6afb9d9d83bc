//! The page around the sections.

use super::html::{escape, list};

const STYLE: &str = include_str!("page.css");
/// Nothing may be loaded; inline scripts and styles may run.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; \
                      base-uri 'none'; form-action 'none'";

/// A part of the page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// Its content.
    pub html: String,
    /// Its style; identical styles appear once.
    pub style: String,
    /// Functions that it calls; identical libraries appear once.
    pub library: &'static str,
    /// The script that runs at the end.
    pub script: String,
}

impl Section {
    /// A section of text and pictures.
    pub fn new(title: &str, html: String) -> Self {
        Self {
            title: title.into(),
            html,
            style: String::new(),
            library: "",
            script: String::new(),
        }
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// A line below it.
    pub subtitle: String,
    /// What failed or is missing.
    pub problems: Vec<String>,
    /// Its sections.
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
        let styles: String = self.distinct(|section| &section.style);
        let libraries = self.distinct(|section| section.library);
        let scripts: String = self
            .sections
            .iter()
            .map(|section| section.script.as_str())
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

    fn status(&self) -> String {
        match self.problems.as_slice() {
            [] => "<p class=\"good\">Finished; nothing failed and nothing is missing.</p>\n".into(),
            problems => format!("<div class=\"bad\">{}</div>\n", list(problems)),
        }
    }

    fn distinct(&self, part: fn(&Section) -> &str) -> String {
        let mut parts: Vec<&str> = Vec::new();
        for text in self.sections.iter().map(part) {
            if !parts.contains(&text) {
                parts.push(text);
            }
        }
        parts.concat()
    }
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
