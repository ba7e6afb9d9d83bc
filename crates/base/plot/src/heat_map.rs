//! Square matrices of numbers from 0 to 1 as pictures side by side in one SVG.

use super::error::{PlotError, Result};
use super::svg::escaped;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use protomer_io::atomic::write_bytes;
use std::path::Path;

/// A square matrix to be shown.
///
/// ```no_run
/// use protomer_plot::HeatMap;
/// use std::path::Path;
/// let map = HeatMap { title: "identity".into(), size: 2, values: vec![1.0, 0.0, 0.0, 1.0] };
/// HeatMap::write_svg(&[map], "Two squares", 1, Path::new("indices.svg"))?;
/// # Ok::<(), protomer_plot::PlotError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Title above the matrix.
    pub title: String,
    /// Number of rows and of columns.
    pub size: usize,
    /// Values, row after row. Values below 0 and above 1 have the colours of 0 and 1.
    pub values: Vec<f64>,
}

/// Edge of a matrix, in units of the SVG.
const EDGE: usize = 360;
/// Space around a matrix, in units of the SVG.
const MARGIN: usize = 40;

/// Colours from dark blue over green to yellow, each lighter than the one before.
const STOPS: [[f64; 3]; 5] = [
    [48.0, 18.0, 85.0],
    [52.0, 84.0, 139.0],
    [31.0, 146.0, 140.0],
    [108.0, 204.0, 92.0],
    [252.0, 231.0, 55.0],
];

impl HeatMap {
    /// Writes matrices side by side, `columns` to a row, with a scale of colours below.
    ///
    /// # Errors
    /// [`PlotError::Drawing`] for a matrix whose values are not `size` x `size`, and if the file
    /// cannot be written.
    pub fn write_svg(maps: &[Self], title: &str, columns: usize, path: &Path) -> Result<()> {
        let svg = to_svg(maps, title, columns.max(1))?;
        Ok(write_bytes(path, svg.as_bytes())?)
    }
}

fn to_svg(maps: &[HeatMap], title: &str, columns: usize) -> Result<String> {
    let (step, rows) = (EDGE + MARGIN, maps.len().div_ceil(columns));
    let (width, height) = (MARGIN + columns * step, 3 * MARGIN + rows * step);
    let title = escaped(title);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"15\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"30\" font-size=\"20\">{title}</text>\n"
    );
    for (index, map) in maps.iter().enumerate() {
        let corner = [index % columns * step, MARGIN + index / columns * step];
        svg += &part(corner, [step, step], &matrix(map)?);
    }
    svg += &part([0, height - MARGIN], [step, 20], &colour_scale()?);
    Ok(svg + "</svg>\n")
}

fn matrix(map: &HeatMap) -> Result<String> {
    let png = png(map.size, map.size, &map.values)?;
    let title = format!(
        "<text x=\"{MARGIN}\" y=\"{}\">{}</text>\n",
        MARGIN - 8,
        escaped(&map.title)
    );
    Ok(picture([MARGIN, MARGIN], [EDGE, EDGE], &png) + &title)
}

fn colour_scale() -> Result<String> {
    let values: Vec<f64> = (0..100).map(|k| f64::from(k) / 99.0).collect();
    let numbers = format!(
        "<text x=\"{MARGIN}\" y=\"14\">0</text><text x=\"{}\" y=\"14\">1</text>\n",
        MARGIN + EDGE - 14
    );
    Ok(picture([MARGIN + 20, 0], [EDGE - 40, 16], &png(100, 1, &values)?) + &numbers)
}

/// A nested drawing, which a page may place elsewhere.
fn part([x, y]: [usize; 2], [width, height]: [usize; 2], inside: &str) -> String {
    format!(
        "<svg class=\"part\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n{inside}</svg>\n"
    )
}

fn picture([x, y]: [usize; 2], [width, height]: [usize; 2], png: &[u8]) -> String {
    format!(
        "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
         // Pixelated: a viewer that smooths would show values that are not there.
         preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" \
         href=\"data:image/png;base64,{}\"/>\n",
        STANDARD.encode(png)
    )
}

/// The colour of a value from 0 to 1; that of 0 for NaN.
fn colour(value: f64) -> [u8; 3] {
    let fraction = if value.is_nan() {
        0.0
    } else {
        value.clamp(0.0, 1.0)
    };
    // Four intervals between five colours; the last one includes its upper end.
    let place = fraction * (STOPS.len() - 1) as f64;
    let below = (place.floor() as usize).min(STOPS.len() - 2);
    let part = place - below as f64;
    let (dark, light) = (STOPS[below], STOPS[below + 1]);
    [0, 1, 2].map(|channel| (dark[channel] * (1.0 - part) + light[channel] * part).round() as u8)
}

fn png(width: usize, height: usize, values: &[f64]) -> Result<Vec<u8>> {
    let failed = |error: png::EncodingError| PlotError::Drawing {
        cause: error.to_string(),
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    let pixels: Vec<u8> = values.iter().flat_map(|value| colour(*value)).collect();
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(&pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lightness(value: f64) -> u32 {
        colour(value).iter().map(|part| u32::from(*part)).sum()
    }

    #[test]
    fn colours_get_lighter() {
        let values: Vec<f64> = (0..100).map(|k| f64::from(k) / 100.0).collect();
        assert!(values.is_sorted_by_key(|value| lightness(*value)));
        assert_eq!(colour(f64::NAN), colour(-1.0));
        assert_eq!(colour(2.0), colour(1.0));
    }

    #[test]
    fn a_matrix_with_values_missing_is_an_error() {
        let map = HeatMap {
            title: "too few".into(),
            size: 3,
            values: vec![0.0; 4],
        };
        assert!(to_svg(&[map], "one", 1).is_err());
    }
}
