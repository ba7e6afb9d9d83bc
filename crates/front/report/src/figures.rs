//! Figures embedded in the page, in one layout for wide screens and one for phones.

use super::html::escape;
use anyhow::{Context, Result, bail};
use protomer_plot::{ColourMap, Figure};
use std::path::Path;

/// Draws a figure, followed by the HTML `below` it.
///
/// # Errors
/// If it cannot be drawn.
pub fn drawn(figure: &Figure, below: &str) -> Result<String> {
    let Some((_, svg)) = Figure::from_svg(&figure.to_svg()?)? else {
        bail!("a figure without its source")
    };
    Ok(around(&in_both_shapes(&svg, figure)?, &figure.title, below))
}

/// Draws a map.
///
/// # Errors
/// If it cannot be drawn.
pub fn map(map: &ColourMap) -> Result<String> {
    let html = both(&map.to_svg()?, &map.to_narrow_svg()?);
    Ok(around(&html, &map.title, ""))
}

/// A figure from the directory, followed by the HTML `below` it; empty if it does not exist.
///
/// # Errors
/// If the file cannot be read, or is not a self-contained picture.
pub fn of_file(directory: &Path, name: &str, title: &str, below: &str) -> Result<String> {
    let path = directory.join(name);
    if !path.is_file() {
        return Ok(String::new());
    }
    let svg = protomer_io::input::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    if !stands_by_itself(&svg) {
        bail!(
            "{} is not a figure written by protomer; make it again, or move it away",
            path.display()
        );
    }
    let embedded_figure = Figure::from_svg(&svg).with_context(|| path.display().to_string())?;
    let html = match embedded_figure {
        Some((figure, svg)) => in_both_shapes(&svg, &figure)?,
        None if svg.contains(PART) => in_parts(&svg),
        None => with_texts_below(&svg),
    };
    Ok(around(&html, title, below))
}

/// Number of texts beyond which a drawing has axis labels, which are useless below it.
const MOST_TEXTS: usize = 4;
/// The beginning of a self-contained part of a drawing.
const PART: &str = "<svg class=\"part\"";

/// The figure in its usual form and redrawn for narrow screens; the page shows one of the two.
fn in_both_shapes(svg: &str, figure: &Figure) -> Result<String> {
    Ok(both(svg, &figure.to_narrow_svg()?))
}

fn both(wide: &str, narrow: &str) -> String {
    format!(
        "<div class=\"wide\">{}</div><div class=\"narrow\">{}</div>",
        wide.trim_end(),
        narrow.trim_end()
    )
}

/// Parts that flow into rows as the width allows.
fn in_parts(svg: &str) -> String {
    let part = |text: &str| Some(format!("{PART}{}</svg>\n", text.split_once("</svg>")?.0));
    let parts: String = svg.split(PART).skip(1).filter_map(part).collect();
    format!("<div class=\"parts\">\n{parts}</div>")
}

/// A drawing whose texts would be too small on a narrow screen. If there are few, they are
/// repeated below it there.
fn with_texts_below(svg: &str) -> String {
    let texts = svg
        .split("<text")
        .skip(1)
        .filter_map(|piece| piece.split_once('>')?.1.split_once("</text>"));
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

/// The text between the tags.
fn without_tags(text: &str) -> String {
    let mut pieces = text.split('<');
    let first = pieces.next().unwrap_or_default().to_owned();
    pieces.fold(first, |text, piece| {
        text + piece.split_once('>').map_or("", |(_, content)| content)
    })
}

fn around(html: &str, title: &str, below: &str) -> String {
    format!(
        "<figure>\n<div class=\"figure\" role=\"img\" aria-label=\"{}\">{html}</div>\n{below}</figure>\n",
        escape(title)
    )
}

/// Whether the text is one picture that runs no scripts and loads nothing. Names in its texts may hold
/// anything.
fn stands_by_itself(svg: &str) -> bool {
    let plain = svg.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let tags = tags(&plain.to_lowercase());
    let picture = svg.trim_start().starts_with("<svg") && svg.trim_end().ends_with("</svg>");
    let acts = |tag: &str| {
        let element = tag.trim_start_matches(['<', '/']);
        ["script", "foreignobject", "iframe"]
            .iter()
            .any(|name| element.starts_with(name))
    };
    let loads = |tag: &str| tag.contains("javascript:") || tag.contains("://");
    let is_harmless = |tag: &String| !acts(tag) && !loads(tag) && !has_handler(tag);
    picture && tags.iter().all(is_harmless)
}

/// The tags of a text, without the texts between them. A `>` in quotes ends no tag.
fn tags(text: &str) -> Vec<String> {
    let mut tags: Vec<String> = Vec::new();
    let (mut is_inside, mut quote) = (false, None);
    for character in text.chars() {
        match (is_inside, quote) {
            (false, _) if character == '<' => {
                is_inside = true;
                tags.push(String::new());
            }
            (false, _) => continue,
            (true, Some(open)) if character == open => quote = None,
            (true, None) if character == '"' || character == '\'' => quote = Some(character),
            (true, None) if character == '>' => is_inside = false,
            (true, _) => {}
        }
        if let Some(tag) = tags.last_mut() {
            tag.push(character);
        }
    }
    tags
}

/// Whether a tag has an attribute such as `onload=`.
fn has_handler(tag: &str) -> bool {
    let mut words = tag.split(|character: char| character.is_whitespace() || character == '/');
    words.any(|word| {
        let name = word.split('=').next().unwrap_or_default();
        word.contains('=') && name.len() > 2 && name.starts_with("on")
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
        assert!(stands_by_itself(&svg(
            "<text>http://x &lt;script&gt; javascript: onload=1 it's</text>"
        )));
        for bad in [
            "<image title=\">\" href=\"https://example.org/a\"/>",
            "<script>1</script>",
            "<image href=\"https://example.org/a\"/>",
            "<g onload=\"x\"/>",
            "<g/onload=x>",
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
