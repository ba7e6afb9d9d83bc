//! The content of a figure, and checks that it can be drawn.

use super::error::{PlotError, Result};
use serde::{Deserialize, Serialize};

/// A figure of panels stacked on a common x axis.
///
/// ```
/// use protomer_plot::{Axis, Figure, Panel, Point, Series};
/// let points = [(0.01, 52.0, 0.5), (0.1, 60.0, 2.0)].map(|(x, y, error)| Point { x, y, error: Some(error) });
/// let series = Series { name: "D_4".into(), points: points.to_vec(), line: true, ..Series::default() };
/// let figure = Figure {
///     title: "Stability of the assembly".into(),
///     caption: "error bars: standard error of five replicas".into(),
///     x: Axis::log("salt concentration / M"),
///     panels: vec![Panel { y: Axis::linear("R_g / Å"), series: vec![series] }],
/// };
/// assert!(figure.to_svg()?.starts_with("<svg"));
/// # Ok::<(), protomer_plot::PlotError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Title; may be empty.
    pub title: String,
    /// A line in small print below the title, such as what the error bars are; may be empty.
    pub caption: String,
    /// The x axis of all panels.
    pub x: Axis,
    /// The panels from top to bottom. Series of one name have one colour in all panels.
    pub panels: Vec<Panel>,
}

/// One panel.
///
/// ```
/// use protomer_plot::{Axis, Panel, Series};
/// let replicas = vec![[0.01, 52.0], [0.1, 60.0]];
/// let dots = Series { name: "single runs".into(), replicas, ..Series::default() };
/// let panel = Panel { y: Axis::linear("R_g (Å)"), series: vec![dots] };
/// assert_eq!(panel.series.len(), 1);
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// The y axis.
    pub y: Axis,
    /// The series, later ones on top.
    pub series: Vec<Series>,
}

/// An axis.
///
/// ```
/// use protomer_plot::Axis;
/// let salt = Axis::log("salt (mM)");
/// let fraction = Axis::linear("native contacts left").with_range(0.0, 1.05);
/// assert!(salt.log && salt.range.is_none());
/// assert_eq!(fraction.range, Some([0.0, 1.05]));
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Whether the axis is logarithmic.
    pub log: bool,
    /// The values at the two ends; `None` to fit the data.
    pub range: Option<[f64; 2]>,
    /// Whether only whole numbers are marked, as on an axis that counts.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub whole: bool,
}

/// Points of one colour.
///
/// ```
/// use protomer_plot::{Point, Series};
/// let points = vec![
///     Point { x: 0.01, y: 52.0, error: Some(0.5) },
///     Point { x: 0.1, y: 60.0, error: None },
/// ];
/// let curve = Series { name: "dimer".into(), points, line: true, ..Series::default() };
/// assert!(curve.replicas.is_empty());
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Name in the legend; empty for a series that its axis describes.
    pub name: String,
    /// The points, in the order in which a line joins them. Points whose y is NaN are omitted.
    pub points: Vec<Point>,
    /// Single measurements behind the points, drawn small and faint: (x, y).
    pub replicas: Vec<[f64; 2]>,
    /// Whether a line joins the points.
    pub line: bool,
    /// Values of x with their intervals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spans: Vec<Span>,
}

/// A value of x and its interval: a marker on a horizontal bar.
///
/// ```
/// use protomer_plot::{Series, Span};
/// let half = Span { x: 0.11, y: 0.5, from: 0.10, to: 0.13 };
/// let half_salt = Series { name: "half, 95 %".into(), spans: vec![half], ..Series::default() };
/// assert!(half_salt.points.is_empty());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// Abscissa.
    pub x: f64,
    /// Ordinate of marker and bar.
    pub y: f64,
    /// Left end of the bar.
    pub from: f64,
    /// Right end of the bar.
    pub to: f64,
}

/// A point with its error.
///
/// ```
/// use protomer_plot::Point;
/// let exact = Point { x: 0.1, y: 60.0, ..Point::default() };
/// assert_eq!(exact.error, None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Half the length of the error bar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
}

