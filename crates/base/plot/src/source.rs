//! A figure stored as JSON inside its own SVG, so that it can be drawn again in another shape.

use super::Figure;
use super::error::{PlotError, Result};
use super::svg::{ESCAPES, escaped};

const OPEN: &str = "<metadata id=\"protomer-figure\">";
const CLOSE: &str = "</metadata>\n";

/// Embeds the figure at the end of the SVG.
pub(crate) fn within(svg: &str, figure: &Figure) -> Result<String> {
    let json = serde_json::to_string(&drawn(figure)).map_err(|error| PlotError::Drawing {
        cause: error.to_string(),
    })?;
    let body = svg.trim_end().trim_end_matches("</svg>");
    Ok(format!("{body}{OPEN}{}{CLOSE}</svg>\n", escaped(&json)))
}

/// The figure of an SVG, and the SVG without it.
pub(crate) fn take(svg: &str) -> Result<Option<(Figure, String)>> {
    let damaged = |cause: String| PlotError::DamagedSource { cause };
    let Some((before, remainder)) = svg.split_once(OPEN) else {
        return Ok(None);
    };
    let (text, after) = remainder
        .split_once(CLOSE)
        .ok_or_else(|| damaged("it has no end".into()))?;
    let figure =
        serde_json::from_str(&unescaped(text)).map_err(|error| damaged(error.to_string()))?;
    Ok(Some((figure, format!("{before}{after}"))))
}

fn unescaped(text: &str) -> String {
    let last_first = ESCAPES.iter().rev();
    last_first.fold(text.to_owned(), |text, (sign, written)| {
        text.replace(written, sign)
    })
}

/// The figure without undrawn values and values that JSON cannot represent.
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
