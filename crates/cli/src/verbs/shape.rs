//! `protomer shape`: what is known exactly of a convex shape.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer::shapes::measure_shape;
use std::path::PathBuf;

/// Measure a convex shape, rounded or not: volume, surface, integrated mean curvature and second
/// virial coefficient, exactly.
///
/// The shape is the convex hull of the points of a file: text with two columns (a polygon) or three
/// (a polyhedron), or an .off, .obj, .ply or .stl mesh. One point with a rounding is a disk or a ball.
/// Or it has a name: tetrahedron, cube, octahedron, dodecahedron, icosahedron (edges of length 1),
/// truncated-tetrahedron:T (T from 0, the tetrahedron with edges of length 1, to 1, the octahedron;
/// 2/3 is Archimedean), cuboid:A,B,C, prism:N,HEIGHT (edges of length 1), polygon:N (area 1).
#[derive(Debug, Args)]
pub struct ShapeArgs {
    /// File with points, or the name of a shape.
    shape: String,
    /// Radius of the ball, or disk, that rounds it (Minkowski sum).
    #[arg(
        long,
        default_value_t = 0.0,
        value_name = "RADIUS",
        allow_negative_numbers = true
    )]
    rounding: f64,
    /// Mesh file to write, without the rounding: .ply, .obj, .off or .stl.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl ShapeArgs {
    pub fn run(&self) -> Result<Reply> {
        let report = measure_shape(&self.shape, self.rounding, self.output.as_deref())?;
        Ok(Reply::data(report))
    }
}
