//! Texts that are too long for their room.

use super::typeface::text_width;

/// A text in lines, all of one size.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fitted {
    pub lines: Vec<String>,
    pub size: f64,
}

impl Fitted {
    /// Height from the top of the first line to the baseline of the last; `line` is the distance
    /// from line to line in em.
    pub fn height(&self, line: f64) -> f64 {
        self.size * (1.0 + line * self.lines.len().saturating_sub(1) as f64)
    }
}

/// Fits a text into the room: a long one is made smaller, down to the part `least` of its size, and
/// a longer one is broken between words.
pub(crate) fn fit(text: &str, size: f64, room: f64, least: f64) -> Fitted {
    let fitting = room / text_width(text, size);
    if fitting >= least {
        return Fitted {
            lines: vec![text.to_owned()],
            size: size * fitting.min(1.0),
        };
    }
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match longer {
            Some(longer) if text_width(&longer, size) <= room => {
                lines.pop();
                lines.push(longer);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    // A single word may still be too long.
    let widths = lines.iter().map(|line| text_width(line, size));
    let widest = widths.fold(room, f64::max);
    Fitted {
        lines,
        size: size * room / widest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_shrink_a_little_or_are_broken() {
        let text = "error bars: standard error of five replicas";
        let room = text_width(text, 20.0);
        let shown = |room: f64, least: f64| fit(text, 20.0, room, least);
        assert_eq!(
            shown(2.0 * room, 0.8),
            Fitted {
                lines: vec![text.into()],
                size: 20.0
            }
        );
        assert_eq!(shown(0.9 * room, 0.8).lines, [text]);
        assert!((shown(0.9 * room, 0.8).size - 18.0).abs() < 1e-9);
        let broken = shown(0.6 * room, 0.8);
        assert_eq!(
            (broken.lines.len(), broken.size, broken.lines.join(" ")),
            (2, 20.0, text.to_owned())
        );
        assert_eq!(shown(0.9 * room, 1.0).lines.len(), 2);
        // Every line fits, also where a word is longer than the room.
        let narrow = shown(0.1 * room, 1.0);
        assert!(
            narrow
                .lines
                .iter()
                .all(|line| text_width(line, narrow.size) <= 0.1 * room * 1.001)
        );
    }
}
