//! The one error type of this crate.

use protomer_io::IoError;

/// Errors of drawing and writing figures.
///
/// ```
/// use protomer_plot::{Figure, PlotError};
/// let figure = Figure { title: "empty".into(), ..Figure::default() };
/// assert!(matches!(figure.to_svg(), Err(PlotError::NoPanels { title }) if title == "empty"));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// A figure without panels.
    #[error("the figure {title:?} has no panels; give it at least one")]
    NoPanels {
        /// Title of the figure.
        title: String,
    },
    /// A panel without a single point.
    #[error("the panel {label:?} has no point to draw")]
    NoPoints {
        /// Label of its y axis.
        label: String,
    },
    /// An invalid axis range.
    #[error("the axis {label:?} cannot range from {from} to {to}")]
    BadRange {
        /// Label of the axis.
        label: String,
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
    },
    /// A value that is not finite, or not positive on a logarithmic axis.
    #[error("the value {value} cannot be drawn on the axis {label:?}; use a linear axis")]
    BadValue {
        /// Label of the axis.
        label: String,
        /// The value.
        value: f64,
    },
    /// A value beyond the stated ends of its axis.
    #[error("the value {value} lies outside the axis {label:?}, {from} to {to}; widen it")]
    OutsideRange {
        /// Label of the axis.
        label: String,
        /// The value.
        value: f64,
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
    },
    /// The figure inside an SVG cannot be read.
    #[error("the figure inside the SVG is damaged or of another version: {cause}; draw it again")]
    DamagedSource {
        /// Description of the damage.
        cause: String,
    },
    /// The picture cannot be made.
    #[error("cannot draw the figure: {cause}")]
    Drawing {
        /// The message of the drawing library.
        cause: String,
    },
    /// The file cannot be written.
    #[error(transparent)]
    File(#[from] IoError),
}

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, PlotError>;