impl Axis {
    /// A linear axis that fits its data.
    ///
    /// ```
    /// use protomer_plot::Axis;
    /// let axis = Axis::linear("distance, Å");
    /// assert_eq!((axis.label.as_str(), axis.log, axis.range), ("distance, Å", false, None));
    /// ```
    pub fn linear(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            log: false,
            range: None,
            whole: false,
        }
    }

    /// A linear axis of a count, such as epochs, whose ticks are whole numbers.
    ///
    /// ```
    /// use protomer_plot::Axis;
    /// let epochs = Axis::count("epoch");
    /// assert!(epochs.whole && !epochs.log);
    /// ```
    pub fn count(label: impl Into<String>) -> Self {
        Self {
            whole: true,
            ..Self::linear(label)
        }
    }

    /// A logarithmic axis that fits its data.
    ///
    /// ```
    /// use protomer_plot::{Axis, Figure, Panel, Series};
    /// let series = Series { replicas: vec![[0.0, 2.0], [3.0, 4.0]], ..Series::default() };
    /// let panels = vec![Panel { y: Axis::linear("y"), series: vec![series] }];
    /// let figure = |x| Figure { x, panels: panels.clone(), ..Figure::default() };
    /// assert!(figure(Axis::linear("salt / M")).to_svg().is_ok());
    /// assert!(figure(Axis::log("salt / M")).to_svg().is_err(), "zero has no logarithm");
    /// ```
    pub fn log(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            log: true,
            range: None,
            whole: false,
        }
    }

    /// The same axis with these ends.
    ///
    /// ```
    /// use protomer_plot::{Axis, Figure, Panel, Series};
    /// let series = Series { replicas: vec![[1.0, 2.0], [3.0, 4.0]], ..Series::default() };
    /// let figure = |to| Figure {
    ///     x: Axis::linear("x").with_range(0.0, to),
    ///     panels: vec![Panel { y: Axis::linear("y"), series: vec![series.clone()] }],
    ///     ..Figure::default()
    /// };
    /// assert!(figure(3.0).to_svg().is_ok());
    /// assert!(figure(2.0).to_svg().is_err(), "3 lies outside");
    /// ```
    #[must_use]
    pub fn with_range(self, from: f64, to: f64) -> Self {
        Self {
            range: Some([from, to]),
            ..self
        }
    }

    /// Checks the stated ends.
    fn check(&self) -> Result<()> {
        let Some([from, to]) = self.range else {
            return Ok(());
        };
        let finite = from.is_finite() && to.is_finite();
        if finite && from < to && (!self.log || from > 0.0) {
            return Ok(());
        }
        let label = self.label.clone();
        Err(PlotError::BadRange { label, from, to })
    }

    /// Checks that a value can be drawn on this axis.
    fn check_value(&self, value: f64) -> Result<()> {
        let label = || self.label.clone();
        if !value.is_finite() || (self.log && value <= 0.0) {
            let label = label();
            return Err(PlotError::BadValue { label, value });
        }
        match self.range {
            Some([from, to]) if value < from || value > to => Err(PlotError::OutsideRange {
                label: label(),
                value,
                from,
                to,
            }),
            _ => Ok(()),
        }
    }
}

impl Figure {
    /// The names of the series in the order of their first appearance.
    pub(crate) fn series_names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        for series in self.panels.iter().flat_map(|panel| &panel.series) {
            if !names.contains(&series.name.as_str()) {
                names.push(series.name.as_str());
            }
        }
        names
    }

    pub(crate) fn check(&self) -> Result<()> {
        if self.panels.is_empty() {
            let title = self.title.clone();
            return Err(PlotError::NoPanels { title });
        }
        self.x.check()?;
        for panel in &self.panels {
            panel.y.check()?;
            if panel.values().next().is_none() {
                let label = panel.y.label.clone();
                return Err(PlotError::NoPoints { label });
            }
            for [x, y] in panel.values() {
                self.x.check_value(x)?;
                panel.y.check_value(y)?;
            }
        }
        Ok(())
    }
}

impl Panel {
    /// All positions that are drawn, without error bars.
    pub(crate) fn values(&self) -> impl Iterator<Item = [f64; 2]> {
        self.series.iter().flat_map(|series| {
            let points = series.points.iter().map(|point| [point.x, point.y]);
            let spans = series.spans.iter();
            let spans = spans.flat_map(|span| [span.x, span.from, span.to].map(|x| [x, span.y]));
            points
                .chain(series.replicas.iter().copied())
                .chain(spans)
                .filter(|[_, y]| !y.is_nan())
        })
    }

