//! Pictures inside the page, in a shape for wide screens and in one for phones.

use super::html::escape;
use anyhow::{Context, Result, bail};
use protomer_plot::Figure;
use std::path::Path;

/// A figure drawn now, with what stands below it.
///
/// # Errors
/// If it cannot be drawn.
pub fn drawn(figure: &Figure, below: &str) -> Result<String> {
    let Some((_, svg)) = Figure::from_svg(&figure.to_svg()?)? else {
        bail!("a figure without its source")
    };
    Ok(around(&in_both_shapes(&svg, figure)?, &figure.title, below))
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
    let svg = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    if !stands_by_itself(&svg) {
        bail!(
            "{} is no figure that protomer wrote; make it again, or move it away",
            path.display()
        );
    }
    let found = Figure::from_svg(&svg).with_context(|| path.display().to_string())?;
    let html = match found {
        Some((figure, svg)) => in_both_shapes(&svg, &figure)?,
        None if svg.contains(PART) => in_parts(&svg),
        None => with_texts_below(&svg),
    };
    Ok(around(&html, title, below))
}

/// More texts than these are those of axes, which say nothing elsewhere.
const MOST_TEXTS: usize = 4;
/// Where a part of a drawing begins that stands by itself.
const PART: &str = "<svg class=\"part\"";

/// The figure as it is, and as it is drawn for a narrow screen; one of the two is shown.
fn in_both_shapes(svg: &str, figure: &Figure) -> Result<String> {
    let narrow = figure.to_narrow_svg()?;
    Ok(format!(
        "<div class=\"wide\">{}</div><div class=\"narrow\">{}</div>",
        svg.trim_end(),
        narrow.trim_end()
    ))
}

/// As many parts to a row as there is room for.
fn in_parts(svg: &str) -> String {
    let part = |text: &str| Some(format!("{PART}{}</svg>\n", text.split_once("</svg>")?.0));
    let parts: String = svg.split(PART).skip(1).filter_map(part).collect();
    format!("<div class=\"parts\">\n{parts}</div>")
}

/// A drawing whose texts would be too small on a narrow screen, where they stand below it instead,
/// if they are few.
fn with_texts_below(svg: &str) -> String {
    let texts = svg
        .split("<text")
        .skip(1)
        .filter_map(|rest| rest.split_once('>')?.1.split_once("</text>"));
    let lines: Vec<String> = texts
        .map(|(text, _)| format!("<p>{}</p>\n", without_tags(text)))
        .collect();
    if lines.len() > MOST_TEXTS {
        return svg.trim_end().to_owned();
    }
    format!(
        "<div class=\"drawing\">{}</div><div class=\"narrow\">\n{}</div>",
        svg.trim_end(),
        lines.concat()
    )
}

/// What stands between the tags.
fn without_tags(text: &str) -> String {
    let mut pieces = text.split('<');
    let first = pieces.next().unwrap_or_default().to_owned();
    pieces.fold(first, |text, piece| {
        text + piece.split_once('>').map_or("", |(_, rest)| rest)
    })
}

fn around(html: &str, title: &str, below: &str) -> String {
    format!(
        "<figure>\n<div class=\"figure\" role=\"img\" aria-label=\"{}\">{html}</div>\n{below}</figure>\n",
        escape(title)
    )
}

/// One picture that runs nothing and loads nothing.
fn stands_by_itself(svg: &str) -> bool {
    let plain = svg.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let lower = plain.to_lowercase();
    let picture = svg.trim_start().starts_with("<svg") && svg.trim_end().ends_with("</svg>");
    let acts = ["<script", "<foreignobject", "<iframe", "javascript:", "://"]
        .iter()
        .any(|word| lower.contains(word));
    picture && !acts && !has_handler(&lower)
}

/// Whether an attribute such as `onload=` is in a tag.
fn has_handler(lower: &str) -> bool {
    lower
        .split('<')
        .filter_map(|part| part.split('>').next())
        .any(|tag| {
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
        let svg = |inside: &str| {
            format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1\">{inside}</svg>\n")
        };
        assert!(stands_by_itself(&svg(
            "<text x=\"1\">based on = this</text>"
        )));
        for bad in [
            "<script>1</script>",
            "<image href=\"https://example.org/a\"/>",
            "<g onload=\"x\"/>",
        ] {
            assert!(!stands_by_itself(&svg(bad)), "{bad}");
        }
        assert!(!stands_by_itself("<html></html>"));
    }

    #[test]
    fn texts_of_a_drawing_stand_below_it_without_tags() {
        let html = with_texts_below(
            "<svg><text x=\"1\">a &lt; b</text><g/><text><tspan fill=\"red\">c</tspan> d</text></svg>",
        );
        assert!(html.contains("<p>a &lt; b</p>\n<p>c d</p>"), "{html}");
    }

    #[test]
    fn parts_are_taken_out_of_their_drawing() {
        let html = in_parts(
            "<svg><text>all</text><svg class=\"part\" x=\"1\">a</svg>\n<svg class=\"part\">b</svg></svg>",
        );
        assert_eq!(html.matches("</svg>").count(), 2);
        assert!(
            html.contains("<svg class=\"part\" x=\"1\">a</svg>") && !html.contains("all"),
            "{html}"
        );
    }
}
