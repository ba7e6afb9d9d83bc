//! A network that moves under its load, as an SVG that plays by itself.

use super::drawing::{AFTER, BEFORE, HEIGHT, MARGIN, Patch, View, WIDTH, cell_counts};
use protomer_linkage::framework::Framework;
use protomer_plot::escaped;
use std::fmt::Write;

/// Largest number of lines over all frames; it keeps the file below some megabytes.
const MOST_LINES: usize = 60_000;
/// Duration of the way from no load to the last and back.
const SECONDS: f64 = 8.0;

/// The unloaded network in grey, and over it the equilibria in their order and back again; between two
/// of them nodes move along straight lines. `None` if the network is too large.
///
/// ```
/// use protomer_linkage::framework::build::rotating_squares;
/// use protomer_linkage_verbs::frameworks::film::film;
/// let states = [0.5, 0.4, 0.3].map(|angle| rotating_squares(1.0, angle, 1.0, 1.0));
/// let states = states.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let text = film("squares", "opened", &states).unwrap_or_default();
/// // There and back: five shapes.
/// assert_eq!(text.split("values=").nth(1).map(|rest| rest.matches(';').count()), Some(4));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn film(title: &str, label: &str, states: &[Framework]) -> Option<String> {
    let first = states.first()?;
    let counts = cell_counts(first);
    let lines = first.rods.len() * counts.iter().product::<usize>() * states.len();
    if lines > MOST_LINES {
        return None;
    }
    let patches: Vec<Patch> = states
        .iter()
        .map(|state| Patch::new(state, &counts))
        .collect();
    let view = View::new(patches.iter());
    let paths: Vec<String> = patches.iter().map(|patch| path(patch, &view)).collect();
    // There and back again, both ends once.
    let forth = paths.iter().map(String::as_str);
    let shapes: Vec<&str> = forth.clone().chain(forth.rev().skip(1)).collect();
    Some(format!(
        "<svg width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"DejaVu Sans, sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{MARGIN}\" \
         y=\"36\" font-size=\"24\">{}</text>\n<text x=\"{MARGIN}\" y=\"62\" font-size=\"18\" fill=\"{AFTER}\">{}</text>\n<g fill=\"none\" \
         stroke-linecap=\"round\">\n<path stroke=\"{BEFORE}\" stroke-width=\"3\" d=\"{first}\"/>\n<path stroke=\"{AFTER}\" \
         stroke-width=\"4\" d=\"{first}\">\n<animate attributeName=\"d\" dur=\"{SECONDS}s\" repeatCount=\"indefinite\" \
         values=\"{}\"/>\n</path>\n</g>\n</svg>\n",
        escaped(title),
        escaped(label),
        shapes.join(";"),
        first = paths[0],
    ))
}

fn path(patch: &Patch, view: &View) -> String {
    let mut text = String::new();
    for [from, to] in &patch.lines {
        let ([x1, y1], [x2, y2]) = (view.place(from), view.place(to));
        // Writing to a string cannot fail.
        let _ = write!(text, "M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}");
    }
    text
}
