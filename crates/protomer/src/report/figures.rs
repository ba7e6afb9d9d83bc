//! Pictures inside the page.

use super::html::escape;
use crate::plot::Figure;
use anyhow::{Context, Result, bail};
use std::path::Path;

/// A figure drawn now, with what stands below it.
///
/// # Errors
/// If it cannot be drawn.
pub fn drawn(figure: &Figure, below: &str) -> Result<String> {
    Ok(around(&figure.to_svg()?, &figure.title, below))
}

/// A figure of the directory, with what stands below it; nothing where it is not there.
///
/// # Errors
/// If the file cannot be read, or is no picture that stands by itself.
pub fn of_file(directory: &Path, name: &str, title: &str, below: &str) -> Result<String> {
    let path = directory.join(name);
    if !path.is_file() {
        return Ok(String::new());
    }
    let svg = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    if !stands_by_itself(&svg) {
        bail!("{} is no figure that protomer wrote; make it again, or move it away", path.display());
    }
    Ok(around(&svg, title, below))
}

fn around(svg: &str, title: &str, below: &str) -> String {
    format!(
        "<figure>\n<div class=\"figure\" role=\"img\" aria-label=\"{}\" tabindex=\"0\">{}</div>\n{below}</figure>\n",
        escape(title),
        svg.trim_end()
    )
}

/// One picture that runs nothing and loads nothing.
fn stands_by_itself(svg: &str) -> bool {
    let plain = svg.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let lower = plain.to_lowercase();
    let picture = svg.trim_start().starts_with("<svg") && svg.trim_end().ends_with("</svg>");
    let acts = ["<script", "<foreignobject", "<iframe", "javascript:", "://"].iter().any(|word| lower.contains(word));
    picture && !acts && !has_handler(&lower)
}

/// Whether an attribute such as `onload=` is in a tag.
fn has_handler(lower: &str) -> bool {
    lower.split('<').filter_map(|part| part.split('>').next()).any(|tag| {
        tag.split_whitespace().any(|word| {
            let name = word.split('=').next().unwrap_or_default();
            word.contains('=') && name.len() > 2 && name.starts_with("on")
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_that_act_are_refused() {
        let svg = |inside: &str| format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1\">{inside}</svg>\n");
        assert!(stands_by_itself(&svg("<text x=\"1\">based on = this</text>")));
        for bad in ["<script>1</script>", "<image href=\"https://example.org/a\"/>", "<g onload=\"x\"/>"] {
            assert!(!stands_by_itself(&svg(bad)), "{bad}");
        }
        assert!(!stands_by_itself("<html></html>"));
    }
}
