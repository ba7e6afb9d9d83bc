//! Figures: points with error bars, single replicas and lines, in one panel or in several that
//! share their x axis.
//!
//! A [`Figure`] is data only; [`Figure::to_svg`] and [`Figure::to_png`] draw it. Labels may have
//! subscripts and superscripts: `R_g`, `10^{-3}`; [`literal`] keeps the names of files and bodies as they are.
//!
//! | module | one idea |
//! |---|---|
//! | [`figure`](Figure) | the content of a figure |
//! | `layout` | the layout of the figure |
//! | `axis` | frame, grid, ticks and labels of a panel |
//! | `measures` | lengths and colours that axes and layout share |
//! | `runs` | subscripts and superscripts |
//! | `text` | texts that are too long for their room |
//! | `output` | figures as SVG and PNG |
//! | `ticks` | the ticks of an axis, and their labels |
//! | `typeface` | the built-in typeface: widths and outlines |
//! | `canvas` | the shapes that every output can draw |
//! | `svg`, `pixels` | the two outputs |
//! | [`heat_map`](HeatMap) | matrices as coloured squares |
//! | [`colour_map`](ColourMap) | a table of numbers above and below zero as coloured cells |
//! | [`contour_map`](ContourMap) | lines of equal value in a plane |
//! | `contours` | lines of equal value through numbers on a grid |
//! | `source` | a figure stored inside its own SVG, so that it can be drawn again |
//!
//! The SVG writer is our own, tiny-skia makes the PNG, and the outlines of one bundled typeface
//! serve both, so both outputs draw the same shapes from one layout. resvg would bring 51 crates
//! for the same PNG. tiny-skia brings 18, and most of them are there already. plotters has whole
//! coordinates and no glyph bearings.
//!
//! An SVG holds what it is drawn from. A page draws it again for a narrow screen, with letters that
//! can be read, and needs no second file and no second format.

mod axis;
mod canvas;
mod colour_map;
mod contour_map;
mod contours;
mod error;
mod figure;
mod heat_map;
mod layout;
mod measures;
mod output;
mod pixels;
mod runs;
mod source;
mod svg;
mod text;
mod ticks;
mod typeface;

pub use colour_map::ColourMap;
pub use contour_map::{ContourMap, ContourPanel};
pub use error::{PlotError, Result};
pub use figure::{Axis, Figure, Panel, Point, Series, Span};
pub use heat_map::HeatMap;
pub use output::{HEIGHT, WIDTH};
pub use runs::literal;
pub use svg::escaped;
