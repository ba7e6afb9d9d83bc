//! The built-in typeface: widths for the layout, outlines for pixels.

use super::runs::runs;
use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve};
use std::sync::LazyLock;

/// Font family of the texts. Where the first typeface is missing, a viewer of an SVG takes the next
/// one of the list.
pub(crate) const FAMILY: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";

/// The built-in typeface; `None` if the bundled bytes are damaged: then texts have estimated widths
/// and no pixels.
static TYPEFACE: LazyLock<Option<Typeface>> = LazyLock::new(Typeface::built_in);

/// Mean width of a letter in em, where the typeface is missing.
const ESTIMATED_ADVANCE: f64 = 0.6;

struct Typeface {
    font: FontRef<'static>,
    units_per_em: f64,
}

/// A glyph of a run: its outline, and its distance from the beginning of the baseline in em.
pub(crate) struct PlacedGlyph {
    pub curves: Vec<OutlineCurve>,
    pub offset: f64,
}

/// Outlines of a run of text in em, y upward from the baseline.
pub(crate) struct Typeset {
    pub glyphs: Vec<PlacedGlyph>,
    /// The length of an em in the units of the outlines.
    pub units_per_em: f64,
}

/// Width of a text with subscripts and superscripts, for an em of length `size`.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    runs(text)
        .iter()
        .map(|run| run_width(&run.text) * size * run.level.scale_and_raise().0)
        .sum()
}

/// The outlines of a run; none where the typeface is missing.
pub(crate) fn typeset(text: &str) -> Option<Typeset> {
    let typeface = TYPEFACE.as_ref()?;
    let mut glyphs = Vec::new();
    typeface.walk(text, |glyph, offset| {
        let curves = typeface.font.outline(glyph).map(|outline| outline.curves);
        glyphs.push(PlacedGlyph {
            curves: curves.unwrap_or_default(),
            offset,
        });
    });
    Some(Typeset {
        glyphs,
        units_per_em: typeface.units_per_em,
    })
}

/// Width of a run in em.
fn run_width(text: &str) -> f64 {
    match TYPEFACE.as_ref() {
        Some(typeface) => typeface.walk(text, |_, _| {}),
        None => text.chars().count() as f64 * ESTIMATED_ADVANCE,
    }
}

impl Typeface {
    fn built_in() -> Option<Self> {
        let font = FontRef::try_from_slice(dejavu::sans::regular()).ok()?;
        let units_per_em = f64::from(font.units_per_em()?);
        Some(Self { font, units_per_em })
    }

    /// Calls `visit` with each glyph and its distance from the beginning of the baseline in em;
    /// returns the length of the run in em.
    fn walk(&self, text: &str, mut visit: impl FnMut(GlyphId, f64)) -> f64 {
        let mut offset = 0.0;
        let mut previous: Option<GlyphId> = None;
        for character in text.chars() {
            let glyph = self.font.glyph_id(character);
            let kerning = previous.map_or(0.0, |before| self.font.kern_unscaled(before, glyph));
            offset += f64::from(kerning) / self.units_per_em;
            visit(glyph, offset);
            offset += f64::from(self.font.h_advance_unscaled(glyph)) / self.units_per_em;
            previous = Some(glyph);
        }
        offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_typeface_can_be_read() {
        assert!(TYPEFACE.is_some());
    }

    #[test]
    fn widths_grow_with_the_text_and_its_size() {
        assert!(text_width("ii", 20.0) < text_width("mm", 20.0));
        let ratio = text_width("salt", 40.0) / text_width("salt", 20.0);
        assert!((ratio - 2.0).abs() < 1e-12);
        assert!(text_width("R_g", 20.0) < text_width("Rg", 20.0));
    }
}
