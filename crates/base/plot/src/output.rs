//! Figures as SVG and PNG, in memory and as files.

use super::canvas::Shape;
use super::error::Result;
use super::{Figure, layout, pixels, source, svg};
use protomer_io::atomic::write_bytes;
use std::path::Path;

/// Width of a figure in pixels of the PNG and units of the SVG.
pub const WIDTH: u32 = 1200;
/// Height of a figure in pixels of the PNG and units of the SVG.
pub const HEIGHT: u32 = 800;

/// Height of a panel on a narrow screen.
const NARROW_PANEL_HEIGHT: f64 = 210.0;
/// Width of a figure for a narrow screen.
pub(crate) const NARROW_WIDTH: f64 = 520.0;
/// Shape of figures in files, and on screens that are wide enough.
pub(crate) const WIDE: Shape = Shape {
    width: WIDTH as f64,
    height: HEIGHT as f64,
    least_shrunk: 0.8,
};

impl Figure {
    /// The text of an SVG file. The file also holds the figure itself, for [`Figure::from_svg`].
    ///
    /// ```
    /// use protomer_plot::{Axis, Figure, Panel, Series};
    /// let series = Series { replicas: vec![[1.0, 2.0], [3.0, 4.0]], ..Series::default() };
    /// let panels = vec![Panel { y: Axis::linear("energy, kT"), series: vec![series] }];
    /// assert!(Figure { panels, ..Figure::default() }.to_svg()?.contains("energy, kT"));
    /// assert!(Figure::default().to_svg().is_err(), "there is no point to draw");
    /// # Ok::<(), protomer_plot::PlotError>(())
    /// ```
    ///
    /// # Errors
    /// If a value cannot be drawn: an x or a range that is not finite, a value outside a stated
    /// range or at or below zero on a logarithmic axis, no point at all.
    pub fn to_svg(&self) -> Result<String> {
        self.check()?;
        let svg = svg::draw(WIDE, |canvas| layout::draw(self, WIDE, canvas));
        source::within(&svg, self)
    }

    /// Variant of [`Figure::to_svg`] for a narrow screen, with larger letters relative to the
    /// width, and without the embedded figure.
    ///
    /// ```
    /// use protomer_plot::{Axis, Figure, Panel, Series};
    /// let series = Series { replicas: vec![[1.0, 2.0], [3.0, 4.0]], ..Series::default() };
    /// let panels = vec![Panel { y: Axis::linear("y"), series: vec![series] }];
    /// let svg = Figure { panels, ..Figure::default() }.to_narrow_svg()?;
    /// assert!(svg.contains("viewBox=\"0 0 520 "));
    /// assert!(Figure::from_svg(&svg)?.is_none(), "it holds no figure");
    /// # Ok::<(), protomer_plot::PlotError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Figure::to_svg`].
    pub fn to_narrow_svg(&self) -> Result<String> {
        self.check()?;
        let shape = Shape {
            width: NARROW_WIDTH,
            height: 0.0,
            least_shrunk: 1.0,
        };
        let height = layout::height_for(self, shape, NARROW_PANEL_HEIGHT).round();
        let shape = Shape { height, ..shape };
        Ok(svg::draw(shape, |canvas| layout::draw(self, shape, canvas)))
    }

    /// The figure embedded in an SVG file, and the file without it; `None` if there is none.
    ///
    /// # Errors
    /// If it is damaged.
    ///
    /// ```
    /// use protomer_plot::{Axis, Figure, Panel, Series};
    /// let series = Series { replicas: vec![[1.0, 2.0], [3.0, 4.0]], ..Series::default() };
    /// let panels = vec![Panel { y: Axis::linear("y"), series: vec![series] }];
    /// let figure = Figure { x: Axis::linear("x"), panels, ..Figure::default() };
    /// let (embedded, _) = Figure::from_svg(&figure.to_svg()?)?.unwrap();
    /// assert_eq!(embedded, figure);
    /// # Ok::<(), protomer_plot::PlotError>(())
    /// ```
    pub fn from_svg(svg: &str) -> Result<Option<(Self, String)>> {
        source::take(svg)
    }

    /// The bytes of a PNG file of [`WIDTH`] x [`HEIGHT`] pixels.
    ///
    /// ```
    /// use protomer_plot::{Axis, Figure, HEIGHT, Panel, Series, WIDTH};
    /// let series = Series { replicas: vec![[1.0, 2.0], [3.0, 4.0]], ..Series::default() };
    /// let panels = vec![Panel { y: Axis::linear("y"), series: vec![series] }];
    /// let png = Figure { panels, ..Figure::default() }.to_png()?;
    /// assert!(png.starts_with(b"\x89PNG"));
    /// let size = |place: usize| u32::from_be_bytes([png[place], png[place + 1], png[place + 2], png[place + 3]]);
    /// assert_eq!((size(16), size(20)), (WIDTH, HEIGHT));
    /// # Ok::<(), protomer_plot::PlotError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Figure::to_svg`].
    pub fn to_png(&self) -> Result<Vec<u8>> {
        self.check()?;
        pixels::draw(WIDE, |canvas| layout::draw(self, WIDE, canvas))
    }

    /// Writes an SVG file atomically.
    ///
    /// # Errors
    /// As [`Figure::to_svg`], and if the file cannot be written.
    pub fn write_svg(&self, path: &Path) -> Result<()> {
        let svg = self.to_svg()?;
        Ok(write_bytes(path, svg.as_bytes())?)
    }

    /// Writes a PNG file atomically.
    ///
    /// # Errors
    /// As [`Figure::to_png`], and if the file cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        let png = self.to_png()?;
        Ok(write_bytes(path, &png)?)
    }
}
