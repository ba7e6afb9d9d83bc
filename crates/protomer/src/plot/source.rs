//! A figure inside its own SVG, as JSON, so that it can be drawn again in another shape.

use super::Figure;
use anyhow::{Context, Result};

const OPEN: &str = "<metadata id=\"protomer-figure\">";
const CLOSE: &str = "</metadata>\n";
/// What may not stand in the text of an element, and what stands for it.
const ESCAPES: [(&str, &str); 3] = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;")];

/// Puts a figure before the end of its SVG.
pub(super) fn within(svg: &str, figure: &Figure) -> Result<String> {
    let json = serde_json::to_string(&drawn(figure)).context("a figure cannot be written down")?;
    let escaped = ESCAPES
        .iter()
        .fold(json, |text, (sign, written)| text.replace(sign, written));
    let end = svg
        .rfind("</svg>")
        .context("the drawing library has written an unknown kind of SVG")?;
    Ok(format!(
        "{}{OPEN}{escaped}{CLOSE}{}",
        &svg[..end],
        &svg[end..]
    ))
}

/// The figure of an SVG, and the SVG without it.
pub(super) fn take(svg: &str) -> Result<Option<(Figure, String)>> {
    let Some((before, rest)) = svg.split_once(OPEN) else {
        return Ok(None);
    };
    let (text, after) = rest
        .split_once(CLOSE)
        .context("the figure inside an SVG has no end")?;
    let json = ESCAPES
        .iter()
        .rev()
        .fold(text.to_owned(), |text, (sign, written)| {
            text.replace(written, sign)
        });
    let figure = serde_json::from_str(&json)
        .context("the figure inside an SVG is damaged or of another version")?;
    Ok(Some((figure, format!("{before}{after}"))))
}

/// Without what is not drawn, and what JSON cannot say.
fn drawn(figure: &Figure) -> Figure {
    let mut figure = figure.clone();
    for series in figure.panels.iter_mut().flat_map(|panel| &mut panel.series) {
        series.points.retain(|point| !point.y.is_nan());
        series.replicas.retain(|[_, y]| !y.is_nan());
        for point in &mut series.points {
            point.error = point.error.filter(|error| error.is_finite());
        }
    }
    figure
}