    /// The ends of all error bars; on a logarithmic axis those that reach zero are omitted.
    pub(crate) fn error_ends(&self) -> impl Iterator<Item = f64> {
        let points = self.series.iter().flat_map(|series| &series.points);
        points
            .filter_map(|point| point.error.map(|error| [point.y - error, point.y + error]))
            .flatten()
            .filter(|end| end.is_finite() && (!self.y.log || *end > 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{HEIGHT, WIDTH};
    use std::path::Path;

    /// The figure of a sweep: radius of gyration and native contacts against salt, for two
    /// arrangements.
    fn example() -> Figure {
        let salts: &'static [f64] = &[10.0, 20.0, 50.0, 100.0, 150.0, 200.0, 300.0];
        let series = |name: &str, midpoint: f64, low: f64, high: f64| {
            let curve = |salt: f64| low + (high - low) / (1.0 + (midpoint / salt).powi(4));
            // Replicas scatter most at the transition; the scatter is that of a golden-ratio
            // sequence.
            let replicas = |i: usize| -> Vec<f64> {
                let width = 0.01 + 0.12 * (-(salts[i] / midpoint).ln().powi(2) * 3.0).exp();
                (0..5)
                    .map(|k| ((i * 5 + k) as f64 * 0.618_034 + midpoint).fract() - 0.5)
                    .map(|u| curve(salts[i]) + 2.0 * u * width * (high - low))
                    .collect()
            };
            let point = |i: usize| {
                let values = replicas(i);
                let y = values.iter().sum::<f64>() / 5.0;
                let variance = values.iter().map(|value| (value - y).powi(2)).sum::<f64>() / 4.0;
                Point {
                    x: salts[i],
                    y,
                    error: Some((variance / 5.0).sqrt()),
                }
            };
            Series {
                name: name.into(),
                points: (0..salts.len()).map(point).collect(),
                replicas: (0..salts.len())
                    .flat_map(|i| replicas(i).into_iter().map(move |y| [salts[i], y]))
                    .collect(),
                line: true,
                ..Series::default()
            }
        };
        let r_g = vec![
            series("up-up D_4 stack", 60.0, 52.0, 131.0),
            series("alternating C_8 ring", 110.0, 58.0, 128.0),
            series("up-down", 170.0, 55.0, 120.0),
        ];
        let contacts = vec![
            series("up-up D_4 stack", 60.0, 0.97, 0.03),
            series("alternating C_8 ring", 110.0, 0.93, 0.03),
            series("up-down", 170.0, 0.9, 0.05),
        ];
        Figure {
            title: "Stability of BPTI(+6) / BPTI(−6) assemblies".into(),
            caption: "16 bodies, cubic box 400 Å, pH 7.4, 298.15 K; error bars: standard error; faint: single replicas"
                .into(),
            x: Axis::log("salt concentration / mM"),
            panels: vec![
                Panel { y: Axis::linear("radius of gyration R_g / Å"), series: r_g },
                Panel { y: Axis::linear("native contacts").with_range(0.0, 1.05), series: contacts },
            ],
        }
    }

    #[test]
    fn an_svg_holds_every_label_and_every_point() {
        let figure = example();
        let svg = figure.to_svg().unwrap();
        assert!(
            svg.starts_with("<svg width=\"1200\" height=\"800\""),
            "{}",
            &svg[..100]
        );
        assert!(svg.trim_end().ends_with("</svg>"));
        for text in [
            "radius\u{a0}of\u{a0}gyration\u{a0}R",
            "native\u{a0}contacts",
            ">10<",
            ">300<",
            "up-down",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        // One faint circle for each replica, and markers of the first series with a halo.
        let replicas: usize = figure
            .panels
            .iter()
            .flat_map(|p| &p.series)
            .map(|s| s.replicas.len())
            .sum();
        assert_eq!(svg.matches("opacity=\"0.4\"").count(), replicas);
    }

    #[test]
    fn an_svg_holds_its_figure_which_can_be_drawn_narrow() {
        let mut figure = example();
        figure.caption += " <&>\"";
        let svg = figure.to_svg().unwrap();
        let (found, bare) = Figure::from_svg(&svg).unwrap().unwrap();
        assert_eq!(found, figure);
        assert_eq!(Figure::from_svg(&bare).unwrap(), None);
        assert!(
            bare.len() < svg.len()
                && bare.starts_with("<svg")
                && bare.trim_end().ends_with("</svg>")
        );
        let narrow = figure.to_narrow_svg().unwrap();
        assert!(narrow.starts_with("<svg width=\"520\" height=") && !narrow.contains("metadata"));
        // All its letters are larger than 8 pixels on a screen of 390, of which the figure has 344.
        let sizes = narrow
            .split("font-size=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap().parse::<f64>().unwrap());
        assert!(
            sizes.clone().count() > 20 && sizes.clone().all(|size| size * 344.0 / 520.0 >= 8.0)
        );
        // Gaps are not drawn and not kept.
        figure.panels[0].series[0].points[0].y = f64::NAN;
        figure.panels[0].series[0].points[1].error = Some(f64::INFINITY);
        let (found, _) = Figure::from_svg(&figure.to_svg().unwrap())
            .unwrap()
            .unwrap();
        assert_eq!(
            found.panels[0].series[0].points.len(),
            figure.panels[0].series[0].points.len() - 1
        );
        assert!(Figure::from_svg(&svg.replace("\"panels\"", "\"pannels\"")).is_err());
    }

    #[test]
    fn a_png_has_the_stated_size_and_the_colours_of_the_series() {
        let mut figure = example();
        figure.panels.truncate(1);
        let bytes = figure.to_png().unwrap();
        let decoder = png::Decoder::new(std::io::Cursor::new(&bytes));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(
            (info.width, info.height, info.color_type),
            (WIDTH, HEIGHT, png::ColorType::Rgba)
        );
        for colour in &crate::canvas::PALETTE[..3] {
            assert!(
                pixels.chunks_exact(4).any(|pixel| pixel[..3] == *colour),
                "{colour:?}"
            );
        }
        if let Some(path) = std::env::var_os("PROTOMER_EXAMPLE_FIGURE") {
            example().write_png(Path::new(&path)).unwrap();
            example()
                .write_svg(&Path::new(&path).with_extension("svg"))
                .unwrap();
            let panel = &mut figure.panels[0];
            panel
                .series
                .iter_mut()
                .for_each(|series| series.name.push_str(", with a name that is rather long"));
            panel.y = Axis {
                label: panel.y.label.clone(),
                log: true,
                range: None,
                whole: false,
            };
            figure.x = Axis::linear("salt concentration / mM");
            figure.caption.clear();
            figure
                .write_png(&Path::new(&path).with_extension("single.png"))
                .unwrap();
        }
    }

    #[test]
    fn a_span_is_a_marker_on_a_bar_and_survives_in_the_source() {
        let span = Span {
            x: 2.0,
            y: 0.5,
            from: 1.0,
            to: 4.0,
        };
        let figure = Figure {
            x: Axis::log("salt"),
            panels: vec![Panel {
                y: Axis::linear("fraction").with_range(0.0, 1.0),
                series: vec![Series {
                    spans: vec![span],
                    ..Series::default()
                }],
            }],
            ..Figure::default()
        };
        let svg = figure.to_svg().unwrap();
        let (found, bare) = Figure::from_svg(&svg).unwrap().unwrap();
        assert_eq!(found, figure);
        // The bar with two caps, in the colour of the series; then the marker on its rim.
        assert_eq!(bare.matches("stroke=\"#0072B2\"").count(), 3, "{bare}");
        assert_eq!(bare.matches("<circle").count(), 2, "{bare}");
        let mut outside = figure;
        outside.panels[0].series[0].spans[0].from = -1.0;
        let error = outside.to_svg().unwrap_err().to_string();
        assert!(error.contains("value -1 cannot be drawn"), "{error}");
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        let point = |x, y| Point { x, y, error: None };
        let figure = |x: Axis, points: Vec<Point>| Figure {
            x,
            panels: vec![Panel {
                y: Axis::linear("R_g"),
                series: vec![Series {
                    points,
                    ..Series::default()
                }],
            }],
            ..Figure::default()
        };
        let error = |figure: Figure| figure.to_svg().unwrap_err().to_string();
        assert!(
            error(figure(Axis::log("salt"), vec![point(0.0, 1.0)]))
                .contains("value 0 cannot be drawn on the axis \"salt\"")
        );
        assert!(error(figure(Axis::linear("salt"), vec![point(f64::NAN, 1.0)])).contains("NaN"));
        assert!(error(figure(Axis::linear("salt"), vec![])).contains("no point"));
        assert!(
            error(figure(
                Axis::linear("salt").with_range(2.0, 1.0),
                vec![point(0.0, 1.0)]
            ))
            .contains("cannot range")
        );
        assert!(error(Figure::default()).contains("no panels"));
        let outside = error(figure(
            Axis::linear("salt").with_range(0.0, 1.0),
            vec![point(2.0, 1.0)],
        ));
        assert!(
            outside.contains("value 2 lies outside the axis \"salt\", 0 to 1"),
            "{outside}"
        );
        // One point, and points that are all the same, still make a figure.
        assert!(
            figure(Axis::log("salt"), vec![point(1.0, 0.0)])
                .to_svg()
                .is_ok()
        );
        assert!(
            figure(
                Axis::linear("salt"),
                vec![point(0.0, 5.0), point(1.0, f64::NAN)]
            )
            .to_png()
            .is_ok()
        );
    }
}
