//! The page that plays a run: one HTML file that needs nothing else, and its frames as SVG.
//!
//! Squares are coloured by orientation, θ modulo 90°, on a colour wheel: squares that turn
//! together share a colour.

use super::directory::read_settings;
use super::start::network;
use super::trajectory::{corner_position, read_states_with_cells};
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::output_file::write_once;
use protomer_io::written::{html, json_in_html};
use protomer_linkage::lattice::{Cell, Network};
use protomer_results::ResultKind;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("animation.html");
/// Style of [`PLAYER`].
pub const PLAYER_STYLE: &str = include_str!("player.css");
/// The elements of the player: a canvas and controls, which [`PLAYER_SCRIPT`] fills.
pub const PLAYER: &str = include_str!("player.html");
/// Script that defines `playLattice(root, keys, data)`.
pub const PLAYER_SCRIPT: &str = include_str!("player.js");
/// Length of the longer edge of a frame, pixels.
const FRAME_PIXELS: f64 = 800.0;

/// The frames of a run, ready to be played.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    network: Network,
    title: String,
    frames: Vec<Frame>,
}

/// A frame: time, x, y, θ of square after square, and the periodic cell.
#[derive(Debug, Clone, PartialEq)]
struct Frame {
    time: f64,
    squares: Vec<f64>,
    cell: Cell,
}

/// A page that was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct WrittenAnimation {
    /// The page.
    pub page: PathBuf,
    /// Number of frames on the page.
    pub frames: usize,
}

impl Answer for WrittenAnimation {
    fn text(&self) -> String {
        format!("{} frames in {}", self.frames, self.page.display())
    }
}

/// Options of [`animate`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AnimationSettings {
    /// The page; `lattice.html` in the directory of the run where `None`.
    pub page: Option<PathBuf>,
    /// A folder for the frames as SVG files.
    pub frames: Option<PathBuf>,
    /// Maximum number of frames, evenly spaced.
    pub most_frames: usize,
    /// Whether to overwrite existing files.
    pub force: bool,
}

/// Writes the page that plays a run and, if a folder is given, its frames.
///
/// # Errors
/// If the directory does not hold a run with frames, or a file already exists or cannot be written.
///
/// ```no_run
/// use protomer_linkage_verbs::lattice::animation::{AnimationSettings, animate};
/// use std::path::Path;
/// let settings =
///     AnimationSettings { page: None, frames: None, most_frames: 300, force: false };
/// println!("{}", animate(Path::new("run"), &settings)?.page.display());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn animate(directory: &Path, settings: &AnimationSettings) -> Result<WrittenAnimation> {
    let animation = Animation::read(directory, settings.most_frames)?;
    let page = settings.page.clone();
    let page = page.unwrap_or_else(|| directory.join("lattice.html"));
    write_once(&page, &animation.to_html(), settings.force)?;
    if let Some(folder) = &settings.frames {
        ResultKind::VoxelSet.refuse_in(folder)?;
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        for frame in 0..animation.len() {
            let path = folder.join(format!("frame_{frame:05}.svg"));
            write_once(&path, &animation.to_svg(frame), settings.force)?;
        }
    }
    Ok(WrittenAnimation {
        page,
        frames: animation.len(),
    })
}

