//! Lengths, colours and values that axes and layout share.

use super::Panel;
use super::canvas::Rgb;

pub(crate) const INK: Rgb = [0x22, 0x22, 0x22];
pub(crate) const MARGIN: f64 = 28.0;
/// Height of capital letters in em, to centre text on a line.
pub(crate) const CAPITALS: f64 = 0.73;
/// Distance from line to line of a text, in em.
pub(crate) const LINE: f64 = 1.2;

/// All values of a panel along y, with the ends of the error bars.
pub(crate) fn y_values(panel: &Panel) -> impl Iterator<Item = f64> {
    panel.values().map(|[_, y]| y).chain(panel.error_ends())
}
