//! Square matrices of numbers from 0 to 1 as pictures in an SVG file.

use anyhow::{Context, Result};
use base64::prelude::*;
use protomer_io::atomic::write_atomically;
use std::path::Path;

/// A matrix to be shown.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Written above it.
    pub title: String,
    /// Rows and columns.
    pub size: usize,
    /// Row after row, 0 to 1; what is outside is drawn as the end.
    pub values: Vec<f64>,
}

/// Edge of a matrix, and what is left around it, in units of the SVG.
const EDGE: usize = 360;
const MARGIN: usize = 40;

/// Writes matrices side by side, so many to a row, with a scale of colours.
///
/// # Errors
/// If the disk does not take it.
pub fn write_svg(path: &Path, title: &str, maps: &[HeatMap], columns: usize) -> Result<()> {
    let svg = to_svg(title, maps, columns)?;
    Ok(write_atomically(path, |file| {
        file.write_all(svg.as_bytes())
    })?)
}

fn to_svg(title: &str, maps: &[HeatMap], columns: usize) -> Result<String> {
    let (step, rows) = (EDGE + MARGIN, maps.len().div_ceil(columns));
    let (width, height) = (MARGIN + columns * step, 2 * MARGIN + rows * step + MARGIN);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"15\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"30\" font-size=\"20\">{title}</text>\n"
    );
    for (index, map) in maps.iter().enumerate() {
        let (x, y) = (index % columns * step, MARGIN + index / columns * step);
        let inside = picture(
            [MARGIN, MARGIN],
            [EDGE, EDGE],
            &png(map.size, map.size, &map.values)?,
        ) + &format!(
            "<text x=\"{MARGIN}\" y=\"{}\">{}</text>\n",
            MARGIN - 8,
            map.title
        );
        svg += &part([x, y], [MARGIN + EDGE, MARGIN + EDGE], &inside);
    }
    let scale: Vec<f64> = (0..100).map(|k| f64::from(k) / 99.0).collect();
    let inside = picture([MARGIN + 20, 0], [EDGE - 40, 16], &png(100, 1, &scale)?)
        + &format!(
            "<text x=\"{MARGIN}\" y=\"14\">0</text><text x=\"{}\" y=\"14\">1</text>\n",
            MARGIN + EDGE - 14
        );
    svg += &part([0, height - MARGIN], [MARGIN + EDGE, 20], &inside);
    Ok(svg + "</svg>\n")
}

/// A drawing of its own within the drawing, which a page may put elsewhere.
fn part([x, y]: [usize; 2], [width, height]: [usize; 2], inside: &str) -> String {
    format!(
        "<svg class=\"part\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\n\
         {inside}</svg>\n"
    )
}

fn picture([x, y]: [usize; 2], [width, height]: [usize; 2], png: &[u8]) -> String {
    format!(
        "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n",
        BASE64_STANDARD.encode(png)
    )
}

/// From dark blue over green to yellow, ever lighter.
fn colour(value: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] = [
        [48.0, 18.0, 85.0],
        [52.0, 84.0, 139.0],
        [31.0, 146.0, 140.0],
        [108.0, 204.0, 92.0],
        [252.0, 231.0, 55.0],
    ];
    let value = if value.is_nan() {
        0.0
    } else {
        value.clamp(0.0, 1.0)
    } * (STOPS.len() - 1) as f64;
    let below = (value.floor() as usize).min(STOPS.len() - 2);
    let part = value - below as f64;
    [0, 1, 2].map(|channel| {
        (STOPS[below][channel] * (1.0 - part) + STOPS[below + 1][channel] * part).round() as u8
    })
}

fn png(width: usize, height: usize, values: &[f64]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = values.iter().flat_map(|value| colour(*value)).collect();
    let mut writer = encoder.write_header().context("a picture of a matrix")?;
    writer
        .write_image_data(&pixels)
        .context("a picture of a matrix")?;
    writer.finish().context("a picture of a matrix")?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_get_lighter() {
        let light = |value: f64| {
            colour(value)
                .iter()
                .map(|part| u32::from(*part))
                .sum::<u32>()
        };
        assert!((0..99).all(|k| light(f64::from(k) / 100.0) <= light(f64::from(k + 1) / 100.0)));
        assert_eq!(colour(f64::NAN), colour(-1.0));
        assert_eq!(colour(2.0), colour(1.0));
    }
}