impl Animation {
    /// Reads the trajectory of a run directory and keeps at most `most_frames` frames, evenly
    /// spaced.
    ///
    /// # Errors
    /// If the directory does not hold a lattice run, or the run has no frames.
    pub fn read(directory: &Path, most_frames: usize) -> Result<Self> {
        if most_frames == 0 {
            bail!("--most-frames is 0; give at least 1");
        }
        let settings = read_settings(directory).with_context(|| {
            format!(
                "{} is not a directory of 'protomer lattice run'",
                directory.display()
            )
        })?;
        let path = directory.join("trajectory.gsd");
        let states = read_states_with_cells(&path)?;
        if states.is_empty() {
            bail!(
                "{} has no frames; run with --trajectory-every 50 or so",
                path.display()
            );
        }
        let stride = states.len().div_ceil(most_frames);
        let title = format!(
            "{} × {} squares, r0 = {:.4}, κ = {}",
            settings.rows, settings.columns, settings.r0, settings.kappa
        );
        let network = network(&settings)?;
        let mut frames = Vec::new();
        for (time, mut squares, cell) in states.into_iter().step_by(stride) {
            let count = squares.len();
            squares.extend(cell);
            let cell = Cell::read(&network, &squares);
            squares.truncate(count);
            frames.push(Frame {
                time,
                squares,
                cell,
            });
        }
        Ok(Self {
            network,
            title,
            frames,
        })
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there are no frames.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Bounds of all frames: left, bottom, right and top.
    fn bounds(&self) -> [f64; 4] {
        let mut largest = 0.0_f64;
        for square in &self.network.squares {
            largest = largest.max(square.half_diagonal);
        }
        let margin = 1.05 * largest;
        let [mut left, mut low] = [f64::INFINITY; 2];
        let [mut right, mut up] = [f64::NEG_INFINITY; 2];
        for frame in &self.frames {
            for square in frame.squares.chunks_exact(3) {
                (left, right) = (left.min(square[0]), right.max(square[0]));
                (low, up) = (low.min(square[1]), up.max(square[1]));
            }
        }
        [left - margin, low - margin, right + margin, up + margin]
    }

    /// Describes the lattice in one line.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The page.
    pub fn to_html(&self) -> String {
        PAGE.replace("{{STYLE}}", PLAYER_STYLE.trim_end())
            .replace("{{PLAYER}}", PLAYER.trim_end())
            .replace("{{SCRIPT}}", PLAYER_SCRIPT.trim_end())
            .replace("{{TITLE}}", &html(&self.title))
            .replace("{{DATA}}", &self.to_json())
    }

    /// The frames as JSON that is safe inside a script element.
    pub fn to_json(&self) -> String {
        let mut rods = Vec::new();
        for rod in &self.network.rods {
            let (from, to, [right, up]) = (rod.from, rod.to, rod.image);
            let ends = [from.square, to.square];
            let vertices = [from.vertex, to.vertex];
            rods.push(serde_json::json!([
                ends[0],
                vertices[0],
                ends[1],
                vertices[1],
                right,
                up
            ]));
        }
        let squares = self.network.squares.iter();
        let half_diagonals: Vec<f64> = squares.map(|square| square.half_diagonal).collect();
        let (mut times, mut frames, mut cells) = (Vec::new(), Vec::new(), Vec::new());
        for frame in &self.frames {
            times.push(frame.time);
            frames.push(rounded(&frame.squares));
            cells.push(rounded(&frame.cell.components()));
        }
        if self.network.cell_mass.is_none() {
            // The same in every frame.
            cells.truncate(1);
        }
        let times = rounded(&times);
        let data = serde_json::json!({
            "title": self.title, "bounds": self.bounds(), "size": half_diagonals, "rods": rods, "times": times,
            "cells": cells, "frames": frames,
        });
        json_in_html(&data.to_string())
    }

    /// One frame as an SVG file.
    pub fn to_svg(&self, frame: usize) -> String {
        let Some(Frame {
            time,
            squares: positions,
            cell,
        }) = self.frames.get(frame)
        else {
            return String::new();
        };
        let [left, low, right, up] = self.bounds();
        let scale = FRAME_PIXELS / (right - left).max(up - low);
        let (width, height) = (scale * (right - left), scale * (up - low));
        let place = |[x, y]: [f64; 2]| [scale * (x - left), scale * (up - y)];
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{:.0}\" viewBox=\"0 0 {width:.1} \
             {:.1}\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
            height + CAPTION_PIXELS,
            height + CAPTION_PIXELS
        );
        for (square, s) in positions.chunks_exact(3).enumerate() {
            let corner = |vertex| {
                let [x, y] = place(corner_position(
                    &self.network,
                    positions,
                    protomer_linkage::lattice::Corner { square, vertex },
                ));
                format!("{x:.1},{y:.1}")
            };
            // Writing to a string cannot fail.
            let _ = writeln!(
                svg,
                "<polygon points=\"{} {} {} {}\" fill=\"{}\" stroke=\"#333333\" stroke-width=\"0.7\"/>",
                corner(1),
                corner(2),
                corner(4),
                corner(3),
                colour(s[2])
            );
        }
        for rod in &self.network.rods {
            let [dx, dy] = cell.shift(rod.image.map(f64::from));
            let [x1, y1] = place(corner_position(&self.network, positions, rod.from));
            let [x, y] = corner_position(&self.network, positions, rod.to);
            let [x2, y2] = place([x + dx, y + dy]);
            let _ = writeln!(
                svg,
                "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"#111111\" \
                 stroke-width=\"1.6\" stroke-linecap=\"round\"/>"
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"8\" y=\"{:.0}\" font-size=\"15\" fill=\"#222222\">{}, t = {time:.3}</text>\n</svg>",
            height + 0.65 * CAPTION_PIXELS,
            self.title
        );
        svg
    }
}

/// Height of the caption below the picture.
const CAPTION_PIXELS: f64 = 30.0;

/// Rounds numbers, as a tenth of a pixel is precise enough.
fn rounded(numbers: &[f64]) -> Vec<f64> {
    numbers.iter().map(|x| (x * 1e4).round() / 1e4).collect()
}

/// A colour wheel over a quarter turn, of constant lightness; the player uses the same.
fn colour(angle: f64) -> String {
    let turn = (angle / FRAC_PI_2).rem_euclid(1.0);
    let part = |phase: f64| (165.0 + 75.0 * (TAU * (turn - phase)).cos()).round() as u8;
    format!(
        "#{:02x}{:02x}{:02x}",
        part(0.0),
        part(1.0 / 3.0),
        part(2.0 / 3.0)
    )
}
